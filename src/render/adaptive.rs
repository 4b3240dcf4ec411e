//! Adaptive sampling: more samples for the blocks of pixels that are noisy, and fewer for the others.
//!
//! A pixel that stops when its own samples happen to agree is darker than it should be on average, because rare bright samples do not agree
//! (Kirk and Arvo, Unbiased sampling techniques for image synthesis, SIGGRAPH 1991). So the number of a pixel's samples must not depend on these samples.
//! Here it depends on *pilots*: a few samples per pixel with random numbers of their own, which decide and are then thrown away. Given the pilots, the
//! numbers of samples are constants, and the mean over so many samples is as unbiased as that of a uniform picture.
//!
//! How far to follow the pilots is the one thing that the picture decides itself, once, when it still has equally many samples everywhere: the tiles are
//! divided like the squares of a chess board, and each half is sampled as it would have been best for the *other* half, whose random numbers are
//! independent of its own. Where that would gain nothing, sampling stays uniform.

use std::sync::atomic::AtomicBool;

use super::adaptive_shares::{Candidate, LEAST, rounded, shares};
use super::bytes::{Damaged, Reader, Writer};
use super::film::Film;
use super::layers::Layers;
use super::light_layers::LightGroups;
use super::mean_error::{BLOCK, BLOCKS};
use super::noise::DARK;
use super::scene::RenderScene;
use super::tile::{TILE, Tile, render_tile};
use super::view::View;
use crate::sampling::hash::pcg3d;

/// The number of samples of every pixel before which there is no pilot.
pub const FIRST: u32 = 64;
/// A pilot takes this share of the samples so far.
const PILOT_SHARE: u32 = 32;
/// The gain in variance at equal cost that is worth the pilots.
const WORTHWHILE: f64 = 1.1;
/// How far pilots may be followed: the powers of the samples that would be best if each block's noise were known and samples were independent.
const POWERS: [f64; 4] = [0.25, 0.5, 0.75, 1.0];

/// A number for each block of a tile, row by row.
pub type PerBlock<T> = [T; BLOCKS];

/// The number of samples per pixel of the pilot after `samples` of the picture.
pub fn pilot_samples(samples: u32) -> u32 {
    // A power of two, so that halves can be compared.
    (samples / PILOT_SHARE).max(2).next_power_of_two()
}

/// The blocks of a tile that are in the picture, with their places in [`PerBlock`].
pub(super) fn blocks_of(tile: Tile) -> impl Iterator<Item = (usize, Tile)> {
    let starts = |length: u32| (0..length).step_by(BLOCK as usize);
    starts(tile.height).flat_map(move |y| {
        starts(tile.width).map(move |x| {
            let block = Tile {
                x: tile.x + x,
                y: tile.y + y,
                width: BLOCK.min(tile.width - x),
                height: BLOCK.min(tile.height - y),
            };
            ((y / BLOCK * (TILE / BLOCK) + x / BLOCK) as usize, block)
        })
    })
}

/// The pilot of a tile.
#[derive(Clone, Debug, PartialEq)]
pub struct PilotTile {
    /// The mean luminance of each pixel of each block, and the variance that a single sample has in effect.
    pixels: Vec<(f32, f32)>,
    /// Where the pixels of each block begin.
    starts: PerBlock<usize>,
    /// The rays of a sample in each block, which are its cost.
    rays: PerBlock<f32>,
    all_rays: u64,
    samples: u32,
}

impl PilotTile {
    /// The rays that were traced for it.
    pub fn rays(&self) -> u64 {
        self.all_rays
    }
}

