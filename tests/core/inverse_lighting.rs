//! Lamps that are found from the light that is wanted: those that made it come back, and contradictions give the answer
//! of an independent solver.

use glam::{Vec2, Vec3};
use sunroom::color::{LUMINANCE, Rgb};
use sunroom::inverse_lighting::{
    Fit, LampLight, LampLimits, Limit, Observation, Observations, PULL, Painting, Stroke, Target, Unsolvable, Wanted,
    Wish, solve,
};

use crate::split_mix::Random;

const SIZE: [u32; 2] = [160, 100];
const MOST: f32 = 10.0;

/// From 0 to 1.
fn unit(random: &mut Random) -> f32 {
    (random.next() >> 40) as f32 / (1 << 24) as f32
}

/// A floor with a pattern under a row of lamps, the light of each in a layer.
struct Floor {
    layers: Vec<Vec<Rgb>>,
    rest: Rgb,
}

impl Floor {
    fn new(lamps: usize, seed: u64) -> Self {
        let mut random = Random(seed);
        let lamp = |_| {
            let place = Vec2::new(unit(&mut random) * 1.6, unit(&mut random));
            let height = 0.1 + 0.2 * unit(&mut random);
            let color = Vec3::new(1.0, 0.6 + 0.4 * unit(&mut random), 0.3 + 0.7 * unit(&mut random));
            let light = |pixel: u32| {
                let at = Vec2::new((pixel % SIZE[0]) as f32, (pixel / SIZE[0]) as f32) / SIZE[1] as f32;
                let squared = at.distance_squared(place) + height * height;
                albedo(pixel) * color * (height * height * height / (squared * squared)) / 10.0
            };
            (0..SIZE[0] * SIZE[1]).map(light).collect()
        };
        Self {
            layers: (0..lamps).map(lamp).collect(),
            rest: Rgb::splat(0.01),
        }
    }

    fn picture(&self, gains: &[Rgb]) -> Vec<Option<Rgb>> {
        let pixel = |pixel: usize| {
            let lamps = self.layers.iter().zip(gains);
            Some(self.rest + lamps.map(|(layer, &gain)| layer[pixel] * gain).sum::<Rgb>())
        };
        (0..self.layers.first().map_or(0, Vec::len)).map(pixel).collect()
    }

    fn fit(&self, targets: &[Target], limits: &[LampLimits]) -> Result<Fit, Unsolvable> {
        solve(&Painting { targets }.observations(self, limits), limits)
    }
}

impl LampLight for Floor {
    fn size(&self) -> [u32; 2] {
        SIZE
    }

    fn at(&self, x: u32, y: u32, light: &mut [Rgb]) -> Option<(Rgb, Rgb)> {
        let pixel = y * SIZE[0] + x;
        for (light, layer) in light.iter_mut().zip(&self.layers) {
            *light = layer[pixel as usize];
        }
        Some((self.rest, albedo(pixel)))
    }
}

fn albedo(pixel: u32) -> Rgb {
    let is_dark = (pixel % SIZE[0] / 20 + pixel / SIZE[0] / 20).is_multiple_of(2);
    Rgb::splat(if is_dark { 0.2 } else { 0.7 })
}

fn random_gains(count: usize, colored: bool, seed: u64) -> Vec<Rgb> {
    let mut random = Random(seed);
    let gain = |_| {
        let strength = 0.1 + 3.0 * unit(&mut random);
        match colored {
            true => strength * Rgb::new(1.0, unit(&mut random), unit(&mut random)),
            false => Rgb::splat(strength),
        }
    };
    (0..count).map(gain).collect()
}

fn limits(count: usize, colored: bool) -> Vec<LampLimits> {
    let lamp = LampLimits {
        colored,
        ..LampLimits::of_strength(MOST)
    };
    vec![lamp; count]
}

/// The largest error of a gain, as a share of the strength of the true one.
fn worst(found: &[Rgb], truth: &[Rgb]) -> f32 {
    let errors = found.iter().zip(truth);
    let errors = errors.map(|(found, truth)| (*found - *truth).abs().max_element() / truth.max_element());
    errors.fold(0.0, f32::max)
}

