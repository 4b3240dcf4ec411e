//! The denoiser's input, copied from the film over several frames if the film is large.

use std::num::NonZeroUsize;
use std::time::{Duration, Instant};

use bevy::math::Vec3;

use super::denoiser::Care;
use crate::color::Rgb;
use crate::engine::RenderFilm;
use crate::render::denoise::{DenoiseInput, DenoiseQuality};
use crate::render::film::Film;

/// The time per frame for copying the film.
const LONGEST: Duration = Duration::from_millis(6);

/// The colours and the features of a film; those of all pixels once it is complete. Later pixels may have more samples
/// than earlier ones, which does not matter, since pixels are means.
pub(super) struct FilmCopy {
    pub job: u64,
    pub mix: Vec<Rgb>,
    pub care: Care,
    /// The least samples of any pixel.
    pub samples: u32,
    size: [u32; 2],
    color: Vec<Rgb>,
    albedo: Vec<Rgb>,
    normal: Vec<Vec3>,
}

impl FilmCopy {
    pub fn begin(film: &RenderFilm, mix: Vec<Rgb>, care: Care) -> Self {
        let size = [film.film.width(), film.film.height()];
        let pixels = size[0] as usize * size[1] as usize;
        Self {
            job: film.job,
            mix,
            care,
            samples: film.samples,
            size,
            color: Vec::with_capacity(pixels),
            albedo: Vec::with_capacity(pixels),
            normal: Vec::with_capacity(pixels),
        }
    }

    /// Copies rows within the time of a frame; returns true once all are copied.
    pub fn step(&mut self, film: &Film) -> bool {
        let begun = Instant::now();
        let [width, height] = self.size;
        let mut row = (self.color.len() / width.max(1) as usize) as u32;
        while row < height && begun.elapsed() < LONGEST {
            for x in 0..width {
                let pixel = film.pixel(x, row).unwrap_or_default();
                let color = match self.mix.is_empty() {
                    true => pixel.radiance,
                    false => film.mixed_pixel(x, row, &self.mix).unwrap_or_default(),
                };
                self.color.push(color);
                self.albedo.push(pixel.albedo);
                self.normal.push(pixel.normal);
            }
            row += 1;
        }
        row >= height
    }

    /// The input of the filter, once all is copied.
    pub fn input(&self, threads: NonZeroUsize) -> DenoiseInput<'_> {
        let (prefilter, quality) = match self.care {
            Care::Quick => (false, DenoiseQuality::Fast),
            Care::Careful => (true, DenoiseQuality::High),
        };
        DenoiseInput {
            width: self.size[0],
            height: self.size[1],
            color: &self.color,
            albedo: Some(&self.albedo),
            normal: Some(&self.normal),
            prefilter,
            quality,
            threads: Some(threads.get()),
        }
    }
}
