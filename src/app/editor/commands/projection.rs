//! Switches the view between perspective and orthographic projection, whatever the file's camera has.

use bevy::math::{Affine3A, Mat3A, Vec3};
use bevy::prelude::*;

use super::view;
use crate::app::editor::camera::navigation;
use crate::app::editor::camera::pose::{self, is_orthographic, lens_of_view};
use crate::app::editor::command::error::CommandError;
use crate::scene::{ActiveSensor, Film, FreeView, Sensor};

/// Switches the projection. The selection keeps its size in the picture, or else the surface ahead.
pub fn switch(world: &mut World) -> Result<(), CommandError> {
    const MISSING: &str = "There is no camera.";
    let pose = pose::view_pose(world).ok_or(MISSING)?;
    let active = world.resource::<ActiveSensor>().0.ok_or(MISSING)?;
    let sensor = *world.get::<Sensor>(active).ok_or(MISSING)?;
    let film = world.get::<Film>(active).copied().unwrap_or_default();
    let aspect = film.width.max(1) as f32 / film.height.max(1) as f32;
    let half_width = (0.5 * sensor.fov_axis.horizontal(sensor.fov, aspect))
        .to_radians()
        .tan();
    let distance = view::distance_looked(world, &pose);
    let orthographic = !is_orthographic(world);
    let pose = if orthographic {
        in_parallel(pose, distance * half_width)
    } else {
        in_perspective(pose, distance, half_width)
    };
    if !pose.is_finite() {
        return Err("The view is too far away for that.".into());
    }
    let lens = lens_of_view(world, orthographic);
    let pose = Some(pose);
    world.resource_mut::<FreeView>().set_if_neq(FreeView { pose, lens });
    Ok(())
}

/// The orthographic pose at the same place for a picture whose half width is `half_width`, in world units.
fn in_parallel(pose: Affine3A, half_width: f32) -> Affine3A {
    let extent = Vec3::new(half_width, half_width, 1.0);
    Affine3A {
        matrix3: unscaled(&pose) * Mat3A::from_diagonal(extent),
        ..pose
    }
}

/// The perspective pose from which things at `distance` fill as much of a picture whose half width at distance 1 is
/// `half_width`.
fn in_perspective(pose: Affine3A, distance: f32, half_width: f32) -> Affine3A {
    let axes = unscaled(&pose);
    let new_distance = pose.matrix3.x_axis.length() / half_width;
    Affine3A {
        matrix3: axes,
        translation: pose.translation + axes.z_axis * (distance - new_distance),
    }
}

fn unscaled(pose: &Affine3A) -> Mat3A {
    let scale = navigation::scale_of(pose).max(Vec3::splat(f32::MIN_POSITIVE));
    pose.matrix3 * Mat3A::from_diagonal(scale.recip())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::camera::Camera;

    /// The picture is as wide as high with ninety degrees: the half width at distance 1 is 1.
    #[test]
    fn what_is_in_the_middle_stays_as_large() {
        let pose = Affine3A::from_rotation_y(0.4) * Affine3A::from_translation(Vec3::new(1.0, 2.0, 3.0));
        let at = |depth: f32, aside: f32| pose.transform_point3(Vec3::new(aside, 0.0, depth));
        let before = Camera::new(pose, 90.0, 1.0, 0.01, 100.0, None).project(at(5.0, 2.0)).0;
        let flat = in_parallel(pose, 5.0);
        let half = flat.matrix3.x_axis.length();
        let rigid = Affine3A {
            matrix3: unscaled(&flat),
            ..flat
        };
        let seen = Camera::orthographic(rigid, bevy::math::Vec2::splat(half), 0.01, 100.0);
        assert!(seen.project(at(5.0, 2.0)).0.abs_diff_eq(before, 1e-4));
        assert!(
            seen.project(at(9.0, 2.0)).0.abs_diff_eq(before, 1e-4),
            "nothing shrinks"
        );
        // Switching back gives the same pose, and the same distance from something nearer.
        assert!(in_perspective(flat, 5.0, 1.0).abs_diff_eq(pose, 1e-4));
        let nearer = in_perspective(flat, 4.0, 1.0);
        let seen = Camera::new(nearer, 90.0, 1.0, 0.01, 100.0, None);
        assert!(seen.project(at(4.0, 2.0)).0.abs_diff_eq(before, 1e-4));
    }
}
