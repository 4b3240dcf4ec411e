//! The integrator `auto`: its pictures are those of the integrator that it stands for.

use std::process::Output;

use sunroom::render::image_io::exr::decode_exr;
use sunroom::render::layered_image::{Attribute, Channel};

use crate::workshop::{Workshop, sunroom};

const EASY: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell-box.xml");
const HARD: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/hard/gold-ring.xml");

fn render(shop: &Workshop, scene: &str, output: &str, arguments: &[&str]) -> Output {
    let mut command = sunroom();
    command
        .current_dir(shop.folder())
        .args(["render", scene, "-o", output])
        .args(arguments);
    let run = command.output().expect("the program starts");
    let errors = String::from_utf8_lossy(&run.stderr);
    assert!(run.status.success(), "{output} {arguments:?}: {errors}");
    run
}

/// The channels of a picture, and what it says of the choice.
fn picture(shop: &Workshop, name: &str) -> (Vec<Channel>, Option<String>) {
    let bytes = std::fs::read(shop.folder().join(name)).expect("it was written");
    let picture = decode_exr(&bytes).expect("an EXR file");
    let choice = picture.attributes.iter().find_map(|(name, value)| match value {
        Attribute::Text(text) if name == "sunroom:auto" => Some(text.clone()),
        _ => None,
    });
    (picture.channels, choice)
}

#[test]
fn a_clamp_says_what_it_removes() {
    let shop = Workshop::new();
    let size = ["--size", "40x30", "--spp", "4", "--seed", "3"];
    let run = render(&shop, EASY, "clamped.exr", &[&size[..], &["--clamp", "99"]].concat());
    let said = String::from_utf8_lossy(&run.stderr);
    assert!(said.contains("were clamped, which removes about"), "{said}");
    let run = render(&shop, EASY, "free.exr", &size);
    assert!(!String::from_utf8_lossy(&run.stderr).contains("clamped"));
    let mean = |name: &str| {
        let samples = picture(&shop, name).0.into_iter().map(|channel| channel.samples);
        samples
            .map(|samples| (0..samples.len()).map(|index| samples.value(index)).sum::<f32>())
            .sum::<f32>()
    };
    assert!(mean("clamped.exr") < mean("free.exr"));
    let refused = sunroom()
        .args(["render", EASY, "--clamp", "100"])
        .output()
        .expect("the program starts");
    let said = String::from_utf8_lossy(&refused.stderr);
    assert!(!refused.status.success() && said.contains("such as 99.9"), "{said}");
}

#[test]
fn guides_without_effect_are_told() {
    let shop = Workshop::new();
    let fog = r#"<scene version="3.0.0"><sensor type="perspective"><medium type="homogeneous"/></sensor></scene>"#;
    let fog = shop.write("fog.xml", fog).display().to_string();
    let guided = |scene: &str, options: &[&str]| {
        let options = [&["--guided", "--size", "8x8", "--spp", "1"], options].concat();
        let run = render(&shop, scene, "a.exr", &options);
        String::from_utf8_lossy(&run.stderr).into_owned()
    };
    for (scene, options, reason) in [
        (EASY, &["--integrator", "bdpt"][..], "on `bdpt`"),
        (
            EASY,
            &["--strategy", "bsdf"],
            "with the strategy `bsdf`, only with `mis`",
        ),
        (
            EASY,
            &["--integrator", "auto", "--strategy", "light"],
            "with the strategy `light`",
        ),
        (EASY, &["--max-depth", "2"], "on paths of at most 2 segments"),
        (&fog, &["--integrator", "auto"], "on `auto` where there are media"),
    ] {
        let said = guided(scene, options);
        let words = format!("warning: --guided has no effect {reason}");
        assert!(
            said.matches("warning:").count() == 1 && said.contains(&words),
            "{options:?}: {said}"
        );
    }
    let said = guided(EASY, &["--strategy", "mis", "--max-depth", "3"]);
    assert!(!said.contains("warning"), "{said}");
}

