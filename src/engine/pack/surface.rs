//! Packs the surface of each instance: the slots that tie it to materials and lights.

use std::collections::HashMap;
use std::sync::Arc;

use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;

use super::Checker;
use super::group::Layout;
use super::mtl::push_mtl;
use super::texture::TexturePacker;
use super::{BRIGHTEST, LAMP_ID, STAND_IN_ID};
use crate::accel::Primitive;
use crate::color::Rgb;
use crate::geometry::mesh::MeshData;
use crate::light::{LightId, LightSource, WeightedSource};
use crate::material::{Material, MaterialId};
use crate::medium::{MediumId, MediumInterface};
use crate::render::scene::{SurfaceSlot, SurfaceTable};
use crate::scene::AreaLight;
use crate::shading::DielectricModel;
use crate::texture::Parameter;

/// The data of a shape that is looked up where its record is not enough.
pub(in crate::engine) struct SurfaceSource<'s> {
    pub name: String,
    /// None for a shape without an area light.
    pub light: Option<&'s AreaLight>,
}

/// The surfaces of all instances, the materials they refer to, and the lights they are.
#[derive(Clone, Debug, Default)]
pub(in crate::engine) struct PackedSurfaces {
    pub table: SurfaceTable,
    /// The scene's materials, then those of mesh files in use.
    pub materials: Vec<Material>,
    /// Light sources with the shapes they are, their ids as in `table`.
    pub lights: Vec<(Entity, WeightedSource)>,
}

/// `source` looks a shape up, which is not done for shapes that do not shine. `ids`: of the entities of `materials`. `media`: the ids of those that light
/// meets; sides of others are empty.
pub(in crate::engine) fn pack_surfaces<'s>(
    layout: &Layout,
    source: impl Fn(Entity) -> SurfaceSource<'s>,
    materials: Vec<Material>,
    ids: &EntityHashMap<MaterialId>,
    media: &EntityHashMap<MediumId>,
    model: DielectricModel,
    textures: &mut TexturePacker,
    errors: &mut Vec<String>,
) -> PackedSurfaces {
    let mut packed = PackedSurfaces {
        materials,
        ..PackedSurfaces::default()
    };
    let mut of_file: HashMap<*const MeshData, Vec<MaterialId>> = HashMap::new();
    packed.table.first_slot.reserve_exact(layout.shapes.len());
    packed.table.slots.reserve(layout.shapes.len());
    for (index, record) in layout.shapes.iter().enumerate() {
        let mesh = match (&record.primitive, record.material) {
            (Primitive::Mesh(blas), None) => Some(blas.mesh()).filter(|mesh| !mesh.materials.is_empty()),
            _ => None,
        };
        let known = record
            .material
            .map_or(Some(STAND_IN_ID), |material| ids.get(&material).copied());
        let [interior, exterior] = record.media.map(|medium| media.get(&medium?).copied());
        let media = MediumInterface { interior, exterior };
        if let Some(material) = known.filter(|_| mesh.is_none() && !record.has_light) {
            packed.table.first_slot.push(packed.table.slots.len() as u32);
            let slot = SurfaceSlot {
                material,
                light: None,
                media,
            };
            packed.table.slots.extend((0..record.slots).map(|_| slot));
            continue;
        }
        let source = source(record.entity);
        let mut check = Checker {
            name: &source.name,
            errors,
        };
        let own = record.material.map(|material| {
            ids.get(&material).copied().unwrap_or_else(|| {
                check.report("its material does not exist");
                STAND_IN_ID
            })
        });
        let own_light = source.light.map(|light| {
            let light = check.area_light(light);
            (textures.packed(&light.radiance), light.sampling_weight)
        });
        if own_light.is_some() && layout.is_member(index) {
            check.report("a shape of a group cannot be a light");
        }
        let from_file = mesh.map_or(&[][..], |mesh| {
            of_file.entry(Arc::as_ptr(mesh)).or_insert_with(|| {
                let of_mesh = mesh.materials.iter();
                of_mesh
                    .map(|mtl| push_mtl(mtl, model, textures, &mut packed.materials, errors))
                    .collect()
            })
        });
        packed.table.first_slot.push(packed.table.slots.len() as u32);
        for slot in 0..record.slots {
            let material = own
                .or_else(|| from_file.get(slot as usize).copied())
                .unwrap_or(if own_light.is_some() { LAMP_ID } else { STAND_IN_ID });
            let in_file = || mesh.and_then(|mesh| mesh.materials.get(slot as usize));
            let (radiance, sampling_weight) = own_light.unwrap_or_else(|| {
                // A library's odd colours have been reported with its other parameters or do not matter: black is no light.
                let radiance = in_file().map_or(Rgb::ZERO, |mtl| mtl.ke.max(Rgb::ZERO).min(Rgb::splat(BRIGHTEST)));
                (Parameter::Constant(radiance), 1.0)
            });
            let is_bright = match radiance {
                Parameter::Constant(color) => color.is_finite() && color != Rgb::ZERO,
                Parameter::Texture(_) => true,
            };
            let shines = is_bright && !layout.is_member(index);
            let light = shines.then(|| {
                let source = LightSource::Surface {
                    instance: index as u32,
                    slot,
                    radiance,
                };
                let light = WeightedSource {
                    source,
                    sampling_weight,
                };
                packed.lights.push((record.entity, light));
                LightId(packed.lights.len() as u32 - 1)
            });
            packed.table.slots.push(SurfaceSlot { material, light, media });
        }
    }
    packed
}
