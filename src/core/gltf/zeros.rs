//! Zeros: elements of accessors without a buffer view, all zero except for sparse values. They take no bytes in the
//! file, so that only a limit bounds their number.

use super::schema::Root;

/// The most zeros of one accessor, and of all meshes and animations together.
pub const MOST_ZEROS: usize = 1 << 26;

/// Bytes of memory for such an element, in the mesh and in its file.
const ZERO_BYTES: u64 = 64;

/// The number of zeros in the meshes, morph targets and animations of a file, except for accessors that exceed the
/// limit by themselves.
pub fn count_zeros(root: &Root) -> usize {
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let attributes = primitives.flat_map(|primitive| {
        let targets = primitive.targets.iter().flat_map(|target| target.values());
        primitive.attributes.values().chain(targets)
    });
    let samplers = root.animations.iter().flat_map(|animation| &animation.samplers);
    let curves = samplers.flat_map(|sampler| [&sampler.input, &sampler.output]);
    let zeros = attributes
        .chain(curves)
        .filter_map(|&index| root.accessors.get(index))
        .filter(|accessor| accessor.buffer_view.is_none() && accessor.count <= MOST_ZEROS);
    zeros.fold(0, |sum, accessor| sum.saturating_add(accessor.count))
}

/// The bytes of memory for this number of zeros. The result is zero if there are too many, because then no mesh is made
/// of them.
pub fn zero_bytes(zeros: usize) -> u64 {
    match zeros <= MOST_ZEROS {
        true => ZERO_BYTES * zeros as u64,
        false => 0,
    }
}
