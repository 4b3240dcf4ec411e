//! The memory and the time that a scene file takes per shape, from its text to the first sample.
//!
//! `cargo bench --bench shapes -- [TABLE...]` writes generated scenes, renders each with one sample per pixel in a
//! process of its own, and prints a line for each; named tables alone if any are named. "peak" is the most memory that
//! the process held, "each" its growth over a scene of one shape, divided by the number of shapes. "load" is the time
//! until everything is read.

use std::fmt::Write as _;
use std::path::Path;
use std::process::Command;

/// Shapes of the tables with one entity for each shape.
const COUNTS: [u32; 3] = [10_000, 100_000, 300_000];
/// An entry of the table with instances of one group.
const INSTANCES: [u32; 3] = [10_000, 100_000, 1_000_000];

/// The elements of a scene with so many shapes.
type Body = fn(u32) -> String;

fn main() {
    let names: Vec<String> = std::env::args()
        .skip(1)
        .filter(|argument| argument != "--bench")
        .collect();
    let tables: [(&str, &str, [u32; 3], Body); 4] = [
        ("spheres", "spheres of one bsdf", COUNTS, spheres),
        ("moved", "spheres with a transform", COUNTS, moved_spheres),
        ("bsdfs", "spheres with a bsdf each", COUNTS, spheres_with_bsdfs),
        ("instances", "instances of a group", INSTANCES, instances),
    ];
    println!(
        "{:<26}{:>10} {:>12} {:>10} {:>12} {:>12}",
        "", "count", "text (MB)", "load (s)", "peak (MB)", "each (B)"
    );
    for (name, what, counts, body) in tables {
        if names.is_empty() || names.iter().any(|wanted| wanted == name) {
            table(what, &counts, body);
        }
    }
}

fn table(what: &str, counts: &[u32], body: Body) {
    let one = measure(&body(1));
    for &count in counts {
        let text = body(count);
        let scene = measure(&text);
        let growth = scene.peak - one.peak;
        println!(
            "{what:<26}{count:>10} {:>12.1} {:>10.2} {:>12.0} {:>12.0}",
            text.len() as f64 / 1e6,
            scene.load,
            scene.peak / 1e6,
            growth / f64::from(count),
        );
    }
}

struct Measured {
    /// In seconds.
    load: f64,
    /// In bytes.
    peak: f64,
}

/// Renders a scene of these elements.
fn measure(body: &str) -> Measured {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let scene = folder.path().join("scene.xml");
    std::fs::write(&scene, whole(body)).expect("a scene file");
    let output = Command::new(env!("CARGO_BIN_EXE_sunroom"))
        .arg("render")
        .args([&scene, Path::new("-o"), &folder.path().join("picture.png")])
        .args(["--spp", "1", "--size", "32x32", "--stats=json"])
        .output()
        .expect("the program");
    let figures = String::from_utf8_lossy(&output.stdout);
    let figures: serde_json::Value = serde_json::from_str(&figures)
        .unwrap_or_else(|_| panic!("no figures: {}", String::from_utf8_lossy(&output.stderr)));
    let figure = |name: &str| figures[name].as_f64().expect("a figure");
    Measured {
        load: figure("load_ms") / 1e3,
        peak: figure("peak_memory_bytes"),
    }
}

fn whole(body: &str) -> String {
    format!(
        r#"<scene version="3.0.0">
<integrator type="path"><integer name="max_depth" value="3"/></integrator>
<sensor type="perspective"><transform name="to_world"><lookat origin="0, 0, 5" target="0, 0, 0" up="0, 1, 0"/></transform></sensor>
<emitter type="constant"/>
<bsdf type="diffuse" id="grey"><rgb name="reflectance" value="0.5"/></bsdf>
{body}</scene>
"#
    )
}

fn spheres(count: u32) -> String {
    written(count, |text, [x, y, z, _], radius| {
        writeln!(
            text,
            r#"<shape type="sphere"><point name="center" x="{x:.6}" y="{y:.6}" z="{z:.6}"/><float name="radius" value="{radius:.6}"/><ref id="grey"/></shape>"#
        )
    })
}

fn moved_spheres(count: u32) -> String {
    written(count, |text, [x, y, z, _], radius| {
        writeln!(
            text,
            r#"<shape type="sphere"><transform name="to_world"><scale value="{radius:.6}"/><translate x="{x:.6}" y="{y:.6}" z="{z:.6}"/></transform><ref id="grey"/></shape>"#
        )
    })
}

fn spheres_with_bsdfs(count: u32) -> String {
    written(count, |text, [x, y, z, grey], radius| {
        let grey = grey.abs();
        writeln!(
            text,
            r#"<shape type="sphere"><point name="center" x="{x:.6}" y="{y:.6}" z="{z:.6}"/><float name="radius" value="{radius:.6}"/><bsdf type="diffuse"><rgb name="reflectance" value="{grey:.3}, 0.5, 0.5"/></bsdf></shape>"#
        )
    })
}

fn instances(count: u32) -> String {
    let group = "<shape type=\"shapegroup\" id=\"group\"><shape type=\"cube\"/><shape type=\"disk\"/></shape>\n";
    let instances = written(count, |text, [x, y, z, turn], size| {
        let angle = 180.0 * turn;
        writeln!(
            text,
            r#"<shape type="instance"><ref id="group"/><transform name="to_world"><scale value="{size:.6}"/><rotate y="1" angle="{angle:.4}"/><translate x="{x:.6}" y="{y:.6}" z="{z:.6}"/></transform></shape>"#
        )
    });
    group.to_owned() + &instances
}

/// Each shape has four numbers in [-1, 1] of its own, and all have a size with which they fill a part of the cube [-1,
/// 1]^3.
fn written(count: u32, shape: impl Fn(&mut String, [f32; 4], f32) -> std::fmt::Result) -> String {
    let size = 0.5 / (count as f32).cbrt();
    let mut text = String::new();
    for index in 0..count {
        // Multiples of irrational numbers (Roberts, "The Unreasonable Effectiveness of Quasirandom Sequences", 2018).
        let numbers = [0.856_674_9, 0.733_891_9, 0.628_706_7, 0.538_596_9_f64]
            .map(|step| (2.0 * (step * f64::from(index)).fract() - 1.0) as f32);
        shape(&mut text, numbers, size).expect("texts take any number");
    }
    text
}
