//! The window without what it needs, and ended from outside.

use std::path::PathBuf;
use std::process::{Command, Stdio};

use image::ImageReader;
use sunroom::app::editor::session::preferences::PreferencesFile;

use crate::program::{Running, SCENE, Workshop, wait_for};
use crate::table::{Row, section};
use crate::window_support::Display;

section! { "The window"
    no_display:
        "There is no display.",
        "`error: there is no display to open a window on`, exit code 1.",
        "Nothing new.";
    display_cannot_be_reached:
        "There is a display's name, but no server.",
        "`error: the display cannot be reached`, exit code 1.",
        "Nothing new.";
    no_vulkan:
        "No graphics driver is installed.",
        "`error: no graphics driver was found that can draw a window`, exit code 1.",
        "Nothing new.";
    screenshot_has_no_folder:
        "The folder for `--screenshot` does not exist.",
        "Before the window opens: `error: cannot write …a.png: there is no folder …`, exit code 1.",
        "Nothing new.";
    script_cannot_save_the_picture:
        "A script saves the picture where it cannot be written.",
        "`error: script.txt:2: cannot write absent/a.exr: there is no folder absent; the picture is kept in ….exr`, exit code 1.",
        "The picture as EXR in the folder for temporary files.";
    script_saves_over_a_picture_of_the_scene:
        "A script saves the picture to a picture that the scene shows.",
        "`error: script.txt:2: a.png: the scene is made of this file; choose another name`, exit code 1.",
        "The picture that the scene shows, and the other one as EXR in the folder for temporary files.";
    termination_with_edits:
        "SIGTERM while there are unsaved edits.",
        "`The unsaved edits are kept and will be offered when the scene is opened again`, exit code 130.",
        "The scene as it was, and a recovery copy with the edits.";
    interrupt_with_edits:
        "SIGINT (Ctrl+C in the terminal) while there are unsaved edits.",
        "`The unsaved edits are kept and will be offered when the scene is opened again`, exit code 130.",
        "The scene as it was, and a recovery copy with the edits.";
    hang_up_with_edits:
        "SIGHUP while there are unsaved edits, such as a terminal that is closed.",
        "`The unsaved edits are kept and will be offered when the scene is opened again`, exit code 130.",
        "The scene as it was, and a recovery copy with the edits.";
    killed_with_edits:
        "SIGKILL while there are unsaved edits.",
        "Nothing; the next window offers the last recovery copy.",
        "The scene as it was, and the recovery copy, which is at most as old as the preference says.";
    display_goes_away:
        "The display server ends while there are unsaved edits.",
        "The window is gone; the next one offers the last recovery copy.",
        "The scene as it was, and the recovery copy.";
    messages_pipe_of_the_window_is_closed:
        "The program that reads the messages of the window ends early.",
        "Nothing, exit code 0.",
        "What was saved.";
    no_home:
        "The folder for preferences cannot be made.",
        "In the preferences: `preferences.json: ` and the reason.",
        "Nothing new.";
}

pub fn edit(shop: &Workshop, arguments: &[&str]) -> Command {
    // The test itself may run where some signals are ignored.
    let before = ["env", "--default-signal"];
    let mut command = shop.command(&before, &[&["edit", "scene.xml", "--threads", "1"], arguments].concat());
    command.env("SUNROOM_CONFIG", shop.path("config"));
    command
}

fn no_display(row: &Row) {
    let shop = Workshop::new();
    row.holds(&Running::start(&mut edit(&shop, &[])).end());
    assert_eq!(shop.names("."), ["scene.xml", "tmp"]);
}

fn display_cannot_be_reached(row: &Row) {
    let shop = Workshop::new();
    let mut command = edit(&shop, &[]);
    command
        .env("DISPLAY", shop.path("absent"))
        .env("XDG_RUNTIME_DIR", shop.path("tmp"));
    row.holds(&Running::start(&mut command).end());
}

fn no_vulkan(row: &Row) {
    let Some(display) = Display::open() else { return };
    let shop = Workshop::new();
    let mut command = edit(&shop, &[]);
    display.show(&mut command, &shop.path("tmp"));
    command
        .env("VK_ICD_FILENAMES", "/absent.json")
        .env("VK_DRIVER_FILES", "/absent.json");
    row.holds(&Running::start(&mut command).end());
}

fn screenshot_has_no_folder(row: &Row) {
    let shop = Workshop::new();
    row.holds(&Running::start(&mut edit(&shop, &["--screenshot", "absent/a.png"])).end());
    assert_eq!(shop.names("."), ["scene.xml", "tmp"]);
}

fn script_cannot_save_the_picture(row: &Row) {
    let Some(display) = Display::open() else { return };
    let shop = Workshop::new();
    shop.write("script.txt", "wait 2\nsave-image-to absent/a.exr\n");
    let mut command = edit(&shop, &["--script", "script.txt", "--exit"]);
    display.show(&mut command, &shop.path("runtime"));
    row.holds(&Running::start(&mut command).end());
    assert_eq!(shop.kept_picture().dimensions(), (64, 48));
}

