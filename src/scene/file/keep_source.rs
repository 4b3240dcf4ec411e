//! The choice whether the text and the tree of a scene file are kept beside what they mean.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use bevy::prelude::*;

/// Whether the source is kept. Saving and reloading need what the file said of each thing. A program that only renders
/// a scene does without it, and without most of the memory that a scene of many things takes; later changes of the file
/// are then left alone. Shared with the loader, which runs on other threads.
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

    /// Sets whether the source is kept. To be called before a scene is opened.
    pub fn set(&self, keeps: bool) {
        self.0.store(keeps, Ordering::Relaxed);
    }
}
