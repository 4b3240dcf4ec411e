//! Reconstruction filters by importance sampling: a sample's offset in the pixel follows the filter's magnitude, so
//! that all samples have the same weight up to the sign, and no sample belongs to two pixels (Ernst, Stamminger, and
//! Greiner, Filter Importance Sampling, 2006).
//!
//! A filter with negative lobes has samples of negative weight. All weights have the magnitude (integral of |f|) /
//! (integral of f), so that the plain mean over the samples is the filtered picture: sums stay sums, and their spread
//! is the true noise of the mean.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{IVec2, Vec2};

use crate::sampling::PiecewiseConstant1d;

/// A reconstruction filter around a pixel's centre; lengths in pixels.
#[derive(Clone, Debug, PartialEq)]
pub enum PixelFilter {
    /// The pixel's own square.
    Box,
    /// Falls linearly to zero at `radius` from the centre.
    Tent {
        /// The radius in pixels, above 0.
        radius: f32,
    },
    /// Any other filter.
    Tabulated(Arc<FilterTable>),
}

/// The filters whose integral has no simple inverse, along one axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FilterKernel {
    /// The Gaussian exp(-x^2 / 2 stddev^2) less its value at four standard deviations, where it ends.
    Gaussian {
        /// The standard deviation in pixels, above 0.
        stddev: f32,
    },
    /// The filter of Mitchell and Netravali, Reconstruction Filters in Computer Graphics (1988).
    Cubic {
        /// The blurring.
        b: f32,
        /// The ringing.
        c: f32,
    },
    /// A sinc, windowed by the central lobe of one that is `lobes` times as wide.
    Lanczos {
        /// Half the width of the filter in pixels, at least 1.
        lobes: u32,
    },
}

/// The position of a sample in the picture, and the weight of its light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilterSample {
    /// The offset from the pixel's centre.
    pub offset: Vec2,
    /// The weight; its mean is 1, and it is negative on negative lobes.
    pub weight: f32,
}

/// The distance at which the Gaussian ends, in standard deviations.
const GAUSSIAN_REACH: f32 = 4.0;
/// The farthest film coordinate, in pixels, whose light belongs to a pixel.
const FARTHEST: f32 = 1e6;
/// The number of steps of a table, over the whole width of the filter.
const STEPS: usize = 1024;

impl FilterKernel {
    /// Catmull and Rom's filter, which interpolates.
    pub const CATMULL_ROM: Self = Self::Cubic { b: 0.0, c: 0.5 };

    /// The filter at `x` pixels from the centre, of any scale.
    pub fn value(&self, x: f32) -> f32 {
        let x = x.abs();
        if x >= self.radius() {
            return 0.0;
        }
        match *self {
            Self::Gaussian { stddev } => {
                let bell = |deviations: f32| (-0.5 * deviations * deviations).exp();
                bell(x / stddev) - bell(GAUSSIAN_REACH)
            }
            Self::Cubic { b, c } if x < 1.0 => {
                ((12.0 - 9.0 * b - 6.0 * c) * x + (-18.0 + 12.0 * b + 6.0 * c)) * x * x + (6.0 - 2.0 * b)
            }
            Self::Cubic { b, c } => {
                let cubic = ((-b - 6.0 * c) * x + (6.0 * b + 30.0 * c)) * x + (-12.0 * b - 48.0 * c);
                cubic * x + (8.0 * b + 24.0 * c)
            }
            Self::Lanczos { lobes } => sinc(x) * sinc(x / lobes as f32),
        }
    }

    /// Half the width in pixels.
    pub fn radius(&self) -> f32 {
        match *self {
            Self::Gaussian { stddev } => GAUSSIAN_REACH * stddev,
            Self::Cubic { .. } => 2.0,
            Self::Lanczos { lobes } => lobes as f32,
        }
    }
}

fn sinc(x: f32) -> f32 {
    let x = PI * x;
    if x < 1e-3 { 1.0 - x * x / 6.0 } else { x.sin() / x }
}

/// A kernel's magnitude as steps, and its sign. The same along x and y.
#[derive(Clone, Debug)]
pub struct FilterTable {
    kernel: FilterKernel,
    magnitude: PiecewiseConstant1d,
    negative: Vec<bool>,
    /// The ratio (integral of |f|) / (integral of f).
    excess: f32,
    /// One over the integral of f.
    scale: f32,
}

/// All other fields follow from the kernel.
impl PartialEq for FilterTable {
    fn eq(&self, other: &Self) -> bool {
        self.kernel == other.kernel
    }
}

impl FilterTable {
    /// None if the kernel has no positive integral.
    fn new(kernel: FilterKernel) -> Option<Self> {
        let at = |step: usize| kernel.radius() * (2.0 * (step as f32 + 0.5) / STEPS as f32 - 1.0);
        let values: Vec<f32> = (0..STEPS).map(|step| kernel.value(at(step))).collect();
        let magnitudes: Vec<f32> = values.iter().map(|value| value.abs()).collect();
        let sum = |values: &[f32]| values.iter().map(|&value| f64::from(value)).sum::<f64>();
        let excess = (sum(&magnitudes) / sum(&values)) as f32;
        let width = 2.0 * kernel.radius() / STEPS as f32;
        Some(Self {
            scale: 1.0 / (sum(&values) as f32 * width),
            kernel,
            magnitude: PiecewiseConstant1d::new(&magnitudes)?,
            negative: values.iter().map(|&value| value < 0.0).collect(),
            excess: Some(excess).filter(|excess| excess.is_finite() && *excess > 0.0)?,
        })
    }

