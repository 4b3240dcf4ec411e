//! The textures of MTL materials.

use bevy::math::{Affine2, Vec2};

use crate::geometry::mtl_map::MtlMap;
use crate::scene::{Bitmap, Texture, TextureFilter, TextureWrap};

/// The texture of a map. `raw`: whether its values are numbers, not colours.
///
/// Meshes of such files have v flipped already, unlike the transform in the library.
pub(crate) fn mtl_picture(map: &MtlMap, raw: bool) -> Texture {
    let (scale, offset) = (map.scale, map.offset);
    let offset = Vec2::new(offset.x, 1.0 - scale.y - offset.y);
    Texture::Bitmap(Box::new(Bitmap {
        path: map.file.clone(),
        filter: TextureFilter::Bilinear,
        wrap: match map.clamp {
            true => TextureWrap::Clamp,
            false => TextureWrap::Repeat,
        },
        wrap_v: None,
        raw,
        to_uv: Affine2::from_scale_angle_translation(scale, 0.0, offset),
    }))
}
