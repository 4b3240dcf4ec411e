//! `sunroom render` whose outputs cannot be written, and that ends before its time.

use std::process::{Command, Stdio};

use crate::program::{OLD, Running, SCENE, Workshop, picture, with_mounts};
use crate::table::{Row, section};

section! { "Rendering"
    output_is_a_folder:
        "An output is a folder.",
        "Before rendering: `error: cannot write …a.png: it is a folder`, exit code 1.",
        "Nothing new.";
    output_is_a_device:
        "An output is a link to a device.",
        "Before rendering: `error: cannot write …a.png: it is a device or a pipe, not a file`, exit code 1.",
        "Nothing new; the device is still one, also where root could have replaced it.";
    output_is_a_link_to_nothing:
        "An output is a link to a file that is not there.",
        "Nothing, exit code 0.",
        "The picture where the link leads; the link is still one.";
    output_is_a_link_in_a_circle:
        "An output is a link that leads to itself.",
        "Before rendering: `error: cannot write …a.png: it is a link that leads in a circle`, exit code 1.",
        "Nothing new.";
    output_is_a_picture_of_the_scene:
        "An output is a picture that the scene shows.",
        "Before rendering: `error: a.png: the scene is made of this file; choose another name`, exit code 1.",
        "Nothing new.";
    output_has_too_long_a_name:
        "The name of an output is too long.",
        "Before rendering: `error: cannot write …a.png: File name too long`, exit code 1.",
        "Nothing new.";
    output_has_no_folder:
        "The folder of an output does not exist.",
        "Before rendering: `error: cannot write …a.png: there is no folder …`, exit code 1.",
        "Nothing new.";
    output_is_read_only:
        "The folder of an output is read-only.",
        "Before rendering: `error: cannot write …a.png: read-only filesystem`, exit code 1.",
        "Nothing new.";
    one_of_two_outputs_fails:
        "The folder of the first of two outputs goes away during the render.",
        "`error: cannot write …a.png: there is no folder …`, exit code 1.",
        "The second output has the picture.";
    no_output_can_be_written:
        "The folder of the only output goes away during the render.",
        "`error: cannot write …a.png: there is no folder …`, `the picture is kept in ….exr`, exit code 1.",
        "The picture as EXR in the folder for temporary files.";
    disk_is_full:
        "The disk of the only output becomes full while the picture is written.",
        "`error: cannot write …a.exr: No space left on device`, `the picture is kept in ….exr`, exit code 1.",
        "The older file of that name, no temporary file beside it, and the picture as EXR in the folder for temporary files.";
    all_disks_are_full:
        "No file can grow beyond a page: neither the output nor a temporary file.",
        "`error: cannot write …a.exr: File too large`, `the picture could not be kept elsewhere: …File too large`, exit code 1.",
        "The older file of that name and no temporary file. The picture is lost.";
    standard_output_is_full:
        "Standard output, the only output, goes to a full disk.",
        "`error: cannot write standard output: No space left on device`, `the picture is kept in ….exr`, exit code 1.",
        "The picture as EXR in the folder for temporary files.";
    picture_pipe_is_closed:
        "The program that reads the picture from standard output ends early.",
        "`error: cannot write standard output: Broken pipe`, `the picture is kept in ….exr`, exit code 1.",
        "The picture as EXR in the folder for temporary files.";
    figures_pipe_is_closed:
        "The program that reads the figures of `--stats` ends early.",
        "Nothing, exit code 0.",
        "The picture.";
    messages_pipe_is_closed:
        "The program that reads the messages ends early.",
        "Nothing, exit code 0.",
        "The picture.";
}

/// A render that has this many samples to make does not end by itself: where it ends, none was begun.
const ENDLESS: [&str; 2] = ["--spp", "100000000"];

/// Fails unless the program ends with what the row says, without having rendered.
#[track_caller]
fn is_refused_before_rendering(row: &Row, shop: &Workshop, before: &[&str], outputs: &[&str]) {
    let mut arguments = vec!["render", "scene.xml"];
    arguments.extend(outputs.iter().flat_map(|output| ["-o", *output]));
    arguments.extend(ENDLESS);
    row.holds(&shop.run(before, &arguments));
}

