//! Numbers as bytes, least significant first, for the exact state of a picture ([`crate::render::part`]).

use std::io::{self, Write};
use std::time::Duration;

use flate2::Crc;

/// Bytes to which numbers are written.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Writer(pub Vec<u8>);

impl Writer {
    /// Writes a whole number.
    pub fn u32(&mut self, number: u32) {
        self.0.extend_from_slice(&number.to_le_bytes());
    }

    /// Writes a long whole number.
    pub fn u64(&mut self, number: u64) {
        self.0.extend_from_slice(&number.to_le_bytes());
    }

    /// Writes a very long whole number.
    pub fn i128(&mut self, number: i128) {
        self.0.extend_from_slice(&number.to_le_bytes());
    }

    /// Writes the bits of a number.
    pub fn f32(&mut self, number: f32) {
        self.u32(number.to_bits());
    }

    /// Writes the bits of a number in double precision.
    pub fn f64(&mut self, number: f64) {
        self.u64(number.to_bits());
    }
}

/// A file that is being written, with the checksum (flate2's CRC) and the length so far.
pub struct SummedFile<'a> {
    /// The file. Direct writes are not included in the checksum.
    pub file: &'a mut dyn Write,
    /// The checksum.
    pub crc: Crc,
    /// The number of bytes.
    pub length: u64,
}

impl<'a> SummedFile<'a> {
    /// A file with an empty checksum.
    pub fn new(file: &'a mut dyn Write) -> Self {
        Self {
            file,
            crc: Crc::new(),
            length: 0,
        }
    }

    /// Writes bytes and adds them to the checksum.
    pub fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.crc.update(bytes);
        self.length += bytes.len() as u64;
        self.file.write_all(bytes)
    }
}

/// The largest valid count.
const MOST_COUNTED: u64 = 1 << 60;
/// The longest valid duration in seconds.
const LONGEST: f64 = 1e9;

/// The error for bytes that end too early or have invalid values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the state of the picture in it is damaged")]
pub struct Damaged;

/// Bytes from which numbers are read.
#[derive(Clone, Copy, Debug)]
pub struct Reader<'a>(pub &'a [u8]);

impl<'a> Reader<'a> {
    /// The next bytes.
    pub fn bytes(&mut self, count: usize) -> Result<&'a [u8], Damaged> {
        let (bytes, rest) = self.0.split_at_checked(count).ok_or(Damaged)?;
        self.0 = rest;
        Ok(bytes)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], Damaged> {
        let (&bytes, rest) = self.0.split_first_chunk().ok_or(Damaged)?;
        self.0 = rest;
        Ok(bytes)
    }

    /// The next whole number.
    pub fn u32(&mut self) -> Result<u32, Damaged> {
        self.array().map(u32::from_le_bytes)
    }

    /// The next long whole number.
    pub fn u64(&mut self) -> Result<u64, Damaged> {
        self.array().map(u64::from_le_bytes)
    }

    /// The next very long whole number.
    pub fn i128(&mut self) -> Result<i128, Damaged> {
        self.array().map(i128::from_le_bytes)
    }

    /// The next number.
    pub fn f32(&mut self) -> Result<f32, Damaged> {
        self.u32().map(f32::from_bits)
    }

    /// The next number in double precision.
    pub fn f64(&mut self) -> Result<f64, Damaged> {
        self.u64().map(f64::from_bits)
    }

    /// The next long whole number, a count: far from the largest number, so that more can be added.
    pub fn count(&mut self) -> Result<u64, Damaged> {
        self.u64()
            .and_then(|count| if count <= MOST_COUNTED { Ok(count) } else { Err(Damaged) })
    }

    /// The next number in double precision, a duration in seconds: at most thirty years, so that more can be added.
    pub fn duration(&mut self) -> Result<Duration, Damaged> {
        let seconds = self.f64()?;
        match (0.0..=LONGEST).contains(&seconds) {
            true => Ok(Duration::from_secs_f64(seconds)),
            false => Err(Damaged),
        }
    }

    /// The next number, which must be 0 or 1.
    pub fn flag(&mut self) -> Result<bool, Damaged> {
        match self.u32()? {
            0 => Ok(false),
            1 => Ok(true),
            _ => Err(Damaged),
        }
    }

    /// The next number, which must be finite.
    pub fn finite(&mut self) -> Result<f32, Damaged> {
        self.f32()
            .and_then(|number| if number.is_finite() { Ok(number) } else { Err(Damaged) })
    }

    /// Fills `places` with finite numbers.
    pub fn finites(&mut self, places: &mut [f32]) -> Result<(), Damaged> {
        places
            .iter_mut()
            .try_for_each(|place| self.finite().map(|number| *place = number))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_and_times_leave_room_for_more() {
        for (count, is_possible) in [(0, true), (1 << 60, true), (u64::MAX, false)] {
            let mut bytes = Writer::default();
            bytes.u64(count);
            assert_eq!(Reader(&bytes.0).count().is_ok(), is_possible, "{count}");
        }
        for (seconds, is_possible) in [
            (0.0, true),
            (1e9, true),
            (1.8e19, false),
            (-1.0, false),
            (f64::NAN, false),
            (f64::INFINITY, false),
        ] {
            let mut bytes = Writer::default();
            bytes.f64(seconds);
            let read = Reader(&bytes.0).duration();
            assert_eq!(read.is_ok(), is_possible, "{seconds}");
            assert!(read.is_err() || read == Ok(Duration::from_secs_f64(seconds)));
        }
    }
}
