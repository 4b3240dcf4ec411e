//! A picture that was denoised.

use rayon::prelude::*;

use crate::color::{Rgb, luminance};
use crate::engine::RenderFilm;
use crate::render::carry::Clean;

/// Is added to radiance before it is divided by.
const LEAST_LIGHT: f32 = 1e-4;

/// A denoised picture, as large as the film it was made from.
pub(crate) struct Denoised {
    pub radiance: Vec<Rgb>,
    /// The factors on the layers of the film that it was made with.
    pub mix: Vec<Rgb>,
    pub seconds: f32,
    /// The samples per pixel that it was made from.
    pub samples: u32,
    /// Tells denoised pictures apart.
    pub number: u64,
    pub job: u64,
    pub is_careful: bool,
    /// Whether lamps have changed since it was made: a fresh one is due.
    pub is_relit: bool,
}

impl Denoised {
    /// The picture as one to which others are compared.
    pub fn clean(&self) -> Clean<'_> {
        Clean {
            radiance: &self.radiance,
            samples: self.samples,
        }
    }

    /// The same picture after lamps have changed: each pixel by what that has made of the pixel of the film, of which
    /// `before` is the light before, row by row. None if the lights are mixed.
    pub fn relit(mut self, film: &RenderFilm, before: &[Rgb], number: u64) -> Option<Self> {
        if !self.mix.is_empty() || before.len() != self.radiance.len() {
            return None;
        }
        let pixels = self.radiance.par_iter_mut().zip(before).enumerate();
        pixels.for_each(|(place, (light, &before))| {
            let (x, y) = (place as u32 % film.film.width(), place as u32 / film.film.width());
            let after = film.film.mixed_pixel(x, y, &[]).unwrap_or_default();
            // Filters of pixels may have made a little of it negative.
            let [before, after] = [before, after].map(|light| light.max(Rgb::ZERO));
            *light = match luminance(before) > 4.0 * LEAST_LIGHT {
                true => *light * ((after + LEAST_LIGHT) / (before + LEAST_LIGHT)),
                // Where it was dark nothing is known of the new light but its samples.
                false => after,
            };
        });
        (self.number, self.job) = (number, film.job);
        (self.is_relit, self.is_careful) = (true, false);
        Some(self)
    }
}
