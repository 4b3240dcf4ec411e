//! Converts affine maps to transform steps as people would write them.

use bevy::math::{Affine3A, Mat3, Mat4, Vec3};

use crate::document::TransformOp;
use crate::scene::components::shape::short_together;
use crate::scene::{EulerAngles, Turned};

/// The largest difference between a map and its recomposed steps, relative to its largest element.
const RECOMPOSED: f32 = 1e-5;

/// The largest difference that shortening the numbers of a transform may make, relative to the largest element of the
/// linear part, and to each coordinate of the translation: some units in the last place.
const SHORTENED: f32 = 4e-7;

/// The largest distance by which shortening may move a camera, relative to its distance from the origin.
const MOVED: f64 = 1e-6;

/// The step with numbers rounded to `digits`: people write 3 and 90, arithmetic makes 2.9999998 and 90.00001 of them.
/// Known angles are kept.
fn shortened(step: &TransformOp, digits: i32, is_turned_so: bool) -> TransformOp {
    match *step {
        TransformOp::Scale(factors) => TransformOp::Scale(short(factors, digits)),
        TransformOp::Translate(by) => TransformOp::Translate(short(by, digits)),
        TransformOp::Rotate { axis, degrees } if !is_turned_so => TransformOp::Rotate {
            axis,
            degrees: short(Vec3::splat(degrees), digits).x,
        },
        other => other,
    }
}

/// The numbers rounded to `digits`.
fn short(numbers: Vec3, digits: i32) -> Vec3 {
    numbers.map(|number| {
        let number = f64::from(number);
        if number == 0.0 {
            return 0.0;
        }
        let unit = 10f64.powf(number.abs().log10().floor() + f64::from(1 - digits));
        ((number / unit).round() * unit) as f32
    })
}

/// The map as scale, rotations about the axes x, y and z in this order, and translation, without steps that have no
/// effect; as a matrix if it shears. `angles`: these are written if they give its rotation, otherwise the nearest ones
/// that do.
pub(crate) fn as_steps(map: &Affine3A, angles: Option<EulerAngles>) -> Vec<TransformOp> {
    let as_matrix = || vec![TransformOp::Matrix(Mat4::from(*map))];
    let Some(Turned { scale, degrees }) = Turned::of(&map.matrix3, angles.map(|angles| angles.0)) else {
        return as_matrix();
    };
    let translation = Vec3::from(map.translation);
    let mut steps = Vec::new();
    if !scale.abs_diff_eq(Vec3::ONE, 1e-6) {
        steps.push(TransformOp::Scale(scale));
    }
    for (axis, degrees) in Vec3::AXES.into_iter().zip(degrees.to_array()) {
        if degrees != 0.0 {
            steps.push(TransformOp::Rotate { axis, degrees });
        }
    }
    if translation != Vec3::ZERO {
        steps.push(TransformOp::Translate(translation));
    }
    let largest = map
        .to_cols_array()
        .iter()
        .fold(0.0f32, |most, element| most.max(element.abs()));
    let linear = map
        .matrix3
        .to_cols_array()
        .iter()
        .fold(0.0f32, |most, part| most.max(part.abs()));
    let is_short_enough = |short: &Vec<TransformOp>| {
        let shorter = TransformOp::compose(short);
        let moved = Vec3::from(shorter.translation - map.translation).abs();
        shorter.matrix3.abs_diff_eq(map.matrix3, SHORTENED * linear)
            && moved.cmple(SHORTENED * Vec3::from(map.translation).abs()).all()
    };
    let is_turned_so = angles.is_some_and(|angles| angles.0 == degrees);
    let short = |digits| -> Vec<TransformOp> {
        let short = steps.iter().map(|step| shortened(step, digits, is_turned_so));
        short.collect()
    };
    if let Some(short) = [6, 7].map(short).into_iter().find(is_short_enough) {
        return short;
    }
    let made = TransformOp::compose(&steps);
    // A small element must not be lost in the rounding of a large translation.
    let is_same =
        made.matrix3.abs_diff_eq(map.matrix3, RECOMPOSED * linear) && made.abs_diff_eq(*map, RECOMPOSED * largest);
    if is_same { steps } else { as_matrix() }
}

