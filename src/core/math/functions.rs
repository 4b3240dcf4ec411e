//! Elementary functions for every form of a number, as polynomials: the same formula in one lane and in sixteen.
//!
//! Coefficients are those of the Cephes library (Moshier, 1984 to 2000, single precision). Errors are in units in the
//! last place, as the tests measure them over the whole range.

use std::f32::consts::{FRAC_1_PI, LOG2_E, SQRT_2};

use super::real::{Real, Word};

/// Outside of this range the power of two would not be a normal number: the result is infinite above (the exact one
/// only above 88.72), and 0 below, where it is less than the least normal number.
const LARGEST_EXPONENT: f32 = 88.02;
const LEAST_EXPONENT: f32 = -87.33;

/// ln 2 in two parts, the first with so few digits that its products with whole numbers are exact.
const LN_2: [f32; 2] = [0.693_359_4, -2.121_944_4e-4];

/// pi in four parts of that kind.
const PI: [f32; 4] = [3.140_625, 9.670_257_6e-4, 6.277_114e-7, 1.215_420_1e-10];

/// The polynomial with these coefficients, from the highest power down.
#[inline(always)]
pub(super) fn polynomial<R: Real, const N: usize>(x: R, coefficients: [f32; N]) -> R {
    let mut sum = R::splat(coefficients[0]);
    for &coefficient in &coefficients[1..] {
        sum = sum.mul_add(x, R::splat(coefficient));
    }
    sum
}

/// The nearest whole number, of a number in the range of `i32`.
#[inline(always)]
fn nearest<R: Real>(x: R) -> R {
    (x + R::HALF).floor()
}

/// 2 to the power of a whole number from -126 to 127.
#[inline(always)]
fn power_of_two<R: Real>(n: R) -> R {
    R::from_bits((n + R::splat(127.0)).whole() << 23)
}

/// The exponential function, within 2 ulps; infinite above 88.02, and 0 below -87.33 and for NaN.
#[inline(always)]
pub(crate) fn exp<R: Real>(x: R) -> R {
    let limited = x.max(R::splat(LEAST_EXPONENT)).min(R::splat(LARGEST_EXPONENT));
    let n = nearest(limited * R::splat(LOG2_E));
    let rest = n.mul_add(R::splat(-LN_2[1]), n.mul_add(R::splat(-LN_2[0]), limited));
    let series = polynomial(
        rest,
        [
            1.987_569_1e-4,
            1.398_2e-3,
            8.333_452e-3,
            4.166_579_6e-2,
            0.166_666_65,
            0.5,
        ],
    );
    let mantissa = series.mul_add(rest * rest, rest + R::ONE);
    let value = mantissa * power_of_two(n);
    let value = R::select(x.is_more(R::splat(LARGEST_EXPONENT)), R::splat(f32::INFINITY), value);
    value.only(R::splat(LEAST_EXPONENT).is_at_most(x))
}

/// The natural logarithm of a positive normal number, within 2 ulps; minus infinity for 0 and subnormal numbers, NaN
/// for negative numbers and NaN.
#[inline(always)]
pub(crate) fn ln<R: Real>(x: R) -> R {
    let bits = x.to_bits();
    // The mantissa, from 0.5 to 1.
    let mantissa = R::from_bits((bits & R::Word::splat(0x007f_ffff)) | R::Word::splat(0x3f00_0000));
    let exponent = R::of_whole((bits >> 23) & R::Word::splat(0xff)) - R::splat(126.0);
    let is_low = mantissa.is_less(R::splat(0.5 * SQRT_2));
    let exponent = R::select(is_low, exponent - R::ONE, exponent);
    let x1 = R::select(is_low, mantissa + mantissa, mantissa) - R::ONE;
    let square = x1 * x1;
    let series = polynomial(
        x1,
        [
            7.037_683_6e-2,
            -0.115_146_1,
            0.116_769_98,
            -0.124_201_41,
            0.142_493_23,
            -0.166_680_57,
            0.200_007_15,
            -0.249_999_94,
            0.333_333_3,
        ],
    );
    let rest = (series * x1).mul_add(square, exponent * R::splat(LN_2[1]));
    let value = exponent.mul_add(R::splat(LN_2[0]), x1 + (-R::HALF).mul_add(square, rest));
    let value = R::select(x.equals(R::splat(f32::INFINITY)), x, value);
    let value = R::select(
        x.abs().is_less(R::splat(f32::MIN_POSITIVE)),
        R::splat(f32::NEG_INFINITY),
        value,
    );
    R::select(x.is_less(R::ZERO) | !x.equals(x), R::splat(f32::NAN), value)
}

