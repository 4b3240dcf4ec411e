//! Rays walked several at a time, a step of each in turn: while the memory that one needs is on its way, the others work. In large scenes
//! most of a lone ray's time is waiting.
//!
//! Each ray takes the very steps that it would take alone. Those at inner nodes are taken together, those at triangles and those at
//! shapes, so that the processor has little to guess.

use arrayvec::ArrayVec;

use super::blas::Blas;
use super::bvh::Bvh;
use super::instance::Primitive;
use super::node::{Child, RaySlabs};
use super::packet::TrianglePacket;
use super::shape_packet::ShapePacket;
use super::tlas::{Hit, Item, Tlas};
use super::traverse::{push_sorted, push_unsorted};
use crate::geometry::triangle::TriangleRay;
use crate::math::Ray;

impl Tlas {
    /// [`Tlas::intersect`] of each ray whose bit is set in `active`, `None` for the others. `N` is at most 32.
    pub fn intersect_many<const N: usize>(&self, rays: &[Ray; N], active: u32) -> [Option<Hit>; N] {
        let alone = |index: usize| self.intersect(&rays[index]);
        closest_many::<true, N>(|index| Level::of_scene(self, &rays[index]), active, alone)
    }

    /// [`Tlas::occluded`] of each ray whose bit is set in `active`; the others' bits are zero. `N` is at most 32.
    pub fn occluded_many<const N: usize>(&self, rays: &[Ray; N], active: u32) -> u32 {
        let alone = |index: usize| self.occluded(&rays[index]);
        any_many::<true, N>(|index| Level::of_scene(self, &rays[index]), active, alone)
    }

    /// The nearest hits with `mesh`, which is the shape of instance `shape`; `rays` are in its space.
    pub(super) fn intersect_mesh_many<const N: usize>(
        &self,
        shape: u32,
        mesh: &Blas,
        rays: &[Ray; N],
        active: u32,
    ) -> [Option<Hit>; N] {
        let alone = |index: usize| Some(Hit::of_mesh(shape, mesh.intersect(&rays[index])?));
        closest_many::<false, N>(|index| Level::of_mesh(self, shape, mesh, &rays[index]), active, alone)
    }

    /// As [`Self::intersect_mesh_many`], the bits of those that hit anything.
    pub(super) fn occluded_mesh_many<const N: usize>(
        &self,
        shape: u32,
        mesh: &Blas,
        rays: &[Ray; N],
        active: u32,
    ) -> u32 {
        let alone = |index: usize| mesh.occluded(&rays[index]);
        any_many::<false, N>(|index| Level::of_mesh(self, shape, mesh, &rays[index]), active, alone)
    }
}

/// The nearest hits of the rays in `active`; `alone` finds that of a ray by itself.
#[inline(always)]
fn closest_many<'a, const DEEP: bool, const N: usize>(
    level: impl Fn(usize) -> Level<'a>,
    active: u32,
    alone: impl Fn(usize) -> Option<Hit>,
) -> [Option<Hit>; N] {
    let mut hits = [None; N];
    walk_many::<false, DEEP, N>(level, active, |index, walk| {
        hits[index] = if walk.lost { alone(index) } else { walk.hit };
    });
    hits
}

/// The bits of the rays in `active` that hit anything; `alone` asks for a ray by itself.
#[inline(always)]
fn any_many<'a, const DEEP: bool, const N: usize>(
    level: impl Fn(usize) -> Level<'a>,
    active: u32,
    alone: impl Fn(usize) -> bool,
) -> u32 {
    let mut occluded = 0;
    walk_many::<true, DEEP, N>(level, active, |index, walk| {
        let hit = if walk.lost { alone(index) } else { walk.hit.is_some() };
        occluded |= u32::from(hit) << index;
    });
    occluded
}

