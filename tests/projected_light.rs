//! Spots, projectors and surfaces whose radiance is a texture: closed forms, densities, and one picture whatever samples it.

mod statistics;
mod support;

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{Affine2, Affine3A, UVec2, Vec2, Vec3};
use sunroom::accel::{Blas, Primitive, SplitMethod};
use sunroom::color::{Rgb, luminance};
use sunroom::geometry::mesh::MeshData;
use sunroom::light::{LightId, LightSource, Projector, Spot, SurfaceHit};
use sunroom::math::Ray;
use sunroom::render::scene::RenderScene;
use sunroom::render::view::Strategy;
use sunroom::sampling::{Sampler, SequenceKind};
use sunroom::shading::{Bsdf, Diffuse};
use sunroom::texture::{Checkerboard, Parameter, Texture, TextureId, TextureTable};
use support::{SceneBuilder, all_around, assert_close, camera, mean_luminance, render, view};

const STRATEGIES: [Strategy; 3] = [Strategy::Bsdf, Strategy::Light, Strategy::Mis];

fn diffuse(reflectance: f32) -> Bsdf {
    Bsdf::Diffuse(Diffuse {
        reflectance: Rgb::splat(reflectance),
    })
}

/// Two by two squares over the unit square of uv, dark red where both halves are the same.
fn squares() -> TextureTable {
    TextureTable::new(vec![Texture::Checkerboard(Checkerboard {
        colors: [
            Parameter::Constant(Rgb::new(0.2, 0.0, 0.0)),
            Parameter::Constant(Rgb::new(1.0, 2.0, 4.0)),
        ],
        to_uv: Affine2::IDENTITY,
    })])
}

fn spot(texture: Parameter<Rgb>) -> Spot {
    Spot {
        // At (0, 4, 0), down: its x is the world's x, its y the world's z.
        world_from_local: Affine3A::from_translation(Vec3::Y * 4.0) * Affine3A::from_rotation_x(FRAC_PI_2),
        intensity: Rgb::new(3.0, 2.0, 1.0),
        cutoff_angle: 0.5,
        beam_angle: 0.3,
        texture,
    }
}

fn projector(irradiance: Parameter<Rgb>) -> Projector {
    Projector {
        world_from_local: Affine3A::from_translation(Vec3::Y * 4.0) * Affine3A::from_rotation_x(FRAC_PI_2),
        irradiance,
        scale: 2.0,
        half_size: Vec2::new(0.5, 0.25),
    }
}

fn with(source: LightSource) -> RenderScene {
    let mut scene = SceneBuilder::with_textures(squares());
    scene.light(source);
    scene.build()
}

/// What arrives at a point from the only light.
fn arriving(scene: &RenderScene, at: Vec3) -> Rgb {
    let sample = scene.lights.sample(&all_around(at), 0.5, Vec2::splat(0.5));
    sample.map_or(Rgb::ZERO, |sample| {
        assert!(sample.is_delta && (sample.wi.length() - 1.0).abs() < 1e-6);
        sample.radiance / sample.pdf
    })
}

#[test]
fn a_spot_fades_between_beam_and_cutoff() {
    let scene = with(LightSource::Spot(spot(Parameter::Constant(Rgb::ONE))));
    let at = |angle: f32| arriving(&scene, Vec3::new(2.0 * angle.sin(), 4.0 - 2.0 * angle.cos(), 0.0));
    let full = Rgb::new(3.0, 2.0, 1.0) / 4.0;
    for (angle, share) in [
        (0.0, 1.0),
        (0.29, 1.0),
        (0.4, 0.5),
        (0.45, 0.25),
        (0.51, 0.0),
        (3.0, 0.0),
    ] {
        assert!(
            (at(angle) - share * full).abs().max_element() < 1e-3,
            "{angle}: {}",
            at(angle)
        );
        assert!((at(-angle) - share * full).abs().max_element() < 1e-3, "{angle}");
    }
    assert_eq!(arriving(&scene, Vec3::Y * 4.0), Rgb::ZERO, "at the spot itself");
}

