//! The same bits, however the work is divided.

use std::sync::atomic::AtomicBool;

use glam::{UVec2, Vec2, Vec3};
use sunroom::bake::lightmap::Lightmaps;
use sunroom::bake::texels::Texels;
use sunroom::render::scene::RenderScene;
use sunroom::render::view::{Strategy, View};

use super::{corner, covered, gather, gathering, patch, settings};

/// A floor of 24 x 24 texels in a corner, with the settings of paths.
fn floor_in_corner() -> (RenderScene, Texels, View) {
    let floor = patch(Vec3::ZERO, Vec3::Y, 1.0, 24.0, Vec2::splat(2.0));
    (
        corner(),
        covered(&[floor], UVec2::splat(28), 1),
        settings(Strategy::Mis),
    )
}

#[test]
fn threads_and_rounds_change_no_bit() {
    let (scene, texels, view) = floor_in_corner();
    let gathering = gathering(&scene, &view);
    let with = |threads: usize, rounds: &[u32]| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        let mut light = Lightmaps::new(texels.texels.len());
        pool.install(|| {
            for &samples in rounds {
                assert!(light.add(&gathering, &texels, samples, &AtomicBool::new(false)));
            }
        });
        light
    };
    let one = with(1, &[7]);
    assert!(one == with(4, &[7]));
    assert!(one == with(3, &[1, 1, 2, 3]));
    let mut light = Lightmaps::new(texels.texels.len());
    assert!(!light.add(&gathering, &texels, 1, &AtomicBool::new(true)));
    assert_eq!((light.samples(), light.rays), (0, 0));
}

#[test]
fn shares_and_interruptions_change_no_bit() {
    let (scene, texels, view) = floor_in_corner();
    let gathering = gathering(&scene, &view);
    let never = AtomicBool::new(false);
    let whole = gather(&gathering, &texels, 50);
    // Block by block, as a job does that is cancelled in the middle of a round.
    let mut piecewise = Lightmaps::new(texels.texels.len());
    let mut calls = 0;
    while piecewise.reached() < 50 {
        let end = piecewise.round_end(50);
        piecewise.go_on(&gathering, &texels, end, 1, &never);
        calls += 1;
    }
    assert!(piecewise == whole && calls > 16, "{calls} calls");
    let mut merged = Lightmaps::new(texels.texels.len());
    for range in [0..16, 16..48, 48..50] {
        let mut share = Lightmaps::beginning_at(range.start, texels.texels.len());
        assert!(share.add(&gathering, &texels, range.end - range.start, &never));
        assert!(merged.append(share));
    }
    assert!(merged == whole);
    // Gaps and other texels are refused.
    assert!(!merged.append(Lightmaps::beginning_at(64, texels.texels.len())));
    assert!(!merged.append(Lightmaps::beginning_at(50, 3)));
}
