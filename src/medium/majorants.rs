//! A coarse grid of upper bounds of a medium's extinction, along which rays walk cell by cell (Amanatides and Woo, A Fast Voxel Traversal
//! Algorithm for Ray Tracing, 1987; PBR 4th ed., section 11.4.2). Tight bounds mean few null collisions.

use glam::{IVec3, Vec3};
use rayon::prelude::*;

use super::{GridVolume, MediumSource, Volume, Way};
use crate::math::Aabb;

/// The edge of a cell in voxels: small enough to follow the density, and large enough that rays do not spend their time at borders of cells.
const VOXELS_PER_CELL: f32 = 8.0;
/// The most cells along an axis: 8 MiB in all.
const MOST_CELLS: f32 = 128.0;
/// What cells are enlarged by, relative to their size, so that rounding leads to no value outside of them.
const MARGIN: f32 = 1e-3;

/// Upper bounds of extinction in the cells of a box in world space.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MajorantGrid {
    bounds: Aabb,
    /// The number of cells along each axis.
    cells: IVec3,
    cell_size: Vec3,
    /// By cell; x grows fastest.
    majorants: Vec<f32>,
    /// The extinction outside of the box.
    outside: f32,
}

/// A part of a ray along which one bound holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Segment {
    /// The distance at which it ends; it begins where the one before ends.
    pub end: f32,
    /// The upper bound of the extinction in all colours.
    pub majorant: f32,
}

impl MajorantGrid {
    /// The bounds of a medium of which extinction or emission is a grid.
    pub fn new(source: &MediumSource) -> Self {
        let grids: Vec<&GridVolume> = [&source.sigma_t, &source.emission]
            .into_iter()
            .filter_map(|volume| match volume {
                Volume::Grid(grid) => Some(grid),
                Volume::Constant(_) => None,
            })
            .collect();
        let bounds = [&source.sigma_t, &source.emission]
            .into_iter()
            .filter_map(|volume| volume.bounds())
            .fold(Aabb::EMPTY, Aabb::union);
        let extent = bounds.extent().max(Vec3::splat(f32::MIN_POSITIVE));
        let edge = VOXELS_PER_CELL * grids.iter().map(|grid| grid.voxel_edge()).fold(f32::INFINITY, f32::min);
        let cells = (extent / edge).ceil().clamp(Vec3::ONE, Vec3::splat(MOST_CELLS));
        let cell_size = extent / cells;
        let (columns, rows) = (cells.x as usize, cells.y as usize);
        let count = columns * rows * cells.z as usize;
        let majorant = |index: usize| {
            let cell = Vec3::new(
                (index % columns) as f32,
                (index / columns % rows) as f32,
                (index / columns / rows) as f32,
            );
            let within = Aabb {
                min: bounds.min + cell_size * (cell - MARGIN),
                max: bounds.min + cell_size * (cell + 1.0 + MARGIN),
            };
            let sigma_t = source.sigma_t.upper_bound(&within) * source.scale;
            // Where a medium shines, its light is gathered at collisions, so that there have to be some: about one for each cell.
            match source.emission.upper_bound(&within) > 0.0 {
                true => sigma_t.max(1.0 / cell_size.max_element()),
                false => sigma_t,
            }
        };
        let outside = match &source.sigma_t {
            Volume::Constant(sigma_t) => sigma_t.max_element() * source.scale,
            Volume::Grid(_) => 0.0,
        };
        Self {
            bounds,
            cells: cells.as_ivec3(),
            cell_size,
            majorants: (0..count).into_par_iter().map(majorant).collect(),
            outside,
        }
    }

    /// The segments of a way, in order. The last one ends where the way does.
    #[inline]
    pub fn walk(&self, way: &Way) -> Walk<'_> {
        let inverse = way.dir.recip();
        let (near, far) = (
            (self.bounds.min - way.origin) * inverse,
            (self.bounds.max - way.origin) * inverse,
        );
        // Zero times infinity, of a ray in the plane of a face, is no number, which min and max leave aside.
        let enter = near.min(far).max_element().max(0.0);
        let exit = near.max(far).min_element().min(way.length);
        let is_missed = enter.is_nan() || exit.is_nan() || enter >= exit;
        Walk {
            grid: self,
            length: way.length,
            enter: if is_missed { f32::INFINITY } else { enter },
            exit,
            t: 0.0,
            cells: CellWalk::new(self, way, if is_missed { 0.0 } else { enter }),
        }
    }
}

/// The segments of one way.
pub(super) struct Walk<'a> {
    grid: &'a MajorantGrid,
    length: f32,
    /// Where the way comes into the box, and where it leaves it or ends.
    enter: f32,
    exit: f32,
    /// The end of the last segment.
    t: f32,
    cells: CellWalk,
}

/// The place among the cells.
struct CellWalk {
    cell: IVec3,
    step: IVec3,
    /// The distances at which the way leaves the cell along each axis.
    leave: Vec3,
    /// The distances from one border to the next.
    across: Vec3,
}

impl CellWalk {
    #[inline]
    fn new(grid: &MajorantGrid, way: &Way, enter: f32) -> Self {
        let start = (way.origin + way.dir * enter - grid.bounds.min) / grid.cell_size;
        let cell = start.floor().as_ivec3().clamp(IVec3::ZERO, grid.cells - 1);
        let is_forward = way.dir.cmpge(Vec3::ZERO);
        let border =
            grid.bounds.min + grid.cell_size * (cell.as_vec3() + Vec3::select(is_forward, Vec3::ONE, Vec3::ZERO));
        let moves = way.dir.cmpne(Vec3::ZERO);
        let endless = Vec3::INFINITY;
        Self {
            cell,
            step: IVec3::select(is_forward, IVec3::ONE, IVec3::NEG_ONE),
            leave: Vec3::select(moves, (border - way.origin) / way.dir, endless),
            across: Vec3::select(moves, grid.cell_size / way.dir.abs(), endless),
        }
    }
}

