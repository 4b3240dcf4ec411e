//! Scales the light of lamps that have changed since it was sampled. Light transport is linear, and the film stores the
//! light of each group of lamps separately.

use glam::UVec2;
use rayon::prelude::*;

use super::{Film, Moments};
use crate::color::{Rgb, luminance};
use crate::render::layers::{FilmLayers, Layer, LayerSums, Layers};
use crate::render::noise::mean_error::{BlockError, Efficiency};
use crate::render::tile::{PixelSum, TILE, tiles};

/// The pixels of a tile in the film.
const PIXELS: usize = (TILE * TILE) as usize;

/// The light of a layer removed from the film: that of a lamp which is off for a while.
#[derive(Clone, Debug)]
pub struct SetAside {
    /// The mean of each pixel's samples, and the variance of the luminance of one of them, by index of the film.
    pixels: Vec<(Rgb, f32)>,
    /// The number of samples that every pixel had.
    pub samples: u32,
}

/// The source of a layer's light.
#[derive(Clone, Copy, Debug)]
pub enum LightFrom<'a> {
    /// A layer of the film as it is; layer 0 is all light if the film keeps no groups.
    Layer(usize),
    /// A copy made with [`Film::set_aside`].
    Aside(&'a SetAside),
    /// No light.
    Nowhere,
}

/// The light of a new layer: its source, and the factor on it.
pub type NewLayer<'a> = (LightFrom<'a>, Rgb);

impl SetAside {
    /// The memory for a pixel in bytes.
    pub const BYTES_OF_PIXEL: u64 = size_of::<(Rgb, f32)>() as u64;
}

impl Film {
    /// Whether [`Self::relight`] can be used: every pixel has samples, and there is no light besides theirs.
    pub fn can_be_relit(&self) -> bool {
        let other = Layers::of(&[Layer::Direct, Layer::Indirect, Layer::Emitted]);
        let has_begun = self.previews.iter().all(Option::is_none);
        has_begun && !self.has_splats() && !self.kept.layers.has_any_of(other) && self.chunks.is_none()
    }

    /// A copy of the light of a layer, or of all light if the film keeps no groups. It is the mean of `samples` for
    /// each pixel.
    pub fn set_aside(&self, layer: usize, samples: u32) -> SetAside {
        let mut pixels = vec![(Rgb::ZERO, 0.0); self.sums.len()];
        let tiles = pixels.par_chunks_mut(PIXELS).zip(tiles(self.width, self.height));
        tiles.for_each(|(pixels, tile)| {
            for y in tile.y..tile.y + tile.height {
                let mut moments = [Moments::default(); TILE as usize];
                self.moments_row(tile, y, &mut moments);
                for (x, moments) in (tile.x..tile.x + tile.width).zip(moments) {
                    let light = match self.kept.groups {
                        0 => moments.radiance,
                        _ if moments.samples == 0 => Rgb::ZERO,
                        _ => Rgb::from_slice(&self.layer_values(x, y)[3 * layer..]) / moments.samples as f32,
                    };
                    let variance = moments.variance * share_of(light, moments.radiance);
                    // The film will weight the returning light with its error at fewer samples than the film has.
                    let own = samples as f32 / moments.samples.max(1) as f32;
                    pixels[(y % TILE * TILE + x % TILE) as usize] = (light, variance * own);
                }
            }
        });
        SetAside { pixels, samples }
    }

