//! Time to read mesh files, beside the crate tobj for OBJ, and beside merely reading the bytes for PLY.
//!
//! `cargo bench --bench loading -- [--rounds N] [--triangles N] [FILE...]` takes OBJ and PLY files; without any,
//! generated ones of about so many triangles and the shared models. Files lie in memory before the clock starts.
//! Shortest times over rounds in which all take turns.

extern crate sunroom_core as sunroom;

#[path = "../tests/core/accel_support/wavy_sphere.rs"]
mod wavy_sphere;

use std::fmt::Write as _;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::Instant;

use glam::Vec3;
use rayon::{ThreadPool, ThreadPoolBuilder};
use sunroom::geometry::mesh::MeshData;
use sunroom::geometry::obj::load_obj;
use sunroom::geometry::ply::load_ply;
use wavy_sphere::wavy_sphere;

type Failure = Box<dyn std::error::Error>;

/// One way to read a file of these bytes; the number of triangles.
type Reader<'a> = Box<dyn Fn(&[u8]) -> Result<usize, Failure> + 'a>;

fn main() -> Result<(), Failure> {
    let (mut rounds, mut triangles, mut files) = (5, 500_000, Vec::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--rounds" => rounds = arguments.next().ok_or("--rounds wants a number")?.parse()?,
            "--triangles" => triangles = arguments.next().ok_or("--triangles wants a number")?.parse()?,
            // Cargo's own.
            "--bench" => {}
            _ => files.push(PathBuf::from(argument)),
        }
    }
    let pools = Pools::new()?;
    if files.is_empty() {
        let mesh = wavy_sphere(f64::from(triangles / 2).sqrt() as u32).with_vertex_normals();
        pools.compare("positions.obj", &obj_text(&mesh, false).into_bytes(), rounds)?;
        pools.compare("everything.obj", &obj_text(&mesh, true).into_bytes(), rounds)?;
        let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data/models");
        files.extend(["bunny.obj", "dragon.ply"].map(|name| models.join(name)));
    }
    for file in files {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        match std::fs::read(&file) {
            Ok(bytes) => pools.compare(&name, &bytes, rounds)?,
            Err(error) => println!("{}: {error}", file.display()),
        }
    }
    Ok(())
}

struct Pools {
    one: ThreadPool,
    all: ThreadPool,
}

impl Pools {
    fn new() -> Result<Self, Failure> {
        Ok(Self {
            one: ThreadPoolBuilder::new().num_threads(1).build()?,
            all: ThreadPoolBuilder::new().build()?,
        })
    }

    fn compare(&self, name: &str, bytes: &[u8], rounds: usize) -> Result<(), Failure> {
        let all = format!("sunroom, {} threads", self.all.current_num_threads());
        let in_pool = |pool: &'static str, read: fn(&[u8]) -> Result<usize, Failure>| -> Reader {
            let pool = if pool == "one" { &self.one } else { &self.all };
            Box::new(move |bytes| {
                pool.install(|| read(bytes).map_err(|error| error.to_string()))
                    .map_err(Into::into)
            })
        };
        let own = if name.ends_with(".ply") { own_ply } else { own_obj };
        let mut readers: Vec<(&str, Reader)> =
            vec![("sunroom, 1 thread", in_pool("one", own)), (&all, in_pool("all", own))];
        if name.ends_with(".ply") {
            readers.push((
                "a copy",
                Box::new(|bytes| {
                    black_box(bytes.to_vec());
                    Ok(0)
                }),
            ));
        } else {
            readers.push(("tobj, one index", Box::new(|bytes| tobj_triangles(bytes, true))));
            readers.push(("tobj, three indices", Box::new(|bytes| tobj_triangles(bytes, false))));
        }
        println!("{name}: {:.1} MB", bytes.len() as f64 / 1e6);
        let mut shortest = vec![(f64::INFINITY, 0); readers.len()];
        for _ in 0..rounds {
            for ((_, read), shortest) in readers.iter().zip(&mut shortest) {
                let begin = Instant::now();
                let triangles = read(bytes)?;
                *shortest = (shortest.0.min(begin.elapsed().as_secs_f64()), triangles);
            }
        }
        for ((reader, _), (seconds, triangles)) in readers.iter().zip(shortest) {
            let rate = bytes.len() as f64 / seconds / 1e6;
            println!(
                "  {reader:20} {:8.2} ms {rate:7.0} MB/s {triangles:9} triangles",
                seconds * 1e3
            );
        }
        Ok(())
    }
}

fn own_obj(bytes: &[u8]) -> Result<usize, Failure> {
    let loaded = load_obj(bytes, &mut |_| Err(std::io::ErrorKind::NotFound.into()))?;
    Ok(black_box(loaded).mesh.triangles.len())
}

fn own_ply(bytes: &[u8]) -> Result<usize, Failure> {
    Ok(black_box(load_ply(bytes)?).mesh.triangles.len())
}

fn tobj_triangles(mut bytes: &[u8], single_index: bool) -> Result<usize, Failure> {
    let options = tobj::LoadOptions {
        single_index,
        triangulate: true,
        ..Default::default()
    };
    let (models, _) = tobj::load_obj_buf(&mut bytes, &options, |_| Ok(Default::default()))?;
    Ok(black_box(models).iter().map(|model| model.mesh.indices.len() / 3).sum())
}

/// With texture coordinates and normals, or with neither.
fn obj_text(mesh: &MeshData, everything: bool) -> String {
    let mut text = String::new();
    let mut line = |keyword: &str, v: Vec3| {
        let _ = writeln!(text, "{keyword} {:.6} {:.6} {:.6}", v.x, v.y, v.z);
    };
    for (&position, &normal) in mesh.positions.iter().zip(&mesh.normals) {
        line("v", position);
        if everything {
            line("vt", 0.5 * position + 0.5);
            line("vn", normal);
        }
    }
    for [a, b, c] in mesh.triangles.iter().map(|triangle| triangle.map(|index| index + 1)) {
        let _ = if everything {
            writeln!(text, "f {a}/{a}/{a} {b}/{b}/{b} {c}/{c}/{c}")
        } else {
            writeln!(text, "f {a} {b} {c}")
        };
    }
    text
}
