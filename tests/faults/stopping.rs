//! `sunroom render` that is stopped: by its time limit, by signals, by sudden death.

use std::process::Output;

use crate::program::{OLD, Running, SCENE, Workshop, picture};
use crate::table::{Row, section};

section! { "Stopping a render"
    interrupt:
        "SIGINT (Ctrl+C) after the first samples.",
        "`interrupted; the picture has … samples per pixel and is in a.png`, exit code 130.",
        "The picture with the samples so far.";
    termination:
        "SIGTERM after the first samples.",
        "`interrupted; the picture has … samples per pixel and is in a.png`, exit code 130.",
        "The picture with the samples so far.";
    hang_up:
        "SIGHUP after the first samples, such as a terminal that is closed.",
        "`interrupted; the picture has … samples per pixel and is in a.png`, exit code 130.",
        "The picture with the samples so far.";
    hang_up_under_nohup:
        "SIGHUP while `nohup` has it ignored.",
        "No message about it, exit code 0.",
        "The whole picture.";
    interrupt_before_the_first_sample:
        "SIGINT before any pixel has a sample.",
        "`error: interrupted; no pixel has a sample yet, and nothing is written`, exit code 1.",
        "The older file of that name.";
    interrupt_of_some_pixels:
        "SIGINT while only some pixels have a sample.",
        "`error: interrupted; … of … pixels have no sample and are black`, exit code 1.",
        "The picture; pixels without a sample are black.";
    time_for_some_pixels:
        "`--time` is over while only some pixels have a sample.",
        "`error: the time was up; … of … pixels have no sample and are black`, exit code 1.",
        "The picture; pixels without a sample are black.";
    time_for_no_pixel:
        "`--time` is over before any pixel has a sample.",
        "`error: the time was up; no pixel has a sample yet, and nothing is written`, exit code 1.",
        "The older file of that name.";
    killed:
        "SIGKILL after the first samples.",
        "Nothing; the program is gone.",
        "The older file of that name and nothing else.";
}

/// Starts an endless render, which is to replace an older file.
fn start(shop: &Workshop, scene: &str, before: &[&str], more: &[&str]) -> Running {
    shop.write("scene.xml", scene);
    shop.write("a.png", OLD);
    let arguments = [&["render", "scene.xml", "-o", "a.png", "--spp", "100000000"], more].concat();
    Running::start(&mut shop.command(before, &arguments))
}

fn old_file_is_there(shop: &Workshop) {
    assert_eq!(std::fs::read(shop.path("a.png")).expect("it is there"), OLD);
    nothing_else_is_left(shop);
}

fn nothing_else_is_left(shop: &Workshop) {
    assert_eq!(shop.names("."), ["a.png", "scene.xml", "tmp"]);
    assert!(shop.names("tmp").is_empty());
}

fn stopped_by(row: &Row, signal: &str) {
    let shop = Workshop::new();
    // The test itself may run where some signals are ignored.
    let mut running = start(&shop, SCENE, &["env", "--default-signal"], &[]);
    running.until_progress();
    running.send(signal);
    row.holds(&running.end());
    assert_eq!(picture(&shop.path("a.png")).dimensions(), (64, 48));
    nothing_else_is_left(&shop);
}

fn interrupt(row: &Row) {
    stopped_by(row, "INT");
}

fn termination(row: &Row) {
    stopped_by(row, "TERM");
}

fn hang_up(row: &Row) {
    stopped_by(row, "HUP");
}

fn hang_up_under_nohup(row: &Row) {
    let shop = Workshop::new();
    let mut running = start(&shop, SCENE, &["env", "--ignore-signal=HUP"], &["--time", "3s"]);
    running.until_progress();
    running.send("HUP");
    let output = running.end();
    row.holds(&output);
    assert!(!String::from_utf8_lossy(&output.stderr).contains("interrupted"));
    picture(&shop.path("a.png"));
    nothing_else_is_left(&shop);
}

/// So many spheres one within the other, at which light does not change.
fn nothing(count: u32) -> String {
    let sphere = |number: u32| {
        let radius = 1.0 + 3.0 * f64::from(number) / f64::from(count);
        format!(r#"<shape type="sphere"><float name="radius" value="{radius}"/><bsdf type="null"/></shape>"#)
    };
    (0..count).map(sphere).collect()
}

/// In a white box without a way out paths end by Russian roulette alone, which begins late and waits at the many
/// surfaces that are nothing: a tile takes a thread seconds. `inside`: more shapes.
fn white_box(inside: &str) -> String {
    let nothing = nothing(100);
    format!(
        r#"<scene version="3.0.0">
  <integrator type="path"><integer name="max_depth" value="2000000"/><integer name="rr_depth" value="2000000"/></integrator>
  <sensor type="perspective">
    <film type="hdrfilm"><integer name="width" value="256"/><integer name="height" value="256"/></film>
  </sensor>
  <shape type="cube"><transform name="to_world"><scale value="5"/></transform>
    <bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="1"/></bsdf></bsdf></shape>
  <emitter type="constant"/>
  {nothing}
  {inside}
</scene>"#
    )
}

/// A small lamp before the camera, so that paths end soon in the middle of the picture, where rendering begins.
const LAMP: &str = r#"<shape type="rectangle"><transform name="to_world"><scale value="0.08"/><rotate y="1" angle="180"/>
    <translate z="0.5"/></transform><bsdf type="diffuse"><rgb name="reflectance" value="0"/></bsdf>
    <emitter type="area"><rgb name="radiance" value="1"/></emitter></shape>"#;

/// The picture of [`LAMP`], with pixels that have no sample.
fn assert_partial(shop: &Workshop) {
    let picture = picture(&shop.path("a.png"));
    assert!(
        picture.get_pixel(128, 128).0[0] > 0.5,
        "{:?}",
        picture.get_pixel(128, 128)
    );
    assert_eq!(picture.get_pixel(0, 0).0, [0.0; 3]);
    nothing_else_is_left(shop);
}

fn interrupt_before_the_first_sample(row: &Row) {
    let shop = Workshop::new();
    let running = start(&shop, &white_box(""), &[], &["--threads", "1"]);
    running.until_rendering();
    running.send("INT");
    row.holds(&running.end());
    old_file_is_there(&shop);
}

fn interrupt_of_some_pixels(row: &Row) {
    let shop = Workshop::new();
    let mut running = start(&shop, &white_box(LAMP), &[], &["--threads", "1", "--time", "20s"]);
    // A tenth of the time is over, which the tiles in the middle do not need.
    running.until_progress();
    running.send("INT");
    row.holds(&running.end());
    assert_partial(&shop);
}

fn timed(row: &Row, inside: &str, time: &str) -> Workshop {
    let shop = Workshop::new();
    let output: Output = start(&shop, &white_box(inside), &[], &["--threads", "1", "--time", time]).end();
    row.holds(&output);
    shop
}

fn time_for_some_pixels(row: &Row) {
    assert_partial(&timed(row, LAMP, "2s"));
}

fn time_for_no_pixel(row: &Row) {
    // A tile takes seconds, since each step of a path is tried against all of this.
    old_file_is_there(&timed(row, &nothing(3000), "0.01s"));
}

fn killed(row: &Row) {
    let shop = Workshop::new();
    let mut running = start(&shop, SCENE, &[], &[]);
    running.until_progress();
    running.send("KILL");
    let output = running.end();
    assert_eq!(output.status.code(), None);
    assert!(row.seen.starts_with("Nothing"));
    old_file_is_there(&shop);
}
