//! Rays as lights send them: their power, their densities, and the light that they bring.

use std::f32::consts::{PI, TAU};
use std::sync::Arc;

use crate::statistics;
use crate::support::{
    SceneBuilder, all_around, assert_close, leaning_triangle, square_mesh, square_of_three_triangles,
};
use glam::{Affine3A, Mat3, Quat, Vec2, Vec3};
use sunroom::accel::Primitive;
use sunroom::color::{Rgb, luminance};
use sunroom::light::emission::{EmittedRay, Start};
use sunroom::light::{
    Atmosphere, EnvironmentMap, LightId, LightReference, LightSource, Luminaire, Projector, Spot, SurfaceHit,
};
use sunroom::math::Ray;
use sunroom::render::scene::RenderScene;
use sunroom::sampling::{Sampler, SequenceKind};
use sunroom::shading::{Bsdf, Diffuse};
use sunroom::texture::{Image, Parameter, Samples, Transfer};

const COUNT: u32 = 1 << 17;

fn black() -> Bsdf {
    Bsdf::Diffuse(Diffuse { reflectance: Rgb::ZERO })
}

fn placed(scale: Vec3, angle: f32, translation: Vec3) -> Affine3A {
    let turn = Quat::from_axis_angle(Vec3::new(1.0, 2.0, -0.5).normalize(), angle);
    Affine3A::from_scale_rotation_translation(scale, turn, translation)
}

fn surface(primitive: Primitive, to_world: Affine3A, flipped: bool) -> RenderScene {
    let mut scene = SceneBuilder::default();
    scene
        .add(primitive, to_world, black(), Some(Rgb::new(1.0, 2.0, 0.5)))
        .flip_normals = flipped;
    scene.build()
}

fn alone(source: LightSource) -> RenderScene {
    let mut scene = SceneBuilder::default();
    scene.add(Primitive::Sphere, Affine3A::from_scale(Vec3::splat(2.0)), black(), None);
    scene.light(source);
    scene.build()
}

/// A lamp that stands far from a floor.
fn far_surface(primitive: Primitive, to_world: Affine3A) -> RenderScene {
    let mut scene = SceneBuilder::default();
    let floor = placed(Vec3::splat(1.6), 0.0, Vec3::new(0.1, 0.4, -0.8));
    scene.add(Primitive::Rectangle, floor, black(), None);
    scene.add(primitive, to_world, black(), Some(Rgb::new(400.0, 800.0, 200.0)));
    scene.build()
}

/// One that shines on both sides.
fn leaning() -> Primitive {
    leaning_triangle([
        Vec3::new(-1.0, 0.0, 0.0),
        Vec3::new(1.0, 0.2, 0.3),
        Vec3::new(0.1, 1.0, -0.2),
    ])
}

fn spot(world_from_local: Affine3A) -> LightSource {
    LightSource::Spot(Spot {
        world_from_local,
        intensity: Rgb::new(3.0, 1.0, 2.0),
        cutoff_angle: 0.6,
        beam_angle: 0.4,
        texture: Parameter::Constant(Rgb::ONE),
    })
}

fn sky(width: u32, height: u32) -> LightSource {
    let pixel = |index: u32| {
        let sampler = Sampler::new(SequenceKind::Independent, glam::UVec2::new(index, 7), 0, 1);
        Rgb::splat(0.1 + 4.0 * sampler.at_1d(0).powi(4))
    };
    let pixels = (0..width * height)
        .map(pixel)
        .flat_map(|color: Rgb| color.to_array())
        .collect();
    let samples = Samples::F32(pixels);
    LightSource::Environment {
        map: Arc::new(EnvironmentMap::new(
            Arc::new(Image::new(width, height, 3, samples, Transfer::Linear).expect("a whole picture")),
            false,
        )),
        world_from_local: Mat3::from_rotation_x(0.7),
        scale: 2.0,
    }
}

/// A lamp whose picture has this number of columns and nine rows, of which the last `lit` shine.
fn lamp(columns: u32, lit: u32) -> LightSource {
    let candela = |row: u32, column: u32| match row + lit >= 9 {
        true => 0.5 + row as f32 + (column % 3) as f32,
        false => 0.0,
    };
    let pixels = (0..9).flat_map(|row| (0..columns).map(move |column| candela(row, column)));
    let samples = Samples::F32(pixels.collect());
    let image = Image::new(columns, 9, 1, samples, Transfer::Linear).expect("a whole picture");
    LightSource::Luminaire(Luminaire {
        position: Vec3::new(0.0, 3.0, 1.0),
        world_from_local: Mat3::from_rotation_x(1.9) * Mat3::from_rotation_z(0.4),
        map: Arc::new(EnvironmentMap::new(Arc::new(image), false)),
        scale: Rgb::new(3.0, 1.0, 2.0),
    })
}

