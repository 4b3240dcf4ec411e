//! Packs one material of the scene for the renderer: clamps its numbers to their ranges, and turns names into ids.

use super::texture::TexturePacker;
use super::{Checker, STAND_IN_ID};
use crate::color::Rgb;
use crate::material::{self, BumpOptions, MaterialId, TexturedBase, TexturedBsdf, TexturedFacets, TexturedSpecular};
use crate::scene::{Absorption, ConductorIor, Distribution, Ior, Material, Parameter, Roughness};
use crate::shading::{DielectricModel, Fiber, MicrofacetKind, ShadingTables, SmoothCoat, ior, melanin_absorption};
use crate::texture;

/// Packs one material.
pub(super) struct MaterialPacker<'a, 'e, 't> {
    pub model: DielectricModel,
    pub textures: &'a mut TexturePacker<'t>,
    pub tables: &'a mut ShadingTables,
    pub check: Checker<'e>,
}

impl MaterialPacker<'_, '_, '_> {
    pub fn pack(&mut self, material: &Material, nested: [Option<MaterialId>; 2]) -> material::Material {
        let material = &self.check.material(material);
        let first = |packer: &mut Self| {
            nested[0].unwrap_or_else(|| {
                let plugin = material.plugin();
                packer.check.report(format_args!("`{plugin}` needs a material inside"));
                STAND_IN_ID
            })
        };
        let textured = match material {
            Material::Diffuse { reflectance } => TexturedBsdf::Diffuse {
                reflectance: self.textures.packed(reflectance),
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
                eta: relative_index(interior, exterior),
                model: self.model,
                specular_reflectance: self.textures.packed(specular_reflectance),
                specular_transmittance: self.textures.packed(specular_transmittance),
            },
            Material::RoughDielectric {
                distribution,
                alpha,
                interior,
                exterior,
                specular_reflectance,
                specular_transmittance,
            } => {
                let eta = relative_index(interior, exterior);
                let model = self.model;
                let facets = self.facets(*distribution, alpha);
                let specular_reflectance = self.textures.packed(specular_reflectance);
                let specular_transmittance = self.textures.packed(specular_transmittance);
                // Without refraction light passes straight through, however rough the interface: there is no density.
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
                eta: relative_index(interior, exterior),
                model: self.model,
                specular_reflectance: self.textures.packed(specular_reflectance),
                specular_transmittance: self.textures.packed(specular_transmittance),
            },
            Material::Plastic {
                interior,
                exterior,
                diffuse_reflectance,
                specular_reflectance,
                nonlinear,
            } => TexturedBsdf::Plastic {
                coat: SmoothCoat::new(relative_index(interior, exterior)),
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
                let eta = relative_index(interior, exterior);
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
                reflectance: self.textures.packed(reflectance),
                fuzz: self.textures.packed(fuzz),
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
                let eta = relative_index(interior, exterior);
                let (sigma_a, scale) = self.absorption(absorption);
                TexturedBsdf::Hair {
                    fiber: Fiber::new(
                        eta,
                        *longitudinal_roughness,
                        *azimuthal_roughness,
                        scale_tilt.to_radians(),
                    ),
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
                    weight: self.textures.packed(weight),
                };
            }
            Material::Mask { opacity } => {
                return material::Material::Mask {
                    nested: first(self),
                    opacity: self.textures.packed(opacity),
                };
            }
            Material::NormalMap {
                normals,
                gltf_tangents,
                flip_invalid_normals,
                use_shadowing_function,
            } => {
                return material::Material::NormalMap {
                    nested: first(self),
                    normals: self.textures.packed(normals),
                    gltf_tangents: *gltf_tangents,
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
                    height: self.textures.packed(height),
                    scale: *scale,
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

    fn facets(&mut self, distribution: Distribution, alpha: &Roughness) -> TexturedFacets {
        let [alpha_u, alpha_v] = match alpha {
            Roughness::Isotropic(alpha) => [self.textures.packed(alpha); 2],
            Roughness::Anisotropic { u, v } => [self.textures.packed(u), self.textures.packed(v)],
        };
        TexturedFacets {
            kind: kind(distribution),
            alpha_u,
            alpha_v,
        }
    }

    fn base(&mut self, diffuse: &Parameter<Rgb>, specular: &Parameter<Rgb>, nonlinear: bool) -> TexturedBase {
        TexturedBase {
            diffuse_reflectance: self.textures.packed(diffuse),
            specular_reflectance: self.textures.packed(specular),
            nonlinear,
        }
    }

    /// The absorption coefficient, and a factor on it.
    fn absorption(&mut self, absorption: &Absorption) -> (texture::Parameter<Rgb>, f32) {
        match absorption {
            Absorption::Melanin { eumelanin, pheomelanin } => {
                let sigma_a = melanin_absorption(*eumelanin, *pheomelanin);
                (texture::Parameter::Constant(sigma_a), 1.0)
            }
            Absorption::Given { sigma_a, scale } => (self.textures.packed(sigma_a), *scale),
        }
    }

    fn conductor(&mut self, ior: &ConductorIor, specular_reflectance: &Parameter<Rgb>) -> TexturedSpecular {
        let (eta, k) = match ior {
            ConductorIor::Named(name) => {
                let (eta, k) = ior::conductor_ior(name).unwrap_or(PERFECT_MIRROR);
                (texture::Parameter::Constant(eta), texture::Parameter::Constant(k))
            }
            ConductorIor::Given { eta, k } => (self.textures.packed(eta), self.textures.packed(k)),
        };
        TexturedSpecular {
            eta,
            k,
            specular_reflectance: self.textures.packed(specular_reflectance),
        }
    }
}

/// Complex index of a conductor that reflects all light.
pub(super) const PERFECT_MIRROR: (Rgb, Rgb) = (Rgb::ZERO, Rgb::ONE);

fn kind(distribution: Distribution) -> MicrofacetKind {
    match distribution {
        Distribution::Beckmann => MicrofacetKind::Beckmann,
        Distribution::Ggx => MicrofacetKind::Ggx,
    }
}

/// The refractive index inside over that outside.
fn relative_index(interior: &Ior, exterior: &Ior) -> f32 {
    let index = |ior: &Ior| match ior {
        Ior::Named(name) => ior::dielectric_ior(name).unwrap_or(1.0),
        Ior::Number(index) => *index,
    };
    index(interior) / index(exterior)
}
