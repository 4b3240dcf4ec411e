//! Lamps with measured intensities in glTF files: EXT_lights_ies.

use glam::{DVec3, Mat4, Vec3};
use sunroom::document::{Category, Object, TransformOp, Value};
use sunroom::gltf::Gltf;
use sunroom::gltf::files::take_apart;
use sunroom::photometry::read_profile;

/// A lamp of type C or B whose intensity is 1000 cd along the beam, and 500 cd in one direction across it: at the
/// horizontal angle 90 degrees of type C, and 90 degrees to the side of type B.
fn profile(kind: u32) -> String {
    let planes = match kind {
        1 => "0 90\n0 90 180 270 360\n1000 0\n1000 500\n1000 0\n1000 0\n1000 0\n",
        _ => "0 90\n-90 0 90\n0 0\n1000 0\n500 0\n",
    };
    let horizontals = if kind == 1 { 5 } else { 3 };
    format!("IES:LM-63-2019\nTILT=NONE\n1 -1 1 2 {horizontals} {kind} 2 0 0 0\n1 1 10\n{planes}")
}

/// The warning about a file of lamps alone.
const NOTHING_ELSE: &str = "the scene has no triangles";

/// Opens a file whose nodes have profiles, with these files beside it. Returns the emitters, the stored files and the
/// warnings.
fn opened(lights: &str, nodes: &str, beside: &[(&str, String)]) -> (Vec<Object>, Vec<(String, Vec<u8>)>, Vec<String>) {
    let text = format!(
        r#"{{"asset": {{"version": "2.0"}}, "extensionsRequired": ["EXT_lights_ies"], "scenes": [{{"nodes": [0, 1]}}],
        "extensions": {{"EXT_lights_ies": {{"lights": [{lights}]}},
            "KHR_lights_punctual": {{"lights": [{{"type": "point", "intensity": 683}}]}}}},
        "nodes": [{nodes}]}}"#
    );
    let mut read = |name: &str| {
        let found = beside.iter().find(|(known, _)| *known == name);
        let content = found.ok_or(std::io::ErrorKind::NotFound)?;
        Ok(content.1.clone().into_bytes())
    };
    let file = Gltf::open(text.as_bytes(), &mut read).expect("it opens");
    let mut files = Vec::new();
    let mut keep = |name: &str, bytes: &[u8]| {
        files.push((name.to_owned(), bytes.to_owned()));
        Ok(name.to_owned())
    };
    let imported = take_apart(&file, &mut keep, &mut read).expect("it is imported");
    let emitters = imported
        .root
        .objects()
        .filter(|object| object.category == Category::Emitter);
    (emitters.cloned().collect(), files, imported.warnings)
}

fn value<'a>(object: &'a Object, name: &str) -> Option<&'a Value> {
    object
        .properties
        .iter()
        .find(|property| property.name == name)
        .map(|property| &property.value)
}

fn world(object: &Object) -> Mat4 {
    match value(object, "to_world") {
        Some(Value::Transform(ops)) => match ops[..] {
            [TransformOp::Matrix(matrix)] => matrix,
            _ => panic!("{ops:?}"),
        },
        None => Mat4::IDENTITY,
        other => panic!("{other:?}"),
    }
}

