//! Every light's sampling against its density, and the density of a found direction against that of a sampled one.

use std::sync::Arc;

use crate::statistics;
use crate::support::{
    SceneBuilder, all_around, leaning_triangle, square_mesh, square_of_three_triangles, triangle_mesh,
};
use glam::{Affine3A, Quat, Vec2, Vec3};
use sunroom::accel::{Blas, Primitive, SplitMethod};
use sunroom::color::Rgb;
use sunroom::geometry::primitives::unit_cube;
use sunroom::light::{LightId, LightReference, LightSource, LightTable, SurfaceHit, Target, WeightedSource};
use sunroom::math::Ray;
use sunroom::render::scene::RenderScene;
use sunroom::sampling::{Sampler, SequenceKind};
use sunroom::shading::{Bsdf, Diffuse};

fn black() -> Bsdf {
    Bsdf::Diffuse(Diffuse { reflectance: Rgb::ZERO })
}

/// One emitting shape, seen from the origin.
fn emitter(primitive: Primitive, to_world: Affine3A, flipped: bool) -> RenderScene {
    let mut scene = SceneBuilder::default();
    scene.add(primitive, to_world, black(), Some(Rgb::ONE)).flip_normals = flipped;
    scene.build()
}

/// One shape that shines from both sides.
fn both_ways(primitive: Primitive, to_world: Affine3A, flipped: bool) -> RenderScene {
    let mut scene = SceneBuilder::default();
    scene.add(primitive, to_world, black(), Some(Rgb::ONE)).flip_normals = flipped;
    scene.both_ways();
    scene.build()
}

/// Turned so that it shines on the origin.
fn triangle(corners: [Vec3; 3]) -> RenderScene {
    let [a, b, c] = corners;
    let away = (b - a).cross(c - a).dot(a) > 0.0;
    emitter(triangle_mesh([corners]), Affine3A::IDENTITY, away)
}

/// Small triangles in a layer above the origin, turned every way but not in front of each other.
fn flock(side: u32) -> Primitive {
    let jitter = |cell, corner| {
        let sampler = Sampler::new(SequenceKind::Independent, glam::UVec2::new(cell, corner), 0, 1);
        Vec3::new(sampler.at_1d(0), sampler.at_1d(1), sampler.at_1d(2)) - 0.5
    };
    let step = 2.0 / side as f32;
    triangle_mesh((0..side * side).map(|cell| {
        let center = Vec3::new((cell % side) as f32, 0.0, (cell / side) as f32) + 0.5;
        [1, 2, 3].map(|corner| step * (center + 0.7 * jitter(cell, corner)) - Vec3::new(1.0, -1.0, 1.0))
    }))
}

fn cube() -> Primitive {
    Primitive::Mesh(Arc::new(Blas::build(Arc::new(unit_cube()), SplitMethod::Sah)))
}

fn transform(scale: Vec3, axis: Vec3, angle: f32, translation: Vec3) -> Affine3A {
    Affine3A::from_scale_rotation_translation(scale, Quat::from_axis_angle(axis.normalize(), angle), translation)
}

/// Density of the light's sampling in direction `wi` from the origin: that of the point it meets, where that point
/// shines.
fn pdf(scene: &RenderScene, wi: Vec3) -> f32 {
    let ray = Ray::new(Vec3::ZERO, wi);
    let Some(hit) = scene.geometry.intersect(&ray) else {
        return scene
            .lights
            .infinite()
            .iter()
            .map(|&id| scene.lights.radiance_and_pdf_from(id, &all_around(Vec3::ZERO), wi).1)
            .sum();
    };
    let point = scene.geometry.surface(&ray, &hit);
    let on_light = SurfaceHit::at(&hit, &point);
    match scene.lights.emitted(LightId(0), &on_light, -wi) {
        Rgb::ZERO => 0.0,
        _ => scene.lights.pdf_of_hit(LightId(0), &all_around(Vec3::ZERO), &on_light),
    }
}

