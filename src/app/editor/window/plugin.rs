//! egui, the resources of the window, and the systems of its input and its panels.

use bevy::input::InputSystems;
use bevy::prelude::*;
use bevy_egui::{EguiPlugin, EguiPreUpdateSet, EguiPrimaryContextPass};

use super::assets::AssetWork;
use super::dialogs::Dialogs;
use super::dropping::DroppedFiles;
use super::preview::Previews;
use super::widgets::Widgets;
use super::{style, ui};
use crate::app::editor::input;
use crate::app::editor::viewport::gather::ViewportScene;
use crate::app::editor::viewport::side_scenes::SideScenes;
use crate::app::editor::viewport::state::ViewportState;

/// Adds egui and the window's panels.
pub(crate) struct WindowPlugin {
    /// Whether the program may move and hide the pointer, as for a user.
    pub is_live: bool,
}

impl Plugin for WindowPlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(EguiPlugin::default())
            .init_resource::<AssetWork>()
            .init_resource::<Dialogs>()
            .init_resource::<DroppedFiles>()
            .init_resource::<Previews>()
            .init_resource::<ViewportScene>()
            .init_resource::<SideScenes>()
            .init_resource::<Widgets>()
            .insert_resource(ViewportState::new(self.is_live))
            .add_systems(Startup, spawn_camera)
            .add_systems(PreUpdate, input::typing::order_keys.before(InputSystems))
            .add_systems(
                PreUpdate,
                (
                    input::modifier_dedup::drop_repeated_modifiers,
                    input::leaving::note_pointer_gone,
                )
                    .after(EguiPreUpdateSet::ProcessInput)
                    .before(EguiPreUpdateSet::BeginPass),
            )
            .add_systems(
                EguiPrimaryContextPass,
                (
                    style::set_styles_of_window.run_if(run_once),
                    style::follow_preferences,
                    ui::show_window,
                )
                    .chain(),
            );
    }
}

/// The camera that egui is drawn by, and nothing else. egui smooths its edges itself: multisampling would only cost, on
/// a software driver most of a frame's time.
fn spawn_camera(mut commands: Commands) {
    commands.spawn((Camera2d, Msaa::Off));
}
