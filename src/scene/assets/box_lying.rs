//! Texture coordinates for shapes whose textures lie by box projection: lengths on the sides of the box.

use std::collections::HashMap;

use bevy::math::{Affine3A, Vec2, Vec3};

use crate::geometry::mesh::MeshData;
use crate::scene::assets::packed_pattern::up_axis;
use crate::scene::components::description::SceneDescription;
use crate::scene::{Choice, Pattern, Texture};
use crate::texture::{ObjectPoint, Up};

/// The upward axis of the box projections of a material and those inside it; None if it has other textures as well.
pub(in crate::scene) fn projection_of(scene: &SceneDescription, material: usize) -> Option<Up> {
    let (mut found, mut are_all) = (None, true);
    // Descriptions have no cycles.
    let mut pending = vec![material];
    while let Some(material) = pending.pop().and_then(|place| scene.materials.get(place)) {
        material
            .material
            .for_each_texture(&mut |texture| match projection(texture) {
                Some(up) => are_all &= *found.get_or_insert(up_axis(up)) == up_axis(up),
                None => are_all = false,
            });
        pending.extend(material.first.into_iter().chain(material.second));
    }
    found.filter(|_| are_all)
}

fn projection(texture: &Texture) -> Option<Choice> {
    match texture {
        Texture::Pattern(pattern) => match &**pattern {
            Pattern::BoxProjection { up, .. } => Some(*up),
            _ => None,
        },
        _ => None,
    }
}

/// The mesh with the coordinates that each triangle has on the side of the box that it faces most. Vertices are split
/// where these differ. Attributes of vertices are left out.
pub(in crate::scene) fn laid(mesh: &MeshData, world_from_mesh: &Affine3A, up: Up) -> MeshData {
    let mut made = MeshData {
        materials: mesh.materials.clone(),
        material_of_triangle: mesh.material_of_triangle.clone(),
        has_computed_normals: mesh.has_computed_normals,
        ..MeshData::default()
    };
    let mut known: HashMap<(u32, [u32; 2]), u32> = HashMap::new();
    for triangle in &mesh.triangles {
        let corners = triangle.map(|corner| world_from_mesh.transform_point3(mesh.positions[corner as usize]));
        let normal = (corners[1] - corners[0])
            .cross(corners[2] - corners[0])
            .normalize_or(Vec3::Z);
        made.triangles.push(std::array::from_fn(|corner| {
            let vertex = triangle[corner];
            let point = ObjectPoint::new(world_from_mesh, corners[corner], normal, [Vec3::ZERO; 2]);
            let uv: Vec2 = point.project(up).0 + Vec2::ZERO;
            *known
                .entry((vertex, uv.to_array().map(f32::to_bits)))
                .or_insert_with(|| {
                    made.positions.push(mesh.positions[vertex as usize]);
                    made.normals.extend(mesh.normals.get(vertex as usize));
                    made.uvs.push(uv);
                    made.positions.len() as u32 - 1
                })
        }));
    }
    made
}
