//! The choice of the integrator `auto` from a pilot run: path tracing, guided or not, or bidirectional path tracing.
//!
//! Bidirectional path tracing finds all light that path tracing finds and more, but a sample of it costs many times as
//! much. It pays off where it is less noisy by more than that. The noise of path tracing cannot be estimated from few
//! samples: light that it finds once in ten thousand samples is not among them, and the pilot would look noise-free. So
//! its second moment has two parts. Light that path tracing finds often, up to `COMMON` times the local brightness, is
//! measured with its own samples. Brighter samples are rare, and are estimated from bidirectional paths: for each of
//! them the density is known with which path tracing would find it (`Find::in_one`), which may be zero.
//!
//! Guided paths are treated alike, with the combined densities of guide and surfaces. But a guide has to be learnt
//! first, which costs more than the rest of the pilot. So it is tried only where path tracing is noisy and
//! bidirectional path tracing does not beat the usual gain of guides by far.
//!
//! All values are relative to the local brightness and bounded by it (`BRIGHTEST`), so that neither a bright spot nor a
//! rare sample dominates the choice. The cost of a sample is counted in rays, not in seconds. The pilot has its own
//! random numbers, and its film has the same number of pixels at every resolution. So the choice is a function of the
//! scene and the view, on any number of threads.

mod choice;

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use glam::UVec2;

pub use self::choice::{Choice, Method};
use self::choice::{WORTHWHILE, method};
use super::bidirectional::{self, Find, Techniques};
use super::guide::Guide;
use super::lanes::{self, Job};
use super::scene::RenderScene;
use super::view::{Integrator, Shown, Strategy, View};
use crate::color::luminance;
use crate::sampling::SequenceKind;
use crate::sampling::hash::pcg3d;

/// The edge of a square pilot film in pixels. Others have as many pixels.
const EDGE: f32 = 512.0;
/// The number of parts along each side of the picture, over which the pilot averages.
const PARTS: u32 = 8;
/// The pixels of a part in each stage. The second stage runs if the first leaves the choice in doubt.
const STAGES: [u32; 2] = [8, 32];
/// The samples of a pixel by path tracing, and by bidirectional path tracing.
const PATH_SAMPLES: u32 = 16;
const PAIR: u32 = 2;
/// The samples of path tracing that cost as much as one pixel of a stage.
const COST_OF_PIXEL: u64 = 48;
/// The largest cost of a pilot as a share of the picture's cost.
const SHARE: f64 = 0.03;
/// That share where path tracing is noisy, so that a guide may gain far more than its cost.
const SHARE_OF_NOISY: f64 = 0.04;
/// The time per ray of bidirectional path tracing, all work included, relative to that of path tracing: as measured,
/// see `benches/NOTES.md`.
const COST_OF_RAY: f64 = 5.0;
/// The time per guided ray, likewise relative.
const COST_OF_GUIDED_RAY: f64 = 1.25;
/// The samples of path tracing that cost as much as learning a guide, and as the guided samples of a pixel.
const COST_OF_LEARNING: u64 = 1 << 19;
const COST_OF_GUIDED_PIXEL: u64 = 24;
/// A guide is tried if the variance of a sample of path tracing is at least this, relative to the local brightness.
const NOISY: f64 = 3.0;
/// The gain of bidirectional path tracing from which on no guide is tried.
const BEYOND_GUIDES: f64 = 6.0;
/// A sample counts as rare if it is this many times as bright as its surroundings.
const COMMON: f32 = 16.0;
/// The largest brightness counted for a single path, relative to its surroundings: in any picture of less than
/// thousands of samples, path tracing misses brighter light.
const BRIGHTEST: f32 = 1024.0;
/// The least local brightness, relative to the picture's mean.
const DARK: f32 = 0.05;
/// The first stage suffices if the gain is off the threshold for bidirectional path tracing by more than this factor.
const CLEAR: f64 = 4.0;
/// Gains are limited to this and its reciprocal.
const LEAST_GAIN: f64 = 1e-6;
/// The seed of the pilot's random numbers.
const SEED: u32 = 0x5eed_a070;

