//! Adaptive sampling: more samples for noisy blocks of pixels, and fewer for the others.
//!
//! A pixel that stops when its own samples happen to agree is darker than it should be on average, because rare bright
//! samples do not agree (Kirk and Arvo, Unbiased sampling techniques for image synthesis, SIGGRAPH 1991). So the number
//! of a pixel's samples must not depend on these samples. Here the blocks are coloured like a chess board. The number
//! of samples of a black block depends only on the samples of white blocks around it, and vice versa; black and white
//! pixels have independent random numbers (`sampling/sampler.rs`). White blocks in turn have numbers of samples that
//! depend on black ones, but only their *first* samples are used, so few that each block has them whatever is decided.
//! Given the white blocks' first samples, the numbers of samples of the black ones are constants, and their means are
//! as unbiased as in a uniform picture. Only the light of splats comes from all blocks: it is a mean over all paths,
//! whose bias falls with their number.
//!
//! How closely blocks follow those around them depends on how well these predict their noise elsewhere: tiles are of
//! two kinds, also like a chess board, and blocks in tiles of one kind use the strength that would have been best for
//! blocks of their colour in tiles of the other kind. Where that gains nothing, sampling stays uniform. So no decision
//! about blocks of one colour in tiles of one kind depends on samples of any of these blocks.

mod shares;
#[cfg(test)]
mod tests;

use bytemuck::{Pod, Zeroable};
use rayon::prelude::*;

use super::blocks::{BLOCK, PerBlock, blocks_of};
use super::mean_error::BlockError;
use crate::render::bytes::{Damaged, Reader, Writer};
use crate::render::film::Film;
use crate::render::noise::DARK;
use crate::render::noise::adaptive::shares::{Candidate, LEAST, rounded, shares, stride};
use crate::render::tile::{TILE, Tile};

/// The number of samples per pixel before which all blocks are equal.
pub const FIRST: u32 = 16;
/// The least gain in variance at equal cost for which blocks differ: the cost of samples is only estimated.
const WORTHWHILE: f64 = 1.1;
/// How closely neighbours may be followed: the powers of the numbers of samples that would be optimal if each block's
/// noise were known and samples were independent.
const POWERS: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
/// The time of a ray that is not from the camera, with shading at its origin, relative to a camera ray. (Parts of the
/// gold dragon, on two threads: 68 ns for a sample of the sky, 330 for one of the floor with 3.4 rays, 551 for one of
/// the dragon with 4.4.)
const COST_OF_OTHERS: f32 = 2.0;
/// The reach of neighbours in blocks.
const REACH: isize = 2;
/// The weight of the nearest neighbours, beside the mean of all within reach.
const NEAREST: f32 = 0.5;
/// The approximate number of blocks by which the power is chosen.
const JUDGES: usize = 1 << 15;

/// What the first samples of a block have found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
struct Found {
    /// The mean over the pixels of the squared difference of the samples' halves, relative to a pixel's luminance or to
    /// the block's if that is greater.
    noise: f32,
    /// The mean luminance.
    luminance: f32,
    /// The time of a sample relative to that of its camera ray; 0 if unknown.
    cost: f32,
}

/// The statistics of a picture's blocks.
#[derive(Clone, Debug)]
pub struct NoiseMap {
    tiles: Vec<Tile>,
    /// The number of blocks in a row of the picture.
    columns: usize,
    /// The number of blocks in the picture's tiles.
    blocks: usize,
    /// The statistics of the first [`FIRST`] samples of each block, the first twice [`FIRST`], and so on, as far as
    /// known.
    levels: Vec<Vec<Found>>,
    /// The power of two of samples that all blocks of a tile had when they began to differ; 0 before that.
    even: Vec<u32>,
}

/// The blocks that are rendered.
struct Board {
    columns: usize,
    /// Their statistics, with noise relative to luminances raised above near black; blocks that are not rendered have
    /// no cost.
    blocks: Vec<Found>,
}

/// The groups of blocks: two colours times two kinds of tiles.
const GROUPS: usize = 4;

