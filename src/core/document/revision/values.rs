//! A new value written over the text of the old one, in its spelling: `x y z` stay attributes, separators and untouched
//! numbers stay.

use glam::Vec3;

use super::edits::Edit;
use super::elements::Element;
use super::source::Source;
use super::source::slot_after;
use crate::document::value::{fields, format_float, parse_float};
use crate::document::write::{WriteError, escape, step_to_block};
use crate::document::{Object, Property, TransformOp, Value};

/// The edits by which the property at `index` spells `now` instead of `before`; None if its tag cannot express that.
/// All numbers are finite.
pub(super) fn revise_value(
    source: &Source,
    index: usize,
    before: &Value,
    now: &Property,
    owner: &Object,
) -> Result<Option<Vec<Edit>>, WriteError> {
    let text = source.text();
    let element = source.elements.get(index);
    let tag = Tag { text, element };
    Ok(match (element.name(text), &now.value) {
        ("float", Value::Float(number)) => tag.numbers("value", &[*number]),
        ("spectrum", Value::Spectrum(number)) => tag.numbers("value", &[*number]),
        ("rgb", Value::Rgb(color)) => tag.numbers("value", &color.to_array()),
        ("integer", Value::Integer(number)) => tag.plain("value", number),
        ("boolean", Value::Boolean(truth)) => tag.plain("value", truth),
        ("string" | "default", Value::String(now)) => tag.value(Some(now), "value")?.map(|edit| vec![edit]),
        ("point", Value::Point(now)) | ("vector", Value::Vector(now)) => match before {
            Value::Point(before) | Value::Vector(before) => Some(tag.triple(*before, *now)),
            _ => None,
        },
        ("transform", Value::Transform(steps)) => match before {
            Value::Transform(before) => revise_steps(source, index, before, steps, &now.name, owner)?,
            _ => None,
        },
        _ => None,
    })
}

/// Sets, adds or removes an attribute; None if nothing changes.
pub fn revise_attribute(
    text: &str,
    element: &Element,
    name: &str,
    value: Option<&str>,
) -> Result<Option<Edit>, WriteError> {
    Tag { text, element }.value(value, name)
}

/// Revises steps: those that keep their kind change in place, and further ones follow. None if the transform has to be
/// rewritten.
fn revise_steps(
    source: &Source,
    index: usize,
    before: &[TransformOp],
    now: &[TransformOp],
    name: &str,
    owner: &Object,
) -> Result<Option<Vec<Edit>>, WriteError> {
    let element = source.elements.get(index);
    if element.children.len() != before.len() || before.len() > now.len() || before.is_empty() {
        return Ok(None);
    }
    let mut edits = Vec::new();
    for ((before, now), &child) in before.iter().zip(now).zip(&element.children) {
        if before == now {
            continue;
        }
        let tag = Tag {
            text: source.text(),
            element: source.elements.get(child),
        };
        let Some(changes) = tag.step(before, now) else {
            return Ok(None);
        };
        edits.extend(changes);
    }
    for step in &now[before.len()..] {
        let slot = slot_after(source, element, element.children.last().copied());
        let block = step_to_block(step, name, owner, &source.layout)?;
        edits.push(slot.edit(&block));
    }
    Ok(Some(edits))
}

#[derive(Clone, Copy)]
struct Tag<'t> {
    text: &'t str,
    element: &'t Element,
}

