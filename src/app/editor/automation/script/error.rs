//! [`ScriptError`] says why a script ends early.

use std::borrow::Cow;

use super::assign::AssignError;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::picture::awaited_image::ImageNotSaved;
use crate::document::value::ValueError;

/// Says why a line of a script is not carried out, without the place of the line.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum ScriptError {
    /// A word of the line names nothing, or is in the wrong place.
    #[error("{0}")]
    Words(Cow<'static, str>),
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
    /// The picture could not be saved; `kept` says where it is instead.
    #[error("{error}; {kept}")]
    Kept { error: CommandError, kept: String },
    /// The log says why.
    #[error("the scene cannot be read")]
    Scene,
    #[error("{0}: no samples can be waited for")]
    Wait(&'static str),
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
