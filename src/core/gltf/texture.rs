//! The textures of a file as bitmaps of the scene format.

use glam::{Affine2, Mat4, Vec2, Vec3};

use super::GltfError;
use super::objects::{object, with};
use super::picture::{KnownPicture, Made, Picture};
use super::scene::Builder;
use super::schema::{Texture, TextureInfo};
use crate::document::{Category, Object, TransformOp, Value};

const MIRROR: u32 = 33648;
const CLAMP: u32 = 33071;
const NEAREST: u32 = 9728;

/// The wrapping of a texture along u and v, and its filter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Look {
    wrap: [&'static str; 2],
    is_nearest: bool,
}

impl Builder<'_> {
    /// The image of a texture; None if the reference is invalid.
    fn image(&self, info: &TextureInfo) -> Option<(&Texture, usize)> {
        let texture = self.gltf.root.textures.get(info.index)?;
        let image = texture.image().filter(|&image| image < self.gltf.root.images.len())?;
        Some((texture, image))
    }

    /// The index of the image of a texture; None if the reference is invalid.
    pub(super) fn image_of(&self, info: &TextureInfo) -> Option<usize> {
        Some(self.image(info)?.1)
    }

    fn look(&self, info: &TextureInfo) -> Look {
        let texture = self.gltf.root.textures.get(info.index);
        let sampler = texture
            .and_then(|texture| texture.sampler)
            .and_then(|sampler| self.gltf.root.samplers.get(sampler));
        let wrap = |given: Option<u32>| match given {
            Some(CLAMP) => "clamp",
            Some(MIRROR) => "mirror",
            _ => "repeat",
        };
        Look {
            wrap: sampler.map_or(["repeat"; 2], |sampler| [wrap(sampler.wrap_s), wrap(sampler.wrap_t)]),
            is_nearest: sampler.is_some_and(|sampler| sampler.mag_filter == Some(NEAREST)),
        }
    }

    /// The images of two textures if both have the same mapping and sampler.
    pub(super) fn images_alike(&self, one: &TextureInfo, other: &TextureInfo) -> Option<(usize, usize)> {
        let is_alike = self.look(one) == self.look(other) && one.set() == other.set() && to_uv(one) == to_uv(other);
        let images = (self.image(one)?.1, self.image(other)?.1);
        is_alike.then_some(images)
    }

    /// The picture made of a texture; None (reported) if the reference is invalid.
    pub(super) fn picture(&mut self, info: &TextureInfo, made: Made) -> Option<Picture> {
        let image = self.image(info).map(|(_, image)| image);
        if image.is_none() {
            self.warn(format!(
                "texture {} has no image that can be read: it is left out",
                info.index
            ));
        }
        Some(Picture { image: image?, made })
    }

    /// A texture of the format for the parameter `name`; None (reported) if the reference is invalid.
    pub(super) fn bitmap(&mut self, name: &str, info: &TextureInfo, made: Made) -> Option<Object> {
        let picture = self.picture(info, made)?;
        let file = self.reference_picture(picture)?;
        let mut bitmap = with(object(Category::Texture, "bitmap"), "filename", Value::String(file));
        if made.is_raw() {
            bitmap = with(bitmap, "raw", Value::Boolean(true));
        }
        let Look {
            wrap: [u, v],
            is_nearest,
        } = self.look(info);
        if u != "repeat" {
            bitmap = with(bitmap, "wrap_mode", Value::String(u.into()));
        }
        if v != u {
            bitmap = with(bitmap, "wrap_mode_v", Value::String(v.into()));
        }
        if is_nearest {
            bitmap = with(bitmap, "filter_type", Value::String("nearest".into()));
        }
        if let Some(map) = to_uv(info) {
            let (x, y, by) = (map.matrix2.x_axis, map.matrix2.y_axis, map.translation);
            let matrix = Mat4::from_cols(
                x.extend(0.0).extend(0.0),
                y.extend(0.0).extend(0.0),
                glam::Vec4::Z,
                by.extend(0.0).extend(1.0),
            );
            bitmap = with(bitmap, "to_uv", Value::Transform(vec![TransformOp::Matrix(matrix)]));
        }
        Some(Object {
            name: Some(name.into()),
            ..bitmap
        })
    }
}

/// The transform of texture coordinates (KHR_texture_transform), if the file gives one.
fn to_uv(info: &TextureInfo) -> Option<Affine2> {
    let transform = info.extensions.transform.as_ref()?;
    // v points down in the picture, so that a counter-clockwise rotation there is clockwise in these coordinates.
    Some(Affine2::from_scale_angle_translation(
        Vec2::from(transform.scale),
        -transform.rotation,
        Vec2::from(transform.offset),
    ))
}

impl Builder<'_> {
    /// The name of the picture's file; None (reported) if the picture cannot be read.
    pub fn reference_picture(&mut self, picture: Picture) -> Option<String> {
        let key = format!("{picture:?}");
        if let Some(known) = self.pictures.get(&key) {
            return known.name.clone();
        }
        let name = match self.references.picture(self.pictures.len(), &picture) {
            Ok(name) => Some(name),
            Err(error @ GltfError::Keep { .. }) => {
                self.failure.get_or_insert(error);
                None
            }
            Err(error) => {
                let image = self.gltf.root.images.get(picture.image);
                let title = match image.and_then(|image| image.name.as_deref()) {
                    Some(name) => format!("picture {} ({name})", picture.image),
                    None => format!("picture {}", picture.image),
                };
                self.warn(format!("{title} is left out: {error}"));
                None
            }
        };
        let known = KnownPicture {
            name: name.clone(),
            mean: None,
        };
        self.pictures.insert(key, known);
        name
    }

    /// The linear mean colour of a picture that has a file.
    pub fn mean_of_picture(&mut self, picture: Picture) -> Vec3 {
        let known = self.pictures.get_mut(&format!("{picture:?}"));
        let mut mean = || self.references.mean(&picture).unwrap_or(Vec3::ONE);
        match known {
            Some(known) => *known.mean.get_or_insert_with(mean),
            None => mean(),
        }
    }
}
