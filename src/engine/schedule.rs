//! The order of work: which tile comes first, and how many samples each visit to a tile adds.
//!
//! The samples of a tile are always divided at the same numbers (see [`crate::render::passes`]), on any thread, with
//! any number of interruptions: floating-point sums depend on their grouping, and equal seeds shall give equal bits.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bevy::math::{Rect, UVec2};

use super::adaptation::TileRound;
use crate::render::noise::blocks::PerBlock;
use crate::render::noise::replicas::Missing;
use crate::render::passes::pass_end;
use crate::render::tile::Tile;

/// Sorts tiles from the centre of the picture outwards, because users look there.
pub(super) fn sort_from_center(tiles: &mut [Tile], width: u32, height: u32) {
    tiles.sort_by_key(|tile| {
        // Twice the distance from the middle is a whole number.
        let dx = i64::from(2 * tile.x + tile.width) - i64::from(width);
        let dy = i64::from(2 * tile.y + tile.height) - i64::from(height);
        dx * dx + dy * dy
    });
}

/// The indices in `tiles` of the tiles that `region` touches, by fractions of the picture; all of them if there is no
/// region, or none in it.
pub(super) fn tiles_in(region: Option<Rect>, tiles: &[Tile], size: UVec2) -> Vec<usize> {
    let touches = |tile: &Tile, region: Rect| {
        let (min, max) = (region.min * size.as_vec2(), region.max * size.as_vec2());
        let (left, top) = (tile.x as f32, tile.y as f32);
        let (right, bottom) = ((tile.x + tile.width) as f32, (tile.y + tile.height) as f32);
        min.x < right && min.y < bottom && max.x > left && max.y > top
    };
    let all = 0..tiles.len();
    let inside: Vec<usize> = match region {
        Some(region) => all.clone().filter(|&index| touches(&tiles[index], region)).collect(),
        None => Vec::new(),
    };
    if inside.is_empty() { all.collect() } else { inside }
}

/// One visit to a tile; `index` is the tile's index in the job's list.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum WorkItem {
    /// The G-buffer of a tile.
    GBuffer {
        index: usize,
    },
    Preview {
        index: usize,
        step: u32,
    },
    /// Samples of some replicas.
    Replicas(Arc<[Missing]>),
    /// Samples of all pixels, or a range of its own for each block.
    Samples {
        index: usize,
        samples: Range<u32>,
        blocks: Option<Arc<PerBlock<Range<u32>>>>,
    },
}

/// The number of replicas in a work item.
const REPLICAS_AT_ONCE: usize = 16;

/// The samples that urgent tiles get before all others.
const HEAD_START: u32 = 4;

/// The rank of a tile: urgent tiles come first, then those with fewer samples, then by their order.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Turn {
    is_late: bool,
    done: u32,
    index: usize,
}

/// Hands out a job's work, pass after pass. Each worker claims its next item, so that none is idle while there is work.
pub(super) struct WorkQueue {
    state: Mutex<QueueState>,
}

struct QueueState {
    /// The greatest number of samples that a tile has or is being given.
    begun: u32,
    /// The tiles of the G-buffer that are not claimed yet, the next one last.
    gbuffer: Vec<usize>,
    /// The tiles of the preview that are not claimed yet, the next one last.
    previews: Vec<usize>,
    /// The edge of preview blocks in pixels.
    step: u32,
    /// The tiles that are not claimed in this pass yet.
    waiting: BinaryHeap<Reverse<Turn>>,
    /// The tiles that have a head start, ascending.
    urgent: Vec<usize>,
    target: u32,
    /// The replicas that are not claimed yet, the next ones last.
    replicas: Vec<Arc<[Missing]>>,
    /// The rounds of tiles whose blocks differ.
    rounds: BTreeMap<usize, Box<TileRound>>,
}

impl WorkQueue {
    /// A queue of work. `tiles` has the index of each tile to be rendered and its samples so far, `target` is the
    /// number of samples to reach, and `previews` are the tiles with a coarse preview, in blocks of `step` pixels.
    pub fn new(tiles: &[(usize, u32)], target: u32, previews: &[usize], step: u32) -> Self {
        Self {
            state: Mutex::new(QueueState {
                begun: tiles.iter().map(|&(_, done)| done).max().unwrap_or(0),
                step,
                gbuffer: Vec::new(),
                previews: previews.iter().rev().copied().collect(),
                waiting: tiles
                    .iter()
                    .map(|&(index, done)| Reverse(turn(&[], index, done)))
                    .collect(),
                urgent: Vec::new(),
                target,
                replicas: Vec::new(),
                rounds: BTreeMap::new(),
            }),
        }
    }

