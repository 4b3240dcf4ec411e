//! What an earlier picture still tells about a new one: light that is shown in place of noise until the new picture has
//! samples of its own. It is only ever shown, and never a part of the film.
//!
//! Each pixel of the new picture is found in the earlier one by the place that its [G-buffer](super::gbuffer) tells
//! (`reproject.rs`; Nehab et al., Accelerating Real-Time Shading with Reverse Reprojection Caching, Graphics Hardware
//! 2007). What is kept there is the light divided by the albedo, so that a surface may have another colour now. What
//! the new samples tell of larger blocks corrects it, and where they contradict it is given up (`trust.rs`). New and
//! old light are then blended by what both are worth in samples, and the old light goes altogether once the new samples
//! are worth far more.

mod coarse;
mod earlier;
mod reproject;
#[cfg(test)]
mod tests;
mod tile;
mod trust;

use std::collections::HashSet;
use std::sync::Arc;

use glam::{UVec2, Vec2};
use rayon::prelude::*;

pub use self::coarse::Coarse;
pub use self::earlier::Earlier;
pub use self::reproject::Reprojection;
pub use self::tile::CarriedTile;
use self::trust::{Standing, Trust, doubt_of_pixel, pooled};
use super::camera::Camera;
use super::film::{Film, Moments};
use super::gbuffer::Texel;
use super::tile::{TILE, Tile};
use crate::color::{Rgb, luminance};

/// Is added to albedos before light is divided by them.
const LEAST_ALBEDO: f32 = 0.02;
/// The samples that one sample of a denoised picture is worth, by what `edit --measure-settling` has measured in rooms.
pub const WORTH_OF_DENOISED: f32 = 64.0;
/// The samples that the variance of a sample is known from, where light is carried over.
const KNOWN_VARIANCE: f32 = 16.0;
/// The least relative standard deviation that is believed of guided paths.
const DEVIATION_OF_GUIDED: f32 = 3.0;
/// Where earlier light covers so much of the picture, previews are not filtered.
const NEARLY_ALL: f32 = 0.9995;
/// New light that is brighter than carried light by more than this factor is shown darker, as long as it is worth less.
const OUTLIER: f32 = 3.0;
/// The share of the tiles that are few.
const FEW: f32 = 0.25;
/// The most samples that earlier light is worth.
const MOST_WORTH: f32 = 512.0;

/// Light of a pixel, and how far it can be relied on.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Light {
    /// The radiance divided by the albedo.
    light: Rgb,
    /// The number of samples of a pixel that have about the same error; 0 for a guess that anything else is better
    /// than.
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

/// What pixels are blended with, beside the light of their tiles.
#[derive(Debug)]
pub struct Blender {
    size: UVec2,
    reprojection: Option<Arc<Reprojection>>,
    trust: Trust,
    /// The share of its worth that all light keeps.
    kept: f32,
}

/// The light of an earlier picture that is carried over to a new one.
#[derive(Debug)]
pub struct Carried {
    camera: Camera,
    blender: Blender,
    /// The tiles whose G-buffer is there, row by row.
    tiles: Vec<Option<CarriedTile>>,
    /// The number of those for which it is not.
    missing: usize,
    /// The pixels that were found in the earlier picture.
    found: usize,
    /// Whether the [`Coarse`] picture was asked for, or is not needed.
    has_coarse: bool,
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
    /// The memory for a pixel in bytes.
    pub const BYTES_OF_PIXEL: u64 = (size_of::<Texel>() + 2 * size_of::<Light>()) as u64;

    /// Begins a picture of this size in pixels. Until a tile is [added](Self::add), the places of its pixels in the
    /// earlier picture are guessed.
    pub fn begin(earlier: Option<Arc<Earlier>>, camera: &Camera, size: UVec2) -> Self {
        let camera = camera.sharp();
        let tiles = size.x.div_ceil(TILE) * size.y.div_ceil(TILE);
        Self {
            camera,
            blender: Blender {
                size,
                reprojection: earlier.map(|earlier| Arc::new(Reprojection::new(earlier, camera, size))),
                trust: Trust::new(size),
                kept: 1.0,
            },
            tiles: (0..tiles).map(|_| None).collect(),
            missing: tiles as usize,
            found: 0,
            has_coarse: false,
        }
    }

    /// The picture as it was painted, to be carried over to the next one. It is still the one before while this one has
    /// hardly begun, and none if it ended without a G-buffer.
    pub fn into_earlier(self) -> Option<Arc<Earlier>> {
        let before = self.earlier().filter(|_| self.blender.kept > 0.0);
        let tiles: Option<Vec<CarriedTile>> = self.tiles.into_iter().collect();
        let own = tiles.map(|tiles| Arc::new(Earlier::new(self.camera, self.blender.size, tiles)));
        own.or(before)
    }

    /// The picture before this one.
    pub fn earlier(&self) -> Option<Arc<Earlier>> {
        Some(self.blender.reprojection.as_ref()?.earlier())
    }

