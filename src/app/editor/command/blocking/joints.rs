//! Where walls meet: their ends are moved so that a corner has neither a notch nor two walls in the same place.
//!
//! At right angles the existing wall goes on through the corner, and the new one begins at its side (a butt joint). At
//! other angles both go on until their outer edges meet. A wall that ends at another one's middle ends at its side.

use bevy::math::{Affine3A, Vec3};
use bevy::prelude::Entity;

use super::block::Block;
use super::faces::Face;
use crate::scene::{ShapeKind, Solid};

/// An existing wall, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StandingWall {
    entity: Entity,
    /// The start of its middle line.
    start: Vec3,
    /// The direction of the line and the one through the wall, of unit length.
    along: Vec3,
    across: Vec3,
    length: f32,
    thickness: f32,
}

/// The changes of a new wall and of the existing ones that it meets.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Joints {
    /// The distances by which the start and the end of the new wall move outwards; negative ones make it shorter. World
    /// units.
    pub outwards: [f32; 2],
    /// Walls with one of their end faces and the distance by which it moves outwards.
    pub pushes: Vec<(Entity, Face, f32)>,
}

/// The largest distance of a point from a wall's middle line or beyond its end at which it meets the wall, as a share
/// of the thickness.
const NEAR: f32 = 0.51;
/// The least cosine between parallel walls, and the greatest between perpendicular ones.
const IN_LINE: f32 = 0.99;
const SQUARE: f32 = 0.01;
/// Distances below this share of the thickness move nothing.
const LEAST: f32 = 1e-3;

impl StandingWall {
    /// The wall of this shape and pose; None for other shapes.
    pub fn of(entity: Entity, kind: &ShapeKind, pose: &Affine3A) -> Option<Self> {
        let ShapeKind::Solid(Solid::Wall { length, thickness, .. }) = kind else {
            return None;
        };
        let [x, y] = [pose.matrix3.x_axis, pose.matrix3.y_axis].map(Vec3::from);
        Some(Self {
            entity,
            start: pose.translation.into(),
            along: x.try_normalize()?,
            across: y.try_normalize()?,
            length: length * x.length(),
            thickness: thickness * y.length(),
        })
    }

    /// The coordinates along and across its middle line of a point at its foot, if that is within the wall or close to
    /// its end.
    fn place_of(&self, point: Vec3) -> Option<[f32; 2]> {
        let way = point - self.start;
        let [x, y] = [self.along, self.across].map(|axis| way.dot(axis));
        let above = (way - x * self.along - y * self.across).length();
        let near = NEAR * self.thickness;
        let is_at = (-near..=self.length + near).contains(&x) && y.abs() <= near && above <= near;
        is_at.then_some([x, y])
    }

    /// The end face nearer to a position along the wall, and how far beyond that end the position is (negative: before
    /// it).
    fn nearer_end(&self, x: f32) -> (Face, f32) {
        let is_far = x > 0.5 * self.length;
        let beyond = if is_far { x - self.length } else { -x };
        (Face { axis: 0, is_far }, beyond)
    }
}

/// The joints of a new wall with existing ones.
pub fn joints(block: &Block, walls: &[StandingWall]) -> Joints {
    let Some(along) = (block.to - block.from).try_normalize() else {
        return Joints::default();
    };
    let mut pushes = Vec::new();
    let half = 0.5 * block.thickness;
    let ends = [(block.from, along), (block.to, -along)];
    let outwards = ends.map(|(place, inwards)| join_end(place, inwards, half, walls, &mut pushes));
    let new = StandingWall {
        entity: Entity::PLACEHOLDER,
        start: block.from,
        along,
        across: block.plane.normal.cross(along),
        length: block.from.distance(block.to),
        thickness: block.thickness,
    };
    for wall in walls {
        pushes.extend(end_at_side(wall, &new));
    }
    pushes.retain(|(_, _, by)| by.abs() > LEAST * block.thickness);
    Joints { outwards, pushes }
}

