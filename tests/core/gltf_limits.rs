//! glTF files that say in few bytes that there is very much: what they get is limited, and the rest is said.

use std::io::Cursor;

use glam::Vec3;
use sunroom::document::{Category, Object};
use sunroom::gltf::files::take_apart;
use sunroom::gltf::scene::Imported;
use sunroom::gltf::{Gltf, GltfError};

use crate::gltf_support::{Parts, SQUARE, nothing_beside, open};

fn import(file: &Gltf) -> Result<Imported, GltfError> {
    let mut keep = |name: &str, _: &[u8]| Ok(name.to_owned());
    take_apart(file, &mut keep, &mut nothing_beside)
}

fn shapes(root: &Object) -> usize {
    root.objects()
        .filter(|object| object.category == Category::Shape)
        .count()
}

/// A square, and an accessor without bytes of so many places.
fn square_and_places(count: usize) -> Parts {
    let mut parts = Parts::default();
    parts.floats("VEC3", &SQUARE);
    parts.accessors.push(format!(
        r#"{{"componentType": 5126, "type": "VEC3", "count": {count}}}"#
    ));
    parts
}

const PRIMITIVE: &str = r#"{"attributes": {"POSITION": 0}, "mode": 6}"#;
const INSTANCED: &str = r#"{"mesh": 0, "extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": 1}}}}"#;

#[test]
fn instances_count_for_each_primitive_and_no_other_node_takes_their_place() {
    let file = |places: usize, primitives: usize, nodes: &[&str]| {
        let text = square_and_places(places).text(&format!(
            r#""meshes": [{{"primitives": [{}]}}], "nodes": [{}]"#,
            vec![PRIMITIVE; primitives].join(","),
            nodes.join(",")
        ));
        open(&text).expect("opens")
    };
    // 65 places of 1000 primitives are the most below 2^16; later nodes have none, and are not warned of one by one.
    let many = file(100, 1000, &[INSTANCED; 3]);
    let imported = import(&many).expect("imports");
    assert_eq!(shapes(&imported.root), 65_000);
    let [warning] = &imported.warnings[..] else {
        panic!("{:?}", imported.warnings)
    };
    assert!(warning.contains("more than 65536 instances"), "{warning}");
    assert_eq!(many.placed_meshes().expect("reads").len(), 65_000);
    // Nodes that are no instances take nothing from it.
    let mut nodes = vec![r#"{"mesh": 0}"#; 1 << 16];
    nodes.push(INSTANCED);
    let placed = file(2, 1, &nodes).placed_meshes().expect("reads");
    assert_eq!(placed.len(), (1 << 16) + 2);
}

#[test]
fn primitives_have_a_bounded_number_of_places() {
    // 2.25 million places, in 100 kB.
    let count = 1500;
    let text = square_and_places(1).text(&format!(
        r#""meshes": [{{"primitives": [{}]}}], "nodes": [{}]"#,
        vec![PRIMITIVE; count].join(","),
        vec![r#"{"mesh": 0}"#; count].join(",")
    ));
    let placed = open(&text).and_then(|gltf| gltf.placed_meshes()).expect("reads");
    assert_eq!(placed.len(), count + (1 << 20));
}

#[test]
fn key_frames_of_instances_count_for_each_of_them() {
    const KEYS: usize = 4096;
    let import_with = |places: usize| {
        let mut parts = square_and_places(places);
        let times: Vec<f32> = (0..KEYS).map(|key| key as f32).collect();
        let input = parts.floats("SCALAR", &times);
        let output = parts.floats("VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0].repeat(KEYS / 2));
        let text = parts.text(&format!(
            r#""meshes": [{{"primitives": [{PRIMITIVE}]}}], "nodes": [{INSTANCED}], "animations": [{{
                "channels": [{{"sampler": 0, "target": {{"node": 0, "path": "translation"}}}}],
                "samplers": [{{"input": {input}, "output": {output}, "interpolation": "LINEAR"}}]}}]"#
        ));
        import(&open(&text).expect("opens"))
    };
    assert_eq!(shapes(&import_with(2).expect("few enough").root), 2);
    // 2^25 of the 2^24 that may be.
    let error = import_with(8192).expect_err("too many");
    assert!(matches!(error, GltfError::Poses(_)), "{error}");
}

