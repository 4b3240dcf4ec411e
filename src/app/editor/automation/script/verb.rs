//! Verbs of scripts: each is one row with its name, its words and its command.

use std::path::PathBuf;

use bevy::prelude::World;

use super::error::ScriptError;
use crate::app::editor::command::Command;

/// The request of a line.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// A command for this frame.
    Do(Command),
    /// A wait for the lines after it.
    Wait(Wait),
    /// A bake into this folder, whose end the lines after it wait for.
    Bake(PathBuf),
    /// A wait for the running bake.
    AwaitBake(BakeWait),
    /// A screenshot of the whole window as PNG.
    Screenshot(PathBuf),
}

/// The event that a line waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wait {
    /// The picture of the present scene has exactly this number of samples per pixel, and gets no more; 0: everything
    /// is loaded.
    Samples(u32),
    /// The picture has reached one of its own limits.
    Done,
}

/// The event of a bake that a script waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BakeWait {
    /// So many samples of each texel, or the end.
    Samples(u32),
    /// The end.
    End,
}

impl<C: Into<Command>> From<C> for Step {
    fn from(command: C) -> Self {
        Self::Do(command.into())
    }
}

/// A verb besides the actions.
pub struct Verb {
    /// The first word of its lines.
    pub name: &'static str,
    /// The words that follow, for messages and `docs/scripts.md`.
    pub usage: &'static str,
    /// Parses the words; None if they do not match the usage.
    pub parse: fn(&mut World, &[&str]) -> Result<Option<Step>, ScriptError>,
}

/// Declares rows of verbs: `"name" "usage" PATTERN => COMMAND, PATTERN => COMMAND, ..;`.
macro_rules! verbs {
    ($table:ident($world:ident): $($name:literal $usage:literal $($words:pat $(if $guard:expr)? => $step:expr),+;)*) => {
        /// The verbs of this topic.
        // Not every verb uses the scene, and some take all words.
        #[allow(unused_variables, unreachable_patterns)]
        pub const $table: &[$crate::app::editor::automation::script::verb::Verb] =
            &[$($crate::app::editor::automation::script::verb::Verb {
                name: $name,
                usage: $usage,
                parse: |$world, words| {
                    Ok(Some(match words {
                        $($words $(if $guard)? => $step.into(),)+
                        _ => return Ok(None),
                    }))
                },
            }),*];
    };
}
pub(super) use verbs;
