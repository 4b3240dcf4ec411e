//! Tabulated distributions: a choice among weights, and a piecewise constant density on [0, 1).
//!
//! Both invert the cumulative sum instead of using an alias table: the inverse is monotonic, so well distributed
//! numbers give well distributed choices. A guide table (Chen and Asau 1974) makes the search constant time on average.
//! Two dimensions are in `bilinear.rs`.

use super::ONE_MINUS_EPSILON;

/// Uniform numbers have 24 bits; a discrete distribution shares out exactly these 2^24 cells, so that `pmf` is the true
/// frequency.
const CELLS: u32 = 1 << 24;

/// The most positive weights with a guaranteed cell each.
const MOST_GRANTED: usize = (CELLS / 2) as usize;

/// A draw from a [`DiscreteDistribution`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiscreteSample {
    /// The index of the weight that was chosen.
    pub index: u32,
    /// The probability of the choice.
    pub pmf: f32,
    /// The remaining random number, uniform in [0, 1). It has 24 bits less those spent on the choice: with thousands of
    /// weights draw a fresh number instead.
    pub remapped_u: f32,
}

/// Chooses an index with probability proportional to its weight.
#[derive(Clone, Debug)]
pub struct DiscreteDistribution {
    /// Cells [boundaries[i], boundaries[i + 1]) belong to index i.
    boundaries: Vec<u32>,
    /// The index that owns the first cell of each bucket of 2^`bucket_shift` cells.
    guide: Vec<u32>,
    bucket_shift: u32,
}

impl DiscreteDistribution {
    /// Builds from weights of any scale. Negative and non-finite weights count as zero. `None` if none is positive.
    ///
    /// Every positive weight stays possible, however small: the probabilities equal the weights within 2^-24 per
    /// weight.
    pub fn new(weights: &[f32]) -> Option<Self> {
        let weights = || weights.iter().map(|&weight| usable(weight));
        let total: f64 = weights().sum();
        let positive = weights().filter(|&weight| weight > 0.0).count();
        if positive == 0 {
            return None;
        }
        let granted = if positive <= MOST_GRANTED { positive } else { 0 };
        let shared = f64::from(CELLS - granted as u32);
        let (mut sum, mut seen) = (0.0, 0u32);
        let mut boundaries: Vec<u32> = std::iter::once(0)
            .chain(weights().map(|weight| {
                sum += weight;
                seen += u32::from(granted > 0 && weight > 0.0);
                ((sum / total * shared).round() as u32 + seen).min(CELLS)
            }))
            .collect();
        // Rounding may have put the last positive weight's sum below the total; zeros behind it must stay empty.
        let last_boundary = boundaries.last().copied().unwrap_or(0);
        for boundary in boundaries
            .iter_mut()
            .rev()
            .take_while(|boundary| **boundary == last_boundary)
        {
            *boundary = CELLS;
        }

        let count = boundaries.len() - 1;
        let bucket_shift = CELLS.ilog2() - count.next_power_of_two().ilog2().min(CELLS.ilog2());
        let mut owner = 0;
        let guide = (0..CELLS >> bucket_shift)
            .map(|bucket| {
                while boundaries[owner + 1] <= bucket << bucket_shift {
                    owner += 1;
                }
                owner as u32
            })
            .collect();
        Some(Self {
            boundaries,
            guide,
            bucket_shift,
        })
    }

    /// The number of weights.
    pub fn len(&self) -> usize {
        self.boundaries.len() - 1
    }

    /// Always false: a positive weight is required.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// The probability of `index`; 0 out of range.
    pub fn pmf(&self, index: u32) -> f32 {
        let index = index as usize;
        match (self.boundaries.get(index), self.boundaries.get(index + 1)) {
            (Some(first), Some(end)) => (end - first) as f32 / CELLS as f32,
            _ => 0.0,
        }
    }

    /// The choice for `u` in [0, 1), increasing with `u`.
    #[inline]
    pub fn sample(&self, u: f32) -> DiscreteSample {
        let position = u.clamp(0.0, ONE_MINUS_EPSILON) * CELLS as f32;
        let cell = position as u32;
        let bucket = (cell >> self.bucket_shift) as usize;
        let low = self.guide[bucket] as usize;
        let high = self
            .guide
            .get(bucket + 1)
            .map_or(self.len(), |&owner| owner as usize + 1);
        let index = low + self.boundaries[low + 1..high + 1].partition_point(|&boundary| boundary <= cell);
        let (first, end) = (self.boundaries[index], self.boundaries[index + 1]);
        let width = (end - first) as f32;
        DiscreteSample {
            index: index as u32,
            pmf: width / CELLS as f32,
            remapped_u: ((position - first as f32) / width).min(ONE_MINUS_EPSILON),
        }
    }
}

