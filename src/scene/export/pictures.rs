//! The pictures of textures: unchanged files if glTF interprets them the same way, otherwise pictures computed from the
//! textures' values.

use std::collections::HashMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::math::{Affine2, Vec2};
use image::codecs::png::PngDecoder;
use image::{DynamicImage, ImageBuffer, ImageDecoder, ImageFormat};
use rayon::prelude::*;

use super::level::{Map, Varying};
use super::messages::Messages;
use crate::color::{Rgb, srgb_from_linear};
use crate::files::Access;
use crate::gltf::write::material::{TextureExtensions, TextureInfo, TextureTransform};
use crate::gltf::write::model::Sampler;
use crate::gltf::write::{GltfWriter, PictureBytes};
use crate::memory;
use crate::scene::assets::packed_pattern::packed_pattern;
use crate::scene::assets::pattern_tile::Tile;
use crate::scene::assets::texture_map::{load_picture, packed_bitmap};
use crate::scene::{Parameter, Texture, TextureFilter, TextureWrap};
use crate::texture::{self, Checkerboard, Image, TextureId, TexturePoint, TextureTable};

/// Pixels along each side of a picture computed from textures with different uv transforms.
const BAKED: u32 = 1024;

/// Bytes per pixel while such a picture is made: the values, their codes with 16 bits and with 8, and the file.
const BAKED_BYTES: u64 = 40;

/// The content of a picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Planes {
    /// Red, green and blue together.
    pub color: Option<Varying>,
    /// Single channels; None means 1.
    pub channels: [Option<Varying>; 4],
    /// Whether colours are written as sRGB, rather than numbers unchanged.
    pub srgb: bool,
    /// Whether values may be above 1: then they are divided by the largest.
    pub is_light: bool,
    /// Whether glTF would use the alpha of the picture.
    pub counts_alpha: bool,
}

/// The uv transform of a texture, its wrapping, and its size in texels.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Lie {
    to_uv: Affine2,
    filter: TextureFilter,
    wraps: [TextureWrap; 2],
    size: (u32, u32),
}

/// The pictures of an export.
pub(super) struct Pictures<'a> {
    access: &'a Access,
    loaded: HashMap<PathBuf, Option<Arc<Image>>>,
    made: Vec<(Planes, Option<(TextureInfo, f32)>)>,
}

impl<'a> Pictures<'a> {
    pub fn new(access: &'a Access) -> Self {
        Self {
            access,
            loaded: HashMap::new(),
            made: Vec::new(),
        }
    }

    /// The picture of a file; None (reported) if it cannot be read.
    fn load(&mut self, path: &Path, messages: &mut Messages) -> Option<Arc<Image>> {
        if let Some(known) = self.loaded.get(path) {
            return known.clone();
        }
        let image = match load_picture(path, self.access) {
            Ok(picture) => Some(picture.image),
            Err(error) => {
                let name = path.display().to_string();
                messages.note(
                    "picture",
                    &name,
                    format!("grey takes the place of what cannot be read: {error}"),
                );
                None
            }
        };
        self.loaded.insert(path.to_owned(), image.clone());
        image
    }

