//! Gathers light at texels.
//!
//! A sample is a pure function of the scene, the settings, the texel's position and the sample's index. Each texel adds
//! its samples up in the fixed groups of [`crate::render::passes`], as pictures do: any number of threads, any
//! interruption and any division into shares give the same bits.
//!
//! Texels are processed in blocks. The blocks of a round may be done in any order, so that light can be saved in the
//! middle of a round.

use std::ops::Range;
use std::sync::atomic::AtomicBool;

use glam::{DVec3, UVec2};
use rayon::prelude::*;

use super::texels::{Texel, Texels};
use crate::color::{Rgb, luminance};
use crate::medium::Medium;
use crate::render::gathering::{Gathering, Site};
use crate::render::noise::DARK;
use crate::render::passes::{chunk_of, chunks_in};
use crate::sampling::Sampler;

/// Sums over the samples of a texel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TexelSum {
    /// Irradiance, or radiance for a texel of a reflection probe; linear Rec. 709.
    pub light: DVec3,
    /// Squared luminances, for the noise estimate.
    pub luminance_squared: f64,
    /// The number of samples that first met the back of a surface.
    pub backs: u32,
}

/// The light gathered at texels so far.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lightmaps {
    /// The index of the first sample of each texel.
    pub(super) first: u32,
    /// The sums of each texel. If the first sample is number 0, there is one list; otherwise there is one for each
    /// group of samples, since the sums of the samples before them, to which they will be added, are not known.
    pub(super) groups: Vec<Vec<TexelSum>>,
    /// The number of layers that the light is divided into as well; 0 for none.
    pub(super) layers: usize,
    /// The light of each layer for each list of `groups`, contiguous for each texel.
    pub(super) layer_sums: Vec<Vec<DVec3>>,
    /// The index after the last sample of the texels of each block.
    pub(super) ends: Vec<u32>,
    /// Rays traced, shadow rays included.
    pub rays: u64,
    /// The number of samples that were not finite; they count as black.
    pub invalid: u64,
}

/// The random dimension of a sample's position within its texel. No path uses it, and the first dimensions, which are
/// stratified over neighbouring pixels, take longer to compute.
const PLACE: u32 = u32::MAX;
/// Texels that a thread processes at once, sixteen for each lane.
pub(super) const BLOCK: usize = 256;

/// The limit of the light of a texel, so that sums over neighbours are finite, whatever a file holds.
const BRIGHTEST: DVec3 = DVec3::splat(1e30);

impl Lightmaps {
    /// No light yet, for `texels` texels.
    pub fn new(texels: usize) -> Self {
        Self::beginning_at(0, texels)
    }

    /// No light yet; the first sample of each texel will have the index `first`, at which a group begins.
    pub fn beginning_at(first: u32, texels: usize) -> Self {
        Self {
            first,
            groups: vec![vec![TexelSum::default(); texels]],
            layers: 0,
            layer_sums: vec![Vec::new()],
            ends: vec![first; texels.div_ceil(BLOCK)],
            rays: 0,
            invalid: 0,
        }
    }

    /// The same with the light of so many layers: as many as the view of the gathering has light groups. Light of no
    /// group, that of glowing media, belongs to the last layer.
    pub fn with_layers(mut self, layers: usize) -> Self {
        self.layers = layers;
        let texels = self.texel_count();
        for sums in &mut self.layer_sums {
            *sums = vec![DVec3::ZERO; texels * layers];
        }
        self
    }

    /// The number of texels.
    pub fn texel_count(&self) -> usize {
        self.groups[0].len()
    }

    /// The number of samples that every texel has.
    pub fn samples(&self) -> u32 {
        self.reached() - self.first
    }

    /// The index after the last sample that every texel has.
    pub fn reached(&self) -> u32 {
        self.ends.iter().min().copied().unwrap_or(self.first)
    }

    /// The mean number of samples of a texel; in the middle of a round it is higher than [`Self::samples`].
    pub fn mean_samples(&self) -> f64 {
        let sum: u64 = self.ends.iter().map(|end| u64::from(end - self.first)).sum();
        sum as f64 / self.ends.len().max(1) as f64
    }

