//! The integrator `auto` in a window: its first pictures are by path tracing.

use std::num::NonZeroUsize;
use std::time::{Duration, Instant};

use bevy::prelude::*;
use sunroom::color::Rgb;
use sunroom::engine::{AutoStatus, EnginePlugin, Limits, RenderControl, RenderFilm, RenderStatus, load_to_completion};
use sunroom::render::auto::{Choice, Method};
use sunroom::scene::{
    DocumentOrder, Emitter, EmitterKind, FileSourcePlugin, Film, IntegratorSettings, Ior, Material, OpenScene,
    PathPlugin, ScenePlugin, Shape, ToWorld, UsesMaterial, asset_plugin,
};

use crate::{ball, finish, spawn_floor};

/// Samples that pay for a pilot.
const SAMPLES: u32 = 300;

/// A ball of glass before a sky and above a floor, under a point.
fn caustic(plugin: PathPlugin) -> App {
    let mut app = ball(Vec3::new(0.0, -0.2, 6.0), 64, 48);
    let world = app.world_mut();
    let glass = world.spawn((
        DocumentOrder(10),
        Material::Dielectric {
            interior: Ior::Number(1.5),
            exterior: Ior::Number(1.0),
            specular_reflectance: Rgb::ONE.into(),
            specular_transmittance: Rgb::ONE.into(),
        },
    ));
    let glass = glass.id();
    let mut shapes = world.query_filtered::<Entity, With<Shape>>();
    let shape = shapes.single(world).expect("a ball");
    world
        .entity_mut(shape)
        .insert((UsesMaterial(glass), ToWorld::default()));
    spawn_floor(world);
    let intensity = Rgb::splat(60.0);
    let point = Transform::from_xyz(0.0, 4.0, 6.0);
    world.spawn((
        DocumentOrder(12),
        Emitter::from(EmitterKind::Point { intensity }),
        ToWorld(point.compute_affine()),
    ));
    let mut films = world.query::<&mut Film>();
    films.single_mut(world).expect("a film").sample_count = SAMPLES;
    let mut integrator = world.resource_mut::<IntegratorSettings>();
    (integrator.plugin, integrator.max_depth) = (plugin, Some(6));
    app
}

fn auto(app: &App) -> Option<AutoStatus> {
    app.world().resource::<RenderStatus>().auto
}

fn is_picture_of(app: &App, other: &App) -> bool {
    let picture = |app: &App| app.world().resource::<RenderFilm>().film.radiance();
    picture(app) == picture(other)
}

#[test]
fn a_window_begins_with_paths_and_goes_on_with_what_is_chosen() {
    let mut bidirectional = caustic(PathPlugin::Bdpt);
    finish(&mut bidirectional);
    assert_eq!(auto(&bidirectional), None);
    let mut app = caustic(PathPlugin::Path);
    let mut control = app.world_mut().resource_mut::<RenderControl>();
    (control.interactive, control.path_is_auto) = (true, true);
    let path = |status: AutoStatus| status.integrator == "path" && status.choice.gain.is_none();
    while app.world().resource::<RenderStatus>().samples == 0 {
        app.update();
        assert!(auto(&app).is_none_or(path), "{:?}", auto(&app));
    }
    finish(&mut app);
    let chosen = auto(&app).expect("a choice");
    assert!(chosen.integrator == "bdpt" && !chosen.is_searching, "{chosen:?}");
    assert!(is_picture_of(&app, &bidirectional), "the pictures differ");

    // A change begins with path tracing again.
    let world = app.world_mut();
    let mut points = world.query_filtered::<&mut ToWorld, With<Emitter>>();
    points.iter_mut(world).for_each(|mut pose| pose.0.translation.x += 0.3);
    app.update();
    assert!(auto(&app).is_some_and(path), "{:?}", auto(&app));
    assert!(app.world().resource::<RenderStatus>().samples < SAMPLES);
}

