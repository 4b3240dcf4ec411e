//! The guide of a scene: a histogram over directions for each voxel of a grid and each of six orientations of surfaces.
//!
//! Where few photons fall, a larger voxel has one histogram for all. A histogram that is nearly that of the cosine is
//! omitted, so that paths there are not guided.

use glam::{UVec3, Vec3};

use super::bins::{BINS, BinLanes, axis_of, bin_of, cosine_shares};
use super::cell::{Cell, UNITS};
use super::{MOST_OF_PATH, PATHS};
use crate::math::lanes::{Lanes, Vec3Lanes, WordLanes};

/// A photon: light that has reached a surface from another one.
#[derive(Clone, Copy, Debug)]
pub(in crate::render) struct PhotonArrival {
    pub position: Vec3,
    /// The shading normal on the side that the light has reached.
    pub normal: Vec3,
    /// Unit vector to the photon's origin.
    pub wi: Vec3,
    /// The power relative to other photons.
    pub power: f32,
}

/// The most voxels along a side of the grid.
const RESOLUTION: f32 = 32.0;
/// The photons that a voxel needs for a histogram of its own.
const LEAST_PHOTONS: u32 = 128;
/// The weight of the histogram of the next larger voxel, in photons.
const PRIOR: f32 = 64.0;
/// The parts of a diffuse lobe's directions that may be sampled from a histogram. A smaller part gains less where the
/// histogram is right, a larger one loses more where it is wrong.
const PARTS: [f32; 2] = [0.5, 0.75];
/// The factor by which the larger part must reduce the second moment of light more than the smaller one.
const DECISIVE: f32 = 1.15;
/// The least factor by which a histogram must reduce the second moment of light: the variance has other parts, and a
/// guided step takes longer.
const WORTHWHILE: f32 = 1.5;
/// Photons of one path are adjacent in the list: runs of this length are in the same half.
const RUN: usize = 64;

/// The most photons for learning.
pub(super) const MOST_PHOTONS: usize = PATHS as usize * MOST_OF_PATH;
/// The voxels of the finest level, times the orientations.
const MOST_PLACES: usize = (RESOLUTION * RESOLUTION * RESOLUTION) as usize * ORIENTATIONS as usize;
/// The most histograms. A level has at most one for each of its voxels and orientations, and at the finest level one
/// for each [`LEAST_PHOTONS`]; each level has an eighth of the voxels of the next finer one.
const MOST_CELLS: usize = {
    let (mut cells, mut left) = (1 + MOST_PHOTONS / LEAST_PHOTONS as usize, MOST_PLACES / 8);
    while left > 0 {
        cells += left;
        left /= 8;
    }
    cells
};
/// The most memory of a field in bytes.
const MOST_BYTES: usize = 48_000_000;
const _: () = assert!(MOST_PLACES * size_of::<u32>() + MOST_CELLS * size_of::<Cell>() <= MOST_BYTES);

/// The orientations of surfaces: the axis that is nearest to the normal.
const ORIENTATIONS: u32 = 6;
const NONE: u32 = u32::MAX;

/// A guide, ready for use.
#[derive(Debug)]
pub(in crate::render) struct Field {
    origin: Vec3,
    /// Voxels per unit of length.
    scale: f32,
    size: UVec3,
    /// The index of the histogram for each voxel and orientation; 0 for none, where the cosine is used.
    index: Box<[u32]>,
    cells: Box<[Cell]>,
}

/// The sums of a level of voxels, which are twice as large as those of the next finer level.
struct Level {
    size: UVec3,
    /// The index of the sums for each voxel and orientation; [`NONE`] where there are no photons.
    cell_of: Vec<u32>,
    /// The sums of each half of the photons.
    sums: [Vec<[f32; BINS]>; 2],
    /// The numbers of photons.
    counts: Vec<u32>,
}

impl Level {
    fn new(size: UVec3) -> Self {
        Self {
            size,
            cell_of: vec![NONE; (size.element_product() * ORIENTATIONS) as usize],
            sums: Default::default(),
            counts: Vec::new(),
        }
    }

    fn place(&self, piece: UVec3, orientation: u32) -> usize {
        let UVec3 { x, y, .. } = self.size;
        (((piece.z * y + piece.y) * x + piece.x) * ORIENTATIONS + orientation) as usize
    }

    fn cell(&mut self, place: usize) -> usize {
        if self.cell_of[place] == NONE {
            self.cell_of[place] = self.counts.len() as u32;
            self.sums.iter_mut().for_each(|sums| sums.push([0.0; BINS]));
            self.counts.push(0);
        }
        self.cell_of[place] as usize
    }

