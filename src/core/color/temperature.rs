//! Colours of light by temperature: chromaticities of black bodies, and of light beside them by its Duv.
//!
//! The chromaticities are those of M. Krystek, "An algorithm to calculate correlated colour temperature", Color
//! Research & Application 10, 1985: within 9e-5 of Planck's law in the CIE 1960 diagram from 1000 to 15,000 K. Duv is
//! the distance from there in the same diagram, positive above the curve, on the side of green (ANSI C78.377; Ohno,
//! "Practical use and calculation of CCT and Duv", LEUKOS 10, 2014).

use std::ops::RangeInclusive;

use glam::{Vec2, Vec3};

use super::{Rgb, rgb_from_xyz, xyz_from_rgb};

/// The temperatures in kelvin for which the formula holds.
pub const TEMPERATURES: RangeInclusive<f32> = 1000.0..=15_000.0;

/// The distances from black bodies for which a colour has a temperature (CIE 15:2018, section 9.5).
pub const DUVS: RangeInclusive<f32> = -0.05..=0.05;

/// The steps in which the nearest black body is searched, even in the reciprocal temperature.
const STEPS: usize = 128;

/// A colour of light by the nearest black body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Temperature {
    /// The correlated colour temperature in kelvin, in [`TEMPERATURES`].
    pub kelvin: f32,
    /// The distance from the black body in the CIE 1960 diagram, in [`DUVS`]; more is greener, less is pinker.
    pub duv: f32,
}

impl Temperature {
    /// The CIE 1960 u, v. Numbers beyond the ranges count as their ends.
    pub fn uv(self) -> Vec2 {
        let kelvin = self.kelvin.max(*TEMPERATURES.start()).min(*TEMPERATURES.end());
        let duv = self.duv.max(*DUVS.start()).min(*DUVS.end());
        black_body(kelvin) + duv * green(kelvin)
    }

    /// The linear Rec. 709 colour, with 1 as its largest channel. Channels of colours outside of Rec. 709 that would be
    /// negative are zero.
    pub fn color(self) -> Rgb {
        let uv = self.uv();
        let xy = Vec2::new(3.0 * uv.x, 2.0 * uv.y) / (2.0 * uv.x - 8.0 * uv.y + 4.0);
        let color = rgb_from_xyz(Vec3::new(xy.x, xy.y, 1.0 - xy.x - xy.y) / xy.y).max(Rgb::ZERO);
        color / color.max_element()
    }

    /// The temperature of a colour; None for black, and for a colour too far from black bodies.
    pub fn of_color(color: Rgb) -> Option<Self> {
        let Vec3 { x, y, z } = xyz_from_rgb(color.max(Rgb::ZERO));
        let uv = Vec2::new(4.0 * x, 6.0 * y) / (x + 15.0 * y + 3.0 * z);
        if !uv.is_finite() {
            return None;
        }
        let [coldest, hottest] = [TEMPERATURES.start().recip(), TEMPERATURES.end().recip()];
        let at = |step: f32| 1.0 / (coldest + (hottest - coldest) * step / STEPS as f32);
        let distance = |step: &f32| black_body(at(*step)).distance_squared(uv);
        let nearest = (0..=STEPS)
            .map(|step| step as f32)
            .min_by(|one, other| distance(one).total_cmp(&distance(other)))?;
        // The perpendicular through the colour meets the curve where its offset along the curve vanishes.
        let along = |step: f32| {
            let kelvin = at(step);
            let green = green(kelvin);
            (uv - black_body(kelvin)).dot(Vec2::new(green.y, -green.x))
        };
        let (mut low, mut high) = ((nearest - 1.0).max(0.0), (nearest + 1.0).min(STEPS as f32));
        let rises = along(high) > along(low);
        for _ in 0..24 {
            let middle = 0.5 * (low + high);
            match (along(middle) > 0.0) == rises {
                true => high = middle,
                false => low = middle,
            }
        }
        let kelvin = at(0.5 * (low + high));
        let duv = (uv - black_body(kelvin)).dot(green(kelvin));
        let is_beyond = (uv - black_body(kelvin)).length() > duv.abs() + 1e-3;
        (DUVS.contains(&duv) && !is_beyond).then_some(Self { kelvin, duv })
    }
}

/// The CIE 1960 u, v of a black body with a temperature in [`TEMPERATURES`].
pub fn black_body(kelvin: f32) -> Vec2 {
    let t = f64::from(kelvin);
    let u = (0.860_117_757 + 1.541_182_54e-4 * t + 1.286_412_12e-7 * t * t)
        / (1.0 + 8.424_202_35e-4 * t + 7.081_451_63e-7 * t * t);
    let v = (0.317_398_726 + 4.228_062_45e-5 * t + 4.204_816_91e-8 * t * t)
        / (1.0 - 2.897_418_16e-5 * t + 1.614_560_53e-7 * t * t);
    Vec2::new(u as f32, v as f32)
}

/// The unit vector in the CIE 1960 diagram that leads from a black body towards green, across the curve.
pub fn green(kelvin: f32) -> Vec2 {
    let along = (black_body(kelvin + 1.0) - black_body(kelvin - 1.0)).normalize();
    // Higher temperatures are to the left in the diagram: green is to the right of that direction.
    Vec2::new(along.y, -along.x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn temperatures_come_back_from_their_colours() {
        // Warmer than this, and far from the curve, colours leave Rec. 709, and their negative blue is cut off.
        for kelvin in [2200.0, 2700.0, 4000.0, 6504.0, 12_000.0] {
            for duv in [-0.01, 0.0, 0.003] {
                let given = Temperature { kelvin, duv };
                let color = 7.0 * given.color();
                let found = Temperature::of_color(color).expect("near black bodies");
                assert!((found.kelvin / kelvin - 1.0).abs() < 2e-3, "{given:?}: {found:?}");
                assert!((found.duv - duv).abs() < 1e-4, "{given:?}: {found:?}");
            }
        }
    }

    #[test]
    fn black_bodies_go_from_red_to_blue() {
        let [warm, cold, white] = [2000.0, 12_000.0, 6500.0].map(|kelvin| Temperature { kelvin, duv: 0.0 }.color());
        assert!(
            warm.x == 1.0 && warm.z < 0.1 && cold.z == 1.0 && cold.x < 0.8,
            "{warm:?} {cold:?}"
        );
        // The white point of Rec. 709 is near the light of 6500 kelvin.
        assert!(white.min_element() > 0.85, "{white:?}");
    }

    #[test]
    fn known_whites_have_their_temperatures() {
        // The white of Rec. 709 is D65: 6504 K with a Duv of 0.0032 (CIE 15:2018; Ohno 2014).
        let white = Temperature::of_color(Rgb::ONE).expect("white");
        assert!(
            (white.kelvin - 6504.0).abs() < 10.0 && (white.duv - 0.0032).abs() < 2e-4,
            "{white:?}"
        );
        assert_eq!(Temperature::of_color(Rgb::ZERO), None);
        assert_eq!(Temperature::of_color(Rgb::Y), None);
        assert_eq!(Temperature::of_color(Rgb::NAN), None);
    }
}
