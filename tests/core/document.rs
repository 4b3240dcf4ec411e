//! Scene files: what they mean, what is said of broken ones, and that nothing in them can bring the reader down.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use glam::{Mat4, Vec3};
use sunroom::document::{
    Category, Child, Diagnostics, Document, Object, Property, Reader, Severity, SourceError, Span, TransformOp, Value,
    load, parse_str, parse_within, to_xml,
};
use sunroom::files::{Access, write_atomically};

use crate::fuzz_corpus::entries::documents::without_spans;
use crate::split_mix::Random;

fn parse(text: &str) -> Document {
    parse_str(text, Path::new("scene.xml"), &[])
}

/// `body` inside a scene; the body's first line is line 2.
fn scene(body: &str) -> String {
    format!("<scene version=\"3.0.0\">\n{body}\n</scene>\n")
}

fn good(body: &str) -> Document {
    let document = parse(&scene(body));
    assert_eq!(document.diagnostics.to_string(), "", "{body}");
    document
}

fn messages(text: &str) -> Vec<String> {
    let document = parse(text);
    document.diagnostics.to_string().lines().map(str::to_owned).collect()
}

fn first_object(document: &Document) -> &Object {
    document.root.objects().next().expect("the scene has an object")
}

fn value<'d>(document: &'d Document, name: &str) -> &'d Value {
    let mut properties = first_object(document).properties.iter();
    &properties.find(|property| property.name == name).expect(name).value
}

/// Folder of the shared scenes, if this machine has it.
fn shared_scenes() -> Vec<PathBuf> {
    let data = Path::new(crate::ROOT).join("../shared/data");
    let mut found = Vec::new();
    let mut folders = vec![data.join("mitsuba-scenes"), data.join("peer-scenes")];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "xml") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

#[test]
fn every_kind_of_value_is_read() {
    let document = good(
        r##"<shape type="sphere" id="ball" name="main">
    <float name="a" value=" 1.5e-1 "/>
    <integer name="b" value="-7"/>
    <boolean name="c" value="True"/>
    <string name="d" value="x &amp; &#65; &lt;y&gt;"/>
    <point name="e" value="1, 2 3"/>
    <vector name="f" x="1" y="2" z="-3"/>
    <rgb name="g" value="0.1 0.2,0.3"/>
    <rgb name="h" value="#f00"/>
    <rgb name="i" value="0.5"/>
    <spectrum name="j" value="0.25"/>
    <string name="k" value=""/>
    <point name="l" value="2"/>
</shape>"##,
    );
    let object = first_object(&document);
    assert_eq!(object.category, Category::Shape);
    assert_eq!(object.plugin, "sphere");
    assert_eq!(
        (object.id.as_deref(), object.name.as_deref()),
        (Some("ball"), Some("main"))
    );
    let expected = [
        ("a", Value::Float(0.15)),
        ("b", Value::Integer(-7)),
        ("c", Value::Boolean(true)),
        ("d", Value::String("x & A <y>".to_owned())),
        ("e", Value::Point(Vec3::new(1.0, 2.0, 3.0))),
        ("f", Value::Vector(Vec3::new(1.0, 2.0, -3.0))),
        ("g", Value::Rgb(Vec3::new(0.1, 0.2, 0.3))),
        ("h", Value::Rgb(Vec3::X)),
        ("i", Value::Rgb(Vec3::splat(0.5))),
        ("j", Value::Spectrum(0.25)),
        ("k", Value::String(String::new())),
        ("l", Value::Point(Vec3::splat(2.0))),
    ];
    let read: Vec<(&str, Value)> = object
        .properties
        .iter()
        .map(|property| (property.name.as_str(), property.value.clone()))
        .collect();
    assert_eq!(read, expected);
}

#[test]
fn transforms_keep_their_steps_in_order() {
    let document = good(
        r#"<sensor type="perspective">
    <transform name="toWorld">
        <translate x="1" z="2"/>
        <scale value="2"/>
        <scale y="3"/>
        <rotate y="1" angle="90"/>
        <rotate value="0, 0, -1" angle="-45.5"/>
        <matrix value="1 2 3 4 5 6 7 8 9 10 11 12 0 0 0 1"/>
        <matrix value="1,2,3, 4,5,6, 7,8,9"/>
        <lookAt origin="0, 0, -4" target="0,0,0" up="0,1,0"/>
    </transform>
</sensor>"#,
    );
    let rows = |rows: [[f32; 4]; 3]| Mat4::from_cols_array_2d(&[rows[0], rows[1], rows[2], [0.0, 0.0, 0.0, 1.0]]);
    let expected = vec![
        TransformOp::Translate(Vec3::new(1.0, 0.0, 2.0)),
        TransformOp::Scale(Vec3::splat(2.0)),
        TransformOp::Scale(Vec3::new(1.0, 3.0, 1.0)),
        TransformOp::Rotate {
            axis: Vec3::Y,
            degrees: 90.0,
        },
        TransformOp::Rotate {
            axis: Vec3::NEG_Z,
            degrees: -45.5,
        },
        TransformOp::Matrix(rows([[1.0, 2.0, 3.0, 4.0], [5.0, 6.0, 7.0, 8.0], [9.0, 10.0, 11.0, 12.0]]).transpose()),
        TransformOp::Matrix(rows([[1.0, 2.0, 3.0, 0.0], [4.0, 5.0, 6.0, 0.0], [7.0, 8.0, 9.0, 0.0]]).transpose()),
        TransformOp::LookAt {
            origin: Vec3::new(0.0, 0.0, -4.0),
            target: Vec3::ZERO,
            up: Vec3::Y,
        },
    ];
    assert_eq!(*value(&document, "to_world"), Value::Transform(expected));
}

#[test]
fn a_matrix_is_given_row_by_row() {
    let document = good(
        r#"<shape type="cube"><transform name="to_world"><matrix value="1 0 0 5 0 1 0 6 0 0 1 7 0 0 0 1"/></transform></shape>"#,
    );
    let Value::Transform(ops) = value(&document, "to_world") else {
        panic!("no transform");
    };
    let moved = TransformOp::compose(ops).transform_point3(Vec3::ZERO);
    assert_eq!(moved, Vec3::new(5.0, 6.0, 7.0));
}

#[test]
fn a_look_at_without_up_gets_one() {
    for target in ["0,0,1", "0,0,-1", "0,1,0", "1,2,3"] {
        let document = good(&format!(
            r#"<sensor type="perspective"><transform name="to_world"><lookat origin="0,0,0" target="{target}"/></transform></sensor>"#
        ));
        let Value::Transform(ops) = value(&document, "to_world") else {
            panic!("no transform");
        };
        let [TransformOp::LookAt { target, up, .. }] = ops[..] else {
            panic!("no look at");
        };
        // A tangent by construction; six digits of a unit vector.
        assert!(up.dot(target.normalize()).abs() < 1e-6 && (up.length() - 1.0).abs() < 1e-6);
    }
}

