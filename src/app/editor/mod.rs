//! The editor: a window with the picture being rendered, and panels that change the scene and see it follow.
//!
//! A frame goes one way: the world is gathered into a plain [`model::Model`]; panels show it and say what the user did
//! as [`command::Command`]s; `commands` writes those to the world; the engine reacts in the same frame; the texture
//! follows the film.
//!
//! The modules from the lowest to the highest, each of which imports only what stands before it: [`command`] and
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

use std::path::Path;
use std::time::Duration;

use bevy::asset::AssetEventSystems;
use bevy::input::InputSystems;
use bevy::prelude::*;
use bevy::window::WindowFocused;
use bevy_egui::{EguiPlugin, EguiPostUpdateSet, EguiPreUpdateSet, EguiPrimaryContextPass};

use crate::app::terminal;
use crate::engine::{EngineSystems, PackedScene};
use crate::memory;
use crate::scene::{OpenScene, OpeningPace, SceneAccess, SceneSystems};
use automation::monkey::Monkey;
use command::resolution::Resolution;
use command::shell::Sheet;
use session::layout::Layout;
use session::options::{BegunWith, SceneDefines, WantedCamera, WindowOptions};
use session::preferences::PreferencesFile;
use session::requests::{CommandQueue, Requests};
use session::systems::EditorSystems;
use session::toasts::{Toasts, Topic};
use session::view_settings::ViewSettings;
use viewport::gather::ViewportScene;
use viewport::state::ViewportState;
use window::widgets::Widgets;

