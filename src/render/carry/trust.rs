//! What new samples tell of earlier light: by which factors it has changed, and where it is nothing to rely on.
//!
//! The means over blocks of four sizes are compared: of the whole picture, of tiles, and of parts of tiles. A difference counts as far as it exceeds what noise
//! would bring about (Efron and Morris, Stein's Estimation Rule and its Competitors, Journal of the American Statistical Association 68, 1973). What the larger blocks tell
//! is taken into account before the smaller ones are asked, so that a lamp that was dimmed changes everything soon, and a shadow that moved changes
//! its surroundings.

use std::ops::Range;

use glam::{UVec2, Vec2};
use rayon::prelude::*;

use super::pixels_of;
use crate::color::{Rgb, luminance};
use crate::render::film::Film;
use crate::render::tile::{TILE, Tile};

/// The edge of the smallest blocks in pixels.
const BLOCK: u32 = 8;
/// The blocks along the edge of a tile.
const BLOCKS: usize = (TILE / BLOCK) as usize;
/// Squared differences count as far as they exceed this many times what noise brings about.
const SIGNIFICANT: f32 = 9.0;
/// The least relative standard deviation of a sample that is believed.
const LEAST_DEVIATION: f32 = 0.4;
/// The largest factor by which light is corrected.
const MOST_CORRECTION: f32 = 16.0;
/// What is left of the trust in a block that has certainly changed, by the size of the block: the picture, tiles, and halves and quarters of their edge.
const LEFT: [f32; 4] = [1.0, 0.7, 0.3, 0.02];

/// Sums over the pixels of a block that have both lights.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    pixels: f32,
    new: Rgb,
    old: Rgb,
    /// The squared differences of luminance.
    squares: f32,
    /// The variances of the new pixels' luminances that are expected of the earlier picture.
    variances: f32,
    samples: f32,
}

impl Sums {
    fn add(&mut self, other: &Self) {
        self.pixels += other.pixels;
        self.new += other.new;
        self.old += other.old;
        self.squares += other.squares;
        self.variances += other.variances;
        self.samples += other.samples;
    }

