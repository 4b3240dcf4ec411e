//! The meter against closed forms, among them the analytic cases of CIE 171:2006, Test Cases to Assess the Accuracy of
//! Lighting Computer Programs, that apply: point lights, area lights, light reflected by a diffuse surface, light
//! reflected inside of a closed room, and the sky through openings. The expected values are computed here, not taken
//! from its tables.
//!
//! Values have to be within three of their own standard errors, and the errors together as large as they are told: a
//! meter that tells too large errors fails as one does that tells too small ones.

mod analytic;
mod daylight;
mod measuring;
mod media;

use std::f64::consts::PI;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{Affine3A, DVec3, Quat, Vec2, Vec3};
use sunroom::accel::Primitive;
use sunroom::color::Rgb;
use sunroom::light::LightSource;
use sunroom::meter::daylight::{OPEN_GROUND, daylight_factor, lit_by, overcast_sky, relative_luminance};
use sunroom::meter::estimate::Estimate;
use sunroom::meter::glare::{glare, position_index};
use sunroom::meter::job::{MeterEnd, MeterEnding, MeterError, MeterJob, MeterReading};
use sunroom::meter::sites::{AskedMeter, MeterKind, MeterLimits};
use sunroom::photometry::LUMENS_PER_WATT;
use sunroom::render::scene::RenderScene;
use sunroom::render::view::{Shown, Strategy, View};
use sunroom::shading::{Bsdf, Diffuse};

use crate::support::{SceneBuilder, camera, mean_luminance, render, view};

/// Lumens per watt.
const K: f64 = LUMENS_PER_WATT as f64;
/// The relative rounding error of sums of single precision.
const ROUNDING: f64 = 2e-5;

fn diffuse(reflectance: f32) -> Bsdf {
    Bsdf::Diffuse(Diffuse {
        reflectance: Rgb::splat(reflectance),
    })
}

fn settings(seed: u32) -> View {
    let mut view = View {
        seed,
        ..view(camera(Vec3::splat(2.0), Vec3::ZERO, 90.0), 1, u32::MAX, Strategy::Mis)
    };
    view.integrator.settings_mut().media = true;
    view
}

fn asked(kind: MeterKind, world_from_meter: Affine3A) -> AskedMeter {
    AskedMeter {
        name: "meter".to_owned(),
        world_from_meter,
        kind,
        limits: MeterLimits::default(),
    }
}

fn facing(normal: Vec3, at: Vec3) -> AskedMeter {
    let turned = Quat::from_rotation_arc(Vec3::Z, normal.normalize());
    asked(MeterKind::Point, Affine3A::from_rotation_translation(turned, at))
}

/// A horizontal grid of this half size and spacing.
fn grid(half: Vec2, at: Vec3, spacing: f32) -> AskedMeter {
    let up = Quat::from_rotation_arc(Vec3::Z, Vec3::Y);
    let place = Affine3A::from_scale_rotation_translation(half.extend(1.0), up, at);
    asked(MeterKind::Grid { spacing }, place)
}

fn pool(threads: usize) -> Arc<rayon::ThreadPool> {
    Arc::new(
        rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads"),
    )
}

fn measure(scene: &RenderScene, meters: Vec<AskedMeter>, end: &MeterEnd, seed: u32) -> Vec<MeterReading> {
    let mut job = MeterJob::new(scene.clone(), &settings(seed), meters).expect("meters that can measure");
    let ending = job.run(end, &pool(2), &AtomicBool::new(false), &mut |_, _| {});
    assert_eq!((ending, job.invalid_samples()), (MeterEnding::Done, 0));
    job.readings().expect("values")
}

/// The end after this number of samples, whatever the error is.
fn exactly(samples: u32) -> MeterEnd {
    MeterEnd {
        noise: 1e-9,
        samples,
        time: None,
    }
}

/// How many standard errors a value is off, and that it is no more than three.
fn off(what: &str, measured: Estimate, expected: f64) -> f64 {
    let error = measured.error + ROUNDING * expected.abs();
    let off = (measured.value - expected) / error;
    assert!(
        off.abs() < 3.0,
        "{what}: {measured:?}, expected {expected}: {off:.2} errors"
    );
    off
}

/// Holds that errors are neither too large nor too small.
fn assert_honest(off: &[f64]) {
    let mean_square = off.iter().map(|off| off * off).sum::<f64>() / off.len() as f64;
    assert!(
        (0.5..1.7).contains(&mean_square),
        "{mean_square} for {} values",
        off.len()
    );
}

/// The irradiance by a polygon of radiance 1 above the horizon of a point (Lambert 1760; Arvo, 1994, equation 2.4).
fn lambert(corners: &[DVec3], at: DVec3, normal: DVec3) -> f64 {
    let corner = |index: usize| corners[index % corners.len()] - at;
    let edge = |index: usize| {
        let (from, to) = (corner(index), corner(index + 1));
        from.angle_between(to) * from.cross(to).normalize_or_zero().dot(normal)
    };
    0.5 * (0..corners.len()).map(edge).sum::<f64>().abs()
}

/// The irradiance by a sky of the zenith radiance 1 through a window, by the midpoint rule: `window(u, v)` is a place
/// on it, from 0 to 1, and `area` its area.
fn through(window: impl Fn(f64, f64) -> DVec3, across: DVec3, area: f64, at: DVec3, normal: DVec3) -> f64 {
    const STEPS: u32 = 1000;
    let middle = |step: u32| (f64::from(step) + 0.5) / f64::from(STEPS);
    let cells = (0..STEPS).flat_map(|u| (0..STEPS).map(move |v| (middle(u), middle(v))));
    let sum: f64 = cells
        .map(|(u, v)| {
            let way = window(u, v) - at;
            let (distance, to) = (way.length_squared(), way.normalize());
            let sky = f64::from(relative_luminance(to.y.asin() as f32));
            sky * to.dot(normal).max(0.0) * to.dot(across).abs() / distance
        })
        .sum();
    sum * area / f64::from(STEPS * STEPS)
}

fn rectangle(half: Vec2, normal: Vec3, at: Vec3) -> Affine3A {
    let turned = Quat::from_rotation_arc(Vec3::Z, normal);
    Affine3A::from_scale_rotation_translation(half.extend(1.0), turned, at)
}

/// A lamp above a floor, with a wall beside it.
fn corner() -> RenderScene {
    let mut scene = SceneBuilder::default();
    let lamp = rectangle(Vec2::new(0.3, 0.5), Vec3::NEG_Y, Vec3::Y * 2.0);
    scene.add(Primitive::Rectangle, lamp, diffuse(0.0), Some(Rgb::splat(3.0)));
    scene.add(
        Primitive::Rectangle,
        rectangle(Vec2::splat(3.0), Vec3::Y, Vec3::ZERO),
        diffuse(0.6),
        None,
    );
    scene.add(
        Primitive::Rectangle,
        rectangle(Vec2::splat(3.0), Vec3::X, Vec3::X * -1.5),
        diffuse(0.8),
        None,
    );
    scene.build()
}
