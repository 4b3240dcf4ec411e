//! A surface in the terms of glTF: metallic-roughness with layers.

use super::level::Level;
use crate::color::Rgb;

/// The parameters of a glTF material. All numbers are from 0 to 1 unless stated.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Look {
    pub base: Level,
    pub opacity: Level,
    pub metallic: Level,
    pub roughness: Level,
    /// The share of transmitted light.
    pub transmission: Level,
    /// Whether transmitted light is refracted, unlike in a pane.
    pub is_thick: bool,
    /// The index of refraction, above 0. Below 1 the outside is denser, which only glass may have.
    pub index: f32,
    /// A factor on the reflectance of dielectrics. At 0 the surface is diffuse.
    pub specular: f32,
    /// The colour of the reflection of dielectrics, over its brightness.
    pub specular_tint: Rgb,
    pub sheen: Rgb,
    /// The stretch of highlights along the first tangent, as `principled` has it.
    pub anisotropic: f32,
    /// The share of matt light that is transmitted.
    pub passing: f32,
    pub clearcoat: Level,
    pub clearcoat_roughness: f32,
    /// The normal map, as raw numbers.
    pub normals: Option<Level>,
    /// Whether normals follow the handedness of texture coordinates, as in glTF, rather than the shading frame.
    pub gltf_tangents: bool,
    pub is_two_sided: bool,
}

/// A surface that is not there: light passes straight through.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Appearance {
    Nothing,
    Surface(Box<Look>),
}

impl Appearance {
    /// Changes the look if it is a surface.
    pub fn changed(self, change: impl FnOnce(Look) -> Look) -> Self {
        match self {
            Self::Nothing => Self::Nothing,
            Self::Surface(look) => Self::Surface(change(*look).into()),
        }
    }
}

impl Look {
    /// A diffuse surface of this colour.
    pub fn matt(base: Level) -> Self {
        Self {
            base,
            opacity: Level::number(1.0),
            metallic: Level::number(0.0),
            roughness: Level::number(1.0),
            transmission: Level::number(0.0),
            is_thick: false,
            index: 1.5,
            specular: 0.0,
            specular_tint: Rgb::ONE,
            sheen: Rgb::ZERO,
            anisotropic: 0.0,
            passing: 0.0,
            clearcoat: Level::number(0.0),
            clearcoat_roughness: 0.0,
            normals: None,
            gltf_tangents: false,
            is_two_sided: false,
        }
    }

    pub fn metal(base: Level, roughness: Level) -> Self {
        Self {
            metallic: Level::number(1.0),
            roughness,
            specular: 1.0,
            ..Self::matt(base)
        }
    }

    /// The look of a pane, whose index, if below 1, is replaced by its inverse: both reflect the same.
    pub fn upright(self) -> Self {
        Self {
            index: self.index.max(self.index.recip()),
            ..self
        }
    }

    pub fn mixed(self, other: Self, weight: f32) -> Self {
        let nearer = |a: f32, b: f32| a + weight * (b - a);
        Self {
            base: self.base.mixed(other.base, weight),
            opacity: self.opacity.mixed(other.opacity, weight),
            metallic: self.metallic.mixed(other.metallic, weight),
            roughness: self.roughness.mixed(other.roughness, weight),
            transmission: self.transmission.mixed(other.transmission, weight),
            is_thick: self.is_thick || other.is_thick,
            index: nearer(self.index, other.index),
            specular: nearer(self.specular, other.specular),
            specular_tint: self.specular_tint.lerp(other.specular_tint, weight),
            sheen: self.sheen.lerp(other.sheen, weight),
            anisotropic: nearer(self.anisotropic, other.anisotropic),
            passing: nearer(self.passing, other.passing),
            clearcoat: self.clearcoat.mixed(other.clearcoat, weight),
            clearcoat_roughness: nearer(self.clearcoat_roughness, other.clearcoat_roughness),
            gltf_tangents: if weight > 0.5 {
                other.gltf_tangents
            } else {
                self.gltf_tangents
            },
            normals: if weight > 0.5 { other.normals } else { self.normals },
            is_two_sided: self.is_two_sided && other.is_two_sided,
        }
    }
}
