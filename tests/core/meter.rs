//! The meter against closed forms, among them the analytic cases of CIE 171:2006, Test Cases to Assess the Accuracy of
//! Lighting Computer Programs, that apply: 5.2 point lights, 5.3 area lights, 5.6 light reflected by a diffuse surface,
//! 5.8 light reflected inside of a closed room, 5.9 and 5.11 the sky through openings. The expected values are computed
//! here, not taken from its tables.
//!
//! Values have to be within three of their own standard errors, and the errors together as large as they are told: a
//! meter that tells too large errors fails as one does that tells too small ones.

use std::f64::consts::PI;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{Affine3A, DVec3, Quat, Vec2, Vec3};
use sunroom::accel::Primitive;
use sunroom::color::Rgb;
use sunroom::light::LightSource;
use sunroom::meter::daylight::{OPEN_GROUND, daylight_factor, lit_by, overcast_sky, relative_luminance};
use sunroom::meter::estimate::Estimate;
use sunroom::meter::job::{MeterEnd, MeterEnding, MeterError, MeterJob, MeterReading};
use sunroom::meter::sites::{AskedMeter, MeterKind, MeterLimits};
use sunroom::photometry::LUMENS_PER_WATT;
use sunroom::render::scene::RenderScene;
use sunroom::render::view::{Strategy, View};
use sunroom::shading::{Bsdf, Diffuse};

use crate::support::{SceneBuilder, camera, view};

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
    View {
        seed,
        ..view(camera(Vec3::ONE, Vec3::ZERO, 90.0), 1, u32::MAX, Strategy::Mis)
    }
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

/// As many samples as these.
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

/// CIE 171, 5.2: the illuminance of a point light is I cos^3 / h^2 on a plane.
#[test]
fn a_point_light_over_a_plane_falls_with_the_cube_of_the_cosine() {
    let (height, intensity) = (3.0, 100.0 / 683.0);
    let mut scene = SceneBuilder::default();
    scene.light(LightSource::Point {
        position: Vec3::new(0.5, height, -1.0),
        intensity: Rgb::splat(intensity),
    });
    let scene = scene.build();
    let places = [0.0, 1.0, 2.5, 5.0, 40.0];
    let meters = places.map(|x| facing(Vec3::Y, Vec3::new(0.5 + x, 0.0, -1.0))).to_vec();
    for (x, reading) in places.iter().zip(measure(&scene, meters, &exactly(64), 1)) {
        let (h, x) = (f64::from(height), f64::from(*x));
        let cosine = h / h.hypot(x);
        off("point", reading.points[0], 100.0 * cosine.powi(3) / (h * h));
    }
    // From behind no light arrives, and the dark is certain.
    let behind = &measure(&scene, vec![facing(Vec3::NEG_Y, Vec3::ZERO)], &exactly(64), 1)[0];
    assert_eq!(behind.points[0], Estimate::default());
}

/// CIE 171, 5.3.
#[test]
fn area_lights_over_a_plane_have_the_illuminance_of_their_form_factors() {
    let radiance = 4.0;
    let mut found = Vec::new();
    let (half, at) = (Vec2::new(0.5, 0.25), Vec3::new(0.3, 2.0, -0.2));
    let mut scene = SceneBuilder::default();
    scene.add(
        Primitive::Rectangle,
        rectangle(half, Vec3::NEG_Y, at),
        diffuse(0.0),
        Some(Rgb::splat(radiance)),
    );
    let scene_of_rectangle = scene.build();
    let reading = &measure(
        &scene_of_rectangle,
        vec![grid(Vec2::splat(2.0), Vec3::ZERO, 0.5)],
        &exactly(2048),
        2,
    )[0];
    assert_eq!(reading.points.len(), 64);
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    // The lamp's own x is the world's, or its opposite.
    let corners = corners.map(|(x, z)| (at + Vec3::new(half.x * x, 0.0, half.y * z)).as_dvec3());
    for (place, measured) in reading.positions.iter().zip(&reading.points) {
        let expected = K * f64::from(radiance) * lambert(&corners, place.as_dvec3(), DVec3::Y);
        found.push(off("rectangle", *measured, expected));
    }
    // A disk over parallel elements at lateral distances (Howell, A Catalog of Radiation Heat Transfer Configuration
    // Factors, B-13).
    let (radius, height) = (0.7f64, 1.5f64);
    let mut scene = SceneBuilder::default();
    let place = rectangle(Vec2::splat(radius as f32), Vec3::NEG_Y, Vec3::Y * height as f32);
    scene.add(Primitive::Disk, place, diffuse(0.0), Some(Rgb::splat(radiance)));
    let scene = scene.build();
    let places: Vec<f32> = (0..16).map(|step| 0.2 * step as f32).collect();
    let meters = places.iter().map(|x| facing(Vec3::Y, Vec3::X * *x)).collect();
    for (x, reading) in places.iter().zip(measure(&scene, meters, &exactly(2048), 3)) {
        let (r, h, l) = (radius * radius, height * height, f64::from(*x).powi(2));
        let factor = 0.5 * (1.0 + (r - l - h) / ((l + h + r).powi(2) - 4.0 * r * l).sqrt());
        found.push(off("disk", reading.points[0], K * PI * f64::from(radiance) * factor));
    }
    assert_honest(&found);
}

