//! Numbers as bytes, for the exact state of a picture ([`crate::render::part`]): as memory has them, which is with the
//! least significant byte first on all processors that Sunroom is built for.

use std::time::Duration;

use bytemuck::{AnyBitPattern, NoUninit, Pod};

// Files would not be read by other machines otherwise.
const _: () = assert!(cfg!(target_endian = "little"), "files have the byte order of memory");

/// Bytes to which numbers are written.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Writer(pub Vec<u8>);

impl Writer {
    /// Writes a number, or several that have a type together.
    pub fn put<T: NoUninit>(&mut self, value: T) {
        self.put_all(&[value]);
    }

    /// Writes all values of a list, without their number.
    pub fn put_all(&mut self, values: &[impl NoUninit]) {
        self.0.extend_from_slice(bytemuck::cast_slice(values));
    }
}

/// The most that can have been counted.
const MOST_COUNTED: u64 = 1 << 60;
/// The longest valid duration in seconds.
const LONGEST: f64 = 1e9;

/// The error for bytes that end too early or have invalid values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the state of the picture in it is damaged")]
pub struct Damaged;

impl Damaged {
    /// The error, unless what was read can be.
    pub fn unless(is_possible: bool) -> Result<(), Self> {
        is_possible.then_some(()).ok_or(Self)
    }
}

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

    /// The next number, or several that have a type together.
    pub fn take<T: AnyBitPattern>(&mut self) -> Result<T, Damaged> {
        Ok(bytemuck::pod_read_unaligned(self.bytes(size_of::<T>())?))
    }

    /// Reads a value for each place of a list.
    pub fn fill(&mut self, places: &mut [impl Pod]) -> Result<(), Damaged> {
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(places);
        bytes.copy_from_slice(self.bytes(bytes.len())?);
        Ok(())
    }

    /// The next long whole number, a count: far from the largest number, so that more can be added.
    pub fn count(&mut self) -> Result<u64, Damaged> {
        let count = self.take()?;
        Damaged::unless(count <= MOST_COUNTED)?;
        Ok(count)
    }

    /// The next number in double precision, a duration in seconds: at most thirty years, so that more can be added.
    pub fn duration(&mut self) -> Result<Duration, Damaged> {
        let seconds = self.take()?;
        Damaged::unless((0.0..=LONGEST).contains(&seconds))?;
        Ok(Duration::from_secs_f64(seconds))
    }

    /// The next number, which must be 0 or 1.
    pub fn flag(&mut self) -> Result<bool, Damaged> {
        let number: u32 = self.take()?;
        Damaged::unless(number <= 1)?;
        Ok(number == 1)
    }

    /// The next number, which must be finite.
    pub fn finite(&mut self) -> Result<f32, Damaged> {
        let number: f32 = self.take()?;
        Damaged::unless(number.is_finite())?;
        Ok(number)
    }

    /// Fills `places` with finite numbers.
    pub fn finites(&mut self, places: &mut [f32]) -> Result<(), Damaged> {
        self.fill(places)?;
        Damaged::unless(places.iter().all(|number| number.is_finite()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_and_times_leave_room_for_more() {
        for (count, is_possible) in [(0, true), (1 << 60, true), (u64::MAX, false)] {
            let mut bytes = Writer::default();
            bytes.put(count);
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
            bytes.put(seconds);
            let read = Reader(&bytes.0).duration();
            assert_eq!(read.is_ok(), is_possible, "{seconds}");
            assert!(read.is_err() || read == Ok(Duration::from_secs_f64(seconds)));
        }
    }
}
