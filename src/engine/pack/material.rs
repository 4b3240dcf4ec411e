//! The one mapping from the scene's materials to the renderer's scattering models: names become numbers, references become ids.

use std::collections::HashMap;

use bevy::prelude::*;

use super::Checker;
use super::texture::TexturePacker;
use crate::color::Rgb;
use crate::material::{self, BumpOptions, MaterialId, TexturedBase, TexturedBsdf, TexturedFacets, TexturedSpecular};
use crate::scene::{ConductorIor, Distribution, Ior, Material, Parameter, Roughness};
use crate::shading::{Bsdf, DielectricModel, Diffuse, Microalbedo, MicrofacetKind, RoughCoat, SmoothCoat, ior};
use crate::texture;

/// What has no material, or one that makes no sense, looks like this: the format's default.
pub(in crate::engine) const STAND_IN: material::Material = material::Material::Plain(Bsdf::Diffuse(Diffuse {
    reflectance: Rgb::splat(0.5),
}));

/// A light that has no material reflects nothing: so the format has it.
const LAMP: material::Material = material::Material::Plain(Bsdf::Diffuse(Diffuse { reflectance: Rgb::ZERO }));

/// What every table begins with, and the places of these.
const FIXED: [material::Material; 2] = [STAND_IN, LAMP];
pub(in crate::engine) const STAND_IN_ID: MaterialId = MaterialId(0);
pub(in crate::engine) const LAMP_ID: MaterialId = MaterialId(1);

/// Largest refractive index or extinction; the highest measured ones in the visible range are below 10.
pub(super) const HIGHEST_IOR: f32 = 100.0;
pub(super) const LOWEST_IOR: f32 = 0.01;

/// A material entity as extraction finds it.
#[derive(Clone, Debug)]
pub(in crate::engine) struct MaterialSource<'a> {
    pub entity: Entity,
    pub name: String,
    pub material: &'a Material,
    pub first: Option<Entity>,
    pub second: Option<Entity>,
}

/// The renderer's materials, and which is which entity.
#[derive(Clone, Debug, Default)]
pub(in crate::engine) struct PackedMaterials {
    /// The fixed ones, then one per source in their order.
    pub materials: Vec<material::Material>,
    pub ids: HashMap<Entity, MaterialId>,
}

/// Packs all materials of a scene.
pub(in crate::engine) fn pack_materials(
    sources: &[MaterialSource],
    model: DielectricModel,
    textures: &mut TexturePacker,
    errors: &mut Vec<String>,
) -> PackedMaterials {
    let places: HashMap<Entity, usize> = sources
        .iter()
        .enumerate()
        .map(|(i, source)| (source.entity, i))
        .collect();
    let id = |place: usize| MaterialId((place + FIXED.len()) as u32);
    let mut materials = FIXED.to_vec();
    for source in sources {
        let mut nested = [source.first, source.second]
            .into_iter()
            .flatten()
            .map(|entity| places.get(&entity).copied().map(id));
        let mut packer = MaterialPacker {
            model,
            textures,
            check: Checker {
                name: &source.name,
                errors,
            },
        };
        let sides = [nested.next().flatten(), nested.next().flatten()];
        materials.push(packer.pack(source.material, sides));
    }
    for (place, source) in sources.iter().enumerate() {
        if contains_itself(place, sources, &places) {
            errors.push(format!("{}: materials contain each other", source.name));
            materials[place + FIXED.len()] = STAND_IN;
        }
    }
    PackedMaterials {
        materials,
        ids: places.into_iter().map(|(entity, place)| (entity, id(place))).collect(),
    }
}

fn contains_itself(start: usize, sources: &[MaterialSource], places: &HashMap<Entity, usize>) -> bool {
    let nested = |place: usize| {
        let source = &sources[place];
        let used = source.material.nested_count().end().min(&2).to_owned();
        [source.first, source.second]
            .into_iter()
            .flatten()
            .take(used)
            .filter_map(|entity| places.get(&entity).copied())
    };
    let mut waiting: Vec<usize> = nested(start).collect();
    let mut seen = vec![false; sources.len()];
    while let Some(place) = waiting.pop() {
        if place == start {
            return true;
        }
        if !std::mem::replace(&mut seen[place], true) {
            waiting.extend(nested(place));
        }
    }
    false
}

/// Packs one material.
pub(super) struct MaterialPacker<'a, 'e, 't> {
    model: DielectricModel,
    textures: &'a mut TexturePacker<'t>,
    pub(super) check: Checker<'e>,
}

