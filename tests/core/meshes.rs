//! The mesh readers on files made here, and on other people's: models, and the good, odd and broken files of other
//! loaders' test suites, which lie outside the repository and are skipped where they are not.

use std::io;
use std::path::Path;

use crate::mesh_support::{Random, assert_sound};
use glam::{Vec2, Vec3};
use sunroom::geometry::mesh::MeshData;
use sunroom::geometry::mesh_file::{LoadedMesh, MeshError, Place};
use sunroom::geometry::obj::load_obj;
use sunroom::geometry::ply::load_ply;

fn no_library(name: &str) -> io::Result<Vec<u8>> {
    Err(io::Error::new(io::ErrorKind::NotFound, format!("no {name} here")))
}

fn obj(text: &str) -> Result<LoadedMesh, MeshError> {
    load_obj(text.as_bytes(), &mut no_library)
}

fn obj_mesh(text: &str) -> MeshData {
    obj(text).unwrap_or_else(|error| panic!("{error}\n{text}")).mesh
}

// ---- PLY ----

#[derive(Clone, Copy, PartialEq)]
enum Format {
    Ascii,
    Little,
    Big,
}

const FORMATS: [Format; 3] = [Format::Ascii, Format::Little, Format::Big];

/// A body under construction, in one of the three formats.
struct Body {
    format: Format,
    bytes: Vec<u8>,
}

macro_rules! put {
    ($body:expr, $value:expr) => {{
        let value = $value;
        match $body.format {
            Format::Ascii => $body.bytes.extend(format!("{value} ").bytes()),
            Format::Little => $body.bytes.extend(value.to_le_bytes()),
            Format::Big => $body.bytes.extend(value.to_be_bytes()),
        }
    }};
}

fn ply(format: Format, header: &str, fill: impl FnOnce(&mut Body)) -> Vec<u8> {
    let name = match format {
        Format::Ascii => "ascii",
        Format::Little => "binary_little_endian",
        Format::Big => "binary_big_endian",
    };
    let mut body = Body {
        format,
        bytes: format!("ply\nformat {name} 1.0\n{header}end_header\n").into_bytes(),
    };
    fill(&mut body);
    body.bytes
}

/// A random mesh with everything: normals, uvs, quads among the triangles, elements and properties that nobody knows.
fn rich_ply(format: Format, seed: u64) -> Vec<u8> {
    let mut random = Random(seed);
    let vertices = 4 + random.below(20);
    let faces = 1 + random.below(20);
    let header = format!(
        "comment made for a test\nobj_info none\nelement camera 2\nproperty list uchar float things\nproperty short kind\n\
         element vertex {vertices}\nproperty double x\nproperty uchar red\nproperty float y\nproperty int z\nproperty list ushort int8 more\n\
         property float nx\nproperty float ny\nproperty double nz\nproperty float s\nproperty float32 t\n\
         element face {faces}\nproperty uint8 flags\nproperty list uint8 uint vertex_indices\nproperty list int float texcoord\n\
         element edge 1\nproperty int vertex1\n"
    );
    ply(format, &header, |body| {
        for length in 0..2u8 {
            put!(body, length);
            for _ in 0..length {
                put!(body, random.float());
            }
            put!(body, -7i16);
        }
        for _ in 0..vertices {
            put!(body, f64::from(random.float()));
            put!(body, 255u8);
            put!(body, random.float());
            put!(body, random.below(100) as i32 - 50);
            put!(body, 2u16);
            put!(body, -1i8);
            put!(body, 1i8);
            put!(body, random.float());
            put!(body, random.float());
            put!(body, f64::from(random.float()));
            put!(body, random.float());
            put!(body, random.float());
        }
        for _ in 0..faces {
            put!(body, 1u8);
            let corners = 3 + random.below(3) as u8;
            put!(body, corners);
            for _ in 0..corners {
                put!(body, random.below(vertices) as u32);
            }
            put!(body, 1i32);
            put!(body, random.float());
        }
        put!(body, 0i32);
    })
}

#[test]
fn the_three_ply_formats_say_the_same() {
    for seed in 0..200 {
        let [ascii, little, big] = FORMATS.map(|format| {
            let loaded = load_ply(&rich_ply(format, seed)).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
            assert_eq!(loaded.warnings, [""; 0]);
            loaded.mesh
        });
        assert_sound(&ascii);
        assert_eq!(ascii.uvs.len(), ascii.positions.len());
        assert_eq!(ascii, little, "seed {seed}");
        assert_eq!(little, big, "seed {seed}");
    }
}

