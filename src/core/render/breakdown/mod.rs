//! The light of a pixel or of a rectangle of pixels by the routes on which it has come: from which lamp, by way of
//! which surface, after how many bounces, and by what kind of scattering.
//!
//! The samples are those of the picture by path tracing, as [`record_paths`] records them: every contribution of every
//! path is put to the account of its [`Route`]. Portions of one grouping therefore sum up to the value of the pixel.
//! The reconstruction filter counts as in the picture; clamps, guides and layers are left out.
//!
//! Standard errors are those of batch means: the samples are split into [`BATCHES`] batches with random numbers that
//! are independent of each other (Owen, Monte Carlo theory, methods and examples, 2013, section 17.7: replicates of
//! randomised quasi-Monte Carlo). So the error of well spread points is not overestimated, as it would be by their
//! spread.

mod account;
mod destinations;
mod progress;
mod remedies;
mod route;

use glam::{DVec2, DVec3, UVec2};

pub use self::account::{Breakdown, Portion};
pub use self::destinations::{Destination, Destinations, destinations};
pub use self::progress::Progress;
pub use self::remedies::{Advice, Trouble};
pub use self::route::{Contribution, Kind, Route, Source, Way, contributions};

use self::account::{Account, PathId, PixelSums};
use super::inspect::{RecordedPath, record_paths};
use super::layers::Layers;
use super::light_layers::LightGroups;
use super::scene::RenderScene;
use super::view::{Integrator, Shown, View};
use crate::color::LUMINANCE;

/// The most batches, of which fewer are made only where they would have fewer than [`LEAST_OF_BATCH`] samples.
pub const BATCHES: u32 = 32;
/// The fewest samples of a pixel in a batch, so that its variance can be estimated.
pub const LEAST_OF_BATCH: u32 = 2;
/// The fewest batches: standard errors of fewer would have the wrong size too often.
pub const LEAST_BATCHES: u32 = 8;
/// The fewest samples of a pixel.
pub const LEAST_SAMPLES: u32 = LEAST_BATCHES * LEAST_OF_BATCH;

/// The most pixels that are traced as one task.
const PIXELS_OF_TASK: u64 = 64;

/// A rectangle of pixels of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Area {
    /// The first column, from 0 at the left edge.
    pub x: u32,
    /// The first row, from 0 at the upper edge.
    pub y: u32,
    /// The width in pixels, from 1 on.
    pub width: u32,
    /// The height in pixels, from 1 on.
    pub height: u32,
}

impl Area {
    /// The area of one pixel.
    pub fn pixel(pixel: UVec2) -> Self {
        Self {
            x: pixel.x,
            y: pixel.y,
            width: 1,
            height: 1,
        }
    }

    /// The number of its pixels.
    pub fn pixels(&self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Whether it has pixels, all of them within a picture of this size.
    pub fn is_within(&self, width: u32, height: u32) -> bool {
        let end = |start: u32, length: u32| u64::from(start) + u64::from(length);
        self.pixels() > 0
            && end(self.x, self.width) <= u64::from(width)
            && end(self.y, self.height) <= u64::from(height)
    }

    /// At most `count` of its pixels, spread over it evenly by the sequence R2 (Roberts, The unreasonable effectiveness
    /// of quasirandom sequences, 2018), row by row.
    pub fn spread(&self, count: u32) -> Vec<UVec2> {
        let size = DVec2::new(self.width.into(), self.height.into());
        let place = |index: u32| (0.5 + f64::from(index) * DVec2::new(0.754_877_666_2, 0.569_840_290_9)).fract();
        let pixel = |index| UVec2::new(self.x, self.y) + (place(index) * size).as_uvec2();
        let mut pixels: Vec<UVec2> = (0..count).map(pixel).collect();
        pixels.sort_by_key(|pixel| (pixel.y, pixel.x));
        pixels.dedup();
        pixels
    }

    /// The pixel with this number, row by row.
    fn pixel_at(&self, number: u64) -> UVec2 {
        let width = u64::from(self.width);
        UVec2::new(self.x + (number % width) as u32, self.y + (number / width) as u32)
    }
}

/// The samples of each pixel and how they are split into batches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Batches {
    /// The number of batches, from [`LEAST_BATCHES`] to [`BATCHES`].
    pub count: u32,
    /// The samples of a pixel in each of them.
    pub samples: u32,
}

