//! Lamps that are found from the light that is wanted: those that made it come back, and contradictions give the answer
//! of an independent solver.

use glam::{Vec2, Vec3};
use sunroom::color::{LUMINANCE, Rgb};
use sunroom::inverse_lighting::{
    Fit, LampLight, LampLimits, Limit, Observation, Observations, PULL, Painting, Range, Seen, Stroke, Target, Tried,
    Unsolvable, Wanted, Wish, place, solve,
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

    fn fit(&self, target: impl Into<Want>, limits: &[LampLimits]) -> Result<Fit, Unsolvable> {
        let targets = target.into().0;
        solve(&Painting::observe_all(targets, self, limits.len()), limits)
    }
}

/// A wanted picture or strokes.
struct Want(Vec<Target>);

impl From<&Vec<Option<Rgb>>> for Want {
    fn from(picture: &Vec<Option<Rgb>>) -> Self {
        Self(vec![Target::Picture(picture.clone().into())])
    }
}

impl From<&Stroke> for Want {
    fn from(stroke: &Stroke) -> Self {
        Self(vec![Target::Stroke(stroke.clone())])
    }
}

impl From<&[Stroke]> for Want {
    fn from(strokes: &[Stroke]) -> Self {
        Self(strokes.iter().cloned().map(Target::Stroke).collect())
    }
}

impl LampLight for Floor {
    fn size(&self) -> [u32; 2] {
        SIZE
    }

    fn at(&self, x: u32, y: u32, light: &mut [Rgb]) -> Option<Seen> {
        let pixel = y * SIZE[0] + x;
        for (light, layer) in light.iter_mut().zip(&self.layers) {
            *light = layer[pixel as usize];
        }
        Some(Seen {
            rest: self.rest,
            present: self.rest + light.iter().sum::<Rgb>(),
        })
    }

    fn irradiance_at(&self, x: u32, y: u32, light: &mut [Rgb]) -> Option<Seen> {
        let scale = std::f32::consts::PI / albedo(y * SIZE[0] + x).x;
        let seen = self.at(x, y, light)?;
        light.iter_mut().for_each(|light| *light *= scale);
        Some(Seen {
            rest: scale * seen.rest,
            present: scale * seen.present,
        })
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
            let fit = floor.fit(&picture, &limits(lamps, colored));
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
    let fit = noisy.fit(&picture, &limits(6, false)).expect("an answer");
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
    let fit = floor.fit(&brighter, &weak).expect("an answer");
    assert_eq!(fit.limits, [Some(Limit::Most); 2]);
    assert_eq!(fit.gains, [Rgb::splat(2.0); 2]);
    assert!(fit.error > 0.5, "{}", fit.error);
    let strong = vec![LampLimits::of_strength(20.0); 2];
    let fit = floor.fit(&brighter, &strong).expect("an answer");
    assert_eq!(fit.limits, [None; 2]);
    assert!(fit.error < 0.05, "{}", fit.error);
    // Light that does not come from the lamps would have to be taken away.
    floor.rest = Rgb::splat(0.01);
    let dark = stroke(Wish::Luminance(0.0), Vec2::splat(0.5));
    let fit = floor.fit(&dark, &strong).expect("an answer");
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
    let fit = floor.fit(&darker, &wide).expect("an answer");
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
    let fit = floor.fit(&blue, &limits).expect("an answer");
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
    let fit = floor.fit(&brighter, &limits(3, false));
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
    let fit = floor.fit(&lit, &limits(1, false)).expect("an answer");
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
    let fit = floor.fit(&strokes[..], &limits(4, false));
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
        pool.install(|| floor.fit(&picture, &limits(24, true)))
    });
    assert!(fits[0].is_ok());
    assert_eq!(fits[0], fits[1]);
}

#[test]
fn what_cannot_be_solved_is_said() {
    let floor = Floor::new(2, 1);
    let brighter = stroke(Wish::Brighter(2.0), Vec2::splat(0.5));
    assert_eq!(floor.fit(&brighter, &[]), Err(Unsolvable::NoLamps));
    assert_eq!(floor.fit(&[][..], &limits(2, false)), Err(Unsolvable::NoPaint));
    let outside = stroke(Wish::Keep, Vec2::splat(9.0));
    assert_eq!(floor.fit(&outside, &limits(2, false)), Err(Unsolvable::NoPaint));
    let mut broken = Floor::new(2, 1);
    broken.layers[1].fill(Rgb::NAN);
    assert_eq!(broken.fit(&brighter, &limits(2, false)), Err(Unsolvable::NotFinite));
    let mut wrong = limits(2, false);
    for (least, most) in [(2.0, 1.0), (-1.0, 1.0), (0.0, f32::INFINITY), (f32::NAN, 1.0)] {
        (wrong[1].least, wrong[1].most) = (least, most);
        assert_eq!(floor.fit(&brighter, &wrong), Err(Unsolvable::Limits(1)));
    }
    let count = Unsolvable::Count { limits: 1, lamps: 2 };
    assert_eq!(solve(&Observations::new(2), &limits(1, false)), Err(count));
    let mut fixed = limits(2, false);
    (fixed[0].least, fixed[0].most) = (1.5, 1.5);
    assert_eq!(
        floor.fit(&brighter, &fixed).map(|fit| fit.gains[0]),
        Ok(Rgb::splat(1.5))
    );
}

