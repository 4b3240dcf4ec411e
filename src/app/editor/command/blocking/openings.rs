//! Cutting doors and windows into walls, and into boxes, which become walls; and holes into floors, which become lying
//! walls.

use bevy::math::{Affine3A, Mat3, Vec3};

use super::{OpeningKind, snapped};
use crate::scene::{Opening, ShapeKind, Solid};

/// A wall with an opening to cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Cut {
    /// The wall before the cut.
    pub wall: Solid,
    /// World from local.
    pub pose: Affine3A,
    /// The opening.
    pub opening: Opening,
    /// Whether it is a hole in a floor, and neither door nor window.
    pub is_hole: bool,
}

/// The largest cosine between two axes that count as perpendicular.
const RIGHT_ANGLE: f32 = 1e-4;

/// A window with a sill lower than this share of the usual one is a French window.
const LOW: f32 = 0.3;
/// The usual hole in a floor, large enough for a ladder. It lies around the point and not at the edge: its sill only
/// has to be above 0.
pub const HOLE: Opening = Opening {
    from: 0.0,
    sill: 1.0,
    width: 1.0,
    height: 1.0,
};
/// The part of the wall that stays above a window of the usual size, as a share of the wall's height.
const LINTEL: f32 = 0.08;

/// A point on the side of a wall or a box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Side {
    /// The point in world space.
    pub place: Vec3,
    /// The normal there, of unit length.
    pub normal: Vec3,
    /// The world's upward direction.
    pub up: Vec3,
}

/// The opening of this kind and of the usual size at a point of a wall's or a box's side. It is rounded to multiples of
/// `step` (world units; 0 for none), and moved into the free part of the wall. A window near the foot of the wall is a
/// French window, which begins at the foot and ends at the height of the others. A window in the upper or lower side of
/// a box is a hole around the point. None if it does not fit.
pub fn at(kind: &ShapeKind, pose: &Affine3A, side: &Side, what: OpeningKind, step: f32) -> Option<Cut> {
    let (wall, pose) = as_wall(kind, pose, side.normal, side.up)?;
    let (length, height) = extents(&wall)?;
    let units = units(&pose);
    let local = pose.inverse().transform_point3(side.place);
    let is_hole = is_lying(&pose, side.up);
    if is_hole && what == OpeningKind::Door {
        return None;
    }
    // Sizes are in world units, also in a scaled wall.
    let of = |opening: Opening| opening.in_wall(height * units[1]);
    let window = of(Opening::WINDOW);
    let low_window = local.z * units[1] < 0.5 * window.height + LOW * window.sill;
    let new = match what {
        _ if is_hole => HOLE,
        OpeningKind::Door => of(Opening::DOOR),
        OpeningKind::Window if low_window => of(Opening::FRENCH_WINDOW),
        OpeningKind::Window => window,
    };
    let width = (new.width / units[0]).min(length);
    let tall = (new.height / units[1]).min(height);
    let snap = |length: f32, unit: f32| snapped(length * unit, step) / unit;
    let from = snap(local.x - 0.5 * width, units[0]).clamp(0.0, length - width);
    let sill = match new.sill > 0.0 {
        false => 0.0,
        true => {
            let lintel = if is_hole { 0.0 } else { LINTEL };
            let highest = (height * (1.0 - lintel) - tall).max(0.0);
            snap(local.z - 0.5 * tall, units[1]).clamp(0.0, highest)
        }
    };
    let opening = Opening {
        from,
        sill,
        width,
        height: tall,
    };
    Some(Cut {
        wall,
        pose,
        opening,
        is_hole,
    })
}

