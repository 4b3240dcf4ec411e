//! What the user does to the window itself: panels, overlays, full screen.

use bevy::prelude::*;
use bevy::window::{MonitorSelection, PrimaryWindow, WindowCloseRequested, WindowMode};

use super::layout::{Layout, Panel};
use super::palette::Palette;
use super::preferences::Preferences;
use super::recovery::{self, Offer};
use super::state::EditorState;
use super::trust::{self, Question};
use crate::memory;

#[derive(Clone, Debug, PartialEq)]
pub enum ShellCommand {
    /// In front of its group, also if it was closed.
    ShowPanel(Panel),
    ClosePanel(Panel),
    /// All panels as in a new window.
    ResetLayout,
    ToggleFullScreen,
    ShowSheet(Sheet),
    SetPreferences(Box<Preferences>),
    /// Opens what was written aside before a crash.
    Recover(Offer),
    DiscardRecovery(Offer),
    /// Lets scenes read the folders of these files.
    AllowFiles(Question),
}

/// What lies over the window until it is closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sheet {
    Palette,
    Shortcuts,
    Preferences,
}

pub fn apply(world: &mut World, command: ShellCommand) -> Result<(), String> {
    match command {
        ShellCommand::ShowPanel(panel) => world.get_resource_or_init::<Layout>().show(panel),
        ShellCommand::ClosePanel(panel) => world.get_resource_or_init::<Layout>().close(panel),
        ShellCommand::ResetLayout => world.insert_resource(Layout::default()),
        ShellCommand::ToggleFullScreen => toggle_full_screen(world),
        ShellCommand::ShowSheet(sheet) => {
            let mut state = world.resource_mut::<EditorState>();
            state.sheet = Some(sheet);
            state.palette = Palette::default();
        }
        ShellCommand::SetPreferences(preferences) => {
            let preferences = preferences.within_range();
            memory::budget().prefer_limit(preferences.memory_limit());
            world.insert_resource(preferences);
        }
        ShellCommand::Recover(offer) => recovery::recover(world, offer)?,
        ShellCommand::DiscardRecovery(offer) => recovery::discard(&offer)?,
        ShellCommand::AllowFiles(question) => trust::allow(world, &question),
    }
    Ok(())
}

fn toggle_full_screen(world: &mut World) {
    let mut windows = world.query_filtered::<&mut Window, With<PrimaryWindow>>();
    if let Ok(mut window) = windows.single_mut(world) {
        window.mode = match window.mode {
            WindowMode::Windowed => WindowMode::BorderlessFullscreen(MonitorSelection::Current),
            _ => WindowMode::Windowed,
        };
    }
}

/// The window stays open until the user has been asked about unsaved edits.
pub fn note_close_requests(mut requests: MessageReader<WindowCloseRequested>, mut state: ResMut<EditorState>) {
    if requests.read().count() > 0 {
        state.closes = true;
    }
}