fn output_is_a_folder(row: &Row) {
    let shop = Workshop::new();
    std::fs::create_dir(shop.path("a.png")).expect("a temporary folder");
    is_refused_before_rendering(row, &shop, &[], &["b.png", "a.png"]);
    assert_eq!(shop.names("."), ["a.png", "scene.xml", "tmp"]);
    assert!(shop.names("a.png").is_empty() && shop.names("tmp").is_empty());
}

fn output_is_a_device(row: &Row) {
    use std::os::unix::fs::FileTypeExt;
    let shop = Workshop::new();
    // A node of its own, of the kind of /dev/full: a fault of the program must not cost the machine one of its devices.
    let make = "mknod device c 1 7 2>/dev/null || { echo 'skipped: no device can be made here, a pipe takes its place'; mkfifo device; }";
    let made = Command::new("sh")
        .args(["-c", make])
        .current_dir(shop.path("."))
        .status();
    assert!(made.is_ok_and(|status| status.success()));
    std::os::unix::fs::symlink("device", shop.path("a.png")).expect("a temporary folder");
    is_refused_before_rendering(row, &shop, &[], &["a.png"]);
    assert_eq!(shop.names("."), ["a.png", "device", "scene.xml", "tmp"]);
    let kind = std::fs::metadata(shop.path("a.png")).expect("it is there").file_type();
    assert!(kind.is_char_device() || kind.is_fifo(), "{kind:?}");
}

fn output_is_a_link_to_nothing(row: &Row) {
    let shop = Workshop::new();
    std::fs::create_dir(shop.path("far")).expect("a temporary folder");
    std::os::unix::fs::symlink("far/b.png", shop.path("a.png")).expect("a temporary folder");
    row.holds(&shop.run(&[], &["render", "scene.xml", "-o", "a.png", "-q"]));
    assert!(shop.path("a.png").is_symlink());
    picture(&shop.path("far/b.png"));
    assert_eq!(shop.names("."), ["a.png", "far", "scene.xml", "tmp"]);
}

fn output_is_a_link_in_a_circle(row: &Row) {
    let shop = Workshop::new();
    std::os::unix::fs::symlink("a.png", shop.path("a.png")).expect("a temporary folder");
    is_refused_before_rendering(row, &shop, &[], &["a.png"]);
    assert!(shop.path("a.png").is_symlink());
    assert_eq!(shop.names("."), ["a.png", "scene.xml", "tmp"]);
}

fn output_is_a_picture_of_the_scene(row: &Row) {
    let shop = Workshop::new();
    let render = ["render", "scene.xml", "-o", "a.png", "-q"];
    assert_eq!(shop.run(&[], &render).status.code(), Some(0));
    let lamp = r#"<emitter type="envmap"><string name="filename" value="a.png"/></emitter></scene>"#;
    shop.write("scene.xml", SCENE.replace("</scene>", lamp));
    let before = std::fs::read(shop.path("a.png")).expect("it is there");
    is_refused_before_rendering(row, &shop, &[], &["a.png"]);
    assert!(std::fs::read(shop.path("a.png")).expect("it is there") == before);
}

fn output_has_too_long_a_name(row: &Row) {
    let shop = Workshop::new();
    is_refused_before_rendering(row, &shop, &[], &[&format!("{}.png", "a".repeat(300))]);
    assert_eq!(shop.names("."), ["scene.xml", "tmp"]);
}

fn output_has_no_folder(row: &Row) {
    let shop = Workshop::new();
    is_refused_before_rendering(row, &shop, &[], &["b.png", "absent/a.png"]);
    assert_eq!(shop.names("."), ["scene.xml", "tmp"]);
}

fn output_is_read_only(row: &Row) {
    let shop = Workshop::new();
    std::fs::create_dir(shop.path("closed")).expect("a temporary folder");
    // Permissions do not bind root; a mount does.
    let Some(before) = with_mounts("mount --bind closed closed && mount -o remount,ro,bind closed") else {
        return;
    };
    let before: Vec<&str> = before.iter().map(String::as_str).collect();
    is_refused_before_rendering(row, &shop, &before, &["closed/a.png"]);
    assert_eq!(shop.names("."), ["closed", "scene.xml", "tmp"]);
    assert!(shop.names("closed").is_empty());
}

