//! Files whose content would take far more memory or time than their size promises: products of two counts, and what is
//! named many times.

use std::collections::HashMap;
use std::io;
use std::path::Path;
use std::time::{Duration, Instant};

use crate::gltf_support::{Parts, SQUARE, nothing_beside, open};
use crate::mesh_support::assert_sound;
use sunroom::document::{self, Document, Reader};
use sunroom::geometry::mesh_file::MeshError;
use sunroom::geometry::obj::load_obj;
use sunroom::geometry::ply::load_ply;
use sunroom::gltf::files::take_apart;
use sunroom::gltf::scene::Imported;
use sunroom::render::layered_image::LayeredImage;

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";

#[test]
fn a_library_is_read_once_however_often_it_is_named() {
    let mut text = TRIANGLE.to_owned();
    for length in 1..=64 {
        text += &format!("mtllib{}\n", " m.mtl".repeat(length));
    }
    let mut asked: HashMap<String, usize> = HashMap::new();
    let loaded = load_obj(text.as_bytes(), &mut |name| {
        *asked.entry(name.to_owned()).or_default() += 1;
        match name {
            "m.mtl" => Ok(b"newmtl a\nKd 1 0 0\n".to_vec()),
            _ => Err(io::ErrorKind::NotFound.into()),
        }
    });
    let mesh = loaded.expect("loads").mesh;
    assert_sound(&mesh);
    assert_eq!(mesh.materials.len(), 1);
    assert_eq!(asked["m.mtl"], 1);
    assert!(
        asked.len() <= 64 && asked.values().all(|&times| times == 1),
        "{asked:?}"
    );
}

#[test]
fn materials_are_read_as_far_as_triangles_can_count_them() {
    let text = format!("{TRIANGLE}mtllib one.mtl\nmtllib two.mtl\n");
    let mut asked = Vec::new();
    let loaded = load_obj(text.as_bytes(), &mut |name| {
        asked.push(name.to_owned());
        Ok(b"newmtl a\n".repeat(70_000))
    });
    let loaded = loaded.expect("loads");
    assert_eq!(loaded.mesh.materials.len(), 1 << 16);
    assert_eq!(asked, ["one.mtl"]);
    assert_eq!(
        loaded.warnings,
        [
            "one.mtl line 65537: further materials are ignored",
            "line 7: further material libraries are ignored"
        ]
    );
}

#[test]
fn values_of_a_face_count_in_the_budget_for_each_of_its_triangles() {
    // A polygon of four million corners with forty thousand values: 640 GB from 5 MB.
    const CORNERS: usize = 4_000_000;
    const VALUES: usize = 40_000;
    let mut file =
        b"ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty char x\nproperty char y\nproperty char z\n\
        element face 1\nproperty list uint uchar vertex_indices\n"
            .to_vec();
    for i in 0..VALUES {
        file.extend(format!("property char a{i}_x\n").bytes());
    }
    file.extend(b"end_header\n\0\0\0\x01\0\0\0\x01\0");
    file.extend((CORNERS as u32).to_le_bytes());
    file.extend([0, 1, 2].into_iter().cycle().take(CORNERS));
    file.extend([0; VALUES]);
    match load_ply(&file) {
        Err(MeshError::Memory { what, shortage }) => {
            assert_eq!(what, format!("the attributes of {} triangles", CORNERS - 2));
            assert!(shortage.asked >= 4 * (VALUES * (CORNERS - 3)) as u64, "{shortage}");
        }
        other => panic!("{:?}", other.map(|loaded| loaded.warnings)),
    }
}

#[test]
fn strips_beside_faces_leave_the_values_of_faces_out() {
    let file = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nproperty float p_x\n\
        element tristrips 1\nproperty list int int vertex_indices\n\
        element face 1\nproperty list uchar int vertex_indices\nproperty float q_x\nend_header\n\
        0 0 0 1\n1 0 0 2\n0 1 0 3\n3 0 1 2\n3 0 1 2 0.5\n";
    let loaded = load_ply(file.as_bytes()).expect("loads");
    assert_sound(&loaded.mesh);
    assert_eq!(loaded.mesh.triangles.len(), 2);
    let names: Vec<&str> = loaded
        .mesh
        .attributes
        .iter()
        .map(|attribute| attribute.name.as_str())
        .collect();
    assert_eq!(names, ["vertex_p"]);
    assert_eq!(
        loaded.warnings,
        ["attribute `face_q`: is ignored, because triangles of strips have no values"]
    );
    // Strips without triangles take nothing away.
    let file = file.replace("3 0 1 2\n3", "1 0\n3");
    let loaded = load_ply(file.as_bytes()).expect("loads");
    assert_eq!(loaded.mesh.attributes.len(), 2);
    assert_eq!(loaded.warnings, [""; 0]);
}