    fn above(&self) -> Self {
        let mut above = Self::new((self.size + 1) / 2);
        for (piece, orientation, place) in self.places() {
            let cell = self.cell_of[place];
            if cell == NONE {
                continue;
            }
            let place = above.place(piece / 2, orientation);
            let number = above.cell(place);
            above.counts[number] += self.counts[cell as usize];
            for (above, own) in above.sums.iter_mut().zip(&self.sums) {
                let own = &own[cell as usize];
                above[number].iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
            }
        }
        above
    }

    fn places(&self) -> impl Iterator<Item = (UVec3, u32, usize)> {
        let size = self.size;
        (0..size.element_product() * ORIENTATIONS).map(move |place| {
            let piece = place / ORIENTATIONS;
            let piece = UVec3::new(piece % size.x, piece / size.x % size.y, piece / size.x / size.y);
            (piece, place % ORIENTATIONS, place as usize)
        })
    }
}

impl Field {
    /// Learns a guide from photons; None if they are too few.
    pub fn learn(arrivals: &[PhotonArrival]) -> Option<Self> {
        let (low, high) = bounds(arrivals)?;
        let extent = (high - low).max(Vec3::splat(1e-20));
        let scale = RESOLUTION / extent.max_element();
        let size = (extent * scale)
            .ceil()
            .as_uvec3()
            .clamp(UVec3::ONE, UVec3::splat(RESOLUTION as u32));
        let mut finest = Level::new(size);
        for (number, arrival) in arrivals.iter().enumerate() {
            let piece = ((arrival.position - low) * scale).clamp(Vec3::ZERO, size.as_vec3() - 1.0);
            let axis = axis_of(arrival.normal);
            let place = finest.place(piece.as_uvec3(), axis as u32);
            let cell = finest.cell(place);
            let half = number / RUN % 2;
            finest.sums[half][cell][bin_of(axis, arrival.wi)] += arrival.power;
            finest.counts[cell] += 1;
        }
        let mut levels = vec![finest];
        while levels[levels.len() - 1].size != UVec3::ONE {
            levels.push(levels[levels.len() - 1].above());
        }
        let cosine = cosine_shares();
        let shares = shares_of(&levels, &cosine);
        let mut cells = vec![Cell::new(&cosine, 0.0)];
        let mut ready: Vec<Vec<Option<u32>>> = levels.iter().map(|level| vec![None; level.counts.len()]).collect();
        let mut number_of = |number: usize, cell: usize| {
            *ready[number][cell].get_or_insert_with(|| {
                let shares = &shares[number][cell];
                let halves = [0, 1].map(|half| &levels[number].sums[half][cell]);
                let Some(part) = part_of(shares, halves, &cosine) else {
                    return 0;
                };
                cells.push(Cell::new(shares, part));
                cells.len() as u32 - 1
            })
        };
        // The smallest voxel around each voxel that has enough photons.
        let found = |piece: UVec3, orientation: u32| {
            levels.iter().enumerate().find_map(|(number, level)| {
                let cell = level.cell_of[level.place(piece >> number as u32, orientation)];
                (cell != NONE && level.counts[cell as usize] >= LEAST_PHOTONS).then_some((number, cell as usize))
            })
        };
        let index = levels[0]
            .places()
            .map(|(piece, orientation, _)| {
                found(piece, orientation).map_or(0, |(number, cell)| number_of(number, cell))
            })
            .collect();
        (cells.len() > 1).then_some(Self {
            origin: low,
            scale,
            size,
            index,
            // A vector could hold up to twice the memory.
            cells: cells.into_boxed_slice(),
        })
    }

    /// Its memory in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&*self.index) + size_of_val(&*self.cells)
    }

    /// The indices of the voxels with their orientations.
    #[inline(always)]
    pub fn places(&self, position: Vec3Lanes, axes: &BinLanes) -> WordLanes {
        let along = |x: Lanes, origin: f32, size: u32| {
            let place = (x - Lanes::splat(origin)) * Lanes::splat(self.scale);
            place
                .fast_max(Lanes::ZERO)
                .trunc()
                .fast_min(Lanes::splat(size as f32 - 1.0))
        };
        let x = along(position.x, self.origin.x, self.size.x);
        let y = along(position.y, self.origin.y, self.size.y);
        let z = along(position.z, self.origin.z, self.size.z);
        let [wide, high] = [self.size.x, self.size.y].map(|size| Lanes::splat(size as f32));
        let piece: WordLanes = bytemuck::cast(z.mul_add(high, y).mul_add(wide, x).fast_trunc_int());
        piece * WordLanes::splat(ORIENTATIONS) + axes.axes()
    }

    /// The index of the histogram of a voxel and orientation; 0 for none.
    #[inline(always)]
    pub fn cell_at(&self, place: u32) -> u32 {
        self.index.get(place as usize).copied().unwrap_or(0)
    }

    /// The density per solid angle of a direction in the histogram at a point, and the part of a diffuse lobe that is
    /// sampled from it, from 0 to 1; None without a histogram.
    pub fn density(&self, position: Vec3, normal: Vec3, wi: Vec3) -> Option<(f32, f32)> {
        let axes = BinLanes::of(Vec3Lanes::splat(normal));
        let place = self.places(Vec3Lanes::splat(position), &axes).as_array()[0];
        let cell = match self.cell_at(place) {
            0 => return None,
            number => self.cell(number),
        };
        let (bins, densities) = axes.find(Vec3Lanes::splat(wi));
        let units = cell.count(bins.as_array()[0]) as f32;
        Some((units * densities.as_array()[0] / UNITS as f32, cell.part()))
    }

    #[inline(always)]
    pub fn cell(&self, number: u32) -> &Cell {
        &self.cells[number as usize]
    }
}

