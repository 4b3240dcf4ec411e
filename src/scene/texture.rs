//! Textures as the user knows them, and parameters that may be one. They are values: a texture that several materials share is simply
//! the same in each.

use std::path::PathBuf;

use bevy::math::Affine2;
use bevy::prelude::*;

use crate::color::Rgb;

/// A parameter that is the same everywhere, or varies as a texture does.
#[derive(Reflect, Clone, Debug, PartialEq)]
pub enum Parameter<T> {
    Constant(T),
    Texture(Texture),
}

impl<T> Parameter<T> {
    /// The picture at `path` instead.
    pub fn set_picture(&mut self, path: PathBuf) {
        let before = match self {
            Self::Constant(_) => None,
            Self::Texture(texture) => Some(&*texture),
        };
        *self = Self::Texture(Texture::of_picture(path, before));
    }
}

impl<T: Copy> Parameter<T> {
    /// The value, if it is the same everywhere.
    pub fn constant(&self) -> Option<T> {
        match self {
            Self::Constant(value) => Some(*value),
            Self::Texture(_) => None,
        }
    }
}

impl From<Rgb> for Parameter<Rgb> {
    fn from(color: Rgb) -> Self {
        Self::Constant(color)
    }
}

impl From<f32> for Parameter<f32> {
    fn from(number: f32) -> Self {
        Self::Constant(number)
    }
}

/// A texture of the scene file.
#[derive(Reflect, Clone, Debug, PartialEq)]
#[reflect(opaque)]
#[reflect(Clone, PartialEq)]
pub enum Texture {
    /// A picture over uv.
    Bitmap(Bitmap),
    /// Squares of two colours, two by two per unit of uv.
    Checkerboard {
        color0: Box<Parameter<Rgb>>,
        color1: Box<Parameter<Rgb>>,
        to_uv: Affine2,
    },
    /// A value that the mesh itself has per vertex or face.
    MeshAttribute {
        /// `vertex_color`, `face_...`: what the mesh's loader calls it.
        name: String,
        scale: f32,
    },
}

/// A picture and how it is looked at.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Bitmap {
    /// Absolute path.
    pub path: PathBuf,
    pub filter: TextureFilter,
    pub wrap: TextureWrap,
    /// Numbers as they stand in the file, not decoded to linear.
    pub raw: bool,
    pub to_uv: Affine2,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TextureFilter {
    Nearest,
    #[default]
    Bilinear,
}

/// What lies outside of the unit square.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TextureWrap {
    #[default]
    Repeat,
    Mirror,
    Clamp,
}

impl Texture {
    /// A picture, looked at as the one before it if there was one.
    pub fn of_picture(path: PathBuf, before: Option<&Self>) -> Self {
        let looks = match before {
            Some(Self::Bitmap(bitmap)) => bitmap.clone(),
            _ => Bitmap::default(),
        };
        Self::Bitmap(Bitmap { path, ..looks })
    }

    /// The plugin's name in the file.
    pub fn plugin(&self) -> &'static str {
        match self {
            Self::Bitmap(_) => "bitmap",
            Self::Checkerboard { .. } => "checkerboard",
            Self::MeshAttribute { .. } => "mesh_attribute",
        }
    }

    /// Calls `meet` with every picture, also of textures inside this one.
    pub fn for_each_bitmap(&self, meet: &mut impl FnMut(&Bitmap)) {
        match self {
            Self::Bitmap(bitmap) => meet(bitmap),
            Self::Checkerboard { color0, color1, .. } => {
                for color in [color0, color1] {
                    if let Parameter::Texture(texture) = &**color {
                        texture.for_each_bitmap(meet);
                    }
                }
            }
            Self::MeshAttribute { .. } => {}
        }
    }
}
