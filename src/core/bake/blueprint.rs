//! Everything about a bake but its light: what is needed to make its files of the sums of samples.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::ThreadPool;

use super::finish::{Denoising, LightmapPicture, finish};
use super::level::BakedNode;
use super::lightmap::Lightmaps;
use super::manifest::BakedLight;
use super::probes::{Probe, ProbePicture};
use super::progress::Work;
use super::seams::Seam;
use super::texels::Texels;
use super::unwrap::TEXEL_BYTES;
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

    /// All lightmaps. `watch` hears of the part that is done, from 0 to 1. An error soon after `discards` is set: an
    /// interrupt alone does not set it, since what light there is shall be written after it.
    pub(super) fn lightmaps(
        &self,
        light: &Lightmaps,
        threads: usize,
        discards: &AtomicBool,
        mut watch: impl FnMut(f64),
    ) -> Result<Vec<LightmapPicture>, DenoiseError> {
        let count = self.page_count();
        let picture = |page| {
            watch(page as f64 / count as f64);
            match discards.load(Ordering::Relaxed) {
                true => Err(DenoiseError::Cancelled),
                false => self.lightmap(page, light, self.denoising(threads, discards)),
            }
        };
        (0..count).map(picture).collect()
    }

    /// The pictures of a probe of its light; None if the work was cancelled.
    pub(super) fn probe(
        &self,
        number: usize,
        light: &Lightmaps,
        work: &mut Work,
    ) -> Result<Option<ProbePicture>, DenoiseError> {
        self.probes[number].finished(light, self.denoise, work)
    }

    /// Finishes everything of the light of the lightmaps and of each probe.
    pub fn finished(&self, lights: &[Lightmaps], pool: &ThreadPool) -> Result<Baked, DenoiseError> {
        let work = &mut Work {
            pool,
            cancel: &AtomicBool::new(false),
            watch: &mut |_| {},
        };
        let probes = lights[1..].iter().enumerate();
        Ok(Baked {
            lightmaps: self.lightmaps(&lights[0], pool.current_num_threads(), work.cancel, |_| {})?,
            samples: lights[0].samples(),
            probes: probes
                .map(|(number, light)| self.probe(number, light, work))
                .collect::<Result<_, _>>()?,
        })
    }

    /// The number of texels of the lightmaps, and then that of each probe.
    pub(super) fn texel_counts(&self) -> impl Iterator<Item = usize> {
        std::iter::once(self.places.texels.len()).chain(self.probes.iter().map(Probe::texel_count))
    }

    /// The samples of the lightmaps (0), or of a probe (its number and 1), where a texel of a lightmap has so many.
    pub(super) fn samples_of(&self, number: usize, samples: u32) -> u32 {
        match number.checked_sub(1) {
            None => samples,
            Some(number) => self.probes[number].samples(samples),
        }
    }

    /// Whether sums of light for the other one's texels are for these as well.
    pub(super) fn has_texels_of(&self, other: &Self) -> bool {
        self.places == other.places && self.texel_counts().eq(other.texel_counts())
    }

    /// Bytes of memory while everything is made.
    pub(super) fn memory_bytes(&self) -> u64 {
        let page = u64::from(self.places.size.x) * u64::from(self.places.size.y);
        let probes: u64 = self.probes.iter().map(Probe::memory_bytes).sum();
        let pages = TEXEL_BYTES.saturating_mul(page * self.page_count() as u64);
        pages.saturating_add(probes)
    }
}
