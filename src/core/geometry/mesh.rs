//! Triangle meshes as plain arrays.

use std::collections::HashMap;

use glam::{Mat3, Vec2, Vec3};

use super::attribute::MeshAttribute;
use super::mtl_map::MtlMaps;
use super::strands::Strands;
use super::triangle::is_regular;
use super::vertex_normals::angle_weighted_normals;
use crate::math::Aabb;
use crate::memory::{self, Held, Shortage};

/// An indexed triangle mesh in its own local space, as it was loaded.
///
/// `normals` and `uvs` are empty or as long as `positions`, `material_of_triangle` is empty or as long as `triangles`.
/// Loaders guarantee that positions are finite, vertex indices below `positions.len()`, and material indices below
/// `materials.len()`. Triangles may be degenerate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    /// The vertices.
    pub positions: Vec<Vec3>,
    /// Unit shading normals per vertex, or empty. Loaders always fill them: where the file has none, they are
    /// computed, as Mitsuba does. A shape with `face_normals` ignores them.
    pub normals: Vec<Vec3>,
    /// Whether the file has no normals and all of them were computed from the triangles. They then follow the winding
    /// of the triangles: a mirroring transform flips them too, as in Mitsuba, which computes them after the transform.
    pub has_computed_normals: bool,
    /// The texture coordinates as they are in the file. Mitsuba's `obj` shape flips v (`flip_tex_coords` is true there
    /// by default, false for `ply`): see [`MeshData::flip_tex_coords`].
    pub uvs: Vec<Vec2>,
    /// The vertex indices of the corners, counter-clockwise as seen from the front.
    pub triangles: Vec<[u32; 3]>,
    /// Further attributes of vertices or faces in the file, with unique names.
    pub attributes: Vec<MeshAttribute>,
    /// Index into `materials` per triangle, or empty if the file names none.
    pub material_of_triangle: Vec<u16>,
    /// The materials of the file itself (OBJ's MTL), used by shapes without a bsdf.
    pub materials: Vec<MtlMaterial>,
    /// The curves of a file of curves, which has no triangles.
    pub strands: Strands,
    /// The memory reserved for the mesh and its acceleration structure.
    pub memory: Held,
}

/// Bytes per triangle of an acceleration structure while it is built. The finished one takes a little more than half of
/// that (the Stanford dragon: 57 bytes; the whole process grows by 120 bytes per triangle with mesh and structure).
pub(super) const HIERARCHY_BYTES: u64 = 100;

/// The values of a material of an MTL library. The scene turns them into a BSDF.
#[derive(Clone, Debug, PartialEq)]
pub struct MtlMaterial {
    /// The name that the library gives after `newmtl`.
    pub name: String,
    /// The diffuse colour, linear.
    pub kd: Vec3,
    /// The specular colour, linear.
    pub ks: Vec3,
    /// The emitted radiance.
    pub ke: Vec3,
    /// The Phong exponent.
    pub ns: f32,
    /// Index of refraction.
    pub ni: f32,
    /// The opacity in [0, 1].
    pub d: f32,
    /// The transmittance of the object, per colour and in [0, 1].
    pub tf: Vec3,
    /// The illumination model of the MTL specification, 0 to 10.
    pub illum: Option<u8>,
    /// The roughness of the PBR extension, in [0, 1], if given.
    pub pr: Option<f32>,
    /// The metallic of the PBR extension, in [0, 1], if given.
    pub pm: Option<f32>,
    /// The textures that replace values.
    pub maps: MtlMaps,
}

/// The name of tangents among a mesh's attributes: unit vectors, as glTF has them.
pub const TANGENT: &str = "vertex_tangent";
/// The name of the signs of bitangents, beside [`TANGENT`].
pub const TANGENT_SIGN: &str = "vertex_tangent_sign";

impl MeshData {
    /// The bounding box of all vertices, including unused ones, and of all curves.
    pub fn bounds(&self) -> Aabb {
        Aabb::from_points(self.positions.iter().copied()).union(self.strands.bounds())
    }

