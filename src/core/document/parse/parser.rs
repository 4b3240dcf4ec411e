//! The parser: one loop over the events of `quick-xml` with a stack of its own, so that deep files cannot exhaust the
//! program's.
//!
//! The files of `<spectrum filename="...">` are cached: a file named by many tags is read once for each role of its
//! spectrum.

use std::collections::{HashMap, HashSet};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec3;
use quick_xml::Reader as XmlReader;
use quick_xml::events::{BytesStart, Event};
use smol_str::SmolStr;

use super::spare::Spare;
use crate::document::crowd::Packer;
use crate::document::define::Defines;
use crate::document::links::Alias;
use crate::document::naming::modernize;
use crate::document::object::MAX_DEPTH;
use crate::document::paths::canonical;
use crate::document::source::MAX_FILE_BYTES;
use crate::document::spectrum::{Role, SampledSpectrum};
use crate::document::tag::Tag;
use crate::document::{
    Category, Child, Crowd, Diagnostics, Include, Interpolation, Key, Object, Property, Severity, SourceFile, SourceId,
    Span, TransformOp, Value,
};
use crate::files::{Access, FolderNames};

const BYTE_ORDER_MARK: char = '\u{feff}';

/// The most levels of includes inside includes.
pub(super) const MAX_INCLUDE_DEPTH: usize = 15;
/// The most search folders of a document: each named file is looked for in all of them.
pub(super) const MAX_SEARCH_FOLDERS: usize = 100;
/// The most includes of a document, each counted as often as it is read.
pub(super) const MAX_INCLUDES: usize = 10_000;
/// The most parameters of one object, all of which are scanned for each reference to it. Plugins have a few dozen.
pub(super) const MAX_PROPERTIES: usize = 4096;
/// The most tags of a document, each include counted each time: enough for a million instances with a few steps each.
const MAX_ELEMENTS: usize = 10_000_000;
/// The most bytes of text of a document, each include counted each time.
const MAX_TOTAL_BYTES: u64 = 4 * MAX_FILE_BYTES;

/// Parses the children of a scene in a part of a source text, which was read without errors before and has no `$names`.
pub(in crate::document) fn parse_children(file: &SourceFile, source: SourceId, range: Range<u32>) -> Vec<Child> {
    let mut level = Level::new(source, file.text.clone(), 0);
    level.packer = None;
    level.stack.push(Frame::Object {
        object: Object::new(Category::Scene, ""),
        names: Names::default(),
    });
    let mut parser = Parser {
        is_part: true,
        ..Parser::default()
    };
    parser.parse_range(range.start as usize..range.end as usize, &mut level);
    level.root.map_or_else(Vec::new, |root| root.children)
}

/// An open tag.
pub(super) enum Frame {
    Object {
        object: Object,
        names: Names,
    },
    Transform {
        /// The name of the property; None inside an animation.
        name: Option<SmolStr>,
        /// The time of the key inside an animation.
        time: Option<f64>,
        ops: Vec<TransformOp>,
        span: Span,
    },
    /// The keys of a property.
    Animation(OpenAnimation),
    /// A value or a step, which has no child elements.
    Leaf {
        tag: &'static str,
        span: Span,
    },
}

/// An animation that is being read.
pub(super) struct OpenAnimation {
    pub name: SmolStr,
    pub interpolation: Interpolation,
    /// The kind of the object that has the property.
    pub category: Category,
    pub keys: Vec<Key>,
    /// Whether a key could not be read, which has been reported.
    pub is_broken: bool,
    pub span: Span,
}

impl Frame {
    fn span(&self) -> Span {
        match self {
            Self::Object { object, .. } => object.span,
            Self::Animation(animation) => animation.span,
            Self::Transform { span, .. } | Self::Leaf { span, .. } => *span,
        }
    }

    fn tag(&self) -> &str {
        match self {
            Self::Object { object, .. } => object.category.name(),
            Self::Transform { .. } => "transform",
            Self::Animation(_) => "animation",
            Self::Leaf { tag, .. } => tag,
        }
    }
}

/// The open tags of one source.
pub(super) struct Level {
    source: SourceId,
    text: Arc<String>,
    stack: Vec<Frame>,
    /// The depth of the including tag in its own file.
    base_depth: usize,
    /// The number of open tags inside a skipped element.
    skipping: usize,
    root: Option<Object>,
    /// Packs consecutive instances of the main file; None in other files.
    packer: Option<Packer>,
}

