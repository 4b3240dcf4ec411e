//! Moves the camera relative to things: around a point, parallel to the image plane, towards the point under the
//! pointer, onto an axis. Arithmetic only; flying is in `navigation`.

use bevy::math::{Affine3A, Mat3A, Vec2, Vec3, Vec3A};
use bevy_egui::egui::Pos2;

use super::navigation::{Navigation, facing, scale_of};
use super::screen::Screen;
use crate::app::editor::command::axis_view::AxisView;
use crate::math::Ray;

/// The share of the distance to the point under the pointer that remains after a notch of the wheel.
const WAY_LEFT: f32 = 0.85;
/// The least distance that a notch moves, as a share of that of flying, so that the camera gets through walls.
const LEAST: f32 = 0.1;
/// The least width of an orthographic picture as a share of the scene; the inverse is the largest.
const NARROWEST: f32 = 1e-4;

/// The largest distance of a point from the view axis, as a share of its depth, that counts as straight ahead.
const BESIDE: f32 = 0.01;

impl Navigation {
    /// The last centre of orbits, as long as it is straight ahead: then the user still looks at it, even if a nearer
    /// thing covers it.
    pub(crate) fn pivot_ahead(&self, world_from_camera: &Affine3A) -> Option<Vec3> {
        let pivot = self.pivot?;
        let forward = Vec3::from(world_from_camera.matrix3.z_axis).normalize_or(Vec3::Z);
        let offset = pivot - Vec3::from(world_from_camera.translation);
        let distance = offset.dot(forward);
        let beside = offset.distance(distance * forward);
        (distance > 0.0 && beside <= BESIDE * distance).then_some(pivot)
    }

    /// Turns the view by a drag in points, with the camera on an orbit around `center`.
    pub(crate) fn orbit(&self, world_from_camera: Affine3A, center: Vec3, drag: Vec2) -> Affine3A {
        let forward = Vec3::from(world_from_camera.matrix3.z_axis).normalize_or(Vec3::Z);
        let level = facing(forward, self.upright(&world_from_camera));
        let turned = self.looking(&world_from_camera, drag);
        let offset = Vec3A::from(center) - world_from_camera.translation;
        Affine3A {
            matrix3: turned * Mat3A::from_diagonal(scale_of(&world_from_camera)),
            translation: Vec3A::from(center) - turned * (level.transpose() * offset),
        }
    }

    /// Dollies a perspective camera by the wheel: towards `target` on the ray under the pointer, or along the ray by a
    /// step of flying.
    pub(crate) fn dolly(
        &self,
        world_from_camera: Affine3A,
        under_pointer: &Ray,
        target: Option<Vec3>,
        notches: f32,
    ) -> Affine3A {
        let flown = notches * self.units_per_notch();
        let forward = under_pointer.dir.normalize_or_zero();
        let way = match target {
            Some(target) => {
                let distance = target.distance(world_from_camera.translation.into());
                let way = distance * (1.0 - WAY_LEFT.powf(notches));
                if way.abs() < LEAST * flown.abs() {
                    LEAST * flown
                } else {
                    way
                }
            }
            None => flown,
        };
        Affine3A {
            translation: world_from_camera.translation + Vec3A::from(forward * way),
            ..world_from_camera
        }
    }

    /// Zooms an orthographic picture by the wheel: its extent changes, and the point under the pointer stays there.
    pub(crate) fn narrow(&self, world_from_camera: Affine3A, film: Vec2, screen: &Screen, notches: f32) -> Affine3A {
        let factor = WAY_LEFT.powf(notches);
        let width = world_from_camera.matrix3.x_axis.length() * factor;
        if !(NARROWEST..=1.0 / NARROWEST).contains(&(width / self.scene_size)) {
            return world_from_camera;
        }
        let from_middle = screen.camera.unproject(film, 0.0) - screen.camera.unproject(Vec2::splat(0.5), 0.0);
        let narrowed = world_from_camera * Affine3A::from_scale(Vec3::new(factor, factor, 1.0));
        translated(narrowed, from_middle * (1.0 - factor))
    }

