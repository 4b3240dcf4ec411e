//! Scattering models with textured parameters, and their numbers at a place.

use super::lookup::{At, Constants, Lookup, TexturedBase, TexturedFacets, TexturedSpecular};
use super::principled::{TexturedPrincipled, TexturedPrincipledThin};
use crate::color::Rgb;
use crate::shading::{
    Bsdf, Conductor, Dielectric, DielectricModel, Diffuse, Fiber, Hair, Metal, Microalbedo, Plastic, RoughCoat,
    RoughConductor, RoughDielectric, RoughPlastic, SmoothCoat, ThinDielectric,
};
use crate::texture::{Parameter, TexturePoint, TextureTable};

/// A model of [`crate::shading`] whose parameters vary over the surface.
#[derive(Clone, Debug, PartialEq)]
pub enum TexturedBsdf {
    /// As [`Diffuse`].
    Diffuse {
        /// Reflected fraction of the power, [0, 1].
        reflectance: Parameter<Rgb>,
    },
    /// As [`Conductor`].
    Conductor {
        /// The optical constants.
        specular: TexturedSpecular,
    },
    /// As [`RoughConductor`].
    RoughConductor {
        /// The optical constants.
        specular: TexturedSpecular,
        /// Distribution and roughness.
        facets: TexturedFacets,
        /// As [`RoughConductor::multiple_scattering`].
        multiple_scattering: Option<&'static Microalbedo>,
    },
    /// As [`Dielectric`].
    Dielectric {
        /// Index inside over that outside.
        eta: f32,
        /// How the Fresnel reflectance is computed.
        model: DielectricModel,
        /// Multiplies what is reflected; 1 is physical.
        specular_reflectance: Parameter<Rgb>,
        /// Multiplies what passes; 1 is physical.
        specular_transmittance: Parameter<Rgb>,
    },
    /// As [`RoughDielectric`].
    RoughDielectric {
        /// The eta of [`RoughDielectric::eta`].
        eta: f32,
        /// How the Fresnel reflectance is computed.
        model: DielectricModel,
        /// Distribution and roughness.
        facets: TexturedFacets,
        /// Multiplies what is reflected; 1 is physical.
        specular_reflectance: Parameter<Rgb>,
        /// Multiplies what passes; 1 is physical.
        specular_transmittance: Parameter<Rgb>,
    },
    /// As [`ThinDielectric`].
    ThinDielectric {
        /// Index of the pane over that around it.
        eta: f32,
        /// How the Fresnel reflectance is computed.
        model: DielectricModel,
        /// Multiplies what is reflected; 1 is physical.
        specular_reflectance: Parameter<Rgb>,
        /// Multiplies what passes; 1 is physical.
        specular_transmittance: Parameter<Rgb>,
    },
    /// As [`Plastic`].
    Plastic {
        /// The same everywhere.
        coat: SmoothCoat,
        /// What lies below the coat.
        base: TexturedBase,
    },
    /// As [`RoughPlastic`].
    RoughPlastic {
        /// The coat of the constant roughness, or one for any.
        coat: &'static RoughCoat,
        /// Roughness, above 0.
        alpha: Parameter<f32>,
        /// What lies below the coat.
        base: TexturedBase,
    },
    /// As [`Metal`].
    Metal {
        /// Reflected fraction of the power, [0, 1].
        reflectance: Parameter<Rgb>,
        /// As [`Metal::fuzz`].
        fuzz: Parameter<f32>,
    },
    /// As [`crate::shading::Principled`].
    Principled(TexturedPrincipled),
    /// As [`crate::shading::PrincipledThin`].
    PrincipledThin(TexturedPrincipledThin),
    /// As [`crate::shading::Hair`].
    Hair {
        /// Roughness and refractive index of the fibre, the same everywhere.
        fiber: Fiber,
        /// The absorption per radius of the fibre, times `scale`.
        sigma_a: Parameter<Rgb>,
        /// A factor on the absorption, not negative.
        scale: f32,
    },
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
    pub(super) fn has_null_lobe(&self) -> bool {
        matches!(self, Self::ThinDielectric { .. } | Self::Hair { .. })
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
            Self::Hair { fiber, sigma_a, scale } => Bsdf::Hair(Hair {
                fiber: *fiber,
                sigma_a: (*scale * lookup.color(*sigma_a)).max(Rgb::ZERO),
            }),
        }
    }
}
