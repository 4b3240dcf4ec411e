//! Spheres, rectangles and disks that are close together are tested against one ray at once: a shape per lane, where
//! [`super::small_scene`] has a ray per lane.

use std::ops::Range;

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::build::SplitMethod;
use super::bvh::Bvh;
use super::collapse::NO_PRIMITIVE;
use super::hit::Hit;
use super::instance::{Instance, Primitive};
use super::instances::Instances;
use super::obstacle::Obstacle;
use super::ray_lanes::RayLanes;
use super::shape_lanes::{in_rectangle, local, plane, round, sphere};
use crate::geometry::local::LocalHit;
use crate::math::lanes::{LANES, Lanes, Vec3Lanes, each_lane, lanes_of};
use crate::math::{Aabb, Ray};

/// The fewest shapes for which a block is faster.
const FEWEST: usize = 3;

/// Up to sixteen shapes.
#[derive(Clone, Debug)]
pub(super) struct ShapeBlock {
    /// Their bounds in the world.
    pub bounds: Aabb,
    /// The rows of the world-to-local matrices, and the shapes' origins in the world.
    rows: [Vec3Lanes; 3],
    place: Vec3Lanes,
    /// The squares of their world radii, if all of them are spheres scaled uniformly.
    squared_radii: Option<Lanes>,
    /// The lanes that hold spheres, rectangles and disks, a bit each.
    spheres: u32,
    rectangles: u32,
    disks: u32,
}

/// The indices of a block's shapes among the instances; only the first lanes are used. They are apart from the block,
/// because an edit of the scene renumbers many shapes but changes few.
#[derive(Clone, Copy, Debug)]
pub(super) struct Members([u32; LANES]);

impl Members {
    fn of(members: &[u32]) -> Self {
        let mut all = [NO_PRIMITIVE; LANES];
        all[..members.len()].copy_from_slice(members);
        Self(all)
    }

    /// The indices without unused lanes.
    pub fn indices(&self) -> &[u32] {
        let used = self.0.iter().take_while(|&&member| member != NO_PRIMITIVE).count();
        &self.0[..used]
    }

    /// Gives the shapes new numbers.
    pub fn renumber(&mut self, new: impl Fn(u32) -> u32) {
        let used = self.indices().len();
        self.0[..used].iter_mut().for_each(|member| *member = new(*member));
    }
}

impl ShapeBlock {
    /// Makes blocks of shapes of similar size that are close together. Other shapes are faster by themselves. A linear
    /// list has no blocks.
    pub fn gather(instances: &Instances, method: SplitMethod) -> Vec<(Self, Members)> {
        if method == SplitMethod::Linear {
            return Vec::new();
        }
        let bounds: Vec<Aabb> = (0..instances.len())
            .into_par_iter()
            .map(|number| match &instances[number] {
                shape if Self::takes(shape) => shape.world_bounds(),
                _ => Aabb::EMPTY,
            })
            .collect();
        let around = |members: &[u32]| {
            members
                .iter()
                .fold(Aabb::EMPTY, |all, &member| all.union(bounds[member as usize]))
        };
        // A floor in a block of many small shapes would blow up the block's box.
        let dwarfs = |place: usize, members: &[u32]| {
            let others = around(&members[..place]).union(around(&members[place + 1..]));
            bounds[members[place] as usize].half_area() > 2.0 * others.half_area()
        };
        let block = |leaf: &[u32]| {
            let mut members: Vec<u32> = leaf.iter().copied().filter(|&member| member != NO_PRIMITIVE).collect();
            while members.len() >= FEWEST {
                match (0..members.len()).find(|&place| dwarfs(place, &members)) {
                    Some(place) => members.remove(place),
                    None => return Some(Self::new(instances, &members, around(&members))),
                };
            }
            None
        };
        let leaves = Bvh::build(&bounds, method, LANES);
        leaves.order().par_chunks(LANES).filter_map(block).collect()
    }

    /// Whether a block can hold this shape.
    pub fn takes(shape: &Instance) -> bool {
        match shape.primitive {
            Primitive::Sphere | Primitive::Rectangle | Primitive::Disk => true,
            Primitive::Mesh(_) | Primitive::Curves(_) | Primitive::Cylinder => false,
        }
    }

    /// Makes blocks of all these shapes, given by their numbers, also of distant ones.
    pub fn gather_all(instances: &Instances, members: &[u32]) -> Vec<(Self, Members)> {
        let bounds: Vec<Aabb> = members
            .iter()
            .map(|&member| instances[member as usize].world_bounds())
            .collect();
        let leaves = Bvh::build(&bounds, SplitMethod::Sah, LANES);
        let block = |leaf: &[u32]| {
            let held = leaf.iter().filter(|&&held| held != NO_PRIMITIVE);
            let held: Vec<u32> = held.map(|&held| members[held as usize]).collect();
            Self::of(instances, &held)
        };
        leaves.order().chunks(LANES).map(block).collect()
    }

