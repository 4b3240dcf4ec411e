//! When pictures stop, and that going on loses nothing.

use bevy::math::{Affine3A, Rect, Vec3};
use bevy::prelude::*;
use sunroom::color::Rgb;
use sunroom::engine::{RenderControl, RenderFilm, RenderStatus, StopReason};
use sunroom::render::film::Film;
use sunroom::scene::{DocumentOrder, Emitter, EmitterKind, ToWorld};

use crate::ball;

const ENDLESS: u32 = 1 << 30;

/// A ball under a lamp, 80 x 40 pixels: three tiles by two.
fn studio(control: impl FnOnce(&mut RenderControl)) -> App {
    let mut app = ball(Vec3::Z * 4.0, 80, 40);
    let world = app.world_mut();
    let lamp = Affine3A::from_translation(Vec3::new(0.0, 4.0, 4.0));
    world.spawn((
        DocumentOrder(2),
        Emitter::from(EmitterKind::Point {
            intensity: Rgb::splat(20.0),
        }),
        ToWorld(lamp),
    ));
    control(&mut world.resource_mut::<RenderControl>());
    app
}

/// Updates until the picture is done and returns why it is.
fn finish(app: &mut App) -> Option<StopReason> {
    crate::finish(app).stopped_by
}

fn change(app: &mut App, change: impl FnOnce(&mut RenderControl)) {
    change(&mut app.world_mut().resource_mut::<RenderControl>());
}

fn film(app: &App) -> (Film, u64) {
    let film = app.world().resource::<RenderFilm>();
    (film.film.clone(), film.job)
}

fn status(app: &App) -> RenderStatus {
    app.world().resource::<RenderStatus>().clone()
}

#[test]
fn time_stops_it_and_more_time_continues_it() {
    let mut app = studio(|control| {
        control.target_samples = Some(ENDLESS);
        control.time_limit = Some(0.2);
    });
    assert_eq!(finish(&mut app), Some(StopReason::Time));
    let (first, job) = film(&app);
    let before = status(&app);
    assert!(before.seconds >= 0.2 && before.rays > 0);
    // Done is done.
    app.update();
    assert_eq!((film(&app).0, status(&app).seconds), (first.clone(), before.seconds));
    // On a busy machine the threads may not have their turn in so short a time.
    let mut limit = 0.25;
    while status(&app).rays == before.rays {
        limit *= 2.0;
        assert!(limit < 1000.0);
        change(&mut app, |control| control.time_limit = Some(limit));
        assert_eq!(finish(&mut app), Some(StopReason::Time));
    }
    let (second, same_job) = film(&app);
    assert_eq!(job, same_job);
    let count = |film: &Film, (x, y): (u32, u32)| film.samples(x, y);
    for at in [(0, 0), (40, 20), (79, 39)] {
        assert!(count(&second, at) >= count(&first, at));
    }
    change(&mut app, |control| {
        control.time_limit = None;
        control.target_samples = Some(1);
    });
    assert_eq!(finish(&mut app), Some(StopReason::Samples));
}

#[test]
fn noise_stops_it_and_less_noise_takes_more_samples() {
    let mut app = studio(|control| {
        control.target_samples = Some(ENDLESS);
        control.noise_target = Some(0.05);
    });
    assert_eq!(finish(&mut app), Some(StopReason::Noise));
    let loud = status(&app);
    assert!(
        loud.noise.is_some_and(|noise| noise <= 0.05) && loud.samples >= 16,
        "{loud:?}"
    );
    let wanted = loud.noise.map(|noise| 0.6 * noise);
    change(&mut app, |control| control.noise_target = wanted);
    assert_eq!(finish(&mut app), Some(StopReason::Noise));
    let quiet = status(&app);
    assert!(quiet.noise <= wanted);
    // The noise falls with the root of the samples, and is itself an estimate: 1 / 0.6^2 = 2.8 times as many, about.
    assert!(
        quiet.samples as f32 > 1.8 * loud.samples as f32,
        "{} {}",
        quiet.samples,
        loud.samples
    );
}

#[test]
fn a_limit_of_noise_gives_the_same_bits_on_any_number_of_threads() {
    let quiet = |threads: usize, interactive: bool| {
        let mut app = studio(|control| {
            control.threads = std::num::NonZeroUsize::new(threads).expect("not zero");
            control.interactive = interactive;
            control.target_samples = Some(ENDLESS);
            control.noise_target = Some(0.03);
        });
        assert_eq!(finish(&mut app), Some(StopReason::Noise));
        let status = status(&app);
        (film(&app).0, status.samples, status.noise)
    };
    let (alone, samples, noise) = quiet(1, false);
    assert!(
        alone.sample_count() == samples && alone.most_samples() == samples,
        "{samples}"
    );
    for (threads, interactive) in [(3, false), (2, true)] {
        let (film, other_samples, other_noise) = quiet(threads, interactive);
        assert_eq!((other_samples, other_noise), (samples, noise), "{threads} threads");
        assert!(film == alone, "{threads} threads");
    }
}

#[test]
fn a_limit_of_noise_that_comes_later_counts_when_all_pixels_have_as_many_samples() {
    let mut app = studio(|control| control.target_samples = Some(ENDLESS));
    while status(&app).samples < 40 {
        app.update();
    }
    change(&mut app, |control| control.noise_target = Some(0.5));
    assert_eq!(finish(&mut app), Some(StopReason::Noise));
    let (film, _) = film(&app);
    assert_eq!(film.sample_count(), film.most_samples());
    // Without it the picture goes on.
    let before = status(&app).samples;
    change(&mut app, |control| {
        control.noise_target = Some(0.0);
        control.target_samples = Some(before + 16);
    });
    assert_eq!(finish(&mut app), Some(StopReason::Samples));
    assert_eq!(status(&app).samples, before + 16);
}

