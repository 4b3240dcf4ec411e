//! Embeds the engine in a Bevy app: the scene is entities with components, and the engine renders whatever they are.
//!
//! `cargo run --release --example embed` renders two pictures, between which one component changes.

use std::error::Error;

use bevy::math::Affine3A;
use bevy::prelude::*;
use sunroom::engine::{EnginePlugin, Limits, RenderFilm, render_to_completion};
use sunroom::render::image_io::{ImageRgb, write_image};
use sunroom::render::tonemap::Display;
use sunroom::scene::{ActiveSensor, EmitterKind, FileSourcePlugin, Film, Material, ScenePlugin, Sensor, Shape};
use sunroom::scene::{Emitter, ShapeKind, ToWorld, UsesMaterial, asset_plugin};

fn main() -> Result<(), Box<dyn Error>> {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, FileSourcePlugin, asset_plugin()))
        .add_plugins((ScenePlugin, EnginePlugin));
    let ball = build_scene(app.world_mut());
    save(&mut app, "embed-before.png")?;

    // An app with a loop of its own only changes components: the engine's systems notice it, rebuild the table of
    // materials, and start the picture again. `RenderStatus` says how far it is, `RenderFilm` holds it.
    let plastic = Material::of_plugin("principled").ok_or("a plugin of this name")?;
    app.world_mut().entity_mut(ball).insert(plastic);
    save(&mut app, "embed-after.png")
}

/// Spawns a ball on a floor under a sky, and a camera; the entity of the ball's material.
fn build_scene(world: &mut World) -> Entity {
    let material = world
        .spawn(Material::of_plugin("roughconductor").unwrap_or_default())
        .id();
    let sphere = ShapeKind::Sphere {
        center: Vec3::Y,
        radius: 1.0,
    };
    world.spawn((
        Shape {
            kind: sphere,
            ..default()
        },
        UsesMaterial(material),
    ));

    let floor = world.spawn(Material::default()).id();
    let lying = Affine3A::from_rotation_x(-std::f32::consts::FRAC_PI_2) * Affine3A::from_scale(Vec3::splat(5.0));
    world.spawn((Shape::default(), ToWorld(lying), UsesMaterial(floor)));

    let radiance = Vec3::new(0.6, 0.8, 1.0);
    world.spawn(Emitter::from(EmitterKind::Constant { radiance }));

    // A camera looks along its +z, with +x to its left and +y up.
    let pose = Affine3A::from_translation(Vec3::new(0.0, 1.0, 6.0)) * Affine3A::from_rotation_y(std::f32::consts::PI);
    let film = Film {
        width: 320,
        height: 240,
        sample_count: 32,
        ..default()
    };
    let camera = world.spawn((Sensor::default(), film, ToWorld(pose))).id();
    world.insert_resource(ActiveSensor(Some(camera)));
    material
}

/// Updates the app until the film has as many samples as the camera asks for, and writes the picture.
fn save(app: &mut App, path: &str) -> Result<(), Box<dyn Error>> {
    render_to_completion(app, &Limits::default(), |_| {})?;
    let film = &app.world().resource::<RenderFilm>().film;
    let image = ImageRgb {
        width: film.width(),
        height: film.height(),
        pixels: film.radiance(),
    };
    Ok(write_image(path.as_ref(), &image, &Display::default())?)
}
