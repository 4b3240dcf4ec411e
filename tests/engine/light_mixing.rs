//! Light mixing: a finished picture with its lights changed is the picture of the scene with its lights changed.

use std::f32::consts::FRAC_PI_2;
use std::num::NonZeroUsize;
use std::sync::atomic::AtomicBool;

use bevy::asset::AssetPlugin;
use bevy::math::{Affine3A, Quat, Vec3};
use bevy::prelude::*;
use sunroom::accel::Primitive;
use sunroom::color::Rgb;
use sunroom::engine::{EnginePlugin, Limits, Outcome, RenderControl, RenderFilm, render_to_completion};
use sunroom::light::LightSource;
use sunroom::render::film::Film;
use sunroom::render::filter::{FilterKernel, PixelFilter};
use sunroom::render::light_layers::LightGroups;
use sunroom::render::scene::RenderScene;
use sunroom::render::tile::{render_preview, tiles};
use sunroom::render::view::{Strategy, View};
use sunroom::scene::{AreaLight, DocumentOrder, Emitter, EmitterKind, ScenePlugin, Shape, ShapeKind, ToWorld};
use sunroom::shading::{Bsdf, Dielectric, DielectricModel, Diffuse};

use crate::look_along;
use crate::support::{SceneBuilder, camera, render, view};

/// A box with one red and one green wall, open to a uniform sky, with a square lamp, a round one and a ball of glass.
/// `strengths` multiply the light of the square lamp, the round lamp and the sky.
fn room(strengths: [Rgb; 3]) -> RenderScene {
    let diffuse = |r, g, b| {
        Bsdf::Diffuse(Diffuse {
            reflectance: Rgb::new(r, g, b),
        })
    };
    let mut scene = SceneBuilder::default();
    let (red, green, white) = (diffuse(0.6, 0.1, 0.1), diffuse(0.1, 0.6, 0.1), diffuse(0.7, 0.7, 0.7));
    for (axis, angle, paint) in [
        (Vec3::X, -FRAC_PI_2, white),
        (Vec3::X, FRAC_PI_2, white),
        (Vec3::Y, FRAC_PI_2, red),
        (Vec3::Y, -FRAC_PI_2, green),
        (Vec3::X, 0.0, white),
    ] {
        let rotation = Affine3A::from_quat(Quat::from_axis_angle(axis, angle));
        let away = Affine3A::from_translation(-rotation.transform_vector3(Vec3::Z));
        scene.add(Primitive::Rectangle, away * rotation, paint, None);
    }
    let glass = Dielectric {
        eta: 1.5,
        model: DielectricModel::Exact,
        specular_reflectance: Rgb::ONE,
        specular_transmittance: Rgb::ONE,
    };
    let placed =
        |scale, rotation, place| Affine3A::from_scale_rotation_translation(Vec3::splat(scale), rotation, place);
    let ball = placed(0.3, Quat::IDENTITY, Vec3::new(0.4, -0.7, 0.2));
    scene.add(Primitive::Sphere, ball, Bsdf::Dielectric(glass), None);
    let square = placed(0.3, Quat::from_rotation_x(FRAC_PI_2), Vec3::new(-0.4, 0.98, 0.0));
    scene.add(
        Primitive::Rectangle,
        square,
        white,
        Some(Rgb::new(6.0, 5.0, 4.0) * strengths[0]),
    );
    let round = placed(0.15, Quat::IDENTITY, Vec3::new(0.5, 0.3, -0.4));
    scene.add(
        Primitive::Sphere,
        round,
        white,
        Some(Rgb::new(3.0, 5.0, 8.0) * strengths[1]),
    );
    scene.light(LightSource::Constant {
        radiance: Rgb::splat(0.4) * strengths[2],
    });
    scene.build()
}

fn look(size: u32) -> View {
    let mut look = view(
        camera(Vec3::new(0.0, 0.0, 3.5), Vec3::ZERO, 45.0),
        size,
        6,
        Strategy::Mis,
    );
    look.light_groups = LightGroups::new(&[0, 1, 2]);
    look
}

/// The layers of a sample hold the contributions that its radiance is the sum of. Of one pixel that is some thousand
/// numbers, added in two orders, half a rounding of 2^-24 each: a few hundred thousandths if all roundings went one
/// way.
const REORDERED: f32 = 1e-4;

fn assert_same_sums(film: &Film) {
    let (mixed, plain) = (film.mixed(&[Rgb::ONE; 3]), film.radiance());
    assert!(plain.iter().any(|&pixel| pixel != Rgb::ZERO));
    for (mixed, plain) in mixed.iter().zip(&plain) {
        let error = (*mixed - *plain).abs().max_element();
        assert!(error <= REORDERED * plain.max_element().abs(), "{mixed} {plain}");
    }
}

#[test]
fn unchanged_lights_give_the_picture_itself() {
    let scene = room([Rgb::ONE; 3]);
    let mut look = look(24);
    // A filter whose weights differ from sample to sample.
    look.filter = PixelFilter::tabulated(FilterKernel::Gaussian { stddev: 0.5 });
    for strategy in [Strategy::Mis, Strategy::Bsdf, Strategy::Light] {
        let settings = look.integrator.settings_mut();
        settings.strategy = strategy;
        let film = render(&scene, &look, 64);
        assert_same_sums(&film);
        assert_eq!(film.mixed(&[]), film.radiance());
        assert_eq!(film.mixed(&[Rgb::ONE]), film.mixed(&[Rgb::ONE; 3]));
    }
    let mut film = Film::with_layers(24, 24, look.film_layers());
    for tile in tiles(24, 24) {
        let preview = render_preview(&scene, &look, tile, 4, &AtomicBool::new(false)).expect("not cancelled");
        film.add_preview(preview);
    }
    assert_same_sums(&film);
}

