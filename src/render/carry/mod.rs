//! What an earlier picture still tells about a new one: light that is shown in place of noise until the new picture has samples of its own. It is only
//! ever shown, and never a part of the film.
//!
//! Each pixel of the new picture is found in the earlier one by the place that its [G-buffer](super::gbuffer) tells
//! (`reproject.rs`; Nehab et al., Accelerating Real-Time Shading with Reverse Reprojection Caching, Graphics Hardware 2007). What is kept there is the light
//! divided by the albedo, so that a surface may have another colour now. What the new samples tell of larger blocks corrects it, and where they
//! contradict it is given up (`trust.rs`). New and old light are then blended by what both are worth in samples, and the old light goes altogether once
//! the new samples are worth far more.

mod coarse;
mod earlier;
mod reproject;
#[cfg(test)]
mod tests;
mod trust;

use std::sync::Arc;

use glam::{UVec2, Vec2, Vec3};
use rayon::prelude::*;

pub use self::coarse::Coarse;
pub use self::earlier::Earlier;
use self::reproject::Reprojection;
use self::trust::Trust;
use super::camera::Camera;
use super::film::Film;
use super::gbuffer::{Texel, TileGBuffer};
use super::tile::{TILE, Tile, tiles as all_tiles};
use crate::color::{Rgb, luminance};

/// Is added to albedos before light is divided by them.
const LEAST_ALBEDO: f32 = 0.02;
/// The samples that one sample of a denoised picture is worth, by what `edit --measure-settling` has measured in rooms.
pub const WORTH_OF_DENOISED: f32 = 64.0;
/// The samples that the variance of a sample is known from, where light is carried over.
const KNOWN_VARIANCE: f32 = 16.0;
/// The samples that the mean light of a tile's preview is worth.
const WORTH_OF_MEAN: f32 = 2.0;
/// The least relative standard deviation that is believed of guided paths.
const DEVIATION_OF_GUIDED: f32 = 3.0;
/// The samples that a filtered preview is worth.
const WORTH_OF_COARSE: f32 = 16.0;
/// Light of no more worth counts as not found: a filtered preview is better.
const LEAST_FOUND: f32 = 4.0;
/// Where earlier light covers so much of the picture, previews are not filtered.
const NEARLY_ALL: f32 = 0.9995;
/// New light that is brighter than carried light by more than this factor is shown darker, as long as it is worth less.
const OUTLIER: f32 = 3.0;
/// The most samples that earlier light is worth.
const MOST_WORTH: f32 = 512.0;

/// Light of a pixel, and how far it can be relied on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Light {
    /// The radiance divided by the albedo.
    light: Rgb,
    /// The number of samples of a pixel that have about the same error; 0 for a guess that anything else is better than.
    worth: f32,
    /// The variance of the luminance of a single sample.
    variance: f32,
}

impl Light {
    /// The same with what is radiance divided by the albedo of a surface, and worth no more than any light is.
    fn on(self, texel: &Texel) -> Self {
        Self {
            light: self.light / divisor(texel),
            worth: self.worth.min(MOST_WORTH),
            ..self
        }
    }
}

/// The light of an earlier picture that is carried over to a new one.
#[derive(Debug)]
pub struct Carried {
    size: UVec2,
    camera: Camera,
    earlier: Option<Arc<Earlier>>,
    texels: Vec<Texel>,
    light: Vec<Light>,
    /// The pixels that were found in the earlier picture.
    found: usize,
    /// The tiles whose G-buffer is not there.
    missing: usize,
    /// Whether the [`Coarse`] picture was asked for, or is not needed.
    has_coarse: bool,
    /// Whether the G-buffer of each tile is there.
    is_exact: Vec<bool>,
    trust: Trust,
    /// The share of its worth that all light keeps.
    kept: f32,
}

/// A denoised picture of the same film.
#[derive(Clone, Copy, Debug)]
pub struct Clean<'a> {
    /// The pixels row by row.
    pub radiance: &'a [Rgb],
    /// The samples per pixel that it was made from.
    pub samples: u32,
}

