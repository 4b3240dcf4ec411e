//! A limit to how bright a sample may be. A few samples that are far brighter than all others ("fireflies") are noise that takes very many samples to
//! even out; a picture in which they are made as bright as the limit has less noise, and too little light.
//!
//! The limit is a percentile of the samples of a pilot (`fireflies`). It depends on the scene and the view alone, so that any part of a picture,
//! rendered anywhere, has the same.

use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use super::camera::Camera;
use super::scene::RenderScene;

/// The percentile of the samples' light that is the limit, with the limits that were found. Clones share these.
///
/// They are a store and no part of what a picture depends on: two clamps are equal if their percentiles are.
#[derive(Clone)]
pub struct Clamp {
    /// The share of the samples with light, in percent, that the clamp leaves as they are; above 0 and below 100.
    pub percentile: f32,
    limits: Arc<Mutex<Vec<KnownLimit>>>,
}

/// The limit of a scene in a view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrightnessLimit {
    /// The greatest luminance of the light of a sample, W/(m^2 sr), without what the camera sees of lamps directly, in mirrors and through glass.
    pub luminance: f32,
    /// The share of the picture's light that the clamp removes, from 0 to 1, as the pilot has it.
    pub removed: f32,
}

struct KnownLimit {
    scene: RenderScene,
    camera: Camera,
    size: [u32; 2],
    from_lights: bool,
    limit: Arc<Mutex<Option<BrightnessLimit>>>,
}

/// The limits that are kept, each with its scene: those of the picture by path tracing and with paths from the lights.
const KEPT: usize = 2;

impl Clamp {
    /// A clamp whose limits are not known yet.
    pub fn new(percentile: f32) -> Self {
        Self {
            percentile,
            limits: Arc::default(),
        }
    }

    /// The limit of a scene that a camera sees on a film of this size, found by `find` if it is not known; None if that gives none. Others who ask for
    /// it in the meantime wait. `from_lights`: whether paths begin at the lights as well.
    pub(super) fn limit(
        &self,
        scene: &RenderScene,
        camera: &Camera,
        size: [u32; 2],
        from_lights: bool,
        find: impl FnOnce() -> Option<BrightnessLimit>,
    ) -> Option<BrightnessLimit> {
        let entry = self.entry(scene, camera, size, from_lights);
        let mut limit = entry.lock().unwrap_or_else(PoisonError::into_inner);
        if limit.is_none() {
            *limit = find();
        }
        *limit
    }

    fn entry(
        &self,
        scene: &RenderScene,
        camera: &Camera,
        size: [u32; 2],
        from_lights: bool,
    ) -> Arc<Mutex<Option<BrightnessLimit>>> {
        let mut known = self.limits.lock().unwrap_or_else(PoisonError::into_inner);
        let is_same = |known: &KnownLimit| {
            (known.size, known.from_lights) == (size, from_lights)
                && known.camera == *camera
                && known.scene.is_same(scene)
        };
        if let Some(found) = known.iter().find(|known| is_same(known)) {
            return found.limit.clone();
        }
        let limit = Arc::default();
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

    /// The limit of the scene and the view that were new last; None before that.
    pub fn found(&self) -> Option<BrightnessLimit> {
        let known = self.limits.lock().unwrap_or_else(PoisonError::into_inner);
        let limit = known.first()?.limit.try_lock().ok()?;
        *limit
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
