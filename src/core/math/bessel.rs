//! The modified Bessel function of the first kind, in single precision.

/// The function exp(-x) I0(x) for x >= 0, within a relative error of 5e-7 (Abramowitz and Stegun, Handbook of
/// Mathematical Functions, 9.8.1 and 9.8.2).
pub(crate) fn scaled_bessel_i0(x: f32) -> f32 {
    const BOUND: f32 = 3.75;
    let horner = |x: f32, coefficients: &[f32]| coefficients.iter().fold(0.0, |sum, c| sum * x + c);
    if x < BOUND {
        let square = (x / BOUND) * (x / BOUND);
        let series = [
            0.004_581_3,
            0.036_076_8,
            0.265_973_2,
            1.206_749_2,
            3.089_942_4,
            3.515_622_9,
            1.0,
        ];
        (-x).exp() * horner(square, &series)
    } else {
        let series = [
            0.003_923_77,
            -0.016_476_33,
            0.026_355_37,
            -0.020_577_06,
            0.009_162_81,
            -0.001_575_65,
            0.002_253_19,
            0.013_285_92,
            0.398_942_3,
        ];
        horner(BOUND / x, &series) / x.sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_values() {
        // I0 from tables, and the leading terms of the asymptotic series.
        for (x, value) in [
            (0.0, 1.0),
            (0.1, 0.907_100_9),
            (1.0, 0.465_759_6),
            (3.7, 0.216_049_44),
            (3.8, 0.212_900_13),
            (10.0, 0.127_833_3),
            (1e4, 3.989_472_7e-3),
        ] {
            assert!(
                (scaled_bessel_i0(x) / value - 1.0).abs() < 1e-6,
                "{x}: {}",
                scaled_bessel_i0(x)
            );
        }
    }
}
