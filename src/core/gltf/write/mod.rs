//! Writes glTF 2.0 files, `.glb` and `.gltf`.
//!
//! [`GltfWriter`] collects nodes, meshes, materials, pictures, lights, cameras and animations, which refer to each
//! other by index, and the bytes of their buffer. [`GltfWriter::binary`] and [`GltfWriter::text`] make the files. The
//! conversion of scenes is decided elsewhere.

mod container;
mod geometry;
pub mod material;
mod meshes;
pub mod model;

pub use self::container::BesideFile;
pub use self::geometry::Triangles;
use self::material::Material;
pub use self::meshes::PlacedMesh;
use self::model::{
    Accessor, Animation, AnimationSampler, BufferView, Camera, Channel, ChannelTarget, Light, Mesh, Node, NodeLight,
    Root, Sampler, Texture,
};

/// The roughness of sheen in written files, since the scene format has none: a lobe as wide as that of `principled`.
pub const SHEEN_ROUGHNESS: f32 = 0.5;

const FLOAT: u32 = 5126;

/// The reason why a file cannot be written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum GltfWriteError {
    #[error("it has {count} {what}: a glTF mesh has at most {most}")]
    TooMany { what: &'static str, count: u64, most: u64 },
    /// The length of the binary container has 32 bits.
    #[error("a .glb file has at most 4294967295 bytes, and this one would have {0}: export as .gltf")]
    Long(u64),
    #[error("the description of the file cannot be written: {0}")]
    Json(String),
}

/// The encoded file of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureBytes {
    /// The name, without extension.
    pub name: String,
    /// PNG or JPEG.
    pub bytes: Vec<u8>,
}

impl PictureBytes {
    /// The extension and the media type of the file.
    fn kind(&self) -> (&'static str, &'static str) {
        match self.bytes.starts_with(b"\x89PNG") {
            true => ("png", "image/png"),
            false => ("jpg", "image/jpeg"),
        }
    }
}

/// The interpolation between keys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Interpolation {
    /// Linear; rotations along the shortest arc.
    Linear,
    /// Each value holds until the next key.
    Step,
}

/// A glTF file under construction.
#[derive(Debug, Default)]
pub struct GltfWriter {
    root: Root,
    bytes: Vec<u8>,
    pictures: Vec<PictureBytes>,
    /// Files of light profiles.
    profiles: Vec<Vec<u8>>,
}

fn push<T>(list: &mut Vec<T>, item: T) -> usize {
    list.push(item);
    list.len() - 1
}

/// The index of an equal item, or of the new one.
fn push_new<T: PartialEq>(list: &mut Vec<T>, item: T) -> usize {
    match list.iter().position(|known| *known == item) {
        Some(index) => index,
        None => push(list, item),
    }
}

impl GltfWriter {
    /// Adds a node below another one, or at the top.
    pub fn add_node(&mut self, node: Node, parent: Option<usize>) -> usize {
        let index = push(&mut self.root.nodes, node);
        match parent {
            Some(parent) => self.root.nodes[parent].children.push(index),
            None => {
                if self.root.scenes.is_empty() {
                    self.root.scenes.push(Default::default());
                }
                self.root.scenes[0].nodes.push(index);
            }
        }
        index
    }

    /// Adds a node with a light.
    pub fn add_light(&mut self, mut node: Node, light: Light, parent: Option<usize>) -> usize {
        let light = push(&mut self.root.extensions.lights.lights, light);
        node.extensions.light = Some(NodeLight { light });
        self.add_node(node, parent)
    }

    /// Adds a mesh.
    pub fn add_mesh(&mut self, mesh: Mesh) -> usize {
        push(&mut self.root.meshes, mesh)
    }

    /// Adds a material.
    pub fn add_material(&mut self, material: Material) -> usize {
        push(&mut self.root.materials, material)
    }

    /// Adds a camera.
    pub fn add_camera(&mut self, camera: Camera) -> usize {
        push(&mut self.root.cameras, camera)
    }

    /// Adds a picture, unless there is one with the same bytes.
    pub fn add_picture(&mut self, picture: PictureBytes) -> usize {
        match self.pictures.iter().position(|known| known.bytes == picture.bytes) {
            Some(index) => index,
            None => push(&mut self.pictures, picture),
        }
    }

    /// Adds a light profile, a file of IES LM-63, unless there is an equal one. Nodes refer to it by its index.
    pub fn add_profile(&mut self, bytes: Vec<u8>) -> usize {
        push_new(&mut self.profiles, bytes)
    }

    /// Adds a texture, a picture with a sampler, unless there is an equal one.
    pub fn add_texture(&mut self, picture: usize, sampler: Sampler) -> usize {
        let sampler = (sampler != Sampler::default()).then(|| push_new(&mut self.root.samplers, sampler));
        let source = Some(picture);
        push_new(
            &mut self.root.textures,
            Texture {
                source,
                sampler,
                ..Texture::default()
            },
        )
    }

    /// Adds a buffer view. `target`: its use on GPUs, by the numbers of the specification.
    fn add_view(&mut self, bytes: impl IntoIterator<Item = u8>, target: Option<u32>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let byte_offset = self.bytes.len();
        self.bytes.extend(bytes);
        let view = BufferView {
            buffer: 0,
            byte_offset,
            byte_length: self.bytes.len() - byte_offset,
            target,
        };
        push(&mut self.root.buffer_views, view)
    }

    /// Adds an accessor of single-precision vectors, at least one. `bounds`: whether it gets the minimum and the
    /// maximum.
    fn add_floats<const N: usize>(&mut self, values: &[[f32; N]], bounds: bool, target: Option<u32>) -> usize {
        let bytes = values.as_flattened().iter().flat_map(|number| number.to_le_bytes());
        let buffer_view = self.add_view(bytes, target);
        let extreme = |of: fn(f32, f32) -> f32| {
            let extremes = values
                .iter()
                .copied()
                .reduce(|a, b| std::array::from_fn(|i| of(a[i], b[i])));
            extremes
                .filter(|_| bounds)
                .map_or(Vec::new(), |extremes| extremes.to_vec())
        };
        let accessor = Accessor {
            buffer_view,
            component_type: FLOAT,
            count: values.len(),
            kind: ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1],
            min: extreme(f32::min),
            max: extreme(f32::max),
        };
        push(&mut self.root.accessors, accessor)
    }

    /// Adds the ascending, non-negative times of keys in seconds.
    pub fn add_times(&mut self, times: &[f32]) -> usize {
        let times: Vec<[f32; 1]> = times.iter().map(|time| [*time]).collect();
        self.add_floats(&times, true, None)
    }

    /// Animates a node: `path` is `translation`, `rotation` or `scale`, with a value for each of the `times`, an
    /// accessor.
    pub fn animate<const N: usize>(
        &mut self,
        node: usize,
        path: &'static str,
        times: usize,
        values: &[[f32; N]],
        interpolation: Interpolation,
    ) {
        let output = self.add_floats(values, false, None);
        if self.root.animations.is_empty() {
            self.root.animations.push(Animation::default());
        }
        let animation = &mut self.root.animations[0];
        let sampler = push(
            &mut animation.samplers,
            AnimationSampler {
                input: times,
                output,
                interpolation: match interpolation {
                    Interpolation::Linear => "LINEAR",
                    Interpolation::Step => "STEP",
                },
            },
        );
        let target = ChannelTarget { node, path };
        animation.channels.push(Channel { sampler, target });
    }
}
