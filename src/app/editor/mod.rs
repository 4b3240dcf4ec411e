//! The editor: a window with the picture being rendered, and panels that change the scene and see it follow.
//!
//! A frame goes one way: the world is gathered into a plain [`model::Model`]; panels show it and say what the user did as
//! [`command::Command`]s; `commands` writes those to the world; the engine reacts in the same frame; the texture follows the film.

pub mod actions;
pub mod addition;
mod captions;
pub mod command;
pub mod commands;
pub mod compare;
pub mod cursor;
mod denoiser;
mod dialogs;
pub mod display;
mod docking;
mod dropping;
mod exit_door;
mod flight;
mod gather;
pub mod gizmo;
pub mod guard;
pub mod history;
pub mod icons;
mod inspection;
pub mod keys;
mod latency;
pub mod layout;
mod leaving;
pub mod light_mix;
pub mod looks;
pub mod material_drop;
pub mod material_tree;
pub mod mixed;
pub mod model;
pub mod monkey;
mod motion;
pub mod navigation;
pub mod options;
pub mod orbit;
pub mod outline;
pub mod overlay;
mod pacing;
pub mod painter;
pub mod palette;
pub mod panel_sizes;
pub mod panels;
pub mod path_lines;
pub mod paths;
mod picking;
mod picture;
pub mod pointer;
pub mod preferences;
pub mod presets;
mod preview;
mod quiet;
pub mod recovery;
pub mod recovery_question;
pub mod save_question;
pub mod scene_watch;
pub mod screen;
pub mod script;
pub mod selection;
mod sheet;
pub mod shell;
pub mod shortcuts;
pub mod state;
pub mod stored_views;
mod studio;
mod style;
pub mod toasts;
pub mod tool;
pub mod toolbar;
pub mod trust;
pub mod trust_question;
mod typing;
mod ui;
pub mod viewport;

use std::path::Path;

use bevy::asset::AssetEventSystems;
use bevy::input::InputSystems;
use bevy::prelude::*;
use bevy_egui::{EguiPlugin, EguiPostUpdateSet, EguiPreUpdateSet, EguiPrimaryContextPass};

use crate::app::terminal;
use crate::engine::EngineSystems;
use crate::memory;
use crate::scene::{OpenScene, SceneAccess, SceneSystems};
use monkey::Monkey;
use options::{SceneDefines, WantedCamera, WindowOptions};
use preferences::PreferencesFile;
use toasts::Topic;

/// Adds the editor to an app that has a window, a renderer, the scene and the engine.
pub struct EditorPlugin(pub WindowOptions);

/// The editor's steps in `PostUpdate`, around those of egui and the engine.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum EditorSystems {
    /// World to model, before the panels are shown.
    Gather,
    /// Commands to world, before the engine looks for changes.
    Apply,
    /// Film to texture, after the engine has collected results and put its workers to new work.
    Show,
}

