//! Procedural textures in files: read, written, refused, and turned into pictures for other programs.

use std::path::Path;

use sunroom::document;
use sunroom::scene::description::SceneDescription;
use sunroom::scene::read::read;
use sunroom::scene::write::{Extensions, write_anew};
use sunroom::scene::{Material, Parameter, Pattern, ShapeKind, Texture};
use sunroom::texture::load_image;

fn describe_at(text: &str, path: &Path) -> (SceneDescription, Vec<String>) {
    let mut document = document::parse_str(text, path, &[]);
    let scene = read(&mut document);
    let located = document
        .diagnostics
        .list
        .iter()
        .filter(|told| told.span != Some(document.root.span));
    let said = located.map(|told| told.message.clone()).collect();
    (scene, said)
}

fn describe(texture: &str) -> (SceneDescription, Vec<String>) {
    let text = format!("<scene version='3.0.0'><bsdf type='diffuse' id='m'>{texture}</bsdf></scene>");
    describe_at(&text, Path::new("/scene.xml"))
}

/// Every plugin, with values that are not the defaults, inside one another.
const ALL: &str = "<texture type='boxprojection' name='reflectance'><string name='up' value='z'/>
    <transform name='to_uv'><scale value='0.01'/></transform>
    <texture type='mix' name='input'>
        <string name='mode' value='multiply'/><float name='weight' value='0.25'/>
        <texture type='bricks' name='color0'>
            <float name='width' value='0.49'/><float name='height' value='0.07'/><float name='joint' value='0'/><float name='bevel' value='0.001'/>
            <string name='bond' value='herringbone'/><float name='offset' value='0.25'/><rgb name='joint_color' value='0.1, 0.2, 0.3'/>
            <texture type='wood' name='color0'><float name='ring' value='0.004'/><float name='waviness' value='2'/></texture>
            <texture type='ramp' name='color1'>
                <texture type='noise' name='input'>
                    <integer name='octaves' value='7'/><float name='gain' value='0.75'/><float name='distortion' value='1.5'/>
                    <boolean name='ridged' value='true'/><transform name='to_uv'><rotate z='1' angle='30'/><scale x='4' y='0.5'/></transform>
                </texture>
                <string name='stops' value='0.25 0.1 0.2 0.3; 0.5 1 0.5 0; 0.75 0 0 0'/>
            </texture>
        </texture>
        <texture type='cells' name='color1'><string name='value' value='border'/><float name='scatter' value='0.5'/></texture>
    </texture>
</texture>";

fn reflectance(scene: &SceneDescription) -> &Parameter<sunroom::color::Rgb> {
    match &scene.materials[0].material {
        Material::Diffuse { reflectance } => reflectance,
        other => panic!("{other:?}"),
    }
}

#[test]
fn patterns_are_read_as_they_are_written() {
    let (scene, said) = describe(ALL);
    assert_eq!(said, [""; 0]);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("written.xml");
    write_anew(&scene, &path, Extensions::Keep).expect("written");
    let text = std::fs::read_to_string(&path).expect("the file is there");
    for plugin in Pattern::PLUGINS {
        assert!(text.contains(&format!("type=\"{plugin}\"")), "{plugin}: {text}");
    }
    let (again, said) = describe_at(&text, &path);
    assert_eq!(said, [""; 0]);
    assert_eq!(reflectance(&scene), reflectance(&again));
}

#[test]
fn wrong_values_are_told_of() {
    let cases = [
        (
            "<texture type='bricks' name='reflectance'><string name='bond' value='english'/></texture>",
            "expected one of `running`, `random`, `herringbone` for `bond`, found `english`",
        ),
        (
            "<texture type='bricks' name='reflectance'><float name='width' value='0'/></texture>",
            "`width` is 0, but should be above 0",
        ),
        (
            "<texture type='noise' name='reflectance'><integer name='octaves' value='17'/></texture>",
            "`octaves` is 17, but should be at least 1 and at most 16",
        ),
        (
            "<texture type='ramp' name='reflectance'><string name='stops' value='1 0 0 0; 0 1 1 1'/></texture>",
            "`stops`: expected values in ascending order",
        ),
        (
            "<texture type='noise' name='reflectance'><float name='octave' value='2'/></texture>",
            "`octave`",
        ),
        (
            "<texture type='perlin' name='reflectance'/>",
            "texture `perlin` is not supported",
        ),
    ];
    for (texture, expected) in cases {
        let (_, said) = describe(texture);
        assert!(said.len() == 1 && said[0].contains(expected), "{texture}: {said:?}");
    }
}

