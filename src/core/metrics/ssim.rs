//! The structural similarity of displayed colours (Wang, Bovik, Sheikh and Simoncelli, "Image Quality Assessment: From
//! Error Visibility to Structural Similarity", 2004).

use super::convolution::{convolve, normalized_kernel};
use crate::color::{Rgb, luminance, srgb_from_linear};

/// Section III.C of the paper: an 11 x 11 window of a Gaussian of 1.5 pixels.
const RADIUS: usize = 5;
const DEVIATION: f32 = 1.5;
const C1: f32 = 0.01 * 0.01;
const C2: f32 = 0.03 * 0.03;

/// The mean similarity in [-1, 1] of pictures of `width` pixels in a row, 1 for equal ones. It compares the luminances
/// of the sRGB-encoded colours, clamped at 1, where the window is within the picture. None for pictures of different
/// sizes or with less than 11 pixels along a side.
pub fn ssim(picture: &[Rgb], reference: &[Rgb], width: usize) -> Option<f32> {
    let window = 2 * RADIUS + 1;
    let height = picture.len().checked_div(width)?;
    if picture.len() != reference.len() || width < window || height < window {
        return None;
    }
    let shown = |pixels: &[Rgb]| {
        let encoded = |rgb: &Rgb| luminance(rgb.clamp(Rgb::ZERO, Rgb::ONE).map(srgb_from_linear));
        pixels.iter().map(encoded).collect::<Vec<f32>>()
    };
    let (a, b) = (shown(picture), shown(reference));
    let kernel = normalized_kernel(RADIUS, |x| (-0.5 * (x / DEVIATION).powi(2)).exp());
    let mean = |plane: &[f32]| convolve(plane, width, &kernel, &kernel);
    let mean_product = |a: &[f32], b: &[f32]| mean(&a.iter().zip(b).map(|(a, b)| a * b).collect::<Vec<f32>>());
    let (mean_a, mean_b) = (mean(&a), mean(&b));
    let (square_a, square_b, product) = (mean_product(&a, &a), mean_product(&b, &b), mean_product(&a, &b));
    let mut sum = 0.0;
    for y in RADIUS..height - RADIUS {
        for i in y * width + RADIUS..(y + 1) * width - RADIUS {
            let (mu_a, mu_b) = (mean_a[i], mean_b[i]);
            let (variance_a, variance_b) = (square_a[i] - mu_a * mu_a, square_b[i] - mu_b * mu_b);
            let covariance = product[i] - mu_a * mu_b;
            let likeness = (2.0 * mu_a * mu_b + C1) * (2.0 * covariance + C2);
            sum += f64::from(likeness / ((mu_a * mu_a + mu_b * mu_b + C1) * (variance_a + variance_b + C2)));
        }
    }
    let pixels = (width - 2 * RADIUS) * (height - 2 * RADIUS);
    Some((sum / pixels as f64) as f32)
}
