//! Rotations as angles about the axes, as people type them.
//!
//! A rotation has many sets of angles: 180 degrees about y are also 180 about x and z. The typed angles, or those in a
//! file, are kept beside the pose ([`EulerAngles`]). The pose decides: if the angles do not match its rotation, the
//! nearest ones that do are shown.

use bevy::math::{DMat3, DVec3, Mat3A, Vec3};
use bevy::prelude::*;

use crate::document::TransformOp;

/// The angles of a thing's rotation about x, then y, then z, in degrees. Absent where all are zero.
#[derive(Component, Reflect, Clone, Copy, Debug, Default, PartialEq)]
#[reflect(Component, PartialEq)]
pub struct EulerAngles(pub Vec3);

/// The largest difference of a matrix from the rotation of its angles times a scale, relative to the length of each
/// column.
const SAME: f64 = 4e-6;
/// The largest part of an axis across another one that counts as rounding and not as shear.
const SHEAR: f64 = 1e-4;
/// The cosine of the angle about y below which the angles about x and z cannot be told apart in single precision.
const LOCKED: f64 = 2e-6;
/// Computed angles in degrees are rounded to multiples of this, if rounding errors explain the difference.
const UNIT: f64 = 1e-3;
/// The rounding error of computed angles in degrees.
const ROUNDING: f64 = 6e-5;

/// A matrix without shear: a scale along its own axes, then a rotation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Turned {
    /// The factors along the axes; negative ones mirror.
    pub scale: Vec3,
    /// The angles about x, then y, then z, in degrees.
    pub degrees: Vec3,
}

impl Turned {
    /// Decomposes a matrix. `near`: angles that are used if they give the rotation; otherwise the nearest to them, or
    /// the smallest if None. None for a matrix that shears or is singular.
    pub fn of(matrix: &Mat3A, near: Option<Vec3>) -> Option<Self> {
        let wide = DMat3::from_cols(
            matrix.x_axis.as_dvec3(),
            matrix.y_axis.as_dvec3(),
            matrix.z_axis.as_dvec3(),
        );
        let near = near.unwrap_or(Vec3::ZERO);
        if let Some(scale) = scale_under(&wide, near) {
            let degrees = near;
            return Some(Self { scale, degrees });
        }
        let mut scale = DVec3::new(wide.x_axis.length(), wide.y_axis.length(), wide.z_axis.length());
        // By convention, a mirror is one along x.
        scale.x *= wide.determinant().signum();
        let rotation = wide * DMat3::from_diagonal(scale.recip());
        let products = rotation.transpose() * rotation;
        let is_rotation = rotation.is_finite() && products.abs_diff_eq(DMat3::IDENTITY, SHEAR);
        is_rotation.then(|| Self {
            scale: scale.as_vec3(),
            degrees: nearest_angles(&rotation, near.as_dvec3()),
        })
    }

    /// The matrix.
    pub fn matrix(&self) -> Mat3A {
        let [x, y, z] = rotation(self.degrees.as_dvec3()).to_cols_array_2d().map(DVec3::from);
        let Vec3 { x: a, y: b, z: c } = self.scale;
        let column = |axis: DVec3, factor: f32| (axis * f64::from(factor)).as_vec3a();
        Mat3A::from_cols(column(x, a), column(y, b), column(z, c))
    }
}

impl EulerAngles {
    /// The angles of the rotation steps of a transform: about axes, first x, then y, then z. None for other rotations,
    /// and without any.
    pub fn of_steps(steps: &[TransformOp]) -> Option<Self> {
        let mut degrees = Vec3::ZERO;
        let mut last = 0;
        for step in steps {
            match *step {
                TransformOp::Translate(_) | TransformOp::Scale(_) => {}
                TransformOp::Rotate { axis, degrees: angle } => {
                    let along = axis.abs().max_position();
                    if axis.abs() != Vec3::AXES[along] || along < last {
                        return None;
                    }
                    degrees[along] += angle * axis[along];
                    last = along;
                }
                TransformOp::Matrix(_) | TransformOp::LookAt { .. } => return None,
            }
        }
        (degrees != Vec3::ZERO && degrees.is_finite()).then_some(Self(degrees))
    }