    /// The mean value of a texture.
    pub fn mean(&mut self, varying: &Varying, messages: &mut Messages) -> Rgb {
        let mut textures = Vec::new();
        let id = self.pack(&varying.texture, None, &mut textures, messages);
        let table = TextureTable::new(textures);
        let side = 16;
        let places =
            (0..side * side).map(|i| Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5) / side as f32);
        let sum: Rgb = places.map(|uv| value(&table, id, varying, uv, 1.0 / side as f32)).sum();
        varying.factor * sum / (side * side) as f32
    }

    /// The texture of a picture with these planes, and a number by which its values are to be multiplied, in addition
    /// to the factors of the planes. None if there are no planes, or if it cannot be made, which is reported.
    pub fn texture(
        &mut self,
        writer: &mut GltfWriter,
        planes: Planes,
        messages: &mut Messages,
    ) -> Option<(TextureInfo, f32)> {
        if let Some((_, known)) = self.made.iter().find(|(known, _)| *known == planes) {
            return known.clone();
        }
        let made = self.make(writer, &planes, messages);
        self.made.push((planes, made.clone()));
        made
    }

    fn make(
        &mut self,
        writer: &mut GltfWriter,
        planes: &Planes,
        messages: &mut Messages,
    ) -> Option<(TextureInfo, f32)> {
        let all: Vec<&Varying> = planes.all().collect();
        let name = name_of(&all.first()?.texture);
        let lies: Vec<Option<Lie>> = all.iter().map(|varying| self.lie(&varying.texture, messages)).collect();
        let common = common_lie(&lies);
        let lie = common.unwrap_or(Lie {
            to_uv: Affine2::IDENTITY,
            filter: TextureFilter::Bilinear,
            wraps: [TextureWrap::Repeat; 2],
            size: (BAKED, BAKED),
        });
        if common.is_none() {
            let what = format!("a picture of {BAKED} x {BAKED} pixels over the unit square of uv takes the place");
            messages.note("texture", &name, what);
        } else if let Some(extent) = all.first().and_then(|varying| Tile::of(&varying.texture)) {
            let extent = extent.extent();
            let what = format!(
                "a picture of {BAKED} x {BAKED} pixels takes the place, which repeats after {:.3} x {:.3}",
                extent.x, extent.y
            );
            messages.note("texture", &name, what);
        }
        let (bytes, peak) = match self.as_it_is(planes) {
            Some(bytes) => (bytes, 1.0),
            None => self.baked(planes, common.is_some(), lie.size, &name, messages)?,
        };
        let picture = writer.add_picture(PictureBytes { name, bytes });
        let [wrap_s, wrap_t] = lie.wraps.map(|wrap| match wrap {
            TextureWrap::Repeat => None,
            TextureWrap::Mirror => Some(33648),
            TextureWrap::Clamp => Some(33071),
        });
        let sampler = Sampler {
            mag_filter: (lie.filter == TextureFilter::Nearest).then_some(9728),
            wrap_s,
            wrap_t,
        };
        let info = TextureInfo {
            index: writer.add_texture(picture, sampler),
            tex_coord: 0,
            scale: 1.0,
            extensions: TextureExtensions {
                transform: transform_of(&lie.to_uv).filter(|_| lie.to_uv != Affine2::IDENTITY),
            },
        };
        Some((info, peak))
    }

    /// The unchanged file of a picture, if glTF interprets it the same way.
    fn as_it_is(&self, planes: &Planes) -> Option<Vec<u8>> {
        let is_alone = planes.channels.iter().all(Option::is_none);
        let varying = planes.color.as_ref().filter(|_| is_alone)?;
        let Texture::Bitmap(bitmap) = &varying.texture else {
            return None;
        };
        if bitmap.raw == planes.srgb || varying.map != Map::Same || varying.as_number {
            return None;
        }
        let bytes = memory::read_data(&bitmap.path, self.access).ok()?;
        let format = image::guess_format(&bytes).ok()?;
        // Here alpha is ignored: opacity is a separate mask.
        let is_right = match format {
            ImageFormat::Png => !(planes.counts_alpha && has_alpha(&bytes)),
            ImageFormat::Jpeg => true,
            _ => false,
        };
        is_right.then_some(bytes)
    }

    /// A PNG file of the planes' values, and the number by which they were divided. `lies_alike`: whether all textures
    /// have the picture's uv transform.
    fn baked(
        &mut self,
        planes: &Planes,
        lies_alike: bool,
        (width, height): (u32, u32),
        name: &str,
        messages: &mut Messages,
    ) -> Option<(Vec<u8>, f32)> {
        let pixels = u64::from(width) * u64::from(height);
        // The sides may come from different pictures, so that it may be far larger than any of them.
        let _memory = match memory::reserve(BAKED_BYTES.saturating_mul(pixels)) {
            Ok(reserved) => reserved,
            Err(shortage) => {
                let what = format!("the picture of {width} x {height} pixels cannot be made: it needs {shortage}");
                messages.note("texture", name, what);
                return None;
            }
        };
        let mut textures = Vec::new();
        let place = lies_alike.then_some(Affine2::IDENTITY);
        let mut pack = |varying: &Varying| self.pack(&varying.texture, place, &mut textures, messages);
        let color = planes.color.as_ref().map(|varying| (varying, pack(varying)));
        let channels = planes
            .channels
            .each_ref()
            .map(|plane| plane.as_ref().map(|varying| (varying, pack(varying))));
        let has_alpha = channels[3].is_some();
        let table = TextureTable::new(textures);
        let size = Vec2::new(width as f32, height as f32);
        let varyings = color.iter().chain(channels.iter().flatten());
        let tiles: Vec<(&Varying, Option<Tile>)> = varyings
            .map(|(varying, _)| (*varying, Tile::of(&varying.texture).filter(|_| lies_alike)))
            .collect();
        let tile_of = |varying: &Varying| tiles.iter().find(|(known, _)| std::ptr::eq(*known, varying))?.1;
        let pixel = |number: u64| {
            let (x, y) = (number % u64::from(width), number / u64::from(width));
            let uv = (Vec2::new(x as f32, y as f32) + 0.5) / size;
            let value = |varying: &Varying, id| match tile_of(varying) {
                Some(tile) => {
                    let pixel = (tile.extent() / size).min_element();
                    tile.value(uv, |at| value(&table, id, varying, tile.place(at), pixel))
                }
                None => value(&table, id, varying, uv, size.recip().min_element()),
            };
            let color = color.map_or(Rgb::ONE, |(varying, id)| value(varying, id));
            let mut pixel = [color.x, color.y, color.z, 1.0];
            for (channel, plane) in pixel.iter_mut().zip(channels) {
                if let Some((varying, id)) = plane {
                    *channel = value(varying, id).x;
                }
            }
            pixel
        };
        let pixels: Vec<[f32; 4]> = (0..pixels).into_par_iter().map(pixel).collect();
        let peak = match planes.is_light {
            true => pixels.iter().flat_map(|pixel| &pixel[..3]).copied().fold(0.0, f32::max),
            false => 1.0,
        };
        let peak = if peak > 1.0 { peak } else { 1.0 };
        let code = |value: f32, is_color: bool| {
            let share = (value / if is_color { peak } else { 1.0 }).clamp(0.0, 1.0);
            let coded = if planes.srgb && is_color {
                srgb_from_linear(share)
            } else {
                share
            };
            (65535.0 * coded).round() as u16
        };
        let coded = pixels.par_iter().map(|[r, g, b, a]| {
            let [r, g, b] = [r, g, b].map(|value| code(*value, true));
            [r, g, b, code(*a, false)]
        });
        let picture = match has_alpha {
            true => {
                let rgba = coded.flat_map_iter(|pixel| pixel);
                ImageBuffer::from_raw(width, height, rgba.collect()).map(DynamicImage::ImageRgba16)
            }
            false => {
                let rgb = coded.flat_map_iter(|[r, g, b, _]| [r, g, b]);
                ImageBuffer::from_raw(width, height, rgb.collect()).map(DynamicImage::ImageRgb16)
            }
        }?;
        // Only emission with a wide range gains from 16 bits, and other programs read 8.
        let picture = match (peak > 1.0, has_alpha) {
            (true, _) => picture,
            (false, true) => picture.into_rgba8().into(),
            (false, false) => picture.into_rgb8().into(),
        };
        let mut bytes = Cursor::new(Vec::new());
        if let Err(error) = picture.write_to(&mut bytes, ImageFormat::Png) {
            messages.note("texture", name, format!("the picture cannot be made: {error}"));
            return None;
        }
        Some((bytes.into_inner(), peak))
    }

    /// The mapping of a texture; None if a picture of its values cannot have it.
    fn lie(&mut self, texture: &Texture, messages: &mut Messages) -> Option<Lie> {
        let lie = match texture {
            Texture::Bitmap(bitmap) => {
                let image = self.load(&bitmap.path, messages);
                Lie {
                    to_uv: bitmap.to_uv,
                    filter: bitmap.filter,
                    wraps: bitmap.wraps(),
                    size: image.map_or((1, 1), |image| (image.width(), image.height())),
                }
            }
            // Two by two squares become two by two texels.
            Texture::Checkerboard { color0, color1, to_uv }
                if color0.constant().is_some() && color1.constant().is_some() =>
            {
                Lie {
                    to_uv: **to_uv,
                    filter: TextureFilter::Nearest,
                    wraps: [TextureWrap::Repeat; 2],
                    size: (2, 2),
                }
            }
            Texture::Pattern(_) => Lie {
                to_uv: place_of(&Tile::of(texture)?)?,
                filter: TextureFilter::Bilinear,
                wraps: [TextureWrap::Repeat; 2],
                size: (BAKED, BAKED),
            },
            Texture::Checkerboard { .. } | Texture::MeshAttribute { .. } => return None,
        };
        transform_of(&lie.to_uv).map(|_| lie)
    }

    /// Adds a texture to the table. `place`: the mapping that replaces its own.
    fn pack(
        &mut self,
        texture: &Texture,
        place: Option<Affine2>,
        textures: &mut Vec<texture::Texture>,
        messages: &mut Messages,
    ) -> TextureId {
        let packed = match texture {
            Texture::Bitmap(bitmap) => {
                let image = self.load(&bitmap.path, messages);
                let image = image.unwrap_or_else(|| Arc::new(Image::uniform(0.5)));
                texture::Texture::Bitmap(texture::Bitmap {
                    to_uv: place.unwrap_or(bitmap.to_uv),
                    ..packed_bitmap(bitmap, image)
                })
            }
            Texture::Checkerboard { color0, color1, to_uv } => {
                let colors = [color0, color1].map(|color| match &**color {
                    Parameter::Constant(color) => texture::Parameter::Constant(*color),
                    Parameter::Texture(inner) => {
                        texture::Parameter::Texture(self.pack(inner, None, textures, messages))
                    }
                });
                texture::Texture::Checkerboard(Checkerboard {
                    colors,
                    to_uv: place.unwrap_or(**to_uv),
                })
            }
            Texture::MeshAttribute { name, scale, times } => texture::Texture::MeshAttribute(texture::MeshAttribute {
                name: name.as_str().into(),
                scale: *scale,
                times: times.as_deref().map(|times| self.pack(times, None, textures, messages)),
            }),
            // Tiles of patterns are looked up in their own coordinates.
            Texture::Pattern(pattern) => {
                packed_pattern(pattern, &mut |nested| self.pack(nested, None, textures, messages))
            }
        };
        textures.push(packed);
        TextureId(textures.len() as u32 - 1)
    }
}

