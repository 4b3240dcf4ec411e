//! The one mapping from the scene's materials to the renderer's scattering models: names become numbers, references become ids.

use std::collections::HashMap;

use bevy::prelude::*;

use super::Checker;
use crate::color::Rgb;
use crate::scene::{ConductorIor, Ior, Material};
use crate::shading::{
    Bsdf, BsdfId, Conductor, ConductorSpecular, Dielectric, DielectricModel, Diffuse, Metal, Microfacet,
    MicrofacetKind, RoughConductor, ior,
};

/// What has no material, or one that makes no sense, looks like this: the format's default.
pub(in crate::engine) const STAND_IN: Bsdf = Bsdf::Diffuse(Diffuse {
    reflectance: Rgb::splat(0.5),
});

/// The stand-in's place in every table.
pub(in crate::engine) const STAND_IN_ID: BsdfId = BsdfId(0);

/// Largest refractive index or extinction; the highest measured ones in the visible range are below 10.
const HIGHEST_IOR: f32 = 100.0;
const LOWEST_IOR: f32 = 0.01;

/// A material entity as extraction finds it.
#[derive(Clone, Debug)]
pub(in crate::engine) struct MaterialSource<'a> {
    pub entity: Entity,
    pub name: String,
    pub material: &'a Material,
    pub first: Option<Entity>,
    pub second: Option<Entity>,
}

/// Scattering models, and which is which material.
#[derive(Clone, Debug, Default)]
pub(in crate::engine) struct PackedMaterials {
    /// The stand-in, then one per source in their order.
    pub bsdfs: Vec<Bsdf>,
    pub ids: HashMap<Entity, BsdfId>,
}

/// Packs all materials of a scene.
pub(in crate::engine) fn pack_materials(
    sources: &[MaterialSource],
    model: DielectricModel,
    errors: &mut Vec<String>,
) -> PackedMaterials {
    let places: HashMap<Entity, usize> = sources
        .iter()
        .enumerate()
        .map(|(i, source)| (source.entity, i))
        .collect();
    let id = |place: usize| BsdfId(place as u32 + 1);
    let mut bsdfs = vec![STAND_IN];
    for source in sources {
        let mut check = Checker {
            name: &source.name,
            errors,
        };
        bsdfs.push(one_sided(source.material, model, &mut check).unwrap_or(STAND_IN));
    }
    // In a second pass, for the sides may come later in the file.
    for (place, source) in sources.iter().enumerate() {
        if *source.material != Material::TwoSided {
            continue;
        }
        let side = |start: Option<Entity>| side_of(start, sources, &places);
        let sides = side(source.first).and_then(|front| match source.second {
            None => Ok((front, front)),
            Some(second) => side(Some(second)).map(|back| (front, back)),
        });
        let packed = match sides {
            Ok((front, back)) => match [front, back].map(|side| bsdfs[side + 1]) {
                [glass @ Bsdf::Dielectric(_), _] | [_, glass @ Bsdf::Dielectric(_)] => {
                    Err(("a transparent material has both its sides already", glass))
                }
                _ => Ok(Bsdf::TwoSided {
                    front: id(front),
                    back: id(back),
                }),
            },
            Err(text) => Err((text, STAND_IN)),
        };
        bsdfs[place + 1] = packed.unwrap_or_else(|(text, instead)| {
            errors.push(format!("{}: {text}", source.name));
            instead
        });
    }
    PackedMaterials {
        bsdfs,
        ids: places.into_iter().map(|(entity, place)| (entity, id(place))).collect(),
    }
}

/// The one-sided material that `start` shows to its front.
fn side_of(
    start: Option<Entity>,
    sources: &[MaterialSource],
    places: &HashMap<Entity, usize>,
) -> Result<usize, &'static str> {
    let mut next = start.ok_or("a two-sided material needs a material inside")?;
    for _ in 0..=sources.len() {
        let &place = places.get(&next).ok_or("the material inside does not exist")?;
        if *sources[place].material != Material::TwoSided {
            return Ok(place);
        }
        next = sources[place]
            .first
            .ok_or("a two-sided material needs a material inside")?;
    }
    Err("two-sided materials contain each other")
}

