//! Texels have the mean of the light over their part of the surface, and nothing of what stands on it.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{Affine3A, Quat, UVec2, Vec2, Vec3};
use sunroom::accel::{Blas, Primitive, SplitMethod};
use sunroom::bake::in_sight::keep_in_sight;
use sunroom::bake::lightmap::Lightmaps;
use sunroom::bake::texels::Texels;
use sunroom::color::{Rgb, luminance};
use sunroom::geometry::primitives::unit_cube;
use sunroom::light::LightSource;
use sunroom::render::scene::RenderScene;
use sunroom::render::view::Strategy;

use super::{UP, covered, diffuse, gather, gathering, patch, rectangle, settings};
use crate::support::SceneBuilder;

/// A turned block on a floor, whose shadows have sharp edges, and a wall that stands in the floor.
fn block() -> RenderScene {
    let mut scene = SceneBuilder::default();
    let floor = rectangle(Vec2::splat(2.0), Quat::from_rotation_x(UP), Vec3::ZERO);
    scene.add(Primitive::Rectangle, floor, diffuse(0.6), None);
    let cube = Primitive::Mesh(Arc::new(Blas::build(Arc::new(unit_cube()), SplitMethod::Sah)));
    let turned = Affine3A::from_scale_rotation_translation(
        Vec3::new(0.3, 0.4, 0.2),
        Quat::from_rotation_y(0.5),
        Vec3::new(-0.2, 0.4, 0.1),
    );
    scene.add(cube.clone(), turned, diffuse(0.5), None);
    let wall =
        Affine3A::from_scale_rotation_translation(Vec3::new(0.21, 1.0, 3.0), Quat::IDENTITY, Vec3::new(-1.2, 0.5, 0.0));
    scene.add(cube, wall, diffuse(0.5), None);
    scene.light(LightSource::Point {
        position: Vec3::new(0.9, 1.5, 0.4),
        intensity: Rgb::splat(3.0),
    });
    scene.build()
}

/// The floor with this many texels on a side.
fn floor(texels: u32) -> Texels {
    let surface = patch(
        Vec3::ZERO,
        Vec3::Y,
        1.5,
        texels as f32,
        Vec2::splat(texels as f32 / 8.0),
    );
    covered(&[surface], UVec2::splat(texels * 5 / 4), 1)
}

/// The light of texels that are not inside of something, by their places.
fn by_place(texels: &Texels, light: &Lightmaps) -> Vec<Option<f32>> {
    let mut found = vec![None; (texels.size.x * texels.size.y) as usize];
    for (number, texel) in texels
        .texels
        .iter()
        .enumerate()
        .filter(|(number, _)| !light.is_buried(*number))
    {
        found[(texel.place.y * texels.size.x + texel.place.x) as usize] = Some(luminance(light.light(number)));
    }
    found
}

/// The least, the mean and the largest value of the finer texels in a texel, if all of them have light.
fn finer(fine: &[Option<f32>], width: u32, place: UVec2) -> Option<[f32; 3]> {
    let of = (0..16).map(|number| {
        let at = 4 * place + UVec2::new(number % 4, number / 4);
        fine[(at.y * 4 * width + at.x) as usize]
    });
    let values: Vec<f32> = of.flatten().collect();
    let ends = values.iter().fold([f32::INFINITY, 0.0], |[low, high], value| {
        [value.min(low), value.max(high)]
    });
    (!values.is_empty()).then(|| [ends[0], values.iter().sum::<f32>() / values.len() as f32, ends[1]])
}

