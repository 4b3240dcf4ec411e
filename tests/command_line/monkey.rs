//! `sunroom edit --monkey`: a run without a window passes its own checks, and the same seed is the same run.

use std::process::Stdio;

use crate::workshop::{Workshop, sunroom};

const SCENE: &str = r#"<scene version="3.0.0">
  <sensor type="perspective" id="eye">
    <transform name="to_world"><lookat origin="0, 1, 6" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="32"/><integer name="height" value="24"/></film>
  </sensor>
  <bsdf type="plastic" id="shiny"/>
  <shape type="sphere" id="ball"><ref id="shiny"/></shape>
  <shape type="cube"><bsdf type="diffuse"/></shape>
  <emitter type="constant" id="sky"/>
</scene>"#;

/// What the monkey does in so many acts, one a line. The run must succeed.
#[track_caller]
fn play(shop: &Workshop, steps: usize, seed: u64) -> Vec<String> {
    let scene = shop.scene(SCENE);
    let mut command = sunroom();
    command.arg("edit").arg(&scene).args(["--no-window", "--threads", "1"]);
    command.args(["--monkey", &steps.to_string(), "--seed", &seed.to_string()]);
    command.arg("--monkey-log").arg(shop.path("log.txt"));
    let output = command.stdin(Stdio::null()).output().expect("the program starts");
    let report = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{report}");
    let text = std::fs::read_to_string(scene).expect("the scene");
    assert_eq!(text, SCENE, "the user's file");

    let log = std::fs::read_to_string(shop.path("log.txt")).expect("a log");
    match log.split_once("sunroom-monkey-") {
        // Folders have random names, which end in six letters.
        Some((_, folder)) => log.lines().map(|line| line.replace(&folder[..6], "")).collect(),
        None => log.lines().map(str::to_owned).collect(),
    }
}

/// With changed and broken files, reloads, imports, rendering, undo to the start and redo, and all that was saved
/// opened again.
#[test]
fn a_monkey_leaves_the_editor_whole_and_does_the_same_again() {
    let shop = Workshop::new();
    let first = play(&shop, 400, 5);
    assert!(first.len() > 400 && first.iter().any(|line| line.contains("another program writes")));
    let again = play(&shop, 400, 5);
    let differs = first.iter().zip(&again).zip(1..).find(|((one, two), _)| one != two);
    assert_eq!(differs, None);
    let other = play(&shop, 40, 6);
    assert!(first[..other.len()] != other);
}
