//! Values that vary in space: constants and placed grids.

use std::sync::Arc;

use glam::{Affine3A, IVec3, UVec3, Vec3};

use super::VolumeGrid;
use crate::color::Rgb;
use crate::math::Aabb;

/// A value at every point of world space.
#[derive(Clone, Debug, PartialEq)]
pub enum Volume {
    /// The same everywhere.
    Constant(Rgb),
    /// A grid placed in the world.
    Grid(GridVolume),
}

/// The reconstruction of values between voxels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VolumeFilter {
    /// The value of the voxel that holds the point.
    Nearest,
    /// Linear along all three axes between the centres of voxels.
    #[default]
    Trilinear,
}

/// The values outside of a grid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum VolumeWrap {
    /// The value of the nearest voxel.
    #[default]
    Clamp,
    /// The grid is repeated.
    Repeat,
    /// The grid is repeated, with every second copy mirrored.
    Mirror,
}

/// A grid in the world. It fills the cube [0, 1]^3 of its local space.
#[derive(Clone, Debug)]
pub struct GridVolume {
    /// The voxels.
    pub grid: Arc<VolumeGrid>,
    /// The map from the unit cube to the world, invertible.
    pub(super) world_from_local: Affine3A,
    local_from_world: Affine3A,
    /// The bounding box in world space.
    bounds: Aabb,
    /// The reconstruction between voxels.
    pub filter: VolumeFilter,
    /// The values outside of the unit cube.
    pub wrap: VolumeWrap,
    /// The factor on all values, not negative.
    pub scale: f32,
}

impl PartialEq for GridVolume {
    /// A shared grid is not compared voxel by voxel.
    fn eq(&self, other: &Self) -> bool {
        let placed = |it: &Self| (it.world_from_local, it.filter, it.wrap, it.scale);
        placed(self) == placed(other) && (Arc::ptr_eq(&self.grid, &other.grid) || self.grid == other.grid)
    }
}

impl Volume {
    /// Zero everywhere.
    pub const ZERO: Self = Self::Constant(Rgb::ZERO);

    /// The value at a point of world space.
    #[inline]
    pub fn at(&self, point: Vec3) -> Rgb {
        match self {
            Self::Constant(value) => *value,
            Self::Grid(volume) => volume.at(point),
        }
    }

    /// The value at a point of world space, zero outside of the box around the volume.
    #[inline]
    pub(super) fn within_bounds_at(&self, point: Vec3) -> Rgb {
        match self {
            Self::Constant(value) => *value,
            Self::Grid(volume) if volume.bounds.contains_point(point) => volume.at(point),
            Self::Grid(_) => Rgb::ZERO,
        }
    }

    /// The bounding box of the volume in world space; None if it is infinite.
    pub fn bounds(&self) -> Option<Aabb> {
        match self {
            Self::Constant(_) => None,
            Self::Grid(volume) => Some(volume.bounds),
        }
    }

    /// An upper bound of all components within a box of world space.
    pub(super) fn upper_bound(&self, within: &Aabb) -> f32 {
        match self {
            Self::Constant(value) => value.max_element(),
            Self::Grid(volume) => volume.upper_bound(within),
        }
    }

    /// A lower bound of all components within a box of world space.
    pub(super) fn lower_bound(&self, within: &Aabb) -> f32 {
        match self {
            Self::Constant(value) => value.min_element(),
            Self::Grid(volume) => volume.lower_bound(within),
        }
    }
}

impl GridVolume {
    /// A grid placed by this map, which must be invertible.
    pub fn new(grid: Arc<VolumeGrid>, world_from_local: Affine3A, filter: VolumeFilter, wrap: VolumeWrap) -> Self {
        let unit = Aabb {
            min: Vec3::ZERO,
            max: Vec3::ONE,
        };
        Self {
            grid,
            world_from_local,
            local_from_world: world_from_local.inverse(),
            bounds: unit.transformed(&world_from_local),
            filter,
            wrap,
            scale: 1.0,
        }
    }

