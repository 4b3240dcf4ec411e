//! The picture that is carried over.

use glam::{UVec2, Vec2};
use rayon::prelude::*;

use super::{Clean, Light, WORTH_OF_DENOISED, place_of};
use crate::color::luminance;
use crate::render::camera::Camera;
use crate::render::film::Film;
use crate::render::gbuffer::{Texel, TileGBuffer, middle_ray};

/// A picture as it was shown, with what tells where its light belongs.
#[derive(Debug)]
pub struct Earlier {
    /// The camera, with everything in focus.
    pub(super) camera: Camera,
    /// Pixels.
    pub(super) size: UVec2,
    /// What the pixels show, row by row.
    pub(super) texels: Vec<Texel>,
    pub(super) light: Vec<Light>,
    /// How far the rays of neighbouring pixels are apart at their origins, and how much they part on the way.
    spacing: [f32; 2],
}

impl Earlier {
    pub(super) fn new(camera: Camera, size: UVec2, texels: Vec<Texel>, light: Vec<Light>) -> Self {
        let ray = |x| middle_ray(&camera, size.as_vec2(), x, size.y / 2);
        let (one, other) = (ray(size.x / 2), ray(size.x / 2 + 1));
        Self {
            camera,
            size,
            texels,
            light,
            spacing: [
                one.origin.distance(other.origin),
                one.dir.normalize().distance(other.dir.normalize()),
            ],
        }
    }

    /// A picture of which nothing was carried over: the film, or the denoised picture, with the G-buffer of all its tiles. None unless that
    /// is whole.
    pub fn of_film(camera: &Camera, film: &Film, clean: Option<Clean>, gbuffer: &[TileGBuffer]) -> Option<Self> {
        let size = UVec2::new(film.width(), film.height());
        let pixels = size.x as usize * size.y as usize;
        let (mut texels, mut found) = (vec![Texel::nothing(); pixels], 0);
        for tile in gbuffer {
            for ((x, y), &texel) in super::pixels_of(tile.tile).zip(&tile.texels) {
                *texels.get_mut(place_of(size, x, y))? = texel;
                found += 1;
            }
        }
        if found != pixels {
            return None;
        }
        let light = texels.par_iter().enumerate().map(|(place, texel)| {
            let pixel = UVec2::new(place as u32 % size.x, place as u32 / size.x);
            radiance_of(film, clean, place, pixel).unwrap_or_default().on(texel)
        });
        let light = light.collect();
        Some(Self::new(camera.sharp(), size, texels, light))
    }

    /// The memory of a picture of so many pixels in bytes.
    pub fn bytes(pixels: u64) -> u64 {
        pixels * (size_of::<Texel>() + size_of::<Light>()) as u64
    }

    /// The pixel around a place of the film; the nearest one for places outside.
    pub(super) fn pixel_at(&self, film: Vec2) -> usize {
        let pixel = (film * self.size.as_vec2()).clamp(Vec2::ZERO, self.size.as_vec2() - 1.0);
        place_of(self.size, pixel.x as u32, pixel.y as u32)
    }

    /// The distance between what neighbouring pixels show of a surface at this distance that is seen from the front.
    pub(super) fn spacing(&self, distance: f32) -> f32 {
        self.spacing[0] + self.spacing[1] * distance
    }
}

/// What the samples of a pixel tell, as radiance; None if it has none.
pub(super) fn radiance_of(film: &Film, clean: Option<Clean>, place: usize, pixel: UVec2) -> Option<Light> {
    let samples = film.samples(pixel.x, pixel.y);
    let mean = film.pixel(pixel.x, pixel.y).filter(|_| samples > 0)?;
    let own = luminance(mean.radiance);
    let variance = match samples {
        1 => own * own,
        _ => (mean.luminance_squared - own * own).max(0.0),
    };
    let (light, worth) = match clean {
        Some(clean) => (clean.radiance[place], WORTH_OF_DENOISED * clean.samples as f32),
        None => (mean.radiance, samples as f32),
    };
    Some(Light { light, worth, variance })
}