/// Each ray from where `level` has it begin. With `ANY` a walk ends at its first hit; without `DEEP` all of them stay in the mesh where
/// they begin.
#[inline(always)]
fn walk_many<'a, const ANY: bool, const DEEP: bool, const N: usize>(
    level: impl Fn(usize) -> Level<'a>,
    active: u32,
    mut finish: impl FnMut(usize, &Walk<ANY, DEEP>),
) {
    const { assert!(N <= u32::BITS as usize) };
    // They are large: made where they stay.
    let mut stacks: [Stack; N] = [const { Stack::new_const() }; N];
    let mut walks = ArrayVec::<Walk<ANY, DEEP>, N>::new();
    for (index, stack) in stacks.iter_mut().enumerate() {
        walks.push(Walk::new(level(index), stack));
    }
    let mut turns = Turns::default();
    for (index, walk) in walks.iter_mut().enumerate() {
        if active >> index & 1 == 1 {
            walk.begin();
            turns.give::<DEEP>(index, walk.go_on());
        }
    }
    while turns != Turns::default() {
        let now = std::mem::take(&mut turns);
        for index in members::<N>(now.at_nodes) {
            let walk = &mut walks[index];
            walk.visit_node();
            turns.give::<DEEP>(index, walk.go_on());
        }
        let asked = turns;
        turns.prefetch(&walks);
        for index in members::<N>(now.at_triangles) {
            let walk = &mut walks[index];
            walk.visit_triangles();
            turns.give::<DEEP>(index, walk.go_on());
        }
        for index in members::<N>(now.at_shapes) {
            let walk = &mut walks[index];
            if walk.visit_elsewhere() {
                turns.give::<DEEP>(index, walk.go_on());
            }
        }
        turns.without(asked).prefetch(&walks);
    }
    for index in members::<N>(active) {
        finish(index, &walks[index]);
    }
}

/// What a ray visits next.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Place {
    Node,
    Triangles,
    /// A shape, or what is around the present space.
    Elsewhere,
}

/// The rays that have a step to take, by where, a bit for each.
#[derive(Clone, Copy, Default, PartialEq, Eq)]
struct Turns {
    at_nodes: u32,
    at_triangles: u32,
    at_shapes: u32,
}

impl Turns {
    #[inline(always)]
    fn give<const DEEP: bool>(&mut self, index: usize, place: Place) {
        self.at_nodes |= u32::from(place == Place::Node) << index;
        self.at_triangles |= u32::from(place == Place::Triangles) << index;
        self.at_shapes |= u32::from(DEEP && place == Place::Elsewhere) << index;
    }

    fn without(self, other: Self) -> Self {
        Self {
            at_nodes: self.at_nodes & !other.at_nodes,
            at_triangles: self.at_triangles & !other.at_triangles,
            at_shapes: self.at_shapes & !other.at_shapes,
        }
    }

    /// Asks for the memory that the rays need, but for shapes.
    #[inline(always)]
    fn prefetch<const ANY: bool, const DEEP: bool, const N: usize>(self, walks: &ArrayVec<Walk<ANY, DEEP>, N>) {
        for index in members::<N>(self.at_nodes) {
            let walk = &walks[index];
            if let Some(node) = walk.level.bvh.nodes.get(walk.next.index()) {
                node.prefetch();
            }
        }
        for index in members::<N>(self.at_triangles) {
            let walk = &walks[index];
            if let Some(packet) = walk.level.packets.get(walk.next.index()) {
                packet.prefetch();
            }
        }
    }
}

/// The places of the bits that are set, all below `N`.
#[inline(always)]
fn members<const N: usize>(mut mask: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let index = mask.trailing_zeros() as usize;
        mask &= mask.wrapping_sub(1);
        (index < N).then_some(index)
    })
}