#[test]
fn guided_paths_are_the_same_in_shares_and_on_any_number_of_threads() {
    const COVE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/hard/cove.xml");
    let shop = Workshop::new();
    let guided = |name: &str, options: &[&str]| {
        render(&shop, COVE, name, &[&["--guided", "--size", "64x48"], options].concat());
    };
    guided("one.exr", &["--spp", "8", "--threads", "1"]);
    guided("three.exr", &["--spp", "8", "--threads", "3"]);
    guided(
        "first.exr",
        &["--spp", "4", "--checkpoint", "c.exr", "--resume", "c.exr"],
    );
    guided(
        "resumed.exr",
        &["--spp", "8", "--checkpoint", "c.exr", "--resume", "c.exr"],
    );
    guided("a.exr", &["--samples", "0..4"]);
    guided("b.exr", &["--samples", "4..8", "--threads", "3"]);
    let merged = sunroom()
        .current_dir(shop.folder())
        .args(["merge", "a.exr", "b.exr", "-o", "merged.exr"])
        .output()
        .expect("the program starts");
    assert!(merged.status.success(), "{}", String::from_utf8_lossy(&merged.stderr));
    render(&shop, COVE, "free.exr", &["--size", "64x48", "--spp", "8"]);
    let one = picture(&shop, "one.exr").0;
    for name in ["three.exr", "resumed.exr", "merged.exr"] {
        assert!(picture(&shop, name).0 == one, "{name}");
    }
    assert!(picture(&shop, "free.exr").0 != one, "nothing is guided");
    let useless = ["--guided", "--integrator", "bdpt", "--size", "16x12", "--spp", "1"];
    let run = render(&shop, COVE, "bdpt.exr", &useless);
    let said = String::from_utf8_lossy(&run.stderr);
    assert!(said.contains("--guided has no effect on `bdpt`"), "{said}");
}

#[test]
fn a_room_lit_from_a_cove_has_the_bits_of_guided_paths() {
    const COVE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/hard/cove.xml");
    let shop = Workshop::new();
    // The choice is that for the whole picture, of which a few samples are rendered.
    let share = ["--spp", "8192", "--samples", "0..4"];
    let render = |name: &str, options: &[&str]| render(&shop, COVE, name, &[&share[..], options].concat());
    let run = render("one.exr", &["--integrator", "auto", "--threads", "1", "--stats=json"]);
    render("three.exr", &["--integrator", "auto", "--threads", "3"]);
    render("guided.exr", &["--guided"]);
    let (guided, none) = picture(&shop, "guided.exr");
    assert_eq!(none, None);
    for name in ["one.exr", "three.exr"] {
        let (found, choice) = picture(&shop, name);
        assert!(found == guided, "{name} differs from the picture by guided paths");
        assert_eq!(choice.as_deref(), Some("guided path"), "{name}");
    }
    let stats: serde_json::Value = serde_json::from_slice(&run.stdout).expect("JSON");
    let auto = &stats["auto"];
    assert_eq!(auto["integrator"], "guided path");
    assert!(auto["gain_of_guide"].as_f64().is_some_and(|gain| gain > 1.5), "{stats}");
    // The pilot has learnt the guide of the picture, which counts none of its rays.
    let is_of_pilot = |stats: &serde_json::Value| {
        let of_pilot = stats["auto"]["guide_rays"].as_u64();
        let bytes = stats["guide"]["bytes"].as_u64();
        of_pilot.is_some_and(|rays| rays > 65_536) && bytes > Some(0) && stats["guide"]["rays"] == 0
    };
    assert!(is_of_pilot(&stats), "{stats}");
    let told = String::from_utf8_lossy(&run.stderr);
    assert!(told.contains("auto takes `guided path`"), "{told}");
    // So it is where only the camera moves while the shutter is open.
    let moving = ["--turntable=48", "--shutter", "0.5", "--frames", "4"];
    let auto = ["--integrator", "auto", "--stats=json"];
    let run = render("moving-###.exr", &[&moving[..], &auto].concat());
    let stats: serde_json::Value = serde_json::from_slice(&run.stdout).expect("JSON");
    assert!(is_of_pilot(&stats), "{stats}");
    render("led-###.exr", &[&moving[..], &["--guided"]].concat());
    assert!(picture(&shop, "moving-004.exr").0 == picture(&shop, "led-004.exr").0);
}

