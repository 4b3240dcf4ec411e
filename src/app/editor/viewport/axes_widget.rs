//! The axes of the world in the upper right corner of the viewport: they show how the view is turned. A click on an
//! axis looks along it, and a drag orbits.

use bevy::math::{Affine3A, Vec3};
use bevy_egui::egui::{self, Align2, Color32, CursorIcon, FontId, Id, Pos2, Rect, Sense, Stroke, Ui};

use crate::app::editor::camera::navigation::Navigation;
use crate::app::editor::command::axis_view::AxisView;
use crate::app::editor::command::key_bindings::KeyBindings;
use crate::app::editor::command::{Command, ViewCommand};
use crate::app::editor::input::actions::hint;
use crate::app::editor::picture::axis_colors::AXIS_COLORS;

/// The id of the widget.
pub const AXES: &str = "axes of the view";
/// The length of an axis in points.
const LENGTH: f32 = 30.0;
/// The radii of the balls at the ends of axes, in points.
const POSITIVE: f32 = 8.0;
const NEGATIVE: f32 = 6.5;
const RADIUS: f32 = LENGTH + POSITIVE + 3.0;
/// The distance to the edges of the panel.
const MARGIN: f32 = 8.0;
/// The width of a panel below which the toolbar reaches into the corner of the widget.
const WIDE: f32 = 680.0;
const BELOW_TOOLBAR: f32 = 36.0;
/// The cosine of the largest angle between an axis and the view direction that counts as a view along the axis.
const ALONG: f32 = 0.9999;

/// The state that the widget keeps between frames.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxesState {
    /// The centre of the orbit during a drag.
    center: Option<Vec3>,
}

/// The square that the widget takes.
pub fn place(panel: Rect) -> Rect {
    let down = if panel.width() < WIDE { BELOW_TOOLBAR } else { 0.0 };
    let corner = panel.right_top() + egui::vec2(-MARGIN - 2.0 * RADIUS, MARGIN + down);
    Rect::from_min_size(corner, egui::Vec2::splat(2.0 * RADIUS))
}

/// An end of an axis on the screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct End {
    /// The unit vector from the origin towards this end, in world space.
    pub direction: Vec3,
    /// The middle of its ball.
    pub at: Pos2,
    /// The cosine of the angle between the axis and the view direction: 1 if it points away from the viewer, -1 if at
    /// the viewer.
    away: f32,
}

impl End {
    fn axis(&self) -> usize {
        self.direction.abs().max_position()
    }

    fn is_positive(&self) -> bool {
        self.direction.max_element() > 0.5
    }

    fn radius(&self) -> f32 {
        if self.is_positive() { POSITIVE } else { NEGATIVE }
    }
}

/// The six ends, the farthest first.
pub fn ends(panel: Rect, world_from_camera: &Affine3A) -> [End; 6] {
    let middle = place(panel).center();
    let axes = world_from_camera.matrix3;
    let [left, up, ahead] = [axes.x_axis, axes.y_axis, axes.z_axis].map(|axis| Vec3::from(axis).normalize_or_zero());
    let mut ends = [Vec3::X, Vec3::Y, Vec3::Z, Vec3::NEG_X, Vec3::NEG_Y, Vec3::NEG_Z].map(|direction| End {
        direction,
        at: middle + LENGTH * egui::vec2(-direction.dot(left), -direction.dot(up)),
        away: direction.dot(ahead),
    });
    ends.sort_by(|a, b| b.away.total_cmp(&a.away));
    ends
}

