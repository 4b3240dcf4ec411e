//! Words and lines of text files, with their places for messages.

use thiserror::Error;

/// The reason why a file of luminous intensities is refused.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[error("line {line}: {message}")]
pub struct ProfileError {
    /// The line of the fault, from 1.
    pub line: usize,
    /// What was expected.
    pub message: String,
}

impl ProfileError {
    pub(super) fn new(line: usize, message: impl Into<String>) -> Self {
        Self {
            line,
            message: message.into(),
        }
    }
}

/// The lines of a text, and the words within them.
pub(super) struct Cursor<'a> {
    lines: Vec<&'a str>,
    /// The index of the current line.
    line: usize,
    /// The rest of the current line.
    rest: &'a str,
}

impl<'a> Cursor<'a> {
    pub fn new(text: &'a str) -> Self {
        let lines: Vec<&str> = text.split('\n').map(|line| line.trim_end_matches('\r')).collect();
        let rest = lines.first().copied().unwrap_or_default();
        Self { lines, line: 0, rest }
    }

    /// The number of the current line, from 1.
    pub fn line(&self) -> usize {
        self.line + 1
    }

    pub fn error(&self, message: impl Into<String>) -> ProfileError {
        ProfileError::new(self.line().min(self.lines.len()), message)
    }

    /// Returns the rest of the current line and goes to the next one; None at the end.
    pub fn next_line(&mut self) -> Option<&'a str> {
        if self.line >= self.lines.len() {
            return None;
        }
        let rest = self.rest;
        self.line += 1;
        self.rest = self.lines.get(self.line).copied().unwrap_or_default();
        Some(rest)
    }

    /// The next number, on this line or a later one; blanks and commas separate numbers. `what` names it in errors.
    pub fn number(&mut self, what: &str) -> Result<f64, ProfileError> {
        let is_between = |c: char| c.is_whitespace() || c == ',';
        loop {
            let rest = self.rest.trim_start_matches(is_between);
            if !rest.is_empty() {
                let end = rest.find(is_between).unwrap_or(rest.len());
                let word = &rest[..end];
                let number =
                    parse(word).ok_or_else(|| self.error(format!("expected {what}, found `{}`", short(word))))?;
                self.rest = &rest[end..];
                return Ok(number);
            }
            if self.next_line().is_none() {
                return Err(self.error(format!("the file ends where {what} is expected")));
            }
        }
    }

    /// The next count, at least `least` and at most `most`.
    pub fn count(&mut self, what: &str, least: usize, most: usize) -> Result<usize, ProfileError> {
        let number = self.number(what)?;
        match number.fract() == 0.0 && (least as f64..=most as f64).contains(&number) {
            true => Ok(number as usize),
            false => Err(self.error(format!("expected {what} from {least} to {most}, found {number}"))),
        }
    }

    /// The next `count` numbers. Memory is taken as they are found, not as they are promised.
    pub fn numbers(&mut self, count: usize, what: &str) -> Result<Vec<f64>, ProfileError> {
        (0..count).map(|_| self.number(what)).collect()
    }

    /// The next line as a number; a decimal comma counts as a point.
    pub fn number_of_line(&mut self, what: &str) -> Result<f64, ProfileError> {
        let line = self.next_line().map(str::trim);
        let Some(line) = line.filter(|line| !line.is_empty() || self.line < self.lines.len()) else {
            return Err(self.error(format!("the file ends where {what} is expected")));
        };
        number_of(line).ok_or_else(|| {
            let found = format!("expected {what}, found `{}`", short(line));
            ProfileError::new(self.line, found)
        })
    }

    /// The next line as a number, 0 if it is blank.
    pub fn number_or_blank(&mut self, what: &str) -> Result<f64, ProfileError> {
        match self.rest.trim().is_empty() && self.line + 1 < self.lines.len() {
            true => {
                self.next_line();
                Ok(0.0)
            }
            false => self.number_of_line(what),
        }
    }
}

/// The number on a line, which may have a decimal comma.
pub(super) fn number_of(line: &str) -> Option<f64> {
    parse(&line.trim().replace(',', "."))
}

/// A finite number.
fn parse(word: &str) -> Option<f64> {
    word.parse().ok().filter(|number: &f64| number.is_finite())
}

/// The first characters of a word that is shown in a message.
fn short(word: &str) -> String {
    word.chars().take(20).collect()
}
