//! `sunroom measure`: what it prints, its exit codes, and its refusals.

use std::path::Path;
use std::process::Output;

use crate::workshop::{Workshop, sunroom};

/// A floor below a point light of 683 candela at a height of 2: 170.75 lx below it. METERS stands for what measures.
const SCENE: &str = r#"<scene version="3.0.0">
  <integrator type="path"><integer name="max_depth" value="2"/></integrator>
  <sensor type="perspective">
    <transform name="to_world"><lookat origin="0, 2, 5" target="0, 0.5, 0" up="0, 1, 0"/></transform>
    <film type="hdrfilm"><integer name="width" value="40"/><integer name="height" value="30"/></film>
  </sensor>
  <shape type="rectangle" id="floor">
    <transform name="to_world"><scale value="4"/><rotate x="1" angle="-90"/></transform>
    <bsdf type="diffuse"><rgb name="reflectance" value="0.8"/></bsdf>
  </shape>
  <emitter type="point" id="bulb"><point name="position" x="0" y="2" z="0"/><rgb name="intensity" value="1"/></emitter>
METERS
</scene>
"#;

const POINT: &str = r#"<emitter type="illuminancemeter" id="below"><float name="least" value="LIMIT"/>
  <transform name="to_world"><rotate x="1" angle="-90"/></transform></emitter>"#;

const GRID: &str = r#"<emitter type="illuminancegrid" id="floor, all of it"><float name="spacing" value="1"/>
  <transform name="to_world"><scale value="2"/><rotate x="1" angle="-90"/><translate y="0.001"/></transform></emitter>"#;

fn measure(scene: &Path, more: &[&str]) -> (Output, String, String) {
    let output = sunroom()
        .arg("measure")
        .arg(scene)
        .args(more)
        .output()
        .expect("the program starts");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    let (said, told) = (text(&output.stdout), text(&output.stderr));
    (output, said, told)
}

fn with_meters(workshop: &Workshop, meters: &str) -> std::path::PathBuf {
    workshop.scene(&SCENE.replace("METERS", meters))
}

#[test]
fn a_point_below_a_lamp_has_its_lux_and_limits_decide_on_the_code() {
    let workshop = Workshop::new();
    for (limit, code, verdict) in [("170", 0, "pass"), ("171", 3, "FAIL")] {
        let scene = with_meters(&workshop, &POINT.replace("LIMIT", limit));
        let (output, said, told) = measure(&scene, &["-q"]);
        assert_eq!(output.status.code(), Some(code), "{told}");
        assert!(said.starts_with("below  171 lx\n"), "{said}");
        assert!(
            said.contains(&format!("least {limit} lx asked for: {verdict}")),
            "{said}"
        );
        let (_, said, _) = measure(&scene, &["-q", "--json"]);
        let json: serde_json::Value = serde_json::from_str(&said).expect("JSON");
        let lux = json["meters"][0]["points"][0]["illuminance"]["lux"]
            .as_f64()
            .expect("a number");
        assert!((lux - 170.75).abs() < 1e-3, "{lux}");
        assert_eq!(json["passes"], code == 0);
    }
}

#[test]
fn grids_have_rows_in_csv_files_and_daylight_replaces_lamps() {
    let workshop = Workshop::new();
    let scene = with_meters(&workshop, GRID);
    let rows = workshop.path("rows.csv");
    let (output, said, told) = measure(&scene, &["--csv", rows.to_str().expect("a name")]);
    assert_eq!(output.status.code(), Some(0), "{told}");
    assert!(said.starts_with("floor, all of it  4 x 4 points  least "), "{said}");
    let table = std::fs::read_to_string(&rows).expect("the rows");
    let lines: Vec<&str> = table.lines().collect();
    assert_eq!((lines.len(), lines[0]), (17, "meter,column,row,x,y,z,lux,error"));
    let numbers = lines[1].strip_prefix("\"floor, all of it\",").expect("the name");
    let numbers: Vec<f64> = numbers
        .split(',')
        .map(|number| number.parse().expect("a number"))
        .collect();
    let place = [0.0, 0.0, -1.5, 0.001, 1.5];
    assert!(
        numbers.len() == 7
            && numbers
                .iter()
                .zip(place)
                .all(|(found, place)| (found - place).abs() < 1e-6),
        "{numbers:?}"
    );
    let (output, said, told) = measure(&scene, &["-q", "--daylight-factor", "--noise", "0.5%"]);
    assert_eq!(output.status.code(), Some(0), "{told}");
    // In the open the factor is one.
    assert!(
        said.contains("4 x 4 points  least 9") || said.contains("4 x 4 points  least 100"),
        "{said}"
    );
    assert!(said.contains("the open ground 10000 lx"), "{said}");
}

