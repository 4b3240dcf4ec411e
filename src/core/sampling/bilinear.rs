//! A density on the unit square, bilinear between the nodes of a regular grid, by which bilinearly filtered pictures
//! are sampled.
//!
//! The marginal over rows is piecewise linear, and so is the conditional within any line between two rows: the blend of
//! the rows' cumulative sums. Both are inverted by bisection and a quadratic (compare PBR 4th ed., appendix A.4 and
//! A.5, for the constant case). The rounding of sums (6e-8 of a row) moves probability between neighbours without
//! changing the total. The probability of a cell is taken from the densities at its corners, not from the difference of
//! two sums, so that points cover it evenly however small it is.

use glam::DVec2;

use crate::math::{Mask, Real, Word};

/// Half a step of the 24-bit random numbers. Each number is moved to the middle of its interval, so that no sample
/// falls on a node of density 0.
const HALF_STEP: f32 = 0.5 / (1 << 24) as f32;

/// A draw from a [`PiecewiseBilinear2d`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SquareSample<R: Real = f32> {
    /// The sampled point, in [0, 1]^2.
    pub position: [R; 2],
    /// Density per unit area at `position`, positive.
    pub pdf: R,
}

/// A node of the grid.
#[derive(Clone, Copy, Debug)]
struct Node {
    density: f32,
    /// The integral along the row up to the node.
    before: f32,
}

/// A density on [0, 1]^2 given at the nodes of a grid, whose outer nodes are on the border.
#[derive(Clone, Debug)]
pub struct PiecewiseBilinear2d {
    columns: usize,
    rows: usize,
    /// The nodes row by row. The data of a node are in one cache line.
    nodes: Vec<Node>,
    /// The integral over the square up to each row.
    up_to_row: Vec<f32>,
    /// The columns at which the search in a row starts: the row's probability is divided into equal intervals, and
    /// these are the columns of their starts (Chen and Asau, On generating random variates from an empirical
    /// distribution, 1974).
    guides: Vec<u32>,
    /// The number of such intervals in a row.
    shares: usize,
    /// The rows at which the search in the square starts, for equal intervals of the whole probability.
    row_guides: Vec<u32>,
}

/// The number of columns, or of rows, in an interval. Most intervals are in one cache line.
const PER_SHARE: usize = 2;

impl PiecewiseBilinear2d {
    /// Bytes of memory for each node of the grid: density, integral and half an entry of the guides.
    pub(crate) const BYTES_PER_NODE: u64 = 10;

