//! Files that a command has read are never replaced by what it writes, under whatever name.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Output;

use crate::workshop::{Workshop, sunroom};

const SCENE: &str = r#"<scene version="3.0.0">
  <include filename="common.xml"/>
  <sensor type="perspective">
    <transform name="to_world"><lookat origin="0, 2, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="12"/></film>
  </sensor>
  <shape type="obj"><string name="filename" value="mesh.obj"/><ref id="wood"/></shape>
  <shape type="wall"/>
  <emitter type="constant"/>
</scene>
"#;

const COMMON: &str = r#"<scene version="3.0.0">
  <bsdf type="diffuse" id="wood">
    <texture type="bitmap" name="reflectance"><string name="filename" value="wood-0001.png"/></texture>
  </bsdf>
</scene>
"#;

const MESH: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n";

/// A folder with a scene that reads files of all kinds.
fn shop() -> Workshop {
    let shop = Workshop::new();
    shop.scene(SCENE);
    shop.write("common.xml", COMMON);
    shop.write("mesh.obj", MESH);
    image::RgbImage::from_pixel(4, 4, image::Rgb([200, 150, 90]))
        .save(shop.path("wood-0001.png"))
        .expect("it can be written");
    shop
}

fn run(shop: &Workshop, line: &str) -> Output {
    let mut command = sunroom();
    command.current_dir(shop.folder()).args(line.split_whitespace());
    command.output().expect("the program starts")
}

fn content(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).expect("it is there").flatten();
    let files = entries.filter(|entry| entry.path().is_file());
    let read = |entry: std::fs::DirEntry| {
        let name = entry.file_name().to_string_lossy().into_owned();
        (name, std::fs::read(entry.path()).expect("a file"))
    };
    files.map(read).collect()
}

/// A number of samples that is never reached: what ends was not begun.
const ENDLESS: &str = "--spp 100000000 -q";

#[track_caller]
fn is_refused(shop: &Workshop, line: &str, name: &str) {
    let before = content(shop.folder());
    let output = run(shop, line);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{line}: {said}");
    let expected = format!("{name}: the scene is made of this file; choose another name");
    assert!(said.contains(&expected), "{line}: {said}");
    assert!(content(shop.folder()) == before, "{line}");
}

#[test]
fn pictures_do_not_replace_the_scene() {
    let shop = shop();
    for output in ["wood-0001.png", "./wood-0001.png", "../FOLDER/wood-0001.png"] {
        let folder = shop.folder().file_name().expect("a name").to_string_lossy();
        let output = output.replace("FOLDER", &folder);
        is_refused(&shop, &format!("render scene.xml -o {output} {ENDLESS}"), &output);
    }
    let frames = format!("render scene.xml --frames 0..2 -o wood-####.png {ENDLESS}");
    is_refused(&shop, &frames, "wood-0001.png");
    // Other pictures in the folder are no part of the scene.
    std::fs::copy(shop.path("wood-0001.png"), shop.path("other.png")).expect("it can be written");
    let output = run(&shop, "render scene.xml -o other.png --spp 1 -q");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
}

#[cfg(unix)]
#[test]
fn other_names_of_a_file_are_the_file() {
    let shop = shop();
    std::os::unix::fs::symlink("wood-0001.png", shop.path("link.png")).expect("it can be made");
    std::fs::hard_link(shop.path("wood-0001.png"), shop.path("hard.png")).expect("it can be made");
    for output in ["link.png", "hard.png"] {
        is_refused(&shop, &format!("render scene.xml -o {output} {ENDLESS}"), output);
        assert!(shop.path("link.png").is_symlink());
    }
    std::os::unix::fs::symlink("common.xml", shop.path("link.xml")).expect("it can be made");
    is_refused(&shop, "convert scene.xml link.xml", "link.xml");
}

#[test]
fn scenes_do_not_replace_what_they_include() {
    let shop = shop();
    for output in ["common.xml", "./common.xml"] {
        is_refused(&shop, &format!("convert scene.xml {output}"), output);
    }
    // The mesh of the wall would be written here.
    assert_eq!(run(&shop, "convert scene.xml new.xml").status.code(), Some(0));
    let mut meshes = content(shop.folder())
        .into_keys()
        .filter(|name| name.starts_with("new.") && name != "new.xml");
    let mesh = meshes.next_back().expect("a mesh");
    std::fs::remove_file(shop.path("new.xml")).expect("it is there");
    std::fs::rename(shop.path("mesh.obj"), shop.path(&mesh)).expect("it can be renamed");
    shop.scene(&SCENE.replace("mesh.obj", &mesh));
    is_refused(&shop, "convert scene.xml new.xml", &mesh);
}

#[test]
fn levels_and_shares_do_not_replace_the_scene() {
    let shop = shop();
    let bake = "bake scene.xml --no-probes --atlas-size 64 -q";
    is_refused(&shop, &format!("{bake} -o common.xml --samples 0..1"), "common.xml");
    // A picture that is called as a lightmap is.
    std::fs::create_dir(shop.path("level")).expect("a writable folder");
    std::fs::rename(shop.path("wood-0001.png"), shop.path("level/lightmap-0.png")).expect("it can be renamed");
    shop.write("common.xml", COMMON.replace("wood-0001.png", "level/lightmap-0.png"));
    let before = content(&shop.path("level"));
    is_refused(
        &shop,
        &format!("{bake} -o level --no-denoise --spp 1"),
        "level/lightmap-0.png",
    );
    assert!(content(&shop.path("level")) == before);
}

