//! One thread's ray queries, and builds, beside the best that the crate obvhs does with the same rays in the same
//! process.
//!
//! `cargo bench --bench rays -- [--rounds N] [--mine] [MESH [RAYS...]]` takes a mesh and files of rays (see `sunroom
//! bench rays`). Without files the rays are made here: those of a pinhole camera, and cosine-distributed ones that
//! leave random hits of those. Without a mesh it takes a generated one and the shared models. `--mine` leaves obvhs
//! out. Rates are in 10^6 rays per second of the thread's own time, medians over rounds in which all take turns, every
//! second time backwards. Ratios are medians of those within a round, to the fastest layout. Rays that go together are
//! in lanes beforehand, where those of renders are; each one of obvhs is made of ours when its turn comes.

extern crate sunroom_core as sunroom;

#[path = "../tests/core/accel_support/random.rs"]
mod random;
#[path = "../tests/core/accel_support/wavy_sphere.rs"]
mod wavy_sphere;

use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::{Affine3A, Vec3};
use obvhs::BvhBuildParams;
use obvhs::bvh2::{Bvh2, builder::build_bvh2_from_tris};
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris};
use obvhs::ray::RayHit;
use obvhs::rt_triangle::RtTriangle;
use obvhs::triangle::Triangle;
use random::Random;
use sunroom::accel::{Blas, Instance, Primitive, RayLanes, SplitMethod, Tlas};
use sunroom::geometry::{mesh::MeshData, obj::load_obj, ply::load_ply};
use sunroom::math::Ray;
use sunroom::math::lanes::LANES;
use wavy_sphere::wavy_sphere;

type Failure = Box<dyn std::error::Error>;

/// Of a generated set, whose pinhole pictures are square.
const PICTURE: usize = 512;

/// Rays one by one, and the same in lanes, where renders have theirs.
struct RaySet {
    name: String,
    alone: Vec<Ray>,
    together: Vec<RayLanes>,
}

impl RaySet {
    fn new(name: &str, rays: Vec<Ray>) -> Self {
        Self {
            name: name.to_owned(),
            together: rays.chunks(LANES).map(RayLanes::of).collect(),
            alone: rays,
        }
    }
}

/// What traces rays: closest hits and any hits, each over a whole set.
trait Tracer {
    fn closest(&self, rays: &RaySet) -> usize;
    fn any(&self, rays: &RaySet) -> usize;
}

impl Tracer for Blas {
    fn closest(&self, rays: &RaySet) -> usize {
        let rays = rays.alone.iter();
        rays.filter(|ray| black_box(self.intersect(black_box(ray))).is_some())
            .count()
    }

    fn any(&self, rays: &RaySet) -> usize {
        let rays = rays.alone.iter();
        rays.filter(|ray| self.occluded(black_box(ray))).count()
    }
}

/// A scene of the mesh alone, whose rays go sixteen at a time.
struct Together(Tlas);

impl Together {
    fn of(blas: &Blas) -> Result<Self, Failure> {
        let mesh = Primitive::Mesh(Arc::new(blas.clone()));
        let instance = Instance::new(mesh, Affine3A::IDENTITY).ok_or("not a place")?;
        Ok(Self(Tlas::build(vec![instance], SplitMethod::Sah)))
    }
}

impl Tracer for Together {
    fn closest(&self, rays: &RaySet) -> usize {
        let hits = |rays| self.0.intersect_lanes(black_box(rays), u32::MAX);
        rays.together
            .iter()
            .map(|rays| hits(rays).iter().flatten().count())
            .sum()
    }

    fn any(&self, rays: &RaySet) -> usize {
        let hits = |rays| self.0.occluded_lanes(black_box(rays), u32::MAX);
        rays.together.iter().map(|rays| hits(rays).count_ones() as usize).sum()
    }
}

/// A hierarchy of obvhs with its triangles in the order of the leaves.
struct Peer<Hierarchy> {
    hierarchy: Hierarchy,
    triangles: Vec<RtTriangle>,
}

fn peer_ray(ray: &Ray) -> obvhs::ray::Ray {
    let vector = |v: Vec3| v.to_array().into();
    obvhs::ray::Ray::new(vector(ray.origin), vector(ray.dir), 0.0, ray.t_max)
}

