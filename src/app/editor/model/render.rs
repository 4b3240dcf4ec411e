//! The content of the render panel.

use bevy::prelude::{Entity, Rect};

use super::painting::PaintingModel;
use crate::app::editor::command::compare_view::CompareView;
use crate::app::editor::command::light_mix::LightMix;
use crate::app::editor::command::resolution::{Enlarging, Resolution};
use crate::app::editor::picture::compare::Measured;
use crate::engine::AutoStatus;
use crate::render::clamp::BrightnessLimit;
use crate::scene::{AccelMethod, IntegratorSettings, SamplerSettings};

/// The render panel's content.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderModel {
    /// The samples per pixel to stop at.
    pub target_samples: u32,
    /// Rendered pixels per pixel of the film along each side.
    pub resolution_scale: f32,
    /// The pixels of the film that are traced.
    pub resolution: Resolution,
    /// The filter of a picture with fewer pixels than its panel.
    pub enlarging: Enlarging,
    /// The integrator of the scene.
    pub integrator: IntegratorSettings,
    /// The sampler of the scene.
    pub sampler: SamplerSettings,
    /// The acceleration structure of the scene.
    pub accel: AccelMethod,
    /// The longest time to render for, in seconds.
    pub time_limit: Option<f32>,
    /// The relative noise to stop at; None is no limit.
    pub noise_target: Option<f32>,
    /// Whether sampling is adaptive.
    pub adaptive: bool,
    /// The last estimate of the noise.
    pub noise: Option<f32>,
    /// The region that gets samples, (0, 0) top left, (1, 1) bottom right; None is the whole picture.
    pub region: Option<Rect>,
    /// Whether three thirds of the picture are rendered by different strategies.
    pub strategy_split: bool,
    /// Whether the integrator `path` stands for `auto`.
    pub path_is_auto: bool,
    /// The choice of the integrator `auto`, if that is set.
    pub auto: Option<AutoStatus>,
    /// The limit of the brightness of samples, once it is known.
    pub clamped: Option<BrightnessLimit>,
    /// The section for light mixing.
    pub mixing: MixingModel,
    /// The light you want.
    pub painting: PaintingModel,
    /// The section for comparison with a snapshot.
    pub comparison: ComparisonModel,
}

/// The mixing desk.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MixingModel {
    /// Whether the film has a layer for each light.
    pub is_on: bool,
    /// The channel of each light.
    pub mix: LightMix,
    /// The lights with a layer, and their names in the mix and the panel.
    pub lights: Vec<(Entity, String)>,
}

/// The snapshot, and how the picture is compared with it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ComparisonModel {
    /// The samples per pixel of the snapshot; None without one.
    pub snapshot: Option<u32>,
    /// Whether the snapshot is of a scene that was open before.
    pub is_of_other_scene: bool,
    /// The comparison in the viewport.
    pub view: CompareView,
    /// Whether there is a denoised picture to compare with, or will be.
    pub denoising: bool,
    /// The last measurement; None before the first.
    pub figures: Option<Measured>,
}
