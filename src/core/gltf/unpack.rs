//! Compressed parts of a file: buffer views (EXT_meshopt_compression, KHR_meshopt_compression) and primitives
//! (KHR_draco_mesh_compression). They are unpacked once, into buffers of their own, so that everything else reads them
//! like parts that were never compressed.

use super::schema::{BufferView, CompressedView, Root};
use super::store::Store;
use super::{GltfError, draco, meshopt};

impl BufferView {
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

    /// Unpacks all compressed parts. A part that cannot be unpacked keeps the
    /// reason, which a later reading of the part returns.
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
