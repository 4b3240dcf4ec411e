//! Scenes with grids of `.vdb` files: what is said of them, how they are converted and sent away.

use std::process::Output;

use sunroom::render::image_io::exr::decode_exr;

use crate::workshop::{Workshop, sunroom};

const SMOKE: &[u8] = include_bytes!("../corpus/vdb/smoke-blosc.vdb");
const FIRE: &[u8] = include_bytes!("../corpus/vdb/fire-zip-half.vdb");

/// Smoke in a turned box in the sky, and a light whose colours are those of another file and place.
const SCENE: &str = r#"<scene version="3.0.0">
  <integrator type="volpath"/>
  <sensor type="perspective">
    <transform name="to_world"><lookat origin="-4, -6, 9" target="-4, -6, -3" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="24"/><integer name="height" value="18"/></film>
    <sampler type="independent"><integer name="sample_count" value="16"/></sampler>
  </sensor>
  <volume type="vdbvolume" id="smoke">
    <string name="filename" value="grids/smoke.vdb"/>
    <transform name="to_world"><rotate y="1" angle="20"/><scale value="1.3"/><translate x="0.1" z="0.7"/></transform>
  </volume>
  <shape type="cube">
    <transform name="to_world"><scale value="30"/></transform>
    <bsdf type="null"/>
    <medium type="heterogeneous" name="interior">
      <ref name="sigma_t" id="smoke"/>
      <volume type="vdbvolume" name="albedo">
        <string name="filename" value="grids/fire.vdb"/><string name="grid" value="color"/>
        <string name="filter_type" value="nearest"/>
      </volume>
      <float name="scale" value="2"/>
    </medium>
  </shape>
  <shape type="sphere">
    <point name="center" x="-8" y="-6" z="-5"/><float name="radius" value="2"/>
    <bsdf type="null"/>
    <medium type="heterogeneous" name="interior">
      <ref name="sigma_t" id="smoke"/>
    </medium>
  </shape>
  <emitter type="constant"/>
</scene>
"#;

fn shop() -> Workshop {
    let shop = Workshop::new();
    shop.write("scenes/scene.xml", SCENE);
    shop.write("scenes/grids/smoke.vdb", SMOKE);
    shop.write("scenes/grids/fire.vdb", FIRE);
    shop
}

fn run(shop: &Workshop, arguments: &[&str]) -> Output {
    let mut command = sunroom();
    command.current_dir(shop.folder()).args(arguments);
    command
        .env_remove("SUNROOM_ASSETS")
        .env_remove("SUNROOM_MEMORY")
        .output()
        .expect("the program starts")
}

/// What is said by a command that ends with this code, in one line.
#[track_caller]
fn said(shop: &Workshop, code: i32, arguments: &[&str]) -> String {
    let output = run(shop, arguments);
    let text = String::from_utf8_lossy(&output.stderr).replace('│', " ");
    let words: Vec<&str> = text.split_whitespace().collect();
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {text}");
    words.join(" ")
}

/// The pixels of a scene.
fn rendered(shop: &Workshop, scene: &str) -> Vec<f32> {
    said(shop, 0, &["render", scene, "-q", "-o", "out.exr"]);
    let bytes = std::fs::read(shop.path("out.exr")).expect("a picture");
    let image = decode_exr(&bytes).expect("an EXR file");
    let picture = image.layer("").expect("the picture");
    picture.pixels.iter().flat_map(|pixel| pixel.to_array()).collect()
}

#[test]
fn a_portable_scene_has_the_grids_as_vol_files_and_the_very_same_picture() {
    let shop = shop();
    said(&shop, 0, &["check", "--strict", "scenes/scene.xml"]);
    let before = rendered(&shop, "scenes/scene.xml");
    // The smoke is in the picture.
    let dark = before.iter().filter(|value| **value < 0.99).count();
    assert!(dark > 50, "{dark}");
    std::fs::create_dir(shop.path("other")).expect("a folder");
    said(
        &shop,
        0,
        &["convert", "--portable", "scenes/scene.xml", "other/new.xml"],
    );
    let text = std::fs::read_to_string(shop.path("other/new.xml")).expect("the scene");
    assert!(!text.contains("vdb") && !text.contains("\"grid\""), "{text}");
    // The two uses of the smoke share a file.
    for name in ["new.volume-1.vol", "new.volume-2.vol"] {
        assert!(text.contains(name) && shop.path("other").join(name).is_file(), "{text}");
    }
    assert!(!shop.path("other/new.volume-3.vol").exists());
    assert!(rendered(&shop, "other/new.xml") == before);
    // As an extension it stays.
    said(&shop, 0, &["convert", "scenes/scene.xml", "other/kept.xml"]);
    let text = std::fs::read_to_string(shop.path("other/kept.xml")).expect("the scene");
    assert!(text.contains("../scenes/grids/smoke.vdb"), "{text}");
    assert!(rendered(&shop, "other/kept.xml") == before);
}

