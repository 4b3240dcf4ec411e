//! Lights that are given in lumens, lux or nits: what they send, sampled as the renderer samples it, integrates to
//! that.

use std::f32::consts::{FRAC_PI_2, PI};
use std::fs;
use std::sync::Arc;

use crate::ROOT;
use crate::support::{SceneBuilder, leaning_triangle, square_of_three_triangles};
use glam::{Affine3A, Mat3, Quat, UVec2, Vec2, Vec3};
use sunroom::accel::{Instance, Primitive};
use sunroom::color::{Rgb, luminance};
use sunroom::light::{
    Atmosphere, EnvironmentMap, LightReference, LightSource, Luminaire, PictureLight, Projector, Spot,
};
use sunroom::photometry::{LUMENS_PER_WATT, LightUnit, Measure};
use sunroom::render::scene::RenderScene;
use sunroom::sampling::{Sampler, SequenceKind};
use sunroom::shading::{Bsdf, Diffuse};
use sunroom::texture::{Image, Parameter, Samples, Transfer, load_image};

const COUNT: u32 = 1 << 18;

/// What is typed, in lumens or lux.
const TYPED: f32 = 800.0;

/// A warm colour, whose luminance is not one of its channels.
const COLOR: Rgb = Rgb::new(1.0, 0.6, 0.2);

/// The strength that has what is typed in a unit of which a light of luminance 1 gives this much.
fn strength(unit: LightUnit, per_strength: f64) -> Rgb {
    let measure = Measure::new(unit, per_strength).expect("it shines");
    COLOR * (TYPED / (measure.per_strength * luminance(COLOR)))
}

fn assert_typed(what: &str, found: f64) {
    let found = found * f64::from(LUMENS_PER_WATT);
    let error = (found / f64::from(TYPED) - 1.0).abs();
    assert!(error < 1e-3, "{what}: {found}, typed {TYPED}");
}

fn black() -> Bsdf {
    Bsdf::Diffuse(Diffuse { reflectance: Rgb::ZERO })
}

/// The power in W that rays take from the lights.
fn power(scene: &RenderScene) -> f64 {
    power_of_rays(scene, COUNT)
}

fn power_of_rays(scene: &RenderScene, count: u32) -> f64 {
    let rays = (0..count).filter_map(|index| {
        let sampler = Sampler::new(SequenceKind::Sobol, UVec2::new(5, 9), index, 3);
        let (choice, place, dir) = (sampler.at_1d(0), sampler.at_2d(1), sampler.at_2d(2));
        scene.lights.sample_emission(&scene.reach, choice, place, dir)
    });
    rays.map(|ray| f64::from(luminance(ray.power))).sum::<f64>() / f64::from(count)
}

/// The irradiance in W/m² on a surface with this normal.
fn irradiance(scene: &RenderScene, normal: Vec3) -> f64 {
    let reference = LightReference {
        position: Vec3::ZERO,
        normal: Some(normal),
    };
    let samples = (0..COUNT).filter_map(|index| {
        let sampler = Sampler::new(SequenceKind::Sobol, UVec2::new(2, 3), index, 3);
        let (_, sample) = scene.lights.sample(&reference, sampler.at_1d(0), sampler.at_2d(1))?;
        Some(f64::from(
            luminance(sample.radiance) * sample.wi.dot(normal).max(0.0) / sample.pdf,
        ))
    });
    samples.sum::<f64>() / f64::from(COUNT)
}

/// A light without a surface, inside of a shape that is around it.
fn alone(source: LightSource) -> RenderScene {
    let mut scene = SceneBuilder::default();
    scene.add(
        Primitive::Sphere,
        Affine3A::from_scale(Vec3::splat(40.0)),
        black(),
        None,
    );
    scene.light(source);
    scene.build()
}

