//! A density on the unit square, bilinear between the nodes of a regular grid: what a bilinearly filtered picture is sampled by.
//!
//! The marginal over rows is piecewise linear, and so is the conditional within any line between two rows: the blend of the rows'
//! cumulative sums. Both are inverted by bisection and a quadratic (compare PBR 4th ed., appendix A.4 and A.5, for the constant case).
//! Sums are kept in f32, whose rounding (6e-8 of a row) moves shares between neighbours but adds up to nothing, and inverted in f64, so
//! that a cell is covered evenly however small its share is.

use glam::{DVec2, Vec2};

/// Half a step of the 24-bit random numbers: they stand for the middle of their interval, so that no sample falls on a node of density 0.
const HALF_STEP: f64 = 0.5 / (1 << 24) as f64;

/// A draw from a [`PiecewiseBilinear2d`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SquareSample {
    /// The sampled point, in [0, 1]^2.
    pub position: Vec2,
    /// Density per unit area at `position`, positive.
    pub pdf: f32,
}

/// A node of the grid.
#[derive(Clone, Copy, Debug)]
struct Node {
    density: f32,
    /// The integral from the left edge to the node along its row.
    before: f32,
}

/// A density on [0, 1]^2 given at the nodes of a grid, whose outer nodes lie on the border.
#[derive(Clone, Debug)]
pub struct PiecewiseBilinear2d {
    columns: usize,
    rows: usize,
    /// Row by row. What a sample needs of a node is in one line of the cache.
    nodes: Vec<Node>,
    /// The integral over the square up to each row.
    up_to_row: Vec<f64>,
    /// The columns before which equal shares of each row lie, where the search for a share begins (Chen and Asau, On generating random variates
    /// from an empirical distribution, 1974).
    guides: Vec<u32>,
    /// The number of such shares in a row.
    shares: usize,
    /// The rows before which equal shares of the square lie, likewise.
    row_guides: Vec<u32>,
}

/// The number of columns, or of rows, in a share. Those of most shares are in one line of the cache.
const PER_SHARE: usize = 2;

impl PiecewiseBilinear2d {
    /// Bytes of memory for each node of the grid: density, integral and half an entry of the guides.
    pub(crate) const BYTES_PER_NODE: u64 = 10;

    /// Builds from `rows` rows of `columns` function values of any scale. Negative and non-finite values count as zero. `None` if none is positive,
    /// or if there are fewer than two rows or columns.
    pub fn new(columns: usize, rows: usize, values: &[f32]) -> Option<Self> {
        if columns < 2 || rows < 2 || values.len() != columns * rows {
            return None;
        }
        let usable = |value: f32| {
            if value.is_finite() {
                f64::from(value.max(0.0))
            } else {
                0.0
            }
        };
        let step = DVec2::new(1.0 / (columns - 1) as f64, 1.0 / (rows - 1) as f64);
        let row_totals = values.chunks_exact(columns).map(|row| {
            let inner: f64 = row.iter().map(|&value| usable(value)).sum();
            step.x * (inner - 0.5 * (usable(row[0]) + usable(row[columns - 1])))
        });
        let row_totals: Vec<f64> = row_totals.collect();
        let total = step.y * (row_totals.iter().sum::<f64>() - 0.5 * (row_totals[0] + row_totals[rows - 1]));
        if total <= 0.0 {
            return None;
        }
        let node = |&value: &f32| Node {
            density: (usable(value) / total) as f32,
            before: 0.0,
        };
        let mut nodes: Vec<Node> = values.iter().map(node).collect();
        for row in nodes.chunks_exact_mut(columns) {
            let mut sum = 0.0;
            for column in 1..columns {
                sum += 0.5 * step.x * (f64::from(row[column - 1].density) + f64::from(row[column].density));
                row[column].before = sum as f32;
            }
        }
        let mut sum = 0.0;
        let up_to_row: Vec<f64> = std::iter::once(0.0)
            .chain((1..rows).map(|row| {
                let [before, here] = [row - 1, row].map(|row| f64::from(nodes[row * columns + columns - 1].before));
                sum += 0.5 * step.y * (before + here);
                sum
            }))
            .collect();
        let shares = (columns / PER_SHARE).max(1);
        let guides = nodes.chunks_exact(columns).flat_map(|row| {
            let mut column = 0;
            (0..=shares).map(move |share| {
                let target = f64::from(row[columns - 1].before) * (share as f64 / shares as f64);
                while column < columns - 2 && f64::from(row[column + 1].before) <= target {
                    column += 1;
                }
                column as u32
            })
        });
        let row_shares = (rows / PER_SHARE).max(1);
        let row_guides = (0..=row_shares).map(|share| {
            let target = up_to_row[rows - 1] * (share as f64 / row_shares as f64);
            let row = up_to_row.partition_point(|&sum| sum <= target).clamp(1, rows - 1) - 1;
            row as u32
        });
        Some(Self {
            row_guides: row_guides.collect(),
            guides: guides.collect(),
            shares,
            columns,
            rows,
            nodes,
            up_to_row,
        })
    }

