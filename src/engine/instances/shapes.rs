//! Updates the records of shapes and the hierarchy over them after changes of a few shapes. [`super::packing`] packs
//! all shapes.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use bevy::ecs::entity::EntityHashSet;
use bevy::ecs::query::QueryEntityError;
use bevy::prelude::*;

use super::named_mesh::mesh_of;
use super::rebuild::Rebuild;
use super::splice::{ListEdits, Piece, ShapeChanges, pieces};
use crate::accel::{Instance, Primitive, ShapeEdits, Tlas};
use crate::engine::authored::Authored;
use crate::engine::blas_cache::{BlasCache, BuildPolicy};
use crate::engine::detect::Touched;
use crate::engine::extract::Extracted;
use crate::engine::pack::instance::{InstanceRecord, pack_instance};
use crate::engine::status::BvhStatus;
use crate::scene::ShapeKind;

/// A changed shape in its current state.
struct Edited {
    packed: Option<(Instance, InstanceRecord)>,
    error: Option<String>,
}

/// The differences between changed shapes and their records.
#[derive(Default)]
struct RecordEdits {
    /// The edits of the hierarchy.
    shapes: ShapeEdits,
    /// New records by the numbers of the old ones.
    replaced: Vec<(u32, InstanceRecord)>,
    /// Further records by the numbers that they get.
    inserted: Vec<(u32, InstanceRecord)>,
    /// Whether a mesh may be in use no more.
    lost_meshes: bool,
}

impl Extracted {
    /// Packs the changed shapes of the world, and edits the tables. The result equals that of packing all shapes, up to
    /// the inner structure of the hierarchy. None where all shapes have to be packed, which also replaces the edits
    /// made here.
    pub(in crate::engine) fn edit_shapes(
        &mut self,
        changed: &EntityHashSet,
        authored: &Authored,
        cache: &mut BlasCache,
        policy: &BuildPolicy,
    ) -> Option<ShapeChanges> {
        let is_settled = self.meshes_loading == 0 && cache.builds_running() == 0 && self.method == policy.method;
        if !is_settled || !self.scene.geometry.is_edited_in_place() {
            return None;
        }
        let in_world = self.layout.in_world;
        let others = self.layout.shapes[in_world..].iter().map(|record| record.entity);
        if others
            .chain(self.layout.placed.iter().map(|placed| placed.entity))
            .any(|entity| changed.contains(&entity))
        {
            return None;
        }
        let mut now = HashMap::with_capacity(changed.len());
        for &entity in changed {
            now.insert(entity, edited(entity, authored, cache, policy)?);
        }
        self.note_errors(changed, authored, &mut now);
        let RecordEdits {
            shapes: edits,
            replaced,
            inserted,
            lost_meshes,
        } = self.record_edits(changed, now);
        if edits.is_empty() {
            let changed = replaced.iter().map(|(number, _)| *number).collect();
            self.layout.edit(&[], replaced, Vec::new());
            return Some(ShapeChanges {
                moved: vec![false; self.layout.shapes.len()],
                edits: Some(ListEdits {
                    changed,
                    ..ListEdits::default()
                }),
            });
        }
        let anew = self.take_rebuilt();
        let geometry = anew.as_ref().unwrap_or(&self.scene.geometry).edited(&edits)?;
        self.count_triangles(&edits);
        let list = ListEdits {
            removed: edits.removed.clone(),
            inserted: inserted.iter().map(|(number, _)| *number).collect(),
            changed: replaced.iter().map(|(number, _)| edits.renumbered(*number)).collect(),
        };
        self.edit_entities(&edits, &list, &inserted);
        self.layout.edit(&edits.removed, replaced, inserted);
        let mut moved = vec![false; self.layout.shapes.len()];
        for &(number, _) in &edits.replaced {
            moved[edits.renumbered(number) as usize] = true;
        }
        edits
            .inserted
            .iter()
            .for_each(|&(number, _)| moved[number as usize] = true);
        if lost_meshes {
            self.drop_unused_meshes(cache);
        }
        self.scene.geometry = Arc::new(geometry);
        self.rebuild_if_worn(cache, policy);
        self.update_figures(cache);
        let edits = Some(list);
        Some(ShapeChanges { moved, edits })
    }

    /// Replaces the errors of the shapes that have changed.
    fn note_errors(&mut self, changed: &EntityHashSet, authored: &Authored, now: &mut HashMap<Entity, Edited>) {
        let errors = &mut self.errors.instances;
        errors.retain(|(_, entity), _| !changed.contains(entity));
        for (&entity, edited) in now {
            if let Some(error) = edited.error.take() {
                let order = authored
                    .surface_bindings
                    .get(entity)
                    .map_or_else(|_| default(), |(order, ..)| *order);
                errors.insert((order, entity), error);
            }
        }
    }