fn script_saves_over_a_picture_of_the_scene(row: &Row) {
    let Some(display) = Display::open() else { return };
    let shop = Workshop::new();
    assert_eq!(
        shop.run(&[], &["render", "scene.xml", "-o", "a.png", "-q"])
            .status
            .code(),
        Some(0)
    );
    let sky = r#"<emitter type="envmap"><string name="filename" value="a.png"/></emitter></scene>"#;
    shop.write("scene.xml", SCENE.replace("</scene>", sky));
    let before = std::fs::read(shop.path("a.png")).expect("it is there");
    shop.write("script.txt", "wait 2\nsave-image-to a.png\n");
    let mut command = edit(&shop, &["--script", "script.txt", "--exit"]);
    display.show(&mut command, &shop.path("runtime"));
    row.holds(&Running::start(&mut command).end());
    assert!(std::fs::read(shop.path("a.png")).expect("it is there") == before);
    assert_eq!(shop.kept_picture().dimensions(), (64, 48));
}

/// A window whose scene has one edit that is not saved, and which is written aside after `seconds`.
fn window_with_an_edit(shop: &Workshop, display: &Display, seconds: u32) -> Running {
    std::fs::create_dir(shop.path("config")).expect("a temporary folder");
    shop.write(
        "config/preferences.json",
        format!("{{\"autosave_seconds\": {seconds}}}"),
    );
    shop.write("script.txt", "add sphere name=edited\nwait 1\nsave-image-to done.png\n");
    let mut command = edit(shop, &["--script", "script.txt"]);
    display.show(&mut command, &shop.path("runtime"));
    let running = Running::start(&mut command);
    wait_for("the script", || shop.path("done.png").exists());
    running
}

/// The recovery copy, if there is one.
pub fn copy(shop: &Workshop) -> Option<String> {
    let folders = std::fs::read_dir(shop.path("config/recovery")).ok()?;
    let mut scenes = folders.map(|folder| folder.expect("an entry").path().join("scene.xml"));
    let scene: Option<PathBuf> = scenes.find(|scene| scene.is_file());
    std::fs::read_to_string(scene?).ok()
}

#[track_caller]
fn edit_is_only_in_the_copy(shop: &Workshop) {
    let copy = copy(shop).expect("there is a copy");
    assert!(
        copy.contains("edited") && copy.trim_end().ends_with("</scene>"),
        "{copy}"
    );
    let scene = std::fs::read_to_string(shop.path("scene.xml")).expect("it is there");
    assert_eq!(scene, SCENE);
}

fn ended_with_edits_by(row: &Row, signal: &str) {
    let Some(display) = Display::open() else { return };
    let shop = Workshop::new();
    let running = window_with_an_edit(&shop, &display, 3600);
    running.send(signal);
    row.holds(&running.end());
    edit_is_only_in_the_copy(&shop);
}

fn termination_with_edits(row: &Row) {
    ended_with_edits_by(row, "TERM");
}

fn interrupt_with_edits(row: &Row) {
    ended_with_edits_by(row, "INT");
}

fn hang_up_with_edits(row: &Row) {
    ended_with_edits_by(row, "HUP");
}

fn killed_with_edits(_: &Row) {
    let Some(display) = Display::open() else { return };
    let shop = Workshop::new();
    let running = window_with_an_edit(&shop, &display, 1);
    wait_for("the recovery copy", || copy(&shop).is_some());
    running.send("KILL");
    assert_eq!(running.end().status.code(), None);
    edit_is_only_in_the_copy(&shop);
}

fn display_goes_away(_: &Row) {
    let Some(display) = Display::open() else { return };
    let shop = Workshop::new();
    let running = window_with_an_edit(&shop, &display, 1);
    wait_for("the recovery copy", || copy(&shop).is_some());
    drop(display);
    let output = running.end();
    println!("{:?} {}", output.status, String::from_utf8_lossy(&output.stderr));
    assert_ne!(output.status.code(), Some(0));
    edit_is_only_in_the_copy(&shop);
}

fn messages_pipe_of_the_window_is_closed(row: &Row) {
    let Some(display) = Display::open() else { return };
    let shop = Workshop::new();
    let mut command = edit(&shop, &["--screenshot", "a.png", "--exit"]);
    display.show(&mut command, &shop.path("runtime"));
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    row.holds(
        &command
            .stderr(Stdio::from(writer))
            .output()
            .expect("the program starts"),
    );
    let shot = ImageReader::open(shop.path("a.png")).expect("it was saved").decode();
    assert!(shot.is_ok());
}

fn no_home(row: &Row) {
    let (mut file, mut preferences) = PreferencesFile::open(Some("/proc/absent".as_ref()));
    preferences.speed += 1.0;
    file.store(preferences);
    row.is_said_in(file.problem.as_deref().expect("there is a problem"));
}
