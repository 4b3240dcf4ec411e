//! The rows of a Bevy component whose type the game's schema tells: fields of structs, lists of variants. Parts whose
//! form is not known are JSON.

use bevy_egui::egui::Ui;
use serde_json::{Map, Value};

use super::caption::Caption;
use super::fields;
use crate::app::editor::model::game_types::{Content, Fields, Form, GameTypes, Variant};

/// The depth to which fields have rows of their own.
const DEEPEST: usize = 8;

/// Shows the rows of a value of this type; returns true if edited.
pub(super) fn rows(ui: &mut Ui, types: &GameTypes, path: &str, caption: Caption, value: &mut Value) -> bool {
    part(ui, types, path, caption, value, DEEPEST)
}

fn part(ui: &mut Ui, types: &GameTypes, path: &str, caption: Caption, value: &mut Value, deepest: usize) -> bool {
    let Some(deeper) = deepest.checked_sub(1) else {
        return json(ui, caption, value);
    };
    match types.form(path) {
        Form::Boolean => {
            let mut truth = value.as_bool().unwrap_or_default();
            fields::checkbox(ui, caption, &mut truth) && set(value, truth.into())
        }
        Form::Integer => {
            let mut number = value.as_i64().unwrap_or_default();
            let least = if path.starts_with('u') { 0 } else { i64::MIN };
            fields::integer(ui, caption, &mut number, least..=i64::MAX) && set(value, number.into())
        }
        Form::Number => {
            let mut number = value.as_f64().unwrap_or_default() as f32;
            let speed = 0.01 * number.abs().max(1.0);
            fields::number(ui, caption, &mut number, speed, f32::MIN..=f32::MAX) && set(value, short_number(number))
        }
        Form::Text => {
            let mut text = value.as_str().unwrap_or_default().to_owned();
            fields::text(ui, caption, &mut text) && set(value, text.into())
        }
        Form::Newtype(of) => part(ui, types, of, caption, value, deeper),
        Form::Struct(all) if all.is_empty() => {
            fields::note(ui, caption, "no fields");
            false
        }
        Form::Struct(all) => {
            fields::note(ui, caption, short(path));
            let mut made = object(value);
            let changed = field_rows(ui, types, &all, &mut made, deeper);
            changed && set(value, Value::Object(made))
        }
        Form::Enum(variants) => variant_rows(ui, types, &variants, caption, value, deeper),
        Form::Other => json(ui, caption, value),
    }
}

/// The number with as few digits as single precision needs.
fn short_number(number: f32) -> Value {
    number.to_string().parse::<f64>().map_or(Value::Null, Value::from)
}

/// The name of a type without its path.
fn short(path: &str) -> &str {
    path.rsplit("::").next().unwrap_or(path)
}

fn set(value: &mut Value, new: Value) -> bool {
    *value = new;
    true
}

fn object(value: &Value) -> Map<String, Value> {
    value.as_object().cloned().unwrap_or_default()
}

/// Fields that the value lacks are shown with that of a new one, and are added when they are edited.
fn field_rows(ui: &mut Ui, types: &GameTypes, all: &Fields, made: &mut Map<String, Value>, deepest: usize) -> bool {
    let mut changed = false;
    for (name, of) in all {
        ui.push_id(name, |ui| {
            let mut field = made
                .get(*name)
                .cloned()
                .or_else(|| types.new_value(of))
                .unwrap_or(Value::Null);
            if part(ui, types, of, Caption::from(*name), &mut field, deepest) {
                made.insert((*name).to_owned(), field);
                changed = true;
            }
        });
    }
    changed
}

fn variant_rows(
    ui: &mut Ui,
    types: &GameTypes,
    variants: &[Variant],
    caption: Caption,
    value: &mut Value,
    deepest: usize,
) -> bool {
    let name = |value: &Value| match value {
        Value::String(name) => Some(name.clone()),
        Value::Object(one) => one.keys().next().cloned(),
        _ => None,
    };
    let now = name(value);
    let place = variants.iter().position(|variant| now.as_deref() == Some(variant.name));
    let mut chosen = place.unwrap_or(usize::MAX);
    let options: Vec<(usize, &str)> = variants
        .iter()
        .enumerate()
        .map(|(i, variant)| (i, variant.name))
        .collect();
    if fields::choice(ui, caption, &mut chosen, &options) {
        return variants
            .get(chosen)
            .and_then(|variant| types.variant(variant))
            .is_some_and(|new| set(value, new));
    }
    let (Some(variant), Value::Object(one)) = (place.and_then(|place| variants.get(place)), value) else {
        return false;
    };
    let Some(inner) = one.get_mut(variant.name) else {
        return false;
    };
    match &variant.content {
        None => false,
        Some(Content::One(of)) => part(ui, types, of, Caption::from(variant.name), inner, deepest),
        Some(Content::Several(_)) => json(ui, Caption::from(variant.name), inner),
        Some(Content::Fields(all)) => {
            let mut made = object(inner);
            field_rows(ui, types, all, &mut made, deepest) && set(inner, Value::Object(made))
        }
    }
}

/// A value as JSON. A text that is none is not taken.
fn json(ui: &mut Ui, caption: Caption, value: &mut Value) -> bool {
    let mut text = value.to_string();
    fields::text(ui, caption, &mut text) && serde_json::from_str(&text).is_ok_and(|new| set(value, new))
}