/// The shares of the bins in each level's histograms, blended with the next coarser level where photons are few.
fn shares_of(levels: &[Level], cosine: &[f32; BINS]) -> Vec<Vec<[f32; BINS]>> {
    let mut shares: Vec<Vec<[f32; BINS]>> = vec![Vec::new(); levels.len()];
    for (number, level) in levels.iter().enumerate().rev() {
        let mut own = vec![[0.0; BINS]; level.counts.len()];
        for (piece, orientation, place) in level.places() {
            let cell = level.cell_of[place];
            if cell == NONE {
                continue;
            }
            let cell = cell as usize;
            let prior = levels.get(number + 1).map_or(cosine, |above| {
                let around = above.cell_of[above.place(piece / 2, orientation)];
                &shares[number + 1][around as usize]
            });
            let sums: [f32; BINS] = std::array::from_fn(|bin| level.sums[0][cell][bin] + level.sums[1][cell][bin]);
            let count = level.counts[cell] as f32;
            let scale = count / sums.iter().sum::<f32>();
            own[cell] = std::array::from_fn(|bin| (sums[bin] * scale + PRIOR * prior[bin]) / (count + PRIOR));
        }
        shares[number] = own;
    }
    shares
}

/// The part of the directions to be sampled from a histogram whose bins have these shares; None if the histogram is of
/// no use. (Müller, "Practical Path Guiding in Production", SIGGRAPH 2019 courses, learns this part while the picture
/// is rendered.)
fn part_of(shares: &[f32; BINS], halves: [&[f32; BINS]; 2], cosine: &[f32; BINS]) -> Option<f32> {
    let [small, large] = PARTS.map(|part| gain(part, shares, halves, cosine));
    (small >= WORTHWHILE).then_some(PARTS[usize::from(large >= DECISIVE * small)])
}

/// The factor by which sampling this part of the directions by these shares reduces the second moment of light. The
/// product of two independent halves avoids the bias of squared noise, which would look like light from few directions.
fn gain(part: f32, shares: &[f32; BINS], halves: [&[f32; BINS]; 2], cosine: &[f32; BINS]) -> f32 {
    // In doubles, because the square of a power may exceed the range of floats in a scene of millimetres.
    let moment = |guided: f32| -> f64 {
        let of_bin = |bin: usize| {
            let density = guided * shares[bin] + (1.0 - guided) * cosine[bin];
            f64::from(halves[0][bin]) * f64::from(halves[1][bin]) / f64::from(density)
        };
        (0..BINS).filter(|&bin| cosine[bin] > 0.0).map(of_bin).sum()
    };
    let guided = moment(part);
    match guided > 0.0 {
        true => (moment(0.0) / guided) as f32,
        false => 1.0,
    }
}

/// A box around nearly all photons.
fn bounds(arrivals: &[PhotonArrival]) -> Option<(Vec3, Vec3)> {
    const MOST: usize = 1 << 14;
    let step = arrivals.len().div_ceil(MOST).max(1);
    let places = || arrivals.iter().step_by(step).map(|arrival| arrival.position);
    let count = places().count();
    if count < LEAST_PHOTONS as usize {
        return None;
    }
    let along = |axis: usize| {
        let mut along: Vec<f32> = places().map(|place| place[axis]).collect();
        along.sort_unstable_by(f32::total_cmp);
        let out = count / 200;
        [along[out], along[count - 1 - out]]
    };
    let [x, y, z] = [0, 1, 2].map(along);
    let ends = [0, 1].map(|end| Vec3::new(x[end], y[end], z[end]));
    let margin = 1e-3 * (ends[1] - ends[0]).max_element();
    Some((ends[0] - margin, ends[1] + margin))
}

#[cfg(test)]
mod tests {
    use glam::Vec3Swizzles;

    use super::*;
    use crate::sampling::hash::pcg3d;

    fn number(word: u32) -> f32 {
        (word >> 8) as f32 / (1 << 24) as f32
    }

