//! Evaluates textured parameters: at a surface point, or where all of them are constant.

use crate::color::Rgb;
use crate::shading::{CoatedBase, ConductorSpecular, Microfacet, MicrofacetKind};
use crate::texture::{Parameter, TexturePoint, TextureTable};

/// The microfacets of a rough surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexturedFacets {
    /// The distribution of microfacet normals.
    pub kind: MicrofacetKind,
    /// Roughness along `dp_du`, above 0.
    pub alpha_u: Parameter<f32>,
    /// Roughness along `dp_dv`, above 0.
    pub alpha_v: Parameter<f32>,
}

/// The layer below a coat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexturedBase {
    /// The reflectance of the base, in [0, 1].
    pub diffuse_reflectance: Parameter<Rgb>,
    /// The factor on the coat's reflection; 1 is physical.
    pub specular_reflectance: Parameter<Rgb>,
    /// Whether light takes up the base's colour again at each internal reflection.
    pub nonlinear: bool,
}

/// The reflection of a conductor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexturedSpecular {
    /// The real part of the refractive index relative to the outside.
    pub eta: Parameter<Rgb>,
    /// The imaginary part of it (extinction), positive.
    pub k: Parameter<Rgb>,
    /// The factor on the reflection; 1 is physical.
    pub specular_reflectance: Parameter<Rgb>,
}

/// Evaluates parameters.
pub(super) trait Lookup {
    fn color(&mut self, parameter: Parameter<Rgb>) -> Rgb;
    fn float(&mut self, parameter: Parameter<f32>) -> f32;

    fn reflectance(&mut self, parameter: Parameter<Rgb>) -> Rgb {
        self.color(parameter).clamp(Rgb::ZERO, Rgb::ONE)
    }

    /// The value clamped to [0, 1].
    fn share(&mut self, parameter: Parameter<f32>) -> f32 {
        self.float(parameter).clamp(0.0, 1.0)
    }

    fn specular(&mut self, specular: &TexturedSpecular) -> ConductorSpecular {
        ConductorSpecular {
            eta: self.color(specular.eta).max(Rgb::ZERO),
            k: self.color(specular.k).max(Rgb::ZERO),
            specular_reflectance: self.reflectance(specular.specular_reflectance),
        }
    }

    fn facets(&mut self, facets: &TexturedFacets) -> Microfacet {
        Microfacet::new(facets.kind, self.float(facets.alpha_u), self.float(facets.alpha_v))
    }

    fn base(&mut self, base: &TexturedBase) -> CoatedBase {
        CoatedBase {
            diffuse_reflectance: self.reflectance(base.diffuse_reflectance),
            specular_reflectance: self.reflectance(base.specular_reflectance),
            nonlinear: base.nonlinear,
        }
    }
}

/// Evaluates textures at one surface point.
pub(super) struct At<'a> {
    pub textures: &'a TextureTable,
    pub point: &'a TexturePoint<'a>,
}

impl Lookup for At<'_> {
    fn color(&mut self, parameter: Parameter<Rgb>) -> Rgb {
        self.textures.color(parameter, self.point)
    }

    fn float(&mut self, parameter: Parameter<f32>) -> f32 {
        self.textures.float(parameter, self.point)
    }
}

/// Evaluates constants, and records whether a parameter was textured instead.
#[derive(Default)]
pub(super) struct Constants {
    pub met_texture: bool,
}

impl Lookup for Constants {
    fn color(&mut self, parameter: Parameter<Rgb>) -> Rgb {
        match parameter {
            Parameter::Constant(color) => color,
            Parameter::Texture(_) => {
                self.met_texture = true;
                Rgb::ZERO
            }
        }
    }

    fn float(&mut self, parameter: Parameter<f32>) -> f32 {
        match parameter {
            Parameter::Constant(number) => number,
            Parameter::Texture(_) => {
                self.met_texture = true;
                0.0
            }
        }
    }
}
