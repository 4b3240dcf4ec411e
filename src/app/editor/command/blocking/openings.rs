//! Cutting doors and windows into walls, and into boxes, which become walls then.

use bevy::math::{Affine3A, Mat3, Vec3};

use super::{OpeningKind, snapped};
use crate::scene::{Opening, ShapeKind, Solid};

/// A wall with an opening that is to be cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Cut {
    /// The wall as it is before.
    pub wall: Solid,
    /// World from local.
    pub pose: Affine3A,
    /// The opening.
    pub opening: Opening,
}

/// How far two axes may be from right angles, as the cosine between them.
const RIGHT_ANGLE: f32 = 1e-4;

/// The opening of this kind at a place of a wall's or a box's side, whose normal is given as well; all in world space. It is moved to multiples of
/// `step` (world units; 0 for none), and to where the wall has room. None where none can be cut.
pub fn at(
    kind: &ShapeKind,
    pose: &Affine3A,
    place: Vec3,
    normal: Vec3,
    up: Vec3,
    what: OpeningKind,
    step: f32,
) -> Option<Cut> {
    let (wall, pose) = as_wall(kind, pose, normal, up)?;
    let Solid::Wall { length, height, .. } = wall else {
        return None;
    };
    let units = [0, 2].map(|axis| Vec3::from(pose.matrix3.col(axis)).length());
    let local = pose.inverse().transform_point3(place);
    let new = match what {
        OpeningKind::Door => Opening::DOOR,
        OpeningKind::Window => Opening::WINDOW,
    };
    // The sizes are those of the world, also in a wall that has been scaled.
    let new = new.in_wall(height * units[1]);
    let width = (new.width / units[0]).min(length);
    let tall = (new.height / units[1]).min(height);
    let snap = |length: f32, unit: f32| snapped(length * unit, step) / unit;
    let from = snap(local.x - 0.5 * width, units[0]).clamp(0.0, length - width);
    let sill = match what {
        OpeningKind::Door => 0.0,
        OpeningKind::Window => snap(local.z - 0.5 * tall, units[1]).clamp(0.0, height - tall),
    };
    let opening = Opening {
        from,
        sill,
        width,
        height: tall,
    };
    Some(Cut { wall, pose, opening })
}

impl Cut {
    /// The wall with the opening.
    pub fn done(self) -> (ShapeKind, Affine3A) {
        let mut wall = self.wall;
        if let Solid::Wall { openings, .. } = &mut wall {
            openings.push(self.opening);
        }
        (ShapeKind::Solid(wall), self.pose)
    }

    /// The corners of the opening on both sides of the wall, in world space: four in turn around, then the same four on the other side.
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

/// The wall that a shape is, and its pose. Of the upright sides of a box the larger ones are those of the wall.
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

/// The wall that a shape is, seen from the side with this normal. A box becomes one if that side is upright.
fn as_wall(kind: &ShapeKind, pose: &Affine3A, normal: Vec3, up: Vec3) -> Option<(Solid, Affine3A)> {
    let columns = [0, 1, 2].map(|axis| Vec3::from(pose.matrix3.col(axis)));
    let across = facing(&columns, normal)?;
    match kind {
        ShapeKind::Solid(wall @ Solid::Wall { .. }) if across == 1 => Some((wall.clone(), *pose)),
        ShapeKind::Cube => {
            let upward = facing(&columns, up)?;
            if upward == across {
                return None;
            }
            let is_right = |a: usize, b: usize| {
                columns[a].normalize_or_zero().dot(columns[b].normalize_or_zero()).abs() < RIGHT_ANGLE
            };
            if !(is_right(0, 1) && is_right(1, 2) && is_right(2, 0)) {
                return None;
            }
            let level = 3 - upward - across;
            let half = |axis: usize| columns[axis].length();
            let z = columns[upward].normalize() * columns[upward].dot(up).signum();
            let x = columns[level].normalize();
            // The wall goes the way that the axes of the world go.
            let x = x * x[x.abs().max_position()].signum();
            let start = Vec3::from(pose.translation) - x * half(level) - z * half(upward);
            let wall = Solid::Wall {
                length: 2.0 * half(level),
                height: 2.0 * half(upward),
                thickness: 2.0 * half(across),
                openings: Vec::new(),
            };
            let axes = Mat3::from_cols(x, z.cross(x), z);
            Some((wall, Affine3A::from_mat3_translation(axes, start)))
        }
        _ => None,
    }
}

/// The axis that a direction is along; None if it is along none.
fn facing(columns: &[Vec3; 3], direction: Vec3) -> Option<usize> {
    (0..3).find(|&axis| columns[axis].normalize_or_zero().dot(direction).abs() > 0.99)
}

#[cfg(test)]
mod tests {
    use bevy::math::Quat;

    use super::*;
    use crate::app::editor::command::blocking::block::corners;

    #[test]
    fn a_box_becomes_the_wall_that_it_is() {
        let pose = Affine3A::from_scale_rotation_translation(
            Vec3::new(0.1, 1.25, 2.0),
            Quat::from_rotation_y(0.4),
            Vec3::new(1.0, 1.25, -2.0),
        );
        let normal = Quat::from_rotation_y(0.4) * Vec3::X;
        let place = Vec3::from(pose.translation) + 0.1 * normal;
        let cut = at(&ShapeKind::Cube, &pose, place, normal, Vec3::Y, OpeningKind::Door, 0.0).expect("a wall");
        let expected = Opening {
            from: 1.55,
            ..Opening::DOOR
        };
        assert!((cut.opening.from - expected.from).abs() < 1e-5 && cut.opening.sill == 0.0);
        let (kind, new_pose) = cut.done();
        let sorted = |kind: &ShapeKind, pose: &Affine3A| {
            let mut corners = corners(kind, pose).expect("a box").to_vec();
            corners.sort_by(|a, b| (a.y, a.x, a.z).partial_cmp(&(b.y, b.x, b.z)).expect("numbers"));
            corners
        };
        for (before, after) in sorted(&ShapeKind::Cube, &pose).iter().zip(sorted(&kind, &new_pose)) {
            assert!(before.abs_diff_eq(after, 1e-5), "{before} {after}");
        }
        assert!(new_pose.matrix3.determinant() > 0.0);
    }

    #[test]
    fn windows_are_snapped_and_stay_inside() {
        let kind = ShapeKind::Solid(Solid::default());
        let window = |x: f32, z: f32| {
            at(
                &kind,
                &Affine3A::IDENTITY,
                Vec3::new(x, -0.1, z),
                Vec3::NEG_Y,
                Vec3::Z,
                OpeningKind::Window,
                0.1,
            )
            .map(|cut| [cut.opening.from, cut.opening.sill])
        };
        assert_eq!(window(2.03, 1.52), Some([1.4, 0.9]));
        assert_eq!(window(0.1, 0.1), Some([0.0, 0.0]));
        let [from, sill] = window(3.9, 2.4).expect("a window");
        assert!((from - 2.8).abs() < 1e-6 && (sill - 1.3).abs() < 1e-6);
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
            let cut = at(
                kind,
                &Affine3A::IDENTITY,
                Vec3::ZERO,
                normal,
                Vec3::Z,
                OpeningKind::Door,
                0.1,
            );
            assert_eq!(cut, None);
        }
    }
}
