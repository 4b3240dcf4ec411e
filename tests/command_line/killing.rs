//! Renders, bakes and merges that are killed at random moments, each of them twenty times: `cargo test --release --test
//! command_line killing -- --ignored --nocapture` prints the figures. It takes some minutes.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::hash::{BuildHasher, RandomState};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use sunroom::bake::part::read_part;

use crate::workshop::{Workshop, sunroom};

const SCENE: &str = r#"<scene version="3.0.0">
  <sensor type="perspective">
    <transform name="to_world"><lookat origin="0, 2, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="80"/><integer name="height" value="60"/></film>
  </sensor>
  <shape type="sphere"><bsdf type="roughconductor"><float name="alpha" value="0.2"/></bsdf></shape>
  <shape type="rectangle"><transform name="to_world"><scale value="4"/><rotate x="1" angle="-90"/><translate y="-1"/></transform></shape>
  <emitter type="constant"/>
</scene>
"#;

const ROUNDS: u32 = 20;

fn command(shop: &Workshop, arguments: &[&str]) -> Command {
    let mut command = sunroom();
    command
        .current_dir(shop.folder())
        .args(arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    command
}

/// Runs the command and returns how long it took.
#[track_caller]
fn succeeds(shop: &Workshop, arguments: &[&str]) -> Duration {
    let begin = Instant::now();
    let status = command(shop, arguments).status().expect("the program starts");
    assert!(status.success(), "{arguments:?}");
    begin.elapsed()
}

/// Kills the command after a random part of this time, and returns that part; None if it had come to its end.
fn kill(shop: &Workshop, arguments: &[&str], within: Duration) -> Option<Duration> {
    let random = RandomState::new().hash_one(arguments);
    let after = within.mul_f64((random >> 11) as f64 / (1u64 << 53) as f64);
    let mut child = command(shop, arguments).spawn().expect("the program starts");
    std::thread::sleep(after);
    child.kill().expect("it was started");
    let status = child.wait().expect("it was started");
    status.code().is_none().then_some(after)
}

fn content(shop: &Workshop, name: &str) -> Option<Vec<u8>> {
    std::fs::read(shop.path(name)).ok()
}

#[test]
#[ignore = "it takes some minutes"]
fn renders_killed_at_random_moments_go_on_to_the_same_bits() {
    let shop = Workshop::new();
    shop.scene(SCENE);
    let kinds: [&[&str]; 4] = [
        &["--spp", "512", "--aov", "variance,normal"],
        &["--spp", "512", "--adaptive", "--aov", "samples"],
        &["--noise", "1%"],
        &["--noise", "1%", "--adaptive"],
    ];
    for kind in kinds {
        let time = succeeds(&shop, &[&["render", "scene.xml", "-o", "whole.exr"][..], kind].concat());
        let whole = content(&shop, "whole.exr");
        let checkpoints = ["--checkpoint", "c.exr", "--every", "20ms", "--resume", "c.exr"];
        let resumed = [&["render", "scene.xml", "-o", "a.exr"][..], &checkpoints[..], kind].concat();
        let (mut killed, mut moments, mut taken_up, mut tries) = (0, Vec::new(), 0, 0);
        while killed < ROUNDS {
            tries += 1;
            assert!(tries < 10 * ROUNDS, "renders end before they are killed");
            for name in ["a.exr", "c.exr"] {
                let _ = std::fs::remove_file(shop.path(name));
            }
            let Some(moment) = kill(&shop, &resumed, time) else {
                continue;
            };
            killed += 1;
            moments.push(moment.as_millis());
            taken_up += u32::from(shop.path("c.exr").exists());
            succeeds(&shop, &resumed);
            assert!(content(&shop, "a.exr") == whole, "{kind:?}, killed after {moment:?}");
        }
        moments.sort_unstable();
        println!(
            "{kind:?}: one run {} ms; {killed} killed after {moments:?} ms, {taken_up} of them with a checkpoint; all have the same bytes",
            time.as_millis()
        );
    }
}

/// The files of a folder but those that belonged to a write.
fn folder(shop: &Workshop, name: &str) -> BTreeMap<OsString, Vec<u8>> {
    let entries = std::fs::read_dir(shop.path(name)).into_iter().flatten().flatten();
    entries
        .filter(|entry| !entry.file_name().to_string_lossy().starts_with(".sunroom-"))
        .map(|entry| (entry.file_name(), std::fs::read(entry.path()).expect("a file")))
        .collect()
}

/// Lightmaps, probes and a share, with a checkpoint every few milliseconds.
#[test]
#[ignore = "it takes some minutes"]
fn bakes_killed_at_random_moments_go_on_to_the_same_bits() {
    let shop = Workshop::new();
    shop.scene(SCENE);
    let small = [
        "--atlas-size",
        "128",
        "--probe-size",
        "16",
        "--probe-spacing",
        "2",
        "--threads",
        "2",
    ];
    let keeping = ["--checkpoint", "c.bake", "--every", "20ms", "--resume", "c.bake"];
    let kinds: [&[&str]; 2] = [&["--spp", "256", "--no-denoise"], &["--samples", "16..256"]];
    for kind in kinds {
        let is_share = kind[0] == "--samples";
        let bake = |output| [&["bake", "scene.xml", "-o", output][..], &small, kind].concat();
        let time = succeeds(&shop, &bake("whole"));
        // A share has the time that it took: its light counts.
        let light = |name: &str| read_part(&shop.path(name)).expect("it is whole").2.lights;
        let resumed = [&bake("a")[..], &keeping].concat();
        let (mut killed, mut moments, mut taken_up, mut tries) = (0, Vec::new(), 0, 0);
        while killed < ROUNDS {
            tries += 1;
            assert!(tries < 10 * ROUNDS, "bakes end before they are killed");
            for name in ["a", "c.bake"] {
                let _ = std::fs::remove_file(shop.path(name));
            }
            let _ = std::fs::remove_dir_all(shop.path("a"));
            let Some(moment) = kill(&shop, &resumed, time) else {
                continue;
            };
            killed += 1;
            moments.push(moment.as_millis());
            if shop.path("c.bake").exists() {
                taken_up += 1;
                light("c.bake");
            }
            let left = folder(&shop, "a");
            let whole = folder(&shop, "whole");
            assert!(left.iter().all(|(name, content)| whole.get(name) == Some(content)));
            succeeds(&shop, &resumed);
            match is_share {
                true => assert!(light("a") == light("whole"), "{kind:?}, killed after {moment:?}"),
                false => assert!(folder(&shop, "a") == whole, "{kind:?}, killed after {moment:?}"),
            }
        }
        let _ = std::fs::remove_dir_all(shop.path("whole"));
        moments.sort_unstable();
        println!(
            "bake {kind:?}: one run {} ms; {killed} killed after {moments:?} ms, {taken_up} of them with a checkpoint; all have the same bits",
            time.as_millis()
        );
    }
}

#[test]
#[ignore = "it takes some minutes"]
fn killed_merges_leave_nothing_half_written() {
    let shop = Workshop::new();
    shop.scene(&SCENE.replace("\"80\"", "\"800\"").replace("\"60\"", "\"600\""));
    let ranges = ["0..2", "2..4", "4..8", "8..16"];
    let names: Vec<String> = (0..ranges.len()).map(|part| format!("part{part}.exr")).collect();
    for (name, range) in names.iter().zip(ranges) {
        succeeds(&shop, &["render", "scene.xml", "-o", name, "--samples", range]);
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let merge = |output| [&["merge", "-o", output][..], &names].concat();
    let time = succeeds(&shop, &merge("whole.exr"));
    let whole = content(&shop, "whole.exr");
    let parts: Vec<_> = names.iter().map(|name| content(&shop, name)).collect();
    let (mut killed, mut moments, mut written, mut tries) = (0, Vec::new(), 0, 0);
    while killed < ROUNDS {
        tries += 1;
        assert!(tries < 10 * ROUNDS, "merges end before they are killed");
        let _ = std::fs::remove_file(shop.path("a.exr"));
        let Some(moment) = kill(&shop, &merge("a.exr"), time) else {
            continue;
        };
        killed += 1;
        moments.push(moment.as_millis());
        let left = content(&shop, "a.exr");
        written += u32::from(left.is_some());
        assert!(left.is_none() || left == whole, "killed after {moment:?}");
        succeeds(&shop, &merge("a.exr"));
        assert!(content(&shop, "a.exr") == whole, "killed after {moment:?}");
        assert!(names.iter().map(|name| content(&shop, name)).eq(parts.iter().cloned()));
    }
    moments.sort_unstable();
    println!(
        "one merge {} ms; {killed} killed after {moments:?} ms, {written} had written the picture; all have the same bytes",
        time.as_millis()
    );
}
