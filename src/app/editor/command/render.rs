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
    /// Turns adaptive sampling on or off.
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
    /// Returns from the full film to the pixels of the window.
    StopFull,
    /// Splits the picture into thirds by bsdf sampling, by light sampling, and by both.
    SetStrategySplit(bool),
    /// Sets whether the integrator `path` stands for `auto`, or for itself.
    SetPathIsAuto(bool),
    /// Sets whether the film has a layer for each light, for mixing.
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