impl Plugin for EditorPlugin {
    fn build(&self, app: &mut App) {
        let options = &self.0;
        let monkey = options.monkey.clone().map(Monkey::new).transpose();
        let folder = match &monkey {
            Ok(Some(monkey)) => Some(monkey::settings_folder(monkey)),
            _ => preferences::folder(options.is_attended()),
        };
        let (preferences_file, preferences) = PreferencesFile::open(folder.as_deref());
        let mut state = state::EditorState::default();
        state.navigation.set_speed(preferences.speed);
        state.gizmo.steps = preferences.steps;
        memory::budget().prefer_limit(preferences.memory_limit());
        if let Some(problem) = &preferences_file.problem {
            state.complain(Topic::Other, problem, None);
        }
        // Nobody could answer the question.
        let (trusted_folders, trust) = match options.is_attended() {
            true => trust::TrustedFolders::open(folder.as_deref()),
            false => Default::default(),
        };
        let access = app.world_mut().get_resource_or_init::<SceneAccess>();
        access.set(trust.access(Path::new("")));
        app.add_plugins(EguiPlugin::default())
            .insert_resource(state)
            .insert_resource(preferences.layout())
            .insert_resource(preferences)
            .insert_resource(preferences_file)
            .insert_resource(trusted_folders)
            .insert_resource(trust)
            .insert_resource(recovery::Recovery::new(folder.as_deref()))
            .insert_resource(stored_views::ViewsFile::new(folder.as_deref()))
            .insert_resource(flight::Flights::new(options.is_attended() || options.monkey.is_some()))
            .insert_resource(motion::Motion::new(
                options.is_attended() || options.measure_latency.is_some() || options.monkey.is_some(),
            ))
            .init_resource::<dropping::DroppedFiles>()
            .init_resource::<history::History>()
            .init_resource::<paths::PathInspector>()
            .init_resource::<selection::Selection>()
            .init_resource::<state::CommandQueue>()
            .init_resource::<light_mix::LightMix>()
            .init_resource::<light_mix::FilmLights>()
            .init_resource::<compare::Comparison>()
            .init_resource::<gather::EditorModel>()
            .init_resource::<looks::Thumbnails>()
            .init_resource::<preview::Previews>()
            .init_resource::<dialogs::Dialogs>()
            .init_resource::<latency::FrameTimes>()
            .insert_resource(pacing::Pacing::new(options.undrawn))
            .insert_resource(denoiser::Denoiser::new())
            .insert_resource(SceneDefines(options.defines.clone()))
            .insert_resource(WantedCamera {
                name: options.camera.clone(),
                is_required: !options.is_attended(),
            })
            .insert_resource(exit_door::ExitDoor::new(
                options.screenshot.clone(),
                options.after_spp,
                options.exit,
                options.timeout,
            ))
            .configure_sets(
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
                Startup,
                (
                    spawn_camera,
                    picture::create_picture,
                    pacing::connect_wake_up,
                    gather::load_presets,
                ),
            )
            .add_systems(
                PreUpdate,
                (
                    scene_watch::choose_camera.run_if(scene_watch::camera_is_wanted),
                    scene_watch::follow_scene,
                    scene_watch::follow_files,
                    trust::follow_access,
                    recovery::follow_scene,
                    stored_views::follow_views,
                    preferences::note_scene,
                    (dropping::take_dropped_files, shell::note_close_requests),
                )
                    .chain()
                    .after(SceneSystems::Follow),
            )
            .add_systems(PreUpdate, scene_watch::hold_reloads.before(SceneSystems::Apply))
            .add_systems(PreUpdate, typing::order_keys.before(InputSystems))
            .add_systems(
                PreUpdate,
                (quiet::drop_repeated_modifiers, leaving::note_pointer_gone)
                    .after(EguiPreUpdateSet::ProcessInput)
                    .before(EguiPreUpdateSet::BeginPass),
            )
            .add_systems(
                PostUpdate,
                (
                    (
                        scene_watch::measure_scene,
                        gather::gather_outline,
                        paths::follow_paths,
                        inspection::gather_selection,
                        looks::update_thumbnails,
                        gather::gather_status,
                    )
                        .chain()
                        .in_set(EditorSystems::Gather),
                    (
                        commands::apply_commands,
                        flight::fly_on,
                        motion::follow_motion,
                        cursor::steer_cursor,
                        pacing::pace,
                    )
                        .chain()
                        .in_set(EditorSystems::Apply),
                    (
                        light_mix::note_film_lights,
                        denoiser::collect_denoised,
                        picture::update_picture,
                        preview::update_previews,
                        pacing::hold_back_frame,
                    )
                        .chain()
                        .in_set(EditorSystems::Show),
                ),
            )
            .add_systems(
                EguiPrimaryContextPass,
                (
                    style::set_styles.run_if(run_once),
                    style::follow_preferences,
                    ui::show_window,
                )
                    .chain(),
            )
            .add_systems(First, (latency::time_frames, history::despawn_forgotten).chain())
            .add_systems(Last, latency::time_systems.after(recovery::clean_up))
            .add_systems(
                Last,
                (
                    exit_door::drive_exit_door,
                    exit_door::log_at_exit,
                    preferences::remember,
                    recovery::plan_autosave,
                    recovery::autosave.run_if(recovery::is_due),
                    recovery::clean_up,
                )
                    .chain(),
            );
        if let Some(moves) = options.measure_latency {
            latency::time_drawing(app);
            app.insert_resource(latency::LatencyProbe::new(moves)).add_systems(
                PostUpdate,
                (
                    latency::act_for_probe
                        .before(EditorSystems::Apply)
                        .after(EguiPostUpdateSet::EndPass),
                    latency::watch_probe.after(EditorSystems::Show),
                ),
            );
        }
        match monkey {
            Ok(Some(monkey)) => monkey::add_to(app, monkey),
            Ok(None) => {}
            Err(error) => {
                eprintln!("error: the monkey's files cannot be written: {error}");
                app.add_systems(Startup, |mut exit: MessageWriter<AppExit>| {
                    exit.write(AppExit::error());
                });
            }
        }
        if let Some(path) = &options.script {
            match script::Script::read(path) {
                Ok(script) => {
                    app.insert_resource(script).add_systems(
                        PostUpdate,
                        script::run_script
                            .before(EditorSystems::Apply)
                            .after(EguiPostUpdateSet::EndPass),
                    );
                }
                Err(error) => {
                    terminal::line(format_args!("error: {}: {error}", path.display()));
                    app.add_systems(Startup, |mut exit: MessageWriter<AppExit>| {
                        exit.write(AppExit::error());
                    });
                }
            }
        }
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

/// egui is drawn by a camera; it sees nothing else. egui smooths its edges itself: multisampling would only cost, on a software driver
/// most of a frame's time.
fn spawn_camera(mut commands: Commands) {
    commands.spawn((Camera2d, Msaa::Off));
}
