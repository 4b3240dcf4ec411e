//! The reader of `serialized` meshes on files made here, whole, truncated and garbled, and on those of Mitsuba's own
//! scenes, which lie outside the repository and are skipped where they are not.

use std::io::Write;
use std::path::Path;

use crate::mesh_support::{Random, assert_sound};
use flate2::Compression;
use flate2::write::ZlibEncoder;
use glam::Vec3;
use sunroom::geometry::mesh::MeshData;
use sunroom::geometry::mesh_file::{LoadedMesh, MeshError};
use sunroom::geometry::serialized::SerializedFile;

const NORMALS: u32 = 1;
const UVS: u32 = 2;
const COLORS: u32 = 8;
const SINGLE: u32 = 0x1000;
const DOUBLE: u32 = 0x2000;

/// A grid of 2 x `count` vertices with something of everything; each second shape differs.
fn strip(count: u32) -> MeshData {
    let vertex = |i: u32| Vec3::new((i / 2) as f32, (i % 2) as f32, 0.25 * (i % 5) as f32);
    MeshData {
        positions: (0..2 * count).map(vertex).collect(),
        normals: (0..2 * count)
            .map(|i| (Vec3::Z + 0.1 * vertex(i)).normalize())
            .collect(),
        uvs: (0..2 * count).map(|i| vertex(i).truncate() / 7.0).collect(),
        triangles: (0..2 * count - 2)
            .map(|i| {
                if i % 2 == 0 {
                    [i, i + 2, i + 1]
                } else {
                    [i, i + 1, i + 2]
                }
            })
            .collect(),
        ..MeshData::default()
    }
}

/// The unpacked content of a shape.
fn content(version: u16, flags: u32, mesh: &MeshData) -> Vec<u8> {
    let mut bytes = flags.to_le_bytes().to_vec();
    if version == 4 {
        bytes.extend(b"a name\0");
    }
    bytes.extend((mesh.positions.len() as u64).to_le_bytes());
    bytes.extend((mesh.triangles.len() as u64).to_le_bytes());
    let mut numbers: Vec<f32> = mesh.positions.iter().flat_map(|p| p.to_array()).collect();
    if flags & NORMALS != 0 {
        numbers.extend(mesh.normals.iter().flat_map(|n| n.to_array()));
    }
    if flags & UVS != 0 {
        numbers.extend(mesh.uvs.iter().flat_map(|uv| uv.to_array()));
    }
    if flags & COLORS != 0 {
        numbers.extend(mesh.positions.iter().flat_map(|p| p.to_array()));
    }
    for number in numbers {
        if flags & DOUBLE != 0 {
            bytes.extend(f64::from(number).to_le_bytes());
        } else {
            bytes.extend(number.to_le_bytes());
        }
    }
    bytes.extend(mesh.triangles.iter().flatten().flat_map(|i| i.to_le_bytes()));
    bytes
}

fn file(version: u16, shapes: &[Vec<u8>]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut offsets = Vec::new();
    for shape in shapes {
        offsets.push(bytes.len() as u64);
        bytes.extend(0x041cu16.to_le_bytes());
        bytes.extend(version.to_le_bytes());
        let mut packer = ZlibEncoder::new(&mut bytes, Compression::default());
        packer.write_all(shape).unwrap();
        packer.finish().unwrap();
    }
    for offset in &offsets {
        bytes.extend(&offset.to_le_bytes()[..if version == 3 { 4 } else { 8 }]);
    }
    bytes.extend((offsets.len() as u32).to_le_bytes());
    bytes
}

fn load(bytes: &[u8], shape: u32) -> Result<LoadedMesh, MeshError> {
    let loaded = SerializedFile::open(bytes)?.load(shape)?;
    assert_sound(&loaded.mesh);
    Ok(loaded)
}

#[test]
fn every_shape_arrives_whole_whatever_the_version_and_precision() {
    for version in [3, 4] {
        for flags in [
            SINGLE,
            SINGLE | NORMALS,
            DOUBLE | UVS,
            DOUBLE | NORMALS | UVS | COLORS,
            SINGLE | COLORS | UVS | NORMALS,
        ] {
            let shapes = [strip(4), strip(300), strip(2)];
            let bytes = file(version, &shapes.each_ref().map(|mesh| content(version, flags, mesh)));
            assert_eq!(SerializedFile::open(&bytes).unwrap().count(), 3);
            for (shape, expected) in (0..).zip(&shapes) {
                let LoadedMesh { mesh, warnings } = load(&bytes, shape).unwrap();
                assert_eq!(warnings, [""; 0]);
                assert_eq!(mesh.positions, expected.positions);
                assert_eq!(mesh.triangles, expected.triangles);
                let has = |flag: u32| flags & flag != 0;
                assert_eq!(mesh.uvs, if has(UVS) { expected.uvs.clone() } else { vec![] });
                // Made unit once more, they may change in the last place.
                let as_given = mesh.normals.iter().zip(&expected.normals);
                assert_eq!(
                    as_given.into_iter().all(|(a, b)| (*a - *b).length() < 1e-6),
                    has(NORMALS)
                );
            }
        }
    }
}

