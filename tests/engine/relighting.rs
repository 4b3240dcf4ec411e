//! Lights that become stronger or weaker: the samples stay.

use bevy::math::Affine3A;
use bevy::prelude::*;
use sunroom::color::Rgb;
use sunroom::engine::{RenderControl, RenderFilm};
use sunroom::render::film::Film;
use sunroom::scene::{DocumentOrder, Emitter, EmitterKind, Shape, ShapeKind, ToWorld};

use crate::{ball, finish};

const CENTER: Vec3 = Vec3::new(0.0, 0.0, 4.0);
const LAMP: Vec3 = Vec3::new(2.0, 3.0, 2.0);

/// A ball below a sky of this radiance and beside a lamp of this intensity; the lamp.
fn lit(sky: f32, lamp: Rgb) -> (App, Entity) {
    let mut app = ball(CENTER, 40, 30);
    app.world_mut().resource_mut::<RenderControl>().lights_are_free = true;
    set_sky(&mut app, sky);
    let lamp = spawn_lamp(&mut app, LAMP, lamp);
    finish(&mut app);
    (app, lamp)
}

fn spawn_lamp(app: &mut App, place: Vec3, intensity: Rgb) -> Entity {
    let kind = EmitterKind::Point { intensity };
    let place = ToWorld(Affine3A::from_translation(place));
    app.world_mut()
        .spawn((DocumentOrder(4), Emitter::from(kind), place))
        .id()
}

fn set_sky(app: &mut App, sky: f32) {
    let mut emitters = app.world_mut().query::<&mut Emitter>();
    for mut emitter in emitters.iter_mut(app.world_mut()) {
        if let EmitterKind::Constant { radiance } = &mut emitter.kind {
            *radiance = Rgb::splat(sky);
        }
    }
}

fn set_lamp(app: &mut App, lamp: Entity, to: Rgb) {
    let mut emitter = app.world_mut().get_mut::<Emitter>(lamp).expect("a lamp");
    if let EmitterKind::Point { intensity } = &mut emitter.kind {
        *intensity = to;
    }
}

fn film(app: &App) -> (&Film, u64, bool) {
    let film = app.world().resource::<RenderFilm>();
    (&film.film, film.job, film.relit.is_some())
}

/// The largest difference of two pictures, relative to the mean of the second.
fn difference(one: &Film, other: &Film) -> f32 {
    apart(&one.radiance(), &other.radiance())
}

/// The same of pixels.
fn apart(one: &[Rgb], other: &[Rgb]) -> f32 {
    let mean = other.iter().map(|light| light.element_sum()).sum::<f32>() / (3 * other.len()) as f32;
    let apart = one.iter().zip(other).map(|(a, b)| (*a - *b).abs().max_element());
    apart.fold(0.0, f32::max) / mean
}

#[test]
fn stronger_lights_leave_all_samples_where_they_are() {
    let (weak, strong) = (Rgb::new(2.0, 4.0, 8.0), Rgb::new(8.0, 4.0, 2.0));
    let (mut app, lamp) = lit(0.5, weak);
    let (_, before, _) = film(&app);
    set_lamp(&mut app, lamp, strong);
    app.update();
    // At once, in the very frame.
    let (relit, job, is_relit) = film(&app);
    assert_eq!(
        (job, is_relit, relit.sample_count()),
        (before + 1, true, relit.most_samples())
    );
    let (sampled, _) = lit(0.5, strong);
    assert!(difference(relit, film(&sampled).0) < 1e-4);
    // Another light, and back.
    set_sky(&mut app, 0.25);
    app.update();
    let (sampled, _) = lit(0.25, strong);
    assert!(difference(film(&app).0, film(&sampled).0) < 1e-4);
    set_lamp(&mut app, lamp, weak);
    set_sky(&mut app, 0.5);
    app.update();
    let (relit, job, is_relit) = film(&app);
    assert!(is_relit && job == before + 3);
    let (sampled, _) = lit(0.5, weak);
    assert!(difference(relit, film(&sampled).0) < 1e-4);
}

