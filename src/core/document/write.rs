//! Writes a [`Document`] as XML text that reads back to the same tree.
//!
//! Includes and defaults are resolved: one file is written, with every value spelled out. File names are written
//! unchanged; the caller has to adapt names that are relative to an include or to another folder.

use std::fmt::Write as _;
use std::path::Path;

use glam::Vec3;

use super::parsed::{property_name, scene_unit};
use super::paths::{file_name, settle};
use super::revision::edits::Layout;
use super::value::format_float;
use super::{Category, Child, Document, Interpolation, Key, Object, Property, Track, TransformOp, Value};

const VERSION: &str = "3.0.0";

/// The reason why a document cannot be written as XML.
#[derive(Debug, thiserror::Error, PartialEq)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum WriteError {
    #[error("`{name}` of {owner} is not a finite number and cannot be saved")]
    NotFinite { name: String, owner: String },
    #[error("{text:?} has characters that XML cannot carry")]
    NotXml { text: String },
}

/// The document as a scene file. The same document always gives the same text.
pub fn to_xml(document: &Document) -> Result<String, WriteError> {
    let layout = Layout::default();
    let mut writer = Writer::new("", &layout);
    let home = settle(&document.path);
    let home = home.parent().unwrap_or(Path::new("/"));
    let search_folders = document
        .search_folders
        .iter()
        .map(|folder| match folder.canonicalize() {
            Ok(folder) => file_name(&folder, home),
            Err(_) => folder.display().to_string(),
        });
    let root = document.unpacked().root;
    writer.object(&root, &search_folders.collect::<Vec<_>>())?;
    Ok(writer.text)
}

/// A child as text for an existing file: lines after the first begin with `margin`, the last one has no line end.
pub(super) fn to_block(child: &Child, margin: &str, layout: &Layout) -> Result<String, WriteError> {
    let mut writer = Writer {
        inside: 1,
        ..Writer::new(margin, layout)
    };
    writer.child(child)?;
    Ok(writer.into_block())
}

/// Writes a property as [`to_block`] does; `owner` is for the message.
pub(super) fn property_to_block(
    property: &Property,
    owner: &Object,
    margin: &str,
    layout: &Layout,
) -> Result<String, WriteError> {
    let mut writer = Writer::new(margin, layout);
    writer.property(property, owner)?;
    Ok(writer.into_block())
}

/// A key of the property `name` as [`to_block`] writes it; `owner` is for the message.
pub(super) fn key_to_block(
    key: &Key,
    name: &str,
    owner: &Object,
    margin: &str,
    layout: &Layout,
) -> Result<String, WriteError> {
    let mut writer = Writer::new(margin, layout);
    writer.key(key, name, owner)?;
    Ok(writer.into_block())
}

/// The start tag of the keys of the property `name`.
pub(super) fn animation_tag(name: &str, track: &Track) -> Result<String, WriteError> {
    let layout = Layout::default();
    let mut writer = Writer::new("", &layout);
    writer.open_animation(name, track)?;
    Ok(writer.text.trim().to_owned())
}

/// One step of the transform `name`, in one line.
pub(super) fn step_to_block(
    step: &TransformOp,
    name: &str,
    owner: &Object,
    layout: &Layout,
) -> Result<String, WriteError> {
    let mut writer = Writer::new("", layout);
    writer.transform_op(step, name, owner)?;
    Ok(writer.into_block())
}

struct Writer<'l> {
    text: String,
    depth: usize,
    margin: &'l str,
    layout: &'l Layout,
    /// The number of open tags around the present position.
    inside: usize,
}

impl<'l> Writer<'l> {
    fn new(margin: &'l str, layout: &'l Layout) -> Self {
        Self {
            text: String::new(),
            depth: 0,
            margin,
            layout,
            inside: 0,
        }
    }

    fn into_block(self) -> String {
        let text = self.text.strip_suffix(self.layout.newline).unwrap_or(&self.text);
        text.strip_prefix(self.margin).unwrap_or(text).to_owned()
    }

