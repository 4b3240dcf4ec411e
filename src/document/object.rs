//! The tree of plugins a scene file describes.

use std::sync::Arc;

use glam::Vec3;
use smol_str::SmolStr;

use super::{Span, TransformOp};

/// The most objects that may lie inside each other, references and includes counted in. Real scenes stay below ten.
pub const MAX_DEPTH: usize = 256;

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

    pub(crate) fn from_tag(tag: &str) -> Option<Self> {
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
    /// The name in snake_case: camelCase names of old files have been renamed.
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

    /// The object at another place in a file.
    pub fn at(self, span: Span) -> Self {
        Self { span, ..self }
    }

    /// The object with another property, which has the object's place.
    pub fn with(mut self, name: &str, value: Value) -> Self {
        self.properties.push(Property {
            name: name.into(),
            value,
            span: self.span,
        });
        self
    }

    /// The object with another plugin in it.
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

    /// The name that messages use: "bsdf `diffuse`", "the scene".
    pub fn title(&self) -> String {
        match self.category {
            Category::Scene => "the scene".to_owned(),
            category => format!("{} `{}`", category.tag(), self.plugin),
        }
    }
}