impl Planes {
    fn all(&self) -> impl Iterator<Item = &Varying> {
        self.color.iter().chain(self.channels.iter().flatten())
    }
}

/// Whether a PNG file has alpha.
fn has_alpha(file: &[u8]) -> bool {
    let decoder = PngDecoder::new(Cursor::new(file));
    decoder.is_ok_and(|decoder| decoder.color_type().has_alpha())
}

/// The value at a point, without the factor. `pixel`: the extent of a pixel, over which slopes of bumps are measured.
/// They are those along the coordinates of the surface, to which tangents belong, however the texture is turned.
fn value(table: &TextureTable, id: TextureId, varying: &Varying, uv: Vec2, pixel: f32) -> Rgb {
    if let Map::Bumps { scale, is_mirrored } = varying.map {
        let height = |at: Vec2| scale * table.float(texture::Parameter::Texture(id), &TexturePoint::of_uv(at));
        let slope = |axis: Vec2| (height(uv + 0.5 * pixel * axis) - height(uv - 0.5 * pixel * axis)) / pixel;
        let (u, v) = (slope(Vec2::X), slope(Vec2::Y));
        let v = if is_mirrored { -v } else { v };
        return 0.5 * (Rgb::new(-u, -v, 1.0).normalize_or(Rgb::Z) + Rgb::ONE);
    }
    let at = TexturePoint::of_uv(uv);
    let value = match varying.as_number {
        true => Rgb::splat(table.float(texture::Parameter::Texture(id), &at)),
        false => table.color(texture::Parameter::Texture(id), &at),
    };
    varying.map.apply(value)
}