    /// Compares the changed shapes with their records: equal keys replace a record, other records leave, and new ones
    /// are inserted in the order of keys.
    fn record_edits(&self, changed: &EntityHashSet, mut now: HashMap<Entity, Edited>) -> RecordEdits {
        let in_world = self.layout.in_world;
        let mut found = RecordEdits::default();
        let mut new = Vec::new();
        // The list of entities is a fraction of the memory of the records.
        let entities = (0u32..).zip(&self.entity_of_instance[..in_world]);
        for (number, _) in entities.filter(|(_, entity)| changed.contains(*entity)) {
            let record = &self.layout.shapes[number as usize];
            let mesh_before = hierarchy_of(&record.primitive).is_some();
            match now.remove(&record.entity).and_then(|edited| edited.packed) {
                Some((instance, new)) if new.key() == record.key() => {
                    if !new.same_geometry(record) {
                        found.lost_meshes |= mesh_before && !new.is_of_same_mesh(record);
                        found.shapes.replaced.push((number, instance));
                    }
                    found.replaced.push((number, new));
                }
                packed => {
                    found.lost_meshes |= mesh_before;
                    found.shapes.removed.push(number);
                    new.extend(packed);
                }
            }
        }
        new.extend(now.into_values().filter_map(|edited| edited.packed));
        new.sort_by_key(|(_, record)| record.key());
        for (instance, record) in new {
            let before = self.layout.shapes[..in_world].partition_point(|old| old.key() < record.key()) as u32;
            let gone = found.shapes.removed.partition_point(|&removed| removed < before) as u32;
            let number = before - gone + found.inserted.len() as u32;
            found.shapes.inserted.push((number, instance));
            found.inserted.push((number, record));
        }
        found
    }

    /// Brings the number of triangles up to date. The layout is still the old one.
    fn count_triangles(&mut self, edits: &ShapeEdits) {
        let triangles = |shapes: &mut dyn Iterator<Item = &Primitive>| shapes.map(triangles_of).sum::<u64>();
        let old = edits
            .removed
            .iter()
            .chain(edits.replaced.iter().map(|(number, _)| number));
        let before = triangles(&mut old.map(|&number| &self.layout.shapes[number as usize].primitive));
        let added = edits.replaced.iter().chain(&edits.inserted);
        let after = triangles(&mut added.map(|(_, instance)| &instance.primitive));
        self.triangles = self.triangles - before + after;
    }

    /// Renumbers the lists of entities and of special shapes.
    fn edit_entities(&mut self, edits: &ShapeEdits, list: &ListEdits, inserted: &[(u32, InstanceRecord)]) {
        if list.removed.is_empty() && list.inserted.is_empty() {
            return;
        }
        let old = &self.entity_of_instance;
        let mut entities = Vec::with_capacity(old.len() + inserted.len());
        for piece in pieces(old.len(), &list.removed, &list.inserted) {
            match piece {
                Piece::Kept(range) => entities.extend_from_slice(&old[range]),
                Piece::New(index) => entities.push(inserted[index].1.entity),
            }
        }
        self.entity_of_instance = entities.into();
        self.special
            .retain(|number| list.removed.binary_search(number).is_err());
        self.special
            .iter_mut()
            .for_each(|number| *number = edits.renumbered(*number));
    }

    fn drop_unused_meshes(&self, cache: &mut BlasCache) {
        let shapes = self.layout.shapes.iter();
        let used: HashSet<*const ()> = shapes.filter_map(|record| hierarchy_of(&record.primitive)).collect();
        cache.retain(|mesh| hierarchy_of(mesh).is_some_and(|mesh| used.contains(&mesh)));
    }

    /// Has the hierarchy built anew if so much has been edited that it is worth it.
    fn rebuild_if_worn(&mut self, cache: &mut BlasCache, policy: &BuildPolicy) {
        let old = &self.scene.geometry;
        if self.rebuild.is_some() || !old.is_worn() {
            return;
        }
        if policy.wait {
            self.scene.geometry = Arc::new(old.rebuilt(policy.method));
        } else {
            self.rebuild = Rebuild::begin(old, cache, policy);
        }
    }

    /// The current hierarchy with few edits beside it, if a rebuild is done. It waits for an edit, because the picture
    /// starts again with it.
    fn take_rebuilt(&mut self) -> Option<Tlas> {
        let anew = self.rebuild.take_if(|rebuild| rebuild.is_done())?;
        anew.finish(&self.scene.geometry)
    }

