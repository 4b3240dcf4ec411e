//! `sunroom bench`: figures that make sense, for people and machines, and a comparison with an earlier run.

use std::path::Path;
use std::process::Output;

use serde_json::Value;

use crate::workshop::sunroom;

fn bench(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = sunroom();
    command.current_dir(folder).arg("bench").args(arguments);
    command.output().expect("the program starts")
}

fn told(output: &Output) -> (i32, String, String) {
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (
        output.status.code().unwrap_or(-1),
        text(&output.stdout),
        text(&output.stderr),
    )
}

const SCENE: &str = r#"<scene version="3.0.0">
  <sensor type="perspective"/>
  <emitter type="constant"/>
  <shape type="sphere"><point name="center" value="0, 0, 5"/></shape>
</scene>"#;

#[test]
fn renders_are_measured_and_compared() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("ball.xml"), SCENE).expect("can be written");
    let few = ["ball.xml", "--spp", "4", "--size", "64x64", "--rounds", "1"];
    let (code, out, _) = told(&bench(folder.path(), &[&few[..], &["--json", "old.json"]].concat()));
    assert_eq!(code, 0);
    assert!(out.contains("ball") && out.contains("relMSE"), "{out}");
    let json = std::fs::read_to_string(folder.path().join("old.json")).expect("was written");
    let json: Value = serde_json::from_str(&json).expect("JSON");
    let render = &json["renders"][0];
    let figure = |name: &str| render[name].as_f64().unwrap_or(f64::NAN);
    for name in ["seconds", "msamples_per_s", "mrays_per_s", "rel_mse", "cost"] {
        assert!(figure(name) > 0.0, "{name} in {json}");
    }
    let spent = 64.0 * 64.0 * 4.0 / 1e6 / figure("msamples_per_s");
    assert!((spent / figure("seconds") - 1.0).abs() < 1e-6, "{json}");
    // The same samples: the noise is the same to the bit, whatever the machine does meanwhile.
    let (code, out, _) = told(&bench(folder.path(), &[&few[..], &["--against", "old.json"]].concat()));
    assert_eq!(code, 0);
    assert!(out.contains("relMSE 1.00"), "{out}");
    // From another folder, by another name of the same file.
    let elsewhere = folder.path().join("elsewhere");
    std::fs::create_dir(&elsewhere).expect("a folder");
    let again = [
        "../ball.xml",
        "--spp",
        "4",
        "--size",
        "64x64",
        "--rounds",
        "2",
        "--against",
        "../old.json",
    ];
    let (code, out, _) = told(&bench(&elsewhere, &again));
    assert_eq!(code, 0);
    assert!(
        out.contains("rounds: 1; this run has ") && out.contains("rounds: 2)"),
        "{out}"
    );
    // That there is nothing to compare is said before time is spent.
    let other = ["ball.xml", "--spp", "2", "--size", "64x64", "--against", "old.json"];
    let (code, out, error) = told(&bench(folder.path(), &[&other[..], &["--json", "new.json"]].concat()));
    assert_eq!((code, out.as_str()), (1, ""));
    assert!(
        !folder.path().join("new.json").exists() && !error.contains("ball.xml ..."),
        "{error}"
    );
    for part in [
        "error: nothing to compare with old.json",
        "it has ball.xml at 64 x 64 and 4 spp",
        "this run has ball.xml at 64 x 64 and 2 spp",
    ] {
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn rays_are_checked() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).expect("can be written");
    write("one.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let rays = |t: f32| {
        let mut bytes = b"RAYS".to_vec();
        bytes.extend([1u32, 1, 32].map(u32::to_le_bytes).as_flattened());
        bytes.extend(
            [0.2f32, 0.2, 3.0, 0.0, 0.0, -1.0, t]
                .map(f32::to_le_bytes)
                .as_flattened(),
        );
        bytes.extend(0u32.to_le_bytes());
        bytes
    };
    write("right.rays", &rays(3.0));
    write("wrong.rays", &rays(2.0));
    let of = |rays| {
        [
            "rays", "--mesh", "one.obj", "--rays", rays, "--rounds", "1", "--json", "-",
        ]
    };
    let (code, out, _) = told(&bench(folder.path(), &of("right.rays")));
    let json: Value = serde_json::from_str(&out).expect("nothing but JSON");
    assert_eq!((code, json["rays"][0]["wrong"].as_u64()), (0, Some(0)));
    assert!(json["rays"][0]["closest"]["one_thread"].as_f64() > Some(0.0), "{json}");
    assert!(
        json["rays"][0]["closest_together"]["one_thread"].as_f64() > Some(0.0),
        "{json}"
    );
    let (code, out, error) = told(&bench(folder.path(), &of("wrong.rays")));
    assert!(error.contains("error: wrong answers: 1"), "{error}");
    let json: Value = serde_json::from_str(&out).expect("nothing but JSON");
    assert_eq!((code, json["rays"][0]["wrong"].as_u64()), (1, Some(1)));
}

#[test]
fn what_cannot_be_measured_is_said() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(folder.path().join("ball.xml"), SCENE).expect("can be written");
    std::fs::write(folder.path().join("other.json"), "{\n  \"a\": }").expect("can be written");
    for (arguments, expected) in [
        (&["nothing.xml"][..], "nothing.xml"),
        (&[][..], "folder `scenes`"),
        (&["ball.xml", "--rounds", "0"], "--rounds"),
        (&["ball.xml", "--json", "nowhere/a.json"], "there is no folder nowhere"),
        (
            &["ball.xml", "--spp", "1", "--size", "64x64", "--against", "other.json"],
            "other.json:2:8",
        ),
    ] {
        let (code, _, error) = told(&bench(folder.path(), arguments));
        assert!(code != 0 && error.contains(expected), "{arguments:?}: {error}");
    }
}
