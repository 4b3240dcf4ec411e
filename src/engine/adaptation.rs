//! The adaptive part of a job: what is known of its noise, and the rounds in which the blocks of a tile get different numbers of samples. What they are and why pictures
//! stay unbiased: [`crate::render::adaptive`].

use std::ops::Range;

use crate::render::adaptive::NoiseMap;
use crate::render::blocks::PerBlock;
use crate::render::bytes::{Damaged, Reader, Writer};
use crate::render::film::Film;
use crate::render::tile::{Tile, TileSamples};

/// The mean samples of a visit to a tile.
const VISIT: u32 = 16;

/// A round of a tile whose blocks differ in their samples: so many visits, each of which brings every block on by its share.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct TileRound {
    /// The samples of the mean pixel before and after the round.
    mean: Range<u32>,
    visits: u32,
    from: PerBlock<u32>,
    to: PerBlock<u32>,
    /// The present numbers.
    counts: PerBlock<u32>,
}

impl TileRound {
    pub fn new(mean: Range<u32>, from: PerBlock<u32>, to: PerBlock<u32>) -> Self {
        let blocks = || from.iter().zip(&to);
        let all: u64 = blocks().map(|(from, to)| u64::from(to - from)).sum();
        let visits = all.div_ceil(from.len() as u64).div_ceil(VISIT.into()) as u32;
        // At each power of two there is an end of a visit, so that halves can be compared.
        let doublings = |(from, to): (&u32, &u32)| to.max(&1).ilog2() - from.max(&1).ilog2() + 1;
        let doublings = blocks().map(doublings).max().unwrap_or(1);
        let most = mean.len() as u32;
        Self {
            mean,
            visits: visits.max(doublings).clamp(1, most.max(1)),
            from,
            to,
            counts: from,
        }
    }

    /// Whether the mean pixel has so many samples within the round.
    pub fn covers(&self, done: u32) -> bool {
        self.mean.contains(&done)
    }

    /// The mean samples after the visit that begins with `done` of them, and the samples of each block.
    pub fn visit(&self, done: u32) -> (u32, PerBlock<Range<u32>>) {
        let (length, visits) = (self.mean.len() as u64, u64::from(self.visits));
        let next = (u64::from(done - self.mean.start) * visits).div_ceil(length) + 1;
        let end = self.mean.start + (length * next / visits) as u32;
        let range = |block: usize| {
            let (from, to, count) = (self.from[block], self.to[block], self.counts[block]);
            let wanted = from + (u64::from(to - from) * next / visits) as u32;
            let end = match next == visits {
                true => to,
                false => wanted.min(count.saturating_add(1).next_power_of_two()),
            };
            // The first visit of a picture gives every block its first sample, which tells what is there.
            let least = if count == 0 { to.min(1) } else { count };
            count..end.max(least)
        };
        (end, std::array::from_fn(range))
    }

    /// What [`Adaptation::write`] has written of a round.
    fn read(from: &mut Reader) -> Result<Self, Damaged> {
        let (mean, visits) = (from.u32()?..from.u32()?, from.u32()?);
        let mut blocks: [PerBlock<u32>; 3] = [[0; _]; 3];
        for number in blocks.iter_mut().flatten() {
            *number = from.u32()?;
        }
        let [before, to, counts] = blocks;
        let grows = before
            .iter()
            .zip(&counts)
            .zip(&to)
            .all(|((from, now), to)| from <= now && now <= to);
        match grows && !mean.is_empty() && visits > 0 {
            true => Ok(Self {
                mean,
                visits,
                from: before,
                to,
                counts,
            }),
            false => Err(Damaged),
        }
    }

    /// Takes note of a visit.
    pub fn advance(&mut self, visited: &PerBlock<Range<u32>>) {
        self.counts = std::array::from_fn(|block| visited[block].end);
    }
}

/// The adaptive part of a job.
pub(super) struct Adaptation {
    noise: NoiseMap,
    /// The last round of each tile whose blocks differ in their samples.
    rounds: Vec<Option<TileRound>>,
}