    /// Photons on a floor of length 1, whose origins are in the directions that `from` makes of two numbers.
    fn photons(from: impl Fn(f32, f32) -> Vec3) -> Vec<PhotonArrival> {
        let photon = |index: u32| {
            let [x, y, u] = pcg3d([index, 1, 2]).map(number);
            let [v, w, _] = pcg3d([index, 3, 4]).map(number);
            PhotonArrival {
                position: Vec3::new(x, 0.0, y),
                normal: Vec3::Y,
                wi: from(u, v).normalize(),
                power: 0.5 + w,
            }
        };
        (0..1 << 16).map(photon).collect()
    }

    fn by_cosine(u: f32, v: f32) -> Vec3 {
        let (radius, turn) = (u.sqrt(), std::f32::consts::TAU * v);
        Vec3::new(radius * turn.cos(), (1.0 - u).sqrt(), radius * turn.sin())
    }

    fn cell_at(field: &Field, place: Vec3, normal: Vec3) -> u32 {
        let axes = BinLanes::of(Vec3Lanes::splat(normal));
        let places = field.places(Vec3Lanes::splat(place), &axes);
        field.cell_at(places.as_array()[0])
    }

    #[test]
    fn light_from_one_side_is_noted_there() {
        let gap = Vec3::new(1.0, 0.4, 0.1);
        let field = Field::learn(&photons(|u, v| gap + 0.1 * Vec3::new(0.0, u, v))).expect("a guide");
        let cell = cell_at(&field, Vec3::new(0.3, 0.0, 0.6), Vec3::Y);
        assert!(cell > 0);
        let counts: Vec<u32> = (0..BINS as u32).map(|bin| field.cell(cell).count(bin)).collect();
        let towards = bin_of(2, (gap + 0.05 * Vec3::new(0.0, 1.0, 1.0)).normalize());
        assert!(counts[towards] > 60, "{counts:?}");
        // No light reaches ceilings and walls, and no photon is far away.
        for other in [Vec3::NEG_Y, Vec3::X] {
            assert_eq!(cell_at(&field, Vec3::new(0.3, 0.0, 0.6), other), 0);
        }
        assert_eq!(field.size.y, 1);
        for outside in [Vec3::splat(1e9), Vec3::splat(-1e9), Vec3::splat(f32::NAN)] {
            cell_at(&field, outside, Vec3::Y);
        }
    }

    #[test]
    fn no_photons_make_a_field_too_large() {
        // The most photons, in all voxels and orientations, each lit from one direction.
        const COUNT: u32 = MOST_PHOTONS as u32;
        let side = RESOLUTION as u32;
        let photon = |index: u32| {
            let place = index / ORIENTATIONS % (side * side * side);
            let axis = index as usize % ORIENTATIONS as usize;
            let mut normal = Vec3::ZERO;
            normal[axis / 2] = if axis.is_multiple_of(2) { 1.0 } else { -1.0 };
            let piece = UVec3::new(place % side, place / side % side, place / side / side);
            PhotonArrival {
                position: piece.as_vec3() + 0.5,
                normal,
                wi: (normal + 0.3 * normal.yzx()).normalize(),
                power: 1.0,
            }
        };
        // Most photons are in voxels that have just enough of them for a histogram of their own, others in voxels with
        // too few.
        let few = |index: u32| index % (side * side * side * ORIENTATIONS) < COUNT / LEAST_PHOTONS;
        let own = (0..COUNT).map(|index| index / LEAST_PHOTONS);
        let all: Vec<PhotonArrival> = own
            .chain((0..COUNT / 8).filter(|&index| !few(index)))
            .map(photon)
            .collect();
        let field = Field::learn(&all).expect("a guide");
        let cells = field.cells.len();
        assert!((20_000..=MOST_CELLS).contains(&cells), "{cells}");
        assert!(field.bytes() <= MOST_BYTES, "{}", field.bytes());
    }

    #[test]
    fn light_from_one_side_alone_is_followed_farther() {
        let narrow = |u: f32, v: f32| Vec3::new(0.3, 1.0, 0.2) + 0.1 * Vec3::new(u, 0.0, v);
        let part = |from: &dyn Fn(f32, f32) -> Vec3| {
            let field = Field::learn(&photons(from)).expect("a guide");
            field.cell(cell_at(&field, Vec3::new(0.3, 0.0, 0.6), Vec3::Y)).part()
        };
        assert_eq!(part(&narrow), PARTS[1]);
        let and_everywhere = |u: f32, v: f32| {
            if u < 0.2 {
                narrow(u, v)
            } else {
                by_cosine((u - 0.2) / 0.8, v)
            }
        };
        assert_eq!(part(&and_everywhere), PARTS[0]);
    }

    #[test]
    fn light_from_everywhere_needs_no_guide() {
        assert!(Field::learn(&photons(by_cosine)).is_none());
        assert!(Field::learn(&photons(by_cosine)[..63]).is_none());
    }
}
