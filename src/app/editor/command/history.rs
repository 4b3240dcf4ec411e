//! Commands that walk through the history.

use super::traits::Traits;

/// A command that walks through the history.
#[derive(Clone, Debug, PartialEq)]
pub enum HistoryCommand {
    /// Goes one step of the history back.
    Undo,
    /// Goes one step of the history forward.
    Redo,
    /// Goes back or forward to where this number of steps is done.
    GoTo(usize),
}

impl HistoryCommand {
    pub(super) fn traits(&self) -> Traits {
        match self {
            Self::Undo | Self::Redo | Self::GoTo(_) => Traits::VIEW,
        }
    }
}
