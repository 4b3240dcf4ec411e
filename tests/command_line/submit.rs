//! `sunroom submit`: the folder of a job, and its scripts as a farm would start them.

use std::path::Path;
use std::process::{Command, Output};

use sunroom::render::image_io::exr::decode_exr;

use crate::workshop::{Workshop, sunroom};

const SCENE: &str = r#"<scene version="3.0.0">
  <sensor type="perspective">
    <transform name="to_world"><lookat origin="0, 0, 4" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="32"/><integer name="height" value="24"/></film>
    <sampler type="independent"><integer name="sample_count" value="16"/></sampler>
  </sensor>
  <shape type="ply" id="mesh"><string name="filename" value="../meshes/triangle.ply"/></shape>
  <shape type="sphere" id="ball">
    <animation name="to_world"><transform time="0"/><transform time="1"><translate x="1"/></transform></animation>
  </shape>
  <emitter type="constant"/>
</scene>
"#;

const TRIANGLE: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
    property list uchar int vertex_indices\nend_header\n-1 -1 0\n1 -1 0\n0 1 0\n3 0 1 2\n";

/// A scene in a folder beside that of its mesh.
fn shop() -> Workshop {
    let shop = Workshop::new();
    shop.write("scenes/still life.xml", SCENE);
    shop.write("meshes/triangle.ply", TRIANGLE);
    shop
}

fn run(shop: &Workshop, arguments: &[&str]) -> Output {
    let mut command = sunroom();
    command
        .current_dir(shop.folder())
        .args(arguments)
        .env_remove("SUNROOM_ASSETS");
    command.output().expect("the program starts")
}

#[track_caller]
fn succeeds(output: &Output) {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[cfg(unix)]
#[track_caller]
fn script(folder: &Path, name: &str, arguments: &[&str]) {
    let mut command = Command::new(folder.join(name));
    command
        .args(arguments)
        .env("SUNROOM", env!("CARGO_BIN_EXE_sunroom"))
        .env_remove("SUNROOM_ASSETS");
    succeeds(&command.output().expect("bash"));
}

#[cfg(unix)]
#[test]
fn the_tasks_of_a_job_make_the_pictures_of_one_render() {
    let shop = shop();
    let scene = "scenes/still life.xml";
    let options = ["--aov", "depth", "--shutter", "0.5"];
    let frames = ["--frames", "3..5"];
    let mut submit = vec!["submit", scene, "--to", "slurm", "-o", "job", "--shares", "2"];
    submit.extend(frames);
    submit.push("--");
    submit.extend(options);
    succeeds(&run(&shop, &submit));
    // The original is not needed any more.
    std::fs::rename(shop.path("meshes"), shop.path("elsewhere")).expect("renamed");
    let job = shop.path("job");
    for task in ["5", "0", "4", "1", "3", "2", "2"] {
        script(&job, "task", &[task, "--threads", "1"]);
    }
    for frame in ["3", "4", "5"] {
        script(&job, "merge", &[frame]);
    }
    // What is no task or frame of the job is an error, and not nothing to do.
    let refused = [
        ("task", vec!["6"], "the tasks of this job are 0 to 5"),
        ("task", vec![], "the tasks of this job are 0 to 5"),
        ("task", vec!["-1"], "no task `-1`"),
        ("task", vec!["1x"], "no task `1x`"),
        ("merge", vec!["6"], "the frames of this job are 3 to 5"),
    ];
    for (name, arguments, words) in refused {
        let output = Command::new(job.join(name)).args(&arguments).output().expect("bash");
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(
            output.status.code() == Some(2) && said.contains(words),
            "{name} {arguments:?}: {said}"
        );
    }
    std::fs::rename(shop.path("elsewhere"), shop.path("meshes")).expect("renamed");
    let mut render = vec!["render", scene, "-o", "whole-####.exr"];
    render.extend(frames);
    render.extend(options);
    succeeds(&run(&shop, &render));
    for frame in 3..=5 {
        let read = |name: String| {
            let bytes = std::fs::read(shop.path(&name)).expect("a picture");
            let image = decode_exr(&bytes).expect("an EXR file");
            // The attributes name the file of the scene, which is another one in the job.
            ["", "Depth"].map(|layer| image.layer(layer))
        };
        let merged = read(format!("job/pictures/still_life-000{frame}.exr"));
        assert!(merged.iter().all(Option::is_some));
        assert!(merged == read(format!("whole-000{frame}.exr")), "frame {frame}");
    }
}

/// A job that is not measured.
const SLURM: [&str; 6] = ["--to", "slurm", "-o", "job", "--shares", "1"];
const OPENJD: [&str; 6] = ["--to", "openjd", "-o", "job", "--shares", "1"];

#[test]
fn options_that_tasks_cannot_have_are_refused_at_once() {
    let shop = shop();
    for options in [
        &["--adaptive"][..],
        &["--noise", "1%"],
        &["--spp", "8"],
        &["--crop", "0,0,32,32"],
        &["--resume", "c.exr"],
        &["-o", "all.exr"],
        &["--frames", "0..3"],
        &["--stats"],
    ] {
        let job = if options[0] == "--stats" { OPENJD } else { SLURM };
        let submit = [&["submit", "scenes/still life.xml"][..], &job, &["--dry-run", "--"]].concat();
        let output = run(&shop, &[&submit[..], options].concat());
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(
            said.contains("the options after `--`") && said.contains(options[0]),
            "{said}"
        );
    }
}

#[cfg(unix)]
#[test]
fn crops_of_a_job_make_the_picture_of_one_render() {
    let shop = shop();
    let scene = "scenes/still life.xml";
    let options = ["--size", "100x70", "--aov", "normal"];
    let submit = [
        "submit", scene, "--to", "slurm", "-o", "job", "--shares", "2", "--crops", "3x2", "--",
    ];
    let output = run(&shop, &[&submit[..], &options].concat());
    succeeds(&output);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        text.contains("12 tasks: 1 frame, each in 6 crops of its 100 x 70 pixels and 2 ranges of its 16 samples"),
        "{text}"
    );
    let job = shop.path("job");
    for task in ["7", "1", "5", "11", "3", "9", "0", "10", "2", "8", "4", "6"] {
        script(&job, "task", &[task]);
    }
    assert_eq!(std::fs::read_dir(job.join("parts")).expect("parts").count(), 12);
    script(&job, "merge", &["0"]);
    succeeds(&run(
        &shop,
        &[&["render", scene, "-o", "whole.exr"][..], &options].concat(),
    ));
    let read = |name: &str| {
        let bytes = std::fs::read(shop.path(name)).expect("a picture");
        decode_exr(&bytes).expect("an EXR file").channels
    };
    assert!(read("job/pictures/still_life.exr") == read("whole.exr"));
}

