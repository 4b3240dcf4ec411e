//! Packet traversal: each box that any of sixteen rays may meet is tested against all of them at once.
//!
//! Rays of one pixel, and shadow rays from their hits to one light, visit nearly the same nodes and triangles, which
//! are then fetched once for all (Wald, Slusallek, Benthin and Wagner, Interactive Rendering with Coherent Ray Tracing,
//! Eurographics 2001). Incoherent rays are slower than with [`super::interleaved`]. Where surfaces coincide, a ray may
//! hit another of them than if traced by itself.

use std::ops::Range;

use arrayvec::ArrayVec;

use super::blas::Blas;
use super::bvh::Bvh;
use super::hit::{Hit, MeshHit};
use super::instance::Primitive;
use super::node::{Child, Node, T_MAX_PADDING, WIDTH, padded};
use super::obstacle::Obstacles;
use super::ray_lanes::RayLanes;
use super::shape_lanes::SlabLanes;
use super::tlas::{Item, Tlas};
use super::traverse::{STACK, TraversalStats};
use crate::geometry::triangle::TriangleRay;
use crate::math::Ray;
use crate::math::lanes::{LANES, Lanes, each_lane, lanes_of};

/// A child on the stack.
#[derive(Clone, Copy)]
struct StackEntry {
    child: Child,
    /// The rays that meet its box, a bit each.
    rays: u32,
    /// The least distance at which one of them enters it.
    enter: f32,
}

impl StackEntry {
    /// The stack with the root alone.
    #[inline(always)]
    fn at_root(rays: u32) -> ArrayVec<Self, STACK> {
        let mut stack = ArrayVec::new();
        stack.push(Self {
            child: Child::ROOT,
            rays,
            enter: 0.0,
        });
        stack
    }
}

impl Blas {
    /// [`Self::intersect`] for the rays in `active`. Calls `found` with the lane and the nearest hit of each ray that
    /// has one.
    pub(super) fn intersect_packet(&self, rays: &RayLanes, active: u32, mut found: impl FnMut(usize, MeshHit)) {
        let active = active & rays.valid_mask();
        if active.count_ones() <= FEW {
            for lane in each_lane(active) {
                if let Some(hit) = self.intersect(&rays.get(lane)) {
                    found(lane, hit);
                }
            }
            return;
        }
        let blocks = self.blocks();
        let lone = triangle_rays(rays);
        let mut nearest: [Option<MeshHit>; LANES] = [None; LANES];
        self.bvh.walk_packet::<false>(rays, active, |range, mask, t_max| {
            for number in Self::blocks_of(range) {
                for lane in each_lane(mask) {
                    let own = nearest[lane].map(|hit| hit.slot);
                    if let Some(hit) = blocks[number].closest(number, &lone[lane], t_max.as_array()[lane], own) {
                        t_max.as_mut_array()[lane] = hit.t;
                        nearest[lane] = Some(hit);
                    }
                }
            }
            0
        });
        for (lane, hit) in nearest.into_iter().enumerate() {
            if let Some(hit) = hit {
                found(lane, hit);
            }
        }
    }

    /// [`Self::occluded`] for the rays in `active`, a bit each.
    pub(super) fn occluded_packet(&self, rays: &RayLanes, active: u32) -> u32 {
        let active = active & rays.valid_mask();
        if active.count_ones() <= FEW {
            return rays.lanes_where(active, |ray| self.occluded(ray));
        }
        let blocks = self.blocks();
        let lone = triangle_rays(rays);
        self.bvh.walk_packet::<true>(rays, active, |range, mask, t_max| {
            let blocks = &blocks[Self::blocks_of(range)];
            let hits = |lane: usize| {
                blocks
                    .iter()
                    .any(|block| block.any(&lone[lane], t_max.as_array()[lane]))
            };
            each_lane(mask).fold(0, |bits, lane| bits | u32::from(hits(lane)) << lane)
        })
    }
}

impl Tlas {
    /// [`Self::intersect_lanes`] for coherent rays.
    pub fn intersect_packet(&self, rays: &RayLanes, active: u32) -> [Option<Hit>; LANES] {
        let active = active & rays.valid_mask();
        if let Some(small) = &self.small_scene {
            let hits = small.closest::<true>(self.shapes(), rays, active);
            self.prefetch_normals(&hits);
            return hits;
        }
        let mut nearest = [None; LANES];
        self.bvh.walk_packet::<false>(rays, active, |range, mask, t_max| {
            for &number in &self.bvh.order()[range] {
                let rays = RayLanes { t_max: *t_max, ..*rays };
                self.intersect_item(number, &rays, mask, |lane, hit| {
                    t_max.as_mut_array()[lane] = hit.t;
                    nearest[lane] = Some(hit);
                });
            }
            0
        });
        self.prefetch_normals(&nearest);
        nearest
    }