/// CIE 171, 5.8, in a sphere, where the reflected light is the same everywhere.
#[test]
fn inside_of_spheres_light_is_the_same_everywhere() {
    let sphere = |albedo: f32, radiance: Option<Rgb>| {
        let mut scene = SceneBuilder::default();
        let place = Affine3A::from_scale(Vec3::splat(3.0));
        scene
            .add(Primitive::Sphere, place, diffuse(albedo), radiance)
            .flip_normals = true;
        scene
    };
    let meters = || {
        let places = [Vec3::ZERO, Vec3::new(1.0, 2.0, -1.5), Vec3::new(-2.9, 0.0, 0.0)];
        let normals = [Vec3::Y, Vec3::new(1.0, -1.0, 0.3), Vec3::NEG_Z];
        let pairs = places
            .into_iter()
            .flat_map(|at| normals.map(|normal| facing(normal, at)));
        pairs.collect::<Vec<_>>()
    };
    let mut found = Vec::new();
    for albedo in [0.0, 0.5, 0.8] {
        let scene = sphere(albedo, Some(Rgb::splat(3.0))).build();
        for reading in measure(&scene, meters(), &exactly(2048), 4) {
            let expected = K * PI * 3.0 / (1.0 - f64::from(albedo));
            let off = off("shining sphere", reading.points[0], expected);
            if albedo > 0.0 {
                found.push(off);
            }
        }
    }
    // An integrating sphere with a point light in its middle, measured on its wall.
    let (albedo, lumens) = (0.7, 500.0);
    let mut scene = sphere(albedo, None);
    scene.light(LightSource::Point {
        position: Vec3::ZERO,
        intensity: Rgb::splat((lumens / (4.0 * PI * K)) as f32),
    });
    let scene = scene.build();
    let normals = [Vec3::Y, Vec3::X, Vec3::new(1.0, 1.0, 1.0), Vec3::new(-3.0, 1.0, 0.5)];
    let walls = normals
        .map(|normal| facing(normal, -2.9999 * normal.normalize()))
        .to_vec();
    for reading in measure(&scene, walls, &exactly(8192), 5) {
        let expected = lumens / (4.0 * PI * 9.0) / (1.0 - f64::from(albedo));
        // The points are a little inside of the wall, nearer to the light.
        let nearer = lumens / (4.0 * PI) * (1.0 / 2.9999f64.powi(2) - 1.0 / 9.0);
        found.push(off("integrating sphere", reading.points[0], expected + nearer));
    }
    assert_honest(&found);
}