/// Renders a pilot of `samples` per pixel, a power of two from 2 on; None if cancelled. Pilots with different numbers are independent of each other, and all
/// of the picture.
pub fn render_pilot(
    scene: &RenderScene,
    view: &View,
    tile: Tile,
    number: u32,
    samples: u32,
    cancel: &AtomicBool,
) -> Option<PilotTile> {
    let [seed, ..] = pcg3d([view.seed, number, 0x9e37_79b9]);
    let view = View {
        seed,
        light_groups: LightGroups::default(),
        layers: Layers::default(),
        ..view.clone()
    };
    let mut pilot = PilotTile {
        pixels: Vec::with_capacity((tile.width * tile.height) as usize),
        starts: [0; BLOCKS],
        rays: [0.0; BLOCKS],
        all_rays: 0,
        samples,
    };
    for (place, block) in blocks_of(tile) {
        let alone = Tile { x: 0, y: 0, ..block };
        let mut film = Film::new(block.width, block.height);
        for range in [0..samples / 2, samples / 2..samples] {
            let mut result = render_tile(scene, &view, block, range, cancel)?;
            pilot.rays[place] += result.rays as f32 / (block.width * block.height * samples) as f32;
            result.tile = alone;
            // Light for other pixels comes from the samples of all blocks.
            result.splats = Default::default();
            pilot.all_rays += result.rays;
            film.add(&result);
        }
        pilot.starts[place] = pilot.pixels.len();
        let errors = film.mean_errors(alone);
        pilot
            .pixels
            .extend(errors.map(|(mean, squared)| (mean, squared * samples as f32)));
    }
    Some(pilot)
}

/// What is known of the blocks of a picture.
#[derive(Clone, Debug, Default, PartialEq)]
struct Block {
    /// The sum over its pixels of the variance of a sample relative to the pixel's luminance, by pilots.
    noise: f64,
    /// The rays of a sample.
    cost: f64,
    /// The pilot's samples behind both.
    weight: f64,
}

/// What the pilots of a picture have found.
#[derive(Clone, Debug, Default)]
pub struct Pilots {
    tiles: Vec<Tile>,
    /// The number of blocks in a row of the picture.
    columns: usize,
    blocks: Vec<Block>,
    /// How far each half of the tiles follows the pilots.
    powers: Option<[f64; 2]>,
    /// The number of pilots so far.
    count: u32,
}

impl Pilots {
    /// Nothing is known of a picture of these tiles, which is `width` pixels wide.
    pub fn new(tiles: &[Tile], width: u32) -> Self {
        let columns = width.div_ceil(TILE) as usize * (TILE / BLOCK) as usize;
        let bottom = tiles.iter().map(|tile| tile.y / TILE + 1).max().unwrap_or(0) as usize;
        Self {
            tiles: tiles.to_vec(),
            columns,
            blocks: vec![Block::default(); columns * bottom * (TILE / BLOCK) as usize],
            ..Self::default()
        }
    }

    /// Writes what was found.
    pub fn write(&self, to: &mut Writer) {
        to.u32(self.count);
        to.u32(u32::from(self.powers.is_some()));
        self.powers.into_iter().flatten().for_each(|power| to.f64(power));
        for block in &self.blocks {
            [block.noise, block.cost, block.weight]
                .into_iter()
                .for_each(|number| to.f64(number));
        }
    }

    /// Takes up what [`Self::write`] has written of the same tiles.
    pub fn read(&mut self, from: &mut Reader) -> Result<(), Damaged> {
        self.count = from.u32()?;
        self.powers = match from.flag()? {
            true => Some([from.f64()?, from.f64()?]),
            false => None,
        };
        for block in &mut self.blocks {
            *block = Block {
                noise: from.f64()?,
                cost: from.f64()?,
                weight: from.f64()?,
            };
        }
        Ok(())
    }

    /// The number of pilots so far.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Whether it is known how far to follow the pilots.
    pub fn are_decided(&self) -> bool {
        self.powers.is_some()
    }

    /// Whether it is known that there is nothing to gain.
    pub fn are_to_no_avail(&self) -> bool {
        self.powers.is_some_and(|powers| powers == [0.0; 2])
    }