    /// The columns between which the share `u` of both rows is, within rounding.
    fn guided(&self, row: usize, u: f64) -> (usize, usize) {
        let share = ((u * self.shares as f64) as usize).min(self.shares - 1);
        let of_row = |row: usize| {
            let at = row * (self.shares + 1) + share;
            [self.guides[at] as usize, self.guides[at + 1] as usize]
        };
        let ([start, end], [other_start, other_end]) = (of_row(row), of_row(row + 1));
        (start.min(other_start), end.max(other_end) + 1)
    }

    /// The last row whose sum is not above `target`, the share `u` of all, and that is not the last one.
    fn row_of(&self, u: f64, target: f64) -> usize {
        let shares = self.row_guides.len() - 1;
        let share = ((u * shares as f64) as usize).min(shares - 1);
        let [start, end] = [share, share + 1].map(|share| self.row_guides[share] as usize);
        // Rounding may have put the target just outside of its share.
        let start = if self.up_to_row[start] > target { 0 } else { start };
        let end = (end + 1).min(self.rows - 1);
        let end = if self.up_to_row[end] <= target {
            self.rows - 1
        } else {
            end
        };
        let among = &self.up_to_row[start + 1..end];
        start + among.partition_point(|&sum| sum <= target)
    }

    /// Density at a point, per unit area; 0 outside of [0, 1]^2.
    pub fn pdf(&self, position: Vec2) -> f32 {
        if !(position.cmpge(Vec2::ZERO) & position.cmple(Vec2::ONE)).all() {
            return 0.0;
        }
        let [x, y] = [
            position.x * (self.columns - 1) as f32,
            position.y * (self.rows - 1) as f32,
        ];
        let (column, row) = ((x as usize).min(self.columns - 2), (y as usize).min(self.rows - 2));
        let (s, t) = (x - column as f32, y - row as f32);
        let at = row * self.columns + column;
        let [lower, upper] =
            [at, at + self.columns].map(|at| lerp32(self.nodes[at].density, self.nodes[at + 1].density, s));
        lerp32(lower, upper, t)
    }

    /// The point for `u` in [0, 1)^2.
    pub fn sample(&self, u: Vec2) -> SquareSample {
        let u = u.as_dvec2() + HALF_STEP;
        let row_total = |row: usize| f64::from(self.nodes[row * self.columns + self.columns - 1].before);
        let target = u.y * self.up_to_row[self.rows - 1];
        let row = self.row_of(u.y, target);
        let (start, end) = (self.up_to_row[row], self.up_to_row[row + 1]);
        let t = invert_linear(row_total(row), row_total(row + 1), (target - start) / (end - start));

        let (lower, upper) = self.nodes[row * self.columns..][..2 * self.columns].split_at(self.columns);
        let blend = |a: f32, b: f32| lerp(f64::from(a), f64::from(b), t);
        let sum_at = |column: usize| blend(lower[column].before, upper[column].before);
        let density_at = |column: usize| blend(lower[column].density, upper[column].density);
        let target = u.x * sum_at(self.columns - 1);
        // The last column whose sum is not above the target is in [0, columns - 2].
        let (mut column, mut beyond) = self.guided(row, u.x);
        if sum_at(column) > target {
            column = 0;
        }
        if sum_at(beyond) <= target {
            beyond = self.columns - 1;
        }
        while beyond - column > 1 {
            let middle = column.midpoint(beyond);
            if sum_at(middle) <= target {
                column = middle;
            } else {
                beyond = middle;
            }
        }
        let (start, end) = (sum_at(column), sum_at(column + 1));
        let (left, right) = (density_at(column), density_at(column + 1));
        let s = invert_linear(left, right, (target - start) / (end - start));
        SquareSample {
            position: Vec2::new(
                ((column as f64 + s) / (self.columns - 1) as f64) as f32,
                ((row as f64 + t) / (self.rows - 1) as f64) as f32,
            ),
            pdf: (lerp(left, right, s) as f32).max(f32::MIN_POSITIVE),
        }
    }
}

/// The x in [0, 1] below which the fraction `u` of the integral of a linear function with end values `a` and `b` lies.
fn invert_linear(a: f64, b: f64, u: f64) -> f64 {
    let u = u.clamp(0.0, 1.0);
    let denominator = a + lerp(a * a, b * b, u).sqrt();
    if denominator > 0.0 {
        (u * (a + b) / denominator).min(1.0)
    } else {
        u
    }
}

fn lerp(a: f64, b: f64, t: f64) -> f64 {
    a + t * (b - a)
}

fn lerp32(a: f32, b: f32, t: f32) -> f32 {
    a + t * (b - a)
}
