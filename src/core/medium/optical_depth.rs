//! The optical depth of a path segment: the integral of the extinction along it, whose negative exponential is the
//! transmittance (PBR 4th ed., section 11.2). It is found by quadrature instead of tracking, because the logarithm of
//! an estimate would be biased.

use glam::Vec3;

use super::{Medium, Volume, Way};
use crate::color::Rgb;
use crate::math::Aabb;

/// The quadrature steps per edge of a voxel.
const STEPS_PER_VOXEL: f32 = 2.0;
/// The most steps along a segment.
const MOST_STEPS: f32 = 4096.0;

impl Medium {
    /// The optical depth of a segment, per channel. It is infinite for an infinite segment through a homogeneous
    /// medium.
    pub fn optical_depth(&self, way: &Way) -> Rgb {
        let scale = self.source.scale;
        match &self.source.sigma_t {
            Volume::Constant(sigma_t) => {
                let sigma_t = *sigma_t * scale;
                // Infinity times zero would be NaN where there is no extinction.
                Rgb::select(sigma_t.cmpgt(Rgb::ZERO), sigma_t * way.length, Rgb::ZERO)
            }
            volume => volume.bounds().map_or(Rgb::ZERO, |bounds| along(volume, &bounds, way)) * scale,
        }
    }
}

/// The integral of a volume along the part of a segment within its box, by the midpoint rule.
fn along(volume: &Volume, bounds: &Aabb, way: &Way) -> Rgb {
    let to = |corner: Vec3| (corner - way.origin) / way.dir;
    let (low, high) = (to(bounds.min), to(bounds.max));
    // A direction along an axis gives infinities there, or NaN where the ray lies in a face itself, which min and max
    // ignore.
    let enters = low.min(high).to_array().into_iter().fold(0.0f32, f32::max);
    let leaves = low.max(high).to_array().into_iter().fold(way.length, f32::min);
    let length = leaves - enters;
    if length.is_nan() || length <= 0.0 {
        return Rgb::ZERO;
    }
    let edge = match volume {
        Volume::Grid(grid) => grid.voxel_edge(),
        Volume::Constant(_) => length,
    };
    let steps = (STEPS_PER_VOXEL * length / edge).ceil().clamp(1.0, MOST_STEPS);
    let step = length / steps;
    let sum = (0..steps as usize).map(|number| {
        let at = way.origin + way.dir * (enters + (number as f32 + 0.5) * step);
        volume.within_bounds_at(at)
    });
    sum.sum::<Rgb>() * step
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{Affine3A, UVec3};

    use super::super::{GridVolume, MediumSource, Phase, VolumeFilter, VolumeGrid, VolumeWrap, Voxels};
    use super::*;

    fn medium(sigma_t: Volume) -> Medium {
        Medium::new(MediumSource {
            sigma_t,
            scale: 2.0,
            albedo: Volume::Constant(Rgb::splat(0.5)),
            emission: Volume::ZERO,
            phase: Phase::Isotropic,
        })
    }

    fn way(origin: Vec3, dir: Vec3, length: f32) -> Way {
        Way { origin, dir, length }
    }

    #[test]
    fn where_all_is_the_same_it_is_extinction_times_length() {
        let fog = medium(Volume::Constant(Rgb::new(1.0, 0.5, 0.0)));
        assert_eq!(
            fog.optical_depth(&way(Vec3::ZERO, Vec3::X, 3.0)),
            Rgb::new(6.0, 3.0, 0.0)
        );
        let endless = fog.optical_depth(&way(Vec3::ZERO, Vec3::X, f32::INFINITY));
        assert_eq!((endless.x, endless.z), (f32::INFINITY, 0.0));
    }

    #[test]
    fn in_a_grid_it_is_the_integral_within_its_box() {
        let voxels: Vec<f32> = (0..8).map(|x| x as f32).collect();
        let grid = VolumeGrid::new(UVec3::new(8, 1, 1), 1, Voxels::F32(voxels)).expect("eight voxels");
        // Eight voxels of a quarter, from -1 to 1.
        let placed = Affine3A::from_translation(Vec3::NEG_ONE) * Affine3A::from_scale(Vec3::splat(2.0));
        let grid = GridVolume::new(Arc::new(grid), placed, VolumeFilter::Nearest, VolumeWrap::Clamp);
        let smoke = medium(Volume::Grid(grid));
        let through = 2.0 * 0.25 * 28.0;
        for (origin, dir) in [(Vec3::X * -5.0, Vec3::X), (Vec3::X * 5.0, -Vec3::X)] {
            let depth = smoke.optical_depth(&way(origin, dir, f32::INFINITY)).x;
            assert!((depth - through).abs() < 1e-4, "{depth}");
        }
        // The second half has the voxels 4 to 7.
        let half = smoke.optical_depth(&way(Vec3::ZERO, Vec3::X, 9.0)).x;
        assert!((half - 2.0 * 0.25 * 22.0).abs() < 1e-4, "{half}");
        // A crossing segment is within one voxel.
        let across = smoke.optical_depth(&way(Vec3::new(0.9, -4.0, 0.0), Vec3::Y, 40.0)).x;
        assert!((across - 2.0 * 2.0 * 7.0).abs() < 1e-4, "{across}");
        assert_eq!(smoke.optical_depth(&way(Vec3::Y * 3.0, Vec3::X, 9.0)), Rgb::ZERO);
        assert_eq!(smoke.optical_depth(&way(Vec3::X * -5.0, -Vec3::X, 9.0)), Rgb::ZERO);
    }
}
