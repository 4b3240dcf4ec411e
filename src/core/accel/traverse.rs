//! Traverses a [`Bvh`], nearest child first. The caller tests the primitives of a leaf.

use std::ops::{AddAssign, Range};

use arrayvec::{ArrayVec, CapacityError};
use wide::f32x8;

use super::build::MAX_DEPTH;
use super::bvh::Bvh;
use super::node::{Child, Node, RaySlabs, WIDTH, padded};
use super::order::{far_to_near, met_first, nearest};
use crate::math::Ray;

/// The work of a traversal: the numbers of boxes and primitives that were tested.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TraversalStats {
    /// Boxes that were tested.
    pub boxes: u32,
    /// Primitives that were tested.
    pub primitives: u32,
}

impl TraversalStats {
    /// The number of all tests.
    pub fn total(&self) -> u32 {
        self.boxes + self.primitives
    }
}

impl AddAssign for TraversalStats {
    fn add_assign(&mut self, other: Self) {
        self.boxes += other.boxes;
        self.primitives += other.primitives;
    }
}

/// Stack entries for the deepest hierarchy: every node on a path down leaves at most all but one of its children on the
/// stack. The last one pushes all its slots before those that are not met are dropped.
pub(super) const STACK: usize = MAX_DEPTH * (WIDTH - 1) + WIDTH;

/// Pushes the children that are met, the nearest on top. An entry has the bits of the entry distance above those of the
/// child. Fails without a change if less than [`WIDTH`] places are free.
#[inline(always)]
pub(super) fn push_sorted<const ROOM: usize>(
    node: &Node,
    enter: f32x8,
    met: f32x8,
    stack: &mut ArrayVec<u64, ROOM>,
) -> Result<(), CapacityError> {
    push_far_to_near(enter, met, node.children, stack)
}

/// [`push_sorted`] for children that need not be a node's.
#[inline(always)]
pub(super) fn push_far_to_near<const ROOM: usize>(
    enter: f32x8,
    met: f32x8,
    children: [Child; WIDTH],
    stack: &mut ArrayVec<u64, ROOM>,
) -> Result<(), CapacityError> {
    let sorted = far_to_near(enter, met, children.each_ref().map(|child| child.0));
    let height = stack.len() + met.to_bitmask().count_ones() as usize;
    let pushed: [u64; WIDTH] =
        std::array::from_fn(|lane| u64::from(sorted.entries[lane].to_bits()) << 32 | u64::from(sorted.children[lane]));
    stack.try_extend_from_slice(&pushed)?;
    stack.truncate(height);
    Ok(())
}

/// [`push_sorted`] without sorting and with distances of zero, for traversals that look for any hit.
#[inline(always)]
pub(super) fn push_unsorted<const ROOM: usize>(
    node: &Node,
    met: f32x8,
    stack: &mut ArrayVec<u64, ROOM>,
) -> Result<(), CapacityError> {
    let mask = met.to_bitmask();
    let height = stack.len() + mask.count_ones() as usize;
    let pushed: [u64; WIDTH] = met_first(mask, node.children.each_ref().map(|child| child.0)).map(u64::from);
    stack.try_extend_from_slice(&pushed)?;
    stack.truncate(height);
    Ok(())
}

impl Bvh {
    /// Visits every leaf that may hold a hit, roughly from near to far. `leaf` gets a range of [`Bvh::order`] and
    /// t_max, which it lowers to its nearest hit. With `COUNT` the work is added to `stats` (the primitives of a
    /// visited leaf are counted as tested once each).
    #[inline(always)]
    pub fn closest<const COUNT: bool>(
        &self,
        ray: &Ray,
        stats: &mut TraversalStats,
        mut leaf: impl FnMut(Range<usize>, &mut f32),
    ) {
        let leaf = |range, t_max: &mut f32| {
            leaf(range, t_max);
            false
        };
        self.walk::<false, COUNT, false>(ray, stats, leaf, |_| ());
    }

