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
