//! Interleaved rays through a whole scene, from the world into its groups and meshes. Each ray takes the same steps as
//! when traced by itself.

use arrayvec::ArrayVec;

use super::{Place, Progress, Stack, Walk, members, take_turns};
use crate::accel::bvh::Bvh;
use crate::accel::hit::Hit;
use crate::accel::instance::Primitive;
use crate::accel::node::{Child, RaySlabs};
use crate::accel::shape_block::{Members, ShapeBlock};
use crate::accel::tlas::{Item, Tlas};
use crate::accel::traverse::TraversalStats;
use crate::accel::triangle_block::TriangleBlock;
use crate::geometry::triangle::TriangleRay;
use crate::math::Ray;

impl Tlas {
    /// [`Tlas::intersect`] of each ray whose bit is set in `active`, `None` for the others. `N` is at most 32.
    pub fn intersect_interleaved<const N: usize>(&self, rays: &[Ray; N], active: u32) -> [Option<Hit>; N] {
        let mut hits = [None; N];
        self.walk_interleaved::<false, N>(rays, active, |index, walk| {
            hits[index] = if walk.progress.gave_up {
                self.intersect(&rays[index])
            } else {
                walk.hit
            };
        });
        hits
    }

    /// [`Tlas::occluded`] of each ray whose bit is set in `active`; the others' bits are zero. `N` is at most 32.
    pub fn occluded_interleaved<const N: usize>(&self, rays: &[Ray; N], active: u32) -> u32 {
        let mut occluded = 0;
        self.walk_interleaved::<true, N>(rays, active, |index, walk| {
            let hit = if walk.progress.gave_up {
                self.occluded(&rays[index])
            } else {
                walk.hit.is_some()
            };
            occluded |= u32::from(hit) << index;
        });
        occluded
    }

    #[inline(always)]
    fn walk_interleaved<const ANY: bool, const N: usize>(
        &self,
        rays: &[Ray; N],
        active: u32,
        mut finish: impl FnMut(usize, &SceneWalk<ANY>),
    ) {
        // The stacks are large, so they are built in place.
        let mut stacks: [Stack; N] = std::array::from_fn(|_| Stack::new());
        let mut walks = ArrayVec::<SceneWalk<ANY>, N>::new();
        for (ray, stack) in rays.iter().zip(&mut stacks) {
            walks.push(SceneWalk::new(Level::of_scene(self, ray), stack));
        }
        for index in members::<N>(active) {
            if let Some(slabs) = RaySlabs::new(&rays[index]) {
                walks[index].level.slabs = slabs;
                walks[index].progress.enter();
            }
        }
        take_turns(&mut walks, &(), active);
        for index in members::<N>(active) {
            finish(index, &walks[index]);
        }
    }
}

/// A ray in one space: the world, a group in the world, or a mesh in either.
#[derive(Clone, Copy)]
struct Level<'a> {
    /// The world or the group.
    scene: &'a Tlas,
    /// The hierarchy of the mesh, or of the scene outside of meshes.
    bvh: &'a Bvh,
    /// The blocks of the mesh; empty outside of meshes.
    blocks: &'a [TriangleBlock],
    ray: Ray,
    slabs: RaySlabs,
    /// The ray prepared for triangle tests; used within a mesh.
    triangle_ray: TriangleRay,
    /// The index of the group's placement in the world.
    placement: Option<u32>,
    /// The index of the mesh's instance in the scene.
    shape: u32,
}

impl<'a> Level<'a> {
    #[inline(always)]
    fn of_scene(scene: &'a Tlas, ray: &Ray) -> Self {
        Self {
            scene,
            bvh: &scene.bvh,
            blocks: &[],
            ray: *ray,
            slabs: RaySlabs::default(),
            triangle_ray: TriangleRay::default(),
            placement: None,
            shape: 0,
        }
    }
}

struct SceneWalk<'a, const ANY: bool> {
    level: Level<'a>,
    outer: ArrayVec<Level<'a>, 2>,
    progress: Progress<'a, ANY>,
    hit: Option<Hit>,
}

impl<'a, const ANY: bool> SceneWalk<'a, ANY> {
    /// A walk that has not begun: its stack is empty.
    #[inline(always)]
    fn new(level: Level<'a>, stack: &'a mut Stack) -> Self {
        Self {
            progress: Progress::new(stack, level.ray.t_max),
            level,
            outer: ArrayVec::new(),
            hit: None,
        }
    }

    /// Enters a space within the current one.
    #[inline(always)]
    fn enter(&mut self, inner: Level<'a>) {
        let Some(slabs) = RaySlabs::new(&inner.ray) else {
            return;
        };
        let outer = std::mem::replace(&mut self.level, Level { slabs, ..inner });
        match self.outer.try_push(outer) {
            Ok(()) => self.progress.enter(),
            Err(_) => self.progress.give_up(),
        }
    }