    /// The view direction of a view along an axis.
    fn forward(&self, view: AxisView) -> Vec3 {
        let north = north(self.up);
        match view {
            AxisView::Front => north,
            AxisView::Back => -north,
            AxisView::Left => north.cross(self.up),
            AxisView::Right => -north.cross(self.up),
            AxisView::Top => -self.up,
            AxisView::Bottom => self.up,
        }
    }

    /// The view from this side of the world, given by the direction of an axis.
    pub fn view_from(&self, side: Vec3) -> AxisView {
        let towards = |view: &AxisView| -self.forward(*view).dot(side);
        let nearest = AxisView::ALL
            .into_iter()
            .max_by(|a, b| towards(a).total_cmp(&towards(b)));
        nearest.unwrap_or(AxisView::Front)
    }

    /// A level view along an axis of the world, with `center` straight ahead at its present distance.
    pub fn axis_view(&self, world_from_camera: Affine3A, center: Vec3, view: AxisView) -> Affine3A {
        let (north, forward) = (north(self.up), self.forward(view));
        let upright = match view {
            AxisView::Top => north,
            AxisView::Bottom => -north,
            _ => self.up,
        };
        let distance = center.distance(world_from_camera.translation.into());
        Affine3A {
            matrix3: facing(forward, upright) * Mat3A::from_diagonal(scale_of(&world_from_camera)),
            translation: (center - forward * distance).into(),
        }
    }
}

/// Moves the camera so that a point at `from` with this depth along the view axis moves to `to`.
pub(crate) fn pan(world_from_camera: Affine3A, screen: &Screen, from: Pos2, to: Pos2, depth: f32) -> Affine3A {
    let way = screen.unproject(from, depth) - screen.unproject(to, depth);
    translated(world_from_camera, way)
}

fn translated(pose: Affine3A, way: Vec3) -> Affine3A {
    Affine3A {
        translation: pose.translation + Vec3A::from(way),
        ..pose
    }
}

/// The view direction of the front view, given the upward direction: as in modelling programs -z where y is up, else y.
fn north(up: Vec3) -> Vec3 {
    if up.y.abs() > 0.5 { Vec3::NEG_Z } else { Vec3::Y }
}

#[cfg(test)]
mod tests {
    use super::super::screen::tests::{orthographic, perspective};
    use super::*;

    /// The pose of the test screens.
    fn pose() -> Affine3A {
        Affine3A::from_translation(Vec3::new(0.0, 0.0, -8.0))
    }

    fn forward(pose: &Affine3A) -> Vec3 {
        pose.matrix3.z_axis.into()
    }

    #[test]
    fn orbiting_keeps_the_center_where_it_is_seen() {
        let navigation = Navigation::default();
        let center = Vec3::new(1.0, -2.0, 3.0);
        let seen = |pose: &Affine3A| pose.inverse().transform_point3(center);
        let mut camera = pose();
        for drag in [Vec2::new(200.0, 30.0), Vec2::new(-40.0, 900.0), Vec2::new(5.0, -3000.0)] {
            let moved = navigation.orbit(camera, center, drag);
            assert!(seen(&moved).abs_diff_eq(seen(&camera), 1e-3), "{}", seen(&moved));
            assert!(moved.matrix3.x_axis.y.abs() < 1e-4, "tilted");
            assert!(!moved.abs_diff_eq(camera, 0.1));
            camera = moved;
        }
        // The front of objects moves to the right, and the camera to its left.
        let right = navigation.orbit(pose(), Vec3::ZERO, Vec2::new(50.0, 0.0));
        assert!(right.translation.x > 0.5 && forward(&right).x < -0.1);
    }

    #[test]
    fn the_pivot_stays_as_long_as_it_is_straight_ahead() {
        let mut navigation = Navigation::default();
        assert_eq!(navigation.pivot_ahead(&pose()), None);
        let pivot = Vec3::new(0.0, 0.0, -3.0);
        navigation.pivot = Some(pivot);
        let turned = navigation.orbit(pose(), pivot, Vec2::new(123.0, -45.0));
        for seen in [pose(), turned, navigation.axis_view(turned, pivot, AxisView::Top)] {
            assert_eq!(navigation.pivot_ahead(&seen), Some(pivot));
        }
        for way in [Vec3::X, Vec3::Y, 6.0 * Vec3::Z] {
            let gone = translated(pose(), way);
            assert_eq!(navigation.pivot_ahead(&gone), None, "{way}");
        }
    }

