//! Bakes that are killed, and what they go on from.

use std::collections::BTreeMap;
use std::hash::{BuildHasher, RandomState};
use std::time::{Duration, Instant};

use sunroom::bake::part::{read_header, read_part};

use crate::killed::{KILLED, is_killed, make_old, temporary_file};
use crate::program::{OLD, Running, Workshop};
use crate::table::{Row, section};

section! { "Baking"
    bake_is_killed:
        "SIGKILL at any moment of a bake with `--checkpoint`.",
        "Nothing; the program is gone.",
        "The last checkpoint, which is whole, and of the level only whole files. `--resume` goes on from it to the bits of a bake without an interruption.";
    checkpoint_of_bake_is_half_written:
        "Killed while a checkpoint of a bake is written.",
        "Nothing; the program is gone.",
        "The checkpoint before it, from which the bake goes on as above, and a file `.sunroom-….part`. A later write into the folder removes that file when it is an hour old.";
    share_is_half_written:
        "Killed while a share of a bake is written.",
        "Nothing; the program is gone.",
        "The older file of that name and a file `.sunroom-….part`, removed as above.";
    checkpoint_of_bake_is_damaged:
        "A checkpoint of a bake is cut, or has other bytes.",
        "`error: c.bake: it is damaged: …`, exit code 1.",
        "The damaged checkpoint, and no level.";
}

/// A bake of some seconds, and its folder or file.
fn bake<'a>(output: &'a str, spp: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let bake = [
        "bake",
        "scene.xml",
        "-o",
        output,
        "--spp",
        spp,
        "--no-denoise",
        "--atlas-size",
        "64",
    ];
    [&bake[..], &["--probe-size", "16", "--probe-spacing", "10"], more].concat()
}

const KEEPING: [&str; 6] = ["--checkpoint", "c.bake", "--every", "10ms", "--resume", "c.bake"];

#[track_caller]
fn succeeds(shop: &Workshop, arguments: &[&str]) {
    let output = shop.run(&[], arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{said}");
}

/// The files of a folder but those that belonged to a write.
fn files(shop: &Workshop, folder: &str) -> BTreeMap<String, Vec<u8>> {
    let names = shop.path(folder).exists().then(|| shop.names(folder));
    let names = names
        .into_iter()
        .flatten()
        .filter(|name| !name.starts_with(".sunroom-"));
    names
        .map(|name| {
            let content = std::fs::read(shop.path(folder).join(&name)).expect("a file");
            (name, content)
        })
        .collect()
}

/// `tests/command_line/killing.rs` does it more often.
fn bake_is_killed(_: &Row) {
    const ROUNDS: u32 = 4;
    let shop = Workshop::new();
    let begin = Instant::now();
    succeeds(&shop, &bake("whole", "128", &[]));
    let time = begin.elapsed();
    let whole = files(&shop, "whole");
    assert!(whole.len() >= 6, "lightmaps and probes");
    for round in 0..ROUNDS {
        let _ = std::fs::remove_dir_all(shop.path("level"));
        let _ = std::fs::remove_file(shop.path("c.bake"));
        // Somewhere in each quarter of the time.
        let random = (RandomState::new().hash_one(round) >> 11) as f64 / (1u64 << 53) as f64;
        let after = time.mul_f64((f64::from(round) + random) / f64::from(ROUNDS));
        let arguments = bake("level", "128", &KEEPING);
        let running = Running::start(&mut shop.command(&[], &arguments));
        std::thread::sleep(after);
        drop(running);
        if shop.path("c.bake").exists() {
            read_part(&shop.path("c.bake")).unwrap_or_else(|error| panic!("killed after {after:?}: {error}"));
        }
        let left = files(&shop, "level");
        assert!(
            left.iter().all(|(name, content)| whole.get(name) == Some(content)),
            "{after:?}"
        );
        succeeds(&shop, &arguments);
        assert!(files(&shop, "level") == whole, "killed after {after:?}");
    }
}

fn checkpoint_of_bake_is_half_written(_: &Row) {
    let shop = Workshop::new();
    std::fs::create_dir(shop.path("kept")).expect("a temporary folder");
    let keeping = ["--checkpoint", "kept/c.bake", "--resume", "kept/c.bake"];
    succeeds(&shop, &bake("level", "4", &keeping));
    let before = std::fs::read(shop.path("kept/c.bake")).expect("a checkpoint");
    is_killed(&shop.run(&KILLED, &bake("level", "8", &keeping)));
    assert!(std::fs::read(shop.path("kept/c.bake")).expect("it is there") == before);
    make_old(&shop.path("kept").join(temporary_file(&shop, "kept")));
    succeeds(&shop, &bake("level", "8", &keeping));
    assert_eq!(shop.names("kept"), ["c.bake"]);
    succeeds(&shop, &bake("whole", "8", &[]));
    assert!(files(&shop, "level") == files(&shop, "whole"));
}

fn share_is_half_written(_: &Row) {
    let shop = Workshop::new();
    std::fs::create_dir(shop.path("out")).expect("a temporary folder");
    shop.write("out/a.bake", OLD);
    let share = [
        "bake",
        "scene.xml",
        "-o",
        "out/a.bake",
        "--samples",
        "0..1",
        "--atlas-size",
        "64",
        "--no-probes",
    ];
    is_killed(&shop.run(&KILLED, &share));
    assert_eq!(std::fs::read(shop.path("out/a.bake")).expect("it is there"), OLD);
    make_old(&shop.path("out").join(temporary_file(&shop, "out")));
    succeeds(&shop, &share);
    assert_eq!(shop.names("out"), ["a.bake"]);
    assert!(read_header(&shop.path("out/a.bake")).expect("a share").is_finished);
}

fn checkpoint_of_bake_is_damaged(row: &Row) {
    let shop = Workshop::new();
    succeeds(&shop, &bake("level", "2", &["--checkpoint", "c.bake"]));
    std::fs::remove_dir_all(shop.path("level")).expect("removed");
    let whole = std::fs::read(shop.path("c.bake")).expect("a checkpoint");
    let mut flipped = whole.clone();
    flipped[whole.len() / 3] ^= 4;
    for damaged in [&whole[..whole.len() / 2], &flipped] {
        shop.write("c.bake", damaged);
        let begin = Instant::now();
        row.holds(&shop.run(&[], &bake("level", "4", &["--resume", "c.bake"])));
        assert!(begin.elapsed() < Duration::from_secs(60));
        assert!(!shop.path("level").exists());
        assert!(std::fs::read(shop.path("c.bake")).expect("it is there") == damaged);
    }
}
