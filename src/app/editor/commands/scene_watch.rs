//! The editor's response to a scene that has been opened or read again.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use bevy::prelude::*;

use crate::app::editor::camera::navigation::up_axis;
use crate::app::editor::camera::picking;
use crate::app::editor::command::Command;
use crate::app::editor::command::light_mix::{FilmLights, LightMix};
use crate::app::editor::command::light_paint::LightPainting;
use crate::app::editor::command::panel::Panel;
use crate::app::editor::command::seeing::Seeing;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::command::shell::{Sheet, ShellCommand};
use crate::app::editor::picture::compare::Comparison;
use crate::app::editor::picture::paths::PathInspector;
use crate::app::editor::session::history::History;
use crate::app::editor::session::options::WantedCamera;
use crate::app::editor::session::recovery::Recovery;
use crate::app::editor::session::requests::Requests;
use crate::app::editor::session::toasts::{Toasts, Tone, Topic};
use crate::app::editor::session::trust::TrustedFolders;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::app::editor::words::files::gone;
use crate::document::Severity;
use crate::engine::{PackedScene, RenderControl, SightControl};
use crate::math::Ray;
use crate::scene::listed::listed;
use crate::scene::{
    ActiveSensor, FileReadAgain, FreeView, SceneFile, SceneState, SceneStatus, Sensor, ToWorld, find_camera,
};

/// Holds changes of the scene's file back while the user is asked about them, and while it is being saved.
pub(crate) fn hold_reloads(requests: Res<Requests>, history: Res<History>, mut file: ResMut<SceneFile>) {
    let holds = requests.save_question.is_some() || history.is_saving();
    if file.is_held() != holds {
        file.hold(holds);
    }
}

/// Shows messages about loading. For a freshly opened scene it also decides which axis is up.
pub fn follow_scene(
    status: Res<SceneStatus>,
    active: Res<ActiveSensor>,
    poses: Query<&ToWorld>,
    mut settings: ResMut<ViewSettings>,
    mut requests: ResMut<Requests>,
    mut toasts: ResMut<Toasts>,
    mut selection: ResMut<Selection>,
    mut history: ResMut<History>,
    mut free_view: ResMut<FreeView>,
    (mut mix, mut film_lights, mut painting, mut comparison): (
        ResMut<LightMix>,
        ResMut<FilmLights>,
        Option<ResMut<LightPainting>>,
        Option<ResMut<Comparison>>,
    ),
    mut paths: ResMut<PathInspector>,
    mut control: ResMut<RenderControl>,
    recovery: Res<Recovery>,
    mut trusted: Option<ResMut<TrustedFolders>>,
    mut seen: Local<(u64, u64)>,
    mut was_asked: Local<bool>,
) {
    // A user who asked for a reload also gets a message if nothing has changed.
    let is_answer = std::mem::replace(&mut *was_asked, status.state == SceneState::Loading);
    if *seen == (status.revision, status.failures) {
        return;
    }
    let before = std::mem::replace(&mut *seen, (status.revision, status.failures));
    // The permission was for this load alone, whatever its result.
    let news = trusted.as_mut().and_then(|trusted| trusted.take_news());
    let file = status.path.as_deref().map(name_of).unwrap_or_default();
    if status.revision != before.0 {
        toasts.forget(Topic::SceneFile);
        if status.fresh_load {
            let pose = active.0.and_then(|sensor| poses.get(sensor).ok());
            settings.navigation.up = pose.map_or(Vec3::Y, |pose| up_axis(&pose.0));
            *selection = Selection::default();
            *free_view = FreeView::default();
            history.clear();
            // All of these questions belong to the previous scene.
            requests.save_question = None;
            requests.full_film_question = None;
            requests.scene_question = None;
            requests.imported.clear();
            settings.bookmarks = Default::default();
            settings.rulers.clear();
            settings.building_step = None;
            settings.seeing = Seeing {
                wireframe: settings.seeing.wireframe,
                ..Seeing::default()
            };
            settings.isolated.clear();
            settings.walks = false;
            if control.sight != SightControl::default() {
                control.sight = SightControl::default();
            }
            (*mix, *film_lights) = Default::default();
            if let Some(painting) = &mut painting {
                **painting = LightPainting::default();
            }
            if let Some(comparison) = &mut comparison {
                comparison.leave_scene();
            }
            paths.wanted = None;
            if control.region.is_some() {
                control.region = None;
            }
            if status.path.is_some() && !recovery.is_returning() {
                toasts.info(format!("Opened {file}"));
            }
        } else {
            let has_news = news.is_some();
            if let Some(news) = news {
                toasts.info(news);
            }
            let changed: Vec<String> = status.files_read_again.iter().map(|path| name_of(path)).collect();
            let files = match changed.is_empty() {
                true => file,
                false => listed(&changed, MOST_NAMED),
            };
            if !status.reload.is_unchanged() {
                toasts.info(format!("Reloaded {files}: {}", status.reload.text()));
            } else if is_answer && !has_news {
                toasts.info(format!("Reloaded {files}: nothing new in it"));
            }
        }
    }
    if status.failures != before.1 {
        let path = status.subject().unwrap_or(Path::new(""));
        let diagnostics = &status.diagnostics;
        let mut errors = diagnostics.list.iter();
        let first = errors.find(|diagnostic| diagnostic.severity == Severity::Error);
        let message = failure(path, status.revision > 0);
        let (message, excerpt) = match first {
            Some(first) => (format!("{message}: {}", first.message), diagnostics.excerpt(first)),
            None => (message, None),
        };
        toasts.error(Topic::SceneFile, message, excerpt);
        requests.wanted_panel = Some(Panel::Messages);
    }
}

