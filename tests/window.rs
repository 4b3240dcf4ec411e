//! Starts the real window in a virtual display with a software graphics driver, and looks at the picture it takes of
//! itself. Skipped, with a word, where Xvfb or Mesa's software Vulkan is not installed.
#![cfg(all(feature = "window", target_os = "linux"))]

mod window_support;

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use image::{Rgb, RgbImage};
use sunroom::render::image_io::exr::decode_exr;
use sunroom::render::layered_image::Attribute;
use window_support::{Display, Ended};

fn editor(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sunroom"));
    command
        .current_dir(env!("CARGO_MANIFEST_DIR"))
        .arg("edit")
        .args(arguments)
        .args(["--timeout", "9m"])
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .env_remove("DISPLAY")
        .env_remove("SUNROOM_CONFIG")
        .stdin(Stdio::null());
    command
}

/// Nothing here takes so long, however busy the machine is.
const HANG: Duration = Duration::from_secs(600);

/// Waits for the end, or kills it when it hangs.
fn outcome(command: &mut Command) -> Option<i32> {
    let mut running = Ended(command.spawn().expect("the program was built with this test"));
    let started = Instant::now();
    while started.elapsed() < HANG {
        if let Some(status) = running.0.try_wait().expect("a child can be waited for") {
            return status.code();
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    None
}

#[test]
fn without_a_display_it_says_so_and_names_the_way_out() {
    let output = editor(&["scenes/cornell-box.xml"])
        .output()
        .expect("the program was built with this test");
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(
        message.contains("display") && message.contains("sunroom render"),
        "{message}"
    );
}

#[test]
fn the_window_shows_the_scene_between_its_panels() {
    let Some(display) = Display::open() else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let shot = folder.path().join("window.png");
    let mut command = editor(&[
        "scenes/cornell-box.xml",
        "--screenshot",
        &shot.to_string_lossy(),
        "--after-spp",
        "4",
        "--exit",
    ]);
    display.show(&mut command, folder.path());
    assert_eq!(outcome(&mut command), Some(0));
    check(&shot);
}

/// Thirty edits from an empty scene on, undone and redone: the file is the same to the byte, the picture to the bit,
/// and the command line renders the same room.
#[test]
fn a_room_is_built_undone_and_redone() {
    let Some(display) = Display::open() else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let file = |name: &str| folder.path().join(name).to_string_lossy().into_owned();
    let room = include_str!("scripts/room.txt");
    let ending = format!(
        "save-to {0}\nwait 8\nsave-image-to {1}\ngo-to 0\nscreenshot {4}\ngo-to 1000\nwait 8\nsave-image-to {2}\nsave-to {3}\n\
         samples 100\nwait 5\nsave-image-to {5}\nwait 20\nmove ball 0,1,0\nundo\nwait 5\nsave-image-to {6}\n\
         wait 8\nmove ball 0,1,0\nundo\nsave-image-to {7}\n",
        file("before.xml"),
        file("before.exr"),
        file("after.exr"),
        file("after.xml"),
        file("undone.png"),
        file("five.exr"),
        file("five-again.exr"),
        file("without-wait.exr"),
    );
    std::fs::write(file("script.txt"), format!("{room}\n{ending}")).expect("a script");
    let mut command = editor(&["scenes/cornell-box.xml", "--script", &file("script.txt"), "--exit"]);
    display.show(&mut command, folder.path());
    assert_eq!(outcome(&mut command), Some(0));

    let bytes = |name: &str| std::fs::read(file(name)).expect(name);
    let (before, after) = (bytes("before.xml"), bytes("after.xml"));
    assert!(
        before.len() > 2000 && before == after,
        "the file is another after undo and redo"
    );
    assert!(bytes("before.exr") == bytes("after.exr"), "the picture is another");
    // Whatever was rendered before, and whether the target is more or less.
    assert!(
        bytes("five.exr") == bytes("five-again.exr"),
        "not the same five samples"
    );
    assert!(bytes("five.exr") != bytes("before.exr"), "five samples are not eight");
    // A picture that was begun anew since is waited for before it is saved. It says that it is of another file.
    let layered = |name: &str| decode_exr(&bytes(name)).expect(name);
    assert!(
        layered("without-wait.exr").channels == layered("before.exr").channels,
        "not the eight samples that were waited for"
    );
    for (name, scene, samples) in [("before.exr", "before.xml", 8), ("five.exr", "after.xml", 5)] {
        let described = layered(name);
        assert_eq!(
            described.attribute("sunroom:scene"),
            Some(&Attribute::Text(file(scene)))
        );
        assert_eq!(described.attribute("sunroom:spp"), Some(&Attribute::Int(samples)));
    }

    let mut command = Command::new(env!("CARGO_BIN_EXE_sunroom"));
    command.args(["render", &file("after.xml"), "-o", &file("rendered.exr"), "--spp", "8"]);
    assert_eq!(outcome(&mut command), Some(0));
    let picture = |name: &str| image::open(file(name)).expect(name).to_rgb32f();
    let (shown, rendered) = (picture("after.exr"), picture("rendered.exr"));
    assert_eq!(shown.dimensions(), (160, 120));
    let mean = |picture: &image::Rgb32FImage| {
        picture.as_raw().iter().map(|value| f64::from(*value)).sum::<f64>() / picture.as_raw().len() as f64
    };
    // Rotations are written as axis and angle, which moves single rays by an ulp; such a ray may hit something else.
    let apart = (mean(&shown) / mean(&rendered) - 1.0).abs();
    assert!(apart < 0.01, "the means differ by {apart}");
    let same = shown.pixels().zip(rendered.pixels());
    let same = same.filter(|(a, b)| a.0.iter().zip(&b.0).all(|(a, b)| (a - b).abs() <= 1e-2 * (a + b)));
    let same = same.count() as f64 / (160.0 * 120.0);
    assert!(same > 0.9, "only {same} of the pixels are the same");
}

/// Panels are at least this wide, menus and the status line this high, at the default size of the window.
const LEFT: u32 = 210;
const RIGHT: u32 = 300;
const BAR: u32 = 22;

fn check(shot: &Path) {
    let window = image::open(shot).expect("a PNG").to_rgb8();
    assert_eq!(window.dimensions(), (1280, 720));
    let area =
        |x: u32, y: u32, width: u32, height: u32| image::imageops::crop_imm(&window, x, y, width, height).to_image();
    let parts = [
        ("menus", area(0, 0, LEFT, BAR)),
        ("outliner", area(0, 2 * BAR, LEFT, 600)),
        ("properties", area(1280 - RIGHT + 20, BAR, RIGHT - 20, 600)),
        ("status line", area(0, 720 - BAR, 640, BAR)),
    ];
    for (name, part) in &parts {
        let text = share(part, |[r, g, b]| r.min(g).min(b) > 140);
        let background = share(part, |[r, g, b]| r.max(g).max(b) < 60);
        assert!(text > 0.002, "{name}: no text, {text}");
        assert!(background > 0.5, "{name}: no panel, {background}");
    }
    let picture = area(LEFT + 60, BAR + 40, 1280 - LEFT - RIGHT - 120, 720 - 2 * BAR - 80);
    let lit = share(&picture, |[r, g, b]| u32::from(r) + u32::from(g) + u32::from(b) > 150);
    let red = share(&picture, |[r, g, b]| r > 60 && u32::from(r) > 2 * u32::from(g.max(b)));
    let green = share(&picture, |[r, g, b]| {
        g > 40 && 10 * u32::from(g) > 16 * u32::from(r.max(b))
    });
    assert!(lit > 0.3, "the picture is dark: {lit}");
    assert!(red > 0.02, "no red wall: {red}");
    assert!(green > 0.02, "no green wall: {green}");
}

/// The share of pixels that are so.
fn share(image: &RgbImage, is_so: impl Fn([u8; 3]) -> bool) -> f32 {
    let count = image.pixels().filter(|Rgb(pixel)| is_so(*pixel)).count();
    count as f32 / image.pixels().len() as f32
}
