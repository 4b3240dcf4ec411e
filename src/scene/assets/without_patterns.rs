//! A scene for programs that have neither patterns nor lamps with measured intensities: pictures take the place of
//! patterns, shapes on which they lie by box projection become meshes with the coordinates of the box, and lamps become
//! spots and point lights.

use std::collections::HashMap;
use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy::math::{Affine2, Affine3A, Vec2};
use image::{DynamicImage, ImageBuffer, ImageFormat};
use rayon::prelude::*;

use super::box_lying::{LyingBox, as_mesh, mirrored};
use super::group_copies::with_groups_by_box;
use super::lamp_file::standard_light;
use super::packed_pattern::packed_pattern;
use super::pattern_tile::Tile;
use super::shape_mesh::{shape_mesh, unit_form};
use super::texture_map::{load_picture, packed_bitmap};
use super::triangle_mesh::load_mesh;
use crate::color::{Rgb, srgb_from_linear};
use crate::files::{Access, FileSet, WriteError};
use crate::geometry::mesh::MeshData;
use crate::geometry::ply_write::binary_ply;
use crate::memory;
use crate::scene::components::description::SceneDescription;
use crate::scene::{
    Bitmap, Declared, EmitterKind, MeshFile, MeshFormat, Parameter, ParameterMut, ShapeKind, Texture, TextureFilter,
    TextureWrap,
};
use crate::texture::{self, Checkerboard, Image, TextureId, TexturePoint, TextureTable};

/// Pixels along each side of a picture.
const EDGE: u32 = 1024;

/// Bytes per pixel while a picture is made: its values, their codes and the file.
const PIXEL_BYTES: u64 = 32;

/// The reason why a scene cannot be written without patterns.
#[derive(Debug, thiserror::Error)]
pub enum PatternError {
    #[error(transparent)]
    File(#[from] WriteError),
    /// A picture cannot be made.
    #[error("{0}")]
    Picture(String),
}

/// The scene without patterns for writing to `target`; the new files beside that are added to `set`. None if it has no
/// patterns.
pub(in crate::scene) fn without_patterns(
    scene: &SceneDescription,
    target: &Path,
    access: &Access,
    set: &mut FileSet,
) -> Result<Option<SceneDescription>, PatternError> {
    let split = with_groups_by_box(scene);
    let scene = split.as_ref().unwrap_or(scene);
    let mut changed = scene.clone();
    let mut maker = Maker {
        target,
        access,
        known: Vec::new(),
        meshes: HashMap::new(),
        set,
        files: 0,
    };
    maker.lay_shapes(scene, &mut changed)?;
    for described in &mut changed.materials {
        maker.parameters(&mut described.material)?;
    }
    for shape in &mut changed.shapes {
        if let Some(light) = &mut shape.area_light {
            maker.parameters(light)?;
        }
    }
    let mut has_lamps = false;
    for emitter in &mut changed.emitters {
        if let Some(light) = standard_light(&emitter.emitter, access) {
            // Without its file the lamp is dark.
            emitter.emitter.kind = light.unwrap_or(EmitterKind::Point { intensity: Rgb::ZERO });
            has_lamps = true;
        }
        maker.parameters(&mut emitter.emitter.kind)?;
    }
    Ok((maker.files > 0 || has_lamps).then_some(changed))
}

/// The use of a picture, which decides on its coding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Use {
    /// Reflectances from 0 to 1, as 8-bit sRGB.
    Reflectance,
    /// Colours of light without a bound, linear.
    Light,
    /// Other colours, such as normals and indices of metals, which are no light, linear.
    Values,
    /// Numbers, linear: in 16 bits if all are from 0 to 1.
    Number,
}

/// Makes files.
struct Maker<'a> {
    target: &'a Path,
    access: &'a Access,
    /// The pictures made so far.
    known: Vec<(Texture, Use, Bitmap)>,
    /// The meshes made so far, by their form and their box.
    meshes: HashMap<String, PathBuf>,
    set: &'a mut FileSet,
    /// The number of files added to the set.
    files: usize,
}

