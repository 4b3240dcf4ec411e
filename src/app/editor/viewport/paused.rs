//! The bar over a paused picture that is not up to date, with a button that resumes rendering.

use bevy_egui::egui::{Align, Button, Layout, Margin, Rect, Ui, UiBuilder, pos2, vec2};

use super::marks::bar_frame;
use super::model::ViewportModel;
use crate::app::editor::command::{Command, RenderCommand};
use crate::app::editor::input::actions::hint;
use crate::engine::Outdated;

/// The size of the bar, in points.
const SIZE: bevy_egui::egui::Vec2 = vec2(380.0, 30.0);
/// The distance of the bar from the top of the panel, below the toolbar and the hint about a tool, and from the foot of
/// the picture, above the bars of tools and the captions.
const TOP: f32 = 68.0;
const FOOT: f32 = 84.0;

/// The text about an outdated picture; None if it is up to date.
pub(super) fn words(model: &ViewportModel) -> Option<&'static str> {
    let outdated = model.outdated.filter(|_| model.keys.paused)?;
    Some(match (model.picture, outdated) {
        (None, _) => "Paused: nothing of this scene is rendered yet",
        (Some(_), Outdated::Scene) => "Paused: the picture is older than the scene",
        (Some(_), Outdated::View) => "Paused: the picture is older than the view",
    })
}

/// The place of the bar: at the top of the picture, or at its foot if it would hide handles at the top.
fn place(panel: Rect, picture: Rect, handles: Option<Rect>) -> Rect {
    let size = SIZE.min(vec2(picture.width(), SIZE.y));
    let at = |top: f32| Rect::from_min_size(pos2(picture.center().x - 0.5 * size.x, top), size);
    let top = at((panel.top() + TOP).max(picture.top() + 8.0));
    match handles.is_some_and(|handles| handles.intersects(top)) {
        true => at(picture.bottom() - FOOT - size.y),
        false => top,
    }
}

/// Shows the bar, and returns its rectangle. `handles` is the rectangle of the handles.
pub(super) fn bar(
    ui: &mut Ui,
    panel: Rect,
    picture: Rect,
    handles: Option<Rect>,
    model: &ViewportModel,
    commands: &mut Vec<Command>,
) -> Option<Rect> {
    let words = words(model)?;
    let place = place(panel, picture, handles);
    let layout = Layout::left_to_right(Align::Center);
    let mut bar = ui.new_child(UiBuilder::new().id_salt("paused").max_rect(place).layout(layout));
    bar_frame(&bar, Margin::symmetric(8, 4)).show(&mut bar, |ui| {
        ui.label(words);
        let button = ui
            .add(Button::new("Resume"))
            .on_hover_text(hint("Render again", "pause", model.keys.bound));
        if button.clicked() {
            commands.push(RenderCommand::SetPaused(false).into());
        }
    });
    Some(place)
}
