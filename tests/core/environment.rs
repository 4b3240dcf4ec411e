//! Pictures of the sky and the analytic sky as lights: orientation, sampling against density, and what they send in
//! all.

use crate::statistics;
use std::f32::consts::{FRAC_PI_2, PI, TAU};
use std::path::Path;
use std::sync::Arc;

use crate::support::{SceneBuilder, all_around, assert_close, camera, mean_luminance, render, view};
use glam::{Affine3A, Mat3, Quat, UVec2, Vec3};
use sunroom::accel::Primitive;
use sunroom::color::{Rgb, luminance};
use sunroom::light::{Atmosphere, EnvironmentMap, LightId, LightSource};
use sunroom::render::scene::RenderScene;
use sunroom::render::view::Strategy;
use sunroom::sampling::{Sampler, SequenceKind, hash::pcg3d, unit_float};
use sunroom::shading::{Bsdf, Diffuse};
use sunroom::texture::{Image, Samples, Transfer, load_image};

fn image(width: u32, height: u32, pixel: impl Fn(u32, u32) -> Rgb) -> Arc<Image> {
    let pixels = (0..width * height).flat_map(|at| pixel(at % width, at / width).to_array());
    let samples = Samples::F32(pixels.collect());
    Arc::new(Image::new(width, height, 3, samples, Transfer::Linear).expect("a whole picture"))
}

fn map(width: u32, height: u32, pixel: impl Fn(u32, u32) -> Rgb) -> LightSource {
    environment(image(width, height, pixel), false, Mat3::IDENTITY)
}

fn environment(image: Arc<Image>, compensated: bool, world_from_local: Mat3) -> LightSource {
    LightSource::Environment {
        map: Arc::new(EnvironmentMap::new(image, compensated)),
        world_from_local,
        scale: 1.5,
    }
}

fn alone(source: LightSource) -> RenderScene {
    let mut scene = SceneBuilder::default();
    scene.light(source);
    scene.build()
}

fn random(x: u32, y: u32) -> Rgb {
    Vec3::from(pcg3d([x, y, 5]).map(unit_float))
}

/// A white pixel in the dark.
fn only(x: u32, y: u32) -> impl Fn(u32, u32) -> Rgb {
    move |column, row| {
        if (column, row) == (x, y) {
            Rgb::splat(100.0)
        } else {
            Rgb::ZERO
        }
    }
}

fn turned() -> Mat3 {
    Mat3::from_quat(Quat::from_axis_angle(Vec3::new(1.0, 2.0, -0.5).normalize(), 2.1))
}

fn atmosphere(elevation: f32) -> Atmosphere {
    let (up, along) = elevation.to_radians().sin_cos();
    Atmosphere {
        turbidity: 3.0,
        albedo: Rgb::splat(0.3),
        sun_direction: Vec3::new(along, 0.0, up),
        sky_scale: 1.0,
        sun_scale: 1.0,
        sun_aperture: 0.5358f32.to_radians(),
        limb_darkening: false,
    }
}

fn sun_sky(atmosphere: Atmosphere) -> LightSource {
    LightSource::SunSky {
        atmosphere,
        world_from_local: Mat3::IDENTITY,
    }
}

