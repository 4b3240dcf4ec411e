//! Texture coordinates for shapes whose textures lie by box projection: lengths on the sides of the box.

use std::collections::HashMap;

use bevy::math::{Affine3A, Mat3, Vec2, Vec3};

use crate::geometry::mesh::MeshData;
use crate::memory::{self, Shortage};
use crate::scene::assets::packed_pattern::up_axis;
use crate::scene::components::description::{SceneDescription, ShapeDescription};
use crate::scene::{Choice, Pattern, ShapeKind, Texture};
use crate::texture::{ObjectPoint, Up};

/// The upward axes of the box projections of a material and those inside it, and whether it has other textures as well.
fn projections_of(scene: &SceneDescription, material: usize) -> (Vec<Up>, bool) {
    let (mut found, mut has_others) = (Vec::new(), false);
    // Descriptions have no cycles.
    let mut pending = vec![material];
    while let Some(material) = pending.pop().and_then(|place| scene.materials.get(place)) {
        material
            .material
            .for_each_texture(&mut |texture| match projection(texture) {
                Some(up) => found.push(up_axis(up)),
                None => has_others = true,
            });
        pending.extend(material.first.into_iter().chain(material.second));
    }
    (found, has_others)
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

/// The box from whose sides textures lie on a shape.
#[derive(Clone, Copy, Debug)]
pub(in crate::scene) struct LyingBox {
    up: Up,
    world_from_mesh: Affine3A,
    /// The box of a triangle has its edges for axes; other shapes have those of their mesh.
    world_from_box: Affine3A,
    /// Whether the geometric normals of the triangles point to the side from which they run clockwise.
    is_turned: bool,
}

/// Bytes for each triangle of the most that coordinates, split vertices and the table of these take.
const BYTES_PER_TRIANGLE: u64 = 250;

impl LyingBox {
    /// The box of a shape whose mesh has the transform `shape_from_mesh`, or of a member of a group in an instance
    /// placed by `placement`. None unless all textures of the shape are box projections with the same upward axis.
    pub fn of(
        scene: &SceneDescription,
        shape: &ShapeDescription,
        shape_from_mesh: &Affine3A,
        placement: Option<&Affine3A>,
    ) -> Option<Self> {
        let (ups, has_others) = projections_of(scene, shape.material?);
        let up = *ups.first()?;
        let is_lit_by_uv = shape
            .area_light
            .as_ref()
            .is_some_and(|light| light.radiance.constant().is_none());
        if has_others || is_lit_by_uv || ups.iter().any(|other| *other != up) {
            return None;
        }
        let own = shape.to_world * *shape_from_mesh;
        // A mirroring transform turns the geometric normals of meshes around, but not those of other shapes and of
        // groups.
        let is_mesh = !is_round_or_flat(&shape.shape.kind);
        let is_mirrored = |map: &Affine3A| map.matrix3.determinant() < 0.0;
        let is_turned = shape.shape.flip_normals ^ (!is_mesh && is_mirrored(&own)) ^ placement.is_some_and(is_mirrored);
        let world_from_mesh = placement.map_or(own, |placement| *placement * own);
        let mesh_from_box = match &shape.shape.kind {
            ShapeKind::Triangle { corners: [a, b, c] } => {
                let (u, v) = (*b - *a, *c - *a);
                Affine3A::from_mat3_translation(Mat3::from_cols(u, v, u.cross(v).normalize_or_zero()), *a)
            }
            _ => Affine3A::IDENTITY,
        };
        Some(Self {
            up,
            world_from_mesh,
            world_from_box: world_from_mesh * mesh_from_box,
            is_turned,
        })
    }

    /// A key for the coordinates: boxes with equal keys lay them alike on one mesh, wherever they stand.
    pub fn key(&self) -> String {
        let Self { up, is_turned, .. } = self;
        let columns = self.world_from_box.matrix3.to_cols_array_2d().map(Vec3::from);
        let directions = columns.map(Vec3::normalize_or_zero);
        let cosine = |a: usize, b: usize| (1e4 * directions[a].dot(directions[b])).round() as i32;
        let lengths = columns.map(|column| format!("{:.4e}", column.length()));
        let is_mirrored = self.world_from_box.matrix3.determinant() < 0.0;
        let upright = self.point(Vec3::ZERO, Vec3::Z).upright(*up);
        format!(
            "box {lengths:?} {:?} {upright:?} {is_mirrored} {is_turned}",
            [cosine(0, 1), cosine(0, 2), cosine(1, 2)]
        )
    }

    /// Whether the axes of the box are not at right angles.
    pub fn is_sheared(&self) -> bool {
        let [x, y, z] = self
            .world_from_box
            .matrix3
            .to_cols_array_2d()
            .map(|axis| Vec3::from(axis).normalize_or_zero());
        [x.dot(y), x.dot(z), y.dot(z)].iter().any(|cosine| cosine.abs() > 1e-3)
    }

    fn point(&self, position: Vec3, normal: Vec3) -> ObjectPoint {
        ObjectPoint::new(&self.world_from_box, position, normal, [Vec3::ZERO; 2])
    }

    /// The mesh with the coordinates that each triangle has on the side of the box that it faces most. Vertices are
    /// split where these differ. Attributes of vertices are left out. An error if the memory does not suffice.
    pub fn laid(&self, mesh: &MeshData) -> Result<MeshData, Shortage> {
        let triangles = mesh.triangles.len() as u64;
        let mut made = MeshData {
            materials: mesh.materials.clone(),
            material_of_triangle: mesh.material_of_triangle.clone(),
            has_computed_normals: mesh.has_computed_normals,
            memory: memory::reserve(BYTES_PER_TRIANGLE.saturating_mul(triangles))?.into(),
            ..MeshData::default()
        };
        let side = if self.is_turned { -1.0 } else { 1.0 };
        let mut known: HashMap<(u32, [u32; 2]), u32> = HashMap::new();
        for triangle in &mesh.triangles {
            let corners = triangle.map(|corner| self.world_from_mesh.transform_point3(mesh.positions[corner as usize]));
            let normal = side
                * (corners[1] - corners[0])
                    .cross(corners[2] - corners[0])
                    .normalize_or(Vec3::Z);
            made.triangles.push(std::array::from_fn(|corner| {
                let vertex = triangle[corner];
                let uv: Vec2 = self.point(corners[corner], normal).project(self.up).0 + Vec2::ZERO;
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
        Ok(made)
    }
}

/// Whether some textures of a shape's material are box projections.
pub(in crate::scene) fn has_projection(scene: &SceneDescription, shape: &ShapeDescription) -> bool {
    let projections = shape.material.map(|material| projections_of(scene, material).0);
    projections.is_some_and(|ups| !ups.is_empty())
}

/// Whether a shape is one whose normals a mirroring transform leaves outside, unlike those of triangles.
fn is_round_or_flat(kind: &ShapeKind) -> bool {
    let is_triangle = matches!(kind, ShapeKind::Triangle { .. });
    kind.is_flat() && !is_triangle || matches!(kind, ShapeKind::Sphere { .. } | ShapeKind::Cylinder { .. })
}

/// The transform of the mesh that takes the place of a shape with the transform `to_world`, and whether the mesh has to
/// be [`mirrored`]: as it is, that of a mirrored round or flat shape would show its inner side.
pub(in crate::scene) fn as_mesh(kind: &ShapeKind, to_world: Affine3A) -> (bool, Affine3A) {
    match is_round_or_flat(kind) && to_world.matrix3.determinant() < 0.0 {
        true => (true, to_world * Affine3A::from_scale(MIRROR)),
        false => (false, to_world),
    }
}

/// The scale that mirrors at the plane x = 0.
const MIRROR: Vec3 = Vec3::new(-1.0, 1.0, 1.0);

/// The mesh mirrored at the plane x = 0, with the same outer side.
pub(in crate::scene) fn mirrored(mesh: MeshData) -> MeshData {
    MeshData {
        positions: mesh.positions.iter().map(|position| MIRROR * *position).collect(),
        normals: mesh.normals.iter().map(|normal| MIRROR * *normal).collect(),
        triangles: mesh.triangles.iter().map(|[a, b, c]| [*a, *c, *b]).collect(),
        ..mesh
    }
}
