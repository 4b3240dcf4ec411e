//! Packs all shapes. In the window, very many are packed over several frames, and the hierarchy over them is built on
//! another thread, so that no frame takes long. Changes in the meantime are packed afterwards.

use std::collections::{BTreeMap, HashMap};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::{Duration, Instant};

use bevy::prelude::*;
use crossbeam_channel::{Receiver, bounded};
use rayon::ThreadPool;

use super::named_mesh::mesh_of;
use crate::accel::{Instance, SplitMethod, Tlas};
use crate::engine::authored::Authored;
use crate::engine::blas_cache::{BlasCache, BuildPolicy};
use crate::engine::control::WakeUp;
use crate::engine::pack::group::{Layout, PackedShapes, PlacedGroup};
use crate::engine::pack::instance::{InstanceRecord, ShapeSource, pack_instance};
use crate::scene::{DocumentOrder, InstanceOf, MemberOf};

/// From this number on, shapes are packed over several frames.
const MANY: usize = 16_384;
/// The time per frame for packing.
pub(in crate::engine) const LONGEST: Duration = Duration::from_millis(15);
/// The shapes that are packed between two checks of the clock.
const STEP: usize = 256;

/// The unfinished packing of all shapes.
pub(in crate::engine) enum Packing {
    Reading(Box<Reading>),
    Building {
        built: Receiver<std::thread::Result<Built>>,
        moved: Vec<bool>,
    },
}

/// The shapes that have been read so far.
pub(in crate::engine) struct Reading {
    rest: std::vec::IntoIter<(DocumentOrder, Entity)>,
    pub is_of_many: bool,
    groups: HashMap<Entity, usize>,
    pub in_world: Vec<Instance>,
    pub records: Vec<InstanceRecord>,
    pub members: Vec<(Vec<Instance>, Vec<InstanceRecord>)>,
    pub placed: Vec<PlacedGroup>,
    pub errors: BTreeMap<(DocumentOrder, Entity), String>,
    pub meshes_loading: u32,
}

/// The shapes with the hierarchy over them.
pub(in crate::engine) struct Built {
    pub layout: Layout,
    pub geometry: Tlas,
    pub entities: Vec<Entity>,
    pub errors: Vec<String>,
    pub method: SplitMethod,
}

impl Built {
    pub fn of(layout: Layout, instances: PackedShapes, method: SplitMethod) -> Self {
        let mut errors = Vec::new();
        let (geometry, entities) = layout.build(instances, method, &mut errors);
        Self {
            layout,
            geometry,
            entities,
            errors,
            method,
        }
    }

    pub fn on_other_thread(
        pool: &ThreadPool,
        wake_up: &WakeUp,
        layout: Layout,
        instances: PackedShapes,
        method: SplitMethod,
    ) -> Receiver<std::thread::Result<Self>> {
        let (sender, built) = bounded(1);
        let wake_up = wake_up.clone();
        pool.spawn(move || {
            let built = catch_unwind(AssertUnwindSafe(|| Self::of(layout, instances, method)));
            // The receiver is gone if another scene has been opened.
            let _ = sender.send(built);
            if let Some(wake) = wake_up.0 {
                wake();
            }
        });
        built
    }
}

impl Reading {
    /// Lists the shapes. All meshes must be requested until [`Self::go_on`] is done.
    pub fn begin(authored: &Authored, cache: &mut BlasCache) -> Self {
        let shapes = authored.shapes.iter();
        let mut shapes: Vec<_> = shapes.map(|shape| (*shape.order, shape.entity)).collect();
        shapes.sort_unstable();
        cache.begin_use();
        let mut groups: Vec<_> = authored.groups.iter().map(|(entity, &order)| (order, entity)).collect();
        groups.sort();
        let groups: HashMap<Entity, usize> = groups.into_iter().zip(0..).map(|((_, group), i)| (group, i)).collect();
        Self {
            is_of_many: shapes.len() >= MANY,
            rest: shapes.into_iter(),
            in_world: Vec::new(),
            records: Vec::new(),
            members: groups.iter().map(|_| default()).collect(),
            groups,
            placed: Vec::new(),
            errors: BTreeMap::new(),
            meshes_loading: 0,
        }
    }

    /// Packs the remaining shapes, or as many as there is time for; true once all are packed.
    pub fn go_on(
        &mut self,
        authored: &Authored,
        cache: &mut BlasCache,
        policy: &BuildPolicy,
        longest: Option<Duration>,
    ) -> bool {
        let begun = Instant::now();
        while self.rest.len() > 0 && longest.is_none_or(|longest| begun.elapsed() < longest) {
            let step: Vec<_> = self.rest.by_ref().take(STEP).collect();
            for (order, entity) in step {
                let packed = self.pack(order, entity, authored, cache, policy);
                self.in_world.extend(packed);
            }
        }
        self.rest.len() == 0
    }

    /// Packs one shape; the result is part of the world itself. `order` is the shape's order in the list.
    fn pack(
        &mut self,
        order: DocumentOrder,
        entity: Entity,
        authored: &Authored,
        cache: &mut BlasCache,
        policy: &BuildPolicy,
    ) -> Option<Instance> {
        let shape = authored.shapes.get(entity).ok()?;
        if let Some((InstanceOf(group), placements)) = shape.instance_of
            && let Some(&group) = self.groups.get(group)
        {
            self.placed.push(PlacedGroup {
                entity,
                name: shape.name(),
                group,
                places: placements.map_or_else(|| Arc::new(vec![shape.to_world.0.into()]), |many| many.places.clone()),
            });
            return None;
        }
        let mesh = mesh_of(shape.shape, &shape.to_world.0, shape.mesh, authored, cache, policy);
        self.meshes_loading += u32::from(mesh.is_loading);
        let source = ShapeSource {
            order,
            ..shape.source()
        };
        let (instance, record) = match pack_instance(&source, mesh.built) {
            Ok(packed) => packed?,
            Err(error) => {
                self.errors
                    .insert((order, entity), format!("{}: {error}", shape.name()));
                return None;
            }
        };
        match shape.member_of.and_then(|MemberOf(group)| self.groups.get(group)) {
            Some(&group) => {
                self.members[group].0.push(instance);
                self.members[group].1.push(record);
                None
            }
            None => {
                self.records.push(record);
                Some(instance)
            }
        }
    }
}
