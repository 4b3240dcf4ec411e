//! Finds the brightness limit of a view with a [clamp](super::clamp), and darkens brighter samples to it.

use std::sync::atomic::AtomicBool;

use glam::{UVec2, Vec2};

use super::bidirectional::photon_paths;
use super::clamp::BrightnessLimit;
use super::lanes::Job;
use super::path::PathSample;
use super::scene::RenderScene;
use super::splats::{Splat, TileSplats};
use super::tracer::Tracer;
use super::view::{Integrator, View};
use crate::color::luminance;

/// The number of samples of a pilot.
const SAMPLES: u32 = 1 << 15;
/// The samples of a part of a pilot, which one worker traces in one go.
const BATCH: u32 = 2048;
/// The fewest sample numbers of a pixel in a pilot.
const NUMBERS: u32 = 16;
/// The light paths for the photons of a pilot, unless [`FEWEST_ROUNDS`] have more. All samples with one number share
/// the same photons; if each had its own, photons would cost far more than the samples.
const PHOTON_PATHS: u32 = 1 << 18;
/// The fewest sample numbers of a pilot with photons.
const FEWEST_ROUNDS: u32 = 4;
/// The seed of pilots: limits do not depend on the seed of the picture.
const SEED: u32 = 0x5eed_c1a3;

/// The limit of a view that clamps its samples; None without a clamp, and if `cancel` was set.
pub(super) fn limit(scene: &RenderScene, view: &View, cancel: &AtomicBool) -> Option<BrightnessLimit> {
    let clamp = view.clamp.as_ref()?;
    let from_lights = view.integrator.splats() && !view.film_layers().parts_light();
    let place = (&view.camera, [view.width, view.height]);
    let pilot = View {
        seed: SEED,
        clamp: None,
        ..view.clone()
    };
    clamp.limit(
        scene,
        place,
        from_lights,
        SAMPLES / BATCH,
        |part| trace(scene, &pilot, part, cancel),
        |parts| limit_of(parts, clamp.percentile),
        cancel,
    )
}

/// The result of a part of a pilot.
#[derive(Default)]
pub(super) struct Pilot {
    /// The luminances of the samples that have light, without directly visible light.
    light: Vec<f32>,
    /// The sum of all directly visible light.
    seen: f64,
}

/// Traces a part of the samples, which are spread evenly over the film; None if cancelled.
fn trace(scene: &RenderScene, view: &View, part: u32, cancel: &AtomicBool) -> Option<Pilot> {
    let mut found = Pilot::default();
    let numbers = Numbers::of(view);
    let jobs = (part * BATCH..(part + 1) * BATCH).map(|index| job(view, index, numbers));
    let mut splats = TileSplats::default();
    let mut traced = Tracer::of(view).trace(scene, view, jobs.clone(), cancel)?;
    for job in jobs {
        let (sample, weight) = traced.next(job);
        let light = luminance(sample.radiance - sample.seen) * weight.abs();
        if light.is_finite() {
            found.light.extend((light > 0.0).then_some(light));
            found.seen += f64::from(luminance(sample.seen) * weight.abs());
        }
    }
    traced.take_splats(&mut splats);
    // Filters with negative lobes make negative light.
    let lights = splats.list.iter().map(|splat| luminance(splat.radiance).abs());
    found
        .light
        .extend(lights.filter(|light| *light > 0.0 && light.is_finite()));
    Some(found)
}

/// The sample numbers of a pilot: their count and their spacing.
#[derive(Clone, Copy)]
struct Numbers {
    count: u32,
    step: u32,
}

impl Numbers {
    /// Many unless they are expensive, and more if there are few pixels.
    fn of(view: &View) -> Self {
        let many = NUMBERS.max(SAMPLES.div_ceil(view.width * view.height));
        let count = match view.integrator {
            Integrator::Merging(_, photons) => {
                (PHOTON_PATHS / photon_paths(view, photons).max(1)).clamp(FEWEST_ROUNDS, many)
            }
            _ => many,
        };
        // Later numbers have photons with smaller merging radii.
        let step = many / count;
        Self { count, step }
    }
}

/// A sample at the point number `index` of an even sequence over the film (M. Roberts, "The Unreasonable Effectiveness
/// of Quasirandom Sequences", 2018).
fn job(view: &View, index: u32, numbers: Numbers) -> Job {
    const STEP: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3];
    let size = UVec2::new(view.width, view.height);
    let [x, y] = STEP.map(|step| (f64::from(index) * step).fract() as f32);
    let pixel = (Vec2::new(x, y) * size.as_vec2()).as_uvec2().min(size - 1);
    Job {
        pixel,
        index: index % numbers.count * numbers.step,
    }
}

fn limit_of(parts: Vec<Pilot>, percentile: f32) -> BrightnessLimit {
    let seen: f64 = parts.iter().map(|part| part.seen).sum();
    let mut pilot = Pilot {
        light: parts.into_iter().flat_map(|part| part.light).collect(),
        seen,
    };
    pilot.light.sort_unstable_by(f32::total_cmp);
    let place = (f64::from(percentile) / 100.0 * pilot.light.len() as f64) as usize;
    let Some(&limit) = pilot.light.get(place.min(pilot.light.len().saturating_sub(1))) else {
        // Without light there is no limit on its brightness.
        return BrightnessLimit {
            luminance: f32::INFINITY,
            removed: 0.0,
        };
    };
    let sum = |light: &mut dyn Iterator<Item = f32>| light.map(f64::from).sum::<f64>();
    let all = sum(&mut pilot.light.iter().copied()) + pilot.seen;
    let above = sum(&mut pilot.light[place.min(pilot.light.len())..]
        .iter()
        .map(|light| light - limit));
    BrightnessLimit {
        luminance: limit,
        removed: (above / all) as f32,
    }
}

impl BrightnessLimit {
    /// The factor on the light of a sample, which has the weight `weight`. Directly visible light does not count.
    pub(super) fn share(&self, sample: &PathSample, weight: f32) -> f32 {
        let [all, seen] = [sample.radiance, sample.seen].map(|light| luminance(light) * weight.abs());
        if all - seen > self.luminance {
            (seen + self.luminance) / all
        } else {
            1.0
        }
    }

    /// Darkens splats that are too bright.
    pub(super) fn clamp_splats(&self, splats: &mut [Splat]) {
        for splat in splats {
            let light = luminance(splat.radiance).abs();
            if light > self.luminance {
                splat.radiance *= self.luminance / light;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_percentile_of_the_light_is_the_limit() {
        let pilot = || Pilot {
            light: (1..=100).rev().map(|light| light as f32).collect(),
            seen: 50.0,
        };
        // The limit is the first of the ten samples above 90, which exceed it by 0 to 9.
        let limit = limit_of(vec![pilot()], 90.0);
        assert_eq!(limit.luminance, 91.0);
        assert!((limit.removed - 45.0 / 5100.0).abs() < 1e-6, "{limit:?}");
        assert_eq!(limit_of(vec![pilot()], 99.999).removed, 0.0);
        let dark = limit_of(vec![Pilot::default()], 99.0);
        assert_eq!((dark.luminance, dark.removed), (f32::INFINITY, 0.0));
    }
}
