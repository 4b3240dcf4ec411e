//! Commands about the unfinished picture that is kept beside its scene.

use super::traits::Traits;

/// A command about the kept picture of the open scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeptPicture {
    /// Keeps the picture with all its samples, in place of one that was kept before.
    Keep,
    /// Does `Keep`, and closes the window unless that fails.
    KeepAndQuit,
    /// Resumes the picture that was kept.
    Continue,
    /// Removes the picture that was kept.
    Discard,
}

impl KeptPicture {
    pub(super) fn traits(&self) -> Traits {
        match self {
            Self::Keep | Self::KeepAndQuit => Traits::NONE.of_pixels(),
            Self::Continue => Traits::VIEW,
            Self::Discard => Traits::NONE,
        }
    }
}
