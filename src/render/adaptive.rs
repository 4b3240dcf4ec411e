//! Adaptive sampling: more samples for the blocks of pixels that are noisy, and fewer for the others.
//!
//! A pixel that stops when its own samples happen to agree is darker than it should be on average, because rare bright samples do not agree
//! (Kirk and Arvo, Unbiased sampling techniques for image synthesis, SIGGRAPH 1991). So the number of a pixel's samples must not depend on these samples.
//! Here the blocks are the squares of a chess board. How many samples a black block gets depends on what white blocks around it have found alone, and the
//! other way round; black and white pixels have random numbers that are independent of each other (`sampling/sampler.rs`). White blocks in turn have as
//! many samples as black ones say, but all that counts of them is their *first* samples, so few that each block has them whatever is decided. Given the
//! white blocks' first samples, the numbers of samples of the black ones are constants, and their means are as unbiased as in a uniform picture. Only the
//! light of splats is that of all blocks: it is a mean over all paths, whose bias falls with their number.
//!
//! How far blocks follow those around them is decided by how well these foretell them elsewhere: the tiles are divided like the squares of a chess board as
//! well, and blocks in tiles of either kind do what would have been best for blocks of their colour in tiles of the other kind. Where that would gain
//! nothing, sampling stays uniform.

use super::adaptive_shares::{Candidate, LEAST, rounded, shares};
use super::blocks::{BLOCK, PerBlock, blocks_of};
use super::bytes::{Damaged, Reader, Writer};
use super::film::Film;
use super::noise::DARK;
use super::tile::{TILE, Tile};

/// The number of samples of every pixel before which no block differs.
pub const FIRST: u32 = 16;
/// The gain in variance at equal cost that is worth the differences: what samples take is only estimated.
const WORTHWHILE: f64 = 1.1;
/// How far neighbours may be followed: the powers of the samples that would be best if each block's noise were known and samples were independent.
const POWERS: [f64; 4] = [0.25, 0.5, 0.75, 1.0];
/// The time that a ray takes that is not from the camera, with the surface where it begins, in units of what a camera ray takes. (Parts of the gold dragon: 68 ns
/// for a sample of the sky, 330 for one of the floor with 3.4 rays, 551 for one of the dragon with 4.4.)
const COST_OF_OTHERS: f32 = 2.0;
/// The reach of neighbours in blocks.
const REACH: isize = 2;
/// The weight of the nearest neighbours, beside the mean of all within reach.
const NEAREST: f64 = 0.5;
/// By about so many blocks it is decided how far to follow neighbours.
const JUDGES: usize = 1 << 15;

/// What the first samples of a block have found, so many of them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Found {
    /// How far the halves of the samples differ: the mean over the pixels of the square, relative to their luminances or that of the block if it is greater.
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
    blocks: usize,
    /// What the first [`FIRST`] samples of each block have found, the first twice [`FIRST`], and so on.
    levels: Vec<Vec<Found>>,
}

/// The blocks that are rendered.
struct Board {
    columns: usize,
    /// What is known of them, with noise relative to luminances that are not those of what is nearly black; no cost for blocks that are not rendered.
    squares: Vec<Found>,
}

/// The colours of the board.
const COLOURS: [usize; 2] = [0, 1];

impl Board {
    fn colour_of(&self, place: usize) -> usize {
        (place % self.columns + place / self.columns) % 2
    }

    /// The places of the blocks of a colour.
    fn of_colour(&self, colour: usize) -> impl Iterator<Item = usize> {
        (0..self.squares.len()).filter(move |&place| self.squares[place].cost > 0.0 && self.colour_of(place) == colour)
    }

    /// The kind of the tile that a block is in, 0 or 1 as on a chess board of tiles.
    fn kind_of_tile(&self, place: usize) -> usize {
        let edge = (TILE / BLOCK) as usize;
        (place % self.columns / edge + place / self.columns / edge) % 2
    }

    /// The blocks of the other colour within reach of a block, and whether they are the nearest ones.
    fn around(&self, place: usize) -> impl Iterator<Item = (&Found, bool)> {
        let (x, y) = ((place % self.columns) as isize, (place / self.columns) as isize);
        let steps = (-REACH..=REACH).flat_map(move |down| (-REACH..=REACH).map(move |right| (right, down)));
        let is_of_other = |&(right, down): &(isize, isize)| (right + down) % 2 != 0;
        steps.filter(is_of_other).filter_map(move |(right, down)| {
            let (x, y) = (x + right, y + down);
            let is_inside = x >= 0 && y >= 0 && (x as usize) < self.columns;
            let square = self
                .squares
                .get(is_inside.then_some(y as usize * self.columns + x as usize)?)?;
            (square.cost > 0.0).then_some((square, right.abs().max(down.abs()) == 1))
        })
    }

