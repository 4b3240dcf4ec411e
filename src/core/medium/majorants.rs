//! A coarse grid of upper bounds of a medium's extinction, along which rays walk cell by cell (Amanatides and Woo, A
//! Fast Voxel Traversal Algorithm for Ray Tracing, 1987; PBR 4th ed., section 11.4.2). Tight bounds mean few null
//! collisions.

use std::fmt::{self, Display, Formatter};

use glam::{IVec3, Vec3};
use rayon::prelude::*;

use super::{GridVolume, MediumSource, Volume, Way};
use crate::math::Aabb;

/// The edge of a cell in voxels: small enough to follow the density, and large enough that rays do not spend their time
/// at the borders of cells.
const VOXELS_PER_CELL: f32 = 8.0;
/// The most cells along an axis: 8 MiB in all.
const MOST_CELLS: f32 = 128.0;
/// The most voxels that are read to bound all cells of a small grid, which takes a second.
const MOST_READ: u64 = 1 << 31;
/// The most times that each voxel of a large grid is read on average. A rotated grid needs ten.
const READS_PER_VOXEL: u64 = 16;
/// The margin added to cells, relative to their size, so that rounding cannot miss a value.
const MARGIN: f32 = 1e-3;
/// The most tentative collisions on average across a cell. If one voxel exceeds it and another does not, a ray beside
/// the dense voxel would be held up by countless null collisions, so the extinction is clamped to this limit. Hardly
/// any light passes a voxel at the limit, unless cells are much larger than [`VOXELS_PER_CELL`].
pub(super) const MOST_TRIED: f32 = 1024.0;

/// Upper bounds of extinction in the cells of a box in world space.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct MajorantGrid {
    bounds: Aabb,
    /// The number of cells along each axis.
    cells: IVec3,
    cell_size: Vec3,
    /// The bound of each cell; x varies fastest.
    majorants: Vec<f32>,
    /// The extinction outside of the box.
    outside: f32,
    /// The cells where extinction is clamped by [`MOST_TRIED`]; None if there are none.
    limited: Option<Limited>,
}

/// The part of a medium that is too dense to be tracked and is clamped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limited {
    /// The number of cells of 8 voxels along an edge, or more in large grids.
    pub cells: usize,
    /// The largest extinction in these cells.
    pub densest: f32,
    /// The largest extinction after clamping.
    pub limit: f32,
}

impl Display for Limited {
    fn fmt(&self, out: &mut Formatter) -> fmt::Result {
        let Self { cells, densest, limit } = self;
        let places = if *cells == 1 { "cell" } else { "cells" };
        write!(
            out,
            "it is too dense next to thin places: the extinction is up to {densest:e} per unit of length, and in {cells} {places} at most {limit:.1} of it counts"
        )
    }
}

/// A part of a path segment along which one bound holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Segment {
    /// The distance at which it ends; it begins at the end of the previous one.
    pub end: f32,
    /// The upper bound of the extinction in all channels.
    pub majorant: f32,
    /// Whether it is outside of the box, where the extinction is constant.
    pub is_outside: bool,
}

/// The division of a box into cells.
struct Cells {
    bounds: Aabb,
    /// The number along each axis.
    along: Vec3,
    size: Vec3,
}

impl Cells {
    /// Cells with about this edge. They are larger where bounding all of them would take far longer than reading the
    /// voxels once: each cell of a slanted or repeated grid may touch all voxels.
    fn new(bounds: Aabb, edge: f32, grids: &[&GridVolume]) -> Self {
        let extent = bounds.extent().max(Vec3::splat(f32::MIN_POSITIVE));
        let along = (extent / edge).ceil().clamp(Vec3::ONE, Vec3::splat(MOST_CELLS));
        let mut cells = Self {
            bounds,
            along,
            size: extent / along,
        };
        let voxels: u64 = grids.iter().map(|grid| grid.voxels()).sum();
        let most = MOST_READ.max(READS_PER_VOXEL * voxels);
        while cells.along != Vec3::ONE && cells.touched(grids) > most {
            cells.along = (0.5 * cells.along).ceil();
            cells.size = extent / cells.along;
        }
        cells
    }

    fn count(&self) -> usize {
        self.along.to_array().into_iter().map(|along| along as usize).product()
    }

    /// The box of the cell with this index, enlarged by [`MARGIN`].
    fn within(&self, index: usize) -> Aabb {
        let (columns, rows) = (self.along.x as usize, self.along.y as usize);
        let cell = Vec3::new(
            (index % columns) as f32,
            (index / columns % rows) as f32,
            (index / columns / rows) as f32,
        );
        Aabb {
            min: self.bounds.min + self.size * (cell - MARGIN),
            max: self.bounds.min + self.size * (cell + 1.0 + MARGIN),
        }
    }

