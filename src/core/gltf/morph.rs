//! Morph targets: by how much the vertices of a mesh at rest are away from where its attributes have them.

use std::collections::HashMap;

use glam::Vec3;

use super::allowances::MOST_MOVES;
use super::mesh::into_vectors;
use super::schema::{Primitive, Root};
use super::{Gltf, GltfError};

/// The attributes that targets move.
const MOVED: [&str; 2] = ["POSITION", "NORMAL"];

/// The targets of a primitive that move something, with their weights.
fn weighted<'a>(
    primitive: &'a Primitive,
    weights: &'a [f32],
) -> impl Iterator<Item = (&'a HashMap<String, usize>, f32)> {
    let targets = primitive.targets.iter().zip(weights.iter().copied());
    targets.filter(|(_, weight)| *weight != 0.0 && weight.is_finite())
}

impl Root {
    /// The number of vectors in the targets that move something.
    pub(super) fn moves(&self) -> usize {
        let targets = self.meshes.iter().flat_map(|mesh| {
            let primitives = mesh.primitives.iter();
            primitives.flat_map(|primitive| weighted(primitive, &mesh.weights))
        });
        let accessors = targets.flat_map(|(target, _)| MOVED.iter().filter_map(|name| target.get(*name)));
        let counts = accessors.filter_map(|&index| Some(self.accessors.get(index)?.count));
        counts.fold(0, usize::saturating_add)
    }
}

impl Gltf {
    /// Whether a primitive has targets that are left out, because those of the file are too many.
    pub(super) fn leaves_targets_out(&self, primitive: &Primitive, weights: &[f32]) -> bool {
        self.moves > MOST_MOVES && weighted(primitive, weights).next().is_some()
    }

    /// Moves values of vertices by the targets at rest, of a mesh with so many vertices of which some are used.
    pub(super) fn morph(
        &self,
        name: &str,
        primitive: &Primitive,
        weights: &[f32],
        (vertices, used): (usize, Option<&[u32]>),
        values: &mut [Vec3],
    ) -> Result<(), GltfError> {
        if values.is_empty() || self.moves > MOST_MOVES {
            return Ok(());
        }
        for (target, weight) in weighted(primitive, weights) {
            let Some(&accessor) = target.get(name) else {
                continue;
            };
            if self.accessor(accessor)?.count == vertices {
                let moved: Vec<Vec3> = into_vectors(self.vectors::<3>(accessor, "VEC3", used)?);
                for (value, by) in values.iter_mut().zip(moved) {
                    *value += weight * by;
                }
            }
        }
        Ok(())
    }
}