#[test]
fn what_is_wrong_with_a_vdb_file_is_said_where_it_is_named() {
    let shop = shop();
    let with = |from: &str, to: &str| {
        assert!(SCENE.contains(from));
        shop.write("scenes/scene.xml", SCENE.replace(from, to));
        said(&shop, 1, &["check", "scenes/scene.xml"])
    };
    let place = "scenes/scene.xml:9:";
    let missing = with("grids/smoke.vdb", "grids/smog.vdb");
    assert!(
        missing.contains(place) && missing.contains("smog.vdb: no such file"),
        "{missing}"
    );
    let several = with("grids/smoke.vdb", "grids/fire.vdb");
    let expected = "fire.vdb: the .vdb file has several grids: name one of `temperature`, `color`";
    assert!(several.contains(place) && several.contains(expected), "{several}");
    let unknown = with("\"color\"", "\"colour\"");
    let expected = "fire.vdb: the .vdb file has no grid `colour`, only `temperature`, `color`";
    assert!(
        unknown.contains("scenes/scene.xml:18:") && unknown.contains(expected),
        "{unknown}"
    );
    let other_plugin = with("type=\"vdbvolume\" id", "type=\"gridvolume\" id");
    assert!(
        other_plugin.contains("this is a .vdb file: a `vdbvolume` reads it"),
        "{other_plugin}"
    );
    let nameless = with("<string name=\"filename\" value=\"grids/smoke.vdb\"/>", "");
    assert!(nameless.contains("a `vdbvolume` needs a `filename`"), "{nameless}");
    let odd = with("\"filter_type\" value=\"nearest\"", "\"filter_type\" value=\"cubic\"");
    assert!(odd.contains("expected `nearest` or `trilinear`"), "{odd}");
    shop.write("scenes/scene.xml", SCENE);
    for (content, expected) in [
        (&SMOKE[..2000], "ends too early"),
        (b"nothing", "this is not a .vdb file"),
        (b"VOL\x03", "this is a .vol file: a `gridvolume` reads it"),
    ] {
        shop.write("scenes/grids/smoke.vdb", content);
        let broken = said(&shop, 1, &["check", "scenes/scene.xml"]);
        assert!(broken.contains(place) && broken.contains(expected), "{broken}");
        let portable = said(&shop, 1, &["convert", "--portable", "scenes/scene.xml", "new.xml"]);
        assert!(
            portable.contains(expected) && !shop.path("new.xml").exists(),
            "{portable}"
        );
    }
}

#[test]
fn a_grid_that_unpacks_to_more_than_the_budget_is_refused() {
    let shop = Workshop::new();
    shop.write("scenes/scene.xml", SCENE.replace("\"color\"", "\"temperature\""));
    shop.write("scenes/grids/smoke.vdb", SMOKE);
    shop.write("scenes/grids/fire.vdb", FIRE);
    let refused = said(&shop, 1, &["check", "--memory", "23kB", "scenes/scene.xml"]);
    let expected = "smoke.vdb: the grid `density` has 21 x 15 x 21 voxels, which need 26.5 kB of memory";
    assert!(
        refused.contains(expected) && refused.contains("--memory SIZE"),
        "{refused}"
    );
}

#[test]
fn a_job_takes_vdb_files_along() {
    let shop = shop();
    said(&shop, 0, &["submit", "scenes/scene.xml", "--to", "slurm", "-o", "job"]);
    let mut found = Vec::new();
    let mut waiting = vec![shop.path("job")];
    while let Some(folder) = waiting.pop() {
        for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
            match entry.path().is_dir() {
                true => waiting.push(entry.path()),
                false => found.push(entry.file_name().to_string_lossy().into_owned()),
            }
        }
    }
    for name in ["smoke.vdb", "fire.vdb"] {
        assert_eq!(found.iter().filter(|known| *known == name).count(), 1, "{found:?}");
    }
}