#[test]
fn meters_without_names_are_numbered_and_a_page_has_plans() {
    let workshop = Workshop::new();
    let nameless = GRID.replace(r#" id="floor, all of it""#, "");
    let meters = [&nameless, &POINT.replace("LIMIT", "1"), &nameless]
        .map(String::as_str)
        .concat();
    let scene = with_meters(&workshop, &meters);
    let page = workshop.path("page.html");
    let (output, said, told) = measure(&scene, &["-q", "--html", page.to_str().expect("a name")]);
    assert_eq!(output.status.code(), Some(0), "{told}");
    assert!(
        said.starts_with("measuring grid 1  4 x 4") && said.contains("\nmeasuring grid 2  4 x 4"),
        "{said}"
    );
    let text = std::fs::read_to_string(&page).expect("the page");
    assert_eq!(text.matches("<svg").count(), 2);
    assert_eq!(text.matches("<rect").count(), 32);
    assert!(text.contains("all limits are met") && !text.contains("{{"), "{text}");
}

#[test]
fn the_upward_axis_is_said_and_can_be_chosen() {
    let workshop = Workshop::new();
    let scene = with_meters(&workshop, &POINT.replace("LIMIT", "0"));
    let (_, said, told) = measure(&scene, &["-q", "--daylight-factor"]);
    assert!(said.contains("up is y, by the camera"), "{said}{told}");
    let (output, said, told) = measure(&scene, &["-q", "--daylight-factor", "--up", "-y", "--json"]);
    assert_eq!(output.status.code(), Some(0), "{told}");
    let json: serde_json::Value = serde_json::from_str(&said).expect("JSON");
    assert_eq!(json["up"], serde_json::json!([0.0, -1.0, 0.0]));
    // The sky is below the floor but for what pictures smooth at the horizon.
    let lux = json["meters"][0]["points"][0]["illuminance"]["lux"].as_f64();
    assert!(lux.is_some_and(|lux| lux < 1.0), "{lux:?}");
    let (output, _, told) = measure(&scene, &["--daylight-factor", "--up", "w"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(told.contains("expected x, y, z, -x, -y or -z"), "{told}");
}

#[test]
fn check_refuses_what_measure_refuses_and_a_depth_of_one_is_warned_of() {
    let workshop = Workshop::new();
    let fine = with_meters(&workshop, &GRID.replace(r#"value="1""#, r#"value="0.001""#));
    let output = sunroom().arg("check").arg(&fine).output().expect("the program starts");
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1));
    assert!(
        told.contains("floor, all of it: a grid may have 16384 points") && told.contains("1 error"),
        "{told}"
    );
    let text = SCENE
        .replace("METERS", GRID)
        .replace(r#"name="max_depth" value="2""#, r#"name="max_depth" value="1""#);
    let (output, said, told) = measure(&workshop.scene(&text), &["-q"]);
    assert_eq!(output.status.code(), Some(0), "{told}");
    assert!(told.contains("max_depth 1 ends paths before any light"), "{told}");
    assert!(said.contains("uniformity none in the dark"), "{said}");
}

#[test]
fn scenes_without_meters_and_impossible_meters_are_errors() {
    let workshop = Workshop::new();
    let (output, _, told) = measure(&with_meters(&workshop, ""), &[]);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        told.contains("has no measuring points: add one") && told.contains("illuminancemeter"),
        "{told}"
    );
    let fine = GRID.replace(r#"value="1""#, r#"value="0.001""#);
    let (output, _, told) = measure(&with_meters(&workshop, &fine), &[]);
    assert_eq!(output.status.code(), Some(1));
    assert!(
        told.contains("floor, all of it: a grid may have 16384 points"),
        "{told}"
    );
    let below = POINT.replace("LIMIT", "0").replace(
        "<rotate x=\"1\" angle=\"-90\"/>",
        "<rotate x=\"1\" angle=\"-90\"/><translate y=\"-1\"/>",
    );
    let (output, said, told) = measure(&with_meters(&workshop, &below), &["-q"]);
    assert_eq!(output.status.code(), Some(0));
    assert!(
        said.contains("below  0 lx") && told.contains("warning: below: it lies inside of something"),
        "{said}{told}"
    );
    let scene = with_meters(&workshop, GRID);
    let (output, ..) = measure(&scene, &["--csv", scene.to_str().expect("a name")]);
    assert_eq!(output.status.code(), Some(1), "the scene is not replaced by rows");
}