/// A ray in one space: the world, a group in it, or a mesh in either.
#[derive(Clone, Copy)]
struct Level<'a> {
    /// The world or the group.
    scene: &'a Tlas,
    /// The mesh's, or else the scene's.
    bvh: &'a Bvh,
    /// The mesh's, or else none.
    packets: &'a [TrianglePacket],
    ray: Ray,
    slabs: RaySlabs,
    /// Within a mesh.
    triangle_ray: TriangleRay,
    /// Which in the world the group is.
    placement: Option<u32>,
    /// Which in the scene the mesh is.
    shape: u32,
}

/// Children that may wait in all spaces together; those of a million triangles are about fifty at most.
const WAITING: usize = 96;

impl<'a> Level<'a> {
    #[inline(always)]
    fn of_scene(scene: &'a Tlas, ray: &Ray) -> Self {
        Self {
            scene,
            bvh: &scene.bvh,
            packets: &[],
            ray: *ray,
            slabs: RaySlabs::default(),
            triangle_ray: TriangleRay::default(),
            placement: None,
            shape: 0,
        }
    }

    #[inline(always)]
    fn of_mesh(scene: &'a Tlas, shape: u32, mesh: &'a Blas, ray: &Ray) -> Self {
        Self {
            bvh: mesh.bvh(),
            packets: mesh.packets(),
            triangle_ray: TriangleRay::new(ray),
            shape,
            ..Self::of_scene(scene, ray)
        }
    }
}

/// Children that wait, and where the ray enters them.
type Stack = ArrayVec<u64, WAITING>;

/// Waits below all children of a space.
const OUTWARD: u64 = Child::NONE.0 as u64;

struct Walk<'a, const ANY: bool, const DEEP: bool> {
    level: Level<'a>,
    around: ArrayVec<Level<'a>, 2>,
    /// As a lone ray's, those of inner spaces on top.
    waiting: &'a mut Stack,
    next: Child,
    t_max: f32,
    hit: Option<Hit>,
    /// The ray needs more than there is room for, and must go alone.
    lost: bool,
}

impl<'a, const ANY: bool, const DEEP: bool> Walk<'a, ANY, DEEP> {
    /// Of a ray that goes nowhere yet.
    #[inline(always)]
    fn new(level: Level<'a>, waiting: &'a mut Stack) -> Self {
        Self {
            t_max: level.ray.t_max,
            // A leaf of a linear list of triangles has many packets.
            lost: !level.packets.is_empty() && level.bvh.is_linear(),
            level,
            around: ArrayVec::new(),
            waiting,
            next: Child::ROOT,
            hit: None,
        }
    }

    #[inline(always)]
    fn begin(&mut self) {
        if !self.lost && let Some(slabs) = RaySlabs::new(&self.level.ray) {
            self.level.slabs = slabs;
            self.waiting.push(OUTWARD);
            self.waiting.push(u64::from(Child::ROOT.0));
        }
    }

    /// Into a space within the present one.
    #[inline(always)]
    fn enter(&mut self, inner: Level<'a>) {
        let Some(slabs) = RaySlabs::new(&inner.ray) else {
            return;
        };
        let outer = std::mem::replace(&mut self.level, Level { slabs, ..inner });
        let entered = self.around.try_push(outer).is_ok()
            && self.waiting.try_push(OUTWARD).is_ok()
            && self.waiting.try_push(u64::from(Child::ROOT.0)).is_ok();
        if !entered {
            self.give_up();
        }
    }

    fn give_up(&mut self) {
        self.lost = true;
        self.waiting.clear();
    }

    /// To the nearest that waits.
    #[inline(always)]
    fn go_on(&mut self) -> Place {
        self.next = Child(self.waiting.pop().unwrap_or(OUTWARD) as u32);
        match (self.next.is_leaf(), self.next == Child::NONE || DEEP && self.level.packets.is_empty()) {
            (false, _) => Place::Node,
            (true, false) => Place::Triangles,
            (true, true) => Place::Elsewhere,
        }
    }

