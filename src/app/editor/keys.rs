//! The keyboard: which keys fly, and which are commands.

use bevy::math::Vec3;
use bevy::prelude::Entity;
use bevy_egui::egui::{InputState, Key, Modifiers};

use super::command::{Command, FileDialogKind};
use super::display::DisplaySettings;
use super::overlay::BvhOverlay;

/// What the keys toggle or step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KeyContext {
    pub display: DisplaySettings,
    pub overlay: BvhOverlay,
    pub paused: bool,
    pub panels_shown: bool,
    pub selection: Option<Entity>,
    /// While flying, Control means slow and is no part of a shortcut.
    pub flying: bool,
}

/// Stops per press of a bracket key.
const EXPOSURE_STEP: f32 = 0.25;

/// To the left, up, forward, each -1, 0 or 1.
pub fn fly_direction(input: &InputState) -> Vec3 {
    let axis = |plus: Key, minus: Key| f32::from(input.key_down(plus)) - f32::from(input.key_down(minus));
    Vec3::new(axis(Key::A, Key::D), axis(Key::E, Key::Q), axis(Key::W, Key::S))
}

/// The commands of the keys pressed this frame.
pub fn shortcuts(input: &InputState, context: &KeyContext) -> Vec<Command> {
    let plain = |key| input.key_pressed(key) && input.modifiers.is_none();
    let shift = |key| input.key_pressed(key) && input.modifiers.matches_exact(Modifiers::SHIFT);
    let control = |key| input.key_pressed(key) && input.modifiers.command_only() && !context.flying;
    let KeyContext { display, overlay, .. } = *context;
    let exposed = |stops: f32| {
        Command::SetDisplay(DisplaySettings {
            exposure: display.exposure + stops,
            ..display
        })
    };
    let table = [
        (
            plain(Key::Tab),
            Command::SetDisplay(DisplaySettings {
                mode: display.mode.next(),
                ..display
            }),
        ),
        (plain(Key::OpenBracket), exposed(-EXPOSURE_STEP)),
        (plain(Key::CloseBracket), exposed(EXPOSURE_STEP)),
        (plain(Key::Space), Command::SetPaused(!context.paused)),
        (shift(Key::R), Command::Restart),
        (plain(Key::N), Command::Denoise),
        (
            plain(Key::B),
            Command::SetOverlay(BvhOverlay {
                shown: !overlay.shown,
                ..overlay
            }),
        ),
        (plain(Key::F), Command::FrameSelection),
        (plain(Key::Home), Command::FrameAll),
        (plain(Key::Escape) && context.selection.is_some(), Command::Select(None)),
        (plain(Key::F5), Command::ReloadScene),
        (plain(Key::F12), Command::ShowDialog(FileDialogKind::SaveImage)),
        (control(Key::O), Command::ShowDialog(FileDialogKind::OpenScene)),
        (control(Key::S), Command::ShowDialog(FileDialogKind::SaveScene)),
        (control(Key::B), Command::ShowPanels(!context.panels_shown)),
        (control(Key::Q), Command::Quit),
    ];
    table
        .into_iter()
        .filter_map(|(pressed, command)| pressed.then_some(command))
        .collect()
}
