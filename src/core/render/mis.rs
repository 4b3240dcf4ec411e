//! The weights of light that two techniques can find, light sampling and BSDF sampling (multiple importance sampling:
//! Veach 1997, chapter 9; PBR 4th ed., section 13.4.1).

use super::observer::MetEmitter;
use super::path_state::Arrival;
use super::view::Strategy;
use crate::color::Rgb;
use crate::light::{LightId, LightReference};
use crate::math::Real;
use crate::sampling::power_heuristic;

impl Strategy {
    /// Whether lights are sampled that BSDF sampling can find as well.
    pub(super) fn samples_lights(self) -> bool {
        self != Self::Bsdf
    }

    /// The weight of light that was found by light sampling with density `light_pdf`, in a direction that the BSDF
    /// samples with density `bsdf_pdf`. Only light sampling finds a light that `is_delta`.
    #[inline(always)]
    pub(super) fn light_weight<R: Real>(self, is_delta: R::Mask, light_pdf: R, bsdf_pdf: R) -> R {
        let weight = match self {
            Self::Mis => power_heuristic(light_pdf, bsdf_pdf),
            Self::Light => R::splat(1.0),
            Self::Bsdf => R::splat(0.0),
        };
        R::select(is_delta, R::splat(1.0), weight)
    }
}

/// The weight of an emitter that the path has hit by BSDF sampling, and its parts as in [`MetEmitter`].
pub(super) struct EmitterWeight {
    weight: f32,
    bsdf_pdf: Option<f32>,
    light_pdf: Option<f32>,
}

impl Arrival {
    /// The weight of an emitter that the path has hit. `light_pdf` is the density with which light sampling would have
    /// found it from a reference point.
    #[inline(always)]
    pub fn weigh(&self, strategy: Strategy, light_pdf: impl FnOnce(&LightReference) -> f32) -> EmitterWeight {
        let bsdf_pdf = self.is_sampled.then_some(self.pdf);
        let (weight, light_pdf) = match (bsdf_pdf, strategy) {
            (None, _) | (_, Strategy::Bsdf) => (1.0, None),
            (_, Strategy::Light) => (0.0, None),
            (Some(bsdf_pdf), Strategy::Mis) => {
                let light_pdf = light_pdf(&self.from);
                (power_heuristic(bsdf_pdf, light_pdf), Some(light_pdf))
            }
        };
        EmitterWeight {
            weight,
            bsdf_pdf,
            light_pdf,
        }
    }
}

impl EmitterWeight {
    /// The hit emitter with this weight, where the path has arrived with `throughput`.
    #[inline(always)]
    pub fn emitter(self, light: LightId, radiance: Rgb, throughput: Rgb) -> MetEmitter {
        MetEmitter {
            light,
            radiance,
            bsdf_pdf: self.bsdf_pdf,
            light_pdf: self.light_pdf,
            weight: self.weight,
            contribution: throughput * radiance * self.weight,
        }
    }
}