    /// The number of voxels that all cells touch together; a voxel counts once per cell.
    fn touched(&self, grids: &[&GridVolume]) -> u64 {
        // Even if every cell touched every voxel, the limit would hold.
        let voxels: u64 = grids.iter().map(|grid| grid.voxels()).sum();
        if (self.count() as u64).saturating_mul(voxels) <= MOST_READ {
            return 0;
        }
        let of_cell = |index: usize| {
            let within = self.within(index);
            grids.iter().map(|grid| grid.voxels_of(&within)).sum::<u64>()
        };
        (0..self.count()).into_par_iter().map(of_cell).sum()
    }
}

impl MajorantGrid {
    /// The majorants of a medium whose extinction or emission is a grid.
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
        let edge = VOXELS_PER_CELL * grids.iter().map(|grid| grid.voxel_edge()).fold(f32::INFINITY, f32::min);
        let cells = Cells::new(bounds, edge, &grids);
        let (cell_size, count) = (cells.size, cells.count());
        let limit = MOST_TRIED / cell_size.length();
        let bounds_of = |index: usize| cells.within(index);
        // Where the extinction is constant, no collision is a null collision.
        let is_limited = |sigma_t: f32, within: &Aabb| {
            sigma_t > limit && source.sigma_t.lower_bound(within) * source.scale < sigma_t
        };
        let majorant = |index: usize| {
            let within = bounds_of(index);
            let sigma_t = source.sigma_t.upper_bound(&within) * source.scale;
            let sigma_t = if is_limited(sigma_t, &within) { limit } else { sigma_t };
            // Emission is gathered at collisions, so cells that emit need a majorant of about one collision per cell.
            match source.emission.upper_bound(&within) > 0.0 {
                true => sigma_t.max(1.0 / cell_size.max_element()),
                false => sigma_t,
            }
        };
        let outside = match &source.sigma_t {
            Volume::Constant(sigma_t) => sigma_t.max_element() * source.scale,
            Volume::Grid(_) => 0.0,
        };
        let majorants: Vec<f32> = (0..count).into_par_iter().map(majorant).collect();
        let too_dense = |index: usize| {
            // Few cells have exactly this bound, and most often none does.
            let within = (majorants[index] == limit).then(|| bounds_of(index))?;
            let sigma_t = source.sigma_t.upper_bound(&within) * source.scale;
            is_limited(sigma_t, &within).then_some((1, sigma_t))
        };
        let found = (0..count).into_par_iter().filter_map(too_dense);
        let found = found.reduce_with(|one, other| (one.0 + other.0, one.1.max(other.1)));
        Self {
            bounds,
            cells: cells.along.as_ivec3(),
            cell_size,
            outside,
            limited: found.map(|(cells, densest)| Limited { cells, densest, limit }),
            majorants,
        }
    }

    /// The part of the medium that is too dense to be tracked and is clamped; None in nearly all media.
    pub fn limited(&self) -> Option<Limited> {
        self.limited
    }

    /// The parts of `way` with one bound each, in order. The last one ends with `way`.
    #[inline]
    pub fn walk(&self, way: &Way) -> Walk<'_> {
        let inverse = way.dir.recip();
        let (near, far) = (
            (self.bounds.min - way.origin) * inverse,
            (self.bounds.max - way.origin) * inverse,
        );
        // Zero times infinity, of a ray in the plane of a face, is NaN, which min and max ignore.
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

/// Iterates over the parts of a path segment with one bound each.
pub(super) struct Walk<'a> {
    grid: &'a MajorantGrid,
    length: f32,
    /// The distances at which the path segment enters the box, and at which it leaves it or ends.
    enter: f32,
    exit: f32,
    /// The end of the last part.
    t: f32,
    cells: CellWalk,
}

