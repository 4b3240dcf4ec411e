//! A scene's only light, for sixteen surfaces at once.

use super::LightTable;
use crate::light::constant::ConstantLight;
use crate::light::finite::FiniteLight;
use crate::light::infinite::InfiniteLight;
use crate::light::surface::PlainRectangle;
use crate::light::{LightId, LightSample, ReferenceLanes};
use crate::math::lanes::{LANES, Lanes, Vec3Lanes};

/// A bit for every lane.
const ALL: u32 = (1 << LANES) - 1;

/// The commonest lights that a scene has alone.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SoleLight<'a> {
    Rectangle(PlainRectangle<'a>),
    Constant(&'a ConstantLight),
}

impl LightTable {
    /// The scene's only light, if there is one alone and it can be sampled in lanes.
    pub(crate) fn sole(&self) -> Option<(LightId, SoleLight<'_>)> {
        if !self.choice.is_certain() {
            return None;
        }
        match (&self.finite[..], &self.infinite[..]) {
            ([finite], []) => match &finite.light {
                FiniteLight::Surface(light) => Some((finite.id, SoleLight::Rectangle(light.plain_rectangle()?))),
                _ => None,
            },
            ([], [(id, InfiniteLight::Constant(light))]) => Some((*id, SoleLight::Constant(light))),
            _ => None,
        }
    }
}

impl SoleLight<'_> {
    /// Directions to the light as of [`LightTable::sample`].
    #[inline(always)]
    pub fn sample(&self, reference: &ReferenceLanes, u: [Lanes; 2]) -> LightSample<Lanes> {
        match self {
            Self::Rectangle(light) => light.sample(reference.position, u),
            Self::Constant(light) => light.sample(&reference.of_lanes(ALL), u),
        }
    }

    /// Places on the light as of [`LightTable::sample_place`]; None if it is at infinity.
    #[inline(always)]
    pub fn place(&self, u: [Lanes; 2]) -> Option<Vec3Lanes> {
        match self {
            Self::Rectangle(light) => Some(light.place(u)),
            Self::Constant(_) => None,
        }
    }
}
