//! Vertex connection and merging: photons beside bidirectional path tracing.

use std::f32::consts::PI;
use std::sync::atomic::AtomicBool;

use crate::bidirectional::{assert_pictures, by, diffuse, glass, lit_room, look, placed};
use crate::support::{SceneBuilder, camera, render};
use glam::{Affine3A, Quat, Vec3};
use sunroom::accel::Primitive;
use sunroom::color::Rgb;
use sunroom::layer::{Layer, Layers};
use sunroom::light::{LightSource, Spot};
use sunroom::render::guide::Guide;
use sunroom::render::photon_rounds::PhotonRounds;
use sunroom::render::scene::RenderScene;
use sunroom::render::shutter::{Moment, Shutter};
use sunroom::render::tile::{TileSamples, render_tile, tiles};
use sunroom::render::view::{Integrator, PathSettings, PhotonSettings, View};
use sunroom::texture::Parameter;

/// Photons of a small radius, which blur less than the noise of these tests.
fn merging(settings: PathSettings) -> Integrator {
    let photons = PhotonSettings {
        paths: Some(300),
        radius: 0.05,
    };
    Integrator::Merging(settings, photons)
}

/// A floor below a slab of glass, as the bottom of a pool is below water, and a small lamp above both.
fn pool() -> RenderScene {
    let mut scene = SceneBuilder::default();
    let floor = placed(
        Vec3::splat(0.9),
        Quat::from_rotation_x(-PI / 2.0),
        Vec3::new(0.0, -1.0, 0.0),
    );
    scene.add(Primitive::Rectangle, floor, diffuse(0.7), None);
    let surface = placed(Vec3::splat(2.0), Quat::from_rotation_x(-PI / 2.0), Vec3::ZERO);
    scene.add(Primitive::Rectangle, surface, glass(), None);
    let ball = Affine3A::from_scale_rotation_translation(Vec3::splat(0.25), Quat::IDENTITY, Vec3::new(0.2, -0.6, 0.0));
    scene.add(Primitive::Sphere, ball, diffuse(0.4), None);
    let lamp = Affine3A::from_scale_rotation_translation(Vec3::splat(0.2), Quat::IDENTITY, Vec3::new(-0.4, 1.6, 0.3));
    scene.add(Primitive::Sphere, lamp, diffuse(0.0), Some(Rgb::splat(20.0)));
    scene.build()
}

fn over_the_pool(depth: u32) -> View {
    View {
        camera: camera(Vec3::new(0.8, 2.0, 1.5), Vec3::new(0.0, -0.9, 0.0), 30.0),
        ..look(depth)
    }
}

#[test]
fn a_floor_below_water_is_as_bright_as_by_luck() {
    let scene = pool();
    // With 4 segments light goes in and comes out, with more it is scattered below as well.
    for depth in [4, 7] {
        let view = over_the_pool(depth);
        let (path, merged) = (render(&scene, &view, 12000), render(&scene, &by(merging, &view), 800));
        assert_pictures(&format!("depth {depth}"), &path, &merged);
    }
}

#[test]
fn a_room_is_as_bright_as_without_photons() {
    let scene = lit_room();
    for depth in [3, 5] {
        let view = look(depth);
        let (path, merged) = (render(&scene, &view, 2500), render(&scene, &by(merging, &view), 1200));
        assert_pictures(&format!("depth {depth}"), &path, &merged);
    }
    // Without the ways to the lens, as layers need it.
    let view = View {
        layers: Layers::of(&[Layer::Direct]),
        ..look(5)
    };
    let (path, merged) = (render(&scene, &view, 2500), render(&scene, &by(merging, &view), 1200));
    assert_pictures("with layers", &path, &merged);
}

