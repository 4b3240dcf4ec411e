//! The triangles of a file: each primitive of each mesh is one mesh of ours, numbered through in the order of the file.

use glam::{Vec2, Vec3};

use super::schema::{Mesh, Primitive};
use super::{Gltf, GltfError};
use crate::geometry::attribute::{AttributeDomain, AttributeValues, MeshAttribute};
use crate::geometry::mesh::MeshData;
use crate::geometry::mesh_file::LoadedMesh;

/// What vertex colours are called among a mesh's attributes.
pub const VERTEX_COLOR: &str = "vertex_color";

const TRIANGLES: u32 = 4;
const STRIP: u32 = 5;
const FAN: u32 = 6;

impl Gltf {
    /// Every primitive; points and lines are numbered as well, but have no triangles.
    fn primitives(&self) -> impl Iterator<Item = &Primitive> {
        self.root.meshes.iter().flat_map(|mesh| &mesh.primitives)
    }

    /// For each mesh of the file the number of its first primitive.
    pub(super) fn first_primitives(&self) -> Vec<u32> {
        let first = |next: &mut u32, mesh: &Mesh| {
            let first = *next;
            *next += mesh.primitives.len() as u32;
            Some(first)
        };
        self.root.meshes.iter().scan(0, first).collect()
    }

    /// How many meshes [`Self::mesh`] has.
    pub fn mesh_count(&self) -> u32 {
        self.primitives().count() as u32
    }

    /// One mesh, in its own space. v is 0 at the upper edge of pictures, as everywhere.
    pub fn mesh(&self, number: u32) -> Result<LoadedMesh, GltfError> {
        let count = self.mesh_count() as usize;
        let found = self.primitives().nth(number as usize).ok_or(GltfError::Index {
            what: "primitive",
            index: number as usize,
            count,
        })?;
        self.read_primitive(number, found)
    }

    /// One mesh whose number is known.
    pub(super) fn read_primitive(&self, number: u32, primitive: &Primitive) -> Result<LoadedMesh, GltfError> {
        let index = number as usize;
        let bad = |what: String| GltfError::Primitive { index, what };
        let mut warnings = Vec::new();
        let attribute = |name: &str| primitive.attributes.get(name).copied();
        let positions = attribute("POSITION").ok_or_else(|| bad("has no positions".into()))?;
        let positions: Vec<Vec3> = self
            .vectors::<3>(positions, "VEC3")?
            .into_iter()
            .map(Vec3::from)
            .collect();
        if let Some(vertex) = positions.iter().position(|position| !position.is_finite()) {
            return Err(bad(format!("the position of vertex {vertex} is not finite")));
        }
        let vertices = positions.len();
        // Values that are not one per vertex are of no use.
        let mut matches_vertices = |name: &str, count: usize| {
            if count != vertices {
                warnings.push(format!(
                    "primitive {index}: {count} values {name} for {vertices} vertices are left out"
                ));
            }
            count == vertices
        };
        let mut normals: Vec<Vec3> = match attribute("NORMAL") {
            Some(accessor) => self
                .vectors::<3>(accessor, "VEC3")?
                .into_iter()
                .map(Vec3::from)
                .collect(),
            None => Vec::new(),
        };
        if !normals.is_empty() && !matches_vertices("NORMAL", normals.len()) {
            normals.clear();
        }
        let set = format!("TEXCOORD_{}", self.uv_set(primitive));
        let mut uvs: Vec<Vec2> = match attribute(&set) {
            Some(accessor) => self
                .vectors::<2>(accessor, "VEC2")?
                .into_iter()
                .map(Vec2::from)
                .collect(),
            None => Vec::new(),
        };
        if !uvs.is_empty() && !matches_vertices(&set, uvs.len()) {
            uvs.clear();
        }
        let mut attributes = Vec::new();
        if let Some(accessor) = attribute("COLOR_0") {
            let colors = self.colors(accessor)?;
            if matches_vertices("COLOR_0", colors.len()) {
                // Of a material without a picture the colour is this product; there is no other place for it.
                let factor = self.base_color(primitive);
                attributes.push(MeshAttribute {
                    name: VERTEX_COLOR.to_owned(),
                    domain: AttributeDomain::Vertex,
                    channels: 3,
                    values: AttributeValues::F32(
                        colors
                            .into_iter()
                            .flat_map(|color| (Vec3::from(color) * factor).to_array())
                            .collect(),
                    ),
                });
            }
        }
        let indices = match primitive.indices {
            Some(accessor) => self.indices(accessor)?,
            None => (0..vertices as u32).collect(),
        };
        if let Some(vertex) = indices.iter().find(|&&vertex| vertex as usize >= vertices) {
            return Err(bad(format!("vertex {vertex} is not there: it has {vertices}")));
        }
        let mut mesh = MeshData {
            triangles: triangles(primitive.mode, &indices).ok_or_else(|| bad("holds no triangles".into()))?,
            positions,
            normals,
            uvs,
            attributes,
            ..MeshData::default()
        };
        let are_unit = mesh.normals.iter().all(|normal| normal.try_normalize().is_some());
        if mesh.normals.is_empty() || !are_unit {
            mesh = mesh.with_vertex_normals();
        } else {
            mesh.normals.iter_mut().for_each(|normal| *normal = normal.normalize());
        }
        Ok(LoadedMesh { mesh, warnings })
    }

