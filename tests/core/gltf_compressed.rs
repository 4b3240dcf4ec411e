//! glTF files with compressed parts: what is read from them, and that broken ones cost neither the program nor memory.

use sunroom::document::{Category, Object};
use sunroom::gltf::Gltf;
use sunroom::gltf::files::take_apart;
use sunroom::gltf::scene::Imported;

use crate::gltf_support::{Parts, SQUARE, nothing_beside, open};

fn import(file: &Gltf) -> Imported {
    let mut keep = |name: &str, _: &[u8]| Ok(name.to_owned());
    take_apart(file, &mut keep, &mut nothing_beside).expect("imports")
}

fn shapes(root: &Object) -> usize {
    root.objects()
        .filter(|object| object.category == Category::Shape)
        .count()
}

/// Up to 16 elements of 12 bytes as a stream of EXT_meshopt_compression: differences of bytes, each in full.
fn attributes(elements: &[[u8; 12]]) -> Vec<u8> {
    let mut stream = vec![0xa0];
    for place in 0..12 {
        stream.push(3);
        let mut last = 0;
        let mut group = [0; 16];
        for (difference, element) in group.iter_mut().zip(elements) {
            let by = element[place].wrapping_sub(last);
            *difference = (by << 1) ^ 0u8.wrapping_sub(by >> 7);
            last = element[place];
        }
        stream.extend(group);
    }
    stream.extend([0; 32]);
    stream
}

fn square() -> Vec<[u8; 12]> {
    let corner = |corner: &[f32; 3]| {
        let bytes = corner.map(f32::to_le_bytes);
        bytes.as_flattened().try_into().expect("three numbers of four bytes")
    };
    SQUARE.as_chunks::<3>().0.iter().map(corner).collect()
}

/// A square whose corners are in a compressed view, and one that is not compressed; `change` changes the text.
fn with_meshopt(stream: &[u8], count: usize, extension: &str) -> String {
    let mut parts = Parts::default();
    let plain = parts.floats("VEC3", &SQUARE);
    let source = parts.view(stream, "");
    let length = 12 * count;
    let offset = parts.bytes.len() - stream.len();
    let packed = parts.view(&[], "");
    let compressed = parts.accessor(packed, 5126, "VEC3", count, "");
    let text = parts.text(&format!(
        r#""extensionsRequired": ["{extension}"],
           "meshes": [{{"primitives": [{{"attributes": {{"POSITION": {compressed}}}, "mode": 6}}]}},
                      {{"primitives": [{{"attributes": {{"POSITION": {plain}}}, "mode": 6}}]}}],
           "nodes": [{{"mesh": 0, "name": "packed"}}, {{"mesh": 1, "name": "plain"}}]"#
    ));
    assert_eq!((source, packed), (1, 2));
    // The last view is in a second buffer, which has no bytes.
    let empty = format!(
        r#"{{"buffer": 0, "byteOffset": {}, "byteLength": 0}}"#,
        parts.bytes.len()
    );
    let view = format!(
        r#"{{"buffer": 1, "byteLength": {length}, "byteStride": 12, "extensions": {{"{extension}": {{
            "buffer": 0, "byteOffset": {offset}, "byteLength": {}, "byteStride": 12, "count": {count}, "mode": "ATTRIBUTES"}}}}}}"#,
        stream.len()
    );
    assert!(text.contains(&empty));
    let second = format!(
        r#", {{"byteLength": {length}, "extensions": {{"{extension}": {{"fallback": true}}}}}}], "extensionsRequired""#
    );
    text.replace(&empty, &view)
        .replacen(r#"], "extensionsRequired""#, &second, 1)
}

#[test]
fn a_compressed_view_is_read_in_place_of_an_empty_buffer() {
    for extension in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
        let file = open(&with_meshopt(&attributes(&square()), 4, extension)).expect("opens");
        let [packed, plain] = [0, 1].map(|number| file.mesh(number).expect("is read").mesh);
        assert_eq!((packed.positions, packed.triangles), (plain.positions, plain.triangles));
        let imported = import(&file);
        assert_eq!(
            (shapes(&imported.root), imported.warnings.len()),
            (2, 0),
            "{:?}",
            imported.warnings
        );
    }
}

