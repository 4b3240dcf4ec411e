//! Rays that stay within one mesh.

use arrayvec::ArrayVec;

use super::{Place, Progress, Stack, Walk, members, take_turns};
use crate::accel::blas::{Blas, MeshHit};
use crate::accel::node::{Child, Node, RaySlabs};
use crate::accel::packet::TrianglePacket;
use crate::geometry::triangle::TriangleRay;
use crate::math::Ray;

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
        let mesh = MeshTables {
            nodes: &self.bvh.nodes,
            packets: self.packets(),
        };
        take_turns(&mut walks, &mesh, active);
        for index in members::<N>(active) {
            finish(index, &walks[index]);
        }
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