    /// The factors on the earlier light and the share of the trust in it, after this block is taken into account as well.
    fn refine(&self, before: (Rgb, f32), left: f32) -> (Rgb, f32) {
        if self.pixels < 1.0 {
            return before;
        }
        let (ratio, trust) = before;
        let scale = 1.0 / self.pixels;
        let (new, old) = (self.new * scale, self.old * scale * ratio);
        let difference = luminance(new - old);
        let plain_difference = luminance(self.new - self.old) * scale;
        let spread = (self.squares * scale - plain_difference * plain_difference).max(0.0) * scale;
        let expected = self.variances * scale * scale;
        let brightness = luminance(old).max(luminance(new));
        let least = (LEAST_DEVIATION * brightness).powi(2) / self.samples;
        let noise = spread.max(expected).max(least);
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

/// The factors on earlier light, and the share of its worth that it keeps.
#[derive(Debug)]
pub(super) struct Trust {
    /// The blocks in a row of the picture, and the rows.
    size: UVec2,
    blocks: Vec<(Rgb, f32)>,
    tiles_in_row: u32,
    tiles: Vec<Sums>,
}

impl Trust {
    pub fn new(picture: UVec2) -> Self {
        let count = |edge: u32| UVec2::new(picture.x.div_ceil(edge), picture.y.div_ceil(edge));
        let (size, tiles) = (count(BLOCK), count(TILE));
        Self {
            size,
            blocks: vec![(Rgb::ONE, 1.0); size.element_product() as usize],
            tiles_in_row: tiles.x,
            tiles: vec![Sums::default(); tiles.element_product() as usize],
        }
    }

    /// Compares tiles of the film with earlier light: `old` gives the radiance of a pixel and the variance of one sample's luminance, where there is any.
    pub fn learn(&mut self, tiles: &[Tile], film: &Film, old: impl Fn(u32, u32) -> Option<(Rgb, f32)> + Sync) {
        let all: Vec<TileSums> = tiles.par_iter().map(|&tile| sums_of(tile, film, &old)).collect();
        for (tile, sums) in tiles.iter().zip(&all) {
            let index = tile.y / TILE * self.tiles_in_row + tile.x / TILE;
            self.tiles[index as usize] = part_of(sums, 0..BLOCKS, 0..BLOCKS);
        }
        let mut picture = Sums::default();
        self.tiles.iter().for_each(|tile| picture.add(tile));
        let of_picture = picture.refine((Rgb::ONE, 1.0), LEFT[0]);
        for (tile, sums) in tiles.iter().zip(&all) {
            self.refine_tile(*tile, sums, of_picture);
        }
    }

    fn refine_tile(&mut self, tile: Tile, sums: &TileSums, of_picture: (Rgb, f32)) {
        let of_tile = part_of(sums, 0..BLOCKS, 0..BLOCKS).refine(of_picture, LEFT[1]);
        let half = BLOCKS / 2;
        for (row, blocks) in sums.iter().enumerate() {
            for (column, block) in blocks.iter().enumerate() {
                let (top, left) = (row / half * half, column / half * half);
                let of_part = part_of(sums, top..top + half, left..left + half).refine(of_tile, LEFT[2]);
                let (x, y) = (tile.x / BLOCK + column as u32, tile.y / BLOCK + row as u32);
                if x < self.size.x && y < self.size.y {
                    self.blocks[(y * self.size.x + x) as usize] = block.refine(of_part, LEFT[3]);
                }
            }
        }
    }

    /// The factors and the share at a pixel, between the middles of the blocks around it.
    pub fn at(&self, pixel: UVec2) -> (Rgb, f32) {
        let last = (self.size - 1).as_vec2();
        let place = ((pixel.as_vec2() + 0.5) / BLOCK as f32 - 0.5).clamp(Vec2::ZERO, last);
        let corner = place.floor();
        let share = place - corner;
        let (x, y) = (corner.x as u32, corner.y as u32);
        let (right, below) = ((x + 1).min(self.size.x - 1), (y + 1).min(self.size.y - 1));
        let block = |x: u32, y: u32| self.blocks[(y * self.size.x + x) as usize];
        let between = |a: (Rgb, f32), b: (Rgb, f32), share: f32| (a.0.lerp(b.0, share), a.1 + (b.1 - a.1) * share);
        let upper = between(block(x, y), block(right, y), share.x);
        let lower = between(block(x, below), block(right, below), share.x);
        between(upper, lower, share.y)
    }
}

/// The sums of the blocks of a tile.
type TileSums = [[Sums; BLOCKS]; BLOCKS];

fn sums_of(tile: Tile, film: &Film, old: impl Fn(u32, u32) -> Option<(Rgb, f32)>) -> TileSums {
    let mut sums = [[Sums::default(); BLOCKS]; BLOCKS];
    for (x, y) in pixels_of(tile) {
        let samples = film.samples(x, y) as f32;
        let (Some((old, variance)), Some(pixel)) = (old(x, y), film.pixel(x, y)) else {
            continue;
        };
        if samples > 0.0 {
            let block = &mut sums[((y - tile.y) / BLOCK) as usize][((x - tile.x) / BLOCK) as usize];
            block.add(&Sums {
                pixels: 1.0,
                new: pixel.radiance,
                old,
                squares: luminance(pixel.radiance - old).powi(2),
                variances: variance / samples,
                samples,
            });
        }
    }
    sums
}

/// The sums of some rows and columns of blocks together.
fn part_of(sums: &TileSums, rows: Range<usize>, columns: Range<usize>) -> Sums {
    let mut whole = Sums::default();
    for row in &sums[rows] {
        row[columns.clone()].iter().for_each(|block| whole.add(block));
    }
    whole
}
