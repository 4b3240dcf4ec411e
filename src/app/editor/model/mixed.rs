//! The differences among several selected things, so that the panel can say that it shows the value of one of them.

use std::collections::BTreeSet;
use std::sync::Arc;

/// The rows whose values differ, by [`key`] of their names.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Mixed(pub(super) Arc<BTreeSet<String>>);

/// The key of a row: its name in small letters, with underscores for spaces.
pub fn key(name: &str) -> String {
    name.to_lowercase().replace(' ', "_")
}

impl Mixed {
    /// Whether the row differs. `name` is that of the row, or of its parameter in the file.
    pub fn has(&self, name: &str) -> bool {
        !self.0.is_empty() && self.0.contains(&key(name))
    }

    /// Whether all values are the same, as with one thing alone.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}
