//! Reconstruction filters and cameras against their definitions, and pictures that a filter must not change.

use std::f32::consts::{PI, TAU};
use std::sync::atomic::AtomicBool;

use crate::statistics::{assert_all_plausible, chi_squared_p};
use crate::support::{SceneBuilder, camera, render, view};
use glam::{Affine3A, UVec2, Vec2, Vec3};
use sunroom::accel::Primitive;
use sunroom::color::Rgb;
use sunroom::render::camera::{Camera, ThinLens};
use sunroom::render::film::Film;
use sunroom::render::filter::{FilterKernel, PixelFilter};
use sunroom::render::tile::{render_tile, tiles};
use sunroom::render::view::Strategy;
use sunroom::sampling::{Sampler, SequenceKind};
use sunroom::shading::{Bsdf, Diffuse};

fn kernels() -> Vec<FilterKernel> {
    let mitchell = |b: f32, c: f32| FilterKernel::Cubic { b, c };
    let lanczos = |lobes| FilterKernel::Lanczos { lobes };
    vec![
        FilterKernel::Gaussian { stddev: 0.5 },
        FilterKernel::Gaussian { stddev: 2.0 },
        mitchell(1.0 / 3.0, 1.0 / 3.0),
        mitchell(1.0, 0.0),
        FilterKernel::CATMULL_ROM,
        lanczos(1),
        lanczos(2),
        lanczos(3),
        lanczos(5),
    ]
}

fn numbers(kind: SequenceKind, index: u32) -> Vec2 {
    Sampler::new(kind, UVec2::new(3, 5), index, 11).at_2d(0)
}

/// Cells per axis; a table has a thousand steps, of which each cell holds a whole number of parts.
const CELLS: usize = 32;

fn cell_of(offset: Vec2, radius: f32) -> usize {
    let along = |x: f32| (((x / radius + 1.0) * 0.5 * CELLS as f32) as usize).min(CELLS - 1);
    along(offset.y) * CELLS + along(offset.x)
}

/// The integral of `f` over each of the cells of one axis, by the midpoint rule.
fn cells_of(f: impl Fn(f32) -> f32, radius: f32) -> Vec<f64> {
    const POINTS: usize = 512;
    let width = 2.0 * radius / (CELLS * POINTS) as f32;
    let point = |i: usize| f64::from(f(-radius + (i as f32 + 0.5) * width)) * f64::from(width);
    (0..CELLS)
        .map(|cell| (cell * POINTS..(cell + 1) * POINTS).map(point).sum())
        .collect()
}

#[test]
fn places_follow_the_magnitude_and_weights_the_sign() {
    let count = 100_000;
    let tents = [0.3f32, 1.0, 2.5].map(|radius| {
        let tent = move |x: f32| (1.0 - (x / radius).abs()).max(0.0);
        let value: Box<dyn Fn(f32) -> f32> = Box::new(tent);
        (format!("tent {radius}"), PixelFilter::Tent { radius }, radius, value)
    });
    let tabulated = kernels().into_iter().map(|kernel| {
        let value: Box<dyn Fn(f32) -> f32> = Box::new(move |x| kernel.value(x));
        (
            format!("{kernel:?}"),
            PixelFilter::tabulated(kernel),
            kernel.radius(),
            value,
        )
    });
    let mut results = Vec::new();
    for (name, filter, radius, value) in tents.into_iter().chain(tabulated) {
        let mut counted = vec![0.0; CELLS * CELLS];
        let mut weighed = vec![0.0; CELLS * CELLS];
        for index in 0..count {
            let sample = filter.sample(numbers(SequenceKind::Independent, index));
            assert!(sample.offset.abs().max_element() <= radius, "{name}: {sample:?}");
            counted[cell_of(sample.offset, radius)] += 1.0;
            weighed[cell_of(sample.offset, radius)] += f64::from(sample.weight);
        }
        let magnitude = cells_of(|x| value(x).abs(), radius);
        let total: f64 = magnitude.iter().sum();
        let outer = |cells: &[f64], total: f64| -> Vec<f64> {
            let rows = cells.iter();
            rows.flat_map(|y| cells.iter().map(move |x| x * y / (total * total)))
                .collect()
        };
        let mut expected = outer(&magnitude, total);
        expected.iter_mut().for_each(|e| *e *= f64::from(count));
        results.push((name.clone(), chi_squared_p(&counted, &expected)));

        // Sums of weights estimate the filter itself, normalised: each cell within five standard deviations, as all
        // weights have the magnitude W and N samples of probability p give a sum with a variance of at most N p
        // W^2 (plus what the staircase moves).
        let signed = cells_of(&value, radius);
        let integral: f64 = signed.iter().sum();
        let weight = (total / integral).powi(2);
        for (cell, (sum, share)) in weighed.iter().zip(outer(&signed, integral)).enumerate() {
            let deviation = (expected[cell].max(1.0)).sqrt() * weight;
            let difference = (sum - share * f64::from(count)).abs();
            assert!(
                difference < 5.0 * deviation + 5.0,
                "{name}, cell {cell}: {sum} of {share}"
            );
        }
    }
    assert_all_plausible(&results);
}

