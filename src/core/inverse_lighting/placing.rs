//! Numbers that light is not linear in, such as places and aims of lamps and the hour of the sun: those that come
//! closest to the wanted light.
//!
//! A look at places spread over all that is allowed (the Halton sequence; Halton, "On the efficiency of certain
//! quasi-random sequences of points", 1960) finds the valley, and Gauss-Newton steps within a region of trust find its
//! floor (Nocedal and Wright, "Numerical Optimization", 2006, sections 4.1 and 10.3). Derivatives are differences: the
//! errors at neighbouring places have to come from equal random numbers. The strengths of lamps are found anew at each
//! place, so that a step knows how they follow (variable projection; Golub and Pereyra 1973).

use super::observations::NormalEquations;
use super::solve::{Limit, minimise};

/// The places of the first look for each number, and for all together.
const LOOKS: [usize; 2] = [48, 240];
/// The most steps after the first look.
const STEPS: usize = 40;
/// Steps end when they may be no longer than this share of what is allowed.
const SHORTEST: f64 = 1e-3;
/// Steps end when one lowers the error by less than this share.
const LEAST_GAIN: f64 = 1e-3;
/// A number within this share of what is allowed is at its limit.
const AT_LIMIT: f64 = 1e-6;

/// The values that a number may have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The present value, within the limits.
    pub present: f64,
    /// The least value.
    pub least: f64,
    /// The largest value, above the least.
    pub most: f64,
    /// The shortest distance of two values that make a difference, above 0.
    pub step: f64,
}

/// The light of a place that was tried.
#[derive(Clone, Debug, PartialEq)]
pub struct Tried<T> {
    /// The errors, as [`Observations::residuals`](super::Observations::residuals) gives them; as many at every place.
    pub residuals: Vec<f64>,
    /// What else is to be known of the place.
    pub found: T,
}

/// The place that comes closest.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed<T> {
    /// The numbers.
    pub values: Vec<f64>,
    /// The limit that each of them is at, if any.
    pub limits: Vec<Option<Limit>>,
    /// The root of the mean squared relative error.
    pub error: f64,
    /// The same at the present place.
    pub error_before: f64,
    /// What was tried there.
    pub found: T,
    /// The number of places that were tried.
    pub tried: usize,
}

/// A search under way.
struct Placing<'a, T, Stop> {
    ranges: &'a [Range],
    light: &'a mut dyn FnMut(&[f64]) -> Result<Option<Tried<T>>, Stop>,
    watch: &'a mut dyn FnMut(f64, f64),
    tried: usize,
}

/// A place in shares of what is allowed, with its light.
struct Point<T> {
    shares: Vec<f64>,
    light: Tried<T>,
    squared: f64,
}

/// Searches for the place that comes closest. `light` gives the light at a place: Ok(None) where there is none to speak
/// of, and an error to end the search. `watch` gets the share of the work that is done at least, from 0 to 1, and the
/// error so far. Ok(None) if the present place has no light to speak of.
///
/// The search ends when steps may be no longer than a thousandth of what is allowed, when a step lowers the error by
/// less than a thousandth, or after 40 steps.
pub fn place<T, Stop>(
    ranges: &[Range],
    light: &mut dyn FnMut(&[f64]) -> Result<Option<Tried<T>>, Stop>,
    watch: &mut dyn FnMut(f64, f64),
) -> Result<Option<Placed<T>>, Stop> {
    Placing {
        ranges,
        light,
        watch,
        tried: 0,
    }
    .search()
}