#[derive(Default)]
pub(super) struct Parser {
    pub access: Access,
    pub diagnostics: Diagnostics,
    pub defines: Defines,
    pub search_folders: Vec<PathBuf>,
    /// The cached names in the folders in which files were sought.
    pub names: FolderNames,
    /// Files read so far.
    pub files: HashMap<PathBuf, SourceId>,
    /// The chain of includes that is being read, the main file first, each with the span of its include.
    pub open_files: Vec<(PathBuf, Option<Span>)>,
    pub ids: HashMap<SmolStr, Span>,
    pub aliases: Vec<Alias>,
    pub includes: Vec<Include>,
    /// The first include whose file could not be read, or only in part, or the place at which the main file is broken.
    pub not_read: Option<Span>,
    pub elements: usize,
    pub bytes: u64,
    /// Whether a limit of the whole document was reached; nothing more is read.
    pub exhausted: bool,
    /// Whether only a part of a text is read. Its includes are left out then.
    pub is_part: bool,
    pub crowds: Vec<Crowd>,
    pub spectra: SpectrumFiles,
    pub spare: Spare,
}

/// Whether another tag begins within this one, because its `>` is missing.
fn runs_into_another(tag: &BytesStart) -> bool {
    tag.contains('<') && tag.attributes().with_checks(false).any(|attribute| attribute.is_err())
}

/// The part of a span in its first line.
fn first_line(text: &str, span: Span) -> Span {
    let line = text
        .get(span.start as usize..span.end as usize)
        .and_then(|text| text.lines().next());
    let length = line.map_or(0, |line| line.trim_end().len());
    Span {
        end: span.start + u32::try_from(length).unwrap_or(0),
        ..span
    }
}

impl Parser {
    pub fn add_source(&mut self, path: PathBuf, mut text: String) -> SourceId {
        let id = SourceId(u32::try_from(self.diagnostics.sources.len()).unwrap_or(u32::MAX));
        let byte_order_mark = text.starts_with(BYTE_ORDER_MARK);
        if byte_order_mark {
            text.drain(..BYTE_ORDER_MARK.len_utf8());
        }
        self.diagnostics.sources.push(SourceFile {
            path,
            byte_order_mark,
            text: Arc::new(text),
        });
        id
    }

    /// The root object of one file.
    pub fn parse_source(&mut self, source: SourceId, base_depth: usize) -> Option<Object> {
        let text = self.diagnostics.source(source)?.text.clone();
        self.bytes += text.len() as u64;
        if self.bytes > MAX_TOTAL_BYTES {
            self.exhaust(None, "the includes of this scene add up to too much text");
            return None;
        }
        let all = 0..text.len();
        let mut level = Level::new(source, text, base_depth);
        self.parse_range(all, &mut level);
        if let Some(packer) = level.packer {
            self.crowds = packer.finish();
        }
        level.root
    }

    /// Parses the tags in a range of the level's text.
    fn parse_range(&mut self, range: Range<usize>, level: &mut Level) {
        let (source, text) = (level.source, level.text.clone());
        let mut reader = XmlReader::from_str(text.get(range.clone()).unwrap_or_default());
        let position = |offset: u64| u32::try_from(range.start as u64 + offset).unwrap_or(u32::MAX);
        while !self.exhausted {
            let start = reader.buffer_position();
            let event = reader.read_event();
            let span = Span {
                source,
                start: position(start),
                end: position(reader.buffer_position()),
            };
            match event {
                Ok(Event::Start(tag) | Event::Empty(tag)) if runs_into_another(&tag) => {
                    let name = tag.name();
                    let error = format!("<{}> has no `>` at its end", name.into_inner());
                    self.stop_reading(first_line(&level.text, span), &error, level);
                    break;
                }
                Ok(Event::Start(tag)) => self.open(&tag, span, true, level),
                Ok(Event::Empty(tag)) => self.open(&tag, span, false, level),
                Ok(Event::End(_)) => self.close(level, span.end),
                Ok(Event::Text(content)) if !content.trim().is_empty() => self.stray_text(span, level),
                Ok(Event::CData(_) | Event::GeneralRef(_)) => self.stray_text(span, level),
                Ok(Event::DocType(content)) => {
                    if content.contains("<!ENTITY") {
                        let message = "entities are not supported";
                        let help = "use <default name=... value=...> and `$name` instead".to_owned();
                        self.diagnostics
                            .push(Severity::Error, Some(span), message.to_owned(), Some(help));
                    } else {
                        self.diagnostics.warn(span, "the document type is ignored");
                    }
                }
                Ok(Event::Eof) => {
                    self.end_of_file(level);
                    break;
                }
                Ok(Event::Text(_) | Event::Comment(_) | Event::Decl(_) | Event::PI(_)) => {}
                Err(error) => {
                    let at = position(reader.error_position());
                    let place = Span {
                        start: at,
                        end: span.end.max(at),
                        ..span
                    };
                    self.stop_reading(place, &error.to_string(), level);
                    break;
                }
            }
        }
        level.skipping = 0;
        let end = position(reader.buffer_position());
        while !level.stack.is_empty() {
            self.close(level, end);
        }
    }

