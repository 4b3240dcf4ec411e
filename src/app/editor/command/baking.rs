//! The bake of lightmaps: its settings, and the user's commands.

use super::traits::Traits;

use std::path::PathBuf;
use std::time::Duration;

use bevy::prelude::Resource;
use serde::{Deserialize, Serialize};

use crate::bake::job::BakeSettings;
use crate::bake::limits::BakeLimits;
use crate::bake::manifest::BakedLight;
use crate::bake::probes::ProbeSettings;
use crate::bake::unwrap::{ATLAS_SIZES, UnwrapSettings};

/// The settings of bakes. The defaults are those of `sunroom bake`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct BakeChoices {
    /// Texels per unit of length, above 0; None is as many as fit in one lightmap.
    pub texels_per_unit: Option<f32>,
    /// The width of a lightmap and its largest height, in texels.
    pub atlas_size: u32,
    /// Samples per texel; None is 64, or as many as the other limits allow.
    pub samples: Option<u32>,
    /// The seconds to stop at; None is no limit.
    pub time: Option<f32>,
    /// The noise to stop at; None is no limit.
    pub noise: Option<f32>,
    /// Whether the lightmaps leave out the direct light of points, spots and directional lights, which the game adds.
    pub indirect_only: bool,
    /// Whether probes are baked.
    pub probes: bool,
    /// Whether the lightmaps are denoised.
    pub denoise: bool,
}

impl Default for BakeChoices {
    fn default() -> Self {
        Self {
            texels_per_unit: None,
            atlas_size: UnwrapSettings::default().atlas_size,
            samples: None,
            time: None,
            noise: None,
            indirect_only: false,
            probes: true,
            denoise: cfg!(feature = "denoise"),
        }
    }
}

impl BakeChoices {
    /// The settings of the bake.
    pub fn settings(&self) -> BakeSettings {
        BakeSettings {
            unwrap: UnwrapSettings {
                atlas_size: self.atlas_size,
                texels_per_unit: self.texels_per_unit,
                ..UnwrapSettings::default()
            },
            light: match self.indirect_only {
                true => BakedLight::WithoutDirectPunctual,
                false => BakedLight::All,
            },
            probes: self.probes.then(ProbeSettings::default),
            denoise: self.denoise,
        }
    }

    /// The same with invalid numbers replaced.
    pub fn within_range(self) -> Self {
        let [first, last] = [*ATLAS_SIZES.start(), *ATLAS_SIZES.end()];
        let is_positive = |number: &f32| *number > 0.0 && number.is_finite();
        Self {
            texels_per_unit: self.texels_per_unit.filter(is_positive),
            atlas_size: self.atlas_size.clamp(first, last),
            samples: self.samples.filter(|samples| *samples > 0),
            time: self.time.filter(is_positive),
            noise: self.noise.filter(is_positive),
            ..self
        }
    }

    /// The limits that end the bake.
    pub fn limits(&self) -> BakeLimits {
        BakeLimits {
            samples: self.samples,
            time: self.time.and_then(|time| Duration::try_from_secs_f32(time).ok()),
            noise: self.noise,
        }
    }
}

/// The remembered bake of the open scene.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct BakePlan {
    /// The settings.
    pub choices: BakeChoices,
    /// The folder of the last bake, or the one chosen for the next.
    pub folder: Option<PathBuf>,
}

/// A command about the bake.
#[derive(Clone, Debug, PartialEq)]
pub enum BakeCommand {
    /// Sets the settings of the next one.
    Choose(BakeChoices),
    /// Sets the folder of the next one.
    ChooseFolder(PathBuf),
    /// Begins to bake the scene as it is now into this folder.
    Begin(PathBuf),
    /// Ends the tracing of light, and writes the result so far.
    Stop,
    /// Discards the bake. Nothing is written.
    Discard,
    /// Shows this lightmap, from 0.
    ShowPage(usize),
    /// Closes the view of an ended bake.
    Close,
}

impl BakeCommand {
    pub(super) fn traits(&self) -> Traits {
        match self {
            Self::Choose(_)
            | Self::ChooseFolder(_)
            | Self::Begin(_)
            | Self::Stop
            | Self::Discard
            | Self::ShowPage(_)
            | Self::Close => Traits::NONE,
        }
    }
}