/// None for a two-sided material.
fn one_sided(material: &Material, model: DielectricModel, check: &mut Checker) -> Option<Bsdf> {
    Some(match material {
        Material::Diffuse { reflectance } => Bsdf::Diffuse(Diffuse {
            reflectance: check.reflectance("reflectance", *reflectance),
        }),
        Material::Conductor {
            ior,
            specular_reflectance,
        } => Bsdf::Conductor(Conductor {
            specular: conductor_specular(ior, *specular_reflectance, check),
        }),
        Material::RoughConductor {
            ior,
            specular_reflectance,
            alpha,
        } => {
            let alpha = check.number("alpha", *alpha, 1e-4, 100.0, 0.1);
            Bsdf::RoughConductor(RoughConductor {
                specular: conductor_specular(ior, *specular_reflectance, check),
                distribution: Microfacet::new(MicrofacetKind::Ggx, alpha, alpha),
                multiple_scattering: None,
            })
        }
        Material::Dielectric {
            interior,
            exterior,
            specular_reflectance,
            specular_transmittance,
        } => Bsdf::Dielectric(Dielectric {
            eta: index("int_ior", interior, "bk7", check) / index("ext_ior", exterior, "air", check),
            model,
            specular_reflectance: check.reflectance("specular_reflectance", *specular_reflectance),
            specular_transmittance: check.reflectance("specular_transmittance", *specular_transmittance),
        }),
        Material::Metal { reflectance, fuzz } => Bsdf::Metal(Metal {
            color: check.reflectance("reflectance", *reflectance),
            fuzz: check.number("fuzz", *fuzz, 0.0, 1.0, 0.0),
        }),
        Material::TwoSided => return None,
    })
}

fn conductor_specular(ior: &ConductorIor, specular_reflectance: Rgb, check: &mut Checker) -> ConductorSpecular {
    let (eta, k) = match ior {
        ConductorIor::Named(name) => ior::conductor_ior(name).unwrap_or_else(|| {
            check.report(format_args!(
                "there is no conductor named {name:?}, a perfect mirror is used"
            ));
            PERFECT_MIRROR
        }),
        ConductorIor::Given { eta, k } => (check.color("eta", *eta, HIGHEST_IOR), check.color("k", *k, HIGHEST_IOR)),
    };
    ConductorSpecular {
        eta,
        k,
        specular_reflectance: check.reflectance("specular_reflectance", specular_reflectance),
    }
}

/// Complex index of a conductor that reflects everything.
pub(super) const PERFECT_MIRROR: (Rgb, Rgb) = (Rgb::ZERO, Rgb::ONE);

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
        let given = ConductorIor::Given { eta: wild, k: wild };
        let materials = [
            Material::Diffuse { reflectance: wild },
            Material::Conductor {
                ior: given.clone(),
                specular_reflectance: wild,
            },
            Material::RoughConductor {
                ior: given,
                specular_reflectance: wild,
                alpha: nan,
            },
            Material::Dielectric {
                interior: Ior::Number(nan),
                exterior: Ior::Number(0.0),
                specular_reflectance: wild,
                specular_transmittance: wild,
            },
            Material::Metal {
                reflectance: wild,
                fuzz: nan,
            },
        ];
        let entities = entities::<5>();
        let sources: Vec<_> = entities
            .iter()
            .zip(&materials)
            .map(|(&e, m)| source(e, m, None, None))
            .collect();
        let mut errors = Vec::new();
        let packed = pack_materials(&sources, DielectricModel::Exact, &mut errors);
        let text = format!("{:?}", packed.bsdfs);
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
            specular_reflectance: Rgb::ONE,
            specular_transmittance: Rgb::ONE,
        };
        let [entity] = entities();
        let mut errors = Vec::new();
        let packed = pack_materials(
            &[source(entity, &glass, None, None)],
            DielectricModel::Schlick,
            &mut errors,
        );
        let Bsdf::Dielectric(packed) = packed.bsdfs[1] else {
            panic!("{packed:?}")
        };
        assert_eq!((packed.eta, packed.model), (1.333, DielectricModel::Schlick));
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
        let packed = pack_materials(&sources, DielectricModel::Exact, &mut errors);
        let (a, b) = (packed.ids[&a], packed.ids[&b]);
        let expected = Bsdf::TwoSided { front: a, back: b };
        assert_eq!(packed.bsdfs[packed.ids[&both].0 as usize], expected);
        let expected = Bsdf::TwoSided { front: b, back: b };
        assert_eq!(packed.bsdfs[packed.ids[&nested].0 as usize], expected);
        assert_eq!(errors, [""; 0]);
        assert!(crate::shading::BsdfTable::new(packed.bsdfs).is_ok());
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
        let packed = pack_materials(&sources, DielectricModel::Exact, &mut errors);
        assert_eq!(packed.bsdfs, [STAND_IN; 5]);
        assert_eq!(errors.len(), 4, "{errors:?}");
    }
}
