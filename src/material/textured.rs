//! Scattering models with textured parameters, and their numbers at a place.

use super::principled::{TexturedPrincipled, TexturedPrincipledThin};
use crate::color::Rgb;
use crate::shading::{
    Bsdf, CoatedBase, Conductor, ConductorSpecular, Dielectric, DielectricModel, Diffuse, Metal, Microalbedo,
    Microfacet, MicrofacetKind, Plastic, RoughCoat, RoughConductor, RoughDielectric, RoughPlastic, SmoothCoat,
    ThinDielectric,
};
use crate::texture::{Parameter, TexturePoint, TextureTable};

/// A model of [`crate::shading`] whose parameters vary over the surface.
#[derive(Clone, Debug, PartialEq)]
pub enum TexturedBsdf {
    Diffuse {
        reflectance: Parameter<Rgb>,
    },
    Conductor {
        specular: TexturedSpecular,
    },
    RoughConductor {
        specular: TexturedSpecular,
        facets: TexturedFacets,
        multiple_scattering: Option<&'static Microalbedo>,
    },
    Dielectric {
        /// Index inside over that outside.
        eta: f32,
        model: DielectricModel,
        specular_reflectance: Parameter<Rgb>,
        specular_transmittance: Parameter<Rgb>,
    },
    RoughDielectric {
        /// As in [`RoughDielectric::eta`].
        eta: f32,
        model: DielectricModel,
        facets: TexturedFacets,
        specular_reflectance: Parameter<Rgb>,
        specular_transmittance: Parameter<Rgb>,
    },
    ThinDielectric {
        /// Index of the pane over that around it.
        eta: f32,
        model: DielectricModel,
        specular_reflectance: Parameter<Rgb>,
        specular_transmittance: Parameter<Rgb>,
    },
    Plastic {
        coat: SmoothCoat,
        base: TexturedBase,
    },
    RoughPlastic {
        /// Of the constant roughness, or one for any.
        coat: &'static RoughCoat,
        alpha: Parameter<f32>,
        base: TexturedBase,
    },
    Metal {
        reflectance: Parameter<Rgb>,
        fuzz: Parameter<f32>,
    },
    Principled(TexturedPrincipled),
    PrincipledThin(TexturedPrincipledThin),
}

/// A rough surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexturedFacets {
    pub kind: MicrofacetKind,
    pub alpha_u: Parameter<f32>,
    pub alpha_v: Parameter<f32>,
}

/// What is below a coat.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexturedBase {
    pub diffuse_reflectance: Parameter<Rgb>,
    pub specular_reflectance: Parameter<Rgb>,
    pub nonlinear: bool,
}

/// A conductor's reflection.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexturedSpecular {
    pub eta: Parameter<Rgb>,
    pub k: Parameter<Rgb>,
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
struct At<'a> {
    textures: &'a TextureTable,
    point: &'a TexturePoint<'a>,
}

impl Lookup for At<'_> {
    fn color(&mut self, parameter: Parameter<Rgb>) -> Rgb {
        self.textures.color(parameter, self.point)
    }

    fn float(&mut self, parameter: Parameter<f32>) -> f32 {
        self.textures.float(parameter, self.point)
    }
}

/// Finds out whether there is a texture at all.
#[derive(Default)]
struct Constants {
    met_texture: bool,
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

impl TexturedBsdf {
    /// The model at a place.
    pub(super) fn at(&self, textures: &TextureTable, point: &TexturePoint) -> Bsdf {
        self.resolve(&mut At { textures, point })
    }

    /// The model, if no parameter is a texture.
    pub(super) fn if_constant(&self) -> Option<Bsdf> {
        let mut constants = Constants::default();
        let bsdf = self.resolve(&mut constants);
        (!constants.met_texture).then_some(bsdf)
    }

    /// Whether light may pass straight through it somewhere.
    pub(super) fn lets_through(&self) -> bool {
        matches!(self, Self::ThinDielectric { .. })
    }

    fn resolve(&self, lookup: &mut impl Lookup) -> Bsdf {
        match self {
            Self::Diffuse { reflectance } => Bsdf::Diffuse(Diffuse {
                reflectance: lookup.reflectance(*reflectance),
            }),
            Self::Conductor { specular } => Bsdf::Conductor(Conductor {
                specular: lookup.specular(specular),
            }),
            Self::RoughConductor {
                specular,
                facets,
                multiple_scattering,
            } => Bsdf::RoughConductor(RoughConductor {
                specular: lookup.specular(specular),
                distribution: lookup.facets(facets),
                multiple_scattering: *multiple_scattering,
            }),
            Self::Dielectric {
                eta,
                model,
                specular_reflectance,
                specular_transmittance,
            } => Bsdf::Dielectric(Dielectric {
                eta: *eta,
                model: *model,
                specular_reflectance: lookup.reflectance(*specular_reflectance),
                specular_transmittance: lookup.reflectance(*specular_transmittance),
            }),
            Self::RoughDielectric {
                eta,
                model,
                facets,
                specular_reflectance,
                specular_transmittance,
            } => Bsdf::RoughDielectric(RoughDielectric {
                eta: *eta,
                model: *model,
                distribution: lookup.facets(facets),
                specular_reflectance: lookup.reflectance(*specular_reflectance),
                specular_transmittance: lookup.reflectance(*specular_transmittance),
            }),
            Self::ThinDielectric {
                eta,
                model,
                specular_reflectance,
                specular_transmittance,
            } => Bsdf::ThinDielectric(ThinDielectric {
                eta: *eta,
                model: *model,
                specular_reflectance: lookup.reflectance(*specular_reflectance),
                specular_transmittance: lookup.reflectance(*specular_transmittance),
            }),
            Self::Plastic { coat, base } => Bsdf::Plastic(Plastic {
                coat: *coat,
                base: lookup.base(base),
            }),
            Self::RoughPlastic { coat, alpha, base } => Bsdf::RoughPlastic(RoughPlastic {
                coat,
                alpha: lookup.float(*alpha),
                base: lookup.base(base),
            }),
            Self::Metal { reflectance, fuzz } => Bsdf::Metal(Metal {
                color: lookup.reflectance(*reflectance),
                fuzz: lookup.share(*fuzz),
            }),
            Self::Principled(principled) => Bsdf::Principled(principled.resolve(lookup)),
            Self::PrincipledThin(thin) => Bsdf::PrincipledThin(thin.resolve(lookup)),
        }
    }
}
