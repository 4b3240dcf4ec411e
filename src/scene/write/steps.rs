//! Expresses a changed transform in the steps of the file, changing as few numbers as possible.

use bevy::math::{Affine3A, Vec3};

use crate::document::{TransformOp, Value};
use crate::scene::EulerAngles;
use crate::scene::components::shape::short_together;

/// The largest difference between a map and its steps, relative to its largest element; numbers closer than that are
/// equal.
const SAME: f32 = 1e-5;

/// The largest difference between angles of the same rotation, in degrees.
const SAME_ANGLE: f32 = 1e-3;

/// Whether the angles of a transform differ.
pub fn is_turned(before: Option<&Value>, now: Option<&Value>) -> bool {
    let [before, now] = [before, now].map(|value| match value {
        Some(Value::Transform(steps)) => EulerAngles::of_steps(steps),
        _ => None,
    });
    before != now
}

/// The steps of `now`, with as many steps of `old` as possible. `is_turned`: the angles of `now` are kept exactly, even
/// if others give the same map.
pub fn revised(old: &[TransformOp], now: &[TransformOp], is_turned: bool) -> Vec<TransformOp> {
    let map = TransformOp::compose(now);
    let exact = looking(old, &map);
    let short = exact.as_deref().and_then(shortened);
    let candidates = [moved(old, &map), short, exact, snapped(old, now)];
    let angles = EulerAngles::of_steps(now);
    let has_angles = |steps: &[TransformOp]| match (angles, EulerAngles::of_steps(steps)) {
        (Some(angles), Some(its)) => its.0.abs_diff_eq(angles.0, SAME_ANGLE),
        (Some(_), None) => false,
        (None, _) => true,
    };
    let fits = |steps: &Vec<TransformOp>| {
        let size = |v: f32| v.abs().max(f32::MIN_POSITIVE);
        let made = TransformOp::compose(steps);
        let linear = largest(&map.matrix3.to_cols_array()).max(f32::MIN_POSITIVE);
        let way = size(largest(&map.translation.to_array()));
        (!is_turned || has_angles(steps))
            && made.matrix3.abs_diff_eq(map.matrix3, SAME * linear)
            && made.translation.abs_diff_eq(map.translation, SAME * way)
    };
    candidates
        .into_iter()
        .flatten()
        .find(fits)
        .unwrap_or_else(|| now.to_vec())
}

/// The old steps with another final translation.
fn moved(old: &[TransformOp], map: &Affine3A) -> Option<Vec<TransformOp>> {
    let mut steps = old.to_vec();
    let last = match steps.last().copied() {
        Some(TransformOp::Translate(by)) => {
            steps.pop();
            Some(by)
        }
        // A single look-at changes its own numbers.
        Some(TransformOp::LookAt { .. }) if steps.len() == 1 => return None,
        _ => None,
    };
    let before = TransformOp::compose(&steps);
    let by = Vec3::from(map.translation - before.translation);
    let by = last.map_or(by, |last| snap(last, by, largest(&map.translation.to_array())));
    if last.is_some() || by != Vec3::ZERO {
        steps.push(TransformOp::Translate(by));
    }
    Some(steps)
}

/// A look-at that keeps `up` and the distance of the target.
fn looking(old: &[TransformOp], map: &Affine3A) -> Option<Vec<TransformOp>> {
    let &[TransformOp::LookAt { origin, target, up }] = old else {
        return None;
    };
    let now = Vec3::from(map.translation);
    let aim = now + Vec3::from(map.matrix3.z_axis) * target.distance(origin);
    let size = now.abs().max_element().max(aim.abs().max_element());
    Some(vec![TransformOp::LookAt {
        origin: snap(origin, now, size),
        target: snap(target, aim, size),
        up,
    }])
}

/// Rounds the points to six digits, because arithmetic makes 3.9999998 of 4.
fn shortened(looking: &[TransformOp]) -> Option<Vec<TransformOp>> {
    let &[TransformOp::LookAt { origin, target, up }] = looking else {
        return None;
    };
    let [origin, target] = short_together([origin, target], 6);
    Some(vec![TransformOp::LookAt { origin, target, up }])
}

