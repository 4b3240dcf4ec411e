//! The data of the form for a bake, and of the panel of the one that is under way.

use std::path::PathBuf;

use crate::app::editor::command::baking::BakeChoices;
use crate::app::editor::command::compare_view::CompareView;
use crate::app::editor::picture::baking::thread::BakeNews;

/// The bake, and how the next one is done.
#[derive(Clone, Debug, Default)]
pub struct BakeModel {
    /// How the next one is done.
    pub choices: BakeChoices,
    /// The folder for the next one, if it is known.
    pub folder: Option<PathBuf>,
    /// The folder of the open scene's file, which the name of another folder counts from. None for the folder that the
    /// program was started in.
    pub scene_folder: Option<PathBuf>,
    /// The bake under way, or that has ended and is still shown.
    pub shown: Option<ShownBake>,
}

/// A bake that is shown.
#[derive(Clone, Debug)]
pub struct ShownBake {
    /// The folder for its files.
    pub folder: PathBuf,
    /// What is known of it.
    pub news: BakeNews,
    /// Whether it was stopped, and writes what there is.
    pub is_stopped: bool,
    /// Whether it is under way.
    pub is_busy: bool,
    /// The lightmap that is to be shown, from 0.
    pub page: usize,
    /// How the picture is compared.
    pub view: CompareView,
    /// Whether it is of the scene that is open now.
    pub is_of_open_scene: bool,
}

impl BakeModel {
    /// Whether a bake waits or is under way.
    pub fn is_busy(&self) -> bool {
        self.shown.as_ref().is_some_and(|shown| shown.is_busy)
    }

    /// Whether there is light that is written if the bake is stopped.
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