macro_rules! trace_with {
    ($hierarchy:ty) => {
        impl Tracer for Peer<$hierarchy> {
            fn closest(&self, rays: &RaySet) -> usize {
                let hit = |ray: &&Ray| {
                    let mut hit = RayHit::none();
                    self.hierarchy
                        .ray_traverse(peer_ray(black_box(ray)), &mut hit, |ray, id| {
                            self.triangles[id].intersect(ray)
                        });
                    black_box(&hit).t < f32::INFINITY
                };
                rays.alone.iter().filter(hit).count()
            }

            fn any(&self, rays: &RaySet) -> usize {
                let hit = |ray: &&Ray| {
                    !self
                        .hierarchy
                        .ray_traverse_miss(peer_ray(black_box(ray)), |ray, id| {
                            self.triangles[id].intersect(ray)
                        })
                };
                rays.alone.iter().filter(hit).count()
            }
        }
    };
}

trace_with!(Bvh2);
trace_with!(CwBvh);

/// Every layout of obvhs that may be its best.
fn peers(triangles: &[Triangle]) -> Vec<(String, Box<dyn Tracer>)> {
    let in_order = |order: &[u32]| order.iter().map(|&id| (&triangles[id as usize]).into()).collect();
    let mut peers: Vec<(String, Box<dyn Tracer>)> = Vec::new();
    let builds = [
        ("fast", BvhBuildParams::fast_build()),
        ("medium", BvhBuildParams::medium_build()),
        ("slow", BvhBuildParams::slow_build()),
        ("very slow", BvhBuildParams::very_slow_build()),
    ];
    for (name, build) in builds {
        let hierarchy = build_bvh2_from_tris(triangles, build, &mut Duration::default());
        let triangles_in_order = in_order(&hierarchy.primitive_indices);
        peers.push((
            format!("bvh2 {name}"),
            Box::new(Peer {
                hierarchy,
                triangles: triangles_in_order,
            }),
        ));
        let hierarchy = build_cwbvh_from_tris(triangles, build, &mut Duration::default());
        let triangles_in_order = in_order(&hierarchy.primitive_indices);
        peers.push((
            format!("cwbvh {name}"),
            Box::new(Peer {
                hierarchy,
                triangles: triangles_in_order,
            }),
        ));
    }
    peers
}

fn main() -> Result<(), Failure> {
    let (mut rounds, mut with_peers, mut files) = (5, true, Vec::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--rounds" => rounds = arguments.next().ok_or("--rounds wants a number")?.parse()?,
            "--mine" => with_peers = false,
            // Cargo's own.
            "--bench" => {}
            _ => files.push(PathBuf::from(argument)),
        }
    }
    if rounds == 0 {
        return Err("--rounds wants at least 1".into());
    }
    let settings = Settings { rounds, with_peers };
    if let Some((mesh, files)) = files.split_first() {
        let sets = files.iter().map(|file| Ok(RaySet::new(&name(file), read_rays(file)?)));
        return settings.compare(&name(mesh), load(mesh)?, sets.collect::<Result<_, Failure>>()?);
    }
    let mut random = Random::new(1);
    let incoherent = (0..1 << 16).map(|_| Ray::new(1.5 * random.in_cube(), random.direction()));
    settings.compare(
        "wavy sphere",
        wavy_sphere(200),
        vec![RaySet::new("random", incoherent.collect())],
    )?;
    let shared = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let mut of_bunny = Vec::new();
    for set in ["primary", "bounce"] {
        let file = shared.join(format!("rays/rays_bunny_{set}_262144.bin"));
        if file.exists() {
            of_bunny.push(RaySet::new(set, read_rays(&file)?));
        }
    }
    for (mesh, sets) in [("models/bunny.obj", of_bunny), ("models/dragon.ply", Vec::new())] {
        let mesh = shared.join(mesh);
        if mesh.exists() {
            settings.compare(&name(&mesh), load(&mesh)?, sets)?;
        } else {
            println!("{} is not there", mesh.display());
        }
    }
    Ok(())
}

fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

struct Settings {
    rounds: usize,
    with_peers: bool,
}

