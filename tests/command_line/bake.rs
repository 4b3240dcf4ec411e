//! `sunroom bake`: a level and its lightmaps.

use std::collections::HashSet;
use std::path::Path;
use std::process::Output;

use sunroom::texture::load_image;

use crate::workshop::{Workshop, sunroom};

/// A white floor, a turned wall of two sides, a ball of glass, and a lamp in the middle of the floor's sky.
const SCENE: &str = r#"<scene version="3.0.0">
  <integrator type="path"><integer name="max_depth" value="4"/></integrator>
  <sensor type="perspective">
    <transform name="to_world"><lookat origin="0, 2, 5" target="0, 0.5, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="40"/><integer name="height" value="30"/></film>
  </sensor>
  <shape type="rectangle" id="floor">
    <transform name="to_world"><scale value="4"/><rotate x="1" angle="-90"/></transform>
    <bsdf type="diffuse"><rgb name="reflectance" value="0.8, 0.8, 0.8"/></bsdf>
  </shape>
  <shape type="rectangle" id="wall">
    <transform name="to_world"><rotate y="1" angle="180"/><translate x="0" y="1" z="-3"/></transform>
    <bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.5, 0.5, 0.5"/></bsdf></bsdf>
  </shape>
  <shape type="sphere" id="ball">
    <point name="center" x="2" y="0.5" z="0"/><float name="radius" value="0.3"/>
    <bsdf type="dielectric"/>
  </shape>
  <emitter type="point" id="bulb"><point name="position" x="0" y="2" z="0"/><rgb name="intensity" value="3, 3, 3"/></emitter>
</scene>
"#;

fn bake(scene: &Path, output: &Path, more: &[&str]) -> Output {
    let mut command = sunroom();
    command.arg("bake").arg(scene).arg("-o").arg(output).args(more);
    command.output().expect("the program starts")
}

#[track_caller]
fn assert_code(output: &Output, code: i32) {
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{said}");
}

fn manifest(folder: &Path) -> serde_json::Value {
    let text = std::fs::read_to_string(folder.join("lightmaps.json")).expect("the manifest");
    serde_json::from_str(&text).expect("JSON")
}

/// The largest red value of a lightmap.
fn brightest(file: &Path) -> f32 {
    let image = load_image(&std::fs::read(file).expect("the lightmap")).expect("a picture");
    let places = (0..image.height()).flat_map(|y| (0..image.width()).map(move |x| (x, y)));
    places.map(|(x, y)| image.pixel(x, y).x).fold(0.0, f32::max)
}

#[test]
fn a_level_is_baked() {
    let workshop = Workshop::new();
    let scene = workshop.scene(SCENE);
    let folder = workshop.path("level");
    let quick = [
        "--spp",
        "16",
        "--texels-per-unit",
        "8",
        "--atlas-size",
        "128",
        "--no-denoise",
        "--no-probes",
    ];
    assert_code(&bake(&scene, &folder, &quick), 0);
    let names: HashSet<String> = std::fs::read_dir(&folder)
        .expect("the folder")
        .map(|entry| entry.expect("an entry").file_name().to_string_lossy().into_owned())
        .collect();
    let expected = ["level.glb", "lightmap-0.exr", "lightmap-0.ktx2", "lightmaps.json"];
    assert_eq!(names, expected.map(str::to_owned).into());
    let about = manifest(&folder);
    let nodes = about["nodes"].as_array().expect("nodes");
    let paths: Vec<&str> = nodes.iter().filter_map(|node| node["path"].as_str()).collect();
    assert_eq!(paths, ["floor", "wall"], "glass has no lightmap");
    assert_eq!((&about["samples"], &about["light"]), (&16.into(), &"all".into()));
    // Straight below the bulb: E / pi = I / d^2 / pi, and some light of the wall.
    let direct = 3.0 / 4.0 / std::f32::consts::PI;
    let light = brightest(&folder.join("lightmap-0.exr"));
    assert!(light > 0.95 * direct && light < 1.3 * direct, "{light} for {direct}");
    let level = sunroom()
        .arg("check")
        .arg(folder.join("level.glb"))
        .output()
        .expect("it starts");
    assert_code(&level, 0);

    // The same bits on another number of threads, and again into the same folder.
    let lightmap = std::fs::read(folder.join("lightmap-0.ktx2")).expect("the lightmap");
    assert_code(
        &bake(&scene, &folder, &[&quick[..], &["--threads", "1", "-q"]].concat()),
        0,
    );
    assert!(lightmap == std::fs::read(folder.join("lightmap-0.ktx2")).expect("the lightmap"));

    assert_code(&bake(&scene, &folder, &[&quick[..], &["--indirect-only"]].concat()), 0);
    assert_eq!(manifest(&folder)["light"], "without_direct_punctual");
    let indirect = brightest(&folder.join("lightmap-0.exr"));
    assert!(indirect > 0.0 && indirect < 0.5 * light, "{indirect} of {light}");
}

