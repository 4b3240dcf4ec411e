//! The shapes of meshes at nodes of glTF files: bones and morph weights.

use glam::{Mat4, Vec3};
use sunroom::gltf::Gltf;

use crate::gltf_support::{Parts, SQUARE, open};

fn positions(file: &Gltf, place: usize) -> Vec<Vec3> {
    let placed = file.placed_meshes().expect("reads");
    let (mesh, pose) = &placed[place];
    mesh.positions
        .iter()
        .map(|position| pose.transform_point3(*position))
        .collect()
}

fn assert_near(found: &[Vec3], expected: &[Vec3]) {
    let is_near = found
        .iter()
        .zip(expected)
        .all(|(found, expected)| found.abs_diff_eq(*expected, 1e-5));
    assert!(found.len() == expected.len() && is_near, "{found:?} {expected:?}");
}

/// A square whose lower corners belong to the first bone and whose upper ones to the second; `bones` are their nodes, 1
/// and 2, and `animation` an animation.
fn bent(joints: &[u8; 16], bones: &str, animation: &dyn Fn(&mut Parts) -> String) -> Gltf {
    let mut parts = Parts::default();
    let positions = parts.floats("VEC3", &SQUARE);
    let normals = parts.floats("VEC3", &[[0.0, 0.0, 1.0]; 4].concat());
    let weights = parts.floats("VEC4", &[[1.0, 0.0, 0.0, 0.0]; 4].concat());
    let view = parts.view(joints, "");
    let joints = parts.accessor(view, 5121, "VEC4", 4, "");
    let bound: Vec<f32> = [Mat4::IDENTITY, Mat4::from_translation(Vec3::NEG_Y)]
        .iter()
        .flat_map(Mat4::to_cols_array)
        .collect();
    let bytes: Vec<u8> = bound.iter().flat_map(|number| number.to_le_bytes()).collect();
    let view = parts.view(&bytes, "");
    let bound = parts.accessor(view, 5126, "MAT4", 2, "");
    let animation = animation(&mut parts);
    open(&parts.text(&format!(
        r#""meshes": [{{"primitives": [{{"attributes": {{"POSITION": {positions}, "NORMAL": {normals}, "JOINTS_0": {joints}, "WEIGHTS_0": {weights}}},
               "mode": 6}}]}}],
           "skins": [{{"joints": [1, 2], "inverseBindMatrices": {bound}}}],
           "nodes": [{{"mesh": 0, "skin": 0, "name": "cloth", "translation": [9, 9, 9]}}, {bones}], "scenes": [{{"nodes": [0, 1]}}]{animation}"#
    )))
    .expect("opens")
}

const LOWER_AND_UPPER: [u8; 16] = [0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0];

#[test]
fn vertices_go_along_with_their_bones() {
    let nothing = |_: &mut Parts| String::new();
    let straight = r#"{"children": [2]}, {"translation": [0, 1, 0]}"#;
    let corners = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y];
    assert_near(&positions(&bent(&LOWER_AND_UPPER, straight, &nothing), 0), &corners);
    // The upper bone is turned by a quarter about x, and stands two higher than in the pose of binding.
    let turned = r#"{"children": [2]}, {"translation": [0, 3, 0], "rotation": [0.70710678, 0, 0, 0.70710678]}"#;
    let file = bent(&LOWER_AND_UPPER, turned, &nothing);
    let upper = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 3.0, 0.0), Vec3::new(0.0, 3.0, 0.0)];
    assert_near(&positions(&file, 0), &upper);
    let normals = &file.placed_meshes().expect("reads")[0].0.normals;
    assert_near(normals, &[Vec3::Z, Vec3::Z, Vec3::NEG_Y, Vec3::NEG_Y]);
    // A bone that is not there holds nothing: the vertex goes along with the first one.
    let mut joints = LOWER_AND_UPPER;
    joints[8] = 200;
    let lost = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::new(0.0, 3.0, 0.0)];
    assert_near(&positions(&bent(&joints, turned, &nothing), 0), &lost);
}

#[test]
fn mirrored_bones_keep_the_outer_side() {
    // The bones stand apart, or they would place the mesh as a node.
    let mirrored = r#"{"scale": [-1, 1, 1], "children": [2]}, {"translation": [0, 2, 0]}"#;
    let file = bent(&LOWER_AND_UPPER, mirrored, &|_: &mut Parts| String::new());
    let corners = [
        Vec3::ZERO,
        Vec3::NEG_X,
        Vec3::new(-1.0, 2.0, 0.0),
        Vec3::new(0.0, 2.0, 0.0),
    ];
    assert_near(&positions(&file, 0), &corners);
    let placed = file.placed_meshes().expect("reads");
    let mesh = &placed[0].0;
    assert_near(&mesh.normals, &[Vec3::Z; 4]);
    for triangle in &mesh.triangles {
        let [a, b, c] = triangle.map(|vertex| mesh.positions[vertex as usize]);
        assert!((b - a).cross(c - a).z > 0.0, "{triangle:?}");
    }
}