impl Carried {
    /// Begins a picture of this size in pixels with guesses of where each of its pixels was in the earlier one, if there is one.
    pub fn begin(earlier: Option<Arc<Earlier>>, camera: &Camera, size: UVec2) -> Self {
        let camera = camera.sharp();
        let pixels = size.x as usize * size.y as usize;
        let (texels, light) = match &earlier {
            Some(earlier) => Reprojection::new(earlier, &camera, size).guess(),
            None => (vec![Texel::nothing(); pixels], vec![Light::default(); pixels]),
        };
        let tiles = size.x.div_ceil(TILE) * size.y.div_ceil(TILE);
        Self {
            size,
            camera,
            texels,
            light,
            found: 0,
            missing: tiles as usize,
            has_coarse: false,
            earlier,
            is_exact: vec![false; tiles as usize],
            trust: Trust::new(size),
            kept: 1.0,
        }
    }

    /// Says that paths are guided: few samples, and those that have taught a guide, do not tell how rare bright ones are.
    pub fn expect_guided_paths(&mut self) {
        self.trust.least_deviation = DEVIATION_OF_GUIDED;
    }

    /// The share of the picture for which there is light of an earlier one, as far as that is known.
    pub fn coverage(&self) -> f32 {
        self.found as f32 / self.light.len().max(1) as f32
    }

    /// Whether a film has as many pixels.
    pub fn is_of_size(&self, film: &Film) -> bool {
        self.size == UVec2::new(film.width(), film.height())
    }

    /// Whether there is an earlier picture.
    pub fn has_earlier(&self) -> bool {
        self.earlier.is_some()
    }

    /// Says how much of the new picture is made: 0 at the beginning, 1 at its last sample. What is carried over goes in the second half, so that the finished
    /// picture has nothing of it.
    pub fn set_progress(&mut self, progress: f32) {
        self.kept = (2.0 - 2.0 * progress).clamp(0.0, 1.0);
    }

    /// Replaces the guesses for these tiles.
    pub fn add(&mut self, tiles: &[TileGBuffer]) {
        let earlier = self.earlier.as_deref();
        let reprojection = earlier.map(|earlier| Reprojection::new(earlier, &self.camera, self.size));
        let find = |tile: &TileGBuffer| -> Vec<Light> {
            let pixels = pixels_of(tile.tile).zip(&tile.texels);
            let found = |((x, y), texel)| reprojection.as_ref().map(|before| before.find(x, y, texel));
            pixels.map(|pixel| found(pixel).unwrap_or_default()).collect()
        };
        let all: Vec<Vec<Light>> = tiles.par_iter().map(find).collect();
        for (tile, light) in tiles.iter().zip(all) {
            for (((x, y), &texel), light) in pixels_of(tile.tile).zip(&tile.texels).zip(light) {
                let place = place_of(self.size, x, y);
                (self.texels[place], self.light[place]) = (texel, light);
                self.found += usize::from(light.worth > LEAST_FOUND);
            }
            let index = self.tile_index(tile.tile);
            self.missing -= usize::from(!std::mem::replace(&mut self.is_exact[index], true));
        }
    }

    /// Compares tiles with the samples that the film has there now. Tiles that have only a preview take up what that tells.
    pub fn learn(&mut self, tiles: &[Tile], film: &Film) {
        let is_exact = |tile: &&Tile| self.is_exact[self.tile_index(**tile)];
        let exact: Vec<Tile> = tiles.iter().filter(is_exact).copied().collect();
        let (sampled, previews): (Vec<Tile>, Vec<Tile>) =
            exact.into_iter().partition(|tile| film.samples(tile.x, tile.y) > 0);
        previews.iter().for_each(|&tile| self.take_preview(tile, film));
        if sampled.is_empty() || self.found == 0 && !self.has_coarse {
            return;
        }
        let old = carried_at(self.size, &self.texels, &self.light);
        self.trust.learn(&sampled, film, old);
    }

    /// Compares all that is carried over with a denoised picture of the film.
    pub fn learn_clean(&mut self, film: &Film, clean: Clean) {
        let old = carried_at(self.size, &self.texels, &self.light);
        self.trust.learn_clean(film, clean, old);
    }

