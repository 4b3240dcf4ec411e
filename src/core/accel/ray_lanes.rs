//! Sixteen rays, one per lane.

use crate::math::lanes::{LANES, Lanes, Vec3Lanes, each_lane};
use crate::math::{PerLane, Ray};

/// Rays in lanes; the fields are those of [`Ray`].
#[derive(Clone, Copy, Debug)]
pub struct RayLanes {
    /// The origins.
    pub origin: Vec3Lanes,
    /// The directions, of any length.
    pub dir: Vec3Lanes,
    /// The least distances, in multiples of the directions.
    pub t_min: Lanes,
    /// The largest distances, in multiples of the directions; 0 in a lane without a ray.
    pub t_max: Lanes,
}

impl PerLane for Ray {
    type Lanes = RayLanes;

    #[inline(always)]
    fn splat(self) -> RayLanes {
        RayLanes::splat(&self)
    }

    #[inline(always)]
    fn gather_lane(lanes: &RayLanes, lane: usize) -> Self {
        lanes.get(lane)
    }

    #[inline(always)]
    fn scatter_lane(self, lanes: &mut RayLanes, lane: usize) {
        lanes.set(lane, &self);
    }
}

impl RayLanes {
    /// Rays that hit nothing.
    pub const NOWHERE: Self = Self {
        origin: Vec3Lanes::ZERO,
        dir: Vec3Lanes::ZERO,
        t_min: Lanes::ZERO,
        t_max: Lanes::ZERO,
    };

    /// At most as many rays as there are lanes; the other lanes are [`Self::NOWHERE`].
    pub fn of(rays: &[Ray]) -> Self {
        let mut lanes = Self::NOWHERE;
        for (lane, ray) in rays.iter().enumerate() {
            lanes.set(lane, ray);
        }
        lanes
    }

    /// The same ray in every lane.
    #[inline(always)]
    pub(super) fn splat(ray: &Ray) -> Self {
        Self {
            origin: Vec3Lanes::splat(ray.origin),
            dir: Vec3Lanes::splat(ray.dir),
            t_min: Lanes::splat(ray.t_min),
            t_max: Lanes::splat(ray.t_max),
        }
    }

    /// The rays as an array.
    #[inline(always)]
    pub(super) fn rays(&self) -> [Ray; LANES] {
        std::array::from_fn(|lane| self.get(lane))
    }

    /// Replaces the ray of a lane below [`LANES`].
    #[inline(always)]
    pub fn set(&mut self, lane: usize, ray: &Ray) {
        self.origin.set(lane, ray.origin);
        self.dir.set(lane, ray.dir);
        self.t_min.as_mut_array()[lane] = ray.t_min;
        self.t_max.as_mut_array()[lane] = ray.t_max;
    }

    /// Returns the ray of a lane below [`LANES`].
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Ray {
        Ray {
            origin: self.origin.get(lane),
            dir: self.dir.get(lane),
            t_min: self.t_min.as_array()[lane],
            t_max: self.t_max.as_array()[lane],
        }
    }

    /// The mask of the rays in `active` for which `condition` holds.
    #[inline(always)]
    pub(super) fn lanes_where(&self, active: u32, condition: impl Fn(&Ray) -> bool) -> u32 {
        each_lane(active).fold(0, |bits, lane| bits | u32::from(condition(&self.get(lane))) << lane)
    }

    /// The mask of the rays that may hit something: they are finite, and have a direction and a positive t_max.
    #[inline(always)]
    pub(super) fn valid_mask(&self) -> u32 {
        let largest = Lanes::splat(f32::MAX);
        let is_finite =
            |v: Vec3Lanes| v.x.abs().simd_le(largest) & v.y.abs().simd_le(largest) & v.z.abs().simd_le(largest);
        let is_ray = is_finite(self.origin) & is_finite(self.dir) & self.dir.is_not_zero();
        (is_ray & self.t_max.simd_gt(Lanes::ZERO)).to_bitmask()
    }
}