#[test]
fn a_look_at_over_the_smallest_distances_has_a_direction() {
    for distance in ["1e-38", "1e-44"] {
        let document = good(&format!(
            r#"<sensor type="perspective"><transform name="to_world"><lookat origin="0,0,0" target="{distance},0,0" up="0,1,0"/></transform></sensor>"#
        ));
        let Value::Transform(ops) = value(&document, "to_world") else {
            panic!("no transform");
        };
        assert_eq!(
            TransformOp::compose(ops).transform_vector3(Vec3::Z),
            Vec3::X,
            "{distance}"
        );
    }
}

#[test]
fn old_names_are_read_as_new_ones() {
    let document = good(
        r#"<bsdf type="diffuse">
    <texture type="bitmap" name="diffuseReflectance"><float name="uscale" value="4"/><string name="filterType" value="ewa"/></texture>
</bsdf>
<bsdf type="dielectric"><float name="intIOR" value="1.5"/></bsdf>"#,
    );
    let texture = first_object(&document).objects().next().unwrap();
    assert_eq!(texture.name.as_deref(), Some("reflectance"));
    let names: Vec<_> = texture
        .properties
        .iter()
        .map(|property| property.name.as_str())
        .collect();
    assert_eq!(names, ["filter_type", "to_uv"]);
    let dielectric = document.root.objects().nth(1).unwrap();
    assert_eq!(dielectric.properties[0].name, "int_ior");
}

#[test]
fn spectra_become_colours_by_what_they_stand_for() {
    let list = "380:0.5, 780:0.5";
    let document = good(&format!(
        r#"<bsdf type="diffuse"><spectrum name="reflectance" value="{list}"/></bsdf>"#
    ));
    let Value::Rgb(gray) = value(&document, "reflectance") else {
        panic!("no colour");
    };
    // Nothing visible lies outside of the list: half of white, to the tables' three digits.
    assert!(gray.abs_diff_eq(Vec3::splat(0.5), 1e-3), "{gray}");
    let document = good(&format!(
        r#"<emitter type="area"><spectrum name="radiance" value="{list}"/></emitter>"#
    ));
    let Value::Rgb(light) = value(&document, "radiance") else {
        panic!("no colour");
    };
    // Equal energy seen by itself (Mitsuba's RGB mode gives 1.2048, 0.9483, 0.9089 for power 1).
    assert!(light.abs_diff_eq(Vec3::new(0.6024, 0.4741, 0.4544), 2e-3), "{light}");
}

#[test]
fn emission_tells_a_spectrum_from_a_float() {
    let document = good(
        r#"<emitter type="area"><spectrum name="a" value="2"/><float name="b" value="2"/><rgb name="c" value="1,2,3"/></emitter>"#,
    );
    let mut diagnostics = document.diagnostics.clone();
    let index = document.index();
    let mut r = Reader::new(&index, first_object(&document), &mut diagnostics);
    let purple = r.emission("a").unwrap();
    assert!(purple.abs_diff_eq(Vec3::new(2.4096, 1.8967, 1.8178), 2e-3), "{purple}");
    assert_eq!(r.rgb("a"), Some(Vec3::splat(2.0)));
    assert_eq!(r.emission("b"), Some(Vec3::splat(2.0)));
    assert_eq!(r.emission("c"), Some(Vec3::new(1.0, 2.0, 3.0)));
}

#[test]
fn defaults_and_the_command_line() {
    let text = scene(
        r#"<default name="spp" value="16"/><default name="spp" value="99"/><default name="file" value="$spp.exr"/>
<sampler type="independent"><integer name="sample_count" value="$spp"/><string name="out" value="$file \$spp"/></sampler>"#,
    );
    let document = parse(&text);
    assert_eq!(document.diagnostics.to_string(), "");
    assert_eq!(*value(&document, "sample_count"), Value::Integer(16));
    assert_eq!(*value(&document, "out"), Value::String("16.exr $spp".to_owned()));
    let defines = [("spp".to_owned(), "4".to_owned()), ("sp".to_owned(), "1".to_owned())];
    let document = parse_str(&*text, Path::new("scene.xml"), &defines);
    assert_eq!(*value(&document, "sample_count"), Value::Integer(4));
    assert_eq!(
        document.diagnostics.to_string(),
        "scene.xml: warning: `-D sp=...` has no effect: the scene does not use `$sp` (did you mean `spp`?)\n"
    );
}

#[test]
fn references_lead_to_objects_defined_before_and_after() {
    let document = good(
        r#"<shape type="sphere"><ref id="late" name="bsdf"/><ref id="other"/></shape>
<bsdf type="diffuse" id="late"/>
<alias id="late" as="other"/>"#,
    );
    let index = document.index();
    let shape = first_object(&document);
    let ids: Vec<_> = shape
        .children
        .iter()
        .map(|child| index.resolve(child).unwrap().id.as_deref())
        .collect();
    assert_eq!(ids, [Some("late"), Some("late")]);
    assert_eq!(shape.children[0].name(), Some("bsdf"));
    assert_eq!(
        document.by_id("late").map(|object| object.plugin.as_str()),
        Some("diffuse")
    );
    assert_eq!(document.by_id("nobody"), None);
}

