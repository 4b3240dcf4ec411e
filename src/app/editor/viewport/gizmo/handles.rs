//! The shapes of the handles in the window, and hit tests of the pointer. All sizes in points, whatever the distance.

use std::f32::consts::TAU;

use bevy::math::Vec3;
use bevy_egui::egui::{Pos2, Rect};

use super::Frame;
use super::constraint::Constraint;
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::command::gizmo_settings::Mode;

/// The length of an axis.
pub const SIZE: f32 = 90.0;
/// The radius of the rings around the axes, and of that around the view axis.
pub(crate) const RING: f32 = 78.0;
const VIEW_RING: f32 = 94.0;
/// The distance from the middle within which all handles can be taken.
pub(crate) const SPAN: f32 = VIEW_RING + REACH;
/// The start of an axis from the origin; below the extents of the plane squares along their axes, and half the widths
/// of the middle and of the tips.
const AXIS_START: f32 = 18.0;
const SQUARE: [f32; 2] = [26.0, 44.0];
/// Half the width of the handle in the middle, in points.
pub const MIDDLE: f32 = 9.0;
pub(crate) const TIP: f32 = 6.0;
/// The distance within which the pointer hits a line.
const REACH: f32 = 7.0;
/// The share of their length below which axes are too short to be shown, and the sine below which squares are too
/// foreshortened.
const SHORTEST: f32 = 0.12;
const RING_SEGMENTS: usize = 64;

/// The form of a handle, in points of the window.
#[derive(Clone, Debug, PartialEq)]
pub enum Form {
    /// The line from its start to the tip.
    Line([Pos2; 2]),
    /// The corners in their order around it.
    Square([Pos2; 4]),
    /// A ring of two parts.
    Ring {
        /// The segments in front of the middle.
        front: Vec<[Pos2; 2]>,
        /// The segments behind the middle.
        back: Vec<[Pos2; 2]>,
    },
    /// A ring around the view axis.
    Circle {
        /// The origin of the gizmo.
        middle: Pos2,
        /// The radius in points.
        radius: f32,
    },
}

/// A part of the gizmo that can be dragged.
#[derive(Clone, Debug, PartialEq)]
pub struct Handle {
    /// The constraint of a drag of this handle.
    pub constraint: Constraint,
    /// The form that the pointer hits.
    pub form: Form,
}

/// The handles in the order in which they are painted; none if the gizmo is behind the camera.
pub(crate) fn handles(frame: &Frame, mode: Mode, screen: &Screen) -> Vec<Handle> {
    let depth = screen.depth(frame.origin);
    let unit = screen.units_per_point(depth);
    let Some(middle) = screen.project(frame.origin).filter(|_| unit > 0.0) else {
        return Vec::new();
    };
    let layout = Layout {
        frame,
        screen,
        unit,
        middle,
    };
    let handle = |constraint, form: Option<Form>| form.map(|form| Handle { constraint, form });
    let circle = |radius| Some(Form::Circle { middle, radius });
    let found: Vec<Option<Handle>> = match mode {
        Mode::Move => (0..3)
            .map(|k| handle(Constraint::Plane(k), layout.square(k)))
            .chain((0..3).map(|k| handle(Constraint::Axis(k), layout.line(k))))
            .chain([handle(Constraint::Free, circle(MIDDLE))])
            .collect(),
        Mode::Rotate => [handle(Constraint::Free, circle(VIEW_RING))]
            .into_iter()
            .chain((0..3).map(|k| handle(Constraint::Axis(k), layout.ring(k))))
            .collect(),
        Mode::Scale => (0..3)
            .map(|k| handle(Constraint::Axis(k), layout.line(k)))
            .chain([handle(Constraint::Free, circle(MIDDLE))])
            .collect(),
    };
    found.into_iter().flatten().collect()
}

struct Layout<'a> {
    frame: &'a Frame,
    screen: &'a Screen,
    /// World units per point.
    unit: f32,
    middle: Pos2,
}

impl Layout<'_> {
    /// The point of the window at this offset along the axes, in points.
    fn at(&self, out: Vec3) -> Option<Pos2> {
        let [x, y, z] = self.frame.axes;
        let place = self.frame.origin + (x * out.x + y * out.y + z * out.z) * self.unit;
        self.screen.project(place)
    }

    fn line(&self, k: usize) -> Option<Form> {
        let start = self.at(Vec3::AXES[k] * AXIS_START)?;
        let tip = self.at(Vec3::AXES[k] * SIZE)?;
        (self.middle.distance(tip) > SHORTEST * SIZE).then_some(Form::Line([start, tip]))
    }

    fn square(&self, normal: usize) -> Option<Form> {
        let facing = self.frame.axes[normal].dot(self.screen.direction_to(self.frame.origin));
        if facing.abs() < SHORTEST {
            return None;
        }
        let (a, b) = (Vec3::AXES[(normal + 1) % 3], Vec3::AXES[(normal + 2) % 3]);
        let [near, far] = SQUARE;
        let corners = [(near, near), (far, near), (far, far), (near, far)];
        let [p, q, r, s] = corners.map(|(along_a, along_b)| self.at(a * along_a + b * along_b));
        Some(Form::Square([p?, q?, r?, s?]))
    }

    fn ring(&self, k: usize) -> Option<Form> {
        let (a, b) = (Vec3::AXES[(k + 1) % 3], Vec3::AXES[(k + 2) % 3]);
        let view = self.screen.direction_to(self.frame.origin);
        let axes = self.frame.axes;
        let (mut front, mut back) = (Vec::new(), Vec::new());
        for segment in 0..RING_SEGMENTS {
            let out = |corner: f32| {
                let angle = TAU * corner / RING_SEGMENTS as f32;
                a * angle.cos() + b * angle.sin()
            };
            let toward = out(segment as f32 + 0.5);
            let away = (axes[0] * toward.x + axes[1] * toward.y + axes[2] * toward.z).dot(view);
            let ends = [
                self.at(out(segment as f32) * RING)?,
                self.at(out(segment as f32 + 1.0) * RING)?,
            ];
            // A little beyond half, so that a ring seen from its axis is whole.
            if away < 0.05 { &mut front } else { &mut back }.push(ends);
        }
        Some(Form::Ring { front, back })
    }
}