impl Adaptation {
    pub fn new(tiles: &[Tile], width: u32) -> Self {
        Self {
            noise: NoiseMap::new(tiles, width),
            rounds: vec![None; tiles.len()],
        }
    }

    /// Whether the blocks of one of these tiles differ in their samples.
    pub fn has_differences(&self, tiles: &[usize]) -> bool {
        tiles.iter().any(|&index| self.rounds[index].is_some())
    }

    /// Takes note of samples of a tile that were added to the film.
    pub fn note(&mut self, index: usize, samples: &TileSamples, film: &Film) {
        let counts = match (&samples.blocks, &mut self.rounds[index]) {
            (Some(blocks), Some(round)) => {
                round.advance(blocks);
                round.counts
            }
            _ => [samples.samples.end; _],
        };
        self.noise.note(index, &counts, film);
    }

    /// The samples that a tile with `done` of them is on its way to: those at the end of its round, if it is in one.
    pub fn on_the_way_to(&self, index: usize, done: u32) -> u32 {
        let round = self.rounds[index].as_ref().filter(|round| round.covers(done));
        round.map_or(done, |round| round.mean.end)
    }

    /// Plans a round: the tiles at `active` have so many samples of the mean pixel, by tile in `done`, and get `end`. With `is_adaptive` their blocks
    /// differ as their neighbours say, and else they keep the differences that they have.
    pub fn plan(&mut self, active: &[usize], done: &[u32], end: u32, is_adaptive: bool) {
        let counts_of = |index: usize| {
            self.rounds[index]
                .as_ref()
                .map_or([done[index]; _], |round| round.counts)
        };
        let counts: Vec<PerBlock<u32>> = (0..done.len()).map(counts_of).collect();
        let begin = active.first().map_or(0, |&index| done[index]);
        let ends = match is_adaptive {
            true => self.noise.allocate(active, &counts, begin, end),
            false => None,
        };
        for (place, &index) in active.iter().enumerate() {
            let begin = done[index];
            let round = self.rounds[index].as_ref();
            if begin >= end || round.is_some_and(|round| round.covers(begin)) {
                continue;
            }
            let ends = match &ends {
                Some(ends) => ends[place],
                None if round.is_some() => counts[index].map(|count| count.saturating_add(end - begin)),
                None => continue,
            };
            self.rounds[index] = Some(TileRound::new(begin..end, counts[index], ends));
        }
    }

    /// The rounds of all tiles.
    pub fn rounds(&self) -> &[Option<TileRound>] {
        &self.rounds
    }

    /// Writes what has been found and planned.
    pub fn write(&self, to: &mut Writer) {
        self.noise.write(to);
        for round in &self.rounds {
            to.u32(u32::from(round.is_some()));
            if let Some(round) = round {
                let numbers = [round.mean.start, round.mean.end, round.visits];
                let blocks = [round.from, round.to, round.counts].into_iter().flatten();
                numbers.into_iter().chain(blocks).for_each(|number| to.u32(number));
            }
        }
    }

    /// Takes up what [`Self::write`] has written of the same picture.
    pub fn read(&mut self, from: &mut Reader) -> Result<(), Damaged> {
        self.noise.read(from)?;
        for round in &mut self.rounds {
            *round = match from.flag()? {
                true => Some(TileRound::read(from)?),
                false => None,
            };
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn visits_bring_every_block_to_its_end_and_stop_at_powers_of_two() {
        let mut to = [64; _];
        (to[1], to[2], to[3]) = (512, 96, 1024);
        let mut round = TileRound::new(64..128, [64; _], to);
        let (mut done, mut seen) = (64, vec![64]);
        while round.covers(done) {
            let (end, visited) = round.visit(done);
            assert!(
                end > done
                    && visited
                        .iter()
                        .zip(round.counts)
                        .all(|(range, count)| range.start == count)
            );
            round.advance(&visited);
            seen.push(round.counts[3]);
            done = end;
        }
        assert_eq!((done, round.counts), (128, to));
        assert!([128, 256, 512].iter().all(|power| seen.contains(power)), "{seen:?}");
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