impl Board {
    fn colour_of(&self, place: usize) -> usize {
        (place % self.columns + place / self.columns) % 2
    }

    /// The kind of the tile that a block is in, 0 or 1.
    fn kind_of_tile(&self, place: usize) -> usize {
        let edge = (TILE / BLOCK) as usize;
        (place % self.columns / edge + place / self.columns / edge) % 2
    }

    fn group_of(&self, place: usize) -> usize {
        2 * self.colour_of(place) + self.kind_of_tile(place)
    }

    /// The indices of a group's blocks that are rendered.
    fn of_group(&self, group: usize) -> impl Iterator<Item = usize> {
        (0..self.blocks.len()).filter(move |&place| self.blocks[place].cost > 0.0 && self.group_of(place) == group)
    }

    /// The blocks of the other colour within reach of a block, and whether they are the nearest ones.
    fn around(&self, place: usize) -> impl Iterator<Item = (&Found, bool)> {
        let (x, y) = ((place % self.columns) as isize, (place / self.columns) as isize);
        let steps = (-REACH..=REACH).flat_map(move |down| (-REACH..=REACH).map(move |right| (right, down)));
        let is_of_other = |&(right, down): &(isize, isize)| (right + down) % 2 != 0;
        steps.filter(is_of_other).filter_map(move |(right, down)| {
            let (x, y) = (x + right, y + down);
            let is_inside = x >= 0 && y >= 0 && (x as usize) < self.columns;
            let block = self
                .blocks
                .get(is_inside.then(|| y as usize * self.columns + x as usize)?)?;
            (block.cost > 0.0).then_some((block, right.abs().max(down.abs()) == 1))
        })
    }

    /// The noise and the cost of a block as predicted from the blocks around it; None without any.
    fn foretold(&self, place: usize) -> Option<[f32; 2]> {
        let mut sums = [[0.0; 3]; 2];
        for (block, is_near) in self.around(place) {
            for sum in &mut sums[usize::from(!is_near)..] {
                for (sum, found) in sum.iter_mut().zip([block.noise, block.cost, 1.0]) {
                    *sum += found;
                }
            }
        }
        let [near, all] = sums.map(|[noise, cost, count]| (count > 0.0).then(|| [noise / count, cost / count]));
        let (near, all) = (near.or(all)?, all?);
        Some(std::array::from_fn(|i| NEAREST * near[i] + (1.0 - NEAREST) * all[i]))
    }

    /// Raises the luminances of nearly black blocks to a share of their group's mean.
    fn raise_luminances(&mut self) {
        let mut sums = [[0.0; 2]; GROUPS];
        for (place, block) in self.blocks.iter().enumerate().filter(|(_, block)| block.cost > 0.0) {
            let [sum, count] = &mut sums[self.group_of(place)];
            (*sum, *count) = (*sum + f64::from(block.luminance), *count + 1.0);
        }
        let dark = sums.map(|[sum, count]| DARK * (sum / f64::max(count, 1.0)) as f32);
        for place in 0..self.blocks.len() {
            let least = dark[self.group_of(place)].max(f32::MIN_POSITIVE);
            let block = &mut self.blocks[place];
            block.noise *= (block.luminance / block.luminance.max(least)).powi(2);
        }
    }

    /// The power with which blocks of a group may follow the blocks around them, as would have been best for blocks of
    /// their colour in the other tiles; 0 for uniform sampling.
    fn power(&self, group: usize) -> f64 {
        let places: Vec<usize> = self.of_group(group ^ 1).collect();
        let judge = |&place: &usize| {
            let [noise, cost] = self.foretold(place)?;
            let (place, least) = (place as u32, 0.0);
            Some(Candidate {
                place,
                noise,
                cost,
                least,
            })
        };
        let judges = places.iter().step_by(stride(places.len(), JUDGES));
        let judges: Vec<Candidate> = judges.filter_map(judge).collect();
        let inefficiency = |shares: &[f64]| {
            let (noise, cost) = (judges.iter().zip(shares)).fold((0.0, 0.0), |(noise, cost), (judge, share)| {
                let Found {
                    noise: found,
                    cost: took,
                    ..
                } = self.blocks[judge.place as usize];
                (noise + f64::from(found) / share, cost + f64::from(took) * share)
            });
            noise * cost
        };
        let uniform = inefficiency(&vec![1.0; judges.len()]);
        let gains = POWERS.map(|power| {
            let adaptive = inefficiency(&shares(&judges, power, 1.0, std::convert::identity));
            (power, if adaptive > 0.0 { uniform / adaptive } else { 1.0 })
        });
        let best = gains.into_iter().max_by(|a, b| a.1.total_cmp(&b.1));
        best.filter(|(_, gain)| *gain >= WORTHWHILE)
            .map_or(0.0, |(power, _)| power)
    }
}

