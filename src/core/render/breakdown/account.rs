//! Sums of light by route, and what follows from them: values, standard errors and portions of the variance.

use std::collections::BTreeMap;

use glam::{DVec3, UVec2};

use super::{Area, Batches, Route, Way, brightness, followed, of_batch};
use crate::color::Rgb;
use crate::render::inspect::{RecordedPath, record_paths};
use crate::render::scene::RenderScene;
use crate::render::view::View;

/// The most routes that are told apart. Light on further ones counts as [`Way::Other`].
const MOST_ROUTES: usize = 1 << 16;

/// The paths of a route that are kept as examples.
const EXAMPLES: usize = 8;

/// A path, by what it takes to trace it again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PathId {
    pub pixel: UVec2,
    pub batch: u32,
    pub sample: u32,
}

/// The light of one route in some samples of a pixel.
#[derive(Clone, Debug, Default)]
pub(super) struct Entry {
    light: DVec3,
    /// The first samples with light of the route.
    samples: Vec<u32>,
    /// The sum of the products of its luminance with that of all light of the sample.
    products: f64,
}

impl Entry {
    /// Adds `light` of sample number `sample`, which has the luminance `whole`.
    pub fn add(&mut self, light: DVec3, sample: u32, whole: f64) {
        // A path may find light of a route several times.
        if self.samples.len() < EXAMPLES && self.samples.last() != Some(&sample) {
            self.samples.push(sample);
        }
        self.light += light;
        self.products += brightness(light) * whole;
    }
}

/// The light of one route in some samples of several pixels.
#[derive(Clone, Debug, Default)]
struct Tally {
    light: DVec3,
    examples: Vec<(UVec2, u32)>,
    /// The sum of the products of deviations: of its luminance, and of the luminance of all light, from the means of
    /// their pixel.
    noise: f64,
}

/// The sums of a task.
#[derive(Debug, Default)]
pub(super) struct Account {
    tallies: BTreeMap<Route, Tally>,
}

impl Account {
    /// Adds a pixel, of which `samples` samples have the luminance `whole` in sum.
    pub fn add_pixel(&mut self, pixel: UVec2, routes: BTreeMap<Route, Entry>, whole: f64, samples: u32) {
        for (route, entry) in routes {
            let tally = place(&mut self.tallies, route);
            let room = EXAMPLES.saturating_sub(tally.examples.len());
            let examples = entry.samples.iter().take(room);
            tally.examples.extend(examples.map(|&sample| (pixel, sample)));
            tally.light += entry.light;
            tally.noise += entry.products - brightness(entry.light) * whole / f64::from(samples);
        }
    }
}

/// The value of a route, or of those like it if there are too many.
fn place<T: Default>(all: &mut BTreeMap<Route, T>, route: Route) -> &mut T {
    let is_room = all.len() < MOST_ROUTES || all.contains_key(&route);
    let route = match is_room {
        true => route,
        false => Route {
            way: Way::Other,
            ..route
        },
    };
    all.entry(route).or_default()
}

/// The light of one route in all batches.
#[derive(Clone, Debug, Default)]
struct Total {
    /// The sum of each batch; batches beyond the end have none.
    batches: Vec<DVec3>,
    noise: f64,
    examples: Vec<PathId>,
}

/// The light of an area by its routes.
#[derive(Clone, Debug)]
pub struct Breakdown {
    /// The pixels.
    pub area: Area,
    /// The samples of each of them.
    pub batches: Batches,
    /// The number of lights of the scene.
    pub lights: usize,
    totals: BTreeMap<Route, Total>,
}

/// The light of one group of routes.
#[derive(Clone, Debug, PartialEq)]
pub struct Portion<K> {
    /// The group.
    pub key: K,
    /// The mean radiance that it adds to the area's pixels, linear Rec. 709.
    pub light: Rgb,
    /// The luminance of that.
    pub luminance: f32,
    /// The standard error of the luminance.
    pub error: f32,
    /// Its part of the luminance of the area; 0 where that is black.
    pub share: f32,
    /// The standard error of `share`.
    pub share_error: f32,
    /// Its part of the variance of the samples, which is the sum over the groups of their covariances with the whole.
    /// Groups that vary against the others have a negative one.
    pub noise: f32,
}

impl Breakdown {
    pub(super) fn new(area: Area, batches: Batches, lights: usize) -> Self {
        Self {
            area,
            batches,
            lights,
            totals: BTreeMap::new(),
        }
    }

