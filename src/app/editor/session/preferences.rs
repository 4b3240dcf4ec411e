//! Stores the preferences between runs, in one JSON file of the platform's folder for settings. It has no data of
//! scenes.
//!
//! Fields of later versions are kept. A file that cannot be parsed is renamed, never overwritten.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use bevy::prelude::*;
use bevy::tasks::futures::check_ready;
use bevy::tasks::{IoTaskPool, Task, TaskPool, block_on};
use bevy::window::PrimaryWindow;
use directories::ProjectDirs;

use super::layout::Layout;
use super::options::BegunWith;
use super::view_settings::ViewSettings;
use super::window_place;
use crate::app::editor::command::preferences::{Preferences, WindowPlace};
use crate::files::{self, LARGEST_NOTE, write_atomically};
use crate::scene::{SceneState, SceneStatus};

const FILE: &str = "preferences.json";
/// The environment variable for a folder in place of the platform's.
const FOLDER_VARIABLE: &str = "SUNROOM_CONFIG";
/// The longest time before changes are written.
const PAUSE: Duration = Duration::from_secs(2);

/// The file of the preferences.
#[derive(Resource, Debug)]
pub struct PreferencesFile {
    /// The path of the file. None: nothing is remembered.
    path: Option<PathBuf>,
    /// Whether they are never written, because there is no user.
    is_only_read: bool,
    written: Preferences,
    /// The write in progress, on another thread because the disk may be busy.
    writing: Option<Task<std::io::Result<()>>>,
    looked_at: Instant,
    /// A problem with the file, in words.
    pub problem: Option<String>,
}

/// The folder for settings; None where the platform has none, and for windows without a user, unless one is named.
pub fn folder(attended: bool) -> Option<PathBuf> {
    match std::env::var_os(FOLDER_VARIABLE).filter(|folder| !folder.is_empty()) {
        Some(folder) => Some(folder.into()),
        None if attended => Some(ProjectDirs::from("", "", "sunroom")?.config_dir().to_owned()),
        None => None,
    }
}

/// The stored place of the window, from the preferences in this folder.
pub(super) fn window_place(folder: &Path) -> Option<WindowPlace> {
    window_place::read(folder, FILE)
}

impl PreferencesFile {
    /// Reads the file in this folder; without one, the preferences are the defaults.
    pub fn open(folder: Option<&Path>) -> (Self, Preferences) {
        Self::open_as(folder, false)
    }

    /// The same for a window without a user: the file is never written nor renamed.
    pub fn open_only_read(folder: Option<&Path>) -> (Self, Preferences) {
        Self::open_as(folder, true)
    }

    fn open_as(folder: Option<&Path>, is_only_read: bool) -> (Self, Preferences) {
        let mut file = Self {
            path: folder.map(|folder| folder.join(FILE)),
            is_only_read,
            written: Preferences::default(),
            writing: None,
            looked_at: Instant::now(),
            problem: None,
        };
        let text = file.path.as_ref().map(|path| files::read_text(path, LARGEST_NOTE));
        let read = match text {
            None => return (file, Preferences::default()),
            Some(Err(error)) if error.is_not_found() => {
                return (file, Preferences::default());
            }
            Some(Err(error)) => Err(error.to_string()),
            Some(Ok(text)) => serde_json::from_str(&text).map_err(|error| error.to_string()),
        };
        match read.map(Preferences::within_range) {
            Ok(preferences) => file.written = preferences,
            Err(reason) if is_only_read => {
                let said =
                    |path: &PathBuf| format!("{}: {reason}. The preferences are as in the beginning.", path.display());
                file.problem = file.path.as_ref().map(said);
            }
            Err(reason) => file.set_aside(&reason),
        }
        let preferences = file.written.clone();
        (file, preferences)
    }

