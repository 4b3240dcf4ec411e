//! Animations of glTF files as key frames.

use std::f32::consts::{FRAC_PI_2, PI};

use glam::{Affine3A, Quat, Vec3};
use sunroom::document::{Category, Interpolation, Object, Property, TransformOp, Value};
use sunroom::gltf::GltfError;
use sunroom::gltf::files::take_apart;
use sunroom::gltf::scene::Imported;

use crate::gltf_support::{Parts, SQUARE, nothing_beside, open};

/// A file in the making: a square is mesh 0, a camera is camera 0, and a point light and the sun are lights 0 and 1.
struct Model {
    parts: Parts,
    samplers: Vec<String>,
}

impl Model {
    fn new() -> Self {
        let mut parts = Parts::default();
        parts.floats("VEC3", &SQUARE);
        Self {
            parts,
            samplers: Vec::new(),
        }
    }

    /// A sampler of an animation, by its index.
    fn curve(&mut self, interpolation: &str, times: &[f32], kind: &str, values: &[f32]) -> usize {
        let input = self.parts.floats("SCALAR", times);
        let output = self.parts.floats(kind, values);
        self.sampler(interpolation, input, output)
    }

    fn sampler(&mut self, interpolation: &str, input: usize, output: usize) -> usize {
        self.samplers.push(format!(
            r#"{{"input": {input}, "output": {output}, "interpolation": "{interpolation}"}}"#
        ));
        self.samplers.len() - 1
    }

    /// An animation of channels (sampler, node, path) that has all samplers.
    fn animation(&self, name: &str, channels: &[(usize, usize, &str)]) -> String {
        let channel = |(sampler, node, path): &(usize, usize, &str)| {
            format!(r#"{{"sampler": {sampler}, "target": {{"node": {node}, "path": "{path}"}}}}"#)
        };
        let channels: Vec<String> = channels.iter().map(channel).collect();
        let (channels, samplers) = (channels.join(","), self.samplers.join(","));
        format!(r#"{{"name": "{name}", "channels": [{channels}], "samplers": [{samplers}]}}"#)
    }

    fn try_import(&self, nodes: &str, animations: &[String]) -> Result<Imported, GltfError> {
        let animations = animations.join(",");
        let text = self.parts.text(&format!(
            r#""meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0}}, "mode": 6}}]}}],
            "cameras": [{{"perspective": {{"yfov": 0.5, "aspectRatio": 1, "znear": 0.1}}}}],
            "extensions": {{"KHR_lights_punctual": {{"lights": [{{"type": "point"}}, {{"type": "directional"}}]}}}},
            "nodes": [{nodes}], "animations": [{animations}]"#
        ));
        let mut keep = |name: &str, _: &[u8]| Ok(name.to_owned());
        take_apart(&open(&text)?, &mut keep, &mut nothing_beside)
    }

    /// The scene of a file without faults.
    #[track_caller]
    fn import(&self, nodes: &str, channels: &[(usize, usize, &str)]) -> Object {
        let imported = self.try_import(nodes, &[self.animation("motion", channels)]);
        let imported = imported.expect("imports");
        assert_eq!(imported.warnings, Vec::<String>::new());
        imported.root
    }
}

fn first(root: &Object, category: Category) -> &Object {
    let mut objects = root.objects();
    objects
        .find(|object| object.category == category)
        .expect("there is one")
}

fn property<'a>(object: &'a Object, name: &str) -> &'a Property {
    let mut properties = object.properties.iter();
    properties
        .find(|property| property.name == name)
        .unwrap_or_else(|| panic!("no {name} in {object:?}"))
}

fn at(object: &Object, name: &str, time: f64) -> Value {
    property(object, name).keys.as_ref().expect("it moves").at(time)
}

fn pose(object: &Object, time: f64) -> Affine3A {
    match at(object, "to_world", time) {
        Value::Transform(steps) => TransformOp::compose(&steps),
        other => panic!("{other:?}"),
    }
}

fn key_count(object: &Object) -> usize {
    let keys = property(object, "to_world").keys.as_ref();
    keys.map_or(0, |track| track.keys.len())
}

#[track_caller]
fn assert_near(found: Affine3A, expected: Affine3A, tolerance: f32, about: impl std::fmt::Debug) {
    assert!(
        found.abs_diff_eq(expected, tolerance),
        "{about:?}: {found} is not {expected}"
    );
}

