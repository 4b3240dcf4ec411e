//! Procedural textures in files: read, written, refused, and turned into pictures for other programs.

use std::path::Path;

use sunroom::document;
use sunroom::scene::description::SceneDescription;
use sunroom::scene::read::read;
use sunroom::scene::write::{Extensions, write_anew};
use sunroom::scene::{Material, Parameter, Pattern, ShapeKind, Texture};
use sunroom::texture::load_image;

use crate::workshop::Workshop;

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

/// Joints of bricks that stand out, laid by box projection on what is inside, lit and seen from a side.
fn wall(turn: f32, shapes: &str) -> String {
    let bricks = |name: &str, high: &str, low: &str, inside: &str| {
        format!(
            "<texture type='boxprojection' name='{name}'><transform name='to_uv'><rotate z='1' angle='{turn}'/></transform>
             <texture type='bricks' name='input'><rgb name='color0' value='{high}'/><rgb name='color1' value='{high}'/>
             <rgb name='joint_color' value='{low}'/>{inside}</texture></texture>"
        )
    };
    let colors = bricks("reflectance", "0.6, 0.3, 0.2", "0.2", "");
    let heights = bricks("height", "1", "0", "<float name='bevel' value='0.02'/>");
    format!(
        "<scene version='3.0.0'><integrator type='path'><integer name='max_depth' value='2'/></integrator>
         <sensor type='perspective'><float name='fov' value='40'/><transform name='to_world'><lookat origin='1, 1.2, 4' target='0, 0, 0' up='0, 1, 0'/></transform>
         <film type='hdrfilm'><integer name='width' value='128'/><integer name='height' value='96'/></film></sensor>
         <emitter type='directional'><vector name='direction' x='-1.5' y='-1.5' z='-1'/></emitter>
         <bsdf type='twosided' id='wall'><bsdf type='bumpmap'>{heights}<float name='scale' value='0.03'/><bsdf type='diffuse'>{colors}</bsdf></bsdf></bsdf>
         {shapes}</scene>"
    )
}

/// Turned textures, flipped, mirrored and sheared shapes and instances look alike in files for other programs. Wrong
/// sides of bumps or mirrored coordinates change a picture by a fifth and more, noise and pixels of the texture by a
/// thirtieth.
#[test]
fn exported_box_projections_look_alike() {
    let shape = |plugin: &str, pose: &str, more: &str| {
        format!("<shape type='{plugin}'><transform name='to_world'>{pose}</transform><ref id='wall'/>{more}</shape>")
    };
    let turn = "<rotate y='1' angle='20'/>";
    let scaled = format!("<scale x='1' y='0.7' z='0.5'/>{turn}");
    let group = |places: [&str; 2]| {
        let instance = |place: &str| {
            format!("<shape type='instance'><ref id='g'/><transform name='to_world'>{place}</transform></shape>")
        };
        let member = shape("cube", "<scale x='0.5' y='0.8' z='0.6'/>", "");
        format!(
            "<shape type='shapegroup' id='g'>{member}</shape>{}",
            places.map(instance).concat()
        )
    };
    let flipped = "<boolean name='flip_normals' value='true'/>";
    let mirrored = "<scale x='-1' y='0.7' z='0.8'/><rotate y='1' angle='20'/>";
    let sheared = "<matrix value='1 0.5 0 0 0 0.7 0 0 0.2 0 0.5 0 0 0 0 1'/><rotate y='1' angle='20'/>";
    let beside = "<translate x='-0.8'/>";
    let cases = [
        ("plain", 0.0, shape("cube", &scaled, "")),
        ("turned", 30.0, shape("cube", &scaled, "")),
        ("flipped", 0.0, shape("cube", &scaled, flipped)),
        ("mirrored", 0.0, shape("sphere", mirrored, "")),
        ("sheared", 0.0, shape("cube", sheared, "")),
        (
            "instances on other sides",
            0.0,
            group([beside, "<rotate z='1' angle='90'/><translate x='0.8'/>"]),
        ),
        (
            "scaled instances",
            0.0,
            group([
                "<scale value='0.7'/><translate x='-0.8'/>",
                "<scale x='1.2' y='1' z='1'/><translate x='0.8'/>",
            ]),
        ),
        (
            "mirrored instances",
            0.0,
            group([beside, "<scale x='-1'/><translate x='0.8'/>"]),
        ),
    ];
    let shop = Workshop::new();
    let render = |file: &str| {
        shop.done(&[
            "render",
            file,
            "-o",
            "picture.exr",
            "-q",
            "--spp",
            "64",
            "--size",
            "128x96",
        ]);
        load_image(&shop.read("picture.exr")).expect("a picture")
    };
    for (name, turn, shapes) in cases {
        shop.put("scene.xml", wall(turn, &shapes));
        shop.done(&["convert", "scene.xml", "portable.xml", "--portable"]);
        shop.done(&["convert", "scene.xml", "exported.glb"]);
        let picture = render("scene.xml");
        let pixels = || (0..96).flat_map(|y| (0..128).map(move |x| (x, y)));
        let sum: f32 = pixels().map(|(x, y)| picture.pixel(x, y).element_sum()).sum();
        for (file, most) in [
            ("portable.xml", 0.05),
            ("exported.glb", if name == "sheared" { 0.1 } else { 0.05 }),
        ] {
            let other = render(file);
            let difference = |(x, y)| (picture.pixel(x, y) - other.pixel(x, y)).abs().element_sum();
            let share = pixels().map(difference).sum::<f32>() / sum;
            assert!(sum > 100.0 && share < most, "{name}, {file}: {share}, {sum}");
        }
    }
}

/// Equal boxes share a file, wherever they stand.
#[test]
fn equal_boxes_share_their_coordinates() {
    let cube = |pose: &str| {
        format!("<shape type='cube'><transform name='to_world'>{pose}</transform><ref id='wall'/></shape>")
    };
    let places = [
        "",
        "<translate x='2'/>",
        "<rotate y='1' angle='40'/>",
        "<scale value='2'/>",
    ];
    let shop = Workshop::new();
    shop.put("scene.xml", wall(0.0, &places.map(cube).concat()));
    shop.done(&["convert", "scene.xml", "portable.xml", "--portable"]);
    let files = std::fs::read_dir(shop.path("")).expect("the folder");
    let meshes = files.filter(|file| {
        file.as_ref()
            .is_ok_and(|file| file.path().extension().is_some_and(|end| end == "ply"))
    });
    assert_eq!(meshes.count(), 2);
}
