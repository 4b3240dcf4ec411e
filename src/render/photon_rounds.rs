//! The photons of a picture, round by round: round number n is sample number n of all pixels, which see the same photons. They are a function of the scene, the
//! view and the number of the round alone, so that they may be traced whenever a worker needs them, and thrown away.
//!
//! A round that is not there yet is traced by all workers that wait for it, a block of its paths each.

use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, OnceLock, PoisonError};

use super::photon_map::{MergeArea, Photon, PhotonMap};
use super::scene::RenderScene;
use crate::sampling::SequenceKind;

/// The paths from the lights of a block.
pub(super) const PATHS_OF_BLOCK: u32 = 1024;
/// The rounds that are kept: those of two of the longest passes, since some workers have begun the next one while others are at the last.
const KEPT: usize = 32;

/// The photons that the workers of a picture share. Clones share them too.
///
/// It is a store and no part of what a picture depends on, so that any two are equal.
#[derive(Clone, Default)]
pub struct PhotonRounds(Arc<Mutex<Vec<Arc<Round>>>>);

impl PartialEq for PhotonRounds {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl fmt::Debug for PhotonRounds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("PhotonRounds")
    }
}

/// What the photons of a round depend on besides the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RoundId {
    pub number: u32,
    pub sequence: SequenceKind,
    pub seed: u32,
    /// The paths from the lights.
    pub paths: u32,
    pub area: MergeArea,
    pub longest_path: u32,
    pub rr_depth: u32,
}

struct Round {
    scene: RenderScene,
    id: RoundId,
    /// The photons of each block, until the map has them.
    blocks: Vec<Mutex<Option<Vec<Photon>>>>,
    /// The number of the next block that no worker has begun.
    next: AtomicUsize,
    /// The blocks that are done, or are not going to be.
    done: Mutex<usize>,
    progress: Condvar,
    /// None if a block has failed.
    map: OnceLock<Option<Arc<PhotonMap>>>,
}

impl PhotonRounds {
    /// The number of rounds that are kept at this moment.
    pub fn kept(&self) -> usize {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).len()
    }

    /// The photons of a round of a scene. `trace` traces block number n of its paths; None if `cancel` was set in the meantime.
    pub(super) fn get(
        &self,
        scene: &RenderScene,
        id: RoundId,
        trace: impl Fn(u32) -> Vec<Photon>,
        cancel: &AtomicBool,
    ) -> Option<Arc<PhotonMap>> {
        let round = self.round(scene, id);
        if let Some(map) = round.map.get() {
            return map.clone();
        }
        while !cancel.load(Ordering::Relaxed) {
            let number = round.next.fetch_add(1, Ordering::Relaxed);
            let Some(block) = round.blocks.get(number) else {
                return round.map();
            };
            let counted = Counted(&round);
            let photons = trace(number as u32);
            *block.lock().unwrap_or_else(PoisonError::into_inner) = Some(photons);
            drop(counted);
        }
        None
    }

    fn round(&self, scene: &RenderScene, id: RoundId) -> Arc<Round> {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let round = match kept
            .iter()
            .position(|round| round.id == id && round.scene.is_same(scene))
        {
            Some(place) => kept.remove(place),
            None => Arc::new(Round::new(scene.clone(), id)),
        };
        // The last one has waited longest for a worker.
        kept.insert(0, round.clone());
        kept.truncate(KEPT);
        round
    }
}

impl Round {
    fn new(scene: RenderScene, id: RoundId) -> Self {
        let blocks = id.paths.div_ceil(PATHS_OF_BLOCK) as usize;
        Self {
            scene,
            id,
            blocks: std::iter::repeat_with(Mutex::default).take(blocks).collect(),
            next: AtomicUsize::new(0),
            done: Mutex::new(0),
            progress: Condvar::new(),
            map: OnceLock::new(),
        }
    }

    /// Waits for the blocks that others are at, and makes the map of all. None if one of them has failed.
    fn map(&self) -> Option<Arc<PhotonMap>> {
        let done = self.done.lock().unwrap_or_else(PoisonError::into_inner);
        let waits = |done: &mut usize| *done < self.blocks.len();
        drop(self.progress.wait_while(done, waits));
        let photons = |block: &Mutex<Option<Vec<Photon>>>| block.lock().unwrap_or_else(PoisonError::into_inner).take();
        let map = || {
            let blocks: Option<Vec<Vec<Photon>>> = self.blocks.iter().map(photons).collect();
            blocks.map(|blocks| Arc::new(PhotonMap::new(blocks.concat())))
        };
        self.map.get_or_init(map).clone()
    }
}

/// Counts a block when it is done, and also when its worker panics: the others must not wait for it.
struct Counted<'a>(&'a Round);

impl Drop for Counted<'_> {
    fn drop(&mut self) {
        *self.0.done.lock().unwrap_or_else(PoisonError::into_inner) += 1;
        self.0.progress.notify_all();
    }
}
