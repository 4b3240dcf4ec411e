//! Turns spectra, given as wavelengths and values or as the temperature of a black body, into linear Rec. 709 colours.
//!
//! A renderer of three colours has to integrate a spectrum when it reads it. As in Mitsuba's RGB mode a reflectance is
//! seen under D65 (so that white stays 1, 1, 1), and a light's spectrum is taken as it is (so that equal energy is
//! slightly purple).

use glam::{DMat3, DVec3, Vec3};

use super::Category;
use super::cie::{D65, FIRST_NM, OBSERVER, SAMPLES, STEP_NM};
use super::value::{ValueError, fields, parse_float, quote};

/// Linear Rec. 709 from CIE XYZ (ITU-R BT.709 primaries, D65 white).
const REC709_FROM_XYZ: DMat3 = DMat3::from_cols_array(&[
    3.240_479, -0.969_256, 0.055_648, -1.537_150, 1.875_991, -0.204_043, -0.498_535, 0.041_556, 1.057_311,
]);

/// The number of intervals of the integral, fine enough for lists with 1 nm steps.
const STEPS: usize = 1000;

/// The quantity that a spectrum describes. It decides the illuminant of the conversion and the bounds of the colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Role {
    /// Radiance and similar quantities: no illuminant, no upper bound.
    Emission,
    /// Emission that is the product of this spectrum and that of D65: no upper bound.
    Daylight,
    /// Reflectance, transmittance: between 0 and 1, under D65.
    Reflectance,
    /// Indices of refraction and extinction: under D65, without an upper bound.
    Unbounded,
}

impl Role {
    /// The role of a spectrum given for this parameter of a plugin of this category.
    pub fn of(owner: Category, parameter: &str) -> Self {
        match owner {
            Category::Emitter => Self::Emission,
            Category::Medium if parameter == "emission" => Self::Emission,
            Category::Medium if parameter == "albedo" => Self::Reflectance,
            Category::Bsdf if !matches!(parameter, "eta" | "k" | "sigma_a") => Self::Reflectance,
            _ if parameter.contains("reflectance") || parameter.contains("transmittance") => Self::Reflectance,
            _ => Self::Unbounded,
        }
    }
}

/// The warning for a spectrum whose colour had to be clamped.
pub const CLAMPED: &str = "no mixture of red, green and blue gives this spectrum; the nearest colour is taken";

/// The reason why a text is no sampled spectrum. Lines count from 1.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum SpectrumError {
    #[error(transparent)]
    Value(#[from] ValueError),
    #[error("expected `wavelength:value`, found {0}")]
    NoPair(String),
    #[error("line {0}: {1}")]
    Line(usize, ValueError),
    #[error("line {0}: expected a wavelength and a value")]
    Columns(usize),
    #[error("the number of wavelengths is {wavelengths}, but the number of values is {values}")]
    Uneven { wavelengths: usize, values: usize },
    #[error("a spectrum needs at least two wavelengths")]
    TooShort,
    #[error("wavelengths must increase, but {next} follows {before}")]
    Unordered { before: f32, next: f32 },
}

/// A sampled spectrum; the wavelengths (nm) increase.
#[derive(Clone, Debug, PartialEq)]
pub struct SampledSpectrum {
    points: Vec<(f64, f64)>,
}

/// The colour of a light that has the power 1 at every wavelength.
pub(crate) fn equal_energy_white() -> Vec3 {
    (REC709_FROM_XYZ * DVec3::ONE).as_vec3()
}

impl SampledSpectrum {
    /// Parses a list such as "400:0.1, 500:0.2, 700:0.9".
    pub fn parse_list(text: &str) -> Result<Self, SpectrumError> {
        let pairs = fields(text).map(|pair| {
            let (wavelength, value) = pair.split_once(':').ok_or_else(|| SpectrumError::NoPair(quote(pair)))?;
            Ok((parse_float(wavelength)?, parse_float(value)?))
        });
        Self::new(pairs.collect::<Result<_, SpectrumError>>()?)
    }

    /// Parses a file with one `wavelength value` on each line; `#` starts a comment.
    pub fn parse_file(text: &str) -> Result<Self, SpectrumError> {
        let mut pairs = Vec::new();
        for (number, line) in text.lines().enumerate() {
            let content = line.split('#').next().unwrap_or_default();
            let numbers: Vec<f32> = fields(content)
                .map(parse_float)
                .collect::<Result<_, _>>()
                .map_err(|error| SpectrumError::Line(number + 1, error))?;
            match numbers[..] {
                [] => {}
                [wavelength, value] => pairs.push((wavelength, value)),
                _ => return Err(SpectrumError::Columns(number + 1)),
            }
        }
        Self::new(pairs)
    }

