//! What a sample costs, and how much memory a scene takes, as the scene grows.
//!
//! `cargo bench --bench growth -- [TABLE...]` prints tables of triangles, instances, lights, volumes, pixels and
//! threads; named ones alone if any are named. Times per sample are of one thread, shortest of a few, on small pictures
//! of paths of three segments. "held" is what the process holds more than before the scene was built, "peak" the most
//! it held meanwhile.

extern crate sunroom_core as sunroom;

#[path = "../tests/support/mod.rs"]
mod support;
#[path = "../tests/core/accel_support/wavy_sphere.rs"]
mod wavy_sphere;

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use glam::{Affine3A, EulerRot, Quat, UVec3, Vec3};
use rayon::prelude::*;
use sunroom::accel::{Blas, Instance, Placement, Primitive, SplitMethod, Tlas};
use sunroom::color::Rgb;
use sunroom::light::LightSource;
use sunroom::material::Material;
use sunroom::medium::{
    GridVolume, MediumId, MediumInterface, MediumSource, Phase, Volume, VolumeFilter, VolumeGrid, VolumeWrap, Voxels,
};
use sunroom::render::film::Film;
use sunroom::render::scene::RenderScene;
use sunroom::render::tile::{render_tile, tiles};
use sunroom::render::view::{Strategy, View};
use sunroom::sampling::hash::pcg4d;
use sunroom::sampling::{unit_float, warp};
use sunroom::shading::{Bsdf, Diffuse};
use support::{SceneBuilder, camera, triangle_mesh, view};
use wavy_sphere::wavy_sphere;

/// The shortest time of so many is taken.
const REPEATS: u32 = 3;
const RESOLUTION: u32 = 96;
const SAMPLES: u32 = 16;

fn main() {
    let names: Vec<String> = std::env::args()
        .skip(1)
        .filter(|argument| argument != "--bench")
        .collect();
    let tables: [(&str, fn()); 6] = [
        ("triangles", of_triangles),
        ("instances", of_instances),
        ("lights", of_lights),
        ("volumes", of_volumes),
        ("pixels", of_pixels),
        ("threads", of_threads),
    ];
    for (name, table) in tables {
        if names.is_empty() || names.iter().any(|wanted| wanted == name) {
            table();
        }
    }
}

fn of_triangles() {
    headings("triangles");
    for rings in [23, 71, 224, 708, 2236] {
        let count = 2 * rings * (rings - 1);
        row("a wavy sphere", count, || under_a_sky(mesh(rings)));
    }
}

fn of_instances() {
    headings("instances");
    for count in [100, 1_000, 10_000, 100_000, 1_000_000] {
        row("placements of a group", count, || {
            let group = Tlas::build(
                vec![Instance::new(mesh(32), Affine3A::IDENTITY).expect("invertible")],
                SplitMethod::Sah,
            );
            let placements = (0..count).filter_map(|index| Placement::new(0, &spread(index, count, 0.0)));
            let placements = placements.collect();
            let mut scene = under_a_sky(Primitive::Sphere);
            scene.geometry = Arc::new(Tlas::with_placements(
                Vec::new(),
                vec![Arc::new(group)],
                placements,
                SplitMethod::Sah,
            ));
            scene
        });
    }
    for count in [100, 10_000, 1_000_000] {
        row("shapes of one mesh", count, || {
            let mesh = mesh(32);
            let mut scene = SceneBuilder::default();
            for index in 0..count {
                scene.add(mesh.clone(), spread(index, count, 0.0), grey(), None);
            }
            scene.light(sky());
            scene.build()
        });
    }
}

