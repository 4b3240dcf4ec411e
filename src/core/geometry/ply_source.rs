//! The numbers of a PLY body, in text or in binary of either byte order.

use super::mesh_file::{MeshError, Place, excerpt};
use super::ply_header::Scalar;

/// A sequential source of the body's numbers. An `f64` holds every number type of PLY exactly, except integers beyond
/// 2⁵³, which no index or position needs.
pub(super) trait Source {
    fn number(&mut self, scalar: Scalar) -> Result<f64, MeshError>;
    fn skip(&mut self, count: u64, scalar: Scalar) -> Result<(), MeshError>;
    /// The place of the number that was read last.
    fn place(&self) -> Place;
    /// The place of the next number.
    fn next_place(&self) -> Place;
    /// The bytes that have not been read yet.
    fn rest(&self) -> &[u8];
    /// The unread bytes, with the byte order of their numbers. `None` for a text.
    fn binary(&self) -> Option<BinaryNumbers<'_>>;

    fn bytes_left(&self) -> u64 {
        self.rest().len() as u64
    }
}

#[derive(Clone, Copy)]
pub(super) struct BinaryNumbers<'a> {
    pub bytes: &'a [u8],
    pub big_endian: bool,
}

impl BinaryNumbers<'_> {
    /// Converts a number of four bytes.
    #[inline(always)]
    pub fn word(&self, bytes: [u8; 4]) -> u32 {
        let word = u32::from_le_bytes(bytes);
        if self.big_endian { word.swap_bytes() } else { word }
    }
}

pub(super) struct Binary<'a, const BIG_ENDIAN: bool> {
    rest: &'a [u8],
    /// The offset in the file at which `rest` ends.
    end: u64,
    last: u64,
}

impl<'a, const BIG_ENDIAN: bool> Binary<'a, BIG_ENDIAN> {
    pub(super) fn new(body: &'a [u8], offset: usize) -> Self {
        Self {
            rest: body,
            end: (offset + body.len()) as u64,
            last: offset as u64,
        }
    }

    #[cold]
    fn ended(&self) -> MeshError {
        MeshError::Truncated {
            place: Place::Byte(self.end),
            promised: "the header promises more".into(),
        }
    }
}

impl<const BIG_ENDIAN: bool> Source for Binary<'_, BIG_ENDIAN> {
    #[inline]
    fn number(&mut self, scalar: Scalar) -> Result<f64, MeshError> {
        self.last = self.end - self.rest.len() as u64;
        let Some((number, rest)) = self.rest.split_at_checked(scalar.size()) else {
            return Err(self.ended());
        };
        self.rest = rest;
        Ok(scalar.number(number, BIG_ENDIAN))
    }

    fn skip(&mut self, count: u64, scalar: Scalar) -> Result<(), MeshError> {
        let bytes = count.saturating_mul(scalar.size() as u64);
        self.rest = usize::try_from(bytes)
            .ok()
            .and_then(|bytes| self.rest.get(bytes..))
            .ok_or_else(|| self.ended())?;
        Ok(())
    }

    fn place(&self) -> Place {
        Place::Byte(self.last)
    }

    fn next_place(&self) -> Place {
        Place::Byte(self.end - self.rest.len() as u64)
    }

    fn rest(&self) -> &[u8] {
        self.rest
    }

    fn binary(&self) -> Option<BinaryNumbers<'_>> {
        Some(BinaryNumbers {
            bytes: self.rest,
            big_endian: BIG_ENDIAN,
        })
    }
}

pub(super) struct Ascii<'a> {
    rest: &'a [u8],
    line: u64,
}

impl<'a> Ascii<'a> {
    pub(super) fn new(body: &'a [u8], line: u64) -> Self {
        Self { rest: body, line }
    }

    fn word(&mut self) -> Result<&'a [u8], MeshError> {
        while let [first, rest @ ..] = self.rest
            && first.is_ascii_whitespace()
        {
            let ends_line = *first == b'\n' || (*first == b'\r' && rest.first() != Some(&b'\n'));
            self.line += u64::from(ends_line);
            self.rest = rest;
        }
        let length = self
            .rest
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(self.rest.len());
        let (word, rest) = self.rest.split_at(length);
        if word.is_empty() {
            return Err(MeshError::Truncated {
                place: Place::Line(self.line),
                promised: "the header promises more".into(),
            });
        }
        self.rest = rest;
        Ok(word)
    }
}

impl Source for Ascii<'_> {
    fn number(&mut self, scalar: Scalar) -> Result<f64, MeshError> {
        let word = self.word()?;
        // Most numbers are short integers, above all in faces.
        if word.len() <= 9 && word.iter().all(u8::is_ascii_digit) {
            return Ok(word
                .iter()
                .fold(0u32, |number, digit| 10 * number + u32::from(digit - b'0'))
                .into());
        }
        let parsed = std::str::from_utf8(word).ok().and_then(|text| match scalar {
            // The text is rounded once, to the same float as in a binary file.
            Scalar::F32 => text.parse::<f32>().ok().map(f64::from),
            _ => text.parse().ok(),
        });
        parsed.ok_or_else(|| MeshError::syntax(self.place(), "a number", excerpt(word)))
    }

    fn skip(&mut self, count: u64, _: Scalar) -> Result<(), MeshError> {
        for _ in 0..count {
            self.word()?;
        }
        Ok(())
    }

    fn place(&self) -> Place {
        Place::Line(self.line)
    }

    fn next_place(&self) -> Place {
        self.place()
    }

    fn rest(&self) -> &[u8] {
        self.rest
    }

    fn binary(&self) -> Option<BinaryNumbers<'_>> {
        None
    }
}
