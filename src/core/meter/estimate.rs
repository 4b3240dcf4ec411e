//! Measured values with their standard errors.
//!
//! The samples of a point are well spread, so that the error of their mean cannot be told from their variance. Instead
//! they are parted into [`REPLICATES`] sets with scrambles of their own, whose means are independent (randomised
//! quasi-Monte Carlo: Owen, Monte Carlo theory, methods and examples, chapter 17). Everything that is derived from
//! the points, such as the mean of a grid, has its error from the sets in the same manner.

use super::daylight::daylight_factor;
use crate::photometry::units;

/// The number of independent sets of samples.
pub const REPLICATES: usize = 32;

/// A measured value.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The value.
    pub value: f64,
    /// The standard error of the value, in its unit.
    pub error: f64,
}

/// The values of a grid, in lux but for the uniformity.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GridEstimate {
    /// The illuminance at the darkest point.
    pub least: Estimate,
    /// The mean of all points.
    pub mean: Estimate,
    /// The least over the mean illuminance, from 0 to 1; None in the dark.
    pub uniformity: Option<Estimate>,
    /// The index of the darkest point.
    pub darkest: usize,
}

impl Estimate {
    /// The mean of independent values.
    pub fn of(values: &[f64]) -> Self {
        let count = values.len() as f64;
        let value = values.iter().sum::<f64>() / count.max(1.0);
        let squares = values.iter().map(|each| (each - value).powi(2)).sum::<f64>();
        Self {
            value,
            error: (squares / ((count - 1.0) * count)).sqrt(),
        }
    }

    /// The error relative to the value; 0 where there is no error, in the dark as well.
    pub fn relative_error(&self) -> f64 {
        match self.error == 0.0 {
            true => 0.0,
            false => self.error / self.value.abs(),
        }
    }

    /// An illuminance in lux as a daylight factor in per cent.
    pub fn daylight_factor(&self) -> Self {
        Self {
            value: daylight_factor(self.value),
            error: daylight_factor(self.error),
        }
    }

    /// An illuminance in lux as a daylight factor, as in `3.1 ± 0.2 %`.
    pub fn in_daylight_factor(&self) -> String {
        self.daylight_factor().in_unit("%")
    }

    /// The value with its error and a unit, as in `532 ± 4 lx`.
    pub fn in_unit(&self, symbol: &str) -> String {
        units::with_error(self.value, self.error, symbol)
    }
}

impl GridEstimate {
    /// The values of a grid, of which `replicates` has the values of all points by each set of samples. At least one
    /// point and one set.
    ///
    /// The least of noisy values is lower than the least value: that counts to its error. How much lower it is, is
    /// told by choosing the darkest point by one half of the samples and measuring it by the other half, which gives a
    /// value that is never too low on average.
    pub fn of(replicates: &[Vec<f64>]) -> Self {
        let half = replicates.len() / 2;
        let all = means(replicates);
        let darkest = darkest(&all);
        let own: Vec<f64> = replicates.iter().map(|values| values[darkest]).collect();
        let mut least = Estimate::of(&own);
        if half > 0 {
            let [first, second] = [&replicates[..half], &replicates[half..]].map(means);
            let crossed = 0.5 * (second[self::darkest(&first)] + first[self::darkest(&second)]);
            least.error = least.error.hypot((crossed - least.value).max(0.0));
        }
        let of_grid = |values: &Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
        let mean = Estimate::of(&replicates.iter().map(of_grid).collect::<Vec<_>>());
        let uniformity = (mean.value > 0.0).then(|| {
            let value = least.value / mean.value;
            // Errors of the darkest point and of the mean, of which it is one of many points, are nearly independent.
            // A darkest point without light has no relative error.
            let error = (least.error / mean.value).hypot(value * mean.relative_error());
            Estimate { value, error }
        });
        Self {
            least,
            mean,
            uniformity,
            darkest,
        }
    }
}

/// The mean of each point.
fn means(replicates: &[Vec<f64>]) -> Vec<f64> {
    let points = replicates.first().map_or(0, Vec::len);
    let sum = |point: usize| replicates.iter().map(|values| values[point]).sum::<f64>();
    (0..points).map(|point| sum(point) / replicates.len() as f64).collect()
}

fn darkest(values: &[f64]) -> usize {
    let least = (0..values.len()).min_by(|a, b| values[*a].total_cmp(&values[*b]));
    least.unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::hash::pcg3d;

    /// Normal numbers, by Box and Muller.
    fn normal(seed: u32, set: usize, point: usize) -> f64 {
        let [a, b, _] = pcg3d([seed, set as u32, point as u32]).map(|word| (f64::from(word) + 0.5) / 4_294_967_296.0);
        (-2.0 * a.ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }

    fn grid(seed: u32, points: usize, value: impl Fn(usize) -> f64, noise: f64) -> GridEstimate {
        let of_set = |set| {
            (0..points)
                .map(|point| value(point) + noise * normal(seed, set, point))
                .collect()
        };
        GridEstimate::of(&(0..REPLICATES).map(of_set).collect::<Vec<_>>())
    }

    #[test]
    fn errors_of_means_are_those_of_independent_values() {
        let estimate = Estimate::of(&[1.0, 3.0]);
        assert_eq!((estimate.value, estimate.error), (2.0, 1.0));
        let squares = (0..2000).map(|seed| (grid(seed, 1, |_| 5.0, 1.0).mean.value - 5.0).powi(2));
        let true_error = (squares.sum::<f64>() / 2000.0).sqrt();
        let told = (0..2000)
            .map(|seed| grid(seed, 1, |_| 5.0, 1.0).mean.error)
            .sum::<f64>()
            / 2000.0;
        assert!((told / true_error - 1.0).abs() < 0.05, "{told} for {true_error}");
    }

    /// The least of the noisy values of 400 equal points is three of its errors too low, which a plain error misses.
    #[test]
    fn the_error_of_the_least_covers_that_it_is_too_low() {
        let (mut covered, mut plainly_covered) = (0, 0);
        for seed in 0..200 {
            let least = grid(seed, 400, |_| 100.0, 10.0).least;
            covered += usize::from((least.value - 100.0).abs() < 2.0 * least.error);
            plainly_covered += usize::from((least.value - 100.0).abs() < 2.0 * 10.0 / 32f64.sqrt());
        }
        assert!(covered >= 190, "{covered} of 200");
        assert!(plainly_covered < 20, "{plainly_covered} of 200");
        // One dark point is found, and has no more than its own error.
        let known = grid(1, 400, |point| if point == 7 { 20.0 } else { 100.0 }, 1.0);
        assert_eq!(known.darkest, 7);
        assert!(known.least.error < 0.3, "{:?}", known.least);
        let uniformity = known.uniformity.expect("light");
        assert!((uniformity.value - 20.0 / 99.8).abs() < 3.0 * uniformity.error);
    }

    #[test]
    fn the_dark_has_no_errors() {
        let dark = grid(1, 5, |_| 0.0, 0.0);
        assert_eq!(dark.uniformity, None);
        assert_eq!((dark.least.relative_error(), dark.mean.relative_error()), (0.0, 0.0));
    }
}