/// Lights of every kind, each alone.
fn lights() -> Vec<(&'static str, RenderScene)> {
    let turned = placed(Vec3::ONE, 0.8, Vec3::new(0.3, -0.2, 0.5));
    let stretched = placed(Vec3::new(1.5, 0.7, 1.1), 0.8, Vec3::new(0.3, -0.2, 0.5));
    vec![
        ("rectangle", surface(Primitive::Rectangle, stretched, false)),
        ("flipped rectangle", surface(Primitive::Rectangle, turned, true)),
        ("disk", surface(Primitive::Disk, stretched, false)),
        ("sphere", surface(Primitive::Sphere, turned, false)),
        ("sphere from within", surface(Primitive::Sphere, turned, true)),
        ("ellipsoid", surface(Primitive::Sphere, stretched, false)),
        ("cylinder", surface(Primitive::Cylinder, turned, false)),
        ("elliptic cylinder", surface(Primitive::Cylinder, stretched, true)),
        ("square of triangles", surface(square_mesh(), stretched, false)),
        ("three triangles", surface(square_of_three_triangles(), turned, true)),
        ("leaning triangle", surface(leaning(), stretched, false)),
        (
            "far sphere",
            far_surface(Primitive::Sphere, placed(Vec3::ONE, 0.8, Vec3::new(9.0, 20.0, 12.0))),
        ),
        (
            "far leaning triangle",
            far_surface(leaning(), placed(Vec3::splat(2.0), 0.8, Vec3::new(-5.0, 6.0, 9.0))),
        ),
        (
            "far point",
            alone(LightSource::Point {
                position: Vec3::new(3.5, 6.0, -4.0),
                intensity: Rgb::new(3.0, 1.0, 2.0),
            }),
        ),
        (
            "point",
            alone(LightSource::Point {
                position: Vec3::new(0.5, 3.0, -1.0),
                intensity: Rgb::new(3.0, 1.0, 2.0),
            }),
        ),
        (
            "spot",
            alone(spot(placed(Vec3::splat(2.0), 0.8, Vec3::new(0.0, 3.0, 1.0)))),
        ),
        (
            "sheared spot",
            alone(spot(placed(Vec3::new(1.5, 0.7, 1.1), 0.8, Vec3::new(0.0, 3.0, 1.0)))),
        ),
        ("lamp", alone(lamp(12, 7))),
        ("lamp for all directions", alone(lamp(5, 9))),
        ("narrow lamp", alone(lamp(1, 2))),
        (
            "projector",
            alone(LightSource::Projector(Projector {
                world_from_local: placed(Vec3::ONE, 0.8, Vec3::new(0.0, 3.0, 1.0)),
                irradiance: Parameter::Constant(Rgb::new(3.0, 1.0, 2.0)),
                scale: 1.5,
                half_size: Vec2::new(0.4, 0.7),
            })),
        ),
        (
            "directional",
            alone(LightSource::Directional {
                direction: Vec3::new(0.3, -1.0, 0.4).normalize(),
                irradiance: Rgb::new(3.0, 1.0, 2.0),
            }),
        ),
        (
            "constant",
            alone(LightSource::Constant {
                radiance: Rgb::new(1.0, 2.0, 0.5),
            }),
        ),
        ("environment", alone(sky(16, 8))),
        (
            "sun and sky",
            alone(LightSource::SunSky {
                atmosphere: Atmosphere {
                    turbidity: 3.0,
                    albedo: Rgb::splat(0.3),
                    sun_direction: Vec3::new(0.5, 0.3, 0.8).normalize(),
                    sky_scale: 1.0,
                    sun_scale: 1.0,
                    sun_aperture: 0.01,
                    limb_darkening: false,
                },
                world_from_local: Mat3::from_rotation_x(-PI / 2.0),
            }),
        ),
    ]
}

fn rays(scene: &RenderScene) -> impl Iterator<Item = Option<EmittedRay>> {
    let reach = scene.reach;
    (0..COUNT).map(move |index| {
        let sampler = Sampler::new(SequenceKind::Independent, glam::UVec2::new(5, 9), index, 3);
        scene
            .lights
            .sample_emission(&reach, sampler.at_1d(0), sampler.at_2d(1), sampler.at_2d(2))
    })
}

/// The mean of values and its standard error.
fn mean(values: impl Iterator<Item = f32>) -> (f32, f32) {
    let (mut count, mut sum, mut squares) = (0.0f64, 0.0f64, 0.0f64);
    for value in values.map(f64::from) {
        (count, sum, squares) = (count + 1.0, sum + value, squares + value * value);
    }
    let mean = sum / count;
    let variance = (squares / count - mean * mean).max(0.0) / count;
    (mean as f32, variance.sqrt() as f32)
}

