//! Sums of light by route, and what follows from them: values, standard errors and portions of the variance.

use std::collections::BTreeMap;

use glam::DVec3;

use super::{Area, Batches, Route, Way, brightness};
use crate::color::Rgb;

/// The most routes that are told apart. Light on further ones counts as [`Way::Other`].
const MOST_ROUTES: usize = 1 << 16;

/// The light of one route in some samples of a pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Entry {
    light: DVec3,
    /// The sum of the products of its luminance with that of all light of the sample.
    products: f64,
}

impl Entry {
    /// Adds `light` of a sample that has the luminance `whole`.
    pub fn add(&mut self, light: DVec3, whole: f64) {
        self.light += light;
        self.products += brightness(light) * whole;
    }
}

/// The light of one route in some samples of several pixels.
#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    light: DVec3,
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
    pub fn add_pixel(&mut self, routes: BTreeMap<Route, Entry>, whole: f64, samples: u32) {
        for (route, entry) in routes {
            let tally = place(&mut self.tallies, route);
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
        }
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
