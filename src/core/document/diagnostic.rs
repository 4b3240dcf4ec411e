//! Messages about a scene file, each with its place. The file `report` prints them.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::suggest::did_you_mean;

/// The most messages that are stored; further ones are only counted. A broken generator must not fill the memory with
/// messages.
pub(crate) const MAX_STORED: usize = 1000;
/// The most messages that get suggestions and the places of related objects. The search for them takes time in
/// proportion to the file.
const MAX_HELPED: usize = 100;

/// The file of a document (the main one or an include); an index into [`Diagnostics::sources`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct SourceId(pub u32);

/// A byte range of one source file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Span {
    /// The file of the range.
    pub source: SourceId,
    /// The first byte, counted from 0 after a byte order mark.
    pub start: u32,
    /// The end of the range, exclusive.
    pub end: u32,
}

/// A source file with its text, kept so that messages can quote lines.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceFile {
    /// The path that the file was opened by. It is shown in messages, and relative names in the file start from its
    /// folder.
    pub path: PathBuf,
    /// The text without a byte order mark. It is not copied from the memory that it was read into, since scenes may
    /// have 200 MB.
    pub text: Arc<String>,
    /// Whether the file begins with a byte order mark.
    pub byte_order_mark: bool,
}

impl SourceFile {
    /// Returns the text as it is in the file, with the byte order mark.
    pub fn with_mark(&self) -> String {
        let mark = if self.byte_order_mark { "\u{feff}" } else { "" };
        format!("{mark}{}", self.text)
    }
}

/// The severity of a message. Levels are ordered by their declaration, the mildest first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// A choice that the reader made, and that the user may want to know.
    Note,
    /// A part of the file has no effect, or another effect than its author may expect.
    Warning,
    /// A part of the file cannot be read. A stand-in or a default replaces it, and strict commands fail.
    Error,
}

/// One message about the scene; `span` is None when it is about a file as a whole.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Diagnostic {
    /// The severity, which decides the label of the message and the count it belongs to.
    pub severity: Severity,
    /// One sentence without a full stop.
    pub message: String,
    /// Advice for the user, if there is any ("did you mean `alpha`?").
    pub help: Option<String>,
    /// The range of text that is underlined.
    pub span: Option<Span>,
}

/// All messages about one document, in the order they were found, with the sources they point into.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Diagnostics {
    /// The main file and its includes. A [`SourceId`] is an index into this list.
    pub sources: Vec<SourceFile>,
    /// The messages in the order in which they came up, at most a thousand; further ones are only counted.
    pub list: Vec<Diagnostic>,
    /// All messages so far: one is kept once for each place, because a file may be included many times.
    said: HashSet<Diagnostic>,
    /// The number of errors after the list was full.
    dropped_errors: usize,
    dropped_warnings: usize,
}

impl Diagnostics {
    /// Adds a warning at a span, without a hint.
    pub fn warn(&mut self, span: Span, message: impl Into<String>) {
        self.push(Severity::Warning, Some(span), message.into(), None);
    }

    /// Adds an error at a span, without a hint.
    pub fn error(&mut self, span: Span, message: impl Into<String>) {
        self.push(Severity::Error, Some(span), message.into(), None);
    }

    /// Adds a message unless the same one exists for the same span. If the list is full, an error replaces a milder
    /// message and everything else is only counted.
    pub fn push(&mut self, severity: Severity, span: Option<Span>, message: String, help: Option<String>) {
        let diagnostic = Diagnostic {
            severity,
            message,
            help,
            span,
        };
        if self.said.contains(&diagnostic) {
            return;
        }
        if self.is_full() {
            match severity {
                Severity::Note => return,
                Severity::Warning => {
                    self.dropped_warnings += 1;
                    return;
                }
                // An error replaces the last milder message, unless errors alone fill the list.
                Severity::Error => {
                    let lesser = match self.dropped_errors {
                        0 => self.list.iter().rposition(|listed| listed.severity != Severity::Error),
                        _ => None,
                    };
                    let Some(lesser) = lesser else {
                        self.dropped_errors += 1;
                        return;
                    };
                    if self.list.remove(lesser).severity == Severity::Warning {
                        self.dropped_warnings += 1;
                    }
                }
            }
        }
        self.said.insert(diagnostic.clone());
        self.list.push(diagnostic);
    }

    /// Whether further messages will only be counted, so that they need no suggestions.
    pub fn is_full(&self) -> bool {
        self.list.len() >= MAX_STORED
    }

    /// Counts warnings that no longer fit in the list.
    pub(crate) fn count_warnings(&mut self, count: usize) {
        self.dropped_warnings += count;
    }

    /// Whether there are so many messages that the next one gets no hint that is slow to find.
    pub(crate) fn has_many(&self) -> bool {
        self.list.len() >= MAX_HELPED
    }

    /// The hint "did you mean ...?" for a name that is none of the candidates; None if there are already too many
    /// messages.
    pub fn did_you_mean<'c>(&self, name: &str, candidates: impl IntoIterator<Item = &'c str>) -> Option<String> {
        match self.has_many() {
            true => None,
            false => did_you_mean(name, candidates),
        }
    }

    /// Whether there is any error, listed or only counted.
    pub fn has_errors(&self) -> bool {
        self.error_count() > 0
    }

    /// Counts all errors, also those beyond the end of the list.
    pub fn error_count(&self) -> usize {
        let listed = self.list.iter().filter(|d| d.severity == Severity::Error).count();
        listed + self.dropped_errors
    }

    /// Counts all warnings, also those beyond the end of the list.
    pub fn warning_count(&self) -> usize {
        let listed = self.list.iter().filter(|d| d.severity == Severity::Warning).count();
        listed + self.dropped_warnings
    }

    /// The file with this id; None for the id of another document.
    pub fn source(&self, id: SourceId) -> Option<&SourceFile> {
        self.sources.get(id.0 as usize)
    }

    /// Shortens the texts to the lines that messages show and that locating `places` needs: the lines up to the last of
    /// these.
    pub fn shorten_texts(&mut self, places: impl Iterator<Item = Span>) {
        let mut needed = vec![None; self.sources.len()];
        let of_messages = self.list.iter().filter_map(|message| message.span);
        for span in of_messages.chain(places) {
            if let Some(end) = needed.get_mut(span.source.0 as usize) {
                *end = (*end).max(Some(span.end as usize));
            }
        }
        for (source, end) in self.sources.iter_mut().zip(needed) {
            let text = Arc::make_mut(&mut source.text);
            let end = end.map_or(0, |end| {
                let rest = text.floor_char_boundary(end);
                text[rest..].find('\n').map_or(text.len(), |newline| rest + newline)
            });
            text.truncate(end);
            text.shrink_to_fit();
        }
    }

    /// The file, line and column of a span's start; both count from 1, columns in characters.
    pub fn locate(&self, span: Span) -> Option<(&Path, usize, usize)> {
        let source = self.source(span.source)?;
        let (line, column) = source.line_column(span.start as usize);
        Some((&source.path, line, column))
    }
}

impl SourceFile {
    /// The line and column of a byte offset, from 1, columns in characters. Offsets past the end mean the end.
    pub(crate) fn line_column(&self, offset: usize) -> (usize, usize) {
        let before = &self.text[..self.text.floor_char_boundary(offset)];
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let line = before.bytes().filter(|byte| *byte == b'\n').count() + 1;
        (line, before[line_start..].chars().count() + 1)
    }
}
