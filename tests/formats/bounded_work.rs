//! Scenes whose parts would take far more memory or time than their files promise, or whose numbers go to infinity.

use std::path::Path;

use sunroom::document::{self, Severity};
use sunroom::scene::SceneDescription;
use sunroom::scene::read::read;

/// A scene with this body, and the errors and warnings about it.
fn describe(body: &str) -> (SceneDescription, Vec<String>) {
    describe_text(&format!(
        "<scene version='3.0.0'><sensor type='perspective'/>\n{body}\n</scene>"
    ))
}

fn describe_text(text: &str) -> (SceneDescription, Vec<String>) {
    let mut document = document::parse_str(text, Path::new("/nowhere/scene.xml"), &[]);
    let scene = read(&mut document);
    let worse = document.diagnostics.list.iter();
    let worse = worse.filter(|message| message.severity > Severity::Note);
    (scene, worse.map(|message| message.message.clone()).collect())
}

#[test]
fn maps_of_textures_are_finite() {
    let bsdf = |steps: &str| {
        format!(
            "<bsdf type='diffuse'><texture type='checkerboard' name='reflectance'>\
             <transform name='to_uv'>{steps}</transform></texture></bsdf>"
        )
    };
    let (_, said) = describe(&bsdf("<scale value='3e38'/><scale value='10'/>"));
    assert_eq!(said, ["`to_uv` is not finite: its steps together are too large"]);
    let (_, said) = describe(&bsdf("<scale value='3e37'/><scale value='10'/>"));
    assert_eq!(said, [""; 0]);
}

/// Checkerboards of daylight of checkerboards, each twice, `depth` times.
fn checkered_daylight(depth: usize) -> String {
    let mut scene = String::new();
    for i in 1..depth {
        let next = i + 1;
        scene += &format!(
            "<texture type='checkerboard' id='c{i}'><ref name='color0' id='d{next}'/><ref name='color1' id='d{next}'/></texture>\
             <spectrum type='d65' id='d{i}'><ref id='c{i}'/></spectrum>\n"
        );
    }
    scene + &format!("<spectrum type='d65' id='d{depth}'/><bsdf type='diffuse'><ref name='reflectance' id='d1'/></bsdf>")
}

#[test]
fn textures_of_daylight_count_like_others() {
    // 2 to the power of 20 textures, and with four levels a few.
    for (depth, expected) in [(20, true), (4, false)] {
        let (_, said) = describe(&checkered_daylight(depth));
        let refused = said == ["`reflectance` consists of more than 256 textures"];
        assert!(refused == expected && (refused || said.is_empty()), "{depth}: {said:?}");
    }
}