/// Broken scenes (the body, from line 2 on) and all that is said of them.
const BROKEN: &[(&str, &[&str])] = &[
    (
        r#"<bsdf type="diffuse"><rgb name="reflectance" value="1"/><rgb name="diffuseReflectance" value="0"/></bsdf>"#,
        &["2:57: error: `reflectance` is given twice in bsdf `diffuse`"],
    ),
    (
        r#"<texture type="bitmap"><transform name="toUV"><scale value="2"/></transform><float name="uoffset" value="1"/></texture>"#,
        &["2:77: error: offset and scale of a texture are given both as `to_uv` and as numbers of their own"],
    ),
    (
        r#"<srgb name="a" value="0, 1e38, 0"/>"#,
        &["2:23: error: `0, 1e38, 0` is too large for a colour"],
    ),
    (
        r#"<float name="a" value="1.5x"/> <integer name="b" value="2.0"/> <boolean name="c" value="yes"/>"#,
        &[
            "2:24: error: expected a number, found `1.5x`",
            "2:57: error: expected an integer, found `2.0`",
            "2:89: error: expected `true` or `false`, found `yes`",
        ],
    ),
    (
        r#"<float name="a" value="nan"/> <float name="b" value="1e40"/> <integer name="c" value="99999999999999999999"/>"#,
        &[
            "2:24: error: expected a finite number, found `nan`",
            "2:54: error: `1e40` is too large for a number",
            "2:87: error: `99999999999999999999` is too large for an integer",
        ],
    ),
    (
        r##"<rgb name="a" value="1, 2"/> <rgb name="b" value="#12345"/> <point name="c" x="1" y="2"/>"##,
        &[
            "2:22: error: expected a colour: three numbers, one, or `#rrggbb`, found `1, 2`",
            "2:51: error: expected a colour like `#ff8000`, found `#12345`",
            "2:61: error: <point> needs the attribute `z`",
        ],
    ),
    (
        r#"<spectrum name="a" value="1, 2, 3"/> <spectrum name="b" value="500:1, 400:1"/>"#,
        &[
            "2:27: error: expected a number or `wavelength:value` pairs, found `1, 2, 3`",
            "2:64: error: wavelengths must increase, but 400 follows 500",
        ],
    ),
    (
        r#"<float value="1"/> <float name="x"/> <bsdf/> <float name="" value="1"/>"#,
        &[
            "2:1: error: <float> needs the attribute `name`",
            "2:20: error: <float> needs the attribute `value`",
            "2:38: error: <bsdf> needs the attribute `type`",
            "2:59: error: attribute `name` is empty",
        ],
    ),
    (
        r#"<float name="x" value="1"/> <float name="x" value="2"/>"#,
        &["2:29: error: `x` is given twice in the scene"],
    ),
    (
        r#"<float name="x" value="1" value="2"/>"#,
        &["2:34: error: attribute `value` is given twice"],
    ),
    (
        r#"<bsdf type="diffuse" id="a"/>
 <bsdf type="conductor" id="a"/>"#,
        &["3:29: error: the id `a` is given twice (the first one is at scene.xml:2:26)"],
    ),
    (
        r#"<bsdf type="diffuse" id="white"/> <shape type="sphere"><ref id="whiet"/></shape>"#,
        &["2:56: error: there is no object with the id `whiet` (did you mean `white`?)"],
    ),
    (
        r#"<bsdf type="twosided" id="a"><ref id="b"/></bsdf> <bsdf type="twosided" id="b"><ref id="a"/></bsdf>"#,
        &["2:80: error: a circle of references leads back to `a` (`b` is referred to at scene.xml:2:30)"],
    ),
    (
        r#"<bsdf type="twosided" id="a"><bsdf type="mask"><ref id="a"/></bsdf></bsdf>"#,
        &["2:48: error: a circle of references leads back to `a`"],
    ),
    (
        r#"<alias id="nobody" as="x"/> <bsdf type="diffuse" id="y"/> <alias id="y" as="y"/>"#,
        &[
            "2:1: error: there is no object with the id `nobody`",
            "2:59: error: the id `y` is given twice",
        ],
    ),
    (
        r#"<default name="width" value="1"/> <integer name="x" value="$widht"/> <integer name="y" value="$"/>"#,
        &[
            "2:60: error: `$widht` is not defined (did you mean `width`?)",
            "2:95: error: a `$` without a name (write `\\$` for a plain dollar sign)",
        ],
    ),
    (
        r#"<include filename="nowhere.xml"/>"#,
        &["2:20: error: the file `nowhere.xml` does not exist (looked for nowhere.xml)"],
    ),
    (
        r#"<transform name="t"><matrix value="1 2 3"/><matrix value="1 0 0 0 0 1 0 0 0 0 1 0 0 0 1 0"/><matrix value="1 0 0 nan 0 1 0 0 0 0 1 0 0 0 0 1"/></transform>"#,
        &[
            "2:36: error: a matrix has 16 numbers, or 9, found 3",
            "2:59: error: the last row of the matrix should be 0 0 0 1",
            "2:108: error: expected a finite number, found `nan`",
        ],
    ),
    (
        r#"<transform name="t"><rotate angle="4"/><rotate x="1"/><lookat origin="1,1,1" target="1,1,1"/><lookat origin="0,0,0" target="0,2,0" up="0,1,0"/><traslate x="1"/></transform>"#,
        &[
            "2:21: error: the axis of a rotation cannot be zero",
            "2:40: error: <rotate> needs the attribute `angle`",
            "2:55: error: `target` is where `origin` is: there is no direction to look in",
            "2:94: error: `up` points along the direction from `origin` to `target`",
            "2:144: error: <traslate> is not a step of a transform (did you mean `translate`?)",
        ],
    ),
    (
        // Three digits are near enough.
        r#"<transform name="t"><rotate value="0.577 0.577 0.577" angle="4"/><rotate y="1.5" angle="90"/></transform>"#,
        &["2:66: warning: the axis of the rotation has the length 1.5, not 1: it also scales, as in Mitsuba 3"],
    ),
    (
        r#"<translate x="1"/> <float name="a" value="1"><float name="b" value="2"/></float> <scene version="3.0.0"/>"#,
        &[
            "2:1: error: <translate> can only stand inside <transform>",
            "2:46: error: <float> cannot stand inside <float>",
            "2:82: error: <scene> cannot stand inside another tag",
        ],
    ),
    (
        r#"<bssdf type="x"><float name="bad" value="x"/></bssdf> <float name="a" value="1" unit="m"/> text"#,
        &[
            "2:1: warning: <bssdf> is not known; it is ignored with all it contains (did you mean `bsdf`?)",
            "2:87: warning: <float> has no attribute `unit`; it is ignored",
            "2:92: warning: text between tags is ignored",
        ],
    ),
    (
        r#"<string name="a" value="x&lol;y"/>"#,
        &["2:25: error: attribute `value` cannot be read: "],
    ),
    (
        "<string name=\"é\" value=\"ü\"/> <float name=\"b\" value=\"ö\"/>",
        // Columns count characters, not bytes.
        &["2:53: error: expected a number, found `ö`"],
    ),
    (
        r#"<bsdf type="diffuse"> <float name="a" value="x"/> </shape>"#,
        &[
            "2:46: error: expected a number, found `x`",
            "2:51: error: broken XML: ill-formed document: expected `</bsdf>`, but `</shape>` was found (<bsdf> of line 2 is still open here)",
        ],
    ),
    // What would follow from a lost `>` is not reported.
    (
        "<shape type=\"cube\" id=\"floor\"\n<ref id=\"oak\"/> <scale value=\"2\"/></shape> <bsdf type=\"diffuse\" id=\"oak\"/>",
        &["2:1: error: broken XML: <shape> has no `>` at its end (<scene> of line 1 is still open here)"],
    ),
    (
        "<ref id=\"oak\"/> <bsdf type=\"diffuse\" id=\"pine\" <ref id=\"ash\"/> <bsdf type=\"diffuse\" id=\"oak\"/>",
        &[
            "2:17: error: broken XML: <bsdf> has no `>` at its end (<scene> of line 1 is still open here)",
            "2:17: note: 1 reference leads to an id that nothing has, perhaps because this file could not be read",
        ],
    ),
];