#[test]
fn a_choice_holds_at_every_resolution() {
    let mut app = caustic(PathPlugin::Auto);
    let world = app.world_mut();
    let mut films = world.query::<&mut Film>();
    let mut film = films.single_mut(world).expect("a film");
    (film.width, film.height) = (128, 96);
    let mut control = world.resource_mut::<RenderControl>();
    (control.interactive, control.view_size) = (true, Some(UVec2::new(64, 48)));
    finish(&mut app);
    let (chosen, film) = (auto(&app), app.world().resource::<RenderFilm>());
    assert!(
        chosen.is_some_and(|chosen| chosen.choice.method == Method::Bidirectional),
        "{chosen:?}"
    );
    assert_eq!(film.film.width(), 64);
    // The demand for all pixels holds until the view changes, and a choice is no change.
    let mut control = app.world_mut().resource_mut::<RenderControl>();
    (control.full_until_change, control.target_samples) = (true, Some(70));
    finish(&mut app);
    assert_eq!(auto(&app), chosen);
    assert_eq!(app.world().resource::<RenderFilm>().film.width(), 128);
    // Whether paths are guided is one.
    app.world_mut().resource_mut::<IntegratorSettings>().guided = true;
    finish(&mut app);
    assert_eq!(app.world().resource::<RenderFilm>().film.width(), 64);
}

/// A room lit from a cove in a window, with so many samples to come.
fn cove(samples: u32) -> App {
    let mut app = App::new();
    app.add_plugins((
        MinimalPlugins,
        FileSourcePlugin,
        asset_plugin(),
        ScenePlugin,
        EnginePlugin,
    ));
    let world = app.world_mut();
    world.write_message(OpenScene {
        path: concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/hard/cove.xml").into(),
        ..default()
    });
    assert_eq!(load_to_completion(&mut app, &Limits::default()), Ok(true));
    let mut control = app.world_mut().resource_mut::<RenderControl>();
    (control.interactive, control.path_is_auto, control.threads) = (true, true, NonZeroUsize::MIN);
    control.target_samples = Some(samples);
    app
}

/// Updates until there is a choice that `is_expected`.
fn choice(app: &mut App, what: &str, is_expected: impl Fn(&Choice) -> bool) -> Choice {
    let begin = Instant::now();
    loop {
        app.update();
        let status = auto(app);
        let found = status.filter(|status| !status.is_searching && is_expected(&status.choice));
        if let Some(status) = found {
            return status.choice;
        }
        assert!(begin.elapsed() < Duration::from_secs(200), "{what}: {status:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
}

#[test]
fn a_choice_does_not_depend_on_how_many_samples_were_asked_for_before() {
    // 64 x 48 pixels: the last number pays for the trial of a guide, and the first for no pilot.
    let [none, some, many] = [100, 400, 6000];
    let has_guide = |choice: &Choice| choice.gain_of_guide.is_some();
    let is_plain = |choice: &Choice| choice.gain.is_some() && !has_guide(choice);
    let mut app = cove(some);
    let first = choice(&mut app, "some samples", is_plain);
    assert_ne!(first.method, Method::GuidedPath);
    let ask = |app: &mut App, samples| app.world_mut().resource_mut::<RenderControl>().target_samples = Some(samples);
    ask(&mut app, many);
    let raised = choice(&mut app, "more samples", has_guide);
    assert_eq!(raised.method, Method::GuidedPath);
    let mut fresh = cove(many);
    assert_eq!(choice(&mut fresh, "a fresh window", has_guide), raised);
    drop(fresh);
    ask(&mut app, some);
    assert_eq!(choice(&mut app, "less again", is_plain), first);
    ask(&mut app, none);
    choice(&mut app, "no pilot", |choice| *choice == Choice::UNTRIED);
}

#[test]
fn path_stands_for_itself_where_it_is_asked_to() {
    let mut app = caustic(PathPlugin::Path);
    app.world_mut().resource_mut::<RenderControl>().interactive = true;
    app.world_mut().resource_mut::<RenderControl>().target_samples = Some(20);
    finish(&mut app);
    assert_eq!(auto(&app), None);
}

#[test]
fn a_short_picture_needs_no_choice() {
    let mut app = caustic(PathPlugin::Auto);
    let mut control = app.world_mut().resource_mut::<RenderControl>();
    (control.interactive, control.target_samples) = (true, Some(20));
    finish(&mut app);
    let status = auto(&app).expect("a status");
    assert!(
        status.integrator == "path" && status.choice.gain.is_none(),
        "{status:?}"
    );
    let mut path = caustic(PathPlugin::Path);
    path.world_mut().resource_mut::<RenderControl>().target_samples = Some(20);
    finish(&mut path);
    assert!(is_picture_of(&app, &path));
}