impl Tag<'_> {
    fn value(self, value: Option<&str>, name: &str) -> Result<Option<Edit>, WriteError> {
        Ok(match (self.element.attribute(self.text, name), value) {
            (Some(attribute), Some(value)) => {
                let mut escaped = String::new();
                escape(value, attribute.quote, &mut escaped)?;
                Some(Edit::replace(attribute.value, escaped))
            }
            (None, Some(value)) => {
                let mut escaped = String::new();
                escape(value, '"', &mut escaped)?;
                Some(self.add(name, &escaped))
            }
            (Some(attribute), None) => {
                let start = self.text[..attribute.name.start].trim_end().len();
                Some(Edit::replace(start..attribute.value.end + 1, ""))
            }
            (None, None) => None,
        })
    }

    fn add(self, name: &str, value: &str) -> Edit {
        let at = self.element.end_of_attributes(self.text);
        Edit::insert(at, format!(" {name}=\"{value}\""))
    }

    fn plain(self, name: &str, value: &impl ToString) -> Option<Vec<Edit>> {
        let attribute = self.element.attribute(self.text, name)?;
        Some(vec![Edit::replace(attribute.value, value.to_string())])
    }

    fn numbers(self, name: &str, numbers: &[f32]) -> Option<Vec<Edit>> {
        let attribute = self.element.attribute(self.text, name)?;
        let list = revise_list(&self.text[attribute.value.clone()], numbers);
        Some(vec![Edit::replace(attribute.value, list)])
    }

    /// The edits of three numbers, in `value` or in `x`, `y`, `z`.
    fn triple(self, before: Vec3, now: Vec3) -> Vec<Edit> {
        if let Some(edits) = self.numbers("value", &now.to_array()) {
            return edits;
        }
        let mut edits = Vec::new();
        for (name, (before, now)) in ["x", "y", "z"]
            .into_iter()
            .zip(before.to_array().into_iter().zip(now.to_array()))
        {
            if before != now {
                let text = format_float(now);
                edits.push(match self.element.attribute(self.text, name) {
                    Some(attribute) => Edit::replace(attribute.value, text),
                    None => self.add(name, &text),
                });
            }
        }
        edits
    }

    /// Returns the edits that turn one step into another. None if the steps are of different kinds.
    fn step(self, before: &TransformOp, now: &TransformOp) -> Option<Vec<Edit>> {
        match (*before, *now) {
            (TransformOp::Translate(before), TransformOp::Translate(now))
            | (TransformOp::Scale(before), TransformOp::Scale(now)) => Some(self.triple(before, now)),
            (
                TransformOp::Rotate {
                    axis: old_axis,
                    degrees: old_degrees,
                },
                TransformOp::Rotate { axis, degrees },
            ) => {
                let mut edits = Vec::new();
                if axis != old_axis {
                    edits = self.triple(old_axis, axis);
                }
                if degrees != old_degrees {
                    edits.extend(self.numbers("angle", &[degrees])?);
                }
                Some(edits)
            }
            (TransformOp::Matrix(_), TransformOp::Matrix(now)) => {
                self.numbers("value", &now.transpose().to_cols_array())
            }
            (
                TransformOp::LookAt {
                    origin: old_origin,
                    target: old_target,
                    up: old_up,
                },
                TransformOp::LookAt { origin, target, up },
            ) => {
                let mut edits = Vec::new();
                for (name, before, now) in [
                    ("origin", old_origin, origin),
                    ("target", old_target, target),
                    ("up", old_up, up),
                ] {
                    if before != now {
                        let now = now.to_array();
                        edits.extend(
                            self.numbers(name, &now)
                                .unwrap_or_else(|| vec![self.add(name, &revise_list("", &now))]),
                        );
                    }
                }
                Some(edits)
            }
            _ => None,
        }
    }
}

/// The numbers as a list, which differs from the old one only where the numbers do. A single number for all is kept if
/// possible.
fn revise_list(old: &str, numbers: &[f32]) -> String {
    let known: Vec<&str> = fields(old).collect();
    if known.len() == 1 && numbers.iter().all(|number| *number == numbers[0]) {
        return format_float(numbers[0]);
    }
    // The old values cannot be compared if they have `$` names or are `#` colours.
    if known.len() != numbers.len() || old.contains(['$', '#']) {
        let texts: Vec<String> = numbers.iter().copied().map(format_float).collect();
        return texts.join(", ");
    }
    let mut result = String::new();
    let mut rest = old;
    for (field, number) in known.iter().zip(numbers) {
        let start = rest.find(field).unwrap_or(0);
        result += &rest[..start];
        match parse_float(field) {
            Ok(same) if same == *number => result += field,
            _ => result += &format_float(*number),
        }
        rest = &rest[start + field.len()..];
    }
    result + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_keep_their_looks() {
        assert_eq!(revise_list("1.0,  0.50\t0", &[1.0, 0.25, 0.0]), "1.0,  0.25\t0");
        assert_eq!(revise_list(" 0.5 ", &[0.7; 3]), "0.7");
        assert_eq!(revise_list("0.5", &[0.7, 0.7, 0.8]), "0.7, 0.7, 0.8");
        assert_eq!(revise_list("#ff0000", &[1.0, 0.5, 0.0]), "1, 0.5, 0");
        assert_eq!(revise_list("$x 1 2", &[0.0, 1.0, 2.0]), "0, 1, 2");
    }
}
