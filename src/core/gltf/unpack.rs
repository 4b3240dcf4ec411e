//! Compressed parts of a file: buffer views (EXT_meshopt_compression, KHR_meshopt_compression) and primitives
//! (KHR_draco_mesh_compression). They are unpacked once, into buffers of their own, so that everything else reads them like
//! parts that were never compressed.

use super::schema::{BufferView, CompressedView, Root};
use super::{COPIES, GltfError, draco, meshopt};
use crate::memory::Reservation;

/// More bytes that compressed parts may have in sum than the buffers, and the factor on the bytes of the buffers. Parts of
/// sound files do not overlap. If they could, a small file would be unpacked again and again.
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
        self.buffers.push(bytes);
        BufferView::of_buffer(self.buffers.len() - 1, &self.buffers[self.buffers.len() - 1])
    }
}

impl BufferView {
    fn of_buffer(buffer: usize, bytes: &[u8]) -> Self {
        Self {
            buffer,
            byte_length: bytes.len(),
            ..Self::default()
        }
    }

    fn compressed(&self) -> Option<&CompressedView> {
        let extensions = &self.extensions;
        extensions.meshopt.as_ref().or(extensions.later_meshopt.as_ref())
    }
}

impl Root {
    /// The buffers that hold no bytes because all of their views are compressed, and have their bytes elsewhere.
    pub(super) fn placeholders(&self) -> Vec<bool> {
        let mut compressed = vec![false; self.buffers.len()];
        let mut used = vec![false; self.buffers.len()];
        for view in &self.buffer_views {
            let (list, source) = match view.compressed() {
                Some(source) => (&mut compressed, Some(source.buffer)),
                None => (&mut used, None),
            };
            if let Some(mark) = list.get_mut(view.buffer) {
                *mark = true;
            }
            if let Some(mark) = source.and_then(|source| used.get_mut(source)) {
                *mark = true;
            }
        }
        compressed
            .iter()
            .zip(used)
            .map(|(compressed, used)| *compressed && !used)
            .collect()
    }

    /// Unpacks all compressed parts. What cannot be unpacked keeps the reason, which whoever reads it gets.
    pub(super) fn unpack(&mut self, store: &mut Store) {
        for view in &mut self.buffer_views {
            let Some(source) = view.compressed() else {
                continue;
            };
            match unpacked(source, view.byte_length, store) {
                Ok(bytes) => {
                    let BufferView { buffer, .. } = store.add(bytes);
                    (view.buffer, view.byte_offset) = (buffer, 0);
                }
                Err(fault) => view.fault = Some(fault),
            }
        }
        draco::unpack(self, store);
    }
}

fn unpacked(source: &CompressedView, length: usize, store: &mut Store) -> Result<Vec<u8>, String> {
    if source.count.checked_mul(source.byte_stride) != Some(length) {
        let CompressedView { count, byte_stride, .. } = source;
        return Err(format!(
            "has {length} bytes, but {count} compressed elements of {byte_stride} bytes"
        ));
    }
    store.reserve(length as u64)?;
    let stream = store.read(source.buffer, source.byte_offset, source.byte_length)?;
    meshopt::decode(stream, source).map_err(|fault| format!("cannot be unpacked: {fault}"))
}

impl super::Gltf {
    /// An error if a buffer view could not be unpacked.
    pub(super) fn check_unpacked(&self, index: usize, view: &BufferView) -> Result<(), GltfError> {
        match view.fault.clone() {
            Some(what) => Err(GltfError::Unpack { index, what }),
            None => Ok(()),
        }
    }
}
