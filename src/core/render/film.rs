//! The accumulation buffer: sums over the samples of every pixel, with a coarse preview until there are samples.

mod chunks;
mod errors;
mod lamp_light;
mod relight;
mod state;
#[cfg(test)]
mod tests;

use std::borrow::Cow;
use std::ops::Range;

use glam::Vec3;
use rayon::prelude::*;

use self::chunks::{is_whole, without_splats};
pub use self::relight::{LightFrom, NewLayer, SetAside};
use super::layers::{FilmLayers, LayerSums, Matte};
use super::passes::chunks_in;
use super::scene::FirstHit;
use super::splats::{Splat, SplatSum, Splats, TileSplats};
use super::tile::{PixelSum, TILE, Tile, TilePreview, TileSamples, tiles};
use crate::color::{Rgb, luminance};
use crate::render::noise::blocks::{BLOCK, BLOCKS};
use crate::render::noise::mean_error::{BlockError, Efficiency};

/// A film smaller than its memory by this factor releases it.
const TOO_MUCH: usize = 16;

/// The number of pictures of the film's size in memory while it is denoised and saved: the colour before and after,
/// albedo and normals.
const COPIES: usize = 4;

/// The film. The pixels of a tile are contiguous, row by row in rows of [`TILE`], because samples come tile by tile; at
/// the right and lower edge some are outside of the picture.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    sums: Vec<PixelSum>,
    counts: Vec<u32>,
    /// The mean luminance at the last power of two of samples, and at the previous one.
    noted: Vec<[f32; 2]>,
    /// The error estimates of each block of pixels, tile by tile.
    errors: Vec<BlockError>,
    /// The sampling efficiency of each tile, from these errors.
    efficiencies: Vec<Efficiency>,
    /// The preview of each tile of the picture without samples.
    previews: Vec<Option<TilePreview>>,
    /// The layers beside the picture.
    kept: FilmLayers,
    layers: LayerSums,
    first_hits: Vec<Option<FirstHit>>,
    splats: Splats,
    /// The unfinished chunk of each tile, see [`super::passes`]. Its samples are in `counts`, and not yet in `sums`.
    begun: Vec<Option<Box<TileSamples>>>,
    /// The chunks of each tile, if they are kept.
    chunks: Option<Vec<Vec<TileSamples>>>,
    /// The ratio of the true squared errors to those estimated from the pixels' own samples, as measured by
    /// [`crate::render::noise::replicas`].
    correction: Option<f32>,
}

/// Statistics of a pixel's samples; all zero if there are none.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    /// The number of samples.
    pub samples: u32,
    /// Their mean.
    pub radiance: Rgb,
    /// The variance of a sample's luminance, without light that light paths bring to the camera. That of a single
    /// sample is arbitrary.
    pub variance: f32,
}

impl Film {
    /// An empty film of this size in pixels, without layers.
    pub fn new(width: u32, height: u32) -> Self {
        Self::with_layers(width, height, FilmLayers::default())
    }

    /// A film with layers beside the picture.
    pub fn with_layers(width: u32, height: u32, kept: FilmLayers) -> Self {
        let mut film = Self::default();
        film.begin(width, height, kept);
        film
    }

