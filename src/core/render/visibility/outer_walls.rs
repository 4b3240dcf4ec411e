//! The outer walls of rooms, which a camera outside sees through: ceilings, floors and walls that are solid and have a
//! front on either side.
//!
//! Scenes do not mark walls, so they are detected by geometry. A wall is a flat shape that at least two other flat
//! shapes touch at right angles. Its outer side is the one with next to no shapes: the room is on the other one. A wall
//! between two rooms has no outer side, and neither has a table top or a board of a shelf under a ceiling, which covers
//! it.

use std::sync::Arc;

use glam::{Vec3, Vec3A};

use crate::accel::{Instance, Primitive, Tlas};
use crate::math::Aabb;

/// The largest thickness of a flat shape, relative to its width.
const THICKNESS: f32 = 0.2;
/// The most walls of a scene, the largest ones.
const MOST: usize = 64;
/// The most shapes of a scene in which walls are detected: the detection runs between two frames of a window, even
/// while an object is dragged.
const MOST_SHAPES: usize = 30_000;
/// The largest gap between touching shapes, relative to the larger one's half extent.
const GAP: f32 = 0.02;
/// The cosine of the angle between normals below which walls are perpendicular.
const PERPENDICULAR: f32 = 0.3;
/// The fewest flat shapes that touch a wall.
const NEIGHBOURS: usize = 2;
/// The least ratio of the number of shapes inside to that outside.
const INSIDE_FOR_EACH_OUTSIDE: usize = 3;
/// The least cosine between the outward direction and the normal of a wall's outer face.
const OUTER_FACE: f32 = 0.7;
/// The least cosine between the inward direction and a ray that clearly comes from outside.
const SEEN_FROM_OUTSIDE: f32 = 0.3;
/// A shape that hides this share of a wall's width and height from outside covers it.
const COVERED: f32 = 0.9;

/// The outer walls of a scene: the items of its hierarchy, in their order, each with the unit vector that points out of
/// the room, in world space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OuterWalls(Arc<Vec<(u32, Vec3)>>);

/// A flat shape.
struct Slab {
    item: u32,
    center: Vec3,
    /// Unit, along the thickness.
    normal: Vec3,
    /// Unit, along the width and height.
    sides: [Vec3; 2],
    /// Half of the thickness, and of the width and height.
    thickness: f32,
    extent: [f32; 2],
}

impl OuterWalls {
    /// Finds the outer walls among the shapes outside groups.
    pub fn find(scene: &Tlas) -> Self {
        if scene.instances().len() > MOST_SHAPES {
            return Self::default();
        }
        let mut slabs: Vec<Slab> = (0..).zip(scene.instances().iter()).filter_map(slab).collect();
        if slabs.len() > MOST {
            let larger = |a: &Slab, b: &Slab| b.area().total_cmp(&a.area()).then(a.item.cmp(&b.item));
            slabs.select_nth_unstable_by(MOST, larger);
            slabs.truncate(MOST);
        }
        let bounds: Vec<Aabb> = scene.instances().iter().map(Instance::world_bounds).collect();
        let is_wall = |slab: &&Slab| {
            let (own, gap) = (bounds[slab.item as usize], GAP * slab.extent[0].max(slab.extent[1]));
            let near = Aabb {
                min: own.min - gap,
                max: own.max + gap,
            };
            let touches = |other: &&Slab| {
                slab.normal.dot(other.normal).abs() < PERPENDICULAR
                    && !near.intersection(bounds[other.item as usize]).is_empty()
            };
            slabs.iter().filter(touches).count() >= NEIGHBOURS
        };
        let outer = |slab: &Slab| Some((slab.item, slab.outwards(&bounds)?));
        let mut walls: Vec<(u32, Vec3)> = slabs.iter().filter(is_wall).filter_map(outer).collect();
        walls.sort_by_key(|(item, _)| *item);
        Self(Arc::new(walls))
    }

