//! Shows the translation, rotation and scale of an entity.

use bevy::math::{Affine3A, Mat3A, Quat, Vec3};
use bevy_egui::egui::Ui;

use super::caption::Caption;
use super::{fields, lengths};
use crate::app::editor::model::freedom::Freedom;
use crate::scene::Turned;
use crate::scene::euler::from_rest;

/// An edit of a pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PoseEdit {
    /// Nothing was edited.
    None,
    /// Its place or its scale was edited.
    Moved,
    /// Its rotation was given by these angles about x, then y, then z, in degrees.
    Turned(Vec3),
}

/// Shows the rows of a pose, and edits it. `size` (world units) sets how fast a drag moves. `angles` are the known
/// angles of the rotation. The rotation is shown relative to `rest`.
pub fn transform(
    ui: &mut Ui,
    to_world: &mut Affine3A,
    freedom: Freedom,
    size: f32,
    angles: Option<Vec3>,
    rest: Vec3,
) -> PoseEdit {
    let moved = match freedom != Freedom::Turning && position(ui, to_world, size) {
        true => PoseEdit::Moved,
        false => PoseEdit::None,
    };
    let Some(turned) = Turned::of(&to_world.matrix3, angles) else {
        fields::note(
            ui,
            ("Rotation", "to_world.rotation"),
            "sheared: only the position can be edited",
        );
        return moved;
    };
    let mut edited = turned;
    edited.degrees = from_rest(turned.degrees, -rest);
    let is_turned = fields::vector(ui, ("Rotation", "to_world.rotation"), &mut edited.degrees, 0.5, "°");
    edited.degrees = from_rest(edited.degrees, rest);
    let is_scaled = freedom == Freedom::Affine
        && fields::vector(
            ui,
            ("Scale", "to_world.scale"),
            &mut edited.scale,
            0.002 * turned.scale.length().max(1e-3),
            "",
        );
    if !is_turned {
        edited.degrees = turned.degrees;
    }
    if is_turned || is_scaled {
        edited.scale = nonzero(edited.scale);
        to_world.matrix3 = edited.matrix();
    }
    match (is_turned, is_scaled) {
        (true, _) => PoseEdit::Turned(edited.degrees),
        (false, true) => PoseEdit::Moved,
        (false, false) => moved,
    }
}

/// Shows the row of a position; returns true if edited. `size` (world units) sets the speed of drags.
pub(super) fn position(ui: &mut Ui, to_world: &mut Affine3A, size: f32) -> bool {
    let mut translation = Vec3::from(to_world.translation);
    let caption = ("Position", "to_world.position");
    let moved = lengths::vector(ui, caption, &mut translation, 0.002 * size);
    if moved {
        to_world.translation = translation.into();
    }
    moved
}

/// Shows a turn about the thing's own axis `up`, on a slider; returns true if edited. Shows nothing for a sheared
/// transform.
pub fn turn(ui: &mut Ui, to_world: &mut Affine3A, up: Vec3) -> bool {
    let Some(Turned { scale, degrees }) = Turned::of(&to_world.matrix3, None) else {
        return false;
    };
    let turned = Turned {
        scale: Vec3::ONE,
        degrees,
    };
    let (swing, mut degrees) = spin_about(Quat::from_mat3a(&turned.matrix()), up);
    let caption = Caption::from("Azimuth").explained("The angle about the vertical axis");
    let turned = fields::angle_slider(ui, caption, &mut degrees, -180.0..=180.0);
    if turned {
        let rotation = swing * Quat::from_axis_angle(up, degrees.to_radians());
        to_world.matrix3 = Mat3A::from_quat(rotation) * Mat3A::from_diagonal(scale);
    }
    turned
}

/// The rest of a rotation after a turn about its own axis `up`, and the degrees of that turn, -180 to 180.
fn spin_about(rotation: Quat, up: Vec3) -> (Quat, f32) {
    let along = Vec3::new(rotation.x, rotation.y, rotation.z).dot(up);
    // Upside down the turn cannot be separated from the rest: then it is zero.
    let angle = if along == 0.0 && rotation.w == 0.0 {
        0.0
    } else {
        2.0 * along.atan2(rotation.w)
    };
    let swing = rotation * Quat::from_axis_angle(up, -angle);
    let degrees = (angle.to_degrees() + 180.0).rem_euclid(360.0) - 180.0;
    (swing, degrees)
}

/// A scale without zeros, which would make the thing invisible for good.
fn nonzero(scale: Vec3) -> Vec3 {
    scale.map(|s| if s.abs() < 1e-6 { 1e-6 } else { s })
}

#[cfg(test)]
mod tests {
    use super::*;

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
}