/// The opening between two opposite corners on a side, the second one in world space. Its edges are rounded to
/// multiples of `step`, and a door begins at the foot. `size`: its width and height in world units, if they are typed;
/// then it extends towards the second corner. None if it has no extent.
pub fn between(
    kind: &ShapeKind,
    pose: &Affine3A,
    side: &Side,
    to: Vec3,
    size: &[f32],
    what: OpeningKind,
    step: f32,
) -> Option<Cut> {
    let (wall, pose) = as_wall(kind, pose, side.normal, side.up)?;
    let (length, height) = extents(&wall)?;
    let units = units(&pose);
    let inverse = pose.inverse();
    let [begin, end] = [side.place, to].map(|place| inverse.transform_point3(place));
    let span = |begin: f32, end: f32, unit: f32, given: Option<&f32>, most: f32| {
        let [begin, end] = [begin, end].map(|place| snapped(place * unit, step) / unit);
        let end = given.map_or(end, |given| begin + given / unit * if end < begin { -1.0 } else { 1.0 });
        [begin.min(end), begin.max(end)].map(|place| place.clamp(0.0, most))
    };
    let [left, right] = span(begin.x, end.x, units[0], size.first(), length);
    let [foot, top] = match what {
        OpeningKind::Door => [0.0, begin.z.max(end.z)],
        OpeningKind::Window => [begin.z, end.z],
    };
    let [low, high] = span(foot, top, units[1], size.get(1), height);
    let opening = Opening {
        from: left,
        sill: low,
        width: right - left,
        height: high - low,
    };
    let least = 1e-4 * length.min(height);
    let is_hole = is_lying(&pose, side.up);
    let is_possible = !(is_hole && what == OpeningKind::Door);
    (is_possible && opening.width > least && opening.height > least).then_some(Cut {
        wall,
        pose,
        opening,
        is_hole,
    })
}

/// The length and the height of a wall, in its own units.
fn extents(wall: &Solid) -> Option<(f32, f32)> {
    match *wall {
        Solid::Wall { length, height, .. } => Some((length, height)),
        _ => None,
    }
}

/// The lengths in the world of a wall's own units along it and upwards.
fn units(pose: &Affine3A) -> [f32; 2] {
    [0, 2].map(|axis| Vec3::from(pose.matrix3.col(axis)).length())
}

impl Cut {
    /// The wall with the opening cut, and its pose.
    pub fn done(self) -> (ShapeKind, Affine3A) {
        let mut wall = self.wall;
        if let Solid::Wall { openings, .. } = &mut wall {
            openings.push(self.opening);
        }
        (ShapeKind::Solid(wall), self.pose)
    }

    /// The word for the opening: only its user knows whether an opening that reaches the foot is a door or a French
    /// window.
    pub fn name(&self, what: OpeningKind) -> &'static str {
        match what {
            _ if self.is_hole => "Hole",
            OpeningKind::Door => "Door",
            OpeningKind::Window if self.opening.sill == 0.0 => "French window",
            OpeningKind::Window => "Window",
        }
    }

    /// The width, the height, the distance from the wall's start and the height of the sill, in world units.
    pub fn sizes(&self) -> [f32; 4] {
        let [along, upward] = units(&self.pose);
        let Opening {
            from,
            sill,
            width,
            height,
        } = self.opening;
        [width * along, height * upward, from * along, sill * upward]
    }

    /// The corners of the opening on both sides of the wall, in world space: four in turn around, then the same four on
    /// the other side.
    pub fn corners(&self) -> [Vec3; 8] {
        let Opening {
            from,
            sill,
            width,
            height,
        } = self.opening;
        let half = match self.wall {
            Solid::Wall { thickness, .. } => 0.5 * thickness,
            _ => 0.0,
        };
        let ring = [
            (from, sill),
            (from + width, sill),
            (from + width, sill + height),
            (from, sill + height),
        ];
        let at = |y: f32| ring.map(|(x, z)| self.pose.transform_point3(Vec3::new(x, y, z)));
        let ([a, b, c, d], [e, f, g, h]) = (at(-half), at(half));
        [a, b, c, d, e, f, g, h]
    }
}

/// The shape as a wall, and its pose. The larger upright sides of a box become those of the wall.
pub fn wall_of(kind: &ShapeKind, pose: &Affine3A, up: Vec3) -> Option<(Solid, Affine3A)> {
    let columns = [0, 1, 2].map(|axis| Vec3::from(pose.matrix3.col(axis)));
    if let ShapeKind::Solid(Solid::Wall { .. }) = kind {
        return as_wall(kind, pose, columns[1].normalize_or_zero(), up);
    }
    let upward = facing(&columns, up)?;
    let across = (0..3)
        .filter(|axis| *axis != upward)
        .min_by(|a, b| columns[*a].length().total_cmp(&columns[*b].length()))?;
    as_wall(kind, pose, columns[across].normalize_or_zero(), up)
}