    /// Builds from `rows` rows of `columns` function values of any scale. Negative and non-finite values count as zero.
    /// `None` if none is positive, or if there are fewer than two rows or columns.
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
            up_to_row: up_to_row.into_iter().map(|sum| sum as f32).collect(),
        })
    }

    /// The density at a point, per unit area; 0 outside of [0, 1]^2.
    #[inline(always)]
    pub fn pdf<R: Real>(&self, [x, y]: [R; 2]) -> R {
        let within = |x: R| !(x.is_less(R::ZERO) | x.is_more(R::ONE)) & x.equals(x);
        let cell = |x: R, nodes: usize| {
            let place = x.saturated() * R::splat((nodes - 1) as f32);
            let cell = place.floor().min(R::splat((nodes - 2) as f32));
            (cell, place - cell)
        };
        let ((column, s), (row, t)) = (cell(x, self.columns), cell(y, self.rows));
        let rows = self.rows_beside(row);
        let density = |column: R| self.between(rows, column, t, |node| node.density);
        density(column)
            .mix(density(column + R::ONE), s)
            .only(within(x) & within(y))
    }

    /// The point for `u` in [0, 1)^2.
    #[inline(always)]
    pub fn sample<R: Real>(&self, [u, v]: [R; 2]) -> SquareSample<R> {
        let up_to = |row: R| R::gather(row.whole(), |row| self.up_to_row[row]);
        let last_row = R::splat((self.rows - 1) as f32);
        let shares = self.row_guides.len() - 1;
        let share = share_of(v, shares);
        let guide = |share: R::Word| R::gather(share, |share| self.row_guides[share] as f32);
        let (first, beyond) = (guide(share), guide(share + R::Word::splat(1)) + R::ONE);
        let all = up_to(last_row);
        let row = last_below([first, beyond.min(last_row), last_row], all * v, up_to);
        let rows = self.rows_beside(row);
        let right = R::splat((self.columns - 1) as f32);
        let total = |row: R::Word| R::gather(row + right.whole(), |node| self.nodes[node].before);
        let [above, below] = rows.map(total);
        let rest = v.mul_add(all, R::splat(HALF_STEP) * all - up_to(row));
        let t = invert_linear([above, below], rest * last_row);

        let sum = |column: R| self.between(rows, column, t, |node| node.before);
        let guides = R::Word::splat(self.shares as u32 + 1);
        let of_row = [row.whole(), row.whole() + R::Word::splat(1)].map(|row| row * guides + share_of(u, self.shares));
        let guide = |at: R::Word| R::gather(at, |at| self.guides[at] as f32);
        let [first, other_first] = of_row.map(guide);
        let [beyond, other_beyond] = of_row.map(|at| guide(at + R::Word::splat(1)) + R::ONE);
        let all = above.mix(below, t);
        let column = last_below(
            [first.min(other_first), beyond.max(other_beyond).min(right), right],
            all * u,
            sum,
        );
        let density = |column: R| self.between(rows, column, t, |node| node.density);
        let (left, beside) = (density(column), density(column + R::ONE));
        let rest = u.mul_add(all, R::splat(HALF_STEP) * all - sum(column));
        let s = invert_linear([left, beside], rest * right);
        SquareSample {
            position: [(column + s) / right, (row + t) / last_row],
            pdf: left.mix(beside, s).max(R::splat(f32::MIN_POSITIVE)),
        }
    }

    /// The first nodes of a row and of the next one.
    #[inline(always)]
    fn rows_beside<R: Real>(&self, row: R) -> [R::Word; 2] {
        let columns = R::Word::splat(self.columns as u32);
        let first = row.whole() * columns;
        [first, first + columns]
    }

    /// A value of the nodes in a column, interpolated at `t` between two rows, which are given by their first nodes.
    #[inline(always)]
    fn between<R: Real>(&self, rows: [R::Word; 2], column: R, t: R, figure: impl Fn(&Node) -> f32) -> R {
        let [above, below] = rows.map(|row| R::gather(row + column.whole(), |node| figure(&self.nodes[node])));
        above.mix(below, t)
    }
}

/// The index of the interval of [0, 1) that holds `u`, among `shares` equal ones.
#[inline(always)]
fn share_of<R: Real>(u: R, shares: usize) -> R::Word {
    (u * R::splat(shares as f32)).min(R::splat((shares - 1) as f32)).whole()
}

/// The last index before `last` whose sum is not above `target`. It is in [first, beyond), up to rounding.
#[inline(always)]
fn last_below<R: Real>([first, beyond, last]: [R; 3], target: R, sum: impl Fn(R) -> R) -> R {
    let mut low = first.only(sum(first).is_at_most(target));
    let mut high = R::select(sum(beyond).is_at_most(target), last, beyond);
    loop {
        let middle = (R::HALF * (low + high)).floor();
        if !middle.is_more(low).any() {
            return low;
        }
        let is_below = sum(middle).is_at_most(target);
        low = R::select(is_below, middle, low);
        high = R::select(is_below, high, middle);
    }
}

/// The x in [0, 1] up to which the integral of a linear function with these end values is `integral`.
#[inline(always)]
fn invert_linear<R: Real>(ends: [R; 2], integral: R) -> R {
    let largest = ends[0].max(ends[1]).max(R::splat(f32::MIN_POSITIVE));
    let [a, b] = ends.map(|end| end / largest);
    let twice = (integral / largest + integral / largest).max(R::ZERO).min(a + b);
    // The square root of a^2 + (b^2 - a^2) twice / (a + b).
    let root = twice.mul_add(b - a, a * a).max(R::ZERO).sqrt();
    let denominator = (a + root).max(R::splat(f32::MIN_POSITIVE));
    (twice / denominator).min(R::ONE)
}
