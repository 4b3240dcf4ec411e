//! FLIP: the differences that a viewer perceives when flipping between two pictures.
//!
//! Sources: P. Andersson, J. Nilsson, T. Akenine-Möller, M. Oskarsson, K. Åström and M. D. Fairchild, "FLIP: A
//! Difference Evaluator for Alternating Images", HPG 2020, for displayed pictures; P. Andersson, J. Nilsson, P. Shirley
//! and T. Akenine-Möller, "Visualizing Errors in Rendered High Dynamic Range Images", Eurographics Short Papers 2021,
//! for radiance. All two-dimensional filters are products of one-dimensional ones, or sums of such products.

use std::f32::consts::PI;

use glam::{Mat3, Vec3};
use rayon::prelude::*;

use super::convolution::{convolve, kernel, normalized_kernel};
use crate::color::Rgb;

/// Pixels per degree of the visual field: a screen 0.7 m wide with 3840 pixels in a row, at a distance of 0.7 m
/// (section 2020, 3).
pub const PIXELS_PER_DEGREE: f32 = 3840.0 * PI / 180.0;

/// The error in [0, 1] of each pixel of a displayed picture, whose linear colours are clamped to [0, 1]. Both pictures
/// have the same number of pixels, which is a multiple of `width`, and at least one.
pub fn ldr_flip(picture: &[Rgb], reference: &[Rgb], width: usize, pixels_per_degree: f32) -> Vec<f32> {
    let filters = Filters::new(pixels_per_degree);
    let [picture, reference] = [picture, reference].map(|pixels| filters.perceive(pixels, width));
    let greatest = greatest_color_error();
    let error = |i: usize| {
        let color = color_error(picture.colors[i], reference.colors[i], greatest);
        let edges = (picture.edges[i] - reference.edges[i]).abs();
        let points = (picture.points[i] - reference.points[i]).abs();
        let feature = (edges.max(points) * std::f32::consts::FRAC_1_SQRT_2).sqrt();
        // Equation 15: differences of edges and points amplify that of the colours.
        color.powf(1.0 - feature)
    };
    (0..picture.colors.len()).into_par_iter().map(error).collect()
}

/// The exposures in stops at which pictures of radiance are compared: the first, the last, and their number, at least
/// 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exposures {
    /// The exposure at which the brightest pixel of the reference is just below saturation.
    pub start: f32,
    /// The exposure at which a pixel of the median luminance is just below saturation.
    pub stop: f32,
    /// The number of exposures, in equal steps.
    pub count: u32,
}

/// Over more stops than this a picture saturates to black and white.
const MOST_EXPOSURES: f32 = 64.0;

impl Exposures {
    /// The exposures for a reference of at least one pixel (2021, section 3.2). None if it is black or has an infinite
    /// pixel.
    pub fn of(reference: &[Rgb]) -> Option<Self> {
        let weights = Vec3::new(0.2126, 0.7152, 0.0722);
        let mut luminances: Vec<f32> = reference.iter().map(|rgb| rgb.max(Vec3::ZERO).dot(weights)).collect();
        let brightest = luminances.iter().copied().fold(0.0, f32::max);
        // Of an even number of pixels the authors' program takes the upper median.
        let middle = luminances.len() / 2;
        let median = *luminances.select_nth_unstable_by(middle, f32::total_cmp).1;
        if !(brightest > 0.0 && brightest.is_finite()) {
            return None;
        }
        // As in the authors' program: half of a picture may be black.
        let median = median.max(f32::EPSILON);
        // The radiance that the tone map maps to 0.85: the greater root of its quotient.
        const SHOWN: f32 = 0.85;
        let [a, b, c] = [0, 1, 2].map(|power| ACES[power] - SHOWN * ACES[power + 3]);
        let half = -0.5 * b / a;
        let radiance = half + (half * half - c / a).sqrt();
        let (start, stop) = ((radiance / brightest).log2(), (radiance / median).log2());
        let count = (stop - start).ceil().clamp(2.0, MOST_EXPOSURES) as u32;
        Some(Self { start, stop, count })
    }
}

/// The error in [0, 1] of each pixel of a picture of radiance: the greatest over all exposures. Sizes are as for
/// [`ldr_flip`].
pub fn hdr_flip(
    picture: &[Rgb],
    reference: &[Rgb],
    width: usize,
    exposures: Exposures,
    pixels_per_degree: f32,
) -> Vec<f32> {
    let step = (exposures.stop - exposures.start) / (exposures.count.max(2) - 1) as f32;
    let mut worst = vec![0.0f32; picture.len()];
    for i in 0..exposures.count {
        let scale = (exposures.start + i as f32 * step).exp2();
        let exposed = |pixels: &[Rgb]| pixels.iter().map(|&rgb| aces(scale * rgb)).collect::<Vec<Rgb>>();
        let errors = ldr_flip(&exposed(picture), &exposed(reference), width, pixels_per_degree);
        worst
            .iter_mut()
            .zip(errors)
            .for_each(|(worst, error)| *worst = worst.max(error));
    }
    worst
}

