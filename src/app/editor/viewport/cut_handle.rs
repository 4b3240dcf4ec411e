//! The cut plane over the picture: its border in the scene, an arrow by which it is moved, and the choice of its axis.

use bevy::math::{Vec2, Vec3};
use bevy_egui::egui::emath::format_with_decimals_in_range;
use bevy_egui::egui::{
    self, Align, Button, Color32, DragValue, Id, Layout, Margin, Painter, Pos2, Rect, Sense, Shape, Stroke, Ui,
    UiBuilder,
};

use super::marks::bar_frame;
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::command::seeing::{AXES, CutOpen, Seeing};
use crate::app::editor::command::{Command, ViewCommand};
use crate::app::editor::input::actions::{ActionContext, hint};
use crate::app::editor::input::number_field::{self, Meaning};
use crate::math::Aabb;

/// The height of the row of buttons in points.
pub(super) const BAR_HEIGHT: f32 = 30.0;
const COLOR: Color32 = Color32::from_rgb(110, 190, 255);
/// The length of the arrow and the size of its tip in points.
const ARROW: f32 = 44.0;
const TIP: f32 = 9.0;
/// The shortest foreshortening of the axis on screen. Below this share the axis points at the viewer, and the plane
/// follows vertical moves of the pointer.
const SHORTEST: f32 = 0.15;

/// Draws the plane, and moves it with its arrow. `bounds` is the scene's.
pub(crate) fn cut_handle(ui: &Ui, screen: &Screen, bounds: &Aabb, seeing: &Seeing, commands: &mut Vec<Command>) {
    let Some(cut) = seeing.cut.filter(|_| !bounds.is_empty()) else {
        return;
    };
    let painter = ui.painter_at(screen.picture);
    border(&painter, screen, bounds, &cut);
    let Some((middle, foot)) = foot(screen, bounds, &cut) else {
        return;
    };
    let axis = Vec3::AXES[cut.axis];
    let units = screen.units_per_point(screen.depth(middle));
    let along = along(screen, middle, axis, units);
    let side = if cut.above { 1.0 } else { -1.0 };
    let tip = foot + ARROW * side * egui::vec2(along.x, along.y);
    let grip = Rect::from_center_size(tip, egui::Vec2::splat(2.5 * TIP));
    let response = ui.interact(grip, Id::new("cut plane"), Sense::drag());
    let color = match response.hovered() || response.dragged() {
        true => Color32::WHITE,
        false => COLOR,
    };
    arrow(&painter, foot, tip, color);
    if response.dragged() {
        let by = response.drag_delta();
        let at = cut.at + units * (by.x * along.x + by.y * along.y);
        if at != cut.at && at.is_finite() {
            commands.push(moved(seeing, CutOpen { at, ..cut }));
        }
    }
    response.on_hover_text("Drag to move the cut plane");
}

fn moved(seeing: &Seeing, cut: CutOpen) -> Command {
    Command::from(ViewCommand::SetSeeing(Seeing {
        cut: Some(cut),
        ..*seeing
    }))
}

/// The direction on the screen along which the plane follows the pointer, of unit length.
fn along(screen: &Screen, middle: Vec3, axis: Vec3, units: f32) -> Vec2 {
    let ends = [0.0, 1.0].map(|share| screen.project(middle + axis * (share * ARROW * units)));
    let across = match ends {
        [Some(from), Some(to)] => Vec2::new(to.x - from.x, to.y - from.y),
        _ => Vec2::ZERO,
    };
    match across.length() > SHORTEST * ARROW {
        true => across.normalize(),
        false => Vec2::new(0.0, -1.0),
    }
}

/// The intersections of the plane with the edges of the scene's box.
fn corners(bounds: &Aabb, cut: &CutOpen) -> [Vec3; 4] {
    let (u, v) = ((cut.axis + 1) % 3, (cut.axis + 2) % 3);
    [
        (bounds.min[u], bounds.min[v]),
        (bounds.max[u], bounds.min[v]),
        (bounds.max[u], bounds.max[v]),
        (bounds.min[u], bounds.max[v]),
    ]
    .map(|(at_u, at_v)| {
        let mut corner = Vec3::ZERO;
        (corner[cut.axis], corner[u], corner[v]) = (cut.at, at_u, at_v);
        corner
    })
}

/// The foot of the arrow, in the world and in the window: in the middle of the side of the border that is farthest to
/// the right in the picture, away from the selection's handles. If no side is in the picture, in the middle of the
/// border.
fn foot(screen: &Screen, bounds: &Aabb, cut: &CutOpen) -> Option<(Vec3, Pos2)> {
    let corners = corners(bounds, cut);
    let seen = |at: Vec3| screen.project(at).map(|point| (at, point));
    let inner = screen.picture.shrink(ARROW + TIP);
    let sides = (0..4).filter_map(|side| seen(corners[side].midpoint(corners[(side + 1) % 4])));
    sides
        .filter(|(_, point)| inner.contains(*point))
        .max_by(|(_, a), (_, b)| a.x.total_cmp(&b.x))
        .or_else(|| seen(corners[0].midpoint(corners[2])))
}

/// Draws the border of the plane.
fn border(painter: &Painter, screen: &Screen, bounds: &Aabb, cut: &CutOpen) {
    let corners = corners(bounds, cut);
    let lines = (0..4).filter_map(|side| screen.segment(corners[side], corners[(side + 1) % 4]));
    painter.extend(lines.map(|ends| Shape::line_segment(ends, Stroke::new(1.0, COLOR.gamma_multiply(0.7)))));
}