#[test]
fn lamps_that_made_a_picture_come_back() {
    for (scene, lamps) in [1, 3, 6, 12, 18, 24].into_iter().enumerate() {
        let floor = Floor::new(lamps, scene as u64);
        for colored in [false, true] {
            let truth = random_gains(lamps, colored, 100 + scene as u64);
            let picture = floor.picture(&truth);
            let fit = floor.fit(&[Target::Picture(&picture)], &limits(lamps, colored));
            let fit = fit.expect("an answer");
            let error = worst(&fit.gains, &truth);
            assert!(error < 0.01, "{lamps} lamps, colours {colored}: {error}");
            assert!(fit.limits.iter().all(Option::is_none), "{:?}", fit.limits);
            assert!(fit.error < 0.001, "{}", fit.error);
        }
    }
}

/// For a target with noise the error of the gains e has e'Me / variance distributed as chi squared, where M is the
/// matrix of the normal equations.
#[test]
fn noise_of_the_target_moves_gains_as_far_as_statistics_say() {
    const LAMPS: usize = 24;
    const ROUNDS: usize = 20;
    let mut random = Random(7);
    let mut sum = 0.0;
    for round in 0..ROUNDS {
        let light: Vec<Rgb> = (0..600 * LAMPS)
            .map(|_| Rgb::new(unit(&mut random), unit(&mut random), unit(&mut random)))
            .collect();
        let truth = random_gains(LAMPS, false, round as u64);
        let mut observations = Observations::new(LAMPS);
        // The sum of twelve uniform numbers has a variance of one, and is nearly normal.
        let deviation = 0.05;
        let mut normal = || (0..12).map(|_| unit(&mut random)).sum::<f32>() - 6.0;
        for light in light.chunks(LAMPS) {
            let exact: Rgb = light.iter().zip(&truth).map(|(&light, &gain)| light * gain).sum();
            let noise = deviation * Rgb::new(normal(), normal(), normal());
            observations.push(observation(Wanted::Color(exact + noise)), light);
        }
        let fit = solve(&observations, &limits(LAMPS, false)).expect("an answer");
        for light in light.chunks(LAMPS) {
            let errors = light.iter().zip(fit.gains.iter().zip(&truth));
            let error: Rgb = errors.map(|(&light, (&found, &truth))| light * (found - truth)).sum();
            sum += f64::from(error.length_squared() / (deviation * deviation));
        }
    }
    let freedom = (LAMPS * ROUNDS) as f64;
    let z = (sum - freedom) / (2.0 * freedom).sqrt();
    assert!(z.abs() < 4.0, "{z} standard deviations");
}

/// Noise in the layers themselves would make a fit to single pixels underrate the lamps.
#[test]
fn noise_of_the_layers_is_averaged_away() {
    let exact = Floor::new(6, 3);
    let truth = random_gains(6, false, 4);
    let picture = exact.picture(&truth);
    let mut random = Random(5);
    let mut noisy = Floor::new(6, 3);
    for light in noisy.layers.iter_mut().flatten() {
        // As with few samples: a third of the pixels have three times the light.
        *light *= if unit(&mut random) < 1.0 / 3.0 { 3.0 } else { 0.0 };
    }
    let fit = noisy
        .fit(&[Target::Picture(&picture)], &limits(6, false))
        .expect("an answer");
    let mut pixels = Observations::new(6);
    for (place, wanted) in picture.iter().copied().flatten().enumerate() {
        let light: Vec<Rgb> = noisy.layers.iter().map(|layer| layer[place]).collect();
        let one = Observation {
            rest: noisy.rest,
            level: wanted.dot(LUMINANCE),
            ..observation(Wanted::Color(wanted))
        };
        pixels.push(one, &light);
    }
    let of_pixels = solve(&pixels, &limits(6, false)).expect("an answer");
    let error = |fit: &Fit| {
        let pairs = fit.gains.iter().zip(&truth);
        pairs
            .map(|(found, truth)| (found.x - truth.x).abs() / truth.x)
            .sum::<f32>()
            / 6.0
    };
    assert!(
        error(&fit) < 0.25 * error(&of_pixels),
        "{} {}",
        error(&fit),
        error(&of_pixels)
    );
}

