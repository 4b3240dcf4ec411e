//! Samples directions from vertices to lights.

use glam::Vec2;

use super::context::Context;
use crate::light::lanes::{ReferenceLanes, SoleLight, sample_constant};
use crate::light::{LightId, LightReference, SkyLanes, Target};
use crate::math::PerLane;
use crate::math::Vector;
use crate::math::lanes::{LANES, Lanes, Vec3Lanes, WordLanes, each_lane, lanes_of};
use crate::render::dimensions::BounceDraw;
use crate::sampling::lanes::SamplerLanes;

/// Directions to a light, with the light that arrives from there unless something is in between.
#[derive(Clone, Copy)]
pub(super) struct LightLanes {
    pub light: [LightId; LANES],
    pub wi: Vec3Lanes,
    pub target: Vec3Lanes,
    /// The lanes whose light is at infinity, in the direction `wi`, a bit each.
    pub infinite: u32,
    pub radiance: Vec3Lanes,
    pub pdf: Lanes,
    pub is_delta: u32,
    pub is_valid: Lanes,
}

impl LightLanes {
    const NONE: Self = Self {
        light: [LightId(0); LANES],
        wi: Vec3Lanes::ZERO,
        target: Vec3Lanes::ZERO,
        infinite: 0,
        radiance: Vec3Lanes::ZERO,
        pdf: Lanes::ONE,
        is_delta: 0,
        is_valid: Lanes::ZERO,
    };

    pub fn target(&self, lane: usize) -> Target {
        match self.infinite >> lane & 1 {
            0 => Target::Point(self.target.get(lane)),
            _ => Target::Infinity,
        }
    }

    /// A light for each of the lanes `asked`, by the numbers of the vertices at `depth`. Densities are per solid angle, the choice
    /// included. The other lanes mean nothing, valid or not. If there is a factor `raised`, the number that chooses a light is multiplied by it.
    #[inline(always)]
    pub fn sample(
        context: &Context,
        asked: u32,
        seen_from: ReferenceLanes,
        sampler: &SamplerLanes,
        depth: WordLanes,
        raised: Option<Lanes>,
    ) -> Self {
        let u = sampler.at_2d(BounceDraw::LightPoint.at(depth));
        let (light, alone) = match &context.sole_light {
            Some((id, SoleLight::Rectangle(rectangle))) => {
                let sample = rectangle.sample(seen_from.position, u);
                return Self {
                    light: [*id; LANES],
                    wi: sample.wi,
                    target: sample.target,
                    infinite: 0,
                    radiance: Vec3Lanes::splat(rectangle.radiance),
                    pdf: sample.pdf,
                    is_delta: 0,
                    is_valid: sample.is_valid,
                };
            }
            Some((id, SoleLight::Constant(radiance))) => {
                let (wi, pdf) = sample_constant(seen_from.normal, u);
                let light = Self {
                    light: [*id; LANES],
                    wi,
                    target: Vec3Lanes::ZERO,
                    infinite: asked,
                    radiance: Vec3Lanes::splat(*radiance),
                    pdf,
                    is_delta: 0,
                    is_valid: pdf.simd_gt(Lanes::ZERO),
                };
                let everywhere = asked & !seen_from.halved;
                if everywhere == 0 {
                    return light;
                }
                (light, everywhere)
            }
            None => (Self::NONE, asked),
        };
        let mut u_choice = sampler.at_1d(BounceDraw::LightChoice.at(depth));
        if let Some(raised) = raised {
            u_choice *= raised;
        }
        light.with_others(context, alone, seen_from, [u_choice, u[0], u[1]])
    }

    /// Replaces the samples of the lanes `asked`: the sky for all that have chosen it, other lights one by one. It is not inlined, because what is set lane
    /// by lane is in memory.
    #[inline(never)]
    fn with_others(mut self, context: &Context, asked: u32, seen_from: ReferenceLanes, u: [Lanes; 3]) -> Self {
        self.infinite &= !asked;
        let mut valid = self.is_valid.to_bitmask() & !asked;
        let mut skies = SkyLanes::default();
        for lane in each_lane(asked) {
            let [u_choice, x, y] = u.map(|numbers| numbers.as_array()[lane]);
            let place = Vec2::new(x, y);
            let reference = LightReference::gather_lane(&seen_from, lane);
            let lights = &context.scene.lights;
            let Some((id, sample)) = lights.sample_or_note(lane, &reference, u_choice, place, &mut skies) else {
                continue;
            };
            let bit = 1 << lane;
            valid |= bit;
            self.light[lane] = id;
            self.wi.set(lane, sample.wi);
            self.radiance.set(lane, sample.radiance);
            self.pdf.as_mut_array()[lane] = sample.pdf;
            self.is_delta |= if sample.is_delta { bit } else { 0 };
            match sample.target {
                Target::Point(target) => self.target.set(lane, target),
                Target::Infinity => self.infinite |= bit,
            }
        }
        if let Some((id, sample, is_there)) = skies.sample([u[1], u[2]]) {
            self.wi = Vec3Lanes::select(is_there, sample.wi, self.wi);
            self.radiance = Vec3Lanes::select(is_there, sample.radiance, self.radiance);
            self.pdf = is_there.select(sample.pdf, self.pdf);
            let lanes = is_there.to_bitmask();
            each_lane(lanes).for_each(|lane| self.light[lane] = id);
            self.infinite |= lanes;
            valid |= lanes;
        }
        self.is_valid = lanes_of(valid);
        self
    }
}
