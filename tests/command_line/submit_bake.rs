//! `sunroom submit --bake`: a bake that is shared out, and its scripts as a farm would start them.

use std::path::Path;
use std::process::{Command, Output};

use crate::workshop::{Workshop, sunroom};

const SCENE: &str = r#"<scene version="3.0.0">
  <default name="height" value="3"/>
  <integrator type="path"><integer name="max_depth" value="3"/></integrator>
  <shape type="ply" id="floor"><string name="filename" value="../meshes/floor.ply"/></shape>
  <emitter type="point"><point name="position" x="0" y="0" z="$height"/></emitter>
  <emitter type="constant"><rgb name="radiance" value="0.5, 0.6, 0.7"/></emitter>
</scene>
"#;

const FLOOR: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
    property list uchar int vertex_indices\nend_header\n-1 -1 0\n1 -1 0\n0 1 0\n3 0 1 2\n";

const LEVEL: &str = "scenes/the level.xml";
/// A lightmap, a reflection probe and a volume.
const SMALL: [&str; 6] = ["--atlas-size", "32", "--probe-size", "16", "--probe-spacing", "1"];
const JOB: [&str; 8] = ["submit", LEVEL, "--bake", "--to", "slurm", "-o", "job", "--no-denoise"];

fn shop() -> Workshop {
    let shop = Workshop::new();
    shop.write(LEVEL, SCENE);
    shop.write("meshes/floor.ply", FLOOR);
    shop
}

fn run(shop: &Workshop, arguments: &[&[&str]]) -> Output {
    let mut command = sunroom();
    command.current_dir(shop.folder()).args(arguments.concat());
    command.output().expect("the program starts")
}

#[track_caller]
fn succeeds(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[track_caller]
fn refused(shop: &Workshop, arguments: &[&[&str]], words: &str) {
    let output = run(shop, arguments);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(2) && said.contains(words), "{said}");
}

#[cfg(unix)]
fn script(shop: &Workshop, name: &str, arguments: &[&str]) -> Command {
    let mut command = Command::new(shop.path("job").join(name));
    command.args(arguments).env("SUNROOM", env!("CARGO_BIN_EXE_sunroom"));
    command
}

#[track_caller]
fn same(one: &Path, other: &Path) {
    let names = |folder: &Path| {
        let entries = std::fs::read_dir(folder).expect("a folder");
        let mut names: Vec<_> = entries.map(|entry| entry.expect("an entry").file_name()).collect();
        names.sort();
        names
    };
    assert_eq!(names(one), names(other));
    assert!(names(one).len() >= 7, "a level with lightmaps and probes");
    for name in names(one) {
        let read = |folder: &Path| std::fs::read(folder.join(&name)).expect("a file");
        assert!(read(one) == read(other), "{name:?} differs");
    }
}

#[cfg(unix)]
#[test]
fn the_tasks_of_a_job_make_the_files_of_one_bake() {
    let shop = shop();
    let options = [&SMALL[..], &["--seed", "5"]].concat();
    let shares = ["--shares", "4", "--spp", "20", "-D", "height=2"];
    let text = succeeds(&run(&shop, &[&JOB, &shares, &["--"], &options]));
    assert!(
        text.contains("4 tasks: a bake in 4 ranges of its 20 samples per texel"),
        "{text}"
    );
    // The original is not needed any more.
    std::fs::rename(shop.path("meshes"), shop.path("elsewhere")).expect("renamed");
    // Two machines.
    let work = |tasks: [&str; 3], threads: &'static str| {
        for task in tasks {
            succeeds(
                &script(&shop, "task", &[task, "--threads", threads])
                    .output()
                    .expect("bash"),
            );
        }
    };
    std::thread::scope(|machines| {
        machines.spawn(|| work(["3", "0", "3"], "1"));
        work(["1", "2", "2"], "2");
    });
    let parts = std::fs::read_dir(shop.path("job/parts")).expect("a folder");
    assert_eq!(parts.count(), 4, "shares, and nothing beside them");
    succeeds(&script(&shop, "merge", &["0"]).output().expect("bash"));
    std::fs::rename(shop.path("elsewhere"), shop.path("meshes")).expect("renamed");
    let whole = [
        "bake",
        LEVEL,
        "-o",
        "whole",
        "--spp",
        "20",
        "--no-denoise",
        "-D",
        "height=2",
    ];
    succeeds(&run(&shop, &[&whole, &options]));
    same(&shop.path("job/levels/the_level"), &shop.path("whole"));
}