/// The coefficients of x^2, x and 1 in the numerator and the denominator of K. Narkowicz' fit of the ACES curve ("ACES
/// Filmic Tone Mapping Curve", 2016), without its factor on the exposure (2021, table 1).
const ACES: [f32; 6] = [0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.0, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14];

fn aces(rgb: Rgb) -> Rgb {
    // The curve is flat above this limit, and squares stay finite.
    let x = rgb.max(Vec3::ZERO).min(Vec3::splat(1e15));
    let [a, b, c, d, e, f] = ACES;
    ((x * (a * x + b) + c) / (x * (d * x + e) + f)).clamp(Vec3::ZERO, Vec3::ONE)
}

/// A picture as perceived by a viewer.
struct Perceived {
    /// L*, a* and b* after the filters of contrast sensitivity, with Hunt's effect.
    colors: Vec<Vec3>,
    /// The strengths of edges.
    edges: Vec<f32>,
    /// The strengths of points.
    points: Vec<f32>,
}

struct Filters {
    achromatic: Vec<f32>,
    red_green: Vec<f32>,
    /// A sum of two Gaussians, each with its weight.
    blue_yellow: [(f32, Vec<f32>); 2],
    /// A Gaussian, and its first and second derivative.
    gaussian: Vec<f32>,
    edge: Vec<f32>,
    point: Vec<f32>,
}

