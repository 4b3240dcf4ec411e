//! The tree of plugins a scene file describes.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;
use smol_str::SmolStr;

use super::parse::file_candidates;
use super::{Crowd, Diagnostics, SourceId, Span, TransformOp};
use crate::files::Access;

/// The kind of plugin a tag declares; the tag's name is the kind's name in the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Category {
    Scene,
    Integrator,
    Sensor,
    Film,
    ReconstructionFilter,
    Sampler,
    Shape,
    Bsdf,
    Emitter,
    Texture,
    Medium,
    Phase,
    Volume,
}

impl Category {
    pub const ALL: [Self; 13] = [
        Self::Scene,
        Self::Integrator,
        Self::Sensor,
        Self::Film,
        Self::ReconstructionFilter,
        Self::Sampler,
        Self::Shape,
        Self::Bsdf,
        Self::Emitter,
        Self::Texture,
        Self::Medium,
        Self::Phase,
        Self::Volume,
    ];

    /// The tag that declares a plugin of this kind.
    pub fn tag(self) -> &'static str {
        match self {
            Self::Scene => "scene",
            Self::Integrator => "integrator",
            Self::Sensor => "sensor",
            Self::Film => "film",
            Self::ReconstructionFilter => "rfilter",
            Self::Sampler => "sampler",
            Self::Shape => "shape",
            Self::Bsdf => "bsdf",
            Self::Emitter => "emitter",
            Self::Texture => "texture",
            Self::Medium => "medium",
            Self::Phase => "phase",
            Self::Volume => "volume",
        }
    }

    pub fn from_tag(tag: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|category| category.tag() == tag)
    }
}

/// A property's value. Numbers are single precision, as everything downstream.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    Float(f32),
    Integer(i64),
    Boolean(bool),
    String(String),
    /// `<rgb>`: linear Rec. 709 (a `#rrggbb` has been taken through the sRGB transfer).
    Rgb(Vec3),
    /// `<spectrum>` given as one number, the same at all wavelengths.
    Spectrum(f32),
    Point(Vec3),
    Vector(Vec3),
    Transform(Vec<TransformOp>),
}

impl Value {
    /// The type in words, with its article: for "found a string".
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Float(_) => "a float",
            Self::Integer(_) => "an integer",
            Self::Boolean(_) => "a boolean",
            Self::String(_) => "a string",
            Self::Rgb(_) => "a colour",
            Self::Spectrum(_) => "a spectrum",
            Self::Point(_) => "a point",
            Self::Vector(_) => "a vector",
            Self::Transform(_) => "a transform",
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct Property {
    /// In snake_case: camelCase names of old files have been renamed.
    pub name: SmolStr,
    pub value: Value,
    /// The span of the whole tag; what a message about the value points at.
    pub span: Span,
}

/// A plugin inside a plugin, in place or by reference.
#[derive(Clone, Debug, PartialEq)]
pub enum Child {
    /// Shared: what is read from a document keeps its objects without a copy.
    Object(Arc<Object>),
    Reference {
        /// The parameter it is meant for, where the file names one.
        name: Option<SmolStr>,
        id: SmolStr,
        span: Span,
    },
}

impl Child {
    /// The parameter of the parent it is meant for, where the file names one.
    pub fn name(&self) -> Option<&str> {
        match self {
            Self::Object(object) => object.name.as_deref(),
            Self::Reference { name, .. } => name.as_deref(),
        }
    }

    /// Gives it another [`Self::name`].
    pub fn set_name(&mut self, new: Option<SmolStr>) {
        match self {
            Self::Object(object) => Arc::make_mut(object).name = new,
            Self::Reference { name, .. } => *name = new,
        }
    }

