//! Bakes that are resumed after an interruption, and bakes that are put together from shares: all have the bits of a
//! bake in one go.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

use sunroom::bake::part::{read_header, read_part};

use crate::workshop::{Workshop, sunroom};

/// A room that is open to the sky, with a lamp and a block.
const SCENE: &str = r#"<scene version="3.0.0">
  <integrator type="path"><integer name="max_depth" value="4"/></integrator>
  <sensor type="perspective">
    <transform name="to_world"><lookat origin="0, 2, 5" target="0, 0.5, 0" up="0, 1, 0"/></transform>
  </sensor>
  <shape type="rectangle" id="floor">
    <transform name="to_world"><scale value="4"/><rotate x="1" angle="-90"/></transform>
    <bsdf type="diffuse"><rgb name="reflectance" value="0.8, 0.6, 0.4"/></bsdf>
  </shape>
  <shape type="cube" id="block">
    <transform name="to_world"><scale value="0.5"/><translate x="1" y="0.5"/></transform>
    <bsdf type="diffuse"><rgb name="reflectance" value="0.5, 0.5, 0.8"/></bsdf>
  </shape>
  <emitter type="point" id="bulb"><point name="position" x="-1" y="2" z="1"/><rgb name="intensity" value="3, 3, 3"/></emitter>
  <emitter type="constant"><rgb name="radiance" value="0.5, 0.6, 0.7"/></emitter>
</scene>
"#;

/// Two lightmaps, a reflection probe and a volume.
const SMALL: &[&str] = &[
    "--texels-per-unit",
    "5",
    "--atlas-size",
    "64",
    "--probe-size",
    "16",
    "--probe-spacing",
    "2",
];

fn shop() -> Workshop {
    shop_of(SCENE)
}

pub(super) fn shop_of(scene: &str) -> Workshop {
    let shop = Workshop::new();
    shop.scene(scene);
    shop
}

fn command(shop: &Workshop, arguments: &[&str]) -> Command {
    let mut command = sunroom();
    command.current_dir(shop.folder()).args(arguments);
    command
}

pub(super) fn bake(shop: &Workshop, output: &str, more: &[&str]) -> Output {
    let arguments = [&["bake", "scene.xml", "-o", output][..], SMALL, more].concat();
    command(shop, &arguments).output().expect("the program starts")
}

pub(super) fn merge(shop: &Workshop, output: &str, parts: &[&str], more: &[&str]) -> Output {
    let arguments = [&["merge", "-o", output][..], parts, more].concat();
    command(shop, &arguments).output().expect("the program starts")
}

/// The messages of a command that ends with this code.
#[track_caller]
pub(super) fn said(output: &Output, code: i32) -> String {
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{said}");
    said
}

pub(super) fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder)
        .expect("the folder")
        .map(|entry| entry.expect("an entry"));
    entries
        .map(|entry| {
            let name = entry.file_name().to_string_lossy().into_owned();
            (name, std::fs::read(entry.path()).expect("a file"))
        })
        .collect()
}

#[track_caller]
pub(super) fn same(shop: &Workshop, one: &str, other: &str) {
    let [one_files, other_files] = [one, other].map(|name| files(&shop.path(name)));
    assert!(
        one_files.keys().eq(other_files.keys()),
        "{one} and {other} have other files"
    );
    for (name, content) in &one_files {
        assert!(other_files[name] == *content, "{name} differs in {one} and {other}");
    }
}

