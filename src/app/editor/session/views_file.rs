//! The file beside the preferences with the views of each scene under the numbers 1 to 9, its last view, its side
//! views, and the settings of its bakes.
//!
//! They are not part of the scene's file, because looking at a scene and baking it are no edits.

use std::path::{Path, PathBuf};

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::app::editor::command::baking::BakePlan;
use crate::app::editor::command::lenient::or_default;
use crate::app::editor::command::side_views::SideViews;
use crate::app::editor::command::stored_view::{StoredView, StoredViews};
use crate::app::editor::command::timeline::Timeline;
use crate::files::{self, LARGEST_NOTE, write_atomically};

/// The views of one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct SceneViews {
    /// The absolute path of the scene, without links.
    scene: PathBuf,
    views: StoredViews,
    /// The last view of the scene; None for that of its camera.
    #[serde(default)]
    last: Option<StoredView>,
    /// The side views; None for the default.
    #[serde(default, deserialize_with = "or_default", skip_serializing_if = "Option::is_none")]
    sides: Option<SideViews>,
    /// The frames of the timeline; None for the default.
    #[serde(default)]
    timeline: Option<Timeline>,
    /// The settings and the folder of its bakes; None for the default.
    #[serde(default, deserialize_with = "or_default", skip_serializing_if = "Option::is_none")]
    bake: Option<BakePlan>,
}

const FILE: &str = "views.json";
/// The number of scenes whose views are remembered; the ones opened least recently are dropped.
const MOST_SCENES: usize = 100;

/// The file of the views.
#[derive(Resource, Debug, Default)]
pub struct ViewsFile {
    /// The path of the file. None: nothing is remembered.
    pub(super) path: Option<PathBuf>,
    /// The path of the open scene, as in the file. None while the scene has no name.
    pub(super) scene: Option<PathBuf>,
    /// The views of that scene, as in the file.
    pub(super) written: StoredViews,
    /// The last view of the scene, as in the file.
    pub(super) last_written: Option<StoredView>,
    /// The present view of that scene; None for that of its camera.
    pub(super) last: Option<StoredView>,
    /// The side views of that scene; None if the file has none.
    pub(super) sides: Option<SideViews>,
    /// The same, as in the file.
    pub(super) sides_written: Option<SideViews>,
    /// The frames of the timeline of that scene, as in the file.
    pub(super) timeline: Timeline,
    /// The settings of bakes of that scene.
    pub(super) bake: BakePlan,
    /// The same, as in the file.
    pub(super) bake_written: BakePlan,
    /// Whether scenes may begin with their last view, their side views and their settings of bakes.
    pub(super) returns: bool,
    /// Whether the stored last view stays in the file: the scene did not begin with it, and the user has not moved the
    /// view since.
    pub(super) keeps_last: bool,
    /// Whether the next scene begins with a requested camera.
    pub(super) begins_at_camera: bool,
}

impl ViewsFile {
    /// The stored views. `folder` is that of the preferences.
    pub fn new(folder: Option<&Path>) -> Self {
        Self {
            path: folder.map(|folder| folder.join(FILE)),
            ..Self::default()
        }
    }

    /// Lets scenes begin with their settings of bakes, their side views and their last view, except that a requested
    /// camera comes first.
    pub fn returning(self, begins_at_camera: bool) -> Self {
        Self {
            returns: true,
            begins_at_camera,
            ..self
        }
    }

    /// The views of the scene in this file.
    pub(super) fn open(&mut self, scene: &Path) -> StoredViews {
        let scene = canonical(scene);
        let all = self.path.as_deref().map_or(Vec::new(), read);
        let known = all.into_iter().find(|known| known.scene == scene);
        self.scene = Some(scene);
        let timeline = known.as_ref().and_then(|known| known.timeline);
        self.timeline = timeline.unwrap_or_default().within_range();
        self.sides = known.as_ref().and_then(|known| known.sides);
        self.sides_written = self.sides;
        let known = known.map(|known| (known.views, known.last, known.bake.unwrap_or_default()));
        (self.written, self.last, self.bake) = known.unwrap_or_default();
        self.last_written = self.last;
        self.bake_written.clone_from(&self.bake);
        self.written
    }

