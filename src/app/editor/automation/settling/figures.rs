//! Pictures as the window shows them, and their errors against a converged one.

use std::borrow::Cow;
use std::io::Cursor;

use bevy::math::{UVec2, Vec2};
use image::{ExtendedColorType, ImageFormat, ImageResult};
use serde::Serialize;

use crate::app::editor::picture::reframing::{of_film, reframed_rgba};
use crate::color::{Rgb, linear_from_srgb8};
use crate::metrics::errors;
use crate::metrics::flip::{PIXELS_PER_DEGREE, ldr_flip};
use crate::render::view::View;

/// The pixels that the window shows, four sRGB-encoded bytes each, row by row from the top left.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Shot {
    pub size: UVec2,
    pub rgba: Vec<u8>,
}

impl Shot {
    /// The film in a picture of this size: its surroundings have fewer samples.
    pub fn of_film(size: UVec2, rgba: &[u8], film_corners: [Vec2; 2]) -> Self {
        let (size, pixels) = of_film(rgba.as_chunks::<4>().0, (size, film_corners));
        Self {
            size,
            rgba: pixels.into_flattened(),
        }
    }

    /// The linear colours in [0, 1], enlarged to this size as the window does: during motion the picture has fewer
    /// pixels.
    fn linear(&self, size: UVec2) -> Vec<Rgb> {
        let rgba = match self.size == size {
            true => Cow::Borrowed(&self.rgba),
            false => Cow::Owned(reframed_rgba(
                &self.rgba,
                (self.size, View::WHOLE_FILM),
                (size, View::WHOLE_FILM),
            )),
        };
        let color = |pixel: &[u8]| {
            let [r, g, b] = [pixel[0], pixel[1], pixel[2]].map(linear_from_srgb8);
            Rgb::new(r, g, b)
        };
        rgba.chunks_exact(4).map(color).collect()
    }

    /// The content of a PNG file.
    pub fn png(&self) -> ImageResult<Vec<u8>> {
        let opaque = self.rgba.chunks_exact(4).flat_map(|pixel| &pixel[..3]);
        let rgb: Vec<u8> = opaque.copied().collect();
        let mut png = Cursor::new(Vec::new());
        let kind = ExtendedColorType::Rgb8;
        image::write_buffer_with_format(&mut png, &rgb, self.size.x, self.size.y, kind, ImageFormat::Png)?;
        Ok(png.into_inner())
    }
}

/// The error of a shown picture against the converged one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Figures {
    /// The seconds from the command to the picture; None for one from before the command.
    pub seconds: Option<f32>,
    /// The mean of FLIP over the pixels.
    pub flip: f32,
    /// The relative squared error of [`errors`].
    pub relative_error: f32,
    /// The peak signal-to-noise ratio of the encoded bytes in decibels; infinite for equal pictures.
    pub psnr: f32,
}

impl Figures {
    /// Compares two pictures; None if there are no pixels.
    pub fn new(seconds: Option<f32>, shot: &Shot, truth: &Shot) -> Option<Self> {
        let [picture, reference] = [shot, truth].map(|shot| shot.linear(truth.size));
        let errors = errors(&picture, &reference)?;
        let flip = ldr_flip(&picture, &reference, truth.size.x as usize, PIXELS_PER_DEGREE);
        Some(Self {
            seconds,
            flip: mean(&flip),
            relative_error: errors.relative_mse,
            psnr: errors.psnr,
        })
    }

    /// The means; the decibels are those of the mean squared error, so that equal pictures count as well. None for an
    /// empty list.
    pub fn mean(all: &[Self]) -> Option<Self> {
        let of = |figure: fn(&Self) -> f32| mean(&all.iter().map(figure).collect::<Vec<f32>>());
        let seconds: Option<Vec<f32>> = all.iter().map(|figures| figures.seconds).collect();
        (!all.is_empty()).then(|| Self {
            seconds: seconds.map(|seconds| mean(&seconds)),
            flip: of(|figures| figures.flip),
            relative_error: of(|figures| figures.relative_error),
            psnr: -10.0 * of(|figures| 10f32.powf(-0.1 * figures.psnr)).log10(),
        })
    }
}