#[test]
fn shares_make_the_bits_of_one_bake_on_any_number_of_threads() {
    let shop = shop();
    said(&bake(&shop, "one", &["--spp", "20", "--no-denoise", "-t", "1"]), 0);
    said(&bake(&shop, "three", &["--spp", "20", "--no-denoise", "-t", "3"]), 0);
    same(&shop, "one", "three");
    assert!(files(&shop.path("one")).len() >= 6, "lightmaps and probes");
    for (share, threads) in [("0..8", "1"), ("8..16", "3"), ("16..20", "2")] {
        said(
            &bake(&shop, &format!("{share}.bake"), &["--samples", share, "-t", threads]),
            0,
        );
    }
    let parts = ["16..20.bake", "0..8.bake", "8..16.bake"];
    said(&merge(&shop, "merged", &parts, &["--no-denoise"]), 0);
    same(&shop, "one", "merged");
    if cfg!(feature = "denoise") {
        said(&bake(&shop, "quiet", &["--spp", "20"]), 0);
        said(&merge(&shop, "merged-quiet", &parts, &[]), 0);
        same(&shop, "quiet", "merged-quiet");
        assert_ne!(files(&shop.path("quiet")), files(&shop.path("one")));
    }

    // What does not belong together, or is not all of it.
    let merges = |parts: &[&str]| said(&merge(&shop, "none", parts, &[]), 1);
    assert!(merges(&parts[..2]).contains("no share has samples 8..16"));
    assert!(merges(&["8..16.bake", "0..8.bake", "8..16.bake"]).contains("8..16.bake both have samples 8..16"));
    said(&bake(&shop, "other.bake", &["--samples", "8..16", "--seed", "7"]), 0);
    let message = merges(&["0..8.bake", "other.bake"]);
    assert!(message.contains("the seed is 7, and was 0"), "{message}");
    shop.write("text.bake", "SUNBAKE without a line feed");
    assert!(merges(&["0..8.bake", "text.bake"]).contains("text.bake: it is no checkpoint or share of a bake"));
    let mut bytes = std::fs::read(shop.path("8..16.bake")).expect("a share");
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    shop.write("damaged.bake", &bytes);
    assert!(merges(&["0..8.bake", "damaged.bake"]).contains("damaged.bake: it is damaged"));
    bytes[middle] ^= 1;
    shop.write("short.bake", &bytes[..middle]);
    assert!(merges(&["0..8.bake", "short.bake"]).contains("short.bake: it is damaged"));
    assert!(!shop.path("none").exists(), "nothing is left of a merge that fails");
    let message = said(&merge(&shop, "a", &parts, &["-o", "b"]), 2);
    assert!(message.contains("one folder"), "{message}");
    let of_pictures = [
        "--exposure=0",
        "--tonemap=clip",
        "--white=5000",
        "--exr-type=half",
        "--compression=zip",
        "--png-bits=8",
        "--jpeg-quality=95",
    ];
    for option in of_pictures {
        let message = said(&merge(&shop, "none", &parts, &[option]), 2);
        let name = option.split('=').next().expect("a name");
        assert!(message.contains(&format!("{name} is for pictures")), "{message}");
    }
}

#[test]
fn the_progress_of_a_share_tells_the_samples_that_it_has() {
    let shop = shop();
    let box_of_cornell = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell-box.xml");
    // One round, which many blocks of texels are through with while others wait.
    let options = [
        "--texels-per-unit",
        "20",
        "--no-probes",
        "--samples",
        "8..16",
        "-t",
        "1",
    ];
    let words = [&["bake", box_of_cornell, "-o", "share.bake"][..], &options].concat();
    let told = said(&command(&shop, &words).output().expect("the program starts"), 0);
    let lines: Vec<[u32; 2]> = told
        .lines()
        .filter_map(|line| {
            let (percent, rest) = line.split_once(" %  ")?;
            let (samples, _) = rest.split_once("/8 spp")?;
            Some([percent.trim(), samples].map(|number| number.parse().expect("a number")))
        })
        .collect();
    assert!(lines.len() > 1 && lines.ends_with(&[[100, 8]]), "{told}");
    for [percent, samples] in lines {
        assert!((8 * percent / 100).abs_diff(samples) <= 1, "{told}");
    }
}

#[test]
fn shares_that_cannot_be_are_refused() {
    let shop = shop();
    let fails = |more: &[&str], words: &str| {
        let message = said(&bake(&shop, "share.bake", more), 2);
        assert!(message.contains(words), "{message}");
    };
    fails(
        &["--samples", "3..8"],
        "a range cannot begin at 3: 2 and 4 are the nearest",
    );
    fails(&["--samples", "8..32", "--spp", "16"], "goes beyond --spp");
    fails(&["--samples", "0..8", "--time", "1s"], "--time");
    fails(&["--samples", "0..8", "--noise", "1%"], "--noise");
    fails(&["--every", "1s"], "--checkpoint");
    std::fs::create_dir(shop.path("folder")).expect("a folder");
    let message = said(&bake(&shop, "folder", &["--samples", "0..8"]), 2);
    assert!(
        message.contains("is a folder: a share of a bake is one file"),
        "{message}"
    );
}