/// What to test, and the direction around which it is counted finely.
fn cases() -> Vec<(&'static str, RenderScene, Vec3)> {
    let wide_sun = Atmosphere {
        sun_aperture: 0.6,
        ..atmosphere(35.0)
    };
    let mirrored = turned() * Mat3::from_diagonal(Vec3::new(-1.0, 1.0, 1.0));
    vec![
        ("constant", alone(map(6, 4, |_, _| Rgb::ONE)), Vec3::Y),
        ("noise", alone(map(16, 9, random)), Vec3::Y),
        ("one pixel", alone(map(16, 9, only(3, 4))), Vec3::new(0.94, 0.0, 0.0)),
        ("one pixel beside the seam", alone(map(16, 9, only(15, 3))), Vec3::NEG_Z),
        ("one pole", alone(map(8, 6, only(2, 0))), Vec3::Y),
        ("other pole", alone(map(8, 6, only(2, 5))), Vec3::NEG_Y),
        ("one row", alone(map(9, 1, random)), Vec3::Y),
        ("two rows", alone(map(9, 2, random)), Vec3::Y),
        ("one column", alone(map(1, 7, random)), Vec3::Y),
        ("one pixel in all", alone(map(1, 1, random)), Vec3::Y),
        (
            "turned",
            alone(environment(image(12, 7, random), false, turned())),
            Vec3::Y,
        ),
        (
            "mirrored",
            alone(environment(image(12, 7, random), false, mirrored)),
            Vec3::Y,
        ),
        (
            "compensated",
            alone(environment(image(12, 7, random), true, turned())),
            Vec3::Y,
        ),
        (
            "noon",
            alone(sun_sky(Atmosphere {
                sun_scale: 0.0,
                ..atmosphere(85.0)
            })),
            Vec3::Z,
        ),
        (
            "evening",
            alone(sun_sky(Atmosphere {
                sun_scale: 0.0,
                ..atmosphere(5.0)
            })),
            Vec3::X,
        ),
        // Counted around another axis: where the rim runs along the cells the test's integral is poor.
        ("large sun", alone(sun_sky(wide_sun)), Vec3::new(0.9, 0.3, 0.5)),
        (
            "sun alone",
            alone(sun_sky(Atmosphere {
                sky_scale: 0.0,
                ..wide_sun
            })),
            Vec3::new(0.9, 0.3, 0.5),
        ),
        (
            "sun half set",
            alone(sun_sky(Atmosphere {
                sun_aperture: 0.6,
                ..atmosphere(2.0)
            })),
            Vec3::X,
        ),
    ]
}

fn pdf(scene: &RenderScene, wi: Vec3) -> f32 {
    let (_, pdf) = scene
        .lights
        .radiance_and_pdf_from(LightId(0), &all_around(Vec3::ZERO), wi);
    pdf
}

fn radiance(scene: &RenderScene, wi: Vec3) -> Rgb {
    scene.lights.radiance_from(LightId(0), wi)
}

fn sample(scene: &RenderScene, index: u32) -> Option<sunroom::light::LightSample> {
    let sampler = Sampler::new(SequenceKind::Independent, UVec2::new(2, 7), index, 8);
    let reference = all_around(Vec3::ZERO);
    let chosen = scene.lights.sample(&reference, sampler.at_1d(0), sampler.at_2d(1));
    chosen.map(|(_, sample)| sample)
}

#[test]
fn directions_follow_their_density() {
    let results: Vec<(String, f64)> = cases()
        .iter()
        .map(|(name, scene, axis)| {
            let draw = |index| sample(scene, index).map(|sample| sample.wi);
            let p = statistics::sphere_p(60_000, axis.normalize(), draw, |wi| pdf(scene, wi).min(1e6));
            (name.to_string(), p)
        })
        .collect();
    statistics::assert_all_plausible(&results);
}

#[test]
fn sampled_directions_carry_the_density_and_radiance_of_found_ones() {
    for (name, scene, _) in cases() {
        let mut differing = 0;
        for index in 0..2000 {
            let Some(sample) = sample(&scene, index) else {
                continue;
            };
            assert!(
                sample.pdf > 0.0 && (sample.wi.length() - 1.0).abs() < 1e-5,
                "{name}: {sample:?}"
            );
            let close = |found: f32, sampled: f32| (found - sampled).abs() <= 2e-3 * sampled.abs();
            let is_close = close(pdf(&scene, sample.wi), sample.pdf)
                && close(luminance(radiance(&scene, sample.wi)), luminance(sample.radiance));
            // Beside black pixels, at the rim of the sun and at the horizon both are mostly rounding.
            differing += u32::from(!is_close);
        }
        assert!(differing <= 20, "{name}: {differing} of 2000 differ");
    }
}

