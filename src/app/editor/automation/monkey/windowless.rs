//! The editor without a window: its commands, history, messages, watch of files and recovery, but no panels and no
//! textures.

use std::process::ExitCode;
use std::time::Duration;

use bevy::app::ScheduleRunnerPlugin;
use bevy::prelude::*;

use super::add_to;
use super::state::{Monkey, settings_folder};
use crate::app::allocator::keep_memory_low;
use crate::app::editor::command::{light_mix, selection};
use crate::app::editor::commands::{self, flight, full_film, scene_watch};
use crate::app::editor::model::{EditorModel, gather, gather_light, inspection, leaks, outline};
use crate::app::editor::picture::frame_times::{self, FrameTimes};
use crate::app::editor::picture::{compare, denoiser, lamp_light, motion, noise_trend, pacing, paths};
use crate::app::editor::session::requests::{CommandQueue, Requests};
use crate::app::editor::session::systems::EditorSystems;
use crate::app::editor::session::toasts::Toasts;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::app::editor::session::{history, layout, options, preferences, recovery, stored_views, views_file};
use crate::app::threads::{run_systems_in_turn, worker_count};
use crate::engine::{EnginePlugin, EngineSystems, RenderControl};
use crate::scene::{FileSourcePlugin, ScenePlugin, SceneSystems, asset_plugin};

/// An editor without a window, in which the monkey plays until the app exits. `threads` as in [`worker_count`].
fn windowless(monkey: Monkey, threads: Option<i32>) -> App {
    let folder = settings_folder(&monkey);
    let mut app = App::new();
    let (preferences_file, preferences) = preferences::PreferencesFile::open(Some(&folder));
    // The frames leave the cores to other threads for a moment.
    let runner = ScheduleRunnerPlugin::run_loop(Duration::from_millis(1));
    app.add_plugins((MinimalPlugins.set(runner), FileSourcePlugin, asset_plugin()))
        .add_plugins((ScenePlugin, EnginePlugin))
        .insert_resource(RenderControl {
            interactive: true,
            path_is_auto: true,
            threads: worker_count(threads, false),
            ..default()
        })
        .init_resource::<ViewSettings>()
        .init_resource::<Requests>()
        .init_resource::<Toasts>()
        .init_resource::<layout::Layout>()
        .insert_resource(preferences)
        .insert_resource(preferences_file)
        .insert_resource(recovery::Recovery::new(Some(&folder)))
        .insert_resource(views_file::ViewsFile::new(Some(&folder)))
        .insert_resource(flight::Flights::new(true))
        .insert_resource(motion::Motion::new(true))
        .init_resource::<history::History>()
        .init_resource::<noise_trend::NoiseTrend>()
        .init_resource::<lamp_light::LampFollower>()
        .init_resource::<paths::PathInspector>()
        .init_resource::<selection::Selection>()
        .init_resource::<CommandQueue>()
        .init_resource::<light_mix::LightMix>()
        .init_resource::<light_mix::FilmLights>()
        .init_resource::<compare::Comparison>()
        .init_resource::<EditorModel>()
        .init_resource::<leaks::Leaks>()
        .init_resource::<FrameTimes>()
        .init_resource::<pacing::Pacing>()
        .init_resource::<options::SceneDefines>()
        .insert_resource(denoiser::Denoiser::new())
        .configure_sets(
            PostUpdate,
            (
                EditorSystems::Gather.before(EditorSystems::Apply),
                EditorSystems::Apply.before(EngineSystems::Detect),
                EditorSystems::Show.after(EngineSystems::Dispatch),
            ),
        )
        .add_systems(
            PreUpdate,
            (
                scene_watch::follow_scene,
                scene_watch::follow_files,
                recovery::follow_scene,
                stored_views::follow_views,
                preferences::note_scene,
            )
                .chain()
                .after(SceneSystems::Follow),
        )
        .add_systems(Startup, gather::load_presets)
        .add_systems(
            PostUpdate,
            (
                (
                    scene_watch::measure_scene,
                    outline::gather_outline,
                    leaks::find_leaks,
                    paths::follow_paths,
                    (inspection::gather_selection, gather_light::gather_light_figures).chain(),
                    gather::gather_status,
                )
                    .chain()
                    .in_set(EditorSystems::Gather),
                (
                    commands::apply_commands,
                    flight::fly_on,
                    full_film::follow_awaited_image,
                    motion::follow_motion,
                )
                    .chain()
                    .in_set(EditorSystems::Apply),
                (light_mix::note_film_lights, denoiser::follow_denoiser)
                    .chain()
                    .in_set(EditorSystems::Show),
            ),
        )
        .add_systems(First, (frame_times::time_frames, history::despawn_forgotten).chain())
        .add_systems(Last, frame_times::time_systems.after(recovery::clean_up))
        .add_systems(
            Last,
            (
                preferences::remember,
                recovery::plan_autosave,
                recovery::autosave.run_if(recovery::is_due),
                recovery::clean_up,
            )
                .chain(),
        );
    add_to(&mut app, monkey);
    run_systems_in_turn(&mut app);
    app
}

/// Plays to the end and prints the report.
pub fn run_windowless(monkey: Monkey, threads: Option<i32>) -> ExitCode {
    keep_memory_low();
    match windowless(monkey, threads).run() {
        AppExit::Success => ExitCode::SUCCESS,
        AppExit::Error(code) => ExitCode::from(code.get()),
    }
}
