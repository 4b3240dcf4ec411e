//! The tree of plugins a scene file describes.

use std::sync::Arc;

use glam::Vec3;
use smol_str::SmolStr;

use super::{Span, TransformOp};

/// The most nested objects, references and includes counted in. Real scenes stay below ten.
pub const MAX_DEPTH: usize = 256;

declare_names! {
    /// The kind of plugin that a tag declares; the name is that of the tag.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
    pub enum Category {
        /// The root of a file, `<scene>`.
        Scene = "scene",
        /// The method by which light is computed, `<integrator>`.
        Integrator = "integrator",
        /// A camera, `<sensor>`.
        Sensor = "sensor",
        /// The size and crop of a sensor's picture, `<film>`.
        Film = "film",
        /// The pixel filter of a film, `<rfilter>`.
        ReconstructionFilter = "rfilter",
        /// The number, kind and seed of a sensor's samples, `<sampler>`.
        Sampler = "sampler",
        /// A geometric object, a group of them or an instance of a group, `<shape>`.
        Shape = "shape",
        /// A material, `<bsdf>`.
        Bsdf = "bsdf",
        /// A light, in the scene or inside an emissive shape, `<emitter>`.
        Emitter = "emitter",
        /// A value that varies over a surface, `<texture>`.
        Texture = "texture",
        /// A participating medium, which fills the space between surfaces, `<medium>`.
        Medium = "medium",
        /// The phase function of a medium, which says where scattered light goes, `<phase>`.
        Phase = "phase",
        /// A value that varies in space, `<volume>`.
        Volume = "volume",
    }
}

/// A property's value. Numbers are single precision, as everything downstream.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// `<float>`; finite where it was read from a file.
    Float(f32),
    /// `<integer>`.
    Integer(i64),
    /// `<boolean>`.
    Boolean(bool),
    /// `<string>`; names of files are kept as written, relative or absolute.
    String(String),
    /// `<rgb>`: linear Rec. 709 (a `#rrggbb` has been taken through the sRGB transfer).
    Rgb(Vec3),
    /// `<spectrum>` given as one number, the same at all wavelengths.
    Spectrum(f32),
    /// `<point>`, a position.
    Point(Vec3),
    /// `<vector>`, a direction or an extent of any length.
    Vector(Vec3),
    /// `<transform>`: its steps, in the order in which they apply.
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

/// A parameter of an object that is a value and no plugin, with its place in the text.
#[derive(Clone, Debug, PartialEq)]
pub struct Property {
    /// The name in snake_case: camelCase names of old files have been renamed.
    pub name: SmolStr,
    /// The value, of the type that the tag names.
    pub value: Value,
    /// The keys, if it is animated. `value` is then the value at the document's time.
    pub keys: Option<Arc<Track>>,
    /// The span of the whole tag, to which messages about the value point.
    pub span: Span,
}

impl Property {
    /// A property that is not animated, at a place in a file.
    pub fn new(name: impl Into<SmolStr>, value: Value, span: Span) -> Self {
        Self {
            name: name.into(),
            value,
            keys: None,
            span,
        }
    }
}

/// The value of a property at a time.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// Seconds; finite.
    pub time: f64,
    /// The value at that time.
    pub value: Value,
}

/// The keys of one property.
#[derive(Clone, Debug, PartialEq)]
pub struct Track {
    /// The keys by rising time, at least one. All values are of one type.
    pub keys: Vec<Key>,
    /// The interpolation between neighbouring keys.
    pub interpolation: Interpolation,
}

declare_names! {
    /// The interpolation from one key to the next.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum Interpolation {
        /// At constant speed.
        #[default]
        Linear = "linear",
        /// With zero speed at both keys: the fraction 3 s^2 - 2 s^3 after the fraction s of the time.
        Ease = "ease",
        /// The value of a key holds until the next key.
        Step = "step",
    }
}

/// A plugin inside a plugin, in place or by reference.
#[derive(Clone, Debug, PartialEq)]
pub enum Child {
    /// A nested object. It is shared, so that readers of a document can keep it without a copy.
    Object(Arc<Object>),
    /// `<ref>` to an object that is declared elsewhere in the scene.
    Reference {
        /// The parameter of the parent, if the file names one.
        name: Option<SmolStr>,
        /// The id of the referenced object. A [`super::Index`] finds it.
        id: SmolStr,
        /// The whole tag.
        span: Span,
    },
}

impl Child {
    /// The parameter of the parent, if the file names one.
    pub fn name(&self) -> Option<&str> {
        match self {
            Self::Object(object) => object.name.as_deref(),
            Self::Reference { name, .. } => name.as_deref(),
        }
    }

    /// Sets [`Self::name`].
    pub fn set_name(&mut self, new: Option<SmolStr>) {
        match self {
            Self::Object(object) => Arc::make_mut(object).name = new,
            Self::Reference { name, .. } => *name = new,
        }
    }

    /// Returns the start tag of a child in place, the whole tag of a reference.
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
    /// The kind of plugin, which the name of the tag gives.
    pub category: Category,
    /// The `type` attribute; empty for the scene itself.
    pub plugin: SmolStr,
    /// The name by which references find the object, unique in a parsed document.
    pub id: Option<SmolStr>,
    /// The parameter of the parent, if the file names one.
    pub name: Option<SmolStr>,
    /// The values in the order of the file. A name occurs at most once in a parsed document.
    pub properties: Vec<Property>,
    /// The plugins inside this one, in the order of the file.
    pub children: Vec<Child>,
    /// The start tag.
    pub span: Span,
}

impl Object {
    /// An empty object; `plugin` is its `type`.
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

    /// The object with one more property, at the object's place.
    pub fn with(mut self, name: &str, value: Value) -> Self {
        self.properties.push(Property::new(name, value, self.span));
        self
    }

    /// The object with one more nested plugin.
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

    /// Whether it is a group of shapes, which appear only where it is instanced.
    pub fn is_group(&self) -> bool {
        self.category == Category::Shape && self.plugin == "shapegroup"
    }

    /// The name that messages use: "bsdf `diffuse`", "the scene".
    pub fn title(&self) -> String {
        match self.category {
            Category::Scene => "the scene".to_owned(),
            category => format!("{} `{}`", category.name(), self.plugin),
        }
    }
}
