//! Decides whether a few shapes are packed or all, and takes in the results.

use std::panic::resume_unwind;
use std::sync::Arc;

use crossbeam_channel::TryRecvError;

use super::packing::{Built, LONGEST, Packing, Reading};
use super::splice::ShapeChanges;
use crate::engine::authored::Authored;
use crate::engine::blas_cache::{BlasCache, BuildError, BuildPolicy};
use crate::engine::detect::Touched;
use crate::engine::extract::Extracted;
use crate::engine::pack::group::Layout;

impl Extracted {
    /// Brings the shapes up to date. Returns the instances that have moved or changed; None while all are being packed,
    /// which continues in the next frame. Shapes that stay in `touched` are for a later frame.
    pub(in crate::engine) fn update_shapes(
        &mut self,
        touched: &mut Touched,
        authored: &Authored,
        cache: &mut BlasCache,
        policy: &BuildPolicy,
    ) -> Option<ShapeChanges> {
        if self.packing.is_none()
            && let Touched::These(shapes) = &*touched
            && let Some(changes) = self.edit_shapes(shapes, authored, cache, policy)
        {
            *touched = Touched::default();
            return Some(changes);
        }
        if self.packing.is_none() {
            // Changes from now on are packed again.
            *touched = Touched::default();
        }
        let mut moved = self.pack_all(authored, cache, policy)?;
        if let Touched::These(shapes) = &*touched
            && !shapes.is_empty()
        {
            *touched = match self.edit_shapes(shapes, authored, cache, policy) {
                Some(_) => {
                    moved = vec![true; self.layout.shapes.len()];
                    Touched::default()
                }
                None => Touched::All,
            };
        }
        Some(ShapeChanges { moved, edits: None })
    }

    /// Starts or continues packing all shapes. Returns the instances that have moved or changed once that is done.
    pub(in crate::engine) fn pack_all(
        &mut self,
        authored: &Authored,
        cache: &mut BlasCache,
        policy: &BuildPolicy,
    ) -> Option<Vec<bool>> {
        let packing = self.packing.take().unwrap_or_else(|| {
            self.packs_revision = authored.status.revision;
            Packing::Reading(Reading::begin(authored, cache).into())
        });
        match packing {
            Packing::Reading(mut reading) => {
                let is_sliced = !policy.wait && reading.is_of_many;
                let is_done = reading.go_on(authored, cache, policy, is_sliced.then_some(LONGEST));
                if !is_done {
                    self.packing = Some(Packing::Reading(reading));
                    return None;
                }
                self.build(*reading, cache, policy, is_sliced)
            }
            Packing::Building { built, moved } => match built.try_recv() {
                Ok(result) => {
                    let built = result.unwrap_or_else(|panic| resume_unwind(panic));
                    self.take_in(built, cache);
                    Some(moved)
                }
                Err(TryRecvError::Empty) => {
                    self.packing = Some(Packing::Building { built, moved });
                    None
                }
                // The thread has ended with the pool, so all shapes are packed again.
                Err(TryRecvError::Disconnected) => self.pack_all(authored, cache, policy),
            },
        }
        .inspect(|_| self.packed_revision = authored.status.revision)
    }

    /// Builds the hierarchy over the shapes, if any of them differs.
    fn build(
        &mut self,
        reading: Reading,
        cache: &mut BlasCache,
        policy: &BuildPolicy,
        on_other_thread: bool,
    ) -> Option<Vec<bool>> {
        cache.end_use();
        self.errors.instances = reading.errors;
        self.errors.meshes = cache.failures().map(BuildError::to_string).collect();
        self.meshes_loading = reading.meshes_loading;
        let (layout, instances) = Layout::new(
            (reading.in_world.into(), reading.records),
            reading.members,
            reading.placed,
        );
        let moved = layout.moved_since(&self.layout);
        if !moved.contains(&true)
            && self.layout.shapes.len() == layout.shapes.len()
            && layout.placed_as(&self.layout)
            && layout.is_of_same_entities(&self.layout)
            && self.method == policy.method
        {
            self.layout = layout;
            return Some(moved);
        }
        let method = policy.method;
        if on_other_thread && let Ok(pool) = cache.pool(policy.threads) {
            let built = Built::on_other_thread(pool, &policy.wake_up, layout, instances, method);
            self.packing = Some(Packing::Building { built, moved });
            return None;
        }
        self.take_in(Built::of(layout, instances, method), cache);
        Some(moved)
    }

    fn take_in(&mut self, built: Built, cache: &BlasCache) {
        self.layout = built.layout;
        self.errors.placements = built.errors;
        self.scene.geometry = Arc::new(built.geometry);
        self.entity_of_instance = built.entities.into();
        self.method = built.method;
        self.triangles = self.scene.geometry.triangles();
        self.rebuild = None;
        self.update_figures(cache);
    }
}
