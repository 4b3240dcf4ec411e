//! Adaptive sampling: where samples go, that pictures stay unbiased, and that they are the same on any number of
//! threads.

use std::num::NonZeroUsize;

use bevy::math::Rect;
use bevy::prelude::*;
use sunroom::color::{Rgb, luminance};
use sunroom::engine::{RenderControl, RenderFilm, StopReason};
use sunroom::render::film::Film;
use sunroom::scene::{AreaLight, DocumentOrder, IntegratorSettings, SamplerSettings, Shape, ShapeKind, Strategy};

use crate::{ball, finish};

const SIZE: u32 = 64;

/// A ball before an even sky and a lamp that is found by chance: by one sample of a hundred, and then it is bright. Two
/// tiles by two.
fn rare_light(seed: u32, control: impl FnOnce(&mut RenderControl)) -> App {
    let mut app = ball(Vec3::Z * 4.0, SIZE, SIZE);
    let world = app.world_mut();
    let kind = ShapeKind::Sphere {
        center: Vec3::new(0.8, 1.5, 2.6),
        radius: 0.2,
    };
    let lamp = AreaLight {
        radiance: Rgb::splat(40.0).into(),
        ..default()
    };
    world.spawn((
        DocumentOrder(2),
        Shape {
            kind,
            ..Shape::default()
        },
        lamp,
    ));
    let mut integrator = world.resource_mut::<IntegratorSettings>();
    (integrator.strategy, integrator.max_depth) = (Strategy::Bsdf, Some(2));
    world.resource_mut::<SamplerSettings>().seed = seed;
    let mut settings = world.resource_mut::<RenderControl>();
    settings.adaptive = Some(true);
    settings.target_samples = Some(256);
    control(&mut settings);
    app
}

fn picture(seed: u32, control: impl FnOnce(&mut RenderControl)) -> Film {
    let mut app = rare_light(seed, control);
    finish(&mut app);
    app.world().resource::<RenderFilm>().film.clone()
}

/// The mean luminance of each block of 8 x 8 pixels.
fn blocks(film: &Film) -> Vec<f64> {
    let radiance = film.radiance();
    let block = |x: u32, y: u32| {
        let pixels = (0..8).flat_map(|dy| (0..8).map(move |dx| ((y + dy) * SIZE + x + dx) as usize));
        pixels.map(|pixel| f64::from(luminance(radiance[pixel]))).sum::<f64>() / 64.0
    };
    let starts = || (0..SIZE).step_by(8);
    starts().flat_map(|y| starts().map(move |x| block(x, y))).collect()
}

/// The mean over pictures and its squared standard error, of each block and of the whole.
fn means(pictures: &[Film]) -> Vec<(f64, f64)> {
    let mut all: Vec<Vec<f64>> = pictures.iter().map(blocks).collect();
    for blocks in &mut all {
        blocks.push(blocks.iter().sum::<f64>() / blocks.len() as f64);
    }
    let count = all.len() as f64;
    let of = |place: usize| {
        let mean = all.iter().map(|blocks| blocks[place]).sum::<f64>() / count;
        let squares = all.iter().map(|blocks| (blocks[place] - mean).powi(2)).sum::<f64>();
        (mean, squares / (count - 1.0) / count)
    };
    (0..all[0].len()).map(of).collect()
}

#[test]
fn the_mean_of_many_adaptive_pictures_is_that_of_long_uniform_ones() {
    let adaptive: Vec<Film> = (0..32).map(|seed| picture(seed, |_| {})).collect();
    let is_uneven = |film: &&Film| film.most_samples() > 2 * film.sample_count();
    assert!(adaptive.iter().filter(is_uneven).count() > 24);
    let long = |seed| {
        picture(seed, |control| {
            control.adaptive = Some(false);
            control.target_samples = Some(512);
        })
    };
    let uniform: Vec<Film> = (100..116).map(long).collect();
    let (adaptive, uniform) = (means(&adaptive), means(&uniform));
    let z: Vec<f64> = adaptive
        .iter()
        .zip(&uniform)
        .map(|(a, u)| (a.0 - u.0) / (a.1 + u.1 + 1e-12).sqrt())
        .collect();
    // 64 blocks and the whole, with standard errors from as few as 16 pictures.
    assert!(z.iter().all(|z| z.abs() < 4.5), "{z:?}");
    assert!(z[64].abs() < 3.5, "{}", z[64]);
    let mean_square = z.iter().map(|z| z * z).sum::<f64>() / z.len() as f64;
    assert!(mean_square < 1.0 + 5.0 * (2.0 / z.len() as f64).sqrt(), "{mean_square}");
    // The noise is what it is for.
    let variance = |means: &[(f64, f64)], pictures: f64, samples: f64| -> f64 {
        means[..64].iter().map(|(_, squared)| squared).sum::<f64>() * pictures * samples
    };
    let gain = variance(&uniform, 16.0, 512.0) / variance(&adaptive, 32.0, 256.0);
    assert!(gain > 1.1, "{gain}");
}