/// Parts that read other files are not of the same picture.
#[cfg(unix)]
#[test]
fn machines_with_assets_of_their_own_take_those_of_the_job() {
    let shop = Workshop::new();
    shop.write("scenes/a.xml", SCENE.replace("../meshes", "../assets/models"));
    shop.write("library/models/triangle.ply", TRIANGLE);
    let library = shop.path("library");
    let on_machine = |mut command: Command, has_library: bool| {
        command
            .current_dir(shop.folder())
            .env("SUNROOM", env!("CARGO_BIN_EXE_sunroom"));
        match has_library {
            true => command.env("SUNROOM_ASSETS", &library),
            false => command.env_remove("SUNROOM_ASSETS"),
        };
        succeeds(&command.output().expect("it starts"));
    };
    let mut submit = sunroom();
    submit.args(["submit", "scenes/a.xml", "--to", "slurm", "-o", "job", "--shares", "2"]);
    on_machine(submit, true);
    for (script, number, has_library) in [("task", "0", true), ("task", "1", false), ("merge", "0", false)] {
        let mut command = Command::new(shop.path("job").join(script));
        command.arg(number);
        on_machine(command, has_library);
    }
    assert!(shop.path("job/pictures/a.exr").exists());
}

/// A glTF file that shines, with a camera, and its mesh in another file.
fn gltf(shop: &Workshop) {
    let text = r#"{"asset":{"version":"2.0"},"buffers":[{"uri":"parts/triangle.bin","byteLength":36}],
        "bufferViews":[{"buffer":0,"byteLength":36}],
        "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],
        "materials":[{"emissiveFactor":[1,0.5,0.25]}],"cameras":[{"type":"perspective","perspective":{"yfov":0.8,"znear":0.1}}],
        "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
        "nodes":[{"mesh":0},{"camera":0,"translation":[0,0,4]}],"scenes":[{"nodes":[0,1]}],"scene":0}"#;
    shop.write("models/lamp.gltf", text);
    let corners: [f32; 9] = [-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 0.0, 1.0, 0.0];
    let bytes: Vec<u8> = corners.iter().flat_map(|number| number.to_le_bytes()).collect();
    shop.write("models/parts/triangle.bin", bytes);
}

