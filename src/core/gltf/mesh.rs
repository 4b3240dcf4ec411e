//! The triangles of a file: each primitive of each mesh becomes one mesh, numbered in the order of the file.

use std::collections::HashMap;

use glam::{Mat4, Vec2, Vec3};

use super::allowances::{MOST_MOVES, MeshAllowance};
use super::pose::{orientation, skinned, turn_mirrored};
use super::schema::{Material, Mesh, Primitive, Root};
use super::{Gltf, GltfError};
use crate::geometry::attribute::{AttributeDomain, AttributeValues, MeshAttribute};
use crate::geometry::mesh::{MeshData, TANGENT, TANGENT_SIGN};
use crate::geometry::mesh_file::{LoadedMesh, Warnings, complete_normals, replace_not_finite};
use crate::geometry::vertex_normals::unit;

/// The vertex attributes that a material uses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct MeshValues {
    /// Whether there are vertex colours.
    pub colors: bool,
    /// Whether the vertex alpha is used.
    pub alpha: bool,
}

/// The name of vertex colours among a mesh's attributes.
pub const VERTEX_COLOR: &str = "vertex_color";
/// The name of the vertex alpha, which is present if the material uses it.
pub const VERTEX_ALPHA: &str = "vertex_alpha";

const TRIANGLES: u32 = 4;
const STRIP: u32 = 5;
const FAN: u32 = 6;

impl Gltf {
    /// All primitives of the file. Points and lines are numbered as well, but have no triangles.
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

    /// The number of meshes for [`Self::mesh`].
    pub fn mesh_count(&self) -> u32 {
        self.primitives().count() as u32
    }

    /// One mesh, in its own space. v is 0 at the upper edge of pictures, as everywhere in glTF.
    pub fn mesh(&self, number: u32) -> Result<LoadedMesh, GltfError> {
        let count = self.mesh_count() as usize;
        let mut before = number as usize;
        for mesh in &self.root.meshes {
            if let Some(found) = mesh.primitives.get(before) {
                return self.read_primitive(number, found, &mesh.weights, None);
            }
            before -= mesh.primitives.len();
        }
        Err(GltfError::Index {
            what: "primitive",
            index: number as usize,
            count,
        })
    }

