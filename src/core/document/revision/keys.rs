//! Writes keys over the text of a value, or of other keys, in its spelling: keys that were not edited do not change.

use super::edits::{Edit, apply, margin_of_line, resettle};
use super::source::Source;
use super::source::slot_after;
use super::values::{revise_attribute, revise_value};
use crate::document::value::format_float;
use crate::document::write::{WriteError, animation_tag, check_finite, key_to_block};
use crate::document::{Interpolation, Key, Object, Property, Track, Value};

/// An element that spells a value.
#[derive(Clone, Copy)]
struct Text<'t> {
    /// The index of the element.
    element: usize,
    value: &'t Value,
}

/// The role of a written value.
#[derive(Clone, Copy)]
enum Use {
    /// The property itself.
    Property,
    /// The key at this time in seconds.
    Key(f64),
}

pub(super) struct Keys<'k> {
    pub source: &'k Source<'k>,
    pub owner: &'k Object,
    /// The property to be written.
    pub now: &'k Property,
}

impl Keys<'_> {
    /// The edits by which the element at `index`, which spells `old`, spells the property with its keys; None if it has
    /// to be rewritten.
    pub fn revise(&self, index: usize, old: &Property) -> Result<Option<Vec<Edit>>, WriteError> {
        for key in self.now.keys.iter().flat_map(|track| &track.keys) {
            check_finite(&key.value, &self.now.name, self.owner)?;
        }
        match (&old.keys, &self.now.keys) {
            (None, None) => revise_value(self.source, index, &old.value, self.now, self.owner),
            (None, Some(track)) => {
                let (element, value) = (index, &old.value);
                self.begin(Text { element, value }, track).map(Some)
            }
            (Some(old), Some(now)) => self.edit(index, old, now),
            (Some(old), None) => self.end(index, old),
        }
    }

    /// Replaces a value by an animation.
    fn begin(&self, text: Text, track: &Track) -> Result<Vec<Edit>, WriteError> {
        let element = self.source.elements.get(text.element);
        let margin = margin_of_line(self.source.text(), element.tag.start);
        let newline = self.source.layout.newline;
        let inner = format!("{margin}{}", self.source.layout.unit);
        let mut block = animation_tag(&self.now.name, track)?;
        for key in &track.keys {
            block += &format!("{newline}{inner}{}", self.key(text, key, &inner)?);
        }
        block += &format!("{newline}{margin}</animation>");
        Ok(vec![Edit::replace(element.range(), block)])
    }

    /// Replaces an animation by a value.
    fn end(&self, index: usize, track: &Track) -> Result<Option<Vec<Edit>>, WriteError> {
        let Some(texts) = self.texts(index, track) else {
            return Ok(None);
        };
        let range = self.source.elements.get(index).range();
        let margin = margin_of_line(self.source.text(), range.start);
        let same = texts.iter().find(|text| *text.value == self.now.value);
        let block = self.spelled(*same.unwrap_or(&texts[0]), Use::Property, &self.now.value, margin)?;
        Ok(block.map(|block| vec![Edit::replace(range, block)]))
    }

    /// Replaces the keys of an animation. Keys of the same time are the same; between two of these, as many others as
    /// possible count as moved.
    fn edit(&self, index: usize, old: &Track, now: &Track) -> Result<Option<Vec<Edit>>, WriteError> {
        let Some(texts) = self.texts(index, old) else {
            return Ok(None);
        };
        let element = self.source.elements.get(index);
        let mut edits = Vec::new();
        if old.interpolation != now.interpolation {
            let word = (now.interpolation != Interpolation::default()).then_some(now.interpolation.name());
            edits.extend(revise_attribute(self.source.text(), element, "interpolation", word)?);
        }
        let is_kept = |key: &Key, others: &Track| others.keys.iter().any(|other| other.time == key.time);
        let mut waiting = old.keys.iter().zip(&texts).peekable();
        let mut last: Option<Text> = None;
        for key in &now.keys {
            let stays = is_kept(key, old);
            // A key that was removed before a key that stays.
            while let Some((_, gone)) = waiting.next_if(|(other, _)| stays && other.time != key.time) {
                edits.push(self.delete(*gone));
            }
            let before = waiting.next_if(|(other, _)| stays || !is_kept(other, now));
            if let Some((before, text)) = before {
                last = Some(*text);
                if before != key {
                    edits.extend(self.changed(*text, before, key)?);
                }
                continue;
            }
            let slot = slot_after(self.source, element, last.map(|last| last.element));
            let near = last.or(texts.first().copied());
            let block = match near {
                Some(near) => self.key(near, key, &slot.margin)?,
                None => self.plain_key(key, &slot.margin)?,
            };
            edits.push(slot.edit(&block));
        }
        edits.extend(waiting.map(|(_, gone)| self.delete(*gone)));
        Ok(Some(edits))
    }

    /// The elements of the keys of an animation; None if it has other elements.
    fn texts<'t>(&self, index: usize, track: &'t Track) -> Option<Vec<Text<'t>>> {
        let element = self.source.elements.get(index);
        let is_animation = element.name(self.source.text()) == "animation";
        let values = track.keys.iter().map(|key| &key.value);
        let texts = element.children.iter().zip(values);
        (is_animation && element.children.len() == track.keys.len())
            .then(|| texts.map(|(&element, value)| Text { element, value }).collect())
    }

    fn delete(&self, text: Text) -> Edit {
        let range = self.source.elements.get(text.element).range();
        Edit::delete(self.source.text(), range)
    }

    /// The edits that turn the text of one key into another.
    fn changed(&self, text: Text, before: &Key, now: &Key) -> Result<Vec<Edit>, WriteError> {
        let edits = self.edits(text, Use::Key(now.time), &now.value, before.time != now.time)?;
        if let Some(edits) = edits {
            return Ok(edits);
        }
        let range = self.source.elements.get(text.element).range();
        let margin = margin_of_line(self.source.text(), range.start);
        Ok(vec![Edit::replace(range, self.plain_key(now, margin)?)])
    }

    /// A key in the spelling of an element, if that can express it. The lines after the first have this indentation.
    fn key(&self, text: Text, key: &Key, margin: &str) -> Result<String, WriteError> {
        match self.spelled(text, Use::Key(key.time), &key.value, margin)? {
            Some(block) => Ok(block),
            None => self.plain_key(key, margin),
        }
    }

    fn plain_key(&self, key: &Key, margin: &str) -> Result<String, WriteError> {
        key_to_block(key, &self.now.name, self.owner, margin, &self.source.layout)
    }

    /// A value in the spelling of an element; None if that cannot express it.
    fn spelled(&self, text: Text, purpose: Use, value: &Value, margin: &str) -> Result<Option<String>, WriteError> {
        let element = self.source.elements.get(text.element);
        let edits = self.edits(text, purpose, value, true)?;
        Ok(edits.map(|edits| {
            let block = apply(self.source.text(), element.range(), edits);
            let old_margin = margin_of_line(self.source.text(), element.tag.start);
            resettle(&block, old_margin, margin, self.source.layout.newline)
        }))
    }

    /// The edits by which an element spells a value, with another role if `renames`; None if it cannot express the
    /// value.
    fn edits(&self, text: Text, purpose: Use, value: &Value, renames: bool) -> Result<Option<Vec<Edit>>, WriteError> {
        let element = self.source.elements.get(text.element);
        let now = Property {
            value: value.clone(),
            keys: None,
            ..self.now.clone()
        };
        let mut edits = match text.value == value {
            true => Vec::new(),
            false => match revise_value(self.source, text.element, text.value, &now, self.owner)? {
                Some(edits) => edits,
                None => return Ok(None),
            },
        };
        if renames {
            let attributes = ["name", "time"].map(|name| element.attribute(self.source.text(), name));
            let Some(attribute) = attributes.into_iter().flatten().next() else {
                return Ok(None);
            };
            let words = match purpose {
                Use::Property => format!("name=\"{}\"", self.now.name),
                Use::Key(time) => format!("time=\"{}\"", format_float(time as f32)),
            };
            edits.push(Edit::replace(attribute.name.start..attribute.value.end + 1, words));
        }
        Ok(Some(edits))
    }
}
