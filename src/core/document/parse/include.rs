//! Handles the other files that a scene names: includes, and the folders in which files are searched.

use std::path::{Path, PathBuf};

use smol_str::SmolStr;

use super::parser::Names;
use super::parser::{MAX_INCLUDE_DEPTH, MAX_INCLUDES, MAX_SEARCH_FOLDERS, Parser};
use crate::document::paths::{canonical, file_candidates};
use crate::document::source::read_text_within;
use crate::document::value::quote;
use crate::document::{Category, Include, Object, Severity, SourceId, Span};
use crate::files::FileError;

/// The reason why a file is not included.
enum NotIncluded {
    /// It is being included already.
    Circle,
    /// It could not be read, so that its declarations are unknown.
    Unread,
}

impl Parser {
    fn folder_of(&self, source: SourceId) -> PathBuf {
        let path = self.diagnostics.source(source).map(|source| source.path.as_path());
        path.and_then(Path::parent).unwrap_or(Path::new("")).to_owned()
    }

    pub(super) fn add_search_folder(&mut self, folder: &str, span: Span) {
        if self.search_folders.len() >= MAX_SEARCH_FOLDERS {
            let message = format!("more than {MAX_SEARCH_FOLDERS} search folders");
            self.diagnostics.error(span, message);
            return;
        }
        let joined = self.folder_of(span.source).join(folder);
        if !self.access.permits(&joined) {
            let message = format!("the folder {} {}", quote(folder), FileError::Outside);
            self.diagnostics.error(span, message);
            return;
        }
        if !joined.is_dir() {
            let message = format!("the folder {} does not exist", quote(folder));
            let help = format!("looked for {}", joined.display());
            self.diagnostics
                .push(Severity::Warning, Some(span), message, Some(help));
        }
        // The path is absolute, so that it stays valid wherever the document is written.
        let folder = std::path::absolute(&joined).unwrap_or(joined);
        if !self.search_folders.contains(&folder) {
            self.search_folders.push(folder);
        }
    }

    /// The path of a file named at `span`; a missing file is reported.
    pub(super) fn find_file(&mut self, name: &str, span: Span) -> Option<PathBuf> {
        let all = file_candidates(
            name,
            &[self.folder_of(span.source), self.folder_of(SourceId(0))],
            &self.search_folders,
        );
        let likely = all.iter().filter(|path| self.names.may_have(path, &self.access));
        let likely: Vec<PathBuf> = likely.cloned().collect();
        let found = self.access.find(&likely).cloned();
        if found.is_none() {
            let permitted = all.iter().filter(|path| self.access.covers(path));
            let looked: Vec<_> = permitted.take(4).map(|path| path.display().to_string()).collect();
            let (what, help) = match looked[..] {
                [] => (FileError::Outside.to_string(), None),
                _ => (
                    "does not exist".to_owned(),
                    Some(format!("looked for {}", looked.join(", "))),
                ),
            };
            let message = format!("the file {} {what}", quote(name));
            self.diagnostics.push(Severity::Error, Some(span), message, help);
        }
        found
    }

    /// Includes the content of another scene file in `object`.
    pub(super) fn include(
        &mut self,
        file: &str,
        span: Span,
        name: Option<SmolStr>,
        object: &mut Object,
        names: &mut Names,
        depth: usize,
    ) {
        if self.is_part {
            return;
        }
        let source = match self.included(file, span) {
            Ok(source) => source,
            Err(NotIncluded::Circle) => return,
            Err(NotIncluded::Unread) => {
                self.not_read = self.not_read.or(Some(span));
                return;
            }
        };
        let root = self.parse_source(source, depth);
        self.open_files.pop();
        match root {
            Some(root) if root.category == Category::Scene => {
                for property in root.properties {
                    self.add_property(object, names, property);
                }
                object.children.extend(root.children);
            }
            Some(mut root) => {
                root.name = name.or(root.name);
                object.children.push(root.into());
            }
            None => self.not_read = self.not_read.or(Some(span)),
        }
    }

    /// Opens the file included at `span` and makes it the last of the open files. Errors are reported.
    fn included(&mut self, file: &str, span: Span) -> Result<SourceId, NotIncluded> {
        let path = self.find_file(file, span).ok_or(NotIncluded::Unread)?;
        let key = canonical(&path);
        if let Some(first) = self.open_files.iter().position(|(open, _)| *open == key) {
            // The chain of includes from that file to this include. Finding its places takes time in proportion to the
            // files.
            let chain = match self.diagnostics.has_many() {
                true => &[][..],
                false => &self.open_files[first + 1..],
            };
            let chain = chain.iter().filter_map(|(file, span)| {
                let (path, line, column) = self.diagnostics.locate((*span)?)?;
                Some(format!(
                    "{} is included at {}:{line}:{column}",
                    file.display(),
                    path.display()
                ))
            });
            let chain: Vec<String> = chain.collect();
            let help = (!chain.is_empty()).then(|| chain.join(", "));
            let message = format!("{} includes itself", quote(file));
            self.diagnostics.push(Severity::Error, Some(span), message, help);
            return Err(NotIncluded::Circle);
        }
        if self.open_files.len() > MAX_INCLUDE_DEPTH {
            let message = format!("includes are nested more than {MAX_INCLUDE_DEPTH} deep");
            self.diagnostics.error(span, message);
            return Err(NotIncluded::Unread);
        }
        if self.includes.len() >= MAX_INCLUDES {
            self.exhaust(Some(span), &format!("more than {MAX_INCLUDES} includes"));
            return Err(NotIncluded::Unread);
        }
        let source = match self.files.get(&key) {
            Some(source) => *source,
            None => match read_text_within(&path, &self.access) {
                Ok(text) if !is_markup(&text) => {
                    let message = format!("the file {} is not XML: it does not begin with a tag", quote(file));
                    self.diagnostics.error(span, message);
                    return Err(NotIncluded::Unread);
                }
                Ok(text) => {
                    let source = self.add_source(path, text);
                    self.files.insert(key.clone(), source);
                    source
                }
                Err(error) => {
                    self.diagnostics.error(span, error.to_string());
                    return Err(NotIncluded::Unread);
                }
            },
        };
        self.includes.push(Include { span, source });
        self.open_files.push((key, Some(span)));
        Ok(source)
    }
}

/// Whether a text begins with a tag, or is empty. The parser would quote any other text.
fn is_markup(text: &str) -> bool {
    let text = text.trim_start_matches('\u{feff}').trim_start();
    text.is_empty() || text.starts_with('<')
}