impl NoiseMap {
    /// A map without statistics for a picture of these tiles, which is `width` pixels wide.
    pub fn new(tiles: &[Tile], width: u32) -> Self {
        let columns = width.div_ceil(TILE) as usize * (TILE / BLOCK) as usize;
        let bottom = tiles.iter().map(|tile| tile.y / TILE + 1).max().unwrap_or(0) as usize;
        Self {
            tiles: tiles.to_vec(),
            columns,
            blocks: columns * bottom * (TILE / BLOCK) as usize,
            levels: Vec::new(),
            even: vec![0; tiles.len()],
        }
    }

    /// Writes the statistics.
    pub fn write(&self, to: &mut Writer) {
        to.put_all(&self.even);
        to.put(self.levels.len() as u32);
        self.levels.iter().for_each(|level| to.put_all(level));
    }

    /// Reads the statistics that [`Self::write`] has written for the same tiles.
    pub fn read(&mut self, from: &mut Reader) -> Result<(), Damaged> {
        from.fill(&mut self.even)?;
        self.levels.clear();
        for _ in 0..from.take::<u32>()? {
            let found = |_| {
                let numbers: [f32; 3] = from.take()?;
                Damaged::unless(numbers.iter().all(|number| (0.0..=f32::MAX).contains(number)))?;
                Ok(bytemuck::cast(numbers))
            };
            self.levels.push((0..self.blocks).map(found).collect::<Result<_, _>>()?);
        }
        Ok(())
    }

    fn place(&self, block: Tile) -> usize {
        (block.y / BLOCK) as usize * self.columns + (block.x / BLOCK) as usize
    }

    /// Takes in the film's statistics of a tile whose blocks have equally many samples. They may differ from now on.
    pub fn begin(&mut self, index: usize, film: &Film) {
        let errors = film.block_errors(self.tiles[index]);
        self.even[index] = errors[0].level;
        self.take_up(index, film, |_, _| true);
    }

    /// Takes in the film's statistics after new samples of a tile whose blocks differ.
    pub fn note(&mut self, index: usize, film: &Film) {
        let has_just_been_reached = |block: Tile, level: u32| film.samples(block.x, block.y) == level;
        self.take_up(index, film, has_just_been_reached);
    }

    /// Takes in the film's statistics of a tile's blocks, for each block and power of two of samples for which
    /// `is_wanted` is true.
    fn take_up(&mut self, index: usize, film: &Film, is_wanted: impl Fn(Tile, u32) -> bool) {
        let errors = film.block_errors(self.tiles[index]);
        for (of_tile, block) in blocks_of(self.tiles[index]) {
            let BlockError { level, noted, .. } = errors[of_tile];
            if level < FIRST || noted != level || !is_wanted(block, level) {
                continue;
            }
            let number = (level / FIRST).ilog2() as usize;
            while self.levels.len() <= number {
                self.levels.push(vec![Found::default(); self.blocks]);
            }
            let place = self.place(block);
            let known = &mut self.levels[number][place];
            if known.cost == 0.0 {
                *known = found(block, film);
            }
        }
    }