/// The film of a render to so many samples that nothing interrupted.
fn plain(samples: u32) -> Film {
    let mut app = studio(|control| control.target_samples = Some(samples));
    finish(&mut app);
    film(&app).0
}

#[test]
fn an_exact_picture_does_not_depend_on_what_was_rendered_before() {
    let expected = plain(12);
    // Too few samples, too many, and passes that end elsewhere: 5 and 10 are in the middle of a pass.
    for (interactive, before) in [(false, 3), (true, 4), (false, 5), (true, 10), (true, 40)] {
        let mut app = studio(|control| {
            control.interactive = interactive;
            control.target_samples = Some(before);
        });
        finish(&mut app);
        change(&mut app, |control| control.exact_samples = Some(12));
        app.update();
        assert_eq!(finish(&mut app), Some(StopReason::Samples));
        assert_eq!(status(&app).samples, 12);
        assert!(
            film(&app).0 == expected,
            "after {before} samples, interactive {interactive}"
        );
    }
}

#[test]
fn an_exact_picture_is_the_same_when_it_is_asked_for_in_the_middle_of_a_render() {
    let expected = plain(8);
    for frames in 0..12 {
        let mut app = studio(|control| {
            control.interactive = true;
            control.target_samples = Some(ENDLESS);
        });
        (0..frames).for_each(|_| app.update());
        change(&mut app, |control| {
            control.exact_samples = Some(8);
            control.time_limit = Some(1e-6);
        });
        app.update();
        assert_eq!(finish(&mut app), Some(StopReason::Samples));
        assert!(film(&app).0 == expected, "after {frames} frames");
        // Without the demand the limits count again.
        change(&mut app, |control| control.exact_samples = None);
        assert_eq!(finish(&mut app), Some(StopReason::Time));
    }
}

#[test]
fn around_the_region_of_an_exact_picture_is_nothing_or_an_exact_picture() {
    let region = Some(Rect::new(0.0, 0.0, 0.3, 0.3));
    let counts = |before: fn(&mut RenderControl)| {
        let mut app = studio(|control| control.target_samples = Some(3));
        change(&mut app, before);
        finish(&mut app);
        change(&mut app, |control| {
            control.region = region;
            control.exact_samples = Some(8);
        });
        app.update();
        app.update();
        finish(&mut app);
        let (film, _) = film(&app);
        [film.samples(0, 0), film.samples(79, 39)]
    };
    assert_eq!(counts(|_| {}), [8, 0]);
    assert_eq!(counts(|control| control.exact_samples = Some(2)), [8, 2]);
}

#[test]
fn around_a_region_nothing_of_an_older_picture_stays() {
    let mut app = studio(|control| {
        control.interactive = true;
        control.region = Some(Rect::new(0.0, 0.0, 0.3, 0.3));
    });
    finish(&mut app);
    let first = region_and_rest(&app);
    let mut lamps = app.world_mut().query::<&mut Emitter>();
    for mut lamp in lamps.iter_mut(app.world_mut()) {
        *lamp = Emitter::from(EmitterKind::Constant {
            radiance: Rgb::splat(3.0),
        });
    }
    app.update();
    finish(&mut app);
    let second = region_and_rest(&app);
    assert!(first.iter().zip(&second).all(|(before, after)| after > before));
    // A picture of another size begins without a preview, but not around the region.
    change(&mut app, |control| {
        control.film_size_override = Some(UVec2::new(120, 60))
    });
    app.update();
    finish(&mut app);
    assert_eq!(region_and_rest(&app).len(), 120 * 60);
}

/// What every pixel shows. The first tile, or the first two, have samples and the others none.
fn region_and_rest(app: &App) -> Vec<f32> {
    let (film, _) = film(app);
    let (width, height) = (film.width(), film.height());
    let shown = |(x, y)| {
        let is_inside = x < 32 * (width * 3 / 10).div_ceil(32) && y < 32;
        assert_eq!(film.samples(x, y) > 0, is_inside, "{x} {y}");
        film.pixel(x, y).expect("something to show").radiance.x
    };
    (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .map(shown)
        .collect()
}

#[test]
fn a_region_gets_samples_and_the_rest_keeps_its_own() {
    let mut app = studio(|_| {});
    assert_eq!(finish(&mut app), Some(StopReason::Samples));
    let (whole, job) = film(&app);
    assert_eq!(whole.sample_count(), 4);
    change(&mut app, |control| {
        control.region = Some(Rect::new(0.0, 0.0, 0.3, 0.3));
        control.target_samples = Some(16);
    });
    assert_eq!(finish(&mut app), Some(StopReason::Samples));
    let (part, same_job) = film(&app);
    assert_eq!(job, same_job);
    assert_eq!(status(&app).samples, 16);
    for (x, y) in (0..40).flat_map(|y| (0..80).map(move |x| (x, y))) {
        if x < 32 && y < 32 {
            assert_eq!(part.samples(x, y), 16);
        } else {
            assert_eq!(part.pixel(x, y), whole.pixel(x, y));
        }
    }
    // The rest catches up, to the bits of a picture that never had a region.
    change(&mut app, |control| control.region = None);
    assert_eq!(finish(&mut app), Some(StopReason::Samples));
    let mut plain = studio(|control| control.target_samples = Some(16));
    finish(&mut plain);
    assert_eq!(film(&app).0, film(&plain).0);
    assert_eq!(film(&app).1, job);
}