/// Sine and cosine of an angle in radians of at most 10^4, within 2e-7 of the exact ones, and within 1e-7 for an angle
/// of at most a turn.
#[inline(always)]
pub(crate) fn sin_cos<R: Real>(x: R) -> (R, R) {
    // In half turns: an even and an odd number of them differ by the sign alone.
    let half_turns = nearest(x * R::splat(FRAC_1_PI));
    let rest = PI
        .iter()
        .fold(x, |rest, &part| half_turns.mul_add(R::splat(-part), rest));
    let even = (half_turns * R::HALF).floor();
    let is_odd = !(even + even).equals(half_turns);
    // |rest| is at most pi / 2. Both series are accurate up to pi / 4; beyond, each is replaced by the other one of the
    // complement.
    let size = rest.abs();
    let is_far = size.is_more(R::splat(std::f32::consts::FRAC_PI_4));
    let complement = R::splat(std::f32::consts::FRAC_PI_2) - size;
    let near = R::select(is_far, complement + R::splat(-4.371_139e-8), size);
    let square = near * near;
    let small = polynomial(square, [-1.951_529_6e-4, 8.332_161e-3, -0.166_666_55]).mul_add(square * near, near);
    let large = polynomial(square, [2.443_315_7e-5, -1.388_731_6e-3, 4.166_664_6e-2])
        .mul_add(square * square, (-R::HALF).mul_add(square, R::ONE));
    let sine = R::select(is_far, large, small).copy_sign(rest);
    let cosine = R::select(is_far, small, large);
    let signed = |value: R| R::select(is_odd, -value, value);
    (signed(sine), signed(cosine))
}

/// The arc sine of a number in [0, 1], within 3 ulps.
#[inline(always)]
pub(crate) fn asin_positive<R: Real>(x: R) -> R {
    let is_far = x.is_more(R::HALF);
    let half = R::HALF * (R::ONE - x);
    let square = R::select(is_far, half, x * x);
    let near = R::select(is_far, half.sqrt(), x);
    let series = polynomial(
        square,
        [4.216_32e-2, 2.418_131e-2, 4.547_002_6e-2, 7.495_300_3e-2, 0.166_667_52],
    );
    let angle = (series * square).mul_add(near, near);
    R::select(is_far, R::splat(std::f32::consts::FRAC_PI_2) - (angle + angle), angle)
}

/// The angle of the direction (x, y) to the first axis, from -pi to pi, within 4 ulps and 1e-37; 0 for the zero vector.
#[inline(always)]
pub(crate) fn atan2<R: Real>(y: R, x: R) -> R {
    let (across, along) = (y.abs(), x.abs());
    let is_steep = across.is_more(along);
    let (less, more) = (R::select(is_steep, along, across), R::select(is_steep, across, along));
    let ratio = (less / more).only(more.is_more(R::ZERO));
    // The series is accurate below the tangent of an eighth of a turn.
    let is_far = ratio.is_more(R::splat(SQRT_2 - 1.0));
    let near = R::select(is_far, (ratio - R::ONE) / (ratio + R::ONE), ratio);
    let square = near * near;
    let series = polynomial(square, [8.053_744_5e-2, -0.138_776_86, 0.199_777_1, -0.333_329_5]);
    let angle = (series * square).mul_add(near, near);
    let quarter = R::splat(std::f32::consts::FRAC_PI_4);
    let angle = R::select(is_far, quarter + angle, angle);
    let angle = R::select(is_steep, R::splat(std::f32::consts::FRAC_PI_2) - angle, angle);
    let angle = R::select(x.is_less(R::ZERO), R::splat(std::f32::consts::PI) - angle, angle);
    angle.copy_sign(y)
}