fn scenes() -> Vec<(&'static str, RenderScene)> {
    let down = |size, y| {
        transform(
            Vec3::splat(size),
            Vec3::X,
            std::f32::consts::FRAC_PI_2,
            Vec3::new(0.2, y, -0.1),
        )
    };
    let skew = |scale| transform(scale, Vec3::new(1.0, 2.0, 0.5), 2.3, Vec3::new(0.4, 1.1, -0.7));
    let shear = Affine3A::from_mat3_translation(
        glam::Mat3::from_cols(Vec3::new(1.0, 0.0, 0.0), Vec3::new(0.6, 0.0, 0.9), Vec3::NEG_Y),
        Vec3::new(-0.2, 1.3, 0.3),
    );
    let aslant = transform(Vec3::new(0.9, 0.4, 1.0), Vec3::X, 1.9, Vec3::new(0.4, 1.1, -0.7));
    // Nearly edge-on, where the normals have light on both sides.
    let slope = [
        Vec3::new(-1.0, 0.5, 0.1),
        Vec3::new(0.4, 0.6, 1.2),
        Vec3::new(0.9, 0.9, -0.6),
    ];
    let mut sky = SceneBuilder::default();
    sky.light(LightSource::Constant { radiance: Rgb::ONE });
    vec![
        ("rectangle, near", emitter(Primitive::Rectangle, down(1.0, 0.3), false)),
        ("rectangle, far", emitter(Primitive::Rectangle, down(1.0, 5.0), false)),
        ("rectangle, aslant", emitter(Primitive::Rectangle, aslant, false)),
        (
            "rectangle, turned over",
            emitter(Primitive::Rectangle, skew(Vec3::new(0.9, 0.4, 1.0)), true),
        ),
        ("parallelogram", emitter(Primitive::Rectangle, shear, false)),
        ("disk", emitter(Primitive::Disk, down(0.8, 1.0), false)),
        (
            "disk, stretched",
            emitter(
                Primitive::Disk,
                down(0.8, 1.0) * Affine3A::from_scale(Vec3::new(1.0, 0.4, 1.0)),
                false,
            ),
        ),
        ("sphere", emitter(Primitive::Sphere, skew(Vec3::splat(0.5)), false)),
        (
            "sphere, close",
            emitter(Primitive::Sphere, skew(Vec3::splat(1.25)), false),
        ),
        (
            "sphere from inside",
            emitter(Primitive::Sphere, skew(Vec3::splat(2.0)), true),
        ),
        (
            "ellipsoid",
            emitter(Primitive::Sphere, skew(Vec3::new(0.9, 0.3, 0.5)), false),
        ),
        (
            "ellipsoid, mirrored",
            emitter(Primitive::Sphere, skew(Vec3::new(-0.9, 0.3, 0.5)), false),
        ),
        (
            "cylinder",
            emitter(Primitive::Cylinder, skew(Vec3::new(0.4, 0.4, 0.9)), false),
        ),
        (
            "cylinder from inside",
            emitter(
                Primitive::Cylinder,
                transform(Vec3::new(1.0, 1.0, 2.0), Vec3::X, 0.7, Vec3::new(0.1, 0.5, -0.8)),
                true,
            ),
        ),
        (
            "cylinder, elliptical and mirrored",
            emitter(Primitive::Cylinder, skew(Vec3::new(-0.7, 0.2, 0.9)), false),
        ),
        ("two triangles", emitter(square_mesh(), down(1.0, 0.8), false)),
        ("two triangles, sheared", emitter(square_mesh(), shear, false)),
        ("mesh", emitter(square_of_three_triangles(), down(1.0, 0.8), false)),
        (
            "mesh, mirrored",
            emitter(
                square_of_three_triangles(),
                down(1.0, 0.8) * Affine3A::from_scale(Vec3::new(1.0, -1.0, 1.0)),
                true,
            ),
        ),
        (
            "triangle, near",
            triangle([
                Vec3::new(-0.4, 0.3, 0.1),
                Vec3::new(0.1, 0.4, 1.2),
                Vec3::new(0.9, 0.2, -0.6),
            ]),
        ),
        (
            "triangle, far",
            triangle([
                Vec3::new(-0.4, 30.0, 0.1),
                Vec3::new(0.1, 29.0, 0.2),
                Vec3::new(0.2, 30.0, -0.6),
            ]),
        ),
        (
            "triangle, long",
            triangle([
                Vec3::new(-1.0, 0.5, 0.1),
                Vec3::new(0.1, 0.7, 0.8),
                Vec3::new(2.0, 0.5, 0.1),
            ]),
        ),
        (
            "triangle, aslant",
            triangle([
                Vec3::new(0.5, 0.1, 0.3),
                Vec3::new(4.5, 0.05, 0.1),
                Vec3::new(0.5, 0.1, -0.6),
            ]),
        ),
        (
            "cube, mirrored",
            emitter(cube(), skew(Vec3::new(-0.4, 0.2, 0.3)), false),
        ),
        (
            "cube from inside, mirrored",
            emitter(
                cube(),
                transform(Vec3::new(1.0, -1.3, 0.9), Vec3::X, 0.4, Vec3::new(0.1, 0.2, -0.3)),
                true,
            ),
        ),
        (
            "leaning normals, from the front",
            emitter(
                leaning_triangle([slope[0], slope[2], slope[1]]),
                Affine3A::IDENTITY,
                false,
            ),
        ),
        (
            "leaning normals, from behind",
            emitter(leaning_triangle(slope), Affine3A::IDENTITY, true),
        ),
        (
            "leaning normals, mirrored and small",
            emitter(
                leaning_triangle(slope),
                transform(Vec3::new(-0.1, 0.05, 0.1), Vec3::Z, 0.3, Vec3::new(0.1, 0.7, 0.5)),
                true,
            ),
        ),
        ("flock of triangles", emitter(flock(3), Affine3A::IDENTITY, false)),
        (
            "rectangle of two sides, from behind",
            both_ways(Primitive::Rectangle, down(1.0, 0.8), true),
        ),
        ("disk of two sides", both_ways(Primitive::Disk, down(0.8, 1.0), false)),
        (
            "two triangles of two sides, from behind",
            both_ways(square_mesh(), down(1.0, 0.8), true),
        ),
        (
            "leaning normals of two sides",
            both_ways(leaning_triangle(slope), Affine3A::IDENTITY, false),
        ),
        ("sky", sky.build()),
    ]
}