    /// Out of line as in [`Tlas::intersect`]: most steps are within meshes.
    #[inline(never)]
    fn visit_shape(&mut self) {
        let level = self.level;
        let bvh = &level.scene.bvh;
        let &[item] = &bvh.order()[bvh.leaf_range(self.progress.next)] else {
            // Only a linear list has leaves of several items.
            return self.progress.give_up();
        };
        let ray = Ray {
            t_max: self.progress.t_max,
            ..level.ray
        };
        let shape = match level.scene.item(item) {
            Item::Shape(shape) => shape,
            Item::Placement(placement) => {
                let group = level.scene.group_of(placement);
                self.enter(Level {
                    scene: group,
                    bvh: &group.bvh,
                    ray: placement.group_ray(&ray),
                    placement: Some(item),
                    ..level
                });
                return;
            }
            Item::Block(block, members) => return self.visit_block(block, members, &ray),
        };
        if !matches!(shape.primitive, Primitive::Mesh(_)) {
            if let Some(hit) = shape.closest::<false>(item, &ray, &mut TraversalStats::default()) {
                self.take(hit);
            }
            return;
        }
        let ray = shape.local_ray(&ray);
        if let Primitive::Mesh(mesh) = &shape.primitive {
            // A leaf of a linear list has many blocks.
            if mesh.bvh().is_linear() {
                return self.progress.give_up();
            }
            self.enter(Level {
                bvh: mesh.bvh(),
                blocks: mesh.blocks(),
                triangle_ray: TriangleRay::new(&ray),
                ray,
                shape: item,
                ..level
            });
        }
    }

    /// Out of line as well: its vectors take stack space that other shapes do not need.
    #[inline(never)]
    fn visit_block(&mut self, block: &ShapeBlock, members: &Members, ray: &Ray) {
        if let Some(hit) = block.closest(members, ray) {
            self.take(hit);
        }
    }

    #[inline(always)]
    fn take(&mut self, hit: Hit) {
        self.hit = Some(match self.level.placement {
            None => hit,
            Some(placement) => Hit {
                instance: placement,
                member: hit.instance,
                ..hit
            },
        });
        self.progress.shorten(hit.t);
    }
}

impl<const ANY: bool> Walk for SceneWalk<'_, ANY> {
    type Context = ();

    #[inline(always)]
    fn next_step(&mut self) -> Place {
        let next = self.progress.next_step();
        match (next.is_leaf(), next == Child::NONE || self.level.blocks.is_empty()) {
            (false, _) => Place::Node,
            (true, false) => Place::Triangles,
            (true, true) => Place::Elsewhere,
        }
    }

    #[inline(always)]
    fn visit_node(&mut self, (): &()) {
        let node = &self.level.bvh.nodes[self.progress.next.index()];
        self.progress.visit(node, &self.level.slabs);
    }

    #[inline(always)]
    fn visit_triangles(&mut self, (): &()) {
        let number = self.progress.next.index();
        let block = &self.level.blocks[number];
        let place = |hit: &Hit| match self.level.placement {
            None => hit.instance == self.level.shape,
            Some(placement) => (hit.instance, hit.member) == (placement, self.level.shape),
        };
        let nearest = self.hit.filter(place).map(|hit| hit.slot);
        if let Some(hit) = block.closest(number, &self.level.triangle_ray, self.progress.t_max, nearest) {
            self.take(Hit::of_mesh(self.level.shape, hit));
        }
    }

    fn visit_elsewhere(&mut self, (): &()) -> bool {
        if self.progress.next != Child::NONE {
            self.visit_shape();
            return true;
        }
        let outer = self.outer.pop();
        outer.map(|outer| self.level = outer).is_some()
    }

    #[inline(always)]
    fn prefetch_node(&self, (): &()) {
        if let Some(node) = self.level.bvh.nodes.get(self.progress.next.index()) {
            node.prefetch();
        }
    }

    #[inline(always)]
    fn prefetch_triangles(&self, (): &()) {
        if let Some(block) = self.level.blocks.get(self.progress.next.index()) {
            block.prefetch();
        }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{Affine3A, Vec3};

    use super::*;
    use crate::accel::{Blas, Instance, SplitMethod};
    use crate::geometry::mesh::MeshData;

    /// Triangles that grow with the distance from the ray's origin, whose boxes it meets but misses them, and a sphere
    /// behind them that it hits: their tree is a chain.
    #[test]
    fn rays_that_need_too_much_room_go_alone() {
        let corners = vec![Vec3::NEG_ONE, Vec3::new(1.0, -1.0, 1.0), Vec3::new(1.0, 1.0, -1.0)];
        let triangle = Arc::new(Blas::build(
            Arc::new(MeshData {
                positions: corners,
                triangles: vec![[0, 1, 2]],
                ..MeshData::default()
            }),
            SplitMethod::Sah,
        ));
        let placed = |primitive: Primitive, center: Vec3, radius: f32| {
            let placed = Affine3A::from_translation(center) * Affine3A::from_scale(Vec3::splat(radius));
            Instance::new(primitive, placed).unwrap()
        };
        let mut shapes: Vec<Instance> = (0..110)
            .map(|power| 2f32.powi(power - 50))
            .map(|size| placed(Primitive::Mesh(triangle.clone()), size * Vec3::X, 0.3 * size))
            .collect();
        let dir = Vec3::new(1.0, 0.28, 0.28);
        shapes.push(placed(Primitive::Sphere, 2f32.powi(61) * dir, 2f32.powi(58)));
        let scene = Tlas::build(shapes, SplitMethod::Sah);
        let rays = [Ray::new(Vec3::ZERO, dir), Ray::new(Vec3::ZERO, -dir)];
        let mut gave_up = [false; 2];
        scene.walk_interleaved::<false, 2>(&rays, 3, |index, walk| gave_up[index] = walk.progress.gave_up);
        assert_eq!(gave_up, [true, false]);
        let alone = rays.map(|ray| scene.intersect(&ray));
        assert_eq!(alone.map(|hit| hit.map(|hit| hit.instance)), [Some(110), None]);
        assert_eq!(scene.intersect_interleaved(&rays, 3), alone);
        assert_eq!(scene.occluded_interleaved(&rays, 3), 1);
    }
}
