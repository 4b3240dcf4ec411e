//! The light of each group of lights, pixel by pixel.

use super::Film;
use crate::color::Rgb;
use crate::render::layers::LayerSums;

impl Film {
    /// Writes the mean radiance from each group of lights at a pixel to the start of `light`. Returns the radiance that
    /// belongs to no group. None if the film keeps no groups or the pixel has no samples.
    pub fn light_of_groups(&self, x: u32, y: u32, light: &mut [Rgb]) -> Option<Rgb> {
        let index = self.index(x, y);
        let count = self.counts[index];
        if count == 0 || self.kept.groups == 0 {
            return None;
        }
        let scale = 1.0 / count as f32;
        let values = self.layer_values(x, y);
        let groups = LayerSums::groups(&values, self.kept);
        light
            .iter_mut()
            .zip(groups)
            .for_each(|(light, sum)| *light = sum * scale);
        Some(self.splatted(index))
    }
}
