//! A limit on the brightness of samples. A few samples that are far brighter than all others ("fireflies") are noise
//! that takes very many samples to average out; a picture in which they are darkened to the limit has less noise, and
//! too little light.
//!
//! The limit is a percentile of the samples of a pilot (`fireflies`). It depends on the scene and the view alone, so
//! that any part of a picture, rendered anywhere, has the same.

use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use super::camera::Camera;
use super::fireflies::Pilot;
use super::scene::RenderScene;
use super::together::Together;

/// The percentile of the samples' light that is the limit, with a cache of limits. Clones share the cache.
///
/// Pictures do not depend on the cache: two clamps are equal if their percentiles are.
#[derive(Clone)]
pub struct Clamp {
    /// The percentage of the samples with light that the clamp does not change; above 0 and below 100.
    pub percentile: f32,
    limits: Arc<Mutex<Vec<KnownLimit>>>,
}

/// The limit of a scene in a view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrightnessLimit {
    /// The greatest luminance of a sample's light, W/(m^2 sr), without lamps that the camera sees directly, in mirrors
    /// and through glass.
    pub luminance: f32,
    /// The share of the picture's light that the clamp removes, from 0 to 1, as estimated by the pilot.
    pub removed: f32,
}

struct KnownLimit {
    scene: RenderScene,
    camera: Camera,
    size: [u32; 2],
    from_lights: bool,
    limit: Arc<Search>,
}

/// The search for a limit by all workers that wait for it. Its parts and its result are None if it was cancelled.
type Search = Together<Option<Pilot>, Option<BrightnessLimit>>;

/// The number of cached limits, each with its scene: for path tracing and for light paths.
const KEPT: usize = 2;

impl Clamp {
    /// A clamp with an empty cache.
    pub fn new(percentile: f32) -> Self {
        Self {
            percentile,
            limits: Arc::default(),
        }
    }

    /// The limit of a scene in a view, from the cache or computed by all workers that ask for it: `trace` traces part
    /// number n of `parts` of the pilot, and `of_pilot` computes the limit. None if cancelled. `from_lights` says
    /// whether light paths are traced as well.
    pub(super) fn limit(
        &self,
        scene: &RenderScene,
        (camera, size): (&Camera, [u32; 2]),
        from_lights: bool,
        parts: u32,
        trace: impl Fn(u32) -> Option<Pilot>,
        of_pilot: impl Fn(Vec<Pilot>) -> BrightnessLimit,
        cancel: &AtomicBool,
    ) -> Option<BrightnessLimit> {
        loop {
            let search = self.search(scene, camera, size, from_lights, parts);
            let finish = |found: Vec<Option<Pilot>>| found.into_iter().collect::<Option<_>>().map(&of_pilot);
            if let Some(Some(limit)) = search.get(&trace, finish, cancel) {
                return Some(limit);
            }
            // A worker was cancelled, and parts are missing: others start again.
            let mut known = self.limits.lock().unwrap_or_else(PoisonError::into_inner);
            known.retain(|known| !Arc::ptr_eq(&known.limit, &search));
            if cancel.load(Ordering::Relaxed) {
                return None;
            }
        }
    }

    fn search(
        &self,
        scene: &RenderScene,
        camera: &Camera,
        size: [u32; 2],
        from_lights: bool,
        parts: u32,
    ) -> Arc<Search> {
        let mut known = self.limits.lock().unwrap_or_else(PoisonError::into_inner);
        let is_same = |known: &KnownLimit| {
            (known.size, known.from_lights) == (size, from_lights)
                && known.camera == *camera
                && known.scene.is_same(scene)
        };
        if let Some(found) = known.iter().find(|known| is_same(known)) {
            return found.limit.clone();
        }
        let limit = Arc::new(Search::new(parts as usize));
        known.insert(
            0,
            KnownLimit {
                scene: scene.clone(),
                camera: *camera,
                size,
                from_lights,
                limit: Arc::clone(&limit),
            },
        );
        known.truncate(KEPT);
        limit
    }

    /// The most recently found limit; None before the first.
    pub fn found(&self) -> Option<BrightnessLimit> {
        let known = self.limits.lock().unwrap_or_else(PoisonError::into_inner);
        known.first()?.limit.known()?
    }
}

impl PartialEq for Clamp {
    fn eq(&self, other: &Self) -> bool {
        self.percentile == other.percentile
    }
}

impl fmt::Debug for Clamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Clamp").field("percentile", &self.percentile).finish()
    }
}