    /// [`Bvh::closest`] for primitives that are in no cache: a leaf is passed to `prefetch` at once, but to `leaf` only
    /// when the next leaf has been found. In between the traversal may visit nodes behind a hit.
    #[inline(always)]
    pub(super) fn closest_prefetching<const COUNT: bool>(
        &self,
        ray: &Ray,
        stats: &mut TraversalStats,
        mut leaf: impl FnMut(Range<usize>, &mut f32),
        prefetch: impl Fn(&Range<usize>),
    ) {
        let leaf = |range, t_max: &mut f32| {
            leaf(range, t_max);
            false
        };
        self.walk::<false, COUNT, true>(ray, stats, leaf, prefetch);
    }

    /// Visits leaves until `leaf` returns true, and returns whether it did.
    #[inline(always)]
    pub fn any(&self, ray: &Ray, mut leaf: impl FnMut(Range<usize>) -> bool) -> bool {
        self.walk::<true, false, false>(ray, &mut TraversalStats::default(), |range, _| leaf(range), |_| ())
    }

    /// [`Bvh::any`] for primitives that are in no cache, see [`Bvh::closest_prefetching`].
    #[inline(always)]
    pub(super) fn any_prefetching(
        &self,
        ray: &Ray,
        mut leaf: impl FnMut(Range<usize>) -> bool,
        prefetch: impl Fn(&Range<usize>),
    ) -> bool {
        self.walk::<true, false, true>(ray, &mut TraversalStats::default(), |range, _| leaf(range), prefetch)
    }

    #[inline(always)]
    fn walk<const ANY: bool, const COUNT: bool, const PREFETCH: bool>(
        &self,
        ray: &Ray,
        stats: &mut TraversalStats,
        mut leaf: impl FnMut(Range<usize>, &mut f32) -> bool,
        prefetch: impl Fn(&Range<usize>),
    ) -> bool {
        let Some(slabs) = RaySlabs::new(ray) else {
            return false;
        };
        let mut t_max = ray.t_max;
        // The children still to be visited, and the distances at which the ray enters them.
        let mut stack = ArrayVec::<u64, STACK>::new();
        // The leaf that is being prefetched.
        let mut pending: Option<Range<usize>> = None;
        let mut current = 0;
        loop {
            let node = &self.nodes[current];
            if COUNT {
                stats.boxes += node.slots_used() as u32;
            }
            let (enter, met) = node.entries(&slabs, padded(t_max));
            let mut next = go_down::<ANY>(node, enter, met, &mut stack);
            current = loop {
                let child = next.take().or_else(|| go_back(&mut stack, padded(t_max)));
                let Some(child) = child else {
                    return pending.is_some_and(|range| leaf(range, &mut t_max) && ANY);
                };
                if !child.is_leaf() {
                    break child.index();
                }
                let range = self.leaf_range(child);
                if COUNT {
                    stats.primitives += range.len() as u32;
                }
                let due = if PREFETCH {
                    prefetch(&range);
                    pending.replace(range)
                } else {
                    Some(range)
                };
                if due.is_some_and(|range| leaf(range, &mut t_max) && ANY) {
                    return true;
                }
            };
        }
    }
}

/// The next child to visit: the nearest one, or with `ANY` any that is met. The others are pushed.
#[inline(always)]
fn go_down<const ANY: bool>(node: &Node, enter: f32x8, met: f32x8, stack: &mut ArrayVec<u64, STACK>) -> Option<Child> {
    let mut others = met.to_bitmask();
    if others == 0 {
        return None;
    }
    if !ANY {
        // Finding the nearest child does not wait for the sort.
        let next = node.children[nearest(enter, met)];
        // The stack is deep enough by construction.
        let _ = push_sorted(node, enter, met, stack);
        stack.pop();
        return Some(next);
    }
    let next = node.children[others.trailing_zeros() as usize % WIDTH];
    others &= others - 1;
    while others != 0 {
        stack.push(u64::from(node.children[others.trailing_zeros() as usize % WIDTH].0));
        others &= others - 1;
    }
    Some(next)
}

/// Pops the next child that is entered within `t_limit`.
#[inline(always)]
fn go_back(stack: &mut ArrayVec<u64, STACK>, t_limit: f32) -> Option<Child> {
    while let Some(top) = stack.pop() {
        if f32::from_bits((top >> 32) as u32) <= t_limit {
            return Some(Child(top as u32));
        }
    }
    None
}