#[test]
fn sampled_directions_carry_the_density_of_found_ones() {
    for (name, scene) in scenes() {
        let (mut sampled, mut passing) = (0, 0);
        for index in 0..4000 {
            let sampler = Sampler::new(SequenceKind::Sobol, glam::UVec2::ZERO, index, 3);
            let Some((_, sample)) = scene
                .lights
                .sample(&all_around(Vec3::ZERO), sampler.at_1d(0), sampler.at_2d(1))
            else {
                continue;
            };
            sampled += 1;
            let found = pdf(&scene, sample.wi);
            let ray = Ray::new(Vec3::ZERO, sample.wi);
            let hit = scene.geometry.intersect(&ray);
            // At silhouettes the direction may pass the shape.
            if hit.is_none() && found == 0.0 {
                passing += 1;
                continue;
            }
            // Where a ray grazes by a cosine c, the place that it meets is uncertain by some 2e-7 / c, the normal there
            // by that over the radius of curvature, here 0.1, and the density by that over the cosine.
            let normal_of = |hit| scene.geometry.surface(&ray, &hit).geometric_normal;
            let cosine = hit.map_or(1.0, |hit| normal_of(hit).dot(sample.wi));
            let tolerance = 2e-3 + 2e-6 / (cosine * cosine);
            assert!(
                (found / sample.pdf - 1.0).abs() < tolerance,
                "{name}: {found} for {sample:?}"
            );
        }
        assert!(sampled > 500, "{name}: {sampled} samples");
        assert!(passing <= sampled / 100, "{name}: {passing} of {sampled} pass");
    }
}

/// The solid angle of a rectangle is one over the density of its samples, which is the same everywhere; triangles have
/// one each.
#[test]
fn two_triangles_that_are_a_rectangle_are_sampled_as_one() {
    let place = transform(Vec3::new(0.7, 0.3, 1.0), Vec3::X, 2.0, Vec3::new(0.4, 0.8, -0.3));
    let densities = |primitive: Primitive, to_world: Affine3A| -> Vec<f32> {
        let scene = emitter(primitive, to_world, false);
        let sample = |index| {
            let sampler = Sampler::new(SequenceKind::Sobol, glam::UVec2::ZERO, index, 3);
            let reference = all_around(Vec3::ZERO);
            let (_, sample) = scene.lights.sample(&reference, sampler.at_1d(0), sampler.at_2d(1))?;
            Some(sample.pdf)
        };
        (0..100).filter_map(sample).collect()
    };
    let is_even = |densities: &[f32], density: f32| {
        densities.len() == 100 && densities.iter().all(|found| (found / density - 1.0).abs() < 1e-4)
    };
    let expected = densities(Primitive::Rectangle, place)[0];
    assert!(is_even(&densities(Primitive::Rectangle, place), expected));
    assert!(is_even(&densities(square_mesh(), place), expected));
    assert!(!is_even(&densities(square_of_three_triangles(), place), expected));

    let sheared = place * Affine3A::from_mat3(glam::Mat3::from_cols(Vec3::X, Vec3::new(0.5, 1.0, 0.0), Vec3::Z));
    let of_parallelogram = densities(square_mesh(), sheared);
    assert!(!is_even(&of_parallelogram, of_parallelogram[0]), "a parallelogram");
    let [a, b, c, d] = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| Vec3::new(x, y, 0.0));
    let two_faced = densities(triangle_mesh([[a, b, c], [a, d, c]]), place);
    assert!((1..100).contains(&two_faced.len()), "half of it shines elsewhere");
}