fn of_lights() {
    headings("lights");
    for count in [10, 100, 1_000, 10_000] {
        row("points", count, || {
            let mut scene = floor();
            for index in 0..count {
                let [x, y, z, _] = random(index, 1);
                scene.light(LightSource::Point {
                    position: Vec3::new(2.0 * x - 1.0, y, 2.0 * z - 1.0),
                    intensity: Rgb::splat(1.0 / count as f32),
                });
            }
            scene.build()
        });
    }
    for count in [10, 100, 1_000, 10_000] {
        row("triangles of one mesh", count, || {
            let mut scene = floor();
            scene.add(
                triangle_mesh((0..count).map(|index| small_triangle(index, count))),
                Affine3A::IDENTITY,
                grey(),
                Some(Rgb::ONE),
            );
            scene.build()
        });
    }
    for count in [10, 100, 1_000, 10_000] {
        row("spheres", count, || {
            let mut scene = floor();
            for index in 0..count {
                scene.add(Primitive::Sphere, spread(index, count, 0.0), grey(), Some(Rgb::ONE));
            }
            scene.build()
        });
    }
}

/// A cloud of more and more voxels, then of more and more density. The density is the optical depth along an edge where
/// the cloud is thickest.
fn of_volumes() {
    headings("volumes");
    for edge in [64, 128, 256, 512] {
        row("voxels, density 8", edge * edge * edge, || cloud(edge, 8.0));
    }
    for density in [1, 8, 64, 512] {
        row("density, 128^3 voxels", density, || cloud(128, density as f32));
    }
}

/// A cube of cloud of `edge` voxels along each edge under the sky.
fn cloud(edge: u32, density: f32) -> RenderScene {
    let value = |index: u32| {
        let place = UVec3::new(index % edge, index / edge % edge, index / edge / edge);
        let at = 9.0 * (place.as_vec3() + 0.5) / edge as f32;
        let wave = (at.x + at.y.sin()).sin() * (at.y + at.z.sin()).sin() * (at.z + at.x.sin()).sin();
        (255.0 * wave.max(0.0)) as u8
    };
    let voxels = (0..edge * edge * edge).into_par_iter().map(value).collect();
    let grid = VolumeGrid::new(UVec3::splat(edge), 1, Voxels::U8(voxels)).expect("a grid");
    let cube = Affine3A::from_translation(Vec3::NEG_ONE) * Affine3A::from_scale(Vec3::splat(2.0));
    let mut scene = SceneBuilder::with_media(vec![MediumSource {
        sigma_t: Volume::Grid(GridVolume::new(
            Arc::new(grid),
            cube,
            VolumeFilter::Trilinear,
            VolumeWrap::Clamp,
        )),
        scale: 0.5 * density,
        albedo: Volume::Constant(Rgb::splat(0.9)),
        emission: Volume::ZERO,
        phase: Phase::HenyeyGreenstein { g: 0.5 },
    }]);
    scene.add(
        Primitive::Sphere,
        Affine3A::from_scale(Vec3::splat(1.8)),
        Material::Null,
        None,
    );
    scene.between(MediumInterface {
        interior: Some(MediumId(0)),
        exterior: None,
    });
    scene.light(sky());
    scene.build()
}

/// The picture's side doubles; a sample each.
fn of_pixels() {
    let threads = rayon::current_num_threads();
    println!(
        "\n{:<24}{:>10} {:>12} {:>12} {:>12} {:>12}",
        "pixels", "count", "us/sample", "film", "bytes/pixel", "to show (ms)"
    );
    let scene = under_a_sky(mesh(23));
    for (width, height) in [(480, 270), (960, 540), (1920, 1080), (3840, 2160), (7680, 4320)] {
        let view = View {
            width,
            height,
            ..seen(2)
        };
        let before = memory("VmRSS");
        let begin = Instant::now();
        let film = render(&scene, &view, 1);
        let seconds = begin.elapsed().as_secs_f64();
        let held = difference(memory("VmRSS"), before);
        let begin = Instant::now();
        std::hint::black_box(film.radiance());
        let shown = begin.elapsed().as_secs_f64();
        let pixels = f64::from(width) * f64::from(height);
        println!(
            "{:<24}{pixels:>10} {:>12.3} {:>12} {:>12} {:>12.1}",
            format!("{width} x {height}"),
            1e6 * seconds * threads as f64 / pixels,
            megabytes(held),
            each(held, pixels),
            1e3 * shown,
        );
        std::mem::forget(film);
    }
}