    /// The noise and the cost of a block as the blocks around it have them; None without any.
    fn foretold(&self, place: usize) -> Option<[f64; 2]> {
        let mut sums = [[0.0; 3]; 2];
        for (square, is_near) in self.around(place) {
            let found = [f64::from(square.noise), f64::from(square.cost), 1.0];
            for sum in &mut sums[usize::from(!is_near)..] {
                for (sum, found) in sum.iter_mut().zip(found) {
                    *sum += found;
                }
            }
        }
        let [near, all] = sums.map(|[noise, cost, count]| (count > 0.0).then(|| [noise / count, cost / count]));
        let (near, all) = (near.or(all)?, all?);
        Some(std::array::from_fn(|i| NEAREST * near[i] + (1.0 - NEAREST) * all[i]))
    }

    /// Has the noise of blocks that are nearly black beside the others of their colour be relative to what is not.
    fn raise_luminances(&mut self) {
        let bright = COLOURS.map(|colour| {
            let (sum, count) = self.of_colour(colour).fold((0.0, 0.0), |(sum, count), place| {
                (sum + f64::from(self.squares[place].luminance), count + 1.0)
            });
            (sum / f64::max(count, 1.0)) as f32
        });
        for place in 0..self.squares.len() {
            let least = DARK * bright[self.colour_of(place)];
            let square = &mut self.squares[place];
            square.noise *= (square.luminance / square.luminance.max(least).max(f32::MIN_POSITIVE)).powi(2);
        }
    }

