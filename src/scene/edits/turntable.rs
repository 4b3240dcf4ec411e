//! A camera that circles once around a point.

use bevy::math::{Affine3A, Mat4, Quat, Vec3};

use crate::document::{Interpolation, Key, Track, TransformOp, Value};
use crate::scene::encode::poses::as_look_at;

/// A full rotation of a camera about an axis of the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Turntable {
    start: Affine3A,
    middle: Vec3,
    axis: Vec3,
}

impl Turntable {
    /// Starts at this pose of the camera, world from camera, and rotates around `middle`, about the axis of the world
    /// that is nearest to upwards in the camera's picture.
    pub fn new(start: Affine3A, middle: Vec3) -> Self {
        let up = Vec3::from(start.matrix3.y_axis);
        let axis = up.abs().max_position();
        Self {
            start,
            middle,
            axis: Vec3::AXES[axis] * up[axis].signum(),
        }
    }

    /// The pose after this fraction of the rotation.
    pub fn at(&self, share: f64) -> Affine3A {
        let turn = Quat::from_axis_angle(self.axis, (share * std::f64::consts::TAU) as f32);
        Affine3A::from_translation(self.middle)
            * Affine3A::from_quat(turn)
            * Affine3A::from_translation(-self.middle)
            * self.start
    }

    /// The rotation as keys at two times in seconds.
    pub fn track(&self, begin: f64, end: f64) -> Track {
        let look_at = as_look_at(&self.start).filter(|step| step.affine().abs_diff_eq(self.start, 1e-5));
        let start = look_at.unwrap_or(TransformOp::Matrix(Mat4::from(self.start)));
        let key = |time: f64, degrees: f32| {
            let steps = [
                start,
                TransformOp::Translate(-self.middle),
                TransformOp::Rotate {
                    axis: self.axis,
                    degrees,
                },
                TransformOp::Translate(self.middle),
            ];
            Key {
                time: f64::from(time as f32),
                value: Value::Transform(steps.to_vec()),
            }
        };
        Track {
            keys: vec![key(begin, 0.0), key(end, 360.0)],
            interpolation: Interpolation::Linear,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_keys_turn_as_the_poses_do() {
        let start = TransformOp::LookAt {
            origin: Vec3::new(1.0, 2.0, 6.0),
            target: Vec3::new(0.5, 1.0, 0.0),
            up: Vec3::Y,
        };
        let turntable = Turntable::new(start.affine(), Vec3::new(0.5, 1.0, -0.25));
        let track = turntable.track(1.0, 3.0);
        for share in [0.0, 0.1, 0.25, 0.5, 0.8, 1.0] {
            let Value::Transform(steps) = track.at(1.0 + 2.0 * share) else {
                panic!("no transform");
            };
            let (keyed, turned) = (TransformOp::compose(&steps), turntable.at(share));
            assert!(keyed.abs_diff_eq(turned, 2e-5), "{share}: {keyed:?}, not {turned:?}");
        }
        assert!(!turntable.at(0.5).abs_diff_eq(turntable.at(0.0), 1.0));
    }
}
