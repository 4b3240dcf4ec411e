//! The hint over the picture of a scene without shapes: the first steps of building one.

use bevy_egui::egui::{self, Align, Color32, Layout, Margin, Rect, RichText, Ui, UiBuilder};

use super::marks::bar_frame;
use crate::app::editor::command::Command;
use crate::app::editor::input::actions::{self, ActionContext};

const SIZE: egui::Vec2 = egui::vec2(350.0, 176.0);

/// Shows the hint in the middle of the picture.
pub(super) fn first_steps(ui: &mut Ui, picture: Rect, context: &ActionContext, commands: &mut Vec<Command>) {
    let place = Rect::from_center_size(picture.center(), SIZE.min(picture.size()));
    let layout = Layout::top_down(Align::Center);
    let mut middle = ui.new_child(UiBuilder::new().id_salt("first steps").max_rect(place).layout(layout));
    middle.set_clip_rect(picture);
    bar_frame(&middle, Margin::symmetric(14, 10)).show(&mut middle, |ui| {
        ui.label(RichText::new("This scene has no shapes yet").strong());
        // Buttons look like buttons on the fill of a window as well.
        if ui.visuals().dark_mode {
            ui.visuals_mut().widgets.inactive.weak_bg_fill = Color32::from_gray(88);
        }
        ui.add_space(4.0);
        ui.horizontal(|ui| {
            ui.label("Add a");
            for name in ["add-cube", "add-sphere", "add-rectangle"] {
                act(ui, name, context, commands);
            }
        });
        ui.horizontal(|ui| {
            ui.label("or");
            for name in ["draw-box", "draw-floor", "draw-wall"] {
                act(ui, name, context, commands);
            }
        });
        ui.horizontal(|ui| {
            ui.label("or");
            act(ui, "import", context, commands);
            ui.label("a mesh, or");
            act(ui, "open", context, commands);
            ui.label("a scene.");
        });
        ui.add_space(4.0);
        ui.weak("The menu Add has more. Meshes, pictures and scenes can also be dropped here.");
        let keys = |name: &str| actions::key_text(name, context.bound);
        ui.weak(format!(
            "{} shows all keys; {} finds any command.",
            keys("shortcuts"),
            keys("palette")
        ));
    });
}

/// The button of an action.
fn act(ui: &mut Ui, name: &str, context: &ActionContext, commands: &mut Vec<Command>) {
    let Some(action) = actions::find(name) else { return };
    let response = ui.button(action.label);
    let response = match action.key_text(context.bound) {
        key if key.is_empty() => response,
        key => response.on_hover_text(key),
    };
    if response.clicked() {
        commands.extend((action.command)(context));
    }
}
