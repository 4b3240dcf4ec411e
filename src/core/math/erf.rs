//! The error function and its inverse, in single precision.

use super::functions::{exp, ln, polynomial};
use super::real::{Mask, Real};

/// The error function erf(x), within 3e-7 (Abramowitz and Stegun, Handbook of Mathematical Functions, 7.1.26).
#[inline(always)]
pub(crate) fn erf<R: Real>(x: R) -> R {
    let t = R::ONE / R::splat(0.327_591_1).mul_add(x.abs(), R::ONE);
    let series = polynomial(
        t,
        [1.061_405_4, -1.453_152, 1.421_413_7, -0.284_496_74, 0.254_829_6, 0.0],
    );
    (R::ONE - series * exp(-x * x)).copy_sign(x)
}

/// The x with erf(x) = y, for y in (-1, 1), with a relative error of 1e-6 (Giles, Approximating the erfinv function,
/// GPU Computing Gems, 2010); undefined at the ends.
#[inline(always)]
pub(crate) fn erf_inv<R: Real>(y: R) -> R {
    let w = -ln((R::ONE - y) * (R::ONE + y));
    let is_far = !w.is_less(R::splat(5.0));
    let mut ratio = polynomial(
        w - R::splat(2.5),
        [
            2.810_226_4e-8,
            3.432_739_4e-7,
            -3.523_387_7e-6,
            -4.391_506_5e-6,
            2.185_808_7e-4,
            -1.253_725e-3,
            -4.177_681_6e-3,
            0.246_640_73,
            1.501_409_4,
        ],
    );
    if is_far.any() {
        let far = polynomial(
            w.max(R::ZERO).sqrt() - R::splat(3.0),
            [
                -2.002_142_6e-4,
                1.009_505_6e-4,
                1.349_343_2e-3,
                -3.673_428_4e-3,
                5.739_507_7e-3,
                -7.622_461_3e-3,
                9.438_87e-3,
                1.001_674,
                2.832_976_8,
            ],
        );
        ratio = R::select(is_far, far, ratio);
    }
    ratio * y
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::Lanes;

    #[test]
    fn known_values_and_inverse() {
        for (x, value) in [
            (0.0, 0.0),
            (0.1, 0.112_462_92),
            (0.5, 0.520_499_9),
            (1.0, 0.842_700_8),
            (2.0, 0.995_322_3),
        ] {
            let (x, value): (f32, f32) = (x, value);
            assert!((erf(x) - value).abs() < 3e-7 && (erf(-x) + value).abs() < 3e-7, "{x}");
            assert!((erf_inv(value) - x).abs() < 2e-5, "{x}");
            assert!((erf(Lanes::splat(x)).as_array()[5] - value).abs() < 3e-7, "{x}");
            assert!((erf_inv(Lanes::splat(value)).as_array()[5] - x).abs() < 2e-5, "{x}");
        }
        assert_eq!((erf(f32::INFINITY), erf(-10.0)), (1.0, -1.0));
        // erfinv(0.999999) and erfinv(1e-7), from tables.
        assert!((erf_inv(0.999_999f32) - 3.4589).abs() < 5e-3);
        assert!((erf_inv(1e-7f32) / 8.862_269e-8 - 1.0).abs() < 1e-5);
    }
}