#[test]
fn weights_are_one_on_average() {
    for kernel in kernels() {
        let filter = PixelFilter::tabulated(kernel);
        let count = 1 << 14;
        let weight = |index| f64::from(filter.sample(numbers(SequenceKind::Sobol, index)).weight);
        let mean: f64 = (0..count).map(weight).sum::<f64>() / f64::from(count);
        // The points are a net: of 128 x 128 elementary squares each holds one. The sign changes along at most 8 lines
        // per axis, and only squares on a line err, by up to twice the weight (below 4); in practice they err
        // in both directions.
        assert!((mean - 1.0).abs() < 0.01, "{kernel:?}: {mean}");
    }
}

fn lens(blades: u32) -> ThinLens {
    ThinLens {
        aperture_radius: 0.4,
        focus_distance: 3.0,
        blades,
        blade_rotation: 0.3,
    }
}

#[test]
fn rays_start_evenly_on_the_aperture() {
    let count = 100_000;
    let mut results = Vec::new();
    for blades in [0, 3, 4, 5, 8] {
        let camera = Camera::new(Affine3A::IDENTITY, 40.0, 1.0, 1e-6, 1e3, Some(lens(blades)));
        let inside = |p: Vec2| match blades {
            0 => p.length() <= 0.4,
            n => (0..n).all(|edge| {
                let middle = 0.3 + TAU * (edge as f32 + 0.5) / n as f32;
                p.dot(Vec2::from_angle(middle)) <= 0.4 * (PI / n as f32).cos()
            }),
        };
        // The part of every cell that lies in the aperture, by counting a fine grid.
        let fine = 64;
        let at = |i: usize, n: usize| 0.4 * (2.0 * (i as f32 + 0.5) / n as f32 - 1.0);
        let mut expected = vec![0.0; CELLS * CELLS];
        for y in 0..CELLS * fine {
            for x in 0..CELLS * fine {
                let p = Vec2::new(at(x, CELLS * fine), at(y, CELLS * fine));
                expected[y / fine * CELLS + x / fine] += f64::from(u8::from(inside(p)));
            }
        }
        let total: f64 = expected.iter().sum();
        expected.iter_mut().for_each(|e| *e *= f64::from(count) / total);
        let mut counted = vec![0.0; CELLS * CELLS];
        for index in 0..count {
            let ray = camera.ray(Vec2::new(0.2, 0.7), numbers(SequenceKind::Independent, index));
            counted[cell_of(ray.origin.truncate(), 0.4)] += 1.0;
        }
        results.push((format!("{blades} blades"), chi_squared_p(&counted, &expected)));
    }
    assert_all_plausible(&results);
}

/// An orthographic picture of 24 x 24 pixels, one pixel 0.1 wide, whose left part up to `edge` pixels shines with
/// radiance 1.
fn picture_of_an_edge(filter: PixelFilter, edge: f32) -> Film {
    let reach = 5.0;
    let mut builder = SceneBuilder::default();
    let toward_camera = Affine3A::from_rotation_y(PI) * Affine3A::from_scale(Vec3::new(reach, reach, 1.0));
    let place = Affine3A::from_translation(Vec3::new(1.2 - 0.1 * edge + reach, 0.0, 2.0));
    let black = Bsdf::Diffuse(Diffuse { reflectance: Rgb::ZERO });
    builder.add(Primitive::Rectangle, place * toward_camera, black, Some(Rgb::ONE));
    let camera = Camera::orthographic(Affine3A::IDENTITY, Vec2::splat(1.2), 0.1, 10.0);
    let mut view = view(camera, 24, 1, Strategy::Mis);
    view.filter = filter;
    render(&builder.build(), &view, 256)
}