/// The light that arrives at a small ball, by rays from the lights and by sampling lights from its surface.
#[test]
fn rays_bring_the_light_that_sampling_finds() {
    for (name, scene) in lights() {
        for (center, radius) in [(Vec3::new(0.6, 1.1, -0.4), 0.3), (Vec3::new(-0.3, 0.1, 0.9), 0.25)] {
            let (ball, squared) = (center, radius * radius);
            let meets = |ray: &EmittedRay| {
                let along = (ball - ray.origin).dot(ray.dir);
                let nearest = ray.origin + along * ray.dir;
                let aside = nearest.distance_squared(ball);
                let t = along - (squared - aside).max(0.0).sqrt();
                // What stands in between keeps the ray away, and from within the ball no ray comes.
                let is_free = aside < squared && t > 0.0;
                let segment = Ray::segment(ray.origin, ray.origin + t * ray.dir);
                is_free && !scene.geometry.occluded(&segment)
            };
            let by_rays = mean(rays(&scene).map(|ray| match ray {
                Some(ray) if meets(&ray) => luminance(ray.power),
                _ => 0.0,
            }));
            let found = mean((0..COUNT).map(|index| {
                let sampler = Sampler::new(SequenceKind::Independent, glam::UVec2::new(6, 2), index, 4);
                let normal = sunroom::sampling::warp::uniform_sphere(sampler.at_2d(0).to_array());
                let reference = LightReference {
                    position: ball + radius * normal,
                    normal: Some(normal),
                };
                let sample = scene.lights.sample(&reference, sampler.at_1d(1), sampler.at_2d(2));
                let Some((_, sample)) = sample else { return 0.0 };
                let ray = match sample.target {
                    sunroom::light::Target::Point(target) => Ray::segment(reference.position, target),
                    sunroom::light::Target::Infinity => Ray::new(reference.position, sample.wi),
                };
                if scene.geometry.occluded(&ray) {
                    return 0.0;
                }
                let area = 2.0 * TAU * squared;
                luminance(sample.radiance) * normal.dot(sample.wi).max(0.0) * area / sample.pdf
            }));
            assert_close(name, (by_rays.0, by_rays.1.hypot(found.1)), found.0);
        }
    }
}

/// What another technique says of the density of a ray is what it was sampled by.
#[test]
fn densities_agree() {
    for (name, scene) in lights() {
        let reach = scene.reach;
        let mut seen = 0;
        for ray in rays(&scene).flatten().filter(|ray| ray.power != Rgb::ZERO).take(2000) {
            let found = match &ray.start {
                Start::Surface(hit) => scene.lights.emission_pdf_of_hit(ray.light, &reach, hit, ray.dir),
                Start::Infinity { .. } => scene.lights.emission_pdf_from(ray.light, &reach, -ray.dir),
                Start::Point(_) => continue,
            };
            for (found, expected) in [(found.start, ray.pdf.start), (found.next, ray.pdf.next)] {
                assert!(
                    (found / expected - 1.0).abs() < 2e-3,
                    "{name}: {found} {expected} {ray:?}"
                );
            }
            seen += 1;
        }
        let is_point =
            name.contains("lamp") || ["point", "far point", "spot", "sheared spot", "projector"].contains(&name);
        assert!(seen > 500 || is_point, "{name}: {seen}");
    }
}

/// Sampling a light says the densities of the ray from there, and finds starts with the density that it is said to.
#[test]
fn sampled_lights_know_the_densities_of_their_rays() {
    // On all sides of the light, and within.
    let places = [
        Vec3::new(0.4, 2.5, 1.5),
        Vec3::new(-0.4, -2.5, -1.5),
        Vec3::new(0.4, -0.1, 0.6),
    ];
    for (name, scene) in lights() {
        let reach = scene.reach;
        let mut seen = 0;
        for index in 0..3000 {
            let reference = all_around(places[index as usize % 3]);
            let sampler = Sampler::new(SequenceKind::Independent, glam::UVec2::new(1, 2), index, 4);
            let found = scene
                .lights
                .sample_start(&reach, &reference, sampler.at_1d(0), sampler.at_2d(1));
            let Some((id, sample, start, emission)) = found else {
                continue;
            };
            let plain = scene.lights.sample(&reference, sampler.at_1d(0), sampler.at_2d(1));
            assert_eq!(plain, Some((id, sample)), "{name}");
            let pdf = scene.lights.pdf_of_start(id, &reference, &start, sample.wi);
            assert!((pdf / sample.pdf - 1.0).abs() < 2e-3, "{name}: {pdf} {}", sample.pdf);
            let again = match &start {
                Start::Surface(hit) => scene.lights.emission_pdf_of_hit(id, &reach, hit, -sample.wi),
                Start::Infinity { .. } => scene.lights.emission_pdf_from(id, &reach, sample.wi),
                Start::Point(_) => emission,
            };
            assert!((again.start / emission.start - 1.0).abs() < 2e-3, "{name}");
            assert!((again.next / emission.next - 1.0).abs() < 2e-3, "{name}");
            assert_eq!(start.is_delta(), sample.is_delta, "{name}");
            seen += 1;
        }
        assert!(
            seen > 100 || name == "sphere from within" || name == "elliptic cylinder",
            "{name}: {seen}"
        );
    }
}

