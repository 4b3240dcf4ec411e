//! Stores views under the numbers 1 to 9 for each scene, the view that a scene was left with, and how its lightmaps are baked, in one file beside the preferences.
//!
//! They are not part of the scene's file, because looking at a scene and baking it are no edits.

use std::path::{Path, PathBuf};

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::toasts::Toasts;
use super::view_settings::ViewSettings;
use crate::app::editor::command::baking::BakePlan;
use crate::app::editor::command::lenient::or_default;
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::command::stored_view::{StoredView, StoredViews};
use crate::app::editor::command::timeline::Timeline;
use crate::files::{self, LARGEST_NOTE, write_atomically};
use crate::scene::{ActiveSensor, FreeView, Lens, SceneState, SceneStatus, Sensor, ToWorld};

/// The views of one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct SceneViews {
    /// The absolute path of the scene, without links.
    scene: PathBuf,
    views: StoredViews,
    /// The view that the scene was left with; None for that of its camera.
    #[serde(default)]
    last: Option<StoredView>,
    /// The frames of the timeline; None for the usual ones.
    #[serde(default)]
    timeline: Option<Timeline>,
    /// How its lightmaps are baked, and where to; None for the usual way.
    #[serde(default, deserialize_with = "or_default", skip_serializing_if = "Option::is_none")]
    bake: Option<BakePlan>,
}

const FILE: &str = "views.json";
/// The number of scenes whose views are remembered; those that were not open for longest are dropped.
const MOST_SCENES: usize = 100;

/// The file in which the views are kept.
#[derive(Resource, Debug, Default)]
pub struct ViewsFile {
    /// The path of the file. None: nothing is remembered.
    path: Option<PathBuf>,
    /// The path of the open scene, as in the file. None while the scene has no name.
    scene: Option<PathBuf>,
    /// The views of that scene, as in the file.
    written: StoredViews,
    /// The view that the scene was left with, as in the file.
    last_written: Option<StoredView>,
    /// The view of that scene now; None for that of its camera.
    last: Option<StoredView>,
    /// The frames of the timeline of that scene, as in the file.
    timeline: Timeline,
    /// How the lightmaps of that scene are baked.
    bake: BakePlan,
    /// The same, as in the file.
    bake_written: BakePlan,
    /// Whether scenes may begin with the view that they were left with, and with how they were baked.
    returns: bool,
    /// Whether the stored view stays in the file: the scene did not begin with it, and the user has not moved the view since.
    keeps_last: bool,
    /// The next scene begins with a camera that was asked for.
    begins_at_camera: bool,
}

impl ViewsFile {
    /// The stored views. `folder` is that of the preferences.
    pub fn new(folder: Option<&Path>) -> Self {
        Self {
            path: folder.map(|folder| folder.join(FILE)),
            ..Self::default()
        }
    }

    /// Lets scenes begin with how they were baked, and with the view that they were left with, except the first one if the user asked for a camera.
    pub fn returning(self, begins_at_camera: bool) -> Self {
        Self {
            returns: true,
            begins_at_camera,
            ..self
        }
    }

    /// The views of the scene in this file.
    fn open(&mut self, scene: &Path) -> StoredViews {
        let scene = canonical(scene);
        let all = self.path.as_deref().map_or(Vec::new(), read);
        let known = all.into_iter().find(|known| known.scene == scene);
        self.scene = Some(scene);
        let timeline = known.as_ref().and_then(|known| known.timeline);
        self.timeline = timeline.unwrap_or_default().within_range();
        let known = known.map(|known| (known.views, known.last, known.bake.unwrap_or_default()));
        (self.written, self.last, self.bake) = known.unwrap_or_default();
        self.last_written = self.last;
        self.bake_written.clone_from(&self.bake);
        self.written
    }

