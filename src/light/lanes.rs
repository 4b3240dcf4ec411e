//! The commonest lights for sixteen surfaces at once: a scene's only light, which is a rectangle that is equally bright all over, or the
//! same from everywhere.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;

use super::LightReference;
use crate::color::Rgb;
use crate::math::PerLane;
use crate::math::Vector;
use crate::math::lanes::{FrameLanes, Lanes, Vec3Lanes, offset_origins};
use crate::sampling::lanes::RectangleLanes;
use crate::sampling::warp::cosine_hemisphere;

/// A rectangle that is the only light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SoleRectangle {
    /// The radiance in W/(m^2 sr), from the front.
    pub radiance: Rgb,
    pub(super) rectangle: RectangleLanes,
    pub(super) corner: Vec3,
    pub(super) edges: [Vec3; 2],
    pub(super) normal: Vec3,
    pub(super) pdf_area: f32,
    /// The bound on the rounding error of its points.
    pub(super) error: f32,
}

/// The points from which light is sought in each lane, as [`LightReference`].
#[derive(Clone, Copy, Debug)]
pub struct ReferenceLanes {
    /// The positions as [`LightReference::position`].
    pub position: Vec3Lanes,
    /// The normals as [`LightReference::normal`].
    pub normal: Vec3Lanes,
    /// The lanes that see the half space around their normal only, a bit per lane; the others have no normal.
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

/// A direction towards the light per lane, as [`super::LightSample`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct RectangleLightSampleLanes {
    /// Unit vectors towards the light.
    pub wi: Vec3Lanes,
    /// The ends of the shadow rays.
    pub target: Vec3Lanes,
    /// The densities per solid angle.
    pub pdf: Lanes,
    /// The lanes that it shines on.
    pub is_valid: Lanes,
}

/// A scene's only light.
#[derive(Clone, Copy, Debug)]
pub(crate) enum SoleLight {
    /// A rectangle of constant radiance.
    Rectangle(SoleRectangle),
    /// The same radiance from everywhere.
    Constant(Rgb),
}

/// Samples directions to a constant light by their cosine with the unit vectors `normal`, as [`super::LightTable::sample`] does, with their
/// densities, which are zero where there is none.
#[inline(always)]
pub(crate) fn sample_constant(normal: Vec3Lanes, u: [Lanes; 2]) -> (Vec3Lanes, Lanes) {
    let local = cosine_hemisphere(u);
    let wi = FrameLanes::from_normal(normal).to_world(local);
    (wi, local.z * Lanes::splat(FRAC_1_PI))
}

impl SoleRectangle {
    /// Places on the light as of [`super::LightTable::sample_place`].
    #[inline(always)]
    pub fn place(&self, u: [Lanes; 2]) -> Vec3Lanes {
        Vec3Lanes::splat(self.corner)
            .plus_scaled(u[0], Vec3Lanes::splat(self.edges[0]))
            .plus_scaled(u[1], Vec3Lanes::splat(self.edges[1]))
    }

    /// Samples directions to the light from the positions `reference`, as [`super::LightTable::sample`] does for one position.
    #[inline(always)]
    pub fn sample(&self, reference: Vec3Lanes, u: [Lanes; 2]) -> RectangleLightSampleLanes {
        let zero = Lanes::ZERO;
        let normal = Vec3Lanes::splat(self.normal);
        let from_corner = reference - Vec3Lanes::splat(self.corner);
        let before = from_corner.dot(normal).simd_gt(zero);
        let seen = self.rectangle.sample(reference, u);
        let mut position = seen.position;
        let mut pdf = Lanes::ONE / seen.solid_angle;
        let tiny = before & !seen.is_valid;
        if tiny.any() {
            let by_area = self.place(u);
            let to_reference = reference - by_area;
            let distance_squared = to_reference.length_squared();
            let cos = to_reference.dot(normal).abs() / distance_squared.sqrt();
            position = Vec3Lanes::select(tiny, by_area, position);
            pdf = tiny.select(Lanes::splat(self.pdf_area) * distance_squared / cos, pdf);
        }
        let toward = position - reference;
        let wi = toward.normalize();
        let target = offset_origins(position, Lanes::splat(self.error), normal, -toward);
        RectangleLightSampleLanes {
            wi,
            target,
            pdf,
            is_valid: before & pdf.simd_gt(zero) & pdf.simd_lt(Lanes::splat(f32::INFINITY)) & wi.x.is_finite(),
        }
    }
}