    /// Replaces the layers of light, as if all had been sampled so: `groups` layers, or all light together if that is 0
    /// and `new` has one. Other layers of the film are dropped. The variance of samples, from which noise is estimated,
    /// is not known by layer: each layer is assumed to have the same share of it as of the light. Light from a copy has
    /// the error of the samples in that copy.
    pub fn relight(&mut self, groups: usize, new: &[NewLayer]) {
        let before = std::mem::replace(&mut self.kept.groups, groups);
        let kept = self.kept;
        let stays = |(layer, (from, _)): (usize, &NewLayer)| matches!(from, LightFrom::Layer(old) if *old == layer);
        if before != groups || !new.iter().enumerate().all(stays) {
            regroup(&mut self.sums, &mut self.layers, before, kept, new);
            for chunk in self.begun.iter_mut().flatten() {
                regroup(&mut chunk.pixels, &mut chunk.layers, before, kept, new);
            }
        }
        let stride = kept.values();
        let mut values: Vec<&mut [f32]> = self.layers.values.chunks_mut((PIXELS * stride).max(1)).collect();
        values.resize_with(self.begun.len(), Default::default);
        let counts = self.counts.par_chunks(PIXELS);
        let sums = self.sums.par_chunks_mut(PIXELS).zip(self.noted.par_chunks_mut(PIXELS));
        let tiles = sums.zip(values).zip(&mut self.begun).zip(counts).enumerate();
        let is_back = new.iter().any(|(from, _)| matches!(from, LightFrom::Aside(_)));
        if is_back {
            // Halves of the samples do not contain the light of copies.
            self.errors.fill(BlockError::default());
            self.efficiencies.fill(Efficiency::default());
        }
        tiles.for_each(|(tile, ((((sums, noted), values), begun), counts))| {
            let first = tile * PIXELS;
            let mut in_chunk = [0; PIXELS];
            if let Some(chunk) = begun {
                let (corner, width) = (UVec2::new(chunk.tile.x, chunk.tile.y), chunk.tile.width as usize);
                for place in 0..chunk.pixels.len() {
                    let (x, y) = (place % width, place / width);
                    let within = y * TILE as usize + x;
                    let count = chunk.count(corner.x + x as u32, corner.y + y as u32);
                    in_chunk[within] = count;
                    let groups = groups_of(&mut chunk.layers.values, place, kept);
                    let counts = [count, counts[within]];
                    relight_pixel(&mut chunk.pixels[place], groups, new, first + within, counts);
                }
            }
            for (place, (sum, noted)) in sums.iter_mut().zip(noted).enumerate() {
                let before = luminance(sum.radiance);
                let groups = groups_of(values, place, kept);
                let counts = [counts[place] - in_chunk[place], counts[place]];
                relight_pixel(sum, groups, new, first + place, counts);
                if before > 0.0 {
                    *noted = noted.map(|mean| mean * (luminance(sum.radiance) / before));
                }
            }
        });
    }
}

/// Rearranges layers of pixels, of which there were `before`. New ones are black.
fn regroup(pixels: &mut [PixelSum], layers: &mut LayerSums, before: usize, kept: FilmLayers, new: &[NewLayer]) {
    let old_kept = FilmLayers { groups: before, ..kept };
    let old = std::mem::take(&mut layers.values);
    layers.values = vec![0.0; pixels.len() * kept.values()];
    for (place, pixel) in pixels.iter_mut().enumerate() {
        let old = &old[place * old_kept.values()..][..old_kept.values()];
        let light = |&(from, _): &NewLayer| match from {
            LightFrom::Layer(_) if before == 0 => pixel.radiance,
            LightFrom::Layer(layer) => Rgb::from_slice(&old[3 * layer..]),
            LightFrom::Aside(_) | LightFrom::Nowhere => Rgb::ZERO,
        };
        let values = &mut layers.values[place * kept.values()..][..kept.values()];
        let (groups, sums) = values.split_at_mut(3 * kept.groups);
        for (target, new) in groups.chunks_exact_mut(3).zip(new) {
            light(new).write_to_slice(target);
        }
        sums.copy_from_slice(&old[3 * before..]);
        if kept.groups == 0 {
            pixel.radiance = new.first().map(light).unwrap_or_default();
        }
    }
}

/// The light of each group of a pixel, as a part of the values of all pixels.
fn groups_of(values: &mut [f32], pixel: usize, kept: FilmLayers) -> &mut [f32] {
    let start = pixel * kept.values();
    values.get_mut(start..start + 3 * kept.groups).unwrap_or_default()
}

/// The share of a layer in the luminance of a pixel.
fn share_of(layer: Rgb, all: Rgb) -> f32 {
    let share = luminance(layer) / luminance(all);
    if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 }
}

/// Multiplies the light of each group of a pixel, and adds the light of copies. `index` is that of the film. `counts`
/// are the samples of the sum, and all of the pixel, which may have an incomplete chunk as well.
fn relight_pixel(sum: &mut PixelSum, groups: &mut [f32], new: &[NewLayer], index: usize, counts: [u32; 2]) {
    let [count, all] = counts.map(|count| count as f32);
    let before = sum.radiance;
    let spread = (sum.luminance_squared - luminance(before).powi(2) / count.max(1.0)).max(0.0);
    let (mut radiance, mut variance) = (Rgb::ZERO, 0.0);
    for (layer, &(from, factor)) in new.iter().enumerate() {
        let own = groups.get_mut(3 * layer..3 * layer + 3);
        let rise = luminance(factor).powi(2);
        let light = match from {
            LightFrom::Layer(_) => {
                let light = own.as_deref().map_or(before, Rgb::from_slice);
                variance += spread * share_of(light, before) * rise;
                light
            }
            LightFrom::Aside(aside) => {
                let (mean, of_sample) = aside.pixels[index];
                // The error of the copy's mean is that of its own samples.
                variance += count * of_sample * rise * all / aside.samples.max(1) as f32;
                mean * count
            }
            LightFrom::Nowhere => Rgb::ZERO,
        };
        let light = light * factor;
        if let Some(own) = own {
            light.write_to_slice(own);
        }
        radiance += light;
    }
    sum.radiance = radiance;
    sum.luminance_squared = luminance(radiance).powi(2) / count.max(1.0) + variance;
}