/// CIE 171, 5.6: a point light on a diffuse square, which lights a point beside it that the lamp does not reach.
#[test]
fn a_diffuse_surface_lights_what_faces_it() {
    let (albedo, intensity) = (0.8f32, 2.0f32);
    let mut scene = SceneBuilder::default();
    scene.add(
        Primitive::Rectangle,
        rectangle(Vec2::splat(0.5), Vec3::Y, Vec3::ZERO),
        diffuse(albedo),
        None,
    );
    let lamp = Vec3::new(0.2, 1.5, 0.1);
    scene.light(LightSource::Point {
        position: lamp,
        intensity: Rgb::splat(intensity),
    });
    let scene = scene.build();
    let (at, normal) = (DVec3::new(0.1, 0.8, -0.3), DVec3::NEG_Y);
    let window = |u: f64, v: f64| DVec3::new(u - 0.5, 0.0, v - 0.5);
    const STEPS: u32 = 1000;
    let middle = |step: u32| (f64::from(step) + 0.5) / f64::from(STEPS);
    let lit = |place: DVec3| {
        let way = lamp.as_dvec3() - place;
        f64::from(intensity) * way.normalize().y / way.length_squared()
    };
    let sum: f64 = (0..STEPS)
        .flat_map(|u| (0..STEPS).map(move |v| window(middle(u), middle(v))))
        .map(|place| {
            let way = place - at;
            let to = way.normalize();
            lit(place) * f64::from(albedo) / PI * to.dot(normal) * -to.y / way.length_squared()
        })
        .sum();
    let expected = K * sum / f64::from(STEPS * STEPS);
    let reading = &measure(&scene, vec![facing(Vec3::NEG_Y, at.as_vec3())], &exactly(1 << 14), 6)[0];
    off("reflected", reading.points[0], expected);
}

#[test]
fn a_uniform_sky_lights_a_plane_by_pi() {
    let mut scene = SceneBuilder::default();
    scene.light(LightSource::Constant {
        radiance: Rgb::splat(2.0),
    });
    let ground = rectangle(Vec2::splat(1e5), Vec3::Y, Vec3::ZERO);
    scene.add(Primitive::Rectangle, ground, diffuse(0.0), None);
    // A wall beside the second point, which takes half of its sky but for what is seen past its ends.
    let wall = rectangle(Vec2::splat(50.0), Vec3::X, Vec3::new(20.0, 0.0, 0.0));
    scene.add(Primitive::Rectangle, wall, diffuse(0.0), None);
    let scene = scene.build();
    let places = [
        (Vec3::Y, Vec3::new(-4e4, 0.01, 0.0)),
        (Vec3::X, Vec3::new(-4e4, 1.0, 0.0)),
        (Vec3::Y, Vec3::new(20.01, 0.01, 0.0)),
        (Vec3::Y, Vec3::new(12.0, 0.01, 7.0)),
    ];
    let readings = measure(
        &scene,
        places.map(|(normal, at)| facing(normal, at)).to_vec(),
        &exactly(4096),
        7,
    );
    let whole = K * 2.0 * PI;
    let past_wall = |at: Vec3| {
        // What is above the horizon of the point.
        let low = f64::from(at.y);
        let corners = [(low, -50.0), (50.0, -50.0), (50.0, 50.0), (low, 50.0)].map(|(y, z)| DVec3::new(20.0, y, z));
        K * 2.0 * (PI - lambert(&corners, at.as_dvec3(), DVec3::Y))
    };
    off("open plane", readings[0].points[0], whole);
    off("upright", readings[1].points[0], 0.5 * whole);
    let behind = past_wall(places[2].1);
    assert!(
        (behind / (0.5 * whole) - 1.0).abs() < 2e-3,
        "half of the sky is hidden: {behind} of {whole}"
    );
    off("at the wall", readings[2].points[0], behind);
    off("before the wall", readings[3].points[0], past_wall(places[3].1));
}

#[test]
fn an_overcast_sky_gives_the_open_ground_its_lux() {
    for up in [Vec3::Y, Vec3::Z, Vec3::NEG_X] {
        // A lamp of the scene does not shine under that sky, nor does another sky.
        let mut scene = SceneBuilder::default();
        let lamp = rectangle(Vec2::splat(0.01), -up, 5.0 * up);
        scene.add(Primitive::Rectangle, lamp, diffuse(0.0), Some(Rgb::splat(1e9)));
        scene.light(LightSource::Constant { radiance: Rgb::ONE });
        let scene = lit_by(&scene.build(), overcast_sky(up));
        let side = up.any_orthonormal_vector();
        let meters = [up, side, -up].map(|normal| facing(normal, Vec3::ZERO)).to_vec();
        let readings = measure(&scene, meters, &exactly(1 << 14), 8);
        let ground = f64::from(OPEN_GROUND);
        // The lamp's shadow is of no account.
        off("ground", readings[0].points[0], ground);
        // Upright, of the zenith's luminance: pi / 6 + 4 / 9, for 7 pi / 9 on the ground.
        let upright = ground * (PI / 6.0 + 4.0 / 9.0) / (7.0 / 9.0 * PI);
        off("upright", readings[1].points[0], upright);
        assert!(readings[2].points[0].value < 1e-3 * ground, "{:?}", readings[2]);
        assert!((daylight_factor(readings[0].points[0].value) - 100.0).abs() < 1.0);
    }
}

