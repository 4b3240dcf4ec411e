//! Phase functions: the plugins for the directions of light scattered in media, each declared once.

use std::ops::DerefMut;

use bevy::prelude::*;

use super::VolumeParameter;
use crate::scene::components::declare::{PluginInfo, declare_plugins};
use crate::scene::components::parameter_info::ParameterInfo;
use crate::scene::components::parameters::{Declared, ParameterMut, ParameterRef};

declare_plugins! {
    /// The distribution of directions into which a medium scatters light. All integrate to 1 over the sphere.
    #[derive(Reflect, Clone, Debug, PartialEq)]
    #[reflect(opaque)]
    #[reflect(Clone, PartialEq)]
    pub enum PhaseFunction {
        [PluginInfo::new("isotropic", "isotropic")]
        Isotropic,

        [PluginInfo::new("hg", "Henyey-Greenstein")]
        HenyeyGreenstein { g: f32 = 0.8 => Number(G) },

        [PluginInfo::new("rayleigh", "Rayleigh")]
        Rayleigh,

        /// Values at equal distances of the cosine of the angle between the directions of light before and after, from
        /// -1 (back) to 1 (forward). They need not be normalised.
        [PluginInfo::new("tabphase", "table")]
        Tabulated { values: Vec<f32> = vec![1.0, 1.0] => Values(VALUES) },

        /// A mixture of two.
        [PluginInfo::new("blendphase", "blend")]
        Blend(blend: Box<PhaseBlend> => DerefMut::deref_mut),
    }
}

impl Default for PhaseFunction {
    /// The format's default.
    fn default() -> Self {
        Self::Isotropic
    }
}

impl PhaseFunction {
    /// The most phase functions in one, blends included. Real ones have a few.
    pub(crate) const MOST: usize = 64;
    /// The most values of a table.
    pub(crate) const MOST_VALUES: usize = 1 << 16;

    /// Calls `meet` with every parameter that may vary in space, nested phase functions included.
    pub fn for_each_volume(&self, meet: &mut dyn FnMut(&VolumeParameter<f32>)) {
        if let Self::Blend(blend) = self {
            meet(&blend.weight);
            blend.of.iter().for_each(|inside| inside.for_each_volume(meet));
        }
    }

    /// [`Self::for_each_volume`] with mutable parameters.
    pub(crate) fn for_each_volume_mut(&mut self, meet: &mut dyn FnMut(&mut VolumeParameter<f32>)) {
        if let Self::Blend(blend) = self {
            meet(&mut blend.weight);
            blend.of.iter_mut().for_each(|inside| inside.for_each_volume_mut(meet));
        }
    }

    /// The nested phase functions.
    pub(crate) fn inside(&self) -> &[Self] {
        match self {
            Self::Blend(blend) => &blend.of,
            _ => &[],
        }
    }
}

/// A mixture of two phase functions.
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseBlend {
    /// The share of the second one, in [0, 1].
    pub weight: VolumeParameter<f32>,
    /// The blended phase functions.
    pub of: [PhaseFunction; 2],
}

impl Default for PhaseBlend {
    fn default() -> Self {
        Self {
            weight: 0.5.into(),
            of: [PhaseFunction::Isotropic, PhaseFunction::Isotropic],
        }
    }
}

impl Declared for PhaseBlend {
    fn visit<'p>(&'p self, meet: &mut impl FnMut(&'static ParameterInfo, ParameterRef<'p>)) {
        meet(&WEIGHT, ParameterRef::VolumeShare(&self.weight));
    }

    fn visit_mut(&mut self, meet: &mut impl FnMut(&'static ParameterInfo, ParameterMut)) {
        meet(&WEIGHT, ParameterMut::VolumeShare(&mut self.weight));
    }
}

const G: ParameterInfo = ParameterInfo::new(
    "g",
    "Anisotropy",
    "The mean cosine of the angle by which light is turned: above 0 it goes on forwards, as in fog and skin; below 0 it goes back.",
    "above -1 and below 1; 0 is the same in all directions",
)
.within((-1.0f32).next_up()..=1.0f32.next_down())
.offering(-0.95..=0.95);

const VALUES: ParameterInfo = ParameterInfo::new(
    "values",
    "Values",
    "How much light goes which way: numbers at equal distances of the cosine, from back to onwards.",
    "two numbers or more, not negative",
);

static WEIGHT: ParameterInfo = ParameterInfo::new(
    "weight",
    "Weight",
    "The share of the second phase function; the first has the rest.",
    "0 to 1, or a volume",
)
.within(0.0..=1.0);
