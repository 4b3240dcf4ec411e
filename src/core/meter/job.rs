//! Measuring as a job, which can be watched and cancelled.
//!
//! Every meter goes on until its values are as certain as asked for. That is judged each time when its samples have
//! doubled: the more often one looks, the more often a value passes whose error is too low by chance. All sets of
//! samples of a meter are equally long then, so that the values depend on the seed alone, and not on the number of
//! threads, unless time ends the job.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use glam::{UVec2, Vec3};
use rayon::ThreadPool;
use rayon::prelude::*;

use super::estimate::{Estimate, GridEstimate, REPLICATES};
use super::sites::{AskedMeter, MOST_POINTS_OF_SCENE, MeterKind, MeterLimits, Sites, SitesError};
use crate::bake::lightmap::Lightmaps;
use crate::bake::progress::Pace;
use crate::color::luminance;
use crate::photometry::LUMENS_PER_WATT;
use crate::render::gathering::Gathering;
use crate::render::irradiance::ReceivedLight;
use crate::render::light_layers::LightGroups;
use crate::render::scene::RenderScene;
use crate::render::view::View;
use crate::sampling::hash::pcg3d;

/// The fewest samples of each set by which a value is judged.
const LEAST_SAMPLES: u32 = 16;
/// The sets that have to find light at a point before their spread tells the error, unless each has as many samples as
/// [`SAMPLES_IN_THE_DARK`].
const LEAST_LIT: usize = 24;
/// The samples of each set after which a single point without light counts as dark. Of a grid with many points one
/// point weighs less, and the samples are fewer.
const SAMPLES_IN_THE_DARK: u32 = 64 * LEAST_SAMPLES;

/// The most samples that a task adds to each point of a set: they bound its memory.
const MOST_AT_ONCE: u32 = 256;

/// The limits that end measuring.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeterEnd {
    /// The relative standard error at which a value is good enough, above 0.
    pub noise: f64,
    /// The most samples of a point.
    pub samples: u32,
    /// The time after which measuring ends; None for no limit.
    pub time: Option<Duration>,
}

impl Default for MeterEnd {
    /// One per cent, and at most 65,536 samples.
    fn default() -> Self {
        Self {
            noise: 0.01,
            samples: 1 << 16,
            time: None,
        }
    }
}

/// The reason why there is nothing to measure with.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum MeterError {
    #[error("{name}: {source}")]
    Sites { name: String, source: SitesError },
    #[error("all meters together have {0} points, more than {MOST_POINTS_OF_SCENE}: widen the spacing of grids")]
    TooManyPoints(usize),
}

/// How a job has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeterEnding {
    /// All values are as certain as asked for, or have all their samples.
    Done,
    /// Time was up.
    TimeUp,
    /// It was cancelled.
    Cancelled,
}

/// The meters of a scene while they measure.
pub struct MeterJob {
    scene: RenderScene,
    /// The settings of paths, with the seed from which each set of samples of each meter has its own.
    view: View,
    meters: Vec<Metering>,
}

/// A meter with the light that it has gathered.
pub struct Metering {
    /// What was asked for.
    pub asked: AskedMeter,
    sites: Sites,
    /// The light of each set of samples.
    replicates: Vec<Lightmaps>,
    /// The number of samples of each set after which the meter is judged next.
    goal: u32,
    /// The number of samples of each set that it is expected to need in all, by its error when it was last judged.
    expected: u32,
    is_done: bool,
}

/// The values of a meter.
#[derive(Clone, Debug, PartialEq)]
pub struct MeterReading {
    /// The name of the meter.
    pub name: String,
    /// The columns and rows of its points.
    pub size: UVec2,
    /// The positions of the points in the world, row by row.
    pub positions: Vec<Vec3>,
    /// The unit normal of the points, on the side that is lit.
    pub normal: Vec3,
    /// The illuminance of each point in lux.
    pub points: Vec<Estimate>,
    /// The values of a grid; None for a single point.
    pub grid: Option<GridEstimate>,
    /// The values that were asked for.
    pub limits: MeterLimits,
    /// The samples that each point has.
    pub samples: u32,
    /// Whether its points see mostly backs of surfaces and no light, as inside of a solid.
    pub is_buried: bool,
}

/// A limit of a meter against its value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Judgement {
    /// The name of the value: `least`, `mean` or `uniformity`.
    pub of: &'static str,
    /// The value that was asked for.
    pub limit: f64,
    /// The measured value.
    pub measured: Estimate,
}

impl Judgement {
    /// Whether the measured value is at least the limit.
    pub fn passes(&self) -> bool {
        self.measured.value >= self.limit
    }

    /// Whether more samples could decide otherwise: the limit is within two standard errors.
    pub fn is_close(&self) -> bool {
        (self.measured.value - self.limit).abs() < 2.0 * self.measured.error
    }
}