    fn set_aside(&mut self, reason: &str) {
        let Some(path) = &self.path else {
            return;
        };
        let numbered = (2..1000).map(|number| format!("bad-{number}"));
        let names = std::iter::once("bad".to_owned()).chain(numbered);
        let free = names.map(|name| path.with_extension(format!("json.{name}")));
        let outcome = match free.into_iter().find(|place| !place.exists()) {
            Some(place) => std::fs::rename(path, &place).map(|()| place),
            None => Err(std::io::ErrorKind::AlreadyExists.into()),
        };
        let file = path.display();
        self.problem = Some(match outcome {
            Ok(place) => format!(
                "{file}: {reason}. It is {} now, and the preferences are as in the beginning.",
                place.display()
            ),
            Err(error) => {
                let problem =
                    format!("{file}: {reason}. It cannot be set aside ({error}): no preferences are remembered.");
                self.path = None;
                problem
            }
        });
    }

    /// Writes the preferences if they differ from those in the file.
    pub fn store(&mut self, preferences: Preferences) {
        self.finish();
        self.begin_to_store(preferences);
        self.finish();
    }

    /// Begins to write them on another thread. No other write may run meanwhile.
    fn begin_to_store(&mut self, preferences: Preferences) {
        let is_changed = preferences != self.written && !self.is_only_read;
        let Some(path) = self.path.clone().filter(|_| is_changed) else {
            return;
        };
        let text = serde_json::to_vec_pretty(&preferences);
        let writing = async move {
            std::fs::create_dir_all(path.parent().unwrap_or(Path::new(".")))?;
            write_atomically(&path, text?)
        };
        self.writing = Some(IoTaskPool::get_or_init(TaskPool::default).spawn(writing));
        // After a failure the next write waits for another change.
        self.written = preferences;
    }

    /// Whether no write is running. Notes the result of the last one.
    fn is_idle(&mut self) -> bool {
        match self.writing.as_mut().map(check_ready) {
            None => true,
            Some(None) => false,
            Some(Some(outcome)) => {
                self.ended(outcome);
                true
            }
        }
    }

    /// Waits for the end of the running write.
    fn finish(&mut self) {
        if let Some(writing) = self.writing.take() {
            let outcome = block_on(writing);
            self.ended(outcome);
        }
    }

    fn ended(&mut self, outcome: std::io::Result<()>) {
        self.writing = None;
        if let (Err(error), Some(path)) = (outcome, &self.path) {
            self.problem = Some(format!("{}: {error}", path.display()));
        }
    }
}

/// Adds a scene that was opened or saved to the recent ones, unless the program has chosen it.
pub(crate) fn note_scene(
    status: Res<SceneStatus>,
    begun_with: Option<Res<BegunWith>>,
    mut preferences: ResMut<Preferences>,
) {
    if !status.is_changed() || status.state != SceneState::Ready {
        return;
    }
    if let Some(path) = &status.path
        && begun_with.is_none_or(|begun| begun.0.as_ref() != Some(path))
        && preferences.recent_files.first() != Some(path)
    {
        preferences.note_recent(path);
    }
}

