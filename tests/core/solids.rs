//! Meshes of walls, stairs and prisms: closed, with outward normals, of the right volume, with texture coordinates in
//! lengths.

use std::collections::HashMap;
use std::f32::consts::TAU;

use glam::Vec3;
use sunroom::geometry::mesh::MeshData;
use sunroom::geometry::ply::load_ply;
use sunroom::geometry::solid::{Hole, prism, stairs, to_ply, wall};

fn hole(from: f32, sill: f32, width: f32, height: f32) -> Hole {
    Hole {
        from,
        sill,
        width,
        height,
    }
}

/// The enclosed volume, by the divergence theorem.
fn volume(mesh: &MeshData) -> f32 {
    let parts = (0..mesh.triangles.len()).map(|triangle| {
        let [a, b, c] = mesh.corners(triangle);
        a.dot(b.cross(c)) / 6.0
    });
    parts.sum()
}

fn area(mesh: &MeshData) -> f32 {
    (0..mesh.triangles.len())
        .map(|triangle| mesh.area_of_triangle(triangle))
        .sum()
}

/// Every edge is passed as often in one direction as in the other, the normals are those of the triangles, and a
/// triangle has the same area in texture coordinates as in space.
fn check(name: &str, mesh: &MeshData) {
    let key = |place: Vec3| place.to_array().map(|x| (x + 0.0).to_bits());
    let mut edges: HashMap<_, i32> = HashMap::new();
    for (number, triangle) in mesh.triangles.iter().enumerate() {
        let corners = mesh.corners(number);
        for (from, to) in [(0, 1), (1, 2), (2, 0)].map(|(a, b)| (key(corners[a]), key(corners[b]))) {
            match from < to {
                true => *edges.entry((from, to)).or_default() += 1,
                false => *edges.entry((to, from)).or_default() -= 1,
            }
        }
        let [a, b, c] = corners;
        let outward = (b - a).cross(c - a);
        let normal = outward.normalize();
        for corner in triangle {
            // Rounding of a normalised vector.
            assert!(normal.abs_diff_eq(mesh.normals[*corner as usize], 1e-5), "{name}");
        }
        let [a, b, c] = triangle.map(|corner| mesh.uvs[corner as usize]);
        let in_texture = (b - a).perp_dot(c - a).abs();
        assert!(
            (in_texture - outward.length()).abs() < 1e-4 * outward.length() + 1e-5,
            "{name}"
        );
    }
    assert!(edges.values().all(|count| *count == 0), "{name} is not closed");
}

#[test]
fn walls_are_closed_whatever_their_openings() {
    // The wall is 4 x 2.5 x 0.2; the last number is the share of its face that is open, in square units.
    let cases: [(&str, Vec<Hole>, f32); 8] = [
        ("plain", vec![], 0.0),
        ("a window", vec![hole(1.0, 0.9, 1.2, 1.2)], 1.44),
        ("a door", vec![hole(0.5, 0.0, 0.9, 2.0)], 1.8),
        (
            "a door and a window",
            vec![hole(0.5, 0.0, 0.9, 2.0), hole(2.0, 0.9, 1.0, 1.0)],
            2.8,
        ),
        (
            "overlapping",
            vec![hole(1.0, 0.5, 1.0, 1.0), hole(1.5, 1.0, 1.0, 1.0)],
            1.75,
        ),
        (
            "touching at a corner",
            vec![hole(1.0, 0.5, 1.0, 0.5), hole(2.0, 1.0, 1.0, 0.5)],
            1.0,
        ),
        (
            "beyond the end",
            vec![hole(3.5, 1.0, 9.0, 9.0), hole(-1.0, -1.0, 1.5, 2.0)],
            0.75 + 0.5,
        ),
        (
            "without area",
            vec![hole(1.0, 1.0, 0.0, 1.0), hole(9.0, 1.0, 1.0, 1.0)],
            0.0,
        ),
    ];
    for (name, holes, open) in cases {
        let mesh = wall(4.0, 2.5, 0.2, &holes);
        check(name, &mesh);
        let expected = (4.0 * 2.5 - open) * 0.2;
        assert!(
            (volume(&mesh) - expected).abs() < 1e-4,
            "{name}: {} {expected}",
            volume(&mesh)
        );
    }
    assert_eq!(wall(4.0, 2.5, 0.2, &[hole(0.0, 0.0, 4.0, 2.5)]).triangles.len(), 0);
    // A window takes its area from both faces and adds its reveal.
    let [plain, windowed] = [&[][..], &[hole(1.0, 0.9, 1.2, 1.2)]].map(|holes| area(&wall(4.0, 2.5, 0.2, holes)));
    assert!((windowed - (plain - 2.0 * 1.44 + 4.8 * 0.2)).abs() < 1e-4);
}