/// The effort of the pilot for a picture. It depends on the number of samples alone, and equal budgets lead to equal
/// choices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Budget {
    stages: usize,
    guide: bool,
}

impl Budget {
    /// The budget of a picture with `samples` summed over all pixels.
    pub fn of(samples: u64) -> Self {
        Self {
            stages: stages(samples),
            guide: pays_for_guide(samples),
        }
    }
}

/// Whether a choice is made for a picture with `samples` summed over all pixels: fewer do not pay for a pilot, and
/// media allow path tracing alone.
pub fn has_choice(scene: &RenderScene, view: &View, samples: u64) -> bool {
    let settings = view.integrator.settings();
    let has_media = settings.media && !scene.media.is_empty();
    let is_usual = view.shown == Shown::Radiance && settings.strategy == Strategy::Mis;
    is_usual && settings.longest_path() > 2 && !has_media && pays_for_pilot(samples)
}

/// Whether a picture with `samples` summed over all pixels pays for a pilot.
pub fn pays_for_pilot(samples: u64) -> bool {
    stages(samples) > 0
}

/// The number of stages that a picture with this number of samples can pay for.
fn stages(samples: u64) -> usize {
    let budget = SHARE * samples as f64;
    let mut cost = 0;
    let is_within = |stage: &&u32| {
        cost += COST_OF_PIXEL * u64::from(**stage * PARTS * PARTS);
        cost as f64 <= budget
    };
    STAGES.iter().take_while(is_within).count()
}

/// Whether a picture with this number of samples can pay for learning a guide, and for the second stage with guided
/// samples.
fn pays_for_guide(samples: u64) -> bool {
    let pixels = |stage: usize| u64::from(STAGES[stage] * PARTS * PARTS);
    let cost = COST_OF_PIXEL * pixels(0) + COST_OF_LEARNING + (COST_OF_PIXEL + COST_OF_GUIDED_PIXEL) * pixels(1);
    cost as f64 <= SHARE_OF_NOISY * samples as f64
}

/// The view of the pilot for a view, whose integrator has the settings of paths. Equal pilot views lead to equal
/// choices.
pub fn pilot_view(view: &View) -> View {
    let ratio = (view.width as f32 / view.height as f32).sqrt();
    let side = |length: f32| length.round().max(1.0) as u32;
    View {
        width: side(EDGE * ratio),
        height: side(EDGE / ratio),
        integrator: Integrator::Path(view.integrator.settings()),
        before: None,
        sequence: SequenceKind::Independent,
        seed: SEED,
        photons: Default::default(),
        clamp: None,
        guide: None,
        ..view.clone()
    }
}

/// The choice for a picture with `samples` summed over all pixels, by a pilot on `threads` threads. `guide` is the
/// scene's guide, which may be learnt: those rays are then in [`Guide::rays_of_pilot`]. None if `cancel` was set in the
/// meantime.
pub fn choose(
    scene: &RenderScene,
    view: &View,
    guide: &Guide,
    samples: u64,
    threads: usize,
    cancel: &AtomicBool,
) -> Option<Choice> {
    if !has_choice(scene, view, samples) {
        return Some(Choice::UNTRIED);
    }
    let view = pilot_view(view);
    let size = UVec2::new(view.width, view.height);
    let pilot = |stage: usize, guide: Option<&Guide>| {
        let view = View {
            guide: guide.cloned(),
            ..view.clone()
        };
        trace(scene, &view, stage, threads, cancel)
    };
    let mut parts = pilot(0, None)?;
    let Some(mut found) = judge(&parts, size) else {
        return Some(Choice::UNTRIED);
    };
    let budget = Budget::of(samples);
    let is_tried = found.noise >= NOISY && found.gain < BEYOND_GUIDES && budget.guide;
    let is_in_doubt = (WORTHWHILE / CLEAR..WORTHWHILE * CLEAR).contains(&found.gain) && budget.stages > 1;
    let mut gain_of_guide = None;
    if is_tried || is_in_doubt {
        let second = pilot(1, is_tried.then_some(guide));
        if is_tried {
            guide.leave_rays_to_pilot();
        }
        let second = second?;
        gain_of_guide = judge(&second, size).and_then(|second| second.gain_of_guide);
        add(&mut parts, second);
        found = judge(&parts, size).unwrap_or(found);
    }
    Some(Choice {
        method: method(found.gain, gain_of_guide),
        gain: Some(found.gain as f32),
        gain_of_guide: gain_of_guide.map(|gain| gain as f32),
        missed: found.missed,
    })
}