#[test]
fn a_spot_shows_its_texture_around_the_cone() {
    let scene = with(LightSource::Spot(spot(Parameter::Texture(TextureId(0)))));
    let [dark, bright] =
        [Rgb::new(0.2, 0.0, 0.0), Rgb::new(1.0, 2.0, 4.0)].map(|color| color * Rgb::new(3.0, 2.0, 1.0));
    for (x, z, color) in [
        (0.4, 0.4, dark),
        (-0.4, -0.4, dark),
        (0.4, -0.4, bright),
        (-0.4, 0.4, bright),
    ] {
        let at = Vec3::new(x, 0.0, z);
        let expected = color / at.distance_squared(Vec3::Y * 4.0);
        assert!((arriving(&scene, at) - expected).abs().max_element() < 1e-4, "{at}");
    }
}

#[test]
fn a_projector_lights_planes_evenly_within_its_picture() {
    let scene = with(LightSource::Projector(projector(Parameter::Constant(Rgb::splat(3.0)))));
    // At a distance of 4 the picture is 4 by 2.
    for (x, z) in [(0.0, 0.0), (1.9, 0.0), (-1.9, 0.9), (0.0, -0.99)] {
        let at = Vec3::new(x, 0.0, z);
        let cos = 4.0 / at.distance(Vec3::Y * 4.0);
        let irradiance = arriving(&scene, at) * cos;
        assert!(
            (irradiance - 6.0 * PI / 16.0).abs().max_element() < 1e-3,
            "{at}: {irradiance}"
        );
    }
    for at in [Vec3::X * 2.1, Vec3::Z * 1.1, Vec3::Y * 8.0, Vec3::Y * 4.0] {
        assert_eq!(arriving(&scene, at), Rgb::ZERO, "{at}");
    }
}

#[test]
fn a_projector_has_the_left_of_its_picture_at_plus_x() {
    let scene = with(LightSource::Projector(projector(Parameter::Texture(TextureId(0)))));
    // uv is (0, 0) at +x, +y of its own space, which are the world's x and z; both are mirrored, so the squares stay.
    assert!(arriving(&scene, Vec3::new(1.0, 0.0, 0.5)).z == 0.0);
    assert!(arriving(&scene, Vec3::new(1.0, 0.0, -0.5)).z > 0.0);

    // Stripes of which one and a third go across.
    let mut scene = SceneBuilder::with_textures(TextureTable::new(vec![Texture::Checkerboard(Checkerboard {
        colors: [Parameter::Constant(Rgb::ZERO), Parameter::Constant(Rgb::ONE)],
        to_uv: Affine2::from_scale(Vec2::new(0.75, 0.0)),
    })]));
    scene.light(LightSource::Projector(projector(Parameter::Texture(TextureId(0)))));
    let scene = scene.build();
    // u < 2/3 is the first colour.
    assert_eq!(arriving(&scene, Vec3::new(1.9, 0.0, 0.0)), Rgb::ZERO, "u = 0.025");
    assert_eq!(arriving(&scene, Vec3::new(-0.6, 0.0, 0.0)), Rgb::ZERO, "u = 0.65");
    assert!(arriving(&scene, Vec3::new(-0.8, 0.0, 0.0)).x > 0.0, "u = 0.7");
}

/// Wherever a lamp shines it is among those chosen: on average the samples bring what all lamps send.
#[test]
fn lamps_are_chosen_wherever_they_shine() {
    for texture in [Parameter::Constant(Rgb::splat(0.7)), Parameter::Texture(TextureId(0))] {
        for source in [
            LightSource::Spot(spot(texture)),
            LightSource::Projector(projector(texture)),
        ] {
            let mut scene = SceneBuilder::with_textures(squares());
            scene.light(source.clone());
            let other = LightSource::Point {
                position: Vec3::new(3.0, 1.0, 0.5),
                intensity: Rgb::ONE,
            };
            scene.light(other.clone());
            let scene = scene.build();
            let (first, second) = (with(source.clone()), with(other));
            for index in 0..300 {
                let mut sampler = Sampler::new(SequenceKind::Independent, UVec2::ONE, index, 8);
                let place = 5.0 * (sampler.next_2d() - 0.5);
                let at = Vec3::new(place.x, 8.0 * (sampler.next_1d() - 0.5), place.y);
                let expected = luminance(arriving(&first, at) + arriving(&second, at));
                // The choice is by intervals of the number; 1/256 is a strip at the border of each.
                let draws = (0..256).filter_map(|u| {
                    let u = (u as f32 + 0.5) / 256.0;
                    scene.lights.sample(&all_around(at), u, Vec2::splat(0.5))
                });
                let mean: f32 = draws.map(|sample| luminance(sample.radiance) / sample.pdf).sum::<f32>() / 256.0;
                assert!(
                    (mean - expected).abs() < 0.1 * expected + 1e-6,
                    "{source:?}, {at}: {mean}, {expected}"
                );
            }
        }
    }
}

