//! Cuts OBJ text into numbered lines and words.

use std::borrow::Cow;

/// The lines of a file with their 1-based numbers, without their ends (LF, CR LF or CR). A backslash at the end of a statement joins the
/// next line to it, under the number of the first; comments are not continued.
pub struct Lines<'a> {
    rest: &'a [u8],
    next_number: u32,
}

impl<'a> Lines<'a> {
    pub fn new(bytes: &'a [u8]) -> Self {
        Self {
            rest: bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes),
            next_number: 1,
        }
    }

    fn next_physical(&mut self) -> Option<&'a [u8]> {
        if self.rest.is_empty() {
            return None;
        }
        self.next_number += 1;
        let is_end = |byte: &u8| *byte == b'\n' || *byte == b'\r';
        let Some(length) = self.rest.iter().position(is_end) else {
            return Some(std::mem::take(&mut self.rest));
        };
        let (line, end) = self.rest.split_at(length);
        self.rest = end.strip_prefix(b"\r\n").unwrap_or(&end[1..]);
        Some(line)
    }
}

impl<'a> Iterator for Lines<'a> {
    type Item = (u32, Cow<'a, [u8]>);

    fn next(&mut self) -> Option<Self::Item> {
        let number = self.next_number;
        let first = self.next_physical()?;
        let is_comment = || first.trim_ascii_start().starts_with(b"#");
        let Some(begun) = first.trim_ascii_end().strip_suffix(b"\\").filter(|_| !is_comment()) else {
            return Some((number, first.into()));
        };
        let mut joined = begun.to_vec();
        while let Some(line) = self.next_physical() {
            joined.push(b' ');
            match line.trim_ascii_end().strip_suffix(b"\\") {
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

/// The words of a line up to a comment.
pub fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
        .take_while(|word| word[0] != b'#')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_in_any_way_and_continue() {
        let text = b"\xef\xbb\xbfv 1\r\nf 1 \\\r\n 2 \\\n3\rg\n\n# c:\\\nlast\\";
        let lines: Vec<(u32, String)> = Lines::new(text)
            .map(|(number, line)| (number, String::from_utf8_lossy(&line).into_owned()))
            .collect();
        let expected = [
            (1, "v 1"),
            (2, "f 1   2  3"),
            (5, "g"),
            (6, ""),
            (7, "# c:\\"),
            (8, "last"),
        ];
        assert_eq!(lines, expected.map(|(number, line)| (number, line.to_owned())));
    }

    #[test]
    fn words_stop_at_a_comment() {
        let found: Vec<&[u8]> = words(b"\tf  1/2 #3 4").collect();
        assert_eq!(found, [&b"f"[..], b"1/2"]);
        assert_eq!(words(b"  # f 1").count(), 0);
    }
}