fn of_threads() {
    println!(
        "\n{:<24}{:>10} {:>12} {:>12}",
        "threads", "count", "us/sample", "speedup"
    );
    for rings in [23, 708] {
        let scene = under_a_sky(mesh(rings));
        let mut one = None;
        for threads in [1, 2, 4, 8, 16, 32]
            .into_iter()
            .filter(|&threads| threads <= rayon::current_num_threads())
        {
            let microseconds = microseconds_per_sample(&scene, threads);
            let speedup = *one.get_or_insert(microseconds) / microseconds;
            println!(
                "{:<24}{threads:>10} {microseconds:>12.3} {speedup:>12.2}",
                format!("{} triangles", 2 * rings * (rings - 1))
            );
        }
    }
}

fn headings(of: &str) {
    println!(
        "\n{of:<24}{:>10} {:>12} {:>12} {:>12} {:>12} {:>12}",
        "count", "build (s)", "us/sample", "held", "each (B)", "peak"
    );
}

/// Builds a scene of `count` things and renders it.
fn row(what: &str, count: u32, build: impl FnOnce() -> RenderScene) {
    let before = memory("VmRSS");
    forget_peak();
    let begin = Instant::now();
    let scene = build();
    let seconds = begin.elapsed().as_secs_f64();
    let held = difference(memory("VmRSS"), before);
    let peak = difference(memory("VmHWM"), before);
    println!(
        "{what:<24}{count:>10} {seconds:>12.3} {:>12.3} {:>12} {:>12} {:>12}",
        microseconds_per_sample(&scene, 1),
        megabytes(held),
        each(held, f64::from(count)),
        megabytes(peak),
    );
    // Freed memory would be used again, and what the next scene holds would not show.
    std::mem::forget(scene);
}

/// Of wall time.
fn microseconds_per_sample(scene: &RenderScene, threads: usize) -> f64 {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .expect("a pool of threads");
    let view = View {
        width: RESOLUTION,
        height: RESOLUTION,
        ..seen(3)
    };
    let seconds = (0..=REPEATS).map(|round| {
        // The first round warms the caches up.
        let samples = if round == 0 { 1 } else { SAMPLES };
        let begin = Instant::now();
        pool.install(|| render(scene, &view, samples));
        begin.elapsed().as_secs_f64() / f64::from(samples * RESOLUTION * RESOLUTION)
    });
    1e6 * seconds.fold(f64::INFINITY, f64::min)
}

fn render(scene: &RenderScene, view: &View, samples: u32) -> Film {
    let mut film = Film::new(view.width, view.height);
    let never = AtomicBool::new(false);
    // Few enough at a time that finished tiles take no memory to speak of.
    for tiles in tiles(view.width, view.height).chunks(256) {
        let finished: Vec<_> = tiles
            .par_iter()
            .filter_map(|&tile| render_tile(scene, view, tile, 0..samples, &never))
            .collect();
        for tile in &finished {
            film.add(tile);
        }
    }
    film
}

fn seen(max_depth: u32) -> View {
    let mut view = view(
        camera(Vec3::new(0.0, 2.8, 2.2), Vec3::ZERO, 40.0),
        RESOLUTION,
        max_depth,
        Strategy::Mis,
    );
    let settings = view.integrator.settings_mut();
    settings.media = true;
    view
}

fn grey() -> Bsdf {
    let reflectance = Rgb::splat(0.5);
    Bsdf::Diffuse(Diffuse { reflectance })
}

fn sky() -> LightSource {
    LightSource::Constant { radiance: Rgb::ONE }
}

fn under_a_sky(shape: Primitive) -> RenderScene {
    let mut scene = SceneBuilder::default();
    scene.add(shape, Affine3A::IDENTITY, grey(), None);
    scene.light(sky());
    scene.build()
}