    #[inline(always)]
    fn intersect_item(&self, number: u32, rays: &RayLanes, mask: u32, mut found: impl FnMut(usize, Hit)) {
        match self.item(number) {
            Item::Block(block, members) => each_hit(rays, mask, |ray| block.closest(members, ray), found),
            Item::Placement(placement) => {
                let hit =
                    |ray: &Ray| self.closest_placed::<false>(number, placement, ray, &mut TraversalStats::default());
                each_hit(rays, mask, hit, found);
            }
            Item::Shape(shape) => match &shape.primitive {
                Primitive::Mesh(mesh) => mesh.intersect_packet(&shape.local_rays(rays), mask, |lane, hit| {
                    found(lane, Hit::of_mesh(number, hit));
                }),
                _ => {
                    let hit = |ray: &Ray| shape.closest::<false>(number, ray, &mut TraversalStats::default());
                    each_hit(rays, mask, hit, found);
                }
            },
        }
    }

    /// [`Self::occluded_lanes`] for coherent rays.
    pub fn occluded_packet(&self, rays: &RayLanes, active: u32) -> u32 {
        self.obstacles_packet(rays, active, |_| false).opaque
    }

    /// [`Self::obstacles`] for coherent rays.
    pub fn obstacles_packet(&self, rays: &RayLanes, active: u32, is_clear: impl Fn(usize) -> bool) -> Obstacles {
        let active = active & rays.valid_mask();
        if let Some(small) = &self.small_scene {
            return small.any::<true>(self.shapes(), rays, active, is_clear);
        }
        let mut obstacles = Obstacles::default();
        self.bvh.walk_packet::<true>(rays, active, |range, mask, _| {
            for &number in &self.bvh.order()[range] {
                self.add_item(number, rays, mask & !obstacles.opaque, &is_clear, &mut obstacles);
            }
            obstacles.opaque
        });
        obstacles
    }

    #[inline(always)]
    fn add_item(
        &self,
        number: u32,
        rays: &RayLanes,
        mask: u32,
        is_clear: &impl Fn(usize) -> bool,
        obstacles: &mut Obstacles,
    ) {
        match self.item(number) {
            Item::Block(block, members) => {
                for lane in each_lane(mask) {
                    obstacles.add_lane(lane, block.obstacle(members, &rays.get(lane), is_clear));
                }
            }
            Item::Placement(placement) => {
                for lane in each_lane(mask) {
                    obstacles.add_lane(lane, self.obstacle_placed(placement, &rays.get(lane), is_clear));
                }
            }
            Item::Shape(shape) => {
                let met = match &shape.primitive {
                    Primitive::Mesh(mesh) => mesh.occluded_packet(&shape.local_rays(rays), mask),
                    _ => rays.lanes_where(mask, |ray| shape.occluded(ray)),
                };
                if met != 0 {
                    obstacles.add(met, is_clear(number as usize));
                }
            }
        }
    }
}

/// Calls `found` with each hit that `intersect` finds for the rays in `mask`.
#[inline(always)]
fn each_hit(rays: &RayLanes, mask: u32, intersect: impl Fn(&Ray) -> Option<Hit>, mut found: impl FnMut(usize, Hit)) {
    for lane in each_lane(mask) {
        if let Some(hit) = intersect(&rays.get(lane)) {
            found(lane, hit);
        }
    }
}

#[inline(always)]
fn triangle_rays(rays: &RayLanes) -> ArrayVec<TriangleRay, LANES> {
    (0..LANES).map(|lane| TriangleRay::new(&rays.get(lane))).collect()
}

impl Bvh {
    /// Traverses the hierarchy with the rays in `active`. `leaf` gets the range of a leaf's primitives in the leaf
    /// order, the rays that may meet them, and each ray's t_max, which it lowers to a hit; it returns the rays that hit
    /// a primitive. With `ANY` these rays are finished. Returns all rays that hit a primitive.
    #[inline(always)]
    fn walk_packet<const ANY: bool>(
        &self,
        rays: &RayLanes,
        active: u32,
        mut leaf: impl FnMut(Range<usize>, u32, &mut Lanes) -> u32,
    ) -> u32 {
        let slabs = SlabLanes::new(rays);
        let common = slabs.common_signs(active);
        let mut left = active;
        let mut met = 0;
        let mut t_max = rays.t_max;
        let mut farthest = f32::INFINITY;
        let mut boxes = BoxesMet::NONE;
        let mut stack = StackEntry::at_root(left);
        while let Some(next) = stack.pop() {
            let mask = next.rays & left;
            if mask == 0 || !ANY && next.enter > farthest {
                continue;
            }
            if !next.child.is_leaf() {
                let node = &self.nodes[next.child.index()];
                boxes.find(node, &slabs, common, mask, t_max * Lanes::splat(T_MAX_PADDING));
                push_met::<ANY>(node, &boxes, boxes.slots, &mut stack);
                continue;
            }
            met |= leaf(self.leaf_range(next.child), mask, &mut t_max);
            if ANY {
                left &= !met;
                if left == 0 {
                    break;
                }
            } else {
                farthest = padded(each_lane(left).fold(0.0, |farthest, lane| t_max.as_array()[lane].max(farthest)));
            }
        }
        met
    }

