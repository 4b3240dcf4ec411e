//! How a picture begins.

use super::Job;

/// The way in which a picture begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::engine) enum Beginning {
    /// It begins with a sample of every pixel.
    Whole,
    /// It begins with a sample of each block with an edge of this many pixels.
    Preview(u32),
}

/// The edge of a preview's blocks in pixels of the full resolution.
const PREVIEW_STEP: f32 = 4.0;

impl Beginning {
    /// A preview in blocks that are about as large whatever part of the resolution is rendered.
    pub fn preview(motion_scale: f32) -> Self {
        match (PREVIEW_STEP * motion_scale).round() as u32 {
            0 | 1 => Self::Whole,
            step => Self::Preview(step),
        }
    }
}

impl Job {
    /// Has it begin with the G-buffer.
    pub fn with_gbuffer(self) -> Self {
        Self {
            gbuffer_left: (0..self.tiles.len()).collect(),
            ..self
        }
    }

    /// Makes it a share of a picture, see [`RenderControl::share`](super::RenderControl::share).
    pub fn into_share(self, first: u32) -> Self {
        Self {
            share: Some(first),
            done: vec![first; self.done.len()],
            preview_left: 0,
            ..self
        }
    }
}
