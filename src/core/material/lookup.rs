//! Looks up textured parameters: at a place, or those that are the same everywhere.

use crate::color::Rgb;
use crate::shading::{CoatedBase, ConductorSpecular, Microfacet, MicrofacetKind};
use crate::texture::{Parameter, TexturePoint, TextureTable};

/// A rough surface.
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
    /// Multiplies what the coat reflects; 1 is physical.
    pub specular_reflectance: Parameter<Rgb>,
    /// Whether light that is scattered again takes up the base's colour each time.
    pub nonlinear: bool,
}

/// A conductor's reflection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexturedSpecular {
    /// The real part of the refractive index relative to the outside.
    pub eta: Parameter<Rgb>,
    /// The imaginary part of it (extinction), positive.
    pub k: Parameter<Rgb>,
    /// Multiplies the reflection; 1 is physical.
    pub specular_reflectance: Parameter<Rgb>,
}

/// Gives the numbers of parameters.
pub(super) trait Lookup {
    fn color(&mut self, parameter: Parameter<Rgb>) -> Rgb;
    fn float(&mut self, parameter: Parameter<f32>) -> f32;

    fn reflectance(&mut self, parameter: Parameter<Rgb>) -> Rgb {
        self.color(parameter).clamp(Rgb::ZERO, Rgb::ONE)
    }

    /// A number in [0, 1].
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

/// Looks textures up at one place.
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

/// A lookup that finds out whether there is a texture at all.
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