/// The square [-1, 1]^2 as two triangles with texture coordinates.
fn textured_mesh() -> Primitive {
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let mesh = MeshData {
        positions: corners.map(|(x, y)| Vec3::new(x, y, 0.0)).to_vec(),
        uvs: corners.map(|(x, y)| Vec2::new(0.5 * x + 0.5, 0.5 * y + 0.5)).to_vec(),
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..MeshData::default()
    };
    Primitive::Mesh(std::sync::Arc::new(Blas::build(
        std::sync::Arc::new(mesh),
        SplitMethod::Sah,
    )))
}

/// A floor under a textured surface that shines down.
fn textured_area(primitive: Primitive, to_world: Affine3A) -> RenderScene {
    let mut scene = SceneBuilder::with_textures(squares());
    let down = Affine3A::from_translation(Vec3::new(0.2, 1.0, 0.1)) * Affine3A::from_rotation_x(FRAC_PI_2);
    scene.add_textured(
        primitive,
        down * to_world,
        diffuse(0.0),
        Parameter::Texture(TextureId(0)),
    );
    let floor = Affine3A::from_rotation_x(-FRAC_PI_2) * Affine3A::from_scale(Vec3::splat(20.0));
    scene.add(
        Primitive::Rectangle,
        Affine3A::from_translation(Vec3::Y * -0.5) * floor,
        diffuse(0.5),
        None,
    );
    scene.build()
}

fn shapes() -> Vec<(&'static str, RenderScene)> {
    let shear = Affine3A::from_mat3(glam::Mat3::from_cols(Vec3::X, Vec3::new(0.5, 0.8, 0.0), Vec3::Z));
    vec![
        ("rectangle", textured_area(Primitive::Rectangle, Affine3A::IDENTITY)),
        ("parallelogram", textured_area(Primitive::Rectangle, shear)),
        ("disk", textured_area(Primitive::Disk, Affine3A::IDENTITY)),
        (
            "cylinder",
            textured_area(
                Primitive::Cylinder,
                Affine3A::from_translation(Vec3::X * 0.6) * Affine3A::from_scale(Vec3::new(0.3, 0.3, 0.8)),
            ),
        ),
        (
            "sphere",
            textured_area(Primitive::Sphere, Affine3A::from_scale(Vec3::splat(0.5))),
        ),
        (
            "ellipsoid",
            textured_area(Primitive::Sphere, Affine3A::from_scale(Vec3::new(0.7, 0.3, 0.5))),
        ),
        ("mesh", textured_area(textured_mesh(), Affine3A::IDENTITY)),
    ]
}

/// Radiance and density of the light in a direction from the origin.
fn found(scene: &RenderScene, wi: Vec3) -> Option<(Rgb, f32)> {
    let ray = Ray::new(Vec3::ZERO, wi);
    let hit = scene.geometry.intersect(&ray).filter(|hit| hit.instance == 0)?;
    let point = scene.geometry.surface(&ray, &hit);
    let on_light = SurfaceHit {
        position: point.position,
        normal: point.geometric_normal,
        primitive: hit.primitive,
        barycentric: Vec2::new(hit.u, hit.v),
        uv: point.uv,
    };
    let radiance = scene.lights.emitted(LightId(0), &on_light, -wi);
    let pdf = scene.lights.pdf_of_hit(LightId(0), &all_around(Vec3::ZERO), &on_light);
    (radiance != Rgb::ZERO).then_some((radiance, pdf))
}

