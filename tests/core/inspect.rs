//! Recorded paths are the paths of the picture.

use std::sync::atomic::AtomicBool;

use crate::bidirectional::by;
use crate::support::{SceneBuilder, camera, render, view};
use glam::{Affine3A, Quat, UVec2, Vec3};
use sunroom::accel::Primitive;
use sunroom::color::Rgb;
use sunroom::light::LightSource;
use sunroom::material::{Lobe, Material, MaterialId};
use sunroom::render::filter::{FilterKernel, PixelFilter};
use sunroom::render::inspect::{RecordedPath, record_paths};
use sunroom::render::observer::PathEnd;
use sunroom::render::scene::RenderScene;
use sunroom::render::tile::{Tile, render_tile};
use sunroom::render::view::{Integrator, PathSettings, Shown, Strategy, View};
use sunroom::sampling::power_heuristic;
use sunroom::shading::{Bsdf, Dielectric, DielectricModel, Diffuse, Metal};
use sunroom::texture::Parameter;

const SIZE: u32 = 12;
const MAX_DEPTH: u32 = 4;

/// A floor, a ball of glass, a veil, a lamp, a point light and two skies: something of everything that a path can do.
fn scene() -> RenderScene {
    let grey = |reflectance| {
        Bsdf::Diffuse(Diffuse {
            reflectance: Rgb::splat(reflectance),
        })
    };
    let placed =
        |scale: f32, rotation, place| Affine3A::from_scale_rotation_translation(Vec3::splat(scale), rotation, place);
    let mut scene = SceneBuilder::default();
    scene.add(
        Primitive::Rectangle,
        placed(3.0, Quat::IDENTITY, Vec3::NEG_Z),
        grey(0.8),
        None,
    );
    let glass = Dielectric {
        eta: 1.5,
        model: DielectricModel::Exact,
        specular_reflectance: Rgb::ONE,
        specular_transmittance: Rgb::ONE,
    };
    scene.add(
        Primitive::Sphere,
        placed(0.6, Quat::IDENTITY, Vec3::X * 0.7),
        Bsdf::Dielectric(glass),
        None,
    );
    let veil = Material::Mask {
        nested: MaterialId(0),
        opacity: Parameter::Constant(0.5),
    };
    scene.add(Primitive::Disk, placed(0.6, Quat::IDENTITY, Vec3::X * -0.7), veil, None);
    let down = Quat::from_rotation_x(2.5);
    scene.add(
        Primitive::Rectangle,
        placed(0.5, down, Vec3::new(0.0, 1.5, 1.0)),
        grey(0.0),
        Some(Rgb::splat(7.0)),
    );
    scene.light(LightSource::Point {
        position: Vec3::new(1.0, -1.0, 2.0),
        intensity: Rgb::new(1.0, 2.0, 3.0),
    });
    scene.light(LightSource::Constant {
        radiance: Rgb::splat(0.3),
    });
    scene.light(LightSource::Constant {
        radiance: Rgb::new(0.1, 0.0, 0.2),
    });
    scene.build()
}

fn look(strategy: Strategy) -> View {
    let mut look = view(
        camera(Vec3::new(0.0, -1.0, 5.0), Vec3::ZERO, 70.0),
        SIZE,
        MAX_DEPTH,
        strategy,
    );
    look.filter = PixelFilter::tabulated(FilterKernel::CATMULL_ROM);
    let settings = look.integrator.settings_mut();
    settings.rr_depth = 2;
    look
}

fn all_paths(scene: &RenderScene, look: &View, samples: u32) -> Vec<(UVec2, RecordedPath)> {
    let pixels = (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| UVec2::new(x, y)));
    pixels
        .flat_map(|pixel| {
            record_paths(scene, look, pixel, 0..samples)
                .into_iter()
                .map(move |path| (pixel, path))
        })
        .collect()
}

/// But for rounding: pictures are traced in vectors, of which each of a path's few vertices takes some tens of
/// operations.
fn is_alike(a: Rgb, b: Rgb) -> bool {
    a.abs_diff_eq(b, 200.0 * f32::EPSILON * a.abs().max_element().max(1.0))
}

/// The contributions in the order in which they were made.
fn contributions(path: &RecordedPath) -> impl Iterator<Item = Rgb> {
    let of_vertices = path.vertices.iter().flat_map(|vertex| {
        let met = vertex.met.map(|met| met.contribution);
        met.into_iter()
            .chain(vertex.sampled.map(|sampled| sampled.contribution))
            .chain(vertex.joined.map(|joined| joined.contribution))
    });
    of_vertices.chain(path.escaped_to.iter().map(|met| met.contribution))
}

