//! The choice whether the text and the tree of a scene file are kept after reading.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use bevy::prelude::*;

/// Whether the source is kept. Saving and reloading need the source of each thing. A program that only renders a scene
/// works without it, and without most of the memory of a scene with many things; then later changes of the file are
/// ignored. Shared with the loader, which runs on other threads.
#[derive(Resource, Clone, Debug)]
pub struct KeepSource(Arc<AtomicBool>);

impl Default for KeepSource {
    fn default() -> Self {
        Self(Arc::new(AtomicBool::new(true)))
    }
}

impl KeepSource {
    /// Whether the source is kept.
    pub fn get(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Sets whether the source is kept. Call it before a scene is opened.
    pub fn set(&self, keeps: bool) {
        self.0.store(keeps, Ordering::Relaxed);
    }
}