#[test]
fn a_view_that_cannot_be_unpacked_costs_what_is_in_it() {
    let whole = attributes(&square());
    let cases = [
        (&whole[..whole.len() - 1], 4, "too short"),
        (&whole[1..], 4, "unknown version"),
        (&whole[..], 1 << 24, "too short"),
    ];
    for (stream, count, message) in cases {
        let file = open(&with_meshopt(stream, count, "EXT_meshopt_compression")).expect("opens");
        let imported = import(&file);
        assert_eq!(shapes(&imported.root), 1, "{message}");
        let [warning] = &imported.warnings[..] else {
            panic!("{:?}", imported.warnings)
        };
        assert!(
            warning.contains(message) && warning.contains("buffer view 2"),
            "{warning}"
        );
    }
}

#[test]
fn the_same_bytes_are_not_unpacked_again_and_again() {
    let mut parts = Parts::default();
    let plain = parts.floats("VEC3", &SQUARE);
    let stream = attributes(&square());
    // 50,000 views of 236 bytes are more than twice the bytes of the buffer and a megabyte.
    let view = format!(
        r#", "extensions": {{"EXT_meshopt_compression": {{"buffer": 0, "byteOffset": 48, "byteLength": {}, "byteStride": 12,
            "count": 4, "mode": "ATTRIBUTES"}}}}"#,
        stream.len()
    );
    parts.view(&stream, "");
    let end = parts.bytes.len().next_multiple_of(4);
    for _ in 0..50_000 {
        parts.view(&[], &view);
    }
    let last = parts.accessor(50_001, 5126, "VEC3", 4, "");
    let text = parts.text(&format!(
        r#""meshes": [{{"primitives": [{{"attributes": {{"POSITION": {plain}}}, "mode": 6}}]}},
                      {{"primitives": [{{"attributes": {{"POSITION": {last}}}, "mode": 6}}]}}],
           "nodes": [{{"mesh": 0}}, {{"mesh": 1}}]"#
    ));
    let empty = format!(r#""byteOffset": {end}, "byteLength": 0"#);
    let imported = import(&open(&text.replace(&empty, r#""byteOffset": 0, "byteLength": 48"#)).expect("opens"));
    assert_eq!(shapes(&imported.root), 1);
    assert!(
        imported.warnings[0].contains("too many others"),
        "{:?}",
        imported.warnings
    );
}

/// The square and its coordinates (16 bits) of the encoder of Draco 1.5.7, plain and by edges.
const DRACO: [&str; 2] = [
    "445241434f02020100000002040100010200020301020009030000030402000102010001010003030130011003003482880400000000ff00\
     00000001010003030130011003003482a40000000000ffff00000000000000000000000000000000803f08",
    "445241434f02020101000000040201020000011fff0111ff011102ff0001000000010009030000020103040200010101010100030301300\
     11003002882980000000000ff0000000000000000000000000000000000803f0801010100030301300110030028822c0000000000ffff0000",
];

fn bytes(hex: &str) -> Vec<u8> {
    let pair = |at: usize| u8::from_str_radix(&hex[at..at + 2], 16).expect("digits");
    (0..hex.len()).step_by(2).map(pair).collect()
}

fn with_draco(stream: &[u8], vertices: usize, corners: usize) -> String {
    let mut parts = Parts::default();
    let plain = parts.floats("VEC3", &SQUARE);
    let view = parts.view(stream, "");
    let first = parts.accessors.len();
    for (component, kind, count) in [
        (5126, "VEC3", vertices),
        (5123, "VEC2", vertices),
        (5123, "SCALAR", corners),
    ] {
        let normalized = kind == "VEC2";
        parts.accessors.push(format!(
            r#"{{"componentType": {component}, "type": "{kind}", "count": {count}, "normalized": {normalized}}}"#
        ));
    }
    parts.text(&format!(
        r#""extensionsRequired": ["KHR_draco_mesh_compression"],
           "meshes": [{{"primitives": [{{"attributes": {{"POSITION": {first}, "TEXCOORD_0": {}}}, "indices": {},
               "extensions": {{"KHR_draco_mesh_compression": {{"bufferView": {view}, "attributes": {{"POSITION": 0, "TEXCOORD_0": 1}}}}}}}}]}},
               {{"primitives": [{{"attributes": {{"POSITION": {plain}}}, "mode": 6}}]}}],
           "nodes": [{{"mesh": 0}}, {{"mesh": 1}}]"#,
        first + 1,
        first + 2
    ))
}

#[test]
fn draco_primitives_are_read() {
    for stream in DRACO.map(bytes) {
        let file = open(&with_draco(&stream, 4, 6)).expect("opens");
        let mesh = file.mesh(0).expect("is read").mesh;
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (4, 2));
        for (position, uv) in mesh.positions.iter().zip(&mesh.uvs) {
            // The encoder has rounded the positions to eight bits.
            assert!(
                position.truncate().abs_diff_eq(*uv, 1e-5) && position.z == 0.0,
                "{position} {uv}"
            );
        }
        let area: f32 = (0..2).map(|triangle| mesh.area_of_triangle(triangle)).sum();
        assert!((area - 1.0).abs() < 1e-5, "{area}");
    }
}

#[test]
fn broken_draco_primitives_are_left_out() {
    let whole = bytes(DRACO[1]);
    let cases = [
        (whole[..60].to_vec(), 4, 6, "is damaged"),
        (whole.clone(), 5, 6, "has 4 vertices where 5 are promised"),
        (whole.clone(), 4, 9, "has 2 triangles where 9 indices are promised"),
        (whole.clone(), 4, 3, "is damaged"),
        // More than any memory.
        (whole.clone(), 1 << 60, 6, "needs"),
    ];
    for (stream, vertices, corners, message) in cases {
        let imported = import(&open(&with_draco(&stream, vertices, corners)).expect("opens"));
        assert_eq!(shapes(&imported.root), 1, "{message}");
        assert!(
            imported.warnings[0].contains(message),
            "{message}: {:?}",
            imported.warnings
        );
    }
    // Any byte may be wrong.
    for stream in DRACO.map(bytes) {
        for at in 0..stream.len() {
            for value in [0, 1, 0x7f, 0xff] {
                let mut broken = stream.clone();
                broken[at] = value;
                // Numbers that are far too large are read as well.
                let file = open(&with_draco(&broken, 4, 6)).expect("opens");
                let _ = file.mesh(0);
            }
        }
    }
}

#[test]
fn webp_pictures_become_png() {
    let image = image::RgbaImage::from_raw(2, 1, vec![255, 128, 0, 255, 0, 64, 255, 255]).expect("fits");
    let mut webp = std::io::Cursor::new(Vec::new());
    image
        .write_to(&mut webp, image::ImageFormat::WebP)
        .expect("can be written");
    let webp = webp.into_inner();
    for (bytes, is_whole) in [(&webp[..], true), (&webp[..webp.len() / 2], false)] {
        let mut parts = Parts::default();
        let positions = parts.floats("VEC3", &SQUARE);
        let uvs = parts.floats("VEC2", &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
        let view = parts.view(bytes, "");
        let text = parts.text(&format!(
            r#""extensionsRequired": ["EXT_texture_webp"], "images": [{{"bufferView": {view}, "mimeType": "image/webp"}}],
               "textures": [{{"extensions": {{"EXT_texture_webp": {{"source": 0}}}}}}],
               "materials": [{{"pbrMetallicRoughness": {{"baseColorTexture": {{"index": 0}}}}}}],
               "meshes": [{{"primitives": [{{"attributes": {{"POSITION": {positions}, "TEXCOORD_0": {uvs}}}, "mode": 6, "material": 0}}]}}],
               "nodes": [{{"mesh": 0}}]"#
        ));
        let mut pictures = Vec::new();
        let mut keep = |name: &str, bytes: &[u8]| {
            if name.starts_with("picture") {
                pictures.push((
                    name.to_owned(),
                    image::load_from_memory(bytes).expect("a picture").to_rgb8(),
                ));
            }
            Ok(name.to_owned())
        };
        let imported = take_apart(&open(&text).expect("opens"), &mut keep, &mut nothing_beside).expect("imports");
        match is_whole {
            true => {
                assert_eq!(imported.warnings, [""; 0]);
                let (name, picture) = &pictures[0];
                assert_eq!(
                    (name.as_str(), picture.as_raw().as_slice()),
                    ("picture-0.png", &[255, 128, 0, 0, 64, 255][..])
                );
            }
            false => assert!(
                imported.warnings[0].contains("picture 0 is left out"),
                "{:?}",
                imported.warnings
            ),
        }
    }
}