/// Transforms that turn, stretch, mirror and shear.
fn transforms() -> Vec<(&'static str, Affine3A)> {
    let turn = Quat::from_axis_angle(Vec3::new(1.0, 2.0, -0.5).normalize(), 0.8);
    let turned = Affine3A::from_rotation_translation(turn, Vec3::new(0.3, -0.2, 0.5));
    let shear = Mat3::from_cols(Vec3::X, Vec3::new(0.6, 1.0, 0.0), Vec3::new(0.3, -0.4, 1.0));
    vec![
        ("turned", turned),
        ("scaled", turned * Affine3A::from_scale(Vec3::splat(2.5))),
        ("stretched", turned * Affine3A::from_scale(Vec3::new(2.0, 0.7, 1.1))),
        ("mirrored", turned * Affine3A::from_scale(Vec3::new(-1.3, 0.7, 0.7))),
        ("sheared", turned * Affine3A::from_mat3(shear)),
    ]
}

#[test]
fn surfaces_shine_with_the_lumens_that_were_typed() {
    let leaning = leaning_triangle([
        Vec3::new(-1.0, 0.0, 0.0),
        Vec3::new(1.0, 0.2, 0.3),
        Vec3::new(0.1, 1.0, -0.2),
    ]);
    let shapes = [
        ("rectangle", Primitive::Rectangle),
        ("disk", Primitive::Disk),
        ("sphere", Primitive::Sphere),
        ("cylinder", Primitive::Cylinder),
        ("mesh", square_of_three_triangles()),
        ("mesh with leaning normals", leaning),
    ];
    for (shape, primitive) in shapes {
        for (transform, to_world) in transforms() {
            let area = Instance::new(primitive.clone(), to_world)
                .expect("it has an area")
                .area();
            for sides in [1, 2] {
                let lumens = std::f64::consts::PI * f64::from(sides) * area;
                let mut scene = SceneBuilder::default();
                let radiance = strength(LightUnit::Lumen, lumens);
                scene.add(primitive.clone(), to_world, black(), Some(radiance));
                if sides == 2 {
                    scene.both_ways();
                }
                // On one side, half of the rays along leaning normals are lost, which is noise.
                let count = if shape.contains("leaning") { 16 * COUNT } else { COUNT };
                let found = power_of_rays(&scene.build(), count);
                assert_typed(&format!("{transform} {shape}, {sides} sides"), found);
            }
        }
    }
}

#[test]
fn spots_shine_with_the_lumens_that_were_typed() {
    for (cutoff_angle, beam_angle) in [(0.6, 0.4), (0.6, 0.6), (1.2, 0.0), (FRAC_PI_2, 0.3), (2.6, 1.9)] {
        for (transform, to_world) in transforms() {
            let white = Spot {
                world_from_local: to_world,
                intensity: Rgb::ONE,
                cutoff_angle,
                beam_angle,
                texture: Parameter::Constant(Rgb::ONE),
            };
            let spot = Spot {
                intensity: strength(LightUnit::Lumen, white.solid_angle()),
                ..white
            };
            let what = format!("{transform} spot of {cutoff_angle} and {beam_angle}");
            assert_typed(&what, power(&alone(LightSource::Spot(spot))));
        }
    }
}

#[test]
fn points_shine_with_the_lumens_that_were_typed() {
    let point = LightSource::Point {
        position: Vec3::new(0.5, 3.0, -1.0),
        intensity: strength(LightUnit::Lumen, 4.0 * std::f64::consts::PI),
    };
    assert_typed("point", power(&alone(point)));
}

#[test]
fn projectors_shine_with_the_lumens_that_were_typed() {
    for half_size in [Vec2::new(0.4, 0.7), Vec2::new(1.7, 1.1)] {
        for (transform, to_world) in transforms() {
            let white = Projector {
                world_from_local: to_world,
                irradiance: Parameter::Constant(Rgb::ONE),
                scale: 1.0,
                half_size,
            };
            let projector = Projector {
                irradiance: Parameter::Constant(strength(LightUnit::Lumen, white.power_of_one())),
                ..white
            };
            let scene = alone(LightSource::Projector(projector));
            assert_typed(&format!("{transform} projector of {half_size}"), power(&scene));
        }
    }
}

