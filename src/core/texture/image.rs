//! A picture in memory, as compact as its file: 8-bit samples stay 8-bit and are decoded at each lookup.
//!
//! Rows go from the top down. Alpha is dropped: no texture of the format uses it.

use std::sync::{LazyLock, OnceLock};

use exr::prelude::f16;
use glam::DVec3;

use crate::color::{BRIGHTEST, Rgb, linear_from_srgb, linear_from_srgb8};
use crate::memory::{self, Held, Reservation, Shortage};
use crate::sampling::PiecewiseBilinear2d;

/// Samples row by row from the top left, with the channels of a pixel adjacent. Integers stand for [0, 1].
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// Eight bits.
    U8(Vec<u8>),
    /// Sixteen bits.
    U16(Vec<u16>),
    /// Half precision, finite.
    F16(Vec<f16>),
    /// Single precision, finite.
    F32(Vec<f32>),
}

impl Samples {
    fn len(&self) -> usize {
        match self {
            Self::U8(samples) => samples.len(),
            Self::U16(samples) => samples.len(),
            Self::F16(samples) => samples.len(),
            Self::F32(samples) => samples.len(),
        }
    }
}

/// The transfer function from samples to light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transfer {
    /// Samples are proportional to light.
    Linear,
    /// sRGB; only integers are stored so.
    Srgb,
}

/// Bytes per pixel of the tables by which an environment is sampled. Nearly all pictures of floats are environments, so
/// these bytes are reserved together with such a picture; those for other pictures are reserved when the tables are
/// built.
pub(super) const ENVIRONMENT_BYTES: u64 = PiecewiseBilinear2d::BYTES_PER_NODE;

/// A picture of one channel (grey) or three (Rec. 709), at least one pixel large.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    width: u32,
    height: u32,
    channels: usize,
    samples: Samples,
    transfer: Transfer,
    not_finite: usize,
    /// The means of the linear and of the raw values, computed at the first use.
    means: [OnceLock<Rgb>; 2],
    memory: Held,
}

impl Image {
    /// `None` unless there are 1 or 3 channels, at least one pixel, and as many samples as the size needs. Infinite and
    /// NaN samples become 0: a single such pixel would spoil every average, and the sampling of a light by it.
    pub fn new(width: u32, height: u32, channels: usize, mut samples: Samples, transfer: Transfer) -> Option<Self> {
        let wanted = (width as usize).checked_mul(height as usize)?.checked_mul(channels)?;
        if !(matches!(channels, 1 | 3) && wanted > 0 && wanted == samples.len()) {
            return None;
        }
        let not_finite = match &mut samples {
            Samples::U8(_) | Samples::U16(_) => 0,
            Samples::F16(samples) => replace(samples, channels, |sample| (!sample.is_finite()).then_some(f16::ZERO)),
            Samples::F32(samples) => replace(samples, channels, |sample| (!sample.is_finite()).then_some(0.0)),
        };
        Some(Self {
            width,
            height,
            channels,
            samples,
            transfer,
            not_finite,
            means: Default::default(),
            memory: Held::default(),
        })
    }

    /// The picture, which keeps its memory reserved.
    pub(super) fn holding(mut self, memory: Reservation) -> Self {
        self.memory = memory.into();
        self
    }

    /// Memory of the samples in bytes, and of the tables for floats as an environment.
    pub(super) fn memory_bytes(&self) -> u64 {
        let count = self.samples.len() as u64;
        let pixels = count / self.channels as u64;
        match &self.samples {
            Samples::U8(_) => count,
            Samples::U16(_) => 2 * count,
            Samples::F16(_) => 2 * count + ENVIRONMENT_BYTES * pixels,
            Samples::F32(_) => 4 * count + ENVIRONMENT_BYTES * pixels,
        }
    }

    /// Reserves memory for the tables by which the picture is sampled as an environment, unless it is a part of the
    /// picture's own reservation.
    pub fn reserve_environment(&self) -> Result<Held, Shortage> {
        match &self.samples {
            Samples::F16(_) | Samples::F32(_) => Ok(self.memory.clone()),
            Samples::U8(_) | Samples::U16(_) => {
                let pixels = u64::from(self.width) * u64::from(self.height);
                memory::reserve(ENVIRONMENT_BYTES.saturating_mul(pixels)).map(Held::from)
            }
        }
    }

