//! Commands of undo and redo.

use super::traits::Traits;

/// A command of undo and redo.
#[derive(Clone, Debug, PartialEq)]
pub enum HistoryCommand {
    /// Undoes a step.
    Undo,
    /// Redoes a step.
    Redo,
    /// Undoes or redoes until this number of steps is done.
    GoTo(usize),
}

impl HistoryCommand {
    pub(super) fn traits(&self) -> Traits {
        match self {
            Self::Undo | Self::Redo | Self::GoTo(_) => Traits::VIEW,
        }
    }
}