/// A picture of all directions, brighter above and to one side.
fn sky(width: u32, height: u32) -> Arc<Image> {
    let pixel = |index: u32| {
        let (x, y) = (index % width, index / width);
        COLOR * (0.2 + ((x * 7 + y * 3) % 11) as f32 + 40.0 / (1.0 + y as f32))
    };
    let pixels = (0..width * height).flat_map(|index| pixel(index).to_array());
    let samples = Samples::F32(pixels.collect());
    Arc::new(Image::new(width, height, 3, samples, Transfer::Linear).expect("a whole picture"))
}

#[test]
fn measured_lamps_shine_with_the_lumens_that_were_typed() {
    for name in [
        "round.ies",
        "half.ies",
        "type_b.ies",
        "without_symmetry.ldt",
        "upward.ies",
    ] {
        let path = format!("{ROOT}/tests/corpus/photometry/{name}");
        let bytes = fs::read(&path).expect("it is there");
        let image = Arc::new(load_image(&bytes).expect("a lamp"));
        let mean = PictureLight::new(&image).mean;
        let own = 4.0 * std::f64::consts::PI * f64::from(mean);
        let lamp = Luminaire {
            position: Vec3::new(0.0, 3.0, 1.0),
            world_from_local: Mat3::from_rotation_x(1.9) * Mat3::from_rotation_z(0.4),
            map: Arc::new(EnvironmentMap::new(image, false)),
            scale: strength(LightUnit::Lumen, own),
        };
        assert_typed(name, power(&alone(LightSource::Luminaire(lamp))));
    }
}

#[test]
fn lights_from_far_bring_the_lux_that_were_typed() {
    let direction = Vec3::new(0.3, -1.0, 0.4).normalize();
    let sun = LightSource::Directional {
        direction,
        irradiance: strength(LightUnit::Lux, 1.0),
    };
    assert_typed("directional", irradiance(&alone(sun), -direction));
    let constant = LightSource::Constant {
        radiance: strength(LightUnit::Lux, std::f64::consts::PI),
    };
    assert_typed("constant", irradiance(&alone(constant), Vec3::Y));
    for (width, height) in [(16, 8), (64, 33), (5, 2)] {
        let image = sky(width, height);
        let light = PictureLight::new(&image);
        let measure = Measure::new(LightUnit::Lux, f64::from(light.irradiance)).expect("it shines");
        let environment = LightSource::Environment {
            map: Arc::new(EnvironmentMap::new(image, false)),
            world_from_local: Mat3::from_rotation_y(0.7),
            scale: TYPED / measure.per_strength,
        };
        let what = format!("picture of {width} x {height}");
        assert_typed(&what, irradiance(&alone(environment), Vec3::Y));
    }
}

#[test]
fn suns_and_skies_bring_the_lux_that_were_typed() {
    for (sun_direction, turbidity) in [(Vec3::new(0.5, 0.3, 0.8), 3.0), (Vec3::new(0.9, 0.1, 0.2), 6.0)] {
        let plain = Atmosphere {
            turbidity,
            albedo: Rgb::splat(0.3),
            sun_direction: sun_direction.normalize(),
            sky_scale: 1.0,
            sun_scale: 1.0,
            sun_aperture: 0.01,
            limb_darkening: false,
        };
        let world_from_local = Mat3::from_rotation_x(-PI / 2.0);
        let lux = |value: f32| TYPED / (value * LUMENS_PER_WATT);
        let sky = Atmosphere {
            sun_scale: 0.0,
            sky_scale: lux(plain.sky_irradiance()),
            ..plain
        };
        let light = |atmosphere| LightSource::SunSky {
            atmosphere,
            world_from_local,
        };
        assert_typed("sky", irradiance(&alone(light(sky)), Vec3::Y));
        let sun = Atmosphere {
            sun_scale: lux(luminance(plain.sun_irradiance())),
            sky_scale: 0.0,
            ..plain
        };
        let facing = world_from_local * plain.sun_direction;
        assert_typed("sun", irradiance(&alone(light(sun)), facing));
    }
}

#[test]
fn the_average_of_a_picture_is_that_of_its_light() {
    let image = sky(24, 13);
    let light = PictureLight::new(&image);
    let mean = EnvironmentMap::new(image, false).mean_luminance();
    assert!((light.mean / mean - 1.0).abs() < 1e-4, "{} {mean}", light.mean);
}