    /// The angles of a matrix nearest to those before; None if all are zero, and for a matrix that shears.
    pub(crate) fn following(before: Option<Self>, matrix: &Mat3A) -> Option<Self> {
        let turned = Turned::of(matrix, before.map(|angles| angles.0))?;
        (turned.degrees != Vec3::ZERO).then_some(Self(turned.degrees))
    }

    /// The same rotation by angles above -180 and up to 180 degrees. Angles already in this range keep their value.
    pub(crate) fn within_half_turns(self) -> Self {
        let within = |angle: f32| match turns_away(f64::from(angle)) {
            0.0 => angle,
            turns => as_meant(f64::from(angle) - 360.0 * turns) as f32,
        };
        Self(Vec3::from(self.0.to_array().map(within)))
    }
}

/// The full turns by which an angle is outside of (-180, 180] degrees.
fn turns_away(degrees: f64) -> f64 {
    (degrees / 360.0 - 0.5).ceil()
}

/// A computed angle without rounding errors.
fn as_meant(degrees: f64) -> f64 {
    let multiple = (degrees / UNIT).round() * UNIT;
    match (degrees - multiple).abs() < ROUNDING {
        true => multiple,
        false => degrees,
    }
}

/// The matrix of the angles without rounding errors, so that errors do not add up over many rotations.
pub(crate) fn tidied(matrix: &Mat3A) -> Mat3A {
    let Some(turned) = Turned::of(matrix, None) else {
        return *matrix;
    };
    let made = turned.matrix();
    let is_same = [0, 1, 2].into_iter().all(|axis| {
        let (made, column) = (made.col(axis), matrix.col(axis));
        (made - column).length() <= SAME as f32 * column.length()
    });
    if is_same { made } else { *matrix }
}

/// The scale of a matrix with the rotation of these angles; None if its rotation differs.
fn scale_under(matrix: &DMat3, degrees: Vec3) -> Option<Vec3> {
    let scaled = rotation(degrees.as_dvec3()).transpose() * *matrix;
    let mut scale = Vec3::ZERO;
    for axis in 0..3 {
        let column = scaled.col(axis);
        let factor = column[axis];
        let off = (column - DVec3::AXES[axis] * factor).length();
        if factor == 0.0 || !factor.is_finite() || off > SAME * factor.abs() {
            return None;
        }
        scale[axis] = factor as f32;
    }
    // Two mirrors are a rotation by 180 degrees.
    let mirrors = scale.to_array().into_iter().filter(|factor| *factor < 0.0).count();
    (mirrors != 2).then_some(scale)
}

/// The rotation about x, then y, then z.
fn rotation(degrees: DVec3) -> DMat3 {
    let [(sx, cx), (sy, cy), (sz, cz)] = degrees.to_array().map(sin_cos);
    DMat3::from_cols(
        DVec3::new(cz * cy, sz * cy, -sy),
        DVec3::new(cz * sy * sx - sz * cx, sz * sy * sx + cz * cx, cy * sx),
        DVec3::new(cz * sy * cx + sz * sx, sz * sy * cx - cz * sx, cy * cx),
    )
}

/// Sine and cosine, exact at right angles.
fn sin_cos(degrees: f64) -> (f64, f64) {
    match degrees.rem_euclid(360.0) {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        turned => turned.to_radians().sin_cos(),
    }
}