#[test]
fn missing_last_shares_of_a_bake_are_told() {
    let shop = shop();
    for (name, samples) in [("a.bake", "0..1"), ("b.bake", "1..2")] {
        said(&bake(&shop, name, &["-q", "--samples", samples, "--spp", "2"]), 0);
    }
    let message = said(&merge(&shop, "half", &["a.bake"], &["--no-denoise"]), 0);
    let words = "warning: the parts have 1 of 2 samples per texel: those of samples 1..2 are missing";
    assert!(message.contains(words), "{message}");
    let message = said(&merge(&shop, "whole", &["a.bake", "b.bake"], &["--no-denoise"]), 0);
    assert!(!message.contains("warning"), "{message}");
}

#[test]
fn a_merged_level_never_replaces_a_share() {
    let shop = shop();
    said(&bake(&shop, "a.bake", &["-q", "--samples", "0..1"]), 0);
    std::fs::create_dir(shop.path("level")).expect("a folder");
    let share = std::fs::read(shop.path("a.bake")).expect("a share");
    for (name, output) in [
        ("a.bake", "a.bake"),
        ("level/level.glb", "level"),
        ("level/lightmap-0.png", "./level"),
    ] {
        shop.write(name, &share);
        let message = said(&merge(&shop, output, &[name], &["--no-denoise"]), 2);
        assert!(message.contains("this output is one of the parts"), "{message}");
        assert!(std::fs::read(shop.path(name)).expect("a share") == share, "{name}");
    }
    // A name of its own in the folder of the level is none of its files.
    std::fs::remove_dir_all(shop.path("level")).expect("removed");
    shop.write("level/a.bake", &share);
    said(&merge(&shop, "level", &["level/a.bake"], &["--no-denoise"]), 0);
    assert!(std::fs::read(shop.path("level/a.bake")).expect("a share") == share);
}

/// Starts a bake with checkpoints, and sends a signal when there is one in which the bake has begun.
#[cfg(unix)]
fn interrupted(shop: &Workshop, output: &str, checkpoint: &str, signal: &str, more: &[&str]) -> Output {
    interrupted_when(shop, [output, checkpoint], signal, more, Path::exists)
}

/// The same when the checkpoint is as it should be.
#[cfg(unix)]
fn interrupted_when(
    shop: &Workshop,
    [output, checkpoint]: [&str; 2],
    signal: &str,
    more: &[&str],
    is_far: impl Fn(&Path) -> bool,
) -> Output {
    let keeping = ["--checkpoint", checkpoint, "--every", "10ms"];
    let arguments = [&["bake", "scene.xml", "-o", output][..], SMALL, &keeping, more].concat();
    let mut command = command(shop, &arguments);
    let child = command.stderr(Stdio::piped()).spawn().expect("the program starts");
    let (begin, path) = (Instant::now(), shop.path(checkpoint));
    while !is_far(&path) {
        assert!(begin.elapsed() < Duration::from_secs(60), "no checkpoint");
        std::thread::sleep(Duration::from_millis(2));
    }
    let mut kill = Command::new("kill");
    kill.args(["-s", signal, &child.id().to_string()])
        .status()
        .expect("kill");
    child.wait_with_output().expect("it ends")
}

#[cfg(unix)]
#[test]
fn an_interrupted_bake_leaves_a_finished_level_as_it_was() {
    let shop = shop();
    said(&bake(&shop, "level", &["--spp", "16", "--no-denoise"]), 0);
    let files = || {
        let entries = std::fs::read_dir(shop.path("level")).expect("the folder");
        let paths = entries.map(|entry| entry.expect("an entry").path());
        let files: BTreeMap<_, _> = paths
            .map(|path| (path.clone(), std::fs::read(path).expect("a file")))
            .collect();
        files
    };
    let before = files();
    let has_samples = |path: &Path| read_part(path).is_ok_and(|(_, _, light)| light.lights[0].samples() > 0);
    let endless = ["--spp", "1000000", "--no-denoise"];
    let output = interrupted_when(&shop, ["level", "one.checkpoint"], "INT", &endless, has_samples);
    let message = said(&output, 130);
    let stays = "and 0 probes: level keeps its level, which has 16 samples per texel and 2 probes; one.checkpoint has what was gathered";
    assert!(message.contains(stays), "{message}");
    assert!(files() == before);
    // Where there is no level, what was gathered is one.
    let output = interrupted_when(&shop, ["other", "other.checkpoint"], "INT", &endless, has_samples);
    let message = said(&output, 130);
    assert!(
        message.contains("interrupted; the lightmaps in other have"),
        "{message}"
    );
    assert!(shop.path("other/lightmaps.json").is_file());
}

