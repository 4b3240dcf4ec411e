//! The buffers of a file while compressed parts are unpacked into further ones.

use super::schema::BufferView;
use crate::memory::Reservation;

/// The number of copies of a buffer: itself, a mesh made of it, and the file of that mesh.
pub(super) const COPIES: u64 = 3;

/// More bytes that compressed parts may have in sum than the buffers, and the factor on the bytes of the buffers. Parts
/// of sound files do not overlap. If they could, a small file would be unpacked again and again.
const MORE_BYTES: u64 = 1 << 20;
const FACTOR: u64 = 2;

/// The buffers of a file with the memory that is reserved for them.
pub(super) struct Store {
    pub buffers: Vec<Vec<u8>>,
    /// The reserved bytes.
    pub needed: u64,
    pub memory: Reservation,
    /// The compressed bytes that may still be read.
    left: u64,
}

impl Store {
    pub fn new(buffers: Vec<Vec<u8>>, needed: u64, memory: Reservation) -> Self {
        let bytes: u64 = buffers.iter().map(|buffer| buffer.len() as u64).sum();
        Self {
            buffers,
            needed,
            memory,
            left: FACTOR * bytes + MORE_BYTES,
        }
    }

    /// Reserves memory for this many more bytes of a buffer, and of what is made of it.
    pub fn reserve(&mut self, bytes: u64) -> Result<(), String> {
        let needed = self.needed.saturating_add(COPIES.saturating_mul(bytes));
        self.memory
            .resize(needed)
            .map_err(|shortage| format!("needs {shortage}"))?;
        self.needed = needed;
        Ok(())
    }

    /// The compressed bytes at a place of a buffer.
    pub fn read(&mut self, buffer: usize, offset: usize, length: usize) -> Result<&[u8], String> {
        let end = offset.checked_add(length);
        let bytes = self
            .buffers
            .get(buffer)
            .zip(end)
            .and_then(|(bytes, end)| bytes.get(offset..end));
        let bytes = bytes.ok_or("has compressed bytes beyond its buffer")?;
        self.left = self
            .left
            .checked_sub(length as u64)
            .ok_or("shares its compressed bytes with too many others")?;
        Ok(bytes)
    }

    /// Adds a buffer, and returns a view of all of it.
    pub fn add(&mut self, bytes: Vec<u8>) -> BufferView {
        let byte_length = bytes.len();
        self.buffers.push(bytes);
        let buffer = self.buffers.len() - 1;
        BufferView {
            buffer,
            byte_length,
            ..BufferView::default()
        }
    }
}