/// The distance by which an end of the new wall moves outwards. `inwards`: the direction from this end to the other.
fn join_end(
    place: Vec3,
    inwards: Vec3,
    half: f32,
    walls: &[StandingWall],
    pushes: &mut Vec<(Entity, Face, f32)>,
) -> f32 {
    let met: Vec<_> = walls
        .iter()
        .filter_map(|wall| wall.place_of(place).map(|place| (wall, place)))
        .collect();
    // Where three walls meet, the corner of the first two is closed already.
    let is_alone = met.len() == 1;
    let ways = met.iter().map(|&(wall, [x, y])| {
        let (end, beyond) = wall.nearer_end(x);
        let its_half = 0.5 * wall.thickness;
        let is_corner = beyond >= -NEAR * wall.thickness;
        let cosine = wall.along.dot(inwards);
        let (way, push) = if cosine.abs() > IN_LINE {
            // The new wall begins where the other one ends, unless they are parallel.
            let goes_on = is_corner && end.is_far == (cosine > 0.0);
            (if goes_on { beyond } else { 0.0 }, None)
        } else if cosine.abs() < SQUARE {
            let side = wall.across.dot(inwards).signum();
            (side * y - its_half, Some(half + beyond))
        } else {
            let sine = (1.0 - cosine * cosine).sqrt();
            let reach = |own: f32, other: f32| ((other - own * cosine.abs()) / sine).max(0.0);
            let way = if is_alone && is_corner {
                reach(half, its_half)
            } else {
                0.0
            };
            (way, Some(reach(its_half, half) + beyond))
        };
        pushes.extend(
            push.filter(|by| is_alone && is_corner && *by > 0.0)
                .map(|by| (wall.entity, end, by)),
        );
        way
    });
    ways.reduce(f32::min).unwrap_or(0.0)
}