#[test]
fn stairs_are_closed_and_fill_half_and_half_a_step() {
    for steps in [1, 2, 3, 15, 100] {
        let mesh = stairs(1.2, 4.0, 3.0, steps);
        check(&format!("{steps} steps"), &mesh);
        let expected = 1.2 * 4.0 * 3.0 * 0.5 * (1.0 + 1.0 / steps as f32);
        assert!(
            (volume(&mesh) - expected).abs() < 1e-3,
            "{steps}: {} {expected}",
            volume(&mesh)
        );
        assert_eq!(mesh.bounds().max, Vec3::new(0.6, 4.0, 3.0));
    }
}

#[test]
fn prisms_are_closed_and_as_large_as_frusta() {
    for sides in [3, 4, 6, 64] {
        for top in [0.0, 0.5, 1.0, 2.0] {
            let mesh = prism(1.0, top, 3.0, sides);
            check(&format!("{sides} sides, top {top}"), &mesh);
            let polygon = 0.5 * sides as f32 * (TAU / sides as f32).sin();
            let expected = polygon * 3.0 / 3.0 * (1.0 + top + top * top);
            assert!(
                (volume(&mesh) - expected).abs() < 1e-3,
                "{sides} {top}: {} {expected}",
                volume(&mesh)
            );
        }
    }
    // One side of a square prism faces -y.
    let lowest = prism(1.0, 1.0, 1.0, 4).bounds().min.y;
    assert!((lowest + 0.5f32.sqrt()).abs() < 1e-6);
}

#[test]
fn pictures_stand_upright_on_walls() {
    let mesh = wall(4.0, 2.5, 0.2, &[]);
    for ((position, normal), uv) in mesh.positions.iter().zip(&mesh.normals).zip(&mesh.uvs) {
        if normal.z == 0.0 {
            assert!((uv.y - (2.5 - position.z)).abs() < 1e-6, "{position} {uv}");
        }
    }
}

#[test]
fn written_meshes_are_read_back_bit_for_bit() {
    let mesh = wall(4.0, 2.5, 0.2, &[hole(1.1, 0.9, 1.2, 1.3)]);
    let read = load_ply(to_ply(&mesh).as_bytes()).expect("a good file").mesh;
    assert!(read.positions == mesh.positions && read.normals == mesh.normals);
    assert!(read.uvs == mesh.uvs && read.triangles == mesh.triangles);
}

#[test]
fn faces_of_all_sizes_have_normals() {
    for size in [1e-20, 1.0, 1e20] {
        let holes = [hole(0.5 * size, 0.0, size, 2.0 * size)];
        for (name, mesh, triangles) in [
            ("wall", wall(4.0 * size, 2.5 * size, 0.2 * size, &holes), None),
            ("stairs", stairs(size, 4.0 * size, 2.5 * size, 3), None),
            ("prism", prism(size, size, size, 6), Some(20)),
        ] {
            assert!(!mesh.triangles.is_empty(), "{name} {size}");
            assert!(
                triangles.is_none_or(|count| mesh.triangles.len() == count),
                "{name} {size}"
            );
            for normal in &mesh.normals {
                assert!((normal.length() - 1.0).abs() < 1e-6, "{name} {size}: {normal}");
            }
        }
    }
}

#[test]
fn numbers_that_are_no_lengths_make_no_wall() {
    for length in [-1.0, f32::NAN] {
        let mesh = wall(length, 1.0, 0.1, &[hole(0.0, 0.0, 1.0, 1.0)]);
        assert!(mesh.triangles.is_empty(), "{length}");
    }
}
