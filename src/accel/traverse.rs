//! The walk through a [`Bvh`], nearest child first; what a leaf holds is the caller's business.

use std::ops::{AddAssign, Range};

use super::build::MAX_DEPTH;
use super::bvh::Bvh;
use super::node::{RaySlabs, WIDTH};
use crate::math::Ray;

/// The work of a traversal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Steps {
    pub boxes: u32,
    pub primitives: u32,
}

impl Steps {
    pub fn total(&self) -> u32 {
        self.boxes + self.primitives
    }
}

impl AddAssign for Steps {
    fn add_assign(&mut self, other: Self) {
        self.boxes += other.boxes;
        self.primitives += other.primitives;
    }
}

/// Stack entries for a hierarchy of some depth: every node on the way down leaves at most all but one of its children behind.
const fn stack_for(depth: usize) -> usize {
    depth * (WIDTH - 1) + 1
}

/// Clearing the stack for the deepest hierarchy would cost a tenth of a ray; most are shallower than this.
const SHALLOW: usize = 9;

/// A child waiting on the stack: its entry distance above its place (node index and slot), so that keys sort by distance.
fn key(entry: f32, node: usize, slot: usize) -> u64 {
    u64::from(entry.to_bits()) << 32 | (node * WIDTH + slot) as u64
}

fn entry_of(key: u64) -> f32 {
    f32::from_bits((key >> 32) as u32)
}

fn place_of(key: u64) -> (usize, usize) {
    let place = key as u32 as usize;
    (place / WIDTH, place % WIDTH)
}

impl Bvh {
    /// Visits every leaf that may hold a hit, roughly from near to far. `leaf` gets a range of [`Bvh::order`] and the distance within
    /// which a hit counts, and lowers that to its nearest hit. With `COUNT` its work is added to `steps` (the primitives of a visited
    /// leaf are counted as tested once each).
    #[inline(always)]
    pub fn closest<const COUNT: bool>(
        &self,
        ray: &Ray,
        steps: &mut Steps,
        mut leaf: impl FnMut(Range<usize>, &mut f32),
    ) {
        self.walk::<false, COUNT>(ray, steps, |range, t_max| {
            leaf(range, t_max);
            false
        });
    }

    /// Visits leaves until `leaf` returns true; that is the result.
    #[inline(always)]
    pub fn any(&self, ray: &Ray, mut leaf: impl FnMut(Range<usize>) -> bool) -> bool {
        self.walk::<true, false>(ray, &mut Steps::default(), |range, _| leaf(range))
    }

    #[inline(always)]
    fn walk<const ANY: bool, const COUNT: bool>(
        &self,
        ray: &Ray,
        steps: &mut Steps,
        leaf: impl FnMut(Range<usize>, &mut f32) -> bool,
    ) -> bool {
        if self.depth <= SHALLOW {
            self.walk_with_stack::<ANY, COUNT, { stack_for(SHALLOW) }>(ray, steps, leaf)
        } else {
            self.walk_with_stack::<ANY, COUNT, { stack_for(MAX_DEPTH) }>(ray, steps, leaf)
        }
    }

    #[inline(always)]
    fn walk_with_stack<const ANY: bool, const COUNT: bool, const STACK: usize>(
        &self,
        ray: &Ray,
        steps: &mut Steps,
        mut leaf: impl FnMut(Range<usize>, &mut f32) -> bool,
    ) -> bool {
        let Some(slabs) = RaySlabs::new(ray) else {
            return false;
        };
        let mut t_max = ray.t_max;
        let mut stack = [0u64; STACK];
        let mut height = 0;
        let mut current = 0;
        loop {
            let node = &self.nodes[current];
            if COUNT {
                steps.boxes += node.slots_used() as u32;
            }
            let (entries, mut hits) = node.entries(&slabs, t_max);
            let base = height;
            while hits != 0 {
                let slot = hits.trailing_zeros() as usize % WIDTH;
                hits &= hits - 1;
                let new = key(entries[slot], current, slot);
                // The nearest goes on top.
                let mut at = height;
                while !ANY && at > base && stack[at - 1] < new {
                    stack[at] = stack[at - 1];
                    at -= 1;
                }
                stack[at] = new;
                height += 1;
            }
            current = loop {
                if height == 0 {
                    return false;
                }
                height -= 1;
                let top = stack[height];
                if !ANY && entry_of(top) > t_max {
                    continue;
                }
                let (parent, slot) = place_of(top);
                let parent = &self.nodes[parent];
                let (child, count) = (parent.child[slot] as usize, parent.count[slot] as usize);
                if count == 0 {
                    break child;
                }
                if COUNT {
                    steps.primitives += count as u32;
                }
                if leaf(child..child + count, &mut t_max) && ANY {
                    return true;
                }
            };
        }
    }
}