impl Maker<'_> {
    /// Adds a file with this content; returns its path.
    fn add(&mut self, kind: &str, extension: &str, content: &[u8]) -> Result<PathBuf, PatternError> {
        let stem = self.target.file_stem().unwrap_or_default().to_string_lossy();
        self.files += 1;
        let name = format!("{stem}.{kind}-{}.{extension}", self.files);
        let path = self.target.with_file_name(name);
        self.set.add(&path, content)?;
        Ok(path)
    }

    /// Replaces shapes whose textures lie by box projection. Members of groups have the coordinates that they have in
    /// the first instance of the group, or of a crowd.
    fn lay_shapes(&mut self, scene: &SceneDescription, changed: &mut SceneDescription) -> Result<(), PatternError> {
        let mut placements: HashMap<usize, Affine3A> = HashMap::new();
        for shape in &scene.shapes {
            if let Some(group) = shape.instance_of {
                let places = shape.placements.as_ref();
                let first = places.and_then(|many| many.places.first().map(|place| Affine3A::from(*place)));
                placements.entry(group).or_insert(first.unwrap_or(shape.to_world));
            }
        }
        for (shape, changed) in scene.shapes.iter().zip(&mut changed.shapes) {
            if shape.shape.is_of_curves() {
                continue;
            }
            let (plain, shape_from_mesh) = unit_form(&shape.shape.kind);
            let placement = shape.member_of.and_then(|group| placements.get(&group));
            let Some(lying) = LyingBox::of(scene, shape, &shape_from_mesh, placement) else {
                continue;
            };
            let Some((mesh, is_flat)) = mesh_of(&plain, self.access) else {
                continue;
            };
            let to_world = shape.to_world * shape_from_mesh;
            let (mirror, to_world) = as_mesh(&plain, to_world);
            let key = format!("{plain:?} {} {mirror}", lying.key());
            let path = match self.meshes.get(&key) {
                Some(path) => path.clone(),
                None => {
                    let no_room =
                        |shortage| PatternError::Picture(format!("a mesh for box projections needs {shortage}"));
                    let laid = lying.laid(&mesh).map_err(no_room)?;
                    let laid = if mirror { mirrored(laid) } else { laid };
                    let path = self.add("box", "ply", &binary_ply(&laid))?;
                    self.meshes.insert(key, path.clone());
                    path
                }
            };
            changed.to_world = to_world;
            changed.shape.kind = ShapeKind::Mesh(MeshFile {
                path,
                format: MeshFormat::Ply,
                shape_index: 0,
                face_normals: is_flat,
                flip_tex_coords: false,
            });
        }
        Ok(())
    }

    fn parameters(&mut self, values: &mut impl Declared) -> Result<(), PatternError> {
        let mut failed = None;
        values.visit_mut(&mut |info, value| {
            let used = match value {
                ParameterMut::Reflectance(_) | ParameterMut::OptionalTexture(_) => Use::Reflectance,
                ParameterMut::TexturedEmission(_) => Use::Light,
                ParameterMut::Normals(_) | ParameterMut::ConductorIor(_) | ParameterMut::Absorption(_) => Use::Values,
                _ => Use::Number,
            };
            value.for_each_texture(info, &mut |_, texture| {
                if has_pattern(texture) {
                    match self.picture(texture, used) {
                        Ok(bitmap) => *texture = Texture::Bitmap(Box::new(bitmap)),
                        Err(reason) => failed = Some(reason),
                    }
                }
            });
        });
        failed.map_or(Ok(()), Err)
    }

    /// The picture of a texture.
    fn picture(&mut self, texture: &Texture, used: Use) -> Result<Bitmap, PatternError> {
        let mut known = self.known.iter();
        if let Some((.., bitmap)) = known.find(|(known, how, _)| *how == used && known == texture) {
            return Ok(bitmap.clone());
        }
        let pixels = u64::from(EDGE) * u64::from(EDGE);
        let _memory =
            memory::reserve(pixels * PIXEL_BYTES).map_err(|shortage| failed(texture, format!("needs {shortage}")))?;
        let tile = Tile::of(texture);
        let values = self.values(texture, tile.as_ref(), used);
        let (coded, format) = coded(&values, used).ok_or_else(|| failed(texture, "is too large".to_owned()))?;
        let mut bytes = Cursor::new(Vec::new());
        let written = coded.write_to(&mut bytes, format);
        written.map_err(|error| failed(texture, format!("cannot be made: {error}")))?;
        let extension = if format == ImageFormat::Png { "png" } else { "exr" };
        let path = self.add("texture", extension, &bytes.into_inner())?;
        let bitmap = Bitmap {
            path,
            filter: TextureFilter::Bilinear,
            wrap: TextureWrap::Repeat,
            wrap_v: None,
            raw: matches!(used, Use::Values | Use::Number),
            to_uv: tile.map_or(Affine2::IDENTITY, |tile| tile.to_uv),
        };
        self.known.push((texture.clone(), used, bitmap.clone()));
        Ok(bitmap)
    }

    /// The values of the pixels, row by row as v grows: over the tile of a box projection, else over the unit square of
    /// uv.
    fn values(&self, texture: &Texture, tile: Option<&Tile>, used: Use) -> Vec<Rgb> {
        let mut textures = Vec::new();
        let id = pack(texture, self.access, &mut textures);
        let table = TextureTable::new(textures);
        let value = |uv: Vec2| {
            let at = TexturePoint::of_uv(uv);
            match used {
                Use::Reflectance | Use::Light | Use::Values => table.color(texture::Parameter::Texture(id), &at),
                Use::Number => Rgb::splat(table.float(texture::Parameter::Texture(id), &at)),
            }
        };
        let of_pixel = |pixel: u32| {
            let at = Vec2::new((pixel % EDGE) as f32 + 0.5, (pixel / EDGE) as f32 + 0.5) / EDGE as f32;
            match tile {
                Some(tile) => tile.value(at, |at| value(tile.place(at))),
                None => value(at),
            }
        };
        (0..EDGE * EDGE).into_par_iter().map(of_pixel).collect()
    }
}