/// The JSON of a `.glb` file.
fn level(folder: &Path) -> serde_json::Value {
    let bytes = std::fs::read(folder.join("level.glb")).expect("the level");
    let length = u32::from_le_bytes(bytes[12..16].try_into().expect("four bytes")) as usize;
    serde_json::from_slice(&bytes[20..20 + length]).expect("JSON")
}

#[test]
fn a_lamp_shines_from_its_front_and_skies_are_not_missed() {
    let shop = Workshop::new();
    let lamp = r#"<shape type="rectangle" id="lamp">
    <transform name="to_world"><scale value="0.5"/><rotate x="1" angle="90"/><translate y="1.5"/></transform>
    <bsdf type="twosided"><bsdf type="diffuse"/></bsdf>
    <emitter type="area"><rgb name="radiance" value="2, 2, 2"/></emitter>
  </shape>
  <emitter type="constant"/>
</scene>"#;
    let scene = shop.scene(&SCENE.replace("</scene>", lamp));
    let folder = shop.path("level");
    let output = bake(&scene, &folder, &["--spp", "4", "--no-denoise", "--no-probes"]);
    assert_code(&output, 0);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(!said.contains("left out"), "{said}");
    let level = level(&folder);
    let shines = |part: &serde_json::Value| {
        let material = &level["materials"][part["material"].as_u64().expect("a material") as usize];
        material.get("emissiveFactor").is_some_and(|factor| factor[0] != 0.0)
    };
    let meshes = level["meshes"].as_array().expect("meshes").iter();
    let lit: Vec<Vec<bool>> = meshes
        .map(|mesh| {
            mesh["primitives"]
                .as_array()
                .expect("parts")
                .iter()
                .map(shines)
                .collect()
        })
        .filter(|parts: &Vec<bool>| parts.contains(&true))
        .collect();
    assert_eq!(lit, [[true, false]]);
}

/// glTF has no projectors: their light is in the lightmaps, also where that of other lights is left to the game.
#[test]
fn a_projector_is_baked_and_not_missed() {
    let shop = Workshop::new();
    let projector = r#"<emitter type="projector" id="slides">
    <transform name="to_world"><lookat origin="0, 3, 0" target="0, 0, 0" up="0, 0, 1"/></transform>
    <rgb name="irradiance" value="9, 9, 9"/><float name="fov" value="40"/>
  </emitter>
</scene>"#;
    let bulb = SCENE.find("<emitter").expect("the bulb");
    let dark = &SCENE[..bulb];
    let scene = shop.scene(&format!("{dark}{projector}"));
    let light = |more: &[&str]| {
        let folder = shop.path("level");
        let quick = ["--spp", "4", "--no-denoise", "--no-probes", "--texels-per-unit", "8"];
        let output = bake(&scene, &folder, &[&quick[..], more].concat());
        assert_code(&output, 0);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(!said.contains("slides"), "{said}");
        brightest(&folder.join("lightmap-0.exr"))
    };
    let all = light(&[]);
    assert!(all > 0.0);
    assert_eq!(light(&["--indirect-only"]), all);
}

/// A number of half precision, not negative and no fraction of the smallest normal one.
fn half(bytes: &[u8]) -> f32 {
    let bits = u16::from_le_bytes([bytes[0], bytes[1]]);
    let (exponent, fraction) = (i32::from(bits >> 10), f32::from(bits & 1023));
    match exponent {
        0 => 0.0,
        _ => (1.0 + fraction / 1024.0) * 2f32.powi(exponent - 15),
    }
}

/// The six words from the width to the number of levels of a KTX 2 file, and the red values of its largest level.
fn texture(file: &Path) -> ([u32; 6], Vec<f32>) {
    let bytes = std::fs::read(file).expect("the texture");
    let word = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four bytes"));
    let (at, length) = (word(80) as usize, word(88) as usize);
    let red = bytes[at..at + length].chunks(8).map(half).collect();
    ([20, 24, 28, 32, 36, 40].map(word), red)
}

