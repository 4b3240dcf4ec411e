//! Cells around scattered points: Worley, A Cellular Texture Basis Function, SIGGRAPH 1996.

use glam::Affine2;

use super::hash::{hash, pair, unit};
use super::*;

/// Cells around scattered points, one in each cell of a lattice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cells {
    /// The colours at the values 0 and 1, each of which may be a texture before this one in the table.
    pub colors: [Parameter<Rgb>; 2],
    /// The quantity that is shown.
    pub value: CellValue,
    /// The extent of the square within its lattice cell in which a point is scattered, in [0, 1]; 0 gives squares.
    pub scatter: f32,
    /// The transform of uv; the lattice has one cell per unit.
    pub to_uv: Affine2,
}

declare_names! {
    /// The quantity that cells show, in units of their lattice.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum CellValue {
        /// The distance from the nearest point.
        #[default]
        Distance = "distance",
        /// The difference of the distances from the two nearest points: 0 along the borders.
        Border = "border",
        /// A random number of the nearest point.
        Random = "random",
    }
}

const SEED: u32 = 201;

impl Cells {
    /// The value in [0, 1] at a point of the pattern.
    pub fn share<R: Real>(&self, [x, y]: [R; 2]) -> R {
        let (left, low) = (x.floor(), y.floor());
        let far = R::splat(1e9);
        let (mut nearest, mut second) = (far, far);
        let (mut column, mut row) = (left, low);
        let scatter = R::splat(self.scatter);
        for j in -1..=1 {
            for i in -1..=1 {
                let cell = [left + R::splat(i as f32), low + R::splat(j as f32)];
                let [u, v] = pair(cell, SEED).map(|random| R::HALF + scatter * (random - R::HALF));
                let (dx, dy) = (cell[0] + u - x, cell[1] + v - y);
                let distance = dx * dx + dy * dy;
                let is_nearer = distance.is_less(nearest);
                second = R::select(is_nearer, nearest, second.min(distance));
                nearest = R::select(is_nearer, distance, nearest);
                column = R::select(is_nearer, cell[0], column);
                row = R::select(is_nearer, cell[1], row);
            }
        }
        let value = match self.value {
            CellValue::Distance => nearest.sqrt(),
            CellValue::Border => second.sqrt() - nearest.sqrt(),
            CellValue::Random => unit::<R>(hash([column, row], SEED + 1)),
        };
        value.saturated()
    }

    /// The value at a point of a surface.
    pub(in crate::texture) fn value<V: TextureValue>(&self, table: &TextureTable, at: &TexturePoint) -> V {
        let share = self.share(point(&self.to_uv, at.uv));
        mixed(table, self.colors, share, at)
    }

    /// The step for derivatives, in coordinates of the pattern.
    pub(in crate::texture) fn step(&self) -> f32 {
        STEP
    }
}