fn mean(values: &[f32]) -> f32 {
    let sum: f64 = values.iter().copied().map(f64::from).sum();
    (sum / values.len() as f64) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shot(size: [u32; 2], greys: &[u8]) -> Shot {
        Shot {
            size: size.into(),
            rgba: greys.iter().flat_map(|&grey| [grey, grey, grey, 255]).collect(),
        }
    }

    fn figures(shot: &Shot, truth: &Shot) -> Figures {
        Figures::new(None, shot, truth).expect("they have pixels")
    }

    #[test]
    fn equal_pictures_have_no_error() {
        let picture = shot([3, 2], &[0, 20, 100, 200, 254, 255]);
        let found = figures(&picture, &picture);
        assert_eq!(
            (found.flip, found.relative_error, found.psnr),
            (0.0, 0.0, f32::INFINITY)
        );
    }

    /// The expected numbers are worked out by hand.
    #[test]
    fn known_differences_have_their_figures() {
        let [black, white] = [0, 255].map(|grey| shot([4, 4], &[grey; 16]));
        let far = figures(&white, &black);
        assert!(far.flip > 0.9 && far.flip <= 1.0, "{far:?}");
        assert!((far.relative_error - 100.0).abs() < 1e-3, "{far:?}");
        assert!(far.psnr.abs() < 1e-4, "{far:?}");
        // One step of the bytes: 20 log10(255).
        let near = figures(&shot([4, 4], &[101; 16]), &shot([4, 4], &[100; 16]));
        assert!((near.psnr - 48.131).abs() < 0.01, "{near:?}");
        assert!(near.flip > 0.0 && near.flip < 0.1 * far.flip, "{near:?}");
    }

    #[test]
    fn smaller_pictures_are_enlarged_to_the_size_of_the_converged_one() {
        let small = shot([2, 1], &[0, 200]);
        let large = shot([4, 2], &[0, 0, 200, 200, 0, 0, 200, 200]);
        assert_eq!(figures(&small, &large).psnr, f32::INFINITY);
        assert_eq!(figures(&large, &small).psnr, f32::INFINITY);
        let other = shot([4, 2], &[0, 200, 0, 200, 0, 200, 0, 200]);
        assert!(figures(&small, &other).psnr < 20.0);
        assert_eq!(Figures::new(None, &small, &shot([0, 0], &[])), None);
    }

    #[test]
    fn means_are_of_squared_errors() {
        let of = |seconds, psnr| Figures {
            seconds: Some(seconds),
            flip: seconds,
            relative_error: 2.0 * seconds,
            psnr,
        };
        let found = Figures::mean(&[of(0.1, 0.0), of(0.3, f32::INFINITY)]).expect("there are two");
        assert!((found.flip - 0.2).abs() < 1e-6 && (found.relative_error - 0.4).abs() < 1e-6);
        assert!((found.psnr - 3.0103).abs() < 1e-3, "{found:?}");
        let kept = Figures { seconds: None, ..found };
        assert_eq!(Figures::mean(&[found, kept]).and_then(|mean| mean.seconds), None);
        assert_eq!(Figures::mean(&[]), None);
        let same = of(1.0, f32::INFINITY);
        assert_eq!(Figures::mean(&[same, same]).map(|mean| mean.psnr), Some(f32::INFINITY));
    }

    #[test]
    fn a_file_has_the_colours_of_the_window() {
        let picture = shot([2, 1], &[7, 200]);
        let png = picture.png().expect("it can be encoded");
        let read = image::load_from_memory(&png).expect("a picture").to_rgb8();
        assert_eq!(read.dimensions(), (2, 1));
        assert_eq!(read.into_raw(), [7, 7, 7, 200, 200, 200]);
    }
}