/// The samples of a part of the picture.
#[derive(Default)]
struct Part {
    /// The luminances of path tracing, for each pixel.
    by_path: Vec<[f32; PATH_SAMPLES as usize]>,
    /// The luminances of guided paths, for each pixel; empty without a guide.
    guided: Vec<[f32; PATH_SAMPLES as usize]>,
    /// The samples of bidirectional path tracing, without light that light paths bring to the lens.
    pairs: Vec<[f32; PAIR as usize]>,
    /// The bidirectional paths found for the part's own pixels, and those sent to the lens, for any part.
    seen: Vec<Find>,
    sent: Vec<Find>,
    /// Rays by path tracing, by bidirectional path tracing, and by guided paths.
    rays: [u64; 3],
}

/// Traces a stage, with the parts distributed over the threads.
fn trace(scene: &RenderScene, view: &View, stage: usize, threads: usize, cancel: &AtomicBool) -> Option<Vec<Part>> {
    let count = (PARTS * PARTS) as usize;
    let next = AtomicUsize::new(0);
    let done: Vec<Mutex<Option<Part>>> = std::iter::repeat_with(Mutex::default).take(count).collect();
    let work = || {
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let Some(place) = done.get(number) else { return };
            let part = trace_part(scene, view, stage, number as u32, cancel);
            *place.lock().unwrap_or_else(PoisonError::into_inner) = part;
        }
    };
    std::thread::scope(|scope| {
        (1..threads.min(count)).for_each(|_| drop(scope.spawn(work)));
        work();
    });
    let part = |place: Mutex<Option<Part>>| place.into_inner().unwrap_or_else(PoisonError::into_inner);
    done.into_iter().map(part).collect()
}

fn trace_part(scene: &RenderScene, view: &View, stage: usize, number: u32, cancel: &AtomicBool) -> Option<Part> {
    let pixels = STAGES[stage];
    let place = |pixel: u32| {
        let [x, y, _] = pcg3d([number, pixel, SEED.wrapping_add(stage as u32)]);
        let along = |part: u32, length: u32, random: u32| {
            let (start, end) = (part * length / PARTS, (part + 1) * length / PARTS);
            (start + ((u64::from(random) * u64::from(end - start)) >> 32) as u32).min(length - 1)
        };
        UVec2::new(
            along(number % PARTS, view.width, x),
            along(number / PARTS, view.height, y),
        )
    };
    let jobs = |first: u32, samples: u32| {
        let job = move |pixel: u32, index: u32| Job {
            pixel: place(pixel),
            index: first + index,
        };
        (0..pixels).flat_map(move |pixel| (0..samples).map(move |index| job(pixel, index)))
    };
    let mut part = Part::default();
    let settings = view.integrator.settings();
    // Each pixel of each stage has its own random numbers, also where two pixels are the same.
    let first = stage as u32 * 64;
    let by_path: Vec<Job> = jobs(first, PATH_SAMPLES).collect();
    let light = |radiance, weight: f32| {
        let light = luminance(radiance) * weight;
        if light.is_finite() { light } else { 0.0 }
    };
    let of_pixel = |samples: &[(super::path::PathSample, f32)]| {
        std::array::from_fn(|index| light(samples[index].0.radiance, samples[index].1))
    };
    let by_paths = |view: &View| {
        let samples = lanes::trace(scene, view, &settings, &by_path, cancel)?.list;
        let rays = samples.iter().map(|(sample, _)| u64::from(sample.rays)).sum();
        let lights: Vec<_> = samples.chunks_exact(PATH_SAMPLES as usize).map(of_pixel).collect();
        Some((lights, rays))
    };
    let field = lanes::field(scene, view, &settings, cancel)?;
    if field.is_some() {
        (part.guided, part.rays[2]) = by_paths(view)?;
    }
    let view = View {
        guide: None,
        ..view.clone()
    };
    (part.by_path, part.rays[0]) = by_paths(&view)?;
    let view = View {
        integrator: Integrator::Bidirectional(settings),
        ..view
    };
    let (settings, techniques) = Techniques::of(&view)?;
    let none = std::iter::empty();
    let mut tracer = bidirectional::Tracer::new(scene, &view, settings, techniques, none, cancel)?;
    tracer.note_finds(field);
    let mut lights = Vec::new();
    for job in jobs(first + PATH_SAMPLES, PAIR) {
        if cancel.load(Ordering::Relaxed) {
            return None;
        }
        let (sample, weight) = tracer.sample(job.pixel, job.index, &mut ());
        part.rays[1] += u64::from(sample.rays);
        lights.push(light(sample.radiance, weight));
    }
    part.pairs = lights
        .chunks_exact(PAIR as usize)
        .map(|pair| [pair[0], pair[1]])
        .collect();
    let finds = tracer.take_finds();
    (part.sent, part.seen) = finds.into_iter().partition(|find| find.pixel.is_some());
    Some(part)
}