#[test]
fn probes_are_baked_around_the_level_and_where_the_scene_has_them() {
    let shop = Workshop::new();
    let sky = r#"<emitter type="constant"><rgb name="radiance" value="2, 2, 2"/></emitter></scene>"#;
    let scene = shop.scene(&SCENE.replace("</scene>", sky));
    let folder = shop.path("level");
    let quick = ["--spp", "2", "--no-denoise", "--atlas-size", "64", "--probe-size", "16"];
    assert_code(
        &bake(&scene, &folder, &[&quick[..], &["--probe-spacing", "2"]].concat()),
        0,
    );
    let about = manifest(&folder);
    let [probe, volume] = ["reflection_probes", "irradiance_volumes"].map(|list| &about[list][0]);
    assert_eq!(
        (&probe["name"], &probe["parallax"]),
        (&"level".into(), &false.into()),
        "under the sky"
    );
    assert_eq!(volume["points"], serde_json::json!([4, 1, 4]));
    assert_eq!(volume["samples"], 16);
    let (sizes, red) = texture(&folder.join("reflection-0-specular.ktx2"));
    assert_eq!(sizes, [16, 16, 0, 0, 6, 3]);
    // Up, where there is nothing but sky.
    assert_eq!(red[2 * 256 + 8 * 16 + 8], 2.0);
    assert_eq!(
        texture(&folder.join("reflection-0-diffuse.ktx2")).0,
        [16, 16, 0, 0, 6, 1]
    );
    let (sizes, red) = texture(&folder.join("irradiance-0.ktx2"));
    assert_eq!(sizes, [4, 2, 12, 0, 1, 1]);
    // The points in the first row look up, at +y: pi times the sky, divided by pi.
    let up = &red[4 * 8..4 * 8 + 4];
    assert!(up.iter().all(|light| (light - 2.0).abs() < 0.3), "{up:?}");

    // The same bits on another number of threads.
    let before = std::fs::read(folder.join("irradiance-0.ktx2")).expect("the volume");
    let again = [&quick[..], &["--probe-spacing", "2", "--threads", "1", "-q"]].concat();
    assert_code(&bake(&scene, &folder, &again), 0);
    assert!(before == std::fs::read(folder.join("irradiance-0.ktx2")).expect("the volume"));

    let own = r#"<emitter type="reflectionprobe" id="corner"><boolean name="parallax" value="false"/>
      <transform name="to_world"><scale value="0.5"/><translate y="1" z="2"/></transform></emitter>
      <emitter type="irradiancevolume" id="air"><float name="spacing" value="0.5"/>
      <transform name="to_world"><translate y="1"/></transform></emitter></scene>"#;
    let placed = shop.scene(&SCENE.replace("</scene>", own));
    assert_code(&bake(&placed, &folder, &quick), 0);
    let about = manifest(&folder);
    let [probe, volume] = ["reflection_probes", "irradiance_volumes"].map(|list| &about[list][0]);
    assert_eq!((&probe["name"], &probe["parallax"]), (&"corner".into(), &false.into()));
    let place = &probe["box"];
    assert_eq!([&place[0], &place[5], &place[13], &place[14]], [1.0, 1.0, 1.0, 2.0]);
    assert_eq!(
        (&volume["name"], &volume["points"]),
        (&"air".into(), &serde_json::json!([4, 4, 4]))
    );

    // Without probes those of the bake before are removed.
    assert_code(&bake(&placed, &folder, &[&quick[..5], &["--no-probes"]].concat()), 0);
    assert_eq!(manifest(&folder)["reflection_probes"], serde_json::json!([]));
    assert!(!folder.join("irradiance-0.ktx2").exists() && !folder.join("reflection-0-diffuse.ktx2").exists());

    let exported = sunroom()
        .arg("convert")
        .args([&placed, &shop.path("level.glb")])
        .output()
        .expect("it starts");
    assert_code(&exported, 0);
    let said = String::from_utf8_lossy(&exported.stderr);
    for words in [
        "reflection probe `corner` is left out: glTF has no place for it",
        "irradiance volume `air` is left out: glTF has no place for it",
    ] {
        assert!(said.contains(words), "{said}");
    }

    let portable = shop.path("portable.xml");
    let converted = sunroom()
        .arg("convert")
        .args([&placed, &portable])
        .arg("--portable")
        .output()
        .expect("it starts");
    assert_code(&converted, 0);
    let text = std::fs::read_to_string(&portable).expect("the scene");
    assert!(!text.contains("probe") && !text.contains("volume"), "{text}");
}