/// Records that are all of one length, but for the faces of one corner more that `is_quad` asks for; numbers of many
/// types, colours and other values of vertices and faces.
fn even_ply(format: Format, seed: u64, is_quad: impl Fn(usize) -> bool) -> Vec<u8> {
    let mut random = Random(seed);
    let vertices = 4 + random.below(10_000);
    let faces = 1 + random.below(10_000);
    let (number, index, normal) = match seed % 3 {
        0 => (
            "float",
            "int",
            "property float nx\nproperty float ny\nproperty float nz\n",
        ),
        1 => (
            "float",
            "uint",
            "property float nx\nproperty float nz\nproperty double ny\n",
        ),
        _ => ("double", "ushort", ""),
    };
    let header = format!(
        "element vertex {vertices}\nproperty uchar flags\nproperty {number} x\nproperty {number} y\nproperty {number} z\n{normal}\
         property uchar red\nproperty uchar green\nproperty uchar blue\nproperty float u\nproperty float v\n\
         element face {faces}\nproperty short kind\nproperty list uchar {index} vertex_indices\nproperty float heat_x\n"
    );
    ply(format, &header, |body| {
        for _ in 0..vertices {
            put!(body, 7u8);
            for _ in 0..3 {
                match number {
                    "float" => put!(body, random.float()),
                    _ => put!(body, f64::from(random.float())),
                }
            }
            if !normal.is_empty() {
                put!(body, random.float());
                put!(body, random.float());
                match normal.contains("double") {
                    true => put!(body, f64::from(random.float())),
                    false => put!(body, random.float()),
                }
            }
            for _ in 0..3 {
                put!(body, random.next() as u8);
            }
            put!(body, random.float());
            put!(body, random.float());
        }
        for face in 0..faces {
            put!(body, -3i16);
            let corners = 3 + u8::from(is_quad(face));
            put!(body, corners);
            for _ in 0..corners {
                let corner = random.below(vertices);
                match index {
                    "int" => put!(body, corner as i32),
                    "uint" => put!(body, corner as u32),
                    _ => put!(body, corner as u16),
                }
            }
            put!(body, random.float());
        }
    })
}

#[test]
fn records_of_one_length_say_the_same_as_text() {
    for seed in 0..24 {
        let quad = (seed % 4 == 3).then_some(Random(seed).below(10_000));
        let [ascii, little, big] = FORMATS.map(|format| {
            let bytes = even_ply(format, seed, |face| Some(face) == quad);
            load_ply(&bytes).unwrap_or_else(|error| panic!("seed {seed}: {error}"))
        });
        assert_sound(&ascii.mesh);
        let names: Vec<&str> = ascii.mesh.attributes.iter().map(|attribute| &*attribute.name).collect();
        assert_eq!(names, ["vertex_color", "face_heat"]);
        assert!(ascii == little && little == big, "seed {seed}");
    }
}

#[test]
fn an_error_amid_records_of_one_length_names_its_byte() {
    let whole = even_ply(Format::Little, 0, |_| false);
    let vertices = load_ply(&whole).unwrap().mesh.positions.len();
    let body = whole.windows(11).position(|window| window == b"end_header\n").unwrap() + 11;
    let second_face = body + vertices * (1 + 24 + 3 + 8) + (2 + 1 + 12 + 4);
    let with = |at: usize, bytes: &[u8]| {
        let mut broken = whole.clone();
        broken[at..at + bytes.len()].copy_from_slice(bytes);
        load_ply(&broken).map(|_| ())
    };
    let y = body + 36 * 5 + 5;
    let place = Place::Byte(y as u64);
    assert_eq!(
        with(y, &f32::INFINITY.to_le_bytes()),
        Err(MeshError::NotFinite { place })
    );
    let last_corner = second_face + 2 + 1 + 8;
    let error = |index: i32| MeshError::IndexOutOfRange {
        place: Place::Byte(last_corner as u64),
        what: "vertex",
        index: index.into(),
        count: vertices as u64,
    };
    for index in [-1, vertices as i32, i32::MIN] {
        assert_eq!(with(last_corner, &index.to_le_bytes()), Err(error(index)));
    }
    assert_eq!(with(last_corner, &(vertices as i32 - 1).to_le_bytes()), Ok(()));
}

/// A tetrahedron of nothing but the simplest properties.
fn plain_ply(format: Format) -> Vec<u8> {
    let header = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                  element face 4\nproperty list uchar int vertex_index\n";
    ply(format, header, |body| {
        for corner in [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.5, 0.0], [0.0, 0.0, -2.25]] {
            for x in corner {
                put!(body, x);
            }
        }
        for face in [[0i32, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]] {
            put!(body, 3u8);
            for i in face {
                put!(body, i);
            }
        }
    })
}

#[test]
fn a_truncated_ply_is_an_error_at_every_byte() {
    for format in FORMATS {
        for whole in [plain_ply(format), rich_ply(format, 1)] {
            let expected = load_ply(&whole).unwrap().mesh;
            // The last number of a text may lose digits and the blank after it without anybody noticing.
            let sure = if format == Format::Ascii {
                whole.len() - 2
            } else {
                whole.len()
            };
            for length in 0..sure {
                assert!(load_ply(&whole[..length]).is_err(), "{length} of {}", whole.len());
            }
            assert_eq!(load_ply(&whole).unwrap().mesh, expected);
        }
    }
}

