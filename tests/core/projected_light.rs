//! Spots and projectors: closed forms, orientation, and that they are chosen wherever they shine.

use std::f32::consts::{FRAC_PI_2, PI};

use crate::support::{SceneBuilder, all_around};
use glam::{Affine2, Affine3A, UVec2, Vec2, Vec3};
use sunroom::color::{Rgb, luminance};
use sunroom::light::{LightSource, Projector, Spot};
use sunroom::render::scene::RenderScene;
use sunroom::sampling::{Sampler, SequenceKind};
use sunroom::texture::{Checkerboard, Parameter, Texture, TextureId, TextureTable};

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
    sample.map_or(Rgb::ZERO, |(_, sample)| {
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
fn a_stretched_spot_lights_all_of_its_cone() {
    let mut stretched = spot(Parameter::Constant(Rgb::ONE));
    stretched.world_from_local *= Affine3A::from_scale(Vec3::new(5.0, 5.0, 1.0));
    let scene = with(LightSource::Spot(stretched));
    // In the spot's own space the angle is a fifth as steep: well within the beam, far beyond it in the world.
    let tan = 5.0 * 0.25f32.tan();
    let at = Vec3::new(2.0 * tan, 2.0, 0.0);
    let expected = Rgb::new(3.0, 2.0, 1.0) / at.distance_squared(Vec3::Y * 4.0);
    assert!(
        (arriving(&scene, at) - expected).abs().max_element() < 1e-4,
        "{}",
        arriving(&scene, at)
    );
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
                let sampler = Sampler::new(SequenceKind::Independent, UVec2::ONE, index, 8);
                let place = 5.0 * (sampler.at_2d(0) - 0.5);
                let at = Vec3::new(place.x, 8.0 * (sampler.at_1d(1) - 0.5), place.y);
                let expected = luminance(arriving(&first, at) + arriving(&second, at));
                // The choice is by intervals of the number; 1/256 is a strip at the border of each.
                let draws = (0..256).filter_map(|u| {
                    let u = (u as f32 + 0.5) / 256.0;
                    scene.lights.sample(&all_around(at), u, Vec2::splat(0.5))
                });
                let mean: f32 = draws
                    .map(|(_, sample)| luminance(sample.radiance) / sample.pdf)
                    .sum::<f32>()
                    / 256.0;
                assert!(
                    (mean - expected).abs() < 0.1 * expected + 1e-6,
                    "{source:?}, {at}: {mean}, {expected}"
                );
            }
        }
    }
}
