//! The gains within limits that come closest to the observations: a convex quadratic programme, solved by an interior
//! point method (the crate `clarabel`; Goulart and Chen, "Clarabel: An interior-point solver for conic programs with
//! quadratic objectives", 2024).

use std::ops::Range;

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSolver, IPSolver, NonnegativeConeT, SolverStatus, SupportedConeT, ZeroConeT,
};
use thiserror::Error;

use super::observations::{NormalEquations, Observations};
use crate::color::Rgb;

/// The weight of the squared change of each gain, beside the mean squared relative error: a change by one counts as
/// much as an error of 0.01 %. It decides where the observations do not: lamps that cannot be told apart change as
/// little as possible.
pub const PULL: f64 = 1e-8;

/// A gain counts as being at its limit within this share of the larger of both, and of one.
const AT_LIMIT: f64 = 1e-6;

/// What may be changed of a lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LampLimits {
    /// The present strength, at least 0.
    pub strength: f32,
    /// The present colour, with a largest component of 1. If only the strength is unknown, gains are multiples of it.
    pub color: Rgb,
    /// Whether the three components are unknown, each within the limits; otherwise they have one factor.
    pub colored: bool,
    /// The least strength, at least 0.
    pub least: f32,
    /// The largest strength, not below the least.
    pub most: f32,
}

/// A limit of a lamp.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// The lamp would have to be darker.
    Least,
    /// The lamp would have to be brighter.
    Most,
}

/// The answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Fit {
    /// The gain of each lamp.
    pub gains: Vec<Rgb>,
    /// The limit that holds back each lamp, if any.
    pub limits: Vec<Option<Limit>>,
    /// The root of the weighted mean squared relative error.
    pub error: f64,
    /// The same for each stroke; 0 if it has no observations.
    pub errors: Vec<f64>,
}

/// The reason why there is no answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum Unsolvable {
    /// There is no lamp.
    #[error("no lamp is chosen")]
    NoLamps,
    /// There is no observation that counts.
    #[error("nothing is painted where the picture has light")]
    NoPaint,
    /// The light of a lamp or what is wanted is infinite or not a number.
    #[error("the picture or the target has values that are not finite")]
    NotFinite,
    /// The limits of this lamp, counted from 0, are negative, infinite or in the wrong order.
    #[error("the limits of lamp {} are not 0 <= least <= most", .0 + 1)]
    Limits(usize),
    /// There are other numbers of limits and of lamps.
    #[error("there are limits of {limits} lamps, and light of {lamps}")]
    Count {
        /// The number of limits.
        limits: usize,
        /// The number of lamps.
        lamps: usize,
    },
    /// The solver gave up.
    #[error("the solver found no answer")]
    NoAnswer,
}

impl LampLimits {
    /// A lamp with the gain 1, of which only the strength may change, up to `most`.
    pub fn of_strength(most: f32) -> Self {
        Self {
            strength: 1.0,
            color: Rgb::ONE,
            colored: false,
            least: 0.0,
            most,
        }
    }

    /// The present gain.
    pub fn gain(&self) -> Rgb {
        self.strength * self.color
    }

    /// The factor of a component for a strength of one.
    pub(super) fn tint(&self, channel: usize) -> f64 {
        match self.colored {
            true => 1.0,
            false => f64::from(self.color[channel]),
        }
    }

    /// The present values of the unknowns.
    fn unknowns(&self) -> Vec<f64> {
        match self.colored {
            true => self.gain().to_array().map(f64::from).to_vec(),
            false => vec![f64::from(self.strength)],
        }
    }

    fn are_valid(&self) -> bool {
        let are_finite = self.gain().is_finite() && self.least.is_finite() && self.most.is_finite();
        let is_color = self.color.min_element() >= 0.0 && self.color.max_element() > 0.0;
        are_finite && self.strength >= 0.0 && is_color && 0.0 <= self.least && self.least <= self.most
    }
}

