//! The parameters of a medium, each declared once.

use bevy::math::Affine3A;
use bevy::prelude::*;

use super::coefficients::{Coefficients, SIGMA_T};
use super::{PhaseFunction, VolumeParameter};
use crate::color::Rgb;
use crate::scene::DocumentOrder;
use crate::scene::components::parameter_info::ParameterInfo;
use crate::scene::components::parameters::{Declared, ParameterMut, ParameterRef};

/// A participating medium, which fills the space between surfaces. In the file it is `homogeneous` if its density is
/// the same everywhere, otherwise `heterogeneous`.
#[derive(Component, Reflect, Clone, Debug, PartialEq)]
#[reflect(Component, PartialEq)]
#[require(DocumentOrder)]
pub struct Medium {
    /// Extinction and albedo.
    pub coefficients: Coefficients,
    /// A factor on the coefficients, at least 0.
    pub scale: f32,
    /// The directions of scattered light.
    pub phase: PhaseFunction,
    /// The radiance emitted per unit of length, in W/(m^3 sr), independent of density and albedo.
    pub emission: VolumeParameter<Rgb>,
    /// A factor on the emission, at least 0.
    pub emission_scale: f32,
}

impl Default for Medium {
    fn default() -> Self {
        Self {
            coefficients: Coefficients::default(),
            scale: 1.0,
            phase: PhaseFunction::default(),
            emission: Rgb::ZERO.into(),
            emission_scale: 1.0,
        }
    }
}

/// The phase function is declared separately.
impl Declared for Medium {
    fn visit<'p>(&'p self, meet: &mut impl FnMut(&'static ParameterInfo, ParameterRef<'p>)) {
        meet(&SIGMA_T, ParameterRef::Coefficients(&self.coefficients));
        meet(&SCALE, ParameterRef::Factor(&self.scale));
        meet(&EMISSION, ParameterRef::VolumeEmission(&self.emission));
        meet(&EMISSION_SCALE, ParameterRef::ExtensionFactor(&self.emission_scale));
    }

    fn visit_mut(&mut self, meet: &mut impl FnMut(&'static ParameterInfo, ParameterMut)) {
        meet(&SIGMA_T, ParameterMut::Coefficients(&mut self.coefficients));
        meet(&SCALE, ParameterMut::Factor(&mut self.scale));
        meet(&EMISSION, ParameterMut::VolumeEmission(&mut self.emission));
        meet(&EMISSION_SCALE, ParameterMut::ExtensionFactor(&mut self.emission_scale));
    }
}

impl Medium {
    /// The plugins of the file.
    pub const PLUGINS: [&'static str; 2] = [HOMOGENEOUS, HETEROGENEOUS];

    /// The plugin's name in the file.
    pub fn plugin(&self) -> &'static str {
        match &self.coefficients {
            Coefficients::Extinction {
                sigma_t: VolumeParameter::Constant(_),
                ..
            }
            | Coefficients::Separate { .. } => HOMOGENEOUS,
            Coefficients::Extinction { .. } => HETEROGENEOUS,
        }
    }

    /// The medium of a plugin with default parameters; None if there is no such plugin.
    pub fn of_plugin(plugin: &str) -> Option<Self> {
        let mut medium = Self::default();
        match (plugin, &mut medium.coefficients) {
            (HETEROGENEOUS, Coefficients::Extinction { sigma_t, .. }) => {
                *sigma_t = VolumeParameter::Box {
                    value: Rgb::ONE,
                    to_world: Affine3A::IDENTITY,
                };
            }
            (HOMOGENEOUS, _) => {}
            _ => return None,
        }
        Some(medium)
    }

    /// Calls `meet` with every grid among the parameters.
    pub fn for_each_grid(&self, meet: &mut dyn FnMut(&super::GridFile)) {
        self.for_each_placed(&mut |_, file| file.into_iter().for_each(&mut *meet));
    }
}

