//! Triangles tested together: the arithmetic of [`crate::geometry::triangle`] over the lanes of a packet.

use glam::Vec3;

use crate::geometry::triangle::volumes;
use crate::math::Ray;

pub(super) const LANES: usize = 4;

/// Corners in structure-of-arrays form. Unused lanes repeat one point, which no ray hits.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub(super) struct TrianglePacket {
    /// `corners[corner][axis][lane]`
    corners: [[[f32; LANES]; 3]; 3],
    /// The mesh's triangle in each lane.
    pub triangle: [u32; LANES],
}

/// A packet's nearest hit.
pub(super) struct PacketHit {
    pub t: f32,
    pub triangle: u32,
    pub u: f32,
    pub v: f32,
}

impl TrianglePacket {
    pub const EMPTY: Self = Self {
        corners: [[[0.0; LANES]; 3]; 3],
        triangle: [u32::MAX; LANES],
    };

    pub fn set(&mut self, lane: usize, corners: [Vec3; 3], triangle: u32) {
        for (corner, point) in corners.into_iter().enumerate() {
            for axis in 0..3 {
                self.corners[corner][axis][lane] = point[axis];
            }
        }
        self.triangle[lane] = triangle;
    }

    /// Ray parameters, weights, and a bit for each lane whose triangle is met within 0 < t < t_max.
    #[inline(always)]
    fn test(&self, ray: &Ray, t_max: f32) -> ([f32; LANES], [[f32; LANES]; 3], u32) {
        let (origin, dir) = (ray.origin.to_array(), ray.dir.to_array());
        let mut distance = [0.0; LANES];
        let mut weights = [[0.0; LANES]; 3];
        let mut hits = 0;
        for lane in 0..LANES {
            let corners = self
                .corners
                .each_ref()
                .map(|axes| axes.each_ref().map(|axis| axis[lane]));
            let volumes = volumes(origin, dir, corners);
            let t = volumes.t();
            distance[lane] = t;
            for (weights, weight) in weights.iter_mut().zip(volumes.weights) {
                weights[lane] = weight;
            }
            hits |= u32::from(volumes.inside() & (t > 0.0) & (t < t_max)) << lane;
        }
        (distance, weights, hits)
    }

    #[inline(always)]
    pub fn closest(&self, ray: &Ray, t_max: f32) -> Option<PacketHit> {
        let (distance, weights, mut hits) = self.test(ray, t_max);
        if hits == 0 {
            return None;
        }
        let mut nearest = hits.trailing_zeros() as usize % LANES;
        hits &= hits - 1;
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize % LANES;
            hits &= hits - 1;
            if distance[lane] < distance[nearest] {
                nearest = lane;
            }
        }
        let sum = weights[0][nearest] + weights[1][nearest] + weights[2][nearest];
        Some(PacketHit {
            t: distance[nearest],
            triangle: self.triangle[nearest],
            u: weights[1][nearest] / sum,
            v: weights[2][nearest] / sum,
        })
    }

    #[inline(always)]
    pub fn any(&self, ray: &Ray, t_max: f32) -> bool {
        self.test(ray, t_max).2 != 0
    }
}
