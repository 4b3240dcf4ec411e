//! White balance: the picture as seen by an eye that is adapted to another white than the display's.
//!
//! The white is that of a black body (M. Krystek, "An algorithm to calculate correlated colour temperature", Color
//! Research & Application 10, 1985), moved by the small step that takes the one of 6504 K to the display's white, D65.
//! The eye adapts to it by scaling the responses of its cones (von Kries), in the space of the Bradford transform (K.
//! M. Lam, 1985; CIECAM97s).

use glam::{Mat3, Vec2, Vec3};

use crate::color::temperature::{self, black_body, green};

/// The colour of the light that is shown as white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WhiteBalance {
    /// The temperature in kelvin, in [`Self::TEMPERATURES`]. A lower one means redder light, which makes the picture
    /// bluer.
    pub temperature: f32,
    /// The excess of green of the light over a black body's, in [-150, 150]; 3000 is a distance of 1 in the CIE 1960
    /// diagram, as in photo programs. Greater values make the picture more magenta.
    pub tint: f32,
}

impl Default for WhiteBalance {
    /// The display's own white, which changes nothing.
    fn default() -> Self {
        Self {
            temperature: D65_TEMPERATURE,
            tint: 0.0,
        }
    }
}

const D65_TEMPERATURE: f32 = 6504.0;
/// The chromaticity x, y of D65.
const D65: Vec2 = Vec2::new(0.3127, 0.3290);

impl WhiteBalance {
    /// The temperatures for which the formula for black bodies holds.
    pub const TEMPERATURES: std::ops::RangeInclusive<f32> = temperature::TEMPERATURES;
    /// The range of tints in the panel.
    pub const TINTS: std::ops::RangeInclusive<f32> = -150.0..=150.0;

    /// The matrix for linear Rec. 709 colours; None if it changes nothing.
    pub(crate) fn adaptation(&self) -> Option<Mat3> {
        if *self == Self::default() {
            return None;
        }
        let xyz_from_rgb = Mat3::from_cols(
            Vec3::new(0.412_453, 0.212_671, 0.019_334),
            Vec3::new(0.357_580, 0.715_160, 0.119_193),
            Vec3::new(0.180_423, 0.072_169, 0.950_227),
        );
        let cones_from_xyz = Mat3::from_cols(
            Vec3::new(0.8951, -0.7502, 0.0389),
            Vec3::new(0.2664, 1.7135, -0.0685),
            Vec3::new(-0.1614, 0.0367, 1.0296),
        );
        let cones_from_rgb = cones_from_xyz * xyz_from_rgb;
        let gains = (cones_from_xyz * xyz(D65)) / (cones_from_xyz * xyz(self.white()));
        Some(cones_from_rgb.inverse() * Mat3::from_diagonal(gains) * cones_from_rgb)
    }

    /// The chromaticity x, y of the white.
    fn white(&self) -> Vec2 {
        let (low, high) = (*Self::TEMPERATURES.start(), *Self::TEMPERATURES.end());
        let kelvin = self.temperature.max(low).min(high);
        let tint = self.tint.max(*Self::TINTS.start()).min(*Self::TINTS.end());
        let uv = black_body(kelvin) + tint / 3000.0 * green(kelvin) + (uv(D65) - black_body(D65_TEMPERATURE));
        Vec2::new(3.0 * uv.x, 2.0 * uv.y) / (2.0 * uv.x - 8.0 * uv.y + 4.0)
    }
}

/// The CIE 1960 u, v of a chromaticity x, y.
fn uv(xy: Vec2) -> Vec2 {
    Vec2::new(4.0 * xy.x, 6.0 * xy.y) / (-2.0 * xy.x + 12.0 * xy.y + 3.0)
}

/// The XYZ of a chromaticity with luminance 1.
fn xyz(xy: Vec2) -> Vec3 {
    Vec3::new(xy.x, xy.y, 1.0 - xy.x - xy.y) / xy.y
}

#[cfg(test)]
mod tests {
    use super::*;