/// The shape as a lying wall, with its pose, for holes from above; None if it is leaning.
pub fn floor_of(kind: &ShapeKind, pose: &Affine3A, up: Vec3) -> Option<(Solid, Affine3A)> {
    as_wall(kind, pose, up, up)
}

/// The wall with the same surface and orientation as a box: axis-aligned if the box is. None for a leaning or sheared
/// box.
pub fn box_as_wall(pose: &Affine3A, up: Vec3) -> Option<(Solid, Affine3A)> {
    let columns = [0, 1, 2].map(|axis| Vec3::from(pose.matrix3.col(axis)));
    let upward = facing(&columns, up)?;
    let level = (0..3).find(|axis| *axis != upward)?;
    let direction = columns[level].try_normalize()?;
    wall_of_box(&columns, pose.translation.into(), upward, direction, up)
}

/// Whether the height of a wall with this pose is level.
fn is_lying(pose: &Affine3A, up: Vec3) -> bool {
    Vec3::from(pose.matrix3.z_axis).normalize_or_zero().dot(up).abs() < 0.5
}

/// The shape as a wall, seen from the side with this normal. A box becomes an upright wall from an upright side and a
/// lying one from above or below.
fn as_wall(kind: &ShapeKind, pose: &Affine3A, normal: Vec3, up: Vec3) -> Option<(Solid, Affine3A)> {
    let columns = [0, 1, 2].map(|axis| Vec3::from(pose.matrix3.col(axis)));
    let across = facing(&columns, normal)?;
    match kind {
        ShapeKind::Solid(wall @ Solid::Wall { .. }) if across == 1 => Some((wall.clone(), *pose)),
        ShapeKind::Cube => {
            let upward = facing(&columns, up)?;
            // The height of a lying wall is the shorter level edge.
            let upward = match upward == across {
                false => upward,
                true => (0..3)
                    .filter(|axis| *axis != across)
                    .min_by(|a, b| columns[*a].length().total_cmp(&columns[*b].length()))?,
            };
            let level = 3 - upward - across;
            let x = columns[level].try_normalize()?;
            let x = positive(x);
            let up = if facing(&columns, up)? == upward {
                up
            } else {
                positive(columns[upward])
            };
            wall_of_box(&columns, pose.translation.into(), upward, x, up)
        }
        _ => None,
    }
}

/// The direction or its opposite, whichever runs along a world axis.
fn positive(direction: Vec3) -> Vec3 {
    direction * direction[direction.abs().max_position()].signum()
}

/// The wall in place of a box with these axes around `middle`, along a direction of unit length that is one of the
/// axes.
fn wall_of_box(
    columns: &[Vec3; 3],
    middle: Vec3,
    upward: usize,
    direction: Vec3,
    up: Vec3,
) -> Option<(Solid, Affine3A)> {
    let is_right =
        |a: usize, b: usize| columns[a].normalize_or_zero().dot(columns[b].normalize_or_zero()).abs() < RIGHT_ANGLE;
    if !(is_right(0, 1) && is_right(1, 2) && is_right(2, 0)) {
        return None;
    }
    let level =
        (0..3).find(|axis| *axis != upward && columns[*axis].normalize_or_zero().dot(direction).abs() > 0.99)?;
    let half = |axis: usize| columns[axis].length();
    let z = columns[upward].normalize() * columns[upward].dot(up).signum();
    let start = middle - direction * half(level) - z * half(upward);
    let wall = Solid::Wall {
        length: 2.0 * half(level),
        height: 2.0 * half(upward),
        thickness: 2.0 * half(3 - upward - level),
        openings: Vec::new(),
    };
    let axes = Mat3::from_cols(direction, z.cross(direction), z);
    Some((wall, Affine3A::from_mat3_translation(axes, start)))
}

/// The axis parallel to a direction; None if there is none.
fn facing(columns: &[Vec3; 3], direction: Vec3) -> Option<usize> {
    (0..3).find(|&axis| columns[axis].normalize_or_zero().dot(direction).abs() > 0.99)
}