impl Settings {
    /// Without `sets` they are made.
    fn compare(&self, name: &str, mesh: MeshData, sets: Vec<RaySet>) -> Result<(), Failure> {
        let mesh = Arc::new(mesh);
        let triangles: Vec<Triangle> = (0..mesh.triangles.len())
            .map(|index| {
                let [v0, v1, v2] = mesh.corners(index).map(|corner| corner.to_array().into());
                Triangle { v0, v1, v2 }
            })
            .collect();
        let blas = self.compare_builds(name, &mesh, &triangles);
        let peers = if self.with_peers { peers(&triangles) } else { Vec::new() };
        let together = Together::of(&blas)?;
        let own: [&dyn Tracer; 2] = [&blas, &together];
        let sets = if sets.is_empty() {
            let primary = pinhole(&mesh);
            let bounce = bounces(&blas, &primary);
            vec![RaySet::new("primary", primary), RaySet::new("bounce", bounce)]
        } else {
            sets
        };
        for set in &sets {
            self.compare_rates("closest", own, &peers, set, |tracer, rays| tracer.closest(rays));
            self.compare_rates("any", own, &peers, set, |tracer, rays| tracer.any(rays));
        }
        Ok(())
    }

    fn compare_builds(&self, name: &str, mesh: &Arc<MeshData>, triangles: &[Triangle]) -> Blas {
        let (mut own, mut peer) = (Vec::new(), Vec::new());
        let seconds = |build: &dyn Fn()| {
            let begin = Instant::now();
            build();
            begin.elapsed().as_secs_f64()
        };
        for _ in 0..self.rounds {
            own.push(seconds(&|| {
                black_box(Blas::build(mesh.clone(), SplitMethod::Sah));
            }));
            if self.with_peers {
                peer.push(seconds(&|| {
                    let fast = BvhBuildParams::fast_build();
                    black_box(build_bvh2_from_tris(triangles, fast, &mut Duration::default()));
                }));
            }
        }
        let blas = Blas::build(mesh.clone(), SplitMethod::Sah);
        println!(
            "{name}: built in {:.4} s (all threads), {:.1} bytes per triangle, SAH cost {:.2}; obvhs bvh2 fast {:.4} s",
            median(own),
            blas.stats().bytes as f64 / mesh.triangles.len() as f64,
            blas.stats().sah_cost,
            median(peer),
        );
        blas
    }

    fn compare_rates(
        &self,
        what: &str,
        own: [&dyn Tracer; 2],
        peers: &[(String, Box<dyn Tracer>)],
        rays: &RaySet,
        query: fn(&dyn Tracer, &RaySet) -> usize,
    ) {
        let tracers: Vec<&dyn Tracer> = own.into_iter().chain(peers.iter().map(|peer| &*peer.1)).collect();
        let mut rates = vec![Vec::new(); tracers.len()];
        for round in 0..self.rounds {
            let mut turns: Vec<usize> = (0..tracers.len()).collect();
            if round % 2 == 1 {
                turns.reverse();
            }
            for turn in turns {
                rates[turn].push(rate(tracers[turn], rays, query));
            }
        }
        let (of_own, of_peers) = rates.split_at(own.len());
        let [alone, together] = [0, 1].map(|which| median(of_own[which].clone()));
        let hits = 100.0 * query(own[0], rays) as f64 / rays.alone.len() as f64;
        let set = &rays.name;
        print!("  {set} {what}: {alone:.2} Mrays/s alone, {together:.2} sixteen together ({hits:.1} % hit)");
        let best = peers
            .iter()
            .zip(of_peers)
            .map(|((layout, _), rates)| (median(rates.clone()), layout, rates))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        let Some((best, layout, best_rates)) = best else {
            return println!();
        };
        let [alone, together] = [0, 1].map(|which| {
            let pairs = of_own[which].iter().zip(best_rates);
            median(pairs.map(|(own, best)| own / best).collect())
        });
        println!(", obvhs {best:.2} ({layout}), ratios {alone:.2} and {together:.2}");
    }
}

/// Seconds for each measurement: the system may count a thread's time in steps of some milliseconds.
const MEASURED: f64 = 0.25;