#[test]
fn bones_without_inverse_bind_matrices_are_named() {
    let straight = r#"{"children": [2]}, {"translation": [0, 1, 0]}"#;
    let mut keep = |name: &str, _: &[u8]| Ok(name.to_owned());
    let mut warnings = |joints: &str| {
        let mut parts = Parts::default();
        let square = parts.floats("VEC3", &SQUARE);
        let view = parts.view(&Mat4::IDENTITY.to_cols_array().map(f32::to_le_bytes).concat(), "");
        let bound = parts.accessor(view, 5126, "MAT4", 1, "");
        let file = open(&parts.text(&format!(
            r#""meshes": [{{"primitives": [{{"attributes": {{"POSITION": {square}}}, "mode": 6}}]}}],
               "skins": [{{"joints": {joints}, "inverseBindMatrices": {bound}}}],
               "nodes": [{{"mesh": 0, "skin": 0}}, {straight}], "scenes": [{{"nodes": [0, 1]}}]"#
        )));
        let file = file.expect("opens");
        let imported = sunroom::gltf::files::take_apart(&file, &mut keep, &mut crate::gltf_support::nothing_beside);
        imported.expect("imports").warnings
    };
    assert_eq!(warnings("[1]"), [""; 0]);
    let short = warnings("[1, 2]");
    assert!(
        short.len() == 1 && short[0].contains("inverse bind matrices of skin 0"),
        "{short:?}"
    );
}

#[test]
fn bones_are_those_at_the_start_of_their_animation() {
    let lifted = |parts: &mut Parts| {
        let times = parts.floats("SCALAR", &[0.0, 1.0]);
        let places = parts.floats("VEC3", &[0.0, 4.0, 0.0, 0.0, 5.0, 0.0]);
        format!(
            r#", "animations": [{{"channels": [{{"sampler": 0, "target": {{"node": 2, "path": "translation"}}}}],
                "samplers": [{{"input": {times}, "output": {places}}}]}}]"#
        )
    };
    let file = bent(
        &LOWER_AND_UPPER,
        r#"{"children": [2]}, {"translation": [0, 1, 0]}"#,
        &lifted,
    );
    let upper = [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 4.0, 0.0), Vec3::new(0.0, 4.0, 0.0)];
    assert_near(&positions(&file, 0), &upper);
    let mut keep = |name: &str, _: &[u8]| Ok(name.to_owned());
    let imported = sunroom::gltf::files::take_apart(&file, &mut keep, &mut crate::gltf_support::nothing_beside);
    let warnings = imported.expect("imports").warnings;
    assert_eq!(
        warnings,
        ["`cloth` has the shape that its bones give it at 0 s, and stands still"]
    );
}

#[test]
fn nodes_and_animations_have_morph_weights_of_their_own() {
    let mut parts = Parts::default();
    let square = parts.floats("VEC3", &SQUARE);
    let lifted = parts.floats("VEC3", &[[0.0, 0.0, 1.0]; 4].concat());
    let times = parts.floats("SCALAR", &[-1.0, 1.0]);
    let weights = parts.floats("SCALAR", &[2.0, 4.0]);
    let file = open(&parts.text(&format!(
        r#""meshes": [{{"weights": [0.5], "primitives": [{{"attributes": {{"POSITION": {square}}}, "mode": 6, "targets": [{{"POSITION": {lifted}}}]}}]}}],
           "nodes": [{{"mesh": 0}}, {{"mesh": 0, "weights": [1]}}, {{"mesh": 0, "weights": [1]}}, {{"mesh": 0}}],
           "animations": [{{"channels": [{{"sampler": 0, "target": {{"node": 2, "path": "weights"}}}}],
               "samplers": [{{"input": {times}, "output": {weights}}}]}}]"#
    )))
    .expect("opens");
    let heights: Vec<f32> = (0..4).map(|place| positions(&file, place)[0].z).collect();
    assert_eq!(heights, [0.5, 1.0, 3.0, 0.5]);
    let placed = file.placed_meshes().expect("reads");
    assert!(std::sync::Arc::ptr_eq(&placed[0].0, &placed[3].0));
}