/// Shows the widget. `center` finds the point to orbit about.
pub(super) fn axes_widget(
    ui: &Ui,
    panel: Rect,
    pose: Affine3A,
    navigation: &Navigation,
    bound: &KeyBindings,
    center: impl FnOnce() -> Vec3,
    state: &mut AxesState,
    commands: &mut Vec<Command>,
) {
    let place = place(panel);
    let response = ui.interact(place, Id::new(AXES), Sense::click_and_drag());
    let pointer = response.hover_pos();
    let ends = ends(panel, &pose);
    let nearest = |pointer: Pos2| {
        ends.iter()
            .rev()
            .find(|end| end.at.distance(pointer) <= end.radius() + 2.0)
    };
    let hovered = pointer.and_then(nearest).copied();
    if response.drag_started() {
        let center = center();
        commands.push(ViewCommand::TurnAbout(center).into());
        state.center = Some(center);
    }
    if response.dragged()
        && let Some(center) = state.center
    {
        let by = response.drag_delta();
        if by != egui::Vec2::ZERO {
            let turned = navigation.orbit(pose, center, bevy::math::Vec2::new(by.x, by.y));
            commands.push(ViewCommand::MoveView(turned).into());
        }
    } else if !response.dragged() {
        state.center = None;
    }
    if response.clicked()
        && let Some(end) = hovered
    {
        commands.push(ViewCommand::LookAlong(view_of(navigation, &pose, end.direction)).into());
    }
    paint(ui, place, &ends, hovered, response.hovered() || response.dragged());
    let cursor = match hovered {
        _ if response.dragged() => CursorIcon::Grabbing,
        Some(_) => CursorIcon::PointingHand,
        None => CursorIcon::Grab,
    };
    let help = match hovered {
        Some(end) => help(view_of(navigation, &pose, end.direction), bound),
        None => "Drag to orbit; click an axis to look along it".to_owned(),
    };
    let response = response.on_hover_cursor(cursor);
    if !response.dragged() {
        response.on_hover_text(help);
    }
}

/// The view from an end of an axis, or from the other end if the view is from this one.
fn view_of(navigation: &Navigation, pose: &Affine3A, from: Vec3) -> AxisView {
    let ahead = Vec3::from(pose.matrix3.z_axis).normalize_or_zero();
    let is_there = ahead.dot(from) < -ALONG;
    navigation.view_from(if is_there { -from } else { from })
}

fn help(view: AxisView, bound: &KeyBindings) -> String {
    let (text, action) = match view {
        AxisView::Front => ("Look at the front", "view-front"),
        AxisView::Back => ("Look at the back", "view-back"),
        AxisView::Right => ("Look from the right", "view-right"),
        AxisView::Left => ("Look from the left", "view-left"),
        AxisView::Top => ("Look from above", "view-top"),
        AxisView::Bottom => ("Look from below", "view-bottom"),
    };
    hint(text, action, bound)
}

fn paint(ui: &Ui, place: Rect, ends: &[End; 6], hovered: Option<End>, is_used: bool) {
    let painter = ui.painter();
    let backing = if is_used { 110 } else { 50 };
    painter.circle_filled(place.center(), RADIUS, Color32::from_black_alpha(backing));
    for end in ends {
        // Axes that point away are dimmer.
        let shade = 0.78 - 0.22 * end.away;
        let color = scaled(AXIS_COLORS[end.axis()], shade);
        let is_hovered = hovered.is_some_and(|hovered| hovered.direction == end.direction);
        let edge = if is_hovered { Color32::WHITE } else { color };
        if end.is_positive() {
            let way = end.at - place.center();
            let before_ball = end.at - way.normalized() * POSITIVE.min(way.length());
            painter.line_segment([place.center(), before_ball], Stroke::new(1.5, color));
            painter.circle(end.at, POSITIVE, color, Stroke::new(1.0, edge));
            let letter = ["X", "Y", "Z"][end.axis()];
            let ink = if is_hovered {
                Color32::WHITE
            } else {
                Color32::from_gray(16)
            };
            painter.text(end.at, Align2::CENTER_CENTER, letter, FontId::proportional(11.0), ink);
        } else {
            painter.circle(end.at, NEGATIVE, scaled(color, 0.35), Stroke::new(1.0, edge));
            if is_hovered {
                let letter = ["-X", "-Y", "-Z"][end.axis()];
                let font = FontId::proportional(11.0);
                painter.text(end.at, Align2::CENTER_CENTER, letter, font, Color32::WHITE);
            }
        }
    }
}

fn scaled(color: Color32, by: f32) -> Color32 {
    let [r, g, b, _] = color.to_array().map(|c| (f32::from(c) * by).clamp(0.0, 255.0) as u8);
    Color32::from_rgb(r, g, b)
}
