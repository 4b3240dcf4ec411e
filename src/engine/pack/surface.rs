//! Packs the surface of each instance: the slots that link it to materials and lights.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::Arc;

use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;

use super::Checker;
use super::group::Layout;
use super::instance::InstanceRecord;
use super::mtl::{emission, push_mtl};
use super::texture::TexturePacker;
use super::{LAMP_ID, STAND_IN_ID};
use crate::accel::Primitive;
use crate::color::Rgb;
use crate::engine::instances::splice::{ListEdits, Piece, pieces};
use crate::geometry::mesh::MeshData;
use crate::light::{LightId, LightSource, WeightedSource};
use crate::material::{Material, MaterialId};
use crate::medium::{MediumId, MediumInterface};
use crate::render::scene::{SurfaceSlot, SurfaceTable};
use crate::scene::AreaLight;
use crate::shading::DielectricModel;
use crate::texture::Parameter;

/// The data of a shape that its record does not have.
pub(in crate::engine) struct SurfaceSource<'s> {
    pub name: String,
    /// None for a shape without an area light.
    pub light: Option<&'s AreaLight>,
}

/// The surfaces of all instances, with their materials and their area lights.
#[derive(Clone, Debug, Default)]
pub(in crate::engine) struct PackedSurfaces {
    /// The slots of all instances; the old table itself if it is equal.
    pub table: Arc<SurfaceTable>,
    /// The scene's materials, then those of mesh files in use.
    pub materials: Vec<Material>,
    /// The light of each emitting shape, with its entity, in the order of the ids in `table`.
    pub lights: Vec<(Entity, WeightedSource)>,
    /// The numbers of the shapes whose slots need more than their records: they emit light, or have materials of a mesh
    /// file or a missing one.
    pub special: Vec<u32>,
}

/// The input for packing surfaces.
pub(in crate::engine) struct SurfacePacker<'a, 't, F> {
    pub layout: &'a Layout,
    /// Looks up a shape, for special ones only.
    pub source: F,
    /// The ids of the scene's materials.
    pub ids: &'a EntityHashMap<MaterialId>,
    /// The ids of the media that light meets; other media are treated as none.
    pub media: &'a EntityHashMap<MediumId>,
    pub model: DielectricModel,
    pub textures: &'a mut TexturePacker<'t>,
    pub errors: &'a mut Vec<String>,
}

impl<'s, F: Fn(Entity) -> SurfaceSource<'s>> SurfacePacker<'_, '_, F> {
    /// Packs the surfaces. `old` is the previous table. With `edits` unchanged shapes are copied from it: the ids are
    /// still valid, and `special` are the special shapes by their current numbers.
    pub fn pack(
        mut self,
        materials: Vec<Material>,
        old: &Arc<SurfaceTable>,
        special: &[u32],
        edits: Option<&ListEdits>,
    ) -> PackedSurfaces {
        let edited = edits.and_then(|edits| self.edited(old, special, edits));
        let (mut table, special) = edited.unwrap_or_else(|| self.all());
        let mut packed = PackedSurfaces {
            materials,
            special,
            ..PackedSurfaces::default()
        };
        let mut of_file = HashMap::new();
        for number in packed.special.clone() {
            let slots = self.special_slots(number, &mut of_file, &mut packed);
            let first = table.first_slot[number as usize] as usize;
            let place = first..first + slots.len();
            if table.slots[place.clone()] != slots {
                table.to_mut().slots[place].copy_from_slice(&slots);
            }
        }
        packed.table = match table {
            Cow::Owned(table) if table != **old => Arc::new(table),
            _ => old.clone(),
        };
        packed
    }

