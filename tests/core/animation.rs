//! Key frames in scene files: what they mean at a time, what is said of broken ones, and that they are written again.

use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use sunroom::document::revision::{Destination, revise};
use sunroom::document::{Category, Document, Object, TransformOp, Value, parse_str, to_xml};

/// `body` inside a scene; the body's first line is line 2.
fn parse(body: &str) -> Document {
    let text = format!("<scene version=\"3.0.0\">\n{body}\n</scene>\n");
    parse_str(text, Path::new("scene.xml"), &[])
}

fn good(body: &str) -> Document {
    let document = parse(body);
    assert_eq!(document.diagnostics.to_string(), "", "{body}");
    document
}

fn value(object: &Object, name: &str) -> Value {
    let mut properties = object.properties.iter();
    properties
        .find(|property| property.name == name)
        .expect(name)
        .value
        .clone()
}

fn first(document: &Document) -> &Object {
    document.root.objects().next().expect("the scene has an object")
}

const MOVING: &str = r#"<shape type="sphere">
    <float name="radius" value="0.5"/>
    <animation name="toWorld">
        <transform time="1"> <translate x="2"/> </transform>
        <transform time="3"> <translate x="6"/> </transform>
    </animation>
    <emitter type="area">
        <animation name="radiance" interpolation="step">
            <rgb time="0" value="1, 0, 0"/>
            <rgb time="2" value="0, 0, 1"/>
        </animation>
    </emitter>
</shape>
<bsdf type="diffuse" id="still"/>"#;

#[test]
fn a_document_shows_one_moment_and_makes_others() {
    let document = good(MOVING);
    assert_eq!((document.time, document.animated_span()), (0.0, Some((0.0, 3.0))));
    let place = |document: &Document| match &value(first(document), "to_world") {
        Value::Transform(steps) => steps[..].to_vec(),
        other => panic!("{other:?}"),
    };
    let light = |document: &Document| {
        let emitter = first(document).objects().next().expect("an emitter");
        value(emitter, "radiance")
    };
    let at = |x| vec![TransformOp::Translate(Vec3::new(x, 0.0, 0.0))];
    // Before the first key its value holds.
    assert_eq!(place(&document), at(2.0));
    let later = document.at(2.0);
    assert_eq!((later.time, place(&later)), (2.0, at(4.0)));
    assert_eq!(light(&document.at(1.9)), Value::Rgb(Vec3::X));
    assert_eq!(light(&later), Value::Rgb(Vec3::Z));
    assert_eq!(place(&later.at(9.0)), at(6.0));
    assert_eq!(later.at(0.0), document);
    // What does not move is shared.
    let still = |document: &Document| match &document.root.children[1] {
        sunroom::document::Child::Object(object) => object.clone(),
        other => panic!("{other:?}"),
    };
    assert!(Arc::ptr_eq(&still(&document), &still(&later)));
}

