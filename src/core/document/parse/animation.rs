//! The key frames of a property: `<animation>` with a value tag for each key.

use std::mem::discriminant;
use std::sync::Arc;

use super::element::{known, leaf};
use super::parser::Names;
use super::parser::{Frame, OpenAnimation, Parser};
use crate::document::animation::MOST_TIME;
use crate::document::property::{VALUE_TAGS, read_value};
use crate::document::tag::Tag;
use crate::document::value::{parse_float, quote};
use crate::document::{Category, Interpolation, Key, Object, Property, Severity, Span, Track, Value};

impl Parser {
    pub(super) fn open_animation(&mut self, tag: &mut Tag, category: Category) -> Option<OpenAnimation> {
        let name = self.property_name(tag);
        let interpolation = match tag.take("interpolation") {
            None => Interpolation::default(),
            Some((word, span)) => {
                let found = Interpolation::of_name(word.trim());
                found.unwrap_or_else(|| {
                    let names = Interpolation::ALL.map(|kind| format!("`{}`", kind.name()));
                    let message = format!("expected {}, found {}", names.join(", "), quote(&word));
                    self.diagnostics.error(span, message);
                    Interpolation::default()
                })
            }
        };
        Some(OpenAnimation {
            name: name?,
            interpolation,
            category,
            keys: Vec::new(),
            is_broken: false,
            span: tag.span,
        })
    }

    /// A key: a value tag, or a transform, with the attribute `time` in place of a name.
    pub(super) fn enter_in_animation(&mut self, tag: &mut Tag, animation: &mut OpenAnimation) -> Option<Frame> {
        let value_tag = known(&VALUE_TAGS, tag.name);
        if value_tag.is_none() && tag.name != "transform" {
            let message = format!("<{}> is no key of an animation", tag.name);
            let known = VALUE_TAGS.into_iter().chain(["transform"]);
            let help = self.diagnostics.did_you_mean(tag.name, known);
            self.diagnostics.push(Severity::Error, Some(tag.span), message, help);
            animation.is_broken = true;
            return None;
        }
        let time = self.key_time(tag, animation);
        animation.is_broken |= time.is_none();
        let Some(value_tag) = value_tag else {
            return Some(Frame::Transform {
                name: None,
                time,
                ops: self.spare.steps.take(),
                span: tag.span,
            });
        };
        let value = match value_tag {
            "spectrum" => self.read_spectrum_tag(tag, animation.category, &animation.name),
            _ => read_value(tag, &mut self.diagnostics),
        };
        match (time, value) {
            (Some(time), Some(value)) => self.add_key(animation, time, value, tag.span),
            _ => animation.is_broken = true,
        }
        Some(leaf(value_tag, tag.span))
    }

    fn key_time(&mut self, tag: &mut Tag, animation: &OpenAnimation) -> Option<f64> {
        let (text, span) = tag.need("time", &mut self.diagnostics)?;
        let time = match parse_float(&text) {
            Ok(time) => f64::from(time),
            Err(error) => {
                self.diagnostics.error(span, error.to_string());
                return None;
            }
        };
        if time.abs() > MOST_TIME {
            let message = format!("expected a time from -1e9 to 1e9 s, found {}", quote(&text));
            self.diagnostics.error(span, message);
            return None;
        }
        if let Some(last) = animation.keys.last()
            && time <= last.time
        {
            let message = format!(
                "expected a time after that of the key before, {} s, found {time} s",
                last.time
            );
            self.diagnostics.error(span, message);
            return None;
        }
        Some(time)
    }

    pub(super) fn add_key(&mut self, animation: &mut OpenAnimation, time: f64, value: Value, span: Span) {
        match animation.keys.first() {
            Some(first) if discriminant(&first.value) != discriminant(&value) => {
                let (first, found) = (first.value.kind(), value.kind());
                let message = format!("expected {first}, as in the first key of this animation, found {found}");
                self.diagnostics.error(span, message);
                animation.is_broken = true;
            }
            _ => animation.keys.push(Key { time, value }),
        }
    }

    /// Gives the object the property, with its value at the time 0.
    pub(super) fn close_animation(&mut self, animation: OpenAnimation, object: &mut Object, names: &mut Names) {
        let OpenAnimation { name, span, .. } = animation;
        if animation.is_broken {
            return;
        }
        if animation.keys.is_empty() {
            self.diagnostics.error(
                span,
                "an animation needs a key, such as <float time=\"0\" value=\"1\"/>",
            );
            return;
        }
        let track = Track {
            keys: animation.keys,
            interpolation: animation.interpolation,
        };
        let property = Property {
            value: track.at(0.0),
            keys: Some(Arc::new(track)),
            name,
            span,
        };
        self.add_property(object, names, property);
    }
}
