//! Reads glTF 2.0 files (`.gltf` and `.glb`) as meshes, pictures, and a scene of the format everything else reads.
//!
//! [`Gltf::open`] reads the container and the JSON; [`Gltf::mesh`] and [`Gltf::picture`] unpack one thing each, and
//! [`scene`] says in the scene format how they belong together. Nothing here draws or knows entities. Animations of
//! nodes become key frames; those of skins and morph targets are not: meshes have the shape that these give them at 0
//! s.
//!
//! The crate `gltf` is not used. It rejects files that load here (positions without bounds, animations without
//! channels, required quantization or clearcoat), knows neither clearcoat, sheen, instances nor hidden nodes, and its
//! accessors do not say what is wrong with them. Its types of the JSON alone would spare fewer than 400 lines of
//! `schema`, which writes files as well, in an order of its own, and would need conversions where they are used.

mod accessor;
mod allowances;
mod animation;
mod basis;
mod camera;
mod combine;
mod draco;
mod emission;
mod error;
pub mod files;
mod folders;
mod guard;
mod instances;
mod layers;
mod lighting;
mod lights;
mod limits;
mod material;
mod mesh;
mod meshopt;
mod motion;
mod nodes;
mod objects;
mod picture;
mod pose;
pub mod profiles;
pub mod scene;
mod schema;
mod skin;
mod specular_glossiness;
mod store;
mod studio;
mod texture;
mod unpack;
mod uri;
pub mod write;
mod zeros;

use std::borrow::Cow;

pub use self::error::{GltfError, MissingParts, ReadFile};
use self::schema::{Material, Root};
use self::store::{COPIES, Store};
use crate::memory::{self, Held};

/// The extensions that a file may require. Of iridescence, dispersion and variants only a warning remains, but a file
/// is better opened without them than not at all.
const SUPPORTED: [&str; 25] = [
    "EXT_lights_ies",
    "EXT_mesh_gpu_instancing",
    "EXT_meshopt_compression",
    "EXT_texture_webp",
    "KHR_draco_mesh_compression",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_diffuse_transmission",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_variants",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    "KHR_meshopt_compression",
    "KHR_node_visibility",
    "KHR_texture_basisu",
    "KHR_texture_transform",
];

fn is_supported(extension: &str) -> bool {
    SUPPORTED.contains(&extension)
}

/// A character for ids: `_` replaces those that ids cannot have, and the slash, which stands between folders.
fn id_character(character: char) -> char {
    match "()[]+:#".contains(character) {
        true => character,
        false => plain_character(character),
    }
}

/// A character for file names: `_` replaces all others.
fn plain_character(character: char) -> char {
    match character.is_alphanumeric() || "-_. ".contains(character) {
        true => character,
        false => '_',
    }
}

/// The byte order mark of UTF-8.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// An opened file with its buffers.
#[derive(Debug)]
pub struct Gltf {
    root: Root,
    buffers: Vec<Vec<u8>>,
    /// The number of mesh elements that are zero without a buffer.
    zeros: usize,
    /// The number of vectors in the morph targets that apply at rest, exact up to the limit.
    moves: usize,
    /// The memory reserved for the objects, the buffers and the mesh that is being made.
    _memory: Held,
}

/// The most memory in bytes that the objects of a JSON take: each of them counts as a material, the largest one, and
/// every other value as a name or a raw value. Growing lists have room for twice as many.
fn json_bytes(json: &[u8]) -> u64 {
    let (mut objects, mut values) = (0, 0);
    for byte in json {
        match byte {
            b'{' => objects += 1,
            b',' | b':' | b'[' => values += 1,
            _ => {}
        }
    }
    json.len() as u64 + 2 * (objects * size_of::<Material>() as u64 + values * VALUE_BYTES)
}

/// Bytes of a value that is no object, with its name.
const VALUE_BYTES: u64 = 64;

impl Gltf {
    /// Whether bytes are a GLB or glTF JSON file, rather than XML.
    pub fn is_gltf(bytes: &[u8]) -> bool {
        let text = bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(bytes);
        Self::is_binary(bytes) || text.trim_ascii_start().starts_with(b"{")
    }

    fn is_binary(bytes: &[u8]) -> bool {
        bytes.starts_with(b"glTF")
    }

