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
    /// A command that scripts have no word for.
    Do(Command),
    /// Another program writes a file.
    Write {
        path: PathBuf,
        content: Vec<u8>,
        how: Writing,
        /// It is the open scene's file: the next act waits until the editor has read this content.
        awaited: bool,
    },
    /// Another program deletes a file.
    Remove(PathBuf),
    /// The window's content, as shares of its first width and height.
    Resize(Vec2),
    CloseSheet,
    /// The next act waits until the engine has packed all edits, and the picture is of the scene as it is.
    AwaitPicture,
    /// Nothing happens for this many frames.
    Rest(usize),
}

/// A change of the scene's own file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OwnFile {
    /// It is not written, neither here nor elsewhere.
    Untouched,
    /// The change leaves the scene in the file as it is.
    Harmless,
    /// The change is one of the scene.
    Changes,
}