/// What no other way finds: light of a spot through water.
#[test]
fn the_light_of_a_spot_comes_through_water() {
    let mut scene = SceneBuilder::default();
    let floor = placed(
        Vec3::splat(3.0),
        Quat::from_rotation_x(-PI / 2.0),
        Vec3::new(0.0, -1.0, 0.0),
    );
    scene.add(Primitive::Rectangle, floor, diffuse(0.7), None);
    let at = Vec3::new(0.0, 2.0, 0.0);
    scene.light(LightSource::Spot(Spot {
        world_from_local: Affine3A::from_translation(at) * Affine3A::from_rotation_x(PI / 2.0),
        intensity: Rgb::splat(5.0),
        cutoff_angle: 0.15,
        beam_angle: 0.12,
        texture: Parameter::Constant(Rgb::ONE),
    }));
    let surface = placed(Vec3::splat(3.0), Quat::from_rotation_x(-PI / 2.0), Vec3::ZERO);
    scene.add(Primitive::Rectangle, surface, glass(), None);
    let scene = scene.build();
    let straight_down = View {
        camera: camera(at, Vec3::ZERO, 4.0),
        ..look(4)
    };
    let integrator = |settings| {
        Integrator::Merging(
            settings,
            PhotonSettings {
                paths: Some(500),
                radius: 1.0,
            },
        )
    };
    let film = render(&scene, &by(integrator, &straight_down), 600);
    // Straight down a share of 0.96 passes at the surface each way. A narrow beam of angle a has one of a / 1.5 below,
    // so that at the floor it is as wide as in air at a distance of 2 + 1 / 1.5. Radiance below is larger by 1.5
    // squared and smaller by the same when it comes out.
    let irradiance = 5.0 * 0.96 / (2.0 + 1.0 / 1.5_f32).powi(2);
    let expected = irradiance * 0.7 / PI * 0.96 / (1.5 * 1.5);
    let (mean, error) = crate::support::mean_luminance(&film);
    assert!(error < 0.02 * mean, "{mean} {error}");
    crate::support::assert_close("through water", (mean, error + 2e-3 * mean), expected);
}

fn traced(scene: &RenderScene, view: &View, tile: usize, first: u32) -> TileSamples {
    let tile = tiles(view.width, view.height)[tile];
    render_tile(scene, view, tile, first..first + 4, &AtomicBool::new(false)).expect("not cancelled")
}

/// With a store for each moment, long pictures would keep some rounds of each.
#[test]
fn the_moments_of_a_blurred_picture_share_their_photons() {
    let (scene, view) = (pool(), by(merging, &over_the_pool(4)));
    let moments: Vec<Moment> = (0..3)
        .map(|_| {
            (
                scene.clone(),
                View {
                    photons: PhotonRounds::default(),
                    ..view.clone()
                },
            )
        })
        .collect();
    let shutter = Shutter::new(&moments, (&scene, &Guide::default())).expect("three moments");
    let tile = tiles(view.width, view.height)[0];
    let never = AtomicBool::new(false);
    shutter.render_tile(tile, 0..48, &never).expect("not cancelled");
    let kept: Vec<usize> = moments.iter().map(|(_, view)| view.photons.kept()).collect();
    assert_eq!(kept, [32, 0, 0], "the first one is that of all");
}

#[test]
fn photons_are_the_same_whoever_traces_them() {
    let scene = pool();
    let view = |photons| View {
        width: 96,
        height: 64,
        photons,
        ..by(
            |settings| {
                Integrator::Merging(
                    settings,
                    PhotonSettings {
                        paths: None,
                        radius: 3.0,
                    },
                )
            },
            &over_the_pool(5),
        )
    };
    let alone: Vec<TileSamples> = (0..6)
        .map(|tile| traced(&scene, &view(PhotonRounds::default()), tile, 4))
        .collect();
    assert!(
        alone
            .iter()
            .any(|samples| samples.pixels.iter().any(|sum| sum.radiance != Rgb::ZERO))
    );
    let together = view(PhotonRounds::default());
    // Forty rounds before and after: more than are kept.
    for first in [4, 40, 80, 4] {
        std::thread::scope(|scope| {
            let (scene, together) = (&scene, &together);
            let workers: Vec<_> = (0..6)
                .map(|tile| scope.spawn(move || traced(scene, together, tile, first)))
                .collect();
            for (worker, expected) in workers.into_iter().zip(&alone) {
                let samples = worker.join().expect("no panic");
                if first == 4 {
                    assert!(samples == *expected);
                }
            }
        });
    }
    // Another scene or camera sees photons of its own.
    let moved = View {
        camera: camera(Vec3::new(0.8, 3.0, 1.5), Vec3::new(0.0, -0.9, 0.0), 30.0),
        ..together.clone()
    };
    let fresh = View {
        photons: PhotonRounds::default(),
        ..moved.clone()
    };
    assert!(traced(&scene, &moved, 1, 4) == traced(&scene, &fresh, 1, 4));
    assert!(traced(&lit_room(), &together, 1, 4) == traced(&lit_room(), &view(PhotonRounds::default()), 1, 4));
    let cancelled = AtomicBool::new(true);
    assert!(render_tile(&scene, &fresh, tiles(96, 64)[0], 8..9, &cancelled).is_none());
}