    /// The end of the current round, as a sample index, if samples end at `target`: a round is a group of samples, or
    /// the rest of one.
    pub fn round_end(&self, target: u32) -> u32 {
        chunk_of(self.reached()).end.min(target)
    }

    /// Adds samples to at most `blocks` blocks of texels that lack those of the round ending at `end`, see
    /// [`Self::round_end`]. Returns whether the round is complete. Blocks in progress when `cancel` is set are dropped.
    pub fn go_on<S: Site>(
        &mut self,
        gathering: &Gathering,
        texels: &Texels<S>,
        end: u32,
        blocks: usize,
        cancel: &AtomicBool,
    ) -> bool {
        let behind = (0..self.ends.len()).filter(|block| self.ends[*block] < end);
        let waiting: Vec<usize> = behind.take(blocks).collect();
        let count = self.texel_count();
        let range_of = |block: usize| block * BLOCK..count.min((block + 1) * BLOCK);
        let traced: Vec<Option<Block>> = waiting
            .par_iter()
            .map(|&block| {
                Block::trace(
                    gathering,
                    texels,
                    self.layers,
                    range_of(block),
                    self.ends[block]..end,
                    cancel,
                )
            })
            .collect();
        for (block, traced) in waiting.into_iter().zip(traced) {
            let Some(traced) = traced else {
                continue;
            };
            let group = match self.first {
                0 => 0,
                first => chunks_in(first..self.ends[block]) as usize,
            };
            while self.groups.len() <= group {
                self.groups.push(vec![TexelSum::default(); count]);
                self.layer_sums.push(vec![DVec3::ZERO; count * self.layers]);
            }
            for (sum, more) in self.groups[group][range_of(block)].iter_mut().zip(&traced.sums) {
                sum.add(more);
            }
            let first = range_of(block).start * self.layers;
            add_all(&mut self.layer_sums[group][first..], &traced.layer_sums);
            self.ends[block] = end;
            self.rays += traced.rays;
            self.invalid += traced.invalid;
        }
        self.reached() >= end
    }

    /// Adds `count` samples to each texel. If `cancel` is set meanwhile, it returns false, and only some texels have
    /// them.
    pub fn add<S: Site>(&mut self, gathering: &Gathering, texels: &Texels<S>, count: u32, cancel: &AtomicBool) -> bool {
        let target = self.reached().saturating_add(count);
        while self.reached() < target && !self.ends.is_empty() {
            let end = self.round_end(target);
            if !self.go_on(gathering, texels, end, usize::MAX, cancel) {
                return false;
            }
        }
        true
    }

    /// Appends a share whose samples follow on these, which begin with number 0. False if they do not follow, or if the
    /// share has other texels.
    pub fn append(&mut self, share: Self) -> bool {
        let follows = self.first == 0 && self.ends.iter().all(|end| *end == share.first);
        if !follows || self.texel_count() != share.texel_count() || self.layers != share.layers {
            return false;
        }
        for (group, layers) in share.groups.iter().zip(&share.layer_sums) {
            self.groups[0]
                .iter_mut()
                .zip(group)
                .for_each(|(sum, more)| sum.add(more));
            add_all(&mut self.layer_sums[0], layers);
        }
        self.ends = share.ends;
        self.rays = self.rays.saturating_add(share.rays);
        self.invalid = self.invalid.saturating_add(share.invalid);
        true
    }

    /// The sums of a texel over all of its samples.
    pub fn sum(&self, texel: usize) -> TexelSum {
        let mut sum = TexelSum::default();
        self.groups.iter().for_each(|group| sum.add(&group[texel]));
        sum
    }

    /// The sums of a layer's light at a texel over all of its samples.
    fn layer_sum(&self, texel: usize, layer: usize) -> DVec3 {
        let place = texel * self.layers + layer;
        self.layer_sums.iter().map(|sums| sums[place]).sum()
    }

