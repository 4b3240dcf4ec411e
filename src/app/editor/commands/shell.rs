//! Applies commands for the window itself: panels, overlays, full screen.

use bevy::prelude::*;
use bevy::window::{MonitorSelection, PrimaryWindow, WindowCloseRequested, WindowMode};

use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::command::{FileDialogKind, ShellCommand};
use crate::app::editor::session::layout::Layout;
use crate::app::editor::session::recovery::Recovery;
use crate::app::editor::session::requests::Requests;
use crate::app::editor::session::tutorial::Tutorial;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::app::editor::session::{recovery, trust};
use crate::memory;
use crate::render::tonemap::ToneMap;

/// Applies a command of the window. The error is a sentence for the user.
pub fn apply(world: &mut World, command: ShellCommand) -> Result<(), CommandError> {
    match command {
        ShellCommand::ShowPanels(shown) => world.resource_mut::<ViewSettings>().panels_shown = shown,
        ShellCommand::ShowPanel(panel) => world.get_resource_or_init::<Layout>().show(panel),
        ShellCommand::ClosePanel(panel) => world.get_resource_or_init::<Layout>().close(panel),
        ShellCommand::ResetLayout => world.insert_resource(Layout::default()),
        ShellCommand::ToggleFullScreen => toggle_full_screen(world),
        ShellCommand::ShowSheet(sheet) => {
            world.resource_mut::<Requests>().sheet = Some(sheet);
        }
        ShellCommand::SetPreferences(preferences) => {
            let preferences = preferences.within_range();
            memory::budget().prefer_limit(preferences.memory_limit());
            show_tone_map(world, preferences.tone_map);
            world.insert_resource(preferences);
        }
        ShellCommand::SetNavigation(preset) => {
            world.get_resource_or_init::<Preferences>().navigation = preset;
        }
        ShellCommand::ShowTutorial(step) => {
            world.get_resource_or_init::<Tutorial>().go_to(step);
            world.resource_mut::<Requests>().leave_start_page();
        }
        ShellCommand::AddAssetFolder(folder) => world.get_resource_or_init::<Preferences>().add_asset_folder(folder),
        ShellCommand::RemoveAssetFolder(folder) => {
            let mut preferences = world.get_resource_or_init::<Preferences>();
            preferences.asset_folders.retain(|known| *known != folder);
        }
        ShellCommand::ShowRecovery => recovery::show(world),
        ShellCommand::AskAboutRecovery(offer) => world.resource_mut::<Recovery>().offer = Some(offer),
        ShellCommand::Recover(offer) => {
            let result = recovery::recover(world, offer);
            recovery::look_again(world);
            result?;
        }
        ShellCommand::DiscardRecovery(offer) => {
            let result = recovery::discard(&offer);
            recovery::look_again(world);
            result?;
        }
        ShellCommand::AskAboutScene(file) => world.resource_mut::<Requests>().scene_question = Some(*file),
        ShellCommand::AllowFiles(question) => trust::allow(world, &question),
        ShellCommand::FindFile(sought) => {
            let mut requests = world.resource_mut::<Requests>();
            requests.dialog = Some(FileDialogKind::FindFile(sought.kind));
            requests.sought = Some(sought);
        }
    }
    Ok(())
}

/// Applies a changed preference of the tone map to the open window.
fn show_tone_map(world: &mut World, tone_map: ToneMap) {
    let is_new = world
        .get_resource::<Preferences>()
        .is_some_and(|known| known.tone_map != tone_map);
    if is_new && let Some(mut settings) = world.get_resource_mut::<ViewSettings>() {
        settings.display.tone_map = tone_map;
    }
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
pub(crate) fn note_close_requests(mut closing: MessageReader<WindowCloseRequested>, mut requests: ResMut<Requests>) {
    if closing.read().count() > 0 {
        requests.closes = true;
    }
}
