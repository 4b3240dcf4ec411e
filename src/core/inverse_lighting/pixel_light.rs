//! The light of lamps at some pixels of a picture, which can be replaced lamp by lamp.

use std::collections::HashMap;

use glam::UVec2;

use super::painting::{LampLight, Painting, Seen};
use crate::color::Rgb;

/// The light of lamps at some pixels.
#[derive(Clone, Debug, Default)]
pub struct PixelLight {
    size: [u32; 2],
    /// The radiance.
    pub radiance: Places,
    /// The irradiance on what is seen.
    pub irradiance: Places,
}

/// One quantity at some pixels.
#[derive(Clone, Debug, Default)]
pub struct Places {
    pixels: Vec<UVec2>,
    number: HashMap<UVec2, usize>,
    seen: Vec<Option<Seen>>,
    /// The light of each lamp at a gain of one, pixel by pixel.
    light: Vec<Rgb>,
    lamps: usize,
}

impl PixelLight {
    /// The light of these lamps at the pixels for which a painting wants it, at most `most` of each quantity.
    pub fn of(painting: &Painting, source: &impl LampLight, lamps: usize, most: usize) -> Self {
        let radiance = painting.pixels(false, most);
        let irradiance = painting.pixels(true, most);
        Self {
            size: source.size(),
            radiance: Places::gather(radiance, lamps, |x, y, light| source.at(x, y, light)),
            irradiance: Places::gather(irradiance, lamps, |x, y, light| source.irradiance_at(x, y, light)),
        }
    }
}

impl Places {
    /// The light at these pixels. `at` works as [`LampLight::at`] does.
    pub fn gather(pixels: Vec<UVec2>, lamps: usize, at: impl Fn(u32, u32, &mut [Rgb]) -> Option<Seen>) -> Self {
        let mut light = vec![Rgb::ZERO; pixels.len() * lamps];
        let mut rest = &mut light[..];
        let mut seen = Vec::with_capacity(pixels.len());
        for pixel in &pixels {
            let (own, others) = rest.split_at_mut(lamps);
            seen.push(at(pixel.x, pixel.y, own));
            rest = others;
        }
        Self {
            number: pixels.iter().copied().zip(0..).collect(),
            pixels,
            seen,
            light,
            lamps,
        }
    }

    /// The pixels.
    pub fn pixels(&self) -> &[UVec2] {
        &self.pixels
    }

    /// Replaces the light of a lamp, pixel by pixel. What is wanted refers to the light of before.
    pub fn set_light(&mut self, lamp: usize, light: &[Option<Rgb>]) {
        for (own, light) in self.light.iter_mut().skip(lamp).step_by(self.lamps.max(1)).zip(light) {
            *own = light.unwrap_or(Rgb::ZERO);
        }
    }

    /// The same light as [`LampLight::at`] gives; None for other pixels.
    pub fn at(&self, x: u32, y: u32, light: &mut [Rgb]) -> Option<Seen> {
        let number = *self.number.get(&UVec2::new(x, y))?;
        let seen = self.seen[number]?;
        light.copy_from_slice(&self.light[number * self.lamps..][..self.lamps]);
        Some(seen)
    }
}

impl LampLight for PixelLight {
    fn size(&self) -> [u32; 2] {
        self.size
    }

    fn at(&self, x: u32, y: u32, light: &mut [Rgb]) -> Option<Seen> {
        self.radiance.at(x, y, light)
    }

    fn irradiance_at(&self, x: u32, y: u32, light: &mut [Rgb]) -> Option<Seen> {
        self.irradiance.at(x, y, light)
    }
}
