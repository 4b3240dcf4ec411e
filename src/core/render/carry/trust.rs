//! Comparison of earlier light with new samples: the factors by which it has changed, and where it is unreliable.
//!
//! The means over blocks of four sizes are compared: of the whole picture, of tiles, and of parts of tiles. A
//! difference counts as far as it exceeds the expected noise (Efron and Morris, Stein's Estimation Rule and its
//! Competitors, Journal of the American Statistical Association 68, 1973). Corrections by larger blocks are applied
//! before smaller ones are compared, so that a dimmed lamp changes the whole picture soon, and a moved shadow its
//! surroundings.

use std::ops::Range;

use glam::UVec2;
use rayon::prelude::*;

use super::{CarriedTile, Clean, KNOWN_VARIANCE, WORTH_OF_DENOISED, pixels_of};
use crate::color::{Rgb, luminance};
use crate::render::film::{Film, Moments};
use crate::render::tile::{TILE, Tile};

/// The edge of the smallest blocks in pixels.
const BLOCK: u32 = 8;
/// From this number of tiles on, several threads compare them.
const MANY: usize = 64;
/// The blocks along the edge of a tile.
const BLOCKS: usize = (TILE / BLOCK) as usize;
/// Squared differences count as far as they exceed this multiple of the expected noise.
const SIGNIFICANT: f32 = 9.0;
/// The least variance assumed for a sample.
const LEAST_VARIANCE: f32 = 1e-9;
/// The relative standard deviation of a denoised picture of one sample is at most this, as `edit --measure-settling`
/// has measured it in rooms.
const DEVIATION_OF_DENOISED: f32 = 0.1;
/// The median of the square of a number that is normally distributed around 0 with variance 1.
const MEDIAN_OF_SQUARES: f32 = 0.455;
/// Blocks darker than this are compared as if they had this luminance.
const DARKEST: f32 = 1e-6;
/// The samples per pixel of a block that determine its variance as well as one sample of a pixel does its own.
const SAMPLES_IN_ONE: f32 = 8.0;
/// The fewest samples by which a single pixel is judged.
const LEAST_SAMPLES: u32 = 4;
/// The largest factor by which light is corrected.
const MOST_CORRECTION: f32 = 16.0;
/// The remaining trust in a block that has certainly changed, by the size of the block: the picture, tiles, and halves
/// and quarters of their edge.
const LEFT: [f32; 4] = [1.0, 0.7, 0.3, 0.02];

/// Sums over the pixels of a block that have both lights.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    pixels: f32,
    new: Rgb,
    old: Rgb,
    /// The variances of the new pixels' luminances, estimated from their own samples.
    own_variances: f32,
    /// The variances of the new pixels' luminances, as expected from the earlier picture.
    variances: f32,
    samples: f32,
}

impl Sums {
    fn add(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.new += other.new;
        self.old += other.old;
        self.own_variances += other.own_variances;
        self.variances += other.variances;
        self.samples += other.samples;
    }

    /// The factors on the earlier light and the share of the trust in it, refined by this block.
    fn refine(&self, before: (Rgb, f32), left: f32, least_deviation: f32) -> (Rgb, f32) {
        if self.pixels < 1.0 {
            return before;
        }
        let (ratio, trust) = before;
        let scale = 1.0 / self.pixels;
        let (new, old) = (self.new * scale, self.old * scale * ratio);
        let difference = luminance(new - old);
        let [own, expected] = [self.own_variances, self.variances].map(|variances| variances * scale * scale);
        let brightness = luminance(old).max(luminance(new));
        let least = (least_deviation * brightness).powi(2) / self.samples;
        // All pixels of the block share one variance, but rare bright samples are not in all of them.
        let noise = pooled(expected, own, self.samples / SAMPLES_IN_ONE).max(least);
        let share = 1.0 - SIGNIFICANT * noise / (difference * difference).max(f32::MIN_POSITIVE);
        if share.is_nan() || share <= 0.0 {
            return before;
        }
        let wanted = (new / old.max(Rgb::splat(1e-12))).max(Rgb::ZERO);
        let possible = wanted.min(Rgb::splat(MOST_CORRECTION));
        let left = if possible == wanted { left } else { 0.0 };
        let refined = ratio * (1.0 + share * (possible - 1.0));
        (refined, trust * (1.0 - share * (1.0 - left)))
    }
}

/// A variance combined from the earlier picture's and that of new samples of a pixel.
pub(super) fn pooled(before: f32, own: f32, samples: f32) -> f32 {
    (KNOWN_VARIANCE * before + samples * own) / (KNOWN_VARIANCE + samples)
}

/// The reliability of the earlier light of a block.
#[derive(Clone, Copy, Debug)]
pub(super) struct Standing {
    /// The factors on the light.
    pub correction: Rgb,
    /// The share of its worth that the light keeps.
    pub share: f32,
    /// One over the worth of light that is as wrong as this light may be.
    pub doubt: f32,
}