    /// These are published chromaticities of black bodies: CIE standard illuminant A is one of 2856 K; 4000 K follows
    /// from Planck's law.
    #[test]
    fn black_bodies_have_their_colours() {
        for (kelvin, x, y) in [(2855.5, 0.447_57, 0.407_45), (4000.0, 0.380_45, 0.376_75)] {
            // The formula is accurate to 8e-5 in u and 9e-5 in v above 1000 K.
            assert!(black_body(kelvin).abs_diff_eq(uv(Vec2::new(x, y)), 2e-4), "{kelvin}");
        }
    }

    #[test]
    fn the_displays_own_white_is_left_alone() {
        assert_eq!(WhiteBalance::default().adaptation(), None);
        let almost = WhiteBalance {
            temperature: D65_TEMPERATURE + 0.01,
            tint: 0.0,
        };
        let adaptation = almost.adaptation().expect("another white");
        assert!(adaptation.abs_diff_eq(Mat3::IDENTITY, 1e-3), "{adaptation}");
    }

    #[test]
    fn the_light_that_is_named_becomes_white() {
        let rgb_from_xyz = Mat3::from_cols(
            Vec3::new(3.240_479, -0.969_256, 0.055_648),
            Vec3::new(-1.537_15, 1.875_991, -0.204_043),
            Vec3::new(-0.498_535, 0.041_556, 1.057_311),
        );
        for (temperature, tint) in [(2500.0, 0.0), (4000.0, 40.0), (9000.0, -30.0)] {
            let balance = WhiteBalance { temperature, tint };
            let light = rgb_from_xyz * xyz(balance.white());
            let seen = balance.adaptation().expect("another white") * light;
            // Both matrices have six digits, and D65 four.
            assert!(seen.abs_diff_eq(Vec3::ONE, 2e-3), "{balance:?}: {seen}");
        }
    }

    /// The matrices are those of colour-science 0.4.7: `CCT_to_uv_Krystek1985` moved by the step from 6504 K to D65,
    /// and `matrix_chromatic_adaptation_VonKries` with "Bradford", between its matrices of sRGB. Rows are written
    /// one after the other.
    #[test]
    fn matrices_are_those_of_another_program() {
        for (temperature, rows) in [
            (
                3200.0,
                [
                    [0.809_928, -0.341_113, -0.082_232],
                    [0.015_806, 1.115_958, -0.034_117],
                    [0.039_890, 0.149_631, 2.711_958],
                ],
            ),
            (
                5000.0,
                [
                    [0.940_676, -0.092_118, -0.016_841],
                    [0.004_357, 1.023_911, -0.006_225],
                    [0.007_801, 0.028_188, 1.317_801],
                ],
            ),
            (
                9000.0,
                [
                    [1.055_698, 0.076_654, 0.012_224],
                    [-0.003_655, 0.986_238, 0.004_183],
                    [-0.005_500, -0.019_381, 0.787_415],
                ],
            ),
        ] {
            let balance = WhiteBalance { temperature, tint: 0.0 };
            let found = balance.adaptation().expect("another white");
            // Both round the matrices of sRGB, to six and to four digits.
            let expected = Mat3::from_cols_array_2d(&rows).transpose();
            assert!(found.abs_diff_eq(expected, 1e-3), "{temperature} K: {found} {expected}");
        }
    }

    #[test]
    fn low_temperatures_make_blue_and_tint_makes_magenta() {
        let grey =
            |temperature, tint| WhiteBalance { temperature, tint }.adaptation().expect("another white") * Vec3::ONE;
        let (warm, cold, green) = (grey(3000.0, 0.0), grey(12_000.0, 0.0), grey(D65_TEMPERATURE, 60.0));
        assert!(warm.z > 1.2 && warm.x < 0.9, "{warm}");
        assert!(cold.z < 0.9 && cold.x > 1.0, "{cold}");
        assert!(green.y < green.x.min(green.z) - 0.05, "{green}");
        // Values out of range and NaN change nothing beyond the range.
        assert!(grey(f32::NAN, f32::INFINITY).is_finite());
        assert_eq!(grey(1.0, 0.0), grey(1000.0, 0.0));
    }
}
