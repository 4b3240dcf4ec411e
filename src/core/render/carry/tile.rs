//! A tile of a picture that is carried over.

use glam::{UVec2, Vec3};

use super::{LEAST_ALBEDO, Light, Reprojection, divisor, pixels_of, place_of};
use crate::color::{Rgb, luminance};
use crate::render::film::Film;
use crate::render::gbuffer::{Texel, TileGBuffer};
use crate::render::tile::Tile;

/// The worth in samples of the mean light of a tile's preview.
const WORTH_OF_MEAN: f32 = 2.0;
/// The worth in samples of a filtered preview.
const WORTH_OF_COARSE: f32 = 16.0;
/// The largest worth of light next to pixels for which no light was found.
const WORTH_OF_RIM: f32 = 4.0;
/// Light of at most this worth counts as not found: a filtered preview is better.
const LEAST_FOUND: f32 = 3.0;
/// The share of a tile's pixels that counts as much of it.
const MUCH: f32 = 0.1;

/// A tile of a picture: the texels of its pixels, the light carried over to them, and the light they were painted with,
/// row by row.
#[derive(Debug)]
pub struct CarriedTile {
    pub(super) tile: Tile,
    pub(super) texels: Vec<Texel>,
    pub(super) light: Vec<Light>,
    pub(super) shown: Vec<Light>,
    /// Whether it shows the film alone.
    pub(super) is_own: bool,
    /// Whether much of the light that it shows is unreliable.
    pub(super) is_hardly_known: bool,
}

impl CarriedTile {
    /// Locates the pixels of a G-buffer in an earlier picture, if there is one.
    pub fn find(reprojection: Option<&Reprojection>, gbuffer: TileGBuffer) -> Self {
        let pixels = pixels_of(gbuffer.tile).zip(&gbuffer.texels);
        let light: Vec<Light> = match reprojection {
            Some(reprojection) => {
                let found = pixels.map(|((x, y), texel)| reprojection.find(x, y, texel));
                without_rims(found.collect(), gbuffer.tile.width as usize)
            }
            None => vec![Light::default(); gbuffer.texels.len()],
        };
        let mut own = Self {
            tile: gbuffer.tile,
            texels: gbuffer.texels,
            shown: light.clone(),
            light,
            is_own: false,
            is_hardly_known: false,
        };
        own.judge();
        own
    }

    /// Judges how reliable the displayed light is.
    pub fn judge(&mut self) {
        let unknown = self.shown.iter().filter(|shown| shown.worth <= LEAST_FOUND).count();
        self.is_hardly_known = unknown as f32 >= MUCH * self.shown.len() as f32;
    }

    /// Marks that the whole tile has samples and was painted without carried light: from now on it shows the film
    /// alone.
    pub fn end(&mut self) {
        self.is_own = true;
    }

    /// The number of pixels with reliable light.
    pub(super) fn found(&self) -> usize {
        self.light.iter().filter(|light| light.worth > LEAST_FOUND).count()
    }

    /// Where no light is carried over, takes the mean light of the tile's preview, over all surfaces whose normals are
    /// near the same axis. Single samples of a preview would only be noise.
    pub(super) fn take_preview(&mut self, film: &Film) {
        let Some(preview) = film.preview_of(self.tile) else {
            return;
        };
        let mut means = [(Rgb::ZERO, 0.0); DIRECTIONS];
        let columns = self.tile.width.div_ceil(preview.step);
        for (block, pixel) in (0..).zip(&preview.blocks) {
            // A block shows the surface at its centre.
            let middle = preview.step * UVec2::new(block % columns, block / columns) + preview.step / 2;
            let middle = middle.min(UVec2::new(self.tile.width, self.tile.height) - 1);
            let mean = &mut means[direction_of(&self.texels[(middle.y * self.tile.width + middle.x) as usize])];
            *mean = (mean.0 + pixel.radiance / (pixel.albedo + LEAST_ALBEDO), mean.1 + 1.0);
        }
        for (light, texel) in self.light.iter_mut().zip(&self.texels) {
            let (sum, count) = means[direction_of(texel)];
            if light.worth <= WORTH_OF_MEAN && count > 0.0 {
                let mean = sum / count;
                *light = Light {
                    light: mean,
                    worth: WORTH_OF_MEAN,
                    variance: luminance(mean).powi(2),
                };
            }
        }
    }

    /// Takes in the light of a [`Coarse`] picture of the same film, where no better light is carried over. `light` is
    /// the whole picture's.
    pub(super) fn add_coarse(&mut self, size: UVec2, light: &[Rgb]) {
        self.is_own = false;
        for ((x, y), own) in pixels_of(self.tile).zip(&mut self.light) {
            let coarse = light[place_of(size, x, y)];
            let share = WORTH_OF_COARSE / (own.worth + WORTH_OF_COARSE);
            *own = Light {
                light: own.light.lerp(coarse, share),
                worth: own.worth + WORTH_OF_COARSE,
                variance: own.variance.max(luminance(coarse).powi(2)),
            };
        }
    }

    /// The carried radiance of a pixel, and the variance of a sample's luminance there; None without carried light.
    pub(super) fn carried(&self, place: usize) -> Option<(Rgb, f32)> {
        let Light { light, worth, variance } = self.light[place];
        (worth > 0.0).then(|| (light * divisor(&self.texels[place]), variance))
    }
}

/// The light of a tile with its worth reduced next to pixels for which none was found: a part of these pixels may have
/// shown the surface that is gone.
fn without_rims(mut light: Vec<Light>, width: usize) -> Vec<Light> {
    let is_lost: Vec<bool> = light.iter().map(|light| light.worth <= 0.0).collect();
    let rows = is_lost.len() / width;
    for (place, _) in is_lost.iter().enumerate().filter(|(_, is_lost)| **is_lost) {
        let (row, column) = (place / width, place % width);
        for y in row.saturating_sub(1)..(row + 2).min(rows) {
            for beside in &mut light[y * width..][column.saturating_sub(1)..(column + 2).min(width)] {
                beside.worth = beside.worth.min(WORTH_OF_RIM);
            }
        }
    }
    light
}

/// The groups of surface directions: both ways along each axis, and no direction.
const DIRECTIONS: usize = 7;

fn direction_of(texel: &Texel) -> usize {
    let normal = texel.normal();
    if normal == Vec3::ZERO {
        return DIRECTIONS - 1;
    }
    let axis = normal.abs().max_position();
    2 * axis + usize::from(normal[axis] < 0.0)
}