#[test]
fn layers_do_not_change_the_picture() {
    let scene = room([Rgb::ONE; 3]);
    let layered = render(&scene, &look(16), 8);
    let plain = render(&scene, &view(look(16).camera, 16, 6, Strategy::Mis), 8);
    assert!(layered.radiance() == plain.radiance(), "not the same bits");
    assert_eq!((layered.layers().groups, plain.layers().groups), (3, 0));
    // A film without layers has nothing to mix.
    assert_eq!(plain.mixed(&[Rgb::ZERO]), plain.radiance());
}

/// How far apart two pictures of the same expectation are on average over a part of them, in standard errors: the
/// spread of the differences of the pixels, which are independent, tells the noise.
fn distance(a: &[Rgb], b: &[Rgb], pixels: impl Iterator<Item = usize>) -> f32 {
    let differences: Vec<Rgb> = pixels.map(|i| a[i] - b[i]).collect();
    let n = differences.len() as f32;
    let mean = differences.iter().sum::<Rgb>() / n;
    let variance = differences.iter().map(|&d| (d - mean) * (d - mean)).sum::<Rgb>() / (n - 1.0);
    (mean.abs() / (variance / n).max(Rgb::splat(1e-12)).map(f32::sqrt)).max_element()
}

#[test]
fn a_mixed_picture_is_that_of_the_changed_scene() {
    const SIZE: u32 = 32;
    let film = render(&room([Rgb::ONE; 3]), &look(SIZE), 256);
    for strengths in [
        [Rgb::splat(2.0), Rgb::new(0.2, 1.0, 3.0), Rgb::ZERO],
        [Rgb::ZERO, Rgb::ZERO, Rgb::new(1.0, 0.5, 0.25)],
        [Rgb::new(0.0, 1.0, 0.0), Rgb::ONE, Rgb::splat(4.0)],
    ] {
        let changed = View { seed: 2, ..look(SIZE) };
        let rendered = render(&room(strengths), &changed, 256).radiance();
        let mixed = film.mixed(&strengths);
        let quarter = |q: u32| {
            let (left, top) = (q % 2 * SIZE / 2, q / 2 * SIZE / 2);
            (0..SIZE / 2).flat_map(move |y| (0..SIZE / 2).map(move |x| ((top + y) * SIZE + left + x) as usize))
        };
        for q in 0..4 {
            // Thirty-six comparisons of normal deviates: 5 is passed once in fifty thousand runs.
            let apart = distance(&mixed, &rendered, quarter(q));
            assert!(apart < 5.0, "{strengths:?}, quarter {q}: {apart} standard errors");
        }
        let unmixed = distance(&film.radiance(), &rendered, 0..rendered.len());
        assert!(unmixed > 5.0, "without mixing it would pass as well: {unmixed}");
    }
}

#[test]
fn every_light_of_the_scene_has_its_layer_when_asked_for() {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AssetPlugin::default(), ScenePlugin, EnginePlugin));
    let world = app.world_mut();
    let sky = world
        .spawn((
            DocumentOrder(0),
            Emitter::from(EmitterKind::Constant { radiance: Rgb::ONE }),
        ))
        .id();
    let lamp = |order: u32, x: f32| {
        (
            DocumentOrder(order),
            Shape {
                kind: ShapeKind::Cube,
                ..Shape::default()
            },
            ToWorld(Affine3A::from_translation(Vec3::new(x, 0.0, 5.0)) * Affine3A::from_scale(Vec3::splat(0.5))),
            AreaLight::default(),
        )
    };
    let lamps = [world.spawn(lamp(1, -1.0)).id(), world.spawn(lamp(2, 1.0)).id()];
    look_along(world, 20, 10);
    world.resource_mut::<RenderControl>().threads = NonZeroUsize::MIN;
    let mut picture = |light_layers: bool| {
        app.world_mut().resource_mut::<RenderControl>().light_layers = light_layers;
        let outcome = render_to_completion(&mut app, &Limits::default(), |_| {});
        assert_eq!(outcome, Ok(Outcome::Complete));
        let film = app.world().resource::<RenderFilm>();
        let entities: Vec<_> = film.light_groups.iter().map(|group| group.entities.clone()).collect();
        (film.film.clone(), entities)
    };
    let (plain, groups) = picture(false);
    assert_eq!((plain.layers().groups, groups.len()), (0, 0));
    let (layered, groups) = picture(true);
    assert_eq!(groups, [[lamps[0]], [lamps[1]], [sky]]);
    assert_eq!(layered.radiance(), plain.radiance());
    assert_same_sums(&layered);
    // The left lamp is seen on the left (the camera's left is +x), and nowhere else.
    let only = |k: usize| {
        layered.mixed(&std::array::from_fn::<Rgb, 3, _>(|i| {
            Rgb::splat(f32::from(u8::from(i == k)))
        }))
    };
    let half = |picture: &[Rgb], right: bool| -> f32 {
        let pixels = picture.iter().enumerate().filter(|(i, _)| (i % 20 >= 10) == right);
        pixels.map(|(_, rgb)| rgb.y).sum()
    };
    assert!(half(&only(0), true) > 10.0 && half(&only(1), false) > 10.0);
    let (plain, groups) = picture(false);
    assert_eq!((plain.layers().groups, groups.len()), (0, 0));
}