fn parse(text: String) -> Document {
    document::parse_str(text, Path::new("/nowhere/scene.xml"), &[])
}

/// The number of messages, and of those whose help begins with these words.
fn helped(document: &Document, words: &str) -> (usize, usize) {
    let list = &document.diagnostics.list;
    let begins = |help: &Option<String>| help.as_ref().is_some_and(|help| help.contains(words));
    (list.len(), list.iter().filter(|message| begins(&message.help)).count())
}

#[test]
fn circles_are_explained_while_there_are_few_messages() {
    // To find a place takes time in proportion to the file, and a file may have very many circles.
    let closing = "<ref id='a'/>".repeat(200);
    let scene = parse(format!(
        "<scene version='3.0.0'><bsdf type='twosided' id='a'><ref id='b'/></bsdf><bsdf type='twosided' id='b'>{closing}</bsdf></scene>"
    ));
    assert_eq!(helped(&scene, "`b` is referred to at"), (200, 100));

    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("scene.xml");
    let closing = "<include filename='scene.xml'/>".repeat(200);
    let inner = format!("<scene version='3.0.0'>{closing}</scene>");
    std::fs::write(folder.path().join("inner.xml"), inner).expect("a writable folder");
    std::fs::write(&path, "<scene version='3.0.0'><include filename='inner.xml'/></scene>").expect("a writable folder");
    let scene = document::load(&path, &[]).expect("text");
    assert_eq!(helped(&scene, "is included at"), (200, 100));
}

#[test]
fn names_that_may_be_meant_are_sought_while_there_are_few_messages() {
    let uses = "<bsdf type='diffuse'><float name='a' value='$alhpa'/></bsdf>".repeat(200);
    let scene = parse(format!(
        "<scene version='3.0.0'><default name='alpha' value='1'/>{uses}</scene>"
    ));
    assert_eq!(helped(&scene, "did you mean `alpha`?"), (200, 100));
    assert_eq!(helped(&scene, "give it with `-D alhpa=...`"), (200, 100));
    let scene = parse(format!("<scene version='3.0.0'>{}</scene>", "<shpae/>".repeat(200)));
    assert_eq!(helped(&scene, "did you mean `shape`?"), (200, 100));
}

fn import(text: &str) -> Imported {
    let gltf = open(text).expect("opens");
    let mut keep = |name: &str, _: &[u8]| Ok(name.to_owned());
    take_apart(&gltf, &mut keep, &mut nothing_beside).expect("imports")
}

