//! Whether the timeline plays, and since when.

use std::time::Instant;

/// The state of playing.
#[derive(Clone, Copy, Debug, Default)]
pub struct Playback {
    /// The time of the scene in seconds at which playing began, and when that was.
    started: Option<(f64, Instant)>,
}

impl Playback {
    /// Plays from this time of the scene, in seconds.
    pub fn start(&mut self, time: f64) {
        self.started = Some((time, Instant::now()));
    }

    /// Holds.
    pub fn stop(&mut self) {
        self.started = None;
    }

    /// Whether it plays.
    pub fn is_playing(&self) -> bool {
        self.started.is_some()
    }

    /// The time of the scene in seconds at which playing began, and when that was; None while it holds.
    pub fn started(&self) -> Option<(f64, Instant)> {
        self.started
    }
}
