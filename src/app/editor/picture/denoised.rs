//! A denoised picture, and its update when lamps change.

use rayon::prelude::*;

use crate::color::{Rgb, luminance};
use crate::engine::RenderFilm;
use crate::render::carry::Clean;

/// The offset of divisors, so that dark pixels are not divided by zero.
const LEAST_LIGHT: f32 = 1e-4;

/// A denoised picture, as large as the film it was made from.
pub(crate) struct Denoised {
    pub radiance: Vec<Rgb>,
    /// The factors on the layers of the film when it was made.
    pub mix: Vec<Rgb>,
    pub seconds: f32,
    /// The samples per pixel that it was made from.
    pub samples: u32,
    /// The number that tells denoised pictures apart.
    pub number: u64,
    pub job: u64,
    pub is_careful: bool,
    /// Whether lamps have changed since it was made: a fresh one is due.
    pub is_relit: bool,
}

impl Denoised {
    /// The picture as a reference for comparisons.
    pub fn clean(&self) -> Clean<'_> {
        Clean {
            radiance: &self.radiance,
            samples: self.samples,
        }
    }

    /// The picture after lamps have changed: each pixel is scaled by the ratio of the film's new light to its old
    /// light, `before`, row by row. None if the lights are mixed.
    pub fn relit(mut self, film: &RenderFilm, before: &[Rgb], number: u64) -> Option<Self> {
        if !self.mix.is_empty() || before.len() != self.radiance.len() {
            return None;
        }
        let pixels = self.radiance.par_iter_mut().zip(before).enumerate();
        pixels.for_each(|(place, (light, &before))| {
            let (x, y) = (place as u32 % film.film.width(), place as u32 / film.film.width());
            let after = film.film.mixed_pixel(x, y, &[]).unwrap_or_default();
            // Reconstruction filters may have made a little of it negative.
            let [before, after] = [before, after].map(|light| light.max(Rgb::ZERO));
            *light = match luminance(before) > 4.0 * LEAST_LIGHT {
                true => *light * ((after + LEAST_LIGHT) / (before + LEAST_LIGHT)),
                // Where it was dark only the new samples tell the light.
                false => after,
            };
        });
        (self.number, self.job) = (number, film.job);
        (self.is_relit, self.is_careful) = (true, false);
        Some(self)
    }
}