#[cfg(unix)]
#[test]
fn gltf_scenes_need_no_parts_of_this_machine() {
    let shop = Workshop::new();
    gltf(&shop);
    let options = ["--size", "32x32", "--spp", "8"];
    let on = |machine: &str, mut command: Command| {
        command
            .current_dir(shop.folder())
            .env("XDG_CACHE_HOME", shop.path(machine))
            .env("SUNROOM", env!("CARGO_BIN_EXE_sunroom"));
        succeeds(&command.output().expect("it starts"));
    };
    let call = |arguments: &[&str]| {
        let mut command = sunroom();
        command.args(arguments);
        command
    };
    let script = |name: &str, argument: &str| {
        let mut command = Command::new(shop.path("job").join(name));
        command.arg(argument);
        command
    };
    let submit = [
        "submit",
        "models/lamp.gltf",
        "--to",
        "slurm",
        "-o",
        "job",
        "--shares",
        "2",
    ];
    on(
        "here",
        call(&[&submit[..], &["--spp", "8", "--", "--size", "32x32"]].concat()),
    );
    on(
        "here",
        call(&[&["render", "models/lamp.gltf", "-o", "whole.exr"][..], &options].concat()),
    );
    assert!(shop.path("here/sunroom/gltf").exists());
    std::fs::remove_dir_all(shop.path("here")).expect("removed");
    std::fs::remove_dir_all(shop.path("models")).expect("removed");
    on("elsewhere", script("task", "0"));
    on("elsewhere", script("task", "1"));
    on("elsewhere", script("merge", "0"));
    let read = |name: &str| {
        let bytes = std::fs::read(shop.path(name)).expect("a picture");
        decode_exr(&bytes).expect("an EXR file").layer("").expect("a picture")
    };
    let (merged, whole) = (read("job/pictures/lamp.exr"), read("whole.exr"));
    assert!(
        whole.pixels.iter().any(|pixel| *pixel != whole.pixels[0]),
        "the lamp is seen"
    );
    assert!(merged == whole);
}

/// Runs a job of two frames by a program of the system, if that is installed, and looks whether the pictures are there.
#[cfg(unix)]
#[track_caller]
fn runs_by(system: &str, program: &str, version: &str, start: &dyn Fn(&Path) -> Command) {
    if Command::new(program).arg(version).output().is_err() {
        println!("{program} is not installed: its job is not run");
        return;
    }
    let shop = shop();
    let scene = "scenes/still life.xml";
    succeeds(&run(
        &shop,
        &[
            "submit", scene, "--to", system, "-o", "job", "--shares", "2", "--frames", "0..1",
        ],
    ));
    let mut start = start(&shop.path("job"));
    start
        .env("SUNROOM", env!("CARGO_BIN_EXE_sunroom"))
        .env_remove("SUNROOM_ASSETS");
    let output = start.output().expect("the system");
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        output.status.success(),
        "{said}{}",
        String::from_utf8_lossy(&output.stderr)
    );
    for frame in 0..=1 {
        let picture = shop.path(&format!("job/pictures/still_life-000{frame}.exr"));
        assert!(picture.exists(), "frame {frame}: {said}");
    }
}

#[cfg(unix)]
#[test]
fn open_job_description_runs_the_template() {
    runs_by("openjd", "openjd", "--version", &|job| {
        let mut command = Command::new("openjd");
        command.arg("run").arg(job.join("template.yaml"));
        command.args(["--step", "Merge", "--run-dependencies"]);
        command
    });
}

#[cfg(unix)]
#[test]
fn gnu_parallel_runs_the_job() {
    runs_by("parallel", "parallel", "--version", &|job| {
        let mut command = Command::new(job.join("parallel"));
        command.arg(":");
        command
    });
}

#[test]
fn a_dry_run_writes_nothing_and_tells_all() {
    let shop = shop();
    let output = run(
        &shop,
        &[
            "submit",
            "scenes/still life.xml",
            "--to",
            "openjd",
            "-o",
            "job",
            "--shares",
            "4",
            "--spp",
            "64",
            "--dry-run",
        ],
    );
    succeeds(&output);
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    for part in [
        "files/scenes/still life.xml",
        "files/meshes/triangle.ply",
        "template.yaml",
        "4 tasks",
    ] {
        assert!(text.contains(part), "{part} in {text}");
    }
    assert!(!shop.path("job").exists());
    // Each system starts all tasks, which crops make more of.
    for (system, start) in [
        ("openjd", "template.yaml"),
        ("slurm", "slurm"),
        ("parallel", "parallel"),
    ] {
        let submit = [
            "submit",
            "scenes/still life.xml",
            "--to",
            system,
            "-o",
            system,
            "--shares",
            "4",
        ];
        let output = run(
            &shop,
            &[
                &submit[..],
                &[
                    "--spp", "64", "--crops", "2x3", "--frames", "5..6", "--", "--size", "64x96",
                ],
            ]
            .concat(),
        );
        succeeds(&output);
        assert!(String::from_utf8_lossy(&output.stdout).contains("48 tasks: 2 frames, each in 6 crops"));
        let script = std::fs::read_to_string(shop.path(system).join(start)).expect("it is written");
        let range = if system == "parallel" { "seq 0 47" } else { "0-47" };
        assert!(script.contains(range), "{script}");
        let merge = std::fs::read_to_string(shop.path(system).join("merge")).expect("it is written");
        assert!(
            merge.contains("crops=(0,0,32,32 32,0,32,32 0,32,32,32 32,32,32,32 0,64,32,32 32,64,32,32)"),
            "{merge}"
        );
    }
}