#[test]
fn an_easy_scene_has_the_bits_of_path() {
    let shop = Workshop::new();
    let size = ["--size", "80x60", "--spp", "192"];
    let run = render(
        &shop,
        EASY,
        "auto.exr",
        &[&size[..], &["--integrator", "auto", "--stats=json"]].concat(),
    );
    render(&shop, EASY, "path.exr", &size);
    let ((auto, choice), (path, none)) = (picture(&shop, "auto.exr"), picture(&shop, "path.exr"));
    assert!(auto == path, "the pictures differ");
    assert_eq!((choice.as_deref(), none), (Some("path"), None));
    let stats: serde_json::Value = serde_json::from_slice(&run.stdout).expect("JSON");
    assert_eq!(stats["auto"]["integrator"], "path");
    assert!(stats["auto"]["gain"].as_f64().is_some_and(|gain| gain < 1.0), "{stats}");
    let told = String::from_utf8_lossy(&run.stderr);
    assert!(told.contains("auto takes `path`"), "{told}");
}

#[test]
fn checkpoints_and_frames_keep_the_choice() {
    let shop = Workshop::new();
    let auto = ["--integrator", "auto", "--threads", "2"];
    let with_checkpoint = |name: &str, samples: &str| {
        let checkpoint = ["--spp", samples, "--checkpoint", "c.exr", "--resume", "c.exr"];
        render(&shop, HARD, name, &[&auto[..], &checkpoint].concat());
    };
    with_checkpoint("first.exr", "272");
    with_checkpoint("resumed.exr", "288");
    render(&shop, HARD, "whole.exr", &[&auto[..], &["--spp", "288"]].concat());
    let (whole, choice) = picture(&shop, "whole.exr");
    assert_eq!(choice.as_deref(), Some("bdpt"));
    assert!(picture(&shop, "resumed.exr").0 == whole, "resumed");
    // What was begun without a pilot goes on without one.
    std::fs::remove_file(shop.folder().join("c.exr")).expect("it was written");
    with_checkpoint("first.exr", "64");
    with_checkpoint("resumed.exr", "272");
    assert_eq!(picture(&shop, "resumed.exr").1.as_deref(), Some("path"));

    let frames = |name: &str, frames: &str| {
        let options = ["--spp", "272", "--turntable=48", "--shutter", "0.5", "--frames", frames];
        render(&shop, HARD, name, &[&auto[..], &options].concat());
    };
    frames("some-###.exr", "3..4");
    frames("one-###.exr", "4");
    let (alone, choice) = picture(&shop, "one-004.exr");
    assert_eq!(choice.as_deref(), Some("bdpt"));
    assert!(picture(&shop, "some-004.exr").0 == alone, "a frame alone");
}

#[test]
fn a_hard_scene_has_the_bits_of_bdpt_in_shares_as_well() {
    let shop = Workshop::new();
    let auto = ["--spp", "272", "--integrator", "auto"];
    render(&shop, HARD, "auto.exr", &[&auto[..], &["--threads", "1"]].concat());
    render(
        &shop,
        HARD,
        "bdpt.exr",
        &["--spp", "272", "--integrator", "bdpt", "--threads", "4"],
    );
    for (name, samples) in [("a.exr", "0..128"), ("b.exr", "128..272")] {
        render(
            &shop,
            HARD,
            name,
            &[&auto[..], &["--samples", samples, "--threads", "3"]].concat(),
        );
    }
    let merged = sunroom()
        .current_dir(shop.folder())
        .args(["merge", "a.exr", "b.exr", "-o", "merged.exr"])
        .output()
        .expect("the program starts");
    assert!(merged.status.success(), "{}", String::from_utf8_lossy(&merged.stderr));
    let (expected, none) = picture(&shop, "bdpt.exr");
    assert_eq!(none, None);
    for name in ["auto.exr", "merged.exr"] {
        let (found, choice) = picture(&shop, name);
        assert!(found == expected, "{name} differs from the picture by bdpt");
        assert_eq!(choice.as_deref(), Some("bdpt"), "{name}");
    }
}
