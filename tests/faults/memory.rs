//! Files and films that need more memory than the budget has: refused before the memory is taken.

use std::process::Command;

use sunroom::engine::{RenderFilm, RenderStatus};
use sunroom::scene::{SceneState, SceneStatus};

use crate::program::{Running, Workshop};
use crate::reloading::{Open, said};
use crate::table::{Row, section};

section! { "Memory"
    mesh_is_too_large:
        "`sunroom render` needs more memory for a mesh than `--memory` allows.",
        "`mesh …mesh.ply: … need … of memory, and the budget is 1.0 MB`, exit code 1.",
        "Nothing new.";
    picture_is_too_large:
        "`sunroom render` needs more memory for a picture than `--memory` allows.",
        "`picture …picture.png: 1000 x 1000 pixels need 3.0 MB of memory, and the budget is 1.0 MB`, exit code 1.",
        "Nothing new.";
    film_is_too_large:
        "`sunroom render` needs more memory for the film than `--memory` allows.",
        "`error: rendering broke off: a film of 1000 x 1000 pixels needs … of memory, and the budget is 1.0 MB`, exit code 1.",
        "Nothing new.";
    stack_is_too_small:
        "The system allows a small stack (`ulimit -s 256`).",
        "`error: the program may use 256 KiB of stack, and needs 1024 at least: …ulimit -s 1024… raises the limit`, exit code 1.",
        "Nothing new.";
    address_space_is_too_small:
        "The system allows a small address space (`ulimit -v`).",
        "`error: the program may use 500000 KiB of address space, and needs … at least: …ulimit -v … raises the limit`, exit code 1.",
        "Nothing new.";
    film_is_too_large_for_the_address_space:
        "`sunroom render` needs more memory for the film than the address space that the system allows has room for.",
        "`error: rendering broke off: a film of 2000 x 2000 pixels needs … of memory, and … budget`, exit code 1.",
        "Nothing new.";
    mesh_of_the_window_grows:
        "A mesh file of an open scene grows beyond the budget.",
        "`mesh …mesh.ply: … need … of memory`. The mesh stays as it was, and the file is read again when it is smaller.",
        "The larger file.";
    picture_of_the_window_grows:
        "A picture file of an open scene grows beyond the budget.",
        "`picture …picture.png: 1000 x 1000 pixels need 3.0 MB of memory`. The picture stays as it was, and the file is read again when it is \
         smaller.",
        "The larger file.";
    film_of_the_window_grows:
        "The file of an open scene asks for a film beyond the budget.",
        "`a film of 1000 x 1000 pixels needs … of memory`. The last rendered picture stays, and rendering goes on when the film is smaller.",
        "The changed file.";
}

/// Words that run a program with this address space in bytes.
fn with_space(bytes: u64) -> [String; 2] {
    ["prlimit".to_owned(), format!("--as={bytes}")]
}

fn stack_is_too_small(row: &Row) {
    let shop = Workshop::new();
    row.holds(&shop.run(&["prlimit", "--stack=262144"], &["render", "scene.xml", "-o", "a.png"]));
    assert_eq!(shop.names("."), ["scene.xml", "tmp"]);
}

fn address_space_is_too_small(row: &Row) {
    let shop = Workshop::new();
    let before = with_space(500_000 << 10);
    let before: Vec<&str> = before.iter().map(String::as_str).collect();
    row.holds(&shop.run(&before, &["render", "scene.xml", "-o", "a.png"]));
    assert_eq!(shop.names("."), ["scene.xml", "tmp"]);
}

fn film_is_too_large_for_the_address_space(row: &Row) {
    let shop = Workshop::new();
    let threads = std::thread::available_parallelism().map_or(1, |threads| threads.get() as u64);
    let before = with_space((1100 << 20) + threads * (16 << 20));
    let before: Vec<&str> = before.iter().map(String::as_str).collect();
    let render = [
        "render",
        "scene.xml",
        "-o",
        "a.exr",
        "--spp",
        "1",
        "--threads",
        "2",
        "-q",
    ];
    let large = [&render[..], &["--size", "2000x2000"]].concat();
    row.holds(&shop.run(&before, &large));
    assert_eq!(shop.names("."), ["scene.xml", "tmp"]);
    // What has room is rendered.
    assert_eq!(shop.run(&before, &render).status.code(), Some(0));
}

const BUDGET: &str = "1MB";
const TRIANGLES: usize = 20_000;

