//! The place of something new in a text, with the indentation found there.

use super::edits::{Edit, end_of_line, margin, margin_of_line};
use super::elements::Element;
use super::source::Source;

/// The place for something new, with the layout that it should have there.
pub struct Slot<'t> {
    pub at: usize,
    pub margin: String,
    /// Whether it gets lines of its own.
    on_own_line: bool,
    source: &'t Source<'t>,
}

impl Slot<'_> {
    pub fn edit(&self, block: &str) -> Edit {
        let text = match self.on_own_line {
            true => format!("{}{}{block}", self.source.layout.newline, self.margin),
            false => block.to_owned(),
        };
        Edit::insert(self.at, text)
    }
}

/// The slot after the element `last`, or before all others if there is none.
pub fn slot_after<'t>(source: &'t Source<'t>, element: &Element, last: Option<usize>) -> Slot<'t> {
    let text = source.text();
    let beside = last
        .or(element.children.first().copied())
        .map(|index| source.elements.get(index));
    let Some(beside) = beside else {
        let outer = margin_of_line(text, element.tag.start);
        return Slot {
            at: element.tag.end,
            margin: format!("{outer}{}", source.layout.unit),
            on_own_line: true,
            source,
        };
    };
    let own_line = margin(text, beside.tag.start);
    let after = match last {
        Some(_) => beside.end,
        None => element.tag.end,
    };
    Slot {
        at: if own_line.is_some() {
            end_of_line(text, after)
        } else {
            after
        },
        margin: own_line.unwrap_or(margin_of_line(text, beside.tag.start)).to_owned(),
        on_own_line: own_line.is_some(),
        source,
    }
}