impl<T, Stop> Placing<'_, T, Stop> {
    fn search(mut self) -> Result<Option<Placed<T>>, Stop> {
        let ranges = self.ranges;
        let count = ranges.len();
        let present = ranges
            .iter()
            .map(|range| (range.present - range.least) / (range.most - range.least));
        let Some(mut best) = self.at(present.collect())? else {
            return Ok(None);
        };
        let error_before = best.squared.sqrt();
        let looks = LOOKS[1].min(LOOKS[0] * count);
        for number in 1..=looks {
            let shares = (0..count).map(|axis| halton(number, axis)).collect();
            if let Some(point) = self.at(shares)?
                && point.squared < best.squared
            {
                best = point;
            }
            self.report(&best);
        }
        let mut trust = (looks as f64).powf(-1.0 / count.max(1) as f64).clamp(0.05, 0.35);
        let mut steps = 0;
        while steps < STEPS && trust > SHORTEST && count > 0 {
            let equations = self.linearised(&mut best, trust)?;
            loop {
                steps += 1;
                let shares = stepped(&equations, &best.shares, trust);
                let length = distance(&shares, &best.shares);
                let next = match length > 0.0 {
                    true => self.at(shares)?,
                    false => None,
                };
                self.report(&best);
                if let Some(next) = next.filter(|next| next.squared < best.squared) {
                    let gain = 1.0 - (next.squared / best.squared).sqrt();
                    best = next;
                    // Short steps are followed by short differences, which tell slopes better.
                    if length > 0.9 * trust {
                        trust = (2.0 * trust).min(0.5);
                    } else if length < 0.25 * trust {
                        trust /= 2.0;
                    }
                    if gain < LEAST_GAIN {
                        steps = STEPS;
                    }
                    break;
                }
                trust /= 4.0;
                if steps >= STEPS || trust <= SHORTEST || length == 0.0 {
                    break;
                }
            }
        }
        let limit = |&share: &f64| match share {
            share if share <= AT_LIMIT => Some(Limit::Least),
            share if share >= 1.0 - AT_LIMIT => Some(Limit::Most),
            _ => None,
        };
        Ok(Some(Placed {
            values: values(ranges, &best.shares),
            limits: best.shares.iter().map(limit).collect(),
            error: best.squared.sqrt(),
            error_before,
            found: best.light.found,
            tried: self.tried,
        }))
    }

    fn report(&mut self, best: &Point<T>) {
        let count = self.ranges.len();
        let most = 1 + LOOKS[1].min(LOOKS[0] * count) + STEPS * (count + 1);
        (self.watch)(self.tried as f64 / most as f64, best.squared.sqrt());
    }

    fn at(&mut self, shares: Vec<f64>) -> Result<Option<Point<T>>, Stop> {
        self.tried += 1;
        let light = (self.light)(&values(self.ranges, &shares))?;
        Ok(light.map(|light| Point {
            squared: light.residuals.iter().map(|error| error * error).sum(),
            shares,
            light,
        }))
    }

    /// The normal equations of a step from the best place, by differences to neighbouring places. One of these becomes
    /// the best if it is better: then the equations are those of a step from there, as far as they are linear.
    fn linearised(&mut self, best: &mut Point<T>, trust: f64) -> Result<NormalEquations, Stop> {
        let mut slopes = Vec::with_capacity(self.ranges.len());
        let mut better: Option<Point<T>> = None;
        for (axis, range) in self.ranges.iter().enumerate() {
            let shortest = (range.step / (range.most - range.least)).min(0.5);
            let ahead = (trust / 4.0).max(shortest);
            let step = match best.shares[axis] + ahead <= 1.0 {
                true => ahead,
                false => -ahead,
            };
            let mut shares = best.shares.clone();
            shares[axis] += step;
            let slope = match self.at(shares)? {
                Some(point) => {
                    let pairs = point.light.residuals.iter().zip(&best.light.residuals);
                    let slope: Vec<f64> = pairs.map(|(there, here)| (there - here) / step).collect();
                    let least = better.as_ref().map_or(best.squared, |better| better.squared);
                    if point.squared < least {
                        better = Some(point);
                    }
                    slope
                }
                None => vec![0.0; best.light.residuals.len()],
            };
            slopes.push(slope);
            self.report(best);
        }
        if let Some(better) = better {
            *best = better;
        }
        let mut equations = NormalEquations::new(slopes.len());
        for (place, &error) in best.light.residuals.iter().enumerate() {
            let row: Vec<f64> = slopes.iter().map(|slope| slope[place]).collect();
            equations.add_row(&row, -error, 1.0);
        }
        equations.keep_still();
        Ok(equations)
    }
}

/// The place after the best step within the limits and the region of trust; the same place if there is none.
fn stepped(equations: &NormalEquations, shares: &[f64], trust: f64) -> Vec<f64> {
    let bounds: Vec<[f64; 2]> = shares
        .iter()
        .map(|share| [(-share).max(-trust), (1.0 - share).min(trust)])
        .collect();
    let step = minimise(equations, &bounds).unwrap_or_else(|_| vec![0.0; shares.len()]);
    let moved = shares.iter().zip(step).zip(bounds);
    moved
        .map(|((share, step), [least, most])| (share + step.clamp(least, most)).clamp(0.0, 1.0))
        .collect()
}

fn distance(one: &[f64], other: &[f64]) -> f64 {
    one.iter()
        .zip(other)
        .map(|(one, other)| (one - other).abs())
        .fold(0.0, f64::max)
}

fn values(ranges: &[Range], shares: &[f64]) -> Vec<f64> {
    let value = |(range, share): (&Range, &f64)| range.least + share * (range.most - range.least);
    ranges.iter().zip(shares).map(value).collect()
}

/// An element of the Halton sequence, from 0 to 1.
fn halton(number: usize, axis: usize) -> f64 {
    const PRIMES: [usize; 12] = [2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37];
    let base = PRIMES[axis % PRIMES.len()];
    let (mut left, mut share, mut sum) = (number, 1.0, 0.0);
    while left > 0 {
        share /= base as f64;
        sum += share * (left % base) as f64;
        left /= base;
    }
    sum
}
