//! Brings the records of shapes and the hierarchy over them up to date: those of a few shapes that have changed, or all.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use bevy::asset::AssetServer;
use bevy::ecs::entity::EntityHashSet;
use bevy::ecs::query::QueryEntityError;
use bevy::prelude::*;

use super::authored::Authored;
use super::blas_cache::{BlasCache, BuildError, BuildPolicy, BuiltMesh, MeshKey};
use super::detect::Touched;
use super::extract::Extracted;
use super::pack::group::{Layout, PlacedGroup};
use super::pack::instance::{InstanceRecord, pack_instance};
use super::status::BvhStatus;
use crate::accel::{Blas, Instance, Primitive, ShapeEdits};
use crate::scene::{InstanceOf, MemberOf, MeshHandle, Shape, ShapeKind};

/// A shape that has changed, as it is now.
struct Edited {
    packed: Option<(Instance, InstanceRecord)>,
    error: Option<String>,
}

impl Extracted {
    /// Brings all up to date, and tells for each instance whether its place or geometry has changed.
    pub(super) fn update_shapes(
        &mut self,
        touched: &Touched,
        authored: &Authored,
        cache: &mut BlasCache,
        policy: &BuildPolicy,
    ) -> Vec<bool> {
        let edited = match touched {
            Touched::These(shapes) => self.edit_shapes(shapes, authored, cache, policy),
            Touched::All => None,
        };
        edited.unwrap_or_else(|| self.update_all(authored, cache, policy))
    }

    /// Packs all shapes.
    fn update_all(&mut self, authored: &Authored, cache: &mut BlasCache, policy: &BuildPolicy) -> Vec<bool> {
        let mut shapes: Vec<_> = authored.shapes.iter().collect();
        shapes.sort_by_key(|shape| (*shape.order, shape.entity));
        self.errors.instances.clear();
        self.meshes_loading = 0;
        cache.begin_use();
        let mut groups: Vec<_> = authored.groups.iter().map(|(entity, &order)| (order, entity)).collect();
        groups.sort();
        let groups: HashMap<Entity, usize> = groups.into_iter().zip(0..).map(|((_, group), i)| (group, i)).collect();
        let mut records = Vec::new();
        let mut members: Vec<(Vec<Instance>, Vec<InstanceRecord>)> = groups.iter().map(|_| default()).collect();
        let mut placed = Vec::new();
        let (errors, meshes_loading) = (&mut self.errors.instances, &mut self.meshes_loading);
        let in_world = shapes.into_iter().filter_map(|shape| {
            if let Some((InstanceOf(group), placements)) = shape.instance_of
                && let Some(&group) = groups.get(group)
            {
                placed.push(PlacedGroup {
                    entity: shape.entity,
                    name: shape.name(),
                    group,
                    places: placements
                        .map_or_else(|| Arc::new(vec![shape.to_world.0.into()]), |many| many.places.clone()),
                });
                return None;
            }
            let mesh = mesh_of(shape.shape, shape.mesh, authored, cache, policy);
            *meshes_loading += u32::from(mesh.is_loading);
            let (instance, record) = match pack_instance(&shape.source(), mesh.built) {
                Ok(packed) => packed?,
                Err(error) => {
                    errors.insert((*shape.order, shape.entity), format!("{}: {error}", shape.name()));
                    return None;
                }
            };
            match shape.member_of.and_then(|MemberOf(group)| groups.get(group)) {
                Some(&group) => {
                    members[group].0.push(instance);
                    members[group].1.push(record);
                    None
                }
                None => {
                    records.push(record);
                    Some(instance)
                }
            }
        });
        let in_world = in_world.collect();
        cache.end_use();
        self.errors.meshes = cache.failures().map(BuildError::to_string).collect();

        let (layout, instances) = Layout::new((in_world, records), members, placed);
        let old = std::mem::replace(&mut self.layout, layout);
        let moved = self.layout.moved_since(&old);
        if moved.contains(&true)
            || old.shapes.len() != self.layout.shapes.len()
            || !self.layout.placed_as(&old)
            || self.method != policy.method
        {
            self.errors.placements.clear();
            let (geometry, entities) = self.layout.build(instances, policy.method, &mut self.errors.placements);
            self.scene.geometry = Arc::new(geometry);
            self.entity_of_instance = entities.into();
            self.method = policy.method;
            self.triangles = self.scene.geometry.triangles();
            self.update_figures(cache);
        }
        moved
    }