#[test]
fn light_samples_follow_their_density() {
    let results: Vec<(String, f64)> = scenes()
        .iter()
        .map(|(name, scene)| {
            let axis = scene.geometry.bounds().center().try_normalize().unwrap_or(Vec3::Y);
            let sample = |index| {
                let sampler = Sampler::new(SequenceKind::Independent, glam::UVec2::ZERO, index, 5);
                let sample = scene
                    .lights
                    .sample(&all_around(Vec3::ZERO), sampler.at_1d(0), sampler.at_2d(1));
                sample.map(|(_, sample)| sample.wi)
            };
            (
                name.to_string(),
                statistics::sphere_p(60_000, axis, sample, |wi| pdf(scene, wi)),
            )
        })
        .collect();
    statistics::assert_all_plausible(&results);
}

#[test]
fn the_choice_between_lights_is_part_of_the_density() {
    let mut scene = SceneBuilder::default();
    scene.add(
        Primitive::Sphere,
        transform(Vec3::splat(0.2), Vec3::X, 0.0, Vec3::X * 2.0),
        black(),
        Some(Rgb::ONE),
    );
    scene.light(LightSource::Point {
        position: Vec3::Y,
        intensity: Rgb::splat(0.7),
    });
    scene.light(LightSource::Constant {
        radiance: Rgb::splat(0.1),
    });
    let scene = scene.build();
    let mut counts = [0usize; 3];
    let n = 20_000;
    let (mut point_pmf, mut total) = (0.0, 0.0f64);
    for index in 0..n {
        let sampler = Sampler::new(SequenceKind::Independent, glam::UVec2::ONE, index, 9);
        let Some((light, sample)) = scene
            .lights
            .sample(&all_around(Vec3::ZERO), sampler.at_1d(0), sampler.at_2d(1))
        else {
            continue;
        };
        let kind = match (sample.is_delta, sample.target) {
            (true, _) => 0,
            (false, Target::Point(_)) => 1,
            (false, Target::Infinity) => 2,
        };
        assert_eq!(light, LightId([1, 0, 2][kind]));
        counts[kind] += 1;
        if kind == 0 {
            point_pmf = sample.pdf;
        }
        total += f64::from(sunroom::color::luminance(sample.radiance) / sample.pdf);
    }
    assert!(counts.iter().all(|&count| count > 300), "{counts:?}");
    let share = counts[0] as f32 / n as f32;
    assert!(
        (share - point_pmf).abs() < 4.0 * (point_pmf / n as f32).sqrt(),
        "{share} against {point_pmf}"
    );
    // All that arrives: the cone of the sphere, the point light, the sky.
    let cone = 2.0 * std::f64::consts::PI * (1.0 - (1.0f64 - 0.01).sqrt());
    let expected = cone + 0.7 + 0.1 * 4.0 * std::f64::consts::PI;
    let mean = total / f64::from(n);
    assert!((mean / expected - 1.0).abs() < 0.02, "{mean} against {expected}");
}

#[test]
fn a_normal_takes_nothing_from_the_half_space_above_it() {
    let mut scene = SceneBuilder::default();
    scene.add(flock(10), Affine3A::IDENTITY, black(), Some(Rgb::ONE));
    for index in 0..40u32 {
        let angle = 0.37 * index as f32;
        scene.light(LightSource::Point {
            position: Vec3::new(2.0 * angle.sin(), 0.1 * (index as f32 - 20.0), 2.0 * angle.cos()),
            intensity: Rgb::splat(0.01 * (1 + index % 5) as f32),
        });
    }
    let scene = scene.build();
    for (case, normal) in [Vec3::Y, Vec3::NEG_Y, Vec3::new(0.6, 0.0, -0.8)]
        .into_iter()
        .enumerate()
    {
        let position = Vec3::new(0.1, 0.9, -0.2);
        // Irradiance by all lights together, without occlusion, and its standard error.
        let irradiance = |normal_known: bool| {
            let reference = LightReference {
                position,
                normal: normal_known.then_some(normal),
            };
            let n = 60_000;
            let (mut sum, mut squares) = (0.0, 0.0);
            for index in 0..n {
                let pixel = glam::UVec2::new(case as u32, u32::from(normal_known));
                let sampler = Sampler::new(SequenceKind::Independent, pixel, index, 7);
                let sample = scene.lights.sample(&reference, sampler.at_1d(0), sampler.at_2d(1));
                let value = sample.map_or(0.0, |(_, sample)| {
                    f64::from(sample.wi.dot(normal).max(0.0) * sample.radiance.x / sample.pdf)
                });
                sum += value;
                squares += value * value;
            }
            let (n, mean) = (f64::from(n), sum / f64::from(n));
            (mean, (squares / n - mean * mean) / n)
        };
        let ((with, with_error), (without, without_error)) = (irradiance(true), irradiance(false));
        assert!(with > 0.0);
        let tolerance = 4.0 * (with_error + without_error).sqrt();
        assert!(
            (with - without).abs() < tolerance,
            "{normal}: {with} and {without} +- {tolerance}"
        );
        assert!(with_error < without_error, "{normal}: knowing the normal makes noise");
    }
}