#[test]
fn probes_that_cannot_be_are_said_before_anything_is_baked() {
    let shop = Workshop::new();
    let folder = shop.path("level");
    let fails = |emitter: &str, words: &str| {
        let scene = shop.scene(&SCENE.replace("</scene>", &format!("{emitter}</scene>")));
        let checked = sunroom().arg("check").arg(&scene).output().expect("it starts");
        for output in [bake(&scene, &folder, &[]), checked] {
            assert_code(&output, 1);
            let said = String::from_utf8_lossy(&output.stderr);
            assert!(said.contains(words) && !folder.exists(), "{said}");
        }
    };
    let probe = |transform: &str| {
        format!(
            r#"<emitter type="reflectionprobe" id="it"><transform name="to_world">{transform}</transform></emitter>"#
        )
    };
    fails(
        &probe(r#"<translate y="50"/>"#),
        "reflectionprobe `it`: it lies outside of the level",
    );
    fails(&probe(r#"<scale x="1" y="0" z="1"/>"#), "it flattens the space");
    fails(
        &probe(r#"<rotate z="1" angle="30"/><scale x="1" y="3" z="1"/>"#),
        "reflectionprobe `it`: its box is skewed",
    );
    let fine = r#"<emitter type="irradiancevolume" id="it"><float name="spacing" value="0.001"/></emitter>"#;
    fails(fine, "a volume may have 262144 points");
    let scene = shop.scene(SCENE);
    for (option, value, words) in [
        ("--probe-size", "100", "a power of two"),
        ("--probe-size", "0", "a power of two"),
        ("--probe-spacing", "0", "a number above 0"),
        ("--probe-spacing", "nan", "a number above 0"),
    ] {
        let output = bake(&scene, &folder, &[option, value]);
        assert_code(&output, 2);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.contains(words), "{said}");
    }
    let output = bake(&scene, &folder, &["--memory", "300MB", "--probe-size", "512"]);
    assert_code(&output, 1);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("the probes need ") && said.contains("budget"), "{said}");
    // Everything is inside of the cube.
    let solid = shop.write(
        "solid.xml",
        r#"<scene version="3.0.0"><sensor type="perspective"/><shape type="cube"/><emitter type="constant"/></scene>"#,
    );
    let quick = [
        "--spp",
        "1",
        "--no-denoise",
        "--atlas-size",
        "64",
        "--probe-spacing",
        "1",
    ];
    let warning = "warning: there is no reflection probe, because no place for it was found";
    for (more, code) in [(&["--strict"][..], 1), (&[], 0)] {
        let output = bake(&solid, &folder, &[&quick[..], more].concat());
        assert_code(&output, code);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.contains(warning) && folder.exists() == (code == 0), "{said}");
    }
    std::fs::remove_dir_all(&folder).expect("the bake");
    let output = bake(&scene, &folder, &["--probe-spacing", "0.001"]);
    assert_code(&output, 1);
    assert!(!folder.exists());
}

#[test]
fn a_bake_removes_the_lightmaps_of_the_one_before() {
    let shop = Workshop::new();
    let scene = shop.scene(SCENE);
    let folder = shop.path("level");
    let quick = ["--spp", "1", "--no-denoise", "--atlas-size", "64", "--probe-size", "16"];
    assert_code(&bake(&scene, &folder, &quick), 0);
    let mut before = manifest(&folder);
    let more = serde_json::json!({ "exr": "lightmap-9.exr", "ktx2": "lightmap-9.ktx2", "width": 1, "height": 1 });
    before["lightmaps"].as_array_mut().expect("a list").push(more);
    for (name, text) in [
        ("lightmaps.json", before.to_string()),
        ("lightmap-9.exr", String::new()),
        ("lightmap-9.ktx2", String::new()),
        ("lightmap-of-mine.exr", String::new()),
    ] {
        std::fs::write(folder.join(name), text).expect("written");
    }
    assert_code(&bake(&scene, &folder, &quick), 0);
    let is_there = [
        "lightmap-0.exr",
        "lightmap-9.exr",
        "lightmap-9.ktx2",
        "lightmap-of-mine.exr",
    ]
    .map(|name| folder.join(name).exists());
    assert_eq!(is_there, [true, false, false, true]);
}

#[test]
fn a_level_is_not_baked_over_itself() {
    let shop = Workshop::new();
    let scene = shop.scene(SCENE);
    let folder = shop.path("baked");
    let quick = ["--spp", "1", "--no-denoise", "--atlas-size", "64", "--probe-size", "16"];
    assert_code(&bake(&scene, &folder, &quick), 0);
    let level = folder.join("level.glb");
    let before = std::fs::read(&level).expect("written");
    let output = bake(&level, &folder, &quick);
    assert_code(&output, 1);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("level.glb: the scene is made of this file"), "{said}");
    assert!(std::fs::read(&level).expect("still there") == before);
}

