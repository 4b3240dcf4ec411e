//! What the film remembers of the surfaces that its pixels see.

use std::sync::atomic::AtomicBool;

use crate::support::{SceneBuilder, camera, render, view};
use glam::{Affine3A, UVec2, Vec3};
use sunroom::accel::Primitive;
use sunroom::color::Rgb;
use sunroom::render::film::Film;
use sunroom::render::tile::{render_preview, tiles};
use sunroom::render::view::{Shown, Strategy};
use sunroom::shading::{Bsdf, Diffuse};

#[test]
fn first_hits_are_those_of_sample_zero() {
    let mut builder = SceneBuilder::default();
    let grey = || {
        Bsdf::Diffuse(Diffuse {
            reflectance: Rgb::splat(0.5),
        })
    };
    builder.add(Primitive::Rectangle, Affine3A::IDENTITY, grey(), None);
    let ball = Affine3A::from_scale_rotation_translation(Vec3::splat(0.4), glam::Quat::IDENTITY, Vec3::Z);
    builder.add(Primitive::Sphere, ball, grey(), None);
    let scene = builder.build();
    // Wide enough to see past the square.
    let mut look = view(camera(Vec3::new(0.3, 0.2, 3.0), Vec3::ZERO, 60.0), 40, 3, Strategy::Mis);
    for shown in [Shown::Radiance, Shown::BvhSteps] {
        look.shown = shown;
        let film = render(&scene, &look, 3);
        let mut seen = [0; 3];
        for (x, y) in (0..40).flat_map(|y| (0..40).map(move |x| (x, y))) {
            let ray = look.camera_sample(UVec2::new(x, y), 0).ray;
            let hit = scene.geometry.intersect(&ray);
            let first = film.first_hit(x, y);
            assert_eq!(
                first.map(|first| (first.instance, first.material)),
                hit.map(|hit| (hit.instance, scene.slot(&hit).material)),
                "{x} {y}"
            );
            if let (Some(first), Some(hit)) = (first, hit) {
                let uv = scene.geometry.surface(&ray, &hit).uv;
                // Many rays at once round otherwise than one.
                assert!(first.uv.abs_diff_eq(uv, 1e-5), "{x} {y}: {} {uv}", first.uv);
            }
            seen[first.map_or(2, |first| first.instance as usize)] += 1;
        }
        assert!(seen.iter().all(|&pixels| pixels > 20), "{seen:?}");
    }
}

#[test]
fn previews_tell_what_their_blocks_see() {
    let mut builder = SceneBuilder::default();
    let grey = Bsdf::Diffuse(Diffuse {
        reflectance: Rgb::splat(0.5),
    });
    builder.add(Primitive::Rectangle, Affine3A::IDENTITY, grey, None);
    let scene = builder.build();
    let look = view(camera(Vec3::Z * 3.0, Vec3::ZERO, 60.0), 40, 3, Strategy::Mis);
    let mut film = Film::new(40, 40);
    for tile in tiles(40, 40) {
        let preview = render_preview(&scene, &look, tile, 4, &AtomicBool::new(false)).expect("not cancelled");
        film.add_preview(preview);
    }
    for (x, y) in (0..40).flat_map(|y| (0..40).map(move |x| (x, y))) {
        // Tiles begin at multiples of 32, so blocks at multiples of 4; the one sample is of the third pixel.
        let ray = look.camera_sample(UVec2::new(x / 4 * 4 + 2, y / 4 * 4 + 2), 0).ray;
        let expected = scene.geometry.intersect(&ray).map(|hit| hit.instance);
        assert_eq!(film.first_hit(x, y).map(|first| first.instance), expected, "{x} {y}");
    }
}