    /// A queue of the missing samples of replicas.
    pub fn of_replicas(missing: &[Missing]) -> Self {
        let queue = Self::new(&[], 0, &[], 1);
        let pieces = missing.chunks(REPLICAS_AT_ONCE).rev();
        queue.state().replicas = pieces.map(Arc::from).collect();
        queue
    }

    /// Adds the G-buffers of these tiles before all samples, alternating with the previews.
    pub fn begin_with_gbuffer(&self, tiles: impl DoubleEndedIterator<Item = usize>) {
        self.state().gbuffer = tiles.rev().collect();
    }

    /// Gives these tiles, in ascending order, their first samples before all others.
    pub fn set_urgent(&self, urgent: Vec<usize>) {
        self.state().set_urgent(urgent);
    }

    /// Sets the rounds of tiles whose blocks get different numbers of samples.
    pub fn set_rounds(&self, rounds: impl Iterator<Item = (usize, Box<TileRound>)>) {
        self.state().rounds = rounds.collect();
    }

    /// The next work item; None when all work up to the target has been claimed.
    pub fn claim(&self) -> Option<WorkItem> {
        let mut state = self.state();
        if state.gbuffer.len() >= state.previews.len()
            && let Some(index) = state.gbuffer.pop()
        {
            return Some(WorkItem::GBuffer { index });
        }
        if let Some(index) = state.previews.pop() {
            return Some(WorkItem::Preview {
                index,
                step: state.step,
            });
        }
        if let Some(replicas) = state.replicas.pop() {
            return Some(WorkItem::Replicas(replicas));
        }
        let Turn { done, index, .. } = state.next_turn()?;
        let target = state.target;
        let round = state.rounds.get_mut(&index).filter(|round| round.covers(done));
        let (end, blocks) = match round {
            // Such a visit is not divided.
            Some(round) => {
                let (end, blocks) = round.visit(done);
                round.advance(&blocks);
                (end, Some(Arc::new(blocks)))
            }
            None => (pass_end(done).min(target), None),
        };
        state.waiting.pop();
        let next = turn(&state.urgent, index, end);
        state.waiting.push(Reverse(next));
        state.begun = state.begun.max(end);
        Some(WorkItem::Samples {
            index,
            samples: done..end,
            blocks,
        })
    }

    /// Sets the target of later claims.
    pub fn set_target(&self, target: u32) {
        self.state().target = target;
    }

    /// Lowers the target to the end of the current pass, so that all tiles end with equal samples. Returns that target.
    pub fn finish_pass(&self) -> u32 {
        let mut state = self.state();
        state.target = state.target.min(state.begun);
        state.target
    }

    fn state(&self) -> MutexGuard<'_, QueueState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl QueueState {
    /// The next tile that is not at the target.
    fn next_turn(&mut self) -> Option<Turn> {
        let Reverse(next) = *self.waiting.peek()?;
        if next.done >= self.target && !next.is_late {
            // The urgent tiles have reached the target; the others go on.
            self.set_urgent(Vec::new());
            return self.next_turn();
        }
        (next.done < self.target).then_some(next)
    }

    fn set_urgent(&mut self, urgent: Vec<usize>) {
        if self.urgent != urgent {
            let waiting = std::mem::take(&mut self.waiting).into_iter();
            let turns = waiting.map(|Reverse(old)| Reverse(turn(&urgent, old.index, old.done)));
            (self.waiting, self.urgent) = (turns.collect(), urgent);
        }
    }
}

