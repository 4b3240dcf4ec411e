//! Scattering models with textured parameters, and their evaluation at a surface point.

use super::lookup::{At, Constants, Lookup, TexturedBase, TexturedFacets, TexturedSpecular};
use super::principled::{TexturedPrincipled, TexturedPrincipledThin};
use crate::color::Rgb;
use crate::shading::{
    Bsdf, CoatId, Compensation, Conductor, Dielectric, DielectricModel, Diffuse, Fiber, Hair, Metal, MicroalbedoId,
    Plastic, RoughConductor, RoughDielectric, RoughPlastic, ShadingTables, SmoothCoat, ThinDielectric,
};
use crate::texture::{Parameter, TexturePoint, TextureTable};

/// A model of [`crate::shading`] whose parameters vary over the surface.
#[derive(Clone, Debug, PartialEq)]
pub enum TexturedBsdf {
    /// A textured [`Diffuse`].
    Diffuse {
        /// The reflected fraction of the power, [0, 1].
        reflectance: Parameter<Rgb>,
    },
    /// A textured [`Conductor`].
    Conductor {
        /// The optical constants.
        specular: TexturedSpecular,
    },
    /// A textured [`RoughConductor`].
    RoughConductor {
        /// The optical constants.
        specular: TexturedSpecular,
        /// The distribution and roughness.
        facets: TexturedFacets,
        /// The table for [`RoughConductor::multiple_scattering`].
        multiple_scattering: Option<MicroalbedoId>,
    },
    /// A textured [`Dielectric`].
    Dielectric {
        /// Index inside over that outside.
        eta: f32,
        /// The law of the Fresnel reflectance.
        model: DielectricModel,
        /// The factor on reflected light; 1 is physical.
        specular_reflectance: Parameter<Rgb>,
        /// The factor on transmitted light; 1 is physical.
        specular_transmittance: Parameter<Rgb>,
    },
    /// A textured [`RoughDielectric`].
    RoughDielectric {
        /// The eta of [`RoughDielectric::eta`].
        eta: f32,
        /// The law of the Fresnel reflectance.
        model: DielectricModel,
        /// The distribution and roughness.
        facets: TexturedFacets,
        /// The factor on reflected light; 1 is physical.
        specular_reflectance: Parameter<Rgb>,
        /// The factor on transmitted light; 1 is physical.
        specular_transmittance: Parameter<Rgb>,
    },
    /// A textured [`ThinDielectric`].
    ThinDielectric {
        /// Refractive index of the pane over that around it.
        eta: f32,
        /// The law of the Fresnel reflectance.
        model: DielectricModel,
        /// The factor on reflected light; 1 is physical.
        specular_reflectance: Parameter<Rgb>,
        /// The factor on transmitted light; 1 is physical.
        specular_transmittance: Parameter<Rgb>,
    },
    /// A textured [`Plastic`].
    Plastic {
        /// The coat, which is not textured.
        coat: SmoothCoat,
        /// The base below the coat.
        base: TexturedBase,
    },
    /// A textured [`RoughPlastic`].
    RoughPlastic {
        /// The coat of the constant roughness, or one for all roughnesses.
        coat: CoatId,
        /// Roughness, above 0.
        alpha: Parameter<f32>,
        /// The base below the coat.
        base: TexturedBase,
    },
    /// A textured [`Metal`].
    Metal {
        /// The reflected fraction of the power, [0, 1].
        reflectance: Parameter<Rgb>,
        /// The fuzz, see [`Metal::fuzz`].
        fuzz: Parameter<f32>,
    },
    /// A textured [`crate::shading::Principled`].
    Principled(TexturedPrincipled),
    /// A textured [`crate::shading::PrincipledThin`].
    PrincipledThin(TexturedPrincipledThin),
    /// A textured [`crate::shading::Hair`].
    Hair {
        /// Roughness and refractive index of the fibre, which are not textured.
        fiber: Fiber,
        /// The absorption per radius of the fibre, times `scale`.
        sigma_a: Parameter<Rgb>,
        /// A factor on the absorption, not negative.
        scale: f32,
    },
}

impl TexturedBsdf {
    /// The model at a surface point.
    pub(super) fn at(&self, textures: &TextureTable, point: &TexturePoint) -> Bsdf {
        self.resolve(&mut At { textures, point })
    }

    /// The model, if no parameter is a texture.
    pub(super) fn if_constant(&self) -> Option<Bsdf> {
        let mut constants = Constants::default();
        let bsdf = self.resolve(&mut constants);
        (!constants.met_texture).then_some(bsdf)
    }

    /// Whether light may pass straight through it.
    pub(super) fn has_null_lobe(&self) -> bool {
        matches!(self, Self::ThinDielectric { .. } | Self::Hair { .. })
    }

    /// Whether it has a delta lobe.
    pub(super) fn has_delta_lobe(&self) -> bool {
        match self {
            Self::Conductor { .. }
            | Self::Dielectric { .. }
            | Self::ThinDielectric { .. }
            | Self::Plastic { .. }
            | Self::Metal { .. } => true,
            Self::Diffuse { .. }
            | Self::RoughConductor { .. }
            | Self::RoughDielectric { .. }
            | Self::RoughPlastic { .. }
            | Self::Principled(_)
            | Self::PrincipledThin(_)
            | Self::Hair { .. } => false,
        }
    }

    /// Whether all ids within the model are valid in `tables`.
    pub(super) fn has_its_tables(&self, tables: &ShadingTables) -> bool {
        match self {
            Self::RoughConductor {
                multiple_scattering, ..
            } => multiple_scattering.is_none_or(|table| tables.has_microalbedo(table)),
            Self::RoughPlastic { coat, .. } => tables.has_coat(*coat),
            _ => true,
        }
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
            } => {
                let (specular, distribution) = (lookup.specular(specular), lookup.facets(facets));
                let compensation = |table| Compensation::new(table, &distribution, &specular);
                Bsdf::RoughConductor(RoughConductor {
                    specular,
                    distribution,
                    multiple_scattering: multiple_scattering.map_or(Compensation::NONE, compensation),
                })
            }
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
                coat: *coat,
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