/// A mesh with all triangles at the same place, which takes more than the budget.
fn mesh() -> String {
    let mut mesh = format!(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face {TRIANGLES}\n\
         property list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n"
    );
    mesh += &"3 0 1 2\n".repeat(TRIANGLES);
    mesh
}

/// A picture of bytes, three times as large as the budget.
fn picture() -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let written = image::RgbImage::new(1000, 1000).write_to(&mut bytes, image::ImageFormat::Png);
    written.expect("memory can be written to");
    bytes.into_inner()
}

/// Renders a scene with this inside, which is refused.
fn is_refused(row: &Row, shop: &Workshop, content: &str, more: &[&str]) {
    shop.write(
        "scene.xml",
        format!(r#"<scene version="3.0.0"><sensor type="perspective"/><emitter type="constant"/>{content}</scene>"#),
    );
    let names = shop.names(".");
    let arguments = [&["render", "scene.xml", "-o", "a.png", "--memory", BUDGET], more].concat();
    row.holds(&shop.run(&[], &arguments));
    assert_eq!(shop.names("."), names);
    assert!(shop.names("tmp").is_empty());
}

fn mesh_is_too_large(row: &Row) {
    let shop = Workshop::new();
    shop.write("mesh.ply", mesh());
    let shape = r#"<shape type="ply"><string name="filename" value="mesh.ply"/></shape>"#;
    is_refused(row, &shop, shape, &[]);
}

fn picture_is_too_large(row: &Row) {
    let shop = Workshop::new();
    shop.write("picture.png", picture());
    let shape = r#"<shape type="sphere"><bsdf type="diffuse"><texture type="bitmap" name="reflectance">
        <string name="filename" value="picture.png"/></texture></bsdf></shape>"#;
    is_refused(row, &shop, shape, &[]);
}

fn film_is_too_large(row: &Row) {
    let shop = Workshop::new();
    is_refused(row, &shop, r#"<shape type="sphere"/>"#, &["--size", "1000x1000"]);
}

/// Runs [`child`] in a process of its own, for which the budget is small; it prints what the user sees.
fn in_an_open_scene(row: &Row, task: &str) {
    let mut command = Command::new(std::env::current_exe().expect("this test has a file"));
    command
        .args(["--exact", "memory::child", "--ignored", "--nocapture"])
        .env("SUNROOM_TEST_TASK", task)
        .env("SUNROOM_MEMORY", BUDGET)
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped());
    let output = Running::start(&mut command).end();
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.success(),
        "{said}{}",
        String::from_utf8_lossy(&output.stdout)
    );
    row.is_said_in(&said);
}

fn mesh_of_the_window_grows(row: &Row) {
    in_an_open_scene(row, "mesh");
}

fn picture_of_the_window_grows(row: &Row) {
    in_an_open_scene(row, "picture");
}

fn film_of_the_window_grows(row: &Row) {
    in_an_open_scene(row, "film");
}

fn meshes(status: &SceneStatus) -> String {
    said(&status.mesh_errors)
}

fn pictures(status: &SceneStatus) -> String {
    said(&status.damaged_pictures)
}

#[test]
#[ignore = "a task that the rows run in a process of its own"]
fn child() {
    let mut open = Open::new();
    let (index, content, said): (usize, Vec<u8>, fn(&SceneStatus) -> String) =
        match std::env::var("SUNROOM_TEST_TASK").as_deref() {
            Ok("mesh") => (1, mesh().into_bytes(), meshes),
            Ok("picture") => (2, picture(), pictures),
            Ok("film") => return film_grows(&mut open),
            task => panic!("{task:?} is no task"),
        };
    open.replace(index, &content);
    open.until("the message", |status| !said(status).is_empty());
    eprintln!("{}", said(open.status()));
    open.nothing_is_lost();
    open.is_read_again(index);
}

fn film_grows(open: &mut Open) {
    let size = |open: &Open| open.app.world().resource::<RenderFilm>().film.width();
    let errors = |open: &Open| open.app.world().resource::<RenderStatus>().errors.join("\n");
    open.until_app("the first picture", |open| size(open) > 0);
    let before = size(open);
    let scene = String::from_utf8(open.content[0].clone()).expect("text");
    let larger = scene.replace(r#"value="64""#, r#"value="1000""#);
    open.replace(0, larger.as_bytes());
    open.until_app("the message", |open| errors(open).contains("film"));
    eprintln!("{}", errors(open));
    assert_eq!(open.status().state, SceneState::Ready);
    assert_eq!(size(open), before);
    open.is_read_again(0);
    open.until_app("rendering goes on", |open| errors(open).is_empty());
}