impl MeterReading {
    /// The values by which the meter is judged, with the limits that it has.
    pub fn judgements(&self) -> Vec<Judgement> {
        let MeterLimits {
            least,
            mean,
            uniformity,
        } = self.limits;
        let asked = match (&self.grid, self.points.first()) {
            (Some(grid), _) => vec![
                ("least", least, grid.least),
                ("mean", mean, grid.mean),
                // In the dark nothing is uniform.
                ("uniformity", uniformity, grid.uniformity.unwrap_or_default()),
            ],
            (None, Some(point)) => vec![("least", least, *point)],
            (None, None) => Vec::new(),
        };
        let judged = asked
            .into_iter()
            .filter_map(|(of, limit, measured)| limit.map(|limit| Judgement { of, limit, measured }));
        judged.collect()
    }

    /// Whether all limits are met; true without any.
    pub fn passes(&self) -> bool {
        self.judgements().iter().all(Judgement::passes)
    }
}

impl Metering {
    fn new(asked: AskedMeter, scene: &RenderScene, view: &View) -> Result<Self, MeterError> {
        let mut sites = asked.sites().map_err(|source| MeterError::Sites {
            name: asked.name.clone(),
            source,
        })?;
        sites.settle(scene, view);
        let count = sites.texels.texels.len();
        Ok(Self {
            asked,
            sites,
            replicates: vec![Lightmaps::new(count); REPLICATES],
            goal: 0,
            expected: u32::MAX,
            is_done: false,
        })
    }

    /// The samples that every set of every point has.
    fn reached(&self) -> u32 {
        self.replicates.iter().map(Lightmaps::samples).min().unwrap_or_default()
    }

    /// The lux of every point by every set.
    fn values(&self) -> Vec<Vec<f64>> {
        let lux = |light: &Lightmaps, point| f64::from(LUMENS_PER_WATT) * f64::from(luminance(light.light(point)));
        let of_set = |light: &Lightmaps| (0..light.texel_count()).map(|point| lux(light, point)).collect();
        self.replicates.iter().map(of_set).collect()
    }

    /// The largest relative error of the values that are reported of the meter as a whole; infinite as long as light
    /// is so rare that its spread is not known.
    fn noise(&self) -> f64 {
        let values = self.values();
        let is_rare = |point: usize| {
            let found = values.iter().filter(|set| set[point] > 0.0).count();
            found < LEAST_LIT && !self.replicates.iter().all(|light| light.are_buried(point..point + 1))
        };
        let points = self.sites.texels.texels.len();
        let in_the_dark = (SAMPLES_IN_THE_DARK / (points as u32).isqrt().max(1)).max(4 * LEAST_SAMPLES);
        if self.reached() < in_the_dark && (0..points).any(is_rare) {
            return f64::INFINITY;
        }
        match self.asked.kind {
            MeterKind::Point => Estimate::of(&values.iter().map(|set| set[0]).collect::<Vec<_>>()).relative_error(),
            MeterKind::Grid { .. } => {
                let grid = GridEstimate::of(&values);
                grid.least.relative_error().max(grid.mean.relative_error())
            }
        }
    }

    /// The present values; None before every point has a sample of each set.
    pub fn reading(&self) -> Option<MeterReading> {
        if self.reached() == 0 {
            return None;
        }
        let values = self.values();
        let of_point = |point: usize| Estimate::of(&values.iter().map(|set| set[point]).collect::<Vec<_>>());
        let first = self.sites.texels.texels.first()?;
        let count = self.sites.texels.texels.len();
        Some(MeterReading {
            name: self.asked.name.clone(),
            size: self.sites.size,
            positions: self.sites.positions().collect(),
            normal: first.receiver.receiver.normal,
            points: (0..count).map(of_point).collect(),
            grid: match self.asked.kind {
                MeterKind::Point => None,
                MeterKind::Grid { .. } => Some(GridEstimate::of(&values)),
            },
            limits: self.asked.limits,
            samples: self.reached().saturating_mul(REPLICATES as u32),
            is_buried: self.replicates.iter().all(|light| light.are_buried(0..count)),
        })
    }
}

impl MeterJob {
    /// Places the points of these meters in a scene. The camera of the view does not matter.
    pub fn new(scene: RenderScene, view: &View, asked: Vec<AskedMeter>) -> Result<Self, MeterError> {
        let mut meters = Vec::with_capacity(asked.len());
        let mut points = 0;
        for asked in asked {
            let metering = Metering::new(asked, &scene, view)?;
            points += metering.sites.texels.texels.len();
            if points > MOST_POINTS_OF_SCENE {
                return Err(MeterError::TooManyPoints(points));
            }
            meters.push(metering);
        }
        let view = View {
            light_groups: LightGroups::default(),
            ..view.clone()
        };
        Ok(Self { scene, view, meters })
    }

    /// The meters in their order.
    pub fn meters(&self) -> &[Metering] {
        &self.meters
    }

    /// The present values of all meters; None if one has none yet.
    pub fn readings(&self) -> Option<Vec<MeterReading>> {
        self.meters.iter().map(Metering::reading).collect()
    }