#[test]
fn lamps_shine_along_minus_z_with_their_sides_where_the_extension_says() {
    for (kind, side) in [(1, Vec3::Y), (2, Vec3::NEG_Y)] {
        let node = r#"{"name": "lamp", "extensions": {"EXT_lights_ies": {"light": 0}}}, {}"#;
        let beside = [("a lamp.ies", profile(kind))];
        let (emitters, files, warnings) = opened(r#"{"uri": "a%20lamp.ies"}"#, node, &beside);
        assert_eq!(warnings, [NOTHING_ELSE]);
        let [lamp] = &emitters[..] else { panic!("{emitters:?}") };
        assert_eq!((lamp.plugin.as_str(), lamp.id.as_deref()), ("ies", Some("lamp")));
        let [(name, bytes)] = &files[..] else {
            panic!("{files:?}")
        };
        assert_eq!(value(lamp, "filename"), Some(&Value::String(name.clone())));
        assert_eq!(value(lamp, "scale"), None);
        let distribution = read_profile(bytes).expect("a lamp");
        let lamp_from_node = world(lamp).inverse();
        let toward = |direction: Vec3| {
            let local: DVec3 = lamp_from_node.transform_vector3(direction).as_dvec3();
            distribution.intensity(local.normalize())
        };
        assert!((toward(Vec3::NEG_Z) - 1000.0).abs() < 1e-6);
        assert!((toward(side) - 500.0).abs() < 1e-6, "type {kind}: {}", toward(side));
        assert!(toward(-side) < 1e-6 && toward(Vec3::X) < 1e-6 && toward(Vec3::Z) < 1e-6);
    }
}

#[test]
fn multipliers_and_colours_scale_the_lamp_and_equal_profiles_share_a_file() {
    let bytes = profile(1);
    let data: String = bytes.bytes().map(|byte| format!("%{byte:02X}")).collect();
    let lights = format!(r#"{{"name": "downlight", "uri": "data:application/x-ies-lm-63,{data}"}}"#);
    let nodes = r#"{"extensions": {"EXT_lights_ies": {"light": 0, "multiplier": 2.5, "color": [1, 0.5, 0]},
            "KHR_lights_punctual": {"light": 0}}},
        {"translation": [1, 2, 3], "scale": [3, 3, 3], "extensions": {"EXT_lights_ies": {"light": 0}}}"#;
    let (emitters, files, warnings) = opened(&lights, nodes, &[]);
    assert_eq!(warnings, [NOTHING_ELSE]);
    // The light beside the first profile is for programs without profiles.
    let [first, second] = &emitters[..] else {
        panic!("{emitters:?}")
    };
    assert_eq!(files.len(), 1);
    assert_eq!(files[0].1, bytes.as_bytes());
    assert_eq!(value(first, "filename"), value(second, "filename"));
    assert_eq!(value(first, "scale"), Some(&Value::Rgb(Vec3::new(2.5, 1.25, 0.0))));
    assert_eq!(first.id.as_deref(), Some("downlight"));
    assert_eq!(world(second).transform_point3(Vec3::ZERO), Vec3::new(1.0, 2.0, 3.0));
}

#[test]
fn profiles_that_cannot_be_read_leave_the_light_beside_them() {
    let damaged = "IES:LM-63-2019\nTILT=NONE\n1 -1 1 2 x".to_owned();
    let nodes = r#"{"name": "lamp", "extensions": {"EXT_lights_ies": {"light": 0}, "KHR_lights_punctual": {"light": 0}}},
        {"extensions": {"EXT_lights_ies": {"light": 1}}}"#;
    for (lights, said) in [
        (r#"{"uri": "lost.ies"}, {}"#, "lost.ies"),
        (r#"{"uri": "damaged.ies"}, {}"#, "line 3"),
        (
            r#"{"bufferView": 7, "mimeType": "application/x-ies-lm-63"}, {}"#,
            "buffer view",
        ),
    ] {
        let (emitters, files, warnings) = opened(lights, nodes, &[("damaged.ies", damaged.clone())]);
        let plugins: Vec<&str> = emitters.iter().map(|emitter| emitter.plugin.as_str()).collect();
        assert_eq!(plugins, ["point"], "{lights}");
        assert!(files.is_empty(), "{files:?}");
        assert!(
            warnings
                .iter()
                .any(|warning| warning.contains("light `lamp`") && warning.contains(said)),
            "{warnings:?}"
        );
        assert!(
            warnings
                .iter()
                .any(|warning| warning.contains("neither a file nor bytes")),
            "{warnings:?}"
        );
    }
}