#[cfg(test)]
mod tests {
    use bevy::math::Quat;

    use super::*;
    use crate::app::editor::command::blocking::block::corners as corners_of;

    #[test]
    fn a_box_becomes_the_wall_that_it_is() {
        let pose = Affine3A::from_scale_rotation_translation(
            Vec3::new(0.1, 1.25, 2.0),
            Quat::from_rotation_y(0.4),
            Vec3::new(1.0, 1.25, -2.0),
        );
        let normal = Quat::from_rotation_y(0.4) * Vec3::X;
        let place = Vec3::from(pose.translation) + 0.1 * normal;
        let side = Side {
            place,
            normal,
            up: Vec3::Y,
        };
        let cut = at(&ShapeKind::Cube, &pose, &side, OpeningKind::Door, 0.0).expect("a wall");
        let expected = Opening {
            from: 1.55,
            ..Opening::DOOR
        };
        assert!((cut.opening.from - expected.from).abs() < 1e-5 && cut.opening.sill == 0.0);
        let (kind, new_pose) = cut.done();
        let sorted = |kind: &ShapeKind, pose: &Affine3A| {
            let mut corners = corners_of(kind, pose).expect("a box").to_vec();
            corners.sort_by(|a, b| (a.y, a.x, a.z).partial_cmp(&(b.y, b.x, b.z)).expect("numbers"));
            corners
        };
        for (before, after) in sorted(&ShapeKind::Cube, &pose).iter().zip(sorted(&kind, &new_pose)) {
            assert!(before.abs_diff_eq(after, 1e-5), "{before} {after}");
        }
        assert!(new_pose.matrix3.determinant() > 0.0);
    }

    #[test]
    fn a_hole_is_cut_into_a_floor() {
        // A slab of 6 x 0.2 x 4 around the origin.
        let pose = Affine3A::from_scale(Vec3::new(3.0, 0.1, 2.0));
        let hole = |x: f32, y: f32, z: f32, what| {
            let side = Side {
                place: Vec3::new(x, y, z),
                normal: Vec3::Y * y.signum(),
                up: Vec3::Y,
            };
            at(&ShapeKind::Cube, &pose, &side, what, 0.1)
        };
        for y in [0.1, -0.1] {
            assert_eq!(hole(1.0, y, 0.53, OpeningKind::Door), None);
            let cut = hole(1.0, y, 0.53, OpeningKind::Window).expect("a hole");
            assert_eq!((cut.is_hole, cut.name(OpeningKind::Window)), (true, "Hole"));
            let corners = cut.corners();
            let low = corners.into_iter().reduce(Vec3::min).expect("eight");
            let high = corners.into_iter().reduce(Vec3::max).expect("eight");
            assert!(low.abs_diff_eq(Vec3::new(0.5, -0.1, 0.0), 1e-5), "{low}");
            assert!(high.abs_diff_eq(Vec3::new(1.5, 0.1, 1.0), 1e-5), "{high}");
            let (kind, new_pose) = cut.done();
            let [before, after] = [(&ShapeKind::Cube, &pose), (&kind, &new_pose)].map(|(kind, pose)| {
                let corners = corners_of(kind, pose).expect("a box");
                corners.into_iter().reduce(Vec3::max).expect("eight")
            });
            assert!(before.abs_diff_eq(after, 1e-5), "{before} {after}");
            // A second hole is cut into what is a wall now.
            let side = Side {
                place: Vec3::new(-2.9, y, -1.9),
                normal: Vec3::Y * y.signum(),
                up: Vec3::Y,
            };
            let second = at(&kind, &new_pose, &side, OpeningKind::Window, 0.1).expect("another hole");
            assert!(second.is_hole && second.opening.from.min(second.opening.sill) == 0.0);
        }
    }

    #[test]
    fn windows_are_snapped_and_stay_inside() {
        let window = |x: f32, z: f32| front(x, z, OpeningKind::Window).map(|cut| [cut.opening.from, cut.opening.sill]);
        assert_eq!(window(2.03, 1.52), Some([1.4, 0.9]));
        let [from, sill] = window(3.9, 2.4).expect("a window");
        assert!((from - 2.8).abs() < 1e-6 && (sill - 1.1).abs() < 1e-6);
    }

