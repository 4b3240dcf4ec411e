//! The layers of glTF materials: what they become, and which parts of them are named as lost.

use glam::Vec3;
use sunroom::document::{Category, Object, Value};
use sunroom::gltf::files::take_apart;

use crate::gltf_support::{Parts, SQUARE, nothing_beside, open};

/// The bsdf of a square with a material, the pictures by their names, and the warnings. Texture 0 is a picture of one
/// texel, and texture 1 another one.
fn read(material: &str, texels: [[u8; 4]; 2]) -> (Object, Vec<(String, image::Rgb32FImage)>, Vec<String>) {
    read_with(material, texels, false)
}

/// The same as [`read`] gives, for a square whose vertices may be white.
fn read_with(
    material: &str,
    texels: [[u8; 4]; 2],
    has_colors: bool,
) -> (Object, Vec<(String, image::Rgb32FImage)>, Vec<String>) {
    let mut parts = Parts::default();
    let colors = match has_colors {
        true => format!(r#", "COLOR_0": {}"#, parts.floats("VEC3", &[1.0; 12])),
        false => String::new(),
    };
    let positions = parts.floats("VEC3", &SQUARE);
    let uvs = parts.floats("VEC2", &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    let images = texels.map(|texel| {
        let mut png = std::io::Cursor::new(Vec::new());
        let picture = image::RgbaImage::from_pixel(1, 1, image::Rgba(texel));
        picture
            .write_to(&mut png, image::ImageFormat::Png)
            .expect("can be written");
        format!(
            r#"{{"bufferView": {}, "mimeType": "image/png"}}"#,
            parts.view(&png.into_inner(), "")
        )
    });
    let text = parts.text(&format!(
        r#""images": [{}], "textures": [{{"source": 0}}, {{"source": 1}}], "materials": [{material}],
           "meshes": [{{"primitives": [{{"attributes": {{"POSITION": {positions}, "TEXCOORD_0": {uvs}{colors}}}, "mode": 6, "material": 0}}]}}],
           "nodes": [{{"mesh": 0}}]"#,
        images.join(",")
    ));
    let mut pictures = Vec::new();
    let mut keep = |name: &str, bytes: &[u8]| {
        if name.starts_with("picture") {
            pictures.push((
                name.to_owned(),
                image::load_from_memory(bytes).expect("a picture").to_rgb32f(),
            ));
        }
        Ok(name.to_owned())
    };
    let imported = take_apart(&open(&text).expect("opens"), &mut keep, &mut nothing_beside).expect("imports");
    let mut bsdfs = imported
        .root
        .objects()
        .filter(|object| object.category == Category::Bsdf);
    let bsdf = bsdfs.next().expect("there is one").clone();
    (bsdf, pictures, imported.warnings)
}

const WHITE: [[u8; 4]; 2] = [[255; 4]; 2];

fn inside<'a>(object: &'a Object, plugin: &str) -> &'a Object {
    let found = object.objects().find(|child| child.plugin == plugin);
    found.unwrap_or_else(|| panic!("no {plugin} in {object:?}"))
}

fn number(object: &Object, name: &str) -> Option<f32> {
    let property = object.properties.iter().find(|property| property.name == name)?;
    match property.value {
        Value::Float(number) => Some(number),
        ref other => panic!("{other:?}"),
    }
}

/// The first texel of a textured parameter.
fn texel(bsdf: &Object, name: &str, pictures: &[(String, image::Rgb32FImage)]) -> [f32; 3] {
    let bitmap = bsdf.objects().find(|child| child.name.as_deref() == Some(name));
    let bitmap = bitmap.unwrap_or_else(|| panic!("no {name} in {bsdf:?}"));
    let Some(Value::String(file)) = bitmap
        .properties
        .iter()
        .find(|it| it.name == "filename")
        .map(|it| &it.value)
    else {
        panic!("no file")
    };
    let found = pictures.iter().find(|(name, _)| *name == **file);
    found.expect("is written").1.get_pixel(0, 0).0
}

fn near(found: f32, expected: f32) {
    assert!((found - expected).abs() < 2e-3, "{found}, not {expected}");
}

