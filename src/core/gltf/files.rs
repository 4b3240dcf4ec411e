//! Splits a glTF file into files that other readers of the scene format know: meshes as PLY, pictures as PNG, JPEG or
//! EXR.

use std::collections::BTreeSet;

use glam::Vec3;

use super::allowances::PictureAllowance;
use super::objects::{object, with};
use super::picture::{Picture, PictureFile};
use super::profiles::{KnownProfile, MOST_PROFILE_BYTES};
use super::scene::{Imported, References};
use super::{Gltf, GltfError, ReadFile};
use crate::document::{Category, Object, Value};
use crate::geometry::mesh::MeshData;
use crate::geometry::ply_write::binary_ply;
use crate::texture::load_image;

/// Stores the content of a file with a plain name such as `mesh-0.ply`, which is unique. Returns the name by which the
/// scene finds it.
pub type KeepFile<'a> = dyn FnMut(&str, &[u8]) -> std::io::Result<String> + 'a;

/// Makes the scene, and passes its meshes and pictures to `keep`. `read` is as for [`Gltf::open`].
pub fn take_apart(gltf: &Gltf, keep: &mut KeepFile, read: &mut ReadFile) -> Result<Imported, GltfError> {
    let mut parts = Parts {
        gltf,
        keep,
        read,
        last: None,
        allowance: PictureAllowance::default(),
        profile_bytes_left: MOST_PROFILE_BYTES,
        replaced: BTreeSet::new(),
    };
    let mut imported = gltf.scene(&mut parts)?;
    let replaced = parts.replaced.iter().map(|index| {
        format!("the file of image {index} is not the one that was written with this file: it was changed, or is of another export")
    });
    imported.warnings.extend(replaced);
    Ok(imported)
}

struct Parts<'a, 'k, 'r> {
    gltf: &'a Gltf,
    keep: &'a mut KeepFile<'k>,
    read: &'a mut ReadFile<'r>,
    /// The latest picture, whose mean may be asked for next.
    last: Option<(Picture, PictureFile)>,
    allowance: PictureAllowance<'a>,
    profile_bytes_left: usize,
    /// The images whose files were replaced since they were written with the glTF file.
    replaced: BTreeSet<usize>,
}

impl Parts<'_, '_, '_> {
    fn keep(&mut self, name: String, bytes: &[u8]) -> Result<String, GltfError> {
        (self.keep)(&name, bytes).map_err(|source| GltfError::Keep { name, source })
    }
}

impl References for Parts<'_, '_, '_> {
    fn shape(&mut self, number: u32, mesh: &MeshData) -> Result<Object, GltfError> {
        let name = self.keep(format!("mesh-{number}.ply"), &binary_ply(mesh))?;
        Ok(with(object(Category::Shape, "ply"), "filename", Value::String(name)))
    }

    fn picture(&mut self, index: usize, picture: &Picture) -> Result<String, GltfError> {
        let make = || self.gltf.picture(picture, self.read);
        let images = (picture.image, picture.made.second());
        let made = self.allowance.spend(self.gltf, images, make)?;
        if !made.is_as_written {
            self.replaced.insert(picture.image);
        }
        let name = self.keep(format!("picture-{index}.{}", made.extension), &made.bytes)?;
        self.last = Some((picture.clone(), made));
        Ok(name)
    }

    fn mean(&mut self, picture: &Picture) -> Result<Vec3, GltfError> {
        let made = match self.last.take() {
            Some((last, made)) if last == *picture => made,
            _ => self.gltf.picture(picture, self.read)?,
        };
        let image = load_image(&made.bytes).map_err(|error| GltfError::Image {
            index: picture.image,
            what: error.to_string(),
        })?;
        // Pictures brighter than white are stored as linear numbers.
        Ok(image.mean(made.extension == "exr"))
    }

    fn profile(&mut self, index: usize) -> Result<KnownProfile, GltfError> {
        let gltf = self.gltf;
        let (bytes, geometry) = gltf.profile(index, self.read)?;
        let left = self.profile_bytes_left.checked_sub(bytes.len());
        self.profile_bytes_left = left.ok_or_else(|| GltfError::Profile {
            index,
            what: "all light profiles together have too many bytes".to_owned(),
        })?;
        let name = self.keep(format!("lamp-{index}.ies"), &bytes)?;
        Ok(KnownProfile { name, geometry })
    }

    fn file(&mut self, name: &str, bytes: &[u8]) -> Result<String, GltfError> {
        self.keep(name.to_owned(), bytes)
    }
}
