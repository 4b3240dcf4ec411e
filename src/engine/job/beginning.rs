//! The start of a picture: a preview or whole samples.

use super::Job;

/// The start of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::engine) enum Beginning {
    /// A sample of every pixel.
    Whole,
    /// A sample of each block with an edge of this many pixels.
    Preview(u32),
}

/// The edge of a preview's blocks in pixels of the full resolution.
const PREVIEW_STEP: f32 = 4.0;

impl Beginning {
    /// A preview in blocks of about the same apparent size at any `motion_scale`.
    pub fn preview(motion_scale: f32) -> Self {
        match (PREVIEW_STEP * motion_scale).round() as u32 {
            0 | 1 => Self::Whole,
            step => Self::Preview(step),
        }
    }
}

impl Job {
    /// Lets the job begin with the G-buffer.
    pub fn with_gbuffer(self) -> Self {
        Self {
            gbuffer_left: (0..self.tiles.len()).collect(),
            ..self
        }
    }

    /// Makes the job a share of a picture, see [`RenderControl::share`](super::RenderControl::share).
    pub fn into_share(self, first: u32) -> Self {
        Self {
            share: Some(first),
            done: vec![first; self.done.len()],
            preview_left: 0,
            ..self
        }
    }
}