/// A square of side 4 below all else, and a ball.
fn floor() -> SceneBuilder {
    let mut scene = SceneBuilder::default();
    let flat = Quat::from_rotation_x(-std::f32::consts::FRAC_PI_2);
    let to_world = Affine3A::from_scale_rotation_translation(Vec3::splat(2.0), flat, Vec3::NEG_Y);
    scene.add(Primitive::Rectangle, to_world, grey(), None);
    let to_world = Affine3A::from_scale_rotation_translation(Vec3::splat(0.4), Quat::IDENTITY, Vec3::NEG_Y * 0.6);
    scene.add(Primitive::Sphere, to_world, grey(), None);
    scene
}

fn mesh(rings: u32) -> Primitive {
    let mesh = wavy_sphere(rings).with_vertex_normals();
    Primitive::Mesh(Arc::new(Blas::build(Arc::new(mesh), SplitMethod::Sah)))
}

/// Where the `index`-th of `count` balls of radius 1 lies in a flat square of side 2 at `height`, turned any way.
/// However many there are, seen from above they cover the same part of it, so that as many rays meet them.
fn spread(index: u32, count: u32, height: f32) -> Affine3A {
    let side = (count as f32).sqrt().ceil();
    let [x, z, ..] = random(index, 2).map(|at| 0.3 * at);
    let [a, b, c, _] = random(index, 3).map(|turn| turn * std::f32::consts::TAU);
    let (column, line) = (index % side as u32, index / side as u32);
    let at = |cell: u32, off: f32| 2.0 * (cell as f32 + 0.35 + off) / side - 1.0;
    let turned = Quat::from_euler(EulerRot::XYZ, a, b, c);
    Affine3A::from_scale_rotation_translation(
        Vec3::splat(0.7 / side),
        turned,
        Vec3::new(at(column, x), height, at(line, z)),
    )
}

/// One of `count` above the floor, turned any way.
fn small_triangle(index: u32, count: u32) -> [Vec3; 3] {
    let [x, y, z, _] = random(index, 4);
    let [u, v, ..] = random(index, 5);
    let normal = warp::uniform_sphere([u, v]);
    let (s, t) = normal.any_orthonormal_pair();
    let center = Vec3::new(2.0 * x - 1.0, y, 2.0 * z - 1.0);
    let size = 0.3 / (count as f32).sqrt();
    [center + size * s, center + size * t, center - size * (s + t)]
}

/// Four uniform numbers of draw `index`.
fn random(index: u32, stream: u32) -> [f32; 4] {
    pcg4d([index, stream, 11, 12]).map(unit_float)
}

/// Of this process in bytes: `VmRSS` what it holds, `VmHWM` the most it held. None where the system does not tell.
fn memory(what: &str) -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with(what))?;
    Some(1024.0 * line.split_ascii_whitespace().nth(1)?.parse::<f64>().ok()?)
}

/// The most held begins anew, where the system allows that.
fn forget_peak() {
    let _ = std::fs::write("/proc/self/clear_refs", "5");
}

fn difference(now: Option<f64>, before: Option<f64>) -> Option<f64> {
    Some(now? - before?)
}

/// Less than this is what the memory's manager has at hand anyway.
const LEAST: f64 = 1e6;

fn megabytes(bytes: Option<f64>) -> String {
    match bytes {
        None => "unknown".to_owned(),
        Some(bytes) if bytes < LEAST => "< 1 MB".to_owned(),
        Some(bytes) => format!("{:.0} MB", bytes / 1e6),
    }
}

/// A share of `bytes`, where there is enough of them.
fn each(bytes: Option<f64>, count: f64) -> String {
    let enough = bytes.filter(|&bytes| bytes >= 10.0 * LEAST);
    enough.map_or("-".to_owned(), |bytes| format!("{:.0}", bytes / count))
}
