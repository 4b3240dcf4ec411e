//! Compares the metrics with independent programs: FLIP with NVIDIA's `flip-evaluator` 1.7, SSIM and PSNR with
//! scikit-image 0.26, squared errors with NumPy, all on pictures computed by formulas. SSIM used Gaussian weights of
//! 1.5 pixels and population covariances.

use super::flip::{Exposures, PIXELS_PER_DEGREE, hdr_flip, ldr_flip};
use super::{errors, ssim};
use crate::color::{Rgb, linear_from_srgb};

const WIDTH: usize = 96;
const HEIGHT: usize = 64;

fn picture(component: impl Fn(usize, usize, usize) -> f64) -> Vec<Rgb> {
    let pixel = |i: usize| {
        let (x, y) = (i % WIDTH, i / WIDTH);
        Rgb::from_array([0, 1, 2].map(|c| component(x, y, c) as f32))
    };
    (0..WIDTH * HEIGHT).map(pixel).collect()
}

/// A number in [0, 1) for a pixel.
fn noise(x: usize, y: usize, stream: u32) -> f64 {
    let i = (y * WIDTH + x) as u32;
    let mut bits = i.wrapping_mul(2_654_435_761).wrapping_add(stream.wrapping_mul(40_503));
    bits = (bits ^ (bits >> 15)).wrapping_mul(2_246_822_519);
    bits = (bits ^ (bits >> 13)).wrapping_mul(3_266_489_917);
    f64::from(bits ^ (bits >> 16)) / 4_294_967_296.0
}

fn smooth(x: usize, y: usize, c: usize) -> f64 {
    0.5 + 0.45 * (0.11 * (x * (c + 1)) as f64 + 0.07 * (y * (3 - c)) as f64).sin()
}

fn edges(x: usize, y: usize, c: usize) -> f64 {
    match (x / 12 + y / 9) % 2 {
        0 => 0.9,
        _ => 0.1 + 0.1 * c as f64,
    }
}

fn radiance(x: usize, y: usize, c: usize) -> f64 {
    (10.0 * x as f64 / WIDTH as f64 - 5.0 + 0.3 * c as f64).exp2() * (0.6 + 0.4 * (0.2 * y as f64).sin())
}

/// The results of the programs for a pair: means, pixels of FLIP at (10, 10) and (47, 33), the greatest FLIP.
struct Expected {
    flip: [f32; 4],
    ssim: f32,
    psnr: f32,
    mse: f32,
    relative_mse: f32,
}

fn assert_flip(name: &str, found: &[f32], expected: [f32; 4]) {
    let mean = found.iter().map(|&error| f64::from(error)).sum::<f64>() / found.len() as f64;
    let greatest = found.iter().copied().fold(0.0, f32::max);
    let found = [mean as f32, found[10 * WIDTH + 10], found[33 * WIDTH + 47], greatest];
    for (found_one, expected_one) in found.iter().zip(expected) {
        // Both use 24 bits.
        assert!(
            (found_one - expected_one).abs() < 2e-4,
            "{name}: {found:?} {expected:?}"
        );
    }
}

