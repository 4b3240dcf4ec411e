//! Sums of light by route, and what follows from them: values, standard errors and portions of the variance.

use std::collections::BTreeMap;

use glam::{DVec3, UVec2};

use super::{Area, Batches, Route, Way, brightness, followed, of_batch};
use crate::color::Rgb;
use crate::render::inspect::{RecordedPath, record_paths};
use crate::render::scene::RenderScene;
use crate::render::view::View;
use crate::sampling::hash::pcg3d;

/// The most routes that are told apart. Light on further ones counts as [`Way::Other`].
const MOST_ROUTES: usize = 1 << 16;

/// The most bounces of those further routes that are told apart.
const MOST_BOUNCES_OF_OTHERS: u32 = 64;

/// The variance that counts as rounding, as a part of the squared luminances: contributions have single precision.
const ROUNDING: f64 = 1e-10;

/// The most paths of a route that are kept as examples.
const EXAMPLES: usize = 8;

/// A path, by what it takes to trace it again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct PathId {
    pub pixel: UVec2,
    pub batch: u32,
    pub sample: u32,
}

impl PathId {
    /// A random number that depends on nothing else, so that paths with the least ones are a fair choice.
    fn rank(&self) -> [u32; 3] {
        pcg3d([self.pixel.x, self.pixel.y, self.batch.rotate_right(8) ^ self.sample])
    }
}

/// The paths of a route that are kept as examples: those of the least rank.
#[derive(Clone, Debug, Default)]
struct Examples(Vec<PathId>);

impl Examples {
    fn add(&mut self, id: PathId) {
        let place = self.0.partition_point(|known| known.rank() < id.rank());
        if place < EXAMPLES {
            self.0.insert(place, id);
            self.0.truncate(EXAMPLES);
        }
    }
}

/// The light of one route in the samples of a pixel.
#[derive(Clone, Debug, Default)]
struct Entry {
    light: DVec3,
    /// The path of the least rank with light of the route.
    example: Option<PathId>,
    /// The sum of the products of its luminance with the deviation of all light of the sample.
    products: f64,
}

/// The light in the samples of a pixel. Deviations are those from the luminance of the first sample: far smaller than
/// the luminances, so that their products lose no digits.
#[derive(Debug, Default)]
pub(super) struct PixelSums {
    entries: BTreeMap<Route, Entry>,
    first: Option<f64>,
    samples: u32,
    deviations: f64,
    squares: f64,
}

impl PixelSums {
    /// Adds a sample with the light that its path has found.
    pub fn add(&mut self, id: PathId, found: &[(Route, DVec3)]) {
        let whole: f64 = found.iter().map(|(_, light)| brightness(*light)).sum();
        let deviation = whole - *self.first.get_or_insert(whole);
        self.samples += 1;
        self.deviations += deviation;
        self.squares += whole * whole;
        for (route, light) in found {
            let entry = place(&mut self.entries, *route);
            if entry.example.is_none_or(|known| id.rank() < known.rank()) {
                entry.example = Some(id);
            }
            entry.light += *light;
            entry.products += brightness(*light) * deviation;
        }
    }
}

/// The light of one route in some samples of several pixels.
#[derive(Clone, Debug, Default)]
struct Tally {
    light: DVec3,
    examples: Examples,
    /// The sum of the products of deviations: of its luminance, and of the luminance of all light, from the means of
    /// their pixel.
    noise: f64,
}

/// The sums of a task.
#[derive(Debug, Default)]
pub(super) struct Account {
    tallies: BTreeMap<Route, Tally>,
    squares: f64,
}

impl Account {
    /// Adds a pixel.
    pub fn add_pixel(&mut self, pixel: PixelSums) {
        self.squares += pixel.squares;
        let deviation = pixel.deviations / f64::from(pixel.samples.max(1));
        for (route, entry) in pixel.entries {
            let tally = place(&mut self.tallies, route);
            // One path of each pixel, so that the examples are spread over all of them.
            entry.example.into_iter().for_each(|id| tally.examples.add(id));
            tally.light += entry.light;
            tally.noise += entry.products - brightness(entry.light) * deviation;
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
            bounces: route.bounces.min(MOST_BOUNCES_OF_OTHERS),
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
    examples: Examples,
}

/// The light of an area by its routes.
#[derive(Clone, Debug)]
pub struct Breakdown {
    /// The pixels.
    pub area: Area,
    /// The samples of each of them.
    pub batches: Batches,
    totals: BTreeMap<Route, Total>,
    /// The sum of the squared luminances of all samples.
    squares: f64,
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
    /// Groups that vary against the others have a negative one. 0 where all samples are alike but for rounding.
    pub noise: f32,
}

impl Breakdown {
    pub(super) fn new(area: Area, batches: Batches) -> Self {
        Self {
            area,
            batches,
            totals: BTreeMap::new(),
            squares: 0.0,
        }
    }

    /// Adds the account of a task of batch number `batch`.
    pub(super) fn add(&mut self, batch: usize, account: Account) {
        self.squares += account.squares;
        for (route, tally) in account.tallies {
            let total = place(&mut self.totals, route);
            if total.batches.len() <= batch {
                total.batches.resize(batch + 1, DVec3::ZERO);
            }
            total.batches[batch] += tally.light;
            total.noise += tally.noise;
            tally.examples.0.into_iter().for_each(|id| total.examples.add(id));
        }
    }

    /// At most `most` of the paths that have found light on routes of a group: one of each route in turns, the
    /// brightest route first, at random among the pixels. `scene` and `view` are those that were broken down.
    pub fn example_paths(
        &self,
        scene: &RenderScene,
        view: &View,
        is_of_group: impl Fn(&Route) -> bool,
        most: usize,
    ) -> Vec<RecordedPath> {
        let of_group = self.totals.iter().filter(|(route, _)| is_of_group(route));
        let mut totals: Vec<&Total> = of_group.map(|(_, total)| total).collect();
        let luminance = |total: &&Total| brightness(total.batches.iter().sum());
        totals.sort_by(|one, other| luminance(other).total_cmp(&luminance(one)));
        let mut ids: Vec<PathId> = Vec::new();
        let rounds = (0..EXAMPLES).flat_map(|round| totals.iter().filter_map(move |total| total.examples.0.get(round)));
        for id in rounds {
            if ids.len() >= most {
                break;
            }
            // A path may have found light on several routes of the group.
            if !ids.contains(id) {
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
        if variance <= ROUNDING * self.squares {
            variance = 0.0;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::LightId;
    use crate::render::breakdown::{Kind, Source};

    #[test]
    fn routes_beyond_the_most_share_few_places() {
        let route = |number: usize| Route {
            source: Source::Light(LightId(0)),
            way: Way::Surface {
                instance: number as u32,
                is_through: false,
            },
            bounces: number as u32,
            kind: Kind::Diffuse,
            is_caustic: false,
        };
        let mut sums = PixelSums::default();
        let id = PathId {
            pixel: UVec2::ZERO,
            batch: 0,
            sample: 0,
        };
        let most = MOST_ROUTES + 1000;
        let found: Vec<(Route, DVec3)> = (0..most).map(|number| (route(number), DVec3::ONE)).collect();
        sums.add(id, &found);
        assert_eq!(sums.entries.len(), MOST_ROUTES + 1);
        let light: DVec3 = sums.entries.values().map(|entry| entry.light).sum();
        assert_eq!(light, DVec3::splat(most as f64));
    }
}
