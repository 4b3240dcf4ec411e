//! Shows the translation, rotation and scale of an entity.

use bevy::math::{Affine3A, EulerRot, Mat3A, Quat, Vec3};
use bevy_egui::egui::Ui;

use super::caption::Caption;
use super::{fields, lengths};
use crate::app::editor::model::freedom::Freedom;

/// The angles that were last shown. A rotation has many sets of angles; those that the user dragged are kept so that they do not jump.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShownAngles {
    rotation: Quat,
    degrees: Vec3,
}

const ORDER: EulerRot = EulerRot::ZYX;
/// Two rotations closer than this are the same one, written by us.
const SAME_ROTATION: f32 = 1e-5;
/// The most that a matrix may differ from translation, rotation and scale and still count as made of them, relative to its size.
const SHEAR_TOLERANCE: f32 = 1e-4;

/// Shows the rows of a pose; true if `to_world` was edited. `size` (world units) sets how fast a drag moves.
pub fn transform(ui: &mut Ui, to_world: &mut Affine3A, freedom: Freedom, size: f32, shown: &mut ShownAngles) -> bool {
    let moved = freedom != Freedom::Turning && position(ui, to_world, size);
    let Some((scale, rotation)) = decompose(&to_world.matrix3) else {
        fields::note(
            ui,
            ("Rotation", "to_world.rotation"),
            "sheared: only the position can be edited",
        );
        return moved;
    };
    let mut degrees = degrees(rotation, shown);
    let turned = fields::vector(ui, ("Rotation", "to_world.rotation"), &mut degrees, 0.5, "°");
    let mut edited_scale = scale;
    let scaled = freedom == Freedom::Affine
        && fields::vector(
            ui,
            ("Scale", "to_world.scale"),
            &mut edited_scale,
            0.002 * scale.length().max(1e-3),
            "",
        );
    if turned || scaled {
        let rotation = if turned { from_degrees(degrees) } else { rotation };
        *shown = ShownAngles { rotation, degrees };
        let matrix3 = Mat3A::from_quat(rotation) * Mat3A::from_diagonal(nonzero(edited_scale));
        to_world.matrix3 = matrix3;
    }
    moved || turned || scaled
}

/// Shows the row of a place; true if it was edited. `size` (world units) sets how fast a drag moves.
pub(super) fn position(ui: &mut Ui, to_world: &mut Affine3A, size: f32) -> bool {
    let mut translation = Vec3::from(to_world.translation);
    let caption = ("Position", "to_world.position");
    let moved = lengths::vector(ui, caption, &mut translation, 0.002 * size);
    if moved {
        to_world.translation = translation.into();
    }
    moved
}

/// A turn about the thing's own axis `up`, on a slider; true if edited. Nothing is shown of a sheared map.
pub fn turn(ui: &mut Ui, to_world: &mut Affine3A, up: Vec3) -> bool {
    let Some((scale, rotation)) = decompose(&to_world.matrix3) else {
        return false;
    };
    let (swing, mut degrees) = spin_about(rotation, up);
    let caption = Caption::from("Azimuth").explained("The angle about the vertical axis");
    let turned = fields::slider_with(ui, caption, &mut degrees, -180.0..=180.0, |slider| {
        slider.suffix("°").max_decimals(1)
    });
    if turned {
        let rotation = swing * Quat::from_axis_angle(up, degrees.to_radians());
        to_world.matrix3 = Mat3A::from_quat(rotation) * Mat3A::from_diagonal(scale);
    }
    turned
}

/// The rotation that remains when a turn about its own axis `up` is done first, and the degrees of that turn, -180 to 180.
fn spin_about(rotation: Quat, up: Vec3) -> (Quat, f32) {
    let along = Vec3::new(rotation.x, rotation.y, rotation.z).dot(up);
    // Upside down the turn cannot be told from the rest: then it is zero.
    let angle = if along == 0.0 && rotation.w == 0.0 {
        0.0
    } else {
        2.0 * along.atan2(rotation.w)
    };
    let swing = rotation * Quat::from_axis_angle(up, -angle);
    let degrees = (angle.to_degrees() + 180.0).rem_euclid(360.0) - 180.0;
    (swing, degrees)
}

/// The scale and rotation, or None for a sheared matrix.
fn decompose(matrix: &Mat3A) -> Option<(Vec3, Quat)> {
    let (scale, rotation, _) = Affine3A {
        matrix3: *matrix,
        translation: Default::default(),
    }
    .to_scale_rotation_translation();
    let made = Mat3A::from_quat(rotation) * Mat3A::from_diagonal(scale);
    let tolerance = SHEAR_TOLERANCE * scale.abs().max_element();
    let fits = made.is_finite() && made.abs_diff_eq(*matrix, tolerance);
    fits.then_some((scale, rotation))
}

/// The angles about x, then y, then z.
fn degrees(rotation: Quat, shown: &ShownAngles) -> Vec3 {
    if rotation.dot(shown.rotation).abs() > 1.0 - SAME_ROTATION * SAME_ROTATION {
        return shown.degrees;
    }
    let (z, y, x) = rotation.to_euler(ORDER);
    // Adding zero turns -0 into 0.
    Vec3::new(x, y, z).map(f32::to_degrees) + Vec3::ZERO
}

fn from_degrees(degrees: Vec3) -> Quat {
    let [x, y, z] = degrees.map(f32::to_radians).to_array();
    Quat::from_euler(ORDER, z, y, x)
}

/// A scale of zero would leave nothing to see, and no way back.
fn nonzero(scale: Vec3) -> Vec3 {
    scale.map(|s| if s.abs() < 1e-6 { 1e-6 } else { s })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_come_back() {
        let degrees_in = Vec3::new(20.0, -35.0, 110.0);
        let out = degrees(from_degrees(degrees_in), &ShownAngles::default());
        assert!(out.abs_diff_eq(degrees_in, 1e-3), "{out}");
    }

    #[test]
    fn a_turn_about_the_upward_axis_is_told_from_the_rest() {
        for tilt in [Quat::IDENTITY, Quat::from_rotation_x(1.2), Quat::from_rotation_z(-2.0)] {
            for degrees in [-170.0f32, -30.0, 0.0, 95.0] {
                let rotation = tilt * Quat::from_rotation_y(degrees.to_radians());
                let (swing, found) = spin_about(rotation, Vec3::Y);
                let again = swing * Quat::from_rotation_y(found.to_radians());
                assert!(again.dot(rotation).abs() > 1.0 - 1e-5);
                assert!((found - degrees).abs() < 1e-2, "{found} {degrees}");
            }
        }
    }

    #[test]
    fn shear_is_noticed() {
        let sheared = Mat3A::from_cols(Vec3::X.into(), Vec3::new(0.5, 1.0, 0.0).into(), Vec3::Z.into());
        assert!(decompose(&sheared).is_none());
        let turned = Mat3A::from_rotation_y(0.7) * Mat3A::from_diagonal(Vec3::new(1.0, 200.0, -3.0));
        assert!(decompose(&turned).is_some());
    }
}