#[test]
fn figures_of_pictures_for_displays() {
    let close = |a: f32, b: f32, tolerance: f32| (a - b).abs() <= tolerance * b.abs();
    let check = |name: &str, reference: Vec<Rgb>, other: Vec<Rgb>, expected: Expected| {
        let [reference, other] = [reference, other].map(|pixels| {
            let linear = |rgb: Rgb| rgb.map(linear_from_srgb);
            pixels.into_iter().map(linear).collect::<Vec<Rgb>>()
        });
        assert_flip(
            name,
            &ldr_flip(&other, &reference, WIDTH, PIXELS_PER_DEGREE),
            expected.flip,
        );
        let found = ssim(&other, &reference, WIDTH).expect("large enough");
        assert!(close(found, expected.ssim, 1e-4), "{name}: {found}");
        let found = errors(&other, &reference).expect("finite");
        assert!(close(found.psnr, expected.psnr, 1e-4), "{name}: {found:?}");
        assert!(close(found.mse, expected.mse, 1e-4), "{name}: {found:?}");
        assert!(
            close(found.relative_mse, expected.relative_mse, 1e-4),
            "{name}: {found:?}"
        );
    };
    let noisy = |x, y, c| (smooth(x, y, c) + 0.2 * (noise(x, y, c as u32) - 0.5)).clamp(0.0, 1.0);
    check(
        "noise",
        picture(smooth),
        picture(noisy),
        Expected {
            flip: [0.121_293, 0.091_878, 0.189_295, 0.327_966],
            ssim: 0.857_612,
            psnr: 24.956_26,
            mse: 0.004_867_13,
            relative_mse: 0.029_018_2,
        },
    );
    let tinted = |x, y, c| smooth(x, y, c) * if c == 0 { 0.9 } else { 1.0 };
    check(
        "tint",
        picture(smooth),
        picture(tinted),
        Expected {
            flip: [0.178_730, 0.204_625, 0.106_350, 0.355_201],
            ssim: 0.998_997,
            psnr: 29.277_25,
            mse: 0.003_164_87,
            relative_mse: 0.008_491_71,
        },
    );
    check(
        "shift",
        picture(edges),
        picture(|x, y, c| edges(x + 1, y, c)),
        Expected {
            flip: [0.187_099, 0.565_781, 0.488_857, 0.986_950],
            ssim: 0.745_312,
            psnr: 13.831_16,
            mse: 0.046_759_9,
            relative_mse: 2.041_389,
        },
    );
    let spotted = |x, y, c| if noise(x, y, 7) > 0.995 { 1.0 } else { edges(x, y, c) };
    check(
        "points",
        picture(edges),
        picture(spotted),
        Expected {
            flip: [0.023_095, 0.0, 0.000_751, 0.785_951],
            ssim: 0.975_983,
            psnr: 26.940_97,
            mse: 0.002_962_29,
            relative_mse: 0.244_661,
        },
    );
}

#[test]
fn flip_of_radiance() {
    let reference = picture(radiance);
    let exposures = Exposures::of(&reference).expect("a picture with light");
    assert_eq!(exposures.count, 6);
    assert!((exposures.start + 4.078_386).abs() < 1e-4, "{exposures:?}");
    assert!((exposures.stop - 1.789_434).abs() < 1e-4, "{exposures:?}");
    let check = |name: &str, other: Vec<Rgb>, expected| {
        let found = hdr_flip(&other, &reference, WIDTH, exposures, PIXELS_PER_DEGREE);
        assert_flip(name, &found, expected);
    };
    let noisy = |x, y, c| radiance(x, y, c) * (0.75 + 0.5 * noise(x, y, c as u32));
    check("noise", picture(noisy), [0.091_640, 0.079_543, 0.098_152, 0.298_678]);
    let spotted = |x, y, c| {
        if noise(x, y, 9) > 0.998 {
            50.0
        } else {
            radiance(x, y, c)
        }
    };
    check(
        "firefly",
        picture(spotted),
        [0.010_011, 0.002_070, 0.009_885, 0.849_957],
    );
    let darker = |x, y, c| 0.95 * radiance(x, y, c);
    check("darker", picture(darker), [0.087_104, 0.092_880, 0.095_764, 0.097_043]);
}

#[test]
fn flip_of_a_picture_that_is_mostly_black() {
    let lit = |factor: f64| picture(move |x, y, c| if x >= 60 { factor * radiance(x, y, c) } else { 0.0 });
    let reference = lit(1.0);
    let exposures = Exposures::of(&reference).expect("a picture with light");
    assert_eq!(exposures.count, 29);
    assert!((exposures.stop - 24.083_298).abs() < 1e-4, "{exposures:?}");
    let found = hdr_flip(&lit(0.9), &reference, WIDTH, exposures, PIXELS_PER_DEGREE);
    assert_flip("mostly black", &found, [0.055_749, 0.0, 0.0, 0.169_586]);
}

#[test]
fn equal_pictures_differ_by_nothing() {
    let reference = picture(radiance);
    let exposures = Exposures::of(&reference).expect("a picture with light");
    let flip = hdr_flip(&reference, &reference, WIDTH, exposures, PIXELS_PER_DEGREE);
    assert!(flip.iter().all(|&error| error == 0.0));
    assert_eq!(ssim(&reference, &reference, WIDTH), Some(1.0));
    let errors = errors(&reference, &reference).expect("finite");
    assert_eq!(
        (errors.mse, errors.relative_mse, errors.psnr),
        (0.0, 0.0, f32::INFINITY)
    );
    assert_eq!(Exposures::of(&[Rgb::ZERO; 4]), None);
    assert_eq!(ssim(&reference[..10 * WIDTH], &reference[..10 * WIDTH], WIDTH), None);
    // A single pixel is a valid picture.
    assert_eq!(ldr_flip(&[Rgb::ONE], &[Rgb::ONE], 1, PIXELS_PER_DEGREE), [0.0]);
}