impl Iterator for Walk<'_> {
    type Item = Segment;

    #[inline]
    fn next(&mut self) -> Option<Segment> {
        if self.t >= self.length {
            return None;
        }
        let outside = self.grid.outside;
        if self.t < self.enter {
            self.t = self.enter.min(self.length);
            return (self.t > 0.0).then_some(Segment {
                end: self.t,
                majorant: outside,
            });
        }
        if self.t >= self.exit {
            self.t = self.length;
            return Some(Segment {
                end: self.length,
                majorant: outside,
            });
        }
        let CellWalk { cell, leave, .. } = self.cells;
        let index = (cell.z * self.grid.cells.y + cell.y) * self.grid.cells.x + cell.x;
        let axis = match leave {
            leave if leave.x <= leave.y && leave.x <= leave.z => 0,
            leave if leave.y <= leave.z => 1,
            _ => 2,
        };
        // Rounding must not lead back.
        let mut end = leave[axis].max(self.t);
        self.cells.cell[axis] += self.cells.step[axis];
        self.cells.leave[axis] += self.cells.across[axis];
        let is_last = self.cells.cell[axis] < 0 || self.cells.cell[axis] >= self.grid.cells[axis];
        if is_last || end >= self.exit {
            end = self.exit;
        }
        self.t = end;
        Some(Segment {
            end,
            majorant: self.grid.majorants[index as usize],
        })
    }
}

impl GridVolume {
    /// The shortest edge of a voxel in world space.
    pub(super) fn voxel_edge(&self) -> f32 {
        let size = self.grid.resolution().as_vec3();
        let axes = self.world_from_local.matrix3;
        let edges = [
            axes.x_axis.length() / size.x,
            axes.y_axis.length() / size.y,
            axes.z_axis.length() / size.z,
        ];
        edges.into_iter().fold(f32::INFINITY, f32::min)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{Affine3A, UVec3};

    use super::super::{Phase, VolumeFilter, VolumeGrid, VolumeWrap, Voxels};
    use super::*;
    use crate::color::Rgb;
    use crate::sampling::hash::pcg3d;
    use crate::sampling::unit_float;

    fn smoke(placed: Affine3A) -> MediumSource {
        let size = UVec3::new(40, 17, 23);
        let count = size.element_product();
        // It becomes thicker along x.
        let value = |n: u32| unit_float(pcg3d([n / 50, 0, 1])[0]).powi(4) * (n % size.x) as f32 / size.x as f32;
        let values = (0..count).map(value).collect();
        let grid = VolumeGrid::new(size, 1, Voxels::F32(values)).unwrap();
        MediumSource {
            sigma_t: Volume::Grid(GridVolume::new(
                Arc::new(grid),
                placed,
                VolumeFilter::Trilinear,
                VolumeWrap::Clamp,
            )),
            scale: 3.0,
            albedo: Volume::Constant(Rgb::ONE),
            emission: Volume::ZERO,
            phase: Phase::Isotropic,
        }
    }

    /// Ways from anywhere, also along axes and from inside: the segments follow each other without a gap, and no extinction is above its bound.
    #[test]
    fn walks_cover_the_way_and_bound_the_extinction() {
        let placed = Affine3A::from_rotation_z(0.4) * Affine3A::from_scale(Vec3::new(4.0, 2.0, 2.0));
        for placed in [placed, Affine3A::from_scale(Vec3::new(4.0, 2.0, 2.0))] {
            let source = smoke(placed);
            let majorants = MajorantGrid::new(&source);
            assert!(majorants.cells.min_element() > 1, "{}", majorants.cells);
            let mut inside = 0;
            for number in 0..2000 {
                let [a, b] = [0, 1].map(|n| Vec3::from(pcg3d([number, n, 3]).map(unit_float)));
                let mut dir = b - 0.5;
                for axis in 0..3 {
                    if number >> axis & 1 == 1 && number % 5 == 0 {
                        dir[axis] = 0.0;
                    }
                }
                let Some(dir) = dir.try_normalize() else { continue };
                let length = if number % 3 == 0 { f32::INFINITY } else { 4.0 * a.x };
                let origin = a * Vec3::new(8.0, 6.0, 6.0) - 2.0;
                let way = Way { origin, dir, length };
                let mut start = 0.0;
                for segment in majorants.walk(&way) {
                    assert!(segment.end >= start && segment.end <= length);
                    for part in [0.01, 0.3, 0.7, 0.99] {
                        let t = start + part * (segment.end.min(start + 10.0) - start);
                        let point = origin + dir * t;
                        let is_inside = majorants.bounds.contains_point(point);
                        let found = if is_inside {
                            source.sigma_t.at(point).x * source.scale
                        } else {
                            0.0
                        };
                        inside += u32::from(is_inside);
                        assert!(
                            found <= segment.majorant * 1.0001,
                            "{way:?} at {t}: {found} > {}",
                            segment.majorant
                        );
                    }
                    start = segment.end;
                }
                assert_eq!(start, length);
            }
            assert!(inside > 1000);
        }
    }

    #[test]
    fn the_bounds_are_tighter_than_one_for_all() {
        let majorants = MajorantGrid::new(&smoke(Affine3A::IDENTITY));
        let mean = majorants.majorants.iter().sum::<f32>() / majorants.majorants.len() as f32;
        let largest = majorants.majorants.iter().copied().fold(0.0, f32::max);
        assert!(mean < 0.6 * largest, "{mean} {largest}");
    }
}
