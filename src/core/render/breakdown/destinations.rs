//! Where the light of lamps goes: how much of it arrives at each shape and stays there, traced from the lamps
//! (Veach 1997, chapter 4: light as particles).
//!
//! Each light path carries a part of the emitted power. At a surface it leaves what it does not carry on, so that the
//! absorbed power of all surfaces and what leaves the scene sum up to the emitted power, path by path. A surface may
//! receive the same light several times, after it was reflected. Media are ignored.

use std::collections::BTreeMap;

use super::account::{error_of_mean, mean_of, ratio};
use super::{BATCHES, Progress, of_batch};
use crate::color::{Rgb, luminance};
use crate::render::bidirectional::{Journey, journeys};
use crate::render::scene::RenderScene;
use crate::render::view::View;

/// The light paths of a task.
const PATHS_OF_TASK: u32 = 1024;

/// The power of one batch, by luminance.
#[derive(Clone, Copy, Debug, Default)]
struct Power {
    received: f64,
    absorbed: f64,
}

impl Power {
    fn add(&mut self, received: Rgb, absorbed: Rgb) {
        self.received += f64::from(luminance(received));
        self.absorbed += f64::from(luminance(absorbed));
    }
}

/// The power of some light paths.
#[derive(Clone, Debug, Default)]
struct Sums {
    emitted: f64,
    escaped: f64,
    landed: BTreeMap<u32, Power>,
}

impl Sums {
    fn add(&mut self, journey: &Journey) {
        // The rays of a sky begin all around the scene, and those that miss it tell nothing.
        if journey.is_from_infinity && journey.landings.is_empty() {
            return;
        }
        self.emitted += f64::from(luminance(journey.emitted));
        self.escaped += f64::from(luminance(journey.escaped));
        for landing in &journey.landings {
            let power = self.landed.entry(landing.instance).or_default();
            power.add(landing.received, landing.absorbed);
        }
    }

    fn append(&mut self, other: Self) {
        self.emitted += other.emitted;
        self.escaped += other.escaped;
        for (instance, power) in other.landed {
            let sum = self.landed.entry(instance).or_default();
            sum.received += power.received;
            sum.absorbed += power.absorbed;
        }
    }
}

/// The destinations of the light of all lamps of a scene.
#[derive(Clone, Debug)]
pub struct Destinations {
    batches: Vec<Sums>,
    /// The light paths of each batch.
    paths: u32,
}

/// The part of the emitted light that goes to one group of shapes. Powers are luminances of the power in W.
#[derive(Clone, Debug, PartialEq)]
pub struct Destination<K> {
    /// The group.
    pub key: K,
    /// The power that arrives there, repeated arrivals included.
    pub received: f32,
    /// The standard error of `received`.
    pub received_error: f32,
    /// The part of the emitted power that stays there.
    pub share: f32,
    /// The standard error of `share`.
    pub share_error: f32,
}

/// Traces about `paths` light paths of all lamps of `scene`, at least one for each batch. Tasks run on the threads of
/// the current `rayon` pool; the result does not depend on their number. None if cancelled.
pub fn destinations(scene: &RenderScene, view: &View, paths: u32, progress: &Progress) -> Option<Destinations> {
    let mut unbounded = view.clone();
    // Light goes on where the paths of a picture end.
    unbounded.integrator.settings_mut().max_depth = u32::MAX;
    let views: Vec<View> = (0..BATCHES).map(|batch| of_batch(&unbounded, batch)).collect();
    let paths = paths.div_ceil(BATCHES).max(1);
    let trace = |task: u64| {
        let batch = (task % u64::from(BATCHES)) as usize;
        let first = (task / u64::from(BATCHES)) as u32 * PATHS_OF_TASK;
        let mut sums = Sums::default();
        let last = paths.min(first.saturating_add(PATHS_OF_TASK));
        for number in first..last {
            if progress.is_cancelled() {
                return None;
            }
            let all = journeys(scene, &views[batch], number..number + 1);
            all.iter().for_each(|journey| sums.add(journey));
        }
        Some((batch, sums))
    };
    let mut batches = vec![Sums::default(); BATCHES as usize];
    let tasks = u64::from(BATCHES) * u64::from(paths.div_ceil(PATHS_OF_TASK));
    progress.follow(tasks, trace, |(batch, sums)| batches[batch].append(sums))?;
    Some(Destinations { batches, paths })
}

impl Destinations {
    /// The number of light paths that were traced.
    pub fn paths(&self) -> u64 {
        u64::from(self.paths) * self.batches.len() as u64
    }

    /// The emitted power with its standard error, in W by luminance. Of lamps at infinity it is that which meets a
    /// surface.
    pub fn emitted(&self) -> [f32; 2] {
        let values = self.values(|sums| sums.emitted);
        [mean_of(&values), error_of_mean(&values)].map(|value| value as f32)
    }

    /// The part of the emitted power that leaves the scene, with its standard error.
    pub fn escaped(&self) -> [f32; 2] {
        self.share(&self.values(|sums| sums.escaped))
    }

    /// Where the light goes by groups of shapes, those that absorb most first. `key` gives the group of an instance.
    pub fn by<K: Ord>(&self, key: impl Fn(u32) -> K) -> Vec<Destination<K>> {
        let mut groups: BTreeMap<K, Vec<Power>> = BTreeMap::new();
        for (batch, sums) in self.batches.iter().enumerate() {
            for (&instance, power) in &sums.landed {
                let group = groups.entry(key(instance));
                let powers = group.or_insert_with(|| vec![Power::default(); self.batches.len()]);
                powers[batch].received += power.received;
                powers[batch].absorbed += power.absorbed;
            }
        }
        let scale = 1.0 / f64::from(self.paths);
        let destination = |(key, powers): (K, Vec<Power>)| {
            let received: Vec<f64> = powers.iter().map(|power| scale * power.received).collect();
            let absorbed: Vec<f64> = powers.iter().map(|power| scale * power.absorbed).collect();
            let [share, share_error] = self.share(&absorbed);
            Destination {
                key,
                received: mean_of(&received) as f32,
                received_error: error_of_mean(&received) as f32,
                share,
                share_error,
            }
        };
        let mut all: Vec<Destination<K>> = groups.into_iter().map(destination).collect();
        all.sort_by(|one, other| other.share.total_cmp(&one.share));
        all
    }

    /// The mean power of each batch.
    fn values(&self, of: impl Fn(&Sums) -> f64) -> Vec<f64> {
        self.batches
            .iter()
            .map(|sums| of(sums) / f64::from(self.paths))
            .collect()
    }

    /// The part of the emitted power, and its standard error.
    fn share(&self, values: &[f64]) -> [f32; 2] {
        let emitted = self.values(|sums| sums.emitted);
        let whole = mean_of(&emitted);
        let share = ratio(mean_of(values), whole);
        let residuals: Vec<f64> = values
            .iter()
            .zip(&emitted)
            .map(|(own, all)| own - share * all)
            .collect();
        [share, ratio(error_of_mean(&residuals), whole)].map(|value| value as f32)
    }
}
