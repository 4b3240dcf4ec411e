//! The frames of the timeline, and the steps that go through them.

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use crate::document::animation::key_time;

/// The frames that are played, and how fast. They are no part of the scene: its keys are in seconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Timeline {
    /// Frames per second, in [`Timeline::FPS`].
    pub fps: f64,
    /// The first frame that is played.
    pub first: u32,
    /// The last frame that is played, not before the first one.
    pub last: u32,
}

impl Default for Timeline {
    fn default() -> Self {
        Self {
            fps: 24.0,
            first: 0,
            last: 95,
        }
    }
}

impl Timeline {
    /// The highest number of a frame.
    pub const MOST: u32 = 9_999_999;
    /// The numbers of frames per second that there can be.
    pub const FPS: RangeInclusive<f64> = 0.001..=100_000.0;

    /// The same with all numbers in their ranges.
    pub fn within_range(self) -> Self {
        let usual = Self::default();
        let first = self.first.min(Self::MOST);
        Self {
            fps: if self.fps.is_finite() {
                self.fps.clamp(*Self::FPS.start(), *Self::FPS.end())
            } else {
                usual.fps
            },
            first,
            last: self.last.clamp(first, Self::MOST),
        }
    }

    /// The time of a frame in seconds, as `sunroom render --frames` has it.
    pub fn time(&self, frame: f64) -> f64 {
        frame / self.fps
    }

    /// The frame at a time in seconds, with the part of a frame that has passed.
    pub fn frame(&self, time: f64) -> f64 {
        time * self.fps
    }

    /// The time of the frame that is nearest to a time, both in seconds.
    pub fn snapped(&self, time: f64) -> f64 {
        self.time(self.frame(time).round())
    }

    /// The exact time of the frame that a key at `time` is for, since keys have times in single precision. A key
    /// between frames stays where it is. Both times are in seconds.
    pub fn time_of_key(&self, time: f64) -> f64 {
        let frame = self.snapped(time);
        if key_time(frame) == key_time(time) { frame } else { time }
    }

    /// The time in seconds that the frames take.
    pub fn duration(&self) -> f64 {
        self.time(f64::from(self.last - self.first) + 1.0)
    }
}

/// A step to another time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeStep {
    /// To the first frame.
    FirstFrame,
    /// To the last frame.
    LastFrame,
    /// To the frame before.
    PreviousFrame,
    /// To the next frame.
    NextFrame,
    /// To the last key before the time that is shown, of the selection or else of everything.
    PreviousKey,
    /// To the next key.
    NextKey,
}
