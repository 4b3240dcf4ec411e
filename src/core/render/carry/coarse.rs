//! A readable picture from few samples: the denoised preview, enlarged along the edges of the G-buffer (joint bilateral
//! upsampling: Kopf et al., SIGGRAPH 2007).

use std::sync::atomic::{AtomicBool, Ordering};

use glam::{UVec2, Vec3};
use rayon::prelude::*;

use super::{LEAST_ALBEDO, divisor, place_of};
use crate::color::Rgb;
use crate::render::denoise::{DenoiseError, DenoiseInput, DenoiseQuality, denoise};
use crate::render::film::Film;
use crate::render::gbuffer::Texel;

/// The edge in pixels of a coarse block, as of the previews: a whole number of them fits a tile.
const STEP: u32 = 4;
/// The power of the cosine between the normals by which blocks are weighted for a pixel.
const NORMALS: i32 = 8;
/// The relative difference of distances at which the weight of a block is below one half.
const DISTANCES: f32 = 0.05;
/// The weight of blocks that show another surface.
const LEAST: f32 = 1e-4;

/// Colours and features of the blocks of a picture, and the G-buffer of its pixels.
#[derive(Debug)]
pub struct Coarse {
    size: UVec2,
    texels: Vec<Texel>,
    /// The blocks in a row, and the rows.
    blocks: UVec2,
    radiance: Vec<Rgb>,
    albedo: Vec<Rgb>,
    normal: Vec<Vec3>,
}

impl Coarse {
    /// The film's picture at the centre of each block, with the texel of each pixel. None if a block has no preview.
    pub(super) fn of(film: &Film, texel: impl Fn(u32, u32) -> Option<Texel>) -> Option<Self> {
        let size = UVec2::new(film.width(), film.height());
        let blocks = UVec2::new(size.x.div_ceil(STEP), size.y.div_ceil(STEP));
        let count = blocks.element_product() as usize;
        let mut coarse = Self {
            size,
            texels: Vec::new(),
            blocks,
            radiance: Vec::with_capacity(count),
            albedo: Vec::with_capacity(count),
            normal: Vec::with_capacity(count),
        };
        for (x, y) in (0..blocks.y).flat_map(|y| (0..blocks.x).map(move |x| (x, y))) {
            let [x, y] = coarse.middle_of(x, y);
            let pixel = film.pixel(x, y)?;
            coarse.radiance.push(pixel.radiance);
            coarse.albedo.push(pixel.albedo);
            coarse.normal.push(pixel.normal);
        }
        let pixels = (0..size.y).flat_map(|y| (0..size.x).map(move |x| (x, y)));
        coarse.texels = pixels.map(|(x, y)| texel(x, y)).collect::<Option<_>>()?;
        Some(coarse)
    }

    /// The pixel at the centre of a block.
    fn middle_of(&self, x: u32, y: u32) -> [u32; 2] {
        [
            (STEP * x + STEP / 2).min(self.size.x - 1),
            (STEP * y + STEP / 2).min(self.size.y - 1),
        ]
    }

    /// Filters the blocks and enlarges them: the radiance of every pixel, row by row, divided by its albedo. `cancel`
    /// and `threads` are as for [`denoise`].
    pub fn enlarge(&self, threads: usize, cancel: &AtomicBool) -> Result<Vec<Rgb>, DenoiseError> {
        let input = DenoiseInput {
            width: self.blocks.x,
            height: self.blocks.y,
            color: &self.radiance,
            albedo: Some(&self.albedo),
            normal: Some(&self.normal),
            prefilter: false,
            quality: DenoiseQuality::Fast,
            threads: Some(threads),
        };
        let filtered = denoise(&input, cancel)?;
        let divided = filtered.iter().zip(&self.albedo);
        let light: Vec<Rgb> = divided
            .map(|(&light, &albedo)| light / (albedo + LEAST_ALBEDO))
            .collect();
        let rows = (0..self.size.y).into_par_iter().flat_map_iter(|y| {
            let width = if cancel.load(Ordering::Relaxed) { 0 } else { self.size.x };
            let light = &light;
            (0..width).map(move |x| self.light_of(light, x, y))
        });
        let enlarged: Vec<Rgb> = rows.collect();
        match enlarged.len() == self.texels.len() {
            true => Ok(enlarged),
            false => Err(DenoiseError::Cancelled),
        }
    }

    /// The light of the blocks around a pixel, weighted by their similarity to its surface.
    fn light_of(&self, light: &[Rgb], x: u32, y: u32) -> Rgb {
        let texel = &self.texels[place_of(self.size, x, y)];
        let last = self.blocks.as_ivec2() - 1;
        // The block to the left and above, by the centres.
        let corner = |at: u32| (at as i32 - (STEP / 2) as i32).div_euclid(STEP as i32);
        let (mut sum, mut weights) = (Rgb::ZERO, 0.0);
        // Distant blocks have little weight, and serve pixels whose nearest blocks all show other surfaces.
        for step_y in -1..=2 {
            let row = (corner(y) + step_y).clamp(0, last.y) as u32;
            for step_x in -1..=2 {
                let column = (corner(x) + step_x).clamp(0, last.x) as u32;
                let [middle_x, middle_y] = self.middle_of(column, row);
                let beside = &self.texels[place_of(self.size, middle_x, middle_y)];
                let apart = [middle_x.abs_diff(x), middle_y.abs_diff(y)].map(|apart| (apart * apart) as f32);
                let near = 1.0 / (1.0 + (apart[0] + apart[1]) / (STEP * STEP) as f32).powi(3);
                let weight = near * likeness(texel, beside);
                sum += light[(row * self.blocks.x + column) as usize] * weight;
                weights += weight;
            }
        }
        sum / weights
    }
}

/// How likely two pixels show the same surface, in (0, 1].
fn likeness(a: &Texel, b: &Texel) -> f32 {
    if a.is_specular != b.is_specular || a.is_surface() != b.is_surface() {
        return LEAST;
    }
    if !a.is_surface() {
        return 1.0;
    }
    let facing = a.normal().dot(b.normal()).clamp(0.0, 1.0).powi(NORMALS);
    let apart = (a.distance - b.distance) / (DISTANCES * a.distance);
    let contrast = (divisor(a) - divisor(b)).abs().max_element();
    LEAST + facing / (1.0 + apart * apart) / (1.0 + 4.0 * contrast)
}
