//! Flying and looking around: computes how keys and drags move the camera. Pure arithmetic, so that it is the same at
//! any frame rate. Movements relative to things are in `orbit`.
//!
//! The camera looks along +z of its own space with +x to its left and +y up. Scale in its pose stays: for an
//! orthographic camera it is the extent of the picture.

use bevy::math::{Affine3A, Mat3A, Quat, Vec2, Vec3, Vec3A};

use crate::app::editor::command::preferences::SPEED_RANGE;
use crate::math::Aabb;

/// Radians per point of mouse movement: a quarter turn takes about 500 points.
const LOOK_RATE: f32 = 0.003;
/// The seconds that crossing the scene takes at speed 1.
const SECONDS_ACROSS: f32 = 4.0;
/// A notch of the wheel dollies as far as this many seconds of flying.
const SECONDS_PER_NOTCH: f32 = 0.2;
/// A notch of the wheel changes the speed by this factor.
const SPEED_PER_NOTCH: f32 = 1.2;
const FAST: f32 = 4.0;
const SLOW: f32 = 0.25;
/// Longer frames (the first after a pause) count as this long, in seconds, so that the camera never leaps.
const LONGEST_FRAME: f32 = 0.1;
/// The least angle, in radians, between the view and straight up or down.
const POLE_MARGIN: f32 = 0.02;

/// One frame's input.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct FlyInput {
    /// The direction to the left, up and forward, each in [-1, 1].
    pub direction: Vec3,
    /// Mouse movement in points while looking, +x right, +y down.
    pub look: Vec2,
    pub fast: bool,
    pub slow: bool,
    /// Seconds since the last frame.
    pub seconds: f32,
}

impl FlyInput {
    /// The factor on the speed.
    pub(super) fn pace(&self) -> f32 {
        match (self.fast, self.slow) {
            (true, false) => FAST,
            (false, true) => SLOW,
            _ => 1.0,
        }
    }

    /// The seconds that count.
    pub(super) fn seconds(&self) -> f32 {
        self.seconds.clamp(0.0, LONGEST_FRAME)
    }
}

/// The settings of navigation besides the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Navigation {
    /// The multiple of the speed that suits the scene.
    pub speed: f32,
    /// World units: the diagonal of the scene's bounds.
    pub scene_size: f32,
    /// The world's upward direction.
    pub up: Vec3,
    /// The last centre of orbits, in world space.
    pub pivot: Option<Vec3>,
}

impl Default for Navigation {
    fn default() -> Self {
        Self {
            speed: 1.0,
            scene_size: 1.0,
            up: Vec3::Y,
            pivot: None,
        }
    }
}

impl Navigation {
    /// World units per second.
    pub(crate) fn units_per_second(&self) -> f32 {
        self.speed * self.scene_size / SECONDS_ACROSS
    }

    /// Sets the speed, limited to its range.
    pub(crate) fn set_speed(&mut self, speed: f32) {
        self.speed = speed.clamp(*SPEED_RANGE.start(), *SPEED_RANGE.end());
    }

    /// The speed after turning the wheel by `notches`.
    pub(crate) fn speed_after(&self, notches: f32) -> f32 {
        (self.speed * SPEED_PER_NOTCH.powf(notches)).clamp(*SPEED_RANGE.start(), *SPEED_RANGE.end())
    }

    /// World units that a notch of the wheel moves if no surface is ahead.
    pub(crate) fn units_per_notch(&self) -> f32 {
        SECONDS_PER_NOTCH * self.units_per_second()
    }

    /// The pose after one frame, or None if nothing moves it.
    pub(crate) fn fly(&self, world_from_camera: Affine3A, input: &FlyInput) -> Option<Affine3A> {
        if input.direction == Vec3::ZERO && input.look == Vec2::ZERO {
            return None;
        }
        let rotation = if input.look == Vec2::ZERO {
            orthonormal(&world_from_camera.matrix3)
        } else {
            self.looking(&world_from_camera, input.look)
        };
        let [left, up, ahead] = input.direction.to_array();
        let way = Vec3::from(rotation.x_axis) * left + self.up * up + Vec3::from(rotation.z_axis) * ahead;
        let way = way.clamp_length_max(1.0) * (input.seconds() * input.pace() * self.units_per_second());
        let pose = Affine3A {
            matrix3: rotation * Mat3A::from_diagonal(scale_of(&world_from_camera)),
            translation: world_from_camera.translation + Vec3A::from(way),
        };
        pose.is_finite().then_some(pose)
    }

