//! glTF files written by hand: what comes out as pictures and scene, what is left out, and that broken ones give one
//! error.

use std::io::Cursor;

use glam::{Affine3A, Vec3};
use sunroom::document::{Category, Child, Object, TransformOp, Value};
use sunroom::gltf::files::take_apart;
use sunroom::gltf::scene::Imported;
use sunroom::gltf::{Gltf, GltfError};

use crate::gltf_support::{Parts, SQUARE, nothing_beside, open};

/// 2 x 1 pixels: (255, 128, 0) with alpha 51, and (0, 64, 255) with alpha 204.
fn png() -> Vec<u8> {
    let image = image::RgbaImage::from_raw(2, 1, vec![255, 128, 0, 51, 0, 64, 255, 204]).expect("fits");
    let mut bytes = Cursor::new(Vec::new());
    image
        .write_to(&mut bytes, image::ImageFormat::Png)
        .expect("can be written");
    bytes.into_inner()
}

fn textured_quad(material: &str) -> (Parts, String) {
    let mut parts = Parts::default();
    let positions = parts.floats("VEC3", &SQUARE);
    let uvs = parts.floats("VEC2", &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    let image = parts.view(&png(), "");
    let rest = format!(
        r#""images": [{{"bufferView": {image}, "mimeType": "image/png"}}], "samplers": [{{"wrapS": 33071, "wrapT": 33071, "magFilter": 9728}}],
           "textures": [{{"source": 0, "sampler": 0}}], "materials": [{material}],
           "meshes": [{{"primitives": [{{"attributes": {{"POSITION": {positions}, "TEXCOORD_0": {uvs}}}, "mode": 6, "material": 0}}]}}],
           "nodes": [{{"mesh": 0}}], "scenes": [{{"nodes": [0]}}], "scene": 0"#
    );
    (parts, rest)
}

type Files = Vec<(String, Vec<u8>)>;

fn import(text: &str) -> (Imported, Files) {
    import_file(&open(text).expect("opens")).expect("imports")
}

fn import_file(file: &Gltf) -> Result<(Imported, Files), GltfError> {
    let mut files = Vec::new();
    let mut keep = |name: &str, bytes: &[u8]| {
        files.push((name.to_owned(), bytes.to_owned()));
        Ok(name.to_owned())
    };
    let imported = take_apart(file, &mut keep, &mut nothing_beside)?;
    Ok((imported, files))
}

fn of(root: &Object, category: Category) -> Vec<&Object> {
    root.objects().filter(|object| object.category == category).collect()
}

fn value<'a>(object: &'a Object, name: &str) -> &'a Value {
    let found = object.properties.iter().find(|property| property.name == name);
    &found.unwrap_or_else(|| panic!("no {name} in {object:?}")).value
}

fn inside<'a>(object: &'a Object, plugin: &str) -> &'a Object {
    object
        .objects()
        .find(|child| child.plugin == plugin)
        .unwrap_or_else(|| panic!("no {plugin} in {object:?}"))
}

fn child<'a>(object: &'a Object, name: &str) -> &'a Object {
    let named = |child: &&Object| child.name.as_deref() == Some(name);
    object
        .objects()
        .find(named)
        .unwrap_or_else(|| panic!("no {name} in {object:?}"))
}

fn world(object: &Object) -> Affine3A {
    match value(object, "to_world") {
        Value::Transform(steps) => TransformOp::compose(steps),
        other => panic!("{other:?}"),
    }
}

#[test]
fn materials_become_principled() {
    let material = r#"{"name": "tin", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 1, 1, 0.5], "baseColorTexture": {"index": 0,
          "extensions": {"KHR_texture_transform": {"offset": [0.5, 0], "scale": [2, 3], "rotation": 1.5707963}}},
          "metallicRoughnessTexture": {"index": 0}, "roughnessFactor": 0.5},
        "normalTexture": {"index": 0, "scale": 0.5}, "alphaMode": "MASK", "alphaCutoff": 0.25,
        "emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0},
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 3}, "KHR_materials_ior": {"ior": 1.33},
          "KHR_materials_clearcoat": {"clearcoatFactor": 0.75, "clearcoatRoughnessFactor": 0.25}}}"#;
    let (parts, rest) = textured_quad(material);
    let (imported, files) = import(&parts.text(&rest));
    assert_eq!(
        imported.warnings,
        [
            "material 0 (tin): its coat has the normals of what is below it",
            "material 0 (tin): alpha does not dim its light, because its pictures lie differently",
        ]
    );
    let mask = of(&imported.root, Category::Bsdf)[0];
    assert_eq!((mask.plugin.as_str(), mask.id.as_deref()), ("mask", Some("tin")));
    let normal_map = inside(inside(mask, "twosided"), "normalmap");
    assert_eq!(value(normal_map, "gltf_tangents"), &Value::Boolean(true));
    let principled = inside(normal_map, "principled");
    assert_eq!(value(principled, "eta"), &Value::Float(1.33));
    assert_eq!(value(principled, "clearcoat"), &Value::Float(0.75));
    assert_eq!(value(principled, "clearcoat_gloss"), &Value::Float(0.75));
    let color = child(principled, "base_color");
    assert_eq!(value(color, "wrap_mode"), &Value::String("clamp".into()));
    assert_eq!(value(color, "filter_type"), &Value::String("nearest".into()));
    let Value::Transform(steps) = value(color, "to_uv") else {
        panic!("no transform")
    };
    // A quarter turn to the left in the picture, whose v points down: (1, 0) goes up, to (0, -1).
    let moved = TransformOp::compose(steps).transform_point3(Vec3::X);
    assert!(moved.abs_diff_eq(Vec3::new(0.5, -2.0, 0.0), 1e-5), "{moved}");

    let picture = |object: &Object| {
        let Value::String(name) = value(object, "filename") else {
            panic!("no name")
        };
        let bytes = &files.iter().find(|(file, _)| file == name).expect("is written").1;
        (
            name.clone(),
            image::load_from_memory(bytes).expect("a picture").to_rgb32f(),
        )
    };
    let first = |object| picture(object).1.get_pixel(0, 0).0;
    let close = |a: [f32; 3], b: [f32; 3]| Vec3::from(a).abs_diff_eq(b.into(), 1e-4);
    // Half of the linear red: 0.735 as sRGB.
    assert!(
        close(first(color), [0.735_36, 128.0 / 255.0, 0.0]),
        "{:?}",
        first(color)
    );
    // Green is roughness, blue metallic, both raw; the metallic factor is 1 by default.
    for (name, share) in [("roughness", 64.0 / 255.0), ("metallic", 0.0)] {
        let texture = child(principled, name);
        assert_eq!(value(texture, "raw"), &Value::Boolean(true));
        assert!(close(first(texture), [share; 3]), "{name}: {:?}", first(texture));
    }
    // 0.2 * 0.5 is below the cutoff, 0.8 * 0.5 above.
    let opacity = picture(child(mask, "opacity")).1;
    assert_eq!(
        (opacity.get_pixel(0, 0).0, opacity.get_pixel(1, 0).0),
        ([0.0; 3], [1.0; 3])
    );
    let normal = Vec3::from(first(child(normal_map, "normalmap"))) * 2.0 - 1.0;
    let expected = Vec3::new(0.5, 0.5 / 255.0, -1.0).normalize();
    assert!(normal.abs_diff_eq(expected, 1e-4), "{normal} {expected}");
    let area = inside(of(&imported.root, Category::Shape)[0], "area");
    let (name, radiance) = picture(child(area, "radiance"));
    assert!(
        name.ends_with(".exr") && close(radiance.get_pixel(0, 0).0, [3.0, 3.0 * 0.215_86, 0.0]),
        "{name}"
    );
}

