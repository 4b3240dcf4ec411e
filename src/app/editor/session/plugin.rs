//! The state of the session as resources, with the preferences of the user.

use std::path::{Path, PathBuf};

use bevy::prelude::*;
use bevy::window::WindowFocused;

use super::history::History;
use super::kept_picture::KeptPictures;
use super::layout::Layout;
use super::options::{BegunWith, SceneDefines, WantedCamera, WindowOptions};
use super::picture_cache::PictureCache;
use super::preferences::PreferencesFile;
use super::recovery::{self, Recovery};
use super::requests::{CommandQueue, Requests};
use super::toasts::{Toasts, Topic};
use super::trust::TrustedFolders;
use super::tutorial::Tutorial;
use super::view_settings::ViewSettings;
use super::views_file::ViewsFile;
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::command::resolution::Resolution;
use crate::app::editor::command::shell::Sheet;
use crate::memory;
use crate::scene::SceneAccess;

/// Adds the resources of the session.
pub(crate) struct SessionPlugin {
    /// The options of the window.
    pub options: WindowOptions,
    /// The folder of the preferences and other remembered files; None if nothing is remembered.
    pub folder: Option<PathBuf>,
}

impl Plugin for SessionPlugin {
    fn build(&self, app: &mut App) {
        let options = &self.options;
        let folder = self.folder.as_deref();
        let is_attended = options.is_attended();
        let open = match is_attended || options.monkey.is_some() {
            true => PreferencesFile::open,
            false => PreferencesFile::open_only_read,
        };
        let (preferences_file, preferences) = open(folder);
        let mut toasts = Toasts::default();
        memory::budget().prefer_limit(preferences.memory_limit());
        if let Some(problem) = &preferences_file.problem {
            toasts.error(Topic::Other, problem, None);
        }
        // Without a user the question could not be answered.
        let (trusted_folders, trust) = match is_attended {
            true => TrustedFolders::open(folder),
            false => Default::default(),
        };
        let mut views_file = ViewsFile::new(folder);
        if is_attended {
            views_file = views_file.returning(options.camera.is_some());
        }
        let access = app.world_mut().get_resource_or_init::<SceneAccess>();
        access.set(trust.access(Path::new("")));
        app.insert_resource(settings(options, &preferences))
            .insert_resource(toasts)
            .insert_resource(Requests {
                sheet: (options.begins && is_attended && preferences.start_page).then_some(Sheet::Start),
                ..default()
            })
            .init_resource::<CommandQueue>()
            .init_resource::<History>()
            .init_resource::<Tutorial>()
            .insert_resource(Layout::remembered(&preferences))
            .insert_resource(preferences)
            .insert_resource(preferences_file)
            .insert_resource(trusted_folders)
            .insert_resource(trust)
            .insert_resource(Recovery::new(folder).asking(is_attended))
            .insert_resource(views_file)
            .insert_resource(KeptPictures::new(is_attended))
            .insert_resource(PictureCache::of_user(is_attended))
            .insert_resource(SceneDefines(options.defines.clone()))
            .insert_resource(BegunWith::new(options))
            .insert_resource(WantedCamera {
                name: options.camera.clone(),
                is_required: !is_attended,
            })
            .add_systems(PreUpdate, recovery::look_again.run_if(on_message::<WindowFocused>));
    }
}

/// The settings of the view at the start.
fn settings(options: &WindowOptions, preferences: &Preferences) -> ViewSettings {
    let mut settings = ViewSettings::default();
    settings.navigation.set_speed(preferences.speed);
    settings.gizmo.steps = preferences.steps;
    settings.gizmo.snap = preferences.snapping;
    settings.enlarging = preferences.enlarging;
    // Pictures that a script saves have the film's resolution, whatever the window's size.
    settings.resolution = match options.script {
        Some(_) => Resolution::Full,
        None => preferences.resolution,
    };
    settings.grid = preferences.grid;
    settings.dimensions = preferences.dimensions;
    // A script starts with the defaults, whatever a user prefers.
    if options.is_attended() {
        settings.display.tone_map = preferences.tone_map;
    }
    settings.denoising = options.denoise || options.is_attended() && preferences.denoising;
    settings
}