/// What Ctrl+C leaves of a task is no finished part.
#[cfg(unix)]
#[test]
fn an_interrupted_task_goes_on() {
    use std::os::unix::process::CommandExt;
    use std::process::Stdio;
    use std::time::{Duration, Instant};

    let shop = shop();
    let job = [&JOB[..], &["--shares", "1", "--spp", "2000", "--"]].concat();
    succeeds(&run(&shop, &[&job, &SMALL, &["--every", "10ms"]]));
    let mut task = script(&shop, "task", &["0"]);
    // A group of its own, as the terminal makes for what it stops together.
    let mut task = task.process_group(0).stderr(Stdio::null()).spawn().expect("bash");
    let begin = Instant::now();
    let parts = shop.path("job/parts");
    while !parts.join("0000-0000-00000000.checkpoint").exists() {
        assert!(begin.elapsed() < Duration::from_secs(60), "no checkpoint");
        std::thread::sleep(Duration::from_millis(5));
    }
    let mut kill = Command::new("kill");
    kill.args(["-s", "INT", "--", &format!("-{}", task.id())])
        .status()
        .expect("kill");
    assert!(!task.wait().expect("it ends").success());
    assert!(parts.join("0000-0000-00000000-begun.bake").exists(), "what it had");
    let merged = script(&shop, "merge", &["0"]).output().expect("bash");
    assert!(!merged.status.success(), "there is no share yet");
    succeeds(&script(&shop, "task", &["0"]).output().expect("bash"));
    succeeds(&script(&shop, "merge", &["0"]).output().expect("bash"));
    let whole = ["bake", LEVEL, "-o", "whole", "--spp", "2000", "--no-denoise"];
    succeeds(&run(&shop, &[&whole, &SMALL]));
    same(&shop.path("job/levels/the_level"), &shop.path("whole"));
}

#[test]
fn a_bake_is_measured_and_divided() {
    let shop = shop();
    let short = succeeds(&run(&shop, &[&JOB, &["--dry-run", "--"], &SMALL]));
    assert!(
        short.contains("1 task: a bake in 1 range of its 64 samples per texel"),
        "{short}"
    );
    let long = ["--dry-run", "--spp", "100000000", "--task-time", "1s", "--", "--quiet"];
    let long = succeeds(&run(&shop, &[&JOB, &long, &SMALL]));
    let tasks: u32 = long
        .lines()
        .last()
        .and_then(|line| line.split(' ').next()?.parse().ok())
        .expect("the number of tasks");
    assert!(tasks > 10, "{long}");
    assert!(!shop.path("job").exists());
}

#[test]
fn what_cannot_be_a_job_of_a_bake_is_refused() {
    let shop = shop();
    let job = [&JOB[..], &["--shares", "2", "--dry-run"]].concat();
    for (options, words) in [
        (&["--time", "1s"][..], "--time"),
        (&["--noise", "1%"], "--noise"),
        (&["--spp", "8"], "--spp"),
        (&["-o", "level"], "--output"),
        (&["--no-denoise"], "--no-denoise"),
        (&["--width", "64"], "--width"),
    ] {
        refused(&shop, &[&job, &["--"], options], words);
        refused(&shop, &[&job, &["--"], options], "the options after `--`");
    }
    refused(&shop, &[&job, &["--frames", "0..3"]], "--frames");
    refused(&shop, &[&job, &["--crops", "2x2"]], "--crops");
    refused(&shop, &[&job, &["--spp", "4000000000"]], "samples of shares end at");
    let render = ["submit", LEVEL, "--to", "slurm", "-o", "job", "--no-denoise"];
    refused(&shop, &[&render], "--bake");
    if !cfg!(feature = "denoise") {
        let render = ["submit", LEVEL, "--to", "slurm", "-o", "job", "--denoise"];
        refused(&shop, &[&JOB[..7]], "--no-denoise bakes without it");
        let output = run(&shop, &[&render]);
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(
            !output.status.success() && said.contains("without the denoiser"),
            "{said}"
        );
    }
    assert!(!shop.path("job").exists());
}