/// The common mapping with the largest size; None if mappings differ.
fn common_lie(lies: &[Option<Lie>]) -> Option<Lie> {
    let first = (*lies.first()?)?;
    lies.iter().try_fold(first, |so_far, lie| {
        let lie = (*lie)?;
        let size = (so_far.size.0.max(lie.size.0), so_far.size.1.max(lie.size.1));
        let is_alike = Lie { size, ..so_far } == Lie { size, ..lie };
        is_alike.then_some(Lie { size, ..so_far })
    })
}

/// The map of a tile that glTF can have; None if there is none.
fn place_of(tile: &Tile) -> Option<Affine2> {
    let maps = [Some(tile.to_uv), tile.square_to_uv()].into_iter().flatten();
    maps.into_iter().find(|map| transform_of(map).is_some())
}

/// The map as a texture transform of glTF; None if it shears.
fn transform_of(map: &Affine2) -> Option<TextureTransform> {
    const SHEAR: f32 = 1e-5;
    let (x, y) = (map.matrix2.x_axis, map.matrix2.y_axis);
    let is_flat = x.dot(y).abs() > SHEAR * x.length() * y.length();
    if is_flat || x.length() == 0.0 || !map.is_finite() {
        return None;
    }
    let angle = x.y.atan2(x.x);
    // v points down in the picture, so that a counter-clockwise rotation there is clockwise in these coordinates.
    Some(TextureTransform {
        offset: map.translation.to_array(),
        rotation: -angle,
        scale: [x.length(), y.dot(Vec2::from_angle(angle).perp())],
        tex_coord: None,
    })
}

/// The name of a texture: that of its file.
fn name_of(texture: &Texture) -> String {
    match texture {
        Texture::Bitmap(bitmap) => bitmap
            .path
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned(),
        other => other.plugin().to_owned(),
    }
}