    fn child(&mut self, child: &Child) -> Result<(), WriteError> {
        match child {
            Child::Object(object) => self.object(object, &[]),
            Child::Reference { name, id, .. } => {
                let mut attributes = vec![("id", id.as_str())];
                attributes.extend(name.as_deref().map(|name| ("name", name)));
                self.tag("ref", &attributes, true)
            }
        }
    }

    fn object(&mut self, object: &Object, search_folders: &[String]) -> Result<(), WriteError> {
        let tag = object.category.name();
        let mut attributes: Vec<(&str, &str)> = Vec::new();
        if self.depth + self.inside == 0 {
            attributes.push(("version", VERSION));
        }
        if object.category != Category::Scene || !object.plugin.is_empty() {
            attributes.push(("type", &object.plugin));
        }
        attributes.extend(object.id.as_deref().map(|id| ("id", id)));
        attributes.extend(object.name.as_deref().map(|name| ("name", name)));
        if object.properties.is_empty() && object.children.is_empty() && search_folders.is_empty() {
            return self.tag(tag, &attributes, true);
        }
        self.tag(tag, &attributes, false)?;
        self.depth += 1;
        for folder in search_folders {
            self.tag("path", &[("value", folder)], true)?;
        }
        for property in &object.properties {
            self.property(property, object)?;
        }
        for child in &object.children {
            self.child(child)?;
        }
        self.close(tag);
        Ok(())
    }

    fn animation(&mut self, name: &str, track: &Track, owner: &Object) -> Result<(), WriteError> {
        self.open_animation(name, track)?;
        self.depth += 1;
        for key in &track.keys {
            self.key(key, name, owner)?;
        }
        self.close("animation");
        Ok(())
    }

    fn open_animation(&mut self, name: &str, track: &Track) -> Result<(), WriteError> {
        let mut attributes = vec![("name", name)];
        if track.interpolation != Interpolation::default() {
            attributes.push(("interpolation", track.interpolation.name()));
        }
        self.tag("animation", &attributes, false)
    }

    fn key(&mut self, key: &Key, name: &str, owner: &Object) -> Result<(), WriteError> {
        let time = format_float(key.time as f32);
        self.value("time", &time, &key.value, (name, owner))
    }

    fn property(&mut self, property: &Property, owner: &Object) -> Result<(), WriteError> {
        let name = &*property.name;
        match &property.keys {
            Some(track) => self.animation(name, track, owner),
            None => self.value("name", name, &property.value, (name, owner)),
        }
    }

    /// Writes a value tag, identified by its first attribute. `of` is the property and its object, for messages.
    fn value(&mut self, key: &str, key_value: &str, value: &Value, of: (&str, &Object)) -> Result<(), WriteError> {
        let (name, owner) = of;
        let numbers = |numbers: &[f32]| list(numbers, name, owner);
        let (tag, text) = match value {
            Value::Float(number) => ("float", numbers(&[*number])?),
            Value::Spectrum(number) => ("spectrum", numbers(&[*number])?),
            Value::Rgb(color) => ("rgb", numbers(&color.to_array())?),
            Value::Point(xyz) => ("point", numbers(&xyz.to_array())?),
            Value::Vector(xyz) => ("vector", numbers(&xyz.to_array())?),
            Value::Integer(number) => ("integer", number.to_string()),
            Value::Boolean(truth) => ("boolean", truth.to_string()),
            Value::String(text) if is_default(owner, name, text) => ("default", text.clone()),
            Value::String(text) => ("string", text.clone()),
            Value::Transform(ops) => {
                self.tag("transform", &[(key, key_value)], ops.is_empty())?;
                if !ops.is_empty() {
                    self.depth += 1;
                    for op in ops {
                        self.transform_op(op, name, owner)?;
                    }
                    self.close("transform");
                }
                return Ok(());
            }
        };
        self.tag(tag, &[(key, key_value), ("value", &text)], true)
    }