    /// The level axes of a camera that is turned by a mouse movement in points.
    pub(crate) fn looking(&self, world_from_camera: &Affine3A, look: Vec2) -> Mat3A {
        let forward = Vec3::from(world_from_camera.matrix3.z_axis).normalize_or(Vec3::Z);
        let angles = look * LOOK_RATE;
        // Elevation and heading are changed separately, so that the horizon stays level.
        let elevation = forward.dot(self.up).clamp(-1.0, 1.0).asin();
        let limit = std::f32::consts::FRAC_PI_2 - POLE_MARGIN;
        let elevation = (elevation - angles.y).clamp(-limit, limit);
        let heading = Quat::from_axis_angle(self.up, -angles.x) * self.heading(world_from_camera);
        facing(heading * elevation.cos() + self.up * elevation.sin(), self.up)
    }

    /// The direction that is up in a picture of this pose: the world's up, or the heading if the view is straight up or
    /// down.
    pub(crate) fn upright(&self, world_from_camera: &Affine3A) -> Vec3 {
        let forward = Vec3::from(world_from_camera.matrix3.z_axis).normalize_or(Vec3::Z);
        let down = -forward.dot(self.up);
        if down.abs() > POLE_MARGIN.cos() {
            self.heading(world_from_camera) * down.signum()
        } else {
            self.up
        }
    }

    /// The level unit direction in which a camera looks, or straight up and down that of its upper or lower edge.
    pub(super) fn heading(&self, world_from_camera: &Affine3A) -> Vec3 {
        let [upward, forward] = [world_from_camera.matrix3.y_axis, world_from_camera.matrix3.z_axis]
            .map(|axis| Vec3::from(axis).normalize_or_zero());
        let level = |direction: Vec3| direction - self.up * direction.dot(self.up);
        let ahead = level(forward);
        if ahead.length() > POLE_MARGIN.sin() {
            return ahead.normalize();
        }
        let edge = level(upward) * -forward.dot(self.up).signum();
        edge.normalize_or(self.up.any_orthonormal_vector())
    }
}

/// The world axis that is nearest to a camera's upward direction: the upward direction of a scene that gives none.
pub(crate) fn up_axis(world_from_camera: &Affine3A) -> Vec3 {
    let up = Vec3::from(world_from_camera.matrix3.y_axis);
    let axis = up.abs().max_position();
    let mut unit = Vec3::ZERO;
    unit[axis] = if up[axis] < 0.0 { -1.0 } else { 1.0 };
    unit
}

/// The pose with the same direction that frames all of `bounds`; None if it is empty. `half_fov` in radians, of the
/// picture's narrower side.
pub(crate) fn framing(world_from_camera: Affine3A, bounds: &Aabb, half_fov: f32) -> Option<Affine3A> {
    if bounds.is_empty() {
        return None;
    }
    let rotation = orthonormal(&world_from_camera.matrix3);
    let radius = bounds.framed_radius();
    let distance = radius / half_fov.clamp(0.01, 1.5).sin();
    let translation = Vec3A::from(bounds.center()) - rotation.z_axis * distance;
    let pose = Affine3A {
        matrix3: rotation,
        translation,
    };
    pose.is_finite().then_some(pose)
}

/// [`framing`] for an orthographic camera, whose scale is its extent; `aspect` is the picture's width over its height.
pub(crate) fn framing_parallel(world_from_camera: Affine3A, bounds: &Aabb, aspect: f32) -> Option<Affine3A> {
    let radius = bounds.framed_radius();
    // At a distance of twice the radius no part of the sphere is behind the camera.
    let pose = framing(world_from_camera, bounds, 30f32.to_radians())?;
    let pose = pose * Affine3A::from_scale(Vec3::new(1.0, 1.0, 0.0) * radius * aspect.max(1.0) + Vec3::Z);
    pose.is_finite().then_some(pose)
}

/// The lengths of the pose's axes.
pub(crate) fn scale_of(pose: &Affine3A) -> Vec3 {
    let axes = pose.matrix3;
    Vec3::new(axes.x_axis.length(), axes.y_axis.length(), axes.z_axis.length())
}

/// A level camera that looks along `forward` (unit length, not parallel to `up`).
pub(crate) fn facing(forward: Vec3, up: Vec3) -> Mat3A {
    let left = up.cross(forward).normalize_or(forward.any_orthonormal_vector());
    Mat3A::from_cols(left.into(), forward.cross(left).into(), forward.into())
}