/// Starts an endless render, removes the folder of an output after the first samples, and interrupts it.
fn without_folder_at_the_end(row: &Row, shop: &Workshop, more: &[&str]) {
    std::fs::create_dir(shop.path("gone")).expect("a temporary folder");
    let arguments = [&["render", "scene.xml", "-o", "gone/a.png"], &ENDLESS[..], more].concat();
    let mut running = Running::start(&mut shop.command(&[], &arguments));
    running.until_progress();
    std::fs::remove_dir_all(shop.path("gone")).expect("it is there");
    running.send("INT");
    row.holds(&running.end());
}

fn one_of_two_outputs_fails(row: &Row) {
    let shop = Workshop::new();
    without_folder_at_the_end(row, &shop, &["-o", "b.png"]);
    assert_eq!(picture(&shop.path("b.png")).dimensions(), (64, 48));
    assert!(shop.names("tmp").is_empty());
}

fn no_output_can_be_written(row: &Row) {
    let shop = Workshop::new();
    without_folder_at_the_end(row, &shop, &[]);
    assert_eq!(shop.kept_picture().dimensions(), (64, 48));
    assert_eq!(shop.names("."), ["scene.xml", "tmp"]);
}

fn disk_is_full(row: &Row) {
    let shop = Workshop::new();
    std::fs::create_dir(shop.path("full")).expect("a temporary folder");
    // The old file is copied back, for the mount ends with the program.
    let mount = "mount -t tmpfs -o size=8k none full && printf 'an older picture' > full/a.exr";
    let copy = "trap 'cp -a full seen' EXIT";
    let Some(mut before) = with_mounts(mount) else {
        return;
    };
    let script = before.last_mut().expect("it has words");
    *script = format!("{mount} && {copy}; \"$0\" \"$@\"");
    let before: Vec<&str> = before.iter().map(String::as_str).collect();
    row.holds(&shop.run(
        &before,
        &["render", "scene.xml", "-o", "full/a.exr", "--size", "120x90"],
    ));
    assert_eq!(shop.names("seen"), ["a.exr"]);
    assert_eq!(std::fs::read(shop.path("seen/a.exr")).expect("it was copied"), OLD);
    assert_eq!(shop.kept_picture().dimensions(), (120, 90));
}

/// With a limit for the length of files, beyond which a write is an error.
pub const SHORT_FILES: [&str; 4] = ["env", "--ignore-signal=XFSZ", "prlimit", "--fsize=4096"];

fn all_disks_are_full(row: &Row) {
    let shop = Workshop::new();
    shop.write("a.exr", OLD);
    row.holds(&shop.run(&SHORT_FILES, &["render", "scene.xml", "-o", "a.exr"]));
    assert_eq!(shop.names("."), ["a.exr", "scene.xml", "tmp"]);
    assert_eq!(std::fs::read(shop.path("a.exr")).expect("it is there"), OLD);
    assert!(shop.names("tmp").is_empty());
}

fn standard_output_is_full(row: &Row) {
    let shop = Workshop::new();
    let full = std::fs::File::options()
        .write(true)
        .open("/dev/full")
        .expect("Linux has it");
    let mut command = shop.command(&[], &["render", "scene.xml", "-o", "-"]);
    row.holds(&Running::start(command.stdout(full)).end());
    shop.kept_picture();
}

/// The writing end of a pipe that has no reader.
fn closed_pipe() -> Stdio {
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    writer.into()
}

fn picture_pipe_is_closed(row: &Row) {
    let shop = Workshop::new();
    let mut command = shop.command(&[], &["render", "scene.xml", "-o", "-"]);
    row.holds(&Running::start(command.stdout(closed_pipe())).end());
    shop.kept_picture();
}

fn figures_pipe_is_closed(row: &Row) {
    let shop = Workshop::new();
    let mut command = shop.command(&[], &["render", "scene.xml", "-o", "a.png", "--stats=json"]);
    let output = Running::start(command.stdout(closed_pipe())).end();
    row.holds(&output);
    assert!(!String::from_utf8_lossy(&output.stderr).contains("error"));
    picture(&shop.path("a.png"));
}

fn messages_pipe_is_closed(row: &Row) {
    let shop = Workshop::new();
    let mut command = shop.command(&[], &["render", "scene.xml", "-o", "a.png"]);
    row.holds(&command.stderr(closed_pipe()).output().expect("the program starts"));
    picture(&shop.path("a.png"));
}