/// Messages about meshes and pictures that were read again or could not be, and about files that are not there any
/// more.
pub fn follow_files(
    mut read_again: MessageReader<FileReadAgain>,
    status: Res<SceneStatus>,
    mut toasts: ResMut<Toasts>,
    mut known: Local<FileTroubles>,
) {
    for FileReadAgain(path) in read_again.read() {
        toasts.info(format!("Reloaded {}", name_of(path)));
    }
    if !status.is_changed() {
        return;
    }
    let mut troubles = FileTroubles::of(&status);
    if !status.is_opening && status.files_loading() == 0 && known.missing != troubles.missing {
        toasts.forget(Topic::MissingFiles);
        if let Some(message) = missing(&troubles.missing) {
            let list = Command::Shell(ShellCommand::ShowSheet(Sheet::Missing));
            toasts.keep_offering((Tone::Warning, Topic::MissingFiles), message, "Find…", list);
        }
    } else {
        // Files that are being read now are reported with the last one.
        troubles.missing.clone_from(&known.missing);
    }
    for path in troubles.gone.iter().filter(|path| !known.gone.contains(path)) {
        toasts.warn(gone(path));
    }
    let mut unreadable = troubles
        .unreadable
        .iter()
        .filter(|text| !known.unreadable.contains(text));
    if let Some(first) = unreadable.next() {
        let others = match unreadable.count() {
            0 => String::new(),
            count => format!(" (and {count} more)"),
        };
        // The log has it already.
        toasts.add(Tone::Warning, Topic::Other, format!("{first}{others}"), None);
    }
    *known = troubles;
}

/// The missing and broken files that messages were shown about.
#[derive(Default)]
pub struct FileTroubles {
    gone: Vec<PathBuf>,
    missing: Vec<PathBuf>,
    unreadable: Vec<String>,
}

impl FileTroubles {
    fn of(status: &SceneStatus) -> Self {
        let of_meshes = status.mesh_errors.iter();
        let all = of_meshes
            .chain(&status.volume_errors)
            .chain(&status.picture_problems)
            .chain(&status.damaged_pictures)
            .filter(|problem| problem.missing.is_none());
        // Things of several kinds may name one file.
        let mut known = HashSet::new();
        let missing = status.missing_files().map(|problem| problem.path.clone());
        Self {
            gone: status.files_gone.clone(),
            missing: missing.filter(|path| known.insert(path.clone())).collect(),
            unreadable: all.map(|problem| problem.message.clone()).collect(),
        }
    }
}

/// Whether a camera was asked for, and there is a scene to look for it in.
pub(crate) fn camera_is_wanted(wanted: Res<WantedCamera>, status: Res<SceneStatus>) -> bool {
    wanted.name.is_some() && status.revision > 0
}

/// Looks through the requested camera.
pub(crate) fn choose_camera(world: &mut World) {
    let mut wanted = world.resource_mut::<WantedCamera>();
    let (name, is_required) = (wanted.name.take(), wanted.is_required);
    let Some(name) = name else {
        return;
    };
    match find_camera(world, &name) {
        Ok(camera) => world.insert_resource(ActiveSensor(Some(camera))),
        Err(error) => {
            world
                .resource_mut::<Toasts>()
                .error(Topic::Other, error.to_string(), None);
            if is_required {
                world.write_message(AppExit::error());
            }
        }
    }
}

/// The most files that a message names.
const MOST_NAMED: usize = 5;

/// The message about all files that are missing; None if there are none.
fn missing(files: &[PathBuf]) -> Option<String> {
    let names: Vec<String> = files.iter().map(|path| name_of(path)).collect();
    let listed = listed(&names, MOST_NAMED);
    match names.len() {
        0 => None,
        1 => Some(format!("A file of the scene is missing: {listed}")),
        count => Some(format!("{count} files of the scene are missing: {listed}")),
    }
}

