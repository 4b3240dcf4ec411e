//! The elements of a file of this dialect with their attributes; other modules interpret them.

use quick_xml::escape::unescape;

use crate::document::revision::elements::Elements;
use crate::document::{SourceId, Span};

pub struct Tree<'t> {
    text: &'t str,
    elements: Elements,
    root: usize,
}

/// One element.
#[derive(Clone, Copy)]
pub struct Node<'t> {
    tree: &'t Tree<'t>,
    index: usize,
}

impl<'t> Tree<'t> {
    /// Parses a text. The error holds the byte offset of the syntax error, and the reason.
    pub fn read(text: &'t str) -> Result<Self, (usize, String)> {
        let (elements, broken) = Elements::read_checked(text);
        if let Some(broken) = broken {
            return Err(broken);
        }
        match elements.root() {
            Some(root) => Ok(Self { text, elements, root }),
            None => Err((text.len(), "there is no element in this file".to_owned())),
        }
    }

    pub fn root(&'t self) -> Node<'t> {
        Node {
            tree: self,
            index: self.root,
        }
    }
}

impl<'t> Node<'t> {
    pub fn name(self) -> &'t str {
        self.tree.elements.get(self.index).name(self.tree.text)
    }

    /// The start tag.
    pub fn span(self) -> Span {
        let tag = &self.tree.elements.get(self.index).tag;
        span(tag.start, tag.end)
    }

    pub fn children(self) -> impl Iterator<Item = Node<'t>> {
        let children = self.tree.elements.get(self.index).children.iter();
        children.map(move |&index| Node { index, ..self })
    }

    /// The first child element with one of these names; their order in the list does not matter.
    pub fn child(self, names: &[&str]) -> Option<Node<'t>> {
        self.children().find(|child| names.contains(&child.name()))
    }

    /// An attribute's text and place.
    pub fn attribute(self, name: &str) -> Option<(String, Span)> {
        let attribute = self.tree.elements.get(self.index).attribute(self.tree.text, name)?;
        let raw = &self.tree.text[attribute.value.clone()];
        let value = unescape(raw).map_or_else(|_| raw.to_owned(), |value| value.into_owned());
        Some((value, span(attribute.value.start, attribute.value.end)))
    }

    /// The names of all attributes, with their places.
    pub fn attributes(self) -> impl Iterator<Item = (&'t str, Span)> {
        let (text, element) = (self.tree.text, self.tree.elements.get(self.index));
        let all = element.attributes(text).into_iter();
        all.map(|attribute| {
            (
                &text[attribute.name.clone()],
                span(attribute.name.start, attribute.name.end),
            )
        })
    }

    pub fn text_of(self, attribute: &str) -> Option<String> {
        self.attribute(attribute).map(|(text, _)| text)
    }
}

fn span(start: usize, end: usize) -> Span {
    let position = |offset: usize| u32::try_from(offset).unwrap_or(u32::MAX);
    Span {
        source: SourceId(0),
        start: position(start),
        end: position(end),
    }
}