    /// The point in units of voxels; the centre of the first voxel is at 0.5.
    #[inline(always)]
    fn in_voxels(&self, point: Vec3) -> Vec3 {
        self.local_from_world.transform_point3(point) * self.grid.resolution().as_vec3()
    }

    /// The value at a point of world space.
    #[inline]
    fn at(&self, point: Vec3) -> Rgb {
        let place = self.in_voxels(point);
        let value = match self.filter {
            VolumeFilter::Nearest => self.voxel(place.floor().as_ivec3()),
            VolumeFilter::Trilinear => {
                let place = place - 0.5;
                let (first, part) = (place.floor(), place - place.floor());
                let first = first.as_ivec3();
                let along_x = |y: i32, z: i32| {
                    let at = first + IVec3::new(0, y, z);
                    self.voxel(at).lerp(self.voxel(at + IVec3::X), part.x)
                };
                let along_y = |z: i32| along_x(0, z).lerp(along_x(1, z), part.y);
                along_y(0).lerp(along_y(1), part.z)
            }
        };
        value * self.scale
    }

    #[inline(always)]
    fn voxel(&self, place: IVec3) -> Rgb {
        let size = self.grid.resolution();
        // Most points are within the grid, and need no division.
        let place = match place.cmpge(IVec3::ZERO).all() && place.as_uvec3().cmplt(size).all() {
            true => place.as_uvec3(),
            false => self.wrapped(place),
        };
        self.grid.voxel(place)
    }

    fn wrapped(&self, place: IVec3) -> UVec3 {
        let size = self.grid.resolution().as_ivec3();
        match self.wrap {
            VolumeWrap::Clamp => place.clamp(IVec3::ZERO, size - 1),
            VolumeWrap::Repeat => place.rem_euclid(size),
            VolumeWrap::Mirror => {
                let twice = place.rem_euclid(2 * size);
                twice.min(2 * size - 1 - twice)
            }
        }
        .as_uvec3()
    }

    /// The bound of [`Volume::upper_bound`]: the largest value of all voxels that the box, enlarged by one voxel,
    /// touches.
    fn upper_bound(&self, within: &Aabb) -> f32 {
        let [first, last] = self.touched(within);
        self.grid.largest(first, last) * self.scale
    }

    /// The bound of [`Volume::lower_bound`]: the least value of the same voxels.
    fn lower_bound(&self, within: &Aabb) -> f32 {
        let [first, last] = self.touched(within);
        self.grid.smallest(first, last) * self.scale
    }

    /// The number of voxels.
    pub(super) fn voxels(&self) -> u64 {
        let [x, y, z] = self.grid.resolution().to_array().map(u64::from);
        x * y * z
    }

    /// The number of voxels that are read for the bound within a box.
    pub(super) fn voxels_of(&self, within: &Aabb) -> u64 {
        let [first, last] = self.touched(within);
        let [x, y, z] = (last - first + 1).to_array().map(u64::from);
        x * y * z
    }

    /// The first and the last of all voxels that the box, enlarged by one voxel, touches.
    fn touched(&self, within: &Aabb) -> [UVec3; 2] {
        let size = self.grid.resolution();
        let local = within.transformed(&self.local_from_world);
        let around = Vec3::splat(match self.filter {
            VolumeFilter::Nearest => 0.01,
            VolumeFilter::Trilinear => 0.51,
        });
        // The clamp keeps far corners within integers.
        let limit = Vec3::splat(1e9);
        let place = |corner: Vec3| (corner * size.as_vec3()).clamp(-limit, limit);
        let first = (place(local.min) - around).floor().as_ivec3();
        let last = (place(local.max) + around).floor().as_ivec3();
        let largest = size.as_ivec3() - 1;
        let (first, last) = match self.wrap {
            VolumeWrap::Clamp => (first.clamp(IVec3::ZERO, largest), last.clamp(IVec3::ZERO, largest)),
            // Along an axis on which the box leaves the grid, all voxels count.
            _ => {
                let stays = first.cmpge(IVec3::ZERO) & last.cmple(largest);
                (
                    IVec3::select(stays, first, IVec3::ZERO),
                    IVec3::select(stays, last, largest),
                )
            }
        };
        [first.as_uvec3(), last.as_uvec3()]
    }
}