#[test]
fn contributions_sum_up_to_the_very_samples_of_the_picture() {
    let scene = scene();
    for strategy in [Strategy::Mis, Strategy::Bsdf, Strategy::Light] {
        let look = look(strategy);
        for (pixel, path) in all_paths(&scene, &look, 8) {
            // From the zero that the renderer begins with: sums of floats depend on their order, and this is its order.
            let sum = contributions(&path).fold(Rgb::ZERO, |sum, light| sum + light);
            assert_eq!(sum, path.radiance, "{path:?}");
            let tile = Tile {
                x: pixel.x,
                y: pixel.y,
                width: 1,
                height: 1,
            };
            let range = path.sample..path.sample + 1;
            let rendered = render_tile(&scene, &look, tile, range, &AtomicBool::new(false)).expect("not cancelled");
            let (recorded, shown) = (path.radiance * path.filter_weight, rendered.pixels[0].radiance);
            assert!(is_alike(recorded, shown), "{recorded} {shown} {path:?}");
            assert_eq!(record_paths(&scene, &look, pixel, path.sample..path.sample + 1), [path]);
        }
    }
}

#[test]
fn both_paths_of_bidirectional_path_tracing_are_recorded() {
    let scene = crate::bidirectional::lit_room();
    let look = View {
        width: SIZE,
        height: SIZE,
        ..by(Integrator::Bidirectional, &crate::bidirectional::look(MAX_DEPTH))
    };
    let (mut joints, mut splats) = (0, 0);
    for (pixel, path) in all_paths(&scene, &look, 8) {
        let sum = contributions(&path).fold(Rgb::ZERO, |sum, light| sum + light);
        assert_eq!(sum, path.radiance, "{path:?}");
        let tile = Tile {
            x: pixel.x,
            y: pixel.y,
            width: 1,
            height: 1,
        };
        let range = path.sample..path.sample + 1;
        let rendered = render_tile(&scene, &look, tile, range, &AtomicBool::new(false)).expect("not cancelled");
        assert_eq!(path.radiance * path.filter_weight, rendered.pixels[0].radiance);
        assert_eq!(path.splats, rendered.splats.list);
        // Every joint is with a vertex of the path from the light, which has no more vertices than the longest path.
        let joined = path.vertices.iter().filter_map(|vertex| vertex.joined);
        for joined in joined {
            assert!(path.light_path[1..].contains(&joined.position), "{path:?}");
            assert!((0.0..=1.0).contains(&joined.weight));
            joints += 1;
        }
        assert!(path.light_path.len() <= MAX_DEPTH as usize);
        splats += path.splats.len();
    }
    assert!(joints > 50 && splats > 50, "{joints} {splats}");
}

#[test]
fn what_is_recorded_fits_together() {
    let scene = scene();
    let look = look(Strategy::Mis);
    let paths = all_paths(&scene, &look, 16);
    let mut ends = [0; 4];
    let (mut lobes, mut weighted, mut hidden, mut passed) = ([0; 3], 0, 0, 0);
    for (pixel, path) in &paths {
        ends[path.end as usize] += 1;
        assert!(path.vertices.len() <= MAX_DEPTH as usize);
        assert_eq!(path.camera_ray, look.camera_sample(*pixel, path.sample).ray);
        let goes_on = path.vertices.iter().filter(|vertex| vertex.bounce.is_some()).count();
        let escaped = path.end == PathEnd::Escaped;
        assert_eq!(path.vertices.len() - goes_on, usize::from(!escaped), "{path:?}");
        // Both skies, or none.
        assert_eq!(path.escaped_to.len(), if escaped { 2 } else { 0 });
        let mut throughput = Rgb::ONE;
        for pair in path.vertices.windows(2) {
            let bounce = pair[0].bounce.expect("it came to another vertex");
            let way = pair[1].place.position() - pair[0].place.position();
            // Positions are good to a few roundings of numbers up to 5, and no way here is shorter than a hundredth.
            assert!(
                way.length() < 1e-2 || way.normalize().distance(bounce.wi) < 1e-2,
                "{path:?}"
            );
        }
        let places = path.vertices.iter().map(|vertex| (vertex.met, vertex.bounce));
        for (met, bounce) in places.chain(path.escaped_to.iter().map(|&met| (Some(met), None))) {
            if let Some(met) = met {
                let weight = match (met.bsdf_pdf, met.light_pdf) {
                    (Some(bsdf), Some(light)) => power_heuristic(bsdf, light),
                    _ => 1.0,
                };
                assert_eq!(met.weight, weight);
                assert_eq!(met.contribution, throughput * met.radiance * weight);
                weighted += usize::from(weight < 1.0 && weight > 0.0);
            }
            if let Some(bounce) = bounce {
                throughput = bounce.throughput;
                lobes[bounce.lobe as usize] += 1;
                assert_eq!(
                    bounce.lobe == Lobe::Null,
                    bounce.wi == arrived(path, &bounce),
                    "{path:?}"
                );
            }
        }
        for sampled in path.vertices.iter().filter_map(|vertex| vertex.sampled) {
            let delta = sampled.sample.is_delta;
            let weight = if delta {
                1.0
            } else {
                power_heuristic(sampled.sample.pdf, sampled.bsdf_pdf * sampled.passed)
            };
            assert_eq!(sampled.weight, weight);
            match sampled.arriving {
                Some(Rgb::ZERO) => hidden += 1,
                Some(share) if share.max_element() < 1.0 => passed += 1,
                _ => {}
            }
            let arrives = sampled.arriving.is_some_and(|share| share != Rgb::ZERO);
            assert!(arrives || sampled.contribution == Rgb::ZERO);
        }
    }
    assert!(ends.iter().all(|&count| count > 0), "{ends:?}");
    assert!(lobes.iter().all(|&count| count > 20), "{lobes:?}");
    assert!(
        weighted > 100 && hidden > 20 && passed > 5,
        "{weighted} {hidden} {passed}"
    );
}