/// Directions from points follow their density.
#[test]
fn directions_follow_their_density() {
    let mut results = Vec::new();
    for (name, scene) in lights() {
        let directions: Vec<Option<Vec3>> = rays(&scene)
            .map(|ray| match ray {
                Some(EmittedRay {
                    dir,
                    start: Start::Point(_),
                    ..
                }) => Some(dir),
                _ => None,
            })
            .collect();
        let Some(axis) = directions.iter().flatten().copied().reduce(|a, b| a + b) else {
            continue;
        };
        let place = rays(&scene).flatten().next().expect("a ray").origin;
        let reach = scene.reach;
        let density = |dir: Vec3| {
            let reference = all_around(place + dir);
            let found = scene.lights.sample_start(&reach, &reference, 0.5, Vec2::splat(0.5));
            found.map_or(0.0, |(.., emission)| emission.next)
        };
        let p = statistics::sphere_p(
            COUNT,
            axis.normalize_or(Vec3::Z),
            |index| directions[index as usize],
            density,
        );
        results.push((name.to_owned(), p));
    }
    assert_eq!(results.len(), 8);
    statistics::assert_all_plausible(&results);
}

/// Most of what a lamp far away sends goes to the things that it lights.
#[test]
fn far_lamps_send_their_rays_to_the_scene() {
    let mut seen = 0;
    for (name, scene) in lights() {
        let reach = scene.reach;
        let is_lamp = |ray: &EmittedRay| ray.power != Rgb::ZERO;
        let rays: Vec<EmittedRay> = rays(&scene).flatten().filter(is_lamp).take(4000).collect();
        let meets = |ray: &&EmittedRay| {
            let along = (reach.lit.center - ray.origin).dot(ray.dir);
            (ray.origin + along * ray.dir).distance(reach.lit.center) < reach.lit.radius
        };
        if name.starts_with("far ") {
            assert!(reach.lit.radius < 3.6, "{name}: {reach:?}");
            let share = rays.iter().filter(meets).count() as f32 / rays.len() as f32;
            // Half of a sphere is turned away.
            let expected = if name == "far sphere" { 0.4 } else { 0.85 };
            assert!(share > expected, "{name}: {share}");
            seen += 1;
        } else {
            assert_eq!(reach.lit, reach.everything, "{name}");
        }
    }
    assert_eq!(seen, 3);
}

/// With many lights, each sends its share of the power.
#[test]
fn many_lights_send_their_power() {
    let mut scene = SceneBuilder::default();
    for index in 0..40 {
        let x = 3.0 * index as f32;
        let scale = 0.2 + 0.02 * index as f32;
        let to_world = Affine3A::from_scale_rotation_translation(
            Vec3::splat(scale),
            Quat::from_rotation_y(index as f32),
            Vec3::new(x, 0.0, 0.0),
        );
        scene.add(
            Primitive::Rectangle,
            to_world,
            black(),
            Some(Rgb::splat(1.0 + index as f32)),
        );
    }
    scene.light(LightSource::Constant {
        radiance: Rgb::splat(0.01),
    });
    let scene = scene.build();
    let reach = scene.reach;
    let of_light = |light: LightId| {
        mean(rays(&scene).map(|ray| match ray {
            Some(ray) if ray.light == light => luminance(ray.power),
            _ => 0.0,
        }))
    };
    for index in [0, 7, 39] {
        let scale = 0.2 + 0.02 * index as f32;
        let expected = PI * 4.0 * scale * scale * (1.0 + index as f32);
        assert_close(&format!("light {index}"), of_light(LightId(index)), expected);
    }
    let radius = reach.everything.radius;
    let expected = 4.0 * PI * PI * radius * radius * 0.01;
    assert_close("sky", of_light(LightId(40)), expected);
}

/// A point beside the light has no density of its own.
#[test]
fn a_hit_on_no_light_has_no_density() {
    let scene = alone(LightSource::Point {
        position: Vec3::Y,
        intensity: Rgb::ONE,
    });
    let hit = SurfaceHit {
        position: Vec3::ZERO,
        normal: Vec3::Z,
        shading_normal: Vec3::Z,
        primitive: 0,
        barycentric: Vec2::ZERO,
        uv: Vec2::ZERO,
    };
    let pdf = scene
        .lights
        .emission_pdf_of_hit(LightId(0), &scene.reach, &hit, Vec3::Z);
    assert_eq!((pdf.start, pdf.next), (0.0, 0.0));
}