impl Medium {
    /// Calls `meet` with every volume that has a transform: the one from the unit cube to the world, and the file of a
    /// grid.
    pub(crate) fn for_each_placed(&self, meet: &mut dyn FnMut(&Affine3A, Option<&super::GridFile>)) {
        let of_coefficients = match &self.coefficients {
            Coefficients::Extinction { sigma_t, albedo } => [Some(sigma_t), Some(albedo)],
            Coefficients::Separate { .. } => [None, None],
        };
        let of_colors = of_coefficients.into_iter().flatten().chain([&self.emission]);
        for (to_world, file) in of_colors.filter_map(VolumeParameter::placed) {
            meet(to_world, file);
        }
        self.phase.for_each_volume(&mut |weight| {
            if let Some((to_world, file)) = weight.placed() {
                meet(to_world, file);
            }
        });
    }

    /// The mean free path by colour, in units of the world; infinite without extinction. None if the extinction varies
    /// in space.
    pub fn mean_free_path(&self) -> Option<Rgb> {
        Some((self.coefficients.uniform_extinction()? * self.scale).recip())
    }

    /// Sets [`Self::mean_free_path`]. Colours whose path is not above 0, or is unchanged, keep their extinction. False
    /// if the extinction varies in space or the density is 0.
    pub fn set_mean_free_path(&mut self, path: Rgb) -> bool {
        let (Some(extinction), Some(before)) = (self.coefficients.uniform_extinction(), self.mean_free_path()) else {
            return false;
        };
        if self.scale <= 0.0 {
            return false;
        }
        let (path, before, most) = (path.to_array(), before.to_array(), *SIGMA_T.range.end());
        let mut extinction = extinction.to_array();
        for color in 0..3 {
            if path[color] > 0.0 && path[color] != before[color] {
                extinction[color] = (path[color] * self.scale).recip().min(most);
            }
        }
        self.coefficients.set_uniform_extinction(Rgb::from_array(extinction));
        true
    }

    /// Calls `meet` with a mutable transform, from the unit cube to the world, of every volume that has one.
    pub(crate) fn for_each_place(&mut self, meet: &mut dyn FnMut(&mut Affine3A)) {
        if let Coefficients::Extinction { sigma_t, albedo } = &mut self.coefficients {
            [sigma_t, albedo]
                .into_iter()
                .filter_map(VolumeParameter::place_mut)
                .for_each(&mut *meet);
        }
        self.emission.place_mut().into_iter().for_each(&mut *meet);
        self.phase.for_each_volume_mut(&mut |weight| {
            weight.place_mut().into_iter().for_each(&mut *meet);
        });
    }

    /// Calls `meet` with every grid among the parameters, mutable.
    pub(crate) fn for_each_grid_mut(&mut self, meet: &mut dyn FnMut(&mut super::GridFile)) {
        if let Coefficients::Extinction { sigma_t, albedo } = &mut self.coefficients {
            [sigma_t, albedo]
                .into_iter()
                .filter_map(VolumeParameter::grid_mut)
                .for_each(&mut *meet);
        }
        self.emission.grid_mut().into_iter().for_each(&mut *meet);
        self.phase.for_each_volume_mut(&mut |weight| {
            weight.grid_mut().into_iter().for_each(&mut *meet);
        });
    }

    /// Whether any of its values has a transform.
    pub(crate) fn has_place(&self) -> bool {
        let mut found = false;
        self.for_each_placed(&mut |_, _| found = true);
        found
    }
}

const HOMOGENEOUS: &str = "homogeneous";
const HETEROGENEOUS: &str = "heterogeneous";

static SCALE: ParameterInfo = ParameterInfo::factor(
    "scale",
    "Density",
    "Factor on the coefficients: how much of the medium there is. 2 is twice as dense.",
);

static EMISSION_SCALE: ParameterInfo =
    ParameterInfo::factor("emission_scale", "Emission scale", "Factor on the emission.");

static EMISSION: ParameterInfo = ParameterInfo::new(
    "emission",
    "Emission",
    "The light that the medium sends out on a unit of length, as fire does. It does not depend on the density.",
    "0 or more per channel, W/(m^3 sr), or a volume",
)
.within(0.0..=f32::MAX);
