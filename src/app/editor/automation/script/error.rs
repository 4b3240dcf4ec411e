//! [`ScriptError`], the reason why a script ends early, and [`ScriptNotBegun`], the reason why it does not begin.

use std::borrow::Cow;
use std::path::PathBuf;

use super::assign::AssignError;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::picture::awaited_image::ImageNotSaved;
use crate::document::value::ValueError;
use crate::files::FileError;

/// The reason why a script is not begun.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum ScriptNotBegun {
    #[error("{}: {error}", path.display())]
    File { path: PathBuf, error: FileError },
    /// The line has a fault that does not depend on the scene. `line` counts from 1.
    #[error("{}:{line}: {error}", path.display())]
    Line {
        path: PathBuf,
        line: usize,
        error: ScriptError,
    },
}

/// The reason why a line of a script is not carried out, without the number of the line.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum ScriptError {
    /// A word of the line is unknown, or in the wrong position.
    #[error("{0}")]
    Words(Cow<'static, str>),
    /// The line could be carried out in another scene, or with another selection.
    #[error("{0}")]
    OfScene(Box<ScriptError>),
    #[error(transparent)]
    Value(#[from] ValueError),
    #[error(transparent)]
    Assign(#[from] AssignError),
    #[error("{error} (usage: {verb} {usage})")]
    Usage {
        error: Box<ScriptError>,
        verb: &'static str,
        usage: &'static str,
    },
    #[error(transparent)]
    Command(#[from] CommandError),
    #[error(transparent)]
    Image(#[from] ImageNotSaved),
    /// The picture could not be saved; `kept` names its temporary file.
    #[error("{error}; {kept}")]
    Kept { error: CommandError, kept: String },
    /// The scene could not be loaded, for a reason in the log.
    #[error("the scene cannot be read")]
    Scene,
    #[error("{0}: no samples can be waited for")]
    Wait(&'static str),
}

impl ScriptError {
    /// The same as an error that depends on the scene.
    pub(super) fn of_scene(self) -> Self {
        Self::OfScene(Box::new(self))
    }

    /// Whether the line could be carried out in another scene.
    pub(super) fn depends_on_scene(&self) -> bool {
        match self {
            Self::OfScene(_) => true,
            Self::Usage { error, .. } => error.depends_on_scene(),
            _ => false,
        }
    }
}

impl From<&'static str> for ScriptError {
    fn from(reason: &'static str) -> Self {
        Self::Words(reason.into())
    }
}

impl From<String> for ScriptError {
    fn from(reason: String) -> Self {
        Self::Words(reason.into())
    }
}