impl Filters {
    fn new(pixels_per_degree: f32) -> Self {
        // 2020, table 1: the widths b of the Gaussians a sqrt(pi / b) exp(-pi^2 x^2 / b) with x in degrees.
        const ACHROMATIC: f32 = 0.0047;
        const RED_GREEN: f32 = 0.0053;
        const BLUE_YELLOW: [(f32, f32); 2] = [(34.1, 0.04), (13.5, 0.025)];
        let radius = (3.0 * (0.04f32 / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as usize;
        let bell = |b: f32| move |x: f32| (-(PI * x / pixels_per_degree).powi(2) / b).exp();
        let parts = BLUE_YELLOW.map(|(a, b)| (a * (PI / b).sqrt(), kernel(radius, bell(b))));
        let volume = |(weight, kernel): &(f32, Vec<f32>)| weight * kernel.iter().sum::<f32>().powi(2);
        let whole: f32 = parts.iter().map(volume).sum();
        // Section 4.2: the width of the filters that find features is 0.082 degrees from peak to trough.
        let deviation = 0.5 * 0.082 * pixels_per_degree;
        let feature_radius = (3.0 * deviation).ceil() as usize;
        let gaussian = |x: f32| (-x * x / (2.0 * deviation * deviation)).exp();
        Self {
            achromatic: normalized_kernel(radius, bell(ACHROMATIC)),
            red_green: normalized_kernel(radius, bell(RED_GREEN)),
            blue_yellow: parts.map(|(weight, kernel)| (weight / whole, kernel)),
            gaussian: normalized_kernel(feature_radius, gaussian),
            edge: signed_unit(kernel(feature_radius, |x| -x * gaussian(x))),
            point: signed_unit(kernel(feature_radius, |x| {
                (x * x / (deviation * deviation) - 1.0) * gaussian(x)
            })),
        }
    }

    fn perceive(&self, pixels: &[Rgb], width: usize) -> Perceived {
        let opponents = pixels.iter().map(|rgb| opponent(rgb.clamp(Vec3::ZERO, Vec3::ONE)));
        let opponents: Vec<Vec3> = opponents.collect();
        let [y, x, z] = [0, 1, 2].map(|axis| opponents.iter().map(|color| color[axis]).collect::<Vec<f32>>());
        let blurred_y = convolve(&y, width, &self.achromatic, &self.achromatic);
        let blurred_x = convolve(&x, width, &self.red_green, &self.red_green);
        let [first, second] = self
            .blue_yellow
            .each_ref()
            .map(|(_, kernel)| convolve(&z, width, kernel, kernel));
        let [first_weight, second_weight] = self.blue_yellow.each_ref().map(|part| part.0);
        let color = |i: usize| {
            let blurred_z = first_weight * first[i] + second_weight * second[i];
            seen(Vec3::new(blurred_y[i], blurred_x[i], blurred_z))
        };
        let colors = (0..pixels.len()).into_par_iter().map(color).collect();
        let shade: Vec<f32> = y.iter().map(|y| (y + 16.0) / 116.0).collect();
        let strength = |filter: &[f32]| {
            let across = convolve(&shade, width, filter, &self.gaussian);
            let down = convolve(&shade, width, &self.gaussian, filter);
            across
                .iter()
                .zip(down)
                .map(|(across, down)| across.hypot(down))
                .collect()
        };
        Perceived {
            colors,
            edges: strength(&self.edge),
            points: strength(&self.point),
        }
    }
}

/// Scales the positive weights to the sum 1, and the negative ones to -1.
fn signed_unit(weights: Vec<f32>) -> Vec<f32> {
    let positive: f32 = weights.iter().filter(|weight| **weight > 0.0).sum();
    let negative: f32 = -weights.iter().filter(|weight| **weight < 0.0).sum::<f32>();
    let scaled = |weight: f32| weight / if weight < 0.0 { negative } else { positive };
    weights.into_iter().map(scaled).collect()
}

/// CIE XYZ of linear sRGB, with the fractions that FLIP's authors use.
const XYZ_FROM_RGB: Mat3 = Mat3::from_cols(
    Vec3::new(
        10_135_552.0 / 24_577_794.0,
        2_613_072.0 / 12_288_897.0,
        1_425_312.0 / 73_733_382.0,
    ),
    Vec3::new(
        8_788_810.0 / 24_577_794.0,
        8_788_810.0 / 12_288_897.0,
        8_788_810.0 / 73_733_382.0,
    ),
    Vec3::new(
        4_435_075.0 / 24_577_794.0,
        887_015.0 / 12_288_897.0,
        70_074_185.0 / 73_733_382.0,
    ),
);
/// XYZ of white.
const WHITE: Vec3 = Vec3::new(0.950_428_55, 1.0, 1.088_900_4);

/// YCxCz, a linear form of L*a*b*, of a linear colour.
fn opponent(rgb: Rgb) -> Vec3 {
    let relative = XYZ_FROM_RGB * rgb / WHITE;
    Vec3::new(
        116.0 * relative.y - 16.0,
        500.0 * (relative.x - relative.y),
        200.0 * (relative.y - relative.z),
    )
}

/// Hunt-adjusted L*a*b* of a filtered colour in YCxCz, which is first clamped to the range of displays.
fn seen(opponent: Vec3) -> Vec3 {
    let y = (opponent.x + 16.0) / 116.0;
    let xyz = Vec3::new(y + opponent.y / 500.0, y, y - opponent.z / 200.0) * WHITE;
    adjusted_lab((XYZ_FROM_RGB.inverse() * xyz).clamp(Vec3::ZERO, Vec3::ONE))
}

/// L*a*b* of a linear colour, with a* and b* weaker in the dark (Hunt's effect; 2020, section 4.1).
fn adjusted_lab(rgb: Rgb) -> Vec3 {
    const DELTA: f32 = 6.0 / 29.0;
    let relative = XYZ_FROM_RGB * rgb / WHITE;
    let curve = |t: f32| match t > DELTA * DELTA * DELTA {
        true => t.cbrt(),
        false => t / (3.0 * DELTA * DELTA) + 4.0 / 29.0,
    };
    let [x, y, z] = relative.to_array().map(curve);
    let lightness = 116.0 * y - 16.0;
    Vec3::new(lightness, 5.0 * lightness * (x - y), 2.0 * lightness * (y - z))
}

/// The distance HyAB: the distance of lightness plus that of hue and chroma.
fn hyab(a: Vec3, b: Vec3) -> f32 {
    let difference = a - b;
    difference.x.abs() + difference.y.hypot(difference.z)
}

/// Section 4.1.3: the exponent that compresses large distances.
const COLOR_EXPONENT: f32 = 0.7;

/// The compressed distance of green and blue, the colours of a display that are farthest apart.
fn greatest_color_error() -> f32 {
    hyab(adjusted_lab(Vec3::Y), adjusted_lab(Vec3::Z)).powf(COLOR_EXPONENT)
}

/// The error of two colours in [0, 1]: distances up to 0.4 of the greatest one are mapped to the range up to 0.95.
fn color_error(a: Vec3, b: Vec3, greatest: f32) -> f32 {
    let error = hyab(a, b).powf(COLOR_EXPONENT);
    let knee = 0.4 * greatest;
    match error < knee {
        true => 0.95 / knee * error,
        false => 0.95 + 0.05 * (error - knee) / (greatest - knee),
    }
}
