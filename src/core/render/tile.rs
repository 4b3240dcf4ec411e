//! The unit of work: a rectangle of pixels times a range of samples, rendered by a pure function.

use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use bytemuck::{Pod, Zeroable};
use glam::{UVec2, Vec3};

use super::fireflies;
use super::lanes::Job;
use super::layers::{LayerSums, PixelLayers};
use super::path::PathSample;
use super::scene::{FirstHit, RenderScene};
use super::splats::TileSplats;
use super::tracer::Tracer;
use super::view::{Shown, View};
use crate::color::{Rgb, luminance};
use crate::render::noise::blocks::{PerBlock, block_of, blocks_of, parts};

/// The edge length of a tile in pixels.
pub const TILE: u32 = 32;

/// A rectangle of pixels, (x, y) its top left.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Tile {
    /// The first column, in pixels from the left edge of the picture.
    pub x: u32,
    /// The first row, in pixels from the upper edge.
    pub y: u32,
    /// The width in pixels, from 1 to [`TILE`].
    pub width: u32,
    /// The height in pixels, from 1 to [`TILE`].
    pub height: u32,
}

/// The tiles of a picture, row by row; those at the right and lower edge may be smaller.
pub fn tiles(width: u32, height: u32) -> Vec<Tile> {
    let (x, y) = (0, 0);
    parts(Tile { x, y, width, height }, TILE).collect()
}

/// Sums over the samples of one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PixelSum {
    /// The sum of the radiance, linear Rec. 709.
    pub radiance: Rgb,
    /// The sum of the albedos of the first surfaces that are not perfectly specular.
    pub albedo: Rgb,
    /// The sum of the world normals of the same surfaces; its length shows how far they agree.
    pub normal: Vec3,
    /// The sum of the distances from the origin of the camera ray to the first surface, 0 for samples that hit
    /// nothing.
    pub depth: f32,
    /// The sum of squared luminances, for the noise estimate.
    pub luminance_squared: f32,
    /// The number of rays that were traced, shadow rays included.
    pub rays: f32,
}

impl PixelSum {
    /// Adds the sums over other samples of the same pixel.
    pub fn add(&mut self, other: &Self) {
        self.radiance += other.radiance;
        self.albedo += other.albedo;
        self.normal += other.normal;
        self.depth += other.depth;
        self.luminance_squared += other.luminance_squared;
        self.rays += other.rays;
    }
}

impl From<PathSample> for PixelSum {
    fn from(sample: PathSample) -> Self {
        Self {
            radiance: sample.radiance,
            albedo: sample.albedo,
            normal: sample.normal,
            depth: sample.depth,
            luminance_squared: luminance(sample.radiance).powi(2),
            rays: sample.rays as f32,
        }
    }
}

/// The samples of a rendered work item.
#[derive(Clone, Debug, PartialEq)]
pub struct TileSamples {
    /// The pixels that were rendered.
    pub tile: Tile,
    /// The indices of the samples in the sums. Where blocks differ, they count the samples of the mean pixel.
    pub samples: Range<u32>,
    /// The indices of the samples of each block, if they differ by [adaptive sampling](crate::render::noise::adaptive).
    pub blocks: Option<Arc<PerBlock<Range<u32>>>>,
    /// The pixels row by row.
    pub pixels: Vec<PixelSum>,
    /// The layers of the view, summed up over the same samples.
    pub layers: LayerSums,
    /// The first hit of sample 0 of every pixel; empty if that is not among the samples.
    pub first_hits: Vec<Option<FirstHit>>,
    /// Splats of light paths, which may be on pixels of other tiles.
    pub splats: TileSplats,
    /// Rays traced, shadow rays included.
    pub rays: u64,
    /// The number of samples that were not finite; they count as black.
    pub invalid: u32,
}

impl TileSamples {
    /// A result with sums of pixels alone.
    #[cfg(test)]
    pub(super) fn of_pixels(tile: Tile, samples: Range<u32>, pixels: Vec<PixelSum>) -> Self {
        Self {
            tile,
            samples,
            blocks: None,
            pixels,
            layers: Default::default(),
            first_hits: Vec::new(),
            splats: Default::default(),
            rays: 0,
            invalid: 0,
        }
    }

