//! What a film knows of the errors of its pixels, see [`crate::render::mean_error`].

use glam::UVec2;

use super::Film;
use crate::color::luminance;
use crate::render::mean_error::{BLOCK, BLOCKS, BlockError, block_of, share_of_doubling};
use crate::render::noise::{DARK, around, likely_luminance};
use crate::render::tile::{PixelSum, TILE, Tile};

impl Film {
    /// Notes the means of the blocks of a tile whose number of samples has become a power of two, and compares them with those of half as many.
    pub(super) fn compare_halves(&mut self, tile: Tile) {
        let starts = |start: u32, length: u32| (start..start + length).step_by(BLOCK as usize);
        for (x, y) in starts(tile.y, tile.height).flat_map(|y| starts(tile.x, tile.width).map(move |x| (x, y))) {
            let count = self.counts[self.index(x, y)];
            let block = self.tile_index(x, y) * BLOCKS + block_of(x, y);
            let noted = self.errors[block].noted;
            if !count.is_power_of_two() || count == noted {
                continue;
            }
            let bottom = (y + BLOCK).min(tile.y + tile.height);
            let width = BLOCK.min(tile.x + tile.width - x) as usize;
            let rows = (y..bottom).map(|y| self.index(x, y)..self.index(x, y) + width);
            let pixels: Vec<usize> = rows.flatten().collect();
            let mean_of = |&pixel: &usize| luminance(self.sums[pixel].radiance / count as f32);
            if 2 * noted == count {
                let average = pixels.iter().map(|pixel| mean_of(pixel).abs()).sum::<f32>() / pixels.len() as f32;
                // The halves of half as many samples were compared, too.
                let has_quarter = self.errors[block].level == noted;
                let mut error = BlockError {
                    level: count,
                    luminance: average,
                    ..BlockError::default()
                };
                for pixel in &pixels {
                    let (mean, [half, quarter]) = (mean_of(pixel), self.noted[*pixel]);
                    let scale = mean.abs().max(DARK * average).max(f32::MIN_POSITIVE);
                    error.difference += ((mean - half) / scale).powi(2);
                    if has_quarter {
                        error.difference_before += ((half - quarter) / scale).powi(2);
                    }
                    error.spread += squared_deviation(&self.sums[*pixel], count) / scale / scale;
                }
                self.errors[block] = error;
            }
            let means: Vec<f32> = pixels.iter().map(mean_of).collect();
            for (&pixel, mean) in pixels.iter().zip(means) {
                let half = if count > 1 { self.noted[pixel][0] } else { 0.0 };
                self.noted[pixel] = [mean, half];
            }
            self.errors[block].noted = count;
        }
    }

    /// The share of a doubling of samples in the one before it, in a tile.
    fn share_of_doubling(&self, tile: usize) -> f32 {
        share_of_doubling(&self.errors[tile * BLOCKS..(tile + 1) * BLOCKS])
    }

    /// The mean luminance and the estimated square of its standard error of the pixels of a tile that have two samples or more.
    pub(in crate::render) fn mean_errors(&self, tile: Tile) -> impl Iterator<Item = (f32, f32)> {
        let index = self.tile_index(tile.x, tile.y);
        let share = self.share_of_doubling(index);
        let efficiencies: [f32; BLOCKS] = std::array::from_fn(|block| {
            let (x, y) = (block as u32 * BLOCK % TILE, block as u32 * BLOCK / TILE * BLOCK);
            let is_inside = x < tile.width && y < tile.height;
            let count = if is_inside {
                self.counts[self.index(tile.x + x, tile.y + y)]
            } else {
                0
            };
            self.errors[index * BLOCKS + block].efficiency(count, share)
        });
        (tile.y..tile.y + tile.height)
            .flat_map(move |y| (tile.x..tile.x + tile.width).map(move |x| (x, y)))
            .filter_map(move |(x, y)| {
                let place = self.index(x, y);
                let count = self.counts[place];
                (count >= 2).then(|| {
                    let sum = self.sum(x, y);
                    let mean = luminance(sum.radiance / count as f32 + self.splatted(place));
                    let own = squared_deviation(&sum, count) * efficiencies[block_of(x, y)];
                    (mean, own + self.splat_variance(place))
                })
            })
    }

    /// The estimated variance of the light of splats in the pixels that [`Self::mean_errors`] has.
    pub(in crate::render) fn splat_variances(&self, tile: Tile) -> impl Iterator<Item = f32> {
        (tile.y..tile.y + tile.height)
            .flat_map(move |y| (tile.x..tile.x + tile.width).map(move |x| self.index(x, y)))
            .filter(|&place| self.counts[place] >= 2)
            .map(|place| self.splat_variance(place))
    }

    /// The mean luminance of a pixel's own samples, and that of splats.
    pub(in crate::render) fn mean_luminances(&self, x: u32, y: u32) -> [f32; 2] {
        let place = self.index(x, y);
        let own = self.sum(x, y).radiance / self.counts[place].max(1) as f32;
        [own, self.splatted(place)].map(luminance)
    }

    /// The luminance that a pixel is likely to have by what is known of it, its mean luminance with the estimated square of its standard error, and by the pixels around it in its tile, as
    /// [`likely_luminance`].
    pub(in crate::render) fn likely_luminance(&self, pixel: UVec2, known: (f32, f32)) -> f32 {
        let tile = pixel / TILE * TILE;
        let size = (UVec2::new(self.width, self.height) - tile).min(UVec2::splat(TILE));
        let of_pixel = |(x, y): (u32, u32)| {
            let (x, y) = (tile.x + x, tile.y + y);
            let [own, splatted] = self.mean_luminances(x, y);
            let error = self.own_variance(x, y)? + self.splat_variance(self.index(x, y));
            Some((own + splatted, error))
        };
        let place = pixel - tile;
        likely_luminance(known, around(place.x, place.y, size.x, size.y).filter_map(of_pixel))
    }

    /// The estimated standard error of a pixel's luminance; None below two samples. How it is estimated: `render/mean_error.rs`, and
    /// `render/replicas.rs` where there are replicas.
    pub fn standard_error(&self, x: u32, y: u32) -> Option<f32> {
        let place = self.index(x, y);
        let own = self.own_variance(x, y)? * self.correction.unwrap_or(1.0);
        Some((own + self.splat_variance(place)).sqrt())
    }

    /// The estimated variance of the mean luminance of a pixel's own samples, without replicas; None below two samples.
    pub(in crate::render) fn own_variance(&self, x: u32, y: u32) -> Option<f32> {
        let count = self.counts[self.index(x, y)];
        if count < 2 {
            return None;
        }
        let tile = self.tile_index(x, y);
        let block = &self.errors[tile * BLOCKS + block_of(x, y)];
        let efficiency = block.efficiency(count, self.share_of_doubling(tile));
        Some(squared_deviation(&self.sum(x, y), count) * efficiency)
    }

    /// Says how many times what is estimated from a pixel's own samples their squared error is. Returns whether that is new.
    pub fn correct_errors(&mut self, correction: f32) -> bool {
        self.correction.replace(correction) != Some(correction)
    }
}

/// The mean squared deviation of the luminances of a pixel's samples from their mean.
fn squared_deviation(sum: &PixelSum, count: u32) -> f32 {
    let scale = 1.0 / count as f32;
    let mean = luminance(sum.radiance * scale);
    (sum.luminance_squared * scale - mean * mean).max(0.0)
}