/// Adds the samples of another stage.
fn add(parts: &mut Vec<Part>, stage: Vec<Part>) {
    parts.resize_with(stage.len(), Part::default);
    for (part, mut new) in parts.iter_mut().zip(stage) {
        part.by_path.append(&mut new.by_path);
        part.guided.append(&mut new.guided);
        part.pairs.append(&mut new.pairs);
        part.seen.append(&mut new.seen);
        part.sent.append(&mut new.sent);
        part.rays.iter_mut().zip(new.rays).for_each(|(rays, new)| *rays += new);
    }
}

/// The estimates from the samples of a pilot.
struct Judgement {
    /// The variance of a sample of path tracing, relative to the local brightness.
    noise: f64,
    /// The gain of bidirectional path tracing, and that of guided paths if all parts have some.
    gain: f64,
    gain_of_guide: Option<f64>,
    missed: f32,
}

/// The estimates from all parts for a picture of this size; None where path tracing has no noise.
fn judge(parts: &[Part], size: UVec2) -> Option<Judgement> {
    let pairs: usize = parts.iter().map(|part| part.pairs.len()).sum();
    let paths = f64::from(PAIR) * pairs.max(1) as f64;
    let pixels = f64::from(size.x) * f64::from(size.y);
    let mut sent: Vec<Vec<Find>> = vec![Vec::new(); parts.len()];
    for find in parts.iter().flat_map(|part| &part.sent) {
        if let Some(pixel) = find.pixel {
            let along = |place: u32, length: u32| (place * PARTS / length).min(PARTS - 1);
            sent[(along(pixel.y, size.y) * PARTS + along(pixel.x, size.x)) as usize].push(*find);
        }
    }
    // The parts have about equally many pixels.
    let of_sent = pixels / paths / (pixels / parts.len().max(1) as f64);
    let sums: Vec<Sums> = parts
        .iter()
        .zip(&sent)
        .map(|(part, sent)| Sums { part, sent, of_sent })
        .collect();
    let mean = sums.iter().map(Sums::light).sum::<f64>() / sums.len().max(1) as f64;
    if mean <= 0.0 {
        return None;
    }
    let (mut by_path, mut guided, mut bidirectional, mut missed) = (0.0, 0.0, 0.0, 0.0);
    for sums in &sums {
        let place = sums.light().max(f64::from(DARK) * mean) as f32;
        let scale = f64::from(place) * f64::from(place);
        by_path += sums.variance_by_path(&sums.part.by_path, place, |find| find.in_one) / scale;
        guided += sums.variance_by_path(&sums.part.guided, place, |find| find.in_guided) / scale;
        bidirectional += sums.variance_bidirectional(place) / scale;
        missed += sums.of_finds(|find| {
            if find.in_one.is_finite() {
                0.0
            } else {
                f64::from(find.light)
            }
        });
    }
    let rays = |method: usize| parts.iter().map(|part| part.rays[method] as f64).sum::<f64>();
    let samples = |of_pixel: u32| f64::from(of_pixel) * pairs.max(1) as f64;
    let of_path = (rays(0) / samples(PATH_SAMPLES)).max(1.0);
    let cost = COST_OF_RAY * (rays(1) / samples(PAIR)) / of_path;
    let cost_of_guided = COST_OF_GUIDED_RAY * (rays(2) / samples(PATH_SAMPLES)).max(1.0) / of_path;
    if by_path <= 0.0 {
        // Both methods are without noise.
        return None;
    }
    let gain = |variance: f64, cost: f64| {
        (by_path / (variance * cost).max(f64::MIN_POSITIVE)).clamp(LEAST_GAIN, 1.0 / LEAST_GAIN)
    };
    let is_guided = parts.iter().all(|part| part.guided.len() == part.by_path.len());
    Some(Judgement {
        noise: by_path / sums.len() as f64,
        gain: gain(bidirectional, cost),
        gain_of_guide: is_guided.then(|| gain(guided, cost_of_guided)),
        missed: (missed / (mean * sums.len() as f64)).min(1.0) as f32,
    })
}

