//! The bake of lightmaps that is under way.

pub mod shown;
pub mod thread;

use std::path::Path;

use bevy::prelude::Resource;

use crate::bake::files::OutputFolder;
use thread::{BakeThread, LeftThread};

/// The bake.
#[derive(Resource, Default)]
pub struct Baking {
    /// The bake under way or at its end.
    pub work: Work,
    /// How the last one failed, for those who wait for it.
    pub failure: Option<String>,
    /// Whether the bake is of the scene that is open now, not of one that was open before.
    pub is_of_open_scene: bool,
    /// The threads of bakes that were given up.
    pub ending: Vec<LeftThread>,
}

/// A bake.
#[derive(Default)]
pub enum Work {
    /// There is none.
    #[default]
    None,
    /// It waits until the scene is loaded and packed.
    Waiting(OutputFolder),
    /// It is under way.
    UnderWay(BakeThread),
    /// It has ended, and is still looked at.
    Ended(BakeThread),
}

impl Baking {
    /// Whether one waits or is under way.
    pub fn is_busy(&self) -> bool {
        matches!(self.work, Work::Waiting(_) | Work::UnderWay(_))
    }

    /// The thread of the bake, under way or not.
    pub fn thread(&self) -> Option<&BakeThread> {
        match &self.work {
            Work::UnderWay(thread) | Work::Ended(thread) => Some(thread),
            Work::None | Work::Waiting(_) => None,
        }
    }

    /// The folder that it is written to.
    pub fn target(&self) -> Option<&Path> {
        match &self.work {
            Work::None => None,
            Work::Waiting(folder) => Some(folder.path()),
            Work::UnderWay(thread) | Work::Ended(thread) => Some(thread.folder()),
        }
    }

    /// How the last bake of the open scene has failed.
    pub fn notice(&self) -> Option<&str> {
        self.failure.as_deref().filter(|_| self.is_of_open_scene)
    }

    /// Gives the bake up, or closes what is shown of it.
    pub fn discard(&mut self) {
        match std::mem::take(&mut self.work) {
            Work::UnderWay(thread) | Work::Ended(thread) => self.ending.push(thread.discard()),
            Work::None | Work::Waiting(_) => {}
        }
    }
}