/// The handle that a press here takes: the middle comes before lines, and lines come before squares.
pub(crate) fn handle_at(handles: &[Handle], pointer: Pos2) -> Option<Constraint> {
    let distance = |handle: &Handle| match &handle.form {
        Form::Circle { middle, radius } if *radius <= MIDDLE => {
            let inside = pointer.distance(*middle) <= radius + 2.0;
            inside.then_some(-1.0)
        }
        Form::Circle { middle, radius } => reached((pointer.distance(*middle) - radius).abs()),
        Form::Line(ends) => {
            reached(distance_to_segment(pointer, ends) - if is_at_tip(pointer, ends) { TIP } else { 0.0 })
        }
        Form::Ring { front, .. } => {
            let distances = front.iter().map(|ends| distance_to_segment(pointer, ends));
            reached(distances.fold(f32::INFINITY, f32::min))
        }
        Form::Square(corners) => contains(corners, pointer).then_some(REACH),
    };
    let reached = handles.iter().filter_map(|handle| Some((distance(handle)?, handle)));
    reached
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, handle)| handle.constraint)
}

/// The distance if it is within reach.
fn reached(distance: f32) -> Option<f32> {
    (distance <= REACH).then_some(distance.max(0.0))
}

fn is_at_tip(pointer: Pos2, [_, tip]: &[Pos2; 2]) -> bool {
    Rect::from_center_size(*tip, bevy_egui::egui::Vec2::splat(4.0 * TIP)).contains(pointer)
}

pub(crate) fn distance_to_segment(p: Pos2, [a, b]: &[Pos2; 2]) -> f32 {
    let along = *b - *a;
    let share = ((p - *a).dot(along) / along.length_sq().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
    p.distance(*a + along * share)
}

/// Whether a convex polygon, in either orientation, contains the point.
fn contains(corners: &[Pos2; 4], p: Pos2) -> bool {
    let side = |k: usize| {
        let (edge, out) = (corners[(k + 1) % 4] - corners[k], p - corners[k]);
        edge.x * out.y - edge.y * out.x
    };
    (0..4).all(|k| side(k) >= 0.0) || (0..4).all(|k| side(k) <= 0.0)
}

#[cfg(test)]
mod tests {
    use bevy_egui::egui::vec2;

    use super::*;
    use crate::app::editor::camera::screen::tests::{orthographic, perspective};

    fn frame(axes: [Vec3; 3]) -> Frame {
        Frame {
            origin: Vec3::new(0.5, 0.2, 0.0),
            axes,
        }
    }

    const OBLIQUE: [Vec3; 3] = [
        Vec3::new(2.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0),
        Vec3::new(-2.0 / 3.0, 2.0 / 3.0, 1.0 / 3.0),
        Vec3::new(-1.0 / 3.0, -2.0 / 3.0, 2.0 / 3.0),
    ];

    #[test]
    fn every_handle_can_be_taken_where_it_is_seen() {
        for screen in [perspective(), orthographic()] {
            for (mode, count) in [(Mode::Move, 7), (Mode::Rotate, 4), (Mode::Scale, 4)] {
                let handles = handles(&frame(OBLIQUE), mode, &screen);
                assert_eq!(handles.len(), count);
                for handle in &handles {
                    let at = match &handle.form {
                        Form::Line([_, tip]) => *tip,
                        Form::Square(corners) => corners[0] + (corners[2] - corners[0]) * 0.5,
                        Form::Ring { front, .. } => front[front.len() / 3][0],
                        Form::Circle { middle, radius } if *radius > MIDDLE => *middle - vec2(0.0, *radius),
                        Form::Circle { middle, .. } => *middle,
                    };
                    assert_eq!(handle_at(&handles, at), Some(handle.constraint), "{mode:?}");
                }
                assert_eq!(handle_at(&handles, Pos2::new(60.0, 30.0)), None);
            }
        }
    }

    #[test]
    fn what_points_at_the_viewer_is_left_out() {
        let handles = handles(&frame(Vec3::AXES), Mode::Move, &orthographic());
        let has = |constraint| handles.iter().any(|handle| handle.constraint == constraint);
        assert!(has(Constraint::Axis(0)) && has(Constraint::Axis(1)) && !has(Constraint::Axis(2)));
        assert!(has(Constraint::Plane(2)) && !has(Constraint::Plane(0)) && !has(Constraint::Plane(1)));
    }

    #[test]
    fn the_gizmo_is_as_large_at_any_distance() {
        let length = |z: f32| {
            let far = Frame {
                origin: Vec3::new(0.0, 0.0, z),
                axes: Vec3::AXES,
            };
            let handles = handles(&far, Mode::Move, &perspective());
            handles.iter().find_map(|handle| match &handle.form {
                Form::Line([_, tip]) if handle.constraint == Constraint::Axis(0) => {
                    Some(tip.distance(perspective().picture.center()))
                }
                _ => None,
            })
        };
        for z in [-7.0, 0.0, 500.0] {
            assert!(
                length(z).is_some_and(|length| (length - SIZE).abs() < 0.1),
                "{z}: {:?}",
                length(z)
            );
        }
        assert_eq!(length(-9.0), None, "behind the camera");
    }
}