    /// Reads one mesh. `weights`: the morph weights. `bones`: the transforms world from mesh by the bones, if they
    /// deform it, which give a mesh in world space.
    pub(super) fn read_primitive(
        &self,
        number: u32,
        primitive: &Primitive,
        weights: &[f32],
        bones: Option<&[Option<Mat4>]>,
    ) -> Result<LoadedMesh, GltfError> {
        let index = number as usize;
        let bad = |what: String| GltfError::Primitive { index, what };
        if let Some(fault) = &primitive.fault {
            return Err(bad(fault.clone()));
        }
        let mut warnings = Vec::new();
        if self.leaves_targets_out(primitive, weights) {
            warnings.push(too_many_moves());
        }
        let attribute = |name: &str| primitive.attributes.get(name).copied();
        let place = attribute("POSITION").ok_or_else(|| bad("has no positions".into()))?;
        let vertices = self.accessor(place)?.count;
        let no_triangles = || bad("holds no triangles".into());
        let indexed = match primitive.indices {
            Some(accessor) => Some(triangles(primitive.mode, &self.indices(accessor)?).ok_or_else(no_triangles)?),
            None => None,
        };
        // Primitives may share vertices; each gets the ones it uses.
        let used = indexed.as_deref().map(used_vertices);
        let used = used.as_deref();
        let mut positions: Vec<Vec3> = into_vectors(self.vectors::<3>(place, "VEC3", used)?);
        self.morph("POSITION", primitive, weights, (vertices, used), &mut positions)?;
        let bones = bones.map(|bones| self.vertex_bones(primitive, bones, (vertices, used)));
        let (bones, _memory) = bones.transpose()?.unzip();
        skinned(&mut positions, bones.as_deref(), false);
        if let Some(slot) = positions.iter().position(|position| !position.is_finite()) {
            let vertex = used.map_or(slot, |used| used[slot] as usize);
            return Err(bad(format!("the position of vertex {vertex} is not finite")));
        }
        let mut triangles = match (indexed, used) {
            (Some(indexed), Some(used)) => renumbered(indexed, used),
            _ => {
                let all: Vec<u32> = (0..positions.len() as u32).collect();
                triangles(primitive.mode, &all).ok_or_else(no_triangles)?
            }
        };
        if triangles.is_empty() {
            return Err(no_triangles());
        }
        turn_mirrored(&mut triangles, bones.as_deref().unwrap_or_default());
        // The accessor, unless it does not have one value per vertex.
        let mut per_vertex = |name: &str| -> Result<Option<usize>, GltfError> {
            let Some(accessor) = attribute(name) else {
                return Ok(None);
            };
            let count = self.accessor(accessor)?.count;
            if count != vertices {
                warnings.push(format!(
                    "primitive {index}: {count} values {name} for {vertices} vertices are left out"
                ));
            }
            Ok(Some(accessor).filter(|_| count == vertices))
        };
        let mut normals: Vec<Vec3> = match per_vertex("NORMAL")? {
            Some(accessor) => into_vectors(self.vectors::<3>(accessor, "VEC3", used)?),
            None => Vec::new(),
        };
        self.morph("NORMAL", primitive, weights, (vertices, used), &mut normals)?;
        skinned(&mut normals, bones.as_deref(), true);
        let uvs: Vec<Vec2> = match per_vertex(&format!("TEXCOORD_{}", self.uv_set(primitive)))? {
            Some(accessor) => into_vectors(self.vectors::<2>(accessor, "VEC2", used)?),
            None => Vec::new(),
        };
        let mut attributes = Vec::new();
        if let Some(accessor) = per_vertex("COLOR_0")? {
            let counts_alpha = self.look_of(primitive).is_some_and(Material::counts_alpha);
            self.add_colors(accessor, primitive, counts_alpha, used, &mut attributes)?;
        }
        // Only normal maps need tangents, and without normals they are ignored (section 3.7.2.1).
        let has_normal_map = self
            .look_of(primitive)
            .is_some_and(|look| look.normal_texture.is_some());
        if has_normal_map
            && !normals.is_empty()
            && let Some(accessor) = per_vertex("TANGENT")?
        {
            self.add_tangents(accessor, used, bones.as_deref(), &mut attributes)?;
        }
        let mesh = MeshData {
            triangles,
            positions,
            normals,
            uvs,
            attributes,
            ..MeshData::default()
        };
        Ok(completed(mesh, index, warnings))
    }

    /// Adds linear vertex colours, and their alpha if it is used.
    fn add_colors(
        &self,
        accessor: usize,
        primitive: &Primitive,
        counts_alpha: bool,
        used: Option<&[u32]>,
        attributes: &mut Vec<MeshAttribute>,
    ) -> Result<(), GltfError> {
        let of_vertices = |name: &str, channels, values| MeshAttribute {
            name: name.to_owned(),
            domain: AttributeDomain::Vertex,
            channels,
            values: AttributeValues::F32(values),
        };
        let has_alpha = self.accessor(accessor)?.kind == "VEC4";
        let colors: Vec<[f32; 4]> = match has_alpha {
            true => self.vectors::<4>(accessor, "VEC4", used)?,
            false => self
                .vectors::<3>(accessor, "VEC3", used)?
                .into_iter()
                .map(|[r, g, b]| [r, g, b, 1.0])
                .collect(),
        };
        // If the material has no texture, this product is the only place for its colour. A picture of specular colour
        // holds it, since the colour of metal there is not that of the diffuse factor.
        let factor = self.base_color(primitive);
        let linear = |[r, g, b, _]: &[f32; 4]| (Vec3::new(*r, *g, *b) * factor).to_array();
        attributes.push(of_vertices(VERTEX_COLOR, 3, colors.iter().flat_map(linear).collect()));
        if has_alpha && counts_alpha {
            let alphas = colors.iter().map(|color| color[3]);
            attributes.push(of_vertices(VERTEX_ALPHA, 1, alphas.collect()));
        }
        Ok(())
    }