    /// Leaves the scene: its view and how it is baked are written.
    fn leave(&mut self) -> std::io::Result<()> {
        let outcome = match self.last == self.last_written && self.bake == self.bake_written {
            true => Ok(()),
            false => self.store(self.written),
        };
        (self.bake, self.bake_written) = Default::default();
        (self.scene, self.written) = (None, StoredViews::default());
        self.timeline = Timeline::default();
        (self.last, self.last_written, self.keeps_last) = (None, None, false);
        outcome
    }

    /// Stores the views of the open scene. Other windows may have written to the file in the meantime.
    fn store(&mut self, views: StoredViews) -> std::io::Result<()> {
        (self.written, self.last_written) = (views, self.last);
        self.bake_written.clone_from(&self.bake);
        let (Some(path), Some(scene)) = (&self.path, &self.scene) else {
            return Ok(());
        };
        let mut all = read(path);
        all.retain(|known| known.scene != *scene);
        // Names that JSON cannot hold are left out.
        let timeline = Some(self.timeline).filter(|timeline| *timeline != Timeline::default());
        let bake = Some(self.bake.clone()).filter(|bake| *bake != BakePlan::default());
        let is_empty = views == StoredViews::default() && self.last.is_none() && timeline.is_none() && bake.is_none();
        if !is_empty && scene.to_str().is_some() {
            let (scene, last) = (scene.clone(), self.last);
            let of_scene = SceneViews {
                scene,
                views,
                last,
                timeline,
                bake,
            };
            all.insert(0, of_scene);
        }
        all.truncate(MOST_SCENES);
        std::fs::create_dir_all(path.parent().unwrap_or(Path::new(".")))?;
        write_atomically(path, serde_json::to_vec(&all)?)
    }
}

fn canonical(path: &Path) -> PathBuf {
    path.canonicalize()
        .or_else(|_| std::path::absolute(path))
        .unwrap_or_else(|_| path.to_owned())
}

/// Reads the entries that can be understood. The others are lost when the next view is stored, and they hold nothing but views.
fn read(path: &Path) -> Vec<SceneViews> {
    let text = files::read_text(path, LARGEST_NOTE).unwrap_or_default();
    let all: Vec<serde_json::Value> = serde_json::from_str(&text).unwrap_or_default();
    let known = all.into_iter().filter_map(|one| serde_json::from_value(one).ok());
    known.map(without_nonsense).collect()
}

fn without_nonsense(mut of_scene: SceneViews) -> SceneViews {
    for place in of_scene.views.iter_mut().chain([&mut of_scene.last]) {
        *place = place.filter(|view| view.pose.is_finite() && view.pose.matrix3.determinant() != 0.0);
    }
    if let Some(bake) = &mut of_scene.bake {
        bake.choices = bake.choices.within_range();
    }
    of_scene
}

/// Reads the views of a scene that has been opened, and writes those that are stored.
pub fn follow_views(
    mut file: ResMut<ViewsFile>,
    mut settings: ResMut<ViewSettings>,
    mut toasts: ResMut<Toasts>,
    mut plan: Option<ResMut<BakePlan>>,
    status: Res<SceneStatus>,
    mut seen: Local<u64>,
) {
    let file = file.bypass_change_detection();
    let is_opened = *seen != status.revision && status.fresh_load;
    *seen = status.revision;
    // A script begins in the same way whatever a user has chosen, and leaves that as it is.
    let plan = plan.as_mut().filter(|_| file.returns);
    if let Some(plan) = &plan
        && ***plan != file.bake
    {
        // This still is of the scene before.
        file.bake = BakePlan::clone(plan);
    }
    let path = status.path.as_deref().filter(|_| status.state == SceneState::Ready);
    if is_opened && let Err(error) = file.leave() {
        warn!("The view is not remembered: {error}");
    }
    if is_opened {
        settings.playback.stop();
    }
    match path {
        Some(path) if is_opened => {
            settings.bookmarks = file.open(path);
            (settings.timeline, settings.timeline_shown) = (file.timeline, None);
        }
        None if is_opened => settings.timeline = file.timeline,
        // The scene was saved under this name.
        Some(path) if status.is_changed() => {
            let scene = Some(canonical(path));
            if file.scene != scene {
                file.scene = scene;
                file.written = StoredViews::default();
                // The file has no views of a scene of this name.
                (file.last_written, file.keeps_last) = (None, false);
                file.bake_written = BakePlan::default();
            }
        }
        _ => {}
    }
    if let Some(plan) = plan.filter(|_| is_opened) {
        **plan = file.bake.clone();
    }
    // While the user chooses numbers, nothing is written.
    let is_baked_elsewhere = file.bake.folder != file.bake_written.folder;
    let is_new = settings.bookmarks != file.written || settings.timeline != file.timeline || is_baked_elsewhere;
    file.timeline = settings.timeline;
    if is_new && let Err(error) = file.store(settings.bookmarks) {
        toasts.reject(format!("The view is not remembered: {error}"));
    }
}