#[cfg(unix)]
#[test]
fn an_interrupted_bake_goes_on_to_the_same_bits() {
    let shop = shop();
    let samples = ["--spp", "300", "--no-denoise"];
    said(&bake(&shop, "whole", &samples), 0);
    let resumed = |name: &str, checkpoint: &str| {
        let header = read_header(&shop.path(checkpoint)).expect("a checkpoint");
        assert!(!header.is_finished && !header.is_share, "the signal came too late");
        let (_, _, light) = read_part(&shop.path(checkpoint)).expect("a checkpoint");
        assert!(light.lights[0].mean_samples() > 0.0, "a bake that has begun");
        let goes_on = [
            &samples[..],
            &["--resume", checkpoint, "--checkpoint", checkpoint, "-t", "3"],
        ]
        .concat();
        said(&bake(&shop, name, &goes_on), 0);
        same(&shop, "whole", name);
        assert!(read_header(&shop.path(checkpoint)).expect("a checkpoint").is_finished);
    };
    let output = interrupted(&shop, "killed", "killed.checkpoint", "KILL", &samples);
    assert_eq!(output.status.code(), None, "it was killed");
    resumed("killed", "killed.checkpoint");

    let output = interrupted(&shop, "stopped", "stopped.checkpoint", "INT", &samples);
    let message = said(&output, 130);
    assert!(
        message.contains("stopped.checkpoint has what was gathered"),
        "{message}"
    );
    resumed("stopped", "stopped.checkpoint");

    let output = interrupted(&shop, "terminated", "terminated.checkpoint", "TERM", &samples);
    let message = said(&output, 143);
    assert!(
        message.contains("terminated; terminated.checkpoint has what was gathered"),
        "{message}"
    );
    assert!(!shop.path("terminated").exists(), "no lightmap is written");
    resumed("terminated", "terminated.checkpoint");

    // The same command begins and goes on.
    let both = [
        "--checkpoint",
        "new.checkpoint",
        "--resume",
        "new.checkpoint",
        "--spp",
        "8",
        "--no-denoise",
    ];
    let message = said(&bake(&shop, "begun", &both), 0);
    assert!(
        message.contains("new.checkpoint does not exist yet: the bake is begun"),
        "{message}"
    );
    let more = [&both[..5], &["16", "--no-denoise"]].concat();
    said(&bake(&shop, "begun", &more), 0);
    said(&bake(&shop, "sixteen", &["--spp", "16", "--no-denoise"]), 0);
    same(&shop, "begun", "sixteen");
    let message = said(&bake(&shop, "begun", &both), 0);
    assert!(
        message.contains("has 16 samples per texel already, and 8 are asked for"),
        "{message}"
    );
}

#[cfg(unix)]
#[test]
fn an_interrupted_share_goes_on_to_the_same_bytes_of_light() {
    let shop = shop();
    let share = ["--samples", "16..256"];
    let output = interrupted(&shop, "a.bake", "share.checkpoint", "INT", &share);
    let message = said(&output, 130);
    assert!(
        message.contains("interrupted; a.bake has what was gathered"),
        "{message}"
    );
    said(&bake(&shop, "0.bake", &["--samples", "0..16"]), 0);
    let message = said(&merge(&shop, "none", &["0.bake", "a.bake"], &[]), 1);
    assert!(message.contains("a.bake is not finished"), "{message}");
    let message = said(
        &bake(
            &shop,
            "b.bake",
            &["--samples", "16..128", "--resume", "share.checkpoint"],
        ),
        1,
    );
    assert!(
        message.contains("another share of the bake: --samples 16..256"),
        "{message}"
    );
    // From the checkpoint, and from the unfinished share itself.
    said(
        &bake(
            &shop,
            "b.bake",
            &[&share[..], &["--resume", "share.checkpoint"]].concat(),
        ),
        0,
    );
    said(
        &bake(&shop, "a.bake", &[&share[..], &["--resume", "a.bake"]].concat()),
        0,
    );
    said(&bake(&shop, "whole", &["--spp", "256", "--no-denoise"]), 0);
    for part in ["a.bake", "b.bake"] {
        said(
            &merge(
                &shop,
                part.trim_end_matches(".bake"),
                &[part, "0.bake"],
                &["--no-denoise"],
            ),
            0,
        );
        same(&shop, "whole", part.trim_end_matches(".bake"));
    }
}

