//! Reference points, at which incoming light is sampled.

use glam::Vec3;

use crate::math::lanes::{Lanes, Vec3Lanes, lanes_of};
use crate::math::{PerLane, Real};

/// A point at which incoming light is sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightReference {
    /// A point in world space.
    pub position: Vec3,
    /// Unit normal of the half space that holds all directions of interest; None where all directions count, as on a
    /// surface that transmits. Lights wholly outside of the half space are not chosen.
    pub normal: Option<Vec3>,
}

/// Reference points, one per lane, as [`LightReference`].
#[derive(Clone, Copy, Debug)]
pub struct ReferenceLanes {
    /// The positions as [`LightReference::position`].
    pub position: Vec3Lanes,
    /// The normals as [`LightReference::normal`].
    pub normal: Vec3Lanes,
    /// The lanes that see only the half space around their normal, a bit per lane; the others have no normal.
    pub halved: u32,
}

impl PerLane for LightReference {
    type Lanes = ReferenceLanes;

    #[inline(always)]
    fn splat(self) -> ReferenceLanes {
        ReferenceLanes {
            position: self.position.splat(),
            normal: self.normal.unwrap_or(Vec3::ZERO).splat(),
            halved: self.normal.is_some().splat(),
        }
    }

    #[inline(always)]
    fn gather_lane(lanes: &ReferenceLanes, lane: usize) -> Self {
        Self {
            position: lanes.position.get(lane),
            normal: bool::gather_lane(&lanes.halved, lane).then(|| lanes.normal.get(lane)),
        }
    }

    #[inline(always)]
    fn scatter_lane(self, lanes: &mut ReferenceLanes, lane: usize) {
        let Self { position, normal } = self;
        lanes.position.set(lane, position);
        normal.is_some().scatter_lane(&mut lanes.halved, lane);
        if let Some(normal) = normal {
            lanes.normal.set(lane, normal);
        }
    }
}

/// The reference points for one light: a single one, or one per lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reference<R: Real = f32> {
    /// A mask of the points to sample.
    pub asked: R::Mask,
    pub position: R::Vec3,
    /// Unit normals where the points are [`Self::halved`].
    pub normal: R::Vec3,
    /// A mask of the points that have a [`LightReference::normal`].
    pub halved: R::Mask,
}

impl From<&LightReference> for Reference {
    #[inline(always)]
    fn from(reference: &LightReference) -> Self {
        Self {
            asked: true,
            position: reference.position,
            normal: reference.normal.unwrap_or(Vec3::Z),
            halved: reference.normal.is_some(),
        }
    }
}

impl ReferenceLanes {
    /// The points of the lanes `asked`, a bit each.
    #[inline(always)]
    pub(super) fn of_lanes(&self, asked: u32) -> Reference<Lanes> {
        Reference {
            asked: lanes_of(asked),
            position: self.position,
            normal: self.normal,
            halved: lanes_of(self.halved),
        }
    }
}
