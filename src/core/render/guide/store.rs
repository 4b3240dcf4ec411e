//! The guide that the workers of a picture share, and learn together.

use std::fmt;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use super::PATHS;
use super::field::{Field, PhotonArrival};
use crate::render::scene::RenderScene;
use crate::render::together::Together;

/// The paths of a block.
const PATHS_OF_BLOCK: u32 = 1024;

/// A request for guided paths, with the last learnt guide. Clones share it.
///
/// It is a cache on which no picture depends, so that any two are equal.
#[derive(Clone, Default)]
pub struct Guide(Arc<Store>);

#[derive(Default)]
struct Store {
    last: Mutex<Option<Arc<Learnt>>>,
    learnings: AtomicU32,
    /// The rays that were traced for learning and not yet taken.
    rays: AtomicU64,
    /// The rays that the pilot of the integrator `auto` traced for learning.
    rays_of_pilot: AtomicU64,
}

/// The photons of some light paths.
pub(in crate::render) struct Photons {
    pub arrivals: Vec<PhotonArrival>,
    pub rays: u64,
}

/// The settings that a guide depends on besides the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::render) struct PhotonPaths {
    pub longest_path: u32,
    pub rr_depth: u32,
}

/// A guide, with all its inputs.
struct Learnt {
    scene: RenderScene,
    paths: PhotonPaths,
    field: Together<Vec<PhotonArrival>, Option<Arc<Field>>>,
}

impl Guide {
    /// The guide of a scene, with an inner None if there is no light to guide paths; None if cancelled. `trace` traces
    /// the light paths with these numbers.
    pub(in crate::render) fn field(
        &self,
        scene: &RenderScene,
        paths: PhotonPaths,
        trace: impl Fn(Range<u32>) -> Photons,
        cancel: &AtomicBool,
    ) -> Option<Option<Arc<Field>>> {
        let learnt = self.learnt(scene, paths);
        let trace = |block: u32| {
            let first = block * PATHS_OF_BLOCK;
            let photons = trace(first..first + PATHS_OF_BLOCK);
            self.0.rays.fetch_add(photons.rays, Ordering::Relaxed);
            photons.arrivals
        };
        let learn = |arrivals: Vec<Vec<PhotonArrival>>| Field::learn(&arrivals.concat()).map(Arc::new);
        learnt.field.get(trace, learn, cancel)
    }

    /// How often a guide was learnt, for a scene and settings unlike the last ones.
    pub fn learnings(&self) -> u32 {
        self.0.learnings.load(Ordering::Relaxed)
    }

    /// The rays traced for learning since the last call.
    pub fn take_rays(&self) -> u64 {
        self.0.rays.swap(0, Ordering::Relaxed)
    }

    /// Counts the rays that were not yet taken as a pilot's, so that no picture counts them.
    pub(in crate::render) fn leave_rays_to_pilot(&self) {
        self.0.rays_of_pilot.fetch_add(self.take_rays(), Ordering::Relaxed);
    }

    /// The rays that pilots have traced for learning.
    pub fn rays_of_pilot(&self) -> u64 {
        self.0.rays_of_pilot.load(Ordering::Relaxed)
    }

    /// The memory of the last learnt guide, in bytes; 0 if there is none.
    pub fn bytes(&self) -> u64 {
        let last = self.0.last.lock().unwrap_or_else(PoisonError::into_inner);
        let field = last.as_ref().and_then(|learnt| learnt.field.known()).flatten();
        field.map_or(0, |field| field.bytes() as u64)
    }

    /// Whether both share their guide.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }

    fn learnt(&self, scene: &RenderScene, paths: PhotonPaths) -> Arc<Learnt> {
        let mut last = self.0.last.lock().unwrap_or_else(PoisonError::into_inner);
        let is_same = |learnt: &&Arc<Learnt>| learnt.paths == paths && learnt.scene.is_same(scene);
        if let Some(same) = last.as_ref().filter(is_same) {
            return same.clone();
        }
        let learnt = Arc::new(Learnt {
            scene: scene.clone(),
            paths,
            field: Together::new((PATHS / PATHS_OF_BLOCK) as usize),
        });
        self.0.learnings.fetch_add(1, Ordering::Relaxed);
        *last = Some(learnt.clone());
        learnt
    }
}

impl PartialEq for Guide {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl fmt::Debug for Guide {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Guide")
    }
}