#[test]
fn channels_of_a_node_make_one_track() {
    let mut model = Model::new();
    let shift = model.curve("LINEAR", &[1.0, 3.0], "VEC3", &[0.0, 0.0, 0.0, 4.0, 2.0, 0.0]);
    // The second quaternion is the same turn as a quarter of one, but on the far side: the short way is the quarter.
    let half = (0.5 * FRAC_PI_2).sin();
    let turn = model.curve(
        "LINEAR",
        &[0.0, 2.0],
        "VEC4",
        &[0.0, 0.0, 0.0, 1.0, 0.0, -half, 0.0, -half],
    );
    let size = model.curve("LINEAR", &[0.0, 4.0], "VEC3", &[1.0, 1.0, 1.0, 3.0, 1.0, 5.0]);
    let root = model.import(
        r#"{"mesh": 0, "translation": [9, 9, 9]}"#,
        &[(shift, 0, "translation"), (turn, 0, "rotation"), (size, 0, "scale")],
    );
    let shape = first(&root, Category::Shape);
    for time in [0.0, 0.5, 1.0, 1.7, 2.0, 2.5, 3.0, 3.9, 4.0, 7.0] {
        let share = |from: f32, to: f32| ((time as f32 - from) / (to - from)).clamp(0.0, 1.0);
        let expected = Affine3A::from_scale_rotation_translation(
            Vec3::ONE.lerp(Vec3::new(3.0, 1.0, 5.0), share(0.0, 4.0)),
            Quat::from_rotation_y(FRAC_PI_2 * share(0.0, 2.0)),
            Vec3::ZERO.lerp(Vec3::new(4.0, 2.0, 0.0), share(1.0, 3.0)),
        );
        assert_near(pose(shape, time), expected, 1e-5, time);
    }
    // Nothing has to be added to the keys of the three.
    assert_eq!(key_count(shape), 5);
    assert_eq!(property(shape, "to_world").value, at(shape, "to_world", 0.0));
}