/// The mesh of a shape of unit size, and whether it is shaded with geometric normals. None for shapes without one, and
/// for files that cannot be read.
fn mesh_of(kind: &ShapeKind, access: &Access) -> Option<(Arc<MeshData>, bool)> {
    let ShapeKind::Mesh(file) = kind else {
        let mesh = shape_mesh(kind).filter(|mesh| !mesh.triangles.is_empty())?;
        return Some((Arc::new(mesh), matches!(kind, ShapeKind::Triangle { .. })));
    };
    // Coordinates of the file are not used.
    let loaded = load_mesh(&file.path, access).ok()?;
    let mesh = loaded
        .data(file.shape_index)
        .filter(|mesh| !mesh.triangles.is_empty())?;
    Some((mesh.clone(), file.face_normals))
}

fn failed(texture: &Texture, problem: String) -> PatternError {
    PatternError::Picture(format!("a picture of `{}` {problem}", texture.plugin()))
}

/// The pixels as codes of a file of this format.
fn coded(values: &[Rgb], used: Use) -> Option<(DynamicImage, ImageFormat)> {
    let is_share = |value: &Rgb| (0.0..=1.0).contains(&value.x);
    match used {
        Use::Reflectance => {
            let code = |value: f32| (255.0 * srgb_from_linear(value.clamp(0.0, 1.0))).round() as u8;
            let codes = values.iter().flat_map(|value| value.to_array()).map(code);
            let coded = ImageBuffer::from_raw(EDGE, EDGE, codes.collect()).map(DynamicImage::ImageRgb8)?;
            Some((coded, ImageFormat::Png))
        }
        Use::Number if values.iter().all(is_share) => {
            let code = |value: &Rgb| (65535.0 * value.x).round() as u16;
            let codes = values.iter().map(code).collect();
            let coded = ImageBuffer::from_raw(EDGE, EDGE, codes).map(DynamicImage::ImageLuma16)?;
            Some((coded, ImageFormat::Png))
        }
        Use::Light | Use::Values | Use::Number => {
            let codes = values.iter().flat_map(|value| value.to_array()).collect();
            let coded = ImageBuffer::from_raw(EDGE, EDGE, codes).map(DynamicImage::ImageRgb32F)?;
            Some((coded, ImageFormat::OpenExr))
        }
    }
}

fn has_pattern(texture: &Texture) -> bool {
    let mut found = matches!(texture, Texture::Pattern(_));
    texture.for_each_nested(&mut |nested| found |= has_pattern(nested));
    found
}

/// Adds a texture to the table, after those inside it. A picture that cannot be read is grey, and mesh attributes,
/// which belong to no place of uv, are black.
fn pack(texture: &Texture, access: &Access, textures: &mut Vec<texture::Texture>) -> TextureId {
    let nested = |parameter: &Parameter<Rgb>, textures: &mut Vec<texture::Texture>| match parameter {
        Parameter::Constant(color) => texture::Parameter::Constant(*color),
        Parameter::Texture(inner) => texture::Parameter::Texture(pack(inner, access, textures)),
    };
    let packed = match texture {
        Texture::Bitmap(bitmap) => {
            let image = load_picture(&bitmap.path, access).map(|picture| picture.image);
            texture::Texture::Bitmap(packed_bitmap(
                bitmap,
                image.unwrap_or_else(|_| Arc::new(Image::uniform(0.5))),
            ))
        }
        Texture::Checkerboard { color0, color1, to_uv } => texture::Texture::Checkerboard(Checkerboard {
            colors: [nested(color0, textures), nested(color1, textures)],
            to_uv: **to_uv,
        }),
        Texture::MeshAttribute { name, scale, .. } => texture::Texture::MeshAttribute(texture::MeshAttribute {
            name: name.as_str().into(),
            scale: *scale,
            times: None,
        }),
        Texture::Pattern(pattern) => packed_pattern(pattern, &mut |inner| pack(inner, access, textures)),
    };
    textures.push(packed);
    TextureId(textures.len() as u32 - 1)
}
