//! Triangle meshes as plain arrays.

use glam::{Vec2, Vec3};

use crate::math::Aabb;

/// An indexed triangle mesh in its own local space, as it was loaded.
///
/// `normals` and `uvs` are empty or as long as `positions`. Every index is below `positions.len()`; loaders guarantee it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshData {
    pub positions: Vec<Vec3>,
    /// Unit shading normals per vertex, or empty.
    pub normals: Vec<Vec3>,
    pub uvs: Vec<Vec2>,
    pub triangles: Vec<[u32; 3]>,
    /// Index into `materials` per triangle, or empty when the file names none.
    pub material_of_triangle: Vec<u16>,
    /// The materials of the file itself (OBJ's MTL), used by shapes that name no bsdf.
    pub materials: Vec<MtlMaterial>,
}

/// A material of an MTL library, as numbers; what they mean as a BSDF is decided by whoever builds one.
#[derive(Clone, Debug, PartialEq)]
pub struct MtlMaterial {
    pub name: String,
    /// Diffuse and specular colour, linear.
    pub kd: Vec3,
    pub ks: Vec3,
    /// Emitted radiance.
    pub ke: Vec3,
    /// Phong exponent.
    pub ns: f32,
    /// Index of refraction.
    pub ni: f32,
    /// Opacity in [0, 1].
    pub d: f32,
    /// Illumination model of the MTL specification, 0 to 10.
    pub illum: Option<u8>,
    /// PBR extension: roughness and metallic in [0, 1], where given.
    pub pr: Option<f32>,
    pub pm: Option<f32>,
}

impl MeshData {
    pub fn bounds(&self) -> Aabb {
        Aabb::from_points(self.positions.iter().copied())
    }

    /// The corners of one triangle.
    pub fn corners(&self, triangle: usize) -> [Vec3; 3] {
        self.triangles[triangle].map(|i| self.positions[i as usize])
    }
}