#[test]
fn broken_files_give_one_clear_error() {
    let mesh = strip(3);
    let good = content(4, SINGLE, &mesh);
    let with = |change: fn(&mut MeshData)| {
        let mut mesh = mesh.clone();
        change(&mut mesh);
        file(4, &[content(4, SINGLE, &mesh)])
    };
    let mut many = good.clone();
    many[11..19].copy_from_slice(&u64::from(u32::MAX).to_le_bytes());
    let mut absurd = good.clone();
    absurd[11..19].copy_from_slice(&u64::MAX.to_le_bytes());
    let mut version = file(4, std::slice::from_ref(&good));
    version[2] = 7;
    let mut damaged = file(4, std::slice::from_ref(&good));
    damaged[4..8].fill(0xff);
    let mut astray = file(4, std::slice::from_ref(&good));
    let table = astray.len() - 12;
    astray[table..table + 8].fill(0xff);
    for (bytes, shape, message) in [
        (
            b"ply\n".to_vec(),
            0,
            "byte 0: expected a serialized mesh, found something else",
        ),
        (vec![], 0, "byte 0: expected a serialized mesh, found something else"),
        (
            version,
            0,
            "byte 2: expected a serialized mesh of version 3 or 4, found version 7",
        ),
        (
            vec![0x1c, 4, 4, 0, 9],
            0,
            "byte 5: the file ends early: a table of shapes belongs here",
        ),
        (
            vec![0x1c, 4, 4, 0, 9, 0, 0, 0],
            0,
            "byte 8: the file ends early: a table of shapes belongs here",
        ),
        (
            file(4, std::slice::from_ref(&good)),
            1,
            "shape index 1 is out of range: the file has 1",
        ),
        (
            with(|mesh| mesh.triangles[3][1] = 99),
            0,
            "byte 139 of the unpacked shape: vertex index 99 is out of range: the file has 6",
        ),
        (
            with(|mesh| mesh.positions[1].y = f32::NAN),
            0,
            "byte 27 of the unpacked shape: a vertex position is not finite",
        ),
        (with(|mesh| mesh.triangles.clear()), 0, "the file holds no triangles"),
        (
            file(4, &[many]),
            0,
            "of the unpacked shape: the file ends early: its counts promise more",
        ),
        (
            file(4, &[absurd]),
            0,
            "the number of vertices is beyond what this program reads",
        ),
        (
            damaged,
            0,
            "byte 0 of the unpacked shape: expected compressed data, found",
        ),
        (astray, 0, "expected the place of a shape, found 18446744073709551615"),
    ] {
        let error = load(&bytes, shape).unwrap_err().to_string();
        assert!(error.contains(message), "{error}\n{message}");
    }
}

#[test]
fn truncated_files_are_errors_and_garbled_ones_never_panic() {
    let mut random = Random(9);
    for version in [3, 4] {
        let shapes = [strip(4), strip(20)].map(|mesh| content(version, DOUBLE | NORMALS | UVS, &mesh));
        let whole = file(version, &shapes);
        for length in 0..whole.len() {
            // What happens to be read as a table may lead to a shape, but not to all of them.
            let cut = &whole[..length];
            assert!(
                (0..2).any(|shape| load(cut, shape).is_err()),
                "{length} of {}",
                whole.len()
            );
        }
        for _ in 0..3000 {
            let mut broken = whole.clone();
            for _ in 0..=random.below(3) {
                let at = random.below(broken.len());
                broken[at] = random.next() as u8;
            }
            for shape in 0..2 {
                // Sound, or an error.
                let _ = load(&broken, shape);
            }
            // Damage to the unpacked content, which compression would hide.
            let mut content = shapes[0].clone();
            let at = random.below(content.len());
            content[at] = random.next() as u8;
            let _ = load(&file(version, &[content]), 0);
        }
    }
}

#[test]
fn the_files_of_mitsubas_scenes() {
    let folder = Path::new(crate::ROOT).join("../shared/data/mitsuba-scenes/original/mitsuba-data");
    for (name, expected) in [
        ("tests/serialized/rectangle_normals_uv.serialized", &[(4, 2)][..]),
        (
            "common/meshes/matpreview.serialized",
            &[(289, 512), (2078, 3936), (29_439, 57_152)],
        ),
    ] {
        let Ok(bytes) = std::fs::read(folder.join(name)) else {
            eprintln!("skipped: there is no {name} in {}", folder.display());
            continue;
        };
        let count = SerializedFile::open(&bytes).unwrap().count();
        let sizes: Vec<(usize, usize)> = (0..count)
            .map(|shape| {
                let loaded = load(&bytes, shape).unwrap_or_else(|error| panic!("{name}, {shape}: {error}"));
                assert_eq!(loaded.warnings, [""; 0]);
                (loaded.mesh.positions.len(), loaded.mesh.triangles.len())
            })
            .collect();
        assert_eq!(sizes, expected, "{name}");
    }
}