#[test]
fn an_edge_looks_as_the_filter_says() {
    let edge = 12.3;
    for kernel in kernels() {
        let film = picture_of_an_edge(PixelFilter::tabulated(kernel), edge);
        let radius = kernel.radius();
        let integral: f64 = cells_of(|x| kernel.value(x), radius).iter().sum();
        for x in 0..24 {
            let distance = (edge - (x as f32 + 0.5)).clamp(-radius, radius);
            // The filter's integral up to the edge, over all of it.
            let middle = 0.5 * (distance - radius);
            let below: f64 = cells_of(|x| kernel.value(x + middle), 0.5 * (distance + radius))
                .iter()
                .sum();
            let pixels = || (0..24).filter_map(|y| film.pixel(x, y));
            let mean = pixels().map(|pixel| pixel.radiance.x).sum::<f32>() / 24.0;
            let errors = (0..24).filter_map(|y| film.standard_error(x, y));
            let error = errors.map(|error| error * error).sum::<f32>().sqrt() / 24.0;
            let expected = (below / integral) as f32;
            // Five standard errors in 9 x 24 columns, and what the steps of the table displace.
            let tolerance = 5.0 * error + 2e-3;
            assert!(
                (mean - expected).abs() < tolerance,
                "{kernel:?}, column {x}: {mean} +- {error}, expected {expected}"
            );
        }
    }
}

#[test]
fn the_standard_error_knows_the_weights() {
    // Inside the light every sample brings its weight: +-W. The spread of the pixels must be what the film says it is.
    let kernel = FilterKernel::Lanczos { lobes: 3 };
    let film = picture_of_an_edge(PixelFilter::tabulated(kernel), 40.0);
    let pixels: Vec<_> = (0..24).flat_map(|y| (0..24).map(move |x| (x, y))).collect();
    let squares = pixels.iter().filter_map(|&(x, y)| film.pixel(x, y));
    let spread = squares.map(|pixel| (pixel.radiance.x - 1.0).powi(2)).sum::<f32>() / 576.0;
    let claims = pixels.iter().filter_map(|&(x, y)| film.standard_error(x, y));
    let claimed = claims.map(|error| error * error).sum::<f32>() / 576.0;
    assert!(claimed > 1e-3, "{claimed}");
    // The variance of 576 values is known to sqrt(2 / 576) = 6 %; five times that.
    assert!((spread / claimed - 1.0).abs() < 0.3, "{spread} of {claimed}");
}

#[test]
fn ranges_of_samples_add_up() {
    let mut builder = SceneBuilder::default();
    builder.add(
        Primitive::Sphere,
        Affine3A::IDENTITY,
        Bsdf::Diffuse(Diffuse {
            reflectance: Rgb::splat(0.5),
        }),
        Some(Rgb::ONE),
    );
    let scene = builder.build();
    let mut view = view(camera(Vec3::new(0.0, 0.0, 4.0), Vec3::ZERO, 40.0), 16, 3, Strategy::Mis);
    view.filter = PixelFilter::tabulated(FilterKernel::Lanczos { lobes: 3 });
    let tile = tiles(16, 16)[0];
    let part = |range| render_tile(&scene, &view, tile, range, &AtomicBool::new(false)).expect("not cancelled");
    let (mut whole, mut parts) = (Film::new(16, 16), Film::new(16, 16));
    whole.add(&part(0..16));
    parts.add(&part(0..5));
    parts.add(&part(5..16));
    for (whole, parts) in whole.radiance().iter().zip(parts.radiance()) {
        // The same numbers in another order of addition: 16 roundings of partial sums below 16 * W^2 = 47.
        assert!(
            whole.abs_diff_eq(parts, 16.0 * 47.0 / 16.0 * f32::EPSILON),
            "{whole} {parts}"
        );
    }
}
