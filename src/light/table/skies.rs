//! A sky with its sun among any lights, for sixteen surfaces at once.

use glam::Vec2;

use super::LightTable;
use crate::light::sun_sky::{SkySample, SunSkyLight};
use crate::light::{LightId, LightReference, LightSample};
use crate::math::lanes::{Lanes, each_lane, lanes_of};

/// The lanes that have chosen a sky with its sun, one and the same.
#[derive(Default)]
pub(crate) struct SkyLanes<'a> {
    /// A bit per lane.
    pub lanes: u32,
    sky: Option<(LightId, &'a SunSkyLight)>,
    /// The probabilities of the choice.
    pmf: Lanes,
}

impl LightTable {
    /// [`Self::sample`] for a lane. A sky with its sun is only noted in `skies`, and sampled for all lanes at once.
    pub(crate) fn sample_or_note<'a>(
        &'a self,
        lane: usize,
        reference: &LightReference,
        u_choice: f32,
        u: Vec2,
        skies: &mut SkyLanes<'a>,
    ) -> Option<(LightId, LightSample)> {
        let choice = self.choose(reference, u_choice, u)?;
        match (self.chosen_sky(choice.0), skies.sky) {
            (Some((id, _)), Some((noted, _))) if id != noted => self.sample_chosen(choice, reference, u),
            (Some(sky), _) => {
                skies.sky = Some(sky);
                skies.lanes |= 1 << lane;
                skies.pmf.as_mut_array()[lane] = choice.1;
                None
            }
            (None, _) => self.sample_chosen(choice, reference, u),
        }
    }
}

impl SkyLanes<'_> {
    /// The light, and directions to it with the choice in their density. The mask tells which there are. None if no lane has chosen it.
    #[inline(never)]
    pub fn sample(&self, u: [Lanes; 2]) -> Option<(LightId, SkySample<Lanes>, Lanes)> {
        let (id, sky) = self.sky?;
        let (sample, is_there) = sky.sample(lanes_of(self.lanes), u);
        debug_assert!(
            each_lane(is_there.to_bitmask())
                .all(|lane| sample.wi.get(lane).is_normalized() && sample.radiance.get(lane).is_finite()),
            "{id:?} is sampled as {:?} with {:?}",
            sample.wi,
            sample.radiance
        );
        let pdf = sample.pdf * self.pmf;
        Some((id, SkySample { pdf, ..sample }, is_there))
    }
}