#[test]
fn sampled_points_of_textured_surfaces_are_those_found() {
    let mut results = Vec::new();
    for (name, scene) in shapes() {
        let draw = |index| {
            let mut sampler = Sampler::new(SequenceKind::Independent, UVec2::new(9, 1), index, 3);
            scene
                .lights
                .sample(&all_around(Vec3::ZERO), sampler.next_1d(), sampler.next_2d())
        };
        let (mut sampled, mut differing, mut bright) = (0, 0, 0);
        for index in 0..4000 {
            let Some(sample) = draw(index) else { continue };
            sampled += 1;
            bright += u32::from(sample.radiance.z > 1.0);
            let same = found(&scene, sample.wi)
                .is_some_and(|(radiance, pdf)| radiance == sample.radiance && (pdf / sample.pdf - 1.0).abs() < 3e-3);
            differing += u32::from(!same);
        }
        // At silhouettes and between the squares of the board the two may fall on different sides.
        assert!(
            sampled > 500 && differing <= sampled / 50,
            "{name}: {differing} of {sampled} differ"
        );
        if matches!(name, "rectangle" | "parallelogram") {
            assert!(
                bright > sampled * 8 / 10,
                "{name}: {bright} of {sampled} on the bright squares"
            );
        }
        if !matches!(name, "rectangle" | "parallelogram") {
            continue;
        }
        // Counted over the surface's parameters, whose squares are whole numbers of bins.
        const BINS: usize = 16;
        let instance = &scene.geometry.instances()[0];
        let edges = [Vec3::X, Vec3::Y].map(|axis| instance.world_from_local.transform_vector3(2.0 * axis));
        let area_normal = edges[0].cross(edges[1]);
        let density = |a: f64, b: f64| {
            let local = Vec3::new(2.0 * a as f32 - 1.0, 2.0 * b as f32 - 1.0, 0.0);
            let at = instance.world_from_local.transform_point3(local);
            let pdf = found(&scene, at.normalize()).map_or(0.0, |(_, pdf)| pdf);
            f64::from(pdf * area_normal.dot(at).abs() / at.length().powi(3))
        };
        let size = 1.0 / BINS as f64;
        let count = 50_000;
        let bin_mass = |bin| {
            let corner = [(bin % BINS) as f64 * size, (bin / BINS) as f64 * size];
            statistics::integrate(&density, corner, [size, size]) * f64::from(count)
        };
        let expected: Vec<f64> = (0..BINS * BINS).map(bin_mass).collect();
        let mut counted = vec![0.0; BINS * BINS];
        for sample in (0..count).filter_map(|index| draw(index + 10_000)) {
            let ray = Ray::new(Vec3::ZERO, sample.wi);
            let hit = scene.geometry.intersect(&ray).expect("a sampled point");
            let bin = |x: f32| (((0.5 * x + 0.5) * BINS as f32) as usize).min(BINS - 1);
            counted[bin(hit.v) * BINS + bin(hit.u)] += 1.0;
        }
        let total: f64 = expected.iter().sum();
        assert!(
            (total / f64::from(count) - 1.0).abs() < 2e-3,
            "{name}: the density integrates to {total}"
        );
        results.push((name.to_owned(), statistics::chi_squared_p(&counted, &expected)));
    }
    statistics::assert_all_plausible(&results);
}

#[test]
fn textured_surfaces_light_the_same_however_they_are_found() {
    for (name, scene) in shapes() {
        let by = |strategy| {
            let look = view(camera(Vec3::new(2.5, 0.4, 0.0), Vec3::Y * -0.5, 20.0), 4, 2, strategy);
            mean_luminance(&render(&scene, &look, 8192))
        };
        let reference = by(Strategy::Mis);
        assert!(reference.0 > 0.005, "{name}: {reference:?}");
        for strategy in STRATEGIES {
            let (mean, error) = by(strategy);
            assert_close(
                &format!("{name}, {strategy:?}"),
                (mean, error.hypot(reference.1)),
                reference.0,
            );
        }
    }
}
