//! The light of lamps that have changed since it was sampled. Light is linear, and the film keeps the light of each group of lamps apart.

use glam::UVec2;
use rayon::prelude::*;

use super::Film;
use crate::color::{Rgb, luminance};
use crate::render::layers::{FilmLayers, Layer, LayerSums, Layers};
use crate::render::tile::{PixelSum, TILE};

/// The pixels of a tile in the film.
const PIXELS: usize = (TILE * TILE) as usize;

/// The light of a layer that is not in the film any more: that of a lamp that does not shine for a while.
#[derive(Clone, Debug)]
pub struct SetAside {
    /// The mean of each pixel's samples, and the mean of the squared luminance of all their light, by index of the film.
    means: Vec<(Rgb, f32)>,
    /// The number of samples that every pixel had.
    pub samples: u32,
}

/// Where the light of a layer is.
#[derive(Clone, Copy, Debug)]
pub enum LightFrom<'a> {
    /// In a layer of the film as it is; in layer 0 is all light if the film keeps no groups.
    Layer(usize),
    /// Beside the film, from which it was taken with [`Film::set_aside`].
    Aside(&'a SetAside),
}

/// The light of a layer: where it is now, and the factor by which it is multiplied.
pub type NewLayer<'a> = (LightFrom<'a>, Rgb);

impl SetAside {
    /// The memory for a pixel in bytes.
    pub const BYTES_OF_PIXEL: u64 = size_of::<(Rgb, f32)>() as u64;
}

impl Film {
    /// Whether [`Self::relight`] can be used: every pixel has samples, and there is no light besides what they have found.
    pub fn can_be_relit(&self) -> bool {
        let other = Layers::of(&[Layer::Direct, Layer::Indirect, Layer::Emitted]);
        let has_begun = self.previews.iter().all(Option::is_none);
        has_begun && !self.has_splats() && !self.kept.layers.has_any_of(other) && self.chunks.is_none()
    }

    /// A copy of the light of a layer, or of all light if the film keeps no groups.
    pub fn set_aside(&self, layer: usize) -> SetAside {
        let mut means = vec![(Rgb::ZERO, 0.0); self.sums.len()];
        let pixels = (0..self.height).flat_map(|y| (0..self.width).map(move |x| (x, y)));
        for (x, y) in pixels.filter(|&(x, y)| self.samples(x, y) > 0) {
            let sum = self.sum(x, y);
            let light = match self.kept.groups {
                0 => sum.radiance,
                _ => Rgb::from_slice(&self.layer_values(x, y)[3 * layer..]),
            };
            let scale = 1.0 / self.samples(x, y) as f32;
            means[self.index(x, y)] = (light * scale, sum.luminance_squared * scale);
        }
        SetAside {
            means,
            samples: self.sample_count(),
        }
    }

    /// Makes these the layers of light, as if all had been sampled so: `groups` layers, or all light together if that is 0 and `new` has one. What the film had
    /// of other layers is gone. The spread of samples, from which noise is estimated, is taken to be the largest that it can be.
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
                    relight_pixel(&mut chunk.pixels[place], groups, new, first + within, count);
                }
            }
            for (place, (sum, noted)) in sums.iter_mut().zip(noted).enumerate() {
                let before = luminance(sum.radiance);
                let groups = groups_of(values, place, kept);
                relight_pixel(sum, groups, new, first + place, counts[place] - in_chunk[place]);
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
            LightFrom::Aside(_) => Rgb::ZERO,
        };
        let mut lights = new.iter().map(light);
        if kept.groups == 0 {
            pixel.radiance = lights.next().unwrap_or_default();
        } else {
            let values = &mut layers.values[place * kept.values()..][..kept.values()];
            let (groups, sums) = values.split_at_mut(3 * kept.groups);
            for (target, light) in groups.chunks_exact_mut(3).zip(lights) {
                light.write_to_slice(target);
            }
            sums.copy_from_slice(&old[3 * before..]);
        }
    }
}

/// The light of each group of a pixel among the values of pixels.
fn groups_of(values: &mut [f32], pixel: usize, kept: FilmLayers) -> &mut [f32] {
    let start = pixel * kept.values();
    values.get_mut(start..start + 3 * kept.groups).unwrap_or_default()
}

/// Multiplies the light of each group of a pixel with so many samples, and adds what has been set aside. `index` is that of the film.
fn relight_pixel(sum: &mut PixelSum, groups: &mut [f32], new: &[NewLayer], index: usize, count: u32) {
    let (mut radiance, mut squared) = (Rgb::ZERO, 0.0_f32);
    for (layer, &(from, factor)) in new.iter().enumerate() {
        let own = groups.get_mut(3 * layer..3 * layer + 3);
        let (light, most) = match from {
            LightFrom::Layer(_) => {
                let light = own.as_deref().map_or(sum.radiance, Rgb::from_slice);
                (light, sum.luminance_squared)
            }
            LightFrom::Aside(aside) => {
                let (light, squared) = aside.means[index];
                (light * count as f32, squared * count as f32)
            }
        };
        // No sample has become brighter by more than this.
        let rise = factor.max_element();
        if light != Rgb::ZERO {
            squared = squared.max(most * rise * rise);
        }
        let light = light * factor;
        if let Some(own) = own {
            light.write_to_slice(own);
        }
        radiance += light;
    }
    (sum.radiance, sum.luminance_squared) = (radiance, squared);
}