    /// A block of these shapes, which may be empty.
    pub fn of(instances: &Instances, members: &[u32]) -> (Self, Members) {
        let bounds = members.iter().map(|&member| instances[member as usize].world_bounds());
        Self::new(instances, members, bounds.fold(Aabb::EMPTY, Aabb::union))
    }

    fn new(instances: &Instances, members: &[u32], bounds: Aabb) -> (Self, Members) {
        let mut block = Self {
            bounds,
            rows: [Vec3Lanes::ZERO; 3],
            place: Vec3Lanes::ZERO,
            squared_radii: Some(Lanes::ZERO),
            spheres: 0,
            rectangles: 0,
            disks: 0,
        };
        for (lane, &member) in members.iter().enumerate() {
            let shape = &instances[member as usize];
            for (row, lanes) in block.rows.iter_mut().enumerate() {
                lanes.set(lane, shape.local_from_world.matrix3.row(row).into());
            }
            block.place.set(lane, shape.world_from_local.translation.into());
            let radius = radius(shape);
            block.squared_radii = block.squared_radii.zip(radius).map(|(mut squares, radius)| {
                squares.as_mut_array()[lane] = radius * radius;
                squares
            });
            let kind = match shape.primitive {
                Primitive::Sphere => &mut block.spheres,
                Primitive::Rectangle => &mut block.rectangles,
                _ => &mut block.disks,
            };
            *kind |= 1 << lane;
        }
        (block, Members::of(members))
    }

    #[inline(always)]
    fn test(&self, ray: &Ray) -> BlockHits {
        let rays = RayLanes::splat(ray);
        if let Some(squares) = self.squared_radii {
            let around = RayLanes {
                origin: rays.origin - self.place,
                ..rays
            };
            let hit = round(&around, squares, rays.t_max);
            return BlockHits {
                t: hit.t,
                u: hit.u,
                v: hit.v,
                met: hit.met.to_bitmask() & self.spheres,
            };
        }
        let local = local(&rays, &self.rows, self.place);
        let (mut t, mut met) = (Lanes::ZERO, Lanes::ZERO);
        let (mut u, mut v) = (Lanes::ZERO, Lanes::ZERO);
        if self.spheres != 0 {
            let hit = sphere(&local, local.t_max);
            t = hit.t;
            met = hit.met & lanes_of(self.spheres);
        }
        if self.rectangles | self.disks != 0 {
            let hit = plane(&local, local.t_max);
            let disk = hit.u.mul_add(hit.u, hit.v * hit.v).simd_le(Lanes::ONE) & lanes_of(self.disks);
            let rectangle = in_rectangle(hit.u, hit.v) & lanes_of(self.rectangles);
            let here = hit.met & (disk | rectangle);
            t = here.select(hit.t, t);
            met |= here;
            (u, v) = (here & hit.u, here & hit.v);
        }
        let met = met.to_bitmask();
        BlockHits { t, u, v, met }
    }

    /// The nearest hit. `members` must be this block's.
    #[inline]
    pub fn closest(&self, members: &Members, ray: &Ray) -> Option<Hit> {
        let BlockHits { t, u, v, met } = self.test(ray);
        let t = t.as_array();
        let nearest = each_lane(met).reduce(|a, b| if t[b] < t[a] { b } else { a })?;
        let hit = LocalHit {
            t: t[nearest],
            u: u.as_array()[nearest],
            v: v.as_array()[nearest],
        };
        Some(Hit::of_shape(members.0[nearest], hit))
    }

    /// The obstacle on the ray, where `is_clear` is true for shapes that light may pass straight through.
    #[inline]
    pub fn obstacle(&self, members: &Members, ray: &Ray, is_clear: impl Fn(usize) -> bool) -> Obstacle {
        let BlockHits { met, .. } = self.test(ray);
        let is_opaque = each_lane(met).any(|place| !is_clear(members.0[place] as usize));
        match (met, is_opaque) {
            (0, _) => Obstacle::Nothing,
            (_, is_opaque) => Obstacle::of(!is_opaque),
        }
    }
}

/// The hits of one ray with the shapes of a block, and the mask of the lanes that are hit.
struct BlockHits {
    t: Lanes,
    u: Lanes,
    v: Lanes,
    met: u32,
}

/// The range of radii whose squares neither overflow nor lose digits.
const SQUARABLE: Range<f32> = 1e-15..1e15;

/// The world radius of a sphere that the transform scales uniformly.
fn radius(shape: &Instance) -> Option<f32> {
    let Primitive::Sphere = shape.primitive else {
        return None;
    };
    let axes = shape.exact_world_from_local().matrix3;
    let squares = axes.transpose() * axes;
    let square = squares.x_axis.x;
    // The tolerance is the resolution of single precision.
    let is_round = squares.abs_diff_eq(DMat3::from_diagonal(DVec3::splat(square)), 2e-7 * square);
    let radius = square.sqrt() as f32;
    (is_round && SQUARABLE.contains(&radius)).then_some(radius)
}