fn observation(wanted: Wanted) -> Observation {
    Observation {
        wanted,
        rest: Rgb::ZERO,
        weight: 1.0,
        level: 1.0,
        stroke: 0,
    }
}

/// Cyclic coordinate descent on the rows as they are, which shares no code with the kernel.
fn descend(observations: &Observations, limits: &[LampLimits]) -> Vec<f64> {
    let unknowns: Vec<(usize, Option<usize>)> = limits
        .iter()
        .enumerate()
        .flat_map(|(lamp, limits)| match limits.colored {
            true => vec![(lamp, Some(0)), (lamp, Some(1)), (lamp, Some(2))],
            false => vec![(lamp, None)],
        })
        .collect();
    let mut rows: Vec<(Vec<f64>, f64, f64)> = Vec::new();
    for (place, one) in observations.list().iter().enumerate() {
        let light = observations.light(place);
        let of_channel = |channel: usize| -> Vec<f64> {
            let of_unknown = |&(lamp, own): &(usize, Option<usize>)| match own {
                Some(own) if own != channel => 0.0,
                _ => f64::from(light[lamp][channel]),
            };
            unknowns.iter().map(of_unknown).collect()
        };
        let channels = [0, 1, 2].map(of_channel);
        let weight = f64::from(one.weight) / f64::from(one.level).powi(2);
        match one.wanted {
            Wanted::Color(color) => {
                for (channel, row) in channels.into_iter().enumerate() {
                    rows.push((row, f64::from(color[channel] - one.rest[channel]), weight / 3.0));
                }
            }
            Wanted::Luminance(wanted) => {
                let row = (0..unknowns.len()).map(|unknown| {
                    let parts = (0..3).map(|channel| channels[channel][unknown] * f64::from(LUMINANCE[channel]));
                    parts.sum()
                });
                rows.push((row.collect(), f64::from(wanted - one.rest.dot(LUMINANCE)), weight));
            }
        }
    }
    let total: f64 = observations.list().iter().map(|one| f64::from(one.weight)).sum();
    let mut values = vec![1.0; unknowns.len()];
    for _ in 0..4000 {
        for unknown in 0..unknowns.len() {
            let (mut slope, mut curvature) = (PULL * (values[unknown] - 1.0), PULL);
            for (row, wanted, weight) in &rows {
                let shown: f64 = row.iter().zip(&values).map(|(row, value)| row * value).sum();
                slope += weight / total * row[unknown] * (shown - wanted);
                curvature += weight / total * row[unknown] * row[unknown];
            }
            let limits = limits[unknowns[unknown].0];
            values[unknown] = (values[unknown] - slope / curvature).clamp(limits.least.into(), limits.most.into());
        }
    }
    values
}

