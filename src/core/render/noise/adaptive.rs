//! Adaptive sampling: more samples for the blocks of pixels that are noisy, and fewer for the others.
//!
//! A pixel that stops when its own samples happen to agree is darker than it should be on average, because rare bright
//! samples do not agree (Kirk and Arvo, Unbiased sampling techniques for image synthesis, SIGGRAPH 1991). So the number
//! of a pixel's samples must not depend on these samples. Here the blocks are the squares of a chess board. How many
//! samples a black block gets depends on what white blocks around it have found alone, and the other way round; black
//! and white pixels have random numbers that are independent of each other (`sampling/sampler.rs`). White blocks in
//! turn have as many samples as black ones say, but all that counts of them is their *first* samples, so few that each
//! block has them whatever is decided. Given the white blocks' first samples, the numbers of samples of the black ones
//! are constants, and their means are as unbiased as in a uniform picture. Only the light of splats is that of all
//! blocks: it is a mean over all paths, whose bias falls with their number.
//!
//! How far blocks follow those around them is decided by how well these foretell them elsewhere: tiles are of two
//! kinds, like the squares of a chess board as well, and blocks in tiles of either kind do what would have been best
//! for blocks of their colour in tiles of the other kind. Where that would gain nothing, sampling stays uniform. So
//! nothing is decided for blocks of one colour in tiles of one kind by what samples of any of these blocks have found.

mod shares;
#[cfg(test)]
mod tests;

use rayon::prelude::*;

use super::blocks::{BLOCK, PerBlock, blocks_of};
use super::mean_error::BlockError;
use crate::render::bytes::{Damaged, Reader, Writer};
use crate::render::film::Film;
use crate::render::noise::DARK;
use crate::render::noise::adaptive::shares::{Candidate, LEAST, rounded, shares, stride};
use crate::render::tile::{TILE, Tile};

/// The number of samples of every pixel before which no block differs.
pub const FIRST: u32 = 16;
/// The gain in variance at equal cost that is worth the differences: what samples take is only estimated.
const WORTHWHILE: f64 = 1.1;
/// How far neighbours may be followed: the powers of the samples that would be best if each block's noise were known
/// and samples were independent.
const POWERS: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
/// The time that a ray takes that is not from the camera, with the surface where it begins, in units of what a camera
/// ray takes. (Parts of the gold dragon, on two threads: 68 ns for a sample of the sky, 330 for one of the floor with
/// 3.4 rays, 551 for one of the dragon with 4.4.)
const COST_OF_OTHERS: f32 = 2.0;
/// The reach of neighbours in blocks.
const REACH: isize = 2;
/// The weight of the nearest neighbours, beside the mean of all within reach.
const NEAREST: f32 = 0.5;
/// By about so many blocks it is decided how far to follow neighbours.
const JUDGES: usize = 1 << 15;

/// What the first samples of a block have found.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Found {
    /// The mean over the pixels of the squared difference of the samples' halves, relative to a pixel's luminance or
    /// to that of the block if it is greater.
    noise: f32,
    /// The mean luminance.
    luminance: f32,
    /// The time that a sample takes, in units of what its camera ray takes; 0 where nothing is known.
    cost: f32,
}

/// What is known of the blocks of a picture.
#[derive(Clone, Debug)]
pub struct NoiseMap {
    tiles: Vec<Tile>,
    /// The number of blocks in a row of the picture.
    columns: usize,
    /// The number of blocks in the picture's tiles.
    blocks: usize,
    /// What the first [`FIRST`] samples of each block have found, the first twice [`FIRST`], and so on, as far as it
    /// is known.
    levels: Vec<Vec<Found>>,
    /// The power of two of samples that all blocks of a tile had when they began to differ; 0 before that.
    even: Vec<u32>,
}

/// The blocks that are rendered.
struct Board {
    columns: usize,
    /// What is known of them, with noise relative to luminances that are not those of what is nearly black; no cost
    /// for blocks that are not rendered.
    blocks: Vec<Found>,
}

/// The groups of blocks, which are the colours in the kinds of tiles.
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

    /// The places of the blocks of a group that are rendered.
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

    /// The noise and the cost of a block as the blocks around it have them; None without any.
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

    /// Has the noise of blocks that are nearly black beside the others of their group be relative to what is not.
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

    /// How far blocks of a group may follow the blocks around them, by what that would have gained for blocks of their
    /// colour in the other tiles; 0 for not at all.
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
    /// Nothing is known of a picture of these tiles, which is `width` pixels wide.
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

    /// Writes what was found.
    pub fn write(&self, to: &mut Writer) {
        self.even.iter().for_each(|&samples| to.u32(samples));
        to.u32(self.levels.len() as u32);
        for Found { noise, luminance, cost } in self.levels.iter().flatten() {
            [noise, luminance, cost].into_iter().for_each(|&number| to.f32(number));
        }
    }

    /// Takes up what [`Self::write`] has written of the same tiles.
    pub fn read(&mut self, from: &mut Reader) -> Result<(), Damaged> {
        for samples in &mut self.even {
            *samples = from.u32()?;
        }
        self.levels.clear();
        for _ in 0..from.u32()? {
            let found = |_| {
                let found = Found {
                    noise: from.finite()?,
                    luminance: from.finite()?,
                    cost: from.finite()?,
                };
                match [found.noise, found.luminance, found.cost]
                    .iter()
                    .all(|number| *number >= 0.0)
                {
                    true => Ok(found),
                    false => Err(Damaged),
                }
            };
            self.levels.push((0..self.blocks).map(found).collect::<Result<_, _>>()?);
        }
        Ok(())
    }

    fn place(&self, block: Tile) -> usize {
        (block.y / BLOCK) as usize * self.columns + (block.x / BLOCK) as usize
    }

    /// Takes up what a film has of a tile whose blocks have equally many samples. They may differ from now on.
    pub fn begin(&mut self, index: usize, film: &Film) {
        let errors = film.block_errors(self.tiles[index]);
        self.even[index] = errors[0].level;
        self.take_up(index, film, |_, _| true);
    }

    /// Takes note of new samples of a tile whose blocks differ, which the film has.
    pub fn note(&mut self, index: usize, film: &Film) {
        let has_just_been_reached = |block: Tile, level: u32| film.samples(block.x, block.y) == level;
        self.take_up(index, film, has_just_been_reached);
    }

    /// Takes up what the film has noted of the blocks of a tile, if `is_wanted` for the block and its power of two of
    /// samples.
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

    /// What is known of the tiles at `active` while the mean pixel has so many samples. None while there is a block of
    /// which nothing is known.
    fn board(&self, active: &[usize], samples: u32) -> Option<Board> {
        let places = || {
            let blocks = active.iter().flat_map(|&index| blocks_of(self.tiles[index]));
            blocks.map(|(_, block)| self.place(block))
        };
        // However few samples a block gets, it has these.
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

    /// The samples that the blocks of the tiles at `active` have at the end of a round in which the mean number, at
    /// equal cost, grows from `from` to `to`. `counts` has the present numbers of each of these tiles. None where
    /// all get as many more: without a gain, or while too little is known.
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

/// What the halves of a block's samples say, as the film has noted them.
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
