//! The acceleration structures of meshes, one per mesh asset for all its shapes, built in the background or at once.

use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Arc;
use std::time::Instant;

use bevy::math::Mat3;
use bevy::prelude::*;
use crossbeam_channel::{Receiver, Sender, unbounded};
use rayon::{ThreadPool, ThreadPoolBuildError};

use super::control::WakeUp;
use super::instances::solid_meshes::SolidMeshes;
use super::run::text_of_panic;
use crate::accel::{Blas, BvhStats, CurveBlas, Primitive, SplitMethod};
use crate::geometry::curve::Basis;
use crate::geometry::mesh::MeshData;
use crate::geometry::primitives::{unit_cube, unit_triangle};
use crate::memory::Shortage;
use crate::scene::{Solid, TriangleMesh};

/// The triangles and parts of curves up to which a hierarchy is built at once on request: that takes about a
/// millisecond, less than a frame.
const SMALL: usize = 4096;

/// The bits of the identity, see [`MeshKey::Curves`].
const UNSTRETCHED: [u32; 9] = {
    let (one, zero) = (1.0_f32.to_bits(), 0.0_f32.to_bits());
    [one, zero, zero, zero, one, zero, zero, zero, one]
};

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum MeshKey {
    Asset {
        id: AssetId<TriangleMesh>,
        shape_index: u32,
        /// Whether the texture coordinates of the asset are flipped.
        upside_down: bool,
    },
    Curves {
        id: AssetId<TriangleMesh>,
        basis: Basis,
        /// The bits of the transform of control points that leaves radii alone, see [`stretch_of`].
        ///
        /// [`stretch_of`]: crate::geometry::strands::stretch_of
        stretch: [u32; 9],
    },
    Cube,
    Triangle,
    /// A building part, by its number among the parts in use.
    Solid(u64),
}

impl MeshKey {
    /// Whether these are the same curves with any stretch.
    fn is_similar(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Curves { id, basis, .. }, Self::Curves { id: its, basis: of, .. }) => (id, basis) == (its, of),
            _ => false,
        }
    }
}

/// A mesh, or the curves of a file, that can be rendered.
#[derive(Clone, Debug)]
pub(super) struct BuiltMesh {
    pub primitive: Primitive,
    /// The transform that was applied to the control points of curves.
    pub stretch: Mat3,
    pub stats: BvhStats,
    /// Materials its triangles refer to, at least 1.
    pub slots: u32,
    pub build_ms: f64,
}

/// Says why a mesh has no acceleration structure.
#[derive(Debug, thiserror::Error)]
pub(super) enum BuildError {
    #[error("{triangles} triangles with flipped texture coordinates need {shortage}")]
    Memory { triangles: usize, shortage: Shortage },
    #[error("{points} control points of curves that are scaled need {shortage}")]
    MemoryOfCurves { points: usize, shortage: Shortage },
    #[error("no threads for building: {0}")]
    Threads(#[from] ThreadPoolBuildError),
    /// A fault of the program, with its message.
    #[error("building an acceleration structure failed: {0}")]
    Panic(String),
}

struct Entry {
    /// The mesh of the last request.
    data: Arc<MeshData>,
    method: SplitMethod,
    /// The hierarchy, perhaps of older data while a build is running.
    built: Option<BuiltMesh>,
    /// The build that is running.
    ticket: Option<u64>,
    /// The number of the last build, which grows from build to build.
    number: u64,
    failure: Option<BuildError>,
    used: bool,
}

struct Finished {
    key: MeshKey,
    ticket: u64,
    result: Result<BuiltMesh, BuildError>,
}

#[derive(Resource)]
pub(super) struct BlasCache {
    entries: HashMap<MeshKey, Entry>,
    cube: Arc<MeshData>,
    triangle: Arc<MeshData>,
    solids: SolidMeshes,
    next_ticket: u64,
    sender: Sender<Finished>,
    finished: Receiver<Finished>,
    /// A pool beside the render threads, which are busy until their picture is done. None until it is needed.
    pool: Option<ThreadPool>,
}

impl Default for BlasCache {
    fn default() -> Self {
        let (sender, finished) = unbounded();
        Self {
            entries: HashMap::new(),
            cube: Arc::new(unit_cube()),
            triangle: Arc::new(unit_triangle()),
            solids: SolidMeshes::default(),
            next_ticket: 0,
            sender,
            finished,
            pool: None,
        }
    }
}

/// The settings for building a mesh that has no hierarchy yet.
#[derive(Clone)]
pub(super) struct BuildPolicy {
    pub method: SplitMethod,
    pub threads: usize,
    /// Whether to wait until the build is done.
    pub wait: bool,
    pub wake_up: WakeUp,
}

impl BlasCache {
    pub fn cube(&self) -> Arc<MeshData> {
        self.cube.clone()
    }

