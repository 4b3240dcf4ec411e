//! The frames of the timeline, and the steps that go through them.

use super::traits::Traits;
use crate::scene::{KeyEdit, KeyPath};
use bevy::prelude::Entity;

use std::ops::RangeInclusive;

use serde::{Deserialize, Serialize};

use crate::document::animation::key_time;

/// The range and speed of playback in frames. They are no part of the scene: its keys are in seconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Timeline {
    /// Frames per second, in [`Timeline::FPS`].
    pub fps: f64,
    /// The first frame of playback.
    pub first: u32,
    /// The last frame of playback, not before the first one.
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
    /// The range of frames per second.
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

    /// The frame at a time in seconds, with its fraction.
    pub fn frame(&self, time: f64) -> f64 {
        time * self.fps
    }

    /// The time of the frame that is nearest to a time, both in seconds.
    pub fn snapped(&self, time: f64) -> f64 {
        self.time(self.frame(time).round())
    }

    /// The exact time of the frame of a key at `time`, since keys have times in single precision. A key between frames
    /// stays where it is. Both times are in seconds.
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
    /// To the last key before the displayed time, of the selection or else of everything.
    PreviousKey,
    /// To the next key.
    NextKey,
}

/// An edit of animated values. All times are in seconds.
#[derive(Clone, Debug, PartialEq)]
pub enum TimeEdit {
    /// Changes the tracks of values at the displayed time. Without any, a key is set for the place of each selected
    /// thing, and other edits apply to all tracks of the selection.
    Key(Vec<(Entity, KeyPath)>, KeyEdit),
    /// Animates the camera in use once around the selection, or the scene, from the pose of the view, over the frames
    /// of the timeline.
    AddTurntable,
}

impl TimeEdit {
    pub(super) fn traits(&self) -> Traits {
        match self {
            Self::Key(targets, how) => {
                let traits = match how {
                    KeyEdit::Set => Traits::edit("Set key of"),
                    KeyEdit::Remove => Traits::edit("Remove key of"),
                    KeyEdit::RemoveAll => Traits::edit("Remove keys of"),
                    KeyEdit::Move { .. } => Traits::drag("Move key of"),
                    KeyEdit::Interpolate(_) => Traits::edit("Set interpolation of"),
                };
                let mut things: Vec<Entity> = targets.iter().map(|(thing, _)| *thing).collect();
                things.dedup();
                match things.is_empty() {
                    true => traits.of_selection(),
                    false => traits.of(&things),
                }
            }
            Self::AddTurntable => Traits::edit("Add turntable"),
        }
    }
}

/// A command about the displayed time. All times are in seconds.
#[derive(Clone, Debug, PartialEq)]
pub enum TimeCommand {
    /// Shows the scene at a time. Playback ends.
    SetTime(f64),
    /// Shows the scene at the time of another frame or key.
    StepTime(TimeStep),
    /// Starts or stops playback.
    SetPlaying(bool),
    /// Sets the frames of the timeline.
    SetTimeline(Timeline),
    /// Shows the timeline below the picture, or not.
    ShowTimeline(bool),
}

impl TimeCommand {
    pub(super) fn traits(&self) -> Traits {
        match self {
            Self::SetTime(_) => Traits::VIEW.moving_picture(),
            Self::StepTime(_) => Traits::VIEW,
            Self::SetPlaying(_) | Self::SetTimeline(_) | Self::ShowTimeline(_) => Traits::NONE,
        }
    }
}
