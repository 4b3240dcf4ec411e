//! Light mixing: the light of each group of lights is summed up by itself beside the picture, which is linear in all of them.
//!
//! The layers hold the very samples of the picture: they are as noisy as it is, and sum up to it.

use std::sync::Arc;

use super::observer::{MetEmitter, PathObserver, SampledLight};
use crate::color::Rgb;
use crate::light::LightId;

/// The assignment of lights to layers of the film.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LightGroups {
    /// The layer by [`LightId`].
    layer_of_light: Arc<[u8]>,
    count: usize,
}

impl LightGroups {
    /// Groups beyond this many share the last layer.
    pub const MOST: usize = 16;

    /// Groups the lights. `group_of_light` is by [`LightId`], counted from 0.
    pub fn new(group_of_light: &[u32]) -> Self {
        let layer = |&group: &u32| group.min(Self::MOST as u32 - 1) as u8;
        let layer_of_light: Arc<[u8]> = group_of_light.iter().map(layer).collect();
        Self {
            count: layer_of_light.iter().max().map_or(0, |&last| usize::from(last) + 1),
            layer_of_light,
        }
    }

    /// The number of layers of the film.
    pub fn count(&self) -> usize {
        self.count
    }

    fn layer(&self, light: LightId) -> Option<usize> {
        self.layer_of_light.get(light.0 as usize).map(|&layer| layer.into())
    }
}

/// The layers of one pixel in the making.
pub(super) struct LayerSums<'g> {
    groups: &'g LightGroups,
    sample: [Rgb; LightGroups::MOST],
    pixel: [Rgb; LightGroups::MOST],
}

impl<'g> LayerSums<'g> {
    pub fn new(groups: &'g LightGroups) -> Self {
        Self {
            groups,
            sample: [Rgb::ZERO; LightGroups::MOST],
            pixel: [Rgb::ZERO; LightGroups::MOST],
        }
    }

    pub fn is_empty(&self) -> bool {
        self.groups.count == 0
    }

    pub fn begin_pixel(&mut self) {
        self.pixel[..self.groups.count].fill(Rgb::ZERO);
    }

    pub fn begin_sample(&mut self) {
        self.sample[..self.groups.count].fill(Rgb::ZERO);
    }

    /// Adds the sample that was observed, its light counting `weight`.
    pub fn add_sample(&mut self, weight: f32) {
        let count = self.groups.count;
        for (sum, light) in self.pixel[..count].iter_mut().zip(&self.sample[..count]) {
            *sum += *light * weight;
        }
    }

    pub fn of_pixel(&self) -> &[Rgb] {
        &self.pixel[..self.groups.count]
    }

    fn add(&mut self, light: LightId, contribution: Rgb) {
        if let Some(layer) = self.groups.layer(light) {
            self.sample[layer] += contribution;
        }
    }
}

impl PathObserver for LayerSums<'_> {
    fn emitter_met(&mut self, met: &MetEmitter) {
        self.add(met.light, met.contribution);
    }

    fn light_sampled(&mut self, sampled: &SampledLight) {
        self.add(sampled.light, sampled.contribution);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_beyond_the_most_share_the_last_layer() {
        let groups = LightGroups::new(&[0, 15, 16, 40]);
        let layers: Vec<_> = (0..5).map(|light| groups.layer(LightId(light))).collect();
        assert_eq!(layers, [Some(0), Some(15), Some(15), Some(15), None]);
        assert_eq!(groups.count(), LightGroups::MOST);
        assert_eq!(LightGroups::new(&[]), LightGroups::default());
    }
}
