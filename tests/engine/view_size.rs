//! Pictures with fewer pixels than the film, because the place where they are shown has no more.

use bevy::prelude::*;
use sunroom::color::{Rgb, luminance};
use sunroom::engine::{Filling, RenderControl, RenderFilm, RenderStatus};
use sunroom::scene::{Film, IntegratorSettings, ReconstructionFilter, Sensor, Shape, ToWorld};

use crate::{ball, finish};

/// A ball before a sky, with a film of 400 x 200 pixels.
fn studio() -> App {
    let mut app = ball(Vec3::new(0.3, 0.1, 4.0), 400, 200);
    let mut control = app.world_mut().resource_mut::<RenderControl>();
    control.interactive = true;
    control.view_size = Some(UVec2::new(100, 90));
    app
}

fn control(app: &mut App) -> Mut<'_, RenderControl> {
    app.world_mut().resource_mut::<RenderControl>()
}

fn status(app: &App) -> RenderStatus {
    app.world().resource::<RenderStatus>().clone()
}

fn film_size(app: &App) -> (u32, u32) {
    let film = &app.world().resource::<RenderFilm>().film;
    (film.width(), film.height())
}

#[test]
fn the_film_is_traced_in_full_until_the_scene_or_the_view_changes() {
    let mut app = studio();
    finish(&mut app);
    assert_eq!(film_size(&app), (100, 50));
    assert_eq!(
        (status(&app).size, status(&app).full_size),
        (UVec2::new(100, 50), UVec2::new(400, 200))
    );
    type Change = fn(&mut App);
    let changes: [Change; 4] = [
        |app| {
            let mut shapes = app.world_mut().query_filtered::<&mut ToWorld, With<Shape>>();
            let mut poses = shapes.iter_mut(app.world_mut());
            poses.next().expect("a ball").0.translation.x += 0.1;
        },
        |app| {
            let mut cameras = app.world_mut().query_filtered::<&mut ToWorld, With<Sensor>>();
            let mut poses = cameras.iter_mut(app.world_mut());
            poses.next().expect("a camera").0.translation.x += 0.1;
        },
        |app| control(app).light_layers = true,
        |app| {
            app.world_mut().resource_mut::<IntegratorSettings>().max_depth = Some(3);
        },
    ];
    for change in changes {
        control(&mut app).full_until_change = true;
        finish(&mut app);
        assert_eq!(film_size(&app), (400, 200));
        // None of these changes what is seen.
        let of_the_picture: [Change; 3] = [
            |app| control(app).target_samples = Some(6),
            |app| control(app).view_size = Some(UVec2::new(120, 90)),
            |app| control(app).restart_requested = true,
        ];
        for other in of_the_picture {
            other(&mut app);
            finish(&mut app);
            assert!(control(&mut app).full_until_change);
            assert_eq!(film_size(&app), (400, 200));
        }
        change(&mut app);
        app.update();
        assert_eq!(status(&app).size, UVec2::new(120, 60));
        assert!(!control(&mut app).full_until_change);
        finish(&mut app);
        assert_eq!(film_size(&app), (120, 60));
    }
}

/// Every pixel of the small picture shows what the pixels of the large one show at the same place, so that both cover
/// the same part of the world.
#[test]
fn a_picture_of_fewer_pixels_shows_the_same() {
    let mut app = studio();
    control(&mut app).target_samples = Some(64);
    let mut films = app.world_mut().query::<&mut Film>();
    for mut film in films.iter_mut(app.world_mut()) {
        film.filter = ReconstructionFilter::Box;
    }
    let depths = |app: &App| app.world().resource::<RenderFilm>().film.depth();
    let light = |app: &App| app.world().resource::<RenderFilm>().film.radiance();
    finish(&mut app);
    let (small, small_light) = (depths(&app), light(&app));
    control(&mut app).full_until_change = true;
    finish(&mut app);
    let (large, large_light) = (depths(&app), light(&app));
    let mut seen = [0; 2];
    for (place, depth) in small.iter().enumerate() {
        let (x, y) = (place % 100, place / 100);
        if [0, 99].contains(&x) || [0, 49].contains(&y) {
            continue;
        }
        let block = (0..16).map(|k| large[(4 * y + k / 4) * 400 + 4 * x + k % 4]);
        let hits: Vec<bool> = block.map(|depth| depth > 0.0).collect();
        // At the rim both are seen.
        let around = (0..9).map(|k| (x as i32 + k % 3 - 1, y as i32 + k / 3 - 1));
        let mut neighbours = around.map(|(x, y)| small[(100 * y + x) as usize] > 0.0);
        if neighbours.all(|hit| hit == (*depth > 0.0)) {
            seen[usize::from(*depth > 0.0)] += 1;
            assert!(hits.iter().all(|hit| *hit == (*depth > 0.0)), "{x} {y}");
        }
    }
    assert!(seen[0] > 500 && seen[1] > 500, "{seen:?}");
    let mean = |light: &[Rgb]| light.iter().map(|&rgb| luminance(rgb)).sum::<f32>() / light.len() as f32;
    let (small, large) = (mean(&small_light), mean(&large_light));
    assert!((small - large).abs() < 0.01 * large, "{small} {large}");
}

#[test]
fn the_surroundings_of_the_film_get_few_samples() {
    let samples = |filling, exact| {
        let mut app = studio();
        {
            let mut control = control(&mut app);
            (control.filling, control.view_size) = (filling, Some(UVec2::new(96, 160)));
            (control.target_samples, control.exact_samples) = (Some(40), exact);
        }
        // A picture that began again for ever would never be done.
        let status = finish(&mut app);
        assert_eq!(status.size, UVec2::new(96, 160));
        assert!(status.is_beyond_film);
        let film = &app.world().resource::<RenderFilm>().film;
        [film.samples(48, 80), film.samples(48, 4)]
    };
    let [in_film, around] = samples(Filling::AroundFilm, None);
    assert!(in_film >= 40 && (16..40).contains(&around), "{in_film} {around}");
    let all = [samples(Filling::Free, None), samples(Filling::AroundFilm, Some(40))];
    assert!(all.as_flattened().iter().all(|count| *count >= 40), "{all:?}");
}

#[test]
fn the_full_film_has_no_surroundings() {
    let mut app = studio();
    {
        let mut control = control(&mut app);
        (control.filling, control.view_size) = (Filling::Free, Some(UVec2::new(100, 100)));
    }
    finish(&mut app);
    assert_eq!((film_size(&app), status(&app).is_beyond_film), ((100, 100), true));
    control(&mut app).full_until_change = true;
    finish(&mut app);
    assert_eq!((film_size(&app), status(&app).is_beyond_film), ((400, 200), false));
}

#[test]
fn a_region_stays_where_it_is_in_the_film() {
    let mut app = studio();
    {
        let mut control = control(&mut app);
        (control.filling, control.view_size) = (Filling::Free, Some(UVec2::new(128, 256)));
        // The film is 128 x 64 in the middle; this is the row of tiles above it.
        control.region = Some(Rect::new(0.0, -0.5, 1.0, 0.0));
        control.target_samples = Some(4);
    }
    finish(&mut app);
    let film = &app.world().resource::<RenderFilm>().film;
    assert_eq!(
        [film.samples(64, 80), film.samples(64, 112), film.samples(64, 40)],
        [4, 0, 0]
    );
}
