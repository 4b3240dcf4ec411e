//! The clamp of bright samples.

use std::sync::atomic::AtomicBool;

use crate::bidirectional::{by, diffuse, lit_room, look, placed};
use crate::support::{SceneBuilder, camera, mean_luminance, render, view};
use glam::{Quat, Vec3};
use sunroom::accel::Primitive;
use sunroom::color::{Rgb, luminance};
use sunroom::layer::{Layer, Layers};
use sunroom::render::clamp::Clamp;
use sunroom::render::filter::{FilterKernel, PixelFilter};
use sunroom::render::scene::RenderScene;
use sunroom::render::tile::{render_tile, tiles};
use sunroom::render::view::{Integrator, PhotonSettings, Strategy, View};

const SAMPLES: u32 = 256;

/// A floor with a large dim lamp and a small bright one above it, which paths find by luck.
fn lamp_found_by_luck() -> (RenderScene, View) {
    let mut scene = SceneBuilder::default();
    let flat = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let floor = placed(Vec3::splat(2.0), flat, Vec3::ZERO);
    scene.add(Primitive::Rectangle, floor, diffuse(0.5), None);
    let lamp = placed(Vec3::splat(0.12), Quat::IDENTITY, Vec3::new(0.0, 0.6, 0.0));
    scene.add(Primitive::Sphere, lamp, diffuse(0.0), Some(Rgb::splat(50.0)));
    let dim = placed(Vec3::splat(0.7), Quat::IDENTITY, Vec3::new(-0.9, 0.8, -0.5));
    scene.add(Primitive::Sphere, dim, diffuse(0.0), Some(Rgb::splat(2.0)));
    let eye = camera(Vec3::new(0.0, 1.0, 3.0), Vec3::new(0.0, 0.3, 0.0), 40.0);
    (scene.build(), view(eye, 24, 3, Strategy::Bsdf))
}

fn clamped(view: &View, percentile: f32) -> View {
    View {
        clamp: Some(Clamp::new(percentile)),
        ..view.clone()
    }
}

#[test]
fn a_clamp_removes_noise_and_as_much_light_as_it_says() {
    let (scene, free) = lamp_found_by_luck();
    let tame = clamped(&free, 70.0);
    let (noisy, quiet) = (render(&scene, &free, SAMPLES), render(&scene, &tame, SAMPLES));
    let limit = tame
        .clamp
        .as_ref()
        .and_then(Clamp::found)
        .expect("a limit after a render");
    let ((mean, error), (less, small_error)) = (mean_luminance(&noisy), mean_luminance(&quiet));
    assert!(small_error < 0.9 * error, "{small_error} and {error}");
    let removed = 1.0 - less / mean;
    assert!(removed > 0.005 && limit.removed > 0.005, "{removed} {limit:?}");
    assert!(
        (removed - limit.removed).abs() < 0.2 * removed + 3.0 * error / mean,
        "{removed} {limit:?}"
    );
    // The lamp itself is far brighter than the limit, and stays as it is.
    let brightest = |film: &sunroom::render::film::Film| film.radiance().into_iter().map(luminance).fold(0.0, f32::max);
    assert!(limit.luminance < 49.0, "{limit:?}");
    assert!((brightest(&quiet) - 50.0).abs() < 1e-3 && (brightest(&noisy) - 50.0).abs() < 1.0);
}

#[test]
fn the_limit_depends_on_neither_seed_nor_part() {
    let (scene, free) = lamp_found_by_luck();
    let tame = clamped(&free, 95.0);
    let other = View {
        seed: 99,
        ..clamped(&free, 95.0)
    };
    let tile = tiles(tame.width, tame.height)[0];
    let [first, second] = [&tame, &other].map(|view| {
        render_tile(&scene, view, tile, 3..4, &AtomicBool::new(false)).expect("not cancelled");
        view.clamp.as_ref().and_then(Clamp::found)
    });
    assert_eq!(first, second);
    // The same bits by parts, and with a limit that is known already.
    let whole = render(&scene, &tame, 8);
    assert_eq!(whole.radiance(), render(&scene, &clamped(&free, 95.0), 8).radiance());
    let begun = clamped(&free, 95.0);
    let cancelled = render_tile(&scene, &begun, tile, 0..1, &AtomicBool::new(true));
    assert!(cancelled.is_none());
    // Who asks again is not left without a limit.
    render_tile(&scene, &begun, tile, 0..1, &AtomicBool::new(false)).expect("not cancelled");
    assert_eq!(begun.clamp.as_ref().and_then(Clamp::found), first);
}

/// Tracing all of them would take seconds, however small the picture is.
#[test]
fn the_search_for_a_limit_has_few_photons() {
    let merging = |settings| {
        let photons = PhotonSettings {
            paths: Some(1 << 16),
            radius: 3.0,
        };
        Integrator::Merging(settings, photons)
    };
    let (scene, view) = (lit_room(), by(merging, &clamped(&look(4), 90.0)));
    let tile = tiles(view.width, view.height)[0];
    render_tile(&scene, &view, tile, 0..1, &AtomicBool::new(false)).expect("not cancelled");
    assert!(view.clamp.as_ref().and_then(Clamp::found).is_some());
    // Four of the search, which has a seed of its own, and that of the sample.
    assert_eq!(view.photons.kept(), 5);
}

#[test]
fn layers_and_light_from_lamps_are_clamped_as_the_picture_is() {
    let (scene, free) = lamp_found_by_luck();
    let view = View {
        layers: Layers::of(&[Layer::Direct, Layer::Indirect, Layer::Emitted]),
        ..clamped(&free, 70.0)
    };
    let tile = tiles(view.width, view.height)[0];
    let samples = render_tile(&scene, &view, tile, 0..16, &AtomicBool::new(false)).expect("not cancelled");
    for (pixel, layers) in samples.pixels.iter().zip(samples.layers.values.chunks_exact(9)) {
        let sum: Rgb = layers.chunks_exact(3).map(Rgb::from_slice).sum();
        assert!(
            sum.abs_diff_eq(pixel.radiance, 1e-3 * (1.0 + pixel.radiance.max_element())),
            "{sum} {pixel:?}"
        );
    }
    // A filter with negative parts makes negative light as well.
    for filter in [
        view.filter.clone(),
        PixelFilter::tabulated(FilterKernel::Lanczos { lobes: 3 }),
    ] {
        let free = View { filter, ..free.clone() };
        let both_ends = by(Integrator::Bidirectional, &clamped(&free, 70.0));
        let [tame, wild] = [&both_ends, &by(Integrator::Bidirectional, &free)].map(|view| {
            let samples = render_tile(&scene, view, tile, 0..16, &AtomicBool::new(false)).expect("not cancelled");
            samples.splats.list
        });
        let limit = both_ends
            .clamp
            .as_ref()
            .and_then(Clamp::found)
            .expect("a limit after a render");
        assert_eq!(tame.len(), wild.len());
        for (tame, wild) in tame.iter().zip(&wild) {
            let [tame, wild] = [tame, wild].map(|splat| luminance(splat.radiance));
            let expected = wild.clamp(-limit.luminance, limit.luminance);
            assert!(
                (tame - expected).abs() <= 1e-4 * expected.abs(),
                "{tame}, {wild} {limit:?}"
            );
        }
    }
}