impl MaterialPacker<'_, '_, '_> {
    fn pack(&mut self, material: &Material, nested: [Option<MaterialId>; 2]) -> material::Material {
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
                multiple_scattering: multiple_scattering.then(|| Microalbedo::of(kind(*distribution))),
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
                        texture::Parameter::Constant(alpha) => RoughCoat::uniform(kind, eta, alpha),
                        texture::Parameter::Texture(_) => RoughCoat::varying(kind, eta),
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

#[cfg(test)]
mod tests {
    use super::*;

    fn source(
        entity: Entity,
        material: &Material,
        first: Option<Entity>,
        second: Option<Entity>,
    ) -> MaterialSource<'_> {
        MaterialSource {
            entity,
            name: format!("{entity}"),
            material,
            first,
            second,
        }
    }

    fn entities<const N: usize>() -> [Entity; N] {
        let mut world = World::new();
        std::array::from_fn(|_| world.spawn_empty().id())
    }

    #[test]
    fn nothing_that_is_no_number_gets_in() {
        let nan = f32::NAN;
        let wild = Rgb::new(nan, f32::INFINITY, -1.0);
        let given = ConductorIor::Given {
            eta: wild.into(),
            k: wild.into(),
        };
        let materials = [
            Material::Diffuse {
                reflectance: wild.into(),
            },
            Material::Conductor {
                ior: given.clone(),
                specular_reflectance: wild.into(),
            },
            Material::RoughConductor {
                ior: given,
                specular_reflectance: wild.into(),
                alpha: Roughness::Isotropic(nan.into()),
                distribution: Distribution::Ggx,
                multiple_scattering: true,
            },
            Material::Dielectric {
                interior: Ior::Number(nan),
                exterior: Ior::Number(0.0),
                specular_reflectance: wild.into(),
                specular_transmittance: wild.into(),
            },
            Material::Metal {
                reflectance: wild.into(),
                fuzz: nan.into(),
            },
        ];
        let entities = entities::<5>();
        let sources: Vec<_> = entities
            .iter()
            .zip(&materials)
            .map(|(&e, m)| source(e, m, None, None))
            .collect();
        let mut errors = Vec::new();
        let packed = pack_materials(
            &sources,
            DielectricModel::Exact,
            &mut TexturePacker::new(&|_| None),
            &mut errors,
        );
        let text = format!("{:?}", packed.materials);
        assert!(!text.contains("NaN") && !text.contains("inf"), "{text}");
        assert!(!text.contains('-'), "{text}");
        for (entity, parameters) in entities.iter().zip([1, 3, 4, 4, 2]) {
            let name = format!("{entity}: ");
            assert_eq!(
                errors.iter().filter(|error| error.starts_with(&name)).count(),
                parameters,
                "{errors:?}"
            );
        }
    }

    #[test]
    fn names_become_indices() {
        let glass = Material::Dielectric {
            interior: Ior::Named("water".into()),
            exterior: Ior::Named("vacuum".into()),
            specular_reflectance: Rgb::ONE.into(),
            specular_transmittance: Rgb::ONE.into(),
        };
        let [entity] = entities();
        let mut errors = Vec::new();
        let packed = pack_materials(
            &[source(entity, &glass, None, None)],
            DielectricModel::Schlick,
            &mut TexturePacker::new(&|_| None),
            &mut errors,
        );
        let material::Material::Textured(TexturedBsdf::Dielectric { eta, model, .. }) = packed.materials[FIXED.len()]
        else {
            panic!("{packed:?}")
        };
        assert_eq!((eta, model), (1.333, DielectricModel::Schlick));
        assert_eq!(errors, [""; 0]);
    }

    #[test]
    fn two_sided_materials_refer_to_their_sides() {
        let (diffuse, two_sided) = (Material::default(), Material::TwoSided);
        let [a, b, both, nested] = entities();
        let sources = [
            source(both, &two_sided, Some(a), Some(nested)),
            source(a, &diffuse, None, None),
            source(nested, &two_sided, Some(b), None),
            source(b, &diffuse, None, None),
        ];
        let mut errors = Vec::new();
        let packed = pack_materials(
            &sources,
            DielectricModel::Exact,
            &mut TexturePacker::new(&|_| None),
            &mut errors,
        );
        let (a, b) = (packed.ids[&a], packed.ids[&b]);
        let expected = material::Material::TwoSided {
            front: a,
            back: packed.ids[&nested],
        };
        assert_eq!(packed.materials[packed.ids[&both].0 as usize], expected);
        let expected = material::Material::TwoSided { front: b, back: b };
        assert_eq!(packed.materials[packed.ids[&nested].0 as usize], expected);
        assert_eq!(errors, [""; 0]);
        assert!(material::MaterialTable::new(packed.materials).is_ok());
    }

    #[test]
    fn circles_and_holes_are_replaced_and_reported() {
        let two_sided = Material::TwoSided;
        let [a, b, empty, missing] = entities();
        let sources = [
            source(a, &two_sided, Some(b), None),
            source(b, &two_sided, Some(a), None),
            source(empty, &two_sided, None, None),
            source(missing, &two_sided, Some(Entity::PLACEHOLDER), None),
        ];
        let mut errors = Vec::new();
        let packed = pack_materials(
            &sources,
            DielectricModel::Exact,
            &mut TexturePacker::new(&|_| None),
            &mut errors,
        );
        let grey = material::Material::TwoSided {
            front: STAND_IN_ID,
            back: STAND_IN_ID,
        };
        let expected = [&STAND_IN, &LAMP, &STAND_IN, &STAND_IN, &grey, &grey];
        assert!(packed.materials.iter().eq(expected), "{:?}", packed.materials);
        assert_eq!(errors.len(), 4, "{errors:?}");
    }
}
