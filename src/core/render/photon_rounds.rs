//! The photons of a picture, round by round: round number n is sample number n of all pixels, which share its photons.
//! They are a function of the scene, the view and the number of the round alone, so that they can be traced whenever a
//! worker needs them, and dropped.
//!
//! A missing round is traced by all workers that wait for it, each of which traces some blocks of its paths.

use std::fmt;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, PoisonError};

use super::photon_map::{MergeArea, Photon, PhotonMap};
use super::scene::RenderScene;
use super::together::Together;
use crate::sampling::SequenceKind;

/// The number of light paths per block.
pub(super) const PATHS_OF_BLOCK: u32 = 1024;
/// The number of cached rounds: those of two of the longest passes, since some workers start the next pass while others
/// finish the last.
const KEPT: usize = 32;

/// The cache of photons that the workers of a picture share. Clones share it too.
///
/// Pictures do not depend on the cache, so that any two are equal.
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

/// The settings that a round's photons depend on besides the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RoundId {
    pub number: u32,
    pub sequence: SequenceKind,
    pub seed: u32,
    /// The number of light paths.
    pub paths: u32,
    pub area: MergeArea,
    pub longest_path: u32,
    pub rr_depth: u32,
}

struct Round {
    scene: RenderScene,
    id: RoundId,
    map: Together<Vec<Photon>, Arc<PhotonMap>>,
}

impl PhotonRounds {
    /// The number of cached rounds.
    pub fn kept(&self) -> usize {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).len()
    }

    /// The photons of a round of a scene. `trace` traces block number n of its paths; None if `cancel` was set in the
    /// meantime.
    pub(super) fn get(
        &self,
        scene: &RenderScene,
        id: RoundId,
        trace: impl Fn(u32) -> Vec<Photon>,
        cancel: &AtomicBool,
    ) -> Option<Arc<PhotonMap>> {
        let round = self.round(scene, id);
        let map = |blocks: Vec<Vec<Photon>>| Arc::new(PhotonMap::new(blocks.concat()));
        round.map.get(trace, map, cancel)
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
        // The last round is the least recently used one.
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
            map: Together::new(blocks),
        }
    }
}