    /// Adds the samples of the same tile that follow these.
    pub fn append(&mut self, next: &Self) {
        self.append_own(next);
        self.splats.append(next.splats.clone());
    }

    /// [`Self::append`] without splats.
    pub(super) fn append_own(&mut self, next: &Self) {
        debug_assert_eq!((self.tile, self.samples.end), (next.tile, next.samples.start));
        self.samples.end = next.samples.end;
        let pixels = self.pixels.iter_mut().zip(&next.pixels);
        pixels.for_each(|(sum, new)| sum.add(new));
        self.layers.append(&next.layers);
        if self.first_hits.is_empty() {
            self.first_hits.clone_from(&next.first_hits);
        }
        self.rays += next.rays;
        self.invalid += next.invalid;
    }

    /// The number of samples of the pixel at (x, y) of the picture.
    pub(super) fn count(&self, x: u32, y: u32) -> u32 {
        let of_block = |blocks: &PerBlock<Range<u32>>| blocks[block_of(x, y)].len();
        self.blocks.as_deref().map_or(self.samples.len(), of_block) as u32
    }

    /// The number of samples of all pixels.
    pub fn total(&self) -> u64 {
        let Some(blocks) = &self.blocks else {
            return self.samples.len() as u64 * u64::from(self.tile.width * self.tile.height);
        };
        let of_block =
            |(place, block): (usize, Tile)| u64::from(block.width * block.height) * blocks[place].len() as u64;
        blocks_of(self.tile).map(of_block).sum()
    }
}

/// A coarse picture of a tile: one sample per block of `step` x `step` pixels. For display only, never accumulated.
#[derive(Clone, Debug, PartialEq)]
pub struct TilePreview {
    /// The pixels that the blocks cover.
    pub tile: Tile,
    /// The edge length of a block in pixels.
    pub step: u32,
    /// The blocks row by row, ceil(width / step) x ceil(height / step).
    pub blocks: Vec<PixelSum>,
    /// The layers as in [`TileSamples`].
    pub layers: LayerSums,
    /// The first hit of each block's sample.
    pub first_hits: Vec<Option<FirstHit>>,
    /// Rays traced, shadow rays included.
    pub rays: u64,
}

/// Renders samples `samples` of every pixel of `tile`; None if `cancel` was set in the meantime (it is checked from
/// time to time).
pub fn render_tile(
    scene: &RenderScene,
    view: &View,
    tile: Tile,
    samples: Range<u32>,
    cancel: &AtomicBool,
) -> Option<TileSamples> {
    render_blocks(scene, view, tile, samples, None, cancel)
}

/// Renders a tile as [`render_tile`] does, or for each of its `blocks` the samples with these indices; `samples` are
/// then those of the mean pixel.
pub fn render_blocks(
    scene: &RenderScene,
    view: &View,
    tile: Tile,
    samples: Range<u32>,
    blocks: Option<Arc<PerBlock<Range<u32>>>>,
    cancel: &AtomicBool,
) -> Option<TileSamples> {
    let indices = |pixel: UVec2| match blocks.as_deref() {
        Some(blocks) => blocks[block_of(pixel.x, pixel.y)].clone(),
        None => samples.clone(),
    };
    // All memory is allocated at once: a growing vector makes other threads wait for the allocator.
    let pixels = (tile.width * tile.height) as usize;
    let mut result = TileSamples {
        tile,
        samples: samples.clone(),
        blocks: blocks.clone(),
        pixels: Vec::with_capacity(pixels),
        layers: LayerSums::default(),
        first_hits: Vec::with_capacity(if samples.contains(&0) { pixels } else { 0 }),
        splats: Default::default(),
        rays: 0,
        invalid: 0,
    };
    let mut layers = PixelLayers::new(scene, view, pixels);
    let limit = match view.clamp {
        // Other modes show no light.
        Some(_) if matches!(view.shown, Shown::Radiance | Shown::StrategyThirds) => {
            Some(fireflies::limit(scene, view, cancel)?)
        }
        _ => None,
    };
    let tracer = Tracer::of(view);
    let rows_at_once = match tracer {
        Tracer::Lanes(_) | Tracer::Illuminance => {
            (SAMPLES_AT_ONCE * tile.height / (result.total() as u32).max(1)).clamp(1, TILE)
        }
        Tracer::Bidirectional(..) | Tracer::OneByOne => 1,
    };
    let bottom = tile.y + tile.height;
    for top in (tile.y..bottom).step_by(rows_at_once as usize) {
        let pixels = (top..bottom.min(top + rows_at_once))
            .flat_map(|y| (tile.x..tile.x + tile.width).map(move |x| UVec2::new(x, y)));
        let jobs = pixels
            .clone()
            .flat_map(|pixel| indices(pixel).map(move |index| Job { pixel, index }));
        let mut traced = tracer.trace(scene, view, jobs, cancel)?;
        for pixel in pixels {
            let mut sum = PixelSum::default();
            layers.begin_pixel();
            for index in indices(pixel) {
                let job = Job { pixel, index };
                let (mut sample, weight) = traced.next(job);
                result.rays += u64::from(sample.rays);
                if index == 0 {
                    result.first_hits.push(first_hit(scene, view, pixel, &sample));
                }
                if is_finite(&sample) {
                    let share = limit.map_or(1.0, |limit| limit.share(&sample, weight));
                    traced.add_layers(job, &sample, weight * share, &mut layers);
                    // Albedo and normal are not weighted: absence of noise and the right range matter more for them
                    // than sharpness.
                    sample.radiance *= weight * share;
                    sum.add(&sample.into());
                } else {
                    result.invalid += 1;
                }
            }
            result.pixels.push(sum);
        }
        traced.take_splats(&mut result.splats);
    }
    if let Some(limit) = limit {
        limit.clamp_splats(&mut result.splats.list);
    }
    result.layers = layers.sums;
    Some(result)
}

