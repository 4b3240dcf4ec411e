//! The meshes in `assets/models` are made here: the files must be what these functions give.
//!
//! After a change to a function, `SUNROOM_WRITE_MESHES=1 cargo test --release --test generated_meshes` writes them
//! anew.

use std::f32::consts::TAU;
use std::path::PathBuf;

use glam::Vec3;

struct Mesh {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    triangles: Vec<[u32; 3]>,
}

/// A closed surface over a torus of `n` x `m` parameters; `at` has period 1 in both.
fn closed_grid(n: u32, m: u32, at: impl Fn(f32, f32) -> Vec3) -> Mesh {
    const STEP: f32 = 1e-3;
    let parameters = |i: u32, j: u32| (i as f32 / n as f32, j as f32 / m as f32);
    let (mut positions, mut normals, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for i in 0..n {
        for j in 0..m {
            let (u, v) = parameters(i, j);
            positions.push(at(u, v));
            let along_u = at(u + STEP, v) - at(u - STEP, v);
            let along_v = at(u, v + STEP) - at(u, v - STEP);
            normals.push(along_u.cross(along_v).normalize());
            let index = |i: u32, j: u32| (i % n) * m + j % m;
            let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    Mesh {
        positions,
        normals,
        triangles,
    }
}

/// A (2, 3) torus knot whose tube has ribs, standing on y = 0.
fn knot() -> Mesh {
    let curve = |u: f32| {
        let (twice, thrice) = (2.0 * TAU * u, 3.0 * TAU * u);
        let ring = 0.72 + 0.3 * thrice.cos();
        Vec3::new(ring * twice.cos(), ring * twice.sin(), 0.42 * thrice.sin())
    };
    let mut mesh = closed_grid(960, 60, |u, v| {
        let tangent = (curve(u + 1e-3) - curve(u - 1e-3)).normalize();
        let outward = (curve(u) - Vec3::new(0.0, 0.0, 2.0 * curve(u).z))
            .reject_from(tangent)
            .normalize();
        let (sin, cos) = (TAU * v).sin_cos();
        let radius = 0.16 + 0.012 * (TAU * (48.0 * u + 2.0 * v)).sin();
        curve(u) + radius * (cos * outward + sin * outward.cross(tangent))
    });
    let lowest = mesh.positions.iter().map(|p| p.y).fold(f32::INFINITY, f32::min);
    for p in &mut mesh.positions {
        p.y -= lowest;
    }
    mesh
}

/// Height of the water in the Cornell box at (x, z): a few waves of different directions around y = -0.42.
fn water_height(x: f32, z: f32) -> f32 {
    let wave = |dx: f32, dz: f32, phase: f32| (dx * x + dz * z + phase).sin();
    -0.42
        + 0.034 * wave(5.1, 2.3, 0.4)
        + 0.024 * wave(-3.7, 6.4, 1.9)
        + 0.012 * wave(9.2, -7.1, 0.7)
        + 0.008 * wave(2.9, 13.3, 2.6)
}

/// A block of water with a wavy top; it reaches a little beyond walls at |x| = 1, z = -1 and y = -1, and ends just
/// inside of z = 1.
fn water() -> Mesh {
    const N: u32 = 96;
    const LOW: Vec3 = Vec3::new(-1.01, -1.01, -1.01);
    const HIGH: Vec3 = Vec3::new(1.01, 0.0, 0.995);
    let mut mesh = Mesh {
        positions: Vec::new(),
        normals: Vec::new(),
        triangles: Vec::new(),
    };
    let along = |i: u32, low: f32, high: f32| low + (high - low) * i as f32 / N as f32;
    let xz = |i: u32, j: u32| (along(i, LOW.x, HIGH.x), along(j, LOW.z, HIGH.z));
    let surface = |i: u32, j: u32| {
        let (x, z) = xz(i, j);
        Vec3::new(x, water_height(x, z), z)
    };
    for i in 0..=N {
        for j in 0..=N {
            let (x, z) = xz(i, j);
            let slope = |dx: f32, dz: f32| (water_height(x + dx, z + dz) - water_height(x - dx, z - dz)) / 2e-3;
            mesh.positions.push(surface(i, j));
            mesh.normals
                .push(Vec3::new(-slope(1e-3, 0.0), 1.0, -slope(0.0, 1e-3)).normalize());
        }
    }
    let index = |i: u32, j: u32| i * (N + 1) + j;
    for i in 0..N {
        for j in 0..N {
            let [a, b, c, d] = [index(i, j), index(i, j + 1), index(i + 1, j + 1), index(i + 1, j)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    // The four sides, each a strip from the rim of the top down to the floor, and the floor.
    let mut strip = |normal: Vec3, rim: Vec<Vec3>| {
        let first = mesh.positions.len() as u32;
        for top in &rim {
            mesh.positions.extend([*top, top.with_y(LOW.y)]);
            mesh.normals.extend([normal; 2]);
        }
        for k in 0..rim.len() as u32 - 1 {
            let [a, b, c, d] = [0, 1, 3, 2].map(|corner| first + 2 * k + corner);
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    };
    strip(Vec3::NEG_X, (0..=N).map(|j| surface(0, j)).collect());
    strip(Vec3::X, (0..=N).rev().map(|j| surface(N, j)).collect());
    strip(Vec3::NEG_Z, (0..=N).rev().map(|i| surface(i, 0)).collect());
    strip(Vec3::Z, (0..=N).map(|i| surface(i, N)).collect());
    let first = mesh.positions.len() as u32;
    for (x, z) in [(LOW.x, LOW.z), (HIGH.x, LOW.z), (HIGH.x, HIGH.z), (LOW.x, HIGH.z)] {
        mesh.positions.push(Vec3::new(x, LOW.y, z));
        mesh.normals.push(Vec3::NEG_Y);
    }
    mesh.triangles
        .extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
    mesh
}

fn ply(mesh: &Mesh) -> Vec<u8> {
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\ncomment made by tests/generated_meshes.rs\nelement vertex {}\n\
         property float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.positions.len(),
        mesh.triangles.len()
    )
    .into_bytes();
    for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
        for value in [p.x, p.y, p.z, n.x, n.y, n.z] {
            bytes.extend(value.to_le_bytes());
        }
    }
    for triangle in &mesh.triangles {
        bytes.push(3);
        for index in triangle {
            bytes.extend(index.to_le_bytes());
        }
    }
    bytes
}

/// Signed volume; positive when the triangles are wound outwards.
fn volume(mesh: &Mesh) -> f32 {
    let corner = |i: u32| mesh.positions[i as usize];
    mesh.triangles
        .iter()
        .map(|t| corner(t[0]).dot(corner(t[1]).cross(corner(t[2]))) / 6.0)
        .sum()
}

fn check(name: &str, mesh: &Mesh) {
    let path = PathBuf::from(crate::ROOT).join("assets/models").join(name);
    if std::env::var_os("SUNROOM_WRITE_MESHES").is_some() {
        std::fs::write(&path, ply(mesh)).expect("assets/models can be written");
    }
    let bytes = std::fs::read(&path).expect("the mesh is in assets/models");
    let stored = sunroom::geometry::ply::load_ply(&bytes).expect("the mesh loads").mesh;
    assert_eq!(stored.triangles, mesh.triangles);
    assert_eq!(stored.positions.len(), mesh.positions.len());
    // Sines differ in their last bits from one machine to the next.
    assert!(
        stored
            .positions
            .iter()
            .zip(&mesh.positions)
            .all(|(a, b)| a.abs_diff_eq(*b, 1e-5))
    );
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
        let facing = (b - a).cross(c - a).dot(mesh.normals[triangle[0] as usize]);
        assert!(facing > 0.0, "winding and normals agree");
    }
}

#[test]
fn the_knot_is_the_stored_one() {
    let mesh = knot();
    assert_eq!(mesh.triangles.len(), 115_200);
    assert!(volume(&mesh) > 0.0);
    check("knot.ply", &mesh);
}

#[test]
fn the_water_is_the_stored_one() {
    let mesh = water();
    // The block's base times its mean height; the waves nearly average out.
    let expected = 2.02 * 2.005 * (1.01 - 0.42);
    assert!((volume(&mesh) / expected - 1.0).abs() < 0.02, "{}", volume(&mesh));
    check("water.ply", &mesh);
}