    fn transform_op(&mut self, op: &TransformOp, name: &str, owner: &Object) -> Result<(), WriteError> {
        let triple = |v: Vec3| list(&v.to_array(), name, owner);
        match *op {
            TransformOp::Translate(by) => self.tag("translate", &[("value", &triple(by)?)], true),
            TransformOp::Scale(by) if by == Vec3::splat(by.x) => {
                self.tag("scale", &[("value", &list(&[by.x], name, owner)?)], true)
            }
            TransformOp::Scale(by) => self.tag("scale", &[("value", &triple(by)?)], true),
            TransformOp::Rotate { axis, degrees } => {
                let angle = list(&[degrees], name, owner)?;
                let mut coordinates = ["x", "y", "z"].into_iter().zip(Vec3::AXES);
                match coordinates.find(|(_, known)| *known == axis) {
                    Some((coordinate, _)) => self.tag("rotate", &[(coordinate, "1"), ("angle", &angle)], true),
                    None => self.tag("rotate", &[("value", &triple(axis)?), ("angle", &angle)], true),
                }
            }
            TransformOp::Matrix(matrix) => {
                let rows = matrix.transpose().to_cols_array();
                self.tag("matrix", &[("value", &list(&rows, name, owner)?)], true)
            }
            TransformOp::LookAt { origin, target, up } => {
                let (origin, target, up) = (triple(origin)?, triple(target)?, triple(up)?);
                self.tag("lookat", &[("origin", &origin), ("target", &target), ("up", &up)], true)
            }
        }
    }

    fn tag(&mut self, name: &str, attributes: &[(&str, &str)], closed: bool) -> Result<(), WriteError> {
        self.indent();
        let _ = write!(self.text, "<{name}");
        for (attribute, value) in attributes {
            // Properties may have values in JSON, which has many quotation marks.
            let quote = if name == "default" && value.contains('"') {
                '\''
            } else {
                '"'
            };
            let _ = write!(self.text, " {attribute}={quote}");
            escape(value, quote, &mut self.text)?;
            self.text.push(quote);
        }
        self.text += if closed { "/>" } else { ">" };
        self.text += self.layout.newline;
        Ok(())
    }

    fn close(&mut self, name: &str) {
        self.depth -= 1;
        self.indent();
        let _ = write!(self.text, "</{name}>{}", self.layout.newline);
    }

    fn indent(&mut self) {
        self.text += self.margin;
        for _ in 0..self.depth {
            self.text += &self.layout.unit;
        }
    }
}

/// Whether a text of an object is a `default` in the file: a unit of the scene, or a property with a type.
fn is_default(owner: &Object, name: &str, text: &str) -> bool {
    scene_unit(owner, name, text).is_some() || property_name(name).is_some()
}

/// An error if a number of the value is infinite or NaN: the format has no text for it.
pub(crate) fn check_finite(value: &Value, name: &str, owner: &Object) -> Result<(), WriteError> {
    let numbers = match value {
        Value::Float(number) | Value::Spectrum(number) => vec![*number],
        Value::Rgb(triple) | Value::Point(triple) | Value::Vector(triple) => triple.to_array().to_vec(),
        Value::Transform(steps) => steps.iter().flat_map(TransformOp::numbers).collect(),
        Value::Integer(_) | Value::Boolean(_) | Value::String(_) => Vec::new(),
    };
    list(&numbers, name, owner).map(|_| ())
}

fn list(numbers: &[f32], name: &str, owner: &Object) -> Result<String, WriteError> {
    if numbers.iter().any(|number| !number.is_finite()) {
        return Err(WriteError::NotFinite {
            name: name.to_owned(),
            owner: owner.title(),
        });
    }
    let texts: Vec<String> = numbers.iter().copied().map(format_float).collect();
    Ok(texts.join(", "))
}

/// Escapes a value between these quotation marks, so that XML and the `$name` replacement both give the text back.
pub(super) fn escape(value: &str, quote: char, text: &mut String) -> Result<(), WriteError> {
    for c in value.chars() {
        match c {
            '&' => *text += "&amp;",
            '<' => *text += "&lt;",
            '>' => *text += "&gt;",
            '"' if quote == '"' => *text += "&quot;",
            '\'' if quote == '\'' => *text += "&apos;",
            '$' => *text += "\\$",
            '\t' => *text += "&#9;",
            '\n' => *text += "&#10;",
            '\r' => *text += "&#13;",
            c if c.is_ascii_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => {
                return Err(WriteError::NotXml { text: value.to_owned() });
            }
            c => text.push(c),
        }
    }
    Ok(())
}