    /// Reports that a file cannot be read from here on. Objects that are missing for that are not reported.
    fn stop_reading(&mut self, place: Span, error: &str, level: &Level) {
        let open = level.stack.last().filter(|_| level.skipping == 0);
        let help = open.map(|frame| {
            let line = self.diagnostics.locate(frame.span()).map_or(0, |(_, line, _)| line);
            format!("<{}> of line {line} is still open here", frame.tag())
        });
        let message = format!("broken XML: {error}");
        self.diagnostics.push(Severity::Error, Some(place), message, help);
        let include = self.open_files.last().and_then(|(_, include)| *include);
        self.not_read = self.not_read.or(include).or(Some(place));
    }

    fn stray_text(&mut self, span: Span, level: &Level) {
        if level.skipping == 0 {
            let text = level
                .text
                .get(span.start as usize..span.end as usize)
                .unwrap_or_default();
            let blanks = text.len() - text.trim_start().len();
            let start = span.start + u32::try_from(blanks).unwrap_or(0);
            let span = Span { start, ..span };
            self.diagnostics.warn(span, "text between tags is ignored");
        }
    }

    fn end_of_file(&mut self, level: &Level) {
        if let Some(frame) = level.stack.last() {
            let message = format!("<{}> is never closed", frame.tag());
            self.diagnostics.error(frame.span(), message);
        } else if level.skipping > 0 {
            let message = "the file ends inside a tag".to_owned();
            self.diagnostics.push(Severity::Error, Some(level.end()), message, None);
        } else if level.root.is_none() && !self.diagnostics.has_errors() {
            let message = "there is no <scene> in this file".to_owned();
            self.diagnostics.push(Severity::Error, Some(level.end()), message, None);
        }
    }

    pub fn exhaust(&mut self, span: Option<Span>, message: &str) {
        self.exhausted = true;
        self.diagnostics.push(Severity::Error, span, message.to_owned(), None);
    }

    /// Handles a start tag, or (`stays_open` false) an empty-element tag.
    fn open(&mut self, start: &BytesStart, span: Span, stays_open: bool, level: &mut Level) {
        self.elements += 1;
        if self.elements > MAX_ELEMENTS {
            self.exhaust(Some(span), &format!("more than {MAX_ELEMENTS} tags"));
            return;
        }
        let opened = level.skipping == 0 && self.enter(start, span, level);
        if opened && !stays_open {
            self.close(level, span.end);
        } else if !opened && stays_open {
            level.skipping += 1;
        }
    }

    /// Pushes the tag's frame; false if the whole element is to be skipped.
    fn enter(&mut self, start: &BytesStart, span: Span, level: &mut Level) -> bool {
        let depth = level.base_depth + level.stack.len();
        if depth >= MAX_DEPTH {
            self.diagnostics
                .error(span, format!("tags are nested more than {MAX_DEPTH} deep"));
            return false;
        }
        let mut tag = Tag::new(start, &level.text, span, &mut self.defines, &mut self.diagnostics);
        let frame = match level.stack.last_mut() {
            None => self.enter_root(&mut tag, level.root.is_some()),
            Some(Frame::Leaf { tag: outer, .. }) => {
                let message = format!("<{}> cannot stand inside <{outer}>", tag.name);
                self.diagnostics.error(span, message);
                None
            }
            Some(Frame::Transform { ops, .. }) => self.enter_transform_op(&mut tag, ops),
            Some(Frame::Animation(animation)) => self.enter_in_animation(&mut tag, animation),
            Some(Frame::Object { object, names }) => self.enter_in_object(&mut tag, object, names, depth),
        };
        let Some(frame) = frame else {
            return false;
        };
        tag.finish(&mut self.diagnostics);
        level.stack.push(frame);
        true
    }