/// Finds the gains that come closest to the observations, pulled slightly towards the present ones (by [`PULL`]). The
/// answer has the same bits on any number of threads.
pub fn solve(observations: &Observations, limits: &[LampLimits]) -> Result<Fit, Unsolvable> {
    if limits.is_empty() {
        return Err(Unsolvable::NoLamps);
    }
    let (lamps, limit_count) = (observations.lamps(), limits.len());
    if lamps != limit_count {
        return Err(Unsolvable::Count {
            limits: limit_count,
            lamps,
        });
    }
    if let Some(lamp) = limits.iter().position(|limits| !limits.are_valid()) {
        return Err(Unsolvable::Limits(lamp));
    }
    if !observations.are_finite() {
        return Err(Unsolvable::NotFinite);
    }
    let unknowns = unknowns_of(limits);
    let mut equations = observations.normal_equations(limits, &unknowns);
    if equations.weight <= 0.0 {
        return Err(Unsolvable::NoPaint);
    }
    let bounds: Vec<[f64; 2]> = limits.iter().zip(&unknowns).flat_map(bounds_of).collect();
    let present: Vec<f64> = limits.iter().flat_map(LampLimits::unknowns).collect();
    equations.pull(&present);
    let mut values = minimise(&equations, &bounds)?;
    let at_limits = snap(&equations, &bounds, &mut values);
    let gain = |(limits, unknowns): (&LampLimits, &Range<usize>)| match values[unknowns.clone()] {
        [r, g, b] => Rgb::new(r as f32, g as f32, b as f32),
        ref strength => strength[0] as f32 * limits.color,
    };
    let gains: Vec<Rgb> = limits.iter().zip(&unknowns).map(gain).collect();
    let limit = |unknowns: &Range<usize>| at_limits[unknowns.clone()].iter().copied().flatten().next();
    let (error, errors) = errors(observations, &gains);
    Ok(Fit {
        limits: unknowns.iter().map(limit).collect(),
        gains,
        error,
        errors,
    })
}

/// The places of each lamp's unknowns among all.
fn unknowns_of(limits: &[LampLimits]) -> Vec<Range<usize>> {
    let ends = limits.iter().scan(0, |end, limits| {
        let start = *end;
        *end += if limits.colored { 3 } else { 1 };
        Some(start..*end)
    });
    ends.collect()
}

fn bounds_of((limits, unknowns): (&LampLimits, &Range<usize>)) -> Vec<[f64; 2]> {
    vec![[limits.least, limits.most].map(f64::from); unknowns.len()]
}

impl NormalEquations {
    /// Adds the pull towards the present values.
    fn pull(&mut self, present: &[f64]) {
        let count = self.right.len();
        for (place, value) in present.iter().enumerate() {
            self.matrix[place * count + place] += PULL;
            self.right[place] += PULL * value;
        }
    }

    /// Adds a slight pull towards zero, beside the largest element of the matrix.
    pub(super) fn keep_still(&mut self) {
        let count = self.right.len();
        let largest = (0..count).map(|place| self.at(place, place)).fold(0.0, f64::max);
        for place in 0..count {
            self.matrix[place * count + place] += 1e-9 * largest + 1e-30;
        }
    }

    /// An element of the symmetric matrix.
    fn at(&self, row: usize, column: usize) -> f64 {
        self.matrix[row.max(column) * self.right.len() + row.min(column)]
    }

    /// Half the derivative of the error with respect to an unknown.
    fn slope(&self, place: usize, values: &[f64]) -> f64 {
        let products = values
            .iter()
            .enumerate()
            .map(|(other, value)| self.at(place, other) * value);
        products.sum::<f64>() - self.right[place]
    }
}