    /// Clears and resizes the film, in its existing memory if that is enough and not far too much: getting pages from
    /// the system costs more than filling them. Returns the old previews.
    pub fn begin(&mut self, width: u32, height: u32, kept: FilmLayers) -> Vec<Option<TilePreview>> {
        let tiles = width.div_ceil(TILE) as usize * height.div_ceil(TILE) as usize;
        let pixels = tiles * (TILE * TILE) as usize;
        let is_far_too_much = |has: usize, needs: usize| has / TOO_MUCH > needs;
        if is_far_too_much(self.sums.capacity(), pixels)
            || is_far_too_much(self.layers.values.capacity(), pixels * kept.values())
            || is_far_too_much(self.layers.mattes.capacity(), pixels * kept.matte_count())
        {
            *self = Self::default();
        }
        (self.width, self.height, self.kept) = (width, height, kept);
        // Old values of pixels without a sample are never read.
        self.sums.resize(pixels, PixelSum::default());
        self.layers.resize(kept, pixels);
        self.first_hits.resize(pixels, None);
        self.splats = Splats::default();
        self.counts.clear();
        self.counts.resize(pixels, 0);
        self.noted.resize(pixels, [0.0; 2]);
        self.errors.clear();
        self.errors.resize(tiles * BLOCKS, BlockError::default());
        self.efficiencies.clear();
        self.efficiencies.resize(tiles, Efficiency::default());
        self.begun.clear();
        self.begun.resize(tiles, None);
        self.chunks = None;
        self.correction = None;
        std::mem::replace(&mut self.previews, vec![None; tiles])
    }

    /// The memory of a film of this size in bytes, with the copies for showing and saving it.
    pub fn memory_bytes(width: u32, height: u32, kept: FilmLayers) -> u64 {
        let pixel = size_of::<PixelSum>()
            + size_of::<u32>()
            + size_of::<[f32; 2]>()
            + size_of::<BlockError>() / (BLOCK * BLOCK) as usize
            + size_of::<Option<FirstHit>>()
            + kept.pixel_bytes()
            + if kept.splats { size_of::<SplatSum>() } else { 0 }
            + size_of::<PixelSum>()
            + kept.sum_bytes()
            + COPIES * size_of::<Rgb>();
        let rounded = |side: u32| u64::from(side.next_multiple_of(TILE));
        rounded(width) * rounded(height) * pixel as u64
    }

    /// The memory in bytes of the chunks of `tiles` tiles that the film of a share with these samples keeps, see
    /// [`Self::keep_chunks`].
    pub fn chunk_bytes(tiles: usize, samples: Range<u32>, kept: FilmLayers) -> u64 {
        let tile = (TILE * TILE) as usize * (size_of::<PixelSum>() + kept.sum_bytes());
        (tiles as u64 * tile as u64).saturating_mul(chunks_in(samples))
    }

    /// The number of pixels in a row.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// The number of rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Adds finished samples. For the same bits in every run, those of one tile must come in the order of their sample
    /// ranges. Returns the preview that they replace.
    pub fn add(&mut self, result: &TileSamples) -> Option<TilePreview> {
        let (tile, width) = (result.tile, result.tile.width as usize);
        let place = self.tile_index(tile.x, tile.y);
        self.add_splats(&result.splats);
        let follows = |chunk: &TileSamples| result.blocks.is_none() && chunk.samples.end == result.samples.start;
        if let Some(chunk) = self.begun[place].take_if(|chunk| !follows(chunk)) {
            self.add_chunk(&chunk);
        }
        for (y, from) in (tile.y..).zip((0..result.pixels.len()).step_by(width)) {
            let row = self.index(tile.x, y)..self.index(tile.x, y) + width;
            if let Some(hits) = result.first_hits.get(from..from + width) {
                self.first_hits[row.clone()].copy_from_slice(hits);
            }
            for (x, samples) in (tile.x..).zip(&mut self.counts[row]) {
                *samples = samples.saturating_add(result.count(x, y));
            }
        }
        match self.begun[place].take() {
            Some(mut chunk) => {
                chunk.append_own(result);
                self.add_if_whole(place, chunk);
            }
            None if result.blocks.is_some() || is_whole(result) => self.add_chunk(result),
            None => self.begun[place] = Some(Box::new(without_splats(result))),
        }
        self.previews[place].take_if(|preview| preview.tile == tile)
    }