impl Batches {
    /// Batches with at least `samples` samples of each pixel in all, and at least [`LEAST_SAMPLES`].
    pub fn of(samples: u32) -> Self {
        let samples = samples.max(LEAST_SAMPLES);
        let count = BATCHES.min(samples / LEAST_OF_BATCH);
        Self {
            count,
            samples: samples.div_ceil(count),
        }
    }

    /// The number of samples of each pixel in all batches.
    pub fn total(&self) -> u64 {
        u64::from(self.count) * u64::from(self.samples)
    }
}

/// The view whose paths are followed: `view` by path tracing, without clamp, guide and layers.
pub fn followed(view: &View) -> View {
    View {
        integrator: Integrator::Path(view.integrator.settings()),
        shown: Shown::Radiance,
        guide: None,
        clamp: None,
        before: None,
        layers: Layers::default(),
        light_groups: LightGroups::default(),
        ..view.clone()
    }
}

/// The view of batch number `batch`, whose random numbers are independent of those of other batches; the first batch
/// has those of `view`.
pub fn of_batch(view: &View, batch: u32) -> View {
    View {
        seed: view.seed.wrapping_add(batch.wrapping_mul(0x9e37_79b9)),
        ..view.clone()
    }
}

/// Breaks the light of `area` down by its routes. `area` has to be within the picture. Tasks run on the threads of the
/// current `rayon` pool; the result does not depend on their number. None if cancelled, or if `area` is not within the
/// picture.
pub fn break_down(
    scene: &RenderScene,
    view: &View,
    area: Area,
    batches: Batches,
    progress: &Progress,
) -> Option<Breakdown> {
    if !area.is_within(view.width, view.height) {
        return None;
    }
    let view = followed(view);
    let views: Vec<View> = (0..batches.count).map(|batch| of_batch(&view, batch)).collect();
    let tasks = area.pixels().div_ceil(PIXELS_OF_TASK) * u64::from(batches.count);
    let mut breakdown = Breakdown::new(area, batches);
    let trace = |task: u64| {
        let batch = (task % u64::from(batches.count)) as usize;
        let first = task / u64::from(batches.count) * PIXELS_OF_TASK;
        let last = area.pixels().min(first + PIXELS_OF_TASK);
        let pixels = (first..last).map(|number| area.pixel_at(number));
        let account = trace_pixels(scene, &views[batch], batch as u32, pixels, batches.samples, progress);
        account.map(|account| (batch, account))
    };
    progress.follow(tasks, trace, |(batch, account)| breakdown.add(batch, account))?;
    Some(breakdown)
}

/// The account of these pixels in batch number `batch`, whose view is `view`.
fn trace_pixels(
    scene: &RenderScene,
    view: &View,
    batch: u32,
    pixels: impl Iterator<Item = UVec2>,
    samples: u32,
    progress: &Progress,
) -> Option<Account> {
    let mut account = Account::default();
    let mut found = Vec::new();
    for pixel in pixels {
        let mut sums = PixelSums::default();
        for sample in 0..samples {
            if progress.is_cancelled() {
                return None;
            }
            let id = PathId { pixel, batch, sample };
            for path in record_paths(scene, view, pixel, sample..sample + 1) {
                weighted_contributions(scene, &path, &mut found);
                sums.add(id, &found);
            }
        }
        account.add_pixel(sums);
    }
    Some(account)
}

/// The contributions of a path to its pixel, which the filter weighs; paths whose radiance is not finite have none. The
/// picture also leaves out those with such an albedo, normal or depth.
fn weighted_contributions(scene: &RenderScene, path: &RecordedPath, found: &mut Vec<(Route, DVec3)>) {
    found.clear();
    if path.radiance.is_finite() {
        let all = contributions(scene, path).into_iter();
        let weight = f64::from(path.filter_weight);
        found.extend(all.map(|found| (found.route, found.light.as_dvec3() * weight)));
    }
}

/// The luminance of a linear colour, in double precision: rounded sums would look like noise.
fn brightness(light: DVec3) -> f64 {
    light.dot(LUMINANCE.as_dvec3())
}