/// Minimises the error within the bounds. Unknowns are scaled so that the matrix has ones on its diagonal.
pub(super) fn minimise(equations: &NormalEquations, bounds: &[[f64; 2]]) -> Result<Vec<f64>, Unsolvable> {
    let count = bounds.len();
    let scale: Vec<f64> = (0..count).map(|place| equations.at(place, place).sqrt()).collect();
    let upper = || (0..count).flat_map(|column| (0..=column).map(move |row| (row, column)));
    let matrix = CscMatrix::new_from_triplets(
        count,
        count,
        upper().map(|(row, _)| row).collect(),
        upper().map(|(_, column)| column).collect(),
        upper()
            .map(|(row, column)| equations.at(row, column) / (scale[row] * scale[column]))
            .collect(),
    );
    let right: Vec<f64> = equations
        .right
        .iter()
        .zip(&scale)
        .map(|(right, scale)| -right / scale)
        .collect();
    // Equal bounds leave no room inside, which the method needs: such unknowns are held by an equation.
    let (fixed, free): (Vec<usize>, Vec<usize>) = (0..count).partition(|&place| bounds[place][0] == bounds[place][1]);
    let mut rows: Vec<(usize, f64, f64)> = Vec::new();
    rows.extend(fixed.iter().map(|&place| (place, 1.0, bounds[place][0] * scale[place])));
    for &place in &free {
        rows.push((place, -1.0, -bounds[place][0] * scale[place]));
        rows.push((place, 1.0, bounds[place][1] * scale[place]));
    }
    let constraints = CscMatrix::new_from_triplets(
        rows.len(),
        count,
        (0..rows.len()).collect(),
        rows.iter().map(|row| row.0).collect(),
        rows.iter().map(|row| row.1).collect(),
    );
    let levels: Vec<f64> = rows.iter().map(|row| row.2).collect();
    let mut cones: Vec<SupportedConeT<f64>> = Vec::new();
    if !fixed.is_empty() {
        cones.push(ZeroConeT(fixed.len()));
    }
    if !free.is_empty() {
        cones.push(NonnegativeConeT(2 * free.len()));
    }
    let settings = DefaultSettings {
        verbose: false,
        tol_gap_abs: 1e-13,
        tol_gap_rel: 1e-13,
        tol_feas: 1e-12,
        ..DefaultSettings::default()
    };
    let mut solver = DefaultSolver::new(&matrix, &right, &constraints, &levels, &cones, settings);
    solver.solve();
    match solver.solution.status {
        SolverStatus::Solved | SolverStatus::AlmostSolved | SolverStatus::InsufficientProgress => {
            let values: Vec<f64> = solver
                .solution
                .x
                .iter()
                .zip(&scale)
                .map(|(x, scale)| x / scale)
                .collect();
            match values.iter().all(|value| value.is_finite()) {
                true => Ok(values),
                false => Err(Unsolvable::NoAnswer),
            }
        }
        _ => Err(Unsolvable::NoAnswer),
    }
}

/// Puts the values into the bounds, those next to a bound onto it, and says which bounds hold back a value.
fn snap(equations: &NormalEquations, bounds: &[[f64; 2]], values: &mut [f64]) -> Vec<Option<Limit>> {
    for (value, [least, most]) in values.iter_mut().zip(bounds) {
        // A wide range must not turn off a lamp whose strength is small beside its upper limit.
        if *value < least + AT_LIMIT * least.max(1.0) {
            *value = *least;
        } else if *value > most - AT_LIMIT * most.max(1.0) {
            *value = *most;
        }
    }
    let held = |(place, [least, most]): (usize, &[f64; 2])| {
        // The pull alone does not count: a lamp that changes nothing is held back by nothing.
        let enough = PULL * AT_LIMIT + AT_LIMIT * equations.at(place, place) * values[place].max(1.0);
        let slope = equations.slope(place, values);
        match values[place] {
            value if value == *most && slope < -enough => Some(Limit::Most),
            value if value == *least && slope > enough => Some(Limit::Least),
            _ => None,
        }
    };
    bounds.iter().enumerate().map(held).collect()
}

/// The root mean squared error of all observations, and of each stroke.
fn errors(observations: &Observations, gains: &[Rgb]) -> (f64, Vec<f64>) {
    let strokes = observations.list().iter().map(|one| one.stroke + 1).max().unwrap_or(0);
    let mut sums = vec![[0.0; 2]; strokes];
    for (place, observation) in observations.list().iter().enumerate() {
        let weight = f64::from(observation.weight);
        let sum = &mut sums[observation.stroke];
        sum[0] += weight * observations.squared_error(place, observations.shown(place, gains));
        sum[1] += weight;
    }
    let root = |[error, weight]: [f64; 2]| if weight > 0.0 { (error / weight).sqrt() } else { 0.0 };
    let all = sums
        .iter()
        .fold([0.0; 2], |all, sum| [all[0] + sum[0], all[1] + sum[1]]);
    (root(all), sums.into_iter().map(root).collect())
}