#[test]
fn lamps_that_go_and_come_back_bring_their_samples_along() {
    type Change = fn(&mut App, Entity) -> Entity;
    let light = Rgb::new(2.0, 4.0, 8.0);
    let out: [Change; 2] = [
        |app, lamp| {
            app.world_mut().despawn(lamp);
            lamp
        },
        |app, lamp| {
            set_lamp(app, lamp, Rgb::ZERO);
            lamp
        },
    ];
    let back: [Change; 2] = [
        |app, _| spawn_lamp(app, LAMP, 2.0 * Rgb::new(2.0, 4.0, 8.0)),
        |app, lamp| {
            set_lamp(app, lamp, 2.0 * Rgb::new(2.0, 4.0, 8.0));
            lamp
        },
    ];
    for (out, back) in out.into_iter().zip(back) {
        let (mut app, lamp) = lit(0.5, light);
        let (_, begun, _) = film(&app);
        let [bright, sky_alone, brighter] = [[Rgb::ONE; 2], [Rgb::ONE, Rgb::ZERO], [Rgb::ONE, Rgb::splat(2.0)]]
            .map(|factors| film(&app).0.mixed(&factors));
        let lamp = out(&mut app, lamp);
        app.update();
        let (dark, job, is_relit) = film(&app);
        assert!(is_relit && job == begun + 1);
        assert!(apart(&dark.radiance(), &sky_alone) < 1e-5);
        assert!(apart(&bright, &sky_alone) > 0.1);
        // It shines twice as strong as before.
        let lamp = back(&mut app, lamp);
        app.update();
        let (lit_again, job, is_relit) = film(&app);
        assert!(is_relit && job == begun + 2 && lit_again.layers().groups == 2);
        assert!(apart(&lit_again.radiance(), &brighter) < 1e-5);
        // The other light goes, and what is left needs no layer.
        let mut emitters = app.world_mut().query::<(Entity, &Emitter)>();
        let sky = emitters
            .iter(app.world())
            .map(|(entity, _)| entity)
            .find(|&entity| entity != lamp);
        app.world_mut().despawn(sky.expect("a sky"));
        app.update();
        let (lamp_alone, job, is_relit) = film(&app);
        assert!(is_relit && job == begun + 3 && lamp_alone.layers().groups == 0);
        let expected: Vec<Rgb> = brighter.iter().zip(&sky_alone).map(|(all, sky)| *all - *sky).collect();
        assert!(apart(&lamp_alone.radiance(), &expected) < 1e-4);
    }
}

#[test]
fn a_single_light_needs_no_layer() {
    let only = |sky| {
        let mut app = ball(CENTER, 40, 30);
        app.world_mut().resource_mut::<RenderControl>().lights_are_free = true;
        set_sky(&mut app, sky);
        finish(&mut app);
        app
    };
    let mut app = only(0.5);
    set_sky(&mut app, 2.0);
    app.update();
    let (relit, _, is_relit) = film(&app);
    assert!(is_relit && relit.layers().groups == 0);
    assert!(difference(relit, film(&only(2.0)).0) < 1e-5);
}

#[test]
fn everything_else_begins_the_picture_anew() {
    let light = Rgb::splat(4.0);
    let begins_anew = |change: fn(&mut App, Entity)| {
        let (mut app, lamp) = lit(0.5, light);
        let (_, before, _) = film(&app);
        change(&mut app, lamp);
        app.update();
        finish(&mut app);
        let (_, job, is_relit) = film(&app);
        assert!(job > before);
        !is_relit
    };
    assert!(!begins_anew(|app, lamp| set_lamp(app, lamp, Rgb::ONE)));
    assert!(begins_anew(|app, lamp| {
        set_lamp(app, lamp, Rgb::new(0.0, 1.0, 1.0));
        app.update();
        // Nothing is left of the red light that could be multiplied.
        set_lamp(app, lamp, Rgb::ONE);
    }));
    assert!(begins_anew(|app, _| {
        // Light of which there are no samples.
        spawn_lamp(app, Vec3::new(-2.0, 3.0, 2.0), Rgb::ONE);
    }));
    assert!(begins_anew(|app, lamp| {
        let mut place = app.world_mut().get_mut::<ToWorld>(lamp).expect("a lamp");
        place.0.translation.x += 1.0;
    }));
    assert!(begins_anew(|app, lamp| {
        set_lamp(app, lamp, Rgb::ONE);
        let mut shapes = app.world_mut().query::<&mut Shape>();
        let mut shape = shapes.single_mut(app.world_mut()).expect("a ball");
        shape.kind = ShapeKind::Sphere {
            center: CENTER,
            radius: 0.5,
        };
    }));
    assert!(begins_anew(|app, lamp| {
        app.world_mut().resource_mut::<RenderControl>().lights_are_free = false;
        set_lamp(app, lamp, Rgb::ONE);
    }));
}
