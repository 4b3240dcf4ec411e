//! Finds the elements of a source text, including those that the parser does not know. It reads no values.

use std::ops::Range;

use quick_xml::Reader;
use quick_xml::events::Event;

use crate::document::value::quote;

/// One element; positions are byte offsets of the text.
#[derive(Debug)]
pub struct Element {
    /// The start tag.
    pub tag: Range<usize>,
    /// The position after the end tag.
    pub end: usize,
    /// The indices into [`Elements`], in the order of the text.
    pub children: Vec<usize>,
    /// Whether it is written as `<a/>`.
    pub closes_itself: bool,
}

/// The position of an attribute.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    /// The bytes of the name.
    pub name: Range<usize>,
    /// The range of the value without the quotes.
    pub value: Range<usize>,
    /// The quotation mark, `"` or `'`.
    pub quote: char,
}

/// The elements of one text, in the order of their start tags.
#[derive(Debug, Default)]
pub struct Elements(Vec<Element>);

impl Elements {
    /// Reads the elements up to the end of the text, or to a syntax error.
    pub fn read(text: &str) -> Self {
        Self::read_checked(text).0
    }

    /// Reads the elements as [`Self::read`] does, and returns the position and reason of a syntax error, if there is
    /// one.
    pub(crate) fn read_checked(text: &str) -> (Self, Option<(usize, String)>) {
        let mut reader = Reader::from_str(text);
        let mut all: Vec<Element> = Vec::new();
        let mut open: Vec<usize> = Vec::new();
        loop {
            let start = offset(reader.buffer_position());
            let event = reader.read_event();
            let end = offset(reader.buffer_position());
            let closes_itself = matches!(event, Ok(Event::Empty(_)));
            match event {
                Ok(Event::Start(_) | Event::Empty(_)) => {
                    let index = all.len();
                    if let Some(&parent) = open.last() {
                        all[parent].children.push(index);
                    }
                    all.push(Element {
                        tag: start..end,
                        end,
                        children: Vec::new(),
                        closes_itself,
                    });
                    if !closes_itself {
                        open.push(index);
                    }
                }
                Ok(Event::End(_)) => {
                    if let Some(index) = open.pop() {
                        all[index].end = end;
                    }
                }
                Ok(Event::Eof) => {
                    let unclosed = open.pop().map(|index| {
                        let tag = all[index].tag.clone();
                        (tag.start, format!("{} is never closed", quote(&text[tag])))
                    });
                    return (Self(all), unclosed);
                }
                Ok(_) => {}
                Err(error) => return (Self(all), Some((offset(reader.error_position()), error.to_string()))),
            }
        }
    }

    /// The element of an index from [`Self::root`] or [`Element::children`]; panics for others.
    pub fn get(&self, index: usize) -> &Element {
        &self.0[index]
    }

    /// The element whose start tag begins at `start`.
    pub(crate) fn starting_at(&self, start: usize) -> Option<usize> {
        self.0.binary_search_by_key(&start, |element| element.tag.start).ok()
    }

    /// The outermost element.
    pub fn root(&self) -> Option<usize> {
        (!self.0.is_empty()).then_some(0)
    }
}

impl Element {
    /// The bytes from the start tag to the end tag, both included.
    pub fn range(&self) -> Range<usize> {
        self.tag.start..self.end
    }

    /// The name of the tag. Here and below, `text` is the text from which the element was read.
    pub fn name<'t>(&self, text: &'t str) -> &'t str {
        let inside = &text[self.tag.start + 1..self.tag.end];
        let end = inside.find(|c: char| c.is_whitespace() || c == '/' || c == '>');
        &inside[..end.unwrap_or(inside.len())]
    }

    /// Reads the attributes of the start tag in their order, up to the first that is not well-formed.
    pub fn attributes(&self, text: &str) -> Vec<Attribute> {
        let mut found = Vec::new();
        let mut at = self.tag.start + 1 + self.name(text).len();
        let skip_blanks = |at: usize| self.tag.end - text[at..self.tag.end].trim_start().len();
        loop {
            at = skip_blanks(at);
            let rest = &text[at..self.tag.end];
            let Some(name_length) = rest.find(|c: char| c.is_whitespace() || matches!(c, '=' | '/' | '>')) else {
                return found;
            };
            let name = at..at + name_length;
            at = skip_blanks(name.end);
            if name.is_empty() || !text[at..self.tag.end].starts_with('=') {
                return found;
            }
            at = skip_blanks(at + 1);
            let Some(quote @ ('"' | '\'')) = text[at..self.tag.end].chars().next() else {
                return found;
            };
            let Some(length) = text[at + 1..self.tag.end].find(quote) else {
                return found;
            };
            let value = at + 1..at + 1 + length;
            at = value.end + 1;
            found.push(Attribute { name, value, quote });
        }
    }

    /// Finds an attribute by its name.
    pub fn attribute(&self, text: &str, name: &str) -> Option<Attribute> {
        let mut all = self.attributes(text).into_iter();
        all.find(|attribute| &text[attribute.name.clone()] == name)
    }

    /// The position for a further attribute: after the last one.
    pub(crate) fn end_of_attributes(&self, text: &str) -> usize {
        let after_name = self.tag.start + 1 + self.name(text).len();
        let last = self.attributes(text).pop();
        last.map_or(after_name, |attribute| attribute.value.end + 1)
    }
}

fn offset(position: u64) -> usize {
    usize::try_from(position).unwrap_or(usize::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_and_attributes_are_where_they_stand() {
        let text =
            "<?xml version='1.0'?><!-- <no/> --><scene a = 'x > y' b=\"1\"><one/>\n<two >t<three c=''/></two></scene>";
        let elements = Elements::read(text);
        let root = elements.get(elements.root().unwrap());
        assert_eq!(root.name(text), "scene");
        assert_eq!(root.end, text.len());
        let attributes: Vec<_> = root.attributes(text).into_iter().map(|a| &text[a.value]).collect();
        assert_eq!(attributes, ["x > y", "1"]);
        let names: Vec<_> = root
            .children
            .iter()
            .map(|&child| elements.get(child).name(text))
            .collect();
        assert_eq!(names, ["one", "two"]);
        let two = elements.get(root.children[1]);
        assert_eq!(&text[two.range()], "<two >t<three c=''/></two>");
        assert_eq!(elements.starting_at(two.tag.start), Some(root.children[1]));
        assert_eq!(elements.starting_at(two.tag.start + 1), None);
        let three = elements.get(two.children[0]);
        assert!(three.closes_itself && three.attribute(text, "c").is_some_and(|c| c.value.is_empty()));
        assert_eq!(&text[three.end_of_attributes(text)..three.end], "/>");
    }
}