/// A camera's pose as a look-at step; None if it scales, shears or mirrors, or if single precision cannot hold the
/// target.
pub(crate) fn as_look_at(map: &Affine3A) -> Option<TransformOp> {
    let rotation = Mat3::from(map.matrix3);
    let is_rigid = (rotation.transpose() * rotation).abs_diff_eq(Mat3::IDENTITY, 1e-4) && rotation.determinant() > 0.0;
    let origin = Vec3::from(map.translation);
    // The distance is large enough that the direction is not lost in the rounding of the position.
    let distance = (origin.as_dvec3().length() as f32).max(1.0);
    let target = origin + distance * rotation.z_axis;
    (is_rigid && target.is_finite()).then(|| {
        let up = rotation.y_axis;
        let plain = |digits| {
            let [origin, target] = short_together([origin, target], digits);
            TransformOp::LookAt {
                origin,
                target,
                // An upright camera gets short numbers.
                up: if up.y > 0.1 && rotation.x_axis.y.abs() < 1e-6 {
                    Vec3::Y
                } else {
                    up
                },
            }
        };
        let moved = |made: &Affine3A| Vec3::from(made.translation).as_dvec3().distance(origin.as_dvec3());
        let is_alike = |step: &TransformOp| {
            let made = step.affine();
            made.matrix3.abs_diff_eq(map.matrix3, 5.0 * SHORTENED)
                && made.translation.abs_diff_eq(map.translation, SHORTENED * distance)
                // In a tiny scene the digits of the position would be lost beside the distance to the target.
                && moved(&made) <= MOVED * origin.as_dvec3().length()
        };
        [6, 7]
            .map(plain)
            .into_iter()
            .find(is_alike)
            .unwrap_or(TransformOp::LookAt { origin, target, up })
    })
}

#[cfg(test)]
mod tests {
    use bevy::math::Quat;

    use super::*;

    #[test]
    fn maps_without_shear_become_steps() {
        let turn = Quat::from_axis_angle(Vec3::new(1.0, 2.0, -0.5).normalize(), 2.0);
        for scale in [Vec3::new(2.0, 0.5, 3.0), Vec3::new(-1.0, 1.0, 1.0), Vec3::splat(1e-3)] {
            let map = Affine3A::from_scale_rotation_translation(scale, turn, Vec3::new(5.0, -7.0, 100.0));
            let steps = as_steps(&map, None);
            assert_eq!(steps.len(), 5, "{steps:?}");
            assert!(TransformOp::compose(&steps).abs_diff_eq(map, 1e-3));
        }
        assert!(as_steps(&Affine3A::IDENTITY, None).is_empty());
        // The square of the distance is beyond single precision, and then the target is as well.
        let far = |x: f32| as_look_at(&Affine3A::from_translation(Vec3::X * x));
        assert!(far(2e19).is_some_and(|look| look.affine().is_finite()));
        assert!(far(f32::MAX).is_none_or(|look| look.affine().is_finite()));
        let shear = Affine3A::from_mat3(Mat3::from_cols(Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Z));
        assert_eq!(as_steps(&shear, None), [TransformOp::Matrix(Mat4::from(shear))]);
        // This also holds for something small that is far away.
        let small = Affine3A::from_translation(Vec3::splat(100.0)) * shear * Affine3A::from_scale(Vec3::splat(1e-4));
        assert_eq!(as_steps(&small, None), [TransformOp::Matrix(Mat4::from(small))]);
    }

    #[test]
    fn a_camera_has_no_coordinates_that_are_nothing() {
        let step = TransformOp::LookAt {
            origin: Vec3::new(3.0, 2.0, -4.0),
            target: Vec3::ZERO,
            up: Vec3::Y,
        };
        let again = as_look_at(&step.affine());
        let Some(TransformOp::LookAt { origin, target, .. }) = again else {
            panic!("{again:?}");
        };
        for number in origin.to_array().into_iter().chain(target.to_array()) {
            assert!(number.to_string().len() < 9, "{number}");
        }
        assert_eq!((origin, target), (Vec3::new(3.0, 2.0, -4.0), Vec3::ZERO));
    }

    #[test]
    fn a_camera_of_a_tiny_scene_keeps_its_place() {
        let turn = Quat::from_axis_angle(Vec3::new(1.0, 2.0, -0.5).normalize(), 2.0);
        for size in [1e-3, 1e-6, 1e-12] {
            let place = size * Vec3::new(1.234_567, -0.345_678_9, 2.618_034);
            let made = as_look_at(&Affine3A::from_rotation_translation(turn, place)).map(|step| step.affine());
            let moved = made.map(|made| Vec3::from(made.translation).distance(place));
            assert!(
                moved.is_some_and(|moved| moved <= 1e-6 * place.length()),
                "{size} {moved:?}"
            );
        }
    }

    #[test]
    fn a_camera_far_away_keeps_its_direction() {
        let step = TransformOp::LookAt {
            origin: Vec3::new(1000.0, 2000.0, -500.0),
            target: Vec3::new(1000.5, 2000.2, -500.4),
            up: Vec3::Y,
        };
        let map = step.affine();
        let again = as_look_at(&map).map(|step| step.affine());
        assert!(again.is_some_and(|again| again.abs_diff_eq(map, 1e-6 * 2000.0)));
        assert_eq!(as_look_at(&Affine3A::from_scale(Vec3::splat(2.0))), None);
    }
}