    /// The index of an item among the walls, below 64; None if it is not one.
    pub(super) fn place_of(&self, item: u32) -> Option<usize> {
        self.0.binary_search_by_key(&item, |(item, _)| *item).ok()
    }

    /// Whether a ray in direction `dir` comes from outside where it meets a front of the wall at `place` that has this
    /// normal: the outer face itself, or the top or an end of the wall if the ray clearly comes from outside.
    pub(super) fn is_entered(&self, place: usize, normal: Vec3, dir: Vec3) -> bool {
        self.0[place].1.dot(normal) > OUTER_FACE || self.is_seen_from_outside(place, dir)
    }

    /// Whether a ray in direction `dir` clearly comes from the outer side of the wall at `place`.
    pub(super) fn is_seen_from_outside(&self, place: usize, dir: Vec3) -> bool {
        self.0[place].1.dot(dir) < -SEEN_FROM_OUTSIDE * dir.length()
    }
}

fn slab((item, shape): (u32, &Instance)) -> Option<Slab> {
    let local = match &shape.primitive {
        Primitive::Mesh(blas) => blas.bounds(),
        Primitive::Rectangle | Primitive::Disk => Aabb {
            min: Vec3::new(-1.0, -1.0, 0.0),
            max: Vec3::new(1.0, 1.0, 0.0),
        },
        Primitive::Sphere | Primitive::Cylinder | Primitive::Curves(_) => return None,
    };
    let half = 0.5 * local.extent();
    let linear = shape.world_from_local.matrix3;
    let mut axes = [linear.x_axis * half.x, linear.y_axis * half.y, linear.z_axis * half.z];
    axes.sort_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    let [thickness, width, height] = axes.map(Vec3A::length);
    let sides = [axes[1], axes[2]].map(|axis| Vec3::from(axis).try_normalize());
    let [Some(across), Some(along)] = sides else {
        return None;
    };
    let normal = across.cross(along).try_normalize()?;
    (thickness <= THICKNESS * width).then(|| Slab {
        item,
        center: shape.world_from_local.transform_point3(local.center()),
        normal,
        sides: [across, along],
        thickness,
        extent: [width, height],
    })
}

impl Slab {
    fn area(&self) -> f32 {
        self.extent[0] * self.extent[1]
    }

    /// The direction that points out of the room; None if there are shapes on both sides, or on neither.
    fn outwards(&self, bounds: &[Aabb]) -> Option<Vec3> {
        let far = 2.0 * self.extent[0].max(self.extent[1]);
        // For the side of the normal, and for the other one: the number of shapes, and whether one covers the wall.
        let mut sides = [(0, false); 2];
        let others = (0..).zip(bounds).filter(|(item, _)| *item != self.item);
        for (_, other) in others.filter(|(_, bounds)| !bounds.is_empty()) {
            let (center, half) = (other.center() - self.center, 0.5 * other.extent());
            let height = center.dot(self.normal);
            if !(self.thickness..far).contains(&height.abs()) {
                continue;
            }
            let side = &mut sides[usize::from(height < 0.0)];
            let across = |axis: usize| (center.dot(self.sides[axis]), half.dot(self.sides[axis].abs()));
            let is_before = |axis: usize| across(axis).0.abs() <= self.extent[axis];
            let covers = |axis: usize| {
                let ((center, half), extent) = (across(axis), self.extent[axis]);
                let hidden = (center + half).min(extent) - (center - half).max(-extent);
                hidden >= COVERED * 2.0 * extent
            };
            side.1 |= covers(0) && covers(1);
            side.0 += usize::from(is_before(0) && is_before(1));
        }
        let is_outer = |outside: (usize, bool), inside: (usize, bool)| {
            !outside.1 && inside.0 > 0 && inside.0 >= INSIDE_FOR_EACH_OUTSIDE * outside.0
        };
        match () {
            _ if is_outer(sides[0], sides[1]) => Some(self.normal),
            _ if is_outer(sides[1], sides[0]) => Some(-self.normal),
            _ => None,
        }
    }
}