    #[inline(always)]
    fn visit_node(&mut self) {
        let node = &self.level.bvh.nodes[self.next.index()];
        let (enter, met) = node.entries(&self.level.slabs, self.t_max);
        let pushed = if ANY {
            push_unsorted(node, met, self.waiting)
        } else {
            push_sorted(node, enter, met, self.waiting)
        };
        if pushed.is_err() {
            self.give_up();
        }
    }

    #[inline(always)]
    fn visit_triangles(&mut self) {
        let number = self.next.index();
        let packet = &self.level.packets[number];
        if let Some(found) = packet.closest(number, &self.level.triangle_ray, self.t_max) {
            self.take(Hit::of_mesh(self.level.shape, found));
        }
    }

    /// A shape, or out of the present space; false if there is nothing around it.
    fn visit_elsewhere(&mut self) -> bool {
        if self.next != Child::NONE {
            self.visit_shape();
            return true;
        }
        let outer = self.around.pop();
        outer.map(|outer| self.level = outer).is_some()
    }

    /// Out of line as in [`Tlas::intersect`]: most steps are within meshes.
    #[inline(never)]
    fn visit_shape(&mut self) {
        let level = self.level;
        let bvh = &level.scene.bvh;
        let &[item] = &bvh.order()[bvh.leaf_range(self.next)] else {
            // A linear list.
            return self.give_up();
        };
        let ray = Ray {
            t_max: self.t_max,
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
            Item::Packet(packet) => return self.visit_packet(packet, &ray),
        };
        let ray = shape.local_ray(&ray);
        if let Primitive::Mesh(mesh) = &shape.primitive {
            // A leaf of a linear list has many packets.
            if mesh.bvh().is_linear() {
                return self.give_up();
            }
            self.enter(Level {
                bvh: mesh.bvh(),
                packets: mesh.packets(),
                triangle_ray: TriangleRay::new(&ray),
                ray,
                shape: item,
                ..level
            });
        } else if let Some(hit) = shape.primitive.intersect(&ray) {
            self.take(Hit::of_shape(item, hit));
        }
    }

    /// Out of line once more: its vectors take room that other shapes do without.
    #[inline(never)]
    fn visit_packet(&mut self, packet: &ShapePacket, ray: &Ray) {
        if let Some(hit) = packet.closest(ray) {
            self.take(hit);
        }
    }

    #[inline(always)]
    fn take(&mut self, hit: Hit) {
        self.t_max = hit.t;
        self.hit = Some(match self.level.placement {
            None => hit,
            Some(placement) => Hit {
                instance: placement,
                member: hit.instance,
                ..hit
            },
        });
        if ANY {
            self.waiting.clear();
            return;
        }
        // What is entered behind the hit waits no longer.
        let farthest = u64::from(hit.t.to_bits()) << 32 | u64::from(u32::MAX);
        let mut kept = 0;
        for place in 0..self.waiting.len() {
            let entry = self.waiting[place];
            self.waiting[kept] = entry;
            kept += usize::from(entry <= farthest);
        }
        self.waiting.truncate(kept);
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{Affine3A, Vec3};

    use super::*;
    use crate::accel::{Instance, SplitMethod};
    use crate::geometry::mesh::MeshData;

    /// Ever larger triangles away from the ray's origin, whose boxes it meets beside them, and a sphere that it hits behind them: their
    /// tree is a chain.
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
        let mut lost = [false; 2];
        let level = |index: usize| Level::of_scene(&scene, &rays[index]);
        walk_many::<false, true, 2>(level, 3, |index, walk| lost[index] = walk.lost);
        assert_eq!(lost, [true, false]);
        let alone = rays.map(|ray| scene.intersect(&ray));
        assert_eq!(alone.map(|hit| hit.map(|hit| hit.instance)), [Some(110), None]);
        assert_eq!(scene.intersect_many(&rays, 3), alone);
        assert_eq!(scene.occluded_many(&rays, 3), 1);
    }
}