/// The angles of a rotation, in degrees, that are nearest to `near`.
fn nearest_angles(rotation: &DMat3, near: DVec3) -> Vec3 {
    let (first, second, third) = (rotation.x_axis, rotation.y_axis, rotation.z_axis);
    let across = first.x.hypot(first.y);
    let y = (-first.z).atan2(across).to_degrees();
    let candidates = if across < LOCKED {
        // The angles about x and z are about the same axis then.
        let side = y.signum();
        let turn = (side * second.x).atan2(second.y).to_degrees();
        [
            DVec3::new(near.x, 90.0 * side, side * (near.x - turn)),
            DVec3::new(turn + side * near.z, 90.0 * side, near.z),
        ]
    } else {
        let x = second.z.atan2(third.z).to_degrees();
        let z = first.y.atan2(first.x).to_degrees();
        [DVec3::new(x, y, z), DVec3::new(x + 180.0, 180.0 - y, z + 180.0)]
    };
    // The full turns nearest to the angles before.
    let round = |angle: f64, near: f64| {
        let angle = as_meant(angle);
        // Adding zero makes -0 positive.
        angle - 360.0 * turns_away(angle - near) + 0.0
    };
    let [one, other] = candidates.map(|angles| {
        let rounded = DVec3::new(
            round(angles.x, near.x),
            round(angles.y, near.y),
            round(angles.z, near.z),
        );
        (rounded, (rounded - near).abs())
    });
    let ways = |away: DVec3| away.element_sum();
    let is_nearer = match ways(one.1) - ways(other.1) {
        difference if difference.abs() > UNIT => difference < 0.0,
        // Things rotated by 90 degrees about x rotate about y then.
        _ => one.1.z <= other.1.z,
    };
    if is_nearer { one.0 } else { other.0 }.as_vec3()
}

/// The rotation about x that sets a thing whose z axis points up upright; `up` is the world's. The angles of upright
/// things are shown relative to it.
pub fn upright_rest(up: Vec3) -> Vec3 {
    match up.y > 0.5 {
        true => Vec3::X * -90.0,
        false => Vec3::ZERO,
    }
}

/// The sum of two sets of angles, rounded to their digits: 33.3 and -90 are -56.7.
pub(crate) fn from_rest(degrees: Vec3, rest: Vec3) -> Vec3 {
    const DIGITS: f64 = 1e4;
    let sum = (degrees.as_dvec3() + rest.as_dvec3()) * DIGITS;
    // Adding zero makes -0 positive.
    let sum = (sum.round() / DIGITS).as_vec3() + Vec3::ZERO;
    Vec3::select(rest.cmpeq(Vec3::ZERO), degrees, sum)
}

#[cfg(test)]
mod tests {
    use bevy::math::Quat;

    use super::*;

    fn matrix(degrees: [f32; 3]) -> Mat3A {
        let [x, y, z] = degrees.map(f32::to_radians);
        Mat3A::from_quat(Quat::from_rotation_z(z) * Quat::from_rotation_y(y) * Quat::from_rotation_x(x))
    }

    fn angles(matrix: &Mat3A, near: Option<[f32; 3]>) -> [f32; 3] {
        let turned = Turned::of(matrix, near.map(Vec3::from)).expect("it is no shear");
        turned.degrees.to_array()
    }

    #[test]
    fn a_matrix_alone_has_the_smallest_angles() {
        for degrees in [
            [0.0, 180.0, 0.0],
            [0.0, 0.0, 180.0],
            [180.0, 0.0, 0.0],
            [0.0, 150.0, 0.0],
            [0.0, -120.0, 0.0],
            [0.0, 90.0, 0.0],
            [20.0, -35.0, 110.0],
            [12.5, 90.0, 0.0],
            // Upright walls, about y.
            [-90.0, 0.0, 0.0],
            [-90.0, 90.0, 0.0],
            [-90.0, -90.0, 0.0],
            [-90.0, 135.0, 0.0],
            [-90.0, 180.0, 0.0],
        ] {
            assert_eq!(angles(&matrix(degrees), None), degrees, "{degrees:?}");
        }
        assert_eq!(angles(&matrix([180.0, 0.0, 180.0]), None), [0.0, 180.0, 0.0]);
    }

    #[test]
    fn known_angles_stay_and_others_are_the_nearest() {
        for degrees in [
            [180.0, 0.0, 180.0],
            [0.0, 370.0, 0.0],
            [0.1, 33.333, -720.0],
            [30.0, 90.0, 40.0],
        ] {
            assert_eq!(angles(&matrix(degrees), Some(degrees)), degrees);
        }
        // A turn by ten degrees goes on from there.
        assert_eq!(
            angles(&matrix([0.0, 190.0, 0.0]), Some([0.0, 180.0, 0.0])),
            [0.0, 190.0, 0.0]
        );
        assert_eq!(
            angles(&matrix([180.0, 10.0, 180.0]), Some([180.0, 0.0, 180.0])),
            [180.0, 10.0, 180.0]
        );
        assert_eq!(
            angles(&matrix([0.0, 10.0, 0.0]), Some([0.0, 355.0, 0.0])),
            [0.0, 370.0, 0.0]
        );
    }

