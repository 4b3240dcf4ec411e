//! A colour map for numbers, from dark to bright.

use crate::color::Rgb;

/// An sRGB-encoded colour of the map "magma" (N. Smith and S. van der Walt, for matplotlib) for a number in [0, 1]:
/// from black over purple to light yellow. Polynomials were fitted to the map by least squares; they are within 0.024
/// of it.
pub fn magma(number: f32) -> Rgb {
    const POWERS: [Rgb; 7] = [
        Rgb::new(-0.002_07, -0.000_69, -0.009_55),
        Rgb::new(0.250_49, 0.694_46, 2.495_29),
        Rgb::new(8.345_9, -3.596_03, 0.329_06),
        Rgb::new(-27.666_97, 14.253_85, -13.646_58),
        Rgb::new(52.170_68, -27.944_58, 12.881_09),
        Rgb::new(-50.758_57, 29.053_88, 4.269_94),
        Rgb::new(18.664_25, -11.490_03, -5.570_77),
    ];
    let x = if number > 0.0 { number.min(1.0) } else { 0.0 };
    let sum = POWERS.iter().rev().fold(Rgb::ZERO, |sum, &power| sum * x + power);
    sum.clamp(Rgb::ZERO, Rgb::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The values are matplotlib's at 0, 64/255, 128/255, 192/255 and 1.
    #[test]
    fn the_colours_are_those_of_the_map() {
        for (step, color) in [
            (0.0, Rgb::new(0.001, 0.000, 0.014)),
            (64.0, Rgb::new(0.317, 0.072, 0.485)),
            (128.0, Rgb::new(0.716, 0.215, 0.475)),
            (192.0, Rgb::new(0.987, 0.536, 0.382)),
            (255.0, Rgb::new(0.987, 0.991, 0.750)),
        ] {
            let found = magma(step / 255.0);
            assert!(found.abs_diff_eq(color, 0.025), "{step}: {found} {color}");
        }
        assert_eq!(magma(f32::NAN), magma(-1.0));
        assert_eq!(magma(2.0), magma(1.0));
    }
}
