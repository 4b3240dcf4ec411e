//! Parses XML text into a [`Document`]: files, includes, defaults, and the nesting of tags.
//!
//! After a bad value the parser goes on, so that one run reports all errors; after malformed XML the rest of that file
//! is skipped. Everything parsed by then is in the document, next to the errors.

mod animation;
mod element;
mod include;
mod parser;
mod spare;

use std::path::Path;
use std::sync::Arc;

use self::parser::Parser;
pub(super) use self::parser::parse_children;
use super::define::Defines;
use super::dialect;
use super::links::link;
use super::parsed::SCENE_UNITS;
use super::paths::canonical;
use super::source::{MAX_FILE_BYTES, SourceError, read_text};
use super::unpack::{keep_known, pack_rest};
use super::{Category, Document, Object, Severity};
use crate::files::Access;

/// Reads a scene file; `defines` are the command line's `name=value` pairs. It fails only if the file cannot be read as
/// text: errors in the text are in the document's diagnostics.
pub fn load(path: &Path, defines: &[(String, String)]) -> Result<Document, SourceError> {
    let text = read_text(path)?;
    Ok(parse_str(text, path, defines))
}

/// Parses a scene whose text is in memory, without copying it; relative paths in it start from the folder of `path`.
/// Every file may be read.
pub fn parse_str(text: impl Into<String>, path: &Path, defines: &[(String, String)]) -> Document {
    parse_within(text, path, defines, Access::everywhere())
}

/// Reads a scene as [`parse_str`] does, but only those of its files that `access` permits.
pub fn parse_within(text: impl Into<String>, path: &Path, defines: &[(String, String)], access: Access) -> Document {
    let mut parser = Parser {
        access,
        defines: Defines::new(defines),
        ..Parser::default()
    };
    let text = text.into();
    let length = text.len() as u64;
    let source = parser.add_source(path.to_owned(), text);
    let root = if length > MAX_FILE_BYTES {
        let message = format!("longer than {} MiB, which no scene should be", MAX_FILE_BYTES >> 20);
        parser.diagnostics.push(Severity::Error, None, message, None);
        None
    } else {
        if let Some(file) = parser.diagnostics.source(source)
            && dialect::is_dialect(&file.text)
        {
            return dialect::import(file.clone(), defines, parser.access);
        }
        parser.open_files.push((canonical(path), None));
        parser.parse_source(source, 0)
    };
    parser.finish(path, root)
}

impl Parser {
    fn finish(mut self, path: &Path, root: Option<Object>) -> Document {
        let mut root = root.unwrap_or_else(|| Object::new(Category::Scene, ""));
        if root.category != Category::Scene {
            self.diagnostics.error(
                root.span,
                format!("a scene file starts with <scene>, not <{}>", root.category.name()),
            );
            let mut scene = Object::new(Category::Scene, "");
            scene.children.push(root.into());
            root = scene;
        }
        let crowds = keep_known(&mut root, self.crowds, &self.diagnostics);
        link(
            &mut root,
            &self.ids,
            &self.aliases,
            self.not_read,
            &mut self.diagnostics,
        );
        let crowds = pack_rest(&mut root, crowds);
        let unused = self.defines.unused().into_iter();
        for (name, help) in unused.filter(|_| self.not_read.is_none()) {
            let message = format!("`-D {name}=...` has no effect: the scene does not use `${name}`");
            self.diagnostics.push(Severity::Warning, None, message, help);
        }
        let is_taken =
            |(name, values): &(&str, &[&str])| self.defines.has_other_use(name, |value| values.contains(&value));
        let taken = SCENE_UNITS.into_iter().filter(is_taken);
        let taken_unit_names = taken.map(|(name, _)| name).collect();
        Document {
            path: path.to_owned(),
            root: Arc::new(root),
            crowds,
            time: 0.0,
            search_folders: self.search_folders,
            includes: self.includes,
            taken_unit_names,
            imported: false,
            stand_in_light: None,
            access: self.access,
            diagnostics: self.diagnostics,
        }
    }
}
