//! XML text to [`Document`]: files, includes, defaults, and the nesting of tags.
//!
//! One loop over the events of `quick-xml` with a stack of its own, so that deep files cannot exhaust the program's. After a bad value
//! it goes on, so that one run tells of all of them; after broken XML the rest of that file is not looked at. Whatever was understood
//! by then is in the document, next to the errors.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use quick_xml::Reader as XmlReader;
use quick_xml::events::{BytesStart, Event};

use super::define::Defines;
use super::links::{Alias, link};
use super::naming::{modernize, snake_case};
use super::property::{
    TRANSFORM_TAGS, VALUE_TAGS, read_spectrum, read_transform_op, read_value, sampled_color, spectrum_role,
};
use super::source::{MAX_FILE_BYTES, SourceError, read_text};
use super::spectrum::SampledSpectrum;
use super::suggest::did_you_mean;
use super::tag::Tag;
use super::value::quote;
use super::{
    Category, Child, Diagnostics, Document, Object, Property, Severity, SourceFile, SourceId, Span, TransformOp, Value,
};

/// Tags inside tags, references and includes counted in. Real scenes stay below ten.
pub const MAX_DEPTH: usize = 256;
/// Includes inside includes.
const MAX_INCLUDE_DEPTH: usize = 15;
/// All tags of a document, each include counted each time.
const MAX_ELEMENTS: usize = 8_000_000;
/// All text of a document, likewise.
const MAX_TOTAL_BYTES: u64 = 4 * MAX_FILE_BYTES;

/// Reads a scene file; `defines` are the command line's `name=value` pairs. An error only if there is no text to be had: what is wrong
/// with the text is in the document's diagnostics.
pub fn load(path: &Path, defines: &[(String, String)]) -> Result<Document, SourceError> {
    let text = read_text(path)?;
    Ok(parse_str(&text, path, defines))
}

/// As [`load`], for text that is in memory; relative paths in it start from `path`'s folder.
pub fn parse_str(text: &str, path: &Path, defines: &[(String, String)]) -> Document {
    let mut parser = Parser {
        diagnostics: Diagnostics::default(),
        defines: Defines::new(defines),
        search_folders: Vec::new(),
        files: HashMap::new(),
        open_files: Vec::new(),
        ids: HashMap::new(),
        aliases: Vec::new(),
        elements: 0,
        bytes: 0,
        exhausted: false,
    };
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let source = parser.add_source(path.to_owned(), text);
    let root = if text.len() as u64 > MAX_FILE_BYTES {
        let message = format!("longer than {} MiB, which no scene should be", MAX_FILE_BYTES >> 20);
        parser.diagnostics.push(Severity::Error, None, message, None);
        None
    } else {
        parser.open_files.push(canonical(path));
        parser.parse_source(source, 0)
    };
    parser.finish(path, root)
}

/// An open tag.
enum Frame {
    Object {
        object: Object,
        /// Names of its properties so far.
        names: HashSet<String>,
    },
    Transform {
        name: Option<String>,
        ops: Vec<TransformOp>,
        span: Span,
    },
    /// A value or a step: nothing may stand inside.
    Leaf { tag: String, span: Span },
}

impl Frame {
    fn span(&self) -> Span {
        match self {
            Self::Object { object, .. } => object.span,
            Self::Transform { span, .. } | Self::Leaf { span, .. } => *span,
        }
    }

    fn tag(&self) -> &str {
        match self {
            Self::Object { object, .. } => object.category.tag(),
            Self::Transform { .. } => "transform",
            Self::Leaf { tag, .. } => tag,
        }
    }
}

/// One source's open tags.
struct Level {
    source: SourceId,
    text: Arc<str>,
    stack: Vec<Frame>,
    /// How deep the including tag is in its own file.
    base_depth: usize,
    /// How many tags deep inside something that is skipped.
    skipping: usize,
    root: Option<Object>,
}

struct Parser {
    diagnostics: Diagnostics,
    defines: Defines,
    search_folders: Vec<PathBuf>,
    /// Files read so far.
    files: HashMap<PathBuf, SourceId>,
    /// The chain of includes that is being read, the main file first.
    open_files: Vec<PathBuf>,
    ids: HashMap<String, Span>,
    aliases: Vec<Alias>,
    elements: usize,
    bytes: u64,
    /// A bound of the whole document was hit; nothing more is read.
    exhausted: bool,
}