/// Sampling must reach all that shines, whatever the density's shape: the mean of radiance / pdf is the integral over
/// the sphere.
#[test]
fn samples_add_up_to_the_whole() {
    for (name, scene, axis) in cases() {
        let whole = statistics::sphere_integral(axis.normalize(), |wi| luminance(radiance(&scene, wi)).max(0.0));
        let count = 40_000;
        let (mut sum, mut squares) = (0.0, 0.0);
        for index in 0..count {
            let value = sample(&scene, index).map_or(0.0, |sample| f64::from(luminance(sample.radiance) / sample.pdf));
            sum += value;
            squares += value * value;
        }
        let mean = sum / f64::from(count);
        let error = ((squares / f64::from(count) - mean * mean) / f64::from(count)).sqrt();
        // The integral's own error: 400 cells of 2e-7 at most, and the steps at the sun's rim.
        assert!(
            (mean - whole).abs() < 4.0 * error + 2e-3 * whole,
            "{name}: {mean} +- {error}, {whole}"
        );
        // The density is nearly in proportion. Worst is a bright pole, where it is linear in the latitude and the light
        // goes with its square: sqrt(1/2). Compensation leaves the rest to others.
        if name != "compensated" {
            assert!(
                error * f64::from(count).sqrt() < 0.72 * whole,
                "{name}: noise {error} of {whole}"
            );
        }
    }
}

#[test]
fn up_is_the_top_row_and_the_middle_is_plus_z() {
    let scene = alone(map(8, 5, |x, y| Rgb::new(x as f32, y as f32, 1.0)));
    let at = |x, y, z| radiance(&scene, Vec3::new(x, y, z).normalize()) / 1.5;
    assert_eq!(at(0.0, 1.0, 0.0).y, 0.0);
    assert_eq!(at(0.0, -1.0, 0.0).y, 4.0);
    // Directions at longitudes of pixel centres: the first column is half a pixel past -z, turning towards +x.
    let horizon = |column: f32| {
        let longitude = (column + 0.5) / 8.0 * 2.0 * PI;
        at(longitude.sin(), 0.0, -longitude.cos())
    };
    for column in 0..8 {
        assert!(
            (horizon(column as f32) - Rgb::new(column as f32, 2.0, 1.0)).length() < 1e-4,
            "{column}"
        );
    }
    assert!((at(0.0, 0.0, 1.0) - Rgb::new(3.5, 2.0, 1.0)).length() < 1e-4);
    assert!(
        (at(0.0, 0.0, -1.0) - Rgb::new(3.5, 2.0, 1.0)).length() < 1e-4,
        "the seam, between 7 and 0"
    );
    assert!((at(1.0, 0.0, 0.0) - Rgb::new(1.5, 2.0, 1.0)).length() < 1e-4);
    // Rows: the first is the pole itself, an eighth of the way down lies half way between the first two.
    let steep = PI / 8.0;
    assert!((at(steep.sin(), steep.cos(), 0.0).y - 0.5).abs() < 1e-4);

    let turned = alone(environment(
        image(8, 5, |_, y| Rgb::splat(y as f32)),
        false,
        Mat3::from_rotation_x(FRAC_PI_2),
    ));
    assert!(radiance(&turned, Vec3::Z).x < 1e-4, "up was turned to +z");
}

#[test]
fn a_black_map_and_a_black_sky_send_nothing() {
    let night = Atmosphere {
        sun_direction: Vec3::NEG_Z,
        ..atmosphere(10.0)
    };
    let sources = [
        map(8, 4, |_, _| Rgb::ZERO),
        map(8, 4, |_, _| Rgb::splat(f32::NAN)),
        map(8, 4, |_, _| Rgb::splat(-1.0)),
        sun_sky(night),
    ];
    for source in sources {
        let scene = alone(source.clone());
        assert!((0..50).all(|index| sample(&scene, index).is_none()), "{source:?}");
        assert_eq!(radiance(&scene, Vec3::new(0.6, 0.0, 0.8)), Rgb::ZERO);
    }
}

#[test]
fn compensation_samples_bright_parts_more() {
    let picture = || {
        image(32, 16, |x, y| {
            if (20..24).contains(&x) && y == 5 {
                Rgb::splat(50.0)
            } else {
                Rgb::ONE
            }
        })
    };
    let bright = |compensated| {
        let scene = alone(environment(picture(), compensated, Mat3::IDENTITY));
        let found = (0..4000).filter_map(|index| sample(&scene, index));
        found.filter(|sample| sample.radiance.x > 20.0).count()
    };
    let (plain, compensated) = (bright(false), bright(true));
    assert!(compensated as f32 > 1.3 * plain as f32, "{compensated} against {plain}");
}