    pub fn triangle(&self) -> Arc<MeshData> {
        self.triangle.clone()
    }

    /// The mesh of a building part and its key. Parts with equal dimensions share them.
    pub fn solid(&mut self, part: &Solid) -> (MeshKey, Arc<MeshData>) {
        let (number, mesh) = self.solids.get(part);
        (MeshKey::Solid(number), mesh)
    }

    /// Takes in the builds that are done; true if there were any.
    pub fn poll(&mut self) -> bool {
        let mut any = false;
        while let Ok(Finished { key, ticket, result }) = self.finished.try_recv() {
            let Some(entry) = self.entries.get_mut(&key).filter(|entry| entry.ticket == Some(ticket)) else {
                // The result is outdated or no longer needed.
                continue;
            };
            entry.finish(result);
            any = true;
        }
        any
    }

    pub fn builds_running(&self) -> usize {
        self.entries.values().filter(|entry| entry.ticket.is_some()).count()
    }

    pub fn failures(&self) -> impl Iterator<Item = &BuildError> {
        self.entries.values().filter_map(|entry| entry.failure.as_ref())
    }

    /// The meshes in use, without repetition.
    pub fn in_use(&self) -> impl Iterator<Item = &BuiltMesh> {
        self.entries.values().filter_map(|entry| entry.built.as_ref())
    }

    /// Begins a round of requests. Every mesh in use must be requested before [`Self::end_use`].
    pub fn begin_use(&mut self) {
        self.entries.values_mut().for_each(|entry| entry.used = false);
    }

    /// Drops the meshes that were not requested in this round.
    pub fn end_use(&mut self) {
        self.entries.retain(|_, entry| entry.used);
        let entries = &self.entries;
        self.solids
            .retain(|number| entries.contains_key(&MeshKey::Solid(number)));
    }

    /// Drops the finished hierarchies for which `is_used` is false.
    pub fn retain(&mut self, is_used: impl Fn(&Primitive) -> bool) {
        self.entries.retain(|_, entry| {
            entry.ticket.is_some() || entry.built.as_ref().is_none_or(|built| is_used(&built.primitive))
        });
        let entries = &self.entries;
        self.solids
            .retain(|number| entries.contains_key(&MeshKey::Solid(number)));
    }

    /// Keeps the hierarchy of a mesh whose data are not available at the moment.
    pub fn keep(&mut self, key: MeshKey) -> Option<&BuiltMesh> {
        let entry = self.entries.get_mut(&key)?;
        entry.used = true;
        entry.built.as_ref()
    }

    /// The mesh prepared for rays. While it is being built, the result is the old one, or None if there is none.
    pub fn get(&mut self, key: MeshKey, data: &Arc<MeshData>, policy: &BuildPolicy) -> Option<&BuiltMesh> {
        let current = self
            .entries
            .get(&key)
            .is_some_and(|entry| Arc::ptr_eq(&entry.data, data) && entry.method == policy.method);
        if !current && (policy.wait || !self.is_similar_pending(&key)) {
            self.start(key, data, policy);
        }
        let pending = self.entries.get(&key).is_some_and(|entry| entry.ticket.is_some());
        if pending && policy.wait {
            self.wait_for(key);
        }
        match self.keep(key).is_some() {
            true => self.keep(key),
            false => self.similar_curves(key),
        }
    }