    /// Opens a file. `read` reads the buffer files that it names; pictures are read later.
    pub fn open(bytes: &[u8], read: &mut ReadFile) -> Result<Self, GltfError> {
        if bytes.trim_ascii().is_empty() {
            return Err(GltfError::Container("the file is empty"));
        }
        if !Self::is_gltf(bytes) {
            let message =
                "the file is neither binary glTF, which begins with `glTF`, nor glTF JSON, which begins with `{`";
            return Err(GltfError::Container(message));
        }
        let (json, binary) = match Self::is_binary(bytes) {
            true => chunks(bytes)?,
            false => (bytes, None),
        };
        let json = json.strip_prefix(BYTE_ORDER_MARK).unwrap_or(json);
        let mut needed = json_bytes(json);
        let mut memory = memory::reserve(needed).map_err(GltfError::Objects)?;
        let mut root: Root = serde_json::from_slice(json).map_err(GltfError::Json)?;
        root.materials.iter_mut().for_each(Material::settle);
        if !root.asset.version.starts_with("2.") {
            return Err(GltfError::Version(root.asset.version));
        }
        if let Some(name) = root.extensions_required.iter().find(|name| !is_supported(name)) {
            return Err(GltfError::Extension(name.clone()));
        }
        let mut buffers = Vec::with_capacity(root.buffers.len());
        for ((index, buffer), is_placeholder) in root.buffers.iter().enumerate().zip(root.placeholders()) {
            if is_placeholder {
                buffers.push(Vec::new());
                continue;
            }
            let content = match (&buffer.uri, binary) {
                (Some(uri), _) => match uri::content(uri, read) {
                    Err(error) if error.is_missing() => return Err(GltfError::Missing(root.missing_parts(read))),
                    content => content?,
                },
                (None, Some(binary)) if index == 0 => binary.to_vec(),
                (None, _) => Vec::new(),
            };
            // One file may be named many times.
            needed = needed.saturating_add(COPIES * content.len() as u64);
            memory.resize(needed).map_err(GltfError::Memory)?;
            if content.len() < buffer.byte_length {
                return Err(GltfError::Buffer {
                    index,
                    held: content.len(),
                    promised: buffer.byte_length,
                });
            }
            if buffer.uri.is_some() && !root.is_as_written(&buffer.extras, &content) {
                return Err(GltfError::OtherBuffer { index });
            }
            buffers.push(content);
        }
        let mut store = Store::new(buffers, needed, memory);
        root.unpack(&mut store);
        let Store {
            buffers,
            needed,
            mut memory,
            ..
        } = store;
        let zeros = zeros::count_zeros(&root);
        let needed = needed.saturating_add(zeros::zero_bytes(zeros));
        memory.resize(needed).map_err(GltfError::Memory)?;
        Ok(Self {
            moves: root.moves(),
            root,
            buffers,
            zeros,
            _memory: memory.into(),
        })
    }

    fn get<'a, T>(&self, what: &'static str, list: &'a [T], index: usize) -> Result<&'a T, GltfError> {
        let count = list.len();
        list.get(index).ok_or(GltfError::Index { what, index, count })
    }

    /// The bytes of a buffer view.
    fn view(&self, index: usize) -> Result<&[u8], GltfError> {
        let view = self.get("buffer view", &self.root.buffer_views, index)?;
        self.check_unpacked(index, view)?;
        let buffer = self.get("buffer", &self.buffers, view.buffer)?;
        let end = view.byte_offset.checked_add(view.byte_length);
        end.and_then(|end| buffer.get(view.byte_offset..end))
            .ok_or(GltfError::View { index })
    }

    /// The encoded file of a picture. `read` as for [`Self::open`].
    fn image_file(&self, index: usize, read: &mut ReadFile) -> Result<Cow<'_, [u8]>, GltfError> {
        let image = self.get("image", &self.root.images, index)?;
        match (&image.uri, image.buffer_view) {
            (Some(uri), _) => Ok(uri::content(uri, read)?.into()),
            (None, Some(view)) => Ok(self.view(view)?.into()),
            (None, None) => Err(GltfError::Image {
                index,
                what: "neither a file nor bytes are given".to_owned(),
            }),
        }
    }
}

/// The JSON and the binary chunk of a GLB container (section 4.4).
fn chunks(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), GltfError> {
    let word = |at: usize| -> Option<usize> {
        let four = bytes.get(at..at.checked_add(4)?)?;
        Some(u32::from_le_bytes(four.try_into().ok()?) as usize)
    };
    const TRUNCATED: GltfError = GltfError::Container("the file ends before its chunks do");
    if word(4) != Some(2) {
        return Err(GltfError::Container("not version 2 of the binary container"));
    }
    let length = word(8).filter(|&length| length <= bytes.len()).ok_or(TRUNCATED)?;
    let (mut json, mut binary) = (None, None);
    let mut at = 12;
    while at + 8 <= length {
        let (Some(size), Some(kind)) = (word(at), word(at + 4)) else {
            return Err(TRUNCATED);
        };
        let chunk = bytes[..length]
            .get(at + 8..(at + 8).saturating_add(size))
            .ok_or(TRUNCATED)?;
        match (kind, &json) {
            (0x4e4f_534a, None) => json = Some(chunk),
            (0x004e_4942, _) if binary.is_none() => binary = Some(chunk),
            _ => {}
        }
        // Chunks are padded to whole words.
        at += 8 + size.next_multiple_of(4);
    }
    let json = json.ok_or(GltfError::Container("the container has no JSON"))?;
    Ok((json, binary))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn empty_objects_take_as_much_memory_as_full_ones() {
        use schema::{Accessor, Animation, Image, Mesh, Node, Primitive};
        let sizes = [
            size_of::<Accessor>(),
            size_of::<Animation>(),
            size_of::<Image>(),
            size_of::<Mesh>(),
            size_of::<Node>(),
            size_of::<Primitive>(),
        ];
        assert!(sizes.iter().all(|&size| size <= size_of::<Material>()), "{sizes:?}");
        let json = format!(
            r#"{{"asset": {{"version": "2.0"}}, "materials": [{}]}}"#,
            ["{}"; 1000].join(",")
        );
        let root: Root = serde_json::from_str(&json).expect("a file");
        let taken = root.materials.capacity() * size_of::<Material>();
        assert!(taken as u64 <= json_bytes(json.as_bytes()), "{taken}");
    }
}
