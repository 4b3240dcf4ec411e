//! Access to the meshes of an unfinished file: their instances, their vertices, and their replacement by other meshes.

use std::collections::HashSet;

use glam::{Affine3A, Quat, Vec3};

use super::material::Material;
use super::model::{Attributes, BufferView, Mesh, Pose, Primitive};
use super::{GltfWriter, push};

/// An instance of a mesh in the world.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedMesh {
    /// The index of its node.
    pub node: usize,
    /// The names of its ancestors and of the node itself, joined by `/`.
    pub path: String,
    /// The index of the mesh.
    pub mesh: usize,
    /// The transform world from mesh.
    pub world_from_mesh: Affine3A,
    /// Whether its node or one above is animated.
    pub moves: bool,
    /// The lightmap texels per length, relative to other meshes; 0 means no lightmap.
    pub lightmap_scale: f32,
}

impl Pose {
    /// The pose as a transform.
    fn transform(&self) -> Affine3A {
        let [scale, translation] = [self.scale, self.translation].map(Vec3::from);
        Affine3A::from_scale_rotation_translation(scale, Quat::from_array(self.rotation), translation)
    }
}

impl GltfWriter {
    /// All instances of meshes, in the order of the nodes.
    pub fn placed_meshes(&self) -> Vec<PlacedMesh> {
        let animations = self.root.animations.iter();
        let channels = animations.flat_map(|animation| &animation.channels);
        let moving: HashSet<usize> = channels.map(|channel| channel.target.node).collect();
        let top = self.root.scenes.iter().flat_map(|scene| &scene.nodes);
        let mut open: Vec<(usize, Affine3A, bool, String)> = top
            .map(|node| (*node, Affine3A::IDENTITY, false, String::new()))
            .collect();
        let mut placed = Vec::new();
        while let Some((index, world_from_parent, moves, above)) = open.pop() {
            let node = &self.root.nodes[index];
            let world = world_from_parent * node.pose.transform();
            let moves = moves || moving.contains(&index);
            let path = match above.is_empty() {
                true => node.name.clone(),
                false => format!("{above}/{}", node.name),
            };
            open.extend(node.children.iter().map(|child| (*child, world, moves, path.clone())));
            if let Some(mesh) = node.mesh {
                placed.push(PlacedMesh {
                    node: index,
                    path,
                    mesh,
                    world_from_mesh: world,
                    moves,
                    lightmap_scale: node.lightmap_scale.unwrap_or(1.0),
                });
            }
        }
        placed.sort_by_key(|placed| placed.node);
        placed
    }

    /// The number of meshes.
    pub fn mesh_count(&self) -> usize {
        self.root.meshes.len()
    }

    /// A mesh.
    pub fn mesh(&self, mesh: usize) -> &Mesh {
        &self.root.meshes[mesh]
    }

    /// A material.
    pub fn material(&self, material: usize) -> &Material {
        &self.root.materials[material]
    }

    /// The vectors of an accessor of single precision with `N` components.
    pub fn vectors<const N: usize>(&self, accessor: usize) -> Vec<[f32; N]> {
        let (numbers, _) = self.bytes_of(accessor).as_chunks::<4>();
        let numbers: Vec<f32> = numbers.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        numbers.as_chunks::<N>().0.to_vec()
    }

    /// The vertex indices of a primitive's triangles.
    pub fn triangles(&self, primitive: &Primitive) -> Vec<[u32; 3]> {
        let bytes = self.bytes_of(primitive.indices);
        let is_short = bytes.len() == 2 * self.root.accessors[primitive.indices].count;
        let corners: Vec<u32> = match is_short {
            true => bytes
                .as_chunks::<2>()
                .0
                .iter()
                .map(|bytes| u32::from(u16::from_le_bytes(*bytes)))
                .collect(),
            false => bytes
                .as_chunks::<4>()
                .0
                .iter()
                .map(|bytes| u32::from_le_bytes(*bytes))
                .collect(),
        };
        corners.as_chunks::<3>().0.to_vec()
    }

    fn bytes_of(&self, accessor: usize) -> &[u8] {
        let view = &self.root.buffer_views[self.root.accessors[accessor].buffer_view];
        &self.bytes[view.byte_offset..view.byte_offset + view.byte_length]
    }

    /// Adds the vertices `chosen` from others, in that order. `is_turned`: with flipped normals.
    pub fn add_chosen_vertices(&mut self, of: &Attributes, chosen: &[u32], is_turned: bool) -> Attributes {
        let mut attributes = Attributes::new();
        for (name, accessor) in of {
            let copy = match (self.root.accessors[*accessor].kind, &**name) {
                ("VEC2", _) => self.add_chosen::<2>(*accessor, chosen, |value| value),
                (_, "NORMAL") if is_turned => self.add_chosen::<3>(*accessor, chosen, |value| value.map(|x| -x)),
                // The bitangent is the cross product of normal and tangent, so the sign flips to keep it.
                ("VEC4", _) if is_turned => self.add_chosen::<4>(*accessor, chosen, |[x, y, z, side]| [x, y, z, -side]),
                ("VEC4", _) => self.add_chosen::<4>(*accessor, chosen, |value| value),
                _ => self.add_chosen::<3>(*accessor, chosen, |value| value),
            };
            attributes.insert(name.clone(), copy);
        }
        attributes
    }

