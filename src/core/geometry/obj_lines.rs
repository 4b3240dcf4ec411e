//! Cuts OBJ text into numbered lines and words, and into chunks of whole statements.

use std::borrow::Cow;

/// The lines of a text with their 1-based numbers, without their ends (LF, CR LF or CR). A backslash at the end of a
/// statement joins the next line to it, under the number of the first; comments are not continued.
pub struct Lines<'a> {
    rest: &'a [u8],
    next_number: u32,
}

impl<'a> Lines<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self {
            rest: bytes,
            next_number: 1,
        }
    }

    /// The number of lines read from the text so far.
    pub fn taken(&self) -> u32 {
        self.next_number - 1
    }

    fn next_physical(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        self.next_number += 1;
        let (line, end) = self.rest.split_at(length_of_line(self.rest));
        self.rest = match end {
            [b'\r', b'\n', rest @ ..] | [_, rest @ ..] => rest,
            [] => end,
        };
        Some(line)
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (u32, Cow<'a, [u8]>);

    #[inline]
    fn next(&mut self) -> Option<Self::Item> {
        let number = self.next_number;
        let first = self.next_physical()?;
        let is_comment = || first.trim_ascii_start().starts_with(b"#");
        let Some(begun) = before_backslash(first).filter(|_| !is_comment()) else {
            return Some((number, first.into()));
        };
        let mut joined = begun.to_vec();
        while let Some(line) = self.next_physical() {
            joined.push(b' ');
            match before_backslash(line) {
                Some(middle) => joined.extend(middle),
                None => {
                    joined.extend(line);
                    break;
                }
            }
        }
        Some((number, joined.into()))
    }
}

/// The line without a backslash at its end; None if it has none.
#[inline]
fn before_backslash(line: &[u8]) -> Option<&[u8]> {
    line.trim_ascii_end().strip_suffix(b"\\")
}

/// The length up to the first LF or CR, or to the end. Looks at eight bytes at a time: in their difference from a byte
/// repeated eight times, the borrows of the subtraction show the lowest byte that is zero (Warren, "Hacker's delight",
/// 6-1).
#[inline]
fn length_of_line(bytes: &[u8]) -> usize {
    const ONES: u64 = u64::MAX / 255;
    let zeros = |word: u64| word.wrapping_sub(ONES) & !word & (ONES << 7);
    let (words, rest) = bytes.as_chunks::<8>();
    for (i, word) in words.iter().enumerate() {
        let word = u64::from_le_bytes(*word);
        let ends = zeros(word ^ (ONES * u64::from(b'\n'))) | zeros(word ^ (ONES * u64::from(b'\r')));
        if ends != 0 {
            return 8 * i + ends.trailing_zeros() as usize / 8;
        }
    }
    let ends = |byte: &u8| matches!(byte, b'\n' | b'\r');
    8 * words.len() + rest.iter().position(ends).unwrap_or(rest.len())
}

/// Cuts a text between statements, into chunks of `length` bytes or slightly more.
pub fn stretches(mut text: &[u8], length: usize) -> Vec<&[u8]> {
    let mut stretches = Vec::new();
    while text.len() > length {
        let mut lines = Lines::new(&text[length..]);
        // The text may be cut within a line: if it is blank from there on, a backslash may come before.
        let mut may_continue = lines
            .next_physical()
            .is_none_or(|line| line.trim_ascii_end().is_empty() || before_backslash(line).is_some());
        while may_continue && let Some(line) = lines.next_physical() {
            may_continue = before_backslash(line).is_some();
        }
        let (stretch, rest) = text.split_at(text.len() - lines.rest.len());
        stretches.push(stretch);
        text = rest;
    }
    if !text.is_empty() {
        stretches.push(text);
    }
    stretches
}

/// The words of a line up to a comment.
pub struct Words<'a> {
    rest: &'a [u8],
}