#[test]
fn a_job_is_measured() {
    let shop = shop();
    let output = run(
        &shop,
        &[
            "submit",
            "scenes/still life.xml",
            "--to",
            "parallel",
            "-o",
            "job",
            "--spp",
            "64",
            "--dry-run",
            "--",
            "--width",
            "16",
            "--quiet",
            "--stats=json-lines",
        ],
    );
    succeeds(&output);
    assert!(String::from_utf8_lossy(&output.stdout).contains("1 task: 1 frame, each in 1 crop of its"));
}

#[test]
fn fewer_ranges_than_are_asked_for_are_told() {
    let shop = shop();
    let said = |shares: &str| {
        let submit = [
            "submit",
            "scenes/still life.xml",
            "--to",
            "slurm",
            "-o",
            "job",
            "--dry-run",
            "--spp",
            "64",
        ];
        let output = run(&shop, &[&submit[..], &["--shares", shares]].concat());
        succeeds(&output);
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let note = said("100");
    assert!(
        note.contains("note: --shares 100 makes 8 ranges") && note.contains("64 of them are 8 groups"),
        "{note}"
    );
    assert!(!said("4").contains("note:"));
}

#[test]
fn what_cannot_be_a_job_is_refused() {
    let shop = shop();
    shop.write("full/file", "");
    let refused = |arguments: &[&str], code: i32| {
        let output = run(&shop, arguments);
        assert_eq!(output.status.code(), Some(code), "{arguments:?}");
        String::from_utf8_lossy(&output.stderr).into_owned()
    };
    let scene = "scenes/still life.xml";
    assert!(refused(&["submit", scene, "--to", "slurm", "-o", "full", "--shares", "1"], 2).contains("not empty"));
    assert!(refused(&["submit", scene, "--to", "pbs", "-o", "job"], 2).contains("openjd"));
    refused(&["submit", "scenes/missing.xml", "--to", "slurm", "-o", "job"], 1);
    let submit = ["submit", scene, "--to", "slurm", "-o", "job", "--shares", "1"];
    let more = |arguments: &[&'static str]| refused(&[&submit[..], arguments].concat(), 2);
    assert!(more(&["--", "--width", "0"]).contains("the options after `--`: invalid value '0'"));
    let message = more(&["--crops", "2x1"]);
    assert!(
        message.contains("a picture of 32 x 24 pixels can be cut into 1x1 at most"),
        "{message}"
    );
    assert!(more(&["--crops", "2x0"]).contains("expected COLUMNSxROWS"));
    assert!(more(&["--", "--spp", "-1"]).contains("the options after `--`: invalid value '-1'"));
    let absolute = SCENE.replace("../meshes", &shop.path("meshes").display().to_string());
    shop.write("scenes/absolute.xml", absolute);
    let text = refused(&[&["submit", "scenes/absolute.xml"][..], &SLURM].concat(), 1);
    assert!(text.contains("absolute name"), "{text}");
    assert!(!shop.path("job").exists());
}

#[cfg(unix)]
#[test]
fn a_scene_without_all_of_its_files_is_submitted_when_the_user_says_so() {
    let shop = shop();
    std::fs::remove_file(shop.path("meshes/triangle.ply")).expect("removed");
    let submit = [
        "submit",
        "scenes/still life.xml",
        "--to",
        "slurm",
        "-o",
        "job",
        "--shares",
        "1",
    ];
    let refused = run(&shop, &submit);
    let said = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(1), "{said}");
    assert!(
        said.contains("triangle.ply: no such file") && said.contains("--allow-missing"),
        "{said}"
    );
    assert!(!shop.path("job").exists());
    let allowed = run(&shop, &[&submit[..], &["--allow-missing"]].concat());
    succeeds(&allowed);
    assert!(String::from_utf8_lossy(&allowed.stderr).contains("triangle.ply: no such file"));
    let job = shop.path("job");
    script(&job, "task", &["0", "--threads", "1"]);
    script(&job, "merge", &["0"]);
    assert!(job.join("pictures/still_life.exr").is_file());
}