    /// Samples the offset and the weight along one axis.
    #[inline(always)]
    fn sample(&self, u: f32) -> (f32, f32) {
        let sample = self.magnitude.sample(u);
        let negative = self.negative[sample.cell as usize];
        (
            self.kernel.radius() * (2.0 * sample.x - 1.0),
            if negative { -self.excess } else { self.excess },
        )
    }
}

impl PixelFilter {
    /// The filter with this kernel, or a box if the kernel has no positive integral.
    pub fn tabulated(kernel: FilterKernel) -> Self {
        FilterTable::new(kernel).map_or(Self::Box, |table| Self::Tabulated(Arc::new(table)))
    }

    /// Chooses a pixel for the light at a point of the film, in pixels, among all whose filters cover it. Returns it
    /// with the factor on the light, over the probability of the choice by `u`; None where no filter reaches. The pixel
    /// may be outside of the film.
    pub fn choose_pixel(&self, film: Vec2, mut u: f32) -> Option<(IVec2, f32)> {
        let mut pixel = IVec2::ZERO;
        let mut weight = 1.0;
        for (axis, place) in film.to_array().into_iter().enumerate() {
            let (chosen, factor) = self.choose_on_axis(place, &mut u)?;
            pixel[axis] = chosen;
            weight *= factor;
        }
        Some((pixel, weight))
    }

    fn choose_on_axis(&self, place: f32, u: &mut f32) -> Option<(i32, f32)> {
        if !place.is_finite() || place.abs() > FARTHEST {
            return None;
        }
        let radius = self.radius();
        let pixels = (place - radius - 0.5).ceil() as i32..=(place + radius - 0.5).floor() as i32;
        if *self == Self::Box {
            return Some((place.floor() as i32, 1.0));
        }
        let at = |pixel: i32| self.value(place - pixel as f32 - 0.5);
        let sum: f32 = pixels.clone().map(|pixel| at(pixel).abs()).sum();
        let mut left = *u * sum;
        for pixel in pixels {
            let value = at(pixel);
            if left < value.abs() {
                *u = (left / value.abs()).min(1.0 - f32::EPSILON);
                return Some((pixel, sum * value.signum()));
            }
            left -= value.abs();
        }
        None
    }

    /// Half the width along an axis, in pixels.
    fn radius(&self) -> f32 {
        match self {
            Self::Box => 0.5,
            Self::Tent { radius } => *radius,
            Self::Tabulated(table) => table.kernel.radius(),
        }
    }

    /// The filter along one axis, with integral 1, at a distance from the centre.
    fn value(&self, x: f32) -> f32 {
        match self {
            Self::Box => 1.0,
            Self::Tent { radius } => (1.0 - x.abs() / radius).max(0.0) / radius,
            Self::Tabulated(table) => table.kernel.value(x) * table.scale,
        }
    }

    /// Samples the filter by `u` in [0, 1)^2.
    pub fn sample(&self, u: Vec2) -> FilterSample {
        let unweighted = |offset| FilterSample { offset, weight: 1.0 };
        match self {
            Self::Box => unweighted(u - 0.5),
            Self::Tent { radius } => unweighted(*radius * Vec2::new(tent(u.x), tent(u.y))),
            Self::Tabulated(table) => {
                let ((x, weight_x), (y, weight_y)) = (table.sample(u.x), table.sample(u.y));
                FilterSample {
                    offset: Vec2::new(x, y),
                    weight: weight_x * weight_y,
                }
            }
        }
    }
}

/// Samples [-1, 1] with density 1 - |x|.
fn tent(u: f32) -> f32 {
    if u < 0.5 {
        (2.0 * u).sqrt() - 1.0
    } else {
        1.0 - (2.0 * (1.0 - u)).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gaussian_has_its_deviation_and_its_reach() {
        let filter = PixelFilter::tabulated(FilterKernel::Gaussian { stddev: 0.5 });
        let n = 4096;
        let samples = (0..n).map(|i| filter.sample(Vec2::splat((i as f32 + 0.5) / n as f32)));
        let xs: Vec<f32> = samples.map(|sample| sample.offset.x).collect();
        let mean = xs.iter().sum::<f32>() / n as f32;
        let variance = xs.iter().map(|x| x * x).sum::<f32>() / n as f32;
        assert!(mean.abs() < 1e-4, "{mean}");
        // The truncated and lowered Gaussian is a little narrower than 0.25: integrating it gives 0.2490.
        assert!((variance - 0.249).abs() < 5e-4, "{variance}");
        assert!(xs.iter().all(|x| x.abs() <= 2.0));
    }

    #[test]
    fn the_box_covers_its_pixel() {
        let sample = PixelFilter::Box.sample(Vec2::new(0.0, 0.75));
        assert_eq!((sample.offset, sample.weight), (Vec2::new(-0.5, 0.25), 1.0));
    }

    #[test]
    fn without_a_positive_integral_there_is_no_kernel() {
        for lobes in [0, 1] {
            let filter = PixelFilter::tabulated(FilterKernel::Lanczos { lobes });
            assert_eq!(filter == PixelFilter::Box, lobes == 0);
        }
    }
}