    /// Linear RGB; alpha is not kept.
    fn colors(&self, accessor: usize) -> Result<Vec<[f32; 3]>, GltfError> {
        match self.accessor_kind(accessor)? {
            "VEC4" => Ok(self
                .vectors::<4>(accessor, "VEC4")?
                .into_iter()
                .map(|[r, g, b, _]| [r, g, b])
                .collect()),
            _ => self.vectors::<3>(accessor, "VEC3"),
        }
    }

    fn base_color(&self, primitive: &Primitive) -> Vec3 {
        let material = primitive.material.and_then(|index| self.root.materials.get(index));
        let factor = material.map_or([1.0; 4], |material| material.pbr_metallic_roughness.base_color_factor);
        Vec3::new(factor[0], factor[1], factor[2])
    }
}

/// Three vertices each; None for points, lines and what is unknown.
fn triangles(mode: u32, indices: &[u32]) -> Option<Vec<[u32; 3]>> {
    Some(match mode {
        TRIANGLES => indices
            .chunks_exact(3)
            .map(|three| [three[0], three[1], three[2]])
            .collect(),
        // Every other triangle of a strip goes around the other way.
        STRIP => indices
            .windows(3)
            .zip(0..)
            .map(|(three, i)| match i % 2 {
                0 => [three[0], three[1], three[2]],
                _ => [three[1], three[0], three[2]],
            })
            .collect(),
        FAN => match indices {
            [center, rest @ ..] => rest.windows(2).map(|two| [two[0], two[1], *center]).collect(),
            [] => Vec::new(),
        },
        _ => return None,
    })
}

impl Primitive {
    /// Whether there are triangles to it, rather than points or lines.
    pub(super) fn has_triangles(&self) -> bool {
        (TRIANGLES..=FAN).contains(&self.mode)
    }

    /// Without normals of its own it is to be shaded flat (section 3.7.2.1).
    pub(super) fn is_flat(&self) -> bool {
        !self.attributes.contains_key("NORMAL")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_their_side() {
        let indices = [0, 1, 2, 3, 4];
        assert_eq!(triangles(STRIP, &indices), Some(vec![[0, 1, 2], [2, 1, 3], [2, 3, 4]]));
        assert_eq!(triangles(FAN, &indices), Some(vec![[1, 2, 0], [2, 3, 0], [3, 4, 0]]));
        assert_eq!(triangles(TRIANGLES, &indices), Some(vec![[0, 1, 2]]));
        assert_eq!(triangles(FAN, &[]), Some(vec![]));
        assert_eq!(triangles(1, &indices), None);
    }
}