#[test]
fn light_that_two_pictures_make_has_the_size_of_one_of_them() {
    let mut parts = square_and_places(1);
    let uvs = parts.floats("VEC2", &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    let mut png = |width, height| {
        let mut bytes = Cursor::new(Vec::new());
        let image = image::RgbaImage::from_pixel(width, height, image::Rgba([255; 4]));
        let written = image.write_to(&mut bytes, image::ImageFormat::Png);
        written.expect("can be written");
        let view = parts.view(&bytes.into_inner(), "");
        format!(r#"{{"bufferView": {view}, "mimeType": "image/png"}}"#)
    };
    let (wide, high) = (png(200, 1), png(1, 300));
    let text = parts.text(&format!(
        r#""images": [{wide}, {high}], "textures": [{{"source": 0}}, {{"source": 1}}],
           "materials": [{{"alphaMode": "BLEND", "emissiveFactor": [1, 1, 1], "emissiveTexture": {{"index": 1}},
                           "pbrMetallicRoughness": {{"baseColorTexture": {{"index": 0}}}}}}],
           "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "TEXCOORD_0": {uvs}}}, "mode": 6, "material": 0}}]}}],
           "nodes": [{{"mesh": 0}}]"#
    ));
    let mut sizes = Vec::new();
    let mut keep = |name: &str, bytes: &[u8]| {
        if name.starts_with("picture") {
            let picture = image::load_from_memory(bytes).expect("a picture");
            sizes.push((picture.width(), picture.height()));
        }
        Ok(name.to_owned())
    };
    take_apart(&open(&text).expect("opens"), &mut keep, &mut nothing_beside).expect("imports");
    // The product would be 300 times as large as both together.
    assert!(sizes.contains(&(1, 300)), "{sizes:?}");
    assert!(sizes.iter().all(|(width, height)| width * height <= 300), "{sizes:?}");
}

/// A square of which the light is a picture in a file.
#[test]
fn the_picture_of_a_light_is_read_once() {
    let mut parts = Parts::default();
    parts.floats("VEC3", &SQUARE);
    let uvs = parts.floats("VEC2", &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    let text = parts.text(&format!(
        r#""images": [{{"uri": "light.png"}}], "textures": [{{"source": 0}}],
           "materials": [{{"emissiveFactor": [1, 0.5, 0.5], "emissiveTexture": {{"index": 0}}}}],
           "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "TEXCOORD_0": {uvs}}}, "mode": 6, "material": 0}}]}}],
           "nodes": [{{"mesh": 0}}]"#
    ));
    let mut reads = 0;
    let mut read = |_: &str| {
        reads += 1;
        let mut bytes = Cursor::new(Vec::new());
        let image = image::RgbImage::from_pixel(2, 2, image::Rgb([255; 3]));
        let written = image.write_to(&mut bytes, image::ImageFormat::Png);
        written.expect("can be written");
        Ok(bytes.into_inner())
    };
    let mut keep = |name: &str, _: &[u8]| Ok(name.to_owned());
    let file = Gltf::open(text.as_bytes(), &mut nothing_beside).expect("opens");
    let imported = take_apart(&file, &mut keep, &mut read).expect("imports");
    assert_eq!(imported.warnings, Vec::<String>::new());
    assert_eq!(reads, 1);
}

#[test]
fn morph_targets_are_limited_for_all_together() {
    // A fan of 2^16 vertices; its positions move it as well. 2^12 times that are 2^28.
    const VERTICES: usize = 1 << 16;
    let mut parts = Parts::default();
    let places = (0..VERTICES).flat_map(|vertex| [vertex as f32, (vertex * vertex % 251) as f32, 1.0]);
    parts.floats("VEC3", &places.collect::<Vec<f32>>());
    let read = |targets: usize, weight: &str| {
        let text = parts.text(&format!(
            r#""meshes": [{{"weights": [{}], "primitives": [{{"attributes": {{"POSITION": 0}}, "mode": 6, "targets": [{}]}}]}}]"#,
            vec![weight; targets].join(","),
            vec![r#"{"POSITION": 0}"#; targets].join(",")
        ));
        let loaded = open(&text).and_then(|file| file.mesh(0)).expect("a mesh");
        (loaded.mesh.positions[0], loaded.warnings)
    };
    assert_eq!(read(2, "0.5"), (Vec3::new(0.0, 0.0, 2.0), vec![]));
    let (first, warnings) = read(4097, "0.5");
    assert_eq!(first, Vec3::Z);
    assert!(
        warnings.iter().any(|warning| warning.contains("morph targets")),
        "{warnings:?}"
    );
    // Those without a weight cost nothing.
    assert_eq!(read(4097, "0"), (Vec3::Z, vec![]));
}
