//! Commands that control the rendering of the picture.

use bevy::prelude::Rect;

use super::resolution::{FullFilm, Resolution};
use super::traits::Traits;

/// A command that controls the rendering of the picture.
#[derive(Clone, Debug, PartialEq)]
pub enum RenderCommand {
    /// Pauses rendering, or continues it.
    SetPaused(bool),
    /// Drops the samples of the picture.
    Restart,
    /// Sets the samples per pixel to stop at, above 0.
    SetTargetSamples(u32),
    /// Sets the seconds of rendering to stop at; None is no limit.
    SetTimeLimit(Option<f32>),
    /// Sets the noise to stop at, relative to the picture's brightness; None is no limit.
    SetNoiseTarget(Option<f32>),
    /// Sends more samples where the noise is, or as many to every pixel.
    SetAdaptive(bool),
    /// Limits the samples to a part of the picture: (0, 0) is top left, (1, 1) bottom right. None stands for the
    /// whole picture.
    SetRegion(Option<Rect>),
    /// Sets the rendered pixels per pixel of the film along each side, above 0.
    SetResolutionScale(f32),
    /// Sets which pixels of the film are traced while the user works.
    SetResolution(Resolution),
    /// Traces all pixels of the film until the next change, and may save the picture then.
    RenderFull(FullFilm),
    /// Goes back from the full film to the pixels that the window shows.
    StopFull,
    /// Splits the picture into thirds by bsdf sampling, by light sampling, and by both.
    SetStrategySplit(bool),
    /// Lets the integrator `path` stand for `auto`, or for itself.
    SetPathIsAuto(bool),
    /// Keeps the light of every light by itself, for mixing.
    SetLightLayers(bool),
}

impl RenderCommand {
    pub(super) fn traits(&self) -> Traits {
        match self {
            Self::Restart
            | Self::SetResolutionScale(_)
            | Self::SetResolution(_)
            | Self::RenderFull(_)
            | Self::StopFull
            | Self::SetStrategySplit(_)
            | Self::SetPathIsAuto(_)
            | Self::SetLightLayers(_) => Traits::VIEW,
            Self::SetPaused(_)
            | Self::SetTargetSamples(_)
            | Self::SetTimeLimit(_)
            | Self::SetNoiseTarget(_)
            | Self::SetAdaptive(_)
            | Self::SetRegion(_) => Traits::NONE,
        }
    }
}