/// The axes without scale, shear or mirroring.
fn orthonormal(matrix: &Mat3A) -> Mat3A {
    let forward = Vec3::from(matrix.z_axis).normalize_or(Vec3::Z);
    facing(forward, Vec3::from(matrix.y_axis))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pose() -> Affine3A {
        Affine3A::IDENTITY
    }

    fn forward(pose: &Affine3A) -> Vec3 {
        pose.matrix3.z_axis.into()
    }

    #[test]
    fn nothing_pressed_moves_nothing() {
        let input = FlyInput {
            seconds: 0.1,
            fast: true,
            ..FlyInput::default()
        };
        assert_eq!(Navigation::default().fly(pose(), &input), None);
    }

    #[test]
    fn dragging_right_looks_right_and_down_looks_down() {
        let look = |x, y| FlyInput {
            look: Vec2::new(x, y),
            ..FlyInput::default()
        };
        let navigation = Navigation::default();
        // +x is to the camera's left.
        let right = navigation.fly(pose(), &look(100.0, 0.0)).map(|p| forward(&p));
        assert!(right.is_some_and(|f| f.x < -0.2 && f.y.abs() < 1e-6), "{right:?}");
        let down = navigation.fly(pose(), &look(0.0, 100.0)).map(|p| forward(&p));
        assert!(down.is_some_and(|f| f.y < -0.2 && f.x.abs() < 1e-6), "{down:?}");
    }

    #[test]
    fn the_view_stays_level_and_stops_at_the_pole() {
        let navigation = Navigation::default();
        let input = FlyInput {
            look: Vec2::new(13.0, -400.0),
            ..FlyInput::default()
        };
        let mut camera = pose();
        for _ in 0..20 {
            camera = navigation.fly(camera, &input).unwrap_or(camera);
            assert!(camera.matrix3.x_axis.y.abs() < 1e-4, "tilted");
            assert!((camera.matrix3.determinant() - 1.0).abs() < 1e-4);
        }
        assert!(forward(&camera).y > 0.99 && camera.matrix3.y_axis.y > 0.0);
    }

    #[test]
    fn two_short_frames_go_as_far_as_a_long_one() {
        let navigation = Navigation {
            scene_size: 8.0,
            ..Navigation::default()
        };
        let step = |seconds| FlyInput {
            direction: Vec3::new(0.0, 0.0, 1.0),
            seconds,
            ..FlyInput::default()
        };
        let once = navigation.fly(pose(), &step(0.08)).unwrap_or_default();
        let half = navigation.fly(pose(), &step(0.04)).unwrap_or_default();
        let twice = navigation.fly(half, &step(0.04)).unwrap_or_default();
        assert!(once.abs_diff_eq(twice, 1e-6));
        assert!((once.translation.z - 8.0 / SECONDS_ACROSS * 0.08).abs() < 1e-6);
        let leap = navigation.fly(pose(), &step(5.0)).unwrap_or_default();
        assert!(leap.translation.z <= 8.0 / SECONDS_ACROSS * LONGEST_FRAME + 1e-6);
    }

    #[test]
    fn framing_fits_the_sphere_around_the_box() {
        let bounds = Aabb {
            min: Vec3::new(1.0, 1.0, 1.0),
            max: Vec3::new(3.0, 3.0, 3.0),
        };
        let camera = framing(pose(), &bounds, 0.5).unwrap_or_default();
        let distance = camera.translation.distance(Vec3A::splat(2.0));
        assert!((distance * 0.5f32.sin() - 3.0f32.sqrt()).abs() < 1e-5);
        assert_eq!(framing(pose(), &Aabb::EMPTY, 0.5), None);
    }

    #[test]
    fn framing_in_parallel_fits_the_sphere_into_the_narrower_side() {
        let bounds = Aabb {
            min: Vec3::splat(1.0),
            max: Vec3::splat(3.0),
        };
        for aspect in [2.0, 0.5] {
            let camera = framing_parallel(pose(), &bounds, aspect).unwrap_or_default();
            let half_width = camera.matrix3.x_axis.length();
            assert!((half_width.min(half_width / aspect) - 3.0f32.sqrt()).abs() < 1e-5);
            assert!((camera.translation.z - (2.0 - 2.0 * 3.0f32.sqrt())).abs() < 1e-5);
        }
    }

    #[test]
    fn up_is_an_axis() {
        let tilted = Affine3A::from_rotation_x(1.2);
        assert_eq!(up_axis(&tilted), Vec3::Z);
        assert_eq!(up_axis(&Affine3A::from_rotation_x(0.3)), Vec3::Y);
    }
}