    /// Whether the same curves are being built with another stretch. Curves that are scaled with the mouse ask for a
    /// stretch in each frame: only one is built at a time, and they ask again when it is done.
    fn is_similar_pending(&self, key: &MeshKey) -> bool {
        let mut others = self.entries.iter().filter(|(other, _)| *other != key);
        others.any(|(other, entry)| entry.ticket.is_some() && other.is_similar(key))
    }

    /// The same curves with another stretch, the newest ones, which are shown until those sought are built. A build of
    /// them that is running stays in use.
    fn similar_curves(&mut self, sought: MeshKey) -> Option<&BuiltMesh> {
        let similar = self.entries.iter_mut().filter(|(key, _)| key.is_similar(&sought));
        let mut newest: Option<&mut Entry> = None;
        for (_, entry) in similar {
            entry.used |= entry.ticket.is_some();
            let is_newer = newest.as_ref().is_none_or(|newest| newest.number < entry.number);
            if entry.built.is_some() && is_newer {
                newest = Some(entry);
            }
        }
        let newest = newest?;
        newest.used = true;
        newest.built.as_ref()
    }

    /// Whether a hierarchy needs a copy of its mesh, with memory of its own. The memory that came with a file is for
    /// one hierarchy of its curves as they are, and a file may hold the control points of splines and of lines.
    fn needs_copy(&self, key: &MeshKey, data: &Arc<MeshData>) -> bool {
        let is_unstretched = |key: &MeshKey| matches!(key, MeshKey::Curves { stretch, .. } if *stretch == UNSTRETCHED);
        let mut others = self.entries.iter().filter(|(other, _)| *other != key);
        match is_unstretched(key) {
            true => others.any(|(other, entry)| is_unstretched(other) && Arc::ptr_eq(&entry.data, data)),
            false => matches!(key, MeshKey::Curves { .. }),
        }
    }

    fn start(&mut self, key: MeshKey, data: &Arc<MeshData>, policy: &BuildPolicy) {
        let ticket = self.next_ticket;
        self.next_ticket += 1;
        let old = self.entries.remove(&key);
        let same_method = old.as_ref().is_some_and(|old| old.method == policy.method);
        let built = old.and_then(|old| old.built);
        let similar = built.as_ref().filter(|_| same_method);
        let similar = similar.and_then(|built| match &built.primitive {
            Primitive::Mesh(blas) => Some(blas.clone()),
            _ => None,
        });
        let mut entry = Entry {
            data: data.clone(),
            method: policy.method,
            built,
            ticket: Some(ticket),
            number: ticket,
            failure: None,
            used: true,
        };
        let parts = match key {
            MeshKey::Curves { basis, .. } => data.strands.most_parts(basis),
            _ => 0,
        };
        let is_copied = self.needs_copy(&key, data);
        let (data, method) = (data.clone(), policy.method);
        if data.triangles.len() + parts <= SMALL {
            entry.finish(build(key, data, method, similar, is_copied));
        } else {
            let (sender, wake_up) = (self.sender.clone(), policy.wake_up.clone());
            let task = move || {
                let result = build(key, data, method, similar, is_copied);
                // The receiver is gone when the application ends.
                let _ = sender.send(Finished { key, ticket, result });
                if let Some(wake) = wake_up.0 {
                    wake();
                }
            };
            match self.pool(policy.threads) {
                Ok(pool) => pool.spawn(task),
                Err(error) => entry.finish(Err(error.into())),
            }
        }
        self.entries.insert(key, entry);
    }

