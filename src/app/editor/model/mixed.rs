//! The values that differ among several selected things, so that the panel can mark them.

use std::collections::BTreeSet;
use std::sync::Arc;

/// The names of differing values: those of parameters in the file, or of fields.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Mixed(pub(super) Arc<BTreeSet<String>>);

impl Mixed {
    /// Whether the value of this name differs.
    pub fn has(&self, name: &str) -> bool {
        self.0.contains(name)
    }

    /// Whether all values are the same, as with one thing alone.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}
