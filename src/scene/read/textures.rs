//! Reads textures: `bitmap`, `checkerboard`, `mesh_attribute`, and the patterns.

use bevy::math::Affine2;
use glam::Vec3;

use super::parameters::Parameters;
use super::picture_search::PictureSearch;
use crate::color::Rgb;
use crate::document::{Reader, TransformOp};
use crate::scene::{Bitmap, Pattern, Texture, TextureFilter, TextureWrap};

/// Reads a texture; None (reported) if it is unsupported or invalid.
pub fn read_texture(reader: &mut Reader, pictures: &mut PictureSearch) -> Option<Texture> {
    Some(match reader.object().plugin.as_str() {
        "bitmap" => Texture::Bitmap(Box::new(bitmap(reader, pictures)?)),
        "checkerboard" => {
            let mut color = |name, default: f32| {
                let given = reader.unbounded_color(name, pictures);
                Box::new(given.unwrap_or(Rgb::splat(default).into()))
            };
            Texture::Checkerboard {
                color0: color("color0", 0.4),
                color1: color("color1", 0.2),
                to_uv: Box::new(to_uv(reader)),
            }
        }
        "mesh_attribute" => Texture::MeshAttribute {
            name: attribute_name(reader)?,
            scale: reader.float_or("scale", 1.0),
            times: reader.texture("times", pictures).map(Box::new),
        },
        plugin if let Some(mut pattern) = Pattern::of_plugin(plugin) => {
            reader.declared(&mut pattern, pictures);
            Texture::Pattern(Box::new(pattern))
        }
        plugin => {
            let message = format!("texture `{plugin}` is not supported");
            let span = reader.object().span;
            reader.diagnostics().warn(span, message);
            return None;
        }
    })
}

fn bitmap(reader: &mut Reader, pictures: &mut PictureSearch) -> Option<Bitmap> {
    // This program decides how the picture is stored in memory.
    reader.ignore(&["format", "accel"]);
    let filter = reader.string("filter_type").and_then(|name| {
        let known = TextureFilter::of_name(name);
        if known.is_none() {
            let message = format!("expected the filter `bilinear` or `nearest`, found `{name}`");
            reader.error_at("filter_type", message);
        }
        known
    });
    let wrap = wrap_mode(reader, "wrap_mode").unwrap_or_default();
    let wrap_v = wrap_mode(reader, "wrap_mode_v");
    let raw = reader.boolean_or("raw", false);
    let to_uv = to_uv(reader);
    let Some(name) = reader.string("filename") else {
        if !reader.has("filename") {
            reader.error_at("filename", "a `bitmap` needs a `filename`");
        }
        return None;
    };
    Some(Bitmap {
        path: pictures.find(name, reader),
        filter: filter.unwrap_or_default(),
        wrap,
        wrap_v: wrap_v.filter(|other| *other != wrap),
        raw,
        to_uv,
    })
}

/// The continuation outside of the picture, if it is given.
fn wrap_mode(reader: &mut Reader, name: &str) -> Option<TextureWrap> {
    let mode = reader.string(name)?;
    let known = TextureWrap::of_name(mode);
    if known.is_none() {
        let message = format!("expected the wrap mode `repeat`, `mirror` or `clamp`, found `{mode}`");
        reader.error_at(name, message);
    }
    known
}

fn attribute_name(reader: &mut Reader) -> Option<String> {
    let name = reader.string("name");
    match name {
        Some(name) if name.starts_with("vertex_") || name.starts_with("face_") => Some(name.to_owned()),
        Some(name) => {
            let message = format!("names of mesh attributes begin with `vertex_` or `face_`, found `{name}`");
            reader.error_at("name", message);
            None
        }
        None => {
            reader.error_at("name", "a `mesh_attribute` needs a `name`");
            None
        }
    }
}

/// The affine map of uv in `to_uv`, a transform of space. If its numbers become too large, it is an error, and the
/// identity is used.
pub(super) fn to_uv(reader: &mut Reader) -> Affine2 {
    let steps = reader.transform("to_uv").unwrap_or_default();
    let map = TransformOp::compose(&steps);
    if !map.is_finite() {
        reader.error_at("to_uv", "`to_uv` is not finite: its steps together are too large");
        return Affine2::IDENTITY;
    }
    Affine2::from_cols(
        Vec3::from(map.matrix3.x_axis).truncate(),
        Vec3::from(map.matrix3.y_axis).truncate(),
        Vec3::from(map.translation).truncate(),
    )
}