impl Parser {
    fn finish(mut self, path: &Path, root: Option<Object>) -> Document {
        let mut root = root.unwrap_or_else(|| Object::new(Category::Scene, ""));
        if root.category != Category::Scene {
            self.diagnostics.error(
                root.span,
                format!("a scene file starts with <scene>, not <{}>", root.category.tag()),
            );
            let mut scene = Object::new(Category::Scene, "");
            scene.children.push(Child::Object(root));
            root = scene;
        }
        link(&mut root, &self.ids, &self.aliases, &mut self.diagnostics);
        for (name, help) in self.defines.unused() {
            let message = format!("`-D {name}=...` has no effect: the scene does not use `${name}`");
            self.diagnostics.push(Severity::Warning, None, message, help);
        }
        Document {
            path: path.to_owned(),
            root,
            search_folders: self.search_folders,
            diagnostics: self.diagnostics,
        }
    }

    fn add_source(&mut self, path: PathBuf, text: &str) -> SourceId {
        let id = SourceId(u32::try_from(self.diagnostics.sources.len()).unwrap_or(u32::MAX));
        self.diagnostics.sources.push(SourceFile {
            path,
            text: text.into(),
        });
        id
    }

    /// The root object of one file.
    fn parse_source(&mut self, source: SourceId, base_depth: usize) -> Option<Object> {
        let text = self.diagnostics.source(source)?.text.clone();
        self.bytes += text.len() as u64;
        if self.bytes > MAX_TOTAL_BYTES {
            self.exhaust(None, "the includes of this scene add up to too much text");
            return None;
        }
        let mut reader = XmlReader::from_str(&text);
        let mut level = Level {
            source,
            text: text.clone(),
            stack: Vec::new(),
            base_depth,
            skipping: 0,
            root: None,
        };
        while !self.exhausted {
            let start = reader.buffer_position();
            let event = reader.read_event();
            let span = Span {
                source,
                start: u32::try_from(start).unwrap_or(u32::MAX),
                end: u32::try_from(reader.buffer_position()).unwrap_or(u32::MAX),
            };
            match event {
                Ok(Event::Start(tag)) => self.open(&tag, span, true, &mut level),
                Ok(Event::Empty(tag)) => self.open(&tag, span, false, &mut level),
                Ok(Event::End(_)) => self.close(&mut level),
                Ok(Event::Text(content)) if !content.trim().is_empty() => self.stray_text(span, &level),
                Ok(Event::CData(_) | Event::GeneralRef(_)) => self.stray_text(span, &level),
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
                    self.end_of_file(&level);
                    break;
                }
                Ok(Event::Text(_) | Event::Comment(_) | Event::Decl(_) | Event::PI(_)) => {}
                Err(error) => {
                    let at = u32::try_from(reader.error_position()).unwrap_or(u32::MAX);
                    let place = Span {
                        start: at,
                        end: span.end.max(at),
                        ..span
                    };
                    let open = level.stack.last().filter(|_| level.skipping == 0);
                    let help = open.map(|frame| {
                        let line = self.diagnostics.locate(frame.span()).map_or(0, |(_, line, _)| line);
                        format!("<{}> of line {line} is still open here", frame.tag())
                    });
                    let message = format!("broken XML: {error}");
                    self.diagnostics.push(Severity::Error, Some(place), message, help);
                    break;
                }
            }
        }
        level.skipping = 0;
        while !level.stack.is_empty() {
            self.close(&mut level);
        }
        level.root
    }

    fn stray_text(&mut self, span: Span, level: &Level) {
        if level.skipping == 0 {
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

    fn exhaust(&mut self, span: Option<Span>, message: &str) {
        self.exhausted = true;
        self.diagnostics.push(Severity::Error, span, message.to_owned(), None);
    }

    /// A start tag, or (`stays_open` false) one that closes itself.
    fn open(&mut self, start: &BytesStart, span: Span, stays_open: bool, level: &mut Level) {
        self.elements += 1;
        if self.elements > MAX_ELEMENTS {
            self.exhaust(Some(span), &format!("more than {MAX_ELEMENTS} tags"));
            return;
        }
        let opened = level.skipping == 0 && self.enter(start, span, level);
        if opened && !stays_open {
            self.close(level);
        } else if !opened && stays_open {
            level.skipping += 1;
        }
    }

    /// Pushes the tag's frame; false if the tag and all it contains are to be skipped.
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
            Some(Frame::Object { object, names }) => self.enter_in_object(&mut tag, object, names, depth),
        };
        let Some(frame) = frame else {
            return false;
        };
        tag.finish(&mut self.diagnostics);
        level.stack.push(frame);
        true
    }

    fn enter_root(&mut self, tag: &mut Tag, second: bool) -> Option<Frame> {
        if second {
            let message = format!("<{}> stands after the end of the scene", tag.name);
            self.diagnostics.error(tag.span, message);
            return None;
        }
        let Some(category) = Category::from_tag(&tag.name) else {
            let message = format!("a scene file starts with <scene>, not <{}>", tag.name);
            self.diagnostics.error(tag.span, message);
            return None;
        };
        match tag.take("version") {
            Some((version, span)) => self.check_version(&version, span),
            None => self
                .diagnostics
                .warn(tag.span, "no `version` is given; it is read as version 3.0.0"),
        }
        Some(self.object_frame(tag, category))
    }

    fn check_version(&mut self, version: &str, span: Span) {
        let parts: Result<Vec<u32>, _> = version.trim().split('.').map(str::parse).collect();
        match parts {
            Ok(parts) if parts.len() <= 3 => {
                if parts[0] > 3 {
                    let message = format!("version {version} is newer than this reader, which knows 3");
                    self.diagnostics.warn(span, message);
                }
            }
            _ => self.diagnostics.error(
                span,
                format!("expected a version like `3.0.0`, found {}", quote(version)),
            ),
        }
    }

    fn object_frame(&mut self, tag: &mut Tag, category: Category) -> Frame {
        let plugin = match category {
            Category::Scene => tag.take("type"),
            _ => tag.need("type", &mut self.diagnostics),
        };
        let mut object = Object::new(category, plugin.map_or_else(String::new, |(plugin, _)| plugin));
        object.span = tag.span;
        object.name = self.name_of(tag);
        object.id = tag.take("id").and_then(|(id, span)| self.register_id(id, span));
        Frame::Object {
            object,
            names: HashSet::new(),
        }
    }

    fn name_of(&mut self, tag: &mut Tag) -> Option<String> {
        let (name, _) = tag.take("name")?;
        Some(snake_case(&name)).filter(|name| !name.is_empty())
    }

    /// None if the id is no good.
    fn register_id(&mut self, id: String, span: Span) -> Option<String> {
        if id.is_empty() {
            self.diagnostics.warn(span, "an empty id is ignored");
            return None;
        }
        if let Some(first) = self.ids.get(&id) {
            let help = self
                .diagnostics
                .locate(*first)
                .map(|(path, line, column)| format!("the first one is at {}:{line}:{column}", path.display()));
            let message = format!("the id {} is given twice", quote(&id));
            self.diagnostics.push(Severity::Error, Some(span), message, help);
            return None;
        }
        self.ids.insert(id.clone(), span);
        Some(id)
    }

    fn enter_transform_op(&mut self, tag: &mut Tag, ops: &mut Vec<TransformOp>) -> Option<Frame> {
        if tag.name == "lookAt" {
            tag.name = "lookat".to_owned();
        }
        if !TRANSFORM_TAGS.contains(&tag.name.as_str()) {
            let message = format!("<{}> is not a step of a transform", tag.name);
            let help = did_you_mean(&tag.name, TRANSFORM_TAGS);
            self.diagnostics.push(Severity::Error, Some(tag.span), message, help);
            return None;
        }
        ops.extend(read_transform_op(tag, &mut self.diagnostics));
        Some(leaf(tag))
    }

    fn enter_in_object(
        &mut self,
        tag: &mut Tag,
        object: &mut Object,
        names: &mut HashSet<String>,
        depth: usize,
    ) -> Option<Frame> {
        match tag.name.as_str() {
            "scene" => {
                self.diagnostics
                    .error(tag.span, "<scene> cannot stand inside another tag");
                None
            }
            "spectrum" if tag.has("type") => Some(self.object_frame(tag, Category::Texture)),
            name if VALUE_TAGS.contains(&name) => {
                self.read_property(tag, object, names);
                Some(leaf(tag))
            }
            "transform" => Some(Frame::Transform {
                name: self.property_name(tag),
                ops: Vec::new(),
                span: tag.span,
            }),
            "ref" => {
                let id = tag.need("id", &mut self.diagnostics);
                let name = self.name_of(tag);
                if let Some((id, _)) = id {
                    object.children.push(Child::Reference {
                        name,
                        id,
                        span: tag.span,
                    });
                }
                Some(leaf(tag))
            }
            "default" => {
                let name = tag.need("name", &mut self.diagnostics);
                let given = tag.has("value");
                match (name, tag.take("value")) {
                    (Some((name, _)), Some((value, _))) => self.defines.add_default(&name, &value),
                    (_, None) if !given => self
                        .diagnostics
                        .error(tag.span, "<default> needs the attribute `value`"),
                    _ => {}
                }
                Some(leaf(tag))
            }
            "alias" => {
                let id = tag.need("id", &mut self.diagnostics);
                let other = tag.need("as", &mut self.diagnostics);
                if let (Some((id, _)), Some((other, _))) = (id, other) {
                    self.aliases.push(Alias {
                        name: other,
                        id,
                        span: tag.span,
                    });
                }
                Some(leaf(tag))
            }
            "path" => {
                if let Some((folder, span)) = tag.need("value", &mut self.diagnostics) {
                    self.add_search_folder(&folder, span);
                }
                Some(leaf(tag))
            }
            "include" => {
                let name = self.name_of(tag);
                if let Some((file, span)) = tag.need("filename", &mut self.diagnostics) {
                    self.include(&file, span, name, object, names, depth);
                }
                Some(leaf(tag))
            }
            name if TRANSFORM_TAGS.contains(&name) || name == "lookAt" => {
                let message = format!("<{name}> can only stand inside <transform>");
                self.diagnostics.error(tag.span, message);
                None
            }
            name => match Category::from_tag(name) {
                Some(category) => Some(self.object_frame(tag, category)),
                None => {
                    let structure = ["transform", "ref", "default", "include", "path", "alias"];
                    let categories = Category::ALL.map(Category::tag);
                    let known = VALUE_TAGS.into_iter().chain(structure).chain(categories);
                    let help = did_you_mean(name, known);
                    let message = format!("<{name}> is not known; it is ignored with all it contains");
                    self.diagnostics.push(Severity::Warning, Some(tag.span), message, help);
                    None
                }
            },
        }
    }

    fn property_name(&mut self, tag: &mut Tag) -> Option<String> {
        let (name, _) = tag.need("name", &mut self.diagnostics)?;
        Some(snake_case(&name))
    }

    fn read_property(&mut self, tag: &mut Tag, object: &mut Object, names: &mut HashSet<String>) {
        let name = self.property_name(tag);
        let value = if tag.name == "spectrum" {
            self.read_spectrum_tag(tag, object.category, name.as_deref().unwrap_or_default())
        } else {
            read_value(tag, &mut self.diagnostics)
        };
        if let (Some(name), Some(value)) = (name, value) {
            self.add_property(object, names, name, value, tag.span);
        }
    }

    fn read_spectrum_tag(&mut self, tag: &mut Tag, category: Category, name: &str) -> Option<Value> {
        let role = spectrum_role(category, name);
        if let Some((file, span)) = tag.take("filename") {
            let path = self.find_file(&file, span)?;
            let sampled = read_text(&path)
                .map_err(|error| error.to_string())
                .and_then(|text| SampledSpectrum::parse_file(&text).map_err(|what| format!("{file}: {what}")));
            return match sampled {
                Ok(sampled) => Some(sampled_color(&sampled, span, role, &mut self.diagnostics)),
                Err(message) => {
                    self.diagnostics.error(span, message);
                    None
                }
            };
        }
        let (text, span) = tag.need("value", &mut self.diagnostics)?;
        read_spectrum(&text, span, role, &mut self.diagnostics)
    }

    fn add_property(
        &mut self,
        object: &mut Object,
        names: &mut HashSet<String>,
        name: String,
        value: Value,
        span: Span,
    ) {
        if names.insert(name.clone()) {
            object.properties.push(Property { name, value, span });
        } else {
            let message = format!("{} is given twice in {}", quote(&name), object.title());
            self.diagnostics.error(span, message);
        }
    }

    /// An end tag, or the end of a broken file.
    fn close(&mut self, level: &mut Level) {
        if level.skipping > 0 {
            level.skipping -= 1;
            return;
        }
        match level.stack.pop() {
            Some(Frame::Object { mut object, .. }) => {
                modernize(&mut object);
                match level.stack.last_mut() {
                    Some(Frame::Object { object: parent, .. }) => parent.children.push(Child::Object(object)),
                    _ => level.root = Some(object),
                }
            }
            Some(Frame::Transform {
                name: Some(name),
                ops,
                span,
            }) => {
                if let Some(Frame::Object { object, names }) = level.stack.last_mut() {
                    self.add_property(object, names, name, Value::Transform(ops), span);
                }
            }
            Some(Frame::Transform { name: None, .. } | Frame::Leaf { .. }) | None => {}
        }
    }

    fn folder_of(&self, source: SourceId) -> PathBuf {
        let path = self.diagnostics.source(source).map(|source| source.path.as_path());
        path.and_then(Path::parent).unwrap_or(Path::new("")).to_owned()
    }

    fn add_search_folder(&mut self, folder: &str, span: Span) {
        let joined = self.folder_of(span.source).join(folder);
        if !joined.is_dir() {
            let message = format!("the folder {} does not exist", quote(folder));
            let help = format!("looked for {}", joined.display());
            self.diagnostics
                .push(Severity::Warning, Some(span), message, Some(help));
        }
        // Absolute, so that it means the same wherever the document is written to.
        let folder = std::path::absolute(&joined).unwrap_or(joined);
        if !self.search_folders.contains(&folder) {
            self.search_folders.push(folder);
        }
    }

    /// A file named at `span`; one that is not there has been reported.
    fn find_file(&mut self, name: &str, span: Span) -> Option<PathBuf> {
        let candidates = file_candidates(
            name,
            &[self.folder_of(span.source), self.folder_of(SourceId(0))],
            &self.search_folders,
        );
        let found = candidates.iter().find(|path| path.is_file()).cloned();
        if found.is_none() {
            let looked: Vec<_> = candidates
                .iter()
                .take(4)
                .map(|path| path.display().to_string())
                .collect();
            let message = format!("the file {} does not exist", quote(name));
            let help = format!("looked for {}", looked.join(", "));
            self.diagnostics.push(Severity::Error, Some(span), message, Some(help));
        }
        found
    }

    /// Puts the content of another scene file into `object`.
    fn include(
        &mut self,
        file: &str,
        span: Span,
        name: Option<String>,
        object: &mut Object,
        names: &mut HashSet<String>,
        depth: usize,
    ) {
        let Some(path) = self.find_file(file, span) else {
            return;
        };
        let key = canonical(&path);
        if self.open_files.contains(&key) {
            let message = format!("{} includes itself", quote(file));
            self.diagnostics.error(span, message);
            return;
        }
        if self.open_files.len() > MAX_INCLUDE_DEPTH {
            let message = format!("includes are nested more than {MAX_INCLUDE_DEPTH} deep");
            self.diagnostics.error(span, message);
            return;
        }
        let source = match self.files.get(&key) {
            Some(source) => *source,
            None => match read_text(&path) {
                Ok(text) => {
                    let source = self.add_source(path, &text);
                    self.files.insert(key.clone(), source);
                    source
                }
                Err(error) => {
                    self.diagnostics.error(span, error.to_string());
                    return;
                }
            },
        };
        self.open_files.push(key);
        let root = self.parse_source(source, depth);
        self.open_files.pop();
        match root {
            Some(root) if root.category == Category::Scene => {
                for Property { name, value, span } in root.properties {
                    self.add_property(object, names, name, value, span);
                }
                object.children.extend(root.children);
            }
            Some(mut root) => {
                root.name = name.or(root.name);
                object.children.push(Child::Object(root));
            }
            None => {}
        }
    }
}

impl Level {
    /// The place after the last character.
    fn end(&self) -> Span {
        let end = u32::try_from(self.text.trim_end().len()).unwrap_or(u32::MAX);
        Span {
            source: self.source,
            start: end,
            end,
        }
    }
}

fn leaf(tag: &Tag) -> Frame {
    Frame::Leaf {
        tag: tag.name.clone(),
        span: tag.span,
    }
}

fn canonical(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_owned())
}

/// Where a file of this name may be: in the given folders, then in the search folders, the last named first.
pub(super) fn file_candidates(name: &str, folders: &[PathBuf], search_folders: &[PathBuf]) -> Vec<PathBuf> {
    if Path::new(name).is_absolute() {
        return vec![PathBuf::from(name)];
    }
    let mut candidates: Vec<PathBuf> = Vec::new();
    for folder in folders.iter().chain(search_folders.iter().rev()) {
        let candidate = folder.join(name);
        if !candidates.contains(&candidate) {
            candidates.push(candidate);
        }
    }
    candidates
}