fn arrow(painter: &Painter, foot: Pos2, tip: Pos2, color: Color32) {
    let along = (tip - foot).normalized();
    let aside = 0.55 * TIP * along.rot90();
    let neck = tip - TIP * along;
    // A dark edge keeps it legible over bright pictures.
    for (width, color) in [(4.0, Color32::from_black_alpha(140)), (2.0, color)] {
        painter.line_segment([foot, neck], Stroke::new(width, color));
    }
    let head = vec![tip + 0.4 * TIP * along, neck + aside, neck - aside];
    painter.add(Shape::convex_polygon(
        head,
        color,
        Stroke::new(1.0, Color32::from_black_alpha(140)),
    ));
    painter.circle_filled(foot, 3.0, color);
}

/// The row of buttons at the foot of the picture while there is a cut plane.
pub(crate) fn cut_bar(ui: &mut Ui, picture: Rect, keys: &ActionContext, scene_size: f32, commands: &mut Vec<Command>) {
    let seeing = &keys.seeing;
    let Some(cut) = seeing.cut else { return };
    let size = egui::vec2(290.0_f32.min(picture.width() - 16.0), BAR_HEIGHT);
    let place = Rect::from_min_size(picture.left_bottom() + egui::vec2(8.0, -8.0 - size.y), size);
    let layout = Layout::left_to_right(Align::Center);
    let mut bar = ui.new_child(UiBuilder::new().id_salt("cut bar").max_rect(place).layout(layout));
    let mut edited = Some(cut);
    bar_frame(&bar, Margin::symmetric(6, 3)).show(&mut bar, |ui| {
        ui.label("Cut");
        let mut next = cut;
        for (axis, name) in AXES.into_iter().enumerate() {
            let button = Button::selectable(cut.axis == axis, name);
            let help = format!("Cut across the axis {name}");
            if ui.add(button).on_hover_text(help).clicked() {
                next.axis = axis;
            }
        }
        let drag = DragValue::new(&mut next.at).speed(0.002 * f64::from(scene_size));
        let range = f32::MIN..=f32::MAX;
        let axis = next.axis;
        let field = number_field::number(ui, drag, axis, range, Meaning::Number, format_with_decimals_in_range);
        ui.add(field).on_hover_text("Where the plane meets the axis");
        if ui.button("Flip").on_hover_text("Leave the other side out").clicked() {
            next.above = !next.above;
        }
        edited = Some(next);
        if ui
            .button("Close")
            .on_hover_text(hint("See everything again", "cut-open", keys.bound))
            .clicked()
        {
            edited = None;
        }
    });
    if edited != Some(cut) {
        commands.push(ViewCommand::SetSeeing(Seeing { cut: edited, ..*seeing }).into());
    }
}

#[cfg(test)]
mod tests {
    use bevy_egui::egui::{Modifiers, PointerButton};
    use egui_kittest::Harness;

    use super::*;
    use crate::app::editor::camera::screen::tests::{orthographic, perspective};

    struct Window {
        seeing: Seeing,
        screen: Screen,
    }

    const BOUNDS: Aabb = Aabb {
        min: Vec3::splat(-2.0),
        max: Vec3::splat(2.0),
    };

    fn window(screen: Screen, axis: usize) -> Harness<'static, Window> {
        let cut = CutOpen {
            axis,
            at: 0.0,
            above: true,
        };
        let window = Window {
            seeing: Seeing {
                cut: Some(cut),
                ..Seeing::default()
            },
            screen,
        };
        let mut harness = Harness::builder().with_size(egui::vec2(500.0, 400.0)).build_ui_state(
            |ui, window: &mut Window| {
                let mut commands = Vec::new();
                cut_handle(ui, &window.screen, &BOUNDS, &window.seeing, &mut commands);
                for command in commands {
                    if let Command::View(ViewCommand::SetSeeing(seeing)) = command {
                        window.seeing = seeing;
                    }
                }
            },
            window,
        );
        harness.run_steps(2);
        harness
    }

    fn dragged(screen: Screen, axis: usize) -> (f32, f32) {
        let mut harness = window(screen, axis);
        let cut = harness.state().seeing.cut.expect("a plane");
        let (middle, foot) = foot(&screen, &BOUNDS, &cut).expect("it is seen");
        let units = screen.units_per_point(screen.depth(middle));
        let along = along(&screen, middle, Vec3::AXES[axis], units);
        let along = egui::vec2(along.x, along.y);
        let tip = foot + ARROW * along;
        let press = |pressed, pos| egui::Event::PointerButton {
            pos,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        harness.event(egui::Event::PointerMoved(tip));
        harness.run_steps(2);
        harness.event(press(true, tip));
        harness.run_steps(1);
        for step in 1..=5 {
            harness.event(egui::Event::PointerMoved(tip + 6.0 * step as f32 * along));
            harness.run_steps(1);
        }
        harness.event(press(false, tip + 30.0 * along));
        harness.run_steps(2);
        (harness.state().seeing.cut.expect("a plane").at, 30.0 * units)
    }

    #[test]
    fn the_plane_follows_the_pointer() {
        // Drags across the view, and along it.
        for axis in [0, 1, 2] {
            let (at, expected) = dragged(orthographic(), axis);
            assert!(
                (at - expected).abs() < 0.15 * expected,
                "axis {axis}: {at}, not {expected}"
            );
        }
        let (at, expected) = dragged(perspective(), 1);
        assert!((at - expected).abs() < 0.3 * expected, "{at}, not {expected}");
    }
}
