//! Scenes whose files are not all there: what the commands say of them, and what they do without them.

use std::path::Path;
use std::process::Output;

use sunroom::texture::load_image;

use crate::workshop::{Workshop, sunroom};

/// A ball in front of a camera, before white everywhere.
const SCENE: &str = r#"<scene version="3.0.0">
  <integrator type="path"/>
  <sensor type="perspective"><float name="fov" value="30"/>
    <transform name="to_world"><lookat origin="0,0,4" target="0,0,0" up="0,1,0"/></transform>
    <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="24"/></film>
    <sampler type="independent"><integer name="sample_count" value="4"/></sampler></sensor>
  <emitter type="constant" id="white"/>
  <shape type="sphere" id="ball"><float name="radius" value="0.3"/></shape>
</scene>
"#;

fn with(content: &str) -> String {
    SCENE.replace("</scene>", &format!("{content}\n</scene>"))
}

fn mesh(plugin: &str, file: &str) -> String {
    format!(r#"<shape type="{plugin}"><string name="filename" value="{file}"/></shape>"#)
}

fn run(shop: &Workshop, arguments: &[&str]) -> Output {
    let mut command = sunroom();
    command.current_dir(shop.folder()).args(arguments);
    command.output().expect("the program starts")
}

fn stderr(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

#[track_caller]
fn assert_code(output: &Output, code: i32) -> String {
    let said = stderr(output);
    assert_eq!(output.status.code(), Some(code), "{said}");
    said
}

/// The mean of all pixels and colours.
fn mean(path: &Path) -> f32 {
    let image = load_image(&std::fs::read(path).expect("the picture")).expect("a picture");
    let places = (0..image.height()).flat_map(|y| (0..image.width()).map(move |x| (x, y)));
    let sum: f32 = places.map(|(x, y)| image.pixel(x, y).element_sum() / 3.0).sum();
    sum / (image.width() * image.height()) as f32
}

const VOLUME: &str = r#"<shape type="sphere"><bsdf type="null"/><medium name="interior" type="heterogeneous">
  <volume type="gridvolume" name="sigma_t"><string name="filename" value="no-smoke.vol"/></volume></medium></shape>"#;

/// Two meshes and a volume are missing, and a picture.
fn shop() -> Workshop {
    let shop = Workshop::new();
    let picture = r#"<bsdf type="diffuse" id="paper"><texture type="bitmap" name="reflectance"><string name="filename" value="no-paper.png"/></texture></bsdf>"#;
    let meshes = [mesh("obj", "models/no-chair.obj"), mesh("ply", "no-table.ply")].concat();
    let text = with(&format!("{meshes}{VOLUME}{picture}"));
    shop.scene(&text.replace(r#"type="path""#, r#"type="volpath""#));
    shop
}

const NAMES: [&str; 4] = ["no-chair.obj", "no-table.ply", "no-smoke.vol", "no-paper.png"];

#[test]
fn a_render_names_all_files_that_are_missing_and_how_to_do_without_them() {
    let shop = shop();
    let refused = run(&shop, &["render", "scene.xml", "-o", "a.exr", "-q"]);
    let said = assert_code(&refused, 1);
    for name in NAMES {
        assert!(said.contains(&format!("{name}: no such file")), "{name}: {said}");
    }
    assert!(said.contains("scene.xml:9:"), "{said}");
    assert!(said.contains("--allow-missing"), "{said}");
    assert!(!shop.path("a.exr").exists());
    let allowed = run(&shop, &["render", "scene.xml", "-o", "a.exr", "-q", "--allow-missing"]);
    let said = assert_code(&allowed, 0);
    for name in NAMES {
        assert!(said.contains(&format!("{name}: no such file")), "{name}: {said}");
    }
    assert!(!said.contains("error") && !said.contains("--allow-missing"), "{said}");
    assert!(shop.path("a.exr").is_file());
    // They are warnings then, which --strict refuses.
    let strict = [
        "render",
        "scene.xml",
        "-o",
        "b.exr",
        "-q",
        "--allow-missing",
        "--strict",
    ];
    let said = assert_code(&run(&shop, &strict), 1);
    assert!(said.contains("refused for its warnings"), "{said}");
}

/// What is broken is an error with the option as well.
#[test]
fn a_broken_mesh_is_not_a_missing_one() {
    let shop = Workshop::new();
    shop.write("broken.ply", "ply\ngarbage\n");
    shop.scene(&with(
        &[mesh("ply", "broken.ply"), mesh("obj", "no-chair.obj")].concat(),
    ));
    let output = run(&shop, &["render", "scene.xml", "-o", "a.exr", "-q", "--allow-missing"]);
    let said = assert_code(&output, 1);
    assert!(
        said.contains("broken.ply: line 2") && said.contains("no-chair.obj"),
        "{said}"
    );
    // The option would not help, or is there already.
    for arguments in [
        &["render", "scene.xml", "-o", "a.exr", "-q"][..],
        &["render", "scene.xml", "-o", "a.exr", "-q", "--allow-missing"],
        &["convert", "scene.xml", "a.xml"],
        &["convert", "scene.xml", "a.xml", "--allow-missing"],
    ] {
        let said = assert_code(&run(&shop, arguments), 1);
        assert!(!said.contains("files are missing"), "{arguments:?}: {said}");
    }
}

/// A scene that cannot be shown for another reason names its missing files all the same, and every file that it cannot
/// do without.
#[test]
fn all_faults_of_a_scene_are_told_at_once() {
    let shop = shop();
    let text = std::fs::read_to_string(shop.path("scene.xml")).expect("the scene");
    let more = r#"<include filename="no-lights.xml"/><include filename="no-walls.xml"/>
        <bsdf type="diffuse"><spectrum name="reflectance" filename="no-copper.spd"/></bsdf></scene>"#;
    shop.scene(&text.replace("</scene>", more));
    let said = assert_code(&run(&shop, &["check", "scene.xml"]), 1);
    for name in NAMES
        .into_iter()
        .chain(["no-lights.xml", "no-walls.xml", "no-copper.spd"])
    {
        assert!(said.contains(name), "{name}: {said}");
    }
    assert!(said.contains("scene.xml: 6 errors, 1 warning"), "{said}");
}

#[test]
fn a_bake_and_a_conversion_name_all_missing_meshes_and_do_without_them_if_they_are_told_to() {
    let shop = Workshop::new();
    shop.scene(&with(
        &[mesh("obj", "no-chair.obj"), mesh("ply", "no-table.ply")].concat(),
    ));
    let bake = [
        "bake",
        "scene.xml",
        "-o",
        "level",
        "-q",
        "--spp",
        "1",
        "--no-probes",
        "--no-denoise",
    ];
    let to_gltf = ["convert", "scene.xml", "level.glb"];
    let to_xml = ["convert", "scene.xml", "other.xml"];
    for (arguments, written) in [
        (&bake[..], "level/level.glb"),
        (&to_gltf[..], "level.glb"),
        (&to_xml[..], "other.xml"),
    ] {
        let said = assert_code(&run(&shop, arguments), 1);
        for name in [
            "no-chair.obj: no such file",
            "no-table.ply: no such file",
            "--allow-missing",
        ] {
            assert!(said.contains(name), "{arguments:?}: {name}: {said}");
        }
        assert!(!shop.path(written).exists(), "{arguments:?}");
        let allowed: Vec<&str> = arguments.iter().copied().chain(["--allow-missing"]).collect();
        let said = assert_code(&run(&shop, &allowed), 0);
        assert!(said.contains("no-chair.obj") && said.contains("no-table.ply"), "{said}");
        assert!(shop.path(written).is_file(), "{arguments:?}");
    }
    let text = std::fs::read_to_string(shop.path("other.xml")).expect("the scene");
    assert!(text.contains("no-chair.obj") && text.contains("no-table.ply"), "{text}");
}

/// A message names the places where a file was looked for, however many they are.
#[test]
fn a_mesh_is_looked_for_in_all_folders_and_some_of_them_are_told() {
    let shop = Workshop::new();
    let folders: String = (0..20)
        .map(|number| format!("<path value=\"parts-{number}\"/>"))
        .collect();
    let meshes: String = (0..30).map(|number| mesh("ply", &format!("no-{number}.ply"))).collect();
    for number in 0..20 {
        std::fs::create_dir(shop.path(&format!("parts-{number}"))).expect("a folder");
    }
    let found = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    shop.write("parts-0/last.obj", found);
    shop.write("parts-19/First.obj", found);
    let last = [mesh("obj", "last.obj"), mesh("obj", "First.obj")].concat();
    shop.scene(&with(&format!("{folders}{meshes}{last}")));
    let said = assert_code(&run(&shop, &["check", "scene.xml"]), 1);
    for number in 0..30 {
        let name = format!("no-{number}.ply: no such file; also looked for as ");
        assert!(said.contains(&name), "{name}: {said}");
    }
    assert!(said.contains(" more places"), "{said}");
    assert!(
        said.contains("scene.xml: 30 errors"),
        "those that are there were found: {said}"
    );
}

#[test]
fn a_sky_whose_picture_is_missing_is_grey() {
    let shop = Workshop::new();
    let sky = r#"<emitter type="envmap"><string name="filename" value="no-sky.exr"/></emitter>"#;
    shop.scene(&SCENE.replace(r#"<emitter type="constant" id="white"/>"#, sky));
    let output = run(&shop, &["render", "scene.xml", "-o", "a.exr", "-q"]);
    let said = assert_code(&output, 0);
    assert!(
        said.contains("no-sky.exr: no such file") && said.contains("; grey takes its place"),
        "{said}"
    );
    // The ball covers a twentieth and scatters half of the light.
    let mean = mean(&shop.path("a.exr"));
    assert!((mean - 0.49).abs() < 0.02, "{mean}");
}

#[test]
fn several_lights_around_a_scene_are_warned_of_and_one_is_portable() {
    let shop = Workshop::new();
    let more = r#"<emitter type="sunsky" id="day"/><emitter type="directional" id="sun"/>
        <emitter type="constant" id="dim"><rgb name="radiance" value="0.1"/></emitter>"#;
    shop.scene(&with(more));
    let said = assert_code(&run(&shop, &["check", "scene.xml"]), 0);
    assert_eq!(said.matches("another light around the scene").count(), 2, "{said}");
    assert!(said.contains("scene.xml: no errors, 2 warnings"), "{said}");
    let said = assert_code(&run(&shop, &["convert", "--portable", "scene.xml", "one.xml"]), 0);
    for name in ["day", "dim"] {
        let expected = format!("emitter `{name}` is left out: Mitsuba takes one light around the scene, and `white`");
        assert!(said.contains(&expected), "{said}");
    }
    let text = std::fs::read_to_string(shop.path("one.xml")).expect("the scene");
    assert!(text.contains("\"white\"") && text.contains("\"sun\""), "{text}");
    assert!(!text.contains("\"day\"") && !text.contains("\"dim\""), "{text}");
    assert_code(&run(&shop, &["convert", "scene.xml", "all.xml"]), 0);
    let text = std::fs::read_to_string(shop.path("all.xml")).expect("the scene");
    assert!(text.contains("\"day\"") && text.contains("\"dim\""), "{text}");
    shop.scene(SCENE);
    let said = assert_code(&run(&shop, &["convert", "--portable", "scene.xml", "one.xml"]), 0);
    assert_eq!(said, "");
}