    /// Parses values at equal distances, the first at `first_nm` and the last at `last_nm`; `values` is a list of
    /// numbers.
    pub fn parse_regular(first_nm: f32, last_nm: f32, values: &str) -> Result<Self, SpectrumError> {
        let values = parse_numbers(values)?;
        // The range may exceed the largest 32-bit float.
        let (first, last) = (f64::from(first_nm), f64::from(last_nm));
        let step = (last - first) / values.len().saturating_sub(1).max(1) as f64;
        let pairs = values.iter().enumerate();
        Self::new(
            pairs
                .map(|(i, &value)| ((first + step * i as f64) as f32, value))
                .collect(),
        )
    }

    /// Parses a spectrum of as many wavelengths as values, both lists of numbers.
    pub fn parse_irregular(wavelengths: &str, values: &str) -> Result<Self, SpectrumError> {
        let (wavelengths, values) = (parse_numbers(wavelengths)?, parse_numbers(values)?);
        if wavelengths.len() != values.len() {
            let (wavelengths, values) = (wavelengths.len(), values.len());
            return Err(SpectrumError::Uneven { wavelengths, values });
        }
        Self::new(wavelengths.into_iter().zip(values).collect())
    }

    fn new(pairs: Vec<(f32, f32)>) -> Result<Self, SpectrumError> {
        if pairs.len() < 2 {
            return Err(SpectrumError::TooShort);
        }
        if let Some(two) = pairs.windows(2).find(|two| two[0].0 >= two[1].0) {
            let (before, next) = (two[0].0, two[1].0);
            return Err(SpectrumError::Unordered { before, next });
        }
        let points = pairs.into_iter().map(|(nm, value)| (nm.into(), value.into())).collect();
        Ok(Self { points })
    }

    /// The colour, and whether it had to be clamped because no mixture of the three primaries makes it.
    pub fn to_rgb(&self, role: Role) -> (Vec3, bool) {
        let mut segment = 0;
        integrate(role, |wavelength| {
            while segment + 2 < self.points.len() && wavelength > self.points[segment + 1].0 {
                segment += 1;
            }
            let ((nm0, value0), (nm1, value1)) = (self.points[segment], self.points[segment + 1]);
            match (nm0..=nm1).contains(&wavelength) {
                true => value0 + (value1 - value0) * (wavelength - nm0) / (nm1 - nm0),
                false => 0.0,
            }
        })
    }
}

/// The light of a black body between two wavelengths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlackBody {
    /// The temperature, above zero.
    pub kelvin: f32,
    /// The shortest wavelength, in nanometres. There is no light below it.
    pub first_nm: f32,
    /// The longest wavelength, in nanometres. There is no light above it.
    pub last_nm: f32,
}

impl BlackBody {
    /// The colour of its radiance, as [`SampledSpectrum::to_rgb`]. The spectral radiance is in W/(m^2 sr nm) by
    /// Planck's law.
    pub fn to_rgb(self, role: Role) -> (Vec3, bool) {
        // The defining constants of the SI.
        const SPEED_OF_LIGHT: f64 = 299_792_458.0;
        const PLANCK: f64 = 6.626_070_15e-34;
        const BOLTZMANN: f64 = 1.380_649e-23;
        const METERS_PER_NM: f64 = 1e-9;
        let range = f64::from(self.first_nm)..=f64::from(self.last_nm);
        integrate(role, |wavelength| {
            if !range.contains(&wavelength) {
                return 0.0;
            }
            let lambda = METERS_PER_NM * wavelength;
            let energy_ratio = PLANCK * SPEED_OF_LIGHT / (lambda * BOLTZMANN * f64::from(self.kelvin));
            METERS_PER_NM * 2.0 * PLANCK * SPEED_OF_LIGHT.powi(2) / (lambda.powi(5) * energy_ratio.exp_m1())
        })
    }
}

