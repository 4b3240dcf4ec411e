//! `sunroom why`: sentences and JSON about the light of places and lamps.

use std::process::Output;

use serde_json::Value;

use crate::workshop::{Workshop, sunroom};

/// A floor between a red wall and a lamp that does not shine onto the wall's back, 40 x 30 pixels.
const SCENE: &str = r#"<scene version="3.0.0">
  <integrator type="path"><integer name="max_depth" value="6"/></integrator>
  <sensor type="perspective">
    <transform name="to_world"><lookat origin="0, 3, 5" target="0, 0, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="40"/><integer name="height" value="30"/></film>
  </sensor>
  <shape type="rectangle" id="floor">
    <transform name="to_world"><scale value="4"/><rotate x="1" angle="-90"/></transform>
    <bsdf type="diffuse"><rgb name="reflectance" value="0.7, 0.7, 0.7"/></bsdf>
  </shape>
  <shape type="rectangle" id="red wall">
    <transform name="to_world"><scale value="2"/><rotate y="1" angle="90"/><translate x="-1"/></transform>
    <bsdf type="twosided"><bsdf type="diffuse"><rgb name="reflectance" value="0.8, 0.1, 0.1"/></bsdf></bsdf>
  </shape>
  <shape type="rectangle" id="desk lamp">
    <transform name="to_world"><scale value="0.3"/><rotate x="1" angle="90"/><translate y="2"/></transform>
    <emitter type="area"><rgb name="radiance" value="9, 9, 9"/></emitter>
  </shape>
  <emitter type="constant" id="sky"><rgb name="radiance" value="0.1, 0.1, 0.2"/></emitter>
</scene>
"#;

fn why(shop: &Workshop, options: &[&str]) -> Output {
    let mut command = sunroom();
    command.arg("why").arg(shop.scene(SCENE)).args(options);
    command.output().expect("the program starts")
}

#[track_caller]
fn text(output: &Output) -> String {
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(0), "{error}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

fn json(output: &Output) -> Value {
    serde_json::from_str(&text(output)).expect("JSON")
}

#[test]
fn sentences_tell_where_the_light_comes_from() {
    let shop = Workshop::new();
    let told = text(&why(&shop, &["--at", "20,15", "--spp", "512"]));
    for part in [
        "Pixel 20, 15: radiance ",
        "desk lamp directly",
        "desk lamp by way of red wall",
        "sky directly",
        "2 bounces",
        "direct light",
        "The noise is made of:",
    ] {
        assert!(told.contains(part), "{part}: {told}");
    }
}

#[test]
fn json_has_the_sentences_with_figures_that_sum_up() {
    let shop = Workshop::new();
    let options = ["--region", "10,10,8,4", "--spp", "64", "--json", "--seed", "3"];
    let told = json(&why(&shop, &options));
    assert_eq!(told["area"], serde_json::json!([10, 10, 8, 4]));
    let number = |value: &Value| value.as_f64().expect("a number");
    let luminance = number(&told["luminance"]);
    let groupings = told["groupings"].as_array().expect("a list");
    let names: Vec<&str> = groupings.iter().filter_map(|one| one["grouping"].as_str()).collect();
    assert_eq!(names, ["route", "lamp", "way", "bounces", "kind"]);
    for grouping in groupings {
        let groups = grouping["groups"].as_array().expect("a list");
        let sum = |name: &str| groups.iter().map(|group| number(&group[name])).sum::<f64>();
        assert!((sum("luminance") - luminance).abs() < 1e-5 * luminance, "{grouping}");
        assert!((sum("share") - 1.0).abs() < 1e-5, "{grouping}");
    }
    // The same on another number of threads.
    let again = json(&why(&shop, &[&options[..], &["-t", "1"]].concat()));
    assert_eq!(told, again);
}

#[test]
fn the_light_of_a_lamp_is_followed() {
    let shop = Workshop::new();
    let told = json(&why(&shop, &["--lamp", "desk lamp", "--spp", "65536", "--json"]));
    let number = |value: &Value| value.as_f64().expect("a number");
    // A square of side 0.6 of radiance 9: 9 pi 0.36.
    let (emitted, error) = (number(&told["emitted"]), number(&told["emitted_error"]));
    let expected = 9.0 * std::f64::consts::PI * 0.36;
    assert!((emitted - expected).abs() < 4.5 * error + 1e-4 * expected, "{told}");
    let things = told["things"].as_array().expect("a list");
    let shares: f64 = things.iter().map(|thing| number(&thing["absorbed"])).sum();
    assert!((shares + number(&told["escaped"]) - 1.0).abs() < 1e-4, "{told}");
    assert!(things.iter().any(|thing| thing["name"] == "red wall"), "{told}");
    let told = text(&why(&shop, &["--lamp", "desk lamp", "--spp", "100"]));
    assert!(told.contains("by 128 paths"), "{told}");
    let told = text(&why(&shop, &["--lamp", "desk lamp", "--spp", "4096"]));
    assert!(
        told.contains("desk lamp emits") && told.contains("leaves the scene"),
        "{told}"
    );
}

#[test]
fn wrong_places_and_lamps_are_refused() {
    let shop = Workshop::new();
    for (options, message) in [
        (&["--at", "40,1"][..], "40 x 30 pixels"),
        (&["--at", "1"], "expected X,Y in pixels"),
        (&["--region", "39,0,2,1"], "outside of the picture"),
        (&["--lamp", "desk lmp"], "did you mean `desk lamp`?"),
        (&["--lamp", "xyz"], "the lamps are desk lamp, sky"),
        (&["--at", "1,1", "--lamp", "sky"], "cannot be used with"),
        (&["--at", "1,1", "--camera", "top"], "there is no camera `top`"),
        (&[], "required"),
    ] {
        let output = why(&shop, options);
        let error = String::from_utf8_lossy(&output.stderr).into_owned();
        assert_eq!(output.status.code(), Some(2), "{options:?}: {error}");
        assert!(error.contains(message), "{options:?}: {error}");
    }
}
