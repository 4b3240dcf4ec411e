//! The adaptive part of a job: the noise estimated so far, and the rounds in which the blocks of a tile get different
//! numbers of samples. [`crate::render::noise::adaptive`] explains both and why pictures stay unbiased.

use std::iter::successors;
use std::ops::Range;

use crate::render::bytes::{Damaged, Reader, Writer};
use crate::render::film::Film;
use crate::render::noise::adaptive::NoiseMap;
use crate::render::noise::blocks::PerBlock;
use crate::render::tile::{Tile, TileSamples};

/// The mean samples of a visit to a tile.
const VISIT: u32 = 16;

/// A round of a tile whose blocks get different numbers of samples, divided into visits. A visit ends at each power of
/// two of a block's samples, so that halves can be compared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct TileRound {
    /// The samples of the mean pixel before and after the round.
    mean: Range<u32>,
    visits: u32,
    /// The number of visits in which blocks that double less than once get all their samples.
    steps: u32,
    from: PerBlock<u32>,
    to: PerBlock<u32>,
    /// The samples of each block so far.
    counts: PerBlock<u32>,
}

impl TileRound {
    /// A round in which the mean pixel goes from the start of `mean` to its end, and blocks from `from` to `to`
    /// samples, or to fewer where the round is too short for their powers of two.
    pub fn new(mean: Range<u32>, from: PerBlock<u32>, to: PerBlock<u32>) -> Self {
        let most = (mean.len() as u32).max(1);
        let reachable = |from: u32| next_power(from).saturating_mul(1 << (most - 1).min(31));
        let to: PerBlock<u32> = std::array::from_fn(|block| to[block].min(reachable(from[block])));
        let blocks = || from.iter().zip(&to);
        let all: u64 = blocks().map(|(from, to)| u64::from(to - from)).sum();
        let steps = all.div_ceil(from.len() as u64).div_ceil(VISIT.into()).max(1) as u32;
        let powers = |(from, to): (&u32, &u32)| {
            let between = successors(Some(next_power(*from)), |power| power.checked_mul(2));
            1 + between.take_while(|power| power < to).count() as u32
        };
        let powers = blocks().map(powers).max().unwrap_or(1);
        let steps = steps.min((most + 1).saturating_sub(powers)).max(1);
        Self {
            mean,
            visits: steps - 1 + powers,
            steps,
            from,
            to,
            counts: from,
        }
    }

    /// Whether the mean pixel has `done` samples within the round.
    pub fn covers(&self, done: u32) -> bool {
        self.mean.contains(&done)
    }

    /// The mean samples after the visit that begins at `done` mean samples, and the samples of each block in it.
    pub fn visit(&self, done: u32) -> (u32, PerBlock<Range<u32>>) {
        let (length, visits) = (self.mean.len() as u64, u64::from(self.visits));
        let next = (u64::from(done - self.mean.start) * visits).div_ceil(length) + 1;
        let end = self.mean.start + (length * next / visits) as u32;
        let range = |block: usize| {
            let (from, to, count) = (self.from[block], self.to[block], self.counts[block]);
            let steps = u64::from(self.steps);
            let wanted = from + (u64::from(to - from) * next.min(steps) / steps) as u32;
            let end = wanted.min(next_power(count));
            // The first visit of a picture gives every block a first sample, so that its noise can be estimated.
            let least = if count == 0 { to.min(1) } else { count };
            count..end.max(least)
        };
        (end, std::array::from_fn(range))
    }

    /// Reads a round that [`Adaptation::write`] has written.
    fn read(from: &mut Reader) -> Result<Self, Damaged> {
        let (mean, [visits, steps]) = (from.take()?..from.take()?, from.take()?);
        let [before, to, counts]: [PerBlock<u32>; 3] = from.take()?;
        let grows = before
            .iter()
            .zip(&counts)
            .zip(&to)
            .all(|((from, now), to)| from <= now && now <= to);
        Damaged::unless(grows && !mean.is_empty() && (1..=visits).contains(&steps) && visits as usize <= mean.len())?;
        Ok(Self {
            mean,
            visits,
            steps,
            from: before,
            to,
            counts,
        })
    }

    /// Records that a visit is done.
    pub fn advance(&mut self, visited: &PerBlock<Range<u32>>) {
        self.counts = std::array::from_fn(|block| visited[block].end);
    }
}

/// The first power of two above a number of samples.
fn next_power(samples: u32) -> u32 {
    samples
        .saturating_add(1)
        .checked_next_power_of_two()
        .unwrap_or(u32::MAX)
}

/// The adaptive part of a job.
pub(super) struct Adaptation {
    noise: NoiseMap,
    /// The last round of each tile whose blocks have different numbers of samples.
    rounds: Vec<Option<Box<TileRound>>>,
}

impl Adaptation {
    pub fn new(tiles: &[Tile], width: u32) -> Self {
        Self {
            noise: NoiseMap::new(tiles, width),
            rounds: vec![None; tiles.len()],
        }
    }

    /// Whether the blocks of one of these tiles have different numbers of samples.
    pub fn has_differences(&self, tiles: &[usize]) -> bool {
        tiles.iter().any(|&index| self.rounds[index].is_some())
    }

