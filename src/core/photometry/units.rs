//! Photometric quantities as text: three significant digits, and values with their standard errors.
//!
//! A value with an error follows the rule of the Particle Data Group (Review of Particle Physics, section 5.3) for the
//! number of digits: the error has two digits if they are less than 35, else one, and the value ends where it does.

use std::fmt;

use super::LUMENS_PER_WATT;

/// The significant digits of a value that has no error.
const DIGITS: i32 = 3;

/// The two leading digits from which on one digit of an error is enough.
const ONE_DIGIT_FROM: f64 = 35.0;

/// From here on, and below the inverse, numbers are written with an exponent.
const LARGEST_PLAIN: f64 = 1e9;

/// The relative error that counts as rounding: values come from computations of single precision.
const ROUNDING: f64 = f32::EPSILON as f64;

macro_rules! quantities {
    ($($(#[$doc:meta])* $name:ident, $symbol:literal;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
        pub struct $name(pub f64);

        impl $name {
            /// The symbol of the unit.
            pub const SYMBOL: &str = $symbol;

            /// The quantity of a radiometric one of Rec. 709 luminance, 683 lumens for a watt.
            pub fn of_watts(watts: f64) -> Self {
                Self(watts * f64::from(LUMENS_PER_WATT))
            }

            /// The quantity with its standard error of the same unit, as in `532 ± 4 lx`.
            pub fn with_error(self, error: f64) -> String {
                with_error(self.0, error, $symbol)
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.pad(&format!("{} {}", short(self.0), $symbol))
            }
        }
    )*};
}

quantities! {
    /// Illuminance in lux: lumens for each square metre of a surface.
    Lux, "lx";
    /// Luminous flux in lumens.
    Lumen, "lm";
    /// Luminous intensity in candela: lumens for each steradian.
    Candela, "cd";
    /// Luminance in nit: candela for each square metre as it is seen.
    Nit, "cd/m²";
}

/// A number with three significant digits, whole from 1000 on.
pub fn short(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return format!("{value}");
    }
    let size = value.abs();
    if !(1.0 / LARGEST_PLAIN..LARGEST_PLAIN).contains(&size) {
        return format!("{value:.2e}");
    }
    // Rounding may add a digit: 9.996 is 10.0.
    let rounded: f64 = format!("{value:.2e}").parse().unwrap_or(value);
    let decimals = (DIGITS - 1 - exponent(rounded)).max(0) as usize;
    format!("{value:.decimals$}")
}

/// A value and its standard error with as many digits as the error has meaning, with a unit: `532 ± 4 lx`. The error
/// is left out if it is not above the rounding of single precision, and unknown if it is not finite.
pub fn with_error(value: f64, error: f64, symbol: &str) -> String {
    if error.abs() <= ROUNDING * value.abs() || !value.is_finite() {
        return format!("{} {symbol}", short(value));
    }
    if !error.is_finite() {
        return format!("{} ± ? {symbol}", short(value));
    }
    let error = error.abs();
    let decimals = match error / 10f64.powi(exponent(error) - 1) < ONE_DIGIT_FROM {
        true => 1 - exponent(error),
        false => -exponent(error),
    };
    let size = value.abs().max(error);
    if !(1.0 / LARGEST_PLAIN..LARGEST_PLAIN).contains(&size) {
        return format!("{value:.2e} ± {error:.1e} {symbol}");
    }
    let places = decimals.max(0) as usize;
    let (value, error) = (to_decimals(value, decimals), to_decimals(error, decimals));
    format!("{value:.places$} ± {error:.places$} {symbol}")
}

/// The power of ten of the first digit.
fn exponent(value: f64) -> i32 {
    value.abs().log10().floor() as i32
}

/// The value rounded to so many decimals, before the point if negative.
fn to_decimals(value: f64, decimals: i32) -> f64 {
    let unit = 10f64.powi(-decimals);
    (value / unit).round() * unit
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_three_digits() {
        for (value, text) in [
            (0.0, "0"),
            (531.64, "532"),
            (1234.5, "1234"),
            (123_456.0, "123456"),
            (9.996, "10.0"),
            (12.345, "12.3"),
            (0.012_345, "0.0123"),
            (-4.0, "-4.00"),
            (1.6e9, "1.60e9"),
            (2e-12, "2.00e-12"),
            (f64::NAN, "NaN"),
            (f64::INFINITY, "inf"),
        ] {
            assert_eq!(short(value), text, "{value}");
        }
        assert_eq!(Lux(531.64).to_string(), "532 lx");
        assert_eq!(format!("{:>10}", Lumen(806.0)), "    806 lm");
        assert_eq!(Candela::of_watts(1.0), Candela(683.0));
    }

    #[test]
    fn values_end_where_their_errors_do() {
        for (value, error, text) in [
            (531.64, 4.2, "532 ± 4 lx"),
            (531.64, 1.23, "531.6 ± 1.2 lx"),
            (531.64, 0.0, "532 lx"),
            (531.64, 42.0, "530 ± 40 lx"),
            (531.64, 12.3, "532 ± 12 lx"),
            (531.64, 9.7, "532 ± 10 lx"),
            (0.5, 0.003_6, "0.500 ± 0.004 lx"),
            (0.5, 0.003_1, "0.5000 ± 0.0031 lx"),
            (0.0, 0.02, "0.000 ± 0.020 lx"),
            (12_345.0, 678.0, "12300 ± 700 lx"),
            (5.0, f64::NAN, "5.00 ± ? lx"),
            (1e12, 1e9, "1.00e12 ± 1.0e9 lx"),
            (3_867.255_876_5, 4e-7, "3867 lx"),
            (3_867.255_876_5, 0.004, "3867.256 ± 0.004 lx"),
            (0.0, 0.0, "0 lx"),
        ] {
            assert_eq!(with_error(value, error, "lx"), text, "{value} {error}");
        }
        assert_eq!(Nit(318.0).with_error(4.0), "318 ± 4 cd/m²");
    }
}