    #[test]
    fn scales_and_mirrors_are_told_from_the_rotation() {
        let scaled = |scale: Vec3| matrix([0.0, 180.0, 0.0]) * Mat3A::from_diagonal(scale);
        for scale in [Vec3::new(4.5, 0.5, 3.0), Vec3::new(2.0, -3.0, 4.0), Vec3::splat(-1.0)] {
            let turned = Turned::of(&scaled(scale), Some(Vec3::Y * 180.0)).expect("it is no shear");
            assert_eq!(turned.degrees, Vec3::Y * 180.0);
            assert!(turned.scale.abs_diff_eq(scale, 1e-6), "{turned:?}");
            assert!(turned.matrix().abs_diff_eq(scaled(scale), 1e-6));
        }
        let sheared = Mat3A::from_cols(Vec3::X.into(), Vec3::new(0.5, 1.0, 0.0).into(), Vec3::Z.into());
        assert_eq!(Turned::of(&sheared, None), None);
        assert_eq!(Turned::of(&Mat3A::ZERO, None), None);
        assert!(Turned::of(&Mat3A::from_diagonal(Vec3::new(1.0, 200.0, -3.0)), None).is_some());
    }

    #[test]
    fn right_angles_are_exact() {
        let turned = Turned {
            scale: Vec3::new(2.0, 3.0, 4.0),
            degrees: Vec3::new(-90.0, 90.0, 0.0),
        };
        let expected = Mat3A::from_cols(Vec3::NEG_Z.into(), Vec3::NEG_X.into(), Vec3::Y.into());
        assert_eq!(turned.matrix(), expected * Mat3A::from_diagonal(turned.scale));
    }

    #[test]
    fn whole_turns_are_left_out() {
        for (degrees, expected) in [
            ([0.0, 360.0, -180.0], [0.0, 0.0, 180.0]),
            ([180.0, 190.0, -190.0], [180.0, -170.0, 170.0]),
            ([12.345678, 370.123, -720.0], [12.345678, 10.123, 0.0]),
        ] {
            let found = EulerAngles(Vec3::from(degrees)).within_half_turns();
            assert_eq!(found.0.to_array(), expected);
        }
    }

    #[test]
    fn many_small_turns_end_at_short_angles() {
        let turn = Mat3A::from_rotation_y(15f32.to_radians());
        let (mut now, mut known) = (matrix([-90.0, 0.0, 0.0]), Some(EulerAngles(Vec3::X * -90.0)));
        for _ in 0..1000 {
            now = tidied(&(turn * now));
            known = EulerAngles::following(known, &now);
        }
        assert_eq!(known, Some(EulerAngles(Vec3::new(-90.0, 15000.0, 0.0))));
    }

    #[test]
    fn steps_about_the_axes_in_order_are_angles() {
        let rotate = |axis, degrees| TransformOp::Rotate { axis, degrees };
        let found = |steps: &[TransformOp]| EulerAngles::of_steps(steps).map(|angles| angles.0.to_array());
        let (scale, by) = (TransformOp::Scale(Vec3::ONE), TransformOp::Translate(Vec3::X));
        let all = [scale, rotate(Vec3::X, -90.0), rotate(Vec3::NEG_Y, 180.0), by];
        assert_eq!(found(&all), Some([-90.0, -180.0, 0.0]));
        assert_eq!(
            found(&[rotate(Vec3::Y, 30.0), rotate(Vec3::Y, 40.0)]),
            Some([0.0, 70.0, 0.0])
        );
        for other in [
            vec![rotate(Vec3::Y, 90.0), rotate(Vec3::X, 90.0)],
            vec![rotate(Vec3::ONE, 90.0)],
            vec![rotate(2.0 * Vec3::Y, 90.0)],
            vec![by],
        ] {
            assert_eq!(found(&other), None, "{other:?}");
        }
    }
}
