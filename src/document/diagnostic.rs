//! What is wrong with a scene file, and where.

use std::path::PathBuf;
use std::sync::Arc;

/// Which file of a document (the main one and its includes); an index into [`Diagnostics::sources`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct SourceId(pub u32);

/// A byte range of one source file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Span {
    pub source: SourceId,
    pub start: u32,
    pub end: u32,
}

/// A file's text, kept so that messages can show the line they speak of.
#[derive(Clone, Debug, PartialEq)]
pub struct SourceFile {
    pub path: PathBuf,
    pub text: Arc<str>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Severity {
    Warning,
    Error,
}

/// One message about the scene; `span` is None when it is about a file as a whole.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    pub severity: Severity,
    pub message: String,
    /// What to do about it, where there is something to say ("did you mean `alpha`?").
    pub help: Option<String>,
    pub span: Option<Span>,
}

/// All messages about one document, in the order they were found, with the sources they point into.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Diagnostics {
    pub sources: Vec<SourceFile>,
    pub list: Vec<Diagnostic>,
}

impl Diagnostics {
    pub fn warn(&mut self, span: Span, message: impl Into<String>) {
        self.push(Severity::Warning, Some(span), message.into(), None);
    }

    pub fn error(&mut self, span: Span, message: impl Into<String>) {
        self.push(Severity::Error, Some(span), message.into(), None);
    }

    pub fn push(&mut self, severity: Severity, span: Option<Span>, message: String, help: Option<String>) {
        self.list.push(Diagnostic {
            severity,
            message,
            help,
            span,
        });
    }

    pub fn has_errors(&self) -> bool {
        self.list.iter().any(|d| d.severity == Severity::Error)
    }
}
