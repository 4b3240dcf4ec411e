//! Colour: linear Rec. 709 RGB, its luminance, and the sRGB transfer function (IEC 61966-2-1).

pub mod temperature;

use std::sync::LazyLock;

use glam::{Mat3, Vec3};

/// Linear Rec. 709 RGB: a radiance, a reflectance or a weight, by context.
pub type Rgb = Vec3;

/// The largest radiance, intensity, irradiance or value of a picture or a grid: products along a path stay finite.
pub const BRIGHTEST: f32 = 1e12;

/// The share of each component of a linear colour in its luminance.
pub const LUMINANCE: Vec3 = Vec3::new(0.212_671, 0.715_160, 0.072_169);

/// Relative luminance (CIE Y) of a linear colour.
pub fn luminance(rgb: Rgb) -> f32 {
    rgb.dot(LUMINANCE)
}

/// CIE XYZ of a linear colour; Y is its [`luminance`].
pub fn xyz_from_rgb(rgb: Rgb) -> Vec3 {
    let x = rgb.dot(Vec3::new(0.412_453, 0.357_580, 0.180_423));
    let z = rgb.dot(Vec3::new(0.019_334, 0.119_193, 0.950_227));
    Vec3::new(x, luminance(rgb), z)
}

/// The linear colour of CIE XYZ, the inverse of [`xyz_from_rgb`].
pub fn rgb_from_xyz(xyz: Vec3) -> Rgb {
    static FROM_XYZ: LazyLock<Mat3> = LazyLock::new(|| {
        let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z].map(xyz_from_rgb);
        Mat3::from_cols(x, y, z).inverse()
    });
    *FROM_XYZ * xyz
}

/// One linear component in [0, 1] to its sRGB encoding in [0, 1].
pub fn srgb_from_linear(linear: f32) -> f32 {
    if linear <= 0.003_130_8 {
        12.92 * linear
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// One sRGB-encoded component in [0, 1] to linear.
pub fn linear_from_srgb(encoded: f32) -> f32 {
    if encoded <= 0.040_45 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

/// An sRGB-encoded component of 8 bits to linear, by table.
pub fn linear_from_srgb8(encoded: u8) -> f32 {
    static LINEAR: LazyLock<[f32; 256]> =
        LazyLock::new(|| std::array::from_fn(|code| linear_from_srgb(code as f32 / 255.0)));
    LINEAR[usize::from(encoded)]
}
