//! [`CommandError`], the reason why a command is not carried out.

use std::borrow::Cow;
use std::error::Error;

/// The reason why a command was not carried out, as a sentence for the user; nothing is changed then.
#[derive(Debug, thiserror::Error)]
pub enum CommandError {
    /// The scene, the selection or the picture does not allow it.
    #[error("{0}")]
    Refused(Cow<'static, str>),
    /// A file cannot be read or written.
    #[error(transparent)]
    File(Box<dyn Error + Send + Sync>),
}

impl CommandError {
    /// An error about a file, with the message of its cause.
    pub fn file(error: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self::File(error.into())
    }
}

impl From<&'static str> for CommandError {
    fn from(reason: &'static str) -> Self {
        Self::Refused(reason.into())
    }
}

impl From<String> for CommandError {
    fn from(reason: String) -> Self {
        Self::Refused(reason.into())
    }
}
