//! The border between the parts of a divided picture: a line, and a handle by which it is dragged.

use bevy_egui::egui::{
    self, Color32, CursorIcon, Id, Painter, Pos2, Rect, Sense, Shape, Stroke, Ui, WidgetInfo, WidgetType, vec2,
};

use super::marks::BACKING;
use crate::app::editor::command::compare_view::CompareView;
use crate::app::editor::command::{Command, DisplayCommand};

/// The radius of the handle in points.
const RADIUS: f32 = 11.0;
/// The distance from the line within which the pointer hits it, in points.
const REACH: f32 = 4.0;
/// The height of the handle as a share of the picture's, from the top. The selection is often in the middle.
const HEIGHT: f32 = 0.75;

/// The place of the handle's middle.
fn middle(picture: Rect, border: f32) -> Pos2 {
    picture.min + picture.size() * vec2(border.clamp(0.0, 1.0), HEIGHT)
}

/// Draws the border, and moves it where the user drags it.
pub(super) fn handle(ui: &Ui, picture: Rect, view: CompareView, commands: &mut Vec<Command>) {
    let Some(border) = view.border() else {
        return;
    };
    let middle = middle(picture, border);
    let line = Rect::from_x_y_ranges(middle.x - REACH..=middle.x + REACH, picture.y_range());
    let round = Rect::from_center_size(middle, egui::Vec2::splat(2.0 * RADIUS));
    // They are two widgets, since a rectangle around both would take the presses beside the line.
    let parts = [(line, "wipe line"), (round, "wipe handle")];
    let [line, round] = parts.map(|(place, name)| drag(ui, picture, place, name, view, commands));
    paint(&ui.painter_at(picture), picture, middle, line || round);
}

/// Moves the border where this part of it is dragged. Returns whether the pointer hovers or drags it.
fn drag(ui: &Ui, picture: Rect, place: Rect, name: &str, view: CompareView, commands: &mut Vec<Command>) -> bool {
    let id = Id::new(name);
    let response = ui.interact(place.intersect(picture), id, Sense::drag());
    response.widget_info(|| WidgetInfo::labeled(WidgetType::Other, true, name));
    if response.drag_started() {
        // The border keeps its distance to the pointer.
        let press = ui.input(|input| input.pointer.press_origin());
        let off = press.map_or(0.0, |press| press.x - place.center().x);
        ui.data_mut(|data| data.insert_temp(id, off));
    }
    if let Some(pointer) = response.interact_pointer_pos().filter(|_| response.dragged()) {
        let off: f32 = ui.data(|data| data.get_temp(id)).unwrap_or(0.0);
        let at = ((pointer.x - off - picture.left()) / picture.width()).clamp(0.0, 1.0);
        let moved = view.with_border(at);
        if at.is_finite() && moved != view {
            commands.push(DisplayCommand::SetCompareView(moved).into());
        }
    }
    let is_used = response.hovered() || response.dragged();
    let response = response.on_hover_and_drag_cursor(CursorIcon::ResizeHorizontal);
    if !response.dragged() {
        response.on_hover_text("Drag to move the border");
    }
    is_used
}

fn paint(painter: &Painter, picture: Rect, middle: Pos2, is_used: bool) {
    let color = match is_used {
        true => Color32::WHITE,
        false => Color32::from_gray(210),
    };
    // A dark edge keeps the line visible on bright pictures.
    for (width, color) in [(4.0, Color32::from_black_alpha(140)), (1.5, color)] {
        painter.vline(middle.x, picture.y_range(), Stroke::new(width, color));
    }
    painter.circle(middle, RADIUS, BACKING, Stroke::new(1.5, color));
    for side in [-1.0, 1.0] {
        let tip = middle + vec2(side * 0.65 * RADIUS, 0.0);
        let foot = middle.x + side * 0.2 * RADIUS;
        let corners = [-1.0, 1.0].map(|up| Pos2::new(foot, middle.y + up * 0.35 * RADIUS));
        painter.add(Shape::convex_polygon(
            vec![tip, corners[0], corners[1]],
            color,
            Stroke::NONE,
        ));
    }
}

#[cfg(test)]
mod tests {
    use bevy_egui::egui::{Modifiers, PointerButton};
    use egui_kittest::Harness;

    use super::*;

    const PICTURE: Rect = Rect::from_min_max(Pos2::new(50.0, 20.0), Pos2::new(450.0, 380.0));

    fn window(view: CompareView) -> Harness<'static, CompareView> {
        let mut harness = Harness::builder().with_size(vec2(500.0, 400.0)).build_ui_state(
            |ui, view: &mut CompareView| {
                let mut commands = Vec::new();
                handle(ui, PICTURE, *view, &mut commands);
                for command in commands {
                    if let Command::Display(DisplayCommand::SetCompareView(moved)) = command {
                        *view = moved;
                    }
                }
            },
            view,
        );
        harness.run_steps(2);
        harness
    }

    /// Drags from one place to another. Returns the cursor icon before the press.
    fn drag(harness: &mut Harness<CompareView>, from: Pos2, to: Pos2) -> CursorIcon {
        let press = |pressed, pos| egui::Event::PointerButton {
            pos,
            button: PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        harness.event(egui::Event::PointerMoved(from));
        harness.run_steps(2);
        let cursor = harness.output().platform_output.cursor_icon;
        harness.event(press(true, from));
        harness.run_steps(1);
        for step in 1..=4 {
            harness.event(egui::Event::PointerMoved(from + (to - from) * (step as f32 / 4.0)));
            harness.run_steps(1);
        }
        harness.event(press(false, to));
        harness.run_steps(2);
        cursor
    }

    #[test]
    fn the_border_follows_the_pointer() {
        // In the middle of the handle, at its edge, and on the line far from it.
        for grab in [vec2(0.0, 0.0), vec2(-8.0, 3.0), vec2(2.0, -200.0)] {
            for view in [CompareView::Wipe(0.5), CompareView::Noisy(0.5)] {
                let mut harness = window(view);
                let from = middle(PICTURE, 0.5) + grab;
                let cursor = drag(&mut harness, from, from + vec2(100.0, 30.0));
                assert_eq!(cursor, CursorIcon::ResizeHorizontal, "{grab:?}");
                let moved = *harness.state();
                let border = moved.border().expect("it is still a wipe");
                assert!((border - 0.75).abs() < 1e-4, "{grab:?}: {border}");
                assert_eq!(moved.with_border(0.5), view);
                // The border stops at the edge of the picture, and comes back.
                let from = middle(PICTURE, border);
                drag(&mut harness, from, from + vec2(300.0, 0.0));
                assert_eq!(harness.state().border(), Some(1.0));
                let from = PICTURE.right_center() - vec2(1.0, 0.0);
                drag(&mut harness, from, from - vec2(200.0, 0.0));
                assert!((harness.state().border().expect("a wipe") - 0.5).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn beside_the_border_and_without_one_there_is_nothing_to_drag() {
        for (view, aside) in [(CompareView::Wipe(0.5), 30.0), (CompareView::Difference, 0.0)] {
            let mut harness = window(view);
            let from = middle(PICTURE, 0.5) + vec2(aside, 0.0);
            let cursor = drag(&mut harness, from, from + vec2(100.0, 0.0));
            assert_eq!((*harness.state(), cursor), (view, CursorIcon::Default));
        }
    }
}
