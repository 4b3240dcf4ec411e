//! The definition of a material: a scattering model, or a combination of other materials.

use bytemuck::{Pod, Zeroable};

use super::bump::BumpOptions;
use super::textured::TexturedBsdf;
use crate::color::Rgb;
use crate::shading::Bsdf;
use crate::texture::Parameter;

/// An index into a [`MaterialTable`](super::MaterialTable).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, Pod, Zeroable)]
#[repr(transparent)]
pub struct MaterialId(pub u32);

/// A material of the scene.
#[derive(Clone, Debug, PartialEq)]
pub enum Material {
    /// A model with constant parameters.
    Plain(Bsdf),
    /// A model with textured parameters.
    Textured(TexturedBsdf),
    /// One material seen from the front and another (or the same, mirrored) from behind.
    TwoSided {
        /// The material on the side that the shading normal points to.
        front: MaterialId,
        /// The material on the other side.
        back: MaterialId,
    },
    /// A mixture of `second` with the weight `weight`, and `first` with the remaining weight.
    Blend {
        /// The material where the weight is 0.
        first: MaterialId,
        /// The material where the weight is 1.
        second: MaterialId,
        /// The weight, clamped to [0, 1].
        weight: Parameter<f32>,
    },
    /// A mask: a share `opacity` of the light meets `nested`; the rest passes through.
    Mask {
        /// The material where the opacity is 1.
        nested: MaterialId,
        /// The opacity, clamped to [0, 1].
        opacity: Parameter<f32>,
    },
    /// A material with the normals of a texture: n = 2 colour - 1 in the shading frame.
    NormalMap {
        /// The material with the new normals.
        nested: MaterialId,
        /// The normals as colours: (1, 1, 2) / 2 is the normal of the surface itself.
        normals: Parameter<Rgb>,
        /// Whether they are in glTF's tangent space, which follows the handedness of texture coordinates, rather than
        /// in the shading frame.
        gltf_tangents: bool,
        /// The treatment of normals that face away and of shadow borders.
        options: BumpOptions,
    },
    /// A material with the normals of the surface after displacement by `scale` times a texture along its own normals
    /// (Blinn, Simulation of Wrinkled Surfaces, 1978).
    BumpMap {
        /// The material with the new normals.
        nested: MaterialId,
        /// The displacement; only bilinear bitmaps have an effect.
        height: Parameter<f32>,
        /// World units per unit of the texture.
        scale: f32,
        /// The treatment of normals that face away and of shadow borders.
        options: BumpOptions,
    },
    /// Light passes as if there were no surface.
    Null,
}

impl From<Bsdf> for Material {
    fn from(bsdf: Bsdf) -> Self {
        Self::Plain(bsdf)
    }
}
