//! The guide that the workers of a picture share, and learn together.

use std::fmt;
use std::ops::Range;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};

use super::field::{Field, PhotonArrival};
use crate::render::scene::RenderScene;
use crate::render::together::Together;

/// The paths from the lights that a guide is learnt from: some 0.2 seconds of one thread.
const PATHS: u32 = 1 << 16;
/// The paths of a block.
const PATHS_OF_BLOCK: u32 = 1024;

/// A request for guided paths, with the guide that was learnt last. Clones share it.
///
/// It is a store and no part of what a picture depends on, so that any two are equal.
#[derive(Clone, Default)]
pub struct Guide(Arc<Mutex<Option<Arc<Learnt>>>>);

/// What a guide depends on besides the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::render) struct PhotonPaths {
    pub longest_path: u32,
    pub rr_depth: u32,
}

/// A guide, with all that it depends on.
struct Learnt {
    scene: RenderScene,
    paths: PhotonPaths,
    field: Together<Vec<PhotonArrival>, Option<Arc<Field>>>,
}

impl Guide {
    /// The guide of a scene, or None where there is nothing to be guided by. None at all if cancelled. `trace` traces the paths from the lights with these numbers.
    pub(in crate::render) fn field(
        &self,
        scene: &RenderScene,
        paths: PhotonPaths,
        trace: impl Fn(Range<u32>) -> Vec<PhotonArrival>,
        cancel: &AtomicBool,
    ) -> Option<Option<Arc<Field>>> {
        let learnt = self.learnt(scene, paths);
        let trace = |block: u32| {
            let first = block * PATHS_OF_BLOCK;
            trace(first..first + PATHS_OF_BLOCK)
        };
        let learn = |arrivals: Vec<Vec<PhotonArrival>>| Field::learn(&arrivals.concat()).map(Arc::new);
        learnt.field.get(trace, learn, cancel)
    }

    fn learnt(&self, scene: &RenderScene, paths: PhotonPaths) -> Arc<Learnt> {
        let mut last = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let is_same = |learnt: &&Arc<Learnt>| learnt.paths == paths && learnt.scene.is_same(scene);
        if let Some(same) = last.as_ref().filter(is_same) {
            return same.clone();
        }
        let learnt = Arc::new(Learnt {
            scene: scene.clone(),
            paths,
            field: Together::new((PATHS / PATHS_OF_BLOCK) as usize),
        });
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
