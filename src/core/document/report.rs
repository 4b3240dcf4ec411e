//! Formats diagnostics: one line each, or a report with the line of the file and a caret.

use std::fmt::{self, Display};
use std::path::Path;

use miette::{
    GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteError, MietteSpanContents, SourceCode, SourceSpan,
    SpanContents, ThemeCharacters, ThemeStyles,
};

use super::{Diagnostic, Diagnostics, Severity, SourceFile, SourceId};
use crate::files::Access;

/// The most messages that are shown; the others are only counted.
const MAX_SHOWN: usize = 50;

/// The most bytes of a very long line that are shown before and after the place.
const EXCERPT: usize = 120;

/// Errors come first: warnings must not push them out of sight.
fn in_order(list: &[Diagnostic]) -> impl Iterator<Item = &Diagnostic> {
    let of = |severity| list.iter().filter(move |d| d.severity == severity);
    [Severity::Error, Severity::Warning, Severity::Note]
        .into_iter()
        .flat_map(of)
        .take(MAX_SHOWN)
}

impl Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Note => "note",
            Self::Warning => "warning",
            Self::Error => "error",
        })
    }
}

/// One line per message.
impl Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for diagnostic in in_order(&self.list) {
            writeln!(f, "{}", self.line(diagnostic))?;
        }
        if let Some(rest) = self.rest() {
            writeln!(f, "{rest}")?;
        }
        Ok(())
    }
}

impl Diagnostics {
    /// The message in one line: `file:line:column: warning: message (help)`.
    pub fn line(&self, diagnostic: &Diagnostic) -> String {
        let mut line = match diagnostic.span.and_then(|span| self.locate(span)) {
            Some((path, line, column)) => format!("{}:{line}:{column}: ", path.display()),
            None => self.main_path().map_or_else(String::new, |path| format!("{path}: ")),
        };
        line += &format!("{}: {}", diagnostic.severity, one_line(&diagnostic.message));
        if let Some(help) = &diagnostic.help {
            line += &format!(" ({})", one_line(help));
        }
        line
    }

    /// The messages with the lines that they are about, for people, followed by the number of messages left out.
    /// Messages are not wrapped, so that names of files stay whole.
    pub fn render(&self, color: bool) -> String {
        let theme = GraphicalTheme {
            characters: ThemeCharacters::unicode(),
            styles: if color {
                ThemeStyles::ansi()
            } else {
                ThemeStyles::none()
            },
        };
        let handler = GraphicalReportHandler::new_themed(theme)
            .with_wrap_lines(false)
            .with_links(false)
            .with_context_lines(0);
        let mut text = String::new();
        for diagnostic in in_order(&self.list) {
            let report = Report::new(self, diagnostic);
            if handler.render_report(&mut text, &report).is_err() {
                text += &self.line(diagnostic);
            }
            text += "\n";
        }
        if let Some(rest) = self.rest() {
            text += &rest;
            text += "\n";
        }
        text
    }

    /// The line of the file that a message is about, after its number, with marks under the span; None for a message
    /// without a span or in a foreign file.
    pub fn excerpt(&self, diagnostic: &Diagnostic) -> Option<String> {
        let span = diagnostic.span?;
        let source = self.source(span.source).filter(|_| !self.is_foreign(span.source))?;
        let excerpt = Excerpt::new(source, span.start as usize, span.end as usize);
        let (line, _) = source.line_column(excerpt.mark.offset());
        let text = excerpt.text.replace('\t', " ");
        let (before, rest) = text.split_at(excerpt.mark.offset() - excerpt.start);
        let margin = before.trim_start();
        let marks = rest[..excerpt.mark.len()].trim_end().chars().count().max(1);
        let number = format!("{line} | ");
        let indent = number.chars().count() + margin.chars().count();
        Some(format!(
            "{number}{margin}{rest}\n{}{}",
            " ".repeat(indent),
            "^".repeat(marks)
        ))
    }

    /// The summary, such as "2 errors, 1 warning"; empty if there are no messages.
    pub fn summary(&self) -> String {
        let count = |number: usize, what: &str| match number {
            0 => None,
            1 => Some(format!("1 {what}")),
            _ => Some(format!("{number} {what}s")),
        };
        let parts = [
            count(self.error_count(), "error"),
            count(self.warning_count(), "warning"),
        ];
        parts.into_iter().flatten().collect::<Vec<_>>().join(", ")
    }

