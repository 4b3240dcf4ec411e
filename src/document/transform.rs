//! The steps of a `<transform>`, kept as the file gives them so that a saved file reads like the loaded one.

use glam::{Affine3A, Mat3, Mat4, Quat, Vec3};

/// One child of a `<transform>`; they apply in document order, the first one nearest to the object.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum TransformOp {
    Translate(Vec3),
    /// Rotation by `degrees`, counter-clockwise seen against `axis` (any length but zero).
    Rotate {
        axis: Vec3,
        degrees: f32,
    },
    Scale(Vec3),
    /// An affine matrix (its last row is 0 0 0 1).
    Matrix(Mat4),
    /// The camera frame at `origin`: +z to `target`, +x to the left, +y nearest to `up`.
    LookAt {
        origin: Vec3,
        target: Vec3,
        up: Vec3,
    },
}

impl TransformOp {
    /// The step as an affine map; a rotation about no axis or a look at nowhere is the identity there.
    pub fn affine(&self) -> Affine3A {
        match *self {
            Self::Translate(by) => Affine3A::from_translation(by),
            Self::Rotate { axis, degrees } => axis.try_normalize().map_or(Affine3A::IDENTITY, |axis| {
                Affine3A::from_quat(Quat::from_axis_angle(axis, degrees.to_radians()))
            }),
            Self::Scale(by) => Affine3A::from_scale(by),
            Self::Matrix(matrix) => Affine3A::from_mat4(matrix),
            Self::LookAt { origin, target, up } => {
                let forward = (target - origin).try_normalize().unwrap_or(Vec3::Z);
                let left = up
                    .cross(forward)
                    .try_normalize()
                    .unwrap_or_else(|| forward.any_orthonormal_vector());
                Affine3A::from_mat3_translation(Mat3::from_cols(left, forward.cross(left), forward), origin)
            }
        }
    }

    /// All numbers of the step.
    pub fn numbers(&self) -> Vec<f32> {
        match *self {
            Self::Translate(by) | Self::Scale(by) => by.to_array().to_vec(),
            Self::Rotate { axis, degrees } => axis.to_array().into_iter().chain([degrees]).collect(),
            Self::Matrix(matrix) => matrix.to_cols_array().to_vec(),
            Self::LookAt { origin, target, up } => [origin, target, up].iter().flat_map(Vec3::to_array).collect(),
        }
    }

    /// All steps of a transform as one map.
    pub fn compose(ops: &[Self]) -> Affine3A {
        ops.iter().fold(Affine3A::IDENTITY, |so_far, op| op.affine() * so_far)
    }
}
