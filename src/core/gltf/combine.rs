//! Pictures whose texels are made of two images, or of several channels of one: emission with alpha, stretched facets,
//! and the colours of specular-glossiness.

use glam::Vec3;
use image::DynamicImage;

use super::specular_glossiness::metallic_look;
use crate::color::linear_from_srgb;

/// The least width of facets, below which the models have none.
const LEAST_ALPHA: f32 = 1e-3;

/// The roughness and the share `anisotropic` of `principled` for the roughness and the strength of
/// KHR_materials_anisotropy, 0 to 1.
///
/// The extension widens the facets along the tangent, from alpha to mix(alpha, 1, strength^2); `principled` widens them
/// along it and narrows them across, by 1 / aspect and aspect = sqrt(1 - 0.9 anisotropic). Facets are at most ten times
/// as wide along the tangent as across it.
pub(super) fn stretched(roughness: f32, strength: f32) -> [f32; 2] {
    let across = (roughness * roughness).clamp(LEAST_ALPHA, 1.0);
    let along = across + (1.0 - across) * strength * strength;
    let anisotropic = (1.0 - across / along) / 0.9;
    [(along * across).sqrt().sqrt(), anisotropic.clamp(0.0, 1.0)]
}

/// A parameter of stretched facets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Stretch {
    /// The roughness between the two directions.
    Roughness,
    /// The share by which facets are stretched.
    Anisotropic,
}

/// The images from which the facets of an anisotropic material come. Green of the first is a factor on the roughness,
/// and blue of the second a factor on the strength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum StretchImages {
    /// The picture is that of the roughness.
    Roughness,
    /// The picture is that of the strength.
    Strength,
    /// The picture is that of the roughness, and this one that of the strength.
    Both(usize),
}

impl Stretch {
    /// The parameter of a texel.
    pub fn of(self, images: StretchImages, [roughness, strength]: [f32; 2], first: [f32; 4], second: [f32; 4]) -> f32 {
        let (roughness, strength) = match images {
            StretchImages::Roughness => (roughness * first[1], strength),
            StretchImages::Strength => (roughness, strength * first[2]),
            StretchImages::Both(_) => (roughness * first[1], strength * second[2]),
        };
        let [roughness, anisotropic] = stretched(roughness, strength);
        match self {
            Self::Roughness => roughness,
            Self::Anisotropic => anisotropic,
        }
    }
}

/// The colour and the metallic of a texel of specular-glossiness: `first` of the specular picture, `second` of the
/// diffuse one. The factors are linear.
pub(super) fn from_specular(diffuse: Vec3, specular: Vec3, first: [f32; 4], second: [f32; 4]) -> (Vec3, f32) {
    let linear = |[r, g, b, _]: [f32; 4]| Vec3::new(r, g, b).map(linear_from_srgb);
    metallic_look(diffuse * linear(second), specular * linear(first))
}

/// Numbers made of the texels of two images, in the size of the one with more pixels. Without a second image its texels
/// are 1.
pub(super) fn combined<const N: usize>(
    first: &DynamicImage,
    second: Option<&DynamicImage>,
    made: impl Fn([f32; 4], [f32; 4]) -> [f32; N],
) -> (u32, u32, Vec<f32>) {
    let one = first.to_rgba32f();
    let other = second.map(DynamicImage::to_rgba32f);
    // The larger width and the larger height together may be far too many pixels, for which no memory is reserved.
    let pixels = |(width, height): (u32, u32)| u64::from(width) * u64::from(height);
    let (width, height) = match &other {
        Some(other) if pixels(other.dimensions()) > pixels(one.dimensions()) => other.dimensions(),
        _ => one.dimensions(),
    };
    // The corresponding texel of an image of another size.
    let place = |at: u32, of: u32, size: u32| (u64::from(at) * u64::from(size) / u64::from(of.max(1))) as u32;
    let texel = |image: &image::Rgba32FImage, x: u32, y: u32| {
        let (across, down) = (place(x, width, image.width()), place(y, height, image.height()));
        image.get_pixel(across, down).0
    };
    let mut numbers = Vec::with_capacity(N * pixels((width, height)) as usize);
    for y in 0..height {
        for x in 0..width {
            let second = other.as_ref().map_or([1.0; 4], |other| texel(other, x, y));
            numbers.extend(made(texel(&one, x, y), second));
        }
    }
    (width, height, numbers)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn facets_have_the_widths_of_the_extension() {
        for (roughness, strength) in [(0.5f32, 0.0f32), (0.5, 0.5), (0.7, 1.0), (0.4, 0.3)] {
            let [middle, anisotropic] = stretched(roughness, strength);
            let aspect = (1.0 - 0.9 * anisotropic).sqrt();
            let across = roughness * roughness;
            let along = across + (1.0 - across) * strength * strength;
            let alpha = middle * middle;
            assert!((alpha / aspect - along).abs() < 1e-5, "{roughness} {strength}");
            assert!((alpha * aspect - across).abs() < 1e-5, "{roughness} {strength}");
        }
        // The models have no facets that are stretched more than tenfold.
        assert_eq!(stretched(0.1, 1.0)[1], 1.0);
        assert!(stretched(0.0, 1.0).iter().all(|number| number.is_finite()));
    }
}
