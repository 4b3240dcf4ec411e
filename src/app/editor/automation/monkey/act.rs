//! The acts of the monkey.

use std::path::PathBuf;

use bevy::prelude::*;

use super::folder::Writing;
use crate::app::editor::command::Command;

/// An act of one frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Act {
    /// Lines of a script.
    Say(Vec<String>),
    /// A command without a verb in scripts.
    Do(Command),
    /// Another program writes a file.
    Write {
        path: PathBuf,
        content: Vec<u8>,
        how: Writing,
        /// Whether it is the open scene's file: the next act waits until the editor has read this content.
        awaited: bool,
    },
    /// Another program deletes a file.
    Remove(PathBuf),
    /// The size of the window's content, as shares of its first width and height.
    Resize(Vec2),
    CloseSheet,
    /// The next act waits until the engine has packed all edits, and the picture is of the present scene.
    AwaitPicture,
    /// No act for this many frames.
    Rest(usize),
}

/// A change of the scene's own file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OwnFile {
    /// It is written neither by the editor nor by the monkey.
    Untouched,
    /// The change leaves the scene in the file as it is.
    Harmless,
    /// The change edits the scene in the file.
    Changes,
}