    /// Adds tangents, unless one is zero: then tangents follow from the texture coordinates.
    fn add_tangents(
        &self,
        accessor: usize,
        used: Option<&[u32]>,
        bones: Option<&[Mat4]>,
        attributes: &mut Vec<MeshAttribute>,
    ) -> Result<(), GltfError> {
        let mut tangents = self.vectors::<4>(accessor, "VEC4", used)?;
        for (tangent, bone) in tangents.iter_mut().zip(bones.into_iter().flatten()) {
            let [x, y, z, sign] = *tangent;
            // Normals stay outside, so that a mirrored bitangent is on their other side.
            *tangent = bone
                .transform_vector3(Vec3::new(x, y, z))
                .extend(sign * orientation(bone))
                .to_array();
        }
        let unit = |[x, y, z, _]: &[f32; 4]| unit(Vec3::new(*x, *y, *z));
        let Some(directions) = tangents.iter().map(unit).collect::<Option<Vec<Vec3>>>() else {
            return Ok(());
        };
        let signs = tangents.iter().map(|[.., sign]| if *sign < 0.0 { -1.0 } else { 1.0 });
        let directions = directions.into_iter().flat_map(|direction| direction.to_array());
        for (name, channels, values) in [(TANGENT, 3, directions.collect()), (TANGENT_SIGN, 1, signs.collect())] {
            attributes.push(MeshAttribute {
                name: name.to_owned(),
                domain: AttributeDomain::Vertex,
                channels,
                values: AttributeValues::F32(values),
            });
        }
        Ok(())
    }

    fn look_of(&self, primitive: &Primitive) -> Option<&Material> {
        self.root.materials.get(primitive.material?)
    }

    /// The factor on vertex colours.
    fn base_color(&self, primitive: &Primitive) -> Vec3 {
        let look = self.look_of(primitive);
        let factor = look
            .filter(|look| look.specular_picture().is_none())
            .map_or([1.0; 4], |look| look.pbr_metallic_roughness.base_color_factor);
        Vec3::new(factor[0], factor[1], factor[2])
    }
}

/// The warning of a file with too many morph targets.
pub(super) fn too_many_moves() -> String {
    format!("the morph targets of the file have more than {MOST_MOVES} vectors, and do not count")
}

/// A mesh without missing and impossible values, with warnings of these.
fn completed(mut mesh: MeshData, index: usize, mut warnings: Vec<String>) -> LoadedMesh {
    let mut found = Warnings::default();
    replace_not_finite(&mut mesh, &mut found);
    complete_normals(&mut mesh, &mut found);
    // The file that is made of the mesh has normals.
    mesh.has_computed_normals = false;
    let found = found.finish().into_iter();
    warnings.extend(found.map(|sentence| format!("primitive {index}: {sentence}")));
    LoadedMesh { mesh, warnings }
}

pub(super) fn into_vectors<const N: usize, V: From<[f32; N]>>(numbers: Vec<[f32; N]>) -> Vec<V> {
    numbers.into_iter().map(V::from).collect()
}

/// The vertices used by triangles, ascending.
fn used_vertices(triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut used = triangles.as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    used.shrink_to_fit();
    used
}

/// The triangles with each vertex replaced by its index in `used`, which has all of them.
fn renumbered(mut triangles: Vec<[u32; 3]>, used: &[u32]) -> Vec<[u32; 3]> {
    // Usually the used vertices are the first ones and keep their indices.
    if used.last().is_some_and(|&last| last as usize + 1 != used.len()) {
        for vertex in triangles.as_flattened_mut() {
            *vertex = used.partition_point(|other| other < vertex) as u32;
        }
    }
    triangles
}

