//! A scene's only light, for sixteen surfaces at once.

use super::LightTable;
use crate::light::constant::ConstantLight;
use crate::light::finite::FiniteLight;
use crate::light::infinite::InfiniteLight;
use crate::light::plain::{Glow, PlainSurface};
use crate::light::rectangle::UniformRectangle;
use crate::light::{LightId, LightSample, ReferenceLanes};
use crate::math::Same;
use crate::math::lanes::{LANES, Lanes, Vec3Lanes};

/// A bit for every lane.
const ALL: u32 = (1 << LANES) - 1;

/// The commonest kinds of lights that are alone in a scene.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SoleLight<'a> {
    Rectangle(UniformRectangle, Glow),
    Constant(&'a ConstantLight),
}

impl LightTable {
    /// The scene's only light; None if there are several or it cannot be sampled in lanes.
    pub(crate) fn sole(&self) -> Option<(LightId, SoleLight<'_>)> {
        if !self.choice.is_certain() {
            return None;
        }
        match (&self.finite[..], &self.infinite[..]) {
            ([finite], []) => match &finite.light {
                FiniteLight::Surface(light) => match light.plain()? {
                    PlainSurface::Rectangle(shape, glow) => Some((finite.id, SoleLight::Rectangle(shape, glow))),
                    PlainSurface::Sphere(..) => None,
                },
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
            Self::Rectangle(shape, glow) => {
                let point = Same::<Lanes>::same(*shape).sample(reference.position, u);
                Same::<Lanes>::same(*glow).towards(point, reference.position)
            }
            Self::Constant(light) => light.sample(&reference.of_lanes(ALL), u),
        }
    }

    /// Points on the light as of [`LightTable::sample_place`]; None if it is at infinity.
    #[inline(always)]
    pub fn place(&self, u: [Lanes; 2]) -> Option<Vec3Lanes> {
        match self {
            Self::Rectangle(shape, _) => Some(Same::<Lanes>::same(*shape).at(u)),
            Self::Constant(_) => None,
        }
    }
}