    /// Packs the shapes of the world that have changed, and edits the tables. The result is the same as if all shapes were packed, except for the
    /// nodes of the hierarchy. None, and nothing is changed, where all shapes have to be packed.
    fn edit_shapes(
        &mut self,
        changed: &EntityHashSet,
        authored: &Authored,
        cache: &mut BlasCache,
        policy: &BuildPolicy,
    ) -> Option<Vec<bool>> {
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
        let mut now = Vec::with_capacity(changed.len());
        for &entity in changed {
            now.push((entity, edited(entity, authored, cache, policy)?));
        }
        let mut now: HashMap<Entity, Edited> = now.into_iter().collect();
        let (mut edits, mut replaced) = (ShapeEdits::default(), Vec::new());
        let errors = &mut self.errors.instances;
        errors.retain(|(_, entity), _| !changed.contains(entity));
        for (&entity, edited) in &mut now {
            if let Some(error) = edited.error.take() {
                let order = authored
                    .surface_bindings
                    .get(entity)
                    .map_or_else(|_| default(), |(order, ..)| *order);
                errors.insert((order, entity), error);
            }
        }
        let mut lost_meshes = false;
        for (number, record) in (0..).zip(&self.layout.shapes[..in_world]) {
            if !changed.contains(&record.entity) {
                continue;
            }
            let mesh_before = matches!(record.primitive, Primitive::Mesh(_));
            match now.remove(&record.entity).and_then(|edited| edited.packed) {
                Some((instance, new)) if new.key() == record.key() => {
                    if !new.same_geometry(record) {
                        lost_meshes |= mesh_before && !new.is_of_same_mesh(record);
                        edits.replaced.push((number, instance));
                    }
                    replaced.push((number, new));
                }
                packed => {
                    lost_meshes |= mesh_before;
                    edits.removed.push(number);
                    if let Some(packed) = packed {
                        now.insert(
                            record.entity,
                            Edited {
                                packed: Some(packed),
                                error: None,
                            },
                        );
                    }
                }
            }
        }
        let mut new: Vec<_> = now.into_values().filter_map(|edited| edited.packed).collect();
        new.sort_by_key(|(_, record)| record.key());
        let mut inserted = Vec::with_capacity(new.len());
        for (instance, record) in new {
            let before = self.layout.shapes[..in_world].partition_point(|old| old.key() < record.key()) as u32;
            let gone = edits.removed.partition_point(|&removed| removed < before) as u32;
            let number = before - gone + inserted.len() as u32;
            edits.inserted.push((number, instance));
            inserted.push((number, record));
        }
        if edits.is_empty() {
            self.layout.edit(&[], replaced, Vec::new());
            return Some(vec![false; self.layout.shapes.len()]);
        }
        let geometry = self.scene.geometry.edited(&edits)?;
        let triangles = |shapes: &mut dyn Iterator<Item = &Primitive>| shapes.map(triangles_of).sum::<u64>();
        let old = edits
            .removed
            .iter()
            .chain(edits.replaced.iter().map(|(number, _)| number));
        let before = triangles(&mut old.map(|&number| &self.layout.shapes[number as usize].primitive));
        let added = edits.replaced.iter().chain(&edits.inserted);
        let after = triangles(&mut added.map(|(_, instance)| &instance.primitive));
        self.triangles = self.triangles - before + after;
        self.layout.edit(&edits.removed, replaced, inserted);
        let mut moved = vec![false; self.layout.shapes.len()];
        for &(number, _) in &edits.replaced {
            moved[edits.renumbered(number) as usize] = true;
        }
        edits
            .inserted
            .iter()
            .for_each(|&(number, _)| moved[number as usize] = true);
        if !edits.removed.is_empty() || !edits.inserted.is_empty() {
            let placed = self.entity_of_instance[in_world..].iter().copied();
            let shapes = self.layout.shapes[..self.layout.in_world]
                .iter()
                .map(|record| record.entity);
            self.entity_of_instance = shapes.chain(placed).collect();
        }
        if lost_meshes {
            let meshes = self.layout.shapes.iter().filter_map(|record| match &record.primitive {
                Primitive::Mesh(mesh) => Some(Arc::as_ptr(mesh)),
                _ => None,
            });
            let used: HashSet<*const Blas> = meshes.collect();
            cache.retain(|mesh| used.contains(&Arc::as_ptr(mesh)));
        }
        self.scene.geometry = Arc::new(geometry);
        self.update_figures(cache);
        Some(moved)
    }