    /// Where nothing is carried over, shows the surfaces of a tile in the mean light of its preview, for all normals near the same axis together. Single
    /// samples of a preview would only be noise.
    fn take_preview(&mut self, tile: Tile, film: &Film) {
        let mut means = [(Rgb::ZERO, 0.0); DIRECTIONS];
        for (x, y) in pixels_of(tile) {
            let Some(pixel) = film.pixel(x, y) else { continue };
            let texel = &self.texels[place_of(self.size, x, y)];
            let mean = &mut means[direction_of(texel)];
            *mean = (mean.0 + pixel.radiance / (pixel.albedo + LEAST_ALBEDO), mean.1 + 1.0);
        }
        for (x, y) in pixels_of(tile) {
            let place = place_of(self.size, x, y);
            let (sum, count) = means[direction_of(&self.texels[place])];
            let light = &mut self.light[place];
            if light.worth <= WORTH_OF_MEAN && count > 0.0 {
                let mean = sum / count;
                *light = Light {
                    light: mean,
                    worth: WORTH_OF_MEAN,
                    variance: luminance(mean).powi(2),
                };
            }
        }
    }

    /// Blends a row of pixels of a tile, as the film has it, with what is carried over. `clean` takes the place of the film's pixels. Returns whether
    /// anything of the row is still carried over.
    pub fn blend_row(&self, film: &Film, tile: Tile, y: u32, clean: Option<Clean>, row: &mut [Option<Rgb>]) -> bool {
        let mut is_carried = false;
        for (x, pixel) in (tile.x..tile.x + tile.width).zip(row) {
            let place = place_of(self.size, x, y);
            let new = match clean {
                Some(clean) => Some((clean.radiance[place], WORTH_OF_DENOISED * clean.samples as f32)),
                None => match film.samples(x, y) {
                    // Previews are taken up tile by tile.
                    0 => None,
                    samples => pixel.map(|radiance| (radiance, samples as f32)),
                },
            };
            if let Some((mixed, carried)) = self.blend(place, UVec2::new(x, y), new) {
                (*pixel, is_carried) = (Some(mixed), is_carried || carried > 0.0);
            }
        }
        is_carried
    }

    /// The denoised picture with what is carried over, and the tiles that still have some of that.
    pub fn blend_picture(&self, film: &Film, clean: Clean) -> (Vec<Rgb>, Vec<Tile>) {
        let blend_tile = |tile: Tile| {
            let mut rows = vec![None; (tile.width * tile.height) as usize];
            let mut is_carried = false;
            for (y, row) in (tile.y..).zip(rows.chunks_exact_mut(tile.width as usize)) {
                is_carried |= self.blend_row(film, tile, y, Some(clean), row);
            }
            (tile, rows, is_carried)
        };
        let blended: Vec<_> = all_tiles(self.size.x, self.size.y)
            .into_par_iter()
            .map(blend_tile)
            .collect();
        let (mut picture, mut carried) = (vec![Rgb::ZERO; self.light.len()], Vec::new());
        for (tile, rows, is_carried) in blended {
            for ((x, y), pixel) in pixels_of(tile).zip(rows) {
                picture[place_of(self.size, x, y)] = pixel.unwrap_or_default();
            }
            carried.extend(is_carried.then_some(tile));
        }
        (picture, carried)
    }

    /// The radiance of a pixel, of which `new` is what the film tells, with its worth. The second number is the worth of what is carried over. None if
    /// nothing is known.
    fn blend(&self, place: usize, pixel: UVec2, new: Option<(Rgb, f32)>) -> Option<(Rgb, f32)> {
        let Light { light, worth, .. } = self.light[place];
        let standing = self.trust.at(pixel);
        let old = light * divisor(&self.texels[place]) * standing.correction;
        let Some((new, samples)) = new else {
            return (light != Rgb::ZERO || worth > 0.0).then_some((old, worth.max(f32::MIN_POSITIVE)));
        };
        let worth = faded(standing.worth(worth) * self.kept, samples);
        if worth <= 0.0 {
            return Some((new, 0.0));
        }
        // A few bright samples would stand out of what has no noise.
        let most = OUTLIER * (1.0 + samples / worth) * luminance(old).max(f32::MIN_POSITIVE);
        let own = luminance(new);
        let new = if own > most { new * (most / own) } else { new };
        Some(((old * worth + new * samples) / (worth + samples), worth))
    }

    /// Takes up what a [`Coarse`] picture of the same film tells, where nothing better is carried over.
    pub fn add_coarse(&mut self, light: &[Rgb]) {
        for (own, &coarse) in self.light.iter_mut().zip(light) {
            let share = WORTH_OF_COARSE / (own.worth + WORTH_OF_COARSE);
            *own = Light {
                light: own.light.lerp(coarse, share),
                worth: own.worth + WORTH_OF_COARSE,
                variance: own.variance.max(luminance(coarse).powi(2)),
            };
        }
    }

