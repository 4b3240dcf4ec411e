//! Denoises a picture with Intel Open Image Denoise (OIDN), on the CPU.
//!
//! This is the program's whole interface to the library; the foreign calls are in `denoise/ffi.rs`. Without the cargo
//! feature `denoise` the interface remains, and [`denoise`] returns [`DenoiseError::NotBuilt`].
//!
//! Source: the API documentation of Open Image Denoise 2, sections "Filters, RT" and "RTLightmap".

#[cfg(feature = "denoise")]
mod ffi;
mod request;
mod running;

use std::sync::atomic::AtomicBool;

#[cfg(feature = "denoise")]
use glam::Vec3;

pub use self::request::{DenoiseError, DenoiseInput, DenoiseQuality};
pub use self::running::end_all;
use super::film::Film;
use crate::color::Rgb;

/// The denoised picture, in the order of `color`; all values are finite and not negative.
///
/// `cancel` is polled while the filter runs: it takes some tenths of a second at worst until
/// [`DenoiseError::Cancelled`] is returned. Calls from several threads are independent of each other.
pub fn denoise(input: &DenoiseInput, cancel: &AtomicBool) -> Result<Vec<Rgb>, DenoiseError> {
    input.check()?;
    run(input, false, cancel)
}

/// [`denoise`] in high quality for the radiance of a film, with its features. `threads` is the number for the denoiser;
/// None is one for each core.
pub fn denoise_film(film: &Film, threads: Option<usize>, cancel: &AtomicBool) -> Result<Vec<Rgb>, DenoiseError> {
    let (color, albedo, normal) = (film.radiance(), film.albedo(), film.normal());
    let input = DenoiseInput {
        width: film.width(),
        height: film.height(),
        color: &color,
        albedo: Some(&albedo),
        normal: Some(&normal),
        prefilter: true,
        quality: DenoiseQuality::High,
        threads,
    };
    denoise(&input, cancel)
}

/// A denoised lightmap, from non-negative irradiance row by row; all values are finite and not negative. `threads` and
/// `cancel` as for [`denoise_film`].
pub fn denoise_lightmap(
    width: u32,
    height: u32,
    irradiance: &[Rgb],
    threads: Option<usize>,
    cancel: &AtomicBool,
) -> Result<Vec<Rgb>, DenoiseError> {
    let input = DenoiseInput {
        width,
        height,
        color: irradiance,
        albedo: None,
        normal: None,
        prefilter: false,
        quality: DenoiseQuality::High,
        threads,
    };
    input.check()?;
    run(&input, true, cancel)
}

/// The largest finite component, at least 0. Infinite pixels are replaced by it: with a fixed large number instead, the
/// library would expose for that pixel and lose the rest of the picture.
#[cfg(feature = "denoise")]
fn brightest(color: &[Rgb]) -> f32 {
    let components = color.iter().flat_map(|pixel| pixel.to_array());
    components.filter(|x| x.is_finite()).fold(0.0, f32::max)
}

#[cfg(not(feature = "denoise"))]
fn run(_: &DenoiseInput, _: bool, _: &AtomicBool) -> Result<Vec<Rgb>, DenoiseError> {
    Err(DenoiseError::NotBuilt)
}

#[cfg(feature = "denoise")]
fn run(input: &DenoiseInput, is_lightmap: bool, cancel: &AtomicBool) -> Result<Vec<Rgb>, DenoiseError> {
    use std::sync::atomic::Ordering;

    if input.color.is_empty() {
        return Ok(Vec::new());
    }
    let color = within(input.color, 0.0, brightest(input.color));
    let job = ffi::Job {
        width: input.width as usize,
        height: input.height as usize,
        quality: input.quality,
        cancel,
    };
    // Each call makes a device of its own, which takes about 4 ms, while filtering takes some hundreds. Thus threads
    // share no state, and no memory is held between calls.
    if is_lightmap {
        return ffi::Device::new(input.threads)?.filter_lightmap(&job, &color);
    }
    let mut albedo = input.albedo.map(|albedo| within(albedo, 0.0, 1.0));
    let mut normal = input.normal.map(|normal| within(normal, -1.0, 1.0));
    if cancel.load(Ordering::Relaxed) {
        return Err(DenoiseError::Cancelled);
    }
    let device = ffi::Device::new(input.threads)?;
    if input.prefilter {
        for (slot, image) in [
            (ffi::Auxiliary::Albedo, &mut albedo),
            (ffi::Auxiliary::Normal, &mut normal),
        ] {
            if let Some(image) = image {
                *image = device.filter_auxiliary(&job, slot, image)?.into();
            }
        }
    }
    device.filter_color(&job, &color, albedo.as_deref(), normal.as_deref(), input.prefilter)
}

/// The pixels clamped to a range, with NaN as the number nearest to 0 in it. Copies only if needed.
#[cfg(feature = "denoise")]
fn within(pixels: &[Vec3], low: f32, high: f32) -> std::borrow::Cow<'_, [Vec3]> {
    let inside = |pixel: &Vec3| pixel.to_array().iter().all(|x| (low..=high).contains(x));
    if pixels.iter().all(inside) {
        return pixels.into();
    }
    let repaired = |x: f32| if x.is_nan() { 0.0 } else { x.clamp(low, high) };
    pixels
        .iter()
        .map(|pixel| pixel.map(repaired))
        .collect::<Vec<_>>()
        .into()
}
