//! The bake of lightmaps: how it is done, and what the user asks of it.

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

/// How lightmaps are baked. The defaults are those of `sunroom bake`.
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
    /// Whether the direct light of points, spots and directional lights is left to the game.
    pub indirect_only: bool,
    /// Whether probes are baked.
    pub probes: bool,
    /// Whether noise is removed.
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

    /// The same without numbers that cannot be.
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

    /// What ends it.
    pub fn limits(&self) -> BakeLimits {
        BakeLimits {
            samples: self.samples,
            time: self.time.and_then(|time| Duration::try_from_secs_f32(time).ok()),
            noise: self.noise,
        }
    }
}

/// How the open scene is baked: what is remembered of it.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct BakePlan {
    /// How lightmaps are baked.
    pub choices: BakeChoices,
    /// The folder of the last bake, or that was chosen for the next one.
    pub folder: Option<PathBuf>,
}

/// What the user asks of the bake.
#[derive(Clone, Debug, PartialEq)]
pub enum BakeCommand {
    /// Sets how the next one is done.
    Choose(BakeChoices),
    /// Sets the folder of the next one.
    ChooseFolder(PathBuf),
    /// Begins to bake the scene as it is now into this folder.
    Begin(PathBuf),
    /// Ends the gathering of light, and writes what there is.
    Stop,
    /// Gives the bake up. Nothing is written.
    Discard,
    /// Shows this lightmap, from 0.
    ShowPage(usize),
    /// Closes what is shown of a bake that has ended.
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
