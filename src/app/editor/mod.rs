//! The editor: a window with the picture being rendered, and panels that change the scene and see it follow.
//!
//! Data flow one way in a frame: the world is gathered into a plain [`model::Model`]; panels show it and return the
//! user's input as [`command::Command`]s; `commands` applies them to the world; the engine reacts in the same frame;
//! the texture follows the film.
//!
//! The modules from the lowest to the highest, each of which imports only the ones before it: [`command`] and
//! [`words`]; [`camera`] and [`input`]; [`session`]; [`picture`]; [`model`]; [`commands`], [`viewport`] and [`panels`];
//! [`window`]; [`automation`]. This file puts their systems and resources together. `tests/layering` has the table.

pub mod automation;
pub mod camera;
pub mod command;
pub mod commands;
pub mod input;
pub mod model;
pub mod panels;
pub mod picture;
pub mod session;
pub mod viewport;
pub mod window;
pub mod words;

use std::time::Duration;

use bevy::asset::AssetEventSystems;
use bevy::prelude::*;
use bevy_egui::EguiPostUpdateSet;

use crate::engine::{EngineSystems, PackedScene};
use crate::scene::{OpenScene, OpeningPace, SceneSystems};
use automation::monkey::Monkey;
use commands::plugin::CommandsPlugin;
use picture::plugin::PicturePlugin;
use session::options::WindowOptions;
use session::plugin::SessionPlugin;
use session::systems::EditorSystems;
use window::plugin::WindowPlugin;

/// The time per frame for spawning the entities of a scene that is being opened.
const LONGEST_OPENING: Duration = Duration::from_millis(20);

/// Adds the editor to an app that has a window, a renderer, the scene and the engine.
pub(crate) struct EditorPlugin(pub WindowOptions);

impl Plugin for EditorPlugin {
    fn build(&self, app: &mut App) {
        let options = &self.0;
        let monkey = options.monkey.clone().map(Monkey::new).transpose();
        let folder = match &monkey {
            Ok(Some(monkey)) => Some(automation::monkey::settings_folder(monkey)),
            _ => session::preferences::folder(options.is_attended()),
        };
        let has_hands = options.is_attended() || options.monkey.is_some();
        let is_live = has_hands || options.is_measured();
        app.add_plugins((
            SessionPlugin {
                options: options.clone(),
                folder,
            },
            PicturePlugin {
                is_live,
                undrawn: options.undrawn,
            },
            model::plugin::plugin,
            CommandsPlugin { flies: has_hands },
            WindowPlugin { is_live: has_hands },
        ))
        .insert_resource(OpeningPace(Some(LONGEST_OPENING)));
        order_frame(app);
        automation::plugin::add_to(app, options, monkey);
        if let Some(path) = &options.scene {
            let request = OpenScene {
                path: path.clone(),
                defines: options.defines.clone(),
                keeps_edits: false,
            };
            app.add_systems(Startup, move |mut requests: MessageWriter<OpenScene>| {
                requests.write(request.clone());
            });
        }
    }
}

/// The order of the systems of different rooms within a frame.
fn order_frame(app: &mut App) {
    app.configure_sets(
        PostUpdate,
        (
            // Letters that are new to egui's texture are on the GPU in the frame that shows them.
            AssetEventSystems.after(EguiPostUpdateSet::PostProcessOutput),
            EditorSystems::Gather.before(EguiPostUpdateSet::EndPass),
            EditorSystems::Apply
                .after(EguiPostUpdateSet::EndPass)
                .before(EngineSystems::Detect),
            EditorSystems::Show.after(EngineSystems::Dispatch),
        ),
    )
    .add_systems(
        PreUpdate,
        (
            commands::scene_watch::choose_camera.run_if(commands::scene_watch::camera_is_wanted),
            commands::scene_watch::follow_scene,
            commands::scene_watch::follow_files,
            session::trust::follow_access,
            session::recovery::follow_scene,
            session::stored_views::follow_views,
            session::stored_views::return_to_view,
            session::preferences::note_scene,
            (
                window::dropping::take_dropped_files,
                commands::shell::note_close_requests,
            ),
        )
            .chain()
            .after(SceneSystems::Follow),
    )
    .add_systems(
        PostUpdate,
        (
            (
                commands::scene_watch::measure_scene,
                commands::fitting::tell_sizes.run_if(resource_changed::<PackedScene>),
                model::outline::gather_outline,
                model::leaks::find_leaks,
                picture::reasons::follow_reasons,
                picture::lamp_light::follow_lamp,
                picture::paths::follow_paths,
                (
                    model::inspection::gather_selection,
                    model::gather_light::gather_light_figures,
                    model::gather_game_types::gather_game_types,
                )
                    .chain(),
                model::thumbnails::update_thumbnails,
                picture::noise_trend::follow_noise,
                model::gather::gather_status,
                model::timeline::gather_timeline,
                model::gather_bake::gather_bake,
                model::gather_meters::gather_meters,
                window::title::follow_title,
                viewport::outlining::collect_outline,
                viewport::gather::gather_viewport,
            )
                .chain()
                .in_set(EditorSystems::Gather),
            (
                commands::saving::go_on.run_if(resource_exists::<commands::saving::SaveUnderWay>),
                commands::exporting::go_on.run_if(resource_exists::<commands::exporting::ExportUnderWay>),
                commands::timeline::play_on,
                commands::apply_commands,
                commands::light_paint::follow,
                commands::kept_picture::follow,
                commands::flight::fly_on,
                commands::full_film::follow_awaited_image,
                picture::resolution::follow_place,
                picture::motion::follow_motion,
                picture::carrying::ask_for_gbuffer,
                viewport::steer_cursor::steer_cursor,
                picture::pacing::pace,
            )
                .chain()
                .in_set(EditorSystems::Apply),
            (
                command::light_mix::note_film_lights,
                picture::denoiser::follow_denoiser,
                picture::carrying::follow_carrying,
                picture::texture::update_picture,
                viewport::side_scenes::follow_side_views.after(EngineSystems::Report),
                viewport::outlining::request_outline,
                picture::metering::follow_meters.after(EngineSystems::Report),
                window::preview::update_previews,
                window::assets::update_assets,
                picture::pacing::hold_back_frame,
            )
                .chain()
                .in_set(EditorSystems::Show),
        ),
    )
    .add_systems(
        First,
        (picture::frame_times::time_frames, session::history::despawn_forgotten).chain(),
    )
    .add_systems(
        Last,
        picture::frame_times::time_systems.after(session::recovery::clean_up),
    )
    .add_systems(
        Last,
        (
            session::window_place::keep_on_screen,
            automation::finish::drive_exit_door,
            automation::finish::log_at_exit,
            commands::saving::finish_at_exit
                .run_if(resource_exists::<commands::saving::SaveUnderWay>.and_then(on_message::<AppExit>)),
            commands::exporting::finish_at_exit
                .run_if(resource_exists::<commands::exporting::ExportUnderWay>.and_then(on_message::<AppExit>)),
            commands::baking::end_at_exit.run_if(on_message::<AppExit>),
            session::preferences::remember,
            session::stored_views::note_view,
            session::recovery::plan_autosave,
            session::recovery::autosave.run_if(session::recovery::is_due),
            session::recovery::clean_up,
        )
            .chain(),
    );
}