#[test]
fn a_long_name_of_a_mesh_is_not_repeated_as_it_is() {
    let mut parts = Parts::default();
    parts.floats("VEC3", &SQUARE);
    let name = "n".repeat(100_000);
    let scene = import(&parts.text(&format!(
        r#""meshes": [{{"name": "{name}", "primitives": [{{"attributes": {{"POSITION": 0}}}}]}}], "nodes": [{}]"#,
        [r#"{"mesh": 0}"#; 3].join(",")
    )));
    let ids = scene.root.objects().filter_map(|object| object.id.as_ref());
    let named: Vec<usize> = ids.map(|id| id.len()).filter(|&length| length > 200).collect();
    assert_eq!(named, [256, 258, 258]);
}

#[test]
fn primitives_of_the_same_vertices_become_a_bounded_number_of_meshes() {
    // A megabyte, of which each primitive makes three.
    let vertex = |i: u32| [i % 1000, i * 7 % 977, i % 13].map(|x| x as f32);
    let positions: Vec<f32> = (0..90_000).flat_map(vertex).collect();
    let mut parts = Parts::default();
    parts.floats("VEC3", &positions);
    let text = |primitives: usize| {
        let primitives = vec![r#"{"attributes": {"POSITION": 0}}"#; primitives].join(",");
        parts.text(&format!(
            r#""meshes": [{{"primitives": [{primitives}]}}], "nodes": [{{"mesh": 0}}]"#
        ))
    };
    for (primitives, expected) in [(10, 10), (60, 32)] {
        let text = text(primitives);
        let scene = import(&text);
        let shapes = scene.root.objects().filter(|object| object.plugin == "ply");
        assert_eq!(shapes.count(), expected);
        let warned = scene
            .warnings
            .iter()
            .any(|warning| warning.contains("far larger than its buffers"));
        assert_eq!(warned, primitives > expected, "{:?}", scene.warnings);
        let placed = open(&text).and_then(|gltf| gltf.placed_meshes()).expect("opens");
        assert_eq!(placed.len(), expected);
    }
}

/// A square at a node, behind so many nodes with nothing.
fn placed_square(parts: &mut Parts, others: usize) -> String {
    let positions = parts.floats("VEC3", &SQUARE);
    let others = "{},".repeat(others);
    format!(
        r#""meshes": [{{"primitives": [{{"attributes": {{"POSITION": {positions}}}}}]}}], "nodes": [{others}{{"mesh": 0}}]"#
    )
}

#[test]
fn curves_are_looked_through_once_for_all_that_they_move() {
    const MANY: usize = 30_000;
    let mut parts = Parts::default();
    let times: Vec<f32> = (0..MANY).map(|i| i as f32).collect();
    parts.floats("SCALAR", &times);
    parts.floats("VEC3", &[times.as_slice(); 3].concat());
    let channel = |node: usize| format!(r#"{{"sampler": 0, "target": {{"node": {node}, "path": "translation"}}}}"#);
    let channels: Vec<String> = (0..MANY).map(channel).collect();
    let rest = placed_square(&mut parts, MANY);
    let scene = import(&parts.text(&format!(
        r#"{rest}, "animations": [{{"samplers": [{{"input": 0, "output": 1}}], "channels": [{}]}}]"#,
        channels.join(",")
    )));
    assert_eq!(scene.warnings, [""; 0]);
}

#[test]
fn curves_of_the_same_numbers_are_bounded_by_the_buffers() {
    const KEYS: usize = 10_000;
    let times: Vec<f32> = (0..KEYS).map(|i| i as f32).collect();
    for (count, is_bounded) in [(100, false), (400, true)] {
        let mut parts = Parts::default();
        parts.floats("SCALAR", &times);
        let bytes = [times.as_slice(); 3].concat();
        let bytes: Vec<u8> = bytes.iter().flat_map(|number| number.to_le_bytes()).collect();
        let view = parts.view(&bytes, "");
        let animation = |node: usize| {
            let output = parts.accessor(view, 5126, "VEC3", KEYS, "");
            format!(
                r#"{{"samplers": [{{"input": 0, "output": {output}}}],
                    "channels": [{{"sampler": 0, "target": {{"node": {node}, "path": "translation"}}}}]}}"#
            )
        };
        let animations: Vec<String> = (0..count).map(animation).collect();
        let rest = placed_square(&mut parts, count);
        let scene = import(&parts.text(&format!(r#"{rest}, "animations": [{}]"#, animations.join(","))));
        let left_out = "is one of too many for the size of the buffers; so it is with 255 other animations";
        let said = scene.warnings.iter().any(|warning| warning.contains(left_out));
        assert_eq!(said, is_bounded, "{:?}", scene.warnings);
    }
}

#[test]
fn an_object_has_thousands_of_parameters_at_most() {
    let given = |count: usize| {
        let floats: String = (0..count).map(|i| format!("<float name='p{i}' value='1'/>")).collect();
        parse(format!(
            "<scene version='3.0.0'><bsdf type='diffuse'>{floats}</bsdf></scene>"
        ))
    };
    assert!(!given(4096).diagnostics.has_errors());
    let scene = given(5000);
    let bsdf = scene.root.objects().next().expect("a bsdf");
    assert_eq!(bsdf.properties.len(), 4096);
    let said = scene.diagnostics.list.iter().map(|message| message.message.as_str());
    let expected = "bsdf `diffuse` has more than 4096 parameters: the others are left out";
    assert_eq!(said.collect::<Vec<_>>(), [expected]);
}

#[test]
fn very_many_parameters_without_effect_are_counted() {
    // Each reading of the plugin says it of each parameter: 12 million sentences.
    const READINGS: usize = 3000;
    let floats: String = (0..4000).map(|i| format!("<float name='p{i}' value='1'/>")).collect();
    let scene = parse(format!(
        "<scene version='3.0.0'><bsdf type='diffuse'>{floats}</bsdf></scene>"
    ));
    let (mut diagnostics, index) = (scene.diagnostics.clone(), scene.index());
    let bsdf = scene.root.objects().next().expect("a bsdf");
    let begin = Instant::now();
    for _ in 0..READINGS {
        Reader::new(&index, bsdf, &mut diagnostics).finish();
    }
    assert!(begin.elapsed() < Duration::from_secs(2), "{:?}", begin.elapsed());
    assert_eq!(
        (diagnostics.list.len(), diagnostics.warning_count()),
        (1000, 4000 * READINGS)
    );
}

#[test]
fn a_picture_may_have_very_many_layers() {
    const LAYERS: usize = 60_000;
    let mut image = LayeredImage::new(1, 1);
    for i in 0..LAYERS {
        image.add_float(&format!("a layer that is called {i}.Y"), vec![0.0]);
    }
    let begin = Instant::now();
    assert_eq!(image.layers().len(), LAYERS);
    assert!(begin.elapsed() < Duration::from_secs(2), "{:?}", begin.elapsed());
}