/// The colour of a spectrum whose `value` is called with wavelengths (nm) in increasing order, and whether it was
/// clamped.
fn integrate(role: Role, mut value: impl FnMut(f64) -> f64) -> (Vec3, bool) {
    let range = STEP_NM * (SAMPLES - 1) as f64;
    let mut xyz = DVec3::ZERO;
    let mut whole = 0.0;
    for step in 0..STEPS {
        let offset = step as f64 / (STEPS - 1) as f64 * range;
        let observer = table(offset, |i| DVec3::from_array(OBSERVER[i]));
        let light = match role {
            Role::Emission => 1.0,
            Role::Daylight | Role::Reflectance | Role::Unbounded => table(offset, |i| D65[i]),
        };
        whole += observer.y * light;
        xyz += observer * light * value(FIRST_NM + offset);
    }
    let rgb = (REC709_FROM_XYZ * (xyz / whole)).as_vec3();
    let highest = if role == Role::Reflectance { 1.0 } else { f32::MAX };
    let possible = rgb.clamp(Vec3::ZERO, Vec3::splat(highest));
    // Rounding may leave white slightly above one, which is no reason for a warning.
    (
        possible,
        !possible.abs_diff_eq(rgb, 1e-3 * rgb.abs().max_element().max(1.0)),
    )
}

fn parse_numbers(text: &str) -> Result<Vec<f32>, ValueError> {
    fields(text).map(parse_float).collect()
}

/// Linear interpolation in a table of the CIE, `offset` nm after its first entry.
fn table<T>(offset: f64, entry: impl Fn(usize) -> T) -> T
where
    T: std::ops::Add<Output = T> + std::ops::Mul<f64, Output = T>,
{
    let place = offset / STEP_NM;
    let index = (place as usize).min(SAMPLES - 2);
    let weight = place - index as f64;
    entry(index) * (1.0 - weight) + entry(index + 1) * weight
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_is_white_under_daylight_and_purple_by_itself() {
        let flat = SampledSpectrum::parse_list("300:0.5, 900:0.5").unwrap();
        let (rgb, clamped) = flat.to_rgb(Role::Reflectance);
        // The published tables and the rounded matrix agree on white to three digits.
        assert!(rgb.abs_diff_eq(Vec3::splat(0.5), 5e-4), "{rgb}");
        assert!(!clamped);
        let (light, _) = flat.to_rgb(Role::Emission);
        assert!(light.abs_diff_eq(0.5 * equal_energy_white(), 5e-4), "{light}");
        assert!(light.x > light.y && light.y > light.z);
    }

    #[test]
    fn red_is_red_and_pure_colours_are_clamped() {
        let red = SampledSpectrum::parse_list("400:0.05 580:0.1, 620:0.6, 700:0.64").unwrap();
        let (rgb, _) = red.to_rgb(Role::Reflectance);
        assert!(rgb.x > 0.5 && rgb.y < 0.2 && rgb.z < 0.1, "{rgb}");
        let laser = SampledSpectrum::parse_list("515:0, 520:1, 525:0").unwrap();
        let (rgb, clamped) = laser.to_rgb(Role::Reflectance);
        assert!(clamped && rgb.min_element() == 0.0);
    }

    #[test]
    fn a_regular_spectrum_may_be_longer_than_any_number() {
        let wide = SampledSpectrum::parse_regular(-3e38, 3e38, "1, 1, 1").expect("rising wavelengths");
        let flat = SampledSpectrum::parse_list("300:1, 900:1").expect("a list");
        assert_eq!(wide.to_rgb(Role::Emission), flat.to_rgb(Role::Emission));
        assert!(SampledSpectrum::parse_regular(700.0, 400.0, "1, 1").is_err());
    }

    #[test]
    fn bad_lists_say_what_is_wrong() {
        assert!(
            SampledSpectrum::parse_list("400:0.1, 0.2")
                .unwrap_err()
                .to_string()
                .contains("`0.2`")
        );
        assert!(
            SampledSpectrum::parse_list("400:x, 500:1")
                .unwrap_err()
                .to_string()
                .contains("`x`")
        );
        assert!(
            SampledSpectrum::parse_list("500:1, 400:1")
                .unwrap_err()
                .to_string()
                .contains("increase")
        );
        assert!(SampledSpectrum::parse_list("").is_err());
        let file = "# nm value\n400 0.25\n\n700 0.75 # end\n";
        assert_eq!(
            SampledSpectrum::parse_file(file),
            SampledSpectrum::parse_list("400:0.25 700:0.75")
        );
        assert!(
            SampledSpectrum::parse_file("400 1\n500\n")
                .unwrap_err()
                .to_string()
                .contains("line 2")
        );
    }
}
