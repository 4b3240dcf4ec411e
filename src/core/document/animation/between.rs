//! Interpolation between two keys.

use glam::{Affine3A, Mat4, Vec3};

use crate::document::{TransformOp, Value};

/// The value at the fraction `share` between two of the same type. Strings and booleans are not interpolated: the first
/// one holds.
pub(super) fn between(from: &Value, to: &Value, share: f64) -> Value {
    let number = |from: f32, to: f32| mix(from, to, share);
    let triple = |from: &Vec3, to: &Vec3| mix_triple(*from, *to, share);
    match (from, to) {
        (Value::Float(from), Value::Float(to)) => Value::Float(number(*from, *to)),
        (Value::Spectrum(from), Value::Spectrum(to)) => Value::Spectrum(number(*from, *to)),
        (Value::Integer(from), Value::Integer(to)) => {
            Value::Integer((*from as f64 + share * (*to as f64 - *from as f64)).round() as i64)
        }
        (Value::Rgb(from), Value::Rgb(to)) => Value::Rgb(triple(from, to)),
        (Value::Point(from), Value::Point(to)) => Value::Point(triple(from, to)),
        (Value::Vector(from), Value::Vector(to)) => Value::Vector(triple(from, to)),
        (Value::Transform(from), Value::Transform(to)) => Value::Transform(steps_between(from, to, share)),
        _ => from.clone(),
    }
}

fn mix(from: f32, to: f32, share: f64) -> f32 {
    (f64::from(from) + share * (f64::from(to) - f64::from(from))) as f32
}

fn mix_triple(from: Vec3, to: Vec3, share: f64) -> Vec3 {
    Vec3::from_array([0, 1, 2].map(|axis| mix(from[axis], to[axis], share)))
}

/// The interpolated steps. Where both keys have the same kinds of steps, each step is interpolated by itself, so that a
/// turn by 360 degrees is a whole turn and a camera looks at a point between its targets. Otherwise translation,
/// rotation and scale are: the rotation along the shortest arc (Shoemake, "Animating rotation with quaternion curves",
/// 1985).
fn steps_between(from: &[TransformOp], to: &[TransformOp], share: f64) -> Vec<TransformOp> {
    let step_by_step = || -> Option<Vec<TransformOp>> {
        let pairs = from.iter().zip(to);
        (from.len() == to.len())
            .then(|| pairs.map(|(from, to)| step_between(from, to, share)).collect())
            .flatten()
    };
    step_by_step().unwrap_or_else(|| {
        let map = affine_between(&TransformOp::compose(from), &TransformOp::compose(to), share);
        vec![TransformOp::Matrix(Mat4::from(map))]
    })
}

/// The interpolated step; None if the kinds or the axes of rotation differ.
fn step_between(from: &TransformOp, to: &TransformOp, share: f64) -> Option<TransformOp> {
    Some(match (*from, *to) {
        (TransformOp::Translate(from), TransformOp::Translate(to)) => {
            TransformOp::Translate(mix_triple(from, to, share))
        }
        (TransformOp::Scale(from), TransformOp::Scale(to)) => TransformOp::Scale(mix_triple(from, to, share)),
        (
            TransformOp::Rotate { axis, degrees },
            TransformOp::Rotate {
                axis: other,
                degrees: end,
            },
        ) if axis == other => TransformOp::Rotate {
            axis,
            degrees: mix(degrees, end, share),
        },
        (
            TransformOp::LookAt { origin, target, up },
            TransformOp::LookAt {
                origin: end_origin,
                target: end_target,
                up: end_up,
            },
        ) => TransformOp::LookAt {
            origin: mix_triple(origin, end_origin, share),
            target: mix_triple(target, end_target, share),
            up: mix_triple(up, end_up, share),
        },
        (TransformOp::Matrix(from), TransformOp::Matrix(to)) => {
            let map = affine_between(&Affine3A::from_mat4(from), &Affine3A::from_mat4(to), share);
            TransformOp::Matrix(Mat4::from(map))
        }
        _ => return None,
    })
}

/// Whether each step can be interpolated with its counterpart.
pub(super) fn are_alike(one: &[TransformOp], other: &[TransformOp]) -> bool {
    one.len() == other.len()
        && one
            .iter()
            .zip(other)
            .all(|(one, other)| step_between(one, other, 0.0).is_some())
}

/// The affine map at the fraction `share` between two: translation and scale are linear, the rotation follows the
/// shortest arc.
pub fn affine_between(from: &Affine3A, to: &Affine3A, share: f64) -> Affine3A {
    let (size, turn, place) = from.to_scale_rotation_translation();
    let (end_size, end_turn, end_place) = to.to_scale_rotation_translation();
    Affine3A::from_scale_rotation_translation(
        mix_triple(size, end_size, share),
        turn.slerp(end_turn, share as f32),
        mix_triple(place, end_place, share),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_type_of_value_has_values_between_or_holds() {
        let half = |from: Value, to: Value| between(&from, &to, 0.5);
        let (low, high) = (Vec3::ZERO, Vec3::new(2.0, 4.0, -6.0));
        let middle = Vec3::new(1.0, 2.0, -3.0);
        assert_eq!(half(Value::Rgb(low), Value::Rgb(high)), Value::Rgb(middle));
        assert_eq!(half(Value::Point(low), Value::Point(high)), Value::Point(middle));
        assert_eq!(half(Value::Vector(low), Value::Vector(high)), Value::Vector(middle));
        assert_eq!(half(Value::Integer(-3), Value::Integer(8)), Value::Integer(3));
        assert_eq!(half(Value::Spectrum(1.0), Value::Spectrum(2.0)), Value::Spectrum(1.5));
        let text = |text: &str| Value::String(text.to_owned());
        assert_eq!(half(text("a"), text("b")), text("a"));
        assert_eq!(half(Value::Boolean(true), Value::Boolean(false)), Value::Boolean(true));
    }

    #[test]
    fn steps_of_the_same_kinds_go_their_own_ways() {
        let rotate = |degrees| TransformOp::Rotate { axis: Vec3::Y, degrees };
        let shift = |x| TransformOp::Translate(Vec3::new(x, 0.0, 0.0));
        let from = [rotate(0.0), shift(1.0)];
        let to = [rotate(720.0), shift(3.0)];
        assert_eq!(steps_between(&from, &to, 0.25), [rotate(180.0), shift(1.5)]);
        let look = |x| TransformOp::LookAt {
            origin: Vec3::new(x, 1.0, 5.0),
            target: Vec3::new(0.0, x, 0.0),
            up: Vec3::Y,
        };
        assert_eq!(steps_between(&[look(0.0)], &[look(4.0)], 0.5), [look(2.0)]);
    }

    #[test]
    fn other_steps_turn_along_the_shortest_arc() {
        let from = [TransformOp::Scale(Vec3::splat(2.0))];
        let to = [
            TransformOp::Rotate {
                axis: Vec3::Z,
                degrees: 90.0,
            },
            TransformOp::Scale(Vec3::splat(4.0)),
            TransformOp::Translate(Vec3::new(0.0, 6.0, 0.0)),
        ];
        let half = TransformOp::compose(&steps_between(&from, &to, 0.5));
        let expected = Affine3A::from_scale_rotation_translation(
            Vec3::splat(3.0),
            glam::Quat::from_rotation_z(std::f32::consts::FRAC_PI_4),
            Vec3::new(0.0, 3.0, 0.0),
        );
        assert!(half.abs_diff_eq(expected, 1e-5), "{half} {expected}");
    }
}