#[test]
fn other_programs_get_pictures() {
    let text = format!(
        "<scene version='3.0.0'><shape type='rectangle'><transform name='to_world'><scale x='3' y='1'/></transform>
         <bsdf type='bumpmap'>{}<bsdf type='diffuse'>{}</bsdf></bsdf></shape>
         <shape type='sphere'><bsdf type='diffuse'><texture type='noise' name='reflectance'/></bsdf></shape></scene>",
        "<texture type='boxprojection'><texture type='bricks' name='input'><rgb name='color0' value='2'/><rgb name='color1' value='2'/>\
         <rgb name='joint_color' value='0'/></texture></texture><float name='scale' value='0.01'/>",
        "<texture type='boxprojection' name='reflectance'><texture type='bricks' name='input'>\
         <rgb name='color0' value='0.5, 0.25, 0.125'/><rgb name='color1' value='0.5, 0.25, 0.125'/></texture></texture>"
    );
    let (scene, said) = describe_at(&text, Path::new("/scene.xml"));
    assert_eq!(said, [""; 0]);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("other.xml");
    write_anew(&scene, &path, Extensions::Approximate).expect("written");
    let written = std::fs::read_to_string(&path).expect("the file is there");
    for plugin in Pattern::PLUGINS {
        assert!(!written.contains(&format!("type=\"{plugin}\"")), "{plugin}: {written}");
    }
    let (again, said) = describe_at(&written, &path);
    assert_eq!(said, [""; 0]);
    // The rectangle is a mesh, and the sphere, whose noise lies by uv, stays.
    assert!(matches!(again.shapes[0].shape.kind, ShapeKind::Mesh(_)));
    assert!(matches!(again.shapes[1].shape.kind, ShapeKind::Sphere { .. }));
    let bitmap = |texture: &Texture| match texture {
        Texture::Bitmap(bitmap) => (**bitmap).clone(),
        other => panic!("{other:?}"),
    };
    let mut pictures = Vec::new();
    for described in &again.materials {
        described
            .material
            .for_each_texture(&mut |texture| pictures.push(bitmap(texture)));
        if let Material::BumpMap { scale, .. } = &described.material {
            assert_eq!(*scale, 0.01);
        }
    }
    assert_eq!(pictures.len(), 3);
    let image = |place: usize| load_image(&std::fs::read(&pictures[place].path).expect("a file")).expect("a picture");
    let colors = pictures
        .iter()
        .position(|bitmap| !bitmap.raw && bitmap.to_uv.matrix2.x_axis.x != 1.0);
    let (colors, bumps) = (
        colors.expect("colours of bricks"),
        pictures.iter().position(|bitmap| bitmap.raw).expect("heights"),
    );
    // A tile of 9 bricks by 28 rows. The middle of the first brick, and the joint beside it.
    let place = |x: f32, y: f32| {
        let uv = pictures[colors].to_uv.transform_point2(glam::Vec2::new(x, y));
        ((uv.x * 1024.0) as u32, (uv.y * 1024.0) as u32)
    };
    let (x, y) = place(0.1, 0.03);
    let brick = image(colors).pixel(x, y);
    assert!(brick.abs_diff_eq(glam::Vec3::new(0.5, 0.25, 0.125), 0.01), "{brick}");
    // Heights above 1 are not clipped.
    let height = image(bumps).pixel(x, y).x;
    assert!((height - 2.0).abs() < 0.01, "{height}");
    let (x, y) = place(0.22, 0.03);
    assert!(image(colors).pixel(x, y).abs_diff_eq(glam::Vec3::splat(0.2), 0.01));
    assert!(image(bumps).pixel(x, y).x < 1e-3);
}
