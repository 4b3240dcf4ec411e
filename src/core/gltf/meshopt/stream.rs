//! The parts that all codecs have in common: reading bytes and numbers, and the reasons why that fails.

/// The reason why a stream cannot be decoded.
pub type Fault = &'static str;

pub const SHORT: Fault = "its compressed stream is too short";
pub const LONG: Fault = "its compressed stream is longer than its data";
pub const HEADER: Fault = "its compressed stream begins with an unknown version";

/// The unread part of a stream.
pub struct Reader<'a>(pub &'a [u8]);

impl<'a> Reader<'a> {
    pub fn take(&mut self, count: usize) -> Result<&'a [u8], Fault> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or(SHORT)?;
        self.0 = rest;
        Ok(taken)
    }

    pub fn byte(&mut self) -> Result<u8, Fault> {
        Ok(self.take(1)?[0])
    }

    /// A number of one to five bytes, of which each holds seven bits (LEB128).
    pub fn number(&mut self) -> Result<u32, Fault> {
        let mut number = 0;
        for shift in (0..35).step_by(7) {
            let byte = u32::from(self.byte()?);
            number |= (byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(number);
            }
        }
        Err("a number of its compressed stream is too long")
    }

    /// An error unless all is read.
    pub fn finish(self) -> Result<(), Fault> {
        match self.0.is_empty() {
            true => Ok(()),
            false => Err(LONG),
        }
    }
}

/// The signed difference for which an unsigned number stands: 0, -1, 1, -2, 2 and so on.
pub fn difference(number: u32) -> u32 {
    (number >> 1) ^ 0u32.wrapping_sub(number & 1)
}