impl<'a> Words<'a> {
    /// Starts at the first word of `line`, which has no line end.
    pub fn new(line: &'a [u8]) -> Self {
        Self { rest: line }
    }

    /// The next word parsed by `read`, which returns the value and the number of bytes used. If it did not use the
    /// whole word, the result is `None`, and the word stays.
    #[inline]
    pub fn next_if<T>(&mut self, read: impl Fn(&[u8]) -> Option<(T, usize)>) -> Option<T> {
        self.skip_blanks();
        let (value, length) = read(self.rest)?;
        let rest = self.rest.get(length..)?;
        if rest.first().is_some_and(|byte| !byte.is_ascii_whitespace()) {
            return None;
        }
        self.rest = rest;
        Some(value)
    }

    #[inline]
    fn skip_blanks(&mut self) {
        while let [first, rest @ ..] = self.rest
            && first.is_ascii_whitespace()
        {
            self.rest = rest;
        }
    }
}

impl<'a> Iterator for Words<'a> {
    type Item = &'a [u8];

    #[inline]
    fn next(&mut self) -> Option<&'a [u8]> {
        self.skip_blanks();
        if matches!(self.rest, [] | [b'#', ..]) {
            self.rest = &[];
            return None;
        }
        let is_blank = |byte: &u8| byte.is_ascii_whitespace();
        let length = self.rest.iter().position(is_blank).unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(length);
        self.rest = rest;
        Some(word)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRICKY: &[u8] = b"v 1\r\nf 1 \\\r\n 2 \\\n3\rg\n\n# c:\\\n\r\r\nf 1 \\ \n\n\\\n\\\n  \nv 12345678\nvt 12 345678901234 \\\t\r\n 6\nlast\\";

    #[test]
    fn lines_end_in_any_way_and_continue() {
        let mut lines = Lines::new(TRICKY);
        let found: Vec<(u32, String)> = lines
            .by_ref()
            .map(|(number, line)| (number, String::from_utf8_lossy(&line).into_owned()))
            .collect();
        let expected = [
            (1, "v 1"),
            (2, "f 1   2  3"),
            (5, "g"),
            (6, ""),
            (7, "# c:\\"),
            (8, ""),
            (9, ""),
            (10, "f 1  "),
            (12, "    "),
            (15, "v 12345678"),
            (16, "vt 12 345678901234   6"),
            (18, "last"),
        ];
        assert_eq!(found, expected.map(|(number, line)| (number, line.to_owned())));
        assert_eq!(lines.taken(), 18);
    }

    #[test]
    fn stretches_are_the_text_cut_between_statements() {
        let whole: Vec<_> = Lines::new(TRICKY).collect();
        for length in 0..=TRICKY.len() {
            let cut = stretches(TRICKY, length);
            assert_eq!(cut.concat(), TRICKY);
            let mut lines = Vec::new();
            let mut before = 0;
            for stretch in cut {
                let mut of_stretch = Lines::new(stretch);
                lines.extend(of_stretch.by_ref().map(|(number, line)| (before + number, line)));
                before += of_stretch.taken();
            }
            assert_eq!(lines, whole, "{length}");
        }
        assert_eq!(stretches(b"a\nb\nc\n", 0).len(), 3);
    }

    #[test]
    fn words_stop_at_a_comment() {
        let found: Vec<&[u8]> = Words::new(b"\tf  1/2 #3 4").collect();
        assert_eq!(found, [&b"f"[..], b"1/2"]);
        assert_eq!(Words::new(b"  # f 1").count(), 0);
        let mut words = Words::new(b" ab abc #");
        let two = |text: &[u8]| text.starts_with(b"ab").then_some(((), 2));
        assert_eq!(words.next_if(two), Some(()));
        assert_eq!(words.next_if(two), None);
        assert_eq!(words.next(), Some(&b"abc"[..]));
        assert_eq!(words.next_if(two), None);
        assert_eq!(words.next(), None);
    }
}