    /// Adds splats, which may be in any tile.
    fn add_splats(&mut self, splats: &TileSplats) {
        let is_inside = |splat: &&Splat| splat.pixel.x < self.width && splat.pixel.y < self.height;
        for splat in splats.list.iter().filter(is_inside) {
            let place = self.index(splat.pixel.x, splat.pixel.y);
            self.splats.add(place, splat.radiance, self.sums.len());
        }
        self.splats.paths += splats.paths;
    }

    /// Whether there is light from splats, which new samples change in the whole picture.
    pub fn has_splats(&self) -> bool {
        self.splats.paths > 0
    }

    /// The light of splats at an index.
    fn splatted(&self, index: usize) -> Rgb {
        self.splats.mean(index, u64::from(self.width) * u64::from(self.height))
    }

    /// The estimated variance of the luminance of [`Self::splatted`].
    fn splat_variance(&self, index: usize) -> f32 {
        self.splats
            .variance(index, u64::from(self.width) * u64::from(self.height))
    }

    /// The numbers of samples of a tile, row by row.
    fn counts_of(&self, tile: Tile) -> impl Iterator<Item = u32> {
        let rows = (tile.y..tile.y + tile.height).map(move |y| self.index(tile.x, y));
        rows.flat_map(move |start| &self.counts[start..start + tile.width as usize])
            .copied()
    }

    /// Shows a coarse picture in the pixels of the tile without samples. It is stored as it is: expanding it pixel by
    /// pixel would take a whole frame's time.
    pub fn add_preview(&mut self, preview: TilePreview) {
        let place = self.tile_index(preview.tile.x, preview.tile.y);
        self.previews[place] = Some(preview);
    }

    /// The preview of a tile of the picture, while the tile has no samples.
    pub(super) fn preview_of(&self, tile: Tile) -> Option<&TilePreview> {
        self.previews[self.tile_index(tile.x, tile.y)].as_ref()
    }

    /// The preview's block at a pixel that has no sample yet.
    fn preview(&self, x: u32, y: u32) -> Option<(&TilePreview, usize)> {
        let preview = self.previews[self.tile_index(x, y)].as_ref()?;
        let (tile, step) = (preview.tile, preview.step);
        let block = (y - tile.y) / step * tile.width.div_ceil(step) + (x - tile.x) / step;
        Some((preview, block as usize))
    }

    /// The index of the picture's [`tiles`] that has this pixel.
    fn tile_index(&self, x: u32, y: u32) -> usize {
        (y / TILE) as usize * self.width.div_ceil(TILE) as usize + (x / TILE) as usize
    }

    fn index(&self, x: u32, y: u32) -> usize {
        self.tile_index(x, y) * (TILE * TILE) as usize + (y % TILE * TILE + x % TILE) as usize
    }

    /// The number of samples of one pixel.
    pub fn samples(&self, x: u32, y: u32) -> u32 {
        self.counts[self.index(x, y)]
    }

    /// The largest number of samples of a pixel.
    pub fn most_samples(&self) -> u32 {
        // There are no samples outside of the picture.
        self.counts.iter().copied().max().unwrap_or(0)
    }

    /// The least number of samples of a pixel.
    pub fn sample_count(&self) -> u32 {
        let rows = tiles(self.width, self.height).into_iter();
        rows.filter_map(|tile| self.counts_of(tile).min()).min().unwrap_or(0)
    }

    /// The number of pixels without samples.
    pub fn pixels_without_samples(&self) -> usize {
        let tiles = tiles(self.width, self.height).into_iter();
        let counts = tiles.flat_map(|tile| self.counts_of(tile));
        counts.filter(|&count| count == 0).count()
    }

    /// The mean over a pixel's samples, or its preview; None if it has neither.
    pub fn pixel(&self, x: u32, y: u32) -> Option<PixelSum> {
        let index = self.index(x, y);
        match self.counts[index] {
            0 => self.preview(x, y).map(|(preview, block)| preview.blocks[block]),
            count => {
                let mut pixel = mean(&self.sum(x, y), count);
                pixel.radiance += self.splatted(index);
                Some(pixel)
            }
        }
    }

