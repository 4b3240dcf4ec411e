//! The bar over a paused picture that is not the one of the scene, with a button to go on.

use bevy_egui::egui::{Align, Button, Layout, Margin, Rect, Ui, UiBuilder, pos2, vec2};

use super::marks::bar_frame;
use super::model::ViewportModel;
use crate::app::editor::command::Command;
use crate::app::editor::input::actions::hint;
use crate::engine::Outdated;

/// The size of the bar, in points.
const SIZE: bevy_egui::egui::Vec2 = vec2(380.0, 30.0);
/// The distance of the bar from the foot of the picture, above the bars of tools and the captions.
const FOOT: f32 = 84.0;

/// What is told of the picture; nothing if it is the one of the scene.
fn words(model: &ViewportModel) -> Option<&'static str> {
    let outdated = model.outdated.filter(|_| model.keys.paused)?;
    Some(match (model.picture, outdated) {
        (None, _) => "Paused: nothing of this scene is rendered yet",
        (Some(_), Outdated::Scene) => "Paused: the picture is older than the scene",
        (Some(_), Outdated::View) => "Paused: the picture is older than the view",
    })
}

pub(super) fn bar(ui: &mut Ui, picture: Rect, model: &ViewportModel, commands: &mut Vec<Command>) {
    let Some(words) = words(model) else { return };
    let size = SIZE.min(vec2(picture.width(), SIZE.y));
    let foot = pos2(picture.center().x, picture.bottom() - FOOT);
    let place = Rect::from_min_size(pos2(foot.x - 0.5 * size.x, foot.y - size.y), size);
    let layout = Layout::left_to_right(Align::Center);
    let mut bar = ui.new_child(UiBuilder::new().id_salt("paused").max_rect(place).layout(layout));
    bar_frame(&bar, Margin::symmetric(8, 4)).show(&mut bar, |ui| {
        ui.label(words);
        let button = ui
            .add(Button::new("Go on"))
            .on_hover_text(hint("Render again", "pause", model.keys.bound));
        if button.clicked() {
            commands.push(Command::SetPaused(false));
        }
    });
}