#[test]
fn broken_files_are_described_at_the_right_place() {
    for (body, expected) in BROKEN {
        let said = messages(&scene(body));
        let expected: Vec<String> = expected.iter().map(|line| format!("scene.xml:{line}")).collect();
        assert_eq!(said.len(), expected.len(), "{body}\n{said:#?}");
        for (said, expected) in said.iter().zip(&expected) {
            assert!(
                said.starts_with(expected),
                "{body}\nsaid     {said}\nexpected {expected}"
            );
        }
    }
}

#[test]
fn broken_wholes_are_described() {
    for (text, expected) in [
        ("", "scene.xml:1:1: error: there is no <scene> in this file"),
        ("<!-- -->\n", "scene.xml:1:9: error: there is no <scene> in this file"),
        (
            "<scene version=\"3.0.0\">",
            "scene.xml:1:1: error: <scene> is never closed",
        ),
        (
            "<html/>",
            "scene.xml:1:1: error: a scene file starts with <scene>, not <html>",
        ),
        (
            "<scene version=\"3.x\"/>",
            "scene.xml:1:17: error: expected a version like `3.0.0`, found `3.x`",
        ),
        (
            "<scene/>",
            "scene.xml:1:1: warning: no `version` is given; it is read as version 3.0.0",
        ),
        (
            "<scene version=\"3.0.0\"/><scene version=\"3.0.0\"/>",
            "scene.xml:1:25: error: <scene> stands after the end of the scene",
        ),
        (
            "<!DOCTYPE scene [<!ENTITY a \"b\">]><scene version=\"3.0.0\"/>",
            "scene.xml:1:1: error: entities are not supported (use <default name=... value=...> and `$name` instead)",
        ),
        (
            "<scene version=\"3.0.0\"><!-- </scene>",
            "scene.xml:1:24: error: broken XML: syntax error: comment not closed: `-->` not found before end of input (<scene> of line 1 is still open here)",
        ),
        (
            "<bsdf version=\"3.0.0\" type=\"diffuse\"/>",
            "scene.xml:1:1: error: a scene file starts with <scene>, not <bsdf>",
        ),
    ] {
        assert_eq!(messages(text), [expected], "{text}");
    }
}

#[test]
fn what_was_understood_is_there_next_to_the_errors() {
    let document = parse(
        "<scene version=\"3.0.0\"><bsdf type=\"diffuse\"><float name=\"a\" value=\"1\"/><float name=\"b\" value=\"x\"/></wrong>",
    );
    assert!(document.diagnostics.has_errors());
    assert_eq!(*value(&document, "a"), Value::Float(1.0));
}

#[test]
fn deep_nesting_is_one_error() {
    for (open, close) in [
        ("<bsdf type=\"twosided\">", "</bsdf>"),
        ("<x>", "</x>"),
        ("<bsdf type=\"twosided\"><x>", "</x></bsdf>"),
    ] {
        let text = scene(&format!("{}{}", open.repeat(20_000), close.repeat(20_000)));
        let said = messages(&text);
        assert_eq!(said.len(), 1, "{said:?}");
    }
    let text = scene(&format!(
        "{}{}",
        "<bsdf type=\"a\">".repeat(20_000),
        "</bsdf>".repeat(20_000)
    ));
    assert!(messages(&text)[0].ends_with("error: tags are nested more than 256 deep"));
    // Never closed, and deep: still no crash, and few words.
    assert!(messages(&scene(&"<bsdf type=\"a\">".repeat(20_000))).len() <= 3);
}

#[test]
fn chains_of_references_are_bounded() {
    let chain = |length: usize, copies: usize| {
        let links = (0..length).map(|i| {
            let next = format!("<ref id=\"b{}\"/>", i + 1).repeat(copies);
            format!("<bsdf type=\"blendbsdf\" id=\"b{i}\">{next}</bsdf>")
        });
        let body: String = links.collect();
        scene(&format!("{body}<bsdf type=\"diffuse\" id=\"b{length}\"/>"))
    };
    assert!(messages(&chain(100, 1)).is_empty());
    assert!(messages(&chain(10, 2)).is_empty());
    let said = messages(&chain(5000, 1));
    assert!(
        said[0].contains("references lead more than 256 objects deep"),
        "{said:?}"
    );
    // Two to the power of sixty objects, if one were to follow every reference.
    let said = messages(&chain(60, 2));
    assert!(said[0].contains("references of references"), "{said:?}");
}

#[test]
fn many_messages_are_counted_not_printed() {
    let bad: String = (0..5000)
        .map(|i| format!("<float name=\"a{i}\" value=\"x{i}\"/>\n"))
        .collect();
    let document = parse(&scene(&bad));
    assert_eq!(document.diagnostics.error_count(), 5000);
    assert_eq!(document.diagnostics.summary(), "5000 errors");
    let said = document.diagnostics.to_string();
    assert_eq!(said.lines().count(), 51);
    assert!(said.ends_with("... and 4950 more (5000 errors in all)\n"), "{said}");
    assert!(
        document
            .diagnostics
            .render(false)
            .ends_with("... and 4950 more (5000 errors in all)\n")
    );
}

#[test]
fn doubling_defaults_are_stopped() {
    let mut body = "<default name=\"a0\" value=\"0123456789\"/>".to_owned();
    for i in 0..64 {
        body += &format!("<default name=\"a{}\" value=\"$a{i}$a{i}\"/>", i + 1);
    }
    let said = messages(&scene(&body));
    assert!(said[0].contains("longer than 65536 bytes"), "{:?}", said.first());
}

#[test]
fn includes_are_read_relative_to_their_file() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, text).unwrap();
        path
    };
    let main = write(
        "main.xml",
        &scene(
            r#"<default name="color" value="1"/><include filename="parts/a.xml"/><include filename="bsdf.xml" name="inner"/>
<path value="lib"/><include filename="c.xml"/>"#,
        ),
    );
    write(
        "parts/a.xml",
        &scene("<include filename=\"b.xml\"/><float name=\"f\" value=\"$color\"/>"),
    );
    write(
        "parts/b.xml",
        &scene("<shape type=\"obj\" id=\"b\"><string name=\"filename\" value=\"m.obj\"/></shape>"),
    );
    write("parts/m.obj", "");
    write("lib/c.xml", &scene("<shape type=\"cube\"/>"));
    write("lib/n.obj", "");
    write("bsdf.xml", "<bsdf version=\"3.0.0\" type=\"diffuse\"/>");
    let document = load(&main, &[]).unwrap();
    assert_eq!(document.diagnostics.to_string(), "");
    let plugins: Vec<_> = document
        .root
        .objects()
        .map(|object| (object.plugin.as_str(), object.name.as_deref()))
        .collect();
    assert_eq!(plugins, [("obj", None), ("diffuse", Some("inner")), ("cube", None)]);
    assert_eq!(document.root.properties[0].value, Value::Float(1.0));
    // A file named inside an include is found beside the include, others in the search folder.
    let span = document.by_id("b").unwrap().span;
    assert_eq!(
        document.find_file("m.obj", span),
        Some(folder.path().join("parts/m.obj"))
    );
    assert_eq!(document.find_file("n.obj", span), Some(folder.path().join("lib/n.obj")));
    assert_eq!(document.find_file("m.obj", document.root.span), None);
    let (path, line, column) = document.diagnostics.locate(span).unwrap();
    assert_eq!(
        (path, line, column),
        (folder.path().join("parts/b.xml").as_path(), 2, 1)
    );
}