    /// Says that paths are guided: few samples, and those that have taught a guide, do not tell how rare bright ones
    /// are.
    pub fn expect_guided_paths(&mut self) {
        self.blender.trust.least_deviation = DEVIATION_OF_GUIDED;
    }

    /// The share of the picture for which there is light of an earlier one, as far as that is known.
    pub fn coverage(&self) -> f32 {
        self.found as f32 / self.blender.size.element_product().max(1) as f32
    }

    /// Whether a film has as many pixels.
    pub fn is_of_size(&self, film: &Film) -> bool {
        self.blender.size == UVec2::new(film.width(), film.height())
    }

    /// Whether it is a picture of this size by this camera, but for what is in focus.
    pub fn has_view(&self, camera: &Camera, size: UVec2) -> bool {
        self.blender.size == size && self.camera == camera.sharp()
    }

    /// The way from the earlier picture; None if there is none.
    pub fn reprojection(&self) -> Option<&Arc<Reprojection>> {
        self.blender.reprojection.as_ref()
    }

    /// Says how much of the new picture is made: 0 at the beginning, 1 at its last sample. What is carried over goes in
    /// the second half, so that the finished picture has nothing of it.
    pub fn set_progress(&mut self, progress: f32) {
        self.blender.kept = (2.0 - 2.0 * progress).clamp(0.0, 1.0);
    }

    /// Replaces the guess for a tile. Returns which one it was.
    pub fn add(&mut self, tile: CarriedTile) -> Tile {
        let place = tile.tile;
        self.found += tile.found();
        let index = self.blender.tile_index(place);
        self.missing -= usize::from(self.tiles[index].replace(tile).is_none());
        place
    }

    /// Compares tiles with the samples that the film has there now. Tiles that have only a preview take up what that
    /// tells.
    pub fn learn(&mut self, tiles: &[Tile], film: &Film) {
        for &tile in tiles {
            if let Some(own) = &mut self.tiles[self.blender.tile_index(tile)]
                && film.samples(tile.x, tile.y) == 0
            {
                own.take_preview(film);
            }
        }
        if self.found > 0 || self.has_coarse {
            let own = tiles
                .iter()
                .filter_map(|&tile| self.tiles[self.blender.tile_index(tile)].as_ref());
            let is_sampled = |own: &&CarriedTile| !own.is_own && film.samples(own.tile.x, own.tile.y) > 0;
            let sampled: Vec<&CarriedTile> = own.filter(is_sampled).collect();
            self.blender.trust.learn(&sampled, film);
        }
    }

    /// Compares all that is carried over with a denoised picture of the film.
    pub fn learn_clean(&mut self, film: &Film, clean: Clean) {
        let old = carried_at(self.blender.size, &self.tiles);
        self.blender.trust.learn_clean(film, clean, old);
    }

    /// The tiles of which much is shown that is hardly known, if they are few. None until the G-buffer is there.
    pub fn hardly_known(&self) -> HashSet<Tile> {
        if self.missing > 0 {
            return HashSet::new();
        }
        let all = self.tiles.iter().flatten().filter(|own| own.is_hardly_known);
        let tiles: HashSet<Tile> = all.map(|own| own.tile).collect();
        let are_few = (tiles.len() as f32) <= FEW * self.tiles.len() as f32;
        if are_few { tiles } else { HashSet::new() }
    }

    /// What tiles are painted with, and the rows of tiles. Tiles that are not there yet are None.
    pub fn rows(&mut self) -> (&Blender, std::slice::ChunksMut<'_, Option<CarriedTile>>) {
        let columns = self.blender.size.x.div_ceil(TILE) as usize;
        (&self.blender, self.tiles.chunks_mut(columns))
    }

    /// Takes up what a [`Coarse`] picture of the same film tells, where nothing better is carried over.
    pub fn add_coarse(&mut self, light: &[Rgb]) {
        let size = self.blender.size;
        self.tiles
            .par_iter_mut()
            .flatten()
            .for_each(|tile| tile.add_coarse(size, light));
    }

    /// The coarse picture that previews of all tiles make, once they and the G-buffer are there and before there are
    /// samples everywhere; None before and afterwards.
    pub fn coarse(&mut self, film: &Film) -> Option<Coarse> {
        if self.has_coarse || self.missing > 0 {
            return None;
        }
        self.has_coarse = self.coverage() >= NEARLY_ALL;
        let texels = |x, y| {
            let (tile, place) = tile_and_place(self.blender.size, UVec2::new(x, y));
            self.tiles[tile].as_ref().map(|tile| tile.texels[place])
        };
        let coarse = (!self.has_coarse).then(|| Coarse::of(film, texels)).flatten();
        self.has_coarse |= coarse.is_some();
        coarse
    }
}

impl Blender {
    fn tile_index(&self, tile: Tile) -> usize {
        tile_and_place(self.size, UVec2::new(tile.x, tile.y)).0
    }

