//! Apertures as photographers name them: the f-number, the focal length over the aperture's diameter.
//!
//! A scene has no focal length of its own. As for the format's `focal_length` it is that of a lens with the same field
//! of view on 35 mm film, by the film's diagonal; and a unit of the world counts as a metre.

use crate::scene::{FovAxis, Sensor};

/// The diagonal of a frame of 36 mm by 24 mm, in metres.
const FILM_DIAGONAL: f32 = 0.043_266_615;

/// The focal length in metres; `aspect` is the picture's width over its height.
pub(crate) fn focal_length(sensor: &Sensor, aspect: f32) -> f32 {
    let half_width = (0.5 * sensor.fov_axis.horizontal(sensor.fov, aspect))
        .to_radians()
        .tan();
    let half_diagonal = half_width * (1.0 + 1.0 / (aspect * aspect)).sqrt();
    0.5 * FILM_DIAGONAL / half_diagonal
}

/// The field of view in degrees along an axis of a lens of this focal length in metres; the inverse of `focal_length`.
pub fn field_of_view(focal_length: f32, axis: FovAxis, aspect: f32) -> f32 {
    let half_diagonal = 0.5 * FILM_DIAGONAL / focal_length;
    let half_width = half_diagonal / (1.0 + 1.0 / (aspect * aspect)).sqrt();
    axis.of_horizontal(2.0 * half_width.atan().to_degrees(), aspect)
}

/// The f-number of an aperture of this radius in world units; infinite for a pinhole.
pub(crate) fn f_number(radius: f32, focal_length: f32) -> f32 {
    focal_length / (2.0 * radius)
}

/// The radius of an aperture of this f-number, above 0, in the units of the focal length.
pub fn aperture_radius(f_number: f32, focal_length: f32) -> f32 {
    focal_length / (2.0 * f_number)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lens_of_fifty_millimetres_is_one() {
        // The values of 35 mm film are known: 50 mm see 46.79 degrees along the diagonal and 39.6 along the width of a
        // 3:2 picture.
        for (fov, fov_axis) in [(46.793, FovAxis::Diagonal), (39.598, FovAxis::X)] {
            let sensor = Sensor {
                fov,
                fov_axis,
                ..Sensor::default()
            };
            let focal = focal_length(&sensor, 1.5);
            assert!((focal - 0.05).abs() < 1e-5, "{fov_axis:?}: {focal}");
            assert!((field_of_view(0.05, fov_axis, 1.5) - fov).abs() < 1e-2);
        }
    }

    #[test]
    fn a_fifty_at_two_opens_twelve_and_a_half_millimetres_to_each_side() {
        assert!((aperture_radius(2.0, 0.05) - 0.0125).abs() < 1e-7);
        assert!((f_number(0.0125, 0.05) - 2.0).abs() < 1e-5);
        assert_eq!(f_number(0.0, 0.05), f32::INFINITY);
        for number in [0.01, 1.4, 22.0, 1e4] {
            assert!((f_number(aperture_radius(number, 0.035), 0.035) / number - 1.0).abs() < 1e-5);
        }
    }
}