#[test]
fn includes_cannot_go_round_or_on_for_ever() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, body: &str| fs::write(folder.path().join(name), scene(body)).unwrap();
    write("a.xml", "<include filename=\"b.xml\"/>");
    write("b.xml", "<include filename=\"a.xml\"/>");
    let document = load(&folder.path().join("a.xml"), &[]).unwrap();
    let said = document.diagnostics.to_string();
    assert!(said.contains("b.xml:2:20: error: `a.xml` includes itself"), "{said}");
    assert!(said.contains("a.xml:2:20"), "{said}");
    assert_eq!(document.diagnostics.list.len(), 1);
    for i in 0..40 {
        write(&format!("c{i}.xml"), &format!("<include filename=\"c{}.xml\"/>", i + 1));
    }
    let document = load(&folder.path().join("c0.xml"), &[]).unwrap();
    let said = document.diagnostics.to_string();
    assert!(said.contains("includes are nested more than 15 deep"), "{said}");
    // Ten files, each of which includes the next one ten times, would be ten thousand million tags.
    for i in 0..10 {
        let body = format!("<include filename=\"d{}.xml\"/>", i + 1).repeat(10);
        write(&format!("d{i}.xml"), &body);
    }
    write("d10.xml", "<emitter type=\"constant\"/>");
    let started = Instant::now();
    let document = load(&folder.path().join("d0.xml"), &[]).unwrap();
    let said = document.diagnostics.to_string();
    assert!(said.contains("more than 10000 includes"), "{said}");
    // All of it would take years.
    assert!(started.elapsed() < Duration::from_secs(600));
}

#[test]
fn ids_of_an_include_that_cannot_be_read_are_not_missed_one_by_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::create_dir(path("scene")).unwrap();
    let part = scene("<bsdf type=\"diffuse\" id=\"red\"/>");
    fs::write(path("outside.xml"), &part).unwrap();
    fs::write(path("scene/broken.xml"), part.replace("</scene>", "<scene")).unwrap();
    fs::write(path("scene/foreign.xml"), "<foo/>").unwrap();
    fs::write(path("scene/empty.xml"), "").unwrap();
    let body = |file: &str| {
        scene(&format!(
            "<include filename=\"{file}\"/><shape type=\"cube\"><ref id=\"red\"/></shape><alias id=\"blue\" as=\"b\"/>
<bsdf type=\"bumpmap\"><ref id=\"dents\"/><ref id=\"red\"/></bsdf>"
        ))
    };
    let main = path("scene/main.xml");
    let said = |file: &str| {
        let access = Access::within([path("scene")]);
        let list = parse_within(body(file), &main, &[], access).diagnostics.list;
        list.iter()
            .map(|diagnostic| (diagnostic.severity, diagnostic.message.clone()))
            .collect::<Vec<_>>()
    };
    for (file, error, references) in [
        (
            "../outside.xml",
            "lies outside the scene's folder",
            "4 references lead to ids",
        ),
        ("absent.xml", "does not exist", "4 references lead to ids"),
        ("foreign.xml", "<foo>", "4 references lead to ids"),
        ("empty.xml", "there is no <scene>", "4 references lead to ids"),
        // What could be read of it counts.
        ("broken.xml", "broken XML", "2 references lead to ids"),
    ] {
        let said = said(file);
        assert_eq!(said.len(), 2, "{said:?}");
        assert!(said[0].0 == Severity::Error && said[0].1.contains(error), "{said:?}");
        let expected = format!("{references} that nothing has, perhaps because this file could not be read");
        assert_eq!(said[1], (Severity::Note, expected));
    }
    // Where everything was read nothing is passed over.
    fs::write(path("scene/good.xml"), &part).unwrap();
    let said = said("good.xml");
    let errors = said.iter().filter(|(severity, _)| *severity == Severity::Error);
    assert_eq!(errors.count(), 2, "{said:?}");
    // So is a file that includes itself.
    let circle = body("main.xml");
    fs::write(&main, &circle).unwrap();
    let said = parse_within(circle, &main, &[], Access::everywhere()).diagnostics;
    assert!(
        said.list
            .iter()
            .all(|diagnostic| diagnostic.severity == Severity::Error),
        "{said:?}"
    );
    assert_eq!(said.error_count(), 5, "{said:?}");
}

#[test]
fn an_error_after_very_many_warnings_is_listed() {
    let span = Span::default();
    let mut diagnostics = Diagnostics::default();
    for number in 0..1200 {
        diagnostics.warn(span, format!("warning {number}"));
    }
    for number in 0..1100 {
        diagnostics.error(span, format!("error {number}"));
        let last = diagnostics.list.last().unwrap();
        assert_eq!(last.message, format!("error {}", number.min(999)));
    }
    assert_eq!((diagnostics.warning_count(), diagnostics.error_count()), (1200, 1100));
    assert_eq!(diagnostics.list.len(), 1000);
}

#[test]
fn a_message_in_an_include_used_thrice_is_said_once() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(
        folder.path().join("part.xml"),
        scene("<shape type=\"cube\"><float name=\"a\" value=\"x\"/></shape>"),
    )
    .unwrap();
    let main = folder.path().join("main.xml");
    fs::write(&main, scene(&"<include filename=\"part.xml\"/>".repeat(3))).unwrap();
    let document = load(&main, &[]).unwrap();
    assert_eq!(document.root.children.len(), 3);
    assert_eq!(document.diagnostics.list.len(), 1);
    assert_eq!(document.diagnostics.sources.len(), 2);
}

