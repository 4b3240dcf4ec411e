//! New sizes for things: the scale along the axes of the world that gives them an extent.

use bevy::math::{Affine3A, Mat3A, Vec3, Vec3A};

use super::rounding;
use crate::math::Aabb;
use crate::scene::{Shape, ShapeKind, world_bounds};

/// The cosine of the largest angle between an axis of a thing and one of the world that count as parallel.
const ALONG: f32 = 0.99999;
/// An extent below this share of the largest counts as zero, such as the thickness of a rectangle.
const FLAT: f32 = 1e-5;
/// The largest distance of the middle of a box from the origin of its space that counts as zero, as a share of the box.
const MIDDLE: f32 = 1e-5;

/// The axis of the world that is parallel to each axis of a matrix; None if one has no such axis.
pub fn axes_of(matrix: &Mat3A) -> Option<[usize; 3]> {
    let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| {
        let axis = Vec3::from(axis).normalize_or_zero().abs();
        (axis.max_element() > ALONG).then(|| axis.max_position())
    });
    Some([axes[0]?, axes[1]?, axes[2]?])
}

/// The pose with which a thing has another extent in the world and the same middle; it must lie along the axes of the
/// world. The scale is the typed extent over the shape's extent in its own space, if that is known: its bounds in the
/// world are rounded. All axes of a sphere grow by the factor of the changed one. None if there is no such pose.
pub fn scaled(pose: &Affine3A, bounds: &Aabb, extent: Vec3, shape: Option<&Shape>) -> Option<Affine3A> {
    let before = bounds.extent();
    let along = axes_of(&pose.matrix3)?;
    let least = FLAT * before.max_element();
    let is_edited = |axis: usize| before[axis] > least && extent[axis] != before[axis];
    let own = shape.and_then(|shape| world_bounds(shape, &Affine3A::IDENTITY, None));
    let is_even = shape.is_some_and(|shape| matches!(shape.kind, ShapeKind::Sphere { .. }));
    let edited: Vec<usize> = (0..3).filter(|axis| is_edited(*axis)).collect();
    if edited.is_empty() || edited.iter().any(|axis| extent[*axis] <= 0.0) {
        return None;
    }
    let mut matrix3 = pose.matrix3;
    for (column, axis) in along.into_iter().enumerate() {
        let axis = if is_even { edited[0] } else { axis };
        if !is_even && !is_edited(axis) {
            continue;
        }
        let direction = pose.matrix3.col(column);
        *matrix3.col_mut(column) = match own.map(|own| own.extent()[column]).filter(|own| *own > 0.0) {
            Some(own) => direction.normalize() * (extent[axis] / own),
            None => direction * (extent[axis] / before[axis]),
        };
    }
    // The middle of the box in the space of the pose.
    let middle = pose.inverse().transform_point3(bounds.center());
    let moved = bounds.center() - Vec3::from(matrix3 * Vec3A::from(middle));
    let unit = rounding::fine_unit(before.max_element());
    let is_at_middle =
        middle.abs().max_element() <= MIDDLE * pose.inverse().transform_vector3(before).abs().max_element();
    let scaled = Affine3A {
        matrix3,
        translation: match is_at_middle {
            true => pose.translation,
            false => rounding::rounded_place(moved, unit).into(),
        },
    };
    scaled.is_finite().then_some(scaled)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Solid;

    fn shape(kind: ShapeKind) -> Shape {
        Shape {
            kind,
            ..Shape::default()
        }
    }

    fn bounds() -> Aabb {
        Aabb {
            min: Vec3::new(1.0, -1.0, 0.0),
            max: Vec3::new(3.0, 1.0, 0.0),
        }
    }

    #[test]
    fn a_typed_extent_scales_along_one_axis_about_the_middle() {
        let pose = Affine3A::from_translation(Vec3::X * 2.0);
        let now = scaled(&pose, &bounds(), Vec3::new(6.0, 2.0, 0.0), None).expect("it can be");
        assert!(
            now.transform_point3(Vec3::ONE)
                .abs_diff_eq(Vec3::new(5.0, 1.0, 1.0), 1e-5)
        );
        let ball = shape(ShapeKind::Sphere {
            center: Vec3::ZERO,
            radius: 1.0,
        });
        let even = scaled(&pose, &bounds(), Vec3::new(6.0, 2.0, 0.0), Some(&ball)).expect("it can be");
        assert_eq!(even, pose * Affine3A::from_scale(Vec3::splat(3.0)));
    }

    #[test]
    fn the_scale_is_that_of_the_typed_number() {
        // Turned by a quarter, and far from the origin, so that the bounds are rounded.
        let axes = Mat3A::from_cols(Vec3::NEG_Z.into(), Vec3::Y.into(), Vec3::X.into());
        let pose = Affine3A {
            matrix3: axes * Mat3A::from_diagonal(Vec3::new(0.3, 0.7, 1.1)),
            translation: Vec3::new(100.3, 0.7, -57.1).into(),
        };
        let cube = shape(ShapeKind::Cube);
        let bounds = world_bounds(&cube, &pose, None).expect("it has bounds");
        let extent = Vec3::new(9.0, bounds.extent().y, 0.2);
        let now = scaled(&pose, &bounds, extent, Some(&cube)).expect("it can be");
        let expected = axes * Mat3A::from_diagonal(Vec3::new(0.1, 0.7, 4.5));
        assert_eq!((now.matrix3, now.translation), (expected, pose.translation));
        // A wall begins at its origin, and keeps its middle.
        let wall = shape(ShapeKind::Solid(Solid::default()));
        let bounds = world_bounds(&wall, &Affine3A::IDENTITY, None).expect("it has bounds");
        let extent = Vec3::new(9.0, 0.2, 2.5);
        let now = scaled(&Affine3A::IDENTITY, &bounds, extent, Some(&wall)).expect("it can be");
        assert_eq!(now.translation, Vec3::new(-2.5, 0.0, 0.0).into());
        assert_eq!(now.matrix3, Mat3A::from_diagonal(Vec3::new(2.25, 1.0, 1.0)));
    }

    #[test]
    fn what_is_flat_stays_flat_and_nothing_becomes_flat() {
        let pose = Affine3A::IDENTITY;
        assert_eq!(scaled(&pose, &bounds(), Vec3::new(2.0, 2.0, 5.0), None), None);
        assert_eq!(scaled(&pose, &bounds(), Vec3::new(0.0, 2.0, 0.0), None), None);
        assert_eq!(scaled(&pose, &bounds(), Vec3::new(2.0, -1.0, 0.0), None), None);
    }

    #[test]
    fn only_what_is_turned_by_right_angles_lies_along_the_axes() {
        let quarter =
            Mat3A::from_rotation_y(std::f32::consts::FRAC_PI_2) * Mat3A::from_diagonal(Vec3::new(2.0, 3.0, 4.0));
        assert_eq!(axes_of(&quarter), Some([2, 1, 0]));
        assert_eq!(axes_of(&Mat3A::from_rotation_y(0.3)), None);
    }
}
