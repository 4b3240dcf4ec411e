//! Reconstruction filters by importance sampling: a sample's place in the pixel follows the filter, so that every sample weighs the same
//! and no sample belongs to two pixels (Ernst, Stamminger, Greiner, Filter Importance Sampling, 2006).

use std::sync::LazyLock;

use glam::Vec2;

use crate::sampling::PiecewiseConstant1d;

/// Weighs light around a pixel's centre; lengths in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PixelFilter {
    /// The pixel's own square.
    Box,
    /// exp(-x^2 / 2 stddev^2) less its value at four standard deviations, where it ends.
    Gaussian { stddev: f32 },
}

/// Where the Gaussian ends, in standard deviations.
const GAUSSIAN_REACH: f32 = 4.0;

static GAUSSIAN: LazyLock<PiecewiseConstant1d> = LazyLock::new(|| {
    const STEPS: usize = 1024;
    let value = |x: f32| (-0.5 * x * x).exp() - (-0.5 * GAUSSIAN_REACH * GAUSSIAN_REACH).exp();
    let steps: Vec<f32> = (0..STEPS)
        .map(|step| value(GAUSSIAN_REACH * (2.0 * (step as f32 + 0.5) / STEPS as f32 - 1.0)))
        .collect();
    PiecewiseConstant1d::new(&steps).unwrap_or_else(|| unreachable!("the Gaussian is positive inside its reach"))
});

impl PixelFilter {
    /// Offset from the pixel's centre, for `u` in [0, 1)^2.
    pub fn sample(&self, u: Vec2) -> Vec2 {
        match *self {
            Self::Box => u - 0.5,
            Self::Gaussian { stddev } => {
                let along = |u: f32| stddev * GAUSSIAN_REACH * (2.0 * GAUSSIAN.sample(u).x - 1.0);
                Vec2::new(along(u.x), along(u.y))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_gaussian_has_its_deviation_and_its_reach() {
        let filter = PixelFilter::Gaussian { stddev: 0.5 };
        let n = 4096;
        let xs: Vec<f32> = (0..n)
            .map(|i| filter.sample(Vec2::splat((i as f32 + 0.5) / n as f32)).x)
            .collect();
        let mean = xs.iter().sum::<f32>() / n as f32;
        let variance = xs.iter().map(|x| x * x).sum::<f32>() / n as f32;
        assert!(mean.abs() < 1e-4, "{mean}");
        // The truncated and lowered Gaussian is a little narrower than 0.25: integrating it gives 0.2490.
        assert!((variance - 0.249).abs() < 5e-4, "{variance}");
        assert!(xs.iter().all(|x| x.abs() <= 2.0));
    }

    #[test]
    fn the_box_covers_its_pixel() {
        assert_eq!(PixelFilter::Box.sample(Vec2::new(0.0, 0.75)), Vec2::new(-0.5, 0.25));
    }
}