#[test]
fn broken_keys_are_named_with_their_places() {
    let cases = [
        (r#"<animation name="radius"/>"#, "3:1", "needs a key"),
        (
            r#"<animation><float time="0" value="1"/></animation>"#,
            "3:1",
            "needs the attribute `name`",
        ),
        (
            r#"<animation name="radius"><float value="1"/></animation>"#,
            "3:26",
            "needs the attribute `time`",
        ),
        (
            r#"<animation name="radius"><float time="soon" value="1"/></animation>"#,
            "3:39",
            "expected a number, found `soon`",
        ),
        (
            r#"<animation name="radius"><float time="0" value="1"/><float time="1e30" value="2"/></animation>"#,
            "3:66",
            "expected a time from -1e9 to 1e9 s, found `1e30`",
        ),
        (
            r#"<animation name="radius"><float time="1" value="1"/><float time="1" value="2"/></animation>"#,
            "3:66",
            "expected a time after that of the key before, 1 s, found 1 s",
        ),
        (
            r#"<animation name="radius"><float time="0" value="1"/><point time="1" value="2"/></animation>"#,
            "3:53",
            "expected a float, as in the first key of this animation, found a point",
        ),
        (
            r#"<animation name="radius" interpolation="bouncy"><float time="0" value="1"/></animation>"#,
            "3:41",
            "expected `linear`, `ease`, `step`, found `bouncy`",
        ),
        (
            r#"<animation name="radius"><ref id="a"/></animation>"#,
            "3:26",
            "<ref> is no key of an animation",
        ),
        (
            r#"<animation name="radius"><float time="0" value="1"/></animation><float name="radius" value="2"/>"#,
            "3:65",
            "`radius` is given twice",
        ),
    ];
    for (animation, place, message) in cases {
        let document = parse(&format!("<shape type=\"sphere\">\n{animation}\n</shape>"));
        let text = document.diagnostics.to_string();
        assert!(document.diagnostics.has_errors(), "{animation}");
        assert!(
            text.contains(&format!(":{place}:")) && text.contains(message),
            "{animation}\n{text}"
        );
    }
}

#[test]
fn keys_are_written_and_read_again() {
    let document = good(MOVING);
    let text = to_xml(&document).expect("finite");
    let again = parse_str(text.clone(), Path::new("scene.xml"), &[]);
    assert_eq!(again.diagnostics.to_string(), "", "{text}");
    for time in [0.0, 1.5, 2.0, 7.0] {
        let (one, other) = (document.at(time), again.at(time));
        for name in ["radius", "to_world"] {
            assert_eq!(value(first(&one), name), value(first(&other), name), "{time}");
        }
    }
    assert_eq!(text.matches("<animation").count(), 2);
    assert_eq!(to_xml(&again).expect("finite"), text);
}

#[test]
fn a_further_key_is_written_among_the_others() {
    let origin = good(MOVING).at(2.0);
    let revised = |change: &dyn Fn(&mut Object)| {
        let mut now = origin.clone();
        change(Arc::make_mut(&mut now.root));
        let nowhere = |_: &str, _: &Path| None;
        let destination = Destination {
            path: Path::new("/scene.xml"),
            has_changed: &|_| false,
            find_before: &nowhere,
            find_after: &nowhere,
        };
        let files = revise(&origin, &now, &destination).expect("finite");
        files.into_iter().next_back().expect("a file").1
    };
    let same = revised(&|_| {});
    assert_eq!(same, *origin.diagnostics.sources[0].text);
    let moved = revised(&|root| {
        let sunroom::document::Child::Object(sphere) = &mut root.children[0] else {
            panic!("a shape")
        };
        let sphere = Arc::make_mut(sphere);
        let place = &mut sphere.properties[1];
        place.value = Value::Transform(vec![TransformOp::Translate(Vec3::Y)]);
        let track = place
            .keys
            .as_ref()
            .expect("it moves")
            .with_key(2.0, place.value.clone());
        place.keys = track.map(Arc::new);
    });
    let again = parse_str(moved.clone(), Path::new("scene.xml"), &[]);
    assert_eq!(again.diagnostics.to_string(), "", "{moved}");
    let place = |time: f64| value(first(&again.at(time)), "to_world");
    let translate = |by| Value::Transform(vec![TransformOp::Translate(by)]);
    assert_eq!(place(2.0), translate(Vec3::Y), "{moved}");
    assert_eq!(place(1.0), translate(Vec3::new(2.0, 0.0, 0.0)));
    assert_eq!(place(3.0), translate(Vec3::new(6.0, 0.0, 0.0)));
    // The rest of the text stays.
    assert!(
        moved.contains("<rgb time=\"2\" value=\"0, 0, 1\"/>") && moved.contains("id=\"still\""),
        "{moved}"
    );
}

#[test]
fn many_moving_instances_stay_apart_from_those_that_stand_still() {
    let instance = |x: usize| {
        format!(
            "<shape type=\"instance\"><ref id=\"g\"/><transform name=\"to_world\"><translate x=\"{x}\"/></transform></shape>\n"
        )
    };
    let moving = "<shape type=\"instance\"><ref id=\"g\"/><animation name=\"to_world\"><transform time=\"0\"/>\
                  <transform time=\"1\"><translate y=\"1\"/></transform></animation></shape>\n";
    let crowd: String = (0..1100).map(instance).collect();
    let document = good(&format!(
        "<shape type=\"shapegroup\" id=\"g\"><shape type=\"sphere\"/></shape>\n{crowd}{moving}{crowd}"
    ));
    let packed: usize = document.crowds.iter().map(|crowd| crowd.places.len()).sum();
    assert_eq!((document.crowds.len(), packed), (2, 2200));
    let later = document.at(1.0);
    let moved = later
        .root
        .objects()
        .find(|object| object.plugin == "instance")
        .expect("it is no part of a crowd");
    assert_eq!(
        (moved.category, value(moved, "to_world")),
        (Category::Shape, Value::Transform(vec![TransformOp::Translate(Vec3::Y)]))
    );
}