    /// Records samples of a tile that were added to the film.
    pub fn note(&mut self, index: usize, samples: &TileSamples, film: &Film) {
        if let (Some(blocks), Some(round)) = (&samples.blocks, &mut self.rounds[index]) {
            round.advance(blocks);
            self.noise.note(index, film);
        }
    }

    /// The samples that a tile with `done` of them will reach: those at the end of its round, if it is in one.
    pub fn on_the_way_to(&self, index: usize, done: u32) -> u32 {
        let round = self.rounds[index].as_ref().filter(|round| round.covers(done));
        round.map_or(done, |round| round.mean.end)
    }

    /// Plans a round for the tiles at `active`, from their samples of the mean pixel in `done`, by tile, to `end`. With
    /// `is_adaptive` the samples of their blocks follow the noise around them; otherwise existing differences are kept.
    pub fn plan(&mut self, active: &[usize], done: &[u32], end: u32, is_adaptive: bool, film: &Film) {
        if is_adaptive {
            let may_begin = |index: &&usize| done[**index] > 0 && self.rounds[**index].is_none();
            for &index in active.iter().filter(may_begin) {
                self.noise.begin(index, film);
            }
        }
        let counts_of = |&index: &usize| {
            let round = self.rounds[index].as_ref();
            round.map_or([done[index]; _], |round| round.counts)
        };
        let counts: Vec<PerBlock<u32>> = active.iter().map(counts_of).collect();
        let begin = active.first().map_or(0, |&index| done[index]);
        let ends = match is_adaptive {
            true if begin < end => self.noise.allocate(active, &counts, begin, end),
            _ => None,
        };
        for (place, &index) in active.iter().enumerate() {
            let begin = done[index];
            let round = self.rounds[index].as_ref();
            if begin >= end || round.is_some_and(|round| round.covers(begin)) {
                continue;
            }
            let ends = match &ends {
                Some(ends) => ends[place],
                None if round.is_some() => counts[place].map(|count| count.saturating_add(end - begin)),
                None => continue,
            };
            self.rounds[index] = Some(Box::new(TileRound::new(begin..end, counts[place], ends)));
        }
    }

    /// The rounds of all tiles.
    pub fn rounds(&self) -> &[Option<Box<TileRound>>] {
        &self.rounds
    }

    /// Writes the noise and the rounds.
    pub fn write(&self, to: &mut Writer) {
        self.noise.write(to);
        for round in &self.rounds {
            to.put(u32::from(round.is_some()));
            if let Some(round) = round {
                to.put([round.mean.start, round.mean.end, round.visits, round.steps]);
                to.put([round.from, round.to, round.counts]);
            }
        }
    }

    /// Reads the noise and the rounds that [`Self::write`] has written for the same picture.
    pub fn read(&mut self, from: &mut Reader) -> Result<(), Damaged> {
        self.noise.read(from)?;
        for round in &mut self.rounds {
            *round = match from.flag()? {
                true => Some(Box::new(TileRound::read(from)?)),
                false => None,
            };
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The samples of a block after each visit.
    fn visited(mut round: TileRound, block: usize) -> Vec<u32> {
        let (mut done, mut seen) = (round.mean.start, vec![round.counts[block]]);
        while round.covers(done) {
            let (end, visited) = round.visit(done);
            let goes_on = visited
                .iter()
                .zip(round.counts)
                .all(|(range, count)| range.start == count);
            assert!(end > done && goes_on);
            round.advance(&visited);
            seen.push(round.counts[block]);
            done = end;
        }
        assert_eq!((done, round.counts), (round.mean.end, round.to));
        seen
    }

    #[test]
    fn visits_bring_every_block_to_its_end_and_stop_at_powers_of_two() {
        let rounds = [
            (64, 128),
            (16, 32),
            (16, 18),
            (64, 72),
            (100, 200),
            (256, 300),
            (30, 33),
            (99, 100),
        ];
        for (begin, end) in rounds {
            let [mut from, mut to] = [[begin; _]; 2];
            let random = |block: usize| crate::sampling::hash::pcg3d([block as u32, begin, end]);
            for (block, (from, to)) in from.iter_mut().zip(&mut to).enumerate() {
                let [a, b, _] = random(block);
                *from = begin / 4 + a % begin;
                *to = *from + (b % 8) * end / 2;
            }
            let round = TileRound::new(begin..end, from, to);
            for (block, &end_of_block) in to.iter().enumerate() {
                let seen = visited(round.clone(), block);
                let (first, last) = (seen[0], seen[seen.len() - 1]);
                let powers = (0..20)
                    .map(|power| 1 << power)
                    .filter(|power| (first..last).contains(power));
                powers.for_each(|power| assert!(seen.contains(&power), "{begin} to {end}: {power} in {seen:?}"));
                // Only short rounds end early.
                assert!(last == end_of_block || end - begin < 6, "{last} of {end_of_block}");
            }
        }
    }

    #[test]
    fn every_block_has_its_first_sample_after_the_first_visit() {
        let mut to = [4; _];
        to[3] = 100;
        let round = TileRound::new(0..16, [0; _], to);
        let (_, visited) = round.visit(0);
        assert!(visited.iter().all(|range| range.contains(&0)), "{visited:?}");
    }

    #[test]
    fn a_round_without_samples_is_a_visit() {
        let round = TileRound::new(100..200, [100; _], [100; _]);
        let (end, visited) = round.visit(100);
        assert!(end == 200 && visited.iter().all(Range::is_empty));
    }
}