/// The cube root of a number from 2^-24 to 8, within 9 ulps; 0 for 0.
#[inline(always)]
pub(crate) fn cube_root<R: Real>(x: R) -> R {
    exp(ln(x) * R::splat(1.0 / 3.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::{LANES, Lanes};

    /// The distance of two numbers in units in the last place of the exact one.
    fn ulps(found: f32, exact: f64) -> f64 {
        let nearest = exact as f32;
        if found == nearest || found.is_nan() && exact.is_nan() {
            return 0.0;
        }
        let ulp = f64::from(f32::from_bits(nearest.abs().to_bits() + 1)) - f64::from(nearest.abs());
        (f64::from(found) - exact).abs() / ulp
    }

    /// Compares both forms at all numbers: within `most` ulps of the exact function, and equal up to that. `of_one` and
    /// `of_lanes` are the same formula.
    fn check(
        name: &str,
        places: impl Iterator<Item = f32>,
        most: f64,
        of_one: impl Fn(f32) -> f32,
        of_lanes: impl Fn(Lanes) -> Lanes,
        exact: impl Fn(f64) -> f64,
    ) {
        let places: Vec<f32> = places.collect();
        for chunk in places.chunks(LANES) {
            let mut lanes = [1.0; LANES];
            lanes[..chunk.len()].copy_from_slice(chunk);
            let found = of_lanes(Lanes::new(lanes));
            for (lane, &x) in chunk.iter().enumerate() {
                for value in [of_one(x), found.as_array()[lane]] {
                    let error = ulps(value, exact(f64::from(x)));
                    assert!(error <= most, "{name}({x}) is {value}, {error} ulps off");
                }
            }
        }
    }

    /// Numbers of all sizes from `least` on, `count` of them by a factor.
    fn sizes(least: f32, factor: f32, count: usize) -> impl Iterator<Item = f32> {
        (0..count).scan(least, move |x, _| {
            let here = *x;
            *x *= factor;
            Some(here)
        })
    }

    #[test]
    fn exponentials() {
        let places = (0..200_000).map(|k| -87.3 + k as f32 * 8.76e-4);
        check("exp", places, 2.0, exp, exp, f64::exp);
        for (x, value) in [
            (0.0, 1.0),
            (-90.0, 0.0),
            (f32::NEG_INFINITY, 0.0),
            (89.0, f32::INFINITY),
            (f32::INFINITY, f32::INFINITY),
        ] {
            assert_eq!(exp(x), value);
            assert_eq!(exp(Lanes::splat(x)).as_array()[3], value);
        }
    }

    #[test]
    fn logarithms() {
        let places = sizes(f32::MIN_POSITIVE, 1.000_87, 200_000).filter(|x| x.is_finite());
        check("ln", places, 2.0, ln, ln, f64::ln);
        let near_one = (-50_000..50_000).map(|k| 1.0 + k as f32 * 1e-5);
        check("ln", near_one, 3.0, ln, ln, f64::ln);
        for (x, value) in [(1.0, 0.0), (0.0, f32::NEG_INFINITY), (f32::INFINITY, f32::INFINITY)] {
            assert_eq!(ln(x), value);
            assert_eq!(ln(Lanes::splat(x)).as_array()[7], value);
        }
        assert!(ln(-1.0f32).is_nan() && ln(f32::NAN).is_nan());
        assert_eq!(exp(f32::NAN), 0.0);
    }

    #[test]
    fn cube_roots() {
        let places = sizes(1.0 / (1 << 24) as f32, 1.000_08, 250_000).filter(|&x| x <= 8.0);
        check("cube root", places, 9.0, cube_root, cube_root, f64::cbrt);
        assert_eq!((cube_root(0.0f32), cube_root(1.0f32)), (0.0, 1.0));
    }

    #[test]
    fn arcs() {
        let places = (0..=200_000).map(|k| k as f32 * 5e-6);
        check("asin", places, 3.0, asin_positive, asin_positive, f64::asin);
        for (k, start) in (0..400_000).step_by(LANES).enumerate() {
            let radius = 10f32.powi(k as i32 % 60 - 30);
            let directions: [(f32, f32); LANES] = std::array::from_fn(|lane| {
                let (sine, cosine) = ((start + lane) as f32 * 1.571e-5).sin_cos();
                (radius * sine, radius * cosine)
            });
            let (y, x) = (directions.map(|d| d.0), directions.map(|d| d.1));
            let lanes = atan2(Lanes::new(y), Lanes::new(x));
            for lane in 0..LANES {
                let exact = f64::from(y[lane]).atan2(f64::from(x[lane]));
                for found in [atan2(y[lane], x[lane]), lanes.as_array()[lane]] {
                    assert!(
                        ulps(found, exact) <= 4.0,
                        "{} {}: {found} for {exact}",
                        y[lane],
                        x[lane]
                    );
                }
            }
        }
        assert_eq!(atan2(0.0f32, 0.0), 0.0);
        assert_eq!(atan2(0.0f32, -1.0), std::f32::consts::PI);
    }

    #[test]
    fn sines_and_cosines() {
        for start in (-400_000..400_000).step_by(LANES) {
            let places: [f32; LANES] = std::array::from_fn(|lane| (start + lane as i32) as f32 * 0.025);
            let lanes = sin_cos(Lanes::new(places));
            for (lane, &x) in places.iter().enumerate() {
                let (sine, cosine) = f64::from(x).sin_cos();
                let (one, other) = sin_cos(x);
                for (found, exact) in [
                    (one, sine),
                    (other, cosine),
                    (lanes.0.as_array()[lane], sine),
                    (lanes.1.as_array()[lane], cosine),
                ] {
                    let most = if x.abs() < 6.3 { 1e-7 } else { 2e-7 };
                    assert!((f64::from(found) - exact).abs() < most, "{x}: {found} for {exact}");
                }
            }
        }
        assert_eq!(sin_cos(0.0f32), (0.0, 1.0));
    }
}
