//! The running bake of lightmaps.

pub mod shown;
pub mod thread;

use std::path::Path;

use bevy::prelude::Resource;

use crate::bake::files::OutputFolder;
use thread::{BakeThread, LeftThread};

/// The bake.
#[derive(Resource, Default)]
pub struct Baking {
    /// The bake, running or ended.
    pub work: Work,
    /// The error of the last bake, for callers that wait for it.
    pub failure: Option<String>,
    /// Whether the bake is of the scene that is open now, not of one that was open before.
    pub is_of_open_scene: bool,
    /// The threads of discarded bakes.
    pub ending: Vec<LeftThread>,
}

/// A bake.
#[derive(Default)]
pub enum Work {
    /// No bake.
    #[default]
    None,
    /// It waits until the scene is loaded and packed.
    Waiting(OutputFolder),
    /// The bake runs.
    UnderWay(BakeThread),
    /// The bake has ended, and its result is still shown.
    Ended(BakeThread),
}

impl Baking {
    /// Whether a bake waits or runs.
    pub fn is_busy(&self) -> bool {
        matches!(self.work, Work::Waiting(_) | Work::UnderWay(_))
    }

    /// The thread of the bake, running or ended.
    pub fn thread(&self) -> Option<&BakeThread> {
        match &self.work {
            Work::UnderWay(thread) | Work::Ended(thread) => Some(thread),
            Work::None | Work::Waiting(_) => None,
        }
    }

    /// The folder of the bake's files.
    pub fn target(&self) -> Option<&Path> {
        match &self.work {
            Work::None => None,
            Work::Waiting(folder) => Some(folder.path()),
            Work::UnderWay(thread) | Work::Ended(thread) => Some(thread.folder()),
        }
    }

    /// The error of the last bake of the open scene.
    pub fn notice(&self) -> Option<&str> {
        self.failure.as_deref().filter(|_| self.is_of_open_scene)
    }

    /// Discards a running bake, or closes the view of its result.
    pub fn discard(&mut self) {
        match std::mem::take(&mut self.work) {
            Work::UnderWay(thread) | Work::Ended(thread) => self.ending.push(thread.discard()),
            Work::None | Work::Waiting(_) => {}
        }
    }
}