/// The current cell of a walk.
struct CellWalk {
    cell: IVec3,
    step: IVec3,
    /// The distances at which the ray leaves the cell along each axis.
    leave: Vec3,
    /// The distances between cell borders along each axis.
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
                is_outside: true,
            });
        }
        if self.t >= self.exit {
            self.t = self.length;
            return Some(Segment {
                end: self.length,
                majorant: outside,
                is_outside: true,
            });
        }
        let CellWalk { cell, leave, .. } = self.cells;
        let index = (cell.z * self.grid.cells.y + cell.y) * self.grid.cells.x + cell.x;
        let axis = match leave {
            leave if leave.x <= leave.y && leave.x <= leave.z => 0,
            leave if leave.y <= leave.z => 1,
            _ => 2,
        };
        // Rounding must not lead backwards.
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
            is_outside: false,
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

    use glam::{Affine3A, UVec3, Vec3A};

    use super::super::{Phase, VolumeFilter, VolumeGrid, VolumeWrap, Voxels};
    use super::*;
    use crate::color::Rgb;
    use crate::sampling::hash::pcg3d;
    use crate::sampling::unit_float;

    fn smoke(placed: Affine3A) -> MediumSource {
        let size = UVec3::new(40, 17, 23);
        let count = size.element_product();
        // The density grows along x.
        let value = |n: u32| unit_float(pcg3d([n / 50, 0, 1])[0]).powi(4) * (n % size.x) as f32 / size.x as f32;
        of_voxels(size, 1, (0..count).map(value).collect(), placed)
    }

    fn of_voxels(size: UVec3, channels: u32, values: Vec<f32>, placed: Affine3A) -> MediumSource {
        let grid = VolumeGrid::new(size, channels, Voxels::F32(values)).unwrap();
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

    /// Segments from anywhere, also along axes and from inside: their parts leave no gap, and no extinction is above
    /// its bound.
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

    /// A cell of 4 x 4 x 4 voxels of which one is dense; there is no clamp where all are as dense, or where the dense
    /// one can be tracked.
    #[test]
    fn what_is_too_dense_beside_what_is_thin_is_limited() {
        let limited = |channels: u32, dense: f32, thin: f32| {
            let mut values = vec![thin; 64 * channels as usize];
            values[17] = dense;
            let source = of_voxels(UVec3::splat(4), channels, values, Affine3A::IDENTITY);
            let majorants = MajorantGrid::new(&source);
            (majorants.limited(), majorants.majorants[0])
        };
        let limit = MOST_TRIED / 3.0f32.sqrt();
        for dense in [1e6_f32, 1e12, 3e38] {
            let densest = 3.0 * dense.min(1e12);
            let found = Limited {
                cells: 1,
                densest,
                limit,
            };
            assert_eq!(limited(1, dense, 0.0), (Some(found), limit));
            // A channel without extinction is held up as well.
            assert_eq!(limited(3, dense, 0.0), (Some(found), limit));
        }
        assert_eq!(limited(1, 150.0, 0.0), (None, 450.0));
        assert_eq!(limited(1, 1e6, 1e6), (None, 3e6));
    }

    /// Every cell of a slanted grid touches most of its voxels, and so does every cell beside a rotated one that is
    /// repeated.
    #[test]
    fn the_bounds_of_slanted_grids_are_found_in_proportion_to_their_size() {
        let size = UVec3::splat(64);
        let slanted = Affine3A::from_cols(
            Vec3A::X,
            Vec3A::new(1000.0, 1.0, 0.0),
            Vec3A::new(0.0, 1000.0, 1.0),
            Vec3A::ZERO,
        );
        let cells_of = |source: &MediumSource| {
            let Volume::Grid(grid) = &source.sigma_t else {
                panic!("it has voxels")
            };
            let bounds = source.sigma_t.bounds().expect("a grid that ends");
            let cells = Cells::new(bounds, VOXELS_PER_CELL * grid.voxel_edge(), &[grid]);
            (cells.count(), cells.touched(&[grid]))
        };
        let mut source = of_voxels(size, 1, vec![1.0; 64 * 64 * 64], slanted);
        let (count, touched) = cells_of(&source);
        assert!(touched <= MOST_READ, "{count} {touched}");
        // With eight times as many voxels, this number of cells would take too long.
        let finer = of_voxels(2 * size, 1, vec![1.0; 8 * 64 * 64 * 64], slanted);
        let (fewer, touched) = cells_of(&finer);
        assert!(fewer < count && touched <= MOST_READ, "{count} {fewer} {touched}");
        let majorants = MajorantGrid::new(&source);
        let largest = majorants.majorants.iter().copied().fold(0.0, f32::max);
        assert_eq!(largest, 3.0);
        if let Volume::Grid(grid) = &mut source.sigma_t {
            let turned = Affine3A::from_rotation_x(0.7) * Affine3A::from_rotation_y(0.6);
            *grid = GridVolume::new(grid.grid.clone(), turned, VolumeFilter::Nearest, VolumeWrap::Repeat);
        }
        let cells = MajorantGrid::new(&source).cells;
        assert!(cells.min_element() > 8, "{cells}");
    }

    #[test]
    fn the_bounds_are_tighter_than_one_for_all() {
        let majorants = MajorantGrid::new(&smoke(Affine3A::IDENTITY));
        let mean = majorants.majorants.iter().sum::<f32>() / majorants.majorants.len() as f32;
        let largest = majorants.majorants.iter().copied().fold(0.0, f32::max);
        assert!(mean < 0.6 * largest, "{mean} {largest}");
    }
}