    #[test]
    fn panning_takes_along_what_is_under_the_pointer() {
        for screen in [perspective(), orthographic()] {
            let (from, to) = (Pos2::new(100.0, 60.0), Pos2::new(280.0, 250.0));
            let depth = 5.0;
            let taken = screen.unproject(from, depth);
            let moved = pan(pose(), &screen, from, to, depth);
            let way = moved.translation - pose().translation;
            assert!((taken - Vec3::from(way)).abs_diff_eq(screen.unproject(to, depth), 1e-4));
        }
    }

    #[test]
    fn the_wheel_goes_towards_what_is_under_the_pointer_and_through_it() {
        let navigation = Navigation {
            scene_size: 20.0,
            ..Navigation::default()
        };
        let screen = perspective();
        let pointer = Pos2::new(100.0, 60.0);
        let ray = screen.ray(pointer);
        let target = ray.at(4.0);
        let near = navigation.dolly(pose(), &ray, Some(target), 1.0);
        let (way, whole) = (
            near.translation - pose().translation,
            Vec3A::from(target) - pose().translation,
        );
        assert!(way.cross(whole).length() < 1e-4 && (way.length() / whole.length() - 1.0 + WAY_LEFT).abs() < 1e-5);
        let back = navigation.dolly(near, &Ray::new(near.translation.into(), ray.dir), Some(target), -1.0);
        assert!(back.abs_diff_eq(pose(), 1e-4));
        let mut camera = pose();
        for _ in 0..100 {
            camera = navigation.dolly(camera, &ray, Some(target), 1.0);
        }
        assert!(camera.translation.z > target.z, "stuck at the wall");
    }

    #[test]
    fn a_narrowed_picture_keeps_what_is_under_the_pointer() {
        let screen = orthographic();
        let scaled = pose() * Affine3A::from_scale(Vec3::new(8.0, 8.0, 1.0));
        let film = Vec2::new(0.2, 0.3);
        let narrowed = Navigation::default().narrow(scaled, film, &screen, 2.0);
        let factor = WAY_LEFT.powi(2);
        assert!((narrowed.matrix3.x_axis.length() - 8.0 * factor).abs() < 1e-4);
        // The distance from the middle to the pointer is the former one times the factor.
        let out = |film| screen.camera.unproject(film, 0.0) - screen.camera.unproject(Vec2::splat(0.5), 0.0);
        let before = Vec3::from(scaled.translation) + out(film);
        let after = Vec3::from(narrowed.translation) + factor * out(film);
        assert!(before.abs_diff_eq(after, 1e-4));
    }

    #[test]
    fn axis_views_are_those_of_modellers() {
        for (up, front, right) in [(Vec3::Y, Vec3::NEG_Z, Vec3::NEG_X), (Vec3::Z, Vec3::Y, Vec3::NEG_X)] {
            let navigation = Navigation {
                up,
                ..Navigation::default()
            };
            let center = Vec3::new(1.0, 0.0, 0.0);
            let look = |view| navigation.axis_view(pose(), center, view);
            assert_eq!(forward(&look(AxisView::Front)), front);
            assert_eq!(forward(&look(AxisView::Right)), right);
            assert_eq!(forward(&look(AxisView::Top)), -up);
            for (view, opposite) in [
                (AxisView::Front, AxisView::Back),
                (AxisView::Right, AxisView::Left),
                (AxisView::Top, AxisView::Bottom),
            ] {
                assert_eq!(forward(&look(view)), -forward(&look(opposite)));
                let (pose, distance) = (look(view), center.distance(pose().translation.into()));
                assert!((pose.matrix3.determinant() - 1.0).abs() < 1e-5);
                assert!((Vec3::from(pose.translation) + distance * forward(&pose)).abs_diff_eq(center, 1e-4));
            }
            // North is at the top of the picture from above, and the heading stays when the view turns on from there.
            let top = look(AxisView::Top);
            assert!(Vec3::from(top.matrix3.y_axis).abs_diff_eq(front, 1e-5));
            let on = navigation.orbit(top, center, Vec2::new(0.0, -200.0));
            assert!(forward(&on).dot(front) > 0.3, "{}", forward(&on));
        }
    }
}
