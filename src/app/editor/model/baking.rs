//! The data of the form for a bake, and of the panel of a running bake.

use std::path::PathBuf;

use crate::app::editor::command::baking::BakeChoices;
use crate::app::editor::command::compare_view::CompareView;
use crate::app::editor::picture::baking::thread::BakeNews;

/// The shown bake, and the settings of the next one.
#[derive(Clone, Debug, Default)]
pub struct BakeModel {
    /// The settings of the next bake.
    pub choices: BakeChoices,
    /// The folder of the next bake, if it is known.
    pub folder: Option<PathBuf>,
    /// The folder of the open scene's file, to which names of folders are relative. None for the folder that the
    /// program was started in.
    pub scene_folder: Option<PathBuf>,
    /// The running bake, or an ended one that is still shown.
    pub shown: Option<ShownBake>,
}

/// A bake that is shown.
#[derive(Clone, Debug)]
pub struct ShownBake {
    /// The folder for its files.
    pub folder: PathBuf,
    /// The progress of the bake.
    pub news: BakeNews,
    /// Whether it was stopped, and writes its result so far.
    pub is_stopped: bool,
    /// Whether it runs.
    pub is_busy: bool,
    /// The shown lightmap, from 0.
    pub page: usize,
    /// The comparison of the picture with the lit level.
    pub view: CompareView,
    /// Whether it is of the scene that is open now.
    pub is_of_open_scene: bool,
}

impl BakeModel {
    /// Whether a bake waits or runs.
    pub fn is_busy(&self) -> bool {
        self.shown.as_ref().is_some_and(|shown| shown.is_busy)
    }

    /// Whether stopping the bake would write some light.
    pub fn can_stop(&self) -> bool {
        self.shown.as_ref().is_some_and(ShownBake::can_stop)
    }
}

impl ShownBake {
    /// Whether there is light that is written if the bake is stopped.
    pub fn can_stop(&self) -> bool {
        self.news.samples > 0 && self.news.stays.is_none()
    }
}