#[test]
fn files_that_are_no_text_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.xml");
    assert!(matches!(load(&path, &[]), Err(SourceError::Unreadable { .. })));
    assert!(
        load(folder.path(), &[])
            .unwrap_err()
            .to_string()
            .ends_with("is a folder, not a file")
    );
    fs::write(&path, b"\xff\xfe<\0s\0").unwrap();
    assert!(matches!(load(&path, &[]), Err(SourceError::Utf16 { .. })));
    fs::write(&path, b"<scene>\n  \xe9").unwrap();
    let Err(SourceError::NotUtf8 { line, column, .. }) = load(&path, &[]) else {
        panic!("read as text");
    };
    assert_eq!((line, column), (2, 3));
    fs::write(&path, format!("\u{feff}{}", scene(""))).unwrap();
    assert_eq!(load(&path, &[]).unwrap().diagnostics.to_string(), "");
}

#[test]
fn lines_of_files_elsewhere_are_not_shown_even_when_the_scene_is_gone() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = |name: &str| folder.path().join(name);
    for name in ["scenes", "private"] {
        std::fs::create_dir(path(name)).expect("a temporary folder");
    }
    let text = "<scene version='3.0.0'>\n<nonsense/> <!-- secret -->\n</scene>";
    std::fs::write(path("private/part.xml"), text).expect("a temporary folder");
    let scene = path("scenes/scene.xml");
    std::fs::write(
        &scene,
        "<scene version='3.0.0'><include filename='../private/part.xml'/></scene>",
    )
    .expect("writable");
    let document = load(&scene, &[]).expect("there is text");
    for is_gone in [false, true] {
        if is_gone {
            std::fs::remove_file(&scene).expect("it is there");
        }
        let report = document.diagnostics.render(false);
        assert!(
            report.contains("part.xml:2:1") && !report.contains("secret"),
            "{report}"
        );
    }
}

#[test]
fn reports_show_the_line_with_a_caret() {
    let document = parse(&scene("  <float name=\"x\" value=\"abc\"/>"));
    let plain = document.diagnostics.render(false);
    assert!(plain.contains("expected a number, found `abc`"), "{plain}");
    assert!(plain.contains("scene.xml:2:26"), "{plain}");
    let lines: Vec<&str> = plain.lines().collect();
    let shown = lines
        .iter()
        .position(|line| line.contains("<float name=\"x\""))
        .expect("the line itself");
    let column = |line: &str, what: &str| line.find(what).map(|byte| line[..byte].chars().count());
    assert_eq!(column(lines[shown], "abc"), column(lines[shown + 1], "───"), "{plain}");
    assert!(!plain.contains('\u{1b}'));
    assert!(document.diagnostics.render(true).contains('\u{1b}'));
}

#[test]
fn reports_stay_small_and_clean_whatever_the_file_has() {
    // A file of one line of megabytes; control characters that would speak to the terminal.
    let long = format!("<float name=\"a\" value=\"1\"/>{}", " ".repeat(1 << 20));
    let text = scene(&format!(
        "{long}<float name=\"b\" value=\"x&#27;[31m\u{1b}[32m\"/>{long}"
    ));
    let document = parse(&text);
    let report = document.diagnostics.render(false);
    assert!(report.len() < 4000, "{}", report.len());
    assert!(!report.contains('\u{1b}') && !document.diagnostics.to_string().contains('\u{1b}'));
    // Spans from another document, or past the end, must not bring the report down.
    let mut diagnostics = document.diagnostics;
    for (start, end) in [(0, u32::MAX), (u32::MAX, 0), (u32::MAX, u32::MAX)] {
        let span = Span {
            start,
            end,
            ..Span::default()
        };
        diagnostics.warn(span, "odd");
    }
    let nowhere = Span {
        source: sunroom::document::SourceId(77),
        start: 0,
        end: 1,
    };
    diagnostics.error(nowhere, "elsewhere");
    assert!(diagnostics.render(true).contains("elsewhere"));
    assert_eq!(Diagnostics::default().render(true), "");
}

#[test]
fn readers_check_types_and_ranges_and_report_what_nobody_read() {
    let document = good(
        r#"<bsdf type="roughconductor">
<float name="alpah" value="0.2"/>
<integer name="eta" value="2"/>
<float name="count" value="1.5"/>
<string name="material" value="Au"/>
<rgb name="tint" value="0.5, 2, 0"/>
<float name="low" value="-1"/>
<boolean name="known" value="true"/>
<texture type="bitmap" name="reflectanse"/>
<bsdf type="diffuse"/>
<shape type="cube"/>
</bsdf>"#,
    );
    let mut diagnostics = document.diagnostics.clone();
    let index = document.index();
    let mut r = Reader::new(&index, first_object(&document), &mut diagnostics);
    assert_eq!(r.float_in("alpha", 0.0..=1.0), None);
    assert_eq!(r.float_or("eta", 9.0), 2.0);
    assert_eq!(r.integer("count"), None);
    assert_eq!(r.string("material"), Some("Au"));
    assert_eq!(r.rgb("material"), None);
    assert_eq!(r.rgb_in("tint", 0.0..=1.0), None);
    assert_eq!(r.float_in("low", 0.0..), None);
    assert_eq!(r.child("reflectance"), None);
    assert_eq!(r.children(Category::Bsdf).len(), 1);
    r.ignore(&["known", "never_given"]);
    r.finish();
    let said: Vec<String> = diagnostics.list.iter().map(|d| diagnostics.line(d)).collect();
    let expected = [
        "scene.xml:5:1: error: `count` should be an integer, found a float",
        "scene.xml:6:1: error: `material` should be a colour, found a string",
        "scene.xml:7:1: error: `tint` is 2, but should be at least 0 and at most 1",
        "scene.xml:8:1: error: `low` is -1, but should be at least 0",
        "scene.xml:3:1: warning: `alpah` is not a parameter of bsdf `roughconductor` (did you mean `alpha`?)",
        "scene.xml:10:1: warning: texture `bitmap` is given for `reflectanse`, which bsdf `roughconductor` does not read (did you mean `reflectance`?)",
        "scene.xml:12:1: warning: shape `cube` has no effect in bsdf `roughconductor`",
    ];
    assert_eq!(said, expected);
    assert!(diagnostics.has_errors());
    assert_eq!(diagnostics.list[0].severity, Severity::Error);
}

fn assert_round_trip(document: &Document, what: &str) {
    let text = to_xml(document).unwrap();
    let again = parse_str(&*text, &document.path, &[]);
    assert_eq!(
        without_spans(&again.root),
        without_spans(&document.root),
        "{what}\n{text}"
    );
    assert_eq!(again.search_folders, document.search_folders, "{what}");
    assert_eq!(to_xml(&again).unwrap(), text, "{what}");
}

