//! Removing the noise of a picture with Intel Open Image Denoise (OIDN), on the CPU.
//!
//! This is the whole of what the program sees of it; the foreign calls are in `denoise/ffi.rs`. Without the cargo feature
//! `denoise` everything here is still there, and [`denoise`] answers [`DenoiseError::NotBuilt`].
//!
//! Source: the API documentation of Open Image Denoise 2, section "Filters, RT".

#[cfg(feature = "denoise")]
mod ffi;

use std::sync::atomic::AtomicBool;

use thiserror::Error;

use crate::color::Rgb;
use glam::Vec3;

/// Time against quality. On a CPU the last two cost about the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DenoiseQuality {
    /// For the moving picture.
    Fast,
    Balanced,
    #[default]
    High,
}

/// A noisy picture, row by row from the top left. All slices are `width * height` long.
#[derive(Clone, Copy, Debug)]
pub struct DenoiseInput<'a> {
    pub width: u32,
    pub height: u32,
    /// Linear radiance, before exposure and tone mapping. Broken numbers are replaced before the filter sees them.
    pub color: &'a [Rgb],
    /// Colour of the first surface that is not a mirror, in [0, 1] per component; 1 for mirrors that are not followed.
    pub albedo: Option<&'a [Rgb]>,
    /// Normal of the same surface in world space, any length up to 1. Only together with `albedo`.
    pub normal: Option<&'a [Vec3]>,
    /// Denoise `albedo` and `normal` on their own first. Better edges wherever they are noisy; up to three times the time.
    pub prefilter: bool,
    pub quality: DenoiseQuality,
    /// `None`: one for each core.
    pub threads: Option<usize>,
}

#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum DenoiseError {
    #[error("this program was built without the denoiser (cargo feature `denoise`)")]
    NotBuilt,
    /// The flag was seen. Not a fault.
    #[error("denoising was cancelled")]
    Cancelled,
    #[error("{what} has {len} pixels, the picture {width} x {height}")]
    WrongSize {
        what: &'static str,
        len: usize,
        width: u32,
        height: u32,
    },
    #[error("the denoiser takes normals only together with albedo")]
    NormalWithoutAlbedo,
    #[error("the denoiser finds no processor that it can run on: {0}")]
    NoDevice(String),
    #[error("the denoiser failed: {0}")]
    Failed(String),
}

/// The picture without noise, in the order of `color`, all of it finite and not negative.
///
/// `cancel` is looked at while the filter runs: from when it is set it takes some tenths of a second at worst until
/// [`DenoiseError::Cancelled`] comes back. Calls from several threads are independent of each other.
pub fn denoise(input: &DenoiseInput, cancel: &AtomicBool) -> Result<Vec<Rgb>, DenoiseError> {
    check(input)?;
    run(input, cancel)
}

fn check(input: &DenoiseInput) -> Result<(), DenoiseError> {
    let (width, height) = (input.width, input.height);
    let images = [
        ("color", Some(input.color)),
        ("albedo", input.albedo),
        ("normal", input.normal),
    ];
    for (what, pixels) in images {
        let len = pixels.map_or(input.color.len(), <[Vec3]>::len);
        if len != width as usize * height as usize {
            return Err(DenoiseError::WrongSize {
                what,
                len,
                width,
                height,
            });
        }
    }
    if input.normal.is_some() && input.albedo.is_none() {
        return Err(DenoiseError::NormalWithoutAlbedo);
    }
    Ok(())
}

#[cfg(not(feature = "denoise"))]
fn run(_: &DenoiseInput, _: &AtomicBool) -> Result<Vec<Rgb>, DenoiseError> {
    Err(DenoiseError::NotBuilt)
}

#[cfg(feature = "denoise")]
fn run(input: &DenoiseInput, cancel: &AtomicBool) -> Result<Vec<Rgb>, DenoiseError> {
    use std::sync::atomic::Ordering;

    if input.color.is_empty() {
        return Ok(Vec::new());
    }
    // An infinite pixel becomes as bright as the brightest other one. With a fixed large number in its place the library
    // would expose for that pixel and lose the rest of the picture.
    let components = input.color.iter().flat_map(|pixel| pixel.to_array());
    let brightest = components.filter(|x| x.is_finite()).fold(0.0, f32::max);
    let color = within(input.color, 0.0, brightest);
    let mut albedo = input.albedo.map(|albedo| within(albedo, 0.0, 1.0));
    let mut normal = input.normal.map(|normal| within(normal, -1.0, 1.0));
    if cancel.load(Ordering::Relaxed) {
        return Err(DenoiseError::Cancelled);
    }

    let job = ffi::Job {
        width: input.width as usize,
        height: input.height as usize,
        quality: input.quality,
        cancel,
    };
    // A device of its own for each call: making one takes about 4 ms, filtering some hundreds. So there is neither state
    // to share between threads nor memory held while nobody denoises.
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

/// The same pixels, with NaN as the number nearest to 0 in the range and all else clamped to it. Copies only if needed.
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
