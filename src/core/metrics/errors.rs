//! Means of errors, pixel by pixel.

use glam::DVec3;

use crate::color::{Rgb, luminance, srgb_from_linear};

/// The differences between a picture and a reference. All three components count alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Errors {
    /// Mean luminance of the picture and of the reference.
    pub means: [f32; 2],
    /// Mean squared error of the radiance.
    pub mse: f32,
    /// Mean squared error, each error relative to the reference (Rousselle, Knaus and Zwicker, "Adaptive Sampling and
    /// Reconstruction using Greedy Error Minimization", 2011): (a - b)^2 / (b^2 + 0.01).
    pub relative_mse: f32,
    /// The peak signal-to-noise ratio in decibels of displayed colours, which are sRGB-encoded and clamped at 1;
    /// infinite for equal pictures.
    pub psnr: f32,
}

/// The errors; None if the pictures differ in size, are empty, or have values that are not finite.
pub fn errors(picture: &[Rgb], reference: &[Rgb]) -> Option<Errors> {
    if picture.len() != reference.len() || picture.is_empty() {
        return None;
    }
    // Double precision holds the square of every single-precision number.
    let mean = |of: &dyn Fn(Rgb, Rgb) -> f64| {
        let sum: f64 = picture.iter().zip(reference).map(|(&a, &b)| of(a, b)).sum();
        let mean = sum / picture.len() as f64;
        match mean.is_finite() {
            true => mean.min(f32::MAX.into()) as f32,
            false => mean as f32,
        }
    };
    let squared = |a: Rgb, b: Rgb| {
        let error = a.as_dvec3() - b.as_dvec3();
        error * error
    };
    let thirds = |rgb: DVec3| rgb.element_sum() / 3.0;
    let shown = |rgb: Rgb| rgb.clamp(Rgb::ZERO, Rgb::ONE).map(srgb_from_linear);
    let display_mse = mean(&|a, b| thirds(squared(shown(a), shown(b))));
    let errors = Errors {
        means: [mean(&|a, _| luminance(a).into()), mean(&|_, b| luminance(b).into())],
        mse: mean(&|a, b| thirds(squared(a, b))),
        relative_mse: mean(&|a, b| thirds(squared(a, b) / (squared(b, Rgb::ZERO) + 0.01))),
        psnr: -10.0 * display_mse.log10(),
    };
    (errors.mse.is_finite() && errors.relative_mse.is_finite()).then_some(errors)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The numbers are worked out by hand: errors of 0.5 in one component of one of two pixels.
    #[test]
    fn errors_are_what_they_say() {
        let reference = [Rgb::splat(0.5), Rgb::ONE];
        let picture = [Rgb::new(1.0, 0.5, 0.5), Rgb::ONE];
        let found = errors(&picture, &reference).expect("two pictures");
        let near = |a: f32, b: f32| (a - b).abs() < 1e-5 * b;
        assert!(near(found.mse, 0.25 / 6.0), "{found:?}");
        assert!(near(found.relative_mse, 0.25 / 0.26 / 6.0), "{found:?}");
        // The sRGB value of one half is 0.735357.
        assert!(
            near(found.psnr, -10.0 * ((1.0f32 - 0.735_357).powi(2) / 6.0).log10()),
            "{found:?}"
        );
        assert!(
            near(found.means[1], 0.75) && near(found.means[0], 0.75 + 0.25 * 0.212_671),
            "{found:?}"
        );
        let same = errors(&reference, &reference).expect("two pictures");
        assert_eq!((same.mse, same.relative_mse, same.psnr), (0.0, 0.0, f32::INFINITY));
        assert_eq!(errors(&picture, &reference[..1]), None);
        assert_eq!(errors(&[], &[]), None);
        assert_eq!(errors(&[Rgb::NAN], &[Rgb::ONE]), None);
        let far = errors(&[Rgb::splat(1e30)], &[Rgb::ZERO]).expect("finite numbers");
        assert_eq!(far.mse, f32::MAX);
    }
}