    /// Looks up which materials and lights shapes have.
    pub(super) fn update_bindings(&mut self, touched: &Touched, authored: &Authored) {
        if !touched.any() {
            return;
        }
        for record in &mut self.layout.shapes {
            let is_touched = match touched {
                Touched::These(shapes) => shapes.contains(&record.entity),
                Touched::All => true,
            };
            // A shape that was just removed is not among these records, because its removal has packed them anew.
            if is_touched && let Ok((_, _, uses, light)) = authored.surface_bindings.get(record.entity) {
                (record.material, record.has_light) = (uses.map(|uses| uses.0), light.is_some());
            }
        }
    }

    fn update_figures(&mut self, cache: &BlasCache) {
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

fn triangles_of(primitive: &Primitive) -> u64 {
    match primitive {
        Primitive::Mesh(mesh) => mesh.mesh().triangles.len() as u64,
        _ => 0,
    }
}

/// The mesh that a shape names.
struct NamedMesh<'c> {
    /// None if there is none, or not yet.
    built: Option<&'c BuiltMesh>,
    /// Whether its file is still being read.
    is_loading: bool,
}

fn mesh_of<'c>(
    shape: &Shape,
    handle: Option<&MeshHandle>,
    authored: &Authored,
    cache: &'c mut BlasCache,
    policy: &BuildPolicy,
) -> NamedMesh<'c> {
    let mut is_loading = false;
    let built = match (&shape.kind, handle) {
        (ShapeKind::Cube, _) => {
            let cube = cache.cube();
            cache.get(MeshKey::Cube, &cube, policy)
        }
        (ShapeKind::Triangle { .. }, _) => {
            let triangle = cache.triangle();
            cache.get(MeshKey::Triangle, &triangle, policy)
        }
        (ShapeKind::Solid(solid), _) => {
            let (key, mesh) = cache.solid(solid);
            cache.get(key, &mesh, policy)
        }
        (ShapeKind::Mesh(file), Some(MeshHandle(handle))) => match authored.meshes.get(handle) {
            Some(mesh) => {
                let key = MeshKey::Asset {
                    id: handle.id(),
                    shape_index: file.shape_index,
                    upside_down: file.flip_tex_coords != file.format.flips_tex_coords(),
                };
                mesh.data(file.shape_index)
                    .and_then(|data| cache.get(key, data, policy))
            }
            None => {
                let failed = |server: &AssetServer| server.load_state(handle).is_failed();
                is_loading = !authored.asset_server.as_deref().is_some_and(failed);
                None
            }
        },
        (ShapeKind::Mesh(_), None) => {
            is_loading = true;
            None
        }
        _ => None,
    };
    NamedMesh { built, is_loading }
}

/// Packs a shape that has changed. None if that is not enough: it is of a group, or its mesh is not there.
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
    let mesh = mesh_of(shape.shape, shape.mesh, authored, cache, policy);
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