    /// The statistics for the tiles at `active` while the mean pixel has `samples` samples. None if those of a block
    /// are missing.
    fn board(&self, active: &[usize], samples: u32) -> Option<Board> {
        let places = || {
            let blocks = active.iter().flat_map(|&index| blocks_of(self.tiles[index]));
            blocks.map(|(_, block)| self.place(block))
        };
        // Every block has at least this many samples.
        let even = active.iter().map(|&index| self.even[index]).min()?;
        let sure = even.max((LEAST * f64::from(samples)) as u32) / FIRST;
        let known = &mut self.levels.iter().take(sure.checked_ilog2()? as usize + 1).rev();
        let level = known.find(|level| places().all(|place| level[place].cost > 0.0))?;
        let mut board = Board {
            columns: self.columns,
            blocks: vec![Found::default(); self.blocks],
        };
        places().for_each(|place| board.blocks[place] = level[place]);
        board.raise_luminances();
        Some(board)
    }

    /// The samples of each block in the tiles at `active` at the end of a round in which the mean number, at equal
    /// cost, grows from `from` to `to`. `counts` has the current numbers of each of these tiles. None for uniform
    /// sampling: without a gain, or with too few statistics.
    pub fn allocate(
        &self,
        active: &[usize],
        counts: &[PerBlock<u32>],
        from: u32,
        to: u32,
    ) -> Option<Vec<PerBlock<u32>>> {
        let board = self.board(active, from)?;
        let powers: [f64; GROUPS] = std::array::from_fn(|group| board.power(group));
        if powers == [0.0; GROUPS] {
            return None;
        }
        let foretold: Vec<Option<[f32; 2]>> = (0..self.blocks)
            .into_par_iter()
            .map(|place| board.foretold(place))
            .collect();
        let mut candidates = [const { Vec::new() }; GROUPS];
        let mut ends = vec![0; self.blocks];
        for (&index, counts) in active.iter().zip(counts) {
            for (of_tile, block) in blocks_of(self.tiles[index]) {
                let place = self.place(block);
                ends[place] = counts[of_tile].saturating_add(to - from);
                let (Some([noise, cost]), pixels) = (foretold[place], (block.width * block.height) as f32) else {
                    continue;
                };
                candidates[board.group_of(place)].push(Candidate {
                    place: place as u32,
                    noise: noise * pixels,
                    cost: cost * pixels,
                    least: f64::from(counts[of_tile]).max(LEAST * f64::from(to)) as f32,
                });
            }
        }
        for (candidates, power) in candidates.iter().zip(powers).filter(|(_, power)| *power > 0.0) {
            let round = |samples: f64| f64::from(rounded(samples, from, to));
            let shares = shares(candidates, power, f64::from(to), round);
            for (candidate, samples) in candidates.iter().zip(shares) {
                ends[candidate.place as usize] = samples as u32;
            }
        }
        let of_tile = |(&index, counts): (&usize, &PerBlock<u32>)| {
            let mut samples = *counts;
            for (of_tile, block) in blocks_of(self.tiles[index]) {
                samples[of_tile] = ends[self.place(block)].max(samples[of_tile]);
            }
            samples
        };
        Some(active.iter().zip(counts).map(of_tile).collect())
    }
}

/// The statistics from the halves of a block's samples, as stored in the film.
fn found(block: Tile, film: &Film) -> Found {
    let places =
        || (block.y..block.y + block.height).flat_map(|y| (block.x..block.x + block.width).map(move |x| (x, y)));
    let pixels = (block.width * block.height) as f32;
    let luminance = places().map(|(x, y)| film.halves(x, y)[0].abs()).sum::<f32>() / pixels;
    let squared = |(x, y)| {
        let [mean, half] = film.halves(x, y);
        ((mean - half) / mean.abs().max(luminance).max(f32::MIN_POSITIVE)).powi(2)
    };
    let noise = places().map(squared).sum::<f32>() / pixels;
    Found {
        noise: if noise.is_finite() { noise } else { 0.0 },
        luminance,
        cost: 1.0 + COST_OF_OTHERS * (places().map(|(x, y)| film.rays_of_sample(x, y)).sum::<f32>() / pixels - 1.0),
    }
}