    /// Descends with the rays in `active` together while at least [`CROWD`] of them meet the same child. Calls `alone`
    /// with the lane, the child and the entry distance where a ray has to continue by itself.
    #[inline(always)]
    pub(super) fn descend_packet(&self, rays: &RayLanes, active: u32, mut alone: impl FnMut(usize, Child, f32)) {
        let slabs = SlabLanes::new(rays);
        let common = slabs.common_signs(active);
        let is_crowd = |child: Child, rays: u32| !child.is_leaf() && rays.count_ones() >= CROWD;
        if !is_crowd(Child::ROOT, active) {
            each_lane(active).for_each(|lane| alone(lane, Child::ROOT, 0.0));
            return;
        }
        let mut boxes = BoxesMet::NONE;
        let mut stack = StackEntry::at_root(active);
        while let Some(next) = stack.pop() {
            let node = &self.nodes[next.child.index()];
            boxes.find(
                node,
                &slabs,
                common,
                next.rays,
                rays.t_max * Lanes::splat(T_MAX_PADDING),
            );
            let mut crowds = 0;
            for slot in each_lane(boxes.slots) {
                // Tells the compiler that the slot is in range.
                let slot = slot % WIDTH;
                if is_crowd(node.children[slot], boxes.rays[slot]) {
                    crowds |= 1 << slot;
                } else {
                    for lane in each_lane(boxes.rays[slot]) {
                        alone(lane, node.children[slot], boxes.enters[slot].as_array()[lane]);
                    }
                }
            }
            push_met::<true>(node, &boxes, crowds, &mut stack);
        }
    }
}

/// From this number of rays on, one packet test of a node is cheaper than a test per ray.
const CROWD: u32 = 8;

/// Up to this number, rays go through a mesh one by one: preparing a packet has a cost.
const FEW: u32 = 4;

/// The boxes of a node that rays of a packet meet.
struct BoxesMet {
    /// The distances at which each ray enters each box.
    enters: [Lanes; WIDTH],
    /// The rays that meet each box, a bit each.
    rays: [u32; WIDTH],
    /// The boxes that any ray meets, a bit each.
    slots: u32,
}

impl BoxesMet {
    const NONE: Self = Self {
        enters: [Lanes::ZERO; WIDTH],
        rays: [0; WIDTH],
        slots: 0,
    };

    /// Tests the boxes of `node` against the rays in `mask`, whose common signs are `common`.
    #[inline(always)]
    fn find(&mut self, node: &Node, slabs: &SlabLanes, common: Option<[bool; 3]>, mask: u32, t_max: Lanes) {
        match common {
            Some(down) => {
                let up = [!down[0], !down[1], !down[2]];
                self.find_by(mask, |slot| {
                    slabs.enter_by(
                        node.faces_in_lanes(slot, down),
                        node.faces_in_lanes(slot, up),
                        down,
                        t_max,
                    )
                });
            }
            None => self.find_by(mask, |slot| {
                let [lower, upper] = [[false; 3], [true; 3]];
                slabs.enter_between(
                    node.faces_in_lanes(slot, lower),
                    node.faces_in_lanes(slot, upper),
                    t_max,
                )
            }),
        }
    }

    /// Tests all boxes without a branch. `enter` gives the distances at which the rays enter a slot's box, and the mask
    /// of the rays that meet it.
    #[inline(always)]
    fn find_by(&mut self, mask: u32, enter: impl Fn(usize) -> (Lanes, Lanes)) {
        let mut slots = 0;
        for slot in 0..WIDTH {
            let (enter, met) = enter(slot);
            let rays = met.to_bitmask() & mask;
            self.enters[slot] = enter;
            self.rays[slot] = rays;
            slots |= u32::from(rays != 0) << slot;
        }
        self.slots = slots;
    }
}

/// Pushes the met children in `slots`, the nearest on top unless any hit is sought.
#[inline(always)]
fn push_met<const ANY: bool>(node: &Node, boxes: &BoxesMet, slots: u32, stack: &mut ArrayVec<StackEntry, STACK>) {
    let base = stack.len();
    for slot in each_lane(slots) {
        let slot = slot % WIDTH;
        let mut entry = StackEntry {
            child: node.children[slot],
            rays: boxes.rays[slot],
            enter: 0.0,
        };
        if !ANY {
            entry.enter = least(lanes_of(entry.rays).select(boxes.enters[slot], Lanes::splat(f32::INFINITY)));
        }
        // The stack is deep enough by construction.
        let _ = stack.try_push(entry);
        if !ANY {
            let mut place = stack.len() - 1;
            while place > base && stack[place - 1].enter < entry.enter {
                stack[place] = stack[place - 1];
                place -= 1;
            }
            stack[place] = entry;
        }
    }
}

#[inline(always)]
fn least(lanes: Lanes) -> f32 {
    let mut values = lanes.to_array();
    let mut half = LANES / 2;
    while half > 0 {
        for lane in 0..half {
            values[lane] = values[lane].min(values[lane + half]);
        }
        half /= 2;
    }
    values[0]
}
