//! The definition of a material: a model, or other materials.

use super::bump::BumpOptions;
use super::textured::TexturedBsdf;
use crate::color::Rgb;
use crate::shading::Bsdf;
use crate::texture::Parameter;

/// An index into a [`MaterialTable`](super::MaterialTable).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MaterialId(pub u32);

/// A material of the scene.
#[derive(Clone, Debug, PartialEq)]
pub enum Material {
    /// The same everywhere.
    Plain(Bsdf),
    Textured(TexturedBsdf),
    /// One material seen from the normal's side and another (or the same, mirrored) from behind.
    TwoSided {
        front: MaterialId,
        back: MaterialId,
    },
    /// `second` with the share `weight`, `first` with the rest.
    Blend {
        first: MaterialId,
        second: MaterialId,
        weight: Parameter<f32>,
    },
    /// `nested` with the share `opacity`; the rest of the light passes through.
    Mask {
        nested: MaterialId,
        opacity: Parameter<f32>,
    },
    /// `nested` about the normals of a texture: n = 2 colour - 1 in the shading frame.
    NormalMap {
        nested: MaterialId,
        normals: Parameter<Rgb>,
        options: BumpOptions,
    },
    /// `nested` about the normals that the surface has once it is moved by `scale` times a texture along its own (Blinn, Simulation of
    /// Wrinkled Surfaces, 1978).
    BumpMap {
        nested: MaterialId,
        height: Parameter<f32>,
        scale: f32,
        options: BumpOptions,
    },
    /// Light passes as if nothing were there.
    Null,
}

impl From<Bsdf> for Material {
    fn from(bsdf: Bsdf) -> Self {
        Self::Plain(bsdf)
    }
}