#[test]
fn what_cannot_be_baked_is_said() {
    let workshop = Workshop::new();
    let scene = workshop.scene(SCENE);
    let folder = workshop.path("level");
    let fails = |more: &[&str], code: i32, word: &str| {
        let output = bake(&scene, &folder, more);
        assert_code(&output, code);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(said.contains(word), "{said}");
        assert!(!folder.join("level.glb").exists());
    };
    fails(&["--texels-per-unit", "0"], 2, "a number above 0");
    fails(&["--texels-per-unit", "-3"], 2, "a number above 0");
    fails(&["--texels-per-unit", "nan"], 2, "a number above 0");
    fails(
        &["--texels-per-unit", "100", "--atlas-size", "128"],
        1,
        "texels per unit",
    );
    fails(&["--texels-per-unit", "1e30"], 1, "e61 texels, of which");
    fails(&["--texels-per-unit", "1e-30"], 1, "large enough for a texel");
    fails(&["--atlas-size", "8"], 2, "--atlas-size");
    fails(&["--spp", "0"], 2, "--spp");
    assert!(!folder.exists(), "a bake that has failed leaves nothing");
    let nowhere = workshop.write("file", "");
    assert_code(&bake(&scene, &nowhere.join("folder"), &[]), 1);
    let output = bake(&scene, &nowhere, &[]);
    assert_code(&output, 1);
    assert!(String::from_utf8_lossy(&output.stderr).contains("is a file"));
    assert_code(&bake(&workshop.path("missing.xml"), &folder, &[]), 1);
    let empty = workshop.write(
        "empty.xml",
        r#"<scene version="3.0.0"><sensor type="perspective"/><emitter type="point"/></scene>"#,
    );
    let output = bake(&empty, &folder, &[]);
    assert_code(&output, 1);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("a lightmap could lie on"), "{said}");
}

#[test]
fn shapes_say_how_fine_their_lightmaps_are() {
    let workshop = Workshop::new();
    let square = |name: &str, x: i32, scale: &str| {
        let place = format!(r#"<transform name="to_world"><translate x="{x}"/></transform>"#);
        format!(r#"<shape type="rectangle" id="{name}">{place}{scale}</shape>"#)
    };
    let [fine, none] = [2, 0].map(|scale| format!(r#"<float name="lightmap_scale" value="{scale}"/>"#));
    // Two of each share a mesh, so that each has a rectangle.
    let squares = [
        square("usual", 0, ""),
        square("usual-2", 3, ""),
        square("fine", 6, &fine),
        square("fine-2", 9, &fine),
        square("bare", 12, &none),
    ];
    let light = r#"<emitter type="constant"/>"#;
    let scene = workshop.scene(&format!(
        r#"<scene version="3.0.0">{}{light}</scene>"#,
        squares.concat()
    ));
    let folder = workshop.path("level");
    let quick = ["--spp", "1", "--texels-per-unit", "8", "--no-denoise", "--no-probes"];
    assert_code(&bake(&scene, &folder, &quick), 0);
    let about = manifest(&folder);
    let nodes = about["nodes"].as_array().expect("nodes");
    let width = |path: &str| {
        let node = nodes.iter().find(|node| node["path"] == path)?;
        let corner = |place: usize| node["rect"][place].as_f64().expect("a number");
        Some(corner(2) - corner(0))
    };
    assert_eq!((nodes.len(), width("bare")), (4, None), "{about}");
    let [usual, fine] = ["usual-2", "fine-2"].map(|path| width(path).expect("a place"));
    assert!((fine / usual - 2.0).abs() < 0.1, "{fine} {usual}");
    // Mitsuba does not know of it.
    let portable = workshop.path("portable.xml");
    let mut convert = sunroom();
    convert.arg("convert").arg(&scene).arg(&portable).arg("--portable");
    assert_code(&convert.output().expect("the program starts"), 0);
    let text = std::fs::read_to_string(&portable).expect("the file");
    assert!(text.contains("fine-2") && !text.contains("lightmap_scale"), "{text}");
}
