//! Everything about a bake but its light: what is needed to make its files of the sums of samples.

use std::sync::atomic::{AtomicBool, Ordering};

use super::finish::{Denoising, LightmapPicture, finish};
use super::level::BakedNode;
use super::lightmap::Lightmaps;
use super::manifest::BakedLight;
use super::probes::{Probe, ProbePicture};
use super::seams::Seam;
use super::texels::Texels;
use crate::render::denoise::DenoiseError;

/// A bake without its light.
#[derive(Clone, Debug, PartialEq)]
pub struct Blueprint {
    /// The content of the level's file.
    pub level: Vec<u8>,
    /// The light that is in the lightmaps.
    pub light: BakedLight,
    /// The seed of the random numbers.
    pub seed: u32,
    /// Whether noise is removed.
    pub denoise: bool,
    /// Texels per unit of length.
    pub texels_per_unit: f32,
    /// The nodes that have a place in a lightmap.
    pub nodes: Vec<BakedNode>,
    /// The covered texels of the lightmaps.
    pub places: Texels<()>,
    /// The seams of each lightmap.
    pub seams: Vec<Vec<Seam>>,
    /// Reflection probes, and then volumes.
    pub probes: Vec<Probe>,
}

/// A finished bake.
#[derive(Clone, Debug, PartialEq)]
pub struct Baked {
    /// The lightmaps.
    pub lightmaps: Vec<LightmapPicture>,
    /// The samples of each texel of a lightmap.
    pub samples: u32,
    /// The pictures of each probe; None of those that are not finished.
    pub probes: Vec<Option<ProbePicture>>,
}

impl Blueprint {
    /// The number of lightmaps.
    pub fn page_count(&self) -> usize {
        self.places.pages.len()
    }

    /// A lightmap of the light so far.
    pub fn lightmap(
        &self,
        page: usize,
        light: &Lightmaps,
        denoising: Option<Denoising>,
    ) -> Result<LightmapPicture, DenoiseError> {
        finish(&self.places, page, light, &self.seams[page], denoising)
    }

    /// The filter that removes noise, if it is asked for.
    fn denoising<'a>(&self, threads: usize, cancel: &'a AtomicBool) -> Option<Denoising<'a>> {
        self.denoise.then_some(Denoising {
            threads: Some(threads),
            cancel,
        })
    }

    /// All lightmaps. `watch` hears of the part that is done, from 0 to 1.
    pub(super) fn lightmaps(
        &self,
        light: &Lightmaps,
        threads: usize,
        mut watch: impl FnMut(f64),
    ) -> Result<Vec<LightmapPicture>, DenoiseError> {
        // What light there is shall be written after an interrupt as well.
        let never = AtomicBool::new(false);
        let count = self.page_count();
        let picture = |page| {
            watch(page as f64 / count as f64);
            self.lightmap(page, light, self.denoising(threads, &never))
        };
        (0..count).map(picture).collect()
    }

    /// The pictures of a probe of its light; None if `cancel` was set in the meantime.
    pub(super) fn probe(
        &self,
        number: usize,
        light: &Lightmaps,
        threads: usize,
        cancel: &AtomicBool,
    ) -> Result<Option<ProbePicture>, DenoiseError> {
        match self.probes[number].finished(light, self.denoising(threads, cancel)) {
            Err(DenoiseError::Cancelled) if cancel.load(Ordering::Relaxed) => Ok(None),
            finished => finished.map(Some),
        }
    }
}