/// The triangles of an index list; None for points, lines and unknown modes.
fn triangles(mode: u32, indices: &[u32]) -> Option<Vec<[u32; 3]>> {
    Some(match mode {
        TRIANGLES => indices
            .chunks_exact(3)
            .map(|three| [three[0], three[1], three[2]])
            .collect(),
        // Every other triangle of a strip has the opposite winding.
        STRIP => indices
            .windows(3)
            .enumerate()
            .map(|(i, three)| match i % 2 {
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
    /// Whether the mode is one of triangles, rather than points or lines.
    pub(super) fn has_triangles(&self) -> bool {
        (TRIANGLES..=FAN).contains(&self.mode)
    }

    /// Whether the primitive has no normals and is shaded flat (section 3.7.2.1).
    pub(super) fn is_flat(&self) -> bool {
        !self.attributes.contains_key("NORMAL")
    }
}

/// The attributes that morph targets change.
const MOVED: [&str; 2] = ["POSITION", "NORMAL"];

/// The morph targets of a primitive with nonzero weights.
pub(super) fn weighted<'a>(
    primitive: &'a Primitive,
    weights: &'a [f32],
) -> impl Iterator<Item = (&'a HashMap<String, usize>, f32)> {
    let targets = primitive.targets.iter().zip(weights.iter().copied());
    targets.filter(|(_, weight)| *weight != 0.0 && weight.is_finite())
}

impl Root {
    /// The number of vectors in the morph targets with nonzero weights, of all meshes and of nodes with weights of
    /// their own, and of the primitives and targets that are looked at. The sum ends above [`MOST_MOVES`]: in a file of
    /// 1 MB, thousands of nodes may each have weights for thousands of primitives.
    pub(super) fn moves(&self) -> usize {
        self.moves_up_to(MOST_MOVES)
    }

    fn moves_up_to(&self, most: usize) -> usize {
        let of_meshes = self.meshes.iter().map(|mesh| (mesh, mesh.weights.as_slice()));
        let of_nodes = self.nodes.iter().filter_map(|node| {
            let mesh = self.meshes.get(node.mesh?)?;
            Some((mesh, node.weights.as_deref()?))
        });
        let shapes = of_meshes.chain(of_nodes);
        let primitives = shapes.flat_map(|(mesh, weights)| mesh.primitives.iter().map(move |one| (one, weights)));
        let mut sum = 0usize;
        for (primitive, weights) in primitives {
            sum = sum.saturating_add(self.moves_of(primitive, weights));
            if sum > most {
                break;
            }
        }
        sum
    }

    /// The cost of adding the morph targets of a primitive: the number of vectors in those with nonzero weights, and
    /// one for the primitive and for each of its targets.
    pub(super) fn moves_of(&self, primitive: &Primitive, weights: &[f32]) -> usize {
        let targets = weighted(primitive, weights);
        let accessors = targets.flat_map(|(target, _)| MOVED.iter().filter_map(|name| target.get(*name)));
        let counts = accessors.filter_map(|&index| {
            let accessor = self.accessors.get(index)?;
            let replaced = accessor.sparse.as_ref().map_or(0, |sparse| sparse.count);
            Some(accessor.count.max(replaced))
        });
        let looked_at = 1 + primitive.targets.len().min(weights.len());
        counts.fold(looked_at, usize::saturating_add)
    }
}

impl Gltf {
    /// The weights by which a primitive is morphed: none once the file has added too many vectors of morph targets.
    pub(super) fn allowed_weights<'a>(
        &self,
        primitive: &Primitive,
        weights: &'a [f32],
        allowance: &mut MeshAllowance,
    ) -> &'a [f32] {
        let is_allowed = weights.is_empty()
            || allowance.has_moves() && allowance.spend_moves(self.root.moves_of(primitive, weights));
        if is_allowed { weights } else { &[] }
    }

    /// Whether morph targets of a primitive are left out, because the file has too many.
    pub(super) fn leaves_targets_out(&self, primitive: &Primitive, weights: &[f32]) -> bool {
        self.moves > MOST_MOVES && weighted(primitive, weights).next().is_some()
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

    #[test]
    fn primitives_of_nodes_with_weights_are_counted_up_to_a_limit() {
        let text = format!(
            r#"{{"asset": {{"version": "2.0"}}, "meshes": [{{"primitives": [{}]}}], "nodes": [{}]}}"#,
            [r#"{"attributes": {}, "targets": [{}]}"#; 100].join(","),
            [r#"{"mesh": 0, "weights": [1]}"#; 100].join(","),
        );
        let root: Root = serde_json::from_str(&text).expect("a file");
        // Each node has 100 primitives with a target, and the mesh has no weights.
        assert_eq!(root.moves(), 100 * 200 + 100);
        assert_eq!(root.moves_up_to(1000), 1002);
    }
}
