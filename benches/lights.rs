//! Noise at equal time with many lights against the same room with few.
//!
//! `cargo bench --bench lights`: for every kind of light and every number of them, the time of a small picture, the
//! mean relative variance of its pixels, and the root of their product, against that of ten lights. The lights' total
//! power is the same.

extern crate sunroom_core as sunroom;

#[path = "../tests/support/mod.rs"]
mod support;

use std::f32::consts::TAU;
use std::time::Instant;

use glam::{Affine3A, Quat, Vec3};
use sunroom::accel::Primitive;
use sunroom::color::{Rgb, luminance};
use sunroom::light::LightSource;
use sunroom::render::film::Film;
use sunroom::render::scene::RenderScene;
use sunroom::render::view::Strategy;
use sunroom::sampling::hash::pcg4d;
use sunroom::sampling::{unit_float, warp};
use sunroom::shading::{Bsdf, Diffuse};
use support::{SceneBuilder, camera, render, triangle_mesh, view};

const RESOLUTION: u32 = 96;
const SAMPLES: u32 = 32;
/// The shortest time of so many is taken.
const REPEATS: u32 = 4;

fn grey() -> Bsdf {
    let reflectance = Rgb::splat(0.5);
    Bsdf::Diffuse(Diffuse { reflectance })
}

/// Four uniform numbers of draw `index`.
fn random(index: u32, stream: u32) -> [f32; 4] {
    pcg4d([index, stream, 11, 12]).map(unit_float)
}

/// A box of side 2 around the origin with two balls in it, open to the camera.
fn room() -> SceneBuilder {
    let mut scene = SceneBuilder::default();
    let turned = |axis: Vec3, degrees: f32| Quat::from_axis_angle(axis, degrees.to_radians());
    for rotation in [
        turned(Vec3::X, -90.0),
        turned(Vec3::X, 90.0),
        turned(Vec3::Y, 90.0),
        turned(Vec3::Y, -90.0),
        Quat::IDENTITY,
    ] {
        let to_world = Affine3A::from_quat(rotation) * Affine3A::from_translation(Vec3::NEG_Z);
        scene.add(Primitive::Rectangle, to_world, grey(), None);
    }
    for (center, radius) in [(Vec3::new(-0.4, -0.6, -0.2), 0.4), (Vec3::new(0.5, -0.7, 0.3), 0.3)] {
        let to_world = Affine3A::from_translation(center) * Affine3A::from_scale(Vec3::splat(radius));
        scene.add(Primitive::Sphere, to_world, grey(), None);
    }
    scene
}

/// Points all over the upper half of the room.
fn points(count: u32) -> RenderScene {
    let mut scene = room();
    for index in 0..count {
        let [x, y, z, share] = random(index, 1);
        scene.light(LightSource::Point {
            position: Vec3::new(1.8 * x - 0.9, 0.9 * y, 1.8 * z - 0.9),
            intensity: Rgb::splat(2.0 * share / count as f32),
        });
    }
    scene.build()
}

/// Equal triangles, together of area `area`, in the room's midst; `place` gives centre and normal by number.
fn emitting(count: u32, area: f32, place: impl Fn(u32) -> (Vec3, Vec3)) -> RenderScene {
    // A triangle of circumradius r has the area 3 sqrt(3) / 4 r^2.
    let size = (area / count as f32 / 1.299).sqrt();
    let triangles = (0..count).map(|index| {
        let (center, normal) = place(index);
        let (s, t) = normal.any_orthonormal_pair();
        [0.0, 1.0, 2.0].map(|third| {
            let (sin, cos) = (third * TAU / 3.0).sin_cos();
            center + size * (cos * s + sin * t)
        })
    });
    let mut scene = room();
    scene.add(
        triangle_mesh(triangles),
        Affine3A::IDENTITY,
        grey(),
        Some(Rgb::splat(10.0)),
    );
    scene.build()
}

/// Triangles turned every way, all over the upper half of the room.
fn scattered(count: u32) -> RenderScene {
    emitting(count, 0.06, |index| {
        let [x, y, z, _] = random(index, 2);
        let [u, v, ..] = random(index, 3);
        let center = Vec3::new(1.8 * x - 0.9, 0.9 * y, 1.8 * z - 0.9);
        (center, warp::uniform_sphere([u, v]))
    })
}

/// Triangles all over a ball, facing outwards.
fn ball(count: u32) -> RenderScene {
    const RADIUS: f32 = 0.15;
    emitting(count, 2.0 * TAU * RADIUS * RADIUS, |index| {
        // Evenly spread over the sphere: equal steps of height, golden sections of a turn.
        let turn = (index as f32 * 0.618_034).fract();
        let normal = warp::uniform_sphere([(index as f32 + 0.5) / count as f32, turn]);
        (Vec3::new(0.2, 0.4, 0.0) + RADIUS * normal, normal)
    })
}

/// Mean of the pixels' variances over their squared values.
fn relative_variance(film: &Film) -> f64 {
    let (width, height) = (film.width(), film.height());
    let radiance = film.radiance();
    let sum: f64 = (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .map(|(x, y)| {
            let mean = luminance(radiance[(y * width + x) as usize]);
            let error = film.standard_error(x, y).unwrap_or(0.0);
            f64::from(error / mean.max(1e-3)).powi(2)
        })
        .sum();
    sum / f64::from(width * height)
}

fn main() {
    println!(
        "{:>9} {:>6} {:>9} {:>10} {:>13}",
        "lights", "count", "time (s)", "variance", "against few"
    );
    let kinds: [(&str, fn(u32) -> RenderScene, [u32; 3]); 3] = [
        ("points", points, [10, 100, 1_000]),
        ("triangles", scattered, [10, 1_000, 10_000]),
        ("ball", ball, [10, 1_000, 10_000]),
    ];
    for (name, scene, counts) in kinds {
        let mut few = None;
        for count in counts {
            let scene = scene(count);
            let mut view = view(
                camera(Vec3::new(0.0, 0.0, 3.6), Vec3::ZERO, 40.0),
                RESOLUTION,
                3,
                Strategy::Mis,
            );
            render(&scene, &view, 1);
            view.seed = 2;
            let settings = view.integrator.settings_mut();
            settings.hide_emitters = true;
            let mut seconds = f64::INFINITY;
            let mut film = None;
            for _ in 0..REPEATS {
                let start = Instant::now();
                film = Some(render(&scene, &view, SAMPLES));
                seconds = seconds.min(start.elapsed().as_secs_f64());
            }
            let film = film.expect("rendered at least once");
            let variance = relative_variance(&film);
            let noise = (variance * seconds).sqrt();
            let against = noise / *few.get_or_insert(noise);
            println!("{name:>9} {count:>6} {seconds:>9.3} {variance:>10.5} {against:>13.2}");
        }
    }
}
