//! Packs the list of the scene's materials for the renderer: references become ids. `bsdf.rs` packs each of them.

use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;

use super::Checker;
use super::bsdf::MaterialPacker;
use super::texture::TexturePacker;
use crate::color::Rgb;
use crate::material::{self, MaterialId, MaterialTable};
use crate::scene::Material;
use crate::shading::{Bsdf, DielectricModel, Diffuse, ShadingTables};
use crate::texture::TextureTable;

/// The look of shapes without a material, or with an invalid one: the format's default.
pub(in crate::engine) const STAND_IN: material::Material = material::Material::Plain(Bsdf::Diffuse(Diffuse {
    reflectance: Rgb::splat(0.5),
}));

/// A light without a material reflects nothing, as in the format.
const LAMP: material::Material = material::Material::Plain(Bsdf::Diffuse(Diffuse { reflectance: Rgb::ZERO }));

/// The first materials of every table, see `STAND_IN_ID` and `LAMP_ID`.
const FIXED: [material::Material; 2] = [STAND_IN, LAMP];

/// A material entity as read by extraction.
#[derive(Clone, Debug)]
pub(in crate::engine) struct MaterialSource<'a> {
    pub entity: Entity,
    pub name: String,
    pub material: &'a Material,
    pub first: Option<Entity>,
    pub second: Option<Entity>,
}

/// The renderer's materials, and the id of each entity.
#[derive(Clone, Debug, Default)]
pub(in crate::engine) struct PackedMaterials {
    /// The fixed ones, then one per source in their order.
    pub materials: Vec<material::Material>,
    /// The tables to which models of `materials` refer.
    pub tables: ShadingTables,
    pub ids: EntityHashMap<MaterialId>,
}

/// Packs all materials of a scene.
pub(in crate::engine) fn pack_materials(
    sources: &[MaterialSource],
    model: DielectricModel,
    textures: &mut TexturePacker,
    errors: &mut Vec<String>,
) -> PackedMaterials {
    let places: EntityHashMap<usize> = sources
        .iter()
        .enumerate()
        .map(|(i, source)| (source.entity, i))
        .collect();
    let id = |place: usize| MaterialId((place + FIXED.len()) as u32);
    let mut materials = FIXED.to_vec();
    let mut tables = ShadingTables::default();
    for source in sources {
        let mut nested = [source.first, source.second]
            .into_iter()
            .flatten()
            .map(|entity| places.get(&entity).copied().map(id));
        let mut packer = MaterialPacker {
            model,
            textures,
            tables: &mut tables,
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
        tables,
        ids: places.into_iter().map(|(entity, place)| (entity, id(place))).collect(),
    }
}

/// The table, with a stand-in for every material that is invalid in it.
pub(in crate::engine) fn material_table(
    mut materials: Vec<material::Material>,
    tables: ShadingTables,
    errors: &mut Vec<String>,
) -> MaterialTable {
    while let Err(error) = MaterialTable::check(&materials, &tables) {
        errors.push(error.to_string());
        materials[error.place] = STAND_IN;
    }
    MaterialTable::checked(materials, tables)
}

/// Packs materials outside of any scene, and returns their ids. Each comes with the indices of its nested materials in
/// the same list; pictures are replaced by grey, and invalid materials by the default.
pub(crate) fn pack_loose(loose: &[(Material, Vec<usize>)]) -> (MaterialTable, TextureTable, Vec<MaterialId>) {
    // Only the identity of the entities matters.
    let entity = |place: usize| Entity::from_raw_u32(place as u32);
    let sources: Vec<MaterialSource> = loose
        .iter()
        .enumerate()
        .filter_map(|(place, (material, inside))| {
            let nested = |index: usize| inside.get(index).and_then(|&inner| entity(inner));
            Some(MaterialSource {
                entity: entity(place)?,
                name: String::new(),
                material,
                first: nested(0),
                second: nested(1),
            })
        })
        .collect();
    let mut textures = TexturePacker::new(&|_| None);
    let mut errors = Vec::new();
    let packed = pack_materials(&sources, DielectricModel::default(), &mut textures, &mut errors);
    let ids = (0..sources.len()).map(|place| MaterialId((place + FIXED.len()) as u32));
    (
        material_table(packed.materials, packed.tables, &mut errors),
        TextureTable::new(textures.finish()),
        ids.collect(),
    )
}

fn contains_itself(start: usize, sources: &[MaterialSource], places: &EntityHashMap<usize>) -> bool {
    let nested = |place: usize| {
        let source = &sources[place];
        let used = source.material.info().nested.end().min(&2).to_owned();
        [source.first, source.second]
            .into_iter()
            .flatten()
            .take(used)
            .filter_map(|entity| places.get(&entity).copied())
    };
    let mut waiting: Vec<usize> = nested(start).collect();
    // Marks per material would take quadratic memory for very many plain materials.
    if waiting.is_empty() {
        return false;
    }
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

#[cfg(test)]
mod tests {
    use super::super::STAND_IN_ID;
    use super::*;
    use crate::material::TexturedBsdf;
    use crate::scene::{ConductorIor, Distribution, Ior, Roughness};

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
