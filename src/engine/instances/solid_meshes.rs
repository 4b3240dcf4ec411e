//! The meshes of building parts in use. Parts with equal dimensions share one, as copies of stairs do.

use std::collections::HashMap;
use std::sync::Arc;

use crate::geometry::mesh::MeshData;
use crate::scene::assets::solid_mesh::solid_mesh;
use crate::scene::{Declared, ParameterRef, Solid};

/// The meshes, each with a unique number.
#[derive(Default)]
pub(in crate::engine) struct SolidMeshes {
    known: HashMap<(&'static str, Vec<u32>), (u64, Arc<MeshData>)>,
    next: u64,
}

impl SolidMeshes {
    /// The mesh and its number.
    pub fn get(&mut self, part: &Solid) -> (u64, Arc<MeshData>) {
        let next = &mut self.next;
        let entry = self.known.entry((part.plugin(), bits(part))).or_insert_with(|| {
            *next += 1;
            (*next, Arc::new(solid_mesh(part)))
        });
        entry.clone()
    }

    /// Drops the meshes whose numbers are not in use.
    pub fn retain(&mut self, is_used: impl Fn(u64) -> bool) {
        self.known.retain(|_, (number, _)| is_used(*number));
    }
}

/// The dimensions that determine the mesh, as bits for an exact comparison.
fn bits(part: &Solid) -> Vec<u32> {
    let mut bits = Vec::new();
    part.visit(&mut |_, value| match value {
        ParameterRef::Length(length) => bits.push(length.to_bits()),
        ParameterRef::Count(count) => bits.push(*count),
        ParameterRef::Openings(openings) => bits.extend(openings.iter().flat_map(|opening| {
            let numbers = [opening.from, opening.sill, opening.width, opening.height];
            numbers.map(f32::to_bits)
        })),
        _ => {}
    });
    bits
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_parts_share_their_mesh_until_none_is_used() {
        let mut meshes = SolidMeshes::default();
        let [wall, stairs] = ["wall", "stairs"].map(|plugin| Solid::of_plugin(plugin).unwrap_or_default());
        let (first, mesh) = meshes.get(&wall);
        let (second, same) = meshes.get(&wall.clone());
        assert!(first == second && Arc::ptr_eq(&mesh, &same));
        let (other, _) = meshes.get(&stairs);
        assert_ne!(first, other);
        meshes.retain(|number| number == other);
        assert_ne!(meshes.get(&wall).0, first);
        assert_eq!(meshes.get(&stairs).0, other);
    }
}