/// Steps of the same kinds, with the old numbers where these are accurate enough.
fn snapped(old: &[TransformOp], now: &[TransformOp]) -> Option<Vec<TransformOp>> {
    let same_kinds = old.len() == now.len()
        && old
            .iter()
            .zip(now)
            .all(|(old, now)| std::mem::discriminant(old) == std::mem::discriminant(now));
    let snap_step = |(old, now): (&TransformOp, &TransformOp)| match (*old, *now) {
        (TransformOp::Translate(old), TransformOp::Translate(now)) => {
            TransformOp::Translate(snap(old, now, now.abs().max_element()))
        }
        (TransformOp::Scale(old), TransformOp::Scale(now)) => {
            TransformOp::Scale(snap(old, now, now.abs().max_element()))
        }
        (
            TransformOp::Rotate {
                axis: old_axis,
                degrees: old_degrees,
            },
            TransformOp::Rotate { axis, degrees },
        ) => {
            let along = old_axis.normalize_or_zero().dot(axis.normalize_or_zero());
            if along.abs() < 1.0 - SAME {
                return *now;
            }
            let degrees = degrees * along.signum();
            // The same angle, plus the full turns that bring it nearest to the old number.
            let degrees = degrees + 360.0 * ((old_degrees - degrees) / 360.0).round();
            TransformOp::Rotate {
                axis: old_axis,
                degrees: snap_number(old_degrees, degrees, 180.0),
            }
        }
        _ => *now,
    };
    same_kinds.then(|| old.iter().zip(now).map(snap_step).collect())
}

fn snap(old: Vec3, now: Vec3, size: f32) -> Vec3 {
    let pairs = |axis: usize| snap_number(old[axis], now[axis], size);
    Vec3::new(pairs(0), pairs(1), pairs(2))
}

fn snap_number(old: f32, now: f32, size: f32) -> f32 {
    // A tenth of the tolerance, so that several differences together stay below it.
    if (old - now).abs() <= 0.1 * SAME * size {
        old
    } else {
        now
    }
}

fn largest(numbers: &[f32]) -> f32 {
    numbers.iter().fold(0.0, |most: f32, number| most.max(number.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_move_changes_the_translation_alone() {
        let turn = TransformOp::Rotate {
            axis: Vec3::new(0.0, 2.0, 0.0),
            degrees: -45.0,
        };
        let old = [turn, TransformOp::Translate(Vec3::new(0.1, 2.0, 3.0))];
        let mut map = TransformOp::compose(&old);
        map.translation.x = 0.35;
        let now = crate::scene::encode::poses::as_steps(&map, None);
        let expected = TransformOp::Translate(Vec3::new(0.35, 2.0, 3.0));
        assert_eq!(revised(&old, &now, false), [turn, expected]);
        assert_eq!(revised(&[turn], &now, false), [turn, expected]);
    }

    #[test]
    fn a_turned_thing_keeps_its_scale_and_its_place() {
        let steps = |degrees| {
            [
                TransformOp::Scale(Vec3::splat(0.3)),
                TransformOp::Rotate {
                    axis: Vec3::NEG_Y,
                    degrees,
                },
                TransformOp::Translate(Vec3::new(0.1, 0.2, 0.3)),
            ]
        };
        let now = crate::scene::encode::poses::as_steps(
            &TransformOp::compose(&steps(300.0)),
            Some(EulerAngles(Vec3::Y * -270.0)),
        );
        let revised = revised(&steps(270.0), &now, true);
        let [scale, TransformOp::Rotate { axis, degrees }, place] = revised[..] else {
            panic!("{revised:?}");
        };
        assert_eq!([scale, place], [steps(0.0)[0], steps(0.0)[2]]);
        // The angle is thirty degrees more, within the rounding of single precision.
        assert!(axis == Vec3::NEG_Y && (degrees - 300.0).abs() < 1e-3, "{degrees}");
    }

    #[test]
    fn a_camera_keeps_its_up_and_the_distance_of_its_target() {
        let old = [TransformOp::LookAt {
            origin: Vec3::new(0.0, 1.0, 4.0),
            target: Vec3::new(0.0, 1.0, 0.0),
            up: Vec3::new(0.0, 2.0, 0.0),
        }];
        let mut map = old[0].affine();
        map.translation.x = 1.5;
        let now = [TransformOp::Matrix(bevy::math::Mat4::from(map))];
        let expected = TransformOp::LookAt {
            origin: Vec3::new(1.5, 1.0, 4.0),
            target: Vec3::new(1.5, 1.0, 0.0),
            up: Vec3::new(0.0, 2.0, 0.0),
        };
        assert_eq!(revised(&old, &now, false), [expected]);
    }

    #[test]
    fn a_camera_that_was_moved_is_written_in_few_digits() {
        let old = [TransformOp::LookAt {
            origin: Vec3::new(0.0, 2.0, 9.5),
            target: Vec3::new(0.0, 1.9, 0.0),
            up: Vec3::Y,
        }];
        let map = TransformOp::LookAt {
            origin: Vec3::new(0.7, 1.3, 5.1),
            target: Vec3::new(-0.4, 0.9, 0.3),
            up: Vec3::Y,
        };
        let now = [TransformOp::Matrix(bevy::math::Mat4::from(map.affine()))];
        let [TransformOp::LookAt { origin, target, .. }] = revised(&old, &now, false)[..] else {
            panic!("no look-at");
        };
        for number in [origin, target].iter().flat_map(Vec3::to_array) {
            let text = number.to_string();
            let digits = text.chars().filter(char::is_ascii_digit).count();
            assert!(digits <= 7, "{text}");
        }
    }
}
