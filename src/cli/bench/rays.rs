//! Measures rays against one mesh: the rates with one and with all threads, the build, the memory, and whether every
//! answer is right. Rays are traced singly, and in packets of sixteen as in renders after the first bounce, converted
//! to lanes beforehand.
//!
//! A file of rays is little endian: "RAYS", then three u32 (version 1, number of rays, bytes of a record, 32), then of
//! each ray its origin and unit direction (three f32 each), the distance of the nearest hit (f32, infinite for none)
//! and the triangle's index (u32, all ones for none).

use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::{Affine3A, Vec3};
use sunroom::accel::{Blas, Instance, Primitive, RayLanes, SplitMethod, Tlas};
use sunroom::files::{self, LARGEST_DATA};
use sunroom::geometry::mesh::MeshData;
use sunroom::geometry::{obj::load_obj, ply::load_ply};
use sunroom::math::Ray;
use sunroom::math::lanes::LANES;

use super::args::RayBenchArgs;
use super::compare;
use super::results::{Error, Rate, RayResult, Results, median};

/// The largest relative difference of equal distances: another program rounds in another order.
const SAME_DISTANCE: f32 = 1e-4;
/// Shorter measurements are repeated.
const SHORTEST: Duration = Duration::from_millis(300);

const HEADER_BYTES: usize = 16;
const RECORD_BYTES: usize = 32;

#[derive(Clone, Copy, Debug, PartialEq)]
struct Answered {
    ray: Ray,
    /// Infinite for a miss.
    t: f32,
    triangle: u32,
}

/// The mesh's BVH, and the scene with only this mesh.
struct Target {
    blas: Arc<Blas>,
    scene: Tlas,
}

/// The mesh and the sets of rays that will be measured.
pub struct Plan<'a> {
    args: &'a RayBenchArgs,
    mesh: Arc<MeshData>,
    sets: Vec<(String, Vec<Answered>)>,
}

impl<'a> Plan<'a> {
    /// An error if a file is missing or broken.
    pub fn new(args: &'a RayBenchArgs) -> Result<Self, Error> {
        let mesh = Arc::new(load_mesh(&args.mesh)?);
        let sets = args.rays.iter().map(|path| Ok((name_of(path), read(path)?)));
        let sets = sets.collect::<Result<_, Error>>()?;
        Ok(Self { args, mesh, sets })
    }

    /// The mesh and the files of rays.
    pub fn files(&self) -> Vec<PathBuf> {
        self.args.rays.iter().chain([&self.args.mesh]).cloned().collect()
    }

    pub fn subjects(&self) -> Vec<compare::Subject> {
        let sets = self.sets.iter();
        sets.map(|(name, set)| compare::Subject::Rays {
            mesh: name_of(&self.args.mesh),
            rays: name.clone(),
            count: set.len(),
        })
        .collect()
    }

    pub fn measure(&self) -> Result<Results, Error> {
        let Self { args, mesh, sets } = self;
        let threads = sunroom::app::threads::worker_count(args.common.threads.threads, false).get();
        let mut builds = Vec::new();
        let mut built = None;
        for _ in 0..args.common.rounds {
            let begin = Instant::now();
            built = Some(Blas::build(mesh.clone(), SplitMethod::Sah));
            builds.push(begin.elapsed().as_secs_f64());
        }
        let Some(built) = built else {
            return Err("there is nothing to measure in no rounds".into());
        };
        let target = Target::new(built);
        let mut results = Results::new(threads, args.common.rounds);
        for (name, set) in sets {
            let (wrong, ties) = check(&target, set);
            let Target { blas, scene } = &target;
            let rays: Vec<Ray> = set.iter().map(|answered| answered.ray).collect();
            let together: Vec<RayLanes> = rays.chunks(LANES).map(RayLanes::of).collect();
            let clock = Clock {
                rounds: args.common.rounds,
                threads,
                rays: rays.len(),
            };
            results.rays.push(RayResult {
                mesh: name_of(&args.mesh),
                rays: name.clone(),
                triangles: mesh.triangles.len(),
                count: rays.len(),
                build_seconds: median(builds.iter().copied()),
                bytes_per_triangle: blas.stats().bytes as f64 / mesh.triangles.len().max(1) as f64,
                closest: clock.rate(&rays, |ray| usize::from(black_box(blas.intersect(ray)).is_some())),
                any: clock.rate(&rays, |ray| usize::from(blas.occluded(ray))),
                closest_together: Some(clock.rate(&together, |rays| {
                    let hits = scene.intersect_lanes(rays, u32::MAX);
                    hits.iter().flatten().count()
                })),
                any_together: Some(clock.rate(&together, |rays| {
                    scene.occluded_lanes(rays, u32::MAX).count_ones() as usize
                })),
                wrong,
                ties,
            });
        }
        Ok(results)
    }
}