#[test]
fn highlights_are_stretched() {
    // Facets of the widths 0.25 and 0.25 + 0.75 * 0.64 = 0.73.
    let (ratio, middle) = (0.25f32 / 0.73, (0.25f32 * 0.73).powf(0.25));
    let constant = r#"{"pbrMetallicRoughness": {"roughnessFactor": 0.5}, "extensions": {"KHR_materials_anisotropy": {"anisotropyStrength": 0.8}}}"#;
    let (bsdf, _, warnings) = read(constant, WHITE);
    assert_eq!(warnings, [""; 0]);
    let principled = inside(&bsdf, "principled");
    near(number(principled, "roughness").expect("a number"), middle);
    near(
        number(principled, "anisotropic").expect("a number"),
        (1.0 - ratio) / 0.9,
    );
    // Half of the roughness in green of the first picture, half of the strength in blue of the second.
    let pictured = r#"{"pbrMetallicRoughness": {"metallicRoughnessTexture": {"index": 0}}, "extensions": {"KHR_materials_anisotropy": {
        "anisotropyStrength": 1, "anisotropyTexture": {"index": 1}}}}"#;
    let (bsdf, pictures, warnings) = read(pictured, [[0, 128, 255, 255], [255, 128, 204, 255]]);
    let principled = inside(&bsdf, "principled");
    let across = (128.0f32 / 255.0).powi(2);
    let along = across + (1.0 - across) * 0.64;
    let (ratio, middle) = (across / along, (across * along).powf(0.25));
    near(texel(principled, "roughness", &pictures)[0], middle);
    near(texel(principled, "anisotropic", &pictures)[0], (1.0 - ratio) / 0.9);
    assert!(
        warnings.len() == 1 && warnings[0].contains("no other direction"),
        "{warnings:?}"
    );
}

#[test]
fn reflection_and_sheen_have_the_hue_of_the_base() {
    // Half of the hue of (0.8, 0.2, 0.2), whose luminance is 0.328.
    let text = r#"{"pbrMetallicRoughness": {"metallicFactor": 0, "baseColorFactor": [0.8, 0.2, 0.2, 1]}, "extensions": {
        "KHR_materials_specular": {"specularColorFactor": [1.7204, 0.8051, 0.8051]},
        "KHR_materials_sheen": {"sheenColorFactor": [0.86, 0.4026, 0.4026], "sheenRoughnessFactor": 0.5}}}"#;
    let (bsdf, _, warnings) = read(text, WHITE);
    assert_eq!(warnings, [""; 0]);
    let principled = inside(&bsdf, "principled");
    near(number(principled, "spec_tint").expect("a number"), 0.5);
    near(number(principled, "sheen_tint").expect("a number"), 0.5);
    near(number(principled, "sheen").expect("a number"), 0.5);
    near(number(principled, "eta").expect("a number"), 1.5);
}

#[test]
fn the_gloss_of_a_coat_has_a_texture() {
    let text = r#"{"extensions": {"KHR_materials_clearcoat": {"clearcoatFactor": 1, "clearcoatRoughnessFactor": 0.5,
        "clearcoatRoughnessTexture": {"index": 0}}}}"#;
    let (bsdf, pictures, warnings) = read(text, [[255, 51, 255, 255]; 2]);
    assert_eq!(warnings, [""; 0]);
    near(texel(inside(&bsdf, "principled"), "clearcoat_gloss", &pictures)[0], 0.9);
}

