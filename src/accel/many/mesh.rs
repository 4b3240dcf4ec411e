//! Rays that stay within one mesh.

use arrayvec::ArrayVec;
use wide::f32x8;

use super::{OUTWARD, Place, Progress, Stack, Walk, members, take_turns};
use crate::accel::blas::{Blas, MeshHit};
use crate::accel::node::{Child, Node, RaySlabs, WIDTH};
use crate::accel::packet::TrianglePacket;
use crate::accel::ray_lanes::RayLanes;
use crate::accel::traverse::push_far_to_near;
use crate::geometry::triangle::TriangleRay;
use crate::math::Ray;
use crate::math::lanes::LANES;

impl Blas {
    /// [`Self::intersect`] of each ray whose bit is set in `active`, `None` for the others. `N` is at most 32.
    pub(in crate::accel) fn intersect_many<const N: usize>(
        &self,
        rays: &[Ray; N],
        active: u32,
    ) -> [Option<MeshHit>; N] {
        let mut hits = [None; N];
        self.walk_many::<false, N>(rays, active, |index, walk| {
            hits[index] = if walk.progress.lost {
                self.intersect(&rays[index])
            } else {
                walk.hit
            };
        });
        hits
    }

    /// [`Self::occluded`] of each ray whose bit is set in `active`; the others' bits are zero. `N` is at most 32.
    pub(in crate::accel) fn occluded_many<const N: usize>(&self, rays: &[Ray; N], active: u32) -> u32 {
        let mut occluded = 0;
        self.walk_many::<true, N>(rays, active, |index, walk| {
            let hit = if walk.progress.lost {
                self.occluded(&rays[index])
            } else {
                walk.hit.is_some()
            };
            occluded |= u32::from(hit) << index;
        });
        occluded
    }

    /// [`Self::intersect_many`] for rays that begin near each other: as long as several go the same way, they are walked as a bundle.
    pub(in crate::accel) fn intersect_neighbours(&self, rays: &RayLanes, active: u32) -> [Option<MeshHit>; LANES] {
        let mut stacks: [Stack; LANES] = [const { Stack::new_const() }; LANES];
        let mut starts = [Start::default(); LANES];
        self.bvh.descend_bundle(rays, active, |lane, child, enter| starts[lane].push(child, enter));
        let rays = rays.rays();
        if self.bvh.is_linear() {
            return self.intersect_many(&rays, active);
        }
        let mut walks = ArrayVec::<MeshWalk<false>, LANES>::new();
        for ((ray, stack), start) in rays.iter().zip(&mut stacks).zip(&starts) {
            stack.push(OUTWARD);
            start.push_to(stack);
            walks.push(MeshWalk::new(ray, stack));
        }
        for (ray, walk) in rays.iter().zip(&mut walks) {
            walk.slabs = RaySlabs::new(ray).unwrap_or_default();
        }
        let mut hits = [None; LANES];
        take_turns(&mut walks, &self.tables(), active);
        for index in members::<LANES>(active) {
            hits[index] = if walks[index].progress.lost {
                self.intersect(&rays[index])
            } else {
                walks[index].hit
            };
        }
        hits
    }

    fn tables(&self) -> MeshTables<'_> {
        MeshTables {
            nodes: &self.bvh.nodes,
            packets: self.packets(),
        }
    }

    #[inline(always)]
    fn walk_many<const ANY: bool, const N: usize>(
        &self,
        rays: &[Ray; N],
        active: u32,
        mut finish: impl FnMut(usize, &MeshWalk<ANY>),
    ) {
        // They are large: made where they stay.
        let mut stacks: [Stack; N] = [const { Stack::new_const() }; N];
        let mut walks = ArrayVec::<MeshWalk<ANY>, N>::new();
        for (ray, stack) in rays.iter().zip(&mut stacks) {
            walks.push(MeshWalk::new(ray, stack));
        }
        for index in members::<N>(active) {
            // A leaf of a linear list has many packets.
            match RaySlabs::new(&rays[index]) {
                _ if self.bvh.is_linear() => walks[index].progress.give_up(),
                None => {}
                Some(slabs) => {
                    walks[index].slabs = slabs;
                    walks[index].progress.enter();
                }
            }
        }
        take_turns(&mut walks, &self.tables(), active);
        for index in members::<N>(active) {
            finish(index, &walks[index]);
        }
    }
}

/// Where a ray begins.
#[derive(Clone, Copy)]
struct Start {
    enters: [f32; WIDTH],
    children: [Child; WIDTH],
    count: usize,
}

impl Default for Start {
    fn default() -> Self {
        Self { enters: [0.0; WIDTH], children: [Child::NONE; WIDTH], count: 0 }
    }
}

impl Start {
    #[inline(always)]
    fn push(&mut self, child: Child, enter: f32) {
        if self.count < WIDTH {
            self.enters[self.count] = enter;
            self.children[self.count] = child;
        }
        self.count += 1;
    }

    #[inline(always)]
    fn push_to(&self, waiting: &mut Stack) {
        if self.count > WIDTH {
            // From the root on, alone.
            waiting.push(u64::from(Child::ROOT.0));
            return;
        }
        let place = f32x8::new([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let met = place.simd_lt(f32x8::splat(self.count as f32));
        let _ = push_far_to_near(f32x8::new(self.enters), met, self.children, waiting);
    }
}

struct MeshTables<'a> {
    nodes: &'a [Node],
    packets: &'a [TrianglePacket],
}

struct MeshWalk<'a, const ANY: bool> {
    slabs: RaySlabs,
    triangle_ray: TriangleRay,
    progress: Progress<'a, ANY>,
    hit: Option<MeshHit>,
}

impl<'a, const ANY: bool> MeshWalk<'a, ANY> {
    /// Of a ray that goes nowhere yet.
    #[inline(always)]
    fn new(ray: &Ray, waiting: &'a mut Stack) -> Self {
        Self {
            slabs: RaySlabs::default(),
            triangle_ray: TriangleRay::new(ray),
            progress: Progress::new(waiting, ray.t_max),
            hit: None,
        }
    }
}

impl<'a, const ANY: bool> Walk for MeshWalk<'a, ANY> {
    type Around = MeshTables<'a>;

    #[inline(always)]
    fn go_on(&mut self) -> Place {
        let next = self.progress.go_on();
        match (next.is_leaf(), next == Child::NONE) {
            (false, _) => Place::Node,
            (true, false) => Place::Triangles,
            (true, true) => Place::Nowhere,
        }
    }

    #[inline(always)]
    fn visit_node(&mut self, mesh: &MeshTables) {
        self.progress
            .visit(&mesh.nodes[self.progress.next.index()], &self.slabs);
    }

    #[inline(always)]
    fn visit_triangles(&mut self, mesh: &MeshTables) {
        let number = self.progress.next.index();
        if let Some(hit) = mesh.packets[number].closest(number, &self.triangle_ray, self.progress.t_max) {
            self.hit = Some(hit);
            self.progress.shorten(hit.t);
        }
    }

    #[inline(always)]
    fn visit_elsewhere(&mut self, _: &MeshTables) -> bool {
        false
    }

    #[inline(always)]
    fn prefetch_node(&self, mesh: &MeshTables) {
        if let Some(node) = mesh.nodes.get(self.progress.next.index()) {
            node.prefetch();
        }
    }

    #[inline(always)]
    fn prefetch_triangles(&self, mesh: &MeshTables) {
        if let Some(packet) = mesh.packets.get(self.progress.next.index()) {
            packet.prefetch();
        }
    }
}