    /// Handles an end tag, or the end of a malformed file. `end`: the byte after it.
    fn close(&mut self, level: &mut Level, end: u32) {
        if level.skipping > 0 {
            level.skipping -= 1;
            return;
        }
        match level.stack.pop() {
            Some(Frame::Object { mut object, .. }) => {
                modernize(&mut object, &mut self.diagnostics);
                object.properties = self.spare.properties.fitted(object.properties);
                object.children = self.spare.children.fitted(object.children);
                let is_top_level = level.stack.len() == 1;
                match level.stack.last_mut() {
                    Some(Frame::Object { object: parent, .. }) => {
                        parent.children.push(object.into());
                        if let Some(packer) = level.packer.as_mut().filter(|_| is_top_level) {
                            packer.note(&mut parent.children, &level.text, end);
                        }
                    }
                    _ => level.root = Some(object),
                }
            }
            Some(Frame::Transform {
                name: Some(name),
                ops,
                span,
                ..
            }) => {
                let ops = self.spare.steps.fitted(ops);
                if let Some(Frame::Object { object, names }) = level.stack.last_mut() {
                    self.add_property(object, names, Property::new(name, Value::Transform(ops), span));
                }
            }
            Some(Frame::Transform {
                time: Some(time),
                ops,
                span,
                ..
            }) => {
                let ops = self.spare.steps.fitted(ops);
                if let Some(Frame::Animation(animation)) = level.stack.last_mut() {
                    self.add_key(animation, time, Value::Transform(ops), span);
                }
            }
            Some(Frame::Animation(animation)) => {
                if let Some(Frame::Object { object, names }) = level.stack.last_mut() {
                    self.close_animation(animation, object, names);
                }
            }
            Some(Frame::Transform { .. } | Frame::Leaf { .. }) | None => {}
        }
    }
}

impl Level {
    /// The state before reading a file. `base_depth` is zero for the main file, whose crowds are packed.
    fn new(source: SourceId, text: Arc<String>, base_depth: usize) -> Self {
        Self {
            source,
            text,
            stack: Vec::new(),
            base_depth,
            skipping: 0,
            root: None,
            packer: (base_depth == 0).then(Packer::default),
        }
    }

    /// The empty span after the last character.
    fn end(&self) -> Span {
        let end = u32::try_from(self.text.trim_end().len()).unwrap_or(u32::MAX);
        Span {
            source: self.source,
            start: end,
            end,
        }
    }
}

/// Up to this number of properties, names are compared one by one.
const FEW: usize = 16;

/// The set of the names given so far. Nearly all objects have few properties, and need no set.
#[derive(Debug, Default)]
pub(super) struct Names(HashSet<SmolStr>);

impl Names {
    /// Whether one of the properties has this name. `properties` must belong to the same object at each call, and may
    /// only grow.
    pub fn contain(&mut self, name: &str, properties: &[Property]) -> bool {
        if properties.len() <= FEW {
            return properties.iter().any(|property| property.name == name);
        }
        let new = &properties[self.0.len()..];
        self.0.extend(new.iter().map(|property| property.name.clone()));
        self.0.contains(name)
    }
}

/// A colour and whether it was clamped, or an error.
type Color = Result<(Vec3, bool), String>;

/// The colours of the spectrum files read so far.
#[derive(Default)]
pub(super) struct SpectrumFiles {
    colors: HashMap<(PathBuf, Role), Color>,
}

impl SpectrumFiles {
    /// The colour of the spectrum in a file, which the first call gets from `read`.
    pub fn color(&mut self, path: &Path, role: Role, read: impl FnOnce() -> Result<SampledSpectrum, String>) -> Color {
        let key = (canonical(path), role);
        let color = self.colors.entry(key);
        color.or_insert_with(|| Ok(read()?.to_rgb(role))).clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_once_for_each_role() {
        let mut files = SpectrumFiles::default();
        let mut readings = 0;
        let mut color = |file: &str, role| {
            files.color(Path::new(file), role, || {
                readings += 1;
                SampledSpectrum::parse_file("400 1\n700 1\n").map_err(|error| error.to_string())
            })
        };
        let first = color("/nowhere/a", Role::Emission);
        assert!(first.is_ok());
        for _ in 0..100 {
            assert_eq!(color("/nowhere/a", Role::Emission), first);
        }
        assert_ne!(color("/nowhere/a", Role::Reflectance), first);
        assert_eq!(color("/nowhere/b", Role::Emission), first);
        assert_eq!(readings, 3);
    }
}
