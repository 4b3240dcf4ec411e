//! Writes the new parts of an object after the element that they follow, with the indentation found there.

use super::edits::{Edit, apply, margin_of_line, resettle};
use super::elements::Element;
use super::source::slot_after;
use super::source::{Place, Source, is_scene};
use super::{Pair, Reviser};
use crate::document::write::{WriteError, check_finite, property_to_block, to_block};
use crate::document::{Child, Object, SourceId, Span};

impl<'r> Reviser<'r> {
    /// The edits for the properties and children of `pair.now` that have no element yet.
    pub(super) fn add(
        &mut self,
        index: usize,
        pair: &Pair,
        place: Place,
        edits: &mut Vec<Edit>,
    ) -> Result<(), WriteError> {
        let source = self.source(place.source);
        let element = source.elements.get(index);
        let mut added = Vec::new();
        for property in &pair.now.properties {
            if pair.old.properties.iter().any(|old| old.name == property.name) {
                continue;
            }
            check_finite(&property.value, &property.name, pair.now)?;
            let property = self.names.property_at(property, pair.now.category, place.folder);
            let slot = slot_after(source, element, pair.last_property);
            let block = property_to_block(&property, pair.now, &slot.margin, &source.layout)?;
            added.push((slot, block));
        }
        let mut last = pair.last_property;
        for (child, place_of_child) in pair.now.children.iter().zip(&pair.elements) {
            match place_of_child {
                Some(known) => last = Some(*known),
                None => {
                    let slot = slot_after(source, element, last);
                    let block = self.new_child(child, &slot.margin, place)?;
                    added.push((slot, block));
                }
            }
        }
        if !element.closes_itself || added.is_empty() {
            // Edits at the same place have to be in order.
            edits.extend(added.iter().map(|(slot, block)| slot.edit(block)));
            let outer = margin_of_line(source.text(), element.tag.start);
            let is_empty = source.text()[element.tag.end..element.end].starts_with("</");
            if let (true, Some((slot, _))) = (is_empty, added.first()) {
                edits.push(Edit::insert(slot.at, format!("{}{outer}", source.layout.newline)));
            }
            return Ok(());
        }
        let mut content = ">".to_owned();
        for (slot, block) in &added {
            content += &slot.edit(block).text;
        }
        let outer = margin_of_line(source.text(), element.tag.start);
        content += &format!("{}{outer}</{}>", source.layout.newline, element.name(source.text()));
        let end_of_attributes = element.end_of_attributes(source.text());
        edits.push(Edit::replace(end_of_attributes..element.end, content));
        Ok(())
    }

    /// The text of a child. If the child has only moved, it is the text of its former place.
    fn new_child(&mut self, child: &Child, margin: &str, place: Place) -> Result<String, WriteError> {
        let layout = &self.source(place.source).layout;
        let Child::Object(now) = child else {
            return to_block(child, margin, layout);
        };
        if let Some(old) = self.objects.get(&now.span).copied()
            && now.span != Span::default()
            && let Some(index) = self
                .source(now.span.source)
                .elements
                .starting_at(now.span.start as usize)
        {
            let from = self.source(now.span.source);
            let edits = self.object(
                index,
                old,
                now,
                Place {
                    source: now.span.source,
                    folder: place.folder,
                },
            )?;
            let range = from.elements.get(index).range();
            let old_margin = margin_of_line(from.text(), range.start);
            let block = apply(from.text(), range, edits);
            return Ok(resettle(&block, old_margin, margin, layout.newline));
        }
        let mut moved = Object::clone(now);
        self.names.move_object(&mut moved, place.folder);
        to_block(&moved.into(), margin, layout)
    }

    /// The text of an included file, in place of its `<include>`.
    pub(super) fn content_as_block(
        &self,
        included: SourceId,
        edits: Vec<Edit>,
        to: &Source,
        include: &Element,
    ) -> String {
        let source = self.source(included);
        let Some(root) = source.elements.root() else {
            return String::new();
        };
        let element = source.elements.get(root);
        let range = match is_scene(source, root) {
            true => element.tag.end..source.text()[..element.end].rfind("</").unwrap_or(element.end),
            false => element.range(),
        };
        let text = apply(source.text(), range.clone(), edits);
        let first_line = source.text()[range.start..].trim_start();
        let start = source.text().len() - first_line.len();
        let old_margin = margin_of_line(source.text(), start);
        let margin = margin_of_line(to.text(), include.tag.start);
        resettle(text.trim(), old_margin, margin, to.layout.newline)
    }
}