#[test]
fn flipped_bytes_never_panic_and_what_loads_is_sound() {
    let mut random = Random(2);
    for format in FORMATS {
        for whole in [plain_ply(format), rich_ply(format, 3)] {
            for _ in 0..4000 {
                let mut broken = whole.clone();
                for _ in 0..=random.below(3) {
                    let at = random.below(broken.len());
                    broken[at] = random.next() as u8;
                }
                if let Ok(loaded) = load_ply(&broken) {
                    assert_sound(&loaded.mesh);
                }
            }
        }
    }
}

#[test]
fn ply_header_lines_may_end_in_any_way() {
    for format in FORMATS {
        let whole = plain_ply(format);
        let end = whole.windows(11).position(|window| window == b"end_header\n").unwrap() + 11;
        let (header, body) = whole.split_at(end);
        let expected = load_ply(&whole).unwrap();
        for line_end in ["\r\n", "\r"] {
            let header = std::str::from_utf8(header).unwrap().replace('\n', line_end);
            let bytes = [header.as_bytes(), body].concat();
            assert_eq!(load_ply(&bytes), Ok(expected.clone()), "{line_end:?}");
        }
    }
}

#[test]
fn ply_without_normals_gets_smooth_ones_and_bad_normals_are_mended() {
    let mesh = load_ply(&plain_ply(Format::Big)).unwrap().mesh;
    // Three right angles meet at the origin; each face weighs the same.
    let expected = Vec3::new(-1.0, -1.0, 1.0).normalize();
    assert!((mesh.normals[0] - expected).length() < 1e-6, "{}", mesh.normals[0]);

    let header = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                  property float nx\nproperty float ny\nproperty float nz\nproperty float u\nproperty float v\n\
                  element face 1\nproperty list uchar int vertex_indices\n";
    let bytes = ply(Format::Ascii, header, |body| {
        body.bytes
            .extend(b"0 0 0 0 0 0 0.25 0.75\n1 0 0 nan 0 1 nan 1\n0 1 0 3 0 0 1 1\n3 0 1 2\n");
    });
    let loaded = load_ply(&bytes).unwrap();
    assert_eq!(loaded.mesh.normals, [Vec3::Z, Vec3::Z, Vec3::X]);
    assert_eq!(loaded.mesh.uvs, [Vec2::new(0.25, 0.75), Vec2::ZERO, Vec2::ONE]);
    assert_eq!(
        loaded.warnings,
        [
            "texture coordinates: a pair that is not finite counts as 0 0",
            "normals: a normal that is zero or not finite is computed from the triangles instead (and 1 times more)"
        ]
    );
}

#[test]
fn tristrips_turn_every_other_triangle_and_restart() {
    let header = "element vertex 6\nproperty float x\nproperty float y\nproperty float z\n\
                  element tristrips 1\nproperty list int int vertex_indices\n";
    for format in FORMATS {
        let bytes = ply(format, header, |body| {
            for i in 0..6 {
                put!(body, (i / 2) as f32);
                put!(body, (i % 2) as f32);
                put!(body, 0.0f32);
            }
            let strips = [0i32, 2, 1, 3, 3, 5, -1, 2, 4, 3, 5];
            put!(body, strips.len() as i32);
            for i in strips {
                put!(body, i);
            }
        });
        let mesh = load_ply(&bytes).unwrap().mesh;
        // 1 3 3 and 3 3 5 have no area.
        assert_eq!(mesh.triangles, [[0, 2, 1], [1, 2, 3], [2, 4, 3], [3, 4, 5]]);
        assert!(
            mesh.normals.iter().all(|&n| n == Vec3::Z),
            "both strips face up: {:?}",
            mesh.normals
        );
    }
}