    /// Whether there was a pilot of each of the tiles at these indices.
    pub fn know(&self, tiles: &[usize]) -> bool {
        let mut blocks = tiles.iter().flat_map(|&index| blocks_of(self.tiles[index]));
        blocks.all(|(_, block)| self.blocks[self.place(block)].weight > 0.0)
    }

    /// Leaves it open again how far to follow the pilots.
    pub fn forget_decision(&mut self) {
        self.powers = None;
    }

    fn place(&self, block: Tile) -> usize {
        (block.y / BLOCK) as usize * self.columns + (block.x / BLOCK) as usize
    }

    /// Takes up a pilot of the tiles at these indices.
    pub fn add(&mut self, pilot: &[(usize, PilotTile)]) {
        let (sum, count) = pilot
            .iter()
            .flat_map(|(_, tile)| &tile.pixels)
            .fold((0.0, 0u64), |(sum, count), (mean, _)| {
                (sum + f64::from(mean.abs()), count + 1)
            });
        let dark = DARK * (sum / count.max(1) as f64) as f32;
        for (index, found) in pilot {
            for (of_tile, block) in blocks_of(self.tiles[*index]) {
                let start = found.starts[of_tile];
                let pixels = &found.pixels[start..start + (block.width * block.height) as usize];
                let relative = |(mean, variance): &(f32, f32)| {
                    let scale = mean.abs().max(dark).max(f32::MIN_POSITIVE);
                    let noise = f64::from(variance / scale / scale);
                    if noise.is_finite() { noise } else { 0.0 }
                };
                let noise: f64 = pixels.iter().map(relative).sum();
                let place = self.place(block);
                let known = &mut self.blocks[place];
                let weight = f64::from(found.samples);
                let all = known.weight + weight;
                known.noise += (noise - known.noise) * weight / all;
                known.cost += (f64::from(found.rays[of_tile]) - known.cost) * weight / all;
                known.weight = all;
            }
        }
        self.count += 1;
    }

    /// The noise of a block, smoothed over its neighbours, which makes more of few samples.
    fn smooth(&self, place: usize) -> f64 {
        let (x, y) = ((place % self.columns) as isize, (place / self.columns) as isize);
        let (mut sum, mut count) = (0.0, 0.0);
        for (x, y) in (y - 1..=y + 1).flat_map(|y| (x - 1..=x + 1).map(move |x| (x, y))) {
            let is_inside = x >= 0 && y >= 0 && (x as usize) < self.columns;
            let block = is_inside
                .then(|| self.blocks.get(y as usize * self.columns + x as usize))
                .flatten();
            if let Some(block) = block.filter(|block| block.weight > 0.0) {
                (sum, count) = (sum + block.noise, count + 1.0);
            }
        }
        0.5 * (self.blocks[place].noise + sum / f64::max(count, 1.0))
    }

    fn half_of(&self, index: usize) -> usize {
        let tile = self.tiles[index];
        ((tile.x / TILE + tile.y / TILE) % 2) as usize
    }

    /// The candidates of a half of the tiles at `active`, where `least` gives the least samples of a block.
    fn candidates(&self, active: &[usize], half: usize, least: impl Fn(usize, usize) -> f64) -> Vec<Candidate> {
        let mut found = Vec::new();
        for &index in active.iter().filter(|&&index| self.half_of(index) == half) {
            for (of_tile, block) in blocks_of(self.tiles[index]) {
                let place = self.place(block);
                // The cost and the noise are of whole blocks: those at the edge have fewer pixels.
                found.push(Candidate {
                    place,
                    noise: self.smooth(place),
                    cost: self.blocks[place].cost * f64::from(block.width * block.height),
                    least: least(index, of_tile),
                });
            }
        }
        found
    }