    fn wait_for(&mut self, key: MeshKey) {
        while self.entries.get(&key).is_some_and(|entry| entry.ticket.is_some()) {
            let Ok(Finished { key, ticket, result }) = self.finished.recv() else {
                return;
            };
            if let Some(entry) = self.entries.get_mut(&key).filter(|entry| entry.ticket == Some(ticket)) {
                entry.finish(result);
            }
        }
    }

    /// The pool with this number of threads, which replaces one with another number.
    pub fn pool(&mut self, threads: usize) -> Result<&ThreadPool, ThreadPoolBuildError> {
        let pool = match self.pool.take() {
            Some(pool) if pool.current_num_threads() == threads => pool,
            _ => rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .thread_name(|index| format!("build {index}"))
                .build()?,
        };
        Ok(self.pool.insert(pool))
    }
}

impl Entry {
    fn finish(&mut self, result: Result<BuiltMesh, BuildError>) {
        self.ticket = None;
        match result {
            Ok(built) => self.built = Some(built),
            Err(error) => self.failure = Some(error),
        }
    }
}

/// Builds a hierarchy. `similar` is the hierarchy of the mesh before its change, built by the same method. `is_copied`
/// says whether curves need a copy of their mesh, see [`BlasCache::needs_copy`].
fn build(
    key: MeshKey,
    mut data: Arc<MeshData>,
    method: SplitMethod,
    similar: Option<Arc<Blas>>,
    is_copied: bool,
) -> Result<BuiltMesh, BuildError> {
    let begin = Instant::now();
    if let MeshKey::Curves { basis, stretch, .. } = key {
        let stretch = Mat3::from_cols_array(&stretch.map(f32::from_bits));
        return build_curves(data, basis, &stretch, method, is_copied);
    }
    if matches!(key, MeshKey::Asset { upside_down: true, .. }) {
        let flipped = data.with_flipped_tex_coords();
        let flipped = flipped.map_err(|shortage| {
            let triangles = data.triangles.len();
            BuildError::Memory { triangles, shortage }
        });
        data = Arc::new(flipped?);
    }
    let slots = data
        .material_of_triangle
        .iter()
        .max()
        .map_or(1, |&highest| u32::from(highest) + 1);
    let slots = slots.max(data.materials.len() as u32);
    let refitted = || similar.and_then(|similar| similar.refit(data.clone()));
    let blas = caught(|| refitted().unwrap_or_else(|| Blas::build(data.clone(), method)))?;
    Ok(BuiltMesh {
        stats: blas.stats(),
        primitive: Primitive::Mesh(Arc::new(blas)),
        stretch: Mat3::IDENTITY,
        slots,
        build_ms: begin.elapsed().as_secs_f64() * 1e3,
    })
}

fn build_curves(
    mut data: Arc<MeshData>,
    basis: Basis,
    stretch: &Mat3,
    method: SplitMethod,
    is_copied: bool,
) -> Result<BuiltMesh, BuildError> {
    let begin = Instant::now();
    if is_copied {
        let stretched = data.with_stretched_strands(stretch).map_err(|shortage| {
            let points = data.strands.points.len();
            BuildError::MemoryOfCurves { points, shortage }
        });
        data = Arc::new(stretched?);
    }
    let curves = caught(|| CurveBlas::build(data, basis, method))?;
    Ok(BuiltMesh {
        stats: curves.stats(),
        primitive: Primitive::Curves(Arc::new(curves)),
        stretch: *stretch,
        slots: 1,
        build_ms: begin.elapsed().as_secs_f64() * 1e3,
    })
}

/// The result of a build, or an error with the message of its panic.
fn caught<T>(build: impl FnOnce() -> T) -> Result<T, BuildError> {
    catch_unwind(AssertUnwindSafe(build)).map_err(|payload| BuildError::Panic(text_of_panic(payload.as_ref())))
}

#[cfg(test)]
mod tests;