#[test]
fn shared_scenes_parse_and_survive_writing() {
    let scenes = shared_scenes();
    if scenes.is_empty() {
        println!("skipped: ../shared/data has no scenes here");
    }
    for path in &scenes {
        let document = load(path, &[]).unwrap();
        // Parts of scenes and scenes that want a -D cannot stand alone; the format is not what is wrong with them.
        for diagnostic in &document.diagnostics.list {
            let known = ["there is no object with the id", "is not defined", "does not exist"];
            let line = document.diagnostics.line(diagnostic);
            let foreign =
                document.root.category == Category::Scene && line.contains("a scene file starts with <scene>");
            assert!(foreign || known.iter().any(|part| line.contains(part)), "{line}");
        }
        if !document.diagnostics.has_errors() {
            assert!(!document.root.children.is_empty(), "{}", path.display());
        }
        assert_round_trip(&document, &path.display().to_string());
    }
}

/// Parts of made-up scenes.
impl Random {
    /// Any finite number, of any size.
    fn finite_float(&mut self) -> f32 {
        let number = f32::from_bits(self.next() as u32);
        if number.is_finite() { number } else { 0.0 }
    }

    fn vec3(&mut self) -> Vec3 {
        Vec3::new(self.finite_float(), self.finite_float(), self.finite_float())
    }

    fn text(&mut self) -> String {
        const LETTERS: [&str; 20] = [
            "a", "b", "_", "1", " ", "&", "<", ">", "\"", "'", "$", "\\", "\n", "\t", "\r", "é", "€", "🦀", "]]>",
            "&amp;",
        ];
        (0..self.below(12))
            .map(|_| LETTERS[self.below(LETTERS.len())])
            .collect()
    }

    fn value(&mut self) -> Value {
        match self.below(9) {
            0 => Value::Float(self.finite_float()),
            1 => Value::Integer(self.next() as i64),
            2 => Value::Boolean(self.below(2) == 0),
            3 => Value::String(self.text()),
            4 => Value::Rgb(self.vec3()),
            5 => Value::Spectrum(self.finite_float()),
            6 => Value::Point(self.vec3()),
            7 => Value::Vector(self.vec3()),
            _ => Value::Transform((0..self.below(5)).map(|_| self.transform_op()).collect()),
        }
    }

    fn transform_op(&mut self) -> TransformOp {
        match self.below(5) {
            0 => TransformOp::Translate(self.vec3()),
            1 => TransformOp::Scale(self.vec3()),
            2 => TransformOp::Rotate {
                axis: Vec3::new(1.0, self.finite_float(), self.finite_float()),
                degrees: self.finite_float(),
            },
            3 => {
                let mut numbers: [f32; 16] = std::array::from_fn(|_| self.finite_float());
                for (i, last) in [0.0, 0.0, 0.0, 1.0].into_iter().enumerate() {
                    numbers[4 * i + 3] = last;
                }
                TransformOp::Matrix(Mat4::from_cols_array(&numbers))
            }
            _ => TransformOp::LookAt {
                origin: Vec3::new(self.below(9) as f32, 0.1, 0.2),
                target: Vec3::new(0.5, 7.0, 0.3),
                up: Vec3::Z,
            },
        }
    }

    fn object(&mut self, depth: usize, ids: &mut usize) -> Object {
        let category = Category::ALL[1 + self.below(Category::ALL.len() - 1)];
        let mut object = Object::new(category, format!("p{}", self.text()));
        if self.below(2) == 0 {
            object.id = Some(format!("{}#{ids}", self.text()).into());
            *ids += 1;
        }
        object.name = (self.below(3) == 0).then(|| format!("name_{}", self.below(5)).into());
        object.properties = (0..self.below(5))
            .map(|i| Property::new(format!("p{i}_{}", self.text()), self.value(), Span::default()))
            .collect();
        if depth < 4 {
            let inner = (0..self.below(4)).map(|_| self.object(depth + 1, ids).into());
            object.children = inner.collect();
        }
        object
    }
}

#[test]
fn made_up_scenes_survive_writing() {
    let mut random = Random(1);
    for round in 0..300 {
        let mut ids = 0;
        let mut root = Object::new(Category::Scene, "");
        let children: Vec<Child> = (0..random.below(5))
            .map(|_| random.object(0, &mut ids).into())
            .collect();
        let known: Vec<_> = children
            .iter()
            .filter_map(|child| match child {
                Child::Object(object) => object.id.clone(),
                Child::Reference { .. } => None,
            })
            .collect();
        root.children = children;
        root.children.extend(known.into_iter().map(|id| Child::Reference {
            name: Some("again".into()),
            id,
            span: Span::default(),
        }));
        let mut document = Document::new("scene.xml", root);
        if random.below(2) == 0 {
            document
                .search_folders
                .push(PathBuf::from("/a folder/with & odd <names>"));
        }
        assert_round_trip(&document, &format!("round {round}"));
    }
}

#[test]
fn what_xml_cannot_carry_is_refused() {
    let mut object = Object::new(Category::Bsdf, "diffuse");
    object
        .properties
        .push(Property::new("alpha", Value::Float(f32::NAN), Span::default()));
    let mut root = Object::new(Category::Scene, "");
    root.children.push(object.into());
    let error = to_xml(&Document::new("a.xml", root)).unwrap_err();
    assert_eq!(
        error.to_string(),
        "`alpha` of bsdf `diffuse` is not a finite number and cannot be saved"
    );
    let root = Object::new(Category::Scene, "a\0b");
    assert!(to_xml(&Document::new("a.xml", root)).is_err());
}

#[test]
fn written_text_is_the_one_people_would_write() {
    let document = good(
        r#"<shape type="sphere" id="ball"><float name="radius" value="0.10"/><transform name="to_world"><translate y="2"/></transform><ref id="m"/></shape>
<bsdf type="diffuse" id="m"/>"#,
    );
    let expected = r#"<scene version="3.0.0">
    <shape type="sphere" id="ball">
        <float name="radius" value="0.1"/>
        <transform name="to_world">
            <translate value="0, 2, 0"/>
        </transform>
        <ref id="m"/>
    </shape>
    <bsdf type="diffuse" id="m"/>
</scene>
"#;
    assert_eq!(to_xml(&document).unwrap(), expected);
}

#[test]
fn files_are_replaced_in_one_step() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.xml");
    write_atomically(&path, "one").unwrap();
    write_atomically(&path, "two").unwrap();
    assert_eq!(fs::read_to_string(&path).unwrap(), "two");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    assert!(write_atomically(&folder.path().join("no/such/folder.xml"), "x").is_err());
    #[cfg(unix)]
    {
        use std::os::unix::fs::{PermissionsExt, symlink};
        fs::set_permissions(&path, fs::Permissions::from_mode(0o640)).unwrap();
        let link = folder.path().join("link.xml");
        symlink(&path, &link).unwrap();
        write_atomically(&link, "three").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read_to_string(&path).unwrap(), "three");
        assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o777, 0o640);
    }
}