    /// The coarse picture that previews of all tiles make, once they and the G-buffer are there and before there are samples everywhere; None before and
    /// afterwards.
    pub fn coarse(&mut self, film: &Film) -> Option<Coarse> {
        if self.has_coarse || self.missing > 0 {
            return None;
        }
        self.has_coarse = self.coverage() >= NEARLY_ALL;
        let coarse = (!self.has_coarse).then(|| Coarse::of(film, &self.texels)).flatten();
        self.has_coarse |= coarse.is_some();
        coarse
    }

    /// The picture as it is shown, to be carried over to the next one. It is still the one before while this one has hardly begun.
    pub fn into_earlier(self, film: &Film, clean: Option<Clean>) -> Option<Arc<Earlier>> {
        if self.missing > 0 || !self.is_of_size(film) {
            return self.earlier;
        }
        let known = |place: usize| {
            let (x, y) = (place as u32 % self.size.x, place as u32 / self.size.x);
            self.known(film, clean, place, UVec2::new(x, y))
        };
        let light = (0..self.light.len()).into_par_iter().map(known).collect();
        Some(Arc::new(Earlier::new(self.camera, self.size, self.texels, light)))
    }

    /// The picture before this one, without anything of this one.
    pub fn into_before(self) -> Option<Arc<Earlier>> {
        self.earlier
    }

    /// What is known of a pixel.
    fn known(&self, film: &Film, clean: Option<Clean>, place: usize, pixel: UVec2) -> Light {
        let own = earlier::radiance_of(film, clean, place, pixel);
        let new = own.map(|own| (own.light, own.worth));
        let (radiance, carried) = self.blend(place, pixel, new).unwrap_or_default();
        let own = own.unwrap_or_default();
        // Few samples do not tell how rare bright ones are.
        let samples = film.samples(pixel.x, pixel.y) as f32;
        let before = if carried > 0.0 { KNOWN_VARIANCE } else { 0.0 };
        let variances = before * self.light[place].variance + samples * own.variance;
        Light {
            light: radiance,
            worth: carried + own.worth,
            variance: variances / (before + samples).max(1.0),
        }
        .on(&self.texels[place])
    }

    fn tile_index(&self, tile: Tile) -> usize {
        (tile.y / TILE * self.size.x.div_ceil(TILE) + tile.x / TILE) as usize
    }
}

/// The radiance that is carried over to a pixel, and the variance of the luminance of a sample there; None where there is none.
fn carried_at<'a>(
    size: UVec2,
    texels: &'a [Texel],
    light: &'a [Light],
) -> impl Fn(u32, u32) -> Option<(Rgb, f32)> + Sync + 'a {
    move |x, y| {
        let place = place_of(size, x, y);
        let Light { light, worth, variance } = light[place];
        (worth > 0.0).then(|| (light * divisor(&texels[place]), variance))
    }
}

/// Earlier light of this worth beside so many new samples: it goes when they are worth three times as much.
fn faded(worth: f32, samples: f32) -> f32 {
    if worth <= 0.0 {
        return 0.0;
    }
    worth * (1.5 - 0.5 * samples / worth).clamp(0.0, 1.0)
}

/// The groups of directions that surfaces face: both ways along each axis, and nowhere.
const DIRECTIONS: usize = 7;

fn direction_of(texel: &Texel) -> usize {
    let normal = texel.normal();
    if normal == Vec3::ZERO {
        return DIRECTIONS - 1;
    }
    let axis = normal.abs().max_position();
    2 * axis + usize::from(normal[axis] < 0.0)
}

/// Light is radiance divided by this.
fn divisor(texel: &Texel) -> Rgb {
    texel.albedo() + LEAST_ALBEDO
}

fn place_of(size: UVec2, x: u32, y: u32) -> usize {
    (y * size.x + x) as usize
}

fn pixels_of(tile: Tile) -> impl Iterator<Item = (u32, u32)> {
    let columns = tile.x..tile.x + tile.width;
    (tile.y..tile.y + tile.height).flat_map(move |y| columns.clone().map(move |x| (x, y)))
}

/// The middle of a pixel in film coordinates, (0, 0) at the top left and (1, 1) at the bottom right.
fn middle(size: UVec2, x: u32, y: u32) -> Vec2 {
    (Vec2::new(x as f32, y as f32) + 0.5) / size.as_vec2()
}
