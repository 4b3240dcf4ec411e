//! Properties of things as `extras` of nodes.
//!
//! Bevy components stand in `skein`, a list of objects with one key each: the path of the type, with the value in the
//! JSON of Bevy's reflection. The plugin of Skein (`bevy_skein` 0.5) inserts them when a level is spawned, and so does
//! any reader of Bevy's `GltfExtras`. Other properties stand beside them under their own names.

use serde_json::{Map, Value};

use crate::gltf::write::GltfWriter;
use crate::scene::{Properties, PropertyItem, PropertyValue};

/// The key with the list of components.
const SKEIN: &str = "skein";

/// The extras of a thing with these properties; None without any. Whole numbers of 64 bits are written as they are,
/// colours are linear, and references are names.
pub(super) fn extras_of(properties: Option<&Properties>) -> Option<Value> {
    let mut plain = Map::new();
    let mut components = Vec::new();
    for (name, value) in properties?.iter() {
        match value {
            PropertyValue::One(PropertyItem::Component(json)) => {
                // Only texts that are JSON become values of this type.
                let json = serde_json::from_str(json).unwrap_or(Value::Null);
                components.push(Value::Object(Map::from_iter([(name.to_owned(), json)])));
            }
            PropertyValue::One(item) => _ = plain.insert(name.to_owned(), json(item)),
            PropertyValue::List(_, items) => {
                _ = plain.insert(name.to_owned(), Value::Array(items.iter().map(json).collect()));
            }
        }
    }
    if !components.is_empty() {
        plain.insert(SKEIN.to_owned(), Value::Array(components));
    }
    Some(Value::Object(plain))
}

fn json(item: &PropertyItem) -> Value {
    match item {
        PropertyItem::Boolean(truth) => Value::from(*truth),
        PropertyItem::Integer(number) => Value::from(*number),
        PropertyItem::Number(number) => short_number(*number),
        PropertyItem::Vector(numbers) | PropertyItem::Color(numbers) => {
            Value::from(numbers.to_array().map(short_number).to_vec())
        }
        PropertyItem::Text(text)
        | PropertyItem::File(text)
        | PropertyItem::Reference(text)
        | PropertyItem::Component(text) => Value::from(text.as_str()),
    }
}

/// The number with as few digits as single precision needs.
fn short_number(number: f32) -> Value {
    number.to_string().parse::<f64>().map_or(Value::Null, Value::from)
}

/// Sets the extras of a node that was made for a thing.
pub(super) fn set_extras(writer: &mut GltfWriter, node: usize, properties: Option<&Properties>) {
    if let Some(extras) = extras_of(properties) {
        writer.add_extras(node, extras);
    }
}