    /// The samples that every point has.
    pub fn least_samples(&self) -> u32 {
        let least = self.meters.iter().map(Metering::reached).min();
        least.unwrap_or_default().saturating_mul(REPLICATES as u32)
    }

    /// Rays traced, shadow rays included.
    pub fn rays(&self) -> u64 {
        let lights = self.meters.iter().flat_map(|meter| &meter.replicates);
        lights.map(|light| light.rays).sum()
    }

    /// The number of samples that were not finite, which count as black.
    pub fn invalid_samples(&self) -> u64 {
        let lights = self.meters.iter().flat_map(|meter| &meter.replicates);
        lights.map(|light| light.invalid).sum()
    }

    /// Measures until one of the limits is reached, on the threads of the pool. `watch` gets the finished share, from 0
    /// to 1, some times a second, and ends nothing. It ends soon after `cancel` is set; the values so far stay.
    pub fn run(
        &mut self,
        end: &MeterEnd,
        pool: &Arc<ThreadPool>,
        cancel: &AtomicBool,
        watch: &mut dyn FnMut(&Self, f64),
    ) -> MeterEnding {
        let begin = Instant::now();
        let most = end.samples.div_ceil(REPLICATES as u32).max(1);
        let mut pace = Pace::new(pool.current_num_threads());
        for meter in &mut self.meters {
            meter.goal = LEAST_SAMPLES.min(most);
        }
        let mut done = 0.0f64;
        loop {
            if cancel.load(Ordering::Relaxed) {
                return MeterEnding::Cancelled;
            }
            self.judge(most, end.noise);
            // A new estimate of the work may be higher than the last one.
            done = done.max(self.done(most));
            watch(self, done);
            if self.meters.iter().all(|meter| meter.is_done) {
                return MeterEnding::Done;
            }
            let is_late = end.time.is_some_and(|time| begin.elapsed() >= time);
            if is_late && self.meters.iter().all(|meter| meter.reached() > 0) {
                return MeterEnding::TimeUp;
            }
            let tasks = pace.blocks();
            pace.measure(|| pool.install(|| self.go_on(tasks, cancel)));
        }
    }

    /// Ends meters that have reached their goals and are certain enough; the others get goals twice as far.
    fn judge(&mut self, most: u32, noise: f64) {
        for meter in &mut self.meters {
            if meter.is_done || meter.reached() < meter.goal {
                continue;
            }
            let found = meter.noise();
            meter.is_done = meter.goal >= most || found <= noise;
            if !meter.is_done {
                // The error falls with the root of the number of samples, or faster.
                let needed = f64::from(meter.goal) * (found / noise).powi(2);
                meter.goal = meter.goal.saturating_mul(2).min(most);
                // A conversion to an integer saturates.
                meter.expected = (needed.ceil() as u32).clamp(meter.goal, most);
            }
        }
    }

    /// A rough share of the work that is done, counted in samples of points.
    fn done(&self, most: u32) -> f64 {
        let (mut reached, mut expected) = (0.0, 0.0);
        for meter in &self.meters {
            let points = meter.sites.texels.texels.len() as f64;
            let of_meter = f64::from(meter.reached());
            reached += points * of_meter;
            expected += points
                * match meter.is_done {
                    true => of_meter,
                    false => f64::from(meter.expected.min(most)).max(of_meter),
                };
        }
        if expected > 0.0 { reached / expected } else { 1.0 }
    }

    /// Adds samples to at most `tasks` sets of meters that have not reached their goals.
    fn go_on(&mut self, tasks: usize, cancel: &AtomicBool) {
        let (scene, view) = (&self.scene, &self.view);
        let mut waiting: Vec<(&Sites, u32, &mut Lightmaps, u32)> = Vec::new();
        let meters = self.meters.iter_mut().zip(0..);
        for (meter, number) in meters.filter(|(meter, _)| !meter.is_done) {
            let goal = meter.goal;
            let behind = meter.replicates.iter_mut().zip(0..);
            let behind = behind.filter(|(light, _)| light.reached() < goal);
            waiting.extend(behind.map(|(light, replicate)| {
                // Hashed, so that neighbouring seeds and meters have no set in common.
                let seed = pcg3d([view.seed, replicate, REPLICATES as u32 + number])[0];
                (&meter.sites, seed, light, goal)
            }));
        }
        // Those with the fewest samples come first, so that an end by time finds all equally far.
        waiting.sort_by_key(|(_, _, light, _)| light.reached());
        waiting.truncate(tasks);
        waiting.into_par_iter().for_each(|(sites, seed, light, goal)| {
            let gathering = Gathering {
                scene,
                view: &View { seed, ..view.clone() },
                light: ReceivedLight::All,
            };
            let end = light.round_end(goal).min(light.reached().saturating_add(MOST_AT_ONCE));
            light.go_on(&gathering, &sites.texels, end, usize::MAX, cancel);
        });
    }
}

/// Whether paths of these settings end at the first surface, so that no light comes to any point.
pub fn finds_no_light(view: &View) -> bool {
    view.integrator.settings().longest_path() <= 1
}