    /// The table with the slots of all shapes except special ones, whose slots are left free, and the numbers of the
    /// special ones.
    fn all<'o>(&self) -> (Cow<'o, SurfaceTable>, Vec<u32>) {
        let shapes = &self.layout.shapes;
        let (mut table, mut special) = (SurfaceTable::default(), Vec::new());
        table.first_slot.reserve_exact(shapes.len());
        table.slots.reserve(shapes.len());
        for (number, record) in (0..).zip(shapes) {
            let slot = self.plain_slot(record);
            if slot.is_none() {
                special.push(number);
            }
            table.first_slot.push(table.slots.len() as u32);
            table.slots.extend((0..record.slots).map(|_| slot.unwrap_or(FREE)));
        }
        (Cow::Owned(table), special)
    }

    /// [`Self::all`] from the old table. None if the number of slots of a shape has changed.
    fn edited<'o>(
        &self,
        old: &'o SurfaceTable,
        special: &[u32],
        edits: &ListEdits,
    ) -> Option<(Cow<'o, SurfaceTable>, Vec<u32>)> {
        let record = |number: u32| &self.layout.shapes[number as usize];
        let mut table = Cow::Borrowed(old);
        if !edits.removed.is_empty() || !edits.inserted.is_empty() {
            let inserted = edits.inserted.iter().map(|number| record(*number).slots);
            table = Cow::Owned(spliced(old, edits, &inserted.collect::<Vec<_>>()));
        }
        let mut special = special.to_vec();
        for &number in edits.inserted.iter().chain(&edits.changed) {
            let record = record(number);
            let first = table.first_slot[number as usize];
            let next = table.first_slot.get(number as usize + 1);
            if next.map_or(table.slots.len() as u32, |next| *next) - first != record.slots {
                return None;
            }
            let slot = self.plain_slot(record);
            match (slot, special.binary_search(&number)) {
                (Some(_), Ok(place)) => drop(special.remove(place)),
                (None, Err(place)) => special.insert(place, number),
                _ => {}
            }
            let place = first as usize..(first + record.slots) as usize;
            if let Some(slot) = slot
                && table.slots[place.clone()].iter().any(|before| *before != slot)
            {
                table.to_mut().slots[place].fill(slot);
            }
        }
        Some((table, special))
    }

    /// Each slot of a shape that is not special.
    fn plain_slot(&self, record: &InstanceRecord) -> Option<SurfaceSlot> {
        if record.has_light || library(record).is_some() {
            return None;
        }
        let material = match record.material {
            None => STAND_IN_ID,
            Some(material) => *self.ids.get(&material)?,
        };
        Some(SurfaceSlot {
            material,
            light: None,
            media: self.media_of(record),
        })
    }

    fn media_of(&self, record: &InstanceRecord) -> MediumInterface {
        let [interior, exterior] = record.media.map(|medium| self.media.get(&medium?).copied());
        MediumInterface { interior, exterior }
    }

    /// The slots of a special shape, whose materials and lights are added to `packed`.
    fn special_slots(
        &mut self,
        number: u32,
        of_file: &mut HashMap<*const MeshData, Vec<MaterialId>>,
        packed: &mut PackedSurfaces,
    ) -> Vec<SurfaceSlot> {
        let record = &self.layout.shapes[number as usize];
        let is_member = self.layout.is_member(number as usize);
        let media = self.media_of(record);
        let mesh = library(record);
        let source = (self.source)(record.entity);
        let mut check = Checker {
            name: &source.name,
            errors: self.errors,
        };
        let own = record.material.map(|material| {
            self.ids.get(&material).copied().unwrap_or_else(|| {
                check.report("its material does not exist");
                STAND_IN_ID
            })
        });
        let own_light = source.light.map(|light| {
            let light = check.area_light(light);
            (
                self.textures.packed(&light.radiance),
                light.sampling_weight,
                light.two_sided,
            )
        });
        if own_light.is_some() && is_member {
            check.report("a shape of a group cannot be a light");
        }
        let from_file = mesh.map_or(&[][..], |mesh| {
            of_file.entry(Arc::as_ptr(mesh)).or_insert_with(|| {
                let of_mesh = mesh.materials.iter();
                of_mesh
                    .map(|mtl| push_mtl(mtl, self.model, self.textures, &mut packed.materials, self.errors))
                    .collect()
            })
        });
        let emitted: Vec<_> = (0..record.slots)
            .map(|slot| {
                own_light.unwrap_or_else(|| {
                    let in_file = mesh.and_then(|mesh| mesh.materials.get(slot as usize));
                    let of_file = in_file.map_or(Parameter::Constant(Rgb::ZERO), |mtl| emission(mtl, self.textures));
                    (of_file, 1.0, false)
                })
            })
            .collect();
        let slot = |(slot, (radiance, sampling_weight, is_two_sided)): (u32, (Parameter<Rgb>, f32, bool))| {
            let material = own
                .or_else(|| from_file.get(slot as usize).copied())
                .unwrap_or(if own_light.is_some() { LAMP_ID } else { STAND_IN_ID });
            let is_bright = match radiance {
                Parameter::Constant(color) => color.is_finite() && color != Rgb::ZERO,
                Parameter::Texture(_) => true,
            };
            let shines = is_bright && !is_member;
            let light = shines.then(|| {
                let source = LightSource::Surface {
                    instance: number,
                    slot,
                    radiance,
                    is_two_sided,
                };
                let light = WeightedSource {
                    source,
                    sampling_weight,
                };
                packed.lights.push((record.entity, light));
                LightId(packed.lights.len() as u32 - 1)
            });
            SurfaceSlot { material, light, media }
        };
        (0..record.slots).zip(emitted).map(slot).collect()
    }
}

/// The mesh of a shape that uses materials of its mesh file.
fn library(record: &InstanceRecord) -> Option<&Arc<MeshData>> {
    match (&record.primitive, record.material) {
        (Primitive::Mesh(blas), None) => Some(blas.mesh()).filter(|mesh| !mesh.materials.is_empty()),
        _ => None,
    }
}

/// A slot that is filled later.
const FREE: SurfaceSlot = SurfaceSlot {
    material: STAND_IN_ID,
    light: None,
    media: MediumInterface {
        interior: None,
        exterior: None,
    },
};

/// The table after edits of the list of shapes; `slots` has the number of slots of each new shape, which are left free.
fn spliced(old: &SurfaceTable, edits: &ListEdits, slots: &[u32]) -> SurfaceTable {
    let first_of = |shape: usize| {
        old.first_slot
            .get(shape)
            .map_or(old.slots.len(), |first| *first as usize)
    };
    let mut table = SurfaceTable::default();
    let count = old.first_slot.len() + slots.len() - edits.removed.len();
    table.first_slot.reserve_exact(count);
    table
        .slots
        .reserve_exact(old.slots.len() + slots.iter().sum::<u32>() as usize);
    for piece in pieces(old.first_slot.len(), &edits.removed, &edits.inserted) {
        let now = table.slots.len() as u32;
        match piece {
            Piece::Kept(shapes) => {
                let all = first_of(shapes.start)..first_of(shapes.end);
                let first = all.start as u32;
                let moved = old.first_slot[shapes].iter().map(|slot| slot - first + now);
                table.first_slot.extend(moved);
                table.slots.extend_from_slice(&old.slots[all]);
            }
            Piece::New(index) => {
                table.first_slot.push(now);
                table.slots.extend((0..slots[index]).map(|_| FREE));
            }
        }
    }
    table
}