    fn rest(&self) -> Option<String> {
        let total = self.error_count() + self.warning_count();
        (total > MAX_SHOWN).then(|| format!("... and {} more ({} in all)", total - MAX_SHOWN, self.summary()))
    }

    fn is_foreign(&self, id: SourceId) -> bool {
        let source = self.source(id).filter(|_| id != SourceId(0));
        source.is_some_and(|source| self.is_outside(&source.path))
    }

    /// Whether a file is outside the folder of the main file. A scene may name any file, so text of such a file is
    /// never shown.
    pub(in crate::document) fn is_outside(&self, path: &Path) -> bool {
        let folder = self.sources.first().and_then(|main| main.path.parent());
        !Access::within(folder.map(Path::to_owned)).covers(path)
    }

    fn main_path(&self) -> Option<String> {
        self.sources.first().map(|source| source.path.display().to_string())
    }
}

/// Removes control characters: messages quote the file, and must not break the line or reach the terminal.
fn one_line(message: &str) -> String {
    message.chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}

/// A diagnostic in the shape miette prints.
#[derive(Debug)]
struct Report<'a> {
    diagnostic: &'a Diagnostic,
    message: String,
    place: Option<Excerpt<'a>>,
}

/// The line of the file that a message is about, or the part of it around the span.
#[derive(Debug)]
struct Excerpt<'a> {
    source: &'a SourceFile,
    start: usize,
    text: String,
    mark: SourceSpan,
}

impl<'a> Report<'a> {
    fn new(all: &'a Diagnostics, diagnostic: &'a Diagnostic) -> Self {
        let place = diagnostic.span.and_then(|span| {
            let source = all.source(span.source).filter(|_| !all.is_foreign(span.source))?;
            Some(Excerpt::new(source, span.start as usize, span.end as usize))
        });
        let mut message = one_line(&diagnostic.message);
        if place.is_none() {
            let at = diagnostic.span.and_then(|span| all.locate(span));
            let at = at.map(|(path, line, column)| format!("{}:{line}:{column}", path.display()));
            if let Some(at) = at.or_else(|| all.main_path()) {
                message = format!("{at}: {message}");
            }
        }
        Self {
            diagnostic,
            message,
            place,
        }
    }
}

impl<'a> Excerpt<'a> {
    fn new(source: &'a SourceFile, start: usize, end: usize) -> Self {
        let text = &source.text;
        let start = text.floor_char_boundary(start);
        let line_start = text[..start].rfind('\n').map_or(0, |newline| newline + 1);
        let line_end = text[start..]
            .find(['\n', '\r'])
            .map_or(text.len(), |length| start + length);
        let from = text.floor_char_boundary(line_start.max(start.saturating_sub(EXCERPT)));
        let to = text.floor_char_boundary(line_end.min(start + 2 * EXCERPT)).max(start);
        let end = text.floor_char_boundary(end).clamp(start, to);
        // The length in bytes stays the same, so that the mark keeps its column. The printer handles tabs.
        let shown = text[from..to]
            .chars()
            .map(|c| if c.is_ascii_control() && c != '\t' { ' ' } else { c })
            .collect();
        Self {
            source,
            start: from,
            text: shown,
            mark: SourceSpan::from((start, end - start)),
        }
    }
}

impl SourceCode for Excerpt<'_> {
    fn read_span<'b>(
        &'b self,
        span: &SourceSpan,
        _before: usize,
        _after: usize,
    ) -> Result<Box<dyn SpanContents<'b> + 'b>, MietteError> {
        let (line, column) = self.source.line_column(span.offset());
        let all = SourceSpan::from((self.start, self.text.len()));
        let name = self.source.path.display().to_string();
        Ok(Box::new(MietteSpanContents::new_named(
            name,
            self.text.as_bytes(),
            all,
            line - 1,
            column - 1,
            1,
        )))
    }
}

impl Display for Report<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Report<'_> {}

impl miette::Diagnostic for Report<'_> {
    fn severity(&self) -> Option<miette::Severity> {
        Some(match self.diagnostic.severity {
            Severity::Note => miette::Severity::Advice,
            Severity::Warning => miette::Severity::Warning,
            Severity::Error => miette::Severity::Error,
        })
    }

    fn help<'b>(&'b self) -> Option<Box<dyn Display + 'b>> {
        let help = one_line(self.diagnostic.help.as_deref()?);
        Some(Box::new(help))
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.place.as_ref().map(|place| place as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let mark = self.place.as_ref()?.mark;
        Some(Box::new(std::iter::once(LabeledSpan::new_primary_with_span(
            None, mark,
        ))))
    }
}
