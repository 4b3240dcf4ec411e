//! The playback of the timeline.

use std::time::Instant;

/// The state of playback.
#[derive(Clone, Copy, Debug, Default)]
pub struct Playback {
    /// The time of the scene in seconds at which playback began, and the clock's time then.
    started: Option<(f64, Instant)>,
}

impl Playback {
    /// Starts playback at this time of the scene, in seconds.
    pub fn start(&mut self, time: f64) {
        self.started = Some((time, Instant::now()));
    }

    /// Stops playback.
    pub fn stop(&mut self) {
        self.started = None;
    }

    /// Whether it plays.
    pub fn is_playing(&self) -> bool {
        self.started.is_some()
    }

    /// The time of the scene in seconds at which playback began, and the clock's time then; None while it is stopped.
    pub fn started(&self) -> Option<(f64, Instant)> {
        self.started
    }
}
