//! The engine without a window: what it rebuilds, when it stops, and what it makes of the lights.

#[path = "../support/split_mix.rs"]
mod split_mix;
#[path = "../support/mod.rs"]
mod support;

mod adaptive;
mod auto;
mod flying;
mod gbuffer;
mod guide;
mod large;
mod light_amounts;
mod light_mixing;
mod noise;
mod portals;
mod reasons;
mod rebuilding;
mod relighting;
mod stopping;
mod view_size;
mod wanted_light;

use std::num::NonZeroUsize;
use std::time::{Duration, Instant};

use bevy::asset::AssetPlugin;
use bevy::prelude::*;
use sunroom::color::Rgb;
use sunroom::engine::{EnginePlugin, RenderControl, RenderState, RenderStatus};
use sunroom::scene::{
    ActiveSensor, DocumentOrder, Emitter, EmitterKind, Film, ScenePlugin, Sensor, Shape, ShapeKind, ToWorld,
};

/// A ball of radius 1 before a grey sky, seen as [`look_along`] says. One thread renders.
fn ball(center: Vec3, width: u32, height: u32) -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), ScenePlugin, EnginePlugin));
    let world = app.world_mut();
    world.spawn((
        DocumentOrder(0),
        Emitter::from(EmitterKind::Constant {
            radiance: Rgb::splat(0.5),
        }),
    ));
    let kind = ShapeKind::Sphere { center, radius: 1.0 };
    world.spawn((
        DocumentOrder(1),
        Shape {
            kind,
            ..Shape::default()
        },
    ));
    look_along(world, width, height);
    world.resource_mut::<RenderControl>().threads = NonZeroUsize::MIN;
    app
}

/// A floor below what [`look_along`] looks at.
fn spawn_floor(world: &mut World) {
    let floor = Shape {
        kind: ShapeKind::Disk,
        ..Shape::default()
    };
    let turn = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let pose = Transform::from_xyz(0.0, -1.5, 6.0)
        .with_rotation(turn)
        .with_scale(Vec3::splat(6.0));
    world.spawn((DocumentOrder(11), floor, ToWorld(pose.compute_affine())));
}

/// Looks along +z from the origin, with a film of so many pixels and four samples of each.
fn look_along(world: &mut World, width: u32, height: u32) {
    let film = Film {
        width,
        height,
        sample_count: 4,
        ..default()
    };
    let camera = (DocumentOrder(3), Sensor::default(), ToWorld::default(), film);
    let sensor = world.spawn(camera).id();
    world.insert_resource(ActiveSensor(Some(sensor)));
}

/// Updates until the picture is done.
fn finish(app: &mut App) -> RenderStatus {
    let begin = Instant::now();
    loop {
        app.update();
        let status = app.world().resource::<RenderStatus>();
        if status.state == RenderState::Done {
            return status.clone();
        }
        assert!(begin.elapsed() < Duration::from_secs(600), "{status:?}");
        std::thread::sleep(Duration::from_millis(1));
    }
}
