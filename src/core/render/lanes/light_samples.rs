//! Samples directions from vertices to lights.

use super::context::Context;
use crate::light::{Alike, LightId, LightSample, ReferenceLanes, Target};
use crate::math::lanes::{LANES, Lanes, Vec3Lanes, WordLanes, each_lane, lanes_of};
use crate::math::{PerLane, Vector};
use crate::render::dimensions::BounceDraw;
use crate::sampling::lanes::SamplerLanes;

/// Directions to lights, with the light that would arrive from there unoccluded.
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

    /// Samples a light for each of the lanes `asked`, by the random numbers of the vertices at `depth`. Densities are
    /// per solid angle, the choice included. The other lanes are undefined. With a factor `raised`, the number that
    /// chooses a light is multiplied by it.
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
        if let Some((id, light)) = context.sole_light {
            return Self::of([id; LANES], light.sample(&seen_from, u));
        }
        let mut u_choice = sampler.at_1d(BounceDraw::LightChoice.at(depth));
        if let Some(raised) = raised {
            u_choice *= raised;
        }
        Self::chosen(context, asked, seen_from, [u_choice, u[0], u[1]])
    }

    /// Samples of these lights.
    #[inline(always)]
    fn of(light: [LightId; LANES], sample: LightSample<Lanes>) -> Self {
        let (target, infinite) = match sample.target {
            Target::Point(target) => (target, false),
            Target::Infinity => (Vec3Lanes::ZERO, true),
        };
        Self {
            light,
            wi: sample.wi,
            target,
            infinite: infinite.splat(),
            radiance: sample.radiance,
            pdf: sample.pdf,
            is_delta: sample.is_delta.splat(),
            is_valid: sample.pdf.simd_gt(Lanes::ZERO),
        }
    }

    /// Replaces the samples of the lanes `here`.
    fn set(&mut self, here: Lanes, other: &Self) {
        let lanes = here.to_bitmask();
        each_lane(lanes).for_each(|lane| self.light[lane] = other.light[lane]);
        self.wi = Vec3Lanes::select(here, other.wi, self.wi);
        self.target = Vec3Lanes::select(here, other.target, self.target);
        self.infinite = self.infinite & !lanes | other.infinite & lanes;
        self.radiance = Vec3Lanes::select(here, other.radiance, self.radiance);
        self.pdf = here.select(other.pdf, self.pdf);
        self.is_delta = self.is_delta & !lanes | other.is_delta & lanes;
        self.is_valid = here.select(other.is_valid, self.is_valid);
    }

    /// Replaces the sample of a lane.
    #[inline(always)]
    fn set_lane(&mut self, lane: usize, id: LightId, sample: &LightSample) {
        let bit = 1 << lane;
        self.light[lane] = id;
        self.wi.set(lane, sample.wi);
        self.radiance.set(lane, sample.radiance);
        self.pdf.as_mut_array()[lane] = sample.pdf;
        self.is_delta |= if sample.is_delta { bit } else { 0 };
        match sample.target {
            Target::Point(target) => self.target.set(lane, target),
            Target::Infinity => self.infinite |= bit,
        }
        self.is_valid |= lanes_of(bit);
    }

    /// Samples the lights that the lanes `asked` choose. Not inlined, because values set lane by lane are in memory.
    #[inline(never)]
    fn chosen(context: &Context, asked: u32, seen_from: ReferenceLanes, u: [Lanes; 3]) -> Self {
        let lights = &context.scene.lights;
        let mut choices = lights.choose_lanes(asked, &seen_from, u);
        let u = [u[1], u[2]];
        let mut chosen = Self::NONE;
        while let Some(alike) = choices.take_alike() {
            match alike {
                Alike::Lanes(lanes) => {
                    let (ids, sample) = lights.sample_lanes(lanes, &choices, &seen_from, u);
                    chosen.set(lanes_of(lanes), &Self::of(ids, sample));
                }
                Alike::Plain(lanes) => {
                    if let Some((ids, sample)) = lights.sample_plain(lanes, &choices, &seen_from, u) {
                        chosen.set(lanes_of(lanes), &Self::of(ids, sample));
                    }
                }
                Alike::Lane(lane) => {
                    if let Some((id, sample)) = lights.sample_lane(lane, &choices, &seen_from, u) {
                        chosen.set_lane(lane, id, &sample);
                    }
                }
            }
        }
        chosen
    }
}
