//! The film's error estimates for its pixels, see [`crate::render::noise::mean_error`].

use glam::UVec2;

use super::Film;
use crate::color::luminance;
use crate::render::noise::blocks::{BLOCK, BLOCKS, PerBlock, block_of, blocks_of, parts};
use crate::render::noise::mean_error::{BlockError, Efficiency, PATCH};
use crate::render::noise::{DARK, around, likely_luminance};
use crate::render::tile::{PixelSum, TILE, Tile};

impl Film {
    /// Stores the means of the blocks of a tile whose number of samples has become a power of two, and compares them
    /// with those at half as many.
    pub(super) fn compare_halves(&mut self, tile: Tile) {
        let place = self.tile_index(tile.x, tile.y);
        let mut are_new = false;
        for patch in parts(tile, PATCH) {
            let mut average = None;
            for (of_tile, block) in blocks_of(patch) {
                let count = self.counts[self.index(block.x, block.y)];
                if !count.is_power_of_two() || count == self.errors[place * BLOCKS + of_tile].noted {
                    continue;
                }
                let average = *average.get_or_insert_with(|| self.mean_brightness(patch));
                self.compare_halves_of(block, place * BLOCKS + of_tile, average);
                are_new = true;
            }
        }
        if are_new {
            self.find_efficiency(place);
        }
    }

    /// Estimates the sampling efficiency of a tile from its blocks' errors.
    pub(super) fn find_efficiency(&mut self, tile: usize) {
        self.efficiencies[tile] = Efficiency::of(self.block_errors_of(tile));
    }

    /// The mean magnitude of the luminance of some pixels.
    fn mean_brightness(&self, part: Tile) -> f32 {
        let brightness = |index: usize| luminance(self.sums[index].radiance / self.counts[index].max(1) as f32).abs();
        let sum: f32 = self.places_of(part).map(brightness).sum();
        sum / (part.width * part.height) as f32
    }

    /// Stores the means of a block, whose number of samples has become a power of two. `average` is the brightness of
    /// its patch.
    fn compare_halves_of(&mut self, block: Tile, place: usize, average: f32) {
        let count = self.counts[self.index(block.x, block.y)];
        let old = self.errors[place];
        let mut error = match 2 * old.noted == count {
            true => BlockError {
                noted: count,
                level: count,
                luminance: average,
                // The halves of half as many samples may have been compared, too.
                difference_before: if old.level == old.noted { 0.0 } else { -1.0 },
                ..BlockError::default()
            },
            false => BlockError { noted: count, ..old },
        };
        let mut pixels = [0; (BLOCK * BLOCK) as usize];
        for (pixel, index) in pixels.iter_mut().zip(self.places_of(block)) {
            *pixel = index;
        }
        for &pixel in &pixels[..(block.width * block.height) as usize] {
            let mean = luminance(self.sums[pixel].radiance / count as f32);
            let [half, quarter] = self.noted[pixel];
            self.noted[pixel] = [mean, if count > 1 { half } else { 0.0 }];
            if error.level != count {
                continue;
            }
            let scale = mean.abs().max(DARK * average).max(f32::MIN_POSITIVE);
            error.difference += ((mean - half) / scale).powi(2);
            if error.difference_before >= 0.0 {
                error.difference_before += ((half - quarter) / scale).powi(2);
            }
            error.spread += squared_deviation(&self.sums[pixel], count) / scale / scale;
        }
        self.errors[place] = error;
    }

    fn block_errors_of(&self, tile: usize) -> &PerBlock<BlockError> {
        let errors = &self.errors[tile * BLOCKS..];
        errors.first_chunk().expect("there are errors of all tiles")
    }

    /// The error estimates of each block of a tile.
    pub(in crate::render) fn block_errors(&self, tile: Tile) -> &PerBlock<BlockError> {
        self.block_errors_of(self.tile_index(tile.x, tile.y))
    }

    /// The stored mean luminances of a pixel at the last power of two of samples, and at half as many.
    pub(in crate::render) fn halves(&self, x: u32, y: u32) -> [f32; 2] {
        self.noted[self.index(x, y)]
    }

    /// The mean number of rays of a pixel's samples, at least the camera ray.
    pub(in crate::render) fn rays_of_sample(&self, x: u32, y: u32) -> f32 {
        let place = self.index(x, y);
        (self.sums[place].rays / self.counts[place].max(1) as f32).max(1.0)
    }

    /// The mean luminance and the estimated square of its standard error, for the pixels of a tile with two samples or
    /// more.
    pub(in crate::render) fn mean_errors(&self, tile: Tile) -> impl Iterator<Item = (f32, f32)> {
        let mut efficiencies = [0.0; BLOCKS];
        for (place, block) in blocks_of(tile) {
            efficiencies[place] = self.efficiency(block.x, block.y);
        }
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

    /// The variance of the mean luminance of a pixel's own samples, over the samples' mean squared deviation.
    fn efficiency(&self, x: u32, y: u32) -> f32 {
        let (tile, block) = (self.tile_index(x, y), block_of(x, y));
        let level = self.errors[tile * BLOCKS + block].level;
        self.efficiencies[tile].at(block, level, self.counts[self.index(x, y)])
    }

    /// The estimated variance of the light of splats in the pixels of [`Self::mean_errors`].
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

    /// The likely luminance of a pixel, from its mean luminance with the estimated square of its standard error in
    /// `known`, and from the pixels around it in its tile, as [`likely_luminance`].
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

    /// The estimated standard error of a pixel's luminance; None below two samples. The estimate is that of
    /// `render/noise/mean_error.rs`, corrected by `render/noise/replicas.rs` where there are replicas.
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
        Some(squared_deviation(&self.sum(x, y), count) * self.efficiency(x, y))
    }

    /// Sets the ratio of the true squared errors to those estimated from the pixels' own samples. Returns whether it
    /// has changed.
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
