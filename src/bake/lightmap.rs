//! Gathers light at texels, in rounds of samples.
//!
//! A sample is a pure function of the scene, the settings, the texel's place and the sample's index, and each texel adds up its own in their order: any
//! number of threads and any division into rounds give the same bits.

use std::ops::Range;
use std::sync::atomic::AtomicBool;

use glam::{DVec3, UVec2};
use rayon::prelude::*;

use super::gathering::{Gathering, Site};
use super::texels::{Texel, Texels};
use crate::color::{Rgb, luminance};
use crate::render::noise::DARK;
use crate::sampling::Sampler;

/// Sums over the samples of a texel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TexelSum {
    /// Irradiance, or radiance where a texel looks through a window; linear Rec. 709.
    pub light: DVec3,
    /// Squared luminances, for the noise estimate.
    pub luminance_squared: f64,
    /// The samples that have first met the back of a surface.
    pub backs: u32,
}

/// The light at texels so far.
#[derive(Clone, Debug, Default)]
pub struct Lightmaps {
    /// The sums of each texel.
    pub sums: Vec<TexelSum>,
    /// The samples of each texel.
    pub samples: u32,
    /// Rays traced, shadow rays included.
    pub rays: u64,
    /// The number of samples that were not finite; they count as black.
    pub invalid: u64,
}

/// Texels that a thread takes at once, sixteen for each lane.
const BLOCK: usize = 256;

impl Lightmaps {
    /// No light yet at so many texels.
    pub fn new(texels: usize) -> Self {
        Self {
            sums: vec![TexelSum::default(); texels],
            ..Self::default()
        }
    }

    /// Adds a round of `count` samples of each texel. If `cancel` is set meanwhile, the round is dropped, and the answer is false. `done` hears of texels that
    /// are finished, as their number.
    pub fn add_round<S: Site>(
        &mut self,
        gathering: &Gathering,
        texels: &Texels<S>,
        count: u32,
        cancel: &AtomicBool,
        done: impl Fn(usize) + Sync,
    ) -> bool {
        let indices = self.samples..self.samples.saturating_add(count);
        let row_of = |page: usize| page as u32 * texels.size.y;
        let pages = texels.pages.iter().enumerate();
        let blocks: Vec<(u32, Range<usize>)> = pages
            .flat_map(|(page, range)| {
                let starts = range.clone().step_by(BLOCK);
                starts.map(move |start| (row_of(page), start..range.end.min(start + BLOCK)))
            })
            .collect();
        let traced: Option<Vec<Block>> = blocks
            .par_iter()
            .map(|(first_row, range)| {
                let (own, before) = (&texels.texels[range.clone()], &self.sums[range.clone()]);
                let block = Block::trace(gathering, own, before, *first_row, indices.clone(), cancel)?;
                done(range.len());
                Some(block)
            })
            .collect();
        let Some(traced) = traced else {
            return false;
        };
        for ((_, range), block) in blocks.into_iter().zip(traced) {
            self.sums[range].copy_from_slice(&block.sums);
            self.rays += block.rays;
            self.invalid += block.invalid;
        }
        self.samples = indices.end;
        true
    }

    /// The irradiance or radiance at a texel; black before the first sample.
    pub fn light(&self, texel: usize) -> Rgb {
        (self.sums[texel].light / f64::from(self.samples.max(1))).as_vec3()
    }

    /// The root mean square over the texels of the estimated standard error of their luminance relative to that luminance, judged in the dark as
    /// [`crate::render::noise`] judges pictures; None without two samples or any light.
    pub fn noise(&self) -> Option<f32> {
        let count = f64::from(self.samples);
        if self.samples < 2 || self.sums.is_empty() {
            return None;
        }
        let mean = |sum: &TexelSum| f64::from(luminance(sum.light.as_vec3())) / count;
        let light = self.sums.iter().map(mean).sum::<f64>() / self.sums.len() as f64;
        let least = f64::from(DARK) * light;
        let square = |sum: &TexelSum| {
            let variance = (sum.luminance_squared / count - mean(sum).powi(2)).max(0.0) / (count - 1.0);
            variance / mean(sum).max(least).powi(2)
        };
        let squares = self.sums.iter().map(square).sum::<f64>();
        (light > 0.0).then(|| (squares / self.sums.len() as f64).sqrt() as f32)
    }

    /// Whether a texel lies inside of something: most paths from it meet the back of a surface, and none has found light. Not all do, since what is inside may
    /// be cut by other surfaces. A surface that lets light through, or that is seen from behind in the light, is no wall.
    pub fn is_buried(&self, texel: usize) -> bool {
        self.are_buried(texel..texel + 1)
    }

    /// The same of texels that are one place, which looks to several sides.
    pub fn are_buried(&self, texels: Range<usize>) -> bool {
        let sums = &self.sums[texels];
        let backs: u64 = sums.iter().map(|sum| u64::from(sum.backs)).sum();
        2 * backs > u64::from(self.samples) * sums.len() as u64 && sums.iter().all(|sum| sum.light == DVec3::ZERO)
    }
}

/// The samples of texels that follow each other.
struct Block {
    sums: Vec<TexelSum>,
    rays: u64,
    invalid: u64,
}

impl Block {
    /// Traces the samples of these indices; None if `cancel` was set in the meantime.
    fn trace<S: Site>(
        gathering: &Gathering,
        texels: &[Texel<S>],
        before: &[TexelSum],
        first_row: u32,
        indices: Range<u32>,
        cancel: &AtomicBool,
    ) -> Option<Self> {
        let mut block = Self {
            sums: before.to_vec(),
            rays: 0,
            invalid: 0,
        };
        let view = gathering.view;
        let sites: Vec<(S, Sampler)> = texels
            .iter()
            .flat_map(|texel| {
                let pixel = UVec2::new(texel.place.x, first_row + texel.place.y);
                let sampler = move |index| Sampler::new(view.sequence, pixel, index, view.seed);
                indices.clone().map(move |index| (texel.receiver, sampler(index)))
            })
            .collect();
        let samples = S::trace(gathering, &sites, cancel)?;
        for (sum, samples) in block.sums.iter_mut().zip(samples.chunks(indices.len())) {
            for sample in samples {
                block.rays += u64::from(sample.rays);
                sum.backs += u32::from(sample.meets_back);
                if !sample.light.is_finite() {
                    block.invalid += 1;
                    continue;
                }
                sum.light += sample.light.as_dvec3();
                sum.luminance_squared += f64::from(luminance(sample.light)).powi(2);
            }
        }
        Some(block)
    }
}