/// Values of Mitsuba 3.9.1's `sunsky` in its scalar_rgb variant.
#[test]
fn the_sky_is_that_of_hosek_and_wilkie() {
    let sky = |elevation, turbidity, albedo: [f32; 3]| Atmosphere {
        sun_scale: 0.0,
        turbidity,
        albedo: albedo.into(),
        ..atmosphere(elevation)
    };
    let usual = sky(45.0, 3.0, [0.3; 3]);
    let hazy = sky(12.0, 4.5, [0.2, 0.5, 0.8]);
    let arctic = sky(1.0, 1.0, [0.0; 3]);
    let humid = sky(70.0, 9.7, [1.0; 3]);
    let (side, low) = (Vec3::new(-0.6, 0.64, 0.48), Vec3::new(0.8, -0.6, 0.0));
    let cases = [
        (usual, Vec3::Z, [0.023_749, 0.041_516, 0.084_094]),
        (usual, Vec3::X, [0.220_311, 0.246_452, 0.223_725]),
        (usual, Vec3::new(0.6, 0.0, 0.8), [0.125_561, 0.148_221, 0.187_617]),
        (usual, Vec3::new(0.0, 0.6, 0.8), [0.027_501, 0.049_812, 0.098_740]),
        (usual, usual.sun_direction, [0.183_193, 0.207_476, 0.232_584]),
        (usual, Vec3::NEG_Z, [0.0; 3]),
        (hazy, Vec3::Z, [0.011_701, 0.022_105, 0.038_514]),
        (hazy, side, [0.032_626, 0.053_462, 0.075_102]),
        (hazy, low, [0.237_684, 0.184_730, 0.099_606]),
        (arctic, Vec3::Z, [0.004_791, 0.006_322, 0.006_778]),
        (arctic, side, [0.016_614, 0.017_641, 0.014_912]),
        (arctic, low, [0.062_055, 0.032_609, 0.005_401]),
        (humid, Vec3::Z, [0.482_411, 0.478_248, 0.463_458]),
        (humid, side, [0.161_455, 0.182_919, 0.221_825]),
        (humid, low, [0.434_033, 0.375_462, 0.315_217]),
    ];
    for (atmosphere, direction, expected) in cases {
        let found = radiance(&alone(sun_sky(atmosphere)), direction);
        // Six digits of the tables and of the values, through powers and exponentials.
        let error = (found - Rgb::from(expected)).abs().max_element();
        assert!(
            error <= 1e-4 * found.max_element(),
            "{atmosphere:?}, {direction}: {found}"
        );
    }
    let sun = alone(sun_sky(Atmosphere {
        sky_scale: 0.0,
        ..atmosphere(45.0)
    }));
    let found = radiance(&sun, atmosphere(45.0).sun_direction);
    let expected = Rgb::new(21_369.16, 17_551.52, 12_928.0);
    // It takes the disk's solid angle from a cosine in f32, which has lost all but three digits of it.
    assert!((found / expected - 1.0).abs().max_element() < 3e-3, "{found}");
}

/// The model's fit has colours outside of Rec. 709: such light would be taken away from the picture.
#[test]
fn the_sky_is_nowhere_negative() {
    for turbidity in [1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0] {
        for elevation in [0.0, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 45.0, 70.0, 90.0] {
            for albedo in [Rgb::ZERO, Rgb::ONE, Rgb::new(1.0, 0.0, 0.0)] {
                let scene = alone(sun_sky(Atmosphere {
                    turbidity,
                    albedo,
                    ..atmosphere(elevation)
                }));
                for index in 0..400 {
                    let (turn, up) = (index as f32 * 2.399_963, (index as f32 / 400.0).powi(2));
                    let (sin, cos) = turn.sin_cos();
                    let flat = (1.0 - up * up).sqrt();
                    let found = radiance(&scene, Vec3::new(flat * cos, flat * sin, up));
                    assert!(
                        found.is_finite() && found.min_element() >= 0.0,
                        "{turbidity} {elevation}: {found}"
                    );
                }
            }
        }
    }
}