fn turn(urgent: &[usize], index: usize, done: u32) -> Turn {
    let is_late = done >= HEAD_START || urgent.binary_search(&index).is_err();
    Turn { is_late, done, index }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(queue: &WorkQueue) -> Vec<(usize, u32, u32)> {
        std::iter::from_fn(|| queue.claim())
            .map(|item| match item {
                WorkItem::Preview { index, .. } => (index, 0, 0),
                WorkItem::Samples { index, samples, .. } => (index, samples.start, samples.end),
                WorkItem::GBuffer { .. } | WorkItem::Replicas(_) => unreachable!("none was asked for"),
            })
            .collect()
    }

    #[test]
    fn every_tile_has_its_turn_in_every_pass() {
        let queue = WorkQueue::new(&[(0, 0), (1, 0)], 3, &[0, 1], 4);
        let expected = [
            (0, 0, 0),
            (1, 0, 0),
            (0, 0, 1),
            (1, 0, 1),
            (0, 1, 2),
            (1, 1, 2),
            (0, 2, 3),
            (1, 2, 3),
        ];
        assert_eq!(all(&queue), expected);
    }

    #[test]
    fn urgent_tiles_have_a_head_start() {
        let queue = WorkQueue::new(&[(0, 0), (1, 0), (2, 0)], 4, &[], 1);
        assert!(matches!(queue.claim(), Some(WorkItem::Samples { index: 0, .. })));
        queue.set_urgent(vec![2]);
        let expected = [
            (2, 0, 1),
            (2, 1, 2),
            (2, 2, 4),
            (1, 0, 1),
            (0, 1, 2),
            (1, 1, 2),
            (0, 2, 4),
            (1, 2, 4),
        ];
        assert_eq!(all(&queue), expected);
        let queue = WorkQueue::new(&[(0, 0), (1, 0)], 2, &[], 1);
        queue.set_urgent(vec![1]);
        assert_eq!(all(&queue), [(1, 0, 1), (1, 1, 2), (0, 0, 1), (0, 1, 2)]);
    }

    #[test]
    fn gbuffer_and_preview_of_a_tile_come_one_after_the_other() {
        let queue = WorkQueue::new(&[(0, 0), (1, 0)], 1, &[0, 1], 4);
        queue.begin_with_gbuffer([0, 1].into_iter());
        for index in [0, 1] {
            assert_eq!(queue.claim(), Some(WorkItem::GBuffer { index }));
            assert_eq!(queue.claim(), Some(WorkItem::Preview { index, step: 4 }));
        }
        let queue = WorkQueue::new(&[(0, 0)], 1, &[], 1);
        queue.begin_with_gbuffer([0].into_iter());
        assert_eq!(queue.claim(), Some(WorkItem::GBuffer { index: 0 }));
        assert!(matches!(queue.claim(), Some(WorkItem::Samples { index: 0, .. })));
    }

    #[test]
    fn what_was_interrupted_or_raised_goes_on_at_the_same_places() {
        let queue = WorkQueue::new(&[(0, 4), (1, 2), (2, 8)], 8, &[], 1);
        assert_eq!(all(&queue), [(1, 2, 4), (0, 4, 8), (1, 4, 8)]);
        queue.set_target(10);
        assert_eq!(all(&queue), [(0, 8, 10), (1, 8, 10), (2, 8, 10)]);
        queue.set_target(40);
        assert_eq!(all(&queue)[..4], [(0, 10, 16), (1, 10, 16), (2, 10, 16), (0, 16, 32)]);
    }

    #[test]
    fn a_begun_pass_is_finished() {
        let queue = WorkQueue::new(&[(0, 0), (1, 0), (2, 0)], 1000, &[], 1);
        (0..4).for_each(|_| assert!(queue.claim().is_some()));
        assert_eq!(queue.finish_pass(), 2);
        assert_eq!(all(&queue), [(1, 1, 2), (2, 1, 2)]);
    }

    #[test]
    fn a_region_is_all_tiles_that_it_touches() {
        let tiles = crate::render::tile::tiles(96, 64);
        let within = |x0, y0, x1, y1| tiles_in(Some(Rect::new(x0, y0, x1, y1)), &tiles, UVec2::new(96, 64));
        assert_eq!(within(0.0, 0.0, 0.3, 0.4), [0]);
        assert_eq!(within(0.3, 0.4, 0.4, 0.6), [0, 1, 3, 4]);
        assert_eq!(within(0.5, 0.6, 0.5, 0.6), [4]);
        assert_eq!(within(-9.0, 0.6, 9.0, 0.7), [3, 4, 5]);
        let everything: Vec<usize> = (0..6).collect();
        assert_eq!(within(1.5, 0.0, 2.0, 1.0), everything);
        assert_eq!(tiles_in(None, &tiles, UVec2::new(96, 64)), everything);
        let queue = WorkQueue::new(&[(3, 0), (5, 1)], 2, &[3, 5], 4);
        assert_eq!(all(&queue), [(3, 0, 0), (5, 0, 0), (3, 0, 1), (3, 1, 2), (5, 1, 2)]);
    }

    #[test]
    fn the_middle_comes_first() {
        let mut tiles = crate::render::tile::tiles(96, 96);
        sort_from_center(&mut tiles, 96, 96);
        assert_eq!((tiles[0].x, tiles[0].y), (32, 32));
        assert!([0, 64].contains(&tiles[8].x) && [0, 64].contains(&tiles[8].y));
    }
}