#[cfg(test)]
mod tests {
    use super::super::Voxels;
    use super::*;
    use crate::sampling::hash::pcg3d;
    use crate::sampling::unit_float;

    fn volume(filter: VolumeFilter, wrap: VolumeWrap, placed: Affine3A) -> GridVolume {
        let size = UVec3::new(3, 4, 2);
        let values: Vec<f32> = (0..24).map(|n| unit_float(pcg3d([n, 0, 1])[0])).collect();
        let grid = VolumeGrid::new(size, 1, Voxels::F32(values)).unwrap();
        GridVolume::new(Arc::new(grid), placed, filter, wrap)
    }

    #[test]
    fn centres_of_voxels_have_their_values_and_between_them_it_is_linear() {
        let placed =
            Affine3A::from_translation(Vec3::new(5.0, 0.0, -1.0)) * Affine3A::from_scale(Vec3::new(3.0, 4.0, 2.0));
        let volume = volume(VolumeFilter::Trilinear, VolumeWrap::Clamp, placed);
        let voxel = |x, y, z| volume.grid.voxel(UVec3::new(x, y, z)).x;
        let at = |x: f32, y: f32, z: f32| volume.at(Vec3::new(x, y, z) + Vec3::new(5.0, 0.0, -1.0)).x;
        assert!((at(1.5, 2.5, 0.5) - voxel(1, 2, 0)).abs() < 1e-6);
        let expected = 0.75 * voxel(1, 2, 0) + 0.25 * voxel(1, 3, 0);
        assert!((at(1.5, 2.75, 0.5) - expected).abs() < 1e-6);
        // Outside it is the nearest voxel.
        assert!((at(-7.0, 3.5, 1.5) - voxel(0, 3, 1)).abs() < 1e-6);
    }

    #[test]
    fn repeated_and_mirrored_grids_continue() {
        let at = |wrap, x: f32| volume(VolumeFilter::Nearest, wrap, Affine3A::IDENTITY).at(Vec3::new(x, 0.1, 0.1));
        for x in [0.1, 0.5, 0.9] {
            assert_eq!(at(VolumeWrap::Repeat, x + 2.0), at(VolumeWrap::Repeat, x));
            assert_eq!(at(VolumeWrap::Repeat, x - 1.0), at(VolumeWrap::Repeat, x));
            assert_eq!(at(VolumeWrap::Mirror, 2.0 - x), at(VolumeWrap::Repeat, x));
            assert_eq!(at(VolumeWrap::Mirror, -x), at(VolumeWrap::Repeat, x));
        }
    }

    #[test]
    fn nothing_in_a_box_is_above_its_bound() {
        let turned = Affine3A::from_rotation_y(0.6) * Affine3A::from_scale(Vec3::new(2.0, 1.0, 0.5));
        for filter in [VolumeFilter::Nearest, VolumeFilter::Trilinear] {
            for wrap in [VolumeWrap::Clamp, VolumeWrap::Repeat, VolumeWrap::Mirror] {
                let volume = volume(filter, wrap, turned);
                let mut is_tight = false;
                for number in 0..200 {
                    let [a, b] = [0, 1].map(|n| Vec3::from(pcg3d([number, n, 3]).map(unit_float)) * 3.0 - 1.0);
                    let bounds = Aabb::from_points([a, a + 0.2 * b]);
                    let bound = volume.upper_bound(&bounds);
                    for inner in 0..50 {
                        let part = Vec3::from(pcg3d([number, inner, 4]).map(unit_float));
                        let found = volume.at(bounds.min + part * bounds.extent()).max_element();
                        assert!(found <= bound + 1e-6, "{filter:?} {wrap:?}: {found} > {bound}");
                        is_tight |= found > 0.9 * bound;
                    }
                }
                assert!(is_tight);
            }
        }
    }
}