#[test]
fn the_sun_sends_the_same_whatever_its_disk_looks_like() {
    let power = |aperture: f32, limb_darkening| {
        let scene = alone(sun_sky(Atmosphere {
            sky_scale: 0.0,
            sun_aperture: aperture,
            limb_darkening,
            ..atmosphere(50.0)
        }));
        let count = 20_000;
        let total: Rgb = (0..count)
            .filter_map(|index| sample(&scene, index))
            .map(|s| s.radiance / s.pdf)
            .sum();
        total / count as f32
    };
    let expected = power(0.5358f32.to_radians(), false);
    for (aperture, limb_darkening) in [(0.05, false), (0.3, false), (0.009, true), (0.1, true)] {
        let found = power(aperture, limb_darkening);
        // Limb darkening has a relative spread of 0.2 over the disk.
        let error = (found / expected - 1.0).abs().max_element();
        assert!(error < 0.006, "{aperture} {limb_darkening}: {found}, {expected}");
    }
}

#[test]
fn skies_light_the_same_however_they_are_found() {
    let bright = |x, y| {
        if (x, y) == (5, 2) {
            Rgb::splat(30.0)
        } else {
            random(x, y)
        }
    };
    let wide_sun = Atmosphere {
        sun_aperture: 0.5,
        ..atmosphere(35.0)
    };
    let cases = [
        ("map", environment(image(16, 9, bright), false, turned())),
        ("compensated map", environment(image(16, 9, bright), true, turned())),
        (
            "sun and sky",
            LightSource::SunSky {
                atmosphere: wide_sun,
                // z up becomes y up.
                world_from_local: Mat3::from_rotation_x(-FRAC_PI_2),
            },
        ),
    ];
    for (name, source) in cases {
        let mut scene = SceneBuilder::default();
        let grey = Bsdf::Diffuse(Diffuse {
            reflectance: Rgb::splat(0.5),
        });
        let floor = Affine3A::from_rotation_x(-FRAC_PI_2) * Affine3A::from_scale(Vec3::splat(5.0));
        scene.add(Primitive::Rectangle, floor, grey, None);
        scene.add(Primitive::Sphere, Affine3A::from_translation(Vec3::Y * 1.5), grey, None);
        scene.light(source);
        let scene = scene.build();
        let by = |strategy| {
            let look = view(camera(Vec3::new(6.0, 3.0, 0.0), Vec3::Y, 40.0), 8, 3, strategy);
            mean_luminance(&render(&scene, &look, 2048))
        };
        let reference = by(Strategy::Mis);
        for strategy in [Strategy::Bsdf, Strategy::Light] {
            let (mean, error) = by(strategy);
            assert_close(
                &format!("{name}, {strategy:?}"),
                (mean, error.hypot(reference.1)),
                reference.0,
            );
        }
    }
}

#[test]
fn the_environments_of_the_program_are_sound_and_equally_bright() {
    for name in ["evening", "living-room", "noon", "overcast", "studio"] {
        let path = Path::new(crate::ROOT).join(format!("assets/environments/{name}.hdr"));
        let bytes = std::fs::read(&path).expect(name);
        assert!(bytes.len() < 1_000_000, "{name} has {} bytes", bytes.len());
        let image = load_image(&bytes).expect(name);
        let (width, height) = (image.width(), image.height());
        assert_eq!((width, height), (768, 384), "{name}");
        let mut lit = 0.0;
        for y in 0..height {
            let theta = PI * y as f32 / (height - 1) as f32;
            let share = theta.cos().max(0.0) * theta.sin() * (TAU / width as f32) * (PI / height as f32) / PI;
            for x in 0..width {
                let pixel = image.pixel(x, y);
                assert!(
                    pixel.is_finite() && pixel.min_element() >= 0.0,
                    "{name} at {x}, {y}: {pixel}"
                );
                assert!(luminance(pixel) > 0.0, "{name} is black at {x}, {y}");
                lit += luminance(pixel) * share;
            }
        }
        // White paper that lies flat reflects a radiance of 1.
        assert!((lit - 1.0).abs() < 0.02, "{name}: {lit}");
    }
}
