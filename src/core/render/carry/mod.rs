//! Reuse of an earlier picture's light, which is shown in place of noise until the new picture has samples of its own.
//! It is for display only, and never a part of the film.
//!
//! Each pixel of the new picture is located in the earlier one by the surface point of its [G-buffer](super::gbuffer)
//! (`reproject.rs`; Nehab et al., Accelerating Real-Time Shading with Reverse Reprojection Caching, Graphics Hardware
//! 2007). The stored light is divided by the albedo, so that a surface may have another colour now. The new samples of
//! larger blocks correct it, and where they contradict it it is dropped (`trust.rs`). New and old light are then
//! blended by their worth in samples, and the old light vanishes once the new samples are worth far more.

mod coarse;
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
pub use self::reproject::Earlier;
pub use self::reproject::Reprojection;
pub use self::tile::CarriedTile;
use self::trust::{Standing, Trust, doubt_of_pixel, pooled};
use super::camera::Camera;
use super::film::{Film, Moments};
use super::gbuffer::Texel;
use super::tile::{TILE, Tile};
use crate::color::{Rgb, luminance};

/// The value added to albedos before light is divided by them.
const LEAST_ALBEDO: f32 = 0.02;
/// The worth of a sample of a denoised picture in samples, as `edit --measure-settling` has measured in rooms.
pub const WORTH_OF_DENOISED: f32 = 64.0;
/// The number of samples by which the variance of carried light counts as known.
const KNOWN_VARIANCE: f32 = 16.0;
/// The least relative standard deviation assumed for guided paths.
const DEVIATION_OF_GUIDED: f32 = 3.0;
/// Previews are not filtered if earlier light covers this share of the picture.
const NEARLY_ALL: f32 = 0.9995;
/// The factor over carried light to which new light is darkened, while it is worth less.
const OUTLIER: f32 = 3.0;
/// The largest share of the tiles that counts as few.
const FEW: f32 = 0.25;
/// The largest worth of earlier light in samples.
const MOST_WORTH: f32 = 512.0;

/// The light of a pixel, and its reliability.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Light {
    /// The radiance divided by the albedo.
    light: Rgb,
    /// The number of samples of a pixel with about the same error; 0 for a guess that is worse than any other light.
    worth: f32,
    /// The variance of the luminance of a single sample.
    variance: f32,
}

impl Light {
    /// The light, given as radiance, divided by the albedo of a surface, with its worth clamped.
    fn on(self, texel: &Texel) -> Self {
        Self {
            light: self.light / divisor(texel),
            worth: self.worth.min(MOST_WORTH),
            ..self
        }
    }
}

/// The data for blending pixels, beside the light of their tiles.
#[derive(Debug)]
pub struct Blender {
    size: UVec2,
    reprojection: Option<Arc<Reprojection>>,
    trust: Trust,
    /// The share of the worth of all carried light that is left.
    kept: f32,
}

/// The light of an earlier picture that is carried over to a new one.
#[derive(Debug)]
pub struct Carried {
    camera: Camera,
    blender: Blender,
    /// The tiles whose G-buffer has arrived, row by row.
    tiles: Vec<Option<CarriedTile>>,
    /// The number of tiles whose G-buffer is missing.
    missing: usize,
    /// The pixels that were found in the earlier picture.
    found: usize,
    /// Whether the [`Coarse`] picture was requested, or is not needed.
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

    /// Begins a picture of this size in pixels. Until a tile is [added](Self::add), the positions of its pixels in the
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

    /// The picture as painted, to be carried over to the next one. It is still the previous picture if this one has
    /// hardly begun, and None if it ended without a G-buffer.
    pub fn into_earlier(self) -> Option<Arc<Earlier>> {
        let before = self.earlier().filter(|_| self.blender.kept > 0.0);
        let tiles: Option<Vec<CarriedTile>> = self.tiles.into_iter().collect();
        let own = tiles.map(|tiles| Arc::new(Earlier::new(self.camera, self.blender.size, tiles)));
        own.or(before)
    }

    /// The previous picture.
    pub fn earlier(&self) -> Option<Arc<Earlier>> {
        Some(self.blender.reprojection.as_ref()?.earlier())
    }

    /// Expects guided paths: a few samples, and those that have taught a guide, do not show how rare bright ones are.
    pub fn expect_guided_paths(&mut self) {
        self.blender.trust.least_deviation = DEVIATION_OF_GUIDED;
    }

    /// The share of the picture for which there is earlier light, as far as known.
    pub fn coverage(&self) -> f32 {
        self.found as f32 / self.blender.size.element_product().max(1) as f32
    }

    /// Whether a film has the same size.
    pub fn is_of_size(&self, film: &Film) -> bool {
        self.blender.size == UVec2::new(film.width(), film.height())
    }

    /// Whether the picture has this size and camera, except for the focus.
    pub fn has_view(&self, camera: &Camera, size: UVec2) -> bool {
        self.blender.size == size && self.camera == camera.sharp()
    }

    /// The reprojection from the earlier picture; None if there is none.
    pub fn reprojection(&self) -> Option<&Arc<Reprojection>> {
        self.blender.reprojection.as_ref()
    }