/// A scene that has been opened begins with the view that it was left with, if the user prefers that. To be run after [`follow_views`].
pub fn return_to_view(
    mut file: ResMut<ViewsFile>,
    mut free_view: ResMut<FreeView>,
    mut toasts: ResMut<Toasts>,
    preferences: Res<Preferences>,
    status: Res<SceneStatus>,
    active: Res<ActiveSensor>,
    sensors: Query<&Sensor>,
    mut seen: Local<u64>,
) {
    let is_opened = *seen != status.revision && status.fresh_load;
    *seen = status.revision;
    if !is_opened || status.state != SceneState::Ready {
        return;
    }
    let file = file.bypass_change_detection();
    let returns = file.returns && !std::mem::take(&mut file.begins_at_camera);
    let view = file.last;
    let sensor = active.0.and_then(|sensor| sensors.get(sensor).ok());
    if let (Some(view), Some(sensor), true) = (view, sensor, returns && preferences.returns_to_views) {
        free_view.pose = Some(view.pose);
        free_view.lens = sensor.lens.for_projection(view.orthographic);
        toasts.info("The view is where it was left; View > Cameras has that of the file");
    } else {
        file.keeps_last = view.is_some();
    }
}

/// Notes the view, and writes it when the program ends.
pub fn note_view(
    mut file: ResMut<ViewsFile>,
    free_view: Res<FreeView>,
    active: Res<ActiveSensor>,
    sensors: Query<(&Sensor, &ToWorld)>,
    mut exits: MessageReader<AppExit>,
) {
    let file = file.bypass_change_detection();
    let sensor = active.0.and_then(|sensor| sensors.get(sensor).ok());
    let is_free = free_view.pose.is_some() || free_view.lens.is_some();
    file.keeps_last &= !is_free;
    if !file.keeps_last {
        file.last = sensor
            .filter(|_| is_free && file.scene.is_some())
            .map(|(sensor, pose)| StoredView {
                pose: free_view.pose.unwrap_or(pose.0),
                orthographic: free_view.lens.unwrap_or(sensor.lens) == Lens::Orthographic,
            });
    }
    if exits.read().next().is_some()
        && let Err(error) = file.leave()
    {
        warn!("The view is not remembered: {error}");
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::{Affine3A, Vec3};

    use super::*;
    use crate::app::editor::command::baking::BakeChoices;

    fn views(x: f32) -> StoredViews {
        let mut views = StoredViews::default();
        views[2] = Some(StoredView {
            pose: Affine3A::from_rotation_y(0.3) * Affine3A::from_translation(Vec3::new(x, 1e-7, -3.5)),
            orthographic: x > 50.0,
        });
        views
    }

    #[test]
    fn each_scene_has_its_own_and_they_come_back_exactly() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mut file = ViewsFile::new(Some(folder.path()));
        for (name, x) in [("a.xml", 1.0), ("b.xml", 60.0)] {
            assert_eq!(file.open(Path::new(name)), StoredViews::default());
            file.store(views(x)).expect("a writable folder");
        }
        let mut again = ViewsFile::new(Some(folder.path()));
        assert_eq!(again.open(Path::new("a.xml")), views(1.0));
        assert_eq!(
            again.open(&std::env::current_dir().expect("one").join("b.xml")),
            views(60.0)
        );
        again.store(StoredViews::default()).expect("a writable folder");
        assert_eq!(again.open(Path::new("b.xml")), StoredViews::default());
    }

    #[test]
    fn the_view_that_a_scene_was_left_with_comes_back() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let left = views(3.0)[2];
        let mut file = ViewsFile::new(Some(folder.path()));
        file.open(Path::new("a.xml"));
        file.last = left;
        let frames = Timeline {
            fps: 30.0,
            first: 5,
            last: 90,
        };
        file.timeline = frames;
        file.leave().expect("a writable folder");
        file.open(Path::new("b.xml"));
        assert_eq!((file.last, file.timeline), (None, Timeline::default()));
        file.leave().expect("a writable folder");
        // The file also has the views under numbers.
        file.open(Path::new("a.xml"));
        assert_eq!((file.last, file.timeline), (left, frames));
        file.store(views(60.0)).expect("a writable folder");
        let mut again = ViewsFile::new(Some(folder.path()));
        assert_eq!((again.open(Path::new("a.xml")), again.last), (views(60.0), left));
        // The camera of the file is looked through again.
        again.last = None;
        again.leave().expect("a writable folder");
        assert_eq!((file.open(Path::new("a.xml")), file.last), (views(60.0), None));
    }

    #[test]
    fn each_scene_has_its_own_way_to_be_baked() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let plan = |texels_per_unit| BakePlan {
            choices: BakeChoices {
                texels_per_unit,
                ..BakeChoices::default()
            },
            folder: Some(folder.path().join("level")),
        };
        let start = |is_attended: bool| {
            let mut world = World::new();
            let file = ViewsFile::new(Some(folder.path()));
            world.insert_resource(if is_attended { file.returning(false) } else { file });
            world.init_resource::<ViewSettings>();
            world.init_resource::<Toasts>();
            world.init_resource::<BakePlan>();
            world.init_resource::<SceneStatus>();
            world
        };
        let open = |world: &mut World, name: &str| {
            let mut status = world.resource_mut::<SceneStatus>();
            (status.state, status.fresh_load) = (SceneState::Ready, true);
            status.path = Some(folder.path().join(name));
            status.revision += 1;
            world.run_system_cached(follow_views).expect("runs");
            world.resource::<BakePlan>().clone()
        };
        let mut world = start(true);
        assert_eq!(open(&mut world, "a.xml"), BakePlan::default());
        world.insert_resource(plan(Some(8.0)));
        assert_eq!(open(&mut world, "b.xml"), BakePlan::default());
        world.insert_resource(plan(Some(-3.0)));
        assert_eq!(open(&mut world, "a.xml"), plan(Some(8.0)));
        assert_eq!(open(&mut world, "b.xml"), plan(None), "there is no such number");
        assert_eq!(open(&mut start(true), "a.xml"), plan(Some(8.0)));
        // A script neither takes it up nor changes it.
        let mut world = start(false);
        assert_eq!(open(&mut world, "a.xml"), BakePlan::default());
        world.insert_resource(plan(Some(2.0)));
        assert_eq!(open(&mut world, "b.xml"), plan(Some(2.0)));
        assert_eq!(open(&mut start(true), "a.xml"), plan(Some(8.0)));
    }

    /// A world in which a scene has just been opened that was left with a view.
    fn opened(returns: bool, prefers: bool) -> World {
        let mut world = World::new();
        let sensor = world.spawn((Sensor::default(), ToWorld::default())).id();
        world.insert_resource(ActiveSensor(Some(sensor)));
        world.insert_resource(SceneStatus {
            state: SceneState::Ready,
            fresh_load: true,
            revision: 1,
            ..SceneStatus::default()
        });
        world.insert_resource(ViewsFile {
            scene: Some("/a.xml".into()),
            last: views(60.0)[2],
            returns,
            ..ViewsFile::default()
        });
        world.insert_resource(Preferences {
            returns_to_views: prefers,
            ..Preferences::default()
        });
        world.init_resource::<FreeView>();
        world.init_resource::<Toasts>();
        world.init_resource::<Messages<AppExit>>();
        world.run_system_cached(return_to_view).expect("runs");
        world
    }

    #[test]
    fn a_scene_begins_where_it_was_left_if_that_is_wanted() {
        for (returns, prefers) in [(true, true), (false, true), (true, false)] {
            let mut world = opened(returns, prefers);
            let view = views(60.0)[2].expect("stored");
            let free = *world.resource::<FreeView>();
            if returns && prefers {
                assert_eq!((free.pose, free.lens), (Some(view.pose), Some(Lens::Orthographic)));
            } else {
                assert_eq!(free, FreeView::default());
            }
            world.run_system_cached(note_view).expect("runs");
            assert_eq!(world.resource::<ViewsFile>().last, Some(view));
            // The view of the camera is not remembered in its place until the user has looked around.
            let other = FreeView {
                pose: Some(Affine3A::IDENTITY),
                ..FreeView::default()
            };
            for (free, expected) in [(other, Some(Affine3A::IDENTITY)), (FreeView::default(), None)] {
                world.insert_resource(free);
                world.run_system_cached(note_view).expect("runs");
                let last = world.resource::<ViewsFile>().last;
                assert_eq!(last.map(|view| view.pose), expected);
            }
        }
    }

    #[test]
    fn a_scene_that_is_opened_does_not_play() {
        let mut world = opened(true, true);
        world.init_resource::<ViewSettings>();
        world.resource_mut::<ViewSettings>().playback.start(0.0);
        let mut plays = |fresh_load: bool| {
            let mut status = world.resource_mut::<SceneStatus>();
            (status.fresh_load, status.revision) = (fresh_load, status.revision + 1);
            world.run_system_cached(follow_views).expect("runs");
            world.resource::<ViewSettings>().playback.is_playing()
        };
        assert!(plays(false));
        assert!(!plays(true));
    }

    #[test]
    fn a_scene_that_is_saved_under_another_name_has_its_view_there() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mut world = opened(true, true);
        let last = views(60.0)[2];
        world.insert_resource(ViewsFile {
            path: Some(folder.path().join(FILE)),
            scene: Some("/a.xml".into()),
            last,
            last_written: last,
            ..ViewsFile::default()
        });
        world.init_resource::<ViewSettings>();
        let mut status = world.resource_mut::<SceneStatus>();
        status.path = Some("/b.xml".into());
        status.fresh_load = false;
        world.run_system_cached(follow_views).expect("runs");
        let mut file = world.resource_mut::<ViewsFile>();
        file.leave().expect("a writable folder");
        file.open(Path::new("/b.xml"));
        assert_eq!(file.last, last);
    }

    #[test]
    fn there_are_never_many_and_nonsense_is_left_out() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mut file = ViewsFile::new(Some(folder.path()));
        for number in 0..MOST_SCENES + 5 {
            file.open(Path::new(&format!("{number}.xml")));
            file.store(views(number as f32)).expect("a writable folder");
        }
        let path = folder.path().join(FILE);
        let all = read(&path);
        assert_eq!(
            (all.len(), all[0].views),
            (MOST_SCENES, views((MOST_SCENES + 4) as f32))
        );
        let zeros = r#"{"scene": "/x.xml", "views": [{"world_from_camera": [[0,0,0],[0,0,0],[0,0,0],[1,2,3]]},
            null, null, null, null, null, null, null, null]}"#;
        std::fs::write(&path, format!("[7, {zeros}]")).expect("a writable folder");
        let all = read(&path);
        assert_eq!((all.len(), all[0].views), (1, StoredViews::default()));
    }

    #[test]
    fn without_a_folder_nothing_is_remembered() {
        let mut file = ViewsFile::new(None);
        assert_eq!(file.open(Path::new("a.xml")), StoredViews::default());
        file.store(views(1.0)).expect("nothing is done");
    }
}
