//! The stand-in light for a file without lights: a photographer's studio, as an environment map.
//!
//! Its radiance is about 1, like that of a white sky. But it has a bright backdrop, a darker floor and lamps, which
//! show the form of white and of mirroring objects.

use std::f32::consts::{PI, TAU};
use std::io::Cursor;

use glam::Vec3;
use image::{DynamicImage, ImageBuffer, Rgb, Rgb32FImage};

/// The size of the environment map. One texel is somewhat more than a degree.
const SIZE: [u32; 2] = [256, 128];

/// A lamp with a soft edge. Angles in degrees, around its centre.
struct SoftBox {
    /// From -z, which is the far side for most cameras of glTF, towards +x.
    azimuth: f32,
    elevation: f32,
    half_width: f32,
    half_height: f32,
    radiance: f32,
}

/// A lamp in front at the right, a weaker one at the left, and a narrow one behind.
const BOXES: [SoftBox; 3] = [
    SoftBox {
        azimuth: 125.0,
        elevation: 40.0,
        half_width: 16.0,
        half_height: 14.0,
        radiance: 1.8,
    },
    SoftBox {
        azimuth: -115.0,
        elevation: 32.0,
        half_width: 12.0,
        half_height: 18.0,
        radiance: 0.6,
    },
    SoftBox {
        azimuth: -60.0,
        elevation: 40.0,
        half_width: 6.0,
        half_height: 20.0,
        radiance: 2.5,
    },
];

/// The width of the edges of lamps in degrees.
const EDGE: f32 = 4.0;

/// The radiance from a direction, a unit vector in a space with y up.
fn radiance(direction: Vec3) -> f32 {
    let elevation = direction.y.clamp(-1.0, 1.0).asin().to_degrees();
    let azimuth = direction.x.atan2(-direction.z).to_degrees();
    let wall = match elevation < 0.0 {
        true => 1.0 - 0.7 * step(-10.0, -60.0, elevation),
        false => 1.0 - 0.55 * step(14.0, 34.0, elevation),
    };
    let ceiling = 3.0 * step(62.0, 68.0, elevation);
    let lamps = BOXES.iter().map(|lamp| {
        let turn = (azimuth - lamp.azimuth + 540.0).rem_euclid(360.0) - 180.0;
        let across = turn.abs() * elevation.to_radians().cos();
        let up = (elevation - lamp.elevation).abs();
        let inside = |distance: f32, half: f32| step(half + EDGE, half, distance);
        lamp.radiance * inside(across, lamp.half_width) * inside(up, lamp.half_height)
    });
    wall + ceiling + lamps.sum::<f32>()
}

/// A smooth step from 0 at `from` to 1 at `to`.
fn step(from: f32, to: f32, at: f32) -> f32 {
    let share = ((at - from) / (to - from)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

/// The environment map as an EXR file, with y up.
pub(super) fn picture() -> Result<Vec<u8>, image::ImageError> {
    let [width, height] = SIZE;
    let picture: Rgb32FImage = ImageBuffer::from_fn(width, height, |x, y| {
        let turn = TAU * (x as f32 + 0.5) / width as f32;
        let theta = PI * (y as f32 + 0.5) / height as f32;
        let direction = Vec3::new(turn.sin() * theta.sin(), theta.cos(), -turn.cos() * theta.sin());
        Rgb([radiance(direction); 3])
    });
    let mut bytes = Cursor::new(Vec::new());
    DynamicImage::ImageRgb32F(picture).write_to(&mut bytes, image::ImageFormat::OpenExr)?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The irradiance over pi on a surface that faces a direction.
    fn on_a_surface(normal: Vec3) -> f32 {
        let (rows, columns) = (180, 360);
        let mut sum = 0.0;
        for row in 0..rows {
            let theta = PI * (row as f32 + 0.5) / rows as f32;
            for column in 0..columns {
                let turn = TAU * (column as f32 + 0.5) / columns as f32;
                let direction = Vec3::new(turn.sin() * theta.sin(), theta.cos(), -turn.cos() * theta.sin());
                let solid_angle = theta.sin() * (PI / rows as f32) * (TAU / columns as f32);
                sum += solid_angle * radiance(direction) * normal.dot(direction).max(0.0) / PI;
            }
        }
        sum
    }

    #[test]
    fn it_is_as_bright_as_a_white_sky_and_has_form() {
        for azimuth in 0..360 {
            let turn = (azimuth as f32).to_radians();
            let backdrop = radiance(Vec3::new(turn.sin(), 0.1, -turn.cos()).normalize());
            assert!((backdrop - 1.0).abs() < 1e-3, "{azimuth}: {backdrop}");
        }
        let sides = [Vec3::X, Vec3::NEG_X, Vec3::Z, Vec3::NEG_Z].map(on_a_surface);
        // A white wall stands out against the backdrop.
        assert!(sides.iter().all(|side| (0.8..0.97).contains(side)), "{sides:?}");
        let [up, down] = [Vec3::Y, Vec3::NEG_Y].map(on_a_surface);
        assert!((1.2..1.5).contains(&up) && (0.4..0.7).contains(&down), "{up} {down}");
    }
}