    /// Sets the progress of the new picture: 0 at the beginning, 1 at its last sample. Carried light fades out in the
    /// second half, so that the finished picture has none.
    pub fn set_progress(&mut self, progress: f32) {
        self.blender.kept = (2.0 - 2.0 * progress).clamp(0.0, 1.0);
    }

    /// Replaces the guess for a tile, and returns the tile.
    pub fn add(&mut self, tile: CarriedTile) -> Tile {
        let place = tile.tile;
        self.found += tile.found();
        let index = self.blender.tile_index(place);
        self.missing -= usize::from(self.tiles[index].replace(tile).is_none());
        place
    }

    /// Compares tiles with the film's current samples. Tiles that have only a preview take in its light.
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

    /// Compares all carried light with a denoised picture of the film.
    pub fn learn_clean(&mut self, film: &Film, clean: Clean) {
        let old = carried_at(self.blender.size, &self.tiles);
        self.blender.trust.learn_clean(film, clean, old);
    }

    /// The tiles that mostly show unreliable light, if they are few. None until the G-buffer is complete.
    pub fn hardly_known(&self) -> HashSet<Tile> {
        if self.missing > 0 {
            return HashSet::new();
        }
        let all = self.tiles.iter().flatten().filter(|own| own.is_hardly_known);
        let tiles: HashSet<Tile> = all.map(|own| own.tile).collect();
        let are_few = (tiles.len() as f32) <= FEW * self.tiles.len() as f32;
        if are_few { tiles } else { HashSet::new() }
    }

    /// The blending data, and the rows of tiles. Tiles that have not arrived are None.
    pub fn rows(&mut self) -> (&Blender, std::slice::ChunksMut<'_, Option<CarriedTile>>) {
        let columns = self.blender.size.x.div_ceil(TILE) as usize;
        (&self.blender, self.tiles.chunks_mut(columns))
    }

    /// Takes in the light of a [`Coarse`] picture of the same film, where no better light is carried over.
    pub fn add_coarse(&mut self, light: &[Rgb]) {
        let size = self.blender.size;
        self.tiles
            .par_iter_mut()
            .flatten()
            .for_each(|tile| tile.add_coarse(size, light));
    }

    /// The coarse picture from the previews of all tiles, once they and the G-buffer are complete and before all pixels
    /// have samples; None otherwise.
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

    /// Blends a row of pixels of a tile with carried light, and stores the displayed light in `own`. `row` is the
    /// film's, or a denoised picture's with its number of samples. Returns whether any carried light is left in the
    /// row.
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
            // Previews are taken in tile by tile.
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
                    // Few samples do not show how rare bright ones are.
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

    /// The radiance of a pixel and the worth of the carried light in it. `old` is the carried light with its `worth` in
    /// samples, `new` is the film's, with its worth. None if neither is known.
    fn blend(&self, old: Rgb, worth: f32, standing: &Standing, new: Option<(Rgb, f32)>) -> Option<(Rgb, f32)> {
        let Some((new, samples)) = new else {
            return (old != Rgb::ZERO || worth > 0.0).then_some((old, worth.max(f32::MIN_POSITIVE)));
        };
        let worth = faded(standing.worth(worth) * self.kept, samples);
        if worth <= 0.0 {
            return Some((new, 0.0));
        }
        // A few bright samples would stand out against noise-free light.
        let most = OUTLIER * (1.0 + samples / worth) * luminance(old).max(f32::MIN_POSITIVE);
        let own = luminance(new);
        let new = if own > most { new * (most / own) } else { new };
        Some(((old * worth + new * samples) / (worth + samples), worth))
    }
}

/// The carried radiance of a pixel of these tiles, and the variance of a sample's luminance there; None where no light
/// is carried over.
fn carried_at(size: UVec2, tiles: &[Option<CarriedTile>]) -> impl Fn(u32, u32) -> Option<(Rgb, f32)> + Sync {
    move |x, y| {
        let (tile, place) = tile_and_place(size, UVec2::new(x, y));
        tiles[tile].as_ref()?.carried(place)
    }
}

/// The worth of earlier light beside new samples: it reaches 0 when they are worth three times as much.
fn faded(worth: f32, samples: f32) -> f32 {
    if worth <= 0.0 {
        return 0.0;
    }
    worth * (1.5 - 0.5 * samples / worth).clamp(0.0, 1.0)
}

/// The divisor that turns radiance into light.
fn divisor(texel: &Texel) -> Rgb {
    texel.albedo() + LEAST_ALBEDO
}

fn place_of(size: UVec2, x: u32, y: u32) -> usize {
    (y * size.x + x) as usize
}

/// The index of a pixel's tile in a picture of this size, and the index of the pixel in the tile.
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

/// The centre of a pixel in film coordinates, (0, 0) at the top left and (1, 1) at the bottom right.
fn middle(size: UVec2, x: u32, y: u32) -> Vec2 {
    (Vec2::new(x as f32, y as f32) + 0.5) / size.as_vec2()
}