/// A scene with a bit of everything, for the tests that break it.
const SAMPLE: &str = r##"<?xml version="1.0" encoding="utf-8"?>
<!-- é -->
<scene version="0.6.0">
    <default name="spp" value="16"/>
    <integrator type="path"><integer name="maxDepth" value="8"/></integrator>
    <sensor type="perspective">
        <float name="fov" value="45"/>
        <transform name="toWorld"><lookat origin="0,1,-6" target="0,1,0" up="0,1,0"/><scale x="-1"/></transform>
        <sampler type="independent"><integer name="sampleCount" value="$spp"/></sampler>
    </sensor>
    <bsdf type="twosided" id="white &amp; more"><bsdf type="diffuse"><rgb name="reflectance" value="#808080"/></bsdf></bsdf>
    <alias id="white &amp; more" as="w"/>
    <shape type="rectangle"><ref id="w"/><boolean name="flipNormals" value="true"/>
        <transform name="to_world"><matrix value="1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1"/><rotate z="1" angle="90"/></transform>
        <emitter type="area"><spectrum name="radiance" value="400:0, 500:8, 600:15.6, 700:18.4"/></emitter>
    </shape>
</scene>
"##;

/// Reads and uses a damaged document in every way; it must neither panic nor take long.
fn exercise(text: &str) {
    let document = parse(text);
    let report = document.diagnostics.render(false);
    assert_eq!(report.is_empty(), document.diagnostics.list.is_empty());
    let index = document.index();
    let mut diagnostics = document.diagnostics.clone();
    for object in document.root.objects() {
        Reader::new(&index, object, &mut diagnostics).finish();
    }
    if !document.diagnostics.has_errors() {
        assert_round_trip(&document, text);
    }
}

#[test]
fn a_file_cut_off_anywhere_is_an_error_and_no_panic() {
    assert_eq!(messages(SAMPLE), [""; 0]);
    exercise(SAMPLE);
    let whole = SAMPLE.trim_end().len();
    for length in (0..whole).filter(|length| SAMPLE.is_char_boundary(*length)) {
        assert!(parse(&SAMPLE[..length]).diagnostics.has_errors(), "{length}");
        if length % 7 == 0 {
            exercise(&SAMPLE[..length]);
        }
    }
}

#[test]
fn damaged_files_never_panic_or_hang() {
    let started = Instant::now();
    let mut random = Random(7);
    for _ in 0..3000 {
        let mut bytes = SAMPLE.as_bytes().to_vec();
        for _ in 0..1 + random.below(6) {
            let place = random.below(bytes.len());
            match random.below(4) {
                0 => bytes[place] ^= 1 << random.below(8),
                1 => bytes[place] = b"<>/\"'=&;$\\# \n\0-!?[]"[random.below(19)],
                2 => drop(bytes.drain(place..(place + random.below(30)).min(bytes.len()))),
                _ => {
                    let end = (place + random.below(40)).min(bytes.len());
                    let copy = bytes[place..end].to_vec();
                    let target = random.below(bytes.len());
                    bytes.splice(target..target, copy);
                }
            }
        }
        exercise(&String::from_utf8_lossy(&bytes));
    }
    // A debug build needs a few seconds; what hangs would never end.
    assert!(started.elapsed() < Duration::from_secs(600));
}

/// A group, instances of it with a comment and another shape between them, and one whose size is a `$name`.
fn crowded(count: usize, size: &str) -> String {
    let instance = |index: usize| {
        format!(
            "  <shape type='instance'><ref id='group'/><transform name='to_world'>\n    <scale value='{size}'/><translate x='{index}'/>\
             </transform></shape> <!-- {index} -->\n"
        )
    };
    let instances = |range: std::ops::Range<usize>| -> String { range.map(instance).collect() };
    format!(
        "<scene version='3.0.0'>\n<default name='size' value='0.5'/>\n\
         <shape type='shapegroup' id='group'><shape type='cube'/></shape>\n{}<shape type='disk'/>\n{}</scene>\n",
        instances(0..count),
        instances(count..count + 3),
    )
}

#[test]
fn very_many_instances_are_packed_and_unpacked() {
    for size in ["0.5", "$size"] {
        let count = 2000;
        let document = parse(&crowded(count, size));
        assert_eq!(document.diagnostics.list, []);
        // The group, the disk, and the few instances behind it.
        assert_eq!(document.root.children.len(), 5);
        let [crowd] = &document.crowds[..] else {
            panic!("{} crowds", document.crowds.len())
        };
        assert_eq!((crowd.position, crowd.group.as_str()), (1, "group"));
        assert_eq!(crowd.places.len(), count);
        let place = glam::Affine3A::from_translation(Vec3::X * 77.0) * glam::Affine3A::from_scale(Vec3::splat(0.5));
        assert_eq!(crowd.places[77], place.into());

        // The tree is that of a text in which nothing is packed, for there a name makes the instances different.
        let named = crowded(count, size).replace("<ref id", "<ref name='group' id");
        let plain = parse(&named);
        assert_eq!(plain.crowds, []);
        let unpacked = document.unpacked();
        assert_eq!(unpacked.root.children.len(), plain.root.children.len());
        for (place, (child, plain)) in unpacked.root.children.iter().zip(&plain.root.children).enumerate() {
            let (Child::Object(child), Child::Object(plain)) = (child, plain) else {
                panic!("references")
            };
            assert_eq!(child.properties.len(), plain.properties.len());
            for (property, plain) in child.properties.iter().zip(&plain.properties) {
                assert_eq!(
                    (&property.name, &property.value),
                    (&plain.name, &plain.value),
                    "{place}"
                );
            }
        }
        let texts = |document: &Document| {
            let of_child = |child: &Child| {
                let span = child.span();
                document.diagnostics.sources[0].text[span.start as usize..span.end as usize].to_owned()
            };
            document.root.children.iter().map(of_child).collect::<Vec<_>>()
        };
        assert_eq!(texts(&unpacked), texts(&plain));
        assert_eq!(to_xml(&document).unwrap(), to_xml(&unpacked).unwrap());
    }
}

#[test]
fn instances_of_no_group_are_not_packed() {
    let text = crowded(1500, "1").replace("id='group'><shape", "id='other'><shape");
    let document = parse(&text);
    assert_eq!(document.crowds, []);
    assert_eq!(document.root.children.len(), 1505);
    // One message for each, up to the number that is kept.
    assert_eq!(document.diagnostics.error_count(), 1503);
    assert!(document.diagnostics.list[0].message.contains("`group`"));

    // Another name for the group is a name of it.
    let alias = text.replace("<shape type='disk'/>", "<alias id='other' as='group'/>");
    let document = parse(&alias);
    assert_eq!(document.diagnostics.list, []);
    assert_eq!(document.crowds.len(), 1);
    assert_eq!(document.crowds[0].group, "other");
    assert_eq!(document.crowds[0].places.len(), 1503);
}