    fn add_chosen<const N: usize>(
        &mut self,
        accessor: usize,
        chosen: &[u32],
        change: impl Fn([f32; N]) -> [f32; N],
    ) -> usize {
        let all = self.vectors::<N>(accessor);
        let values: Vec<[f32; N]> = chosen.iter().map(|vertex| change(all[*vertex as usize])).collect();
        let bounds = !self.root.accessors[accessor].min.is_empty();
        self.add_floats(&values, bounds, Some(super::geometry::ARRAY_BUFFER))
    }

    /// Adds a pair of texture coordinates for each vertex.
    pub fn add_coordinates(&mut self, attributes: &mut Attributes, name: &str, coordinates: &[[f32; 2]]) {
        let accessor = self.add_floats(coordinates, false, Some(super::geometry::ARRAY_BUFFER));
        attributes.insert(name.to_owned(), accessor);
    }

    /// Replaces the mesh of a node, and adds `extras`, which other programs read.
    pub fn replace_mesh(&mut self, node: usize, mesh: usize, extras: serde_json::Value) {
        self.root.nodes[node].mesh = Some(mesh);
        self.add_extras(node, extras);
    }

    /// Adds the fields of an object to the `extras` of a node. A field of the same name is replaced.
    pub fn add_extras(&mut self, node: usize, extras: serde_json::Value) {
        let own = &mut self.root.nodes[node].extras;
        match (own, extras) {
            (Some(serde_json::Value::Object(own)), serde_json::Value::Object(new)) => own.extend(new),
            (own, new) => *own = Some(new),
        }
    }

    /// Adds `value` to the extras of the nodes of the thing at this position in the scene's file. Returns the nodes.
    pub fn mark(&mut self, order: u32, key: &str, value: usize) -> Vec<usize> {
        let nodes = self.root.nodes.iter_mut().enumerate();
        let mut marked = Vec::new();
        for (number, node) in nodes.filter(|(_, node)| node.order == Some(order)) {
            let extras = node.extras.get_or_insert_with(|| serde_json::json!({}));
            if let Some(extras) = extras.as_object_mut() {
                extras.insert(key.to_owned(), value.into());
            }
            marked.push(number);
        }
        marked
    }

    /// Drops meshes without instances, and the accessors that only these use.
    pub fn drop_unused_meshes(&mut self) {
        let standing: HashSet<usize> = self.root.nodes.iter().filter_map(|node| node.mesh).collect();
        let mut kept = Vec::new();
        let mut new_index = vec![0; self.root.meshes.len()];
        for (index, mesh) in std::mem::take(&mut self.root.meshes).into_iter().enumerate() {
            if standing.contains(&index) {
                new_index[index] = push(&mut kept, mesh);
            }
        }
        self.root.meshes = kept;
        for mesh in self.root.nodes.iter_mut().filter_map(|node| node.mesh.as_mut()) {
            *mesh = new_index[*mesh];
        }
        self.drop_unused_accessors();
    }

    /// Each accessor has its own part of the buffer. Pictures are added to it only when the file is written.
    fn drop_unused_accessors(&mut self) {
        let bytes = std::mem::take(&mut self.bytes);
        let views = std::mem::take(&mut self.root.buffer_views);
        let mut old: Vec<_> = std::mem::take(&mut self.root.accessors).into_iter().map(Some).collect();
        let mut new_index = vec![0; old.len()];
        let mut meshes = std::mem::take(&mut self.root.meshes);
        let mut animations = std::mem::take(&mut self.root.animations);
        let primitives = meshes.iter_mut().flat_map(|mesh| &mut mesh.primitives);
        let of_meshes = primitives.flat_map(|part| part.attributes.values_mut().chain([&mut part.indices]));
        let samplers = animations.iter_mut().flat_map(|animation| &mut animation.samplers);
        let of_animations = samplers.flat_map(|sampler| [&mut sampler.input, &mut sampler.output]);
        for used in of_meshes.chain(of_animations) {
            if let Some(mut accessor) = old[*used].take() {
                let BufferView {
                    byte_offset,
                    byte_length,
                    target,
                    ..
                } = views[accessor.buffer_view];
                let content = bytes[byte_offset..byte_offset + byte_length].iter().copied();
                accessor.buffer_view = self.add_view(content, target);
                new_index[*used] = push(&mut self.root.accessors, accessor);
            }
            *used = new_index[*used];
        }
        self.root.meshes = meshes;
        self.root.animations = animations;
    }
}
