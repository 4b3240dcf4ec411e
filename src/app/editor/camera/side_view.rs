//! The cameras of the side views: level and orthographic, along an axis of the world, outside of everything.

use bevy::math::{Affine3A, Vec2, Vec3};

use super::navigation::Navigation;
use crate::app::editor::command::axis_view::AxisView;
use crate::app::editor::command::side_views::SidePlace;
use crate::math::Aabb;
use crate::render::camera::Camera;

/// The height of a view relative to that of the scene in it, so that there is a border around the scene.
const WITH_BORDER: f32 = 1.15;
/// The least height of a framed view as a share of the farthest coordinate, which single precision can resolve.
const LEAST_SHARE: f32 = 1e-4;

impl SidePlace {
    /// The place that shows all of `bounds` with a border, in a view of this `aspect` (width over height); the
    /// surroundings of the origin, as large as the scene, if the bounds are empty.
    pub fn framing(bounds: &Aabb, view: AxisView, aspect: f32, navigation: &Navigation) -> Self {
        if bounds.is_empty() {
            return Self {
                center: [0.0; 3],
                height: WITH_BORDER * navigation.scene_size,
            };
        }
        let axes = navigation.axis_view(Affine3A::IDENTITY, Vec3::ZERO, view).matrix3;
        let extent = |axis| bounds.extent().dot(Vec3::from(axis).abs());
        let height = extent(axes.y_axis).max(extent(axes.x_axis) / aspect.max(f32::MIN_POSITIVE));
        let least = LEAST_SHARE * bounds.min.abs().max(bounds.max.abs()).max_element();
        Self {
            center: bounds.center().into(),
            height: WITH_BORDER * height.max(least),
        }
    }

    /// The pose of the camera, world from camera, with half the width of the picture as its scale. The camera stands
    /// before all of `bounds`, at a distance that is a power of two, so that it stays while things move.
    pub fn pose(&self, view: AxisView, aspect: f32, navigation: &Navigation, bounds: &Aabb) -> Affine3A {
        let center = Vec3::from(self.center);
        let reach = match bounds.is_empty() {
            true => self.height,
            false => center.distance(bounds.center()) + 0.5 * bounds.extent().length(),
        };
        let distance = (2.0 * reach.max(self.height)).log2().ceil().exp2();
        let scale = Vec3::new(0.5 * self.height * aspect, 0.5 * self.height * aspect, 1.0);
        let from = Affine3A::from_translation(center + Vec3::Z * distance) * Affine3A::from_scale(scale);
        navigation.axis_view(from, center, view)
    }

    /// The camera of a [`Self::pose`].
    pub fn camera(pose: &Affine3A, center: Vec3, aspect: f32) -> Camera {
        let [left, up, forward] = [pose.matrix3.x_axis, pose.matrix3.y_axis, pose.matrix3.z_axis];
        let half_width = left.length();
        let rigid = Affine3A::from_cols(
            left.normalize_or_zero(),
            up.normalize_or_zero(),
            forward,
            pose.translation,
        );
        let distance = center.distance(pose.translation.into());
        Camera::orthographic(rigid, Vec2::new(half_width, half_width / aspect), 0.0, 4.0 * distance)
    }

    /// The place after the pose of its camera was panned or narrowed from one to another.
    pub fn moved(&self, from: &Affine3A, to: &Affine3A) -> Self {
        let offset = Vec3::from(to.translation - from.translation);
        Self {
            center: (Vec3::from(self.center) + offset).into(),
            height: self.height * (to.matrix3.x_axis.length() / from.matrix3.x_axis.length()),
        }
    }
}

#[cfg(test)]
mod tests {
    use bevy_egui::egui::{Pos2, Rect, vec2};

    use super::super::orbit::pan;
    use super::super::screen::Screen;
    use super::*;
    use crate::app::editor::command::side_views::SIDES;

    const ASPECT: f32 = 2.0;

    fn bounds() -> Aabb {
        Aabb {
            min: Vec3::new(-1.0, 0.0, 3.0),
            max: Vec3::new(5.0, 2.0, 4.0),
        }
    }

    fn screen(place: &SidePlace, view: AxisView) -> (Affine3A, Screen) {
        let pose = place.pose(view, ASPECT, &Navigation::default(), &bounds());
        let screen = Screen {
            camera: SidePlace::camera(&pose, place.center.into(), ASPECT),
            picture: Rect::from_min_size(Pos2::new(10.0, 20.0), vec2(400.0, 200.0)),
        };
        (pose, screen)
    }

    #[test]
    fn everything_is_framed_and_before_the_camera() {
        for (view, name) in SIDES {
            let place = SidePlace::framing(&bounds(), view, ASPECT, &Navigation::default());
            let (_, screen) = screen(&place, view);
            for corner in [bounds().min, bounds().max] {
                let at = screen.project(corner).expect(name);
                assert!(screen.picture.contains(at), "{name}: {at}");
            }
            let middle = screen.project(bounds().center()).expect(name);
            assert!(middle.distance(screen.picture.center()) < 1e-2, "{name}: {middle}");
        }
    }

    #[test]
    fn the_views_look_along_their_axes_with_the_right_way_up() {
        let place = SidePlace::framing(&bounds(), AxisView::Top, ASPECT, &Navigation::default());
        let directions = SIDES.map(|(view, _)| screen(&place, view).1.forward());
        for (found, expected) in directions.into_iter().zip([Vec3::NEG_Y, Vec3::NEG_Z, Vec3::NEG_X]) {
            assert!(found.abs_diff_eq(expected, 1e-5), "{found}");
        }
        // In the plan, +x is to the right and -z is up.
        let (_, plan) = screen(&place, AxisView::Top);
        let at = |world| plan.project(world).expect("seen");
        let center = Vec3::from(place.center);
        assert!(at(center + Vec3::X).x > at(center).x && at(center - Vec3::Z).y < at(center).y);
    }

    #[test]
    fn a_place_follows_its_camera() {
        for (view, name) in SIDES {
            let place = SidePlace::framing(&bounds(), view, ASPECT, &Navigation::default());
            let (pose, seen) = screen(&place, view);
            let (from, to) = (Pos2::new(100.0, 60.0), Pos2::new(180.0, 150.0));
            let taken = seen.unproject(from, 1.0);
            let panned = place.moved(&pose, &pan(pose, &seen, from, to, 1.0));
            let (_, after) = screen(&panned, view);
            assert!(after.project(taken).expect(name).distance(to) < 0.1, "{name}");
            assert_eq!(panned.height, place.height);
            let narrowed = Navigation::default().narrow(pose, seen.film(from), &seen, 2.0);
            let (_, after) = screen(&place.moved(&pose, &narrowed), view);
            assert!(after.project(taken).expect(name).distance(from) < 0.1, "{name}");
        }
    }

    #[test]
    fn an_empty_scene_has_a_view_too() {
        let place = SidePlace::framing(&Aabb::EMPTY, AxisView::Front, ASPECT, &Navigation::default());
        assert!(place.is_possible());
        let pose = place.pose(AxisView::Front, ASPECT, &Navigation::default(), &Aabb::EMPTY);
        assert!(pose.is_finite() && pose.matrix3.determinant() != 0.0);
    }
}
