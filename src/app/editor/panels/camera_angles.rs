//! The direction of a camera as yaw, pitch and roll.

use bevy::math::{Affine3A, Mat3A, Quat, Vec3};
use bevy_egui::egui::{DragValue, Ui};

use super::{fields, typed};
use crate::app::editor::camera::navigation::{facing, scale_of};
use crate::app::editor::words::figures::{DEGREES, MOST_DECIMALS, tidy};

/// The horizontal part of a view direction below which a camera looks straight up or down.
const STRAIGHT: f32 = 1e-4;

/// The angles of a camera in degrees, with +y of the world up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CameraAngles {
    /// The heading: 0 looks along -z, 90 along +x.
    pub yaw: f32,
    /// The elevation: positive looks up.
    pub pitch: f32,
    /// The turn about the view direction: positive leans the camera to its right.
    pub roll: f32,
}

impl CameraAngles {
    /// The angles of a pose, world from camera.
    pub fn of(pose: &Affine3A) -> Self {
        let axes = [pose.matrix3.y_axis, pose.matrix3.z_axis];
        let [up, ahead] = axes.map(|axis| Vec3::from(axis).normalize_or_zero());
        let level = ahead.with_y(0.0);
        let pitch = ahead.y.clamp(-1.0, 1.0).asin();
        // If the camera looks straight up or down, the direction of the picture's upper edge gives the heading.
        let heading = match level.length() > STRAIGHT {
            true => level,
            false => up.with_y(0.0) * -ahead.y.signum(),
        };
        let yaw = heading.x.atan2(-heading.z);
        let upright = Vec3::from(Self::level(yaw, pitch).y_axis);
        let roll = upright.cross(up).dot(ahead).atan2(upright.dot(up));
        // Adding zero turns -0 into 0.
        let degrees = |angle: f32| angle.to_degrees() + 0.0;
        Self {
            yaw: degrees(yaw),
            pitch: degrees(pitch),
            roll: degrees(roll),
        }
    }

    /// The axes of a level camera; angles in radians.
    fn level(yaw: f32, pitch: f32) -> Mat3A {
        let heading = Vec3::new(yaw.sin(), 0.0, -yaw.cos());
        let ahead = heading * pitch.cos() + Vec3::Y * pitch.sin();
        let up = Vec3::Y * pitch.cos() - heading * pitch.sin();
        facing(ahead, up)
    }

    /// The rotation, world from camera.
    pub fn rotation(&self) -> Mat3A {
        let [yaw, pitch, roll] = [self.yaw, self.pitch, self.roll].map(f32::to_radians);
        let level = Self::level(yaw, pitch);
        let turn = Quat::from_axis_angle(level.z_axis.into(), roll);
        Mat3A::from_quat(turn) * level
    }
}

/// Shows the angles of a camera's pose; returns true if edited.
pub(super) fn camera_angles(ui: &mut Ui, pose: &mut Affine3A) -> bool {
    let mut angles = CameraAngles::of(pose);
    let mut row = |text: &str, angle: &mut f32, most: f32| {
        let drag = DragValue::new(angle)
            .speed(0.5)
            .clamp_existing_to_range(false)
            .max_decimals(MOST_DECIMALS)
            .suffix(DEGREES);
        let format = |angle, decimals| tidy(DEGREES, angle, decimals);
        let field = typed::number(ui, drag, text, -most..=most, format);
        fields::row(ui, (text, "to_world.rotation"), |ui| fields::wide_number(ui, field)).changed()
    };
    let mut changed = row("Yaw", &mut angles.yaw, 180.0);
    changed |= row("Pitch", &mut angles.pitch, 90.0);
    changed |= row("Roll", &mut angles.roll, 180.0);
    if changed {
        pose.matrix3 = angles.rotation() * Mat3A::from_diagonal(scale_of(pose));
    }
    changed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_come_back() {
        for (yaw, pitch, roll) in [
            (0.0, 0.0, 0.0),
            (30.0, -20.0, 5.0),
            (-170.0, 60.0, -90.0),
            (180.0, 10.0, 0.0),
        ] {
            let given = CameraAngles { yaw, pitch, roll };
            let pose = Affine3A::from_mat3(given.rotation().into());
            let found = CameraAngles::of(&pose);
            let differs = [found.yaw - yaw, found.pitch - pitch, found.roll - roll];
            assert!(
                differs
                    .iter()
                    .all(|by| by.abs() < 1e-3 || (by.abs() - 360.0).abs() < 1e-3),
                "{found:?}"
            );
        }
    }

    #[test]
    fn a_level_camera_to_the_right_has_a_yaw_only() {
        let looking = |ahead: Vec3| Affine3A::from_mat3(facing(ahead, Vec3::Y).into());
        let front = CameraAngles::of(&looking(Vec3::NEG_Z));
        assert_eq!((front.yaw, front.pitch, front.roll), (0.0, 0.0, 0.0));
        let right = CameraAngles::of(&looking(Vec3::X));
        assert!((right.yaw - 90.0).abs() < 1e-4 && right.pitch.abs() < 1e-4 && right.roll.abs() < 1e-4);
        let down = CameraAngles::of(&looking(Vec3::new(0.0, -1.0, -1.0).normalize()));
        assert!((down.pitch + 45.0).abs() < 1e-3 && down.yaw.abs() < 1e-3, "{down:?}");
    }

    #[test]
    fn straight_down_the_upper_edge_says_the_heading() {
        let given = CameraAngles {
            yaw: 40.0,
            pitch: -90.0,
            roll: 0.0,
        };
        let found = CameraAngles::of(&Affine3A::from_mat3(given.rotation().into()));
        assert!(
            (found.yaw - 40.0).abs() < 0.1 && (found.pitch + 90.0).abs() < 0.1,
            "{found:?}"
        );
    }
}