/// CIE 171, 5.9 and 5.11: the sky component through openings of a black room of 4 x 4 x 3 without glass.
#[test]
fn the_sky_through_openings_has_the_sky_component_of_the_openings() {
    let zenith = f64::from(OPEN_GROUND) / (7.0 / 9.0 * PI);
    let mut found = Vec::new();
    let slab = |scene: &mut SceneBuilder, half: Vec2, normal: Vec3, at: Vec3| {
        scene.add(Primitive::Rectangle, rectangle(half, normal, at), diffuse(0.0), None);
    };
    // Closed but for one side; the openings are made of the parts around them.
    let closed = |without: Vec3| {
        let mut scene = SceneBuilder::default();
        for (normal, middle) in [
            (Vec3::X, Vec3::new(-2.0, 1.5, 0.0)),
            (Vec3::NEG_X, Vec3::new(2.0, 1.5, 0.0)),
            (Vec3::Z, Vec3::new(0.0, 1.5, -2.0)),
            (Vec3::NEG_Z, Vec3::new(0.0, 1.5, 2.0)),
            (Vec3::Y, Vec3::new(0.0, 0.0, 0.0)),
            (Vec3::NEG_Y, Vec3::new(0.0, 3.0, 0.0)),
        ] {
            if normal != without {
                slab(&mut scene, Vec2::splat(2.0), normal, middle);
            }
        }
        scene
    };
    // A hole of 1 x 1 in the middle of the roof.
    let mut roof = closed(Vec3::NEG_Y);
    for (x, z, half) in [
        (-1.25, 0.0, Vec2::new(0.75, 2.0)),
        (1.25, 0.0, Vec2::new(0.75, 2.0)),
        (0.0, -1.25, Vec2::new(0.5, 0.75)),
        (0.0, 1.25, Vec2::new(0.5, 0.75)),
    ] {
        slab(&mut roof, half, Vec3::NEG_Y, Vec3::new(x, 3.0, z));
    }
    let scene = lit_by(&roof.build(), overcast_sky(Vec3::Y));
    let floor = || vec![grid(Vec2::splat(1.9), Vec3::Y * 1e-3, 0.7)];
    let reading = &measure(&scene, floor(), &exactly(8192), 9)[0];
    let hole = |u: f64, v: f64| DVec3::new(u - 0.5, 3.0, v - 0.5);
    for (place, measured) in reading.positions.iter().zip(&reading.points) {
        let expected = zenith * through(hole, DVec3::Y, 1.0, place.as_dvec3(), DVec3::Y);
        found.push(off("roof", *measured, expected));
    }
    // A window of 2 x 1 in a wall, 1 above the floor.
    let mut facade = closed(Vec3::NEG_X);
    for (y, z, half) in [
        (0.5, 0.0, Vec2::new(0.5, 2.0)),
        (2.5, 0.0, Vec2::new(0.5, 2.0)),
        (1.5, -1.5, Vec2::new(0.5, 0.5)),
        (1.5, 1.5, Vec2::new(0.5, 0.5)),
    ] {
        let place = Affine3A::from_mat3_translation(
            glam::Mat3::from_cols(Vec3::Y * half.x, Vec3::Z * half.y, Vec3::X),
            Vec3::new(2.0, y, z),
        );
        facade.add(Primitive::Rectangle, place, diffuse(0.0), None);
    }
    let scene = lit_by(&facade.build(), overcast_sky(Vec3::Y));
    let reading = &measure(&scene, floor(), &exactly(8192), 10)[0];
    let window = |u: f64, v: f64| DVec3::new(2.0, 1.0 + u, 2.0 * v - 1.0);
    for (place, measured) in reading.positions.iter().zip(&reading.points) {
        let expected = zenith * through(window, DVec3::X, 2.0, place.as_dvec3(), DVec3::Y);
        found.push(off("facade", *measured, expected));
    }
    assert_honest(&found);
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

#[test]
fn values_depend_on_the_seed_and_not_on_threads() {
    let scene = corner();
    let meters = || {
        vec![
            grid(Vec2::ONE, Vec3::Y * 0.7, 0.3),
            facing(Vec3::Y, Vec3::new(0.4, 0.0, 0.2)),
        ]
    };
    let readings = |threads, seed| {
        let mut job = MeterJob::new(scene.clone(), &settings(seed), meters()).expect("meters");
        let end = MeterEnd {
            noise: 0.02,
            ..MeterEnd::default()
        };
        job.run(&end, &pool(threads), &AtomicBool::new(false), &mut |_, _| {});
        job.readings().expect("values")
    };
    let one = readings(1, 5);
    assert_eq!(one, readings(3, 5));
    assert_ne!(one, readings(3, 6));
    // Neighbouring seeds have no set of samples in common.
    let values = |readings: &[MeterReading]| readings[1].points[0].value;
    assert!((values(&one) - values(&readings(1, 6))).abs() > 1e-3 * one[1].points[0].error);
}

#[test]
fn measuring_ends_at_the_error_asked_for_or_at_the_most_samples() {
    let scene = corner();
    let meters = || {
        vec![
            grid(Vec2::ONE, Vec3::Y * 0.7, 0.5),
            facing(Vec3::Y, Vec3::new(0.4, 0.0, 0.2)),
        ]
    };
    for noise in [0.05, 0.01, 0.003] {
        let end = MeterEnd {
            noise,
            samples: 1 << 20,
            time: None,
        };
        for reading in measure(&scene, meters(), &end, 11) {
            let error = reading.grid.map_or(reading.points[0].relative_error(), |grid| {
                grid.least.relative_error().max(grid.mean.relative_error())
            });
            assert!(error <= noise, "{error} for {noise}");
            assert!(
                reading.samples >= 512 && reading.samples < 1 << 20,
                "{}",
                reading.samples
            );
        }
    }
    let samples: Vec<u32> = measure(&scene, meters(), &exactly(1000), 11)
        .iter()
        .map(|it| it.samples)
        .collect();
    assert_eq!(samples, [1024; 2]);
}

#[test]
fn a_cancelled_job_keeps_its_values() {
    let mut job = MeterJob::new(corner(), &settings(1), vec![grid(Vec2::ONE, Vec3::Y, 0.2)]).expect("a meter");
    assert_eq!(job.readings(), None);
    let cancel = AtomicBool::new(false);
    let mut looks = 0;
    let ending = job.run(&exactly(1 << 30), &pool(2), &cancel, &mut |job, done| {
        looks += 1;
        assert!((0.0..=1.0).contains(&done));
        if job.readings().is_some() {
            cancel.store(true, std::sync::atomic::Ordering::Relaxed);
        }
    });
    assert_eq!(ending, MeterEnding::Cancelled);
    assert!(looks > 1);
    let reading = &job.readings().expect("values")[0];
    assert!(reading.grid.expect("a grid").mean.value > 0.0);
}

#[test]
fn limits_are_judged_and_buried_meters_found() {
    let limits = |least, mean, uniformity| MeterLimits {
        least: Some(least),
        mean: Some(mean),
        uniformity: Some(uniformity),
    };
    let mut meters = vec![grid(Vec2::ONE, Vec3::Y * 0.7, 0.5); 2];
    meters[0].limits = limits(1.0, 2.0, 0.01);
    meters[1].limits = limits(1.0, 2.0, 0.99);
    meters.push(facing(Vec3::Y, Vec3::NEG_Y));
    let readings = measure(&corner(), meters, &MeterEnd::default(), 3);
    assert!(readings[0].passes());
    let judged: Vec<bool> = readings[1].judgements().iter().map(|it| it.passes()).collect();
    assert_eq!(judged, [true, true, false]);
    assert!(!readings[1].passes() && !readings[1].judgements()[2].is_close());
    assert!(readings[2].judgements().is_empty() && readings[2].passes());
    // Below the floor it meets the back of the floor.
    assert!(readings[2].is_buried && !readings[0].is_buried);
    let huge = vec![grid(Vec2::splat(1e4), Vec3::ZERO, 0.1)];
    assert!(matches!(
        MeterJob::new(corner(), &settings(1), huge),
        Err(MeterError::Sites { .. })
    ));
    let many = vec![grid(Vec2::ONE, Vec3::ZERO, 0.016); 5];
    let error = MeterJob::new(corner(), &settings(1), many)
        .err()
        .expect("too many points");
    assert!(matches!(error, MeterError::TooManyPoints(_)), "{error}");
}
