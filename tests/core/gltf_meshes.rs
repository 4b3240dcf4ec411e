//! Meshes of glTF files written by hand: types of numbers, strides, sparse values, indices, and what primitives share.

use glam::{Vec2, Vec3};
use sunroom::geometry::attribute::AttributeValues;
use sunroom::geometry::mesh::{MeshData, TANGENT, TANGENT_SIGN};
use sunroom::geometry::ply::load_ply;
use sunroom::geometry::ply_write::binary_ply;
use sunroom::gltf::{Gltf, GltfError};
use sunroom::memory;

use crate::gltf_support::{Parts, SQUARE, open};

/// A square, drawn as `primitive` says beside its positions.
fn square(primitive: impl FnOnce(&mut Parts) -> String) -> MeshData {
    let mut parts = Parts::default();
    let positions = parts.floats("VEC3", &SQUARE);
    let more = primitive(&mut parts);
    let (attributes, rest) = more.split_once('|').unwrap_or((&more, ""));
    let meshes =
        format!(r#""meshes": [{{"primitives": [{{"attributes": {{"POSITION": {positions}{attributes}}}{rest}}}]}}]"#);
    open(&parts.text(&meshes))
        .and_then(|file| file.mesh(0))
        .expect("a mesh")
        .mesh
}

#[test]
fn indices_come_in_three_sizes_or_not_at_all() {
    let expected = vec![[0, 1, 2], [0, 2, 3]];
    let cases: [(u32, &[u8]); 3] = [
        (5121, &[0, 1, 2, 0, 2, 3]),
        (5123, &[0, 0, 1, 0, 2, 0, 0, 0, 2, 0, 3, 0]),
        (
            5125,
            &[0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0, 0, 3, 0, 0, 0],
        ),
    ];
    for (component, bytes) in cases {
        let mesh = square(|parts| {
            let view = parts.view(bytes, "");
            let indices = parts.accessor(view, component, "SCALAR", 6, "");
            format!(r#"|, "indices": {indices}"#)
        });
        assert_eq!(mesh.triangles, expected);
        // No normals are given: flat, which on a square is the same as smooth.
        assert!(mesh.normals.iter().all(|normal| normal.abs_diff_eq(Vec3::Z, 1e-6)));
    }
    assert_eq!(square(|_| String::new()).triangles, vec![[0, 1, 2]]);
    assert_eq!(
        square(|_| r#"|, "mode": 6"#.to_owned()).triangles,
        vec![[1, 2, 0], [2, 3, 0]]
    );
    assert_eq!(
        square(|_| r#"|, "mode": 5"#.to_owned()).triangles,
        vec![[0, 1, 2], [2, 1, 3]]
    );
}

#[test]
fn whole_numbers_stand_for_shares_and_strides_are_kept() {
    let mesh = square(|parts| {
        // Two bytes of coordinates in every four; normals as normalised signed bytes.
        let view = parts.view(
            &[0, 0, 9, 9, 255, 0, 9, 9, 255, 255, 9, 9, 0, 51, 9, 9],
            r#", "byteStride": 4"#,
        );
        let uvs = parts.accessor(view, 5121, "VEC2", 4, r#", "normalized": true"#);
        let view = parts.view(&[0, 0, 129, 0].repeat(4), r#", "byteStride": 4"#);
        let normals = parts.accessor(view, 5120, "VEC3", 4, r#", "normalized": true"#);
        let view = parts.view(&[0xff, 0xff, 0, 0, 0x33, 0x33, 0, 0].repeat(4), "");
        let colors = parts.accessor(view, 5123, "VEC4", 4, r#", "normalized": true"#);
        format!(r#", "TEXCOORD_0": {uvs}, "NORMAL": {normals}, "COLOR_0": {colors}"#)
    });
    assert_eq!(mesh.uvs, [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::new(0.0, 0.2)]);
    assert_eq!(mesh.normals, [Vec3::NEG_Z; 4]);
    let AttributeValues::F32(colors) = &mesh.attributes[0].values else {
        panic!("not floats")
    };
    assert_eq!(colors[..3], [1.0, 0.0, 0.2]);
}

#[test]
fn sparse_values_replace_others() {
    let mut parts = Parts::default();
    parts.floats("VEC3", &SQUARE);
    let places = parts.view(&[1, 0, 3, 0], "");
    let values = parts.view(&[5.0f32, 6.0, 7.0, -1.0, -2.0, -3.0].map(f32::to_le_bytes).concat(), "");
    let sparse = |count| {
        format!(
            r#", "sparse": {{"count": {count}, "indices": {{"bufferView": {places}, "componentType": 5123}},
                "values": {{"bufferView": {values}}}}}"#
        )
    };
    parts.accessors[0] = parts.accessors[0].replace('}', &format!("{}}}", sparse(2)));
    // Zeros but for the two.
    parts.accessors.push(format!(
        r#"{{"componentType": 5126, "type": "VEC3", "count": 4{}}}"#,
        sparse(2)
    ));
    parts.accessors.push(format!(
        r#"{{"componentType": 5126, "type": "VEC3", "count": 3{}}}"#,
        sparse(2)
    ));
    let meshes = (0..3).map(|a| format!(r#"{{"primitives": [{{"attributes": {{"POSITION": {a}}}}}]}}"#));
    let text = parts.text(&format!(r#""meshes": [{}]"#, meshes.collect::<Vec<_>>().join(",")));
    let file = open(&text).expect("opens");
    let positions = file.mesh(0).expect("a mesh").mesh.positions;
    assert_eq!(
        positions,
        [
            Vec3::ZERO,
            Vec3::new(5.0, 6.0, 7.0),
            Vec3::new(1.0, 1.0, 0.0),
            Vec3::new(-1.0, -2.0, -3.0)
        ]
    );
    let positions = file.mesh(1).expect("a mesh").mesh.positions;
    assert_eq!(
        positions,
        [
            Vec3::ZERO,
            Vec3::new(5.0, 6.0, 7.0),
            Vec3::ZERO,
            Vec3::new(-1.0, -2.0, -3.0)
        ]
    );
    let error = file.mesh(2).expect_err("element 3 of 3").to_string();
    assert!(error.contains("element 3"), "{error}");
}

#[test]
fn of_shared_vertices_a_mesh_has_those_it_uses() {
    let mut parts = Parts::default();
    // Two squares beside each other, and a vertex of neither that is nowhere.
    let mut corners: Vec<f32> = SQUARE.to_vec();
    corners.extend([f32::NAN; 3]);
    corners.extend(
        SQUARE
            .chunks(3)
            .flat_map(|corner| [corner[0] + 5.0, corner[1], corner[2]]),
    );
    let positions = parts.floats("VEC3", &corners);
    let normals = parts.floats("VEC3", &[[0.0, 0.0, 1.0]; 9].concat());
    let uvs: Vec<f32> = (0..9).flat_map(|vertex| [vertex as f32, 0.5]).collect();
    let uvs = parts.floats("VEC2", &uvs);
    let colors: Vec<f32> = (0..9).flat_map(|vertex| [vertex as f32, 1.0, 0.0]).collect();
    let colors = parts.floats("VEC3", &colors);
    // One position is replaced.
    let places = parts.view(&[7, 0], "");
    let values = parts.view(&[9.0f32, 9.0, 9.0].map(f32::to_le_bytes).concat(), "");
    let sparse = format!(
        r#", "sparse": {{"count": 1, "indices": {{"bufferView": {places}, "componentType": 5123}},
            "values": {{"bufferView": {values}}}}}}}"#
    );
    parts.accessors[positions] = parts.accessors[positions].replace('}', &sparse);
    let primitives = [[0, 1, 2, 0, 2, 3], [8, 7, 5, 7, 6, 5], [0, 4, 1, 0, 1, 2], [0, 1, 9, 0, 1, 2]].map(|triangles: [u8; 6]| {
        let view = parts.view(&triangles, "");
        let indices = parts.accessor(view, 5121, "SCALAR", 6, "");
        format!(
            r#"{{"attributes": {{"POSITION": {positions}, "NORMAL": {normals}, "TEXCOORD_0": {uvs}, "COLOR_0": {colors}}}, "indices": {indices}}}"#
        )
    });
    let file =
        open(&parts.text(&format!(r#""meshes": [{{"primitives": [{}]}}]"#, primitives.join(",")))).expect("opens");
    let first = file.mesh(0).expect("a mesh").mesh;
    assert_eq!(
        (first.positions.len(), first.triangles),
        (4, vec![[0, 1, 2], [0, 2, 3]])
    );
    let second = file.mesh(1).expect("a mesh").mesh;
    assert_eq!(second.triangles, [[3, 2, 0], [2, 1, 0]]);
    assert_eq!(
        second.positions[..3],
        [Vec3::new(5.0, 0.0, 0.0), Vec3::new(6.0, 0.0, 0.0), Vec3::splat(9.0)]
    );
    assert_eq!(second.normals, [Vec3::Z; 4]);
    assert_eq!(second.uvs, [5.0, 6.0, 7.0, 8.0].map(|u| Vec2::new(u, 0.5)));
    let AttributeValues::F32(colors) = &second.attributes[0].values else {
        panic!("not floats")
    };
    assert_eq!(colors[..], [5.0, 1.0, 0.0, 6.0, 1.0, 0.0, 7.0, 1.0, 0.0, 8.0, 1.0, 0.0]);
    for (number, part) in [(2, "vertex 4"), (3, "number 9")] {
        let error = file.mesh(number).expect_err(part).to_string();
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn elements_without_bytes_have_a_limit_for_all_together() {
    let zeros = |primitives: usize| {
        let primitive = r#"{"attributes": {"POSITION": 0}}"#;
        let text = format!(
            r#"{{"asset": {{"version": "2.0"}}, "accessors": [{{"componentType": 5126, "type": "VEC3", "count": 30000}}],
                "meshes": [{{"primitives": [{}]}}]}}"#,
            vec![primitive; primitives].join(",")
        );
        open(&text).expect("opens").mesh(0)
    };
    // Around 2^26 / 30000 = 2236.96.
    assert_eq!(zeros(2236).expect("few enough").mesh.positions.len(), 30000);
    let error = zeros(2237).expect_err("too many").to_string();
    assert!(error.contains("without a buffer"), "{error}");
}

#[test]
fn morph_targets_without_bytes_count_as_well() {
    let targets = |count: usize| {
        let text = format!(
            r#"{{"asset": {{"version": "2.0"}}, "accessors": [{{"componentType": 5126, "type": "VEC3", "count": 30000}}],
                "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "targets": [{}]}}]}}]}}"#,
            vec![r#"{"POSITION": 0}"#; count].join(",")
        );
        open(&text).expect("opens").mesh(0)
    };
    targets(10).expect("few enough");
    let error = targets(2236).expect_err("too many").to_string();
    assert!(error.contains("without a buffer"), "{error}");
}

/// The pages are never touched: only what is promised is tested.
#[test]
fn one_file_that_is_many_buffers_is_refused_before_they_are_all_read() {
    let buffers = [r#"{"byteLength": 1, "uri": "a"}"#; 10].join(",");
    let text = format!(r#"{{"asset": {{"version": "2.0"}}, "buffers": [{buffers}]}}"#);
    let half = memory::budget().limit() / 2;
    let mut reads = 0;
    let outcome = Gltf::open(text.as_bytes(), &mut |_| {
        reads += 1;
        Ok(vec![0; half as usize])
    });
    assert!(matches!(outcome, Err(GltfError::Memory(_))), "{outcome:?}");
    assert_eq!(reads, 1);
}

#[test]
fn texture_coordinates_and_colours_that_are_not_finite_are_zero() {
    let mesh = square(|parts| {
        let uvs = parts.floats("VEC2", &[0.0, 1.0, f32::NAN, 1.0, f32::INFINITY, 0.0, 1.0, 1.0]);
        let mut colors = [0.5; 12];
        (colors[3], colors[8]) = (f32::NEG_INFINITY, f32::NAN);
        let colors = parts.floats("VEC3", &colors);
        format!(r#", "TEXCOORD_0": {uvs}, "COLOR_0": {colors}"#)
    });
    assert_eq!(mesh.uvs, [Vec2::Y, Vec2::ZERO, Vec2::ZERO, Vec2::ONE]);
    let mut expected = [0.5; 12];
    (expected[3], expected[8]) = (0.0, 0.0);
    assert_eq!(mesh.attributes[0].values, AttributeValues::F32(expected.to_vec()));
}

#[test]
fn counts_offsets_and_strides_of_any_size_are_errors_of_the_accessor() {
    let mut parts = Parts::default();
    parts.floats("VEC3", &SQUARE);
    let places = parts.view(&[1, 0, 3, 0], "");
    let values = parts.view(&[5.0f32; 6].map(f32::to_le_bytes).concat(), "");
    let sparse = format!(
        r#", "sparse": {{"count": 2, "indices": {{"bufferView": {places}, "byteOffset": 0, "componentType": 5123}},
            "values": {{"bufferView": {values}, "byteOffset": 0}}}}}}"#
    );
    parts.accessors[0] = parts.accessors[0].replace('}', &format!(r#", "byteOffset": 0{sparse}"#));
    let indices = parts.view(&[0, 1, 2], "");
    parts.accessor(indices, 5121, "SCALAR", 3, "");
    let text = parts.text(r#""meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]"#);
    let read = |text: &str| open(text).and_then(|file| file.mesh(0));
    read(&text).expect("is good");
    // One number at a time is wrong, among them some whose product with a size of 12 or 2 bytes, or sum with an offset,
    // wraps around to a small number.
    let numbers = [
        u64::MAX,
        u64::MAX - 11,
        1 << 63,
        (1 << 63) + 1,
        (1 << 62) + 1,
        u64::MAX / 12 + 1,
        u64::MAX / 12 + 2,
        u64::from(u32::MAX) + 1,
        u64::from(u32::MAX),
    ];
    let places = [
        (r#""type": "VEC3", "count": 4"#, "accessor 0"),
        (r#""sparse": {"count": 2"#, "accessor 0"),
        (r#""type": "SCALAR", "count": 3"#, "accessor 1"),
        (r#""byteOffset": 0, "sparse""#, "accessor 0"),
        (r#""byteOffset": 0, "componentType""#, "accessor 0"),
        (r#""byteOffset": 0}}"#, "accessor 0"),
        (r#""byteOffset": 0, "byteLength""#, "buffer view 0"),
        (r#""byteLength": 48"#, "buffer view 0"),
    ];
    for (old, part) in places {
        assert_eq!(text.matches(old).count(), 1, "{old}");
        let digit = old.rfind(|c: char| c.is_ascii_digit()).expect("has a number");
        let first = old[..=digit].rfind(' ').expect("a space before it") + 1;
        for number in numbers {
            let bad = text.replace(old, &format!("{}{number}{}", &old[..first], &old[digit + 1..]));
            let error = read(&bad).expect_err(&bad).to_string();
            assert!(error.contains(part), "{old} {number}: {error}");
        }
    }
    for stride in [0, 1, 11, u64::MAX, u64::MAX / 3 + 1] {
        let strided = text.replace(
            r#""byteLength": 48"#,
            &format!(r#""byteLength": 48, "byteStride": {stride}"#),
        );
        let error = read(&strided)
            .expect_err("elements overlap or reach too far")
            .to_string();
        assert!(error.contains("accessor 0"), "{stride}: {error}");
    }
}

/// Only the vertices without a usable normal get one of the triangles.
#[test]
fn one_bad_normal_leaves_the_others() {
    for bad in [[0.0; 3], [f32::NAN, 0.0, 1.0], [f32::INFINITY, 0.0, 0.0]] {
        let mut parts = Parts::default();
        let positions = parts.floats("VEC3", &SQUARE);
        let normals = parts.floats(
            "VEC3",
            &[[1.0, 0.0, 0.0], bad, [0.0, 2.0, 0.0], [0.0, 0.0, -1.0]].concat(),
        );
        let meshes = format!(
            r#""meshes": [{{"primitives": [{{"attributes": {{"POSITION": {positions}, "NORMAL": {normals}}}, "mode": 6}}]}}]"#
        );
        let loaded = open(&parts.text(&meshes))
            .and_then(|file| file.mesh(0))
            .expect("a mesh");
        assert_eq!(loaded.mesh.normals, [Vec3::X, Vec3::Z, Vec3::Y, Vec3::NEG_Z]);
        let [warning] = &loaded.warnings[..] else {
            panic!("{:?}", loaded.warnings)
        };
        assert!(
            warning.contains("primitive 0") && warning.contains("normal"),
            "{warning}"
        );
    }
}

/// Tangents are kept where a normal map asks for them, and come through the file of the mesh.
#[test]
fn tangents_are_kept_for_normal_maps() {
    let mesh = |material: &str, attributes: &str| {
        let mut parts = Parts::default();
        parts.floats("VEC3", &SQUARE);
        parts.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
        parts.floats("VEC2", &[0.0; 8]);
        parts.floats("VEC4", &[0.0, 2.0, 0.0, -1.0].repeat(4));
        let text = parts.text(&format!(
            r#""materials": [{{{material}}}], "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "TEXCOORD_0": 2, "TANGENT": 3{attributes}}},
                "material": 0, "mode": 6}}]}}]"#
        ));
        open(&text).and_then(|file| file.mesh(0)).expect("a mesh").mesh
    };
    let map = r#""normalTexture": {"index": 0}"#;
    let with_tangents = mesh(map, r#", "NORMAL": 1"#);
    let names: Vec<&str> = with_tangents
        .attributes
        .iter()
        .map(|attribute| &*attribute.name)
        .collect();
    assert_eq!(names, [TANGENT, TANGENT_SIGN]);
    assert_eq!(
        with_tangents.attributes[0].values,
        AttributeValues::F32([0.0, 1.0, 0.0].repeat(4))
    );
    assert_eq!(with_tangents.attributes[1].values, AttributeValues::F32(vec![-1.0; 4]));
    let again = load_ply(&binary_ply(&with_tangents)).expect("a PLY file").mesh;
    assert_eq!(again.attributes, with_tangents.attributes);
    for (material, attributes) in [("", r#", "NORMAL": 1"#), (map, "")] {
        assert_eq!(mesh(material, attributes).attributes, []);
    }
}

#[test]
fn morph_targets_shape_a_mesh_as_its_weights_at_rest_say() {
    let mut parts = Parts::default();
    parts.floats("VEC3", &SQUARE);
    parts.floats("VEC3", &[0.0, -1.0, 0.0].repeat(4));
    parts.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4));
    let text = |weights: &str| {
        parts.text(&format!(
            r#""meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "mode": 6, "targets": [{{"POSITION": 1}}, {{"POSITION": 2}}]}}]{weights}}}]"#
        ))
    };
    let first = |weights: &str| {
        let mesh = open(&text(weights)).and_then(|file| file.mesh(0)).expect("a mesh").mesh;
        mesh.positions[0]
    };
    assert_eq!(first(""), Vec3::ZERO);
    assert_eq!(first(r#", "weights": [0.5, 2]"#), Vec3::new(0.0, -0.5, 2.0));
}