#[test]
fn each_broken_ply_gives_one_clear_error() {
    let head = "ply\nformat ascii 1.0\n";
    let vertices = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    let face = "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let body = "0 0 0\n1 0 0\n0 1 0\n";
    let cases = [
        (
            String::new(),
            "line 1: expected `ply` as the first line of a PLY file, found nothing",
        ),
        (
            "solid cube\n".into(),
            "line 1: expected `ply` as the first line of a PLY file, found `solid cube`",
        ),
        (
            head.into(),
            "line 3: the file ends early: the header has no `end_header`",
        ),
        (
            "ply\nformat utf8 1.0\n".into(),
            "line 2: expected the format `ascii`, `binary_little_endian` or `binary_big_endian`, found `utf8`",
        ),
        (
            format!("ply\n{vertices}{face}"),
            "line 8: expected a `format` in the header, found `end_header`",
        ),
        (
            format!("{head}property float x\n"),
            "line 3: expected an `element` before its properties, found `property float x`",
        ),
        (
            format!("{head}element vertex -3\n"),
            "line 3: expected a count of elements, found `-3`",
        ),
        (
            format!("{head}{vertices}property quad w\n"),
            "line 7: expected a PLY number type such as `float`, found `quad`",
        ),
        (
            format!("{head}{vertices}property list float int a\n"),
            "line 7: expected a whole number type as list count, found `float`",
        ),
        (
            format!("{head}nonsense\n"),
            "line 3: expected a statement of a PLY header, found `nonsense`",
        ),
        (
            format!("{head}element vertex 3\nproperty float x\nproperty float y\n{face}"),
            "line 3: expected one scalar property `z` of the vertices, found none or several",
        ),
        (
            format!("{head}{vertices}element face 1\nproperty int a\nend_header\n"),
            "line 7: expected one property list `vertex_indices` of `face`, found none or several",
        ),
        (
            format!("{head}{vertices}{vertices}{face}"),
            "line 7: expected one element `vertex`, found another",
        ),
        (
            format!("{head}{}{face}{body}3 0 1 2\n", vertices.replace('3', "4294967295")),
            "line 3: the file ends early: 4294967295 elements `vertex` are promised, and only 26 bytes follow",
        ),
        (
            format!(
                "{head}{}{face}{body}3 0 1 2\n",
                vertices.replace('3', "18446744073709551615")
            ),
            "the number of vertices is beyond what this program reads (4294967295)",
        ),
        (
            format!("{head}{vertices}{face}{body}3 0 1 3\n"),
            "line 13: vertex index 3 is out of range: the file has 3",
        ),
        (
            format!("{head}{vertices}{face}{body}3 0 -1 2\n"),
            "line 13: vertex index -1 is out of range: the file has 3",
        ),
        (
            format!("{head}{vertices}{face}{body}-3 0 1 2\n"),
            "line 13: expected the length of a list, found `-3`",
        ),
        (
            format!("{head}{vertices}{face}{body}4000000000 0 1 2\n"),
            "line 14: the file ends early: the header promises more",
        ),
        (
            format!("{head}{vertices}{face}{body}3 0 1\n"),
            "line 14: the file ends early: the header promises more",
        ),
        (
            format!("{head}{vertices}{face}0 0 0\n1 0 zero\n0 1 0\n"),
            "line 11: expected a number, found `zero`",
        ),
        (
            format!("{head}{vertices}{face}0 0 0\n1 0 nan\n0 1 0\n3 0 1 2\n"),
            "line 11: a vertex position is not finite",
        ),
        (
            format!("{head}{vertices}{face}0 0 0\n1 0 1e99\n0 1 0\n3 0 1 2\n"),
            "line 11: a vertex position is not finite",
        ),
        (
            format!("{head}{vertices}end_header\n{body}"),
            "the file holds no triangles",
        ),
        (
            format!("{head}{vertices}{face}{body}2 0 1\n"),
            "the file holds no triangles",
        ),
        (
            format!("{head}element face 0\nproperty int a\nend_header\n"),
            "the file holds no triangles",
        ),
    ];
    for (text, expected) in cases {
        let error = load_ply(text.as_bytes()).expect_err(&text);
        assert_eq!(error.to_string(), expected, "{text}");
    }
    let mut broken = plain_ply(Format::Little);
    let length = broken.len();
    broken[length - 4..].copy_from_slice(&9i32.to_le_bytes());
    let expected = MeshError::IndexOutOfRange {
        place: Place::Byte(length as u64 - 4),
        what: "vertex",
        index: 9,
        count: 4,
    };
    assert_eq!(load_ply(&broken), Err(expected));
}

#[test]
fn absurd_ply_counts_cost_neither_time_nor_memory() {
    let count = u64::MAX / 2;
    let vertex = "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
    for format in FORMATS {
        // An element without properties takes no bytes, however often it is there.
        let header = format!("element ghost {count}\n{vertex}element face 0\nproperty list uchar int vertex_indices\n");
        let bytes = ply(format, &header, |body| body.bytes.extend([b'0', b' '].repeat(16)));
        assert_eq!(load_ply(&bytes), Err(MeshError::NoTriangles));
        for promise in [
            format!("element ghost {count}\nproperty list uchar double a\n{vertex}"),
            format!("{vertex}element face {count}\nproperty list ulong int vertex_indices\n"),
            format!("{vertex}element tristrips {count}\nproperty list uchar int vertex_indices\n"),
        ] {
            let bytes = ply(format, &promise, |body| body.bytes.extend([b'0', b' '].repeat(100)));
            assert!(
                matches!(load_ply(&bytes), Err(MeshError::Truncated { .. })),
                "{promise}"
            );
        }
        let bytes = ply(
            format,
            &format!("{vertex}element face 1\nproperty list ulong int vertex_indices\n"),
            |body| {
                for _ in 0..3 {
                    put!(body, 0.0f32);
                }
                put!(body, u64::MAX);
            },
        );
        assert!(load_ply(&bytes).is_err());
    }
}

// ---- OBJ ----