    /// The first hit of a pixel's sample 0, or of its preview before that. None where nothing is hit or there is no
    /// sample.
    pub fn first_hit(&self, x: u32, y: u32) -> Option<FirstHit> {
        let index = self.index(x, y);
        match self.counts[index] {
            0 => self
                .preview(x, y)
                .and_then(|(preview, block)| preview.first_hits[block]),
            _ => self.first_hits[index],
        }
    }

    /// The layers beside the picture.
    pub fn layers(&self) -> FilmLayers {
        self.kept
    }

    /// The values of a pixel's layers, summed up over its samples; None if it has none yet.
    pub(super) fn layer_sums(&self, x: u32, y: u32) -> Option<Cow<'_, [f32]>> {
        (self.samples(x, y) > 0).then(|| self.layer_values(x, y))
    }

    /// The cryptomatte number `place` of a pixel, empty if it has no samples yet.
    pub(super) fn matte(&self, x: u32, y: u32, place: usize) -> Matte {
        let index = self.index(x, y);
        match self.counts[index] {
            0 => Matte::default(),
            _ => self.matte_sum(x, y, place),
        }
    }

    /// The radiance of [`Self::pixel`] with the light of each group multiplied by its factor, which is 1 for groups
    /// without one. Splats belong to no group. Without layers or without factors it is unchanged.
    pub fn mixed_pixel(&self, x: u32, y: u32, factors: &[Rgb]) -> Option<Rgb> {
        let index = self.index(x, y);
        let (radiance, layers, count) = match self.counts[index] {
            0 => {
                let (preview, block) = self.preview(x, y)?;
                (
                    preview.blocks[block].radiance,
                    Cow::Borrowed(preview.layers.values_of(self.kept, block)),
                    1,
                )
            }
            count => (self.sum(x, y).radiance, self.layer_values(x, y), count),
        };
        // Previews include all light.
        let splats = match self.counts[index] {
            0 => Rgb::ZERO,
            _ => self.splatted(index),
        };
        if self.kept.groups == 0 || factors.is_empty() {
            return Some(radiance * (1.0 / count as f32) + splats);
        }
        let groups = LayerSums::groups(&layers, self.kept);
        let factors = factors.iter().copied().chain(std::iter::repeat(Rgb::ONE));
        let sum: Rgb = groups.zip(factors).map(|(light, factor)| light * factor).sum();
        Some(sum / count as f32 + splats)
    }

    /// The radiance of [`Self::mixed_pixel`] for a row of pixels of a tile, written to the start of `row`.
    pub fn mixed_row(&self, tile: Tile, y: u32, factors: &[Rgb], row: &mut [Option<Rgb>; TILE as usize]) {
        let is_mixed = self.kept.groups > 0 && !factors.is_empty();
        if is_mixed || self.has_splats() || self.previews[self.tile_index(tile.x, y)].is_some() {
            for (x, pixel) in (tile.x..tile.x + tile.width).zip(row) {
                *pixel = self.mixed_pixel(x, y, factors);
            }
            return;
        }
        self.each_sum_of_row(tile, y, |place, count, radiance, _| {
            row[place] = (count > 0).then(|| radiance * (1.0 / count as f32));
        });
    }

    /// The statistics of a row of pixels of a tile, written to the start of `row`.
    pub fn moments_row(&self, tile: Tile, y: u32, row: &mut [Moments; TILE as usize]) {
        let start = self.index(tile.x, y);
        self.each_sum_of_row(tile, y, |place, samples, radiance, luminance_squared| {
            let scale = if samples > 0 { 1.0 / samples as f32 } else { 0.0 };
            let splats = if samples > 0 {
                self.splatted(start + place)
            } else {
                Rgb::ZERO
            };
            let mean = luminance(radiance * scale);
            row[place] = Moments {
                samples,
                radiance: radiance * scale + splats,
                variance: match samples {
                    1 => mean * mean,
                    _ => (luminance_squared * scale - mean * mean).max(0.0),
                },
            };
        });
    }

    /// Calls `each` for every pixel in a row of a tile with its index in the row, its number of samples, and the sums
    /// of their radiance and of their squared luminances.
    fn each_sum_of_row(&self, tile: Tile, y: u32, mut each: impl FnMut(usize, u32, Rgb, f32)) {
        let places = self.index(tile.x, y)..self.index(tile.x, y) + tile.width as usize;
        // Looked up once for all pixels.
        let begun = self.begun_at(tile.x, y);
        let begun = begun.map(|(chunk, start, _)| (&chunk.pixels[start..], chunk.samples.len() as u32));
        let pixels = self.sums[places.clone()].iter().zip(&self.counts[places]);
        for (place, (sum, &count)) in pixels.enumerate() {
            let (radiance, luminance_squared) = match begun {
                Some((new, samples)) if count == samples => (new[place].radiance, new[place].luminance_squared),
                Some((new, _)) => (
                    sum.radiance + new[place].radiance,
                    sum.luminance_squared + new[place].luminance_squared,
                ),
                None => (sum.radiance, sum.luminance_squared),
            };
            each(place, count, radiance, luminance_squared);
        }
    }

    /// The radiance of [`Self::mixed_pixel`] for the whole picture; black where there is none yet.
    pub fn mixed(&self, factors: &[Rgb]) -> Vec<Rgb> {
        (0..self.height)
            .flat_map(|y| (0..self.width).map(move |x| (x, y)))
            .map(|(x, y)| self.mixed_pixel(x, y, factors).unwrap_or_default())
            .collect()
    }

    /// Mean radiance; black where there is none yet.
    pub fn radiance(&self) -> Vec<Rgb> {
        let mut radiance = vec![Rgb::ZERO; self.width as usize * self.height as usize];
        let rows = radiance.par_chunks_mut(self.width.max(1) as usize).enumerate();
        rows.for_each(|(y, row)| {
            let y = y as u32;
            for (tile, part) in (0..).zip(row.chunks_mut(TILE as usize)) {
                let tile = Tile {
                    x: tile * TILE,
                    y: y / TILE * TILE,
                    width: part.len() as u32,
                    height: TILE.min(self.height - y / TILE * TILE),
                };
                let mut light = [None; TILE as usize];
                self.mixed_row(tile, y, &[], &mut light);
                part.iter_mut()
                    .zip(light)
                    .for_each(|(to, light)| *to = light.unwrap_or_default());
            }
        });
        radiance
    }

    /// Mean albedo for the denoiser, in [0, 1].
    pub fn albedo(&self) -> Vec<Rgb> {
        self.means(|mean| mean.albedo)
    }

    /// Mean normal for the denoiser, in world space; shorter than 1 where normals differ within a pixel.
    pub fn normal(&self) -> Vec<Vec3> {
        self.means(|mean| mean.normal)
    }

    /// Mean distance from the camera to the first surface.
    pub fn depth(&self) -> Vec<f32> {
        self.means(|mean| mean.depth)
    }

    fn means<T: Send>(&self, of: impl Fn(PixelSum) -> T + Sync) -> Vec<T> {
        let rows = (0..self.height).into_par_iter();
        rows.flat_map_iter(|y| (0..self.width).map(move |x| (x, y)))
            .map(|(x, y)| of(self.pixel(x, y).unwrap_or_default()))
            .collect()
    }
}

fn mean(sum: &PixelSum, count: u32) -> PixelSum {
    let scale = 1.0 / count as f32;
    PixelSum {
        radiance: sum.radiance * scale,
        albedo: sum.albedo * scale,
        normal: sum.normal * scale,
        depth: sum.depth * scale,
        luminance_squared: sum.luminance_squared * scale,
        rays: sum.rays * scale,
    }
}