    /// Adds the account of a task of batch number `batch`.
    pub(super) fn add(&mut self, batch: usize, account: Account) {
        for (route, tally) in account.tallies {
            let total = place(&mut self.totals, route);
            if total.batches.len() <= batch {
                total.batches.resize(batch + 1, DVec3::ZERO);
            }
            total.batches[batch] += tally.light;
            total.noise += tally.noise;
            let room = EXAMPLES.saturating_sub(total.examples.len());
            let examples = tally.examples.into_iter().take(room);
            total.examples.extend(examples.map(|(pixel, sample)| PathId {
                pixel,
                batch: batch as u32,
                sample,
            }));
        }
    }

    /// At most `most` of the paths that have found light on routes of a group, with few of each route. `scene` and
    /// `view` are those that were broken down.
    pub fn example_paths(
        &self,
        scene: &RenderScene,
        view: &View,
        is_of_group: impl Fn(&Route) -> bool,
        most: usize,
    ) -> Vec<RecordedPath> {
        let totals = self.totals.iter().filter(|(route, _)| is_of_group(route));
        let mut ids: Vec<PathId> = Vec::new();
        for id in totals.flat_map(|(_, total)| &total.examples) {
            // A path may have found light on several routes of the group.
            if ids.len() < most && !ids.contains(id) {
                ids.push(*id);
            }
        }
        let view = followed(view);
        let paths = ids.into_iter().flat_map(|id| {
            let view = of_batch(&view, id.batch);
            record_paths(scene, &view, id.pixel, id.sample..id.sample + 1)
        });
        paths.collect()
    }

    /// The mean radiance of the area's pixels, linear Rec. 709, with the standard error of its luminance.
    pub fn value(&self) -> Portion<()> {
        let mut all = self.portions(|_| Some(()));
        all.pop().unwrap_or(Portion {
            key: (),
            light: Rgb::ZERO,
            luminance: 0.0,
            error: 0.0,
            share: 0.0,
            share_error: 0.0,
            noise: 0.0,
        })
    }

    /// The routes on which light has come.
    pub fn routes(&self) -> impl Iterator<Item = &Route> {
        self.totals.keys()
    }

    /// The light by groups, the brightest first. `key` gives the group of a route; routes without one are left out, and
    /// the other portions are still parts of the whole.
    pub fn portions<K: Ord + Clone>(&self, key: impl Fn(&Route) -> Option<K>) -> Vec<Portion<K>> {
        let count = self.batches.count as usize;
        let mut groups: BTreeMap<K, (Vec<DVec3>, f64)> = BTreeMap::new();
        let mut whole = vec![DVec3::ZERO; count];
        let mut variance = 0.0;
        for (route, total) in &self.totals {
            let add = |to: &mut Vec<DVec3>| to.iter_mut().zip(&total.batches).for_each(|(to, light)| *to += *light);
            add(&mut whole);
            variance += total.noise;
            if let Some(key) = key(route) {
                let group = groups.entry(key).or_insert_with(|| (vec![DVec3::ZERO; count], 0.0));
                add(&mut group.0);
                group.1 += total.noise;
            }
        }
        let samples = f64::from(self.batches.samples) * self.area.pixels() as f64;
        let whole: Vec<f64> = whole.iter().map(|sum| brightness(*sum) / samples).collect();
        let mean = mean_of(&whole);
        let portion = |(key, (sums, noise)): (K, (Vec<DVec3>, f64))| {
            let light = sums.iter().sum::<DVec3>() / (samples * count as f64);
            let values: Vec<f64> = sums.iter().map(|sum| brightness(*sum) / samples).collect();
            let own = mean_of(&values);
            let share = ratio(own, mean);
            let residuals: Vec<f64> = values.iter().zip(&whole).map(|(own, all)| own - share * all).collect();
            Portion {
                key,
                light: light.as_vec3(),
                luminance: own as f32,
                error: error_of_mean(&values) as f32,
                share: share as f32,
                share_error: ratio(error_of_mean(&residuals), mean.abs()) as f32,
                noise: ratio(noise, variance) as f32,
            }
        };
        let mut portions: Vec<Portion<K>> = groups.into_iter().map(portion).collect();
        portions.sort_by(|one, other| other.luminance.total_cmp(&one.luminance));
        portions
    }
}

pub(super) fn mean_of(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The standard error of the mean of independent values, of which there are at least two.
pub(super) fn error_of_mean(values: &[f64]) -> f64 {
    let (mean, count) = (mean_of(values), values.len() as f64);
    let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    (squares / (count * (count - 1.0))).sqrt()
}

/// `part / whole`; 0 where there is no whole.
pub(super) fn ratio(part: f64, whole: f64) -> f64 {
    match whole == 0.0 {
        true => 0.0,
        false => part / whole,
    }
}
