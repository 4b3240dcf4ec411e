//! The size of the selection along the axes of the world.

use bevy::math::{Affine3A, Mat3A, Vec3};
use bevy_egui::egui::Ui;

use super::fields;
use super::lengths;
use crate::math::Aabb;
use crate::scene::{Shape, ShapeKind};

/// The cosine of the largest angle between an axis of a thing and one of the world that counts as none.
const ALONG: f32 = 0.99999;
/// An extent below this share of the largest counts as none, such as the thickness of a rectangle.
const FLAT: f32 = 1e-5;

/// Shows the extents of a box. A new extent scales `to_world` about the middle of the box, so that the box gets that extent. True if edited.
/// Without a pose, or if it is turned, the numbers are only shown.
pub(super) fn dimensions(ui: &mut Ui, bounds: &Aabb, to_world: Option<&mut Affine3A>, shape: Option<&Shape>) -> bool {
    let extent = bounds.extent();
    let scalable = to_world.filter(|pose| shape.is_some() && axes_of(&pose.matrix3).is_some());
    let Some(to_world) = scalable else {
        let unit = lengths::unit(ui);
        let [x, y, z] = extent.to_array().map(|extent| unit.number(extent));
        let text = format!("{x} × {y} × {z}{}", unit.sign());
        fields::note(ui, "Size", text);
        return false;
    };
    let mut edited = extent;
    let speed = 0.005 * extent.max_element().max(1e-3);
    if !lengths::vector(ui, "Size", &mut edited, speed) {
        return false;
    }
    let even = shape.is_some_and(|shape| matches!(shape.kind, ShapeKind::Sphere { .. }));
    match scaled(to_world, bounds, edited, even) {
        Some(pose) => *to_world = pose,
        None => return false,
    }
    true
}

/// The axis of the world that each axis of a matrix is along; None if one of them is along none.
fn axes_of(matrix: &Mat3A) -> Option<[usize; 3]> {
    let axes = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|axis| {
        let axis = Vec3::from(axis).normalize_or_zero().abs();
        (axis.max_element() > ALONG).then(|| axis.max_position())
    });
    Some([axes[0]?, axes[1]?, axes[2]?])
}

/// The pose with which the box has another extent and the same middle. `even`: all axes grow by the factor of the one that was changed. None
/// where that cannot be.
pub fn scaled(to_world: &Affine3A, bounds: &Aabb, extent: Vec3, even: bool) -> Option<Affine3A> {
    let before = bounds.extent();
    let least = FLAT * before.max_element();
    let factor = |axis: usize| match before[axis] > least && extent[axis] != before[axis] {
        true => extent[axis] / before[axis],
        false => 1.0,
    };
    let mut factors = Vec3::new(factor(0), factor(1), factor(2));
    if even {
        let changed = factors.to_array().into_iter().find(|factor| *factor != 1.0);
        factors = Vec3::splat(changed.unwrap_or(1.0));
    }
    let middle = Affine3A::from_translation(bounds.center());
    let pose = middle * Affine3A::from_scale(factors) * middle.inverse() * *to_world;
    (factors.min_element() > 0.0 && factors != Vec3::ONE && pose.is_finite()).then_some(pose)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bounds() -> Aabb {
        Aabb {
            min: Vec3::new(1.0, -1.0, 0.0),
            max: Vec3::new(3.0, 1.0, 0.0),
        }
    }

    #[test]
    fn a_typed_extent_scales_along_one_axis_about_the_middle() {
        let pose = Affine3A::from_translation(Vec3::X * 2.0);
        let now = scaled(&pose, &bounds(), Vec3::new(6.0, 2.0, 0.0), false).expect("it can be");
        assert!(
            now.transform_point3(Vec3::ONE)
                .abs_diff_eq(Vec3::new(5.0, 1.0, 1.0), 1e-5)
        );
        let even = scaled(&pose, &bounds(), Vec3::new(6.0, 2.0, 0.0), true).expect("it can be");
        assert!(
            even.transform_point3(Vec3::ONE)
                .abs_diff_eq(Vec3::new(5.0, 3.0, 3.0), 1e-5)
        );
    }

    #[test]
    fn what_is_flat_stays_flat_and_nothing_becomes_flat() {
        let pose = Affine3A::IDENTITY;
        assert_eq!(scaled(&pose, &bounds(), Vec3::new(2.0, 2.0, 5.0), false), None);
        assert_eq!(scaled(&pose, &bounds(), Vec3::new(0.0, 2.0, 0.0), false), None);
        assert_eq!(scaled(&pose, &bounds(), Vec3::new(2.0, -1.0, 0.0), false), None);
    }

    #[test]
    fn only_what_is_turned_by_right_angles_lies_along_the_axes() {
        let quarter =
            Mat3A::from_rotation_y(std::f32::consts::FRAC_PI_2) * Mat3A::from_diagonal(Vec3::new(2.0, 3.0, 4.0));
        assert_eq!(axes_of(&quarter), Some([2, 1, 0]));
        assert_eq!(axes_of(&Mat3A::from_rotation_y(0.3)), None);
    }
}