impl Standing {
    fn lerp(&self, other: &Self, share: f32) -> Self {
        let between = |a: f32, b: f32| a + (b - a) * share;
        Self {
            correction: self.correction.lerp(other.correction, share),
            share: between(self.share, other.share),
            doubt: between(self.doubt, other.doubt),
        }
    }

    /// The remaining worth of light that was worth `before` samples.
    pub fn worth(&self, before: f32) -> f32 {
        let kept = before * self.share;
        kept / (1.0 + kept * self.doubt)
    }
}

/// The doubt, as [`Standing::doubt`], in a pixel's earlier radiance from its own samples alone. `variance` is that of a
/// sample's luminance by the earlier picture. At visible lamps, and in mirrors, single pixels change without their
/// blocks.
pub(super) fn doubt_of_pixel(new: &Moments, old: Rgb, variance: f32) -> f32 {
    if new.samples < LEAST_SAMPLES {
        return 0.0;
    }
    let difference = luminance(new.radiance - old);
    let samples = new.samples as f32;
    let variance = pooled(variance, new.variance, samples);
    let beyond_noise = difference * difference - SIGNIFICANT * variance / samples;
    beyond_noise.max(0.0) / variance.max(LEAST_VARIANCE)
}

/// The reliability of earlier light, block by block.
#[derive(Debug)]
pub(super) struct Trust {
    /// The blocks in a row of the picture, and the rows.
    size: UVec2,
    blocks: Vec<Standing>,
    tiles_in_row: u32,
    tiles: Vec<Sums>,
    /// The least relative standard deviation assumed for a sample.
    pub least_deviation: f32,
}

impl Trust {
    pub fn new(picture: UVec2) -> Self {
        let count = |edge: u32| UVec2::new(picture.x.div_ceil(edge), picture.y.div_ceil(edge));
        let (size, tiles) = (count(BLOCK), count(TILE));
        Self {
            size,
            blocks: vec![
                Standing {
                    correction: Rgb::ONE,
                    share: 1.0,
                    doubt: 0.0,
                };
                size.element_product() as usize
            ],
            tiles_in_row: tiles.x,
            tiles: vec![Sums::default(); tiles.element_product() as usize],
            least_deviation: 1.0,
        }
    }

    /// Compares tiles with the film's samples.
    pub fn learn(&mut self, tiles: &[&CarriedTile], film: &Film) {
        if tiles.is_empty() {
            return;
        }
        let sums = |own: &&CarriedTile| sums_of(own, film);
        let all: Vec<TileSums> = match tiles.len() {
            // Waiting for other threads would take longer.
            0..MANY => tiles.iter().map(sums).collect(),
            _ => tiles.par_iter().map(sums).collect(),
        };
        for (own, sums) in tiles.iter().zip(&all) {
            let index = own.tile.y / TILE * self.tiles_in_row + own.tile.x / TILE;
            self.tiles[index as usize] = part_of(sums, 0..BLOCKS, 0..BLOCKS);
        }
        let mut picture = Sums::default();
        self.tiles.iter().for_each(|tile| picture.add(tile));
        let of_picture = picture.refine((Rgb::ONE, 1.0), LEFT[0], self.least_deviation);
        for (own, sums) in tiles.iter().zip(&all) {
            self.refine_tile(own.tile, sums, of_picture);
        }
    }

    fn refine_tile(&mut self, tile: Tile, sums: &TileSums, of_picture: (Rgb, f32)) {
        let of_tile = part_of(sums, 0..BLOCKS, 0..BLOCKS).refine(of_picture, LEFT[1], self.least_deviation);
        let (half, least) = (BLOCKS / 2, self.least_deviation);
        for (row, blocks) in sums.iter().enumerate() {
            for (column, block) in blocks.iter().enumerate() {
                let (top, left) = (row / half * half, column / half * half);
                let of_part =
                    part_of(sums, top..top + half, left..left + half).refine(of_tile, LEFT[2], self.least_deviation);
                let (x, y) = (tile.x / BLOCK + column as u32, tile.y / BLOCK + row as u32);
                if x < self.size.x && y < self.size.y {
                    let standing = &mut self.blocks[(y * self.size.x + x) as usize];
                    (standing.correction, standing.share) = block.refine(of_part, LEFT[3], least);
                }
            }
        }
    }