    pub fn span(&self) -> Span {
        match self {
            Self::Object(object) => object.span,
            Self::Reference { span, .. } => *span,
        }
    }
}

impl From<Object> for Child {
    fn from(object: Object) -> Self {
        Self::Object(Arc::new(object))
    }
}

/// One plugin: `<bsdf type="diffuse" id="red" name="..."> ... </bsdf>`.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    pub category: Category,
    /// The `type` attribute; empty for the scene itself.
    pub plugin: SmolStr,
    pub id: Option<SmolStr>,
    /// The parameter of the parent it is meant for, where the file names one.
    pub name: Option<SmolStr>,
    pub properties: Vec<Property>,
    pub children: Vec<Child>,
    /// The start tag.
    pub span: Span,
}

impl Object {
    /// An empty one; `plugin` is its `type`.
    pub fn new(category: Category, plugin: impl Into<SmolStr>) -> Self {
        Self {
            category,
            plugin: plugin.into(),
            id: None,
            name: None,
            properties: Vec::new(),
            children: Vec::new(),
            span: Span::default(),
        }
    }

    /// With this place in a file.
    pub fn at(self, span: Span) -> Self {
        Self { span, ..self }
    }

    /// With another property, which has the object's place.
    pub fn with(mut self, name: &str, value: Value) -> Self {
        self.properties.push(Property {
            name: name.into(),
            value,
            span: self.span,
        });
        self
    }

    /// With another plugin in it.
    pub fn with_child(mut self, child: Object) -> Self {
        self.children.push(child.into());
        self
    }

    /// The plugins given in place, without those referred to.
    pub fn objects(&self) -> impl Iterator<Item = &Object> {
        self.children.iter().filter_map(|child| match child {
            Child::Object(object) => Some(&**object),
            Child::Reference { .. } => None,
        })
    }

    /// Whether it is a group of shapes, which stand where its instances are.
    pub fn is_group(&self) -> bool {
        self.category == Category::Shape && self.plugin == "shapegroup"
    }

    /// What a message calls it: "bsdf `diffuse`", "the scene".
    pub fn title(&self) -> String {
        match self.category {
            Category::Scene => "the scene".to_owned(),
            category => format!("{} `{}`", category.tag(), self.plugin),
        }
    }
}

/// An `<include>`, once for each time it was read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Include {
    /// Of the file's name in the tag.
    pub span: Span,
    /// The included file.
    pub source: SourceId,
}

/// A parsed scene file with its includes and defaults resolved.
#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    pub path: PathBuf,
    /// The `<scene>` without its crowds; shared, because saving wants what was read, which may be very large.
    pub root: Arc<Object>,
    /// In the order of their positions among the children of the root. An imported document has none.
    pub crowds: Vec<Crowd>,
    /// Where files are looked for besides the folders of the scene's own files: the `<path>`s, absolute, in file order.
    pub search_folders: Vec<PathBuf>,
    pub includes: Vec<Include>,
    /// Made from a file of another format: spans tell where things come from, but there is no such text.
    pub imported: bool,
    /// Permits the files that the scene may read.
    pub access: Access,
    pub diagnostics: Diagnostics,
}

impl Document {
    /// One that was not read from a file; `path` is where it will be written.
    pub fn new(path: impl Into<PathBuf>, root: Object) -> Self {
        Self {
            path: path.into(),
            root: Arc::new(root),
            crowds: Vec::new(),
            search_folders: Vec::new(),
            includes: Vec::new(),
            imported: false,
            access: Access::everywhere(),
            diagnostics: Diagnostics::default(),
        }
    }

    /// Where a file named at `span` may be, most likely place first: beside the file that names it, beside the main file, then in the
    /// search folders, the last one first. An absolute name is its own only candidate.
    pub fn file_candidates(&self, name: &str, span: Span) -> Vec<PathBuf> {
        let folder = |path: &Path| path.parent().unwrap_or(Path::new("")).to_owned();
        let beside = self.diagnostics.source(span.source).map(|source| folder(&source.path));
        let folders: Vec<PathBuf> = beside.into_iter().chain([folder(&self.path)]).collect();
        file_candidates(name, &folders, &self.search_folders)
    }

    /// The first of [`Self::file_candidates`] where there is a file that the scene may read.
    pub fn find_file(&self, name: &str, span: Span) -> Option<PathBuf> {
        self.access.find(&self.file_candidates(name, span)).cloned()
    }
}