impl Target {
    fn new(blas: Blas) -> Self {
        let blas = Arc::new(blas);
        let placed = Instance::new(Primitive::Mesh(blas.clone()), Affine3A::IDENTITY);
        let scene = Tlas::build(placed.into_iter().collect(), SplitMethod::Sah);
        Self { blas, scene }
    }
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

fn load_mesh(path: &Path) -> Result<MeshData, Error> {
    let place = path.display();
    let bytes = files::read(path, LARGEST_DATA).map_err(|error| format!("{place}: {error}"))?;
    let extension = path.extension().unwrap_or_default().to_ascii_lowercase();
    let loaded = match extension.to_str() {
        // Materials are not used here.
        Some("obj") => load_obj(&bytes, &mut |_| Err(std::io::ErrorKind::NotFound.into())),
        Some("ply") => load_ply(&bytes),
        _ => return Err(format!("{place}: expected an .obj or a .ply file").into()),
    };
    Ok(loaded.map_err(|error| format!("{place}: {error}"))?.mesh)
}

fn read(path: &Path) -> Result<Vec<Answered>, Error> {
    let bytes = files::read(path, LARGEST_DATA).map_err(|error| format!("{}: {error}", path.display()))?;
    parse(&bytes).map_err(|error| format!("{}: {error}", path.display()).into())
}

fn parse(bytes: &[u8]) -> Result<Vec<Answered>, String> {
    let (header, records) = bytes
        .split_at_checked(HEADER_BYTES)
        .ok_or("expected a header of 16 bytes, the file is shorter")?;
    let word = |bytes: &[u8], place: usize| {
        let word = bytes[4 * place..4 * place + 4].try_into();
        u32::from_le_bytes(word.unwrap_or_default())
    };
    if &header[..4] != b"RAYS" {
        return Err("byte 0: expected `RAYS`".to_owned());
    }
    let (version, count, size) = (word(header, 1), word(header, 2), word(header, 3));
    if (version, size as usize) != (1, RECORD_BYTES) {
        return Err(format!(
            "byte 4: expected version 1 with records of {RECORD_BYTES} bytes, found version {version} with {size}"
        ));
    }
    let (records, rest) = records.as_chunks::<RECORD_BYTES>();
    if records.len() != count as usize || !rest.is_empty() {
        let found = records.len();
        return Err(format!(
            "byte 8: {count} rays are promised, the file has {found} and {} bytes",
            rest.len()
        ));
    }
    if records.is_empty() {
        return Err("byte 8: expected rays, the file has none".to_owned());
    }
    let float = |record: &[u8], place: usize| f32::from_bits(word(record, place));
    let vector = |record: &[u8], place: usize| Vec3::from_array([0, 1, 2].map(|k| float(record, place + k)));
    let answered = records.iter().map(|record| Answered {
        ray: Ray::new(vector(record, 0), vector(record, 3)),
        t: float(record, 6),
        triangle: word(record, 7),
    });
    Ok(answered.collect())
}

/// The number of wrong answers, of single rays or packets, and of answers with a neighbour at the same distance.
fn check(target: &Target, set: &[Answered]) -> (usize, usize) {
    let (mut wrong, mut ties) = (0, 0);
    for chunk in set.chunks(LANES) {
        let rays: Vec<Ray> = chunk.iter().map(|answered| answered.ray).collect();
        let lanes = RayLanes::of(&rays);
        let hits = target.scene.intersect_lanes(&lanes, u32::MAX);
        let occluded = target.scene.occluded_lanes(&lanes, u32::MAX);
        for (lane, answered) in chunk.iter().enumerate() {
            let ray = &answered.ray;
            let alone = target.blas.intersect(ray).map(|hit| (hit.t, hit.triangle));
            let together = hits[lane].map(|hit| (hit.t, hit.primitive));
            let alone = answered.verdict(alone, target.blas.occluded(ray));
            let together = answered.verdict(together, occluded >> lane & 1 == 1);
            match alone.max(together) {
                Verdict::Right => {}
                Verdict::Tie => ties += 1,
                Verdict::Wrong => wrong += 1,
            }
        }
    }
    (wrong, ties)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Verdict {
    Right,
    /// The answer names another triangle at the same distance.
    Tie,
    Wrong,
}

impl Answered {
    /// Compares a found distance and triangle, and the result of the occlusion test, with the file.
    fn verdict(&self, found: Option<(f32, u32)>, occluded: bool) -> Verdict {
        let (t, triangle) = found.unwrap_or((f32::INFINITY, u32::MAX));
        let apart = (t - self.t).abs();
        let is_same_distance = t == self.t || (apart.is_finite() && apart <= SAME_DISTANCE * self.t.abs());
        if !is_same_distance || occluded != found.is_some() {
            Verdict::Wrong
        } else if triangle != self.triangle {
            Verdict::Tie
        } else {
            Verdict::Right
        }
    }
}

/// The rounds and threads of a measurement, and the number of its rays.
struct Clock {
    rounds: u32,
    threads: usize,
    rays: usize,
}

impl Clock {
    /// Measures a query over all `items`, which are rays or packets of rays.
    fn rate<T: Sync>(&self, items: &[T], query: impl Fn(&T) -> usize + Sync) -> Rate {
        let rays_per_item = self.rays as f64 / items.len() as f64;
        let rate =
            |threads: usize| rays_per_item * median((0..self.rounds).map(|_| items_rate(items, &query, threads)));
        Rate {
            one_thread: rate(1),
            all_threads: rate(self.threads),
        }
    }
}

/// The rate in 10^6 items a second. Items are divided evenly, and each thread repeats its own until enough time has
/// passed.
fn items_rate<T: Sync>(items: &[T], query: &(impl Fn(&T) -> usize + Sync), threads: usize) -> f64 {
    let share = items.len().div_ceil(threads);
    std::thread::scope(|scope| {
        let workers: Vec<_> = items
            .chunks(share)
            .map(|items| {
                scope.spawn(move || {
                    let begin = Instant::now();
                    let mut done = 0usize;
                    while begin.elapsed() < SHORTEST {
                        black_box(items.iter().map(|item| query(black_box(item))).sum::<usize>());
                        done += items.len();
                    }
                    done as f64 / begin.elapsed().as_secs_f64()
                })
            })
            .collect();
        let rates = workers.into_iter().map(|worker| worker.join().unwrap_or(f64::NAN));
        rates.sum::<f64>() / 1e6
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(version: u32, count: u32, records: &[[f32; 8]]) -> Vec<u8> {
        let mut bytes = b"RAYS".to_vec();
        for word in [version, count, 32] {
            bytes.extend(word.to_le_bytes());
        }
        for number in records.as_flattened() {
            bytes.extend(number.to_le_bytes());
        }
        bytes
    }

    #[test]
    fn files_of_rays_are_read_and_broken_ones_refused() {
        let record = [1.0, 2.0, 3.0, 0.0, 0.0, -1.0, 5.0, f32::from_bits(7)];
        let rays = parse(&file(1, 1, &[record])).expect("one ray");
        let ray = Ray::new(Vec3::new(1.0, 2.0, 3.0), -Vec3::Z);
        assert_eq!(
            rays,
            [Answered {
                ray,
                t: 5.0,
                triangle: 7
            }]
        );
        for (broken, place) in [
            (b"RAYS".to_vec(), "header"),
            (b"RAISE and shine!".to_vec(), "byte 0"),
            (file(2, 1, &[record]), "byte 4"),
            (file(1, 2, &[record]), "byte 8"),
            (file(1, 0, &[]), "has none"),
        ] {
            let error = parse(&broken).expect_err("broken");
            assert!(error.contains(place), "{error}");
        }
    }

    #[test]
    fn wrong_answers_are_counted() {
        let mesh = load_obj(b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", &mut |_| {
            Err(std::io::ErrorKind::NotFound.into())
        });
        let blas = Blas::build(Arc::new(mesh.expect("a triangle").mesh), SplitMethod::Sah);
        let down = Ray::new(Vec3::new(0.2, 0.2, 3.0), -Vec3::Z);
        let answered = |t: f32, triangle: u32| Answered { ray: down, t, triangle };
        let set = [
            answered(3.0, 0),
            answered(3.0, 4),
            answered(2.0, 0),
            answered(f32::INFINITY, u32::MAX),
        ];
        let target = Target::new(blas);
        assert_eq!(check(&target, &set), (2, 1));
        // The last of them is alone in its packet.
        let mut many = vec![answered(3.0, 0); LANES];
        many.push(answered(2.0, 0));
        assert_eq!(check(&target, &many), (1, 0));
    }

    #[test]
    fn verdicts() {
        let ray = Ray::new(Vec3::ZERO, Vec3::Z);
        let [hit, miss] = [(3.0, 7), (f32::INFINITY, u32::MAX)].map(|(t, triangle)| Answered { ray, t, triangle });
        for (answered, found, occluded, expected) in [
            (hit, Some((3.0001, 7)), true, Verdict::Right),
            (hit, Some((3.0, 8)), true, Verdict::Tie),
            (hit, Some((3.0, 7)), false, Verdict::Wrong),
            (hit, Some((3.001, 7)), true, Verdict::Wrong),
            (hit, None, false, Verdict::Wrong),
            (miss, None, false, Verdict::Right),
            (miss, None, true, Verdict::Wrong),
            (miss, Some((3.0, 7)), true, Verdict::Wrong),
        ] {
            assert_eq!(
                answered.verdict(found, occluded),
                expected,
                "{answered:?} {found:?} {occluded}"
            );
        }
    }
}