    /// Compares all blocks with a denoised picture of these pixels of the film: light that differs by more than its
    /// noise is worth no more than that many samples. Most blocks are usually unchanged, so that the median of the
    /// differences estimates their noise.
    pub fn learn_clean(&mut self, film: &Film, clean: Clean, old: impl Fn(u32, u32) -> Option<(Rgb, f32)> + Sync) {
        let samples = clean.samples.max(1) as f32;
        let worth = WORTH_OF_DENOISED * samples;
        let (columns, blocks) = (self.size.x, self.blocks.par_iter().enumerate());
        let compare = |(index, standing): (usize, &Standing)| {
            let (left, top) = (index as u32 % columns * BLOCK, index as u32 / columns * BLOCK);
            let block = Tile {
                x: left,
                y: top,
                width: BLOCK.min(film.width() - left),
                height: BLOCK.min(film.height() - top),
            };
            compare_clean(block, standing.correction, film, clean, &old)
        };
        let compared: Vec<Option<[f32; 3]>> = blocks.map(compare).collect();
        let known = compared.iter().flatten();
        let relative = known.map(|[difference, _, brightness]| (difference / brightness.max(DARKEST)).powi(2));
        let mut relative: Vec<f32> = relative.collect();
        if relative.is_empty() {
            return;
        }
        let middle = relative.len() / 2;
        let (_, median, _) = relative.select_nth_unstable_by(middle, f32::total_cmp);
        let usual = (*median / MEDIAN_OF_SQUARES).min(DEVIATION_OF_DENOISED.powi(2) / samples);
        for (standing, compared) in self.blocks.iter_mut().zip(compared) {
            if let Some([difference, variance, brightness]) = compared {
                // Two standard deviations.
                let noise = (4.0 * usual * brightness * brightness).min(variance / worth);
                let beyond_noise = (difference * difference - noise).max(0.0);
                standing.doubt = beyond_noise / (noise * worth).max(LEAST_VARIANCE);
            }
        }
    }

    /// The reliability for the pixels of a row of a tile.
    pub fn row(&self, tile: Tile, y: u32) -> TrustRow {
        let last = self.size - 1;
        let place = ((y as f32 + 0.5) / BLOCK as f32 - 0.5).clamp(0.0, last.y as f32);
        let (upper, share) = (place as u32, place.fract());
        let lower = (upper + 1).min(last.y);
        // The block to the left of the tile.
        let first = (tile.x / BLOCK) as i32 - 1;
        let between = |column: usize| {
            let x = (first + column as i32).clamp(0, last.x as i32) as u32;
            let block = |y: u32| &self.blocks[(y * self.size.x + x) as usize];
            block(upper).lerp(block(lower), share)
        };
        TrustRow {
            first,
            blocks: std::array::from_fn(between),
        }
    }
}

/// The reliability along a row of pixels: of the blocks of a tile and of one on either side.
pub(super) struct TrustRow {
    first: i32,
    blocks: [Standing; BLOCKS + 2],
}

impl TrustRow {
    /// The reliability at a pixel of the row, interpolated between the centres of its blocks.
    pub fn at(&self, x: u32) -> Standing {
        let place = (x as f32 + 0.5) / BLOCK as f32 - 0.5 - self.first as f32;
        let left = place as usize;
        self.blocks[left].lerp(&self.blocks[left + 1], place.fract())
    }
}

/// The means over a block of the luminance difference between a denoised picture and earlier light, of the variance of
/// a sample, and of the luminance of the denoised picture. None without earlier light.
fn compare_clean(
    block: Tile,
    correction: Rgb,
    film: &Film,
    clean: Clean,
    old: impl Fn(u32, u32) -> Option<(Rgb, f32)>,
) -> Option<[f32; 3]> {
    let (mut pixels, mut difference, mut variance, mut brightness) = (0.0, 0.0, 0.0, 0.0);
    for (x, y) in pixels_of(block) {
        let (Some((old, expected)), Some(own)) = (old(x, y), film.pixel(x, y)) else {
            continue;
        };
        let new = clean.radiance[(y * film.width() + x) as usize];
        pixels += 1.0;
        difference += luminance(new - old * correction);
        let spread = (own.luminance_squared - luminance(new).powi(2)).max(0.0);
        variance += spread.max(expected);
        brightness += luminance(new);
    }
    (pixels > 0.0).then(|| [difference, variance, brightness].map(|sum| sum / pixels))
}

/// The sums of the blocks of a tile.
type TileSums = [[Sums; BLOCKS]; BLOCKS];

fn sums_of(own: &CarriedTile, film: &Film) -> TileSums {
    let mut sums = [[Sums::default(); BLOCKS]; BLOCKS];
    let tile = own.tile;
    for (row, y) in (tile.y..tile.y + tile.height).enumerate() {
        let mut moments = [Moments::default(); TILE as usize];
        film.moments_row(tile, y, &mut moments);
        for (column, new) in moments[..tile.width as usize].iter().enumerate() {
            let Some((old, variance)) = own.carried(row * tile.width as usize + column) else {
                continue;
            };
            if new.samples > 0 {
                let samples = new.samples as f32;
                sums[row / BLOCK as usize][column / BLOCK as usize].add(&Sums {
                    pixels: 1.0,
                    new: new.radiance,
                    old,
                    own_variances: new.variance / samples,
                    variances: variance / samples,
                    samples,
                });
            }
        }
    }
    sums
}

/// The sum of a range of rows and columns of blocks.
fn part_of(sums: &TileSums, rows: Range<usize>, columns: Range<usize>) -> Sums {
    let mut whole = Sums::default();
    for row in &sums[rows] {
        row[columns.clone()].iter().for_each(|block| whole.add(block));
    }
    whole
}
