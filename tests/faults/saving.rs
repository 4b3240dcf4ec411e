//! Scenes that cannot be saved.

use crate::program::{OLD, Running, SCENE, Workshop};
use crate::rendering::SHORT_FILES;
use crate::table::{Row, section};
use crate::window::{copy, edit};
use crate::window_support::Display;

section! { "Saving a scene"
    scene_goes_to_a_folder:
        "`sunroom convert` writes to a folder.",
        "`error: …new.xml: it is a folder`, exit code 1.",
        "The folder; nothing new.";
    disk_is_full_for_a_scene:
        "The disk becomes full while `sunroom convert` writes a scene.",
        "`error: …new.xml: File too large`, exit code 1.",
        "The older file of that name, no temporary file.";
    disk_is_full_for_an_export:
        "The disk becomes full while `sunroom convert` exports to glTF.",
        "`error: …new.glb: File too large`, exit code 1.",
        "The older file of that name, no temporary file.";
    script_cannot_save:
        "A script saves a scene where it cannot be written, and the program ends with it.",
        "`error: script.txt:2: …there is no folder`, `The unsaved edits are kept`, exit code 1.",
        "The scene as it was, and a recovery copy with the edits.";
}

fn scene_goes_to_a_folder(row: &Row) {
    let shop = Workshop::new();
    std::fs::create_dir(shop.path("new.xml")).expect("a temporary folder");
    row.holds(&shop.run(&[], &["convert", "scene.xml", "new.xml"]));
    assert!(shop.names("new.xml").is_empty());
    assert_eq!(shop.names("."), ["new.xml", "scene.xml", "tmp"]);
}

fn disk_is_full_for_a_scene(row: &Row) {
    let shop = Workshop::new();
    // More shapes than the limit has room for.
    let shape = r#"<shape type="sphere"><point name="center" value="1, 2, 3"/></shape>"#;
    shop.write(
        "scene.xml",
        SCENE.replace("</scene>", &format!("{}</scene>", shape.repeat(100))),
    );
    shop.write("new.xml", OLD);
    row.holds(&shop.run(&SHORT_FILES, &["convert", "scene.xml", "new.xml"]));
    assert_eq!(std::fs::read(shop.path("new.xml")).expect("it is there"), OLD);
    assert_eq!(shop.names("."), ["new.xml", "scene.xml", "tmp"]);
}

fn disk_is_full_for_an_export(row: &Row) {
    let shop = Workshop::new();
    // The mesh of a sphere is larger than the limit.
    shop.write(
        "scene.xml",
        SCENE.replace("</scene>", "<shape type=\"sphere\"/></scene>"),
    );
    shop.write("new.glb", OLD);
    row.holds(&shop.run(&SHORT_FILES, &["convert", "scene.xml", "new.glb"]));
    assert_eq!(std::fs::read(shop.path("new.glb")).expect("it is there"), OLD);
    assert_eq!(shop.names("."), ["new.glb", "scene.xml", "tmp"]);
}

fn script_cannot_save(row: &Row) {
    let Some(display) = Display::open() else { return };
    let shop = Workshop::new();
    shop.write("script.txt", "add sphere name=edited\nsave-to absent/new.xml\n");
    let mut command = edit(&shop, &["--script", "script.txt", "--exit"]);
    display.show(&mut command, &shop.path("runtime"));
    row.holds(&Running::start(&mut command).end());
    assert!(copy(&shop).is_some_and(|copy| copy.contains("edited")));
    assert_eq!(
        std::fs::read_to_string(shop.path("scene.xml")).expect("it is there"),
        SCENE
    );
}