    /// Decides how far to follow the pilots from a film that has `samples` of every pixel in the tiles at `active`.
    pub fn decide(&mut self, film: &Film, active: &[usize]) {
        // What is best for one half is done to the other.
        let best = |half: usize| {
            let tiles = active.iter().filter(|&&index| self.half_of(index) == half);
            let errors: Vec<Vec<(f32, f32)>> = tiles
                .clone()
                .map(|&index| film.mean_errors(self.tiles[index]).collect())
                .collect();
            let count = errors.iter().map(Vec::len).sum::<usize>().max(1);
            let light: f64 = errors.iter().flatten().map(|(mean, _)| f64::from(mean.abs())).sum();
            let dark = DARK * (light / count as f64) as f32;
            let mut noise = vec![0.0; self.blocks.len()];
            for (&index, errors) in tiles.zip(&errors) {
                let tile = self.tiles[index];
                for (pixel, (mean, squared)) in errors.iter().enumerate() {
                    let (x, y) = (tile.x + pixel as u32 % tile.width, tile.y + pixel as u32 / tile.width);
                    let scale = mean.abs().max(dark).max(f32::MIN_POSITIVE);
                    noise[(y / BLOCK) as usize * self.columns + (x / BLOCK) as usize] +=
                        f64::from(squared / scale / scale);
                }
            }
            let candidates = self.candidates(active, half, |_, _| LEAST);
            let uniform: f64 = candidates.iter().map(|block| noise[block.place]).sum();
            let gain = |power: f64| {
                let shares = shares(&candidates, power, 1.0, std::convert::identity);
                let adaptive: f64 = candidates
                    .iter()
                    .zip(&shares)
                    .map(|(block, share)| noise[block.place] / share)
                    .sum();
                if adaptive > 0.0 { uniform / adaptive } else { 1.0 }
            };
            let gains = POWERS.map(|power| (power, gain(power)));
            let (power, gain) = gains
                .into_iter()
                .max_by(|a, b| a.1.total_cmp(&b.1))
                .unwrap_or((0.0, 1.0));
            if gain >= WORTHWHILE { power } else { 0.0 }
        };
        // A half without tiles has nothing to gain, and is no guide.
        let halves = [0, 1].map(|half| active.iter().any(|&index| self.half_of(index) == half));
        let powers = [best(1), best(0)];
        self.powers = Some(if halves == [true; 2] { powers } else { [0.0; 2] });
    }

    /// The samples that the blocks of the tiles at `active` have at the end of a round in which the mean number, at equal cost, grows from `from` to `to`.
    /// `counts` has the present numbers of each tile. None where sampling is uniform: without a gain, or while there was no pilot of some tile.
    pub fn allocate(
        &self,
        active: &[usize],
        counts: &[PerBlock<u32>],
        from: u32,
        to: u32,
    ) -> Option<Vec<PerBlock<u32>>> {
        let powers = self.powers.filter(|_| !self.are_to_no_avail() && self.know(active))?;
        let mut ends = vec![0; self.blocks.len()];
        for (half, power) in powers.into_iter().enumerate() {
            let least = |index: usize, block: usize| f64::from(counts[index][block]).max(LEAST * f64::from(to));
            let candidates = self.candidates(active, half, least);
            let round = |samples: f64| f64::from(rounded(samples, from, to));
            let shares = shares(&candidates, power, f64::from(to), round);
            candidates
                .iter()
                .zip(shares)
                .for_each(|(block, samples)| ends[block.place] = samples as u32);
        }
        let of_tile = |index: &usize| {
            let mut samples = counts[*index];
            for (of_tile, block) in blocks_of(self.tiles[*index]) {
                samples[of_tile] = ends[self.place(block)].max(samples[of_tile]);
            }
            samples
        };
        Some(active.iter().map(of_tile).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_cover_a_tile_once() {
        let tile = Tile {
            x: 64,
            y: 32,
            width: 20,
            height: 32,
        };
        let pixels: u32 = blocks_of(tile).map(|(_, block)| block.width * block.height).sum();
        assert_eq!(pixels, 640);
        assert!(blocks_of(tile).all(|(place, block)| super::super::mean_error::block_of(block.x, block.y) == place));
    }
}