    /// The part of [`Self::light`] that a layer has.
    pub fn layer(&self, texel: usize, layer: usize) -> Rgb {
        let mean = self.layer_sum(texel, layer) / f64::from(self.samples_of(texel).max(1));
        mean.clamp(-BRIGHTEST, BRIGHTEST).as_vec3()
    }

    /// The luminance of each layer's light, summed up over these texels.
    pub(super) fn strengths(&self, texels: Range<usize>) -> Vec<f64> {
        let strength = |layer: usize| {
            let light = texels
                .clone()
                .map(|texel| f64::from(luminance(self.layer(texel, layer))));
            light.sum()
        };
        (0..self.layers).map(strength).collect()
    }

    /// The part of the light that some layers have, which `layers_of` gives for each texel. Texels are buried as in the
    /// whole.
    pub(super) fn part<'a>(&self, layers_of: impl Fn(usize) -> &'a [usize]) -> Self {
        let part = |texel: usize| TexelSum {
            light: layers_of(texel).iter().map(|layer| self.layer_sum(texel, *layer)).sum(),
            ..self.sum(texel)
        };
        Self {
            groups: vec![(0..self.texel_count()).map(part).collect()],
            layers: 0,
            layer_sums: vec![Vec::new()],
            ends: self.ends.clone(),
            ..*self
        }
    }

    /// Whether the sums of a texel are possible for its number of samples.
    pub(super) fn is_possible(&self, texel: usize) -> bool {
        let sums = || self.groups.iter().map(|group| &group[texel]);
        let backs: u64 = sums().map(|sum| u64::from(sum.backs)).sum();
        let is_finite = |sum: &TexelSum| sum.light.is_finite() && sum.luminance_squared.is_finite();
        let layers = texel * self.layers..(texel + 1) * self.layers;
        let mut of_layers = self.layer_sums.iter().flat_map(|sums| &sums[layers.clone()]);
        backs <= u64::from(self.samples_of(texel)) && sums().all(is_finite) && of_layers.all(|sum| sum.is_finite())
    }

    fn samples_of(&self, texel: usize) -> u32 {
        self.ends[texel / BLOCK] - self.first
    }

    /// The irradiance or radiance at a texel, at most `BRIGHTEST`; black before the first sample.
    pub fn light(&self, texel: usize) -> Rgb {
        let mean = self.sum(texel).light / f64::from(self.samples_of(texel).max(1));
        mean.clamp(-BRIGHTEST, BRIGHTEST).as_vec3()
    }

    /// The root mean square over the texels of the estimated standard error of their luminance relative to that
    /// luminance, judged in the dark as [`crate::render::noise`] judges pictures; None without two samples or any
    /// light.
    pub fn noise(&self) -> Option<f32> {
        let texels = self.texel_count();
        if self.samples() < 2 || texels == 0 {
            return None;
        }
        let mean = |texel: usize| {
            let count = f64::from(self.samples_of(texel));
            f64::from(luminance(self.sum(texel).light.as_vec3())) / count
        };
        let light = (0..texels).map(mean).sum::<f64>() / texels as f64;
        let least = f64::from(DARK) * light;
        let square = |texel: usize| {
            let (mean, count) = (mean(texel), f64::from(self.samples_of(texel)));
            let variance = (self.sum(texel).luminance_squared / count - mean.powi(2)).max(0.0) / (count - 1.0);
            variance / mean.max(least).powi(2)
        };
        let squares = (0..texels).map(square).sum::<f64>();
        (light > 0.0).then(|| (squares / texels as f64).sqrt() as f32)
    }

    /// Whether a texel lies inside a solid: most paths from it meet the back of a surface, and none has found light.
    /// Not all paths need to, since other surfaces may cut the inside. A surface that transmits light, or whose back is
    /// seen in the light, is no wall.
    pub fn is_buried(&self, texel: usize) -> bool {
        self.are_buried(texel..texel + 1)
    }

    /// [`Self::is_buried`] for the texels of one point, which face several directions.
    pub fn are_buried(&self, texels: Range<usize>) -> bool {
        let (mut backs, mut samples, mut is_dark) = (0, 0, true);
        for texel in texels {
            let sum = self.sum(texel);
            backs += u64::from(sum.backs);
            samples += u64::from(self.samples_of(texel));
            // A layer may be dark where the whole is not.
            is_dark &= sum.light == DVec3::ZERO && sum.luminance_squared == 0.0;
        }
        2 * backs > samples && is_dark
    }
}