#[test]
fn contradictions_give_the_answer_of_an_independent_solver() {
    const LAMPS: usize = 8;
    for seed in 0..6 {
        let mut random = Random(seed);
        let mut limits = limits(LAMPS, false);
        for (lamp, limits) in limits.iter_mut().enumerate() {
            limits.colored = lamp % 3 == 0;
            limits.most = 0.5 + 2.0 * unit(&mut random);
            limits.least = 0.4 * unit(&mut random);
        }
        let mut observations = Observations::new(LAMPS);
        for place in 0..40 {
            let light: Vec<Rgb> = (0..LAMPS)
                .map(|_| Rgb::new(unit(&mut random), unit(&mut random), unit(&mut random)))
                .collect();
            let level = 8.0 * unit(&mut random);
            let wanted = match place % 2 {
                0 => Wanted::Color(Rgb::new(level, 8.0 * unit(&mut random), 1.0)),
                _ => Wanted::Luminance(level),
            };
            let one = Observation {
                rest: Rgb::splat(0.1),
                weight: unit(&mut random),
                level: 0.5 + unit(&mut random),
                stroke: place % 3,
                ..observation(wanted)
            };
            observations.push(one, &light);
        }
        let fit = solve(&observations, &limits).expect("an answer");
        let expected = descend(&observations, &limits);
        let mut found = Vec::new();
        for (gain, limits) in fit.gains.iter().zip(&limits) {
            let count = if limits.colored { 3 } else { 1 };
            found.extend(gain.to_array().into_iter().take(count).map(f64::from));
        }
        for (found, expected) in found.iter().zip(&expected) {
            assert!((found - expected).abs() < 1e-4, "seed {seed}: {found} {expected}");
        }
        let is_held = fit.limits.iter().filter(|limit| limit.is_some()).count();
        assert!(is_held >= 2 && fit.error > 0.1, "{fit:?}");
        for ((gain, limit), limits) in fit.gains.iter().zip(&fit.limits).zip(&limits) {
            assert!(gain.min_element() >= limits.least && gain.max_element() <= limits.most);
            match limit {
                Some(Limit::Least) => assert_eq!(gain.min_element(), limits.least),
                Some(Limit::Most) => assert_eq!(gain.max_element(), limits.most),
                None => {}
            }
        }
        assert_eq!(fit.errors.len(), 3);
    }
}

fn stroke(wish: Wish, at: Vec2) -> Stroke {
    Stroke {
        wish,
        path: vec![at],
        radius: 0.1,
        hardness: 0.5,
    }
}

#[test]
fn a_lamp_that_limits_is_named() {
    let mut floor = Floor::new(2, 1);
    floor.rest = Rgb::ZERO;
    let brighter = stroke(Wish::Brighter(5.0), Vec2::splat(0.5));
    let weak = vec![LampLimits::of_strength(2.0); 2];
    let fit = floor.fit(&[Target::Stroke(&brighter)], &weak).expect("an answer");
    assert_eq!(fit.limits, [Some(Limit::Most); 2]);
    assert_eq!(fit.gains, [Rgb::splat(2.0); 2]);
    assert!(fit.error > 0.5, "{}", fit.error);
    let strong = vec![LampLimits::of_strength(20.0); 2];
    let fit = floor.fit(&[Target::Stroke(&brighter)], &strong).expect("an answer");
    assert_eq!(fit.limits, [None; 2]);
    assert!(fit.error < 0.05, "{}", fit.error);
    // Light that does not come from the lamps would have to be taken away.
    floor.rest = Rgb::splat(0.01);
    let dark = stroke(Wish::Luminance(0.0), Vec2::splat(0.5));
    let fit = floor.fit(&[Target::Stroke(&dark)], &strong).expect("an answer");
    assert_eq!(
        (fit.gains, fit.limits),
        (vec![Rgb::ZERO; 2], vec![Some(Limit::Least); 2])
    );
}

#[test]
fn a_wide_range_does_not_turn_off_a_lamp() {
    let floor = Floor::new(1, 1);
    let darker = stroke(Wish::Darker(2.0), Vec2::splat(0.5));
    let wide = vec![LampLimits::of_strength(1e6); 1];
    let fit = floor.fit(&[Target::Stroke(&darker)], &wide).expect("an answer");
    assert!(
        fit.gains.iter().all(|gain| gain.x > 0.1 && gain.x < 1.0),
        "{:?}",
        fit.gains
    );
}

#[test]
fn errors_of_colours_are_relative_to_their_light() {
    let mut floor = Floor::new(1, 1);
    (floor.layers, floor.rest) = (vec![vec![Rgb::ZERO; floor.layers[0].len()]], Rgb::Z);
    let blue: Vec<Option<Rgb>> = vec![Some(2.0 * Rgb::Z); floor.layers[0].len()];
    let limits = vec![LampLimits::of_strength(1.0)];
    let fit = floor.fit(&[Target::Picture(&blue)], &limits).expect("an answer");
    assert!((fit.error - 0.5).abs() < 1e-3, "{}", fit.error);
}