/// A draw from a [`PiecewiseConstant1d`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContinuousSample {
    /// The sampled number, in [0, 1).
    pub x: f32,
    /// Density at `x`, per unit of x.
    pub pdf: f32,
    /// The step of the table that holds `x`.
    pub cell: u32,
}

/// A density on [0, 1) that is constant on each of n equal steps.
#[derive(Clone, Debug)]
pub struct PiecewiseConstant1d {
    /// The cumulative probability at the start of each step, and 1 at the end.
    cumulative: Vec<f32>,
    /// The steps at which a search starts, for n equal intervals of the probability (Chen and Asau, On Generating
    /// Random Variates from an Empirical Distribution, 1974).
    guide: Vec<u32>,
    integral: f32,
}

impl PiecewiseConstant1d {
    /// Builds from function values of any scale, one for each step. Negative and non-finite values count as zero.
    /// `None` if none is positive.
    pub fn new(values: &[f32]) -> Option<Self> {
        let total: f64 = values.iter().map(|&value| usable(value)).sum();
        if total <= 0.0 {
            return None;
        }
        let mut sum = 0.0;
        let mut cumulative: Vec<f32> = std::iter::once(0.0)
            .chain(values.iter().map(|&value| {
                sum += usable(value);
                (sum / total) as f32
            }))
            .collect();
        let last = cumulative.last().copied().unwrap_or(1.0);
        for entry in cumulative.iter_mut().rev().take_while(|entry| **entry == last) {
            *entry = 1.0;
        }
        let mut cell = 0;
        let guide = (0..values.len())
            .map(|k| {
                cell = cell_at(&cumulative, cell, k as f32 / values.len() as f32);
                cell as u32
            })
            .collect();
        Some(Self {
            cumulative,
            guide,
            integral: (total / values.len() as f64) as f32,
        })
    }

    /// The integral of the function over [0, 1), before normalisation.
    pub fn integral(&self) -> f32 {
        self.integral
    }

    fn steps(&self) -> usize {
        self.cumulative.len() - 1
    }

    fn cell_pdf(&self, cell: usize) -> f32 {
        (self.cumulative[cell + 1] - self.cumulative[cell]) * self.steps() as f32
    }

    /// Density at `x`, per unit of x; 0 outside [0, 1).
    pub fn pdf(&self, x: f32) -> f32 {
        if !(0.0..1.0).contains(&x) {
            return 0.0;
        }
        self.cell_pdf(((x * self.steps() as f32) as usize).min(self.steps() - 1))
    }

    /// The point below which the fraction `u` in [0, 1) of the probability lies.
    pub fn sample(&self, u: f32) -> ContinuousSample {
        let u = u.clamp(0.0, ONE_MINUS_EPSILON);
        let entry = ((u * self.guide.len() as f32) as usize).min(self.guide.len() - 1);
        let cell = cell_at(&self.cumulative, self.guide[entry] as usize, u);
        let (start, end) = (self.cumulative[cell], self.cumulative[cell + 1]);
        let x = (cell as f32 + (u - start) / (end - start)) / self.steps() as f32;
        ContinuousSample {
            x: x.min(ONE_MINUS_EPSILON),
            pdf: self.cell_pdf(cell),
            cell: cell as u32,
        }
    }
}

/// The last step whose start is at most `u` in [0, 1), searched from the step `near` on.
#[inline(always)]
fn cell_at(cumulative: &[f32], near: usize, u: f32) -> usize {
    let mut cell = near;
    while cumulative[cell + 1] <= u {
        cell += 1;
    }
    // Rounding may have given the next entry of the guide.
    while cumulative[cell] > u {
        cell -= 1;
    }
    cell
}

/// The weight in double precision; zero if it is negative or not finite.
fn usable(weight: f32) -> f64 {
    if weight.is_finite() {
        f64::from(weight.max(0.0))
    } else {
        0.0
    }
}