impl TexelSum {
    fn add(&mut self, more: &Self) {
        self.light += more.light;
        self.luminance_squared += more.luminance_squared;
        self.backs += more.backs;
    }
}

fn add_all(sums: &mut [DVec3], more: &[DVec3]) {
    sums.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
}

/// The samples of consecutive texels.
struct Block {
    /// Their sums, without earlier samples.
    sums: Vec<TexelSum>,
    /// The light of each layer, contiguous for each texel.
    layer_sums: Vec<DVec3>,
    rays: u64,
    invalid: u64,
}

impl Block {
    /// Traces the samples with these indices; None if `cancel` was set meanwhile.
    fn trace<S: Site>(
        gathering: &Gathering,
        texels: &Texels<S>,
        layers: usize,
        range: Range<usize>,
        indices: Range<u32>,
        cancel: &AtomicBool,
    ) -> Option<Self> {
        let mut block = Self {
            sums: vec![TexelSum::default(); range.len()],
            layer_sums: vec![DVec3::ZERO; range.len() * layers],
            rays: 0,
            invalid: 0,
        };
        let view = gathering.view;
        let mut sites: Vec<(S, Sampler)> = Vec::with_capacity(range.len() * indices.len());
        let mut page = texels.pages.partition_point(|page| page.end <= range.start);
        for (index, texel) in range.clone().zip(&texels.texels[range]) {
            while texels.pages.get(page).is_some_and(|page| page.end <= index) {
                page += 1;
            }
            let Texel { place, receiver } = *texel;
            let pixel = UVec2::new(place.x, page as u32 * texels.size.y + place.y);
            let spread = texels.spreads.get(index);
            sites.extend(indices.clone().map(|index| {
                let sampler = Sampler::new(view.sequence, pixel, index, view.seed);
                let place = spread.and_then(|spread| spread.place(sampler.at_2d(PLACE)));
                (place.map_or(receiver, |place| receiver.at(place)), sampler)
            }));
        }
        let arrived = S::trace(gathering, &sites, cancel)?;
        let has_glow = gathering.scene.media.iter().any(Medium::glows);
        let count = indices.len();
        for (number, (sum, samples)) in block.sums.iter_mut().zip(arrived.samples.chunks(count)).enumerate() {
            for (index, sample) in samples.iter().enumerate() {
                block.rays += u64::from(sample.rays);
                sum.backs += u32::from(sample.meets_back);
                if !sample.light.is_finite() {
                    block.invalid += 1;
                    continue;
                }
                sum.light += sample.light.as_dvec3();
                sum.luminance_squared += f64::from(luminance(sample.light)).powi(2);
                let sums = &mut block.layer_sums[number * layers..][..layers];
                let Some(last) = layers.checked_sub(1) else {
                    continue;
                };
                let groups = &arrived.groups[(number * count + index) * layers..][..layers];
                sums.iter_mut()
                    .zip(groups)
                    .for_each(|(sum, light)| *sum += light.as_dvec3());
                if has_glow {
                    let glow = sample.light - groups.iter().sum::<Rgb>();
                    sums[last] += glow.max(Rgb::ZERO).as_dvec3();
                }
            }
        }
        Some(block)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_beyond_all_numbers_is_limited() {
        let mut light = Lightmaps::new(1);
        light.groups[0][0].light = DVec3::new(1e300, 1.0, -1e300);
        assert!(light.is_possible(0));
        assert_eq!(light.light(0), Rgb::new(1e30, 1.0, -1e30));
    }
}
