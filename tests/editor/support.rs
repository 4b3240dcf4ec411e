//! What tests of the editor share.

use bevy_egui::egui;
use sunroom::app::editor::command::bvh_overlay::BvhOverlay;
use sunroom::app::editor::command::display::DisplaySettings;
use sunroom::app::editor::command::gizmo_settings::GizmoSettings;
use sunroom::app::editor::command::key_bindings::NO_BINDINGS;
use sunroom::app::editor::command::selection::Selection;
use sunroom::app::editor::input::actions::ActionContext;
use sunroom::app::editor::input::press::Press;

/// The keys that went down this frame, as the window hands them to the editor.
pub fn presses(ui: &egui::Ui) -> Vec<Press> {
    let press = |event: &egui::Event| match *event {
        egui::Event::Key {
            key,
            pressed: true,
            repeat: false,
            modifiers,
            ..
        } => Some(Press {
            key,
            modifiers,
            numpad: false,
        }),
        _ => None,
    };
    ui.input(|input| input.events.iter().filter_map(press).collect())
}

/// What keys refer to in an editor that was just opened.
pub fn context(selection: &Selection) -> ActionContext<'_> {
    ActionContext {
        display: DisplaySettings::default(),
        overlay: BvhOverlay::default(),
        gizmo: GizmoSettings::default(),
        paused: false,
        panels_shown: true,
        selection,
        tool: Default::default(),
        bound: &NO_BINDINGS,
        safe_frame: false,
        grid: Default::default(),
        dimensions: false,
        seeing: Default::default(),
        isolated: false,
        flying: false,
    }
}