    /// How far blocks of a colour in some of the tiles may follow the blocks around them, by what that would have gained in the others; 0 for not at all.
    fn power(&self, colour: usize, kind: usize) -> f64 {
        let is_judge = |place: &usize| self.kind_of_tile(*place) != kind;
        let places: Vec<usize> = self.of_colour(colour).filter(is_judge).collect();
        let judge = |&place: &usize| {
            let [noise, cost] = self.foretold(place)?;
            Some(Candidate {
                place,
                noise,
                cost,
                least: 0.0,
            })
        };
        let judges: Vec<Candidate> = (places.iter().step_by(places.len() / JUDGES + 1))
            .filter_map(judge)
            .collect();
        let inefficiency = |shares: &[f64]| {
            let (noise, cost) = (judges.iter().zip(shares)).fold((0.0, 0.0), |(noise, cost), (judge, share)| {
                let square = &self.squares[judge.place];
                (
                    noise + f64::from(square.noise) / share,
                    cost + f64::from(square.cost) * share,
                )
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
        }
    }

    /// Writes what was found.
    pub fn write(&self, to: &mut Writer) {
        to.u32(self.levels.len() as u32);
        for Found { noise, luminance, cost } in self.levels.iter().flatten() {
            [noise, luminance, cost].into_iter().for_each(|&number| to.f32(number));
        }
    }

    /// Takes up what [`Self::write`] has written of the same tiles.
    pub fn read(&mut self, from: &mut Reader) -> Result<(), Damaged> {
        self.levels.clear();
        for _ in 0..from.u32()? {
            let found = |_| {
                Ok(Found {
                    noise: from.f32()?,
                    luminance: from.f32()?,
                    cost: from.f32()?,
                })
            };
            self.levels.push((0..self.blocks).map(found).collect::<Result<_, _>>()?);
        }
        Ok(())
    }

    fn place(&self, block: Tile) -> usize {
        (block.y / BLOCK) as usize * self.columns + (block.x / BLOCK) as usize
    }

    /// Takes note of new samples of a tile, which the film has, so many of each block.
    pub fn note(&mut self, index: usize, counts: &PerBlock<u32>, film: &Film) {
        let errors = film.block_errors(self.tiles[index]);
        for (of_tile, block) in blocks_of(self.tiles[index]) {
            let place = self.place(block);
            let count = counts[of_tile];
            let is_level = count >= FIRST && (count / FIRST).is_power_of_two() && count.is_multiple_of(FIRST);
            if !is_level || errors[of_tile].level != count {
                continue;
            }
            let level = (count / FIRST).ilog2() as usize;
            while self.levels.len() <= level {
                self.levels.push(vec![Found::default(); self.blocks]);
            }
            let known = &mut self.levels[level][place];
            if known.cost == 0.0 {
                *known = found(block, film);
            }
        }
    }

    /// What is known of the tiles at `active` while the mean pixel has so many samples. None while there is a block of which nothing is known.
    fn board(&self, active: &[usize], samples: u32) -> Option<Board> {
        let places = || {
            let blocks = active.iter().flat_map(|&index| blocks_of(self.tiles[index]));
            blocks.map(|(_, block)| self.place(block))
        };
        // However few samples a block gets, it has these.
        let least = (LEAST * f64::from(samples)) as u32 / FIRST;
        let highest = least.checked_ilog2().unwrap_or(0) as usize;
        let known = &mut self.levels.iter().take(highest + 1).rev();
        let level = known.find(|level| places().all(|place| level[place].cost > 0.0))?;
        let mut board = Board {
            columns: self.columns,
            squares: vec![Found::default(); self.blocks],
        };
        places().for_each(|place| board.squares[place] = level[place]);
        board.raise_luminances();
        Some(board)
    }

    /// The samples that the blocks of the tiles at `active` have at the end of a round in which the mean number, at equal cost, grows from `from` to `to`.
    /// `counts` has the present numbers of each tile. None where sampling is uniform: without a gain, or while too little is known.
    pub fn allocate(
        &self,
        active: &[usize],
        counts: &[PerBlock<u32>],
        from: u32,
        to: u32,
    ) -> Option<Vec<PerBlock<u32>>> {
        let board = self.board(active, from)?;
        let powers = COLOURS.map(|colour| [0, 1].map(|kind| board.power(colour, kind)));
        if powers == [[0.0; 2]; 2] {
            return None;
        }
        let mut candidates = [const { Vec::new() }; 4];
        for &index in active {
            for (of_tile, block) in blocks_of(self.tiles[index]) {
                let place = self.place(block);
                let [noise, cost] = board.foretold(place)?;
                let pixels = f64::from(block.width * block.height);
                candidates[2 * board.colour_of(place) + board.kind_of_tile(place)].push(Candidate {
                    place,
                    noise: noise * pixels,
                    cost: cost * pixels,
                    least: f64::from(counts[index][of_tile]).max(LEAST * f64::from(to)),
                });
            }
        }
        let mut ends = vec![0; self.blocks];
        for (candidates, &power) in candidates.iter().zip(powers.as_flattened()) {
            let round = |samples: f64| f64::from(rounded(samples, from, to));
            let shares = shares(candidates, power, f64::from(to), round);
            for (candidate, samples) in candidates.iter().zip(shares) {
                ends[candidate.place] = samples as u32;
            }
        }
        let of_tile = |&index: &usize| {
            let mut samples = counts[index];
            for (of_tile, block) in blocks_of(self.tiles[index]) {
                samples[of_tile] = ends[self.place(block)].max(samples[of_tile]);
            }
            samples
        };
        Some(active.iter().map(of_tile).collect())
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::color::Rgb;
    use crate::render::tile::{PixelSum, TileSamples, tiles};
    use crate::sampling::sequence_of;

    const WIDTH: u32 = 96;
    const HEIGHT: u32 = 70;

    /// A map and a film after [`FIRST`] samples of luminance 1, which differ from half to half by what `noise` says of a pixel and in sign from pixel to pixel.
    fn sampled(noise: impl Fn(u32, u32) -> f32) -> (NoiseMap, Film, Vec<Tile>) {
        let all = tiles(WIDTH, HEIGHT);
        let (mut map, mut film) = (NoiseMap::new(&all, WIDTH), Film::new(WIDTH, HEIGHT));
        for (index, &tile) in all.iter().enumerate() {
            let ranges = [0..1, 1..2, 2..4, 4..8, 8..16];
            for samples in ranges {
                let sign = if samples.start < 8 { -1.0 } else { 1.0 };
                let pixel = |x: u32, y: u32| {
                    let light = 1.0 + sign * noise(x, y);
                    let count = samples.len() as f32;
                    PixelSum {
                        radiance: Rgb::splat(light * count),
                        luminance_squared: light * light * count,
                        rays: 3.0 * count,
                        ..PixelSum::default()
                    }
                };
                let rows = tile.y..tile.y + tile.height;
                let pixels = rows.flat_map(|y| (tile.x..tile.x + tile.width).map(move |x| (x, y)));
                let pixels = pixels.map(|(x, y)| pixel(x, y)).collect();
                film.add(&TileSamples::of_pixels(tile, samples.clone(), pixels));
                map.note(index, &[samples.end; _], &film);
            }
        }
        (map, film, all)
    }

    fn allocated(map: &NoiseMap, tiles: &[Tile]) -> Option<Vec<PerBlock<u32>>> {
        let active: Vec<usize> = (0..tiles.len()).collect();
        map.allocate(&active, &vec![[FIRST; _]; tiles.len()], FIRST, 2 * FIRST)
    }

    #[test]
    fn samples_go_where_the_noise_is_and_cost_as_much() {
        let is_noisy = |x: u32, y: u32| (x / 16 + y / 16).is_multiple_of(4);
        let (map, _, tiles) = sampled(|x, y| if is_noisy(x, y) { 0.5 } else { 0.02 });
        let ends = allocated(&map, &tiles).expect("a gain");
        let (mut all, mut pixels, mut noisy) = (0, 0, Vec::new());
        for (tile, ends) in tiles.iter().zip(&ends) {
            for (place, block) in blocks_of(*tile) {
                let area = block.width * block.height;
                (all, pixels) = (all + area * ends[place], pixels + area);
                if is_noisy(block.x, block.y) {
                    noisy.push(ends[place]);
                }
            }
        }
        let mean = f64::from(all) / f64::from(pixels);
        assert!((0.85..1.01).contains(&(mean / f64::from(2 * FIRST))), "{mean}");
        let of_noisy = noisy.iter().sum::<u32>() as f64 / noisy.len() as f64;
        assert!(
            of_noisy > 1.8 * mean && noisy.iter().all(|&end| end >= FIRST),
            "{of_noisy}"
        );
    }

    #[test]
    fn even_noise_is_sampled_evenly() {
        let (map, _, tiles) = sampled(|_, _| 0.3);
        assert_eq!(allocated(&map, &tiles), None);
        let (map, _, tiles) = sampled(|_, _| 0.0);
        assert_eq!(allocated(&map, &tiles), None);
        // Noise that the blocks around a block tell nothing of.
        let random = |x: u32, y: u32| crate::sampling::hash::pcg3d([x / BLOCK, y / BLOCK, 7])[0] % 8 == 0;
        let (map, _, tiles) = sampled(|x, y| if random(x, y) { 0.5 } else { 0.02 });
        assert_eq!(allocated(&map, &tiles), None);
    }

    #[test]
    fn a_block_has_no_say_in_its_own_samples() {
        let noise = |x: u32, y: u32| if x < 40 { 0.3 } else { 0.02 + 0.001 * y as f32 };
        let (map, _, tiles) = sampled(noise);
        let usual = allocated(&map, &tiles).expect("a gain");
        // Blocks of the colour of (50, 32), in tiles of the kind of that one, have other samples.
        let board = map.board(&Vec::from_iter(0..tiles.len()), FIRST).expect("all is known");
        let is_same = |x: u32, y: u32| {
            let [a, b] = [(50, 32), (x, y)].map(|(x, y)| (y / BLOCK) as usize * board.columns + (x / BLOCK) as usize);
            board.colour_of(a) == board.colour_of(b) && board.kind_of_tile(a) == board.kind_of_tile(b)
        };
        let (map, ..) = sampled(|x, y| if is_same(x, y) { 0.9 } else { noise(x, y) });
        let other = allocated(&map, &tiles).expect("a gain");
        let (mut same, mut differ) = (0, false);
        for ((tile, usual), other) in tiles.iter().zip(&usual).zip(&other) {
            for (place, block) in blocks_of(*tile) {
                if is_same(block.x, block.y) {
                    assert_eq!(usual[place], other[place], "{block:?}");
                    same += 1;
                } else {
                    differ |= usual[place] != other[place];
                }
            }
        }
        assert!(same > 300 && differ);
    }

    #[test]
    fn neighbours_of_another_colour_have_random_numbers_of_their_own() {
        let (map, _, tiles) = sampled(|_, _| 0.3);
        let board = map.board(&Vec::from_iter(0..tiles.len()), FIRST).expect("all is known");
        let pixels = || (0..HEIGHT).flat_map(|y| (0..WIDTH).map(move |x| (x, y)));
        let mut sequences = COLOURS.map(|_| std::collections::HashSet::new());
        for (x, y) in pixels() {
            let place = (y / BLOCK) as usize * board.columns + (x / BLOCK) as usize;
            sequences[board.colour_of(place)].insert(sequence_of(x, y));
        }
        let [black, white] = &sequences;
        assert!(black.is_disjoint(white) && black.len() == 6 * 5 && white.len() == 6 * 5);
    }

    #[test]
    fn what_was_found_survives_writing() {
        let (map, _, tiles) = sampled(|x, _| if x < 40 { 0.3 } else { 0.02 });
        let mut bytes = Writer::default();
        map.write(&mut bytes);
        let mut read = NoiseMap::new(&tiles, WIDTH);
        read.read(&mut Reader(&bytes.0)).expect("what was written");
        assert_eq!(read.levels, map.levels);
    }
}
