//! Meshes of walls, stairs, prisms and roofs: closed, with outward normals, of the right volume, with texture coordinates
//! in lengths.

use std::collections::HashMap;
use std::f32::consts::TAU;

use glam::Vec3;
use sunroom::geometry::mesh::MeshData;
use sunroom::geometry::ply::load_ply;
use sunroom::geometry::solid::{Hole, Roof, RoofForm, prism, roof, stairs, to_ply, wall};

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

/// A roof over 8 x 6 that rises by 2.
fn over_a_house(form: RoofForm, overhang: f32, gable: f32) -> Roof {
    Roof {
        form,
        width: 8.0,
        depth: 6.0,
        height: 2.0,
        overhang,
        thickness: 0.2,
        gable,
    }
}

#[test]
fn roofs_are_closed_and_as_thick_as_was_said() {
    for form in [RoofForm::Gable, RoofForm::Hip, RoofForm::Shed] {
        for overhang in [0.0, 0.4] {
            for gable in [0.0, 0.25, 5.0] {
                let about = over_a_house(form, overhang, gable);
                let name = format!("{about:?}");
                let mesh = roof(&about);
                check(&name, &mesh);
                let (run, ends) = match form {
                    RoofForm::Gable | RoofForm::Hip => (3.0, 0.5 * 6.0 * 2.0),
                    RoofForm::Shed => (6.0, 0.5 * 6.0 * 2.0),
                };
                let slab = 0.2 * f32::hypot(1.0, 2.0 / run);
                let thick = f32::min(gable, 4.0);
                let walls = match form {
                    RoofForm::Hip => 0.0,
                    RoofForm::Gable => 2.0 * thick * ends,
                    // The mean height of the wall at the high side.
                    RoofForm::Shed => {
                        let back = f32::min(gable, 6.0);
                        2.0 * thick * ends + (8.0 - 2.0 * thick) * back * 2.0 * (1.0 - back / 12.0)
                    }
                };
                let expected = (8.0 + 2.0 * overhang) * (6.0 + 2.0 * overhang) * slab + walls;
                assert!(
                    (volume(&mesh) - expected).abs() < 1e-3,
                    "{name}: {} {expected}",
                    volume(&mesh)
                );
                let bounds = mesh.bounds();
                let [low, high] = about.corners();
                assert!(
                    low.abs_diff_eq(bounds.min, 1e-5) && high.abs_diff_eq(bounds.max, 1e-5),
                    "{name}"
                );
                assert!((bounds.min.z + overhang * 2.0 / run).abs() < 1e-5, "{name}");
                let end = Vec3::new(4.0 + overhang, 3.0 + overhang, 0.0);
                assert_eq!(
                    (bounds.max - bounds.max.z * Vec3::Z, bounds.min.y),
                    (end, -end.y),
                    "{name}"
                );
            }
        }
    }
}

#[test]
fn the_slopes_of_a_roof_face_upwards_and_have_true_lengths() {
    let about = over_a_house(RoofForm::Gable, 0.4, 0.0);
    let mesh = roof(&about);
    let rise = about.slab_height();
    // From the ridge down to the eaves.
    let way = f32::hypot(3.4, 3.4 * 2.0 / 3.0);
    let mut seen = 0;
    for ((position, normal), uv) in mesh.positions.iter().zip(&mesh.normals).zip(&mesh.uvs) {
        let is_eaves = position.y == -3.4 && (position.z - (rise - 0.4 * 2.0 / 3.0)).abs() < 1e-5;
        if is_eaves && normal.z > 0.5 {
            // Texture coordinates begin at the ridge of the underside.
            let above = rise / about.slope().hypot(1.0) * about.slope();
            assert!((uv.y - (way - above)).abs() < 1e-4, "{position} {uv} {way}");
            assert!((uv.x - position.x).abs() < 1e-5, "{position} {uv}");
            seen += 1;
        }
    }
    assert!(seen > 0);
    // The ridge of a hip roof runs along the longer side, and over a square it is a point.
    for (width, depth, length) in [(8.0, 6.0, 2.0), (6.0, 8.0, 2.0), (6.0, 6.0, 0.0)] {
        let about = Roof {
            width,
            depth,
            ..over_a_house(RoofForm::Hip, 0.3, 0.0)
        };
        let mesh = roof(&about);
        check("hip", &mesh);
        let top = mesh.bounds().max.z - 1e-5;
        let ridge = mesh.positions.iter().filter(|place| place.z > top);
        let low = ridge.clone().copied().reduce(Vec3::min).expect("a ridge");
        let high = ridge.copied().reduce(Vec3::max).expect("a ridge");
        assert!(
            ((high - low).length() - length).abs() < 1e-5,
            "{width} {depth}: {low} {high}"
        );
    }
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
            ("roof", roof(&large(RoofForm::Gable, size)), None),
            ("hip", roof(&large(RoofForm::Hip, size)), None),
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

fn large(form: RoofForm, size: f32) -> Roof {
    Roof {
        form,
        width: 8.0 * size,
        depth: 6.0 * size,
        height: 2.0 * size,
        overhang: 0.4 * size,
        thickness: 0.2 * size,
        gable: 0.2 * size,
    }
}

#[test]
fn numbers_that_are_no_lengths_make_no_wall() {
    for length in [-1.0, f32::NAN] {
        let flawed = Roof {
            depth: length,
            ..over_a_house(RoofForm::Shed, 0.4, 0.2)
        };
        assert!(roof(&flawed).triangles.is_empty(), "{length}");
        let mesh = wall(length, 1.0, 0.1, &[hole(0.0, 0.0, 1.0, 1.0)]);
        assert!(mesh.triangles.is_empty(), "{length}");
    }
}

#[test]
fn roofs_beyond_single_precision_have_no_surface() {
    for form in [RoofForm::Gable, RoofForm::Hip, RoofForm::Shed] {
        let steep = Roof {
            overhang: 1e20,
            height: 1e20,
            depth: 1e-5,
            ..large(form, 1.0)
        };
        assert!(roof(&steep).triangles.is_empty(), "{form:?}");
        assert_eq!(steep.corners(), [Vec3::ZERO; 2], "{form:?}");
    }
}
