//! A batch of changes to a text: replaced ranges, and lines that are added or removed.

use std::ops::Range;

use super::elements::Element;

/// A range of the old text and its replacement.
#[derive(Clone, Debug, PartialEq)]
pub struct Edit {
    pub range: Range<usize>,
    pub text: String,
}

impl Edit {
    /// Replaces the bytes of `range` by `text`.
    pub fn replace(range: Range<usize>, text: impl Into<String>) -> Self {
        Self {
            range,
            text: text.into(),
        }
    }

    /// Inserts `text` before the byte `at`.
    pub fn insert(at: usize, text: impl Into<String>) -> Self {
        Self::replace(at..at, text)
    }

    /// Removes an element, with its lines if they hold nothing else.
    pub fn delete(text: &str, element: Range<usize>) -> Self {
        let line = line_start(text, element.start);
        let rest = &text[element.end..];
        let line_end = rest.find('\n').map_or(rest.len(), |newline| newline + 1);
        let is_alone = text[line..element.start].trim().is_empty() && rest[..line_end].trim().is_empty();
        // If no newline follows that could be removed, the line keeps its blanks.
        match is_alone && rest[..line_end].ends_with('\n') {
            true => Self::replace(line..element.end + line_end, ""),
            false => Self::replace(element, ""),
        }
    }
}

/// The part `within` of the text after the edits. They do not overlap; edits at the same position keep their order.
pub fn apply(text: &str, within: Range<usize>, mut edits: Vec<Edit>) -> String {
    edits.sort_by_key(|edit| (edit.range.start, edit.range.end));
    let mut result = String::with_capacity(within.len() + 256);
    let mut at = within.start;
    for edit in edits {
        // The deletions of two neighbours may extend to the same line end.
        let start = edit.range.start.max(at);
        result += &text[at..start];
        result += &edit.text;
        at = edit.range.end.max(at);
    }
    result += &text[at..within.end.max(at)];
    result
}

fn line_start(text: &str, at: usize) -> usize {
    text[..at].rfind('\n').map_or(0, |newline| newline + 1)
}

/// The layout of a text, which additions follow.
#[derive(Clone, Debug, PartialEq)]
pub struct Layout {
    /// The end of a line: `\n` or `\r\n`.
    pub newline: &'static str,
    /// One step of indentation.
    pub unit: String,
}

impl Default for Layout {
    fn default() -> Self {
        Self {
            newline: "\n",
            unit: "    ".to_owned(),
        }
    }
}

impl Layout {
    /// The layout of a text. `first` is the first element inside the outermost one.
    pub fn of(text: &str, root: &Element, first: Option<&Element>) -> Self {
        let newline = if text.contains("\r\n") { "\r\n" } else { "\n" };
        let outer = margin(text, root.tag.start).unwrap_or_default();
        let inner = first.and_then(|first| margin(text, first.tag.start));
        let unit = inner.and_then(|inner| inner.strip_prefix(outer));
        let unit = unit.filter(|unit| !unit.is_empty()).map(str::to_owned);
        Self {
            newline,
            unit: unit.unwrap_or(Self::default().unit),
        }
    }
}

/// The blanks before an element that begins its line; None if it does not.
pub fn margin(text: &str, start: usize) -> Option<&str> {
    let before = &text[line_start(text, start)..start];
    before.trim().is_empty().then_some(before)
}

/// The blanks at the beginning of the line that holds `at`.
pub fn margin_of_line(text: &str, at: usize) -> &str {
    let line = &text[line_start(text, at)..at];
    &line[..line.len() - line.trim_start().len()]
}

/// The position for a new element on a line of its own after another: behind the comment at the end of that line, if
/// there is one.
pub fn end_of_line(text: &str, element_end: usize) -> usize {
    let rest = &text[element_end..];
    let line = &rest[..rest.find('\n').unwrap_or(rest.len())];
    let line = line.strip_suffix('\r').unwrap_or(line);
    let remark = line.trim();
    let is_remark = remark.starts_with("<!--") && remark.find("-->") == Some(remark.len().saturating_sub(3));
    if is_remark {
        element_end + line.len()
    } else {
        element_end
    }
}

/// The lines of a block with another indentation and line end.
pub fn resettle(block: &str, from: &str, to: &str, newline: &str) -> String {
    let plain = block.replace("\r\n", "\n");
    move_margin(&plain, from, to).replace('\n', newline)
}

/// Replaces the indentation of the lines of a block. The first line has none.
fn move_margin(block: &str, from: &str, to: &str) -> String {
    let mut lines = block.split('\n');
    let mut result = lines.next().unwrap_or_default().to_owned();
    for line in lines {
        result.push('\n');
        match line.strip_prefix(from) {
            Some(rest) if !rest.trim().is_empty() => {
                result += to;
                result += rest;
            }
            _ => result += line,
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_deleted_element_takes_its_line_along_only_if_it_is_alone_there() {
        let delete = |text: &str, element: &str| {
            let start = text.find(element).unwrap();
            apply(
                text,
                0..text.len(),
                vec![Edit::delete(text, start..start + element.len())],
            )
        };
        assert_eq!(
            delete("<a>\r\n  <b/> \r\n  <c/>\r\n</a>", "<b/>"),
            "<a>\r\n  <c/>\r\n</a>"
        );
        assert_eq!(delete("<a>\n  <b/><c/>\n</a>", "<b/>"), "<a>\n  <c/>\n</a>");
        assert_eq!(delete("<a><b/></a>", "<b/>"), "<a></a>");
        assert_eq!(
            delete("<a>\n  <b/> <!-- b -->\n</a>", "<b/>"),
            "<a>\n   <!-- b -->\n</a>"
        );
        assert_eq!(delete("<b/>", "<b/>"), "");
    }

    #[test]
    fn blocks_move_as_a_whole() {
        assert_eq!(
            move_margin("<a>\n\t  <b/>\n\n\t</a>", "\t", "    "),
            "<a>\n      <b/>\n\n    </a>"
        );
    }

    #[test]
    fn what_follows_a_line_comes_after_its_remark() {
        let text = "  <a/> <!-- first -->\r\n  <b/>";
        assert_eq!(&text[end_of_line(text, 6)..], "\r\n  <b/>");
        assert_eq!(end_of_line("<a/><!-- 1 --><b/>", 4), 4);
        assert_eq!(end_of_line("<a/><!-- 1\n -->", 4), 4);
    }
}
