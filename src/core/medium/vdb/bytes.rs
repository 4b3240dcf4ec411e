//! Reads the numbers and texts of a .vdb file one after the other, little-endian.

use super::VdbError;

/// A position in a file.
#[derive(Clone)]
pub(super) struct Bytes<'a> {
    all: &'a [u8],
    at: usize,
}

impl<'a> Bytes<'a> {
    pub(super) fn new(all: &'a [u8]) -> Self {
        Self { all, at: 0 }
    }

    /// The current position, in bytes from the start of the file.
    pub(super) fn at(&self) -> u64 {
        self.at as u64
    }

    /// Moves to a position in the file.
    pub(super) fn seek(&mut self, at: u64) -> Result<(), VdbError> {
        let within = usize::try_from(at).ok().filter(|at| *at <= self.all.len());
        self.at = within.ok_or(self.truncated())?;
        Ok(())
    }

    /// The next `count` bytes.
    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8], VdbError> {
        let (taken, _) = self.all[self.at..].split_at_checked(count).ok_or(self.truncated())?;
        self.at += count;
        Ok(taken)
    }

    fn truncated(&self) -> VdbError {
        VdbError::Truncated(self.all.len() as u64)
    }

    /// An error at the current position.
    pub(super) fn damaged(&self, expected: &'static str) -> VdbError {
        let at = self.at();
        VdbError::Damaged { at, expected }
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], VdbError> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    pub(super) fn u8(&mut self) -> Result<u8, VdbError> {
        self.array().map(u8::from_le_bytes)
    }

    pub(super) fn u32(&mut self) -> Result<u32, VdbError> {
        self.array().map(u32::from_le_bytes)
    }

    pub(super) fn i32(&mut self) -> Result<i32, VdbError> {
        self.array().map(i32::from_le_bytes)
    }

    pub(super) fn u64(&mut self) -> Result<u64, VdbError> {
        self.array().map(u64::from_le_bytes)
    }

    pub(super) fn i64(&mut self) -> Result<i64, VdbError> {
        self.array().map(i64::from_le_bytes)
    }

    pub(super) fn f64(&mut self) -> Result<f64, VdbError> {
        self.array().map(f64::from_le_bytes)
    }

    /// The bytes after their own length.
    pub(super) fn sized(&mut self) -> Result<&'a [u8], VdbError> {
        let length = self.u32()?;
        self.take(length as usize)
    }

    pub(super) fn string(&mut self) -> Result<String, VdbError> {
        Ok(String::from_utf8_lossy(self.sized()?).into_owned())
    }
}