/// A lamp over a floor whose place is wanted back, with its strength: light is linear in the strength alone.
#[test]
fn a_lamp_is_put_back_to_its_place() {
    let light = |at: Vec3| -> Vec<Rgb> {
        let of_pixel = |pixel: u32| {
            let floor = Vec2::new((pixel % SIZE[0]) as f32, (pixel / SIZE[0]) as f32) / SIZE[1] as f32;
            let squared = floor.distance_squared(at.truncate()) + at.z * at.z;
            albedo(pixel) * (at.z / squared.powf(1.5)) / 10.0
        };
        (0..SIZE[0] * SIZE[1]).map(of_pixel).collect()
    };
    let mut floor = Floor::new(1, 1);
    let truth = Vec3::new(1.1, 0.35, 0.22);
    floor.layers = vec![light(truth)];
    let picture = floor.picture(&[Rgb::splat(1.7)]);
    let ranges = [[0.8, 0.2, 1.4], [0.5, 0.0, 1.0], [0.3, 0.1, 0.6]].map(|[present, least, most]| Range {
        present,
        least,
        most,
        step: 1e-4,
    });
    let mut shares = Vec::new();
    let mut try_at = |values: &[f64]| -> Result<_, ()> {
        floor.layers = vec![light(Vec3::from(std::array::from_fn(|axis| values[axis] as f32)))];
        let observations = Painting::observe_all(Want::from(&picture).0, &floor, 1);
        let fit = solve(&observations, &limits(1, false)).expect("an answer");
        Ok(Some(Tried {
            residuals: observations.residuals(&fit.gains),
            found: fit,
        }))
    };
    let placed = place(&ranges, &mut try_at, &mut |share, _| shares.push(share));
    let placed = placed.expect("it is not stopped").expect("there is light");
    for (value, truth) in placed.values.iter().zip(truth.to_array()) {
        assert!((value - f64::from(truth)).abs() < 0.005, "{placed:?}");
    }
    assert!((placed.found.gains[0].x / 1.7 - 1.0).abs() < 0.01, "{placed:?}");
    assert!(placed.error < 0.01 && placed.error_before > 0.1, "{placed:?}");
    assert!(placed.limits.iter().all(Option::is_none), "{placed:?}");
    assert!(shares.is_sorted() && shares.iter().all(|share| (0.0..=1.0).contains(share)));
    // Where the place is out of reach, the limit that it is at is named.
    let near = ranges.map(|range| Range {
        most: range.most.min(0.9),
        ..range
    });
    let placed = place(&near, &mut try_at, &mut |_, _| ()).expect("it is not stopped");
    let placed = placed.expect("there is light");
    assert_eq!(placed.limits, [Some(Limit::Most), None, None]);
    assert_eq!(
        place(&ranges, &mut |_| Err::<Option<Tried<Fit>>, _>(()), &mut |_, _| ()),
        Err(())
    );
}

#[test]
fn a_dark_lamp_keeps_its_colour() {
    let floor = Floor::new(1, 1);
    let tint = Rgb::new(1.0, 0.5, 0.25);
    let picture = floor.picture(&[2.0 * tint]);
    let dark = LampLimits {
        strength: 0.0,
        color: tint,
        ..LampLimits::of_strength(MOST)
    };
    let fit = floor.fit(&picture, &[dark]).expect("an answer");
    assert!(fit.gains[0].abs_diff_eq(2.0 * tint, 1e-3), "{:?}", fit.gains);
}

/// Observations of strokes that have not changed are used again; the answer is that of looking at everything.
#[test]
fn only_the_stroke_that_changed_is_looked_at() {
    struct Watched(Floor, std::sync::atomic::AtomicUsize);

    impl LampLight for Watched {
        fn size(&self) -> [u32; 2] {
            self.0.size()
        }

        fn at(&self, x: u32, y: u32, light: &mut [Rgb]) -> Option<Seen> {
            self.1.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
            self.0.at(x, y, light)
        }

        fn irradiance_at(&self, x: u32, y: u32, light: &mut [Rgb]) -> Option<Seen> {
            self.0.irradiance_at(x, y, light)
        }
    }

    let watched = Watched(Floor::new(3, 1), Default::default());
    let looks = || watched.1.swap(0, std::sync::atomic::Ordering::Relaxed);
    let large = Stroke {
        radius: 0.3,
        ..stroke(Wish::Keep, Vec2::new(0.2, 0.5))
    };
    let small = stroke(Wish::Brighter(2.0), Vec2::new(0.8, 0.5));
    let strokes = |last: &Stroke| Want::from(&[large.clone(), last.clone()][..]).0;
    let mut painting = Painting::default();
    painting.set(strokes(&small), SIZE, 3);
    assert!(painting.observe(&watched, || false));
    let all = looks();
    let grown = Stroke {
        path: vec![small.path[0], Vec2::new(0.85, 0.5)],
        ..small.clone()
    };
    painting.set(strokes(&grown), SIZE, 3);
    // It goes on where it was late.
    let mut turns = 0;
    while !painting.observe(&watched, || std::mem::replace(&mut turns, 1) == 0) {}
    assert!((1..all / 2).contains(&looks()), "{all} before");
    assert_eq!(
        painting.observations(),
        Painting::observe_all(strokes(&grown), &watched, 3)
    );
    looks();
    // A stroke that covers another one changes both.
    let over = stroke(Wish::Brighter(2.0), Vec2::new(0.2, 0.5));
    painting.set(strokes(&over), SIZE, 3);
    assert!(painting.observe(&watched, || false));
    assert_eq!(
        painting.observations(),
        Painting::observe_all(strokes(&over), &watched, 3)
    );
}
