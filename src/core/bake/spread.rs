//! The part of each texel over which its samples are spread.
//!
//! A texel is the mean of the light over its part of the surface: each sample has its own position there, otherwise the
//! edges of shadows would be as jagged as the texels. The square of a texel is divided into 4 x 4 cells, and those
//! count whose corners lie on the surface and are visible from the texel's centre. So objects standing on a surface do
//! not darken the texels around their feet, and no light of the far side of a wall leaks through.

use glam::{Vec2, Vec3};

/// Cells along the side of a texel.
const CELLS: u32 = 4;
/// Corners of cells along the side.
const CORNERS: u32 = CELLS + 1;

/// The area in the world over which the samples of a texel are spread.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spread {
    /// The position of the texel's upper left corner.
    corner: Vec3,
    /// The edge vectors of the texel in the world, along its rows and its columns.
    along: [Vec3; 2],
    /// A bit mask of cells, row by row.
    cells: u16,
}

/// A bit mask of cell corners, row by row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Corners(u32);

impl Corners {
    pub const ALL: Self = Self((1 << (CORNERS * CORNERS)) - 1);

    /// All corners as masks of one bit, with their positions from (0, 0) to (1, 1).
    pub fn all() -> impl Iterator<Item = (Self, Vec2)> {
        (0..CORNERS * CORNERS).map(|number| {
            let place = Vec2::new((number % CORNERS) as f32, (number / CORNERS) as f32);
            (Self(1 << number), place / CELLS as f32)
        })
    }

    pub fn add(&mut self, more: Self) {
        self.0 |= more.0;
    }

    pub fn are_all(self) -> bool {
        self == Self::ALL
    }

    /// A bit mask of the cells of which all four corners are set.
    fn cells(self) -> u16 {
        let rows = self.0 & self.0 >> 1;
        let squares = rows & rows >> CORNERS;
        let row = |row: u32| (squares >> (row * CORNERS) & 0xf) << (row * CELLS);
        (row(0) | row(1) | row(2) | row(3)) as u16
    }
}

impl Spread {
    /// A texel without cells.
    pub(super) fn new(corner: Vec3, along: [Vec3; 2]) -> Self {
        Self {
            corner,
            along,
            cells: 0,
        }
    }

    /// The position in the world at these coordinates from (0, 0) to (1, 1) in the texel.
    pub(super) fn at(&self, part: Vec2) -> Vec3 {
        self.corner + self.along[0] * part.x + self.along[1] * part.y
    }

    /// The longer side of the texel in the world.
    pub(super) fn side(&self) -> f32 {
        let [row, column] = self.along;
        row.length().max(column.length())
    }

    /// Adds the cells of which all four corners are in `corners`.
    pub(super) fn take(&mut self, corners: Corners) {
        self.cells = corners.cells();
    }

    /// Whether the samples have positions of their own.
    pub(super) fn has_cells(&self) -> bool {
        self.cells != 0
    }

    /// Removes the cells of which a corner is not in `corners`.
    pub(super) fn keep(&mut self, corners: Corners) {
        self.cells &= corners.cells();
    }

    /// The position of a sample with the random numbers `u`; None if the texel has no cells, so that light is gathered
    /// at its receiver.
    pub fn place(&self, u: Vec2) -> Option<Vec3> {
        if self.cells == u16::MAX {
            return Some(self.at(u));
        }
        let count = self.cells.count_ones();
        let number = ((u.x * count as f32) as u32).min(count.checked_sub(1)?);
        let mut cells = self.cells;
        for _ in 0..number {
            cells &= cells - 1;
        }
        let cell = cells.trailing_zeros();
        let within = Vec2::new((u.x * count as f32 - number as f32).min(1.0), u.y);
        let corner = Vec2::new((cell % CELLS) as f32, (cell / CELLS) as f32);
        Some(self.at((corner + within) / CELLS as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(cells: u16) -> Spread {
        Spread {
            corner: Vec3::ZERO,
            along: [Vec3::X, Vec3::Y],
            cells,
        }
    }

    #[test]
    fn cells_have_four_corners() {
        assert_eq!(Corners::ALL.cells(), u16::MAX);
        let upper = Corners::all().filter(|(_, part)| part.y <= 0.25);
        let mut corners = Corners::default();
        upper.for_each(|(corner, _)| corners.add(corner));
        assert_eq!(corners.cells(), 0xf);
        let without_middle = Corners(Corners::ALL.0 & !(1 << 12));
        assert_eq!(without_middle.cells(), 0xf99f);
    }

    #[test]
    fn samples_are_spread_evenly_over_the_cells() {
        for cells in [0x7fff, 0x8001, 0x0700, 1] {
            let spread = of(cells);
            let count = cells.count_ones();
            for number in 0..count {
                let u = Vec2::new((number as f32 + 0.5) / count as f32, 0.25);
                let place = spread.place(u).expect("cells").truncate() * 4.0;
                let cell = place.floor().as_uvec2();
                assert_eq!(place.fract(), Vec2::new(0.5, 0.25));
                assert!(cells >> (cell.y * 4 + cell.x) & 1 == 1, "{cells:x} {place}");
            }
            for u in [Vec2::ZERO, Vec2::splat(1.0 - f32::EPSILON)] {
                let place = spread.place(u).expect("cells");
                assert!(place.min_element() >= 0.0 && place.max_element() <= 1.0);
            }
        }
        assert_eq!(of(0).place(Vec2::splat(0.5)), None);
        assert_eq!(of(u16::MAX).place(Vec2::new(0.3, 0.8)), Some(Vec3::new(0.3, 0.8, 0.0)));
    }
}
