//! One material of the scene as one of the renderer: names become numbers, numbers are brought into range.

use super::texture::TexturePacker;
use super::{Checker, STAND_IN_ID};
use crate::color::Rgb;
use crate::material::{self, BumpOptions, MaterialId, TexturedBase, TexturedBsdf, TexturedFacets, TexturedSpecular};
use crate::scene::{Absorption, ConductorIor, Distribution, Ior, Material, Parameter, Roughness};
use crate::shading::{DielectricModel, Fiber, MicrofacetKind, ShadingTables, SmoothCoat, ior, melanin_absorption};
use crate::texture;

/// Largest refractive index or extinction; the highest measured ones in the visible range are below 10.
pub(super) const HIGHEST_IOR: f32 = 100.0;
pub(super) const LOWEST_IOR: f32 = 0.01;

/// Largest absorption coefficient of a hair, factor on it, and concentration of a pigment: blacker than any.
const MOST_ABSORPTION: f32 = 1e6;

/// Packs one material.
pub(super) struct MaterialPacker<'a, 'e, 't> {
    pub model: DielectricModel,
    pub textures: &'a mut TexturePacker<'t>,
    pub tables: &'a mut ShadingTables,
    pub check: Checker<'e>,
}

impl MaterialPacker<'_, '_, '_> {
    pub fn pack(&mut self, material: &Material, nested: [Option<MaterialId>; 2]) -> material::Material {
        let first = |packer: &mut Self| {
            nested[0].unwrap_or_else(|| {
                let plugin = material.plugin();
                packer.check.report(format_args!("`{plugin}` needs a material inside"));
                STAND_IN_ID
            })
        };
        let textured = match material {
            Material::Diffuse { reflectance } => TexturedBsdf::Diffuse {
                reflectance: self.reflectance("reflectance", reflectance),
            },
            Material::Conductor {
                ior,
                specular_reflectance,
            } => TexturedBsdf::Conductor {
                specular: self.conductor(ior, specular_reflectance),
            },
            Material::RoughConductor {
                distribution,
                alpha,
                ior,
                specular_reflectance,
                multiple_scattering,
            } => TexturedBsdf::RoughConductor {
                specular: self.conductor(ior, specular_reflectance),
                facets: self.facets(*distribution, alpha),
                multiple_scattering: multiple_scattering.then(|| self.tables.microalbedo_of(kind(*distribution))),
            },
            Material::Dielectric {
                interior,
                exterior,
                specular_reflectance,
                specular_transmittance,
            } => TexturedBsdf::Dielectric {
                eta: self.eta(interior, "bk7", exterior),
                model: self.model,
                specular_reflectance: self.reflectance("specular_reflectance", specular_reflectance),
                specular_transmittance: self.reflectance("specular_transmittance", specular_transmittance),
            },
            Material::RoughDielectric {
                distribution,
                alpha,
                interior,
                exterior,
                specular_reflectance,
                specular_transmittance,
            } => {
                let eta = self.eta(interior, "bk7", exterior);
                let model = self.model;
                let facets = self.facets(*distribution, alpha);
                let specular_reflectance = self.reflectance("specular_reflectance", specular_reflectance);
                let specular_transmittance = self.reflectance("specular_transmittance", specular_transmittance);
                // Light goes straight through where nothing refracts it, however rough: there is no density.
                if eta == 1.0 {
                    TexturedBsdf::Dielectric {
                        eta,
                        model,
                        specular_reflectance,
                        specular_transmittance,
                    }
                } else {
                    TexturedBsdf::RoughDielectric {
                        eta,
                        model,
                        facets,
                        specular_reflectance,
                        specular_transmittance,
                    }
                }
            }
            Material::ThinDielectric {
                interior,
                exterior,
                specular_reflectance,
                specular_transmittance,
            } => TexturedBsdf::ThinDielectric {
                eta: self.eta(interior, "bk7", exterior),
                model: self.model,
                specular_reflectance: self.reflectance("specular_reflectance", specular_reflectance),
                specular_transmittance: self.reflectance("specular_transmittance", specular_transmittance),
            },
            Material::Plastic {
                interior,
                exterior,
                diffuse_reflectance,
                specular_reflectance,
                nonlinear,
            } => TexturedBsdf::Plastic {
                coat: SmoothCoat::new(self.eta(interior, "polypropylene", exterior)),
                base: self.base(diffuse_reflectance, specular_reflectance, *nonlinear),
            },
            Material::RoughPlastic {
                distribution,
                alpha,
                interior,
                exterior,
                diffuse_reflectance,
                specular_reflectance,
                nonlinear,
            } => {
                if let Roughness::Anisotropic { .. } = alpha {
                    self.check.report("`roughplastic` has one `alpha`: `alpha_u` is taken");
                }
                let TexturedFacets { kind, alpha_u, .. } = self.facets(*distribution, alpha);
                let eta = self.eta(interior, "polypropylene", exterior);
                TexturedBsdf::RoughPlastic {
                    coat: match alpha_u {
                        texture::Parameter::Constant(alpha) => self.tables.uniform_coat(kind, eta, alpha),
                        texture::Parameter::Texture(_) => self.tables.varying_coat(kind, eta),
                    },
                    alpha: alpha_u,
                    base: self.base(diffuse_reflectance, specular_reflectance, *nonlinear),
                }
            }
            Material::Metal { reflectance, fuzz } => TexturedBsdf::Metal {
                reflectance: self.reflectance("reflectance", reflectance),
                fuzz: self.float("fuzz", fuzz, 0.0, 1.0, 0.0),
            },
            Material::Principled(principled) => TexturedBsdf::Principled(self.principled(principled)),
            Material::PrincipledThin(thin) => TexturedBsdf::PrincipledThin(self.principled_thin(thin)),
            Material::Hair {
                absorption,
                longitudinal_roughness,
                azimuthal_roughness,
                scale_tilt,
                interior,
                exterior,
            } => {
                let along = self
                    .check
                    .number("longitudinal_roughness", *longitudinal_roughness, 0.0, 1.0, 0.3);
                let around = self
                    .check
                    .number("azimuthal_roughness", *azimuthal_roughness, 0.0, 1.0, 0.3);
                let tilt = self.check.number("scale_tilt", *scale_tilt, -90.0, 90.0, 2.0);
                let eta = self.eta(interior, "amber", exterior);
                let (sigma_a, scale) = self.absorption(absorption);
                TexturedBsdf::Hair {
                    fiber: Fiber::new(eta, along, around, tilt.to_radians()),
                    sigma_a,
                    scale,
                }
            }
            Material::TwoSided => {
                let front = first(self);
                let back = nested[1].unwrap_or(front);
                return material::Material::TwoSided { front, back };
            }
            Material::Blend { weight } => {
                let first = first(self);
                return material::Material::Blend {
                    first,
                    second: nested[1].unwrap_or(first),
                    weight: self.float("weight", weight, 0.0, 1.0, 0.5),
                };
            }
            Material::Mask { opacity } => {
                return material::Material::Mask {
                    nested: first(self),
                    opacity: self.float("opacity", opacity, 0.0, 1.0, 0.5),
                };
            }
            Material::NormalMap {
                normals,
                flip_invalid_normals,
                use_shadowing_function,
            } => {
                return material::Material::NormalMap {
                    nested: first(self),
                    normals: self.reflectance("normalmap", normals),
                    options: BumpOptions {
                        flip_invalid_normals: *flip_invalid_normals,
                        use_shadowing_function: *use_shadowing_function,
                    },
                };
            }
            Material::BumpMap {
                height,
                scale,
                flip_invalid_normals,
                use_shadowing_function,
            } => {
                return material::Material::BumpMap {
                    nested: first(self),
                    height: self.float("height", height, f32::MIN, f32::MAX, 0.0),
                    scale: self.check.number("scale", *scale, f32::MIN, f32::MAX, 1.0),
                    options: BumpOptions {
                        flip_invalid_normals: *flip_invalid_normals,
                        use_shadowing_function: *use_shadowing_function,
                    },
                };
            }
            Material::Null => return material::Material::Null,
        };
        material::Material::Textured(textured)
    }

    pub(super) fn reflectance(&mut self, name: &str, value: &Parameter<Rgb>) -> texture::Parameter<Rgb> {
        self.color(name, value, 1.0)
    }

    fn color(&mut self, name: &str, value: &Parameter<Rgb>, high: f32) -> texture::Parameter<Rgb> {
        match value {
            Parameter::Constant(color) => texture::Parameter::Constant(self.check.color(name, *color, high)),
            Parameter::Texture(texture) => self.textures.parameter(texture),
        }
    }

    pub(super) fn float(
        &mut self,
        name: &str,
        value: &Parameter<f32>,
        low: f32,
        high: f32,
        otherwise: f32,
    ) -> texture::Parameter<f32> {
        match value {
            Parameter::Constant(number) => {
                texture::Parameter::Constant(self.check.number(name, *number, low, high, otherwise))
            }
            Parameter::Texture(texture) => self.textures.parameter(texture),
        }
    }

    fn facets(&mut self, distribution: Distribution, alpha: &Roughness) -> TexturedFacets {
        let mut one = |name, alpha: &_| self.float(name, alpha, 1e-4, 100.0, 0.1);
        let [alpha_u, alpha_v] = match alpha {
            Roughness::Isotropic(alpha) => [one("alpha", alpha); 2],
            Roughness::Anisotropic { u, v } => [one("alpha_u", u), one("alpha_v", v)],
        };
        TexturedFacets {
            kind: kind(distribution),
            alpha_u,
            alpha_v,
        }
    }

    fn base(&mut self, diffuse: &Parameter<Rgb>, specular: &Parameter<Rgb>, nonlinear: bool) -> TexturedBase {
        TexturedBase {
            diffuse_reflectance: self.reflectance("diffuse_reflectance", diffuse),
            specular_reflectance: self.reflectance("specular_reflectance", specular),
            nonlinear,
        }
    }

    /// The index inside, or else that of `otherwise`, over that outside, or else that of air.
    fn eta(&mut self, interior: &Ior, otherwise: &str, exterior: &Ior) -> f32 {
        index("int_ior", interior, otherwise, &mut self.check) / index("ext_ior", exterior, "air", &mut self.check)
    }

    /// The coefficient, and a factor on it.
    fn absorption(&mut self, absorption: &Absorption) -> (texture::Parameter<Rgb>, f32) {
        match absorption {
            Absorption::Melanin { eumelanin, pheomelanin } => {
                let eumelanin = self.check.number("eumelanin", *eumelanin, 0.0, MOST_ABSORPTION, 1.3);
                let pheomelanin = self
                    .check
                    .number("pheomelanin", *pheomelanin, 0.0, MOST_ABSORPTION, 0.2);
                let sigma_a = melanin_absorption(eumelanin, pheomelanin);
                (texture::Parameter::Constant(sigma_a), 1.0)
            }
            Absorption::Given { sigma_a, scale } => {
                let scale = self.check.number("scale", *scale, 0.0, MOST_ABSORPTION, 1.0);
                (self.color("sigma_a", sigma_a, MOST_ABSORPTION), scale)
            }
        }
    }

    fn conductor(&mut self, ior: &ConductorIor, specular_reflectance: &Parameter<Rgb>) -> TexturedSpecular {
        let (eta, k) = match ior {
            ConductorIor::Named(name) => {
                let (eta, k) = ior::conductor_ior(name).unwrap_or_else(|| {
                    self.check.report(format_args!(
                        "there is no conductor named {name:?}, a perfect mirror is used"
                    ));
                    PERFECT_MIRROR
                });
                (texture::Parameter::Constant(eta), texture::Parameter::Constant(k))
            }
            ConductorIor::Given { eta, k } => (self.color("eta", eta, HIGHEST_IOR), self.color("k", k, HIGHEST_IOR)),
        };
        TexturedSpecular {
            eta,
            k,
            specular_reflectance: self.reflectance("specular_reflectance", specular_reflectance),
        }
    }
}

/// Complex index of a conductor that reflects everything.
pub(super) const PERFECT_MIRROR: (Rgb, Rgb) = (Rgb::ZERO, Rgb::ONE);

fn kind(distribution: Distribution) -> MicrofacetKind {
    match distribution {
        Distribution::Beckmann => MicrofacetKind::Beckmann,
        Distribution::Ggx => MicrofacetKind::Ggx,
    }
}

fn index(what: &str, ior: &Ior, otherwise: &str, check: &mut Checker) -> f32 {
    let fallback = ior::dielectric_ior(otherwise).unwrap_or(1.0);
    match ior {
        Ior::Named(name) => ior::dielectric_ior(name).unwrap_or_else(|| {
            check.report(format_args!(
                "there is no material named {name:?} for {what}, {otherwise} is used"
            ));
            fallback
        }),
        Ior::Number(number) => check.number(what, *number, LOWEST_IOR, HIGHEST_IOR, fallback),
    }
}