    /// A wall of 4 x 2.5, seen from its front, with an opening at a point of it.
    fn front(x: f32, z: f32, what: OpeningKind) -> Option<Cut> {
        at(
            &ShapeKind::Solid(Solid::default()),
            &Affine3A::IDENTITY,
            &place(x, z),
            what,
            0.1,
        )
    }

    fn place(x: f32, z: f32) -> Side {
        Side {
            place: Vec3::new(x, -0.1, z),
            normal: Vec3::NEG_Y,
            up: Vec3::Z,
        }
    }

    #[test]
    fn a_window_near_the_foot_goes_down_to_it_and_ends_where_others_do() {
        for z in [0.1, 0.6, 0.8] {
            let cut = front(2.0, z, OpeningKind::Window).expect("a window");
            assert_eq!(
                (cut.name(OpeningKind::Window), cut.opening.sill),
                ("French window", 0.0)
            );
            let lintel = Opening::WINDOW.sill + Opening::WINDOW.height;
            assert!((cut.opening.height - lintel).abs() < 1e-6);
        }
        let cut = front(2.0, 1.0, OpeningKind::Window).expect("a window");
        assert_eq!(cut.name(OpeningKind::Window), "Window");
        assert!(cut.opening.sill > 0.0);
        assert_eq!(
            front(2.0, 1.0, OpeningKind::Door).map(|cut| cut.opening.sill),
            Some(0.0)
        );
    }

    #[test]
    fn a_drag_gives_an_opening_its_corners_whichever_came_first() {
        let wall = ShapeKind::Solid(Solid::default());
        let drawn = |from: (f32, f32), to: (f32, f32), size: &[f32], what: OpeningKind| {
            let to = place(to.0, to.1).place;
            let side = place(from.0, from.1);
            let cut = between(&wall, &Affine3A::IDENTITY, &side, to, size, what, 0.1)?;
            let Opening {
                from,
                sill,
                width,
                height,
            } = cut.opening;
            Some([from, sill, width, height])
        };
        let is = |found: Option<[f32; 4]>, expected: [f32; 4]| {
            let off = found.map(|found| (0..4).map(|k| (found[k] - expected[k]).abs()).fold(0.0, f32::max));
            assert!(off.is_some_and(|off| off < 1e-5), "{found:?} {expected:?}");
        };
        let (low, high) = ((0.98, 0.03), (2.81, 2.12));
        is(drawn(low, high, &[], OpeningKind::Window), [1.0, 0.0, 1.8, 2.1]);
        is(drawn(high, low, &[], OpeningKind::Window), [1.0, 0.0, 1.8, 2.1]);
        is(
            drawn((1.0, 1.2), (2.0, 2.0), &[], OpeningKind::Door),
            [1.0, 0.0, 1.0, 2.0],
        );
        is(
            drawn((1.0, 1.2), (1.1, 1.1), &[1.5, 0.4], OpeningKind::Window),
            [1.0, 0.8, 1.5, 0.4],
        );
        // A drawing beyond the wall ends at its edge.
        is(
            drawn((3.0, 1.0), (9.0, 9.0), &[], OpeningKind::Window),
            [3.0, 1.0, 1.0, 1.5],
        );
        assert_eq!(drawn((1.0, 1.0), (1.02, 2.0), &[], OpeningKind::Window), None);
    }

    #[test]
    fn nothing_is_cut_into_tops_ends_and_balls() {
        let wall = ShapeKind::Solid(Solid::default());
        let ball = ShapeKind::Sphere {
            center: Vec3::ZERO,
            radius: 1.0,
        };
        for (kind, normal) in [
            (&wall, Vec3::Z),
            (&wall, Vec3::X),
            (&ShapeKind::Cube, Vec3::Z),
            (&ball, Vec3::X),
        ] {
            let side = Side {
                place: Vec3::ZERO,
                normal,
                up: Vec3::Z,
            };
            assert_eq!(at(kind, &Affine3A::IDENTITY, &side, OpeningKind::Door, 0.1), None);
        }
    }
}