#[test]
fn shadows_have_the_edges_of_a_finer_lightmap() {
    const TEXELS: u32 = 32;
    let scene = block();
    let view = settings(Strategy::Mis);
    let gathering = gathering(&scene, &view);
    let mut fine = floor(4 * TEXELS);
    fine.spreads.clear();
    let reference = by_place(&fine, &gather(&gathering, &fine, 64));
    let mut spread = floor(TEXELS);
    keep_in_sight(&mut spread, &scene.geometry, &AtomicBool::new(false));
    let mut alone = spread.clone();
    alone.spreads.clear();
    // The root mean square errors of texels with an edge of a shadow, and of the others.
    let errors = |texels: &Texels| {
        let found = by_place(texels, &gather(&gathering, texels, 64));
        let (mut sums, mut counts) = ([0.0; 2], [0; 2]);
        for (number, value) in (0..).zip(&found) {
            let place = UVec2::new(number % texels.size.x, number / texels.size.x);
            let (Some(value), Some([low, mean, high])) = (value, finer(&reference, texels.size.x, place)) else {
                continue;
            };
            let kind = usize::from(high - low < 0.3 * mean);
            sums[kind] += (value - mean).powi(2);
            counts[kind] += 1;
        }
        let error = |kind: usize| (sums[kind] / counts[kind] as f32).sqrt();
        println!("{counts:?} texels: {} at edges, {} elsewhere", error(0), error(1));
        assert!(counts[0] > 50 && counts[1] > 500, "{counts:?}");
        [error(0), error(1)]
    };
    let [before, after] = [errors(&alone), errors(&spread)];
    assert!(after[0] < 0.4 * before[0], "{after:?} and {before:?}");
    assert!(after[1] < 1.1 * before[1], "{after:?} and {before:?}");
}

/// What stands on a surface takes no light from the texels around its foot.
#[test]
fn the_foot_of_a_wall_has_no_seam() {
    let scene = block();
    let view = settings(Strategy::Mis);
    let gathering = gathering(&scene, &view);
    let mut texels = floor(32);
    let all = texels.spreads.clone();
    keep_in_sight(&mut texels, &scene.geometry, &AtomicBool::new(false));
    let changed = all
        .iter()
        .zip(&texels.spreads)
        .filter(|(one, other)| one != other)
        .count();
    assert!((20..400).contains(&changed), "{changed}");
    let row = |texels: &Texels| {
        let light = by_place(texels, &gather(&gathering, texels, 256));
        // The lit side of the wall, whose foot is at x = -0.99 and cuts texels, in the row of z = 1.1.
        let width = texels.size.x;
        let places = texels
            .texels
            .iter()
            .filter(|texel| (texel.receiver.position.z - 1.1).abs() < 0.04);
        let mut row: Vec<(f32, f32)> = places
            .filter_map(|texel| {
                let light = light[(texel.place.y * width + texel.place.x) as usize]?;
                Some((texel.receiver.position.x, light))
            })
            .filter(|(x, _)| (-0.99..-0.7).contains(x))
            .collect();
        row.sort_by(|one, other| one.0.total_cmp(&other.0));
        row
    };
    let lit = row(&texels);
    assert!(lit.len() >= 3, "{lit:?}");
    assert!(lit[0].1 > 0.9 * lit[1].1, "{lit:?}");
    // Without lines of sight the foot is darker: places in the wall have no light.
    texels.spreads = all;
    let dark = row(&texels);
    assert!(dark[0].1 < 0.9 * lit[0].1, "{dark:?} and {lit:?}");
}

/// Places of a bent surface stay on it.
#[test]
fn places_on_bent_surfaces_are_not_below_them() {
    let (half_size, texels) = (1.0, 8.0);
    let side = 2.0 * half_size / texels;
    let mut ball = patch(Vec3::ZERO, Vec3::Z, half_size, texels, Vec2::splat(2.0));
    let centre = Vec3::new(0.0, 0.0, -3.0);
    ball.normals = ball
        .positions
        .iter()
        .map(|place| (*place - centre).normalize())
        .collect();
    let radius = ball.positions[0].distance(centre);
    let texels = covered(&[ball], UVec2::splat(12), 1);
    let mut spread = 0;
    for (texel, places) in texels.texels.iter().zip(&texels.spreads) {
        for number in 0..64 {
            let u = Vec2::new(number as f32 / 64.0, (number * 37 % 64) as f32 / 64.0);
            let Some(place) = places.place(u) else { continue };
            spread += 1;
            assert!(place.z > -1e-5 && place.distance(centre) > 0.999 * radius, "{place}");
            // Half the diagonal of a texel, and a tenth of its side, as far as a sample may lie beside the surface.
            let reach = (0.5f32.sqrt() + 0.1) * side;
            assert!(place.distance(texel.receiver.position) < reach, "{place} {texel:?}");
        }
    }
    assert!(spread > 64 * 36, "{spread}");
}