    /// The corners of one triangle.
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        let [a, b, c] = self.triangles[triangle];
        [
            self.positions[a as usize],
            self.positions[b as usize],
            self.positions[c as usize],
        ]
    }

    /// The corners of a triangle that a ray can hit: None if a corner is missing or not finite, or if the area is zero.
    pub fn regular_corners(&self, triangle: usize) -> Option<[Vec3; 3]> {
        let [a, b, c] = self.triangles[triangle].map(|corner| self.positions.get(corner as usize).copied());
        Some([a?, b?, c?]).filter(|&corners| is_regular(corners))
    }

    /// The area of a triangle in the mesh's own space; zero if it is degenerate.
    pub fn area_of_triangle(&self, triangle: usize) -> f32 {
        let [a, b, c] = self.corners(triangle);
        0.5 * (b - a).cross(c - a).length()
    }

    /// Finds an attribute by its name, including the prefix.
    pub fn attribute(&self, name: &str) -> Option<&MeshAttribute> {
        self.attributes.iter().find(|attribute| attribute.name == name)
    }

    /// Memory held by the arrays, in bytes; names of materials are not counted.
    pub fn heap_bytes(&self) -> usize {
        fn held<T>(array: &Vec<T>) -> usize {
            array.capacity() * size_of::<T>()
        }
        held(&self.positions)
            + held(&self.normals)
            + held(&self.uvs)
            + held(&self.triangles)
            + held(&self.material_of_triangle)
            + held(&self.materials)
            + self
                .attributes
                .iter()
                .map(|attribute| attribute.values.heap_bytes())
                .sum::<usize>()
            + self.strands.heap_bytes()
    }

    /// Memory of the arrays and of the acceleration structure that rays will need, in bytes.
    pub fn memory_bytes(&self) -> u64 {
        let of_hierarchy = HIERARCHY_BYTES * self.triangles.len() as u64 + self.strands.hierarchy_bytes();
        self.heap_bytes() as u64 + of_hierarchy
    }

    /// This mesh with smooth normals computed from its triangles, replacing its normals. Vertices that only share a
    /// position are not merged: the crease between them remains.
    pub fn with_vertex_normals(mut self) -> Self {
        self.normals = angle_weighted_normals(&self.positions, &self.triangles);
        self.has_computed_normals = true;
        self
    }

    /// A copy with vertically flipped texture coordinates, and with memory reserved for itself and its acceleration
    /// structure.
    pub fn with_flipped_tex_coords(&self) -> Result<Self, Shortage> {
        let memory = memory::reserve(self.memory_bytes())?.into();
        let mut copy = Self { memory, ..self.clone() };
        copy.flip_tex_coords();
        Ok(copy)
    }

    /// A copy whose strands have the positions of their control points transformed, as [`super::strands::stretch_of`]
    /// says, and with memory reserved for itself and its acceleration structure.
    pub fn with_stretched_strands(&self, by: &Mat3) -> Result<Self, Shortage> {
        let memory = memory::reserve(self.memory_bytes())?.into();
        let mut copy = Self { memory, ..self.clone() };
        copy.strands.stretch(by);
        Ok(copy)
    }

    /// Flips every texture coordinate vertically: v becomes 1 - v.
    pub fn flip_tex_coords(&mut self) {
        for uv in &mut self.uvs {
            uv.y = 1.0 - uv.y;
        }
    }

    /// The number of edges with a different number of triangles on each side; 0 for a mesh without holes. Vertices at
    /// the same position count as one, because files repeat those where texture coordinates or normals differ.
    /// Triangles without area do not count.
    pub fn open_edges(&self) -> usize {
        let vertices = self.welded();
        let mut edges: Vec<(u32, u32, i32)> = Vec::with_capacity(3 * self.triangles.len());
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|vertex| vertices[vertex as usize]);
            if a == b || b == c || c == a {
                continue;
            }
            edges.extend([(a, b), (b, c), (c, a)].map(|(from, to)| match from < to {
                true => (from, to, 1),
                false => (to, from, -1),
            }));
        }
        edges.sort_unstable();
        let of_edge = edges.chunk_by(|one, other| (one.0, one.1) == (other.0, other.1));
        of_edge
            .filter(|sides| sides.iter().map(|side| side.2).sum::<i32>() != 0)
            .count()
    }

    /// For each vertex the first vertex at its position.
    fn welded(&self) -> Vec<u32> {
        // -0 and +0 are the same coordinate.
        let key = |place: Vec3| (place + Vec3::ZERO).to_array().map(f32::to_bits);
        let mut first = HashMap::with_capacity(self.positions.len());
        let places = self.positions.iter().zip(0..);
        places
            .map(|(place, index)| *first.entry(key(*place)).or_insert(index))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::primitives::unit_cube;

    #[test]
    fn a_cube_is_closed_and_one_without_a_triangle_is_not() {
        // Each face of the cube has corners of its own.
        let mut cube = unit_cube();
        assert_eq!(cube.open_edges(), 0);
        cube.triangles.pop();
        assert_eq!(cube.open_edges(), 3);
        // A triangle with the opposite winding does not close the hole.
        let turned = unit_cube().triangles[11];
        cube.triangles.push([turned[0], turned[2], turned[1]]);
        assert_eq!(cube.open_edges(), 3);
    }

    #[test]
    fn a_zero_has_no_sign_and_what_has_no_area_no_edge() {
        let mut cube = unit_cube();
        for place in &mut cube.positions {
            *place = (*place + 1.0) * 0.5;
        }
        for (index, place) in cube.positions.iter_mut().enumerate() {
            if index % 2 == 0 && place.x == 0.0 {
                place.x = -0.0;
            }
        }
        cube.triangles.push([0, 0, 1]);
        assert_eq!(cube.open_edges(), 0);
    }

    #[test]
    fn two_cubes_that_share_an_edge_are_closed() {
        let mut both = unit_cube();
        let other = unit_cube();
        let first = both.positions.len() as u32;
        both.positions
            .extend(other.positions.iter().map(|place| *place + Vec3::new(2.0, 2.0, 0.0)));
        both.triangles.extend(
            other
                .triangles
                .iter()
                .map(|corners| corners.map(|corner| corner + first)),
        );
        assert_eq!(both.open_edges(), 0);
    }
}