    /// A single pixel of a linear value.
    pub fn uniform(value: f32) -> Self {
        Self {
            width: 1,
            height: 1,
            channels: 1,
            samples: Samples::F32(vec![value]),
            transfer: Transfer::Linear,
            not_finite: 0,
            means: Default::default(),
            memory: Held::default(),
        }
    }

    /// The number of pixels with an infinite or NaN channel, which is 0 here.
    pub fn not_finite(&self) -> usize {
        self.not_finite
    }

    /// Clamps channels to [`BRIGHTEST`] and its negative, and returns the number of pixels that changed.
    pub fn limit(&mut self) -> usize {
        let limited = |sample: f32| (sample.abs() > BRIGHTEST).then(|| BRIGHTEST.copysign(sample));
        match &mut self.samples {
            // These formats have no numbers as large.
            Samples::U8(_) | Samples::U16(_) | Samples::F16(_) => 0,
            Samples::F32(samples) => replace(samples, self.channels, limited),
        }
    }

    /// The number of pixels with a negative channel, which only pictures of floats can have.
    pub fn negative_pixels(&self) -> usize {
        fn count<T>(samples: &[T], channels: usize, is_negative: impl Fn(&T) -> bool) -> usize {
            let pixels = samples.chunks_exact(channels);
            pixels.filter(|pixel| pixel.iter().any(&is_negative)).count()
        }
        match &self.samples {
            Samples::U8(_) | Samples::U16(_) => 0,
            Samples::F16(samples) => count(samples, self.channels, |sample| *sample < f16::ZERO),
            Samples::F32(samples) => count(samples, self.channels, |sample| *sample < 0.0),
        }
    }

    /// Pixels in a row, at least 1.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Number of rows, at least 1.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The transfer function of the samples.
    pub fn transfer(&self) -> Transfer {
        self.transfer
    }

    /// The number of channels, 1 or 3.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// Linear colour of the pixel in column `x` from the left and row `y` from the top, both within the picture.
    pub fn pixel(&self, x: u32, y: u32) -> Rgb {
        self.texel(x, y, false)
    }

    /// [`Self::pixel`]; `raw` skips the decoding to linear.
    pub(super) fn texel(&self, x: u32, y: u32, raw: bool) -> Rgb {
        let first = (y as usize * self.width as usize + x as usize) * self.channels;
        let decoded = self.transfer == Transfer::Srgb && !raw;
        match &self.samples {
            Samples::U8(samples) if decoded => self.color(&samples[first..], linear_from_srgb8),
            Samples::U8(samples) => self.color(&samples[first..], |value| f32::from(value) / 255.0),
            Samples::U16(samples) if decoded => {
                self.color(&samples[first..], |value| LINEAR_FROM_16_BITS[usize::from(value)])
            }
            Samples::U16(samples) => self.color(&samples[first..], |value| f32::from(value) / 65_535.0),
            Samples::F16(samples) => self.color(&samples[first..], f16::to_f32),
            Samples::F32(samples) => self.color(&samples[first..], |value| value),
        }
    }

    /// The colour of the pixel whose samples come first.
    #[inline(always)]
    fn color<T: Copy>(&self, samples: &[T], value: impl Fn(T) -> f32) -> Rgb {
        match self.channels {
            1 => Rgb::splat(value(samples[0])),
            _ => Rgb::new(value(samples[0]), value(samples[1]), value(samples[2])),
        }
    }

    /// Average colour over all pixels; computed at the first call.
    pub fn mean(&self, raw: bool) -> Rgb {
        *self.means[usize::from(raw)].get_or_init(|| {
            let row = |y| (0..self.width).map(move |x| self.texel(x, y, raw).as_dvec3());
            let sum: DVec3 = (0..self.height).flat_map(row).sum();
            (sum / (f64::from(self.width) * f64::from(self.height))).as_vec3()
        })
    }

    /// Memory held by the samples, in bytes.
    pub fn heap_bytes(&self) -> usize {
        match &self.samples {
            Samples::U8(samples) => samples.capacity(),
            Samples::U16(samples) => 2 * samples.capacity(),
            Samples::F16(samples) => 2 * samples.capacity(),
            Samples::F32(samples) => 4 * samples.capacity(),
        }
    }
}