/// The name of a file without its folder.
fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn failure(path: &Path, has_good_scene: bool) -> String {
    let path = path.display();
    if has_good_scene {
        format!("{path} could not be read; the last good scene is shown")
    } else {
        format!("{path} could not be read")
    }
}

/// Keeps the size that flying and steps are scaled by. It depends on nothing but the scene, so that a scene has the
/// same steps however it was opened. Edits change it only if the scene grows or shrinks much, so that a step that was
/// just used stays.
pub fn measure_scene(
    packed: Res<PackedScene>,
    active: Res<ActiveSensor>,
    sensors: Query<(&Sensor, &ToWorld)>,
    history: Res<History>,
    mut settings: ResMut<ViewSettings>,
) {
    let camera = active.0.and_then(|sensor| sensors.get(sensor).ok());
    let (size, kept) = (size_of_scene(&packed, camera), settings.navigation.scene_size);
    let is_edited = history.len() != (0, 0);
    let is_alike = (1.0 / LEAST_CHANGE..LEAST_CHANGE).contains(&(size / kept));
    if size.is_finite() && size > 0.0 && size != kept && !(is_edited && is_alike) {
        settings.navigation.scene_size = size;
    }
}

/// The size of everything with the camera, since a first small thing is not all there will be. A floor of a kilometre
/// must not let one key press fly past a still life on it, so that the distance of the camera's target limits the size;
/// and a camera with a long lens may be far away.
fn size_of_scene(packed: &PackedScene, camera: Option<(&Sensor, &ToWorld)>) -> f32 {
    let Some(bounds) = picking::scene_bounds(packed) else {
        return NEW_SCENE;
    };
    let size = bounds.extent().length();
    let Some((sensor, ToWorld(pose))) = camera else {
        return size;
    };
    let place = Vec3::from(pose.translation);
    let axis = Ray {
        t_min: sensor.near_clip,
        ..Ray::new(place, Vec3::from(pose.matrix3.z_axis).normalize_or_zero())
    };
    let ahead = picking::surface(packed, &axis, |_| false);
    let ahead = ahead.map_or(f32::INFINITY, |seen| seen.position.distance(place));
    let with_camera = bounds.grown(place).extent().length();
    with_camera.min(MOST_WITH_CAMERA * size).min(SIZE_PER_DISTANCE * ahead)
}

/// The size of a scene without anything in it, in world units.
const NEW_SCENE: f32 = 5.0;

/// The factor by which edits have to change the size before it is updated.
const LEAST_CHANGE: f32 = 2.0;

/// The size of a scene relative to the distance of the camera's target: a target is about as large as it is far, with
/// something around it.
const SIZE_PER_DISTANCE: f32 = 2.0;

/// The most that the camera adds to the size of everything.
const MOST_WITH_CAMERA: f32 = 4.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{DocumentOrder, FileKind, FileProblem, SceneId};

    #[test]
    fn a_file_that_is_missing_for_two_things_is_named_once() {
        let problem = |name: &str, kind| FileProblem {
            path: name.into(),
            span: None,
            what: String::new(),
            message: String::new(),
            help: None,
            missing: Some(kind),
        };
        let status = SceneStatus {
            mesh_errors: vec![problem("a", FileKind::Mesh), problem("b", FileKind::Mesh)],
            picture_problems: vec![problem("a", FileKind::Picture)],
            ..SceneStatus::default()
        };
        let troubles = FileTroubles::of(&status);
        assert_eq!(
            missing(&troubles.missing).as_deref(),
            Some("2 files of the scene are missing: a and b")
        );
    }

    #[test]
    fn a_camera_that_is_not_there_is_an_error() {
        for (name, is_required, is_error, ends) in [
            ("top", true, false, false),
            ("tpo", false, true, false),
            ("tpo", true, true, true),
        ] {
            let mut world = World::new();
            world.init_resource::<ViewSettings>();
            world.init_resource::<Requests>();
            world.init_resource::<Toasts>();
            world.init_resource::<Messages<AppExit>>();
            world.spawn((
                DocumentOrder(0),
                SceneId("top".to_owned()),
                Name::new("top"),
                Sensor::default(),
            ));
            world.insert_resource(WantedCamera {
                name: Some(name.to_owned()),
                is_required,
            });
            choose_camera(&mut world);
            let texts: Vec<String> = world.resource::<Toasts>().texts().map(str::to_owned).collect();
            assert_eq!(texts.iter().any(|text| text.contains("tpo")), is_error, "{texts:?}");
            assert_eq!(!world.resource::<Messages<AppExit>>().is_empty(), ends);
        }
    }
}