#[test]
fn matt_light_goes_through() {
    let material = |more: &str| {
        format!(
            r#"{{"name": "leaf", "pbrMetallicRoughness": {{"metallicFactor": 0, "baseColorFactor": [0.2, 0.5, 0.1, 1]}}, "extensions": {{
                "KHR_materials_diffuse_transmission": {{"diffuseTransmissionFactor": 0.4, "diffuseTransmissionColorFactor": [0.2, 0.5, 0.1]}}{more}}}}}"#
        )
    };
    let (blend, _, warnings) = read(&material(""), WHITE);
    assert!(
        warnings.len() == 1 && warnings[0].contains("mirror reflection is dimmed"),
        "{warnings:?}"
    );
    assert_eq!(blend.plugin, "blendbsdf");
    near(number(&blend, "weight").expect("a number"), 0.4);
    assert_eq!(
        inside(&blend, "twosided").objects().next().map(|it| it.plugin.as_str()),
        Some("principled")
    );
    let sheet = inside(&blend, "principledthin");
    near(number(sheet, "diff_trans").expect("a number"), 2.0);
    let color = sheet
        .properties
        .iter()
        .find(|it| it.name == "base_color")
        .map(|it| &it.value);
    assert_eq!(color, Some(&Value::Rgb(Vec3::new(0.2, 0.5, 0.1))));
    // Without a mirror image it is one sheet.
    let (sheet, _, warnings) = read(&material(r#", "KHR_materials_specular": {"specularFactor": 0}"#), WHITE);
    assert_eq!((sheet.plugin.as_str(), warnings.len()), ("principledthin", 0));
    near(number(&sheet, "diff_trans").expect("a number"), 0.8);
    let matt_volume =
        r#", "KHR_materials_specular": {"specularFactor": 0}, "KHR_materials_volume": {"thicknessFactor": 1}"#;
    let (_, _, warnings) = read(&material(matt_volume), WHITE);
    assert!(
        warnings.len() == 1 && warnings[0].contains("(leaf)") && warnings[0].contains("volume"),
        "{warnings:?}"
    );
}

/// A texel of gold, and one of blue plastic.
#[test]
fn a_specular_picture_gives_metal_and_gloss() {
    let text = r#"{"extensions": {"KHR_materials_pbrSpecularGlossiness": {"diffuseTexture": {"index": 1}, "specularGlossinessTexture": {"index": 0},
        "glossinessFactor": 0.5}}}"#;
    let (bsdf, pictures, warnings) = read(text, [[255, 220, 149, 204], [0, 0, 0, 255]]);
    assert_eq!(warnings, [""; 0]);
    let gold = inside(&bsdf, "principled");
    near(texel(gold, "roughness", &pictures)[0], 0.6);
    assert!(texel(gold, "metallic", &pictures)[0] > 0.98);
    let [r, g, b] = texel(gold, "base_color", &pictures);
    assert!(
        (r - 1.0).abs() < 0.02 && (g - 220.0 / 255.0).abs() < 0.02 && (b - 149.0 / 255.0).abs() < 0.02,
        "{r} {g} {b}"
    );
    // White vertices change nothing, even where the diffuse colour is black.
    let black = text.replace(
        r#""diffuseTexture""#,
        r#""diffuseFactor": [0, 0, 0, 1], "diffuseTexture""#,
    );
    let (bsdf, pictures, warnings) = read_with(&black, [[255, 220, 149, 204], [0, 0, 0, 255]], true);
    assert_eq!(warnings, [""; 0]);
    let colored = inside(&bsdf, "principled");
    assert!(texel(colored, "metallic", &pictures)[0] > 0.98);
    let factor = texel(inside(colored, "mesh_attribute"), "times", &pictures);
    near(factor[0], r);
    near(factor[1], g);
    // A reflectance of 4 % is 56 in sRGB.
    let (bsdf, pictures, _) = read(text, [[56, 56, 56, 204], [20, 40, 200, 255]]);
    let plastic = inside(&bsdf, "principled");
    assert!(texel(plastic, "metallic", &pictures)[0] < 0.02);
    let [r, g, b] = texel(plastic, "base_color", &pictures);
    assert!(
        (r - 20.0 / 255.0).abs() < 0.02 && (g - 40.0 / 255.0).abs() < 0.02 && (b - 200.0 / 255.0).abs() < 0.02,
        "{r} {g} {b}"
    );
}

#[test]
fn what_no_model_has_is_named() {
    for (extension, part) in [
        (
            r#""KHR_materials_iridescence": {"iridescenceFactor": 1}"#,
            "iridescence",
        ),
        (r#""KHR_materials_dispersion": {"dispersion": 0.1}"#, "dispersion"),
        (
            r#""KHR_materials_anisotropy": {"anisotropyStrength": 1, "anisotropyRotation": 1}"#,
            "no other direction",
        ),
        (
            r#""KHR_materials_transmission": {"transmissionFactor": 1}, "KHR_materials_diffuse_transmission": {"diffuseTransmissionFactor": 1}"#,
            "clear light",
        ),
    ] {
        let (_, _, warnings) = read(&format!(r#"{{"name": "pearl", "extensions": {{{extension}}}}}"#), WHITE);
        assert!(
            warnings.len() == 1 && warnings[0].contains("(pearl)") && warnings[0].contains(part),
            "{extension}: {warnings:?}"
        );
    }
    // A file that asks for them is opened.
    let text = r#"{"asset": {"version": "2.0"}, "extensionsRequired": ["KHR_materials_iridescence", "KHR_materials_dispersion"]}"#;
    open(text).expect("opens");
}