#[cfg(test)]
mod tests {
    use glam::{Affine3A, Quat, Vec3};

    use super::*;
    use crate::math::offset_origin;

    fn placed(primitive: Primitive, size: Vec3, turn: f32, at: Vec3) -> Instance {
        let turned = Quat::from_axis_angle(Vec3::new(0.6, 0.0, 0.8), turn);
        Instance::new(primitive, Affine3A::from_scale_rotation_translation(size, turned, at)).unwrap()
    }

    fn row(size: impl Fn(usize) -> Vec3) -> Vec<Instance> {
        (0..40)
            .map(|k| {
                placed(
                    Primitive::Sphere,
                    size(k),
                    k as f32,
                    Vec3::new(3.0 * k as f32, 0.5, -700.0),
                )
            })
            .collect()
    }

    #[test]
    fn shapes_are_gathered_by_place() {
        let mut shapes = row(|_| Vec3::ONE);
        shapes.push(placed(Primitive::Cylinder, Vec3::ONE, 0.0, Vec3::ZERO));
        let blocks = ShapeBlock::gather(&shapes.clone().into(), SplitMethod::Sah);
        let mut members: Vec<u32> = blocks
            .iter()
            .flat_map(|(_, members)| members.indices())
            .copied()
            .collect();
        for (block, members) in &blocks {
            let around = members.indices().iter().map(|&k| shapes[k as usize].world_bounds());
            assert_eq!(block.bounds, around.fold(Aabb::EMPTY, Aabb::union));
            assert!((FEWEST..=LANES).contains(&members.indices().len()));
        }
        members.sort_unstable();
        assert!(members.is_sorted_by(|a, b| a < b) && members.iter().all(|&k| k < 40));
        assert!(members.len() > 30, "{members:?}");
        // The same with a floor, which stays outside of blocks.
        let floor = placed(
            Primitive::Rectangle,
            Vec3::splat(1e3),
            0.0,
            Vec3::new(60.0, 0.0, -700.0),
        );
        shapes.insert(0, floor);
        let blocks = ShapeBlock::gather(&shapes.clone().into(), SplitMethod::Sah);
        assert!(blocks.iter().all(|(_, members)| !members.indices().contains(&0)));
        assert!(blocks.iter().map(|(_, members)| members.indices().len()).sum::<usize>() > 30);
        assert!(ShapeBlock::gather(&shapes.clone().into(), SplitMethod::Linear).is_empty());
        assert!(ShapeBlock::gather(&shapes[..3].to_vec().into(), SplitMethod::Sah).is_empty());
    }

    /// Spheres that are round in the world, and stretched ones: a ray that starts on one does not hit it from outside.
    #[test]
    fn spheres_are_met_once_from_outside_and_again_from_within() {
        for shapes in [
            row(|_| Vec3::splat(1.2)),
            row(|k| Vec3::new(1.2, 0.3 + 0.02 * k as f32, 0.9)),
        ] {
            let scene = crate::accel::Tlas::build(shapes.clone(), SplitMethod::Sah);
            let blocks = ShapeBlock::gather(&shapes.clone().into(), SplitMethod::Sah);
            assert_eq!(
                blocks[0].0.squared_radii.is_some(),
                shapes[0].world_bounds().min.y < -0.6
            );
            let mut met = 0;
            for k in 0..2000 {
                let part = |factor: f32| (k as f32 * factor).fract() - 0.5;
                let dir = Vec3::new(part(0.7548), part(0.5698), part(0.3117)).normalize();
                let target = Vec3::new(3.0 * (k % 40) as f32, 0.5, -700.0);
                let block = (blocks.iter()).find(|(_, members)| members.indices().contains(&(k as u32 % 40)));
                let Some((block, members)) = block else { continue };
                let ray = Ray::new(target - 9.0 * dir, dir);
                let Some(hit) = block.closest(members, &ray) else {
                    panic!("through the middle of {k}")
                };
                met += 1;
                let point = scene.surface(&ray, &hit);
                let n = point.geometric_normal;
                let leave = |dir: Vec3| Ray::new(offset_origin(point.position, point.error, n, dir), dir);
                let outside = leave(n + 0.9 * n.any_orthonormal_vector());
                assert!(
                    block
                        .closest(members, &outside)
                        .is_none_or(|next| next.instance != hit.instance)
                );
                let within = block.closest(members, &leave(-n)).unwrap();
                assert!(within.instance == hit.instance && within.t > 0.2, "{within:?}");
            }
            assert!(met > 1000);
        }
    }
}