const CUBE: &str = "# a cube\nmtllib a.mtl\no cube\nv -1 -1 -1\nv 1 -1 -1\nv 1 1 -1\nv -1 1 -1\nv -1 -1 1\nv 1 -1 1\nv 1 1 1\nv -1 1 1\n\
    vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nvn 0 0 -1\nvn 0 0 1\ng a\nusemtl red\nf 4/4/1 3/3/1 2/2/1 1/1/1\nusemtl green\nf 5/1/2 6/2/2 7/3/2 8/4/2\n\
    g b\nf 1 2 6 5\nf 2 3 7 6\nusemtl red\nf 3// 4// 8// 7//\nf -8/-4 -4/-3 -1/-2 -5/-1\n";

#[test]
fn an_obj_arrives_whole() {
    let mut asked = Vec::new();
    let loaded = load_obj(CUBE.as_bytes(), &mut |name| {
        asked.push(name.to_owned());
        Ok(b"newmtl green\nKd 0 1 0\nnewmtl red\nKd 1 0 0\nmap_Kd a.png\n".to_vec())
    })
    .unwrap();
    assert_eq!(asked, ["a.mtl"]);
    assert_eq!(
        loaded.warnings,
        ["12 of 20 vertices: without a usable normal of their own get one computed from the triangles"]
    );
    let mesh = loaded.mesh;
    assert_sound(&mesh);
    let picture = mesh.materials[1].maps.kd.as_ref().map(|map| map.file.as_path());
    assert_eq!(picture, Some(Path::new("a.png")));
    assert_eq!((mesh.positions.len(), mesh.triangles.len()), (20, 12));
    let names: Vec<&str> = mesh.materials.iter().map(|material| material.name.as_str()).collect();
    assert_eq!(names, ["green", "red"]);
    assert_eq!(mesh.material_of_triangle, [1, 1, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1]);
    assert_eq!(mesh.normals[..4], [Vec3::NEG_Z; 4]);
    assert_eq!(mesh.uvs[..4], [Vec2::Y, Vec2::ONE, Vec2::X, Vec2::ZERO]);
    for triangle in 0..12 {
        let [a, b, c] = mesh.corners(triangle);
        assert!(
            (b - a).cross(c - a).dot(a + b + c) > 0.0,
            "triangle {triangle} faces inward"
        );
        assert_eq!(mesh.area_of_triangle(triangle), 2.0);
    }
}