#[test]
fn transmission_is_thin_without_a_volume() {
    let material = |more: &str| {
        let text = format!(
            r#"{{"pbrMetallicRoughness": {{"metallicFactor": 0}}, "extensions": {{"KHR_materials_transmission": {{"transmissionFactor": 0.9}}{more}}}}}"#
        );
        let (parts, rest) = textured_quad(&text);
        import(&parts.text(&rest)).0
    };
    let thin = material("");
    let bsdf = of(&thin.root, Category::Bsdf)[0];
    assert_eq!(
        (bsdf.plugin.as_str(), value(bsdf, "spec_trans")),
        ("principledthin", &Value::Float(0.9))
    );
    let volume = |numbers: &str| material(&format!(r#", "KHR_materials_volume": {{{numbers}}}"#));
    let clear = volume(r#""thicknessFactor": 1"#);
    assert_eq!(of(&clear.root, Category::Bsdf)[0].plugin, "principled");
    assert!(of(&clear.root, Category::Medium).is_empty());
    assert_eq!(of(&clear.root, Category::Integrator)[0].plugin, "path");
}

/// After the attenuation distance light has the attenuation colour.
#[test]
fn a_volume_absorbs_light() {
    let import_with = |numbers: &str| {
        let text = format!(
            r#"{{"extensions": {{"KHR_materials_transmission": {{"transmissionFactor": 1}}, "KHR_materials_volume": {{{numbers}}}}}}}"#
        );
        let (parts, rest) = textured_quad(&text);
        import(&parts.text(&rest)).0
    };
    let green = r#""thicknessFactor": 1, "attenuationDistance": 2, "attenuationColor": [0.25, 1, 0]"#;
    let Imported { root, warnings, .. } = import_with(green);
    assert!(warnings.is_empty(), "{warnings:?}");
    let medium = of(&root, Category::Medium)[0];
    let Value::Rgb(sigma_t) = value(medium, "sigma_t") else {
        panic!("{medium:?}");
    };
    let left = sigma_t.map(|sigma| (-2.0 * sigma).exp());
    assert!(left.abs_diff_eq(Vec3::new(0.25, 1.0, 0.0), 1e-6), "{left}");
    assert_eq!(value(medium, "albedo"), &Value::Float(0.0));
    let inside = of(&root, Category::Shape)[0].children.iter();
    let inside: Vec<_> = inside.filter(|child| child.name() == Some("interior")).collect();
    let is_it = |child: &Child| matches!(child, Child::Reference { id, .. } if Some(id) == medium.id.as_ref());
    assert!(inside.len() == 1 && is_it(inside[0]), "{inside:?}");
    assert_eq!(of(&root, Category::Integrator)[0].plugin, "volpath");
    // Without thickness there is no inside, and white or infinitely far light is not absorbed.
    for numbers in [
        r#""attenuationDistance": 2, "attenuationColor": [0.5, 1, 1]"#,
        r#""thicknessFactor": 1, "attenuationDistance": 2"#,
        r#""thicknessFactor": 1, "attenuationColor": [0.5, 1, 1]"#,
        r#""thicknessFactor": 1, "attenuationDistance": 0, "attenuationColor": [0.5, 1, 1]"#,
    ] {
        assert!(of(&import_with(numbers).root, Category::Medium).is_empty(), "{numbers}");
    }
}

/// The intensity of a light in the units of the file.
fn assert_candela(light: &Object, expected: Vec3) {
    let Value::Rgb(intensity) = value(light, "intensity") else {
        panic!("{light:?}")
    };
    let candela = 683.0 * *intensity;
    assert!(candela.abs_diff_eq(expected, 1e-5), "{candela}, expected {expected}");
}

#[test]
fn nodes_place_meshes_cameras_and_lights() {
    let mut parts = Parts::default();
    let positions = parts.floats("VEC3", &SQUARE);
    let text = parts.text(&format!(
        r#""meshes": [{{"name": "leaf", "primitives": [{{"attributes": {{"POSITION": {positions}}}}}]}}],
        "cameras": [{{"type": "perspective", "perspective": {{"yfov": 0.5, "aspectRatio": 2, "znear": 0.1}}}},
            {{"type": "orthographic", "orthographic": {{"xmag": 3, "ymag": 1.5, "znear": 0.1, "zfar": 50}}}}],
        "extensions": {{"KHR_lights_punctual": {{"lights": [{{"type": "point", "color": [1, 0.5, 0], "intensity": 4}},
            {{"type": "directional"}}, {{"type": "spot", "spot": {{"innerConeAngle": 0.1, "outerConeAngle": 0.5}}}}]}}}},
        "nodes": [{{"translation": [1, 2, 3], "rotation": [0, 0.70710678, 0, 0.70710678], "children": [1, 2, 3, 4, 5]}},
            {{"mesh": 0, "scale": [2, 2, 2]}}, {{"camera": 0}}, {{"camera": 1, "name": "flat/plan"}},
            {{"extensions": {{"KHR_lights_punctual": {{"light": 0}}}}}},
            {{"matrix": [1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1], "children": [6, 7]}},
            {{"extensions": {{"KHR_lights_punctual": {{"light": 1}}}}}}, {{"extensions": {{"KHR_lights_punctual": {{"light": 2}}}}}}]"#
    ));
    let (imported, files) = import(&text);
    let root = &imported.root;
    // (x, y, z) turns to (z, y, -x).
    let placed = world(of(root, Category::Shape)[0]).transform_point3(Vec3::new(1.0, 1.0, 0.0));
    assert!(placed.abs_diff_eq(Vec3::new(1.0, 4.0, 1.0), 1e-5), "{placed}");
    assert_eq!(
        value(of(root, Category::Shape)[0], "face_normals"),
        &Value::Boolean(true)
    );
    let cameras = of(root, Category::Sensor);
    let [perspective, plan] = cameras[..] else {
        panic!("{cameras:?}")
    };
    assert_eq!(
        (perspective.plugin.as_str(), plan.plugin.as_str()),
        ("perspective", "orthographic")
    );
    assert_eq!(plan.id.as_deref(), Some("flat_plan"));
    assert_eq!(value(perspective, "fov"), &Value::Float(0.5f32.to_degrees()));
    assert_eq!(value(inside(perspective, "hdrfilm"), "width"), &Value::Integer(1440));
    // It looked along -z, which turned to -x; its right was +x, which turned to -z.
    let pose = world(perspective);
    assert!(pose.transform_vector3(Vec3::Z).abs_diff_eq(Vec3::NEG_X, 1e-5));
    assert!(
        pose.transform_vector3(Vec3::X).abs_diff_eq(Vec3::Z, 1e-5),
        "+x is to the left"
    );
    assert!((world(plan).transform_vector3(Vec3::X).length() - 3.0).abs() < 1e-5);
    let lights = of(root, Category::Emitter);
    let [point, sun, spot] = lights[..] else {
        panic!("{lights:?}")
    };
    assert_candela(point, Vec3::new(4.0, 2.0, 0.0));
    let Value::Point(place) = value(point, "position") else {
        panic!()
    };
    assert!(place.abs_diff_eq(Vec3::new(1.0, 2.0, 3.0), 1e-5));
    // -z turns to -y by the matrix, which stays there.
    let Value::Vector(direction) = value(sun, "direction") else {
        panic!()
    };
    assert!(direction.abs_diff_eq(Vec3::NEG_Y, 1e-5), "{direction}");
    assert!(world(spot).transform_vector3(Vec3::Z).abs_diff_eq(Vec3::NEG_Y, 1e-5));
    assert_eq!(value(spot, "cutoff_angle"), &Value::Float(0.5f32.to_degrees()));
    assert_eq!(files.len(), 1);
}

#[test]
fn without_camera_and_light_there_are_some() {
    let (parts, rest) = textured_quad("{}");
    let (imported, _) = import(&parts.text(&rest));
    let sensor = of(&imported.root, Category::Sensor)[0];
    let pose = world(sensor);
    let toward = Vec3::new(0.5, 0.5, 0.0) - Vec3::from(pose.translation);
    assert!(pose.transform_vector3(Vec3::Z).dot(toward.normalize()) > 0.9999);
    let studio = of(&imported.root, Category::Emitter)[0];
    assert_eq!(studio.plugin, "envmap");
    assert_eq!(imported.stand_in.as_deref(), studio.id.as_deref());
}

/// A square that shines as its material says, on a floor of 100 times its area, with a punctual light.
fn stand_in(material: &str, floor: bool, light: &str) -> Option<String> {
    let (mut parts, rest) = textured_quad(material);
    let far: Vec<f32> = SQUARE.iter().map(|number| 10.0 * number).collect();
    let far = parts.floats("VEC3", &far);
    let nodes = match floor {
        true => r#""nodes": [{"mesh": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}, {"mesh": 1}]"#,
        false => r#""nodes": [{"mesh": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}]"#,
    };
    let rest = rest
        .replace(r#""nodes": [{"mesh": 0}]"#, nodes)
        .replace(
            r#""nodes": [0]"#,
            if floor { r#""nodes": [0, 1]"# } else { r#""nodes": [0]"# },
        )
        .replace(
            r#""meshes": ["#,
            &format!(r#""extensions": {{"KHR_lights_punctual": {{"lights": [{light}]}}}}, "meshes": ["#),
        )
        .replace(
            r#""material": 0}]}]"#,
            &format!(r#""material": 0}}]}}, {{"primitives": [{{"attributes": {{"POSITION": {far}}}, "mode": 6}}]}}]"#),
        );
    let (imported, _) = import(&parts.text(&rest));
    let studios = of(&imported.root, Category::Emitter);
    let studios = studios.iter().filter(|emitter| emitter.plugin == "envmap").count();
    assert_eq!(studios, usize::from(imported.stand_in.is_some()));
    imported.stand_in
}

#[test]
fn what_stands_in_for_light_goes_when_something_lights_the_scene() {
    let dark = r#"{"type": "point", "intensity": 0}"#;
    let emission = |factor: &str, more: &str| format!(r#"{{"emissiveFactor": {factor}{more}}}"#);
    let strength = |strength: &str| {
        format!(r#", "extensions": {{"KHR_materials_emissive_strength": {{"emissiveStrength": {strength}}}}}"#)
    };
    // The mean of the picture has a luminance of about 0.22.
    let picture = r#", "emissiveTexture": {"index": 0}"#;
    let gone = r#", "alphaMode": "MASK", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.1]}"#;
    for (material, floor, light, is_lit) in [
        ("{}".to_owned(), false, dark, false),
        ("{}".to_owned(), false, r#"{"type": "directional"}"#, true),
        ("{}".to_owned(), false, r#"{"type": "spot", "color": [0, 0, 0]}"#, false),
        (emission("[1, 1, 1]", ""), false, dark, true),
        (emission("[0.01, 0.01, 0.01]", ""), false, dark, false),
        (emission("[0, 0, 0]", picture), false, dark, false),
        (emission("[1, 1, 1]", picture), false, dark, true),
        (emission("[0.05, 0.05, 0.05]", picture), false, dark, false),
        // A small lamp in a large place has to be bright.
        (emission("[1, 1, 1]", ""), true, dark, false),
        (emission("[1, 1, 1]", &strength("10")), true, dark, true),
        (emission("[1, 1, 1]", &strength("0")), false, dark, false),
        (emission("[1, 1, 1]", gone), false, dark, false),
    ] {
        let found = stand_in(&material, floor, light);
        assert_eq!(found.is_none(), is_lit, "{material} {light}: {found:?}");
    }
}

#[test]
fn black_pictures_do_not_shine() {
    let (mut parts, rest) = textured_quad(r#"{"emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0}}"#);
    let image = image::RgbImage::new(2, 2);
    let mut bytes = Cursor::new(Vec::new());
    image
        .write_to(&mut bytes, image::ImageFormat::Png)
        .expect("can be written");
    let black = parts.view(&bytes.into_inner(), "");
    let rest = rest.replace(r#""bufferView": 2"#, &format!(r#""bufferView": {black}"#));
    let (imported, _) = import(&parts.text(&rest));
    assert!(imported.stand_in.is_some());
    assert!(
        of(&imported.root, Category::Shape)[0]
            .objects()
            .all(|child| child.plugin != "area")
    );
}

#[test]
fn light_goes_by_alpha_and_from_both_sides_of_what_has_two() {
    let emitter = |material: &str| {
        let (parts, rest) = textured_quad(material);
        let (imported, files) = import(&parts.text(&rest));
        assert_eq!(imported.warnings, Vec::<String>::new(), "{material}");
        (inside(of(&imported.root, Category::Shape)[0], "area").clone(), files)
    };
    let light = |material: &str| {
        let (area, files) = emitter(material);
        let Value::String(name) = value(child(&area, "radiance"), "filename") else {
            panic!("no name")
        };
        let bytes = &files.iter().find(|(file, _)| file == name).expect("is written").1;
        let image = image::load_from_memory(bytes).expect("a picture").to_rgb32f();
        [0, 1].map(|x| Vec3::from(image.get_pixel(x, 0).0))
    };
    let (one, both) = (
        r#"{"emissiveFactor": [1, 1, 1]}"#,
        r#"{"emissiveFactor": [1, 1, 1], "doubleSided": true}"#,
    );
    assert!(
        emitter(one)
            .0
            .properties
            .iter()
            .all(|property| property.name != "two_sided")
    );
    assert_eq!(value(&emitter(both).0, "two_sided"), &Value::Boolean(true));
    // Alpha is 0.2 and 0.8.
    let base = r#""pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}"#;
    let [left, right] = light(&format!(
        r#"{{"emissiveFactor": [1, 0.5, 0], "alphaMode": "MASK", {base}}}"#
    ));
    assert_eq!(left, Vec3::ZERO);
    assert!(right.abs_diff_eq(Vec3::new(1.0, 0.735_36, 0.0), 1e-4), "{right}");
    // Both pictures are one here; the numbers of those that are brighter than white are linear.
    let [left, right] = light(&format!(
        r#"{{"emissiveFactor": [2, 2, 2], "emissiveTexture": {{"index": 0}}, "alphaMode": "BLEND", {base}}}"#
    ));
    assert!(left.abs_diff_eq(0.4 * Vec3::new(1.0, 0.215_86, 0.0), 1e-4), "{left}");
    assert!(right.abs_diff_eq(1.6 * Vec3::new(0.0, 0.051_27, 1.0), 1e-4), "{right}");
    // Without a picture the factor alone counts.
    let faded = r#"{"emissiveFactor": [1, 1, 1], "alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.25]}}"#;
    assert_eq!(value(&emitter(faded).0, "radiance"), &Value::Rgb(Vec3::splat(0.25)));
}

/// The quad with colours of its vertices, the last of which are clear.
fn colored_quad(material: &str) -> Imported {
    let (mut parts, rest) = textured_quad(material);
    let colors = parts.floats("VEC4", &[[1.0, 0.5, 0.0, 1.0], [1.0, 0.5, 0.0, 0.0]].concat().repeat(2));
    let rest = rest.replace(r#""POSITION": 0"#, &format!(r#""POSITION": 0, "COLOR_0": {colors}"#));
    import(&parts.text(&rest)).0
}

#[test]
fn colours_of_vertices_multiply_pictures_and_their_alpha_counts() {
    let picture = r#""baseColorTexture": {"index": 0}"#;
    let imported = colored_quad(&format!(r#"{{"pbrMetallicRoughness": {{{picture}}}}}"#));
    assert_eq!(imported.warnings, Vec::<String>::new());
    let principled = inside(of(&imported.root, Category::Bsdf)[0], "principled");
    let colors = child(principled, "base_color");
    assert_eq!(
        (colors.plugin.as_str(), value(colors, "name")),
        ("mesh_attribute", &Value::String("vertex_color".into()))
    );
    assert_eq!(child(colors, "times").plugin, "bitmap");

    let fading = colored_quad(r#"{"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [1, 1, 1, 0.5]}}"#);
    let opacity = child(of(&fading.root, Category::Bsdf)[0], "opacity");
    assert_eq!(value(opacity, "name"), &Value::String("vertex_alpha".into()));
    assert_eq!(value(opacity, "scale"), &Value::Float(0.5));
    let both = colored_quad(&format!(
        r#"{{"alphaMode": "BLEND", "pbrMetallicRoughness": {{{picture}}}}}"#
    ));
    assert_eq!(
        child(child(of(&both.root, Category::Bsdf)[0], "opacity"), "times").plugin,
        "bitmap"
    );
    assert_eq!([fading.warnings, both.warnings].concat(), Vec::<String>::new());
    let cut = colored_quad(r#"{"name": "lace", "alphaMode": "MASK"}"#);
    assert_eq!(
        cut.warnings,
        ["material 0 (lace): alpha of vertices fades, and is not cut off"]
    );
    // Opaque surfaces have none.
    let opaque = colored_quad("{}");
    assert_eq!(
        (of(&opaque.root, Category::Bsdf)[0].plugin.as_str(), opaque.warnings),
        ("twosided", vec![])
    );
}

#[test]
fn metal_beside_thin_glass_is_a_blend() {
    let bsdf = |pbr: &str, more: &str| {
        let text = format!(
            r#"{{"name": "leaded", "pbrMetallicRoughness": {{{pbr}}}, "extensions": {{"KHR_materials_transmission": {{"transmissionFactor": 1}}{more}}}}}"#
        );
        let (parts, rest) = textured_quad(&text);
        let (imported, _) = import(&parts.text(&rest));
        (of(&imported.root, Category::Bsdf)[0].clone(), imported.warnings)
    };
    let (blend, warnings) = bsdf(r#""metallicFactor": 0.25, "roughnessFactor": 0.5"#, "");
    assert_eq!(warnings, Vec::<String>::new());
    assert_eq!(
        (blend.plugin.as_str(), value(&blend, "weight")),
        ("blendbsdf", &Value::Float(0.25))
    );
    let bsdfs: Vec<&str> = blend.objects().map(|inner| inner.plugin.as_str()).collect();
    assert_eq!(bsdfs, ["principledthin", "twosided"]);
    let metal = inside(inside(&blend, "twosided"), "principled");
    assert_eq!(value(metal, "metallic"), &Value::Float(1.0));
    assert_eq!(value(metal, "roughness"), &Value::Float(0.5));
    let (by_picture, _) = bsdf(r#""metallicRoughnessTexture": {"index": 0}"#, "");
    assert_eq!(child(&by_picture, "weight").plugin, "bitmap");
    // What is all metal lets nothing through.
    let (metal, _) = bsdf(r#""metallicFactor": 1"#, "");
    assert_eq!(
        inside(&metal, "principled")
            .properties
            .iter()
            .find(|it| it.name == "spec_trans"),
        None
    );
    let (_, warnings) = bsdf(
        r#""metallicFactor": 0"#,
        r#", "KHR_materials_clearcoat": {"clearcoatFactor": 1}"#,
    );
    assert!(
        warnings.len() == 1 && warnings[0].contains("(leaded)") && warnings[0].contains("coat is left out"),
        "{warnings:?}"
    );
}

#[test]
fn layers_that_the_models_cannot_have_are_named() {
    let said = |layers: &str| {
        let (parts, rest) = textured_quad(&format!(r#"{{"name": "cloth", "extensions": {{{layers}}}}}"#));
        let (imported, _) = import(&parts.text(&rest));
        let bsdf = inside(of(&imported.root, Category::Bsdf)[0], "principled").clone();
        (bsdf, imported.warnings)
    };
    let sheen = |numbers: &str| said(&format!(r#""KHR_materials_sheen": {{{numbers}}}"#));
    let (bsdf, warnings) = sheen(r#""sheenColorFactor": [0.5, 0.5, 0.5], "sheenRoughnessFactor": 0.5"#);
    let Value::Float(strength) = value(&bsdf, "sheen") else {
        panic!("no number")
    };
    assert!((strength - 0.5).abs() < 1e-5, "{strength}");
    assert_eq!(warnings, Vec::<String>::new());
    for (numbers, part) in [
        (
            r#""sheenColorFactor": [0.9, 0.1, 0.1], "sheenRoughnessFactor": 0.5"#,
            "not all of the colour",
        ),
        (r#""sheenColorFactor": [0.5, 0.5, 0.5]"#, "width"),
        (
            r#""sheenColorFactor": [0.5, 0.5, 0.5], "sheenRoughnessFactor": 0.5, "sheenColorTexture": {"index": 0}"#,
            "not the colour",
        ),
    ] {
        let (_, warnings) = sheen(numbers);
        assert!(
            warnings.len() == 1 && warnings[0].contains("(cloth)") && warnings[0].contains(part),
            "{numbers}: {warnings:?}"
        );
    }
    // A reflectance of 4 % head on, as converters from specular-glossiness write it: that of an index of 1.5.
    let (bsdf, warnings) = said(
        r#""KHR_materials_specular": {"specularColorFactor": [0.04, 0.04, 0.04]}, "KHR_materials_ior": {"ior": 1000}"#,
    );
    assert_eq!(warnings, Vec::<String>::new());
    let Value::Float(eta) = value(&bsdf, "eta") else {
        panic!("no number")
    };
    assert!((eta - 1.5).abs() < 2e-3, "{eta}");
}

#[test]
fn pictures_repeat_along_u_and_v_each_in_its_own_way() {
    let wraps = |s: u32, t: u32| {
        let (parts, rest) = textured_quad(r#"{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}"#);
        let rest = rest.replace(
            r#""wrapS": 33071, "wrapT": 33071"#,
            &format!(r#""wrapS": {s}, "wrapT": {t}"#),
        );
        let (imported, _) = import(&parts.text(&rest));
        assert_eq!(imported.warnings, Vec::<String>::new());
        let color = child(
            inside(of(&imported.root, Category::Bsdf)[0], "principled"),
            "base_color",
        )
        .clone();
        ["wrap_mode", "wrap_mode_v"].map(|name| {
            let found = color.properties.iter().find(|property| property.name == name);
            found.map(|property| property.value.clone())
        })
    };
    let mode = |name: &str| Some(Value::String(name.into()));
    assert_eq!(wraps(33071, 10497), [mode("clamp"), mode("repeat")]);
    assert_eq!(wraps(10497, 33648), [None, mode("mirror")]);
    assert_eq!(wraps(33648, 33648), [mode("mirror"), None]);
}

/// The node of a skinned mesh does not place it, but its bones do: by their rest pose, from the pose in which the mesh
/// is bound to them.
#[test]
fn bones_place_skinned_meshes() {
    let place = |skin: &str, bone: &str| {
        let mut parts = Parts::default();
        let positions = parts.floats("VEC3", &SQUARE);
        let mut bound = glam::Mat4::from_translation(Vec3::new(0.0, 0.0, -5.0))
            .to_cols_array()
            .to_vec();
        bound.extend(glam::Mat4::IDENTITY.to_cols_array());
        let view = parts.view(
            &bound.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<_>>(),
            "",
        );
        parts.accessor(view, 5126, "MAT4", 2, "");
        let text = parts.text(&format!(
            r#""meshes": [{{"primitives": [{{"attributes": {{"POSITION": {positions}}}, "mode": 6}}]}}], "skins": [{skin}],
               "nodes": [{{"mesh": 0, "skin": 0, "scale": [0.3, 0.3, 0.3], "children": [3]}}, {{"children": [2], "translation": [1, 0, 0]}}, {{{bone}}}, {{"mesh": 0}}],
               "scenes": [{{"nodes": [0, 1]}}]"#
        ));
        let file = open(&text).expect("opens");
        let (imported, _) = import_file(&file).expect("imports");
        let shapes = of(&imported.root, Category::Shape);
        let is_placed = |shape: &&Object| shape.properties.iter().any(|property| property.name == "to_world");
        // What hangs on the node goes by it.
        assert!(
            world(shapes[1])
                .transform_vector3(Vec3::X)
                .abs_diff_eq(0.3 * Vec3::X, 1e-6)
        );
        let found = if is_placed(&shapes[0]) {
            world(shapes[0])
        } else {
            Affine3A::IDENTITY
        };
        assert_eq!(file.placed_meshes().expect("reads")[0].1, found);
        (found, imported.warnings)
    };
    let none = Vec::<String>::new();
    assert_eq!(place(r#"{"joints": []}"#, ""), (Affine3A::IDENTITY, none.clone()));
    let shifted = Affine3A::from_translation(Vec3::X);
    assert_eq!(place(r#"{"joints": [2]}"#, ""), (shifted, none.clone()));
    let bound = place(
        r#"{"joints": [2, 1], "inverseBindMatrices": 1}"#,
        r#""translation": [0, 0, 5]"#,
    );
    assert_eq!(bound, (shifted, none));
    // Bones that do not agree bend it, and what they bend is in world space.
    let (bent, warnings) = place(r#"{"joints": [2, 1]}"#, r#""translation": [0, 0, 5]"#);
    assert_eq!((bent, warnings), (Affine3A::IDENTITY, Vec::new()));
}

#[test]
fn a_scene_of_no_extent_is_framed_and_one_beyond_all_numbers_is_refused_for_that() {
    let frame = |corner: f32, scale: f32| {
        let (mut parts, rest) = textured_quad("{}");
        let corners: Vec<f32> = SQUARE.iter().map(|number| corner + scale * number).collect();
        let square = parts.floats("VEC3", &corners);
        let rest = rest.replacen(r#""POSITION": 0"#, &format!(r#""POSITION": {square}"#), 1);
        let file = open(&parts.text(&rest)).expect("opens");
        import_file(&file).map(|(imported, _)| imported)
    };
    for (corner, scale) in [
        (0.0, 0.0),
        (7.0, 0.0),
        (-1e12, 0.0),
        (0.0, 1e-38),
        (1e6, 1e-3),
        (0.0, 1e12),
    ] {
        let imported = frame(corner, scale).expect("can be framed");
        let pose = world(of(&imported.root, Category::Sensor)[0]);
        assert!(pose.is_finite(), "{corner} {scale}: {pose}");
        let toward = Vec3::splat(corner) + 0.5 * scale * Vec3::new(1.0, 1.0, 0.0) - Vec3::from(pose.translation);
        if corner == 0.0 && scale < 1.0 {
            // A sphere of radius 1 fills a field of view of 40 degrees.
            let distance = 1.0 / 20f32.to_radians().sin();
            assert!(
                (toward.length() / distance - 1.0).abs() < 1e-5,
                "{corner} {scale}: {pose}"
            );
        }
        let toward = (toward / toward.abs().max_element()).normalize();
        assert!(
            pose.transform_vector3(Vec3::Z).dot(toward) > 0.99,
            "{corner} {scale}: {pose}"
        );
        // Only what is too small to see is said.
        assert_eq!(
            imported.warnings.len(),
            usize::from(scale < 1.0),
            "{:?}",
            imported.warnings
        );
    }
    let said = |corner, scale| frame(corner, scale).expect("can be framed").warnings.concat();
    assert!(said(0.0, 0.0).contains("an extent of 0, too small for a camera to frame: the camera frames 1"));
    assert!(said(1e6, 1e-3).contains("the camera frames 10"), "{}", said(1e6, 1e-3));
    for (corner, scale) in [(0.0, 1e13), (1e20, 1.0), (0.0, 3e38), (-2e38, 3e38)] {
        let error = frame(corner, scale).expect_err("is too large").to_string();
        assert!(error.contains("no camera") && error.contains("reaches to"), "{error}");
    }
    let nothing = r#"{"asset": {"version": "2.0"}}"#;
    let (imported, _) = import(nothing);
    assert_eq!(imported.warnings, ["the scene has no triangles"]);
    assert_eq!(of(&imported.root, Category::Sensor).len(), 1);
}

#[test]
fn a_file_of_which_no_primitive_can_be_read_is_an_error() {
    let (parts, rest) = textured_quad("{}");
    let text = parts
        .text(&rest)
        .replacen(r#""count": 4"#, r#""count": 9223372036854775808"#, 1);
    let file = open(&text).expect("opens");
    let error = import_file(&file).map(|_| ()).expect_err("nothing is left").to_string();
    assert!(error.contains("accessor 0 has 9223372036854775808 elements"), "{error}");
}

#[test]
fn light_is_neither_negative_nor_infinite() {
    let lit = |material: &str, lights: &str| {
        let (parts, rest) = textured_quad(material);
        let rest = rest.replacen(
            r#"{"mesh": 0}"#,
            r#"{"mesh": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}"#,
            1,
        );
        let lights = format!(r#""extensions": {{"KHR_lights_punctual": {{"lights": [{lights}]}}}}, "#);
        import(&parts.text(&format!("{lights}{rest}"))).0
    };
    let imported = lit(
        r#"{"name": "lamp", "emissiveFactor": [1, -0.5, 0]}"#,
        r#"{"type": "point", "name": "bulb", "color": [1, 0.5, -1], "intensity": 2}"#,
    );
    let area = inside(of(&imported.root, Category::Shape)[0], "area");
    assert_eq!(value(area, "radiance"), &Value::Rgb(Vec3::X));
    let point = of(&imported.root, Category::Emitter)[0];
    assert_candela(point, Vec3::new(2.0, 1.0, 0.0));
    let [lamp, bulb] = &imported.warnings[..] else {
        panic!("{:?}", imported.warnings)
    };
    assert!(
        lamp.contains("material 0 (lamp)") && lamp.contains("negative"),
        "{lamp}"
    );
    assert!(bulb.contains("`bulb`") && bulb.contains("negative"), "{bulb}");
    // A light that takes everything away is none.
    let imported = lit(
        r#"{"emissiveFactor": [-1, -1, -1]}"#,
        r#"{"type": "point", "intensity": 1e39}"#,
    );
    assert_eq!(imported.warnings.len(), 2, "{:?}", imported.warnings);
    let point = of(&imported.root, Category::Emitter)[0];
    assert_eq!(value(point, "intensity"), &Value::Rgb(Vec3::ZERO));
}

#[test]
fn a_mesh_is_written_as_it_is_read() {
    let (parts, rest) = textured_quad("{}");
    let file = Gltf::open(&parts.binary(&rest), &mut nothing_beside).expect("opens");
    let (imported, files) = import_file(&file).expect("imports");
    let again = sunroom::geometry::ply::load_ply(&files[0].1).expect("a PLY file");
    assert_eq!(again.warnings, Vec::<String>::new());
    assert_eq!(again.mesh, file.mesh(0).expect("a mesh").mesh);
    let Some(Child::Reference { id, .. }) = of(&imported.root, Category::Shape)[0].children.first() else {
        panic!("no material")
    };
    assert_eq!(of(&imported.root, Category::Bsdf)[0].id.as_ref(), Some(id));
}

#[test]
fn what_is_passed_over_is_said() {
    let material = r#"{"extensions": {"KHR_materials_specular": {"specularColorFactor": [1, 0.5, 0]},
        "KHR_materials_iridescence": {"iridescenceFactor": 1}}}"#;
    let (parts, rest) = textured_quad(material);
    let used = r#""extensionsUsed": ["KHR_materials_specular", "KHR_materials_iridescence"], "#;
    let (imported, _) = import(&parts.text(&format!("{used}{rest}")));
    let [iridescence, specular] = &imported.warnings[..] else {
        panic!("{:?}", imported.warnings)
    };
    assert_eq!(iridescence, "material 0: its thin film has no colours (iridescence)");
    assert!(specular.contains("not all of the colour"), "{specular}");
}

/// Also where the file does not list the extension, and of many materials the first ones alone.
#[test]
fn extensions_that_are_not_read_are_told_of_with_their_materials() {
    let brushed = |name: &str| {
        format!(
            r#"{{"name": "{name}", "extensions": {{"KHR_materials_fuzz": {{"fuzzStrength": 1}}, "KHR_materials_ior": {{"ior": 1.4}}}}}}"#
        )
    };
    let (parts, rest) = textured_quad(&brushed("steel"));
    let (imported, _) = import(&parts.text(&rest));
    assert_eq!(
        imported.warnings,
        ["the extension KHR_materials_fuzz of material 0 (steel) is not read"]
    );
    let many: Vec<String> = ["a", "b", "c", "d", "e", "f", "g"].map(brushed).into();
    let (parts, rest) = textured_quad(&many.join(","));
    let used = r#""extensionsUsed": ["KHR_materials_fuzz", "KHR_xmp"], "#;
    let (imported, _) = import(&parts.text(&format!("{used}{rest}")));
    assert_eq!(
        imported.warnings,
        [
            "the extension KHR_materials_fuzz of material 0 (a), material 1 (b), material 2 (c), material 3 (d), material 4 (e) and 2 more is not read",
            "the extension KHR_xmp is not read"
        ]
    );
}

#[test]
fn variants_are_told_of_by_name() {
    let (parts, rest) = textured_quad("{}");
    let names: Vec<String> = (1..=7).map(|number| format!(r#"{{"name": "v{number}"}}"#)).collect();
    let variants = format!(
        r#""extensionsRequired": ["KHR_materials_variants"], "extensions": {{"KHR_materials_variants": {{"variants": [{}]}}}}, "#,
        names.join(",")
    );
    let (imported, _) = import(&parts.text(&format!("{variants}{rest}")));
    assert_eq!(
        imported.warnings,
        [
            "the materials are those without a variant; the file also has `v1`, `v2`, `v3`, `v4`, `v5` and 2 more (KHR_materials_variants)"
        ]
    );
}

#[test]
fn what_cannot_be_is_one_error() {
    let (parts, rest) = textured_quad("{}");
    let good = parts.text(&rest);
    let table = [
        (r#""version": "2.0""#, r#""version": "1.0""#, "1.0"),
        (
            r#""asset""#,
            r#""extensionsRequired": ["KHR_physics_rigid_bodies"], "asset""#,
            "KHR_physics",
        ),
        (r#""mesh": 0}"#, r#""mesh": 7}"#, "mesh 7"),
        (
            r#"{"mesh": 0}"#,
            r#"{"mesh": 0, "camera": 0}], "cameras": [{"perspective": {"yfov": 1e39, "znear": 1}}"#,
            "`fov` of sensor",
        ),
        (r#""nodes": [0]"#, r#""nodes": [3]"#, "node 3"),
        (r#"{"mesh": 0}"#, r#"{"mesh": 0, "children": [0]}"#, "ancestor"),
        (";base64,", ";base64,!", "base64"),
        ("data:application/octet-stream;base64,", "http://a/b?", "fetched"),
    ];
    for (old, new, part) in table {
        let text = good.replacen(old, new, 1);
        assert_ne!(text, good, "{old} is not there");
        let opened = open(&text).and_then(|file| import_file(&file).map(|_| ()));
        let message = opened.expect_err(part).to_string();
        assert!(message.contains(part), "{message}");
    }
    let message = open("no glTF at all").expect_err("no JSON").to_string();
    assert!(message.starts_with("the file is neither binary glTF"), "{message}");
    let message = open("{ \"asset\": 1 }").expect_err("not an object").to_string();
    assert!(message.contains("at line 1 column 12"), "{message}");
}

/// Accessors that claim more elements than memory holds, without a buffer for them.
const HUGE: &str = r#""componentType": 5126, "type": "VEC3", "count": 1000000000"#;
const ENDLESS: &str = r#""componentType": 5126, "type": "VEC3", "count": 9223372036854775808"#;

#[test]
fn what_cannot_be_read_of_a_mesh_is_left_out_and_said() {
    let (mut parts, rest) = textured_quad("{}");
    // Beside the square of the file a second one, which is good.
    let rest = rest
        .replace(
            r#""meshes": ["#,
            r#""meshes": [{"primitives": [{"attributes": {"POSITION": 2}}]}, "#,
        )
        .replace(
            r#""nodes": [{"mesh": 0}]"#,
            r#""nodes": [{"mesh": 1, "name": "flag"}, {"mesh": 0}]"#,
        )
        .replace(r#""nodes": [0]"#, r#""nodes": [0, 1]"#);
    parts.floats("VEC3", &SQUARE);
    let good = parts.text(&rest);
    assert_eq!(import(&good).0.warnings, Vec::<String>::new());
    let table = [
        (r#""count": 4"#, r#""count": 4000000000"#, "elements"),
        (
            r#""bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 4"#,
            HUGE,
            "1000000000 elements without a buffer",
        ),
        (
            r#""bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 4"#,
            ENDLESS,
            "9223372036854775808 elements",
        ),
        (r#""type": "VEC3""#, r#""type": "MAT4""#, "VEC3"),
        (r#""byteOffset": 0"#, r#""byteOffset": 18446744073709551615"#, "beyond"),
        (r#""mode": 6"#, r#""mode": 6, "indices": 1"#, "indices"),
        (r#""componentType": 5126"#, r#""componentType": 5130"#, "5130"),
        (r#""POSITION": 0"#, r#""POSITIONS": 0"#, "no positions"),
        (r#""POSITION": 0"#, r#""POSITION": 9"#, "accessor 9"),
    ];
    for (old, new, part) in table {
        let text = good.replacen(old, new, 1);
        assert_ne!(text, good, "{old} is not there");
        let (imported, files) = import(&text);
        let [warning] = &imported.warnings[..] else {
            panic!("{part}: {:?}", imported.warnings)
        };
        assert!(warning.contains("flag") && warning.contains(part), "{warning}");
        assert_eq!(of(&imported.root, Category::Shape).len(), 1, "{part}");
        let meshes = files.iter().filter(|(name, _)| name.ends_with(".ply"));
        assert_eq!(meshes.count(), 1, "{part}");
    }
    let (imported, _) = import(&good.replacen(r#""material": 0"#, r#""material": 4"#, 1));
    assert!(imported.warnings.len() == 1 && imported.warnings[0].contains("material 4"));
    assert_eq!(of(&imported.root, Category::Shape).len(), 2);
}

#[test]
fn of_pictures_that_cannot_be_read_the_factors_stay() {
    let material = r#"{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 1, 1, 1], "baseColorTexture": {"index": 0},
          "metallicRoughnessTexture": {"index": 0}, "roughnessFactor": 0.25},
        "normalTexture": {"index": 0}, "emissiveFactor": [1, 2, 3], "emissiveTexture": {"index": 0}}"#;
    let (parts, rest) = textured_quad(material);
    let good = parts.text(&rest);
    for (image, part) in [
        (r#"{"name": "bark", "uri": "gone.png"}"#, "gone.png"),
        (r#"{"name": "bark", "bufferView": 0}"#, "format"),
        (r#"{"name": "bark", "bufferView": 9}"#, "buffer view 9"),
        (r#"{"name": "bark"}"#, "neither"),
    ] {
        let text = good.replacen(r#"{"bufferView": 2, "mimeType": "image/png"}"#, image, 1);
        assert_ne!(text, good);
        let (imported, files) = import(&text);
        let [warning] = &imported.warnings[..] else {
            panic!("{:?}", imported.warnings)
        };
        assert!(warning.contains("bark") && warning.contains(part), "{warning}");
        assert_eq!(files.len(), 1, "only the mesh");
        let principled = inside(of(&imported.root, Category::Bsdf)[0], "principled");
        assert_eq!(value(principled, "base_color"), &Value::Rgb(Vec3::new(0.5, 1.0, 1.0)));
        assert_eq!(value(principled, "roughness"), &Value::Float(0.25));
        let area = inside(of(&imported.root, Category::Shape)[0], "area");
        assert_eq!(value(area, "radiance"), &Value::Rgb(Vec3::new(1.0, 2.0, 3.0)));
    }
}

#[test]
fn a_picture_that_promises_more_than_its_bytes_can_hold_takes_no_memory() {
    let material = r#"{"pbrMetallicRoughness": {"baseColorFactor": [0.5, 1, 1, 1], "baseColorTexture": {"index": 0}}}"#;
    let (mut parts, rest) = textured_quad(material);
    // The first chunk: length, name, width, height, five more bytes, checksum.
    let mut bomb = png();
    for side in [16, 20] {
        bomb[side..side + 4].copy_from_slice(&20_000u32.to_be_bytes());
    }
    let mut checksum = flate2::Crc::new();
    checksum.update(&bomb[12..29]);
    bomb[29..33].copy_from_slice(&checksum.sum().to_be_bytes());
    let image = parts.view(&bomb, "");
    let rest = rest.replacen(
        r#""images": [{"bufferView": 2"#,
        &format!(r#""images": [{{"bufferView": {image}"#),
        1,
    );
    let (imported, _) = import(&parts.text(&rest));
    let [warning] = &imported.warnings[..] else {
        panic!("{:?}", imported.warnings)
    };
    assert!(warning.contains("20000 x 20000 pixels is promised"), "{warning}");
}

#[test]
fn what_cannot_be_kept_is_an_error() {
    let (parts, rest) = textured_quad(r#"{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}"#);
    let file = open(&parts.text(&rest)).expect("opens");
    for kind in ["mesh", "picture", "studio"] {
        let mut keep = |name: &str, _: &[u8]| match name.starts_with(kind) {
            true => Err(std::io::Error::other("the disk is full")),
            false => Ok(name.to_owned()),
        };
        let error = take_apart(&file, &mut keep, &mut nothing_beside)
            .expect_err(kind)
            .to_string();
        assert!(error.contains(kind) && error.contains("full"), "{error}");
    }
}

#[test]
fn nodes_stand_at_finite_places() {
    let (parts, rest) = textured_quad("{}");
    let nodes = r#""nodes": [{"mesh": 0, "rotation": [0, 0, 0, 0], "translation": [1, 2, 3]},
        {"mesh": 0, "name": "lost", "translation": [1e39, 0, 0], "children": [2]}, {"mesh": 0}]"#;
    let rest = rest
        .replace(r#""nodes": [{"mesh": 0}]"#, nodes)
        .replace(r#""nodes": [0]"#, r#""nodes": [0, 1]"#);
    let (imported, _) = import(&parts.text(&rest));
    let shapes = of(&imported.root, Category::Shape);
    assert_eq!(shapes.len(), 1);
    assert_eq!(world(shapes[0]), Affine3A::from_translation(Vec3::new(1.0, 2.0, 3.0)));
    assert!(imported.warnings.len() == 1 && imported.warnings[0].contains("lost"));
}

/// Files hide nodes by a scale of zero.
#[test]
fn flattened_nodes_are_left_out_by_name() {
    for scale in [[0.0, 0.0, 0.0], [1.0, 0.0, 1.0], [1e-30, 0.0, 1e-30]] {
        let (parts, rest) = textured_quad("{}");
        let nodes = format!(
            r#""cameras": [{{"perspective": {{"yfov": 1, "znear": 1}}}}],
               "nodes": [{{"mesh": 0}}, {{"mesh": 0, "name": "hidden", "scale": {scale:?}, "children": [2, 3]}},
                 {{"camera": 0, "name": "eye"}}, {{"name": "group"}}]"#
        );
        let rest = rest
            .replace(r#""nodes": [{"mesh": 0}]"#, &nodes)
            .replace(r#""nodes": [0]"#, r#""nodes": [0, 1]"#);
        let (imported, _) = import(&parts.text(&rest));
        assert_eq!(of(&imported.root, Category::Shape).len(), 1);
        let expected = ["node 1 (hidden)", "node 2 (eye)"];
        let expected = expected.map(|node| format!("{node} is flattened by its transform: it is left out"));
        assert_eq!(imported.warnings, expected);
    }
}

#[test]
fn equal_names_are_numbered() {
    let (parts, rest) = textured_quad("{}");
    let names = ["leaf", "leaf-2", "leaf", "leaf", "leaf-2"];
    let nodes: Vec<String> = names
        .iter()
        .map(|name| format!(r#"{{"mesh": 0, "name": "{name}"}}"#))
        .collect();
    let rest = rest
        .replace(
            r#""nodes": [{"mesh": 0}]"#,
            &format!(r#""nodes": [{}]"#, nodes.join(",")),
        )
        .replace(r#""nodes": [0]"#, r#""nodes": [0, 1, 2, 3, 4]"#);
    let (imported, _) = import(&parts.text(&rest));
    let ids: Vec<&str> = of(&imported.root, Category::Shape)
        .iter()
        .filter_map(|shape| shape.id.as_deref())
        .collect();
    assert_eq!(ids, ["leaf", "leaf-2", "leaf-3", "leaf-4", "leaf-2-2"]);
}

#[test]
fn broken_files_never_panic() {
    let (parts, rest) = textured_quad(r#"{"pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": 0}}}"#);
    let good = parts.binary(&rest);
    let attempt = |bytes: &[u8]| {
        let file = Gltf::open(bytes, &mut nothing_beside)?;
        import_file(&file).map(|_| ())
    };
    attempt(&good).expect("is good");
    for length in 0..good.len() {
        assert!(attempt(&good[..length]).is_err(), "cut at {length}");
    }
    // Any one byte may be another; whether the file is still good does not matter.
    for place in 0..good.len() {
        for flip in [0x01, 0x80, 0xff] {
            let mut bad = good.clone();
            bad[place] ^= flip;
            let _ = attempt(&bad);
        }
    }
}

/// Where a node mirrors its mesh, the front of a triangle is on the other side of its corners (section 3.7.4).
#[test]
fn flat_meshes_that_are_mirrored_keep_their_front() {
    let mut parts = Parts::default();
    let positions = parts.floats("VEC3", &SQUARE);
    let normals = parts.floats("VEC3", &[0.0, 0.0, 1.0].repeat(SQUARE.len() / 3));
    let text = parts.text(&format!(
        r#""meshes": [{{"primitives": [{{"attributes": {{"POSITION": {positions}}}}}]}},
            {{"primitives": [{{"attributes": {{"POSITION": {positions}, "NORMAL": {normals}}}}}]}}],
        "nodes": [{{"mesh": 0}}, {{"mesh": 0, "scale": [-1, 1, 1]}}, {{"mesh": 1, "scale": [-1, 1, 1]}},
            {{"mesh": 0, "scale": [-1, -1, 1]}}]"#
    ));
    let (imported, _) = import(&text);
    let flips: Vec<bool> = of(&imported.root, Category::Shape)
        .into_iter()
        .map(|shape| shape.properties.iter().any(|property| property.name == "flip_normals"))
        .collect();
    assert_eq!(flips, [false, true, false, false]);
}

#[test]
fn hidden_nodes_are_left_out_with_what_hangs_on_them() {
    let (parts, rest) = textured_quad("{}");
    let nodes = r#""nodes": [{"mesh": 0, "name": "seen", "extensions": {"KHR_node_visibility": {"visible": true}}},
        {"mesh": 0, "extensions": {"KHR_node_visibility": {"visible": false}}, "children": [2]}, {"mesh": 0}]"#;
    let rest = rest
        .replace(r#""nodes": [{"mesh": 0}]"#, nodes)
        .replace(r#""nodes": [0]"#, r#""nodes": [0, 1]"#);
    let used = r#""extensionsUsed": ["KHR_node_visibility"], "#;
    let (imported, _) = import(&parts.text(&format!("{used}{rest}")));
    let shapes = of(&imported.root, Category::Shape);
    assert_eq!(
        shapes.iter().map(|shape| shape.id.as_deref()).collect::<Vec<_>>(),
        [Some("seen")]
    );
    assert_eq!(imported.warnings, Vec::<String>::new());
}

/// What the material says in metallic-roughness counts where it says both.
#[test]
fn specular_glossiness_is_read_where_there_is_nothing_else() {
    let bsdf = |more: &str| {
        let text = format!(
            r#"{{"name": "old", "extensions": {{"KHR_materials_pbrSpecularGlossiness": {{"diffuseFactor": [0.1, 0.4, 0.1, 1], "specularFactor": [0, 0, 0],
              "glossinessFactor": 0.75{more}}}}}}}"#
        );
        let (parts, rest) = textured_quad(&text);
        let (imported, _) = import(&parts.text(&rest));
        (
            inside(of(&imported.root, Category::Bsdf)[0], "diffuse").clone(),
            imported.warnings,
        )
    };
    let (paint, warnings) = bsdf("");
    assert_eq!(value(&paint, "reflectance"), &Value::Rgb(Vec3::new(0.1, 0.4, 0.1)));
    assert_eq!(warnings, Vec::<String>::new());
    let (pictured, warnings) = bsdf(r#", "diffuseTexture": {"index": 0}, "specularGlossinessTexture": {"index": 0}"#);
    assert_eq!(child(&pictured, "reflectance").plugin, "bitmap");
    assert_eq!(warnings, Vec::<String>::new());
    let both = r#"{"pbrMetallicRoughness": {"roughnessFactor": 0.5}, "extensions": {"KHR_materials_pbrSpecularGlossiness": {}}}"#;
    let (parts, rest) = textured_quad(both);
    let principled = inside(of(&import(&parts.text(&rest)).0.root, Category::Bsdf)[0], "principled").clone();
    assert_eq!(value(&principled, "metallic"), &Value::Float(1.0));
}

#[test]
fn instances_stand_where_their_node_has_them() {
    let place = |attributes: &str, count: usize| {
        let (mut parts, rest) = textured_quad("{}");
        let places = parts.floats("VEC3", &[[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]].concat()[..3 * count]);
        let scales = parts.floats("VEC3", &[[1.0; 3], [3.0; 3]].concat());
        let attributes = attributes
            .replace("PLACES", &places.to_string())
            .replace("SCALES", &scales.to_string());
        let node = format!(
            r#""nodes": [{{"mesh": 0, "name": "leaf", "scale": [2, 2, 2], "extensions": {{"EXT_mesh_gpu_instancing": {{"attributes": {{{attributes}}}}}}}}}]"#
        );
        let file = open(&parts.text(&rest.replace(r#""nodes": [{"mesh": 0}]"#, &node))).expect("opens");
        let (imported, _) = import_file(&file).expect("imports");
        let shapes = of(&imported.root, Category::Shape);
        let poses: Vec<Affine3A> = shapes.into_iter().map(world).collect();
        let seen: Vec<Affine3A> = file
            .placed_meshes()
            .expect("reads")
            .into_iter()
            .map(|(_, pose)| pose)
            .collect();
        assert_eq!(seen, poses);
        (poses, imported.warnings)
    };
    let at =
        |scale: f32, by: Vec3| Affine3A::from_scale_rotation_translation(Vec3::splat(scale), glam::Quat::IDENTITY, by);
    let (poses, warnings) = place(r#""TRANSLATION": PLACES, "SCALE": SCALES, "_ID": 0"#, 2);
    assert_eq!(poses, [at(2.0, 2.0 * Vec3::X), at(6.0, 4.0 * Vec3::Y)]);
    assert_eq!(warnings, Vec::<String>::new());
    let (poses, warnings) = place(r#""TRANSLATION": PLACES, "SCALE": SCALES"#, 1);
    assert_eq!(poses, [at(2.0, Vec3::ZERO)]);
    assert!(warnings.len() == 1 && warnings[0].contains("leaf"), "{warnings:?}");
}