#[test]
fn a_foreign_or_damaged_checkpoint_is_told_from_ones_own() {
    let shop = shop();
    let keeping = ["--spp", "2", "--no-denoise", "--checkpoint", "c.checkpoint"];
    said(&bake(&shop, "level", &keeping), 0);
    let resumes = |more: &[&str]| {
        let arguments = [&["--spp", "4", "--no-denoise", "--resume", "c.checkpoint"][..], more].concat();
        said(&bake(&shop, "again", &arguments), 1)
    };
    let message = resumes(&["--seed", "3"]);
    assert!(
        message.contains("checkpoint of another bake: the seed is 3, and was 0"),
        "{message}"
    );
    let message = resumes(&["--indirect-only"]);
    assert!(message.contains("--indirect-only is true, and was false"), "{message}");
    shop.scene(&SCENE.replace("<scale value=\"4\"/>", "<scale value=\"3\"/>"));
    let message = resumes(&["--force"]);
    assert!(message.contains("its lightmaps and probes have"), "{message}");
    let whole = std::fs::read(shop.path("c.checkpoint")).expect("a checkpoint");
    shop.scene(&SCENE.replace("0.8, 0.6, 0.4", "0.8, 0.6, 0.5"));
    let message = resumes(&[]);
    assert!(message.contains("scene.xml has another content"), "{message}");
    let forced = ["--spp", "4", "--no-denoise", "--resume", "c.checkpoint", "--force"];
    assert!(said(&bake(&shop, "again", &forced), 0).contains("warning: c.checkpoint is a checkpoint of another bake"));
    shop.scene(SCENE);
    for (content, words) in [
        (&whole[..whole.len() - 1], "c.checkpoint: it is damaged"),
        (&whole[..9], "c.checkpoint: it is damaged"),
        (
            &b"a text"[..],
            "is no checkpoint or share of a bake, which begins with `SUNBAKE`",
        ),
        (
            &[&whole[..8], &[9, 0, 0, 0], &whole[12..]].concat(),
            "its format is 9, and this version reads 6",
        ),
    ] {
        shop.write("c.checkpoint", content);
        let message = resumes(&[]);
        assert!(message.contains(words), "{message}");
    }
    let message = said(&merge(&shop, "none", &["c.checkpoint"], &[]), 1);
    assert!(message.contains("its format is 9"), "{message}");
    shop.write("c.checkpoint", &whole);
    let message = said(&merge(&shop, "none", &["c.checkpoint"], &[]), 1);
    assert!(message.contains("c.checkpoint is a checkpoint: "), "{message}");
}

#[test]
fn shares_and_what_is_made_of_them_never_replace_files_of_the_scene() {
    let shop = shop();
    let refused = said(&bake(&shop, "scene.xml", &["--samples", "0..1"]), 1);
    assert!(refused.contains("the scene is made of this file"), "{refused}");
    assert_eq!(std::fs::read_to_string(shop.path("scene.xml")).expect("a file"), SCENE);

    said(&bake(&shop, "game", &["--spp", "1", "--no-denoise"]), 0);
    let before = files(&shop.path("game"));
    let share = [
        &["bake", "game/level.glb", "-o", "a.bake", "--samples", "0..1"][..],
        SMALL,
    ]
    .concat();
    said(&command(&shop, &share).output().expect("the program starts"), 0);
    let refused = said(&merge(&shop, "game", &["a.bake"], &["--no-denoise"]), 1);
    assert!(refused.contains("the scene is made of this file"), "{refused}");
    assert!(files(&shop.path("game")) == before);
}

#[test]
fn shares_of_other_seeds_are_merged_by_force_alone() {
    let shop = shop();
    for (name, samples, seed) in [("a.bake", "0..1", "1"), ("b.bake", "1..2", "2")] {
        said(&bake(&shop, name, &["--samples", samples, "--seed", seed]), 0);
    }
    let refused = said(&merge(&shop, "level", &["a.bake", "b.bake"], &["--no-denoise"]), 1);
    assert!(refused.contains("the seed"), "{refused}");
    said(
        &merge(&shop, "level", &["a.bake", "b.bake"], &["--no-denoise", "--force"]),
        0,
    );
}
