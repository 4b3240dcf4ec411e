//! The guide of paths, which belongs to the scene: views that come and go share it.

use bevy::math::Affine3A;
use bevy::prelude::*;
use sunroom::color::Rgb;
use sunroom::engine::{GuideStatus, PackedScene, RenderFilm, RenderStatus};
use sunroom::render::guide::Guide;
use sunroom::scene::{Emitter, EmitterKind, Film, FreeView, IntegratorSettings, Sensor, Shape, ToWorld};

use crate::{ball, finish, spawn_floor};

const BALL: Vec3 = Vec3::new(0.0, -0.2, 6.0);

/// A ball above a floor, with guided paths.
fn guided() -> App {
    let mut app = ball(BALL, 16, 12);
    let world = app.world_mut();
    spawn_floor(world);
    world.resource_mut::<IntegratorSettings>().guided = true;
    app
}

fn guide(app: &App) -> Guide {
    let view = app.world().resource::<PackedScene>().view.as_ref();
    view.and_then(|view| view.guide.clone()).expect("a guide")
}

fn status(app: &App) -> GuideStatus {
    app.world().resource::<RenderStatus>().guide.expect("a guide")
}

/// Finishes the picture from a place; None is that of the sensor.
fn fly(app: &mut App, place: Option<Vec3>) -> Guide {
    let view = place.map_or_else(FreeView::default, |place| {
        FreeView::at(Affine3A::from_translation(place))
    });
    app.world_mut().insert_resource(view);
    finish(app);
    guide(app)
}

#[test]
fn flying_keeps_the_guide_and_an_edit_drops_it() {
    let mut app = guided();
    let first = fly(&mut app, None);
    assert_eq!(first.learnings(), 1);
    let whole = app.world().resource::<RenderStatus>().rays;
    let told = status(&app);
    assert!(told.rays > 60_000 && whole > told.rays, "{told:?} of {whole}");
    let picture = |app: &App| app.world().resource::<RenderFilm>().film.radiance();
    let at_first = picture(&app);

    for place in [Some(Vec3::new(0.3, 0.1, 0.0)), Some(Vec3::X), None] {
        assert!(fly(&mut app, place).is_same(&first));
        assert_eq!((first.learnings(), status(&app).rays), (1, 0), "{place:?}");
    }
    assert_eq!(app.world().resource::<RenderStatus>().rays, whole - told.rays);
    assert!(picture(&app) == at_first, "the guide has changed the picture");
    // Nor does it matter how large and how good the picture is.
    let world = app.world_mut();
    let mut films = world.query::<&mut Film>();
    let mut film = films.single_mut(world).expect("a film");
    (film.width, film.sample_count) = (24, 6);
    world.query::<&mut Sensor>().single_mut(world).expect("a sensor").fov = 50.0;
    assert!(fly(&mut app, None).is_same(&first) && first.learnings() == 1);

    // A brighter sky brings other light.
    brighten(&mut app);
    let second = fly(&mut app, None);
    assert!(!second.is_same(&first) && second.learnings() == 1);
    // And so does what has moved.
    move_down(&mut app);
    let third = fly(&mut app, None);
    assert!(!third.is_same(&second) && third.learnings() == 1 && status(&app).rays > 60_000);

    // What was edited is guided as if it had been read that way.
    let edited = picture(&app);
    let mut fresh = guided();
    let world = fresh.world_mut();
    let mut films = world.query::<&mut Film>();
    let mut film = films.single_mut(world).expect("a film");
    (film.width, film.sample_count) = (24, 6);
    world.query::<&mut Sensor>().single_mut(world).expect("a sensor").fov = 50.0;
    brighten(&mut fresh);
    move_down(&mut fresh);
    finish(&mut fresh);
    assert!(
        picture(&fresh) == edited,
        "the guide of the edited scene is not that of the scene"
    );

    // Without a guide and with it again.
    let mut settings = app.world_mut().resource_mut::<IntegratorSettings>();
    settings.guided = false;
    finish(&mut app);
    assert_eq!(app.world().resource::<RenderStatus>().guide, None);
    app.world_mut().resource_mut::<IntegratorSettings>().guided = true;
    assert!(fly(&mut app, None).is_same(&third) && picture(&app) == edited);
    assert_eq!(third.learnings(), 1);
}

/// A brighter sky.
fn brighten(app: &mut App) {
    let world = app.world_mut();
    let mut skies = world.query::<&mut Emitter>();
    skies.single_mut(world).expect("a sky").kind = EmitterKind::Constant {
        radiance: Rgb::splat(0.7),
    };
}

/// Moves all shapes.
fn move_down(app: &mut App) {
    let world = app.world_mut();
    let mut shapes = world.query_filtered::<&mut ToWorld, With<Shape>>();
    shapes.iter_mut(world).for_each(|mut pose| pose.0.translation.y -= 0.1);
}