/// Replaces samples by the value of `other`, and returns the number of pixels in which it gave one.
fn replace<T: Copy>(samples: &mut [T], channels: usize, other: impl Fn(T) -> Option<T>) -> usize {
    let mut pixels = 0;
    for pixel in samples.chunks_exact_mut(channels) {
        let mut is_changed = false;
        for sample in pixel {
            if let Some(other) = other(*sample) {
                (*sample, is_changed) = (other, true);
            }
        }
        pixels += usize::from(is_changed);
    }
    pixels
}

/// These are too many values to compute each time, and 16-bit pictures are not rare.
static LINEAR_FROM_16_BITS: LazyLock<Box<[f32]>> = LazyLock::new(|| {
    (0..=u16::MAX)
        .map(|code| linear_from_srgb(f32::from(code) / 65_535.0))
        .collect()
});

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_must_fit() {
        let image = |width, height, channels, samples| {
            Image::new(width, height, channels, Samples::U8(vec![7; samples]), Transfer::Linear)
        };
        assert!(image(2, 3, 1, 6).is_some());
        assert!(image(2, 3, 3, 18).is_some());
        assert!(image(2, 3, 2, 12).is_none());
        assert!(image(2, 3, 1, 5).is_none());
        assert!(image(0, 3, 1, 0).is_none());
        assert!(image(u32::MAX, u32::MAX, 3, 5).is_none());
    }

    #[test]
    fn samples_become_light() {
        // IEC 61966-2-1: 188/255 is 0.5029 linear; 10/255 lies on the straight piece.
        let eight = Image::new(2, 1, 1, Samples::U8(vec![188, 10]), Transfer::Srgb).unwrap();
        assert!((eight.pixel(0, 0) - 0.502_886).abs().max_element() < 1e-5);
        assert!((eight.pixel(1, 0) - 10.0 / 255.0 / 12.92).abs().max_element() < 1e-7);
        assert_eq!(eight.texel(0, 0, true), Rgb::splat(188.0 / 255.0));

        let sixteen = Image::new(1, 1, 3, Samples::U16(vec![0, 257 * 188, 65_535]), Transfer::Srgb).unwrap();
        let expected = Rgb::new(0.0, 0.502_886, 1.0);
        assert!((sixteen.pixel(0, 0) - expected).abs().max_element() < 1e-5);

        let half = Image::new(1, 1, 1, Samples::F16(vec![f16::from_f32(65_504.0)]), Transfer::Linear);
        assert_eq!(half.unwrap().pixel(0, 0), Rgb::splat(65_504.0));
    }

    #[test]
    fn what_is_no_number_is_black() {
        let samples = vec![f32::NAN, 2.0, f32::NEG_INFINITY, f32::INFINITY, 4.0, 6.0];
        let image = Image::new(2, 1, 3, Samples::F32(samples), Transfer::Linear).unwrap();
        assert_eq!(image.pixel(0, 0), Rgb::new(0.0, 2.0, 0.0));
        assert_eq!(image.mean(false), Rgb::new(0.0, 3.0, 3.0));
        assert_eq!(image.not_finite(), 2);
        let half = Image::new(1, 1, 1, Samples::F16(vec![f16::INFINITY]), Transfer::Linear);
        assert_eq!(half.unwrap().pixel(0, 0), Rgb::ZERO);
    }

    #[test]
    fn what_is_too_large_is_limited() {
        let samples = vec![3e38, 1.0, -1e20, 1e12, -1e12, 0.0];
        let mut image = Image::new(2, 1, 3, Samples::F32(samples), Transfer::Linear).unwrap();
        assert_eq!((image.not_finite(), image.limit()), (0, 1));
        assert_eq!(image.pixel(0, 0), Rgb::new(BRIGHTEST, 1.0, -BRIGHTEST));
        assert_eq!(
            (image.pixel(1, 0), image.limit()),
            (Rgb::new(BRIGHTEST, -BRIGHTEST, 0.0), 0)
        );
    }

    #[test]
    fn means_are_of_what_is_seen() {
        let image = Image::new(2, 1, 3, Samples::U8(vec![0, 255, 10, 255, 255, 10]), Transfer::Srgb).unwrap();
        let dark = 10.0 / 255.0;
        assert!(
            (image.mean(false) - Rgb::new(0.5, 1.0, dark / 12.92))
                .abs()
                .max_element()
                < 1e-6
        );
        assert!((image.mean(true) - Rgb::new(0.5, 1.0, dark)).abs().max_element() < 1e-6);
        assert_eq!(image.heap_bytes(), 6);
    }
}
