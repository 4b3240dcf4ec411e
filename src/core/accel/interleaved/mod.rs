//! Interleaved traversal: several rays take a step each in turn, so that a ray's memory is fetched while the others
//! work. A single ray spends most of its time on such waits in large scenes.
//!
//! Steps at inner nodes are taken together, then those at triangles, then those at shapes, so that branches are easy to
//! predict.

mod mesh;
mod scene;

use arrayvec::ArrayVec;

use super::node::{Child, Node, RaySlabs, padded};
use super::traverse::{push_sorted, push_unsorted};

/// The traversal of one ray.
trait Walk {
    /// The data that all walks share.
    type Context;

    /// Picks the next step.
    fn next_step(&mut self) -> Place;
    fn visit_node(&mut self, context: &Self::Context);
    fn visit_triangles(&mut self, context: &Self::Context);
    /// Takes a step at a shape or at the end of a space. Returns false if the traversal is over.
    fn visit_elsewhere(&mut self, context: &Self::Context) -> bool;
    /// Prefetches the memory of the next step.
    fn prefetch_node(&self, context: &Self::Context);
    fn prefetch_triangles(&self, context: &Self::Context);
}

/// Where a ray's next step is.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Place {
    Node,
    Triangles,
    /// A shape, or the end of the current space, from which the ray leaves it.
    Elsewhere,
    Nowhere,
}

/// Runs the walks in `active`, a bit each, to their ends. `N` is at most 32.
#[inline(always)]
fn take_turns<W: Walk, const N: usize>(walks: &mut ArrayVec<W, N>, context: &W::Context, active: u32) {
    const { assert!(N <= u32::BITS as usize) };
    let mut turns = Turns::default();
    for index in members::<N>(active) {
        turns.give(index, walks[index].next_step());
    }
    turns.prefetch(walks, context);
    while turns != Turns::default() {
        let now = std::mem::take(&mut turns);
        for index in members::<N>(now.at_nodes) {
            let walk = &mut walks[index];
            walk.visit_node(context);
            turns.give(index, walk.next_step());
        }
        let prefetched = turns;
        turns.prefetch(walks, context);
        for index in members::<N>(now.at_triangles) {
            let walk = &mut walks[index];
            walk.visit_triangles(context);
            turns.give(index, walk.next_step());
        }
        for index in members::<N>(now.elsewhere) {
            let walk = &mut walks[index];
            if walk.visit_elsewhere(context) {
                turns.give(index, walk.next_step());
            }
        }
        turns.without(prefetched).prefetch(walks, context);
    }
}

/// The rays that have not finished, by the place of their next step, a bit each.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
struct Turns {
    at_nodes: u32,
    at_triangles: u32,
    elsewhere: u32,
}

impl Turns {
    #[inline(always)]
    fn give(&mut self, index: usize, place: Place) {
        self.at_nodes |= u32::from(place == Place::Node) << index;
        self.at_triangles |= u32::from(place == Place::Triangles) << index;
        self.elsewhere |= u32::from(place == Place::Elsewhere) << index;
    }

    fn without(self, other: Self) -> Self {
        Self {
            at_nodes: self.at_nodes & !other.at_nodes,
            at_triangles: self.at_triangles & !other.at_triangles,
            elsewhere: self.elsewhere & !other.elsewhere,
        }
    }

    /// Prefetches the nodes and triangles of the next steps.
    #[inline(always)]
    fn prefetch<W: Walk, const N: usize>(self, walks: &ArrayVec<W, N>, context: &W::Context) {
        for index in members::<N>(self.at_nodes) {
            walks[index].prefetch_node(context);
        }
        for index in members::<N>(self.at_triangles) {
            walks[index].prefetch_triangles(context);
        }
    }
}

/// The positions of the bits that are set, all below `N`.
#[inline(always)]
fn members<const N: usize>(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let index = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (index < N).then_some(index)
    })
}

/// The capacity of a ray's stack for all spaces together. A million triangles need about fifty entries at most.
const STACK_LEN: usize = 96;

/// The children still to be visited, and the distances at which the ray enters them.
type Stack = ArrayVec<u64, STACK_LEN>;

/// The entry below all children of a space, at which the ray returns to the space around it.
const OUTWARD: u64 = Child::NONE.0 as u64;

/// The state of a ray's traversal, for any hit with `ANY` or else for the nearest.
struct Progress<'a, const ANY: bool> {
    /// The stack of a single-ray traversal, with the entries of inner spaces on top.
    stack: &'a mut Stack,
    next: Child,
    t_max: f32,
    /// Whether the stack is too small for the ray, which then has to be traced by itself.
    gave_up: bool,
}

impl<'a, const ANY: bool> Progress<'a, ANY> {
    #[inline(always)]
    fn new(stack: &'a mut Stack, t_max: f32) -> Self {
        Self {
            stack,
            next: Child::NONE,
            t_max,
            gave_up: false,
        }
    }

    /// Enters a space at its root.
    #[inline(always)]
    fn enter(&mut self) {
        let entered = self.stack.try_push(OUTWARD).is_ok() && self.stack.try_push(u64::from(Child::ROOT.0)).is_ok();
        if !entered {
            self.give_up();
        }
    }

    fn give_up(&mut self) {
        self.gave_up = true;
        self.stack.clear();
    }

    /// Pops the nearest child.
    #[inline(always)]
    fn next_step(&mut self) -> Child {
        self.next = Child(self.stack.pop().unwrap_or(OUTWARD) as u32);
        self.next
    }

    #[inline(always)]
    fn visit(&mut self, node: &Node, slabs: &RaySlabs) {
        let (enter, met) = node.entries(slabs, padded(self.t_max));
        let pushed = if ANY {
            push_unsorted(node, met, self.stack)
        } else {
            push_sorted(node, enter, met, self.stack)
        };
        if pushed.is_err() {
            self.give_up();
        }
    }

    /// Lowers t_max to a hit at `t`.
    #[inline(always)]
    fn shorten(&mut self, t: f32) {
        self.t_max = t;
        if ANY {
            self.stack.clear();
            return;
        }
        // Entries behind the hit are removed now. Skipping them later would be a branch at every step that is hard to
        // predict.
        let farthest = u64::from(padded(t).to_bits()) << 32 | u64::from(u32::MAX);
        let mut kept = 0;
        for place in 0..self.stack.len() {
            let entry = self.stack[place];
            self.stack[kept] = entry;
            kept += usize::from(entry <= farthest);
        }
        self.stack.truncate(kept);
    }
}
