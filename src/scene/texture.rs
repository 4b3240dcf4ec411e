//! Textures as the user knows them, and parameters that may be one. They are values: a texture that several materials share is simply
//! the same in each.

use bevy::math::Affine2;
use bevy::prelude::*;

use crate::color::Rgb;

/// A parameter that is the same everywhere, or varies as a texture does.
#[derive(Reflect, Clone, Debug, PartialEq)]
pub enum Parameter<T> {
    Constant(T),
    Texture(Texture),
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
    /// Squares of two colours, two by two per unit of uv.
    Checkerboard {
        color0: Box<Parameter<Rgb>>,
        color1: Box<Parameter<Rgb>>,
        to_uv: Affine2,
    },
}

impl Texture {
    /// The plugin's name in the file.
    pub fn plugin(&self) -> &'static str {
        match self {
            Self::Checkerboard { .. } => "checkerboard",
        }
    }
}