#[test]
fn the_sampling_weight_scales_the_probability_only() {
    let empty = SceneBuilder::default().build();
    let point = |x: f32| LightSource::Point {
        position: Vec3::new(x, 0.0, 0.0),
        intensity: Rgb::ONE,
    };
    let probability_of_first = |sampling_weight| {
        let first = WeightedSource {
            source: point(-1.0),
            sampling_weight,
        };
        let table = LightTable::build(&[first, point(1.0).into()], &empty.geometry, &Default::default());
        let samples = (0..100).filter_map(|index| {
            let u = (index as f32 + 0.5) / 100.0;
            table.sample(&all_around(Vec3::ZERO), u, Vec2::splat(0.5))
        });
        let first: Vec<_> = samples.filter(|(light, _)| *light == LightId(0)).collect();
        assert!(
            first
                .iter()
                .all(|(_, sample)| sample.wi == Vec3::NEG_X && sample.radiance == Rgb::ONE)
        );
        assert!(
            first
                .iter()
                .all(|(_, sample)| (sample.pdf - first.len() as f32 / 100.0).abs() < 0.011)
        );
        first.len()
    };
    assert_eq!([0.0, 1.0, 3.0].map(probability_of_first), [0, 50, 75]);
}

/// Lights that nothing else can find: the whole of a point's intensity over the squared distance, the whole of a
/// direction's irradiance.
#[test]
fn lights_without_extent_send_what_they_say() {
    for (i, color) in [
        Rgb::ONE,
        Rgb::X,
        Rgb::new(0.2, 3.0, 40.0),
        Rgb::splat(1e-6),
        Rgb::splat(1e6),
    ]
    .into_iter()
    .enumerate()
    {
        let i = i as f32;
        let position = Vec3::new(3.0 - i, 0.3 * i * i, -2.0);
        let direction = Vec3::new(0.3 - i, 1.0, 0.2 * i).normalize();
        let at = Vec3::new(0.5, -0.1, 0.4 * i);
        let to_point = position - at;
        for (source, wi, radiance) in [
            (
                LightSource::Point {
                    position,
                    intensity: color,
                },
                to_point.normalize(),
                color / to_point.length_squared(),
            ),
            (
                LightSource::Directional {
                    direction,
                    irradiance: color,
                },
                -direction,
                color,
            ),
        ] {
            let mut scene = SceneBuilder::default();
            let is_point = matches!(source, LightSource::Point { .. });
            scene.light(source.clone());
            let scene = scene.build();
            for u in [0.0, 0.3, 0.999] {
                let sample = scene.lights.sample(&all_around(at), u, Vec2::new(u, 0.5));
                let (_, sample) = sample.unwrap_or_else(|| panic!("{source:?} is seen from everywhere"));
                assert!(
                    sample.is_delta && (sample.wi - wi).length() < 1e-6,
                    "{source:?}: {sample:?}"
                );
                assert_eq!(matches!(sample.target, Target::Point(_)), is_point);
                let error = (sample.radiance / sample.pdf - radiance).abs().max_element();
                assert!(error <= 1e-5 * radiance.max_element(), "{source:?}: {sample:?}");
            }
            // No ray that leaves the scene meets them.
            let escaping: Rgb = scene
                .lights
                .infinite()
                .iter()
                .map(|&id| scene.lights.radiance_from(id, wi))
                .sum();
            assert_eq!(escaping, Rgb::ZERO);
            let (_, pdf) = scene.lights.radiance_and_pdf_from(LightId(0), &all_around(at), wi);
            assert_eq!(pdf, 0.0);
        }
    }
}

#[test]
fn a_table_without_light_gives_none() {
    let mut scene = SceneBuilder::default();
    scene.add(Primitive::Sphere, Affine3A::IDENTITY, black(), Some(Rgb::ZERO));
    let scene = scene.build();
    assert_eq!(
        scene.lights.sample(&all_around(Vec3::Y * 3.0), 0.5, Vec2::splat(0.5)),
        None
    );
}