/// The direction in which the path came to the vertex that it left by `bounce`.
fn arrived(path: &RecordedPath, bounce: &sunroom::render::observer::Bounce) -> Vec3 {
    let place = path.vertices.iter().position(|vertex| vertex.bounce == Some(*bounce));
    match place.and_then(|place| place.checked_sub(1)) {
        Some(before) => path.vertices[before].bounce.map_or(Vec3::NAN, |bounce| bounce.wi),
        None => path.camera_ray.dir,
    }
}

#[test]
fn where_no_paths_are_traced_there_are_none() {
    let mut look = look(Strategy::Mis);
    look.shown = Shown::BvhSteps;
    assert_eq!(record_paths(&scene(), &look, UVec2::ONE, 0..4), []);
}

#[test]
fn the_split_shows_each_strategy_in_its_third() {
    let scene = scene();
    let strategies = [Strategy::Bsdf, Strategy::Light, Strategy::Mis];
    let mut split = look(Strategy::Mis);
    split.shown = Shown::StrategyThirds;
    let film = render(&scene, &split, 4);
    let alone = strategies.map(|strategy| render(&scene, &look(strategy), 4));
    for (x, y) in (0..SIZE).flat_map(|y| (0..SIZE).map(move |x| (x, y))) {
        let third = (x / (SIZE / 3)) as usize;
        let [split, alone] = [&film, &alone[third]].map(|film| film.pixel(x, y).expect("a pixel"));
        assert!(is_alike(split.radiance, alone.radiance), "{x} {y}: {split:?} {alone:?}");
        assert!(is_alike(split.albedo, alone.albedo), "{x} {y}: {split:?} {alone:?}");
        assert!(is_alike(split.normal, alone.normal), "{x} {y}: {split:?} {alone:?}");
    }
    // They do differ.
    assert!(alone[0].radiance() != alone[1].radiance() && alone[1].radiance() != alone[2].radiance());
}

/// What has found its way through glass or from mirror to mirror is not given up on the way; but it ends, however
/// bright.
#[test]
fn roulette_waits_where_surfaces_leave_no_choice() {
    let lengths = |bsdf: Bsdf| -> Vec<usize> {
        let mut scene = SceneBuilder::default();
        let around = Affine3A::from_scale(Vec3::splat(9.0));
        scene.add(Primitive::Sphere, around, bsdf, None).flip_normals = true;
        let mut look = look(Strategy::Mis);
        look.integrator = Integrator::Path(PathSettings {
            media: false,
            max_depth: u32::MAX,
            rr_depth: 2,
            hide_emitters: false,
            strategy: Strategy::Mis,
        });
        let paths = all_paths(&scene.build(), &look, 2);
        // A few end where rounding takes a direction into the surface.
        let by_roulette = paths.iter().filter(|(_, path)| path.end == PathEnd::Roulette);
        let lengths: Vec<usize> = by_roulette.map(|(_, path)| path.vertices.len()).collect();
        assert!(
            10 * lengths.len() > 9 * paths.len(),
            "{} of {}",
            lengths.len(),
            paths.len()
        );
        lengths
    };
    let mirror = |reflectance| {
        Bsdf::Metal(Metal {
            color: Rgb::splat(reflectance),
            fuzz: 0.0,
        })
    };
    let least = |bsdf| lengths(bsdf).into_iter().min();
    assert_eq!(least(mirror(0.5)), Some(18));
    assert_eq!(least(mirror(1.0)), Some(18));
    let plain = Bsdf::Diffuse(Diffuse {
        reflectance: Rgb::splat(0.5),
    });
    assert_eq!(least(plain), Some(2));
}