/// In 10^6 rays per second of this thread.
fn rate(tracer: &dyn Tracer, rays: &RaySet, query: fn(&dyn Tracer, &RaySet) -> usize) -> f64 {
    let begin = thread_seconds();
    let mut traced = 0;
    loop {
        black_box(query(tracer, rays));
        traced += rays.alone.len();
        let seconds = thread_seconds() - begin;
        if seconds > MEASURED {
            return traced as f64 / seconds / 1e6;
        }
    }
}

/// What this thread has had of a processor; the time of day where the system does not say.
fn thread_seconds() -> f64 {
    let of_thread = std::fs::read_to_string("/proc/thread-self/schedstat")
        .ok()
        .and_then(|text| text.split(' ').next()?.parse::<f64>().ok());
    of_thread.map_or_else(
        || {
            std::time::SystemTime::UNIX_EPOCH
                .elapsed()
                .unwrap_or_default()
                .as_secs_f64()
        },
        |nanoseconds| nanoseconds * 1e-9,
    )
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}

fn load(path: &Path) -> Result<MeshData, Failure> {
    let bytes = std::fs::read(path)?;
    let loaded = if path.extension().is_some_and(|extension| extension == "obj") {
        load_obj(&bytes, &mut |_| Err(std::io::ErrorKind::NotFound.into()))?
    } else {
        load_ply(&bytes)?
    };
    Ok(loaded.mesh)
}

fn read_rays(path: &Path) -> Result<Vec<Ray>, Failure> {
    let bytes = std::fs::read(path)?;
    let records = bytes
        .strip_prefix(b"RAYS")
        .and_then(|rest| rest.get(12..))
        .ok_or("not a file of rays")?;
    let vector = |record: &[[u8; 4]]| Vec3::new(number(record[0]), number(record[1]), number(record[2]));
    let number_ray = |record: &[[u8; 4]; 8]| Ray::new(vector(&record[..3]), vector(&record[3..6]));
    Ok(records
        .as_chunks::<4>()
        .0
        .as_chunks::<8>()
        .0
        .iter()
        .map(number_ray)
        .collect())
}

fn number(bytes: [u8; 4]) -> f32 {
    f32::from_le_bytes(bytes)
}

/// Row by row, looking at the middle of the mesh from a little above, from as far as its box is long.
fn pinhole(mesh: &MeshData) -> Vec<Ray> {
    let bounds = mesh.bounds();
    let back = Vec3::new(0.27, 0.32, 0.91).normalize();
    let origin = bounds.center() + bounds.extent().length() * back;
    let (right, up) = (
        Vec3::Y.cross(back).normalize(),
        back.cross(Vec3::Y.cross(back)).normalize(),
    );
    let across = |pixel: usize| ((pixel as f32 + 0.5) / PICTURE as f32 - 0.5) * 0.83;
    (0..PICTURE * PICTURE)
        .map(|pixel| {
            let (x, y) = (across(pixel % PICTURE), across(pixel / PICTURE));
            Ray::new(origin, (x * right - y * up - back).normalize())
        })
        .collect()
}

/// As many rays in no order, which leave random hits of `primary` on the side they came from.
fn bounces(blas: &Blas, primary: &[Ray]) -> Vec<Ray> {
    let hits: Vec<(Vec3, Vec3)> = primary
        .iter()
        .filter_map(|ray| {
            let hit = blas.intersect(ray)?;
            let [a, b, c] = blas.mesh().corners(hit.triangle as usize);
            let normal = (b - a).cross(c - a).normalize();
            let normal = if normal.dot(ray.dir) > 0.0 { -normal } else { normal };
            let point = a + hit.u * (b - a) + hit.v * (c - a);
            Some((point + 1e-6 * blas.bounds().extent().length() * normal, normal))
        })
        .collect();
    let mut random = Random::new(1);
    if hits.is_empty() {
        return Vec::new();
    }
    (0..primary.len())
        .map(|_| {
            let (point, normal) = hits[random.next_u32() as usize % hits.len()];
            // The sum of a unit normal and a point on the unit sphere is distributed as the cosine.
            Ray::new(point, (normal + 0.9999 * random.direction()).normalize())
        })
        .collect()
}