#[test]
fn values_that_hold_jump_at_the_frames_of_their_keys() {
    for smooth in [false, true] {
        let mut model = Model::new();
        let times: Vec<f32> = (0..48).map(|frame| (f64::from(frame) / 24.0) as f32).collect();
        let places: Vec<f32> = (0..48).flat_map(|frame| [frame as f32, 0.0, 0.0]).collect();
        let jumps = model.curve("STEP", &times, "VEC3", &places);
        let mut channels = vec![(jumps, 0, "translation")];
        if smooth {
            let grows = model.curve("LINEAR", &[0.0, 4.0], "VEC3", &[1.0, 1.0, 1.0, 5.0, 5.0, 5.0]);
            channels.push((grows, 0, "scale"));
        }
        let root = model.import(r#"{"mesh": 0}"#, &channels);
        let shape = first(&root, Category::Shape);
        for frame in 0..48 {
            // Frames before and after the next key.
            for part in [0.0, 0.4, 0.999] {
                let time = (f64::from(frame) + part) / 24.0;
                let found = pose(shape, time);
                assert_eq!(found.translation.x, frame as f32, "{time}");
                let size = if smooth { 1.0 + time as f32 } else { 1.0 };
                assert!((found.matrix3.x_axis.x - size).abs() < 1e-4, "{time}");
            }
        }
        let track = property(shape, "to_world").keys.as_ref().expect("moves");
        let expected = [Interpolation::Step, Interpolation::Linear][usize::from(smooth)];
        assert_eq!(track.interpolation, expected);
    }
}

#[test]
fn cubic_curves_are_followed_closely() {
    let mut model = Model::new();
    let values = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [4.0, 9.0, 0.0],
        [0.0, -3.0, 2.0],
        [2.0, 5.0, 1.0],
        [0.0; 3],
    ];
    let curve = model.curve("CUBICSPLINE", &[0.5, 2.5], "VEC3", values.concat().as_slice());
    let root = model.import(r#"{"mesh": 0}"#, &[(curve, 0, "translation")]);
    let shape = first(&root, Category::Shape);
    let [start, leaving, arriving, end] = [1, 2, 3, 4].map(|index| Vec3::from(values[index]));
    for step in 0..=100 {
        let share = step as f32 / 100.0;
        // The curve of Bézier with the same ends and tangents, by de Casteljau's construction.
        let mut points = [start, start + 2.0 / 3.0 * leaving, end - 2.0 / 3.0 * arriving, end];
        for count in (1..4).rev() {
            for index in 0..count {
                points[index] = points[index].lerp(points[index + 1], share);
            }
        }
        let found = Vec3::from(pose(shape, 0.5 + 2.0 * f64::from(share)).translation);
        assert!(found.distance(points[0]) < 0.01, "{share}: {found}, not {}", points[0]);
    }
    assert!((8..65).contains(&key_count(shape)), "{}", key_count(shape));
}

#[test]
fn what_hangs_on_a_moving_node_goes_along_its_arc() {
    let mut model = Model::new();
    let quaternion = |angle: f32| [0.0, (0.5 * angle).sin(), 0.0, (0.5 * angle).cos()];
    let turns = |model: &mut Model, end: f32| {
        let values = [quaternion(0.0), quaternion(end)].concat();
        model.curve("LINEAR", &[0.0, 2.0], "VEC4", &values)
    };
    // Together they turn by 320 degrees.
    let [outer, inner] = [
        turns(&mut model, 170.0 / 180.0 * PI),
        turns(&mut model, 150.0 / 180.0 * PI),
    ];
    let root = model.import(
        r#"{"translation": [1, 0, 0], "scale": [2, 2, 2], "children": [1]},
           {"children": [2]}, {"translation": [3, 0, 0], "children": [3]},
           {"translation": [0.5, 0, 0], "mesh": 0}"#,
        &[(outer, 1, "rotation"), (inner, 2, "rotation")],
    );
    let shape = first(&root, Category::Shape);
    for step in 0..=100 {
        let share = step as f32 / 100.0;
        let turned = |degrees: f32| Affine3A::from_rotation_y(share * degrees / 180.0 * PI);
        let shifted = |x: f32| Affine3A::from_translation(Vec3::new(x, 0.0, 0.0));
        let expected = shifted(1.0)
            * Affine3A::from_scale(Vec3::splat(2.0))
            * turned(170.0)
            * shifted(3.0)
            * turned(150.0)
            * shifted(0.5);
        // The path is fifteen units across.
        assert_near(pose(shape, 2.0 * f64::from(share)), expected, 0.02, share);
    }
}

#[test]
fn cameras_and_lights_move_with_their_nodes() {
    let mut model = Model::new();
    // A turn by -90 degrees about x in normalised whole numbers: what looked along -z looks along -y.
    let shares: Vec<u8> = [0i16, 0, 0, 32767, -23170, 0, 0, 23170]
        .iter()
        .flat_map(|share| share.to_le_bytes())
        .collect();
    let view = model.parts.view(&shares, "");
    let output = model.parts.accessor(view, 5122, "VEC4", 2, r#", "normalized": true"#);
    let input = model.parts.floats("SCALAR", &[0.0, 1.0]);
    let turn = model.sampler("LINEAR", input, output);
    let shift = model.curve("LINEAR", &[0.0, 1.0], "VEC3", &[0.0, 0.0, 0.0, 0.0, 6.0, 0.0]);
    let root = model.import(
        r#"{"children": [1, 2, 3]}, {"camera": 0}, {"extensions": {"KHR_lights_punctual": {"light": 0}}},
           {"extensions": {"KHR_lights_punctual": {"light": 1}}}"#,
        &[(turn, 0, "rotation"), (shift, 0, "translation")],
    );
    let camera = first(&root, Category::Sensor);
    let down = |map: Affine3A| map.transform_vector3(Vec3::Z);
    assert!(down(pose(camera, 0.0)).abs_diff_eq(Vec3::NEG_Z, 1e-4));
    assert!(down(pose(camera, 1.0)).abs_diff_eq(Vec3::NEG_Y, 1e-4));
    let half = Vec3::new(0.0, -1.0, -1.0).normalize();
    assert!(down(pose(camera, 0.5)).abs_diff_eq(half, 1e-3));
    assert!((pose(camera, 0.5).translation.y - 3.0).abs() < 1e-3);
    let emitter = |plugin: &str| {
        root.objects()
            .find(|object| object.plugin == plugin)
            .expect("there is one")
    };
    let Value::Point(place) = at(emitter("point"), "position", 0.25) else {
        panic!("no point")
    };
    assert!(place.abs_diff_eq(Vec3::new(0.0, 1.5, 0.0), 1e-4), "{place}");
    let sun = emitter("directional");
    assert!(down(pose(sun, 0.5)).abs_diff_eq(half, 1e-3));
    assert!(!sun.properties.iter().any(|property| property.name == "direction"));
}

#[test]
fn a_scale_of_zero_leaves_a_dot() {
    let mut model = Model::new();
    let size = model.curve("STEP", &[0.0, 1.0], "VEC3", &[0.0, 0.0, 0.0, 2.0, 2.0, 2.0]);
    let root = model.import(r#"{"mesh": 0, "scale": [0, 0, 0]}"#, &[(size, 0, "scale")]);
    let shape = first(&root, Category::Shape);
    assert_near(
        pose(shape, 0.0),
        Affine3A::from_scale(Vec3::splat(1e-4)),
        1e-7,
        "hidden",
    );
    assert_near(pose(shape, 1.0), Affine3A::from_scale(Vec3::splat(2.0)), 0.0, "shown");
}

#[test]
fn animations_play_together_unless_they_drive_the_same() {
    let mut model = Model::new();
    let right = model.curve("LINEAR", &[0.0, 1.0], "VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let up = model.curve("LINEAR", &[0.0, 1.0], "VEC3", &[0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let animations = [
        model.animation("walk", &[(right, 0, "translation")]),
        model.animation("jump", &[(up, 1, "translation"), (up, 0, "translation")]),
        model.animation("wave", &[(up, 1, "translation")]),
    ];
    let nodes = r#"{"mesh": 0, "name": "man"}, {"mesh": 0}"#;
    let imported = model.try_import(nodes, &animations).expect("imports");
    assert_eq!(
        imported.warnings,
        ["animation 1 (jump) is left out: it drives the translation of node 0 (man), as animation 0 (walk) does"]
    );
    let shapes = imported.root.objects();
    let ends: Vec<Vec3> = shapes
        .filter(|object| object.category == Category::Shape)
        .map(|shape| pose(shape, 1.0).translation.into())
        .collect();
    assert_eq!(ends, [Vec3::X, Vec3::Y]);
}

#[test]
fn what_is_not_read_is_named() {
    let mut model = Model::new();
    let weights = model.curve("LINEAR", &[0.0, 1.0], "SCALAR", &[0.0, 1.0]);
    let shift = model.curve("LINEAR", &[0.0, 1.0], "VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let nodes = r#"{"mesh": 0, "name": "face"},
        {"mesh": 0, "name": "fixed", "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]},
        {"mesh": 0, "name": "body", "skin": 0}"#;
    let animation = model.animation("smile", &[(weights, 0, "weights"), (shift, 1, "translation")]);
    let imported = model.try_import(nodes, &[animation]).expect("imports");
    assert_eq!(
        imported.warnings,
        [
            "animation 0 (smile): the morph weights of node 0 (face) stay as they are at 0 s",
            "animation 0 (smile): node 1 (fixed) has a matrix and stands still",
            "the skin of `body` is not there",
        ]
    );
}

#[test]
fn what_is_not_read_many_times_is_named_once() {
    let mut model = Model::new();
    let weights = model.curve("LINEAR", &[0.0, 1.0], "SCALAR", &[0.0, 1.0]);
    let shift = model.curve("LINEAR", &[0.0, 1.0], "VEC3", &[0.0, 0.0, 0.0, 1.0, 0.0, 0.0]);
    let nodes = vec![r#"{"mesh": 0}"#; 50].join(",");
    let faces: Vec<_> = (0..50).map(|node| (weights, node, "weights")).collect();
    let walk = [(shift, 0, "translation"), (weights, 0, "weights")];
    let animations = [
        model.animation("smile", &faces),
        model.animation("walk", &walk),
        model.animation("run", &walk[..1]),
        model.animation("jump", &walk[..1]),
    ];
    let imported = model.try_import(&nodes, &animations).expect("imports");
    assert_eq!(
        imported.warnings,
        [
            "animation 0 (smile): the morph weights of node 0 (unnamed) stay as they are at 0 s; so it is with 50 other channels",
            "animation 2 (run) is left out: it drives the translation of node 0 (unnamed), as animation 1 (walk) does; so it is with another animation",
        ]
    );
}

#[test]
fn long_names_are_cut_in_warnings() {
    let mut model = Model::new();
    let weights = model.curve("LINEAR", &[0.0, 1.0], "SCALAR", &[0.0, 1.0]);
    let animation = model.animation(&"long ".repeat(1000), &[(weights, 0, "weights")]);
    let node = format!(r#"{{"mesh": 0, "name": "{}"}}"#, "face".repeat(1000));
    let imported = model.try_import(&node, &[animation]).expect("imports");
    let start = format!(
        "animation 0 ({}...): the morph weights of node 0 (face",
        "long ".repeat(12)
    );
    assert!(imported.warnings[0].starts_with(&start), "{:?}", imported.warnings);
    assert!(imported.warnings[0].len() < 300);
}

#[test]
fn an_animation_that_cannot_be_read_is_left_out_and_the_scene_stays() {
    type Break = fn(&mut Model) -> (usize, usize);
    let cases: [(&str, Break); 9] = [
        ("accessor 99 is not there", |model| (model.sampler("LINEAR", 99, 1), 0)),
        ("has type VEC2 where VEC3 is expected", |model| {
            (model.curve("LINEAR", &[0.0], "VEC2", &[0.0; 2]), 0)
        }),
        ("has 2 times, to which 2 values belong, but 1 values", |model| {
            (model.curve("LINEAR", &[0.0, 1.0], "VEC3", &[0.0; 3]), 0)
        }),
        ("has 2 times, to which 6 values belong", |model| {
            (model.curve("CUBICSPLINE", &[0.0, 1.0], "VEC3", &[0.0; 6]), 0)
        }),
        ("times that do not rise", |model| {
            (model.curve("LINEAR", &[1.0, 1.0], "VEC3", &[0.0; 6]), 0)
        }),
        ("times beyond 1e9 s", |model| {
            (model.curve("LINEAR", &[0.0, 1e30], "VEC3", &[0.0; 6]), 0)
        }),
        ("values that are not finite", |model| {
            (model.curve("LINEAR", &[1.0], "VEC3", &[f32::NAN; 3]), 0)
        }),
        ("unknown interpolation `BOUNCE`", |model| {
            (model.curve("BOUNCE", &[1.0], "VEC3", &[0.0; 3]), 0)
        }),
        ("node 7 is not there", |model| {
            (model.curve("LINEAR", &[1.0], "VEC3", &[0.0; 3]), 7)
        }),
    ];
    for (message, wrong) in cases {
        let mut model = Model::new();
        let (sampler, node) = wrong(&mut model);
        let animation = model.animation("walk", &[(sampler, node, "translation")]);
        let imported = model.try_import(r#"{"mesh": 0}"#, &[animation]).expect(message);
        let [warning] = &imported.warnings[..] else {
            panic!("{message}: {:?}", imported.warnings)
        };
        assert!(
            warning.starts_with("animation 0 (walk) is left out: ") && warning.contains(message),
            "{warning}"
        );
        let shape = first(&imported.root, Category::Shape);
        assert!(shape.properties.iter().all(|property| property.keys.is_none()));
    }
}

#[test]
fn key_frames_without_end_are_refused() {
    let mut model = Model::new();
    let count = 4096;
    let times: Vec<f32> = (0..count).map(|key| key as f32).collect();
    let places: Vec<f32> = (0..3 * count).map(|number| number as f32).collect();
    let shift = model.curve("LINEAR", &times, "VEC3", &places);
    // A small file: each node hangs on the one before, so that each has the keys of all above it.
    let nodes: Vec<String> = (1..=2048)
        .map(|next| format!(r#"{{"mesh": 0, "children": [{next}]}}"#))
        .collect();
    let nodes = format!("{}, {{}}", nodes.join(","));
    let animation = model.animation("chain", &[(shift, 0, "translation")]);
    let error = model.try_import(&nodes, &[animation]).expect_err("too many");
    assert!(matches!(error, GltfError::Poses(_)), "{error}");
}
