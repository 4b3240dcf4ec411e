//! The texts that are revised, and their destinations.

use std::path::{Path, PathBuf};

use super::edits::{Edit, Layout, apply, end_of_line, margin, margin_of_line};
use super::elements::{Element, Elements};
use crate::document::{Document, SourceFile, SourceId, Span};

/// Finds the file that a name refers to in a file of this folder.
pub type FindFile<'f> = &'f dyn Fn(&str, &Path) -> Option<PathBuf>;

/// The path of the main file, and the lookup of file names.
#[derive(Clone, Copy)]
pub struct Destination<'d> {
    /// The absolute path. If its folder is that of the original document, included files are written as well.
    pub path: &'d Path,
    /// Finds the file that a name refers to now.
    pub find_before: FindFile<'d>,
    /// Finds the file that a name will refer to once the main file is at `path`.
    pub find_after: FindFile<'d>,
    /// Whether an included file (absolute path) has changed since it was read: a main file in another folder cannot
    /// include it then.
    pub has_changed: &'d dyn Fn(&Path) -> bool,
}

/// A file of the document with its layout.
pub struct Source<'a> {
    pub file: &'a SourceFile,
    pub elements: Elements,
    pub layout: Layout,
}

impl<'a> Source<'a> {
    /// Reads the layout of every file of a document, in the order of [`SourceId`].
    pub fn all(document: &'a Document) -> Vec<Self> {
        let files = document.diagnostics.sources.iter();
        files
            .map(|file| {
                let elements = Elements::read(&file.text);
                let layout = elements.root().map_or_else(Layout::default, |root| {
                    let root = elements.get(root);
                    Layout::of(
                        &file.text,
                        root,
                        root.children.first().map(|&first| elements.get(first)),
                    )
                });
                Self { file, elements, layout }
            })
            .collect()
    }

    /// The text as it was read, without a byte order mark.
    pub fn text(&self) -> &'a str {
        &self.file.text
    }

    /// The text to write: with the edits made, and with the byte order mark that the file had.
    pub fn with(&self, edits: Vec<Edit>) -> String {
        let text = apply(self.text(), 0..self.text().len(), edits);
        match self.file.byte_order_mark {
            true => format!("\u{feff}{text}"),
            false => text,
        }
    }
}

/// The destination of a text.
#[derive(Clone, Copy)]
pub struct Place<'p> {
    pub source: SourceId,
    /// The folder to which names of files are relative.
    pub folder: &'p Path,
}

pub fn is_scene(source: &Source, root: usize) -> bool {
    source.elements.get(root).name(source.text()) == "scene"
}

pub fn span_of(element: &Element, source: SourceId) -> Span {
    Span {
        source,
        start: position(element.tag.start),
        end: position(element.tag.end),
    }
}

pub fn position(offset: usize) -> u32 {
    u32::try_from(offset).unwrap_or(u32::MAX)
}

/// The position of an insertion, with the layout expected there.
pub struct Slot<'t> {
    pub at: usize,
    pub margin: String,
    /// Whether the insertion gets lines of its own.
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

/// The slot after the element `last`, or before all others if it is None.
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