#[test]
fn obj_text_may_look_in_many_ways() {
    let plain = obj_mesh("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    assert_eq!(plain.triangles, [[0, 1, 2]]);
    assert_eq!(plain.normals, [Vec3::Z; 3]);
    for other in [
        "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3",
        "v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r",
        "\u{feff}v 0 0 0 1\n\tv  1.\t0 -.0  # x\n v +0 1e0 0e-9 1.0\n\nf\t1//  2/ 3 # end",
        "f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n",
        "v 0 0 0\nv 1 \\\n0 0\nv 0 1 0\nf 1 2\\\r\n 3\nl 1 2\np 1\ns off\n",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/5/7 2/6/8 3/7/9\n",
        "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\nf\nf 1\nf -3 -2 -1\n",
    ] {
        assert_eq!(obj_mesh(other), plain, "{other:?}");
    }
    let warned =
        obj("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2\nf 1 2 3\nf\ncurv 1 2\nusemtl a\nmtllib my colours.mtl\n").unwrap();
    assert_eq!(
        warned.warnings,
        [
            "line 4: a face with fewer than three corners is skipped (and 1 times more)",
            "line 7: the statement `curv` is ignored",
            "line 9: the material library `my` cannot be read: no my here",
            "line 9: the material library `colours.mtl` cannot be read: no colours.mtl here",
            "usemtl: materials are named, but there is no library that has any",
        ]
    );
}

#[test]
fn material_libraries_are_found_by_any_spelling() {
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a b\nf 1 2 3\nusemtl none\nf 1 2 3\n";
    for (statement, expected) in [
        ("mtllib my file.mtl", vec!["my file.mtl"]),
        ("mtllib \"my file.mtl\"", vec!["my file.mtl"]),
        ("mtllib .\\sub\\my file.mtl ", vec!["./sub/my file.mtl"]),
        ("mtllib one.mtl two.mtl", vec!["one.mtl two.mtl", "one.mtl", "two.mtl"]),
        ("mtllib one.mtl\nmtllib one.mtl", vec!["one.mtl"]),
    ] {
        let mut asked = Vec::new();
        // The library may follow its use.
        let text = format!("{triangle}{statement}\n");
        let mesh = load_obj(text.as_bytes(), &mut |name| {
            asked.push(name.to_owned());
            if name == "one.mtl two.mtl" {
                return no_library(name);
            }
            Ok(b"newmtl a b\nKd 1 0 0\nNi 1.25".to_vec())
        })
        .unwrap()
        .mesh;
        assert_eq!(asked, expected);
        assert_sound(&mesh);
        assert_eq!(mesh.materials[0].name, "a b");
        assert_eq!(mesh.materials[0].ni, 1.25);
        // What no library has is the grey of a shape without a bsdf.
        let grey = &mesh.materials[mesh.material_of_triangle[1] as usize];
        assert_eq!((grey.name.as_str(), grey.kd), ("none", Vec3::splat(0.5)));
    }
}

#[test]
fn each_broken_obj_gives_one_clear_error() {
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n";
    let cases = [
        (String::new(), "the file holds no triangles"),
        ("\u{1}\u{2}\u{3}PNG".into(), "the file holds no triangles"),
        (square.into(), "the file holds no triangles"),
        (format!("{square}l 1 2 3\nf 1 2\n"), "the file holds no triangles"),
        (
            format!("{square}f 1 2 5\n"),
            "line 7: vertex index 5 is out of range: the file has 4",
        ),
        (
            format!("{square}f 1 2 -5\n"),
            "line 7: vertex index -5 is out of range: the file has 4",
        ),
        (
            format!("{square}f 1 2 0\n"),
            "line 7: vertex index 0 is out of range: the file has 4",
        ),
        (
            format!("{square}f 1/1 2/1 3/2\n"),
            "line 7: texture coordinate index 2 is out of range: the file has 1",
        ),
        (
            format!("{square}f 1//1 2//1 3//2\n"),
            "line 7: normal index 2 is out of range: the file has 1",
        ),
        (
            format!("{square}f 1 2 99999999999999999999\n"),
            "line 7: expected the index of a vertex, found `99999999999999999999`",
        ),
        (
            format!("{square}f 1 2 4294967296\n"),
            "line 7: vertex index 4294967296 is out of range: the file has 4",
        ),
        (
            format!("{square}f 1 2 /1\n"),
            "line 7: expected a corner such as 1, 1/2, 1//3 or 1/2/3, found `/1`",
        ),
        (
            format!("{square}f 1 2 3/1/1/1\n"),
            "line 7: expected a corner such as 1, 1/2, 1//3 or 1/2/3, found `3/1/1/1`",
        ),
        (
            format!("{square}f 1 2 b\n"),
            "line 7: expected the index of a vertex, found `b`",
        ),
        ("\nv 1 2\n".into(), "line 2: expected three coordinates, found `v 1 2`"),
        (
            "v 1 2 1,5\n".into(),
            "line 1: expected three coordinates, found `v 1 2 1,5`",
        ),
        ("v 1 2 inf\n".into(), "line 1: a vertex position is not finite"),
        ("v 1 2 1e40\n".into(), "line 1: a vertex position is not finite"),
        (
            "vn 1 2\n".into(),
            "line 1: expected three components of a normal, found `vn 1 2`",
        ),
        (
            "vt a\n".into(),
            "line 1: expected one to three texture coordinates, found `vt a`",
        ),
    ];
    for (text, expected) in cases {
        assert_eq!(obj(&text).expect_err(&text).to_string(), expected, "{text}");
    }
}

#[test]
fn broken_obj_text_never_panics_and_what_loads_is_sound() {
    for length in 0..CUBE.len() {
        if let Ok(loaded) = obj(&CUBE[..length]) {
            assert_sound(&loaded.mesh);
        }
    }
    let library = b"newmtl red\nKd 1 0 0\nKs 1 1 1\nNs 10\nd 1\nillum 2\nPr 0.5\nmap_Kd a.png\nnewmtl green\nKe 1\n";
    let mut random = Random(4);
    for _ in 0..10_000 {
        let [text, library] = [CUBE.as_bytes(), library].map(|whole| {
            let mut broken = whole.to_vec();
            for _ in 0..=random.below(4) {
                let at = random.below(broken.len());
                // Mostly the characters that mean something.
                let meaningful = b"0123456789-/ \n.vftn#\\\r";
                let byte = random.next() as u8;
                broken[at] = if byte < 64 {
                    byte.wrapping_mul(4)
                } else {
                    meaningful[random.below(meaningful.len())]
                };
            }
            broken
        });
        if let Ok(loaded) = load_obj(&text, &mut |_| Ok(library.clone())) {
            assert_sound(&loaded.mesh);
        }
    }
}

#[test]
fn hostile_obj_files_cost_little() {
    // Many corners at one position, each with a texture coordinate of its own; one polygon of very many corners; ten
    // thousand statements nobody knows; as many libraries. Any of these as a square would take minutes.
    let mut text = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    for i in 1..=50_000 {
        text += &format!("vt {i} 0\nf 1/{i} 1/{i} 1/{i}\nword{i}\nmtllib lib{i}\n");
    }
    text += "f";
    for i in 0..200_000 {
        text += &format!(" {}", i % 3 + 1);
    }
    let mut asked = 0;
    let loaded = load_obj(text.as_bytes(), &mut |name| {
        asked += 1;
        no_library(name)
    })
    .unwrap();
    assert_sound(&loaded.mesh);
    assert_eq!(loaded.mesh.triangles.len(), 50_000 + 199_998);
    assert!(asked <= 64, "{asked} libraries were asked for");
    assert!(loaded.warnings.len() <= 33, "{} warnings", loaded.warnings.len());
}

#[test]
fn colours_of_a_ply_file_become_attributes() {
    let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        property uchar red\nproperty uchar green\nproperty uchar blue\nproperty uchar alpha\nproperty float heat_x\n\
        element face 2\nproperty float paint_r\nproperty list uchar int vertex_indices\nproperty ushort paint_g\nproperty ushort paint_b\n\
        end_header\n0 0 0 255 0 188 9 0.5\n1 0 0 0 255 188 9 1.5\n1 1 0 0 0 188 9 -2\n0 1 0 0 0 188 9 0\n\
        0.25 4 0 1 2 3 65535 0\n0.5 3 0 1 2 0 65535\n";
    let mesh = load_ply(text.as_bytes()).unwrap().mesh;
    let names: Vec<&str> = mesh.attributes.iter().map(|attribute| &*attribute.name).collect();
    // The list parts the first paint from the others, which cannot begin a group.
    assert_eq!(names, ["vertex_color", "vertex_heat", "face_paint_color"]);

    let value = |name: &str, triangle, at| mesh.attribute(name).unwrap().value(&mesh.triangles, triangle, at);
    let color = value("vertex_color", 0, Vec3::new(0.5, 0.25, 0.25));
    // Whole numbers are encoded as sRGB: 188 is 0.5029 linear.
    assert!(
        (color - Vec3::new(0.5, 0.25, 0.502_886)).abs().max_element() < 1e-5,
        "{color}"
    );
    assert_eq!(value("vertex_heat", 1, Vec3::Y), Vec3::splat(-2.0));
    // A quad is two triangles with one value.
    assert_eq!(
        [0, 1, 2].map(|triangle| value("face_paint_color", triangle, Vec3::X).x),
        [0.25, 0.25, 0.5]
    );
    // Three bytes and one float per vertex, one float per triangle.
    let bare = load_ply(
        text.replace("red", "other")
            .replace("heat_x", "heat")
            .replace("paint_r", "paint")
            .as_bytes(),
    );
    assert_eq!(
        mesh.heap_bytes() - bare.unwrap().mesh.heap_bytes(),
        4 * 3 + 4 * 4 + 3 * 4
    );
}

/// The area of a mesh and the sum of its triangles' areas with the sign of their winding about z: equal, if none lies
/// outside or over another.
fn areas(mesh: &MeshData) -> (f32, f32) {
    let area = |triangle: usize| {
        let [a, b, c] = mesh.corners(triangle);
        0.5 * (b - a).cross(c - a).z
    };
    let all = (0..mesh.triangles.len()).map(area);
    all.fold((0.0, 0.0), |(all, signed), area| (all + area.abs(), signed + area))
}

#[test]
fn a_concave_polygon_of_a_ply_file_is_cut_as_that_of_an_obj_file() {
    // A dart whose first corner sees not all others, an L of six corners, a convex quad and a triangle, side by side.
    let corners = [
        [-1.0, -1.0],
        [0.0, -0.2],
        [1.0, -1.0],
        [0.0, 1.0],
        [3.0, 1.0],
        [3.0, 2.0],
        [2.0, 2.0],
        [2.0, 0.0],
        [4.0, 0.0],
        [4.0, 1.0],
    ];
    let faces: [&[u8]; 4] = [&[0, 1, 2, 3], &[4, 5, 6, 7, 8, 9], &[7, 8, 9, 6], &[7, 8, 6]];
    let mut text = String::new();
    for [x, y] in corners {
        text += &format!("v {x} {y} 0\n");
    }
    for face in faces {
        let of_face: Vec<String> = face.iter().map(|corner| (corner + 1).to_string()).collect();
        text += &format!("f {}\n", of_face.join(" "));
    }
    let of_obj = obj_mesh(&text);
    let vertices = "element vertex 10\nproperty float x\nproperty float y\nproperty float z\n";
    let elements = "element face 4\nproperty float heat_x\nproperty list uchar int vertex_indices\n";
    for format in FORMATS {
        for is_first in [true, false] {
            let put_vertices = |body: &mut Body| {
                for [x, y] in corners {
                    for number in [x, y, 0.0f32] {
                        put!(body, number);
                    }
                }
            };
            let put_faces = |body: &mut Body| {
                for (number, face) in faces.iter().enumerate() {
                    put!(body, number as f32);
                    put!(body, face.len() as u8);
                    face.iter().for_each(|&corner| put!(body, i32::from(corner)));
                }
            };
            let header = if is_first {
                [vertices, elements]
            } else {
                [elements, vertices]
            };
            let bytes = ply(format, &header.concat(), |body| {
                if is_first {
                    put_vertices(body);
                    put_faces(body);
                } else {
                    put_faces(body);
                    put_vertices(body);
                }
            });
            let mesh = load_ply(&bytes).unwrap().mesh;
            let (all, signed) = areas(&mesh);
            let expected = 1.2 + 3.0 + 3.0 + 2.0;
            assert!(
                (all - expected).abs() < 1e-5 && (signed - expected).abs() < 1e-5,
                "{all} {signed}"
            );
            assert_eq!(mesh.triangles.len(), 2 + 4 + 2 + 1);
            assert_eq!(areas(&of_obj), (all, signed));
            // Each triangle has the value of its polygon.
            let heat = mesh.attribute("face_heat").expect("an attribute");
            let heats: Vec<f32> = (0..9)
                .map(|triangle| heat.value(&mesh.triangles, triangle, Vec3::X).x)
                .collect();
            assert_eq!(heats, [0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 3.0]);
        }
    }
}

#[test]
fn colours_of_an_obj_file_become_an_attribute() {
    let text = "v 0 0 0 1 0 0\nv 1 0 0 0 0.25 0\nv 1 1 0 0 0 1 0.5\nv 0 1 0 2\nf 4 1 2\nf 4 2 3\n";
    let loaded = obj(text).unwrap();
    assert_eq!(loaded.warnings, ["1 of 4 vertices: without a colour are white"]);
    let mesh = loaded.mesh;
    let color = mesh.attribute("vertex_color").expect("an attribute");
    let at = |triangle, place| color.value(&mesh.triangles, triangle, place);
    // Linear numbers, in the order of the mesh's own vertices; the alpha and the weight are none of them.
    assert_eq!(at(0, Vec3::X), Vec3::ONE);
    assert_eq!(at(0, Vec3::Y), Vec3::X);
    assert_eq!(at(0, Vec3::Z), Vec3::new(0.0, 0.25, 0.0));
    assert_eq!(at(1, Vec3::Z), Vec3::Z);
    assert_eq!(at(1, Vec3::new(0.0, 0.5, 0.5)), Vec3::new(0.0, 0.125, 0.5));
    let plain = obj_mesh("v 0 0 0\nv 1 0 0 2\nv 1 1 0 0.5 0.5\nf 1 2 3\n");
    assert!(plain.attributes.is_empty());
}

#[test]
fn colours_of_an_obj_file_are_no_brighter_than_light_may_be() {
    let loaded = obj("v 0 0 0 1e38 -1e38 0.5\nv 1 0 0 1 1 1\nv 1 1 0 1 1 1\nf 1 2 3\n").unwrap();
    assert_eq!(
        loaded.warnings,
        ["attributes: a number of `vertex_color` is beyond 1e12, and counts as that (and 1 times more)"]
    );
    let color = loaded.mesh.attribute("vertex_color").expect("an attribute");
    let first = color.value(&loaded.mesh.triangles, 0, Vec3::X);
    assert_eq!(first, Vec3::new(1e12, -1e12, 0.5));
}

#[test]
fn colours_of_an_obj_file_may_have_all_digits() {
    let loaded = obj("v 0 0 0 0.12500000000000000001 1e-30 1\nv 1 0 0 1 1 1\nv 1 1 0 1 1 1\nf 1 2 3\n").unwrap();
    assert_eq!(loaded.warnings, [""; 0]);
    let color = loaded.mesh.attribute("vertex_color").expect("an attribute");
    let first = color.value(&loaded.mesh.triangles, 0, Vec3::X);
    assert_eq!(first, Vec3::new(0.125, 1e-30, 1.0));
}

#[test]
fn a_number_with_something_behind_it_is_read_as_far_as_it_is_one() {
    let text = "v 3.1+e2 0 0.5f\nv 1 0 0\nv 0 -1e2x 0\nvt 0.25a 0.5.5\nvn 0 0 1e\nf 1/1/1 2/1/1 3/1/1\n";
    let loaded = obj(text).expect("is read");
    assert_eq!(
        loaded.mesh.positions,
        [Vec3::new(3.1, 0.0, 0.5), Vec3::X, Vec3::new(0.0, -100.0, 0.0)]
    );
    assert_eq!(loaded.mesh.uvs[0], Vec2::new(0.25, 0.5));
    assert_eq!(loaded.mesh.normals[0], Vec3::Z);
    assert_eq!(loaded.warnings.len(), 6, "{:?}", loaded.warnings);
    assert!(
        loaded.warnings[0].starts_with("line 1: `3.1+e2` is no number: 3.1 is taken"),
        "{:?}",
        loaded.warnings
    );
    for bad in [
        "v x 0 0\n",
        "v 0,5 0 0\n",
        "v + 0 0\n",
        "v .e5 0 0\n",
        "v 1 2\n",
        "vt e1\n",
        "v 1e99x 0 0\n",
    ] {
        let error = obj(&format!("v 1 0 0\n{bad}v 0 1 0\nf 1 2 3\n")).expect_err(bad);
        assert!(error.to_string().starts_with("line 2: "), "{error}");
    }
}