/// The longest part of a frame in which entities of a scene that is being opened are made.
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
        let open = match options.is_attended() || options.monkey.is_some() {
            true => PreferencesFile::open,
            false => PreferencesFile::open_only_read,
        };
        let (preferences_file, preferences) = open(folder.as_deref());
        let mut settings = ViewSettings::default();
        settings.navigation.set_speed(preferences.speed);
        settings.gizmo.steps = preferences.steps;
        settings.enlarging = preferences.enlarging;
        // Pictures that a script saves have the pixels of the film, whatever the window's size.
        settings.resolution = match options.script {
            Some(_) => Resolution::Full,
            None => preferences.resolution,
        };
        settings.gizmo.snap = preferences.snapping;
        settings.grid = preferences.grid;
        settings.dimensions = preferences.dimensions;
        // A script begins in the same way whatever a user prefers.
        if options.is_attended() {
            settings.display.tone_map = preferences.tone_map;
        }
        settings.denoising = options.denoise || options.is_attended() && preferences.denoising;
        let mut toasts = Toasts::default();
        memory::budget().prefer_limit(preferences.memory_limit());
        if let Some(problem) = &preferences_file.problem {
            toasts.error(Topic::Other, problem, None);
        }
        // Without a user the question could not be answered.
        let (trusted_folders, trust) = match options.is_attended() {
            true => session::trust::TrustedFolders::open(folder.as_deref()),
            false => Default::default(),
        };
        let mut views_file = session::views_file::ViewsFile::new(folder.as_deref());
        if options.is_attended() {
            views_file = views_file.returning(options.camera.is_some());
        }
        let access = app.world_mut().get_resource_or_init::<SceneAccess>();
        access.set(trust.access(Path::new("")));
        app.add_plugins(EguiPlugin::default())
            .insert_resource(settings)
            .insert_resource(toasts)
            .insert_resource(Requests {
                sheet: (options.begins && options.is_attended() && preferences.start_page).then_some(Sheet::Start),
                ..default()
            })
            .init_resource::<session::tutorial::Tutorial>()
            .init_resource::<Widgets>()
            .insert_resource(ViewportState::new(options.is_attended() || options.monkey.is_some()))
            .init_resource::<ViewportScene>()
            .init_resource::<picture::outline_pass::OutlinePass>()
            .insert_resource(Layout::remembered(&preferences))
            .insert_resource(preferences)
            .insert_resource(preferences_file)
            .insert_resource(trusted_folders)
            .insert_resource(trust)
            .insert_resource(session::recovery::Recovery::new(folder.as_deref()).asking(options.is_attended()))
            .insert_resource(views_file)
            .insert_resource(session::kept_picture::KeptPictures::new(options.is_attended()))
            .insert_resource(commands::flight::Flights::new(
                options.is_attended() || options.monkey.is_some(),
            ))
            .insert_resource(picture::motion::Motion::new(
                options.is_attended() || options.is_measured() || options.monkey.is_some(),
            ))
            .init_resource::<picture::resolution::PicturePlace>()
            .init_resource::<window::dropping::DroppedFiles>()
            .init_resource::<session::history::History>()
            .init_resource::<picture::noise_trend::NoiseTrend>()
            .init_resource::<picture::paths::PathInspector>()
            .init_resource::<command::selection::Selection>()
            .init_resource::<CommandQueue>()
            .init_resource::<command::light_mix::LightMix>()
            .init_resource::<command::light_mix::FilmLights>()
            .init_resource::<picture::compare::Comparison>()
            .init_resource::<picture::baking::Baking>()
            .init_resource::<command::baking::BakePlan>()
            .init_resource::<model::EditorModel>()
            .init_resource::<model::leaks::Leaks>()
            .init_resource::<model::thumbnails::Thumbnails>()
            .init_resource::<window::preview::Previews>()
            .init_resource::<window::assets::AssetWork>()
            .insert_resource(session::picture_cache::PictureCache::of_user(options.is_attended()))
            .init_resource::<window::dialogs::Dialogs>()
            .init_resource::<picture::frame_times::FrameTimes>()
            .insert_resource(picture::pacing::Pacing::new(options.undrawn))
            .insert_resource(picture::denoiser::Denoiser::new())
            .insert_resource(picture::carrying::Carrying::new(
                options.is_attended() || options.is_measured() || options.monkey.is_some(),
            ))
            .insert_resource(OpeningPace(Some(LONGEST_OPENING)))
            .insert_resource(SceneDefines(options.defines.clone()))
            .insert_resource(BegunWith::new(options))
            .insert_resource(WantedCamera {
                name: options.camera.clone(),
                is_required: !options.is_attended(),
            })
            .insert_resource(automation::exit_door::ExitDoor::new(
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
                    picture::texture::create_picture,
                    picture::pacing::connect_wake_up,
                    model::gather::load_presets,
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
                PreUpdate,
                commands::scene_watch::hold_reloads.before(SceneSystems::Apply),
            )
            .add_systems(
                PreUpdate,
                session::recovery::look_again.run_if(on_message::<WindowFocused>),
            )
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
                PostUpdate,
                (
                    (
                        commands::scene_watch::measure_scene,
                        commands::fitting::tell_sizes.run_if(resource_changed::<PackedScene>),
                        model::outline::gather_outline,
                        model::leaks::find_leaks,
                        picture::paths::follow_paths,
                        model::inspection::gather_selection,
                        model::thumbnails::update_thumbnails,
                        picture::noise_trend::follow_noise,
                        model::gather::gather_status,
                        model::timeline::gather_timeline,
                        model::gather_bake::gather_bake,
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
                        viewport::outlining::request_outline,
                        window::preview::update_previews,
                        window::assets::update_assets,
                        picture::pacing::hold_back_frame,
                    )
                        .chain()
                        .in_set(EditorSystems::Show),
                ),
            )
            .add_systems(PostUpdate, commands::baking::follow.after(EngineSystems::Report))
            .add_systems(
                EguiPrimaryContextPass,
                (
                    window::style::set_styles.run_if(run_once),
                    window::style::follow_preferences,
                    window::ui::show_window,
                )
                    .chain(),
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
        picture::frame_times::time_drawing(app);
        if let Some(moves) = options.measure_latency {
            app.insert_resource(automation::latency::LatencyProbe::new(moves))
                .add_systems(
                    First,
                    automation::latency::begin_frame.after(picture::frame_times::time_frames),
                )
                .add_systems(
                    Last,
                    automation::latency::end_frame.after(picture::frame_times::time_systems),
                )
                .add_systems(
                    PostUpdate,
                    (
                        automation::latency::act_for_probe
                            .before(EditorSystems::Apply)
                            .after(EguiPostUpdateSet::EndPass),
                        automation::latency::watch_probe.after(EditorSystems::Show),
                    ),
                );
        }
        if let Some(settling) = &options.measure_settling {
            automation::settling::add_to(app, settling, options.scene.as_deref());
        }
        match monkey {
            Ok(Some(monkey)) => automation::monkey::add_to(app, monkey),
            Ok(None) => {}
            Err(error) => {
                eprintln!("error: the monkey's files cannot be written: {error}");
                app.add_systems(Startup, |mut exit: MessageWriter<AppExit>| {
                    exit.write(AppExit::error());
                });
            }
        }
        if let Some(path) = &options.script {
            match automation::script::Script::read(path) {
                Ok(script) => {
                    app.insert_resource(script).add_systems(
                        PostUpdate,
                        automation::script::run_script
                            .before(EditorSystems::Apply)
                            .after(EguiPostUpdateSet::EndPass),
                    );
                }
                Err(error) => {
                    terminal::line(format_args!("error: {error}"));
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

/// egui is drawn by a camera; it sees nothing else. egui smooths its edges itself: multisampling would only cost, on a
/// software driver most of a frame's time.
fn spawn_camera(mut commands: Commands) {
    commands.spawn((Camera2d, Msaa::Off));
}
