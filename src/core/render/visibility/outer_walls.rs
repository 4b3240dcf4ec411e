//! The outer walls of rooms, which a camera outside sees through: roofs, ceilings, floors and walls that are solid and
//! have a front on either side.
//!
//! Scenes do not mark walls, so they are detected by geometry. A wall is a flat shape that at least two other flat
//! shapes touch at right angles. Its outer side is the one with next to no shapes: the room is on the other one. A wall
//! between two rooms has no outer side, and neither has a table top or a board of a shelf under a ceiling, which covers
//! it. A roof with slopes is as high as a wall or higher: it is a mesh that lies on at least two walls or on a ceiling,
//! with next to no shapes on its other side.

use std::sync::Arc;

use glam::{Vec3, Vec3A};

use crate::accel::{Instance, Primitive, Tlas};
use crate::math::Aabb;

/// The largest thickness of a flat shape, relative to its width.
const THICKNESS: f32 = 0.2;
/// The same of a roof.
const ROOF_THICKNESS: f32 = 1.0;
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
/// The least area of a ceiling that carries a roof, relative to the roof's.
const CEILING: f32 = 0.5;

/// The outer walls of a scene, in the order of their items.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OuterWalls(Arc<Vec<Wall>>);

/// An outer wall, or a roof.
#[derive(Clone, Debug, PartialEq)]
struct Wall {
    /// The item of the hierarchy.
    item: u32,
    /// The unit vector that points out of the room, in world space.
    outwards: Vec3,
    /// Whether it is a roof, whose slopes are seen from the sides.
    is_roof: bool,
}

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
        let flat_or_thick = (0..).zip(scene.instances().iter()).filter_map(slab);
        let (mut slabs, mut thick): (Vec<Slab>, Vec<Slab>) = flat_or_thick.partition(Slab::is_flat);
        keep_largest(&mut slabs);
        keep_largest(&mut thick);
        let mut bounds: Vec<Aabb> = scene.instances().iter().map(Instance::world_bounds).collect();
        let mut walls: Vec<Wall> = thick.iter().filter_map(|slab| slab.roof(&slabs, &bounds)).collect();
        // A roof does not cover the ceiling below it: both are in front of the rooms.
        walls.iter().for_each(|roof| bounds[roof.item as usize] = Aabb::EMPTY);
        walls.extend(slabs.iter().filter_map(|slab| slab.wall(&slabs, &bounds)));
        walls.truncate(MOST);
        walls.sort_by_key(|wall| wall.item);
        Self(Arc::new(walls))
    }

    /// The index of an item among the walls, below 64; None if it is not one.
    pub(super) fn place_of(&self, item: u32) -> Option<usize> {
        self.0.binary_search_by_key(&item, |wall| wall.item).ok()
    }

    /// Whether a ray in direction `dir` comes from outside where it meets a front of the wall at `place` that has this
    /// normal: the outer face itself, or the top or an end of the wall, or a roof, if the ray clearly comes from
    /// outside.
    pub(super) fn is_entered(&self, place: usize, normal: Vec3, dir: Vec3) -> bool {
        let wall = &self.0[place];
        (!wall.is_roof && wall.outwards.dot(normal) > OUTER_FACE) || self.is_seen_from_outside(place, dir)
    }

    /// Whether a ray in direction `dir` clearly comes from the outer side of the wall at `place`.
    pub(super) fn is_seen_from_outside(&self, place: usize, dir: Vec3) -> bool {
        self.0[place].outwards.dot(dir) < -SEEN_FROM_OUTSIDE * dir.length()
    }
}

/// Keeps the largest of the slabs.
fn keep_largest(slabs: &mut Vec<Slab>) {
    if slabs.len() > MOST {
        let larger = |a: &Slab, b: &Slab| b.area().total_cmp(&a.area()).then(a.item.cmp(&b.item));
        slabs.select_nth_unstable_by(MOST, larger);
        slabs.truncate(MOST);
    }
}

/// A shape as a slab; None if it can be neither a wall nor a roof.
fn slab((item, shape): (u32, &Instance)) -> Option<Slab> {
    let (local, most) = match &shape.primitive {
        Primitive::Mesh(blas) => (blas.bounds(), ROOF_THICKNESS),
        Primitive::Rectangle | Primitive::Disk => {
            let flat = Aabb {
                min: Vec3::new(-1.0, -1.0, 0.0),
                max: Vec3::new(1.0, 1.0, 0.0),
            };
            (flat, THICKNESS)
        }
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
    (thickness <= most * width).then(|| Slab {
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

    fn is_flat(&self) -> bool {
        self.thickness <= THICKNESS * self.extent[0]
    }

    /// The bounds in world space of the shape and of what touches it.
    fn near(&self, bounds: &[Aabb]) -> Aabb {
        let (own, gap) = (bounds[self.item as usize], GAP * self.extent[0].max(self.extent[1]));
        Aabb {
            min: own.min - gap,
            max: own.max + gap,
        }
    }

    /// The wall that this is: it has an outer side, and enough flat shapes touch it at right angles.
    fn wall(&self, slabs: &[Self], bounds: &[Aabb]) -> Option<Wall> {
        let near = self.near(bounds);
        let touches = |other: &&Self| {
            self.normal.dot(other.normal).abs() < PERPENDICULAR
                && !near.intersection(bounds[other.item as usize]).is_empty()
        };
        let is_touched = slabs.iter().filter(touches).count() >= NEIGHBOURS;
        Some(Wall {
            item: self.item,
            outwards: is_touched.then(|| self.outwards(bounds))??,
            is_roof: false,
        })
    }

    /// The roof that this is: it has an outer side, and on the inner one it lies on at least two walls or on a ceiling
    /// that is wide enough.
    fn roof(&self, slabs: &[Self], bounds: &[Aabb]) -> Option<Wall> {
        let outwards = self.outwards(bounds)?;
        let near = self.near(bounds);
        let carries = |other: &&Self| {
            // The eaves of a roof hang below what carries it.
            let is_below = (other.center - self.center).dot(outwards) < -0.5 * self.thickness;
            is_below && !near.intersection(bounds[other.item as usize]).is_empty()
        };
        let carrying = slabs.iter().filter(carries);
        let (ceilings, walls): (Vec<&Self>, Vec<&Self>) =
            carrying.partition(|other| self.normal.dot(other.normal).abs() > PERPENDICULAR);
        let is_wide = |ceiling: &&Self| ceiling.area() >= CEILING * self.area();
        (walls.len() >= NEIGHBOURS || ceilings.iter().any(is_wide)).then_some(Wall {
            item: self.item,
            outwards,
            is_roof: true,
        })
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
