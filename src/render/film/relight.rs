//! The light of lamps that have become stronger or weaker since it was sampled. Light is linear, and the film keeps the light of each group apart.

use super::Film;
use crate::color::{Rgb, luminance};
use crate::render::layers::{FilmLayers, Layer, LayerSums, Layers};
use crate::render::tile::PixelSum;

impl Film {
    /// Whether [`Self::relight`] can be used: every pixel has samples, and there is no light besides what they have found.
    pub fn can_be_relit(&self) -> bool {
        let other = Layers::of(&[Layer::Direct, Layer::Indirect, Layer::Emitted]);
        let has_begun = self.previews.iter().all(Option::is_none);
        has_begun && !self.has_splats() && !self.kept.layers.has_any_of(other) && self.chunks.is_none()
    }

    /// Multiplies the light of each group by its factor, or all light by the only factor if the film keeps no groups, as if it had been sampled so. The spread of
    /// samples, from which noise is estimated, is taken to be the largest that it can be.
    pub fn relight(&mut self, factors: &[Rgb]) {
        let kept = self.kept;
        for place in 0..self.sums.len() {
            let before = luminance(self.sums[place].radiance);
            relight_pixel(&mut self.sums[place], &mut self.layers, place, kept, factors);
            let after = luminance(self.sums[place].radiance);
            if before > 0.0 {
                self.noted[place] = self.noted[place].map(|mean| mean * (after / before));
            }
        }
        for chunk in self.begun.iter_mut().flatten() {
            for (place, sum) in chunk.pixels.iter_mut().enumerate() {
                relight_pixel(sum, &mut chunk.layers, place, kept, factors);
            }
        }
    }
}

fn relight_pixel(sum: &mut PixelSum, layers: &mut LayerSums, place: usize, kept: FilmLayers, factors: &[Rgb]) {
    let start = place * kept.values();
    let mut radiance = match (kept.groups, factors) {
        (0, &[factor]) => sum.radiance * factor,
        _ => Rgb::ZERO,
    };
    // No sample has become brighter by more than this.
    let mut most = match kept.groups {
        0 => factors.iter().map(|factor| factor.max_element()).fold(0.0, f32::max),
        _ => 0.0_f32,
    };
    let groups = layers
        .values
        .get_mut(start..start + 3 * kept.groups)
        .unwrap_or_default();
    for (light, &factor) in groups.chunks_exact_mut(3).zip(factors) {
        let own = Rgb::from_slice(light);
        if own != Rgb::ZERO {
            most = most.max(factor.max_element());
        }
        let relit = own * factor;
        relit.write_to_slice(light);
        radiance += relit;
    }
    sum.luminance_squared *= most * most;
    sum.radiance = radiance;
}
