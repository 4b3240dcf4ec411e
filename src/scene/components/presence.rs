//! Detects watched files that were removed from the disk.
//!
//! Text editors save by replacing the file, so that it does not exist for a moment: a file is gone only after some
//! time. A file that never existed is not gone; its reader reports it as missing.

use std::collections::{BTreeMap, HashSet};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use crate::files::{Access, FolderNames};

/// The time for which a file may be away while it is saved.
const GRACE: Duration = Duration::from_millis(500);

#[derive(Debug, Default)]
pub(in crate::scene) struct Presence {
    there: HashSet<PathBuf>,
    /// The absent files, each with the time since when.
    away: BTreeMap<PathBuf, Instant>,
}

impl Presence {
    /// Checks whether all files exist: to be called when the list changes, and after events in their folders.
    pub fn look<'a>(&mut self, files: impl Iterator<Item = &'a PathBuf>) {
        let before = std::mem::take(self);
        let (mut names, access) = (FolderNames::default(), Access::everywhere());
        for file in files {
            if names.may_have(file, &access) && file.is_file() {
                self.there.insert(file.clone());
            } else if let Some(since) = before.away.get(file) {
                self.away.insert(file.clone(), *since);
            } else if before.there.contains(file) {
                self.away.insert(file.clone(), Instant::now());
            }
        }
    }

    /// The files that are gone, sorted by name.
    pub fn gone(&self) -> Vec<PathBuf> {
        let gone = self
            .away
            .iter()
            .filter(|(file, since)| since.elapsed() >= GRACE && !file.is_file());
        gone.map(|(file, _)| file.clone()).collect()
    }
}
