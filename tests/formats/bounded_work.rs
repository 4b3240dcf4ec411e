//! Scenes whose parts would take far more memory or time than their files promise, or whose numbers go to infinity.

use std::path::Path;

use sunroom::document::{self, Severity};
use sunroom::scene::description::DeclarationPlace;
use sunroom::scene::read::read;
use sunroom::scene::{Material, SceneDescription};

use crate::workshop::Workshop;

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

/// So many that a walk through all of them for each takes far longer than any test.
const VERY_MANY: usize = 100_000;

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
    scene
        + &format!("<spectrum type='d65' id='d{depth}'/><bsdf type='diffuse'><ref name='reflectance' id='d1'/></bsdf>")
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

#[test]
fn a_group_may_have_very_many_shapes() {
    let inside = "<shape type='sphere'/>".repeat(VERY_MANY);
    let (scene, said) = describe(&format!(
        "<shape type='shapegroup' id='g'>{inside}<ref id='other'/></shape><shape type='sphere' id='other'/>\
         <shape type='instance'><ref id='g'/></shape>"
    ));
    assert_eq!(
        said,
        ["the shapes of a shapegroup are written inside it: those it refers to are left out"]
    );
    let members = scene.shapes.iter().filter(|shape| shape.member_of == Some(0));
    assert_eq!((members.count(), scene.shapes.len()), (VERY_MANY, VERY_MANY + 2));
}

#[test]
fn very_many_shapes_may_be_flattened() {
    let shape = |scale: &str| {
        format!(
            "<shape type='sphere'><transform name='to_world'><scale value='{scale}'/></transform><bsdf type='diffuse'/>\
             <medium type='homogeneous' name='interior'/></shape>"
        )
    };
    let (scene, said) = describe(&[shape("1"), shape("0").repeat(VERY_MANY), shape("2")].concat());
    assert!(said[0].starts_with("`to_world` cannot be undone"), "{}", said[0]);
    assert_eq!((scene.shapes.len(), scene.materials.len()), (2, VERY_MANY + 2));
    let materials = scene.materials.iter().map(|material| material.declared_in);
    let media = scene.media.iter().map(|medium| medium.declared_in);
    for mut places in [materials.collect::<Vec<_>>(), media.collect()] {
        assert_eq!(places.pop(), Some(DeclarationPlace::Shape(1)));
        assert_eq!(places[0], DeclarationPlace::Shape(0));
        assert!(places[1..].iter().all(|place| *place == DeclarationPlace::TopLevel));
    }
}

#[test]
fn light_may_go_below_the_surface_of_very_many_objects() {
    let objects = "<Sphere material='wax'/>".repeat(VERY_MANY);
    let (scene, said) = describe_text(&format!(
        "<ItemContainer><Config><Width value='100'/><Aspect_ratio value='1.5'/><Samples_Per_Pixel value='4'/><Max_Depth value='3'/></Config>\
         <Camera/><Lights><Sun/></Lights><Materials><SSS name='wax'><Color r='0.8' g='0.8' b='0.8'/><ScatterDistance value='0.5'/></SSS>\
         </Materials><Objects>{objects}</Objects></ItemContainer>"
    ));
    assert_eq!(said, [""; 0]);
    assert_eq!(scene.integrator.max_depth, Some(256));
    assert_eq!(scene.shapes.len(), VERY_MANY);
    let materials = scene.shapes.iter().filter_map(|shape| shape.material);
    let mut materials = materials.map(|material| &scene.materials[material].material);
    assert!(materials.all(|material| *material == Material::Null));
}

#[test]
fn a_thing_has_a_thousand_values_with_keys() {
    let keys = |i: usize| format!("<animation name='p{i}'><float time='0' value='1'/></animation>");
    for (count, is_bounded) in [(900, false), (1200, true)] {
        let keys: String = (0..count).map(keys).collect();
        let (scene, said) = describe(&format!("<bsdf type='diffuse'>{keys}</bsdf>"));
        let message = "more than 1000 values of bsdf `diffuse` have keys: the others do not move";
        assert_eq!(said.iter().any(|said| said == message), is_bounded, "{count}");
        let kept = scene.materials[0].identity.keys.as_ref().expect("keys");
        assert_eq!(kept.tracks().count(), count.min(1000));
    }
}

#[test]
fn a_scene_names_so_many_grids_of_a_file() {
    let medium = |i: usize| {
        format!(
            "<medium type='heterogeneous' id='m{i}'><volume type='vdbvolume' name='sigma_t'><string name='filename' value='smoke.vdb'/>\
             <string name='grid' value='g{}'/></volume></medium>",
            // Each grid is named twice.
            i / 2
        )
    };
    for (count, is_bounded) in [(128, false), (132, true)] {
        let media: String = (0..count).map(medium).collect();
        let (scene, said) = describe(&media);
        let refused = said
            .iter()
            .filter(|said| *said == "more than 64 grids of one file are named");
        assert_eq!(refused.count(), if is_bounded { 4 } else { 0 }, "{said:?}");
        assert_eq!(scene.volume_places.len(), 64);
    }
}

#[test]
fn an_export_leaves_out_a_picture_as_wide_as_one_and_as_high_as_another() {
    let shop = Workshop::new();
    for (name, width, height) in [("wide.png", 1_000_000, 1), ("tall.png", 1, 1_000_000)] {
        let picture = image::GrayImage::new(width, height);
        picture.save(shop.path(name)).expect("a picture");
    }
    let bitmap = |name: &str, file: &str| {
        format!(
            "<texture type='bitmap' name='{name}'><string name='filename' value='{file}'/><boolean name='raw' value='true'/></texture>"
        )
    };
    let scene = format!(
        "<scene version='3.0.0'><sensor type='perspective'/><emitter type='point'/><shape type='rectangle'><bsdf type='twosided'>\
         <bsdf type='principled'>{}{}</bsdf></bsdf></shape></scene>",
        bitmap("roughness", "wide.png"),
        bitmap("metallic", "tall.png")
    );
    shop.put("scene.xml", scene);
    let output = shop.sunroom(&["convert", "scene.xml", "scene.glb"]);
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{said}");
    let expected = "the picture of 1000000 x 1000000 pixels cannot be made: it needs 40.0 TB of memory";
    assert!(said.contains(expected), "{said}");
}
