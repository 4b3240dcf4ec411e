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
    /// A model whose parameters vary over the surface.
    Textured(TexturedBsdf),
    /// One material seen from the normal's side and another (or the same, mirrored) from behind.
    TwoSided {
        /// Seen from the side that the shading normal points to.
        front: MaterialId,
        /// Seen from the other side.
        back: MaterialId,
    },
    /// `second` with the share `weight`, `first` with the rest.
    Blend {
        /// What there is where the weight is 0.
        first: MaterialId,
        /// What there is where the weight is 1.
        second: MaterialId,
        /// Clamped to [0, 1].
        weight: Parameter<f32>,
    },
    /// `nested` with the share `opacity`; the rest of the light passes through.
    Mask {
        /// What there is where the opacity is 1.
        nested: MaterialId,
        /// Clamped to [0, 1].
        opacity: Parameter<f32>,
    },
    /// `nested` about the normals of a texture: n = 2 colour - 1 in the shading frame.
    NormalMap {
        /// What is seen about the new normals.
        nested: MaterialId,
        /// The colour (1, 1, 2) / 2 stands for the normal of the surface itself.
        normals: Parameter<Rgb>,
        /// How normals that face away and shadow borders are treated.
        options: BumpOptions,
    },
    /// `nested` about the normals that the surface has once it is moved by `scale` times a texture along its own (Blinn, Simulation of
    /// Wrinkled Surfaces, 1978).
    BumpMap {
        /// What is seen about the new normals.
        nested: MaterialId,
        /// Only bilinear bitmaps have an effect.
        height: Parameter<f32>,
        /// World units per unit of the texture.
        scale: f32,
        /// How normals that face away and shadow borders are treated.
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