    /// Writes the last view, the side views and the settings of bakes when the scene is left.
    pub(super) fn leave(&mut self) -> std::io::Result<()> {
        let is_written = self.last == self.last_written && self.sides == self.sides_written;
        let outcome = match is_written && self.bake == self.bake_written {
            true => Ok(()),
            false => self.store(self.written),
        };
        (self.bake, self.bake_written) = Default::default();
        (self.scene, self.written) = (None, StoredViews::default());
        self.timeline = Timeline::default();
        (self.last, self.last_written, self.keeps_last) = (None, None, false);
        (self.sides, self.sides_written) = (None, None);
        outcome
    }

    /// Stores the views of the open scene, in a file that other windows may have changed in the meantime.
    pub(super) fn store(&mut self, views: StoredViews) -> std::io::Result<()> {
        (self.written, self.last_written, self.sides_written) = (views, self.last, self.sides);
        self.bake_written.clone_from(&self.bake);
        let (Some(path), Some(scene)) = (&self.path, &self.scene) else {
            return Ok(());
        };
        let mut all = read(path);
        all.retain(|known| known.scene != *scene);
        // Names that JSON cannot hold are left out.
        let timeline = Some(self.timeline).filter(|timeline| *timeline != Timeline::default());
        let bake = Some(self.bake.clone()).filter(|bake| *bake != BakePlan::default());
        let sides = self.sides.filter(|sides| *sides != SideViews::default());
        let has_view = views != StoredViews::default() || self.last.is_some() || sides.is_some();
        if (has_view || timeline.is_some() || bake.is_some()) && scene.to_str().is_some() {
            let (scene, last) = (scene.clone(), self.last);
            let of_scene = SceneViews {
                scene,
                views,
                last,
                sides,
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

pub(super) fn canonical(path: &Path) -> PathBuf {
    path.canonicalize()
        .or_else(|_| std::path::absolute(path))
        .unwrap_or_else(|_| path.to_owned())
}

/// Reads the valid entries. Others are lost when the next view is stored, and they hold nothing but views.
fn read(path: &Path) -> Vec<SceneViews> {
    let text = files::read_text(path, LARGEST_NOTE).unwrap_or_default();
    let all: Vec<serde_json::Value> = serde_json::from_str(&text).unwrap_or_default();
    let known = all.into_iter().filter_map(|one| serde_json::from_value(one).ok());
    known.map(without_nonsense).collect()
}

fn without_nonsense(mut of_scene: SceneViews) -> SceneViews {
    for place in of_scene.views.iter_mut().chain([&mut of_scene.last]) {
        *place = place.filter(StoredView::is_possible);
    }
    of_scene.sides = of_scene.sides.map(SideViews::within_range);
    if let Some(bake) = &mut of_scene.bake {
        bake.choices = bake.choices.within_range();
    }
    of_scene
}

#[cfg(test)]
pub(super) mod tests {
    use bevy::math::{Affine3A, Vec3};

    use super::*;

    pub fn views(x: f32) -> StoredViews {
        let mut views = StoredViews::default();
        views[2] = Some(StoredView {
            pose: Affine3A::from_rotation_y(0.3) * Affine3A::from_translation(Vec3::new(x, 1e-7, -3.5)),
            orthographic: x > 50.0,
            hides_walls: x > 50.0,
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
        let sides = Some(SideViews {
            shown: true,
            ..SideViews::default()
        });
        file.sides = sides;
        let frames = Timeline {
            fps: 30.0,
            first: 5,
            last: 90,
        };
        file.timeline = frames;
        file.leave().expect("a writable folder");
        file.open(Path::new("b.xml"));
        assert_eq!((file.last, file.sides), (None, None));
        assert_eq!(file.timeline, Timeline::default());
        file.leave().expect("a writable folder");
        // The file also has the views under numbers.
        file.open(Path::new("a.xml"));
        assert_eq!((file.last, file.sides, file.timeline), (left, sides, frames));
        file.store(views(60.0)).expect("a writable folder");
        let mut again = ViewsFile::new(Some(folder.path()));
        assert_eq!((again.open(Path::new("a.xml")), again.last), (views(60.0), left));
        assert_eq!(again.sides, sides);
        // The camera of the file is looked through again.
        again.last = None;
        again.leave().expect("a writable folder");
        assert_eq!((file.open(Path::new("a.xml")), file.last), (views(60.0), None));
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