/// A dark lamp has nothing to say, and two lamps with the same light share the change.
#[test]
fn what_the_target_does_not_decide_stays() {
    let mut floor = Floor::new(3, 2);
    floor.layers[1].fill(Rgb::ZERO);
    floor.layers[2] = floor.layers[0].clone();
    floor.rest = Rgb::ZERO;
    let brighter = stroke(Wish::Brighter(2.0), Vec2::splat(0.5));
    let fit = floor.fit(&[Target::Stroke(&brighter)], &limits(3, false));
    let fit = fit.expect("an answer");
    let expected = [2.0, 1.0, 2.0];
    for (gain, expected) in fit.gains.iter().zip(expected) {
        assert!((gain.x - expected).abs() < 0.01, "{:?}", fit.gains);
    }
    assert_eq!(fit.limits, [None; 3]);
}

#[test]
fn lux_are_met_whatever_the_colour_of_the_floor() {
    let mut floor = Floor::new(1, 4);
    floor.layers[0] = (0..SIZE[0] * SIZE[1]).map(albedo).collect();
    floor.rest = Rgb::ZERO;
    let lit = stroke(Wish::Illuminance(500.0), Vec2::new(0.4, 0.6));
    let fit = floor
        .fit(&[Target::Stroke(&lit)], &limits(1, false))
        .expect("an answer");
    let expected = 500.0 / 683.0 / std::f32::consts::PI;
    assert!(
        (fit.gains[0].x / expected - 1.0).abs() < 1e-3,
        "{:?} {expected}",
        fit.gains
    );
    assert!(fit.error < 1e-3);
}

#[test]
fn later_strokes_cover_earlier_ones() {
    let floor = Floor::new(4, 5);
    let strokes = [Wish::Brighter(4.0), Wish::Keep].map(|wish| Stroke {
        hardness: 1.0,
        ..stroke(wish, Vec2::splat(0.4))
    });
    let fit = floor.fit(&strokes.each_ref().map(Target::Stroke), &limits(4, false));
    assert!(worst(&fit.expect("an answer").gains, &[Rgb::ONE; 4]) < 0.01);
}

#[test]
fn the_same_bits_on_any_number_of_threads() {
    let floor = Floor::new(24, 6);
    let truth = random_gains(24, true, 8);
    let picture = floor.picture(&truth);
    let fits = [1, 4].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("a pool");
        pool.install(|| floor.fit(&[Target::Picture(&picture)], &limits(24, true)))
    });
    assert!(fits[0].is_ok());
    assert_eq!(fits[0], fits[1]);
}

#[test]
fn what_cannot_be_solved_is_said() {
    let floor = Floor::new(2, 1);
    let brighter = stroke(Wish::Brighter(2.0), Vec2::splat(0.5));
    let target = [Target::Stroke(&brighter)];
    assert_eq!(floor.fit(&target, &[]), Err(Unsolvable::NoLamps));
    assert_eq!(floor.fit(&[], &limits(2, false)), Err(Unsolvable::NoPaint));
    let outside = stroke(Wish::Keep, Vec2::splat(9.0));
    assert_eq!(
        floor.fit(&[Target::Stroke(&outside)], &limits(2, false)),
        Err(Unsolvable::NoPaint)
    );
    let mut broken = Floor::new(2, 1);
    broken.layers[1].fill(Rgb::NAN);
    assert_eq!(broken.fit(&target, &limits(2, false)), Err(Unsolvable::NotFinite));
    let mut wrong = limits(2, false);
    for (least, most) in [(2.0, 1.0), (-1.0, 1.0), (0.0, f32::INFINITY), (f32::NAN, 1.0)] {
        (wrong[1].least, wrong[1].most) = (least, most);
        assert_eq!(floor.fit(&target, &wrong), Err(Unsolvable::Limits(1)));
    }
    let count = Unsolvable::Count { limits: 1, lamps: 2 };
    assert_eq!(solve(&Observations::new(2), &limits(1, false)), Err(count));
    let mut fixed = limits(2, false);
    (fixed[0].least, fixed[0].most) = (1.5, 1.5);
    assert_eq!(floor.fit(&target, &fixed).map(|fit| fit.gains[0]), Ok(Rgb::splat(1.5)));
}