/// A wall that ends within the new one, at right angles to it, ends at its side.
fn end_at_side(wall: &StandingWall, new: &StandingWall) -> Option<(Entity, Face, f32)> {
    [false, true].into_iter().find_map(|is_far| {
        let outwards = if is_far { wall.along } else { -wall.along };
        let end = wall.start + wall.along * if is_far { wall.length } else { 0.0 };
        let [x, y] = new.place_of(end)?;
        let (_, beyond) = new.nearer_end(x);
        let is_within = beyond < -NEAR * wall.thickness.max(new.thickness);
        let facing = new.across.dot(outwards);
        (is_within && facing.abs() > IN_LINE).then(|| {
            let by = -facing.signum() * y - 0.5 * new.thickness;
            (wall.entity, Face { axis: 0, is_far }, by)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::editor::command::blocking::block::corners;
    use crate::app::editor::command::blocking::faces::pushed;

    type Built = (ShapeKind, Affine3A);

    /// Walls between points of the ground, each joined to those before.
    fn built(lines: &[[(f32, f32); 2]]) -> Vec<Built> {
        let mut walls: Vec<Built> = Vec::new();
        for ends in lines {
            let [from, to] = ends.map(|(x, z)| Vec3::new(x, 0.0, z));
            let mut block = Block::wall(from, to);
            let standing: Vec<_> = walls
                .iter()
                .enumerate()
                .filter_map(|(index, (kind, pose))| StandingWall::of(Entity::from_raw_u32(index as u32)?, kind, pose))
                .collect();
            let joints = joints(&block, &standing);
            block.lengthen(joints.outwards);
            for (entity, face, by) in joints.pushes {
                let wall = &mut walls[entity.index_u32() as usize];
                *wall = pushed(&wall.0, &wall.1, face, by).expect("it is a wall");
            }
            walls.push(block.shape().expect("a wall"));
        }
        walls
    }

    fn is_inside((kind, pose): &Built, point: Vec3, margin: f32) -> bool {
        let [low, high] = match kind {
            ShapeKind::Solid(part) => part.corners(),
            _ => panic!("it is no wall"),
        };
        let local = pose.inverse().transform_point3(point);
        local.cmpgt(low + margin).all() && local.cmplt(high - margin).all()
    }

    /// The least and the greatest number of walls at the points of a fine grid around a point, at half their height.
    fn counts(walls: &[Built], (x, z): (f32, f32), reach: f32) -> [usize; 2] {
        let steps = -20..=20;
        let places = steps.clone().flat_map(|i| steps.clone().map(move |j| (i, j)));
        let count = |(i, j): (i32, i32)| {
            let off = Vec3::new(i as f32, 0.0, j as f32) * reach / 20.0;
            let place = Vec3::new(x + 0.0013, 1.0, z + 0.0017) + off;
            walls.iter().filter(|wall| is_inside(wall, place, 0.0)).count()
        };
        let counts: Vec<usize> = places.map(count).collect();
        [
            *counts.iter().min().expect("places"),
            *counts.iter().max().expect("places"),
        ]
    }

    #[test]
    fn four_walls_make_a_room_without_notches_and_without_a_place_twice() {
        let points = [(0.0, 0.0), (4.0, 0.0), (4.0, 3.0), (0.0, 3.0)];
        for turned in [false, true] {
            let points = if turned { points.map(|(x, z)| (z, x)) } else { points };
            let lines: Vec<_> = (0..4).map(|at| [points[at], points[(at + 1) % 4]]).collect();
            let room = built(&lines);
            for corner in points {
                assert_eq!(counts(&room, corner, 0.09), [1, 1], "{corner:?}");
            }
            let boxes: Vec<Vec3> = room
                .iter()
                .flat_map(|(kind, pose)| corners(kind, pose).expect("a box"))
                .collect();
            let low = boxes.iter().copied().reduce(Vec3::min).expect("corners");
            let high = boxes.iter().copied().reduce(Vec3::max).expect("corners");
            assert!(low.abs_diff_eq(Vec3::new(-0.1, 0.0, -0.1), 1e-5), "{low}");
            let far = if turned {
                Vec3::new(3.1, 2.5, 4.1)
            } else {
                Vec3::new(4.1, 2.5, 3.1)
            };
            assert!(high.abs_diff_eq(far, 1e-5), "{high}");
        }
    }

    #[test]
    fn walls_may_meet_in_a_t_in_a_cross_and_in_line() {
        let a = [(0.0, 0.0), (4.0, 0.0)];
        let t = built(&[a, [(2.0, 0.0), (2.0, 3.0)]]);
        assert_eq!(counts(&t, (2.0, 0.05), 0.04), [1, 1]);
        assert_eq!(counts(&t, (2.0, 0.15), 0.09), [1, 1], "there is no gap beside it");
        let other_t = built(&[[(2.0, 3.0), (2.0, 0.0)], a]);
        assert_eq!(counts(&other_t, (2.0, 0.05), 0.09), [1, 1]);
        let line = built(&[a, [(4.0, 0.0), (6.0, 0.0)]]);
        assert_eq!(counts(&line, (4.0, 0.0), 0.09), [1, 1]);
        // A corner, and then the two other walls that meet at it.
        let arms = [
            [(4.0, 0.0), (4.0, 3.0)],
            [(4.0, 0.0), (4.0, -3.0)],
            [(4.0, 0.0), (7.0, 0.0)],
        ];
        let cross = built(&[a, arms[0], arms[1], arms[2]]);
        assert_eq!(counts(&cross, (4.0, 0.0), 0.09), [1, 1]);
        let cross = built(&[a, arms[2], arms[0], arms[1]]);
        assert_eq!(counts(&cross, (4.0, 0.0), 0.09), [1, 1]);
    }

    #[test]
    fn outer_edges_meet_at_other_angles() {
        let corner = (4.0, 0.0);
        for degrees in [30f32, 60.0, 80.0, -45.0] {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let end = (4.0 + 3.0 * cosine, 3.0 * sine);
            for line in [[corner, end], [end, corner]] {
                let walls = built(&[[(0.0, 0.0), corner], line]);
                let outer = 0.1 * (0.5 * degrees.to_radians()).tan().abs();
                let tip = Vec3::new(4.0 + outer, 1.0, -0.1 * degrees.signum());
                let towards = (Vec3::new(4.0, 1.0, 0.0) - tip).normalize();
                let just = |off: f32| walls.iter().any(|wall| is_inside(wall, tip + towards * off, 0.0));
                assert!(just(2e-3) && !just(-2e-3), "{degrees} {line:?}");
            }
        }
    }

    #[test]
    fn walls_that_do_not_meet_stay_as_they_are() {
        let lines = [
            [(0.0, 0.0), (4.0, 0.0)],
            [(4.2, 0.0), (4.2, 3.0)],
            [(1.0, 0.2), (3.0, 0.2)],
        ];
        for (wall, ends) in built(&lines).iter().zip(lines) {
            let length = (ends[1].0 - ends[0].0).hypot(ends[1].1 - ends[0].1);
            assert!(matches!(wall.0, ShapeKind::Solid(Solid::Wall { length: is, .. }) if (is - length).abs() < 1e-5));
        }
    }
}