#[test]
fn adaptive_pictures_are_the_same_on_any_number_of_threads() {
    let on = |threads: usize, noise: Option<f32>, interactive: bool| {
        let film = picture(7, |control| {
            control.threads = NonZeroUsize::new(threads).expect("not zero");
            control.interactive = interactive;
            control.noise_target = noise;
            control.light_layers = noise.is_some();
        });
        assert!(film.most_samples() > film.sample_count(), "{noise:?}");
        film
    };
    // With 64 samples the noise is above this limit, and below it with 256.
    for noise in [None, Some(0.08)] {
        let alone = on(1, noise, false);
        assert!(on(3, noise, false) == alone, "{noise:?}");
        assert!(on(2, noise, true) == alone, "{noise:?}, with previews");
    }
}

#[test]
fn light_layers_and_guides_are_means_over_the_same_samples() {
    let film = picture(3, |control| control.light_layers = true);
    assert!(film.most_samples() > film.sample_count());
    for (x, y) in (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| (x, y))) {
        let whole = film.pixel(x, y).expect("samples").radiance;
        let layers = film.mixed_pixel(x, y, &[Rgb::ONE; 8]).expect("samples");
        assert!(
            (whole - layers).abs().max_element() <= 1e-3 * whole.max_element(),
            "{x} {y}: {whole} {layers}"
        );
    }
    let outside = film.normal()[0];
    assert!(film.normal().iter().all(|normal| normal.length() < 1.001) && outside.length() < 0.001);
    assert!(film.normal().iter().any(|normal| normal.length() > 0.99));
}

#[test]
fn an_interrupted_adaptive_picture_goes_on_at_the_same_places() {
    let whole = picture(5, |_| {});
    let mut app = rare_light(5, |control| control.target_samples = Some(128));
    assert_eq!(finish(&mut app).stopped_by, Some(StopReason::Samples));
    for (paused, frames) in [(false, 3), (true, 2), (false, 5), (true, 1)] {
        let mut control = app.world_mut().resource_mut::<RenderControl>();
        control.target_samples = Some(256);
        control.paused = paused;
        (0..frames).for_each(|_| app.update());
    }
    app.world_mut().resource_mut::<RenderControl>().paused = false;
    app.update();
    finish(&mut app);
    assert!(app.world().resource::<RenderFilm>().film == whole);
    // Switched off, every block gets as many more as the others.
    let count = |app: &App, at: (u32, u32)| app.world().resource::<RenderFilm>().film.samples(at.0, at.1);
    let before = [(0, 0), (32, 32)].map(|at| count(&app, at));
    let mut control = app.world_mut().resource_mut::<RenderControl>();
    (control.adaptive, control.target_samples) = (Some(false), Some(300));
    app.update();
    finish(&mut app);
    assert_eq!(
        [(0, 0), (32, 32)].map(|at| count(&app, at)),
        before.map(|count| count + 44)
    );
    // An exact picture has no differences.
    app.world_mut().resource_mut::<RenderControl>().exact_samples = Some(70);
    app.update();
    finish(&mut app);
    let film = &app.world().resource::<RenderFilm>().film;
    assert_eq!((film.sample_count(), film.most_samples()), (70, 70));
}

#[test]
fn a_region_is_adaptive_within_itself() {
    let film = picture(1, |control| control.region = Some(Rect::new(0.0, 0.0, 1.0, 0.4)));
    assert!(film.samples(32, 31) >= 64 && film.samples(32, 32) == 0);
    // How far to follow what is found in one tile, only other tiles can tell.
    let one_tile = picture(1, |control| control.region = Some(Rect::new(0.0, 0.0, 0.4, 0.4)));
    assert_eq!((one_tile.samples(0, 0), one_tile.samples(31, 31)), (256, 256));
}

#[test]
fn another_region_decides_by_itself() {
    let [upper, lower] = [Rect::new(0.0, 0.0, 1.0, 0.5), Rect::new(0.0, 0.5, 1.0, 1.0)];
    let mut app = rare_light(1, |control| control.region = Some(upper));
    finish(&mut app);
    let counts = |app: &App| {
        let film = &app.world().resource::<RenderFilm>().film;
        let places = (32..SIZE).flat_map(|y| (0..SIZE).map(move |x| (x, y)));
        let counts: Vec<u32> = places.map(|(x, y)| film.samples(x, y)).collect();
        let [least, most] = [counts.iter().min(), counts.iter().max()].map(|count| *count.expect("pixels"));
        (least, most)
    };
    let mut go_on = |samples: u32| {
        let mut control = app.world_mut().resource_mut::<RenderControl>();
        (control.region, control.target_samples) = (Some(lower), Some(samples));
        app.update();
        finish(&mut app);
        counts(&app)
    };
    // The first samples are the same for every pixel, and then what they have found in this half decides.
    assert_eq!(go_on(16), (16, 16));
    let (least, most) = go_on(256);
    assert!(least >= 64 && most > least, "{least} to {most}");
    let film = &app.world().resource::<RenderFilm>().film;
    let uniform = picture(1, |control| {
        (control.adaptive, control.target_samples) = (Some(false), Some(16))
    });
    let places = (32..SIZE).flat_map(|y| (0..SIZE).map(move |x| (x, y)));
    places.for_each(|(x, y)| assert_eq!(film.first_hit(x, y), uniform.first_hit(x, y), "{x}, {y}"));
}