/// Writes changed preferences after a pause and at the end.
pub(crate) fn remember(
    mut file: ResMut<PreferencesFile>,
    preferences: Res<Preferences>,
    layout: Res<Layout>,
    settings: Res<ViewSettings>,
    windows: Query<&Window, With<PrimaryWindow>>,
    mut exits: MessageReader<AppExit>,
) {
    let ends = exits.read().next().is_some();
    if file.path.is_none() || (!ends && file.looked_at.elapsed() < PAUSE) {
        return;
    }
    let silent = file.bypass_change_detection();
    silent.looked_at = Instant::now();
    let problem = silent.problem.clone();
    let now = Preferences {
        layout: layout.to_json(),
        // At the end the window may be closed already.
        window: windows
            .single()
            .ok()
            .and_then(WindowPlace::of)
            .or(silent.written.window),
        speed: settings.navigation.speed,
        steps: settings.gizmo.steps,
        resolution: settings.resolution,
        enlarging: settings.enlarging,
        snapping: settings.gizmo.snap,
        grid: settings.grid,
        dimensions: settings.dimensions,
        ..preferences.clone()
    };
    if ends {
        silent.store(now);
    } else if silent.is_idle() {
        silent.begin_to_store(now);
    }
    if silent.problem != problem {
        file.set_changed();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::editor::command::gizmo_settings::Steps;
    use crate::app::editor::command::panel::Panel;
    use crate::app::editor::command::preferences::{MOST_MEMORY_GIB, MOST_RECENT_FILES, ThemeChoice};
    use crate::memory;
    use crate::render::tonemap::ToneMap;

    fn written(folder: &Path, text: &str) -> PathBuf {
        let path = folder.join(FILE);
        std::fs::write(&path, text).expect("a temporary folder");
        path
    }

    #[test]
    fn only_a_scene_that_the_user_has_chosen_is_a_recent_one() {
        let mut world = World::new();
        world.init_resource::<Preferences>();
        world.insert_resource(BegunWith(Some("/scenes/box.xml".into())));
        let note = |world: &mut World, path: &str| {
            world.insert_resource(SceneStatus {
                state: SceneState::Ready,
                path: Some(path.into()),
                ..SceneStatus::default()
            });
            world.run_system_cached(note_scene).expect("it runs");
            world.resource::<Preferences>().recent_files.clone()
        };
        assert_eq!(note(&mut world, "/scenes/box.xml"), [] as [PathBuf; 0]);
        assert_eq!(
            note(&mut world, "/scenes/room.xml"),
            ["/scenes/room.xml"].map(PathBuf::from)
        );
        world.insert_resource(BegunWith(None));
        assert_eq!(note(&mut world, "/scenes/box.xml").len(), 2);
    }

    #[test]
    fn they_come_back_with_what_is_not_understood() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        written(
            folder.path(),
            r#"{"theme": "light", "of tomorrow": [1, 2], "ui_scale": 99.0}"#,
        );
        let (mut file, preferences) = PreferencesFile::open(Some(folder.path()));
        assert_eq!((preferences.theme, preferences.ui_scale), (ThemeChoice::Light, 3.0));
        assert_eq!(preferences.autosave_seconds, 60);
        let mut layout = Layout::default();
        layout.close(Panel::History);
        let steps = Steps {
            length: Some(0.25),
            degrees: 5.0,
            ..Steps::default()
        };
        let mut changed = Preferences {
            layout: layout.to_json(),
            speed: 2.5,
            steps,
            moving_scale: 0.25,
            reduced_motion: true,
            memory_gib: 3,
            ..preferences
        };
        changed.note_recent(Path::new("/a.xml"));
        file.store(changed.clone());
        let (file, back) = PreferencesFile::open(Some(folder.path()));
        assert_eq!((back.clone(), file.problem), (changed, None));
        assert_eq!(back.memory_limit(), 3 << 30);
        assert_eq!(Preferences::default().memory_limit(), memory::default_limit());
        assert!(!Layout::remembered(&back).has(Panel::History) && Layout::remembered(&back).has(Panel::Render));
        let text = std::fs::read_to_string(folder.path().join(FILE)).expect("just written");
        assert!(text.contains("of tomorrow"), "{text}");
    }

    #[test]
    fn new_preferences_have_a_soft_shoulder_and_older_ones_stay_as_they_were() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let (mut file, new) = PreferencesFile::open(Some(folder.path()));
        assert_eq!(new.tone_map, ToneMap::AgX);
        file.store(Preferences { speed: 2.0, ..new });
        let (_, back) = PreferencesFile::open(Some(folder.path()));
        assert_eq!(back.tone_map, ToneMap::AgX);
        for text in [r#"{"speed": 2.0}"#, r#"{"tone_map": "of tomorrow"}"#] {
            written(folder.path(), text);
            let (file, old) = PreferencesFile::open(Some(folder.path()));
            assert_eq!((old.tone_map, file.problem), (ToneMap::Clip, None), "{text}");
        }
    }

    #[test]
    fn numbers_that_no_control_could_set_are_mended() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let text = r#"{"steps": {"length": -2.0, "degrees": 1e9, "factor": 0.0}, "moving_scale": 0.0, "memory_gib": 4000000000}"#;
        written(folder.path(), text);
        let (_, preferences) = PreferencesFile::open(Some(folder.path()));
        let Steps {
            length,
            degrees,
            factor,
        } = preferences.steps;
        assert_eq!((length, degrees, factor), (None, 180.0, 0.001));
        assert_eq!(preferences.moving_scale, 0.25);
        assert_eq!(preferences.memory_gib, MOST_MEMORY_GIB);
    }

    #[test]
    fn a_word_of_a_later_version_costs_no_other_preference() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for text in [
            r#""theme": "sepia""#,
            r#""navigation": "of tomorrow""#,
            r#""resolution": "eighth""#,
            r#""enlarging": 7"#,
            r#""snapping": {"to": "centres", "always": true}"#,
            r#""window": {"size": "large"}"#,
            r#""tone_map": null"#,
            r#""keys": {"save": "F6", "undo": 7}"#,
            r#""keys": null"#,
        ] {
            written(folder.path(), &format!(r#"{{{text}, "speed": 2.5}}"#));
            let (file, preferences) = PreferencesFile::open(Some(folder.path()));
            assert_eq!((preferences.speed, file.problem), (2.5, None), "{text}");
            assert_eq!(preferences.snapping.always, text.contains("always"));
        }
    }

    #[test]
    fn a_broken_file_is_set_aside_and_said() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for (text, name) in [
            ("{\"theme\": \"dark\"", "preferences.json.bad"),
            ("{\"speed\": \"fast\"}", "preferences.json.bad-2"),
        ] {
            let path = written(folder.path(), text);
            let (mut file, preferences) = PreferencesFile::open(Some(folder.path()));
            assert_eq!(preferences, Preferences::default());
            assert!(file.problem.as_ref().is_some_and(|problem| problem.contains(name)));
            assert!(!path.exists());
            let kept = std::fs::read_to_string(folder.path().join(name)).expect("set aside");
            assert_eq!(kept, text);
            file.store(Preferences {
                speed: 2.0,
                ..preferences
            });
            assert!(path.exists());
        }
    }

    #[test]
    fn windows_without_a_user_change_no_preferences() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = written(folder.path(), r#"{"speed": 2.5}"#);
        let before = std::fs::read(&path).expect("it is there");
        for is_attended in [false, true] {
            let (mut file, preferences) = PreferencesFile::open_as(Some(folder.path()), !is_attended);
            assert_eq!(preferences.speed, 2.5);
            file.store(Preferences {
                denoising: !preferences.denoising,
                ..preferences
            });
            let after = std::fs::read(&path).expect("it is there");
            assert_eq!(after != before, is_attended);
        }
    }

    #[test]
    fn windows_without_a_user_leave_a_broken_file_where_it_is() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let text = r#"{"speed": "fast"}"#;
        let path = written(folder.path(), text);
        let (mut file, preferences) = PreferencesFile::open_only_read(Some(folder.path()));
        assert_eq!(preferences, Preferences::default());
        let problem = file.problem.clone().expect("it is said");
        assert!(problem.contains(FILE) && problem.contains("fast"), "{problem}");
        file.store(Preferences {
            speed: 2.0,
            ..preferences
        });
        assert_eq!(std::fs::read_to_string(&path).expect("it is there"), text);
        assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 1);
    }

    #[test]
    fn without_a_folder_nothing_is_remembered() {
        let (mut file, preferences) = PreferencesFile::open(None);
        file.store(Preferences {
            speed: 2.0,
            ..preferences
        });
        assert_eq!(file.problem, None);
    }

    #[test]
    fn recent_files_are_few_and_each_is_there_once() {
        let mut preferences = Preferences::default();
        for number in (0..15).chain([12]) {
            preferences.note_recent(Path::new(&format!("/{number}.xml")));
        }
        let files: Vec<_> = preferences.recent_files.iter().map(|path| path.to_str()).collect();
        assert_eq!(files.len(), MOST_RECENT_FILES);
        assert_eq!(files[..3], [Some("/12.xml"), Some("/14.xml"), Some("/13.xml")]);
    }
}
