//! The window without a user: it takes a picture of itself and ends, for tests and for unattended use.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use bevy::prelude::*;

#[derive(Resource)]
pub struct ExitDoor {
    pub(super) screenshot: Option<PathBuf>,
    pub(super) after_spp: u32,
    pub(super) exit: bool,
    pub(super) started: Instant,
    pub(super) timeout: Duration,
    pub(super) step: Step,
}

#[derive(Clone, Copy, PartialEq)]
pub(super) enum Step {
    /// Waits for the samples, or for the measurement.
    Waiting,
    /// Waits for exactly this number of samples.
    Sampling(u32),
    /// The picture is finished; some more frames let the panels show it too.
    Settling(u32),
    Capturing,
    Done,
}

impl ExitDoor {
    pub fn new(screenshot: Option<PathBuf>, after_spp: u32, exit: bool, timeout: Duration) -> Self {
        Self {
            screenshot,
            after_spp,
            exit,
            started: Instant::now(),
            timeout,
            step: Step::Waiting,
        }
    }

    /// The awaited samples per pixel: exactly so many in `Sampling`, at least so many before.
    pub(super) fn wanted_samples(&self) -> u32 {
        match self.step {
            Step::Sampling(samples) => samples,
            _ => self.after_spp,
        }
    }

    /// Stops waiting. Returns the path of the screenshot that will not be written.
    pub fn give_up(&mut self) -> Option<PathBuf> {
        let before = std::mem::replace(&mut self.step, Step::Done);
        self.screenshot.take().filter(|_| before != Step::Done)
    }
}
