//! Files that `--checkpoint` must not replace, and files that are no checkpoint to go on with.

use crate::workshop::{Workshop, sunroom};

const SCENE: &str = r#"<scene version="3.0.0">
  <sensor type="perspective">
    <film type="hdrfilm"><integer name="width" value="32"/><integer name="height" value="32"/></film>
  </sensor>
  <shape type="rectangle"><transform name="to_world"><translate z="-3"/></transform></shape>
  <emitter type="constant"/>
</scene>
"#;

fn shop() -> Workshop {
    let shop = Workshop::new();
    shop.scene(SCENE);
    shop
}

/// Runs a command line, whose words have no spaces, and returns its messages.
#[track_caller]
fn said(shop: &Workshop, words: &str, code: i32) -> String {
    let mut command = sunroom();
    command.current_dir(shop.folder()).args(words.split(' '));
    let output = command.output().expect("the program starts");
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{words}: {message}");
    message
}

const RENDER: &str = "render scene.xml -q --spp 2 -o a.exr";
const BAKE: &str = "bake scene.xml -q --spp 1 --no-denoise --no-probes --atlas-size 64 -o level";
const SHARE: &str = "bake scene.xml -q --samples 0..1 --no-probes --atlas-size 64 -o a.bake";

#[test]
fn only_checkpoints_are_replaced_by_checkpoints() {
    let shop = shop();
    let read = |name: &str| std::fs::read(shop.path(name)).expect("it is there");
    shop.write("other.xml", SCENE);
    said(&shop, &format!("{RENDER} --checkpoint c.exr"), 0);
    said(&shop, &format!("{BAKE} --checkpoint c.bake"), 0);
    std::fs::remove_dir_all(shop.path("level")).expect("removed");
    std::fs::rename(shop.path("a.exr"), shop.path("plain.exr")).expect("renamed");
    for (command, names) in [
        (RENDER, ["scene.xml", "other.xml", "plain.exr", "c.bake"]),
        (BAKE, ["scene.xml", "other.xml", "plain.exr", "c.exr"]),
        (SHARE, ["scene.xml", "other.xml", "plain.exr", "c.exr"]),
    ] {
        for name in names {
            let before = read(name);
            let message = said(&shop, &format!("{command} --checkpoint {name}"), 1);
            let work = if command == RENDER { "picture" } else { "bake" };
            let words = format!("{name} is there already and is no checkpoint of a {work}: it is not replaced");
            assert!(message.contains(&words), "{message}");
            assert!(read(name) == before, "{command}: {name}");
        }
    }
    for output in ["a.exr", "a.bake", "level"] {
        assert!(!shop.path(output).exists(), "{output} was written");
    }

    // An empty file has nothing to lose, and a checkpoint of another picture is an old one.
    shop.write("empty", "");
    said(&shop, &format!("{RENDER} --checkpoint empty"), 0);
    said(&shop, &format!("{RENDER} --seed 7 --checkpoint c.exr"), 0);
    assert!(read("empty") != read("c.exr"));
    said(&shop, &format!("{RENDER} --seed 7 --resume c.exr"), 0);
    said(&shop, &format!("{BAKE} --seed 7 --checkpoint c.bake"), 0);
    said(&shop, &format!("{BAKE} --seed 7 --resume c.bake"), 0);
}

#[test]
fn a_checkpoint_that_cannot_be_written_is_told_before_anything_is_rendered() {
    let shop = shop();
    for command in [RENDER, BAKE, SHARE] {
        let message = said(&shop, &format!("{command} --checkpoint none/c"), 1);
        assert!(
            message.contains("cannot write none/c: there is no folder none"),
            "{message}"
        );
    }
    for output in ["a.exr", "a.bake", "level"] {
        assert!(!shop.path(output).exists(), "{output} was written");
    }
}

#[test]
fn two_results_never_go_to_one_file() {
    let shop = shop();
    std::fs::create_dir(shop.path("level")).expect("a folder");
    let twice = "a.exr: this output is named twice";
    let both = "the checkpoint and an output cannot be the same file";
    for (words, expected) in [
        (format!("{RENDER} -o b.png -o ./a.exr"), twice),
        (format!("{RENDER} -o level/../a.exr"), twice),
        ("merge c.exr -o a.exr -o a.exr".to_owned(), twice),
        (format!("{RENDER} --checkpoint a.exr"), both),
        (format!("{RENDER} --frames 3 --checkpoint a-0003.exr"), both),
        (format!("{SHARE} --checkpoint level/../a.bake"), both),
        (format!("{BAKE} --checkpoint level/level.glb"), both),
        (format!("{BAKE} --checkpoint level/lightmap-0.png"), both),
    ] {
        let message = said(&shop, &words, 2);
        assert!(message.contains(expected), "{words}: {message}");
    }
    for output in ["a.exr", "b.png", "a.bake", "level/level.glb"] {
        assert!(!shop.path(output).exists(), "{output} was written");
    }
    // A name of its own in the folder of the level is none of the bake's files.
    said(&shop, &format!("{BAKE} --checkpoint level/c.bake"), 0);
}

#[test]
fn what_is_no_checkpoint_to_go_on_with_is_told() {
    let shop = shop();
    said(&shop, &format!("{RENDER} --checkpoint c.exr"), 0);
    said(&shop, &format!("{BAKE} --checkpoint c.bake"), 0);
    let whole = std::fs::read(shop.path("c.exr")).expect("a checkpoint");
    shop.write("cut.exr", &whole[..whole.len() / 2]);
    shop.write("short.exr", &whole[..9]);
    shop.write("picture.exr", std::fs::read(shop.path("a.exr")).expect("a picture"));
    shop.write("grey.png", b"\x89PNG\r\n\x1a\n");
    shop.write("empty.exr", "");
    let none = "no EXR file: a ";
    for (name, words) in [
        ("scene.xml", none),
        ("grey.png", none),
        ("empty.exr", none),
        ("cut.exr", "it is damaged or no checkpoint"),
        ("short.exr", "it is damaged or no checkpoint"),
        ("picture.exr", "it is damaged or no checkpoint"),
        ("c.bake", "it is a checkpoint or share of a bake"),
    ] {
        let message = said(&shop, &format!("{RENDER} --resume {name}"), 1);
        let is_told =
            message.contains(&format!("{name}: {words}")) || message.contains(&format!("{name}: it is {words}"));
        assert!(is_told, "{message}");
    }
    let message = said(&shop, "merge scene.xml -o merged.exr", 1);
    assert!(message.contains(&format!("scene.xml: is {none}")), "{message}");
    let message = said(&shop, &format!("{RENDER} --aov depth --resume c.exr"), 1);
    assert!(
        message.ends_with("the list of layers is depth, and was empty (--force goes on with it)\n"),
        "{message}"
    );
}
