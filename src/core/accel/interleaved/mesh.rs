//! Sixteen rays within one mesh: they descend as a packet while enough of them meet the same child, then interleaved.

use arrayvec::ArrayVec;
use wide::f32x8;

use super::{OUTWARD, Place, Progress, Stack, Walk, members, take_turns};
use crate::accel::blas::Blas;
use crate::accel::hit::MeshHit;
use crate::accel::node::{Child, Node, RaySlabLanes, RaySlabs, WIDTH};
use crate::accel::ray_lanes::RayLanes;
use crate::accel::traverse::push_far_to_near;
use crate::accel::triangle_block::TriangleBlock;
use crate::geometry::triangle::TriangleRay;
use crate::math::Ray;
use crate::math::lanes::LANES;

impl Blas {
    /// [`Self::intersect`] of the rays in `active`. Calls `found` with the lane and the nearest hit of each ray that
    /// has one.
    #[inline(always)]
    pub(in crate::accel) fn intersect_lanes(
        &self,
        rays: &RayLanes,
        active: u32,
        mut found: impl FnMut(usize, MeshHit),
    ) {
        self.walk_lanes::<false>(rays, active, |index, ray, walk| {
            let hit = if walk.progress.gave_up {
                self.intersect(ray)
            } else {
                walk.hit
            };
            if let Some(hit) = hit {
                found(index, hit);
            }
        });
    }

    /// [`Self::occluded`] of the rays in `active`, a bit each; all other bits are zero.
    pub(in crate::accel) fn occluded_lanes(&self, rays: &RayLanes, active: u32) -> u32 {
        let mut occluded = 0;
        self.walk_lanes::<true>(rays, active, |index, ray, walk| {
            let hit = if walk.progress.gave_up {
                self.occluded(ray)
            } else {
                walk.hit.is_some()
            };
            occluded |= u32::from(hit) << index;
        });
        occluded
    }

    #[inline(always)]
    fn walk_lanes<const ANY: bool>(
        &self,
        rays: &RayLanes,
        active: u32,
        mut finish: impl FnMut(usize, &Ray, &MeshWalk<ANY>),
    ) {
        let active = active & rays.valid_mask();
        let mut starts = [Start::NOWHERE; LANES];
        self.bvh
            .descend_packet(rays, active, |lane, child, enter| starts[lane].push(child, enter));
        let slabs = RaySlabLanes::new(rays);
        let rays = rays.rays();
        // The stacks are large, so they are built in place.
        let mut stacks: [Stack; LANES] = std::array::from_fn(|_| Stack::new());
        let mut walks = ArrayVec::<MeshWalk<ANY>, LANES>::new();
        for (index, stack) in stacks.iter_mut().enumerate() {
            let (ray, start) = (&rays[index], &starts[index]);
            stack.push(OUTWARD);
            start.push_to(stack);
            walks.push(MeshWalk {
                slabs: slabs.get(index),
                triangle_ray: TriangleRay::new(ray),
                progress: Progress::new(stack, ray.t_max),
                hit: None,
            });
        }
        if self.bvh.is_linear() {
            // The only leaf of a linear list has many blocks.
            walks.iter_mut().for_each(|walk| walk.progress.give_up());
        }
        let mesh = MeshTables {
            nodes: &self.bvh.nodes,
            blocks: self.blocks(),
        };
        take_turns(&mut walks, &mesh, active);
        for index in members::<LANES>(active) {
            finish(index, &rays[index], &walks[index]);
        }
    }
}

/// The children at which a ray leaves the packet, unsorted.
#[derive(Clone, Copy)]
struct Start {
    enters: [f32; WIDTH],
    children: [Child; WIDTH],
    /// The number of children, which may exceed the room for them.
    count: usize,
}

impl Start {
    const NOWHERE: Self = Self {
        enters: [0.0; WIDTH],
        children: [Child::NONE; WIDTH],
        count: 0,
    };

    #[inline(always)]
    fn push(&mut self, child: Child, enter: f32) {
        if self.count < WIDTH {
            self.enters[self.count] = enter;
            self.children[self.count] = child;
        }
        self.count += 1;
    }

    #[inline(always)]
    fn push_to(&self, stack: &mut Stack) {
        if self.count > WIDTH {
            stack.push(u64::from(Child::ROOT.0));
            return;
        }
        let places = f32x8::new([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let used = places.simd_lt(f32x8::splat(self.count as f32));
        // A new stack has room.
        let _ = push_far_to_near(f32x8::new(self.enters), used, self.children, stack);
    }
}

struct MeshTables<'a> {
    nodes: &'a [Node],
    blocks: &'a [TriangleBlock],
}

struct MeshWalk<'a, const ANY: bool> {
    slabs: RaySlabs,
    triangle_ray: TriangleRay,
    progress: Progress<'a, ANY>,
    hit: Option<MeshHit>,
}

impl<'a, const ANY: bool> Walk for MeshWalk<'a, ANY> {
    type Context = MeshTables<'a>;

    #[inline(always)]
    fn next_step(&mut self) -> Place {
        let next = self.progress.next_step();
        match (next.is_leaf(), next == Child::NONE) {
            (false, _) => Place::Node,
            (true, false) => Place::Triangles,
            (true, true) => Place::Nowhere,
        }
    }

    #[inline(always)]
    fn visit_node(&mut self, mesh: &MeshTables) {
        let node = &mesh.nodes[self.progress.next.index()];
        self.progress.visit(node, &self.slabs);
    }

    #[inline(always)]
    fn visit_triangles(&mut self, mesh: &MeshTables) {
        let number = self.progress.next.index();
        let nearest = self.hit.map(|hit| hit.slot);
        if let Some(hit) = mesh.blocks[number].closest(number, &self.triangle_ray, self.progress.t_max, nearest) {
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
        if let Some(block) = mesh.blocks.get(self.progress.next.index()) {
            block.prefetch();
        }
    }
}