/// The approximate number of samples that are traced before they are summed up: enough to keep all lanes busy, and few
/// enough for the cache.
const SAMPLES_AT_ONCE: u32 = 4096;

/// Renders one sample at the centre of each block of `step` x `step` pixels; None if cancelled.
pub fn render_preview(
    scene: &RenderScene,
    view: &View,
    tile: Tile,
    step: u32,
    cancel: &AtomicBool,
) -> Option<TilePreview> {
    let middle = |start: u32, end: u32| start + step.min(end - start) / 2;
    let blocks = (tile.width.div_ceil(step) * tile.height.div_ceil(step)) as usize;
    let mut result = TilePreview {
        tile,
        step,
        blocks: Vec::with_capacity(blocks),
        layers: LayerSums::default(),
        first_hits: Vec::with_capacity(blocks),
        rays: 0,
    };
    let mut layers = PixelLayers::new(scene, view, blocks);
    let (right, bottom) = (tile.x + tile.width, tile.y + tile.height);
    let starts = |start: u32, end: u32| (start..end).step_by(step as usize);
    // Learning a guide would take longer than a preview may.
    let view = &View {
        guide: None,
        ..view.clone()
    };
    // With a single sample the filter's weight would only change the brightness.
    let jobs = starts(tile.y, bottom).flat_map(|y| {
        starts(tile.x, right).map(move |x| Job {
            pixel: UVec2::new(middle(x, right), middle(y, bottom)),
            index: 0,
        })
    });
    let mut traced = Tracer::of_preview(view).trace(scene, view, jobs.clone(), cancel)?;
    for job in jobs {
        layers.begin_pixel();
        let (sample, _) = traced.next(job);
        result.rays += u64::from(sample.rays);
        result.first_hits.push(first_hit(scene, view, job.pixel, &sample));
        result.blocks.push(if is_finite(&sample) {
            traced.add_layers(job, &sample, 1.0, &mut layers);
            sample.into()
        } else {
            PixelSum::default()
        });
    }
    result.layers = layers.sums;
    Some(result)
}

/// The first hit of sample 0 of a pixel. Not inlined, so that the loop over samples stays short.
#[inline(never)]
fn first_hit(scene: &RenderScene, view: &View, pixel: UVec2, sample: &PathSample) -> Option<FirstHit> {
    let hit = sample.first_hit?;
    Some(scene.first_hit(&view.camera_sample(pixel, 0).ray, &hit))
}

fn is_finite(sample: &PathSample) -> bool {
    sample.radiance.is_finite() && sample.albedo.is_finite() && sample.normal.is_finite() && sample.depth.is_finite()
}