/// The sums over the samples of a part.
struct Sums<'a> {
    part: &'a Part,
    /// The paths from the lights that reach the lens in this part.
    sent: &'a [Find],
    /// The factor that turns the sum of that light into the mean over the part's pixels.
    of_sent: f64,
}

impl Sums<'_> {
    /// The mean over the part's samples of a number for each of their finds.
    fn of_finds(&self, number: impl Fn(&Find) -> f64) -> f64 {
        let of_seen = 1.0 / (f64::from(PAIR) * self.part.pairs.len().max(1) as f64);
        let sum = |finds: &[Find]| finds.iter().map(&number).sum::<f64>();
        of_seen * sum(&self.part.seen) + self.of_sent * sum(self.sent)
    }

    /// The mean luminance, by bidirectional path tracing.
    fn light(&self) -> f64 {
        let seen: f64 = self.part.pairs.iter().flatten().map(|&light| f64::from(light)).sum();
        let sent: f64 = self.sent.iter().map(|find| f64::from(find.light)).sum();
        seen / (f64::from(PAIR) * self.part.pairs.len().max(1) as f64) + self.of_sent * sent
    }

    /// The variance of a sample of path tracing, given these samples and the local luminance.
    fn variance_by_path(
        &self,
        samples: &[[f32; PATH_SAMPLES as usize]],
        place: f32,
        in_one: impl Fn(&Find) -> f32,
    ) -> f64 {
        let of_pixel = |lights: &[f32; PATH_SAMPLES as usize]| {
            let lights = lights.map(|light| f64::from(light.min(COMMON * place)));
            let mean = lights.iter().sum::<f64>() / lights.len() as f64;
            lights.iter().map(|light| (light - mean).powi(2)).sum::<f64>() / (lights.len() - 1) as f64
        };
        let common: f64 = samples.iter().map(of_pixel).sum();
        let rare = |find: &Find| match in_one(find) > COMMON * place {
            true => f64::from(find.light) * f64::from(in_one(find).min(BRIGHTEST * place)),
            false => 0.0,
        };
        common / samples.len().max(1) as f64 + self.of_finds(rare)
    }

    /// The variance of a sample of bidirectional path tracing, given the local luminance. Of very many light paths few
    /// reach the lens here, so that their variance is their second moment.
    fn variance_bidirectional(&self, place: f32) -> f64 {
        let clipped = |light: f32| f64::from(light.min(BRIGHTEST * place));
        let of_pair = |pair: &[f32; PAIR as usize]| 0.5 * (clipped(pair[0]) - clipped(pair[1])).powi(2);
        let seen: f64 = self.part.pairs.iter().map(of_pair).sum();
        let sent: f64 = self.sent.iter().map(|find| clipped(find.light).powi(2)).sum();
        seen / self.part.pairs.len().max(1) as f64 + self.of_sent * sent
    }
}
