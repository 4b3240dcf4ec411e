//! The steps of a `<transform>`, kept as given so that a saved file reads like the loaded one.

use glam::{Affine3A, DMat3, DVec3, Mat3, Mat4, Quat, Vec3};

/// One child of a `<transform>`; they apply in document order, the first one nearest to the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TransformOp {
    /// A shift by this vector.
    Translate(Vec3),
    /// A rotation by `degrees`, counter-clockwise seen against `axis`. The axis may have any length but zero. If that
    /// is not 1, the step also scales and shears, as in Mitsuba 3.
    Rotate {
        /// The direction of the axis through the origin.
        axis: Vec3,
        /// The angle in degrees.
        degrees: f32,
    },
    /// A factor along each axis; a negative one mirrors.
    Scale(Vec3),
    /// An affine matrix (its last row is 0 0 0 1).
    Matrix(Mat4),
    /// The camera frame at `origin`: +z to `target`, +x to the left, +y nearest to `up`.
    LookAt {
        /// The position of the camera.
        origin: Vec3,
        /// The point that the camera looks at.
        target: Vec3,
        /// A direction of any length that is not along the view.
        up: Vec3,
    },
}

impl TransformOp {
    /// The step as an affine map; a rotation about a zero axis or a degenerate look-at is the identity.
    pub fn affine(&self) -> Affine3A {
        match *self {
            Self::Translate(by) => Affine3A::from_translation(by),
            Self::Rotate { axis, degrees } => rotation(axis, degrees.to_radians()),
            Self::Scale(by) => Affine3A::from_scale(by),
            Self::Matrix(matrix) => Affine3A::from_mat4(matrix),
            Self::LookAt { origin, target, up } => {
                let forward = direction(origin, target).unwrap_or(DVec3::Z);
                let left = left_of(forward, up).unwrap_or_else(|| forward.any_orthonormal_vector());
                let axes = DMat3::from_cols(left, forward.cross(left), forward).as_mat3();
                Affine3A::from_mat3_translation(axes, origin)
            }
        }
    }

    /// The numbers of the step.
    pub fn numbers(&self) -> Vec<f32> {
        match *self {
            Self::Translate(by) | Self::Scale(by) => by.to_array().to_vec(),
            Self::Rotate { axis, degrees } => axis.to_array().into_iter().chain([degrees]).collect(),
            Self::Matrix(matrix) => matrix.to_cols_array().to_vec(),
            Self::LookAt { origin, target, up } => [origin, target, up].iter().flat_map(Vec3::to_array).collect(),
        }
    }

    /// The composed map of all steps.
    pub fn compose(ops: &[Self]) -> Affine3A {
        ops.iter().fold(Affine3A::IDENTITY, |so_far, op| op.affine() * so_far)
    }
}

/// The direction from `origin` to `target`, of length 1; None if they are the same point. Double precision holds the
/// square of every length that single precision has.
pub fn direction(origin: Vec3, target: Vec3) -> Option<DVec3> {
    (target.as_dvec3() - origin.as_dvec3()).try_normalize()
}

/// The direction to the left of a camera that looks along `forward`, of length 1; None if `up` is zero or along
/// `forward`.
pub(crate) fn left_of(forward: DVec3, up: Vec3) -> Option<DVec3> {
    up.as_dvec3().try_normalize()?.cross(forward).try_normalize()
}

/// The difference from 1 below which the squared length of an axis counts as a rounding error of single precision, or
/// of six digits.
const UNIT: f32 = 1e-6;

/// Rodrigues' formula, cos I + (1 - cos) a a^T + sin [a]x, with the axis as it is. Mitsuba 3 does not normalise the
/// axis either (found by reading back the matrices of its shapes), so files with such an axis show the same picture.
fn rotation(axis: Vec3, angle: f32) -> Affine3A {
    if axis == Vec3::ZERO {
        return Affine3A::IDENTITY;
    }
    if (axis.length_squared() - 1.0).abs() < UNIT {
        return Affine3A::from_quat(Quat::from_axis_angle(axis.normalize(), angle));
    }
    let (sin, cos) = angle.sin_cos();
    let column = |unit: Vec3| cos * unit + (1.0 - cos) * axis.dot(unit) * axis + sin * axis.cross(unit);
    Affine3A::from_mat3(Mat3::from_cols(column(Vec3::X), column(Vec3::Y), column(Vec3::Z)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The matrices of a shape's `to_world` in Mitsuba 3.9.1, row by row. A rotation acts through its matrix alone: the
    /// matrix places a shape, and its inverse turns the normals, whatever steps it is made of.
    #[test]
    fn axes_of_any_length_give_the_matrices_of_mitsuba() {
        let cases = [
            (
                Vec3::Y,
                30.0,
                [0.866_025_4, 0.0, 0.5, 0.0, 1.0, 0.0, -0.5, 0.0, 0.866_025_4],
            ),
            (
                2.0 * Vec3::Y,
                30.0,
                [0.866_025_4, 0.0, 1.0, 0.0, 1.401_923_9, 0.0, -1.0, 0.0, 0.866_025_4],
            ),
            (0.5 * Vec3::Y, 180.0, [-1.0, 0.0, 0.0, 0.0, -0.5, 0.0, 0.0, 0.0, -1.0]),
            (
                Vec3::new(1.0, 2.0, 3.0),
                90.0,
                [1.0, -1.0, 5.0, 5.0, 4.0, 5.0, 1.0, 7.0, 9.0],
            ),
        ];
        for (axis, degrees, rows) in cases {
            let found = TransformOp::Rotate { axis, degrees }.affine();
            let expected = Mat3::from_cols_array(&rows).transpose();
            assert!(
                Mat3::from(found.matrix3).abs_diff_eq(expected, 2e-6),
                "{axis} {degrees}: {found}"
            );
        }
        let nowhere = TransformOp::Rotate {
            axis: Vec3::ZERO,
            degrees: 30.0,
        };
        assert_eq!(nowhere.affine(), Affine3A::IDENTITY);
    }

    #[test]
    fn a_look_over_any_distance_has_the_same_axes() {
        let (to, up) = (Vec3::new(1.0, -2.0, 3.0), Vec3::new(0.25, 1.0, 0.5));
        let axes = |distance: f32, upwards: f32| {
            let step = TransformOp::LookAt {
                origin: Vec3::ZERO,
                target: distance * to,
                up: upwards * up,
            };
            Mat3::from(step.affine().matrix3)
        };
        let expected = axes(1.0, 1.0);
        assert!(expected.z_axis.abs_diff_eq(to.normalize(), 1e-6), "{expected}");
        for size in [1e-44f32, 1e-38, 1e-20, 1e20, 1e38] {
            // The smallest numbers have only few digits.
            let tolerance = if size < 1e-40 { 0.2 } else { 1e-6 };
            assert!(axes(size, 1.0).abs_diff_eq(expected, tolerance), "{size}");
            assert!(axes(1.0, size).abs_diff_eq(expected, tolerance), "{size}");
        }
    }
}