    /// Blends a row of pixels of a tile with what is carried over, and notes in `own` what is shown then. `row` is what
    /// the film has, or the denoised picture of so many samples. Returns whether anything of the row is still
    /// carried over.
    pub fn blend_row(
        &self,
        mut own: Option<&mut CarriedTile>,
        film: &Film,
        (tile, y): (Tile, u32),
        denoised: Option<u32>,
        row: &mut [Option<Rgb>],
    ) -> bool {
        let mut is_carried = false;
        let standings = self.trust.row(tile, y);
        let mut moments = [Moments::default(); TILE as usize];
        film.moments_row(tile, y, &mut moments);
        let places = ((y - tile.y) * tile.width) as usize..;
        for (((x, place), pixel), moments) in (tile.x..).zip(places).zip(row).zip(&moments) {
            let (texel, old) = match (&own, &self.reprojection) {
                (Some(own), _) => (own.texels[place], own.light[place]),
                (None, Some(reprojection)) => reprojection.guess(x, y),
                (None, None) => continue,
            };
            let samples = moments.samples as f32;
            let worth = denoised.map_or(samples, |samples| WORTH_OF_DENOISED * samples as f32);
            // Previews are taken up tile by tile.
            let new = pixel.filter(|_| worth > 0.0).map(|radiance| (radiance, worth));
            let is_over = self.kept <= 0.0 || own.as_ref().is_some_and(|own| own.is_own);
            let old = if is_over { Light::default() } else { old };
            let mut standing = standings.at(x);
            let radiance = old.light * divisor(&texel) * standing.correction;
            standing.doubt = standing.doubt.max(doubt_of_pixel(moments, radiance, old.variance));
            let blended = self.blend(radiance, old.worth, &standing, new);
            if let Some((mixed, carried)) = blended {
                (*pixel, is_carried) = (Some(mixed), is_carried || carried > 0.0);
            }
            if let Some(own) = &mut own {
                let (light, carried) = blended.unwrap_or_default();
                let shown = Light {
                    light,
                    worth: carried + new.map_or(0.0, |(_, worth)| worth),
                    // Few samples do not tell how rare bright ones are.
                    variance: match carried > 0.0 {
                        true => pooled(old.variance, moments.variance, samples),
                        false => moments.variance,
                    },
                };
                own.shown[place] = shown.on(&texel);
            }
        }
        is_carried
    }

    /// The radiance of a pixel and the worth of what is carried over in it. `old` is carried over and worth so many
    /// samples, `new` is what the film tells, with its worth. None if nothing is known.
    fn blend(&self, old: Rgb, worth: f32, standing: &Standing, new: Option<(Rgb, f32)>) -> Option<(Rgb, f32)> {
        let Some((new, samples)) = new else {
            return (old != Rgb::ZERO || worth > 0.0).then_some((old, worth.max(f32::MIN_POSITIVE)));
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
}

/// The radiance that is carried over to a pixel of these tiles, and the variance of the luminance of a sample there;
/// None where there is none.
fn carried_at(size: UVec2, tiles: &[Option<CarriedTile>]) -> impl Fn(u32, u32) -> Option<(Rgb, f32)> + Sync {
    move |x, y| {
        let (tile, place) = tile_and_place(size, UVec2::new(x, y));
        tiles[tile].as_ref()?.carried(place)
    }
}

/// Earlier light of this worth beside so many new samples: it goes when they are worth three times as much.
fn faded(worth: f32, samples: f32) -> f32 {
    if worth <= 0.0 {
        return 0.0;
    }
    worth * (1.5 - 0.5 * samples / worth).clamp(0.0, 1.0)
}

/// Light is radiance divided by this.
fn divisor(texel: &Texel) -> Rgb {
    texel.albedo() + LEAST_ALBEDO
}

fn place_of(size: UVec2, x: u32, y: u32) -> usize {
    (y * size.x + x) as usize
}

/// The index of the tile of a pixel in a picture of this size, and the place of the pixel in the tile.
fn tile_and_place(size: UVec2, pixel: UVec2) -> (usize, usize) {
    let (tile, within) = (pixel / TILE, pixel % TILE);
    let width = TILE.min(size.x - tile.x * TILE);
    (
        place_of(UVec2::splat(size.x.div_ceil(TILE)), tile.x, tile.y),
        place_of(UVec2::splat(width), within.x, within.y),
    )
}

fn pixels_of(tile: Tile) -> impl Iterator<Item = (u32, u32)> {
    let columns = tile.x..tile.x + tile.width;
    (tile.y..tile.y + tile.height).flat_map(move |y| columns.clone().map(move |x| (x, y)))
}

/// The middle of a pixel in film coordinates, (0, 0) at the top left and (1, 1) at the bottom right.
fn middle(size: UVec2, x: u32, y: u32) -> Vec2 {
    (Vec2::new(x as f32, y as f32) + 0.5) / size.as_vec2()
}