    /// Looks up the materials, lights and media of shapes, and adds the shapes to the changed ones.
    pub(in crate::engine) fn update_bindings(
        &mut self,
        touched: &Touched,
        authored: &Authored,
        changes: &mut ShapeChanges,
    ) {
        let touched: Vec<u32> = match touched {
            Touched::All => {
                changes.edits = None;
                (0..self.layout.shapes.len() as u32).collect()
            }
            Touched::These(shapes) if shapes.is_empty() => return,
            Touched::These(shapes) => {
                let (in_world, all) = (self.layout.in_world, &self.layout.shapes);
                let members = all[in_world..].iter().map(|record| &record.entity);
                let entities = self.entity_of_instance[..in_world].iter().chain(members);
                let numbered = (0..).zip(entities);
                let touched = numbered.filter(|(_, entity)| shapes.contains(*entity));
                touched.map(|(number, _)| number).collect()
            }
        };
        for &number in &touched {
            let record = &mut self.layout.shapes[number as usize];
            // A shape that was just removed is not among these records, because its removal has packed them again.
            if let Ok((_, _, uses, light, media)) = authored.surface_bindings.get(record.entity) {
                (record.material, record.has_light) = (uses.map(|uses| uses.0), light.is_some());
                record.media = media.entities();
            }
        }
        if let Some(edits) = &mut changes.edits {
            edits.changed.extend(touched);
            edits.changed.sort_unstable();
            edits.changed.dedup();
            edits
                .changed
                .retain(|number| edits.inserted.binary_search(number).is_err());
        }
    }

    pub(in crate::engine) fn update_figures(&mut self, cache: &BlasCache) {
        let top = self.scene.geometry.stats();
        let largest = cache.in_use().max_by_key(|mesh| mesh.stats.nodes);
        let sum = |of: fn(&crate::accel::BvhStats) -> usize| -> u64 {
            (of(&top) + cache.in_use().map(|mesh| of(&mesh.stats)).sum::<usize>()) as u64
        };
        self.bvh = BvhStatus {
            nodes: sum(|stats| stats.nodes),
            leaves: sum(|stats| stats.leaves),
            bytes: sum(|stats| stats.bytes),
            max_depth: (top.max_depth + cache.in_use().map(|mesh| mesh.stats.max_depth).max().unwrap_or(0)) as u32,
            sah_cost: f64::from(largest.map_or(top.sah_cost, |mesh| mesh.stats.sah_cost)),
            // The sum starts from a positive zero: the empty sum of floats is -0.
            build_ms: cache.in_use().fold(0.0, |sum, mesh| sum + mesh.build_ms),
        };
    }
}

/// The identity of the hierarchy of a mesh or of curves.
fn hierarchy_of(primitive: &Primitive) -> Option<*const ()> {
    match primitive {
        Primitive::Mesh(mesh) => Some(Arc::as_ptr(mesh).cast()),
        Primitive::Curves(curves) => Some(Arc::as_ptr(curves).cast()),
        _ => None,
    }
}

fn triangles_of(primitive: &Primitive) -> u64 {
    match primitive {
        Primitive::Mesh(mesh) => mesh.mesh().triangles.len() as u64,
        _ => 0,
    }
}

/// Packs a changed shape. None if that is not enough: it belongs to a group, or its mesh is not loaded.
fn edited(entity: Entity, authored: &Authored, cache: &mut BlasCache, policy: &BuildPolicy) -> Option<Edited> {
    let none = Edited {
        packed: None,
        error: None,
    };
    let shape = match authored.shapes.get(entity) {
        Ok(shape) => shape,
        Err(QueryEntityError::QueryDoesNotMatch(..) | QueryEntityError::NotSpawned(_)) => return Some(none),
        Err(_) => return None,
    };
    if shape.member_of.is_some() || shape.instance_of.is_some() {
        return None;
    }
    let mesh = mesh_of(shape.shape, &shape.to_world.0, shape.mesh, authored, cache, policy);
    let has_mesh = matches!(shape.shape.kind, ShapeKind::Mesh(_) | ShapeKind::Solid(_));
    if has_mesh && mesh.built.is_none() {
        return None;
    }
    Some(match pack_instance(&shape.source(), mesh.built) {
        Ok(packed) => Edited { packed, error: None },
        Err(error) => Edited {
            packed: None,
            error: Some(format!("{}: {error}", shape.name())),
        },
    })
}
