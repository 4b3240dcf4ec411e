//! The tree of plugins a scene file describes.

use std::path::PathBuf;

use glam::Vec3;

use super::{Diagnostics, Span, TransformOp};

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

#[derive(Clone, Debug, PartialEq)]
pub struct Property {
    /// In snake_case: camelCase names of old files have been renamed.
    pub name: String,
    pub value: Value,
    /// The span of the whole tag; what a message about the value points at.
    pub span: Span,
}

/// A plugin inside a plugin, in place or by reference.
#[derive(Clone, Debug, PartialEq)]
pub enum Child {
    Object(Object),
    Reference {
        /// The parameter it is meant for, where the file names one.
        name: Option<String>,
        id: String,
        span: Span,
    },
}

/// One plugin: `<bsdf type="diffuse" id="red" name="..."> ... </bsdf>`.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    pub category: Category,
    /// The `type` attribute; empty for the scene itself.
    pub plugin: String,
    pub id: Option<String>,
    /// The parameter of the parent it is meant for, where the file names one.
    pub name: Option<String>,
    pub properties: Vec<Property>,
    pub children: Vec<Child>,
    pub span: Span,
}

/// A parsed scene file with its includes and defaults resolved.
#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    pub path: PathBuf,
    /// The `<scene>`.
    pub root: Object,
    pub diagnostics: Diagnostics,
}