#[test]
fn measurements_do_not_replace_what_they_are_compared_with() {
    let shop = shop();
    let old = r#"{"version": 0}"#;
    shop.write("old.json", old);
    let output = run(&shop, "bench scene.xml --against old.json --json ./old.json");
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(
        said.contains("./old.json: this output is what it is compared with"),
        "{said}"
    );
    assert_eq!(
        std::fs::read_to_string(shop.path("old.json")).expect("it is there"),
        old
    );
}

/// What is measured is known before anything is, and what else a scene needs once it is loaded.
#[test]
fn measurements_do_not_replace_what_is_measured() {
    let shop = shop();
    let refused = |line: &str, told: &str| {
        let before = content(shop.folder());
        let output = run(&shop, line);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{line}: {said}");
        assert!(said.contains(told), "{line}: {said}");
        assert!(content(shop.folder()) == before, "{line}");
    };
    let of_scene = "the scene is made of this file; choose another name";
    let measured = "this output is one of the files that are measured";
    refused(
        "bench scene.xml --json ./scene.xml",
        &format!("./scene.xml: {measured}"),
    );
    for name in ["common.xml", "mesh.obj", "wood-0001.png"] {
        let line = format!("bench scene.xml --spp 1000000 --json {name}");
        refused(&line, &format!("{name}: {of_scene}"));
    }
    // Scenes of the folder that cannot be rendered are left out, but this is another error.
    std::fs::create_dir(shop.path("scenes")).expect("a writable folder");
    shop.write(
        "scenes/a.xml",
        SCENE
            .replace("common.xml", "../common.xml")
            .replace("mesh.obj", "../mesh.obj"),
    );
    refused(
        "bench --spp 1000000 --json common.xml",
        &format!("common.xml: {of_scene}"),
    );
    let mut rays = b"RAYS".to_vec();
    for word in [1, 1, 32] {
        rays.extend(u32::to_le_bytes(word));
    }
    let ray = [0.2, 0.2, 1.0, 0.0, 0.0, -1.0, 1.0f32];
    rays.extend(ray.into_iter().flat_map(f32::to_le_bytes).chain([0; 4]));
    shop.write("a.rays", rays);
    for name in ["mesh.obj", "a.rays"] {
        let line = format!("bench rays --mesh mesh.obj --rays a.rays --json {name}");
        refused(&line, &format!("{name}: {measured}"));
    }
}

#[test]
fn pictures_do_not_replace_the_checkpoint_they_go_on_with() {
    let shop = shop();
    let begun = run(&shop, "render scene.xml -o a.exr --checkpoint c.exr --spp 1 -q");
    assert_eq!(begun.status.code(), Some(0));
    let before = content(shop.folder());
    let output = run(&shop, &format!("render scene.xml -o ./c.exr --resume c.exr {ENDLESS}"));
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{said}");
    assert!(
        said.contains("./c.exr: this output is what the picture goes on with"),
        "{said}"
    );
    assert!(content(shop.folder()) == before);
}

#[cfg(feature = "window")]
#[test]
fn files_about_the_editor_do_not_replace_what_it_opens() {
    let shop = shop();
    shop.write("script.txt", "save\n");
    shop.write("old.txt", "# The acts of a monkey\nundo\n");
    let before = content(shop.folder());
    let opened = "this output is what is opened, which is not replaced: name another file";
    let no_log = "is there already and is no log of a monkey: it is not replaced; name another file by --monkey-log";
    for (line, told) in [
        (
            "edit scene.xml --screenshot ./scene.xml",
            format!("./scene.xml: {opened}"),
        ),
        (
            "edit scene.xml --script script.txt --screenshot script.txt",
            format!("script.txt: {opened}"),
        ),
        (
            "edit scene.xml --monkey 3 --no-window --monkey-log common.xml",
            format!("common.xml {no_log}"),
        ),
        (
            "edit scene.xml --monkey 3 --no-window --monkey-log ./scene.xml",
            format!("./scene.xml {no_log}"),
        ),
    ] {
        let output = run(&shop, line);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{line}: {said}");
        assert!(said.contains(&told), "{line}: {said}");
        assert!(content(shop.folder()) == before, "{line}");
    }
    // Another log is replaced.
    run(
        &shop,
        "edit scene.xml --monkey 3 --no-window --threads 1 --monkey-log old.txt",
    );
    let log = std::fs::read_to_string(shop.path("old.txt")).expect("a log");
    assert!(log.starts_with("# The acts of a monkey\nopen "), "{log}");
}

#[test]
fn names_that_are_too_long_are_refused_before_rendering() {
    let shop = shop();
    let stem = |length: usize| "a".repeat(length);
    for line in [
        format!("render scene.xml -o {}.png {ENDLESS}", stem(252)),
        // The last frame has a digit more than the first.
        format!("render scene.xml --frames 9..10 -o {}#.png {ENDLESS}", stem(250)),
        format!("convert scene.xml {}.gltf", stem(248)),
        format!("bake scene.xml -o {}.bake --samples 0..1", stem(251)),
        format!("render scene.xml -o a.png --checkpoint {} {ENDLESS}", stem(256)),
    ] {
        let before = content(shop.folder());
        let output = run(&shop, &line);
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(1), "{said}");
        assert!(said.contains("File name too long"), "{said}");
        assert!(content(shop.folder()) == before);
    }
}
