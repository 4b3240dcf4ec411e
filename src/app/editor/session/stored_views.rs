//! Stores views under the numbers 1 to 9 for each scene, in one file beside the preferences.
//!
//! They are not part of the scene's file, because looking at a scene is no edit.

use std::path::{Path, PathBuf};

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::toasts::Toasts;
use super::view_settings::ViewSettings;
use crate::app::editor::command::stored_view::StoredViews;
use crate::files::{self, LARGEST_NOTE, write_atomically};
use crate::scene::{SceneState, SceneStatus};

/// The views of one scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct SceneViews {
    /// The absolute path of the scene, without links.
    scene: PathBuf,
    views: StoredViews,
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
}

impl ViewsFile {
    /// The stored views. `folder` is that of the preferences.
    pub fn new(folder: Option<&Path>) -> Self {
        Self {
            path: folder.map(|folder| folder.join(FILE)),
            ..Self::default()
        }
    }

    /// The views of the scene in this file.
    fn open(&mut self, scene: &Path) -> StoredViews {
        let scene = canonical(scene);
        let all = self.path.as_deref().map_or(Vec::new(), read);
        let known = all.into_iter().find(|known| known.scene == scene);
        self.scene = Some(scene);
        self.written = known.map_or_else(StoredViews::default, |known| known.views);
        self.written
    }

    /// Stores the views of the open scene. Other windows may have written to the file in the meantime.
    fn store(&mut self, views: StoredViews) -> std::io::Result<()> {
        self.written = views;
        let (Some(path), Some(scene)) = (&self.path, &self.scene) else {
            return Ok(());
        };
        let mut all = read(path);
        all.retain(|known| known.scene != *scene);
        // Names that JSON cannot hold are left out.
        if views != StoredViews::default() && scene.to_str().is_some() {
            let scene = scene.clone();
            all.insert(0, SceneViews { scene, views });
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
    for place in &mut of_scene.views {
        *place = place.filter(|view| view.pose.is_finite() && view.pose.matrix3.determinant() != 0.0);
    }
    of_scene
}

/// Reads the views of a scene that has been opened, and writes those that are stored.
pub fn follow_views(
    mut file: ResMut<ViewsFile>,
    mut settings: ResMut<ViewSettings>,
    mut toasts: ResMut<Toasts>,
    status: Res<SceneStatus>,
    mut seen: Local<u64>,
) {
    let file = file.bypass_change_detection();
    let is_opened = *seen != status.revision && status.fresh_load;
    *seen = status.revision;
    let path = status.path.as_deref().filter(|_| status.state == SceneState::Ready);
    match path {
        Some(path) if is_opened => settings.bookmarks = file.open(path),
        None if is_opened => (file.scene, file.written) = (None, StoredViews::default()),
        // The scene was saved under this name.
        Some(path) if status.is_changed() => {
            let scene = Some(canonical(path));
            if file.scene != scene {
                file.scene = scene;
                file.written = StoredViews::default();
            }
        }
        _ => {}
    }
    if settings.bookmarks != file.written
        && let Err(error) = file.store(settings.bookmarks)
    {
        toasts.reject(format!("The view is not remembered: {error}"));
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::{Affine3A, Vec3};

    use super::*;
    use crate::app::editor::command::stored_view::StoredView;

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
