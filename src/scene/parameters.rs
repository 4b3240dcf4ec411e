//! The kinds of parameters that materials have, and the visitor that meets them.

use std::ops::RangeInclusive;

use bevy::prelude::*;

use super::texture::Parameter;
use crate::color::Rgb;

/// Meets the parameters of a material in turn; names are those of the file. A parameter that a visitor leaves alone keeps its value,
/// which in a fresh material is the format's default.
pub trait ParameterVisitor {
    /// A share of the light, 0 to 1.
    fn reflectance(&mut self, name: &'static str, value: &mut Parameter<Rgb>);
    /// A colour that is not a direction's: it is not negative, and has no upper bound.
    fn color(&mut self, name: &'static str, value: &mut Parameter<Rgb>);
    fn float(&mut self, name: &'static str, value: &mut Parameter<f32>, range: RangeInclusive<f32>);
    /// A height in units of the scene: a texture, to which the format gives no name ([`HEIGHT`] in files that are written).
    fn height(&mut self, value: &mut Parameter<f32>) {
        self.float(HEIGHT, value, -f32::MAX..=f32::MAX);
    }
    /// A number that is the same everywhere.
    fn number(&mut self, name: &'static str, value: &mut f32, range: RangeInclusive<f32>);
    fn flag(&mut self, name: &'static str, value: &mut bool);
    /// A flag of ours, which no other program knows: off by default, and written only where it is on.
    fn extension(&mut self, name: &'static str, value: &mut bool) {
        self.flag(name, value);
    }
    fn ior(&mut self, name: &'static str, value: &mut Ior);
    /// `material`, or `eta` and `k`.
    fn conductor_ior(&mut self, value: &mut ConductorIor);
    /// `distribution`
    fn distribution(&mut self, value: &mut Distribution);
    /// `alpha`, or `alpha_u` and `alpha_v`.
    fn roughness(&mut self, value: &mut Roughness);
    /// `specular` or `eta`.
    fn principled_index(&mut self, value: &mut PrincipledIndex);
}

/// The name of a bump map's texture where the file gives none.
pub const HEIGHT: &str = "height";
/// The texture of a normal map.
pub const NORMALS: &str = "normalmap";

/// Complex index of refraction of a conductor, per colour channel.
#[derive(Reflect, Clone, Debug, PartialEq)]
pub enum ConductorIor {
    /// `Au`, `Cu`, ...; `none` is a perfect mirror.
    Named(String),
    Given {
        eta: Parameter<Rgb>,
        k: Parameter<Rgb>,
    },
}

/// Index of refraction of a dielectric.
#[derive(Reflect, Clone, Debug, PartialEq)]
pub enum Ior {
    /// `water`, `bk7`, ...
    Named(String),
    Number(f32),
}

/// The distribution of the normals of a rough surface's facets.
#[derive(Reflect, Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distribution {
    Beckmann,
    Ggx,
}

/// Width of the distribution of slopes (not its square root), above 0.
#[derive(Reflect, Clone, Debug, PartialEq)]
pub enum Roughness {
    Isotropic(Parameter<f32>),
    /// The roughness along each of the two tangents.
    Anisotropic {
        u: Parameter<f32>,
        v: Parameter<f32>,
    },
}

impl Default for Roughness {
    fn default() -> Self {
        Self::Isotropic(0.1.into())
    }
}

/// The reflectance of a principled surface at normal incidence.
#[derive(Reflect, Clone, Copy, Debug, PartialEq)]
pub enum PrincipledIndex {
    /// The reflectance over 0.08, in [0, 1].
    Specular(f32),
    /// Refractive index inside over outside, above 0.
    Eta(f32),
}

impl Default for PrincipledIndex {
    fn default() -> Self {
        Self::Specular(0.5)
    }
}
