//! Participating media from the scene file to components and back: what is read, what is warned of, and what is
//! written.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use bevy::math::{Affine3A, UVec3, Vec3};
use bevy::prelude::*;
use sunroom::color::Rgb;
use sunroom::document::{self, Diagnostics};
use sunroom::math::Aabb;
use sunroom::medium::{VolumeGrid, Voxels, write_vol};
use sunroom::scene::read::read;
use sunroom::scene::write::{Extensions, files, write_anew};
use sunroom::scene::*;

use crate::meaning::meaning;

/// The scene of a body that begins on line 2.
fn describe(body: &str) -> (SceneDescription, Diagnostics) {
    let text =
        format!("<scene version='3.0.0'>\n{body}\n<integrator type='volpath'/><sensor type='perspective'/></scene>");
    let mut document = document::parse_str(&*text, Path::new("/somewhere/scene.xml"), &[]);
    let scene = read(&mut document);
    (scene, document.diagnostics)
}

fn good(body: &str) -> SceneDescription {
    let (scene, diagnostics) = describe(body);
    assert!(diagnostics.list.is_empty(), "{diagnostics}");
    scene
}

fn medium(plugin: &str, inside: &str) -> Medium {
    let scene = good(&format!("<medium type='{plugin}' id='m'>{inside}</medium>"));
    scene.media[0].medium.clone()
}

fn phase(text: &str) -> PhaseFunction {
    medium("homogeneous", text).phase
}

/// The messages of a body, each with its line and column.
fn messages(body: &str) -> Vec<String> {
    let (_, diagnostics) = describe(body);
    let line = |message| diagnostics.line(message).trim_start_matches("/somewhere/").to_owned();
    diagnostics.list.iter().map(line).collect()
}

fn extinction(medium: &Medium) -> (VolumeParameter<Rgb>, VolumeParameter<Rgb>) {
    match &medium.coefficients {
        Coefficients::Extinction { sigma_t, albedo } => (sigma_t.clone(), albedo.clone()),
        separate => panic!("{separate:?}"),
    }
}

fn grid(path: &str) -> GridFile {
    GridFile {
        path: path.into(),
        ..GridFile::default()
    }
}

#[test]
fn media_have_the_defaults_of_the_format() {
    let homogeneous = medium("homogeneous", "");
    assert_eq!(Some(&homogeneous), Medium::of_plugin("homogeneous").as_ref());
    assert_eq!(extinction(&homogeneous), (Rgb::ONE.into(), Rgb::splat(0.75).into()));
    assert_eq!(
        (homogeneous.scale, &homogeneous.phase),
        (1.0, &PhaseFunction::Isotropic)
    );
    assert_eq!(homogeneous.emission, Rgb::ZERO.into());
    // A heterogeneous medium ends with the box of its density, also where that is the same all over the box.
    let (sigma_t, albedo) = extinction(&medium("heterogeneous", "<float name='sigma_t' value='2'/>"));
    let to_world = Affine3A::IDENTITY;
    assert_eq!(
        sigma_t,
        VolumeParameter::Box {
            value: Rgb::splat(2.0),
            to_world
        }
    );
    assert_eq!(albedo, Rgb::splat(0.75).into());
    assert_eq!(phase("<phase type='hg'/>"), PhaseFunction::HenyeyGreenstein { g: 0.8 });
}

#[test]
fn coefficients_are_numbers_colours_spectra_and_volumes() {
    let sigma_t = |text: &str| extinction(&medium("homogeneous", text)).0;
    let five = Rgb::splat(5.0).into();
    assert_eq!(sigma_t("<float name='sigma_t' value='5'/>"), five);
    assert_eq!(sigma_t("<integer name='sigma_t' value='5'/>"), five);
    assert_eq!(sigma_t("<spectrum name='sigma_t' value='5'/>"), five);
    assert_eq!(
        sigma_t("<spectrum type='uniform' name='sigma_t'><float name='value' value='5'/></spectrum>"),
        five
    );
    assert_eq!(
        sigma_t("<rgb name='sigmaT' value='5, 2, 1'/>"),
        Rgb::new(5.0, 2.0, 1.0).into()
    );
    let constant = "<volume type='constvolume' name='sigma_t'><rgb name='value' value='5, 2, 1'/></volume>";
    assert_eq!(sigma_t(constant), Rgb::new(5.0, 2.0, 1.0).into());

    let separate = medium(
        "homogeneous",
        "<rgb name='sigma_s' value='3, 0, 0'/><rgb name='sigma_a' value='1, 2, 0'/><float name='scale' value='10'/>",
    );
    let (sigma_t, albedo) = separate.coefficients.sigma_t_and_albedo();
    assert_eq!(
        (sigma_t, albedo),
        (Rgb::new(4.0, 2.0, 0.0).into(), Rgb::new(0.75, 0.0, 0.0).into())
    );
    assert_eq!(separate.scale, 10.0);

    let smoke = "<volume type='gridvolume' name='sigma_t'>
            <string name='filename' value='smoke.vol'/><string name='filter_type' value='nearest'/>
            <string name='wrap_mode' value='mirror'/><boolean name='use_grid_bbox' value='true'/>
            <transform name='to_world'><scale value='2'/></transform><boolean name='raw' value='true'/></volume>
        <volume type='gridvolume' name='albedo'><string name='filename' value='/colours.vol'/></volume>
        <rgb name='emission' value='1, 0.5, 0'/><float name='emission_scale' value='20'/>";
    let smoke = medium("heterogeneous", smoke);
    let density = GridFile {
        to_world: Affine3A::from_scale(Vec3::splat(2.0)),
        filter: VolumeFilter::Nearest,
        wrap: VolumeWrap::Mirror,
        use_grid_bbox: true,
        ..grid("/somewhere/smoke.vol")
    };
    let colours = VolumeParameter::Grid(grid("/colours.vol"));
    assert_eq!(extinction(&smoke), (VolumeParameter::Grid(density), colours));
    assert_eq!(
        (&smoke.emission, smoke.emission_scale),
        (&Rgb::new(1.0, 0.5, 0.0).into(), 20.0)
    );
}

#[test]
fn phase_functions_are_read() {
    assert_eq!(phase("<phase type='isotropic'/>"), PhaseFunction::Isotropic);
    assert_eq!(phase("<phase type='rayleigh' name='any'/>"), PhaseFunction::Rayleigh);
    let hg = |g| PhaseFunction::HenyeyGreenstein { g };
    assert_eq!(
        phase("<phase type='hg'><float name='g' value='-0.3'/></phase>"),
        hg(-0.3)
    );
    let table = "<phase type='tabphase'><string name='values' value='0.5, 1, 2e0 3'/></phase>";
    assert_eq!(
        phase(table),
        PhaseFunction::Tabulated {
            values: vec![0.5, 1.0, 2.0, 3.0]
        }
    );
    let blend = "<phase type='blendphase'><float name='weight' value='0.25'/><phase type='hg'/>
        <phase type='blendphase'><volume type='gridvolume' name='weight'><string name='filename' value='/w.vol'/></volume>
            <phase type='rayleigh'/><phase type='hg'><float name='g' value='0.1'/></phase></phase></phase>";
    let mixed = |weight, of| PhaseFunction::Blend(Box::new(PhaseBlend { weight, of }));
    let inner = mixed(
        VolumeParameter::Grid(grid("/w.vol")),
        [PhaseFunction::Rayleigh, hg(0.1)],
    );
    assert_eq!(phase(blend), mixed(0.25.into(), [hg(0.8), inner]));
}

#[test]
fn shapes_cameras_and_lights_say_what_they_are_in() {
    let scene = good(
        "<shape type='sphere'><ref name='interior' id='fog'/>
            <medium type='homogeneous' name='exterior'><float name='scale' value='3'/></medium></shape>
        <medium type='homogeneous' id='fog'/>
        <emitter type='point'><ref id='fog'/></emitter>
        <sensor type='perspective'><ref name='medium' id='fog'/></sensor>
        <shape type='shapegroup' id='group'><shape type='cube'><ref name='interior' id='fog'/></shape></shape>
        <shape type='instance'><ref id='group'/></shape>",
    );
    // They are in the order of the file.
    assert_eq!(scene.media[0].medium.scale, 3.0);
    assert_eq!(scene.media[1].identity.id.as_deref(), Some("fog"));
    let (inner, outer) = (scene.shapes[0].interior, scene.shapes[0].exterior);
    assert_eq!((inner, outer), (Some(1), Some(0)));
    assert_eq!((scene.emitters[0].medium, scene.sensors[0].medium), (Some(1), Some(1)));
    assert_eq!((scene.shapes[1].interior, scene.shapes[2].interior), (Some(1), None));
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let fog = |inside: &str| messages(&format!("<medium type='homogeneous' id='fog'>\n{inside}</medium>"));
    for (inside, expected) in [
        (
            "<float name='sigma_t' value='-1'/>",
            "scene.xml:3:1: error: `sigma_t` is -1, but should be at least 0",
        ),
        (
            "<rgb name='albedo' value='0.5, 2, 0'/>",
            "scene.xml:3:1: error: `albedo` is 2, but should be at least 0 and at most 1",
        ),
        (
            "<float name='sigma_t' value='nan'/>",
            "expected a finite number, found `nan`",
        ),
        (
            "<float name='scale' value='-2'/>",
            "scene.xml:3:1: error: `scale` is -2",
        ),
        (
            "<rgb name='emission' value='-1'/>",
            "scene.xml:3:1: error: `emission` is -1",
        ),
        (
            "<float name='sigma_x' value='1'/>",
            "`sigma_x` is not a parameter of medium `homogeneous`",
        ),
        (
            "<float name='sigma_t' value='1'/><float name='sigma_a' value='1'/>",
            "scene.xml:3:34: error: `sigma_t`, `albedo` and `sigma_s`, `sigma_a` exclude each other",
        ),
        (
            "<phase type='hg'><float name='g' value='1'/></phase>",
            "scene.xml:3:18: error: `g` is 1",
        ),
        (
            "<phase type='sggx'><float name='S' value='1'/></phase>",
            "scene.xml:3:1: warning: phase `sggx` is not supported: `isotropic` takes its place",
        ),
        (
            "<phase type='hg'/><phase type='hg'/>",
            "scene.xml:3:19: error: medium `homogeneous` has a phase function already",
        ),
        (
            "<phase type='tabphase'/>",
            "scene.xml:3:1: error: phase `tabphase` needs `values`",
        ),
        (
            "<phase type='tabphase'><string name='values' value='1'/></phase>",
            "scene.xml:3:24: error: a table needs at least two numbers, found 1",
        ),
        (
            "<phase type='tabphase'><string name='values' value='1, -1'/></phase>",
            "scene.xml:3:24: error: a number of the table is negative",
        ),
        (
            "<phase type='tabphase'><string name='values' value='0 0'/></phase>",
            "all numbers of the table are 0",
        ),
        (
            "<phase type='tabphase'><string name='values' value='1 x'/></phase>",
            "expected a number, found `x`",
        ),
        (
            "<phase type='blendphase'><float name='weight' value='1'/><phase type='hg'/></phase>",
            "scene.xml:3:1: error: `blendphase` takes two phase functions, found 1",
        ),
        (
            "<phase type='blendphase'><phase type='hg'/><phase type='hg'/></phase>",
            "scene.xml:3:1: error: phase `blendphase` needs a `weight`",
        ),
        (
            "<volume type='gridvolume' name='sigma_t'/>",
            "scene.xml:3:1: error: a `gridvolume` needs a `filename`",
        ),
        (
            "<volume type='sdfgrid' name='sigma_t'/>",
            "scene.xml:3:1: error: volume `sdfgrid` is not supported",
        ),
        (
            "<volume type='gridvolume' name='albedo'><string name='filename' value='a.vol'/><string name='wrap_mode' value='black'/></volume>",
            "expected `clamp` or `repeat` or `mirror` for `wrap_mode`, found `black`",
        ),
        (
            "<volume type='gridvolume' name='sigma_t'><string name='filename' value='a.vol'/></volume>",
            "scene.xml:3:1: warning: `homogeneous` is the same everywhere",
        ),
        (
            "<texture type='checkerboard' name='sigma_t'/>",
            "`sigma_t` should be a colour or a volume, found texture `checkerboard`",
        ),
        (
            "<bsdf type='diffuse'/>",
            "bsdf `diffuse` has no effect in medium `homogeneous`",
        ),
    ] {
        let mut found = fog(inside);
        // A scene that is refused has its missing files named as well.
        if found.iter().any(|it| it.contains(": error: ")) {
            found.retain(|it| !it.contains("volume /somewhere/a.vol: no such file"));
        }
        assert_eq!(found.len(), 1, "{inside}: {found:?}");
        assert!(found[0].contains(expected), "{inside}: {found:?}");
    }
    for (body, expected) in [
        (
            "<medium type='homogenous' id='fog'/>",
            "scene.xml:2:1: error: medium `homogenous` is not known",
        ),
        (
            "<shape type='sphere'><ref name='interior' id='smog'/></shape>",
            "scene.xml:2:22: error",
        ),
        (
            "<shape type='sphere'><medium type='homogeneous' name='inside'/></shape>",
            "scene.xml:2:22: warning: medium `homogeneous` is given for `inside`",
        ),
        (
            "<shape type='sphere'><medium type='homogeneous'/></shape>",
            "medium `homogeneous` has no effect in shape `sphere`",
        ),
        (
            "<shape type='sphere'><bsdf type='diffuse' name='interior'/></shape>",
            "`interior` should be a medium, found bsdf `diffuse`",
        ),
        (
            "<emitter type='point'><medium type='homogeneous'/><medium type='homogeneous'/></emitter>",
            "scene.xml:2:51: error: a second medium",
        ),
        (
            "<medium type='heterogeneous' id='a'><float name='sigma_s' value='1'/></medium>",
            "`sigma_s` is for a `homogeneous` medium",
        ),
    ] {
        let found = messages(body);
        assert_eq!(found.len(), 1, "{body}: {found:?}");
        assert!(found[0].contains(expected), "{body}: {found:?}");
    }
}

/// A few references mean very many phase functions; it is refused before they are made.
#[test]
fn a_short_file_cannot_mean_endless_phase_functions() {
    let mut body = String::from("<phase type='hg' id='p0'/>");
    for level in 1..12 {
        let inner = level - 1;
        body += &format!(
            "<phase type='blendphase' id='p{level}'><float name='weight' value='0.5'/><ref id='p{inner}'/><ref id='p{inner}'/></phase>"
        );
    }
    body += "<medium type='homogeneous' id='m'><ref id='p11'/></medium>";
    let found = messages(&body);
    assert!(
        found.len() == 1 && found[0].contains("consists of more than 64"),
        "{found:?}"
    );
}

#[test]
fn path_says_that_it_leaves_media_out() {
    let with = |integrator: &str| {
        let text = format!(
            "<scene version='3.0.0'>{integrator}<sensor type='perspective'/>\n<medium type='homogeneous' id='m'/></scene>"
        );
        let mut document = document::parse_str(&*text, Path::new("/scene.xml"), &[]);
        let scene = read(&mut document);
        let lines: Vec<String> = document
            .diagnostics
            .list
            .iter()
            .map(|it| document.diagnostics.line(it))
            .collect();
        (scene.integrator, lines)
    };
    let (path, lines) = with("<integrator type='path'/>");
    assert_eq!(path.plugin, PathPlugin::Path);
    assert!(
        lines[0].contains(":1:24: warning: `path` leaves out the media of the scene; `volpath` traces them"),
        "{lines:?}"
    );
    assert!(with("").1[0].contains("has no integrator"));
    let volpath = "<integrator type='volpath'><integer name='max_depth' value='7'/><boolean name='hide_emitters' value='true'/></integrator>";
    let (settings, lines) = with(volpath);
    assert_eq!(lines, [""; 0]);
    assert_eq!(
        (settings.plugin, settings.max_depth, settings.hide_emitters),
        (PathPlugin::VolPath, Some(7), true)
    );
    let (settings, lines) =
        with("<integrator type='volpathmis'><boolean name='use_spectral_mis' value='false'/></integrator>");
    assert_eq!((settings.plugin, lines.len()), (PathPlugin::VolPathMis, 0));
    for (name, plugin) in [
        ("bdpt", PathPlugin::Bdpt),
        ("vcm", PathPlugin::Vcm),
        ("ptracer", PathPlugin::Ptracer),
    ] {
        let (settings, lines) = with(&format!("<integrator type='{name}'/>"));
        assert_eq!(settings.plugin, plugin);
        assert!(
            lines[0].contains(&format!("`{name}` leaves out the media")),
            "{lines:?}"
        );
    }
    let (settings, lines) = with("<integrator type='auto'/>");
    assert_eq!((settings.plugin, lines.len()), (PathPlugin::Auto, 0));
    let around =
        "<integrator type='aov'><string name='aovs' value='dd:depth'/><integrator type='volpath'/></integrator>";
    assert_eq!(with(around).0.plugin, PathPlugin::VolPath);
}

#[test]
fn photons_have_a_number_and_a_radius() {
    let with = |parameters: &str| {
        let text = format!("<scene version='3.0.0'><integrator type='vcm'>{parameters}</integrator></scene>");
        let mut document = document::parse_str(&*text, Path::new("/scene.xml"), &[]);
        let settings = read(&mut document).integrator;
        let list = document.diagnostics.list.iter();
        let lines: Vec<String> = list.map(|it| it.message.clone()).collect();
        (settings.photons, settings.merge_radius, lines)
    };
    let of = |photons: &str, radius: &str| {
        with(&format!(
            "<integer name='photons' value='{photons}'/><float name='merge_radius' value='{radius}'/>"
        ))
    };
    let (photons, radius, said) = of("70000", "1.5");
    assert_eq!((photons, radius), (Some(70000), 1.5));
    // Nothing is wrong: what is said otherwise is that there is no camera.
    for usual in [with(""), of("0", "3")] {
        assert_eq!(usual, (None, 3.0, said.clone()));
    }
    for (photons, radius, wrong) in [
        ("-1", "3", "photons"),
        ("262145", "3", "photons"),
        ("0", "0", "merge_radius"),
    ] {
        let (count, pixels, lines) = of(photons, radius);
        assert_eq!((count, pixels), (None, 3.0));
        assert!(lines.iter().any(|line| line.contains(wrong)), "{lines:?}");
    }
}

#[test]
fn paths_are_guided_if_the_file_says_so() {
    let text = |plugin: &str, guided: &str| {
        format!("<scene version='3.0.0'><integrator type='{plugin}'>{guided}</integrator></scene>")
    };
    let property = "<boolean name='guided' value='true'/>";
    let with = |plugin: &str| {
        let mut document = document::parse_str(&*text(plugin, property), Path::new("/scene.xml"), &[]);
        let settings = read(&mut document).integrator;
        let is_told_of = |it: &document::Diagnostic| it.message.contains("guided");
        (settings.guided, document.diagnostics.list.iter().any(is_told_of))
    };
    assert_eq!(with("path"), (true, false));
    assert_eq!(with("auto"), (true, false));
    assert_eq!(with("bdpt"), (false, true));
    let folder = tempfile::tempdir().unwrap();
    let target = folder.path().join("new.xml");
    let is_written = |guided: &str, extensions| {
        let scene = read_text(&text("path", guided), &folder.path().join("old.xml"));
        write_anew(&scene, &target, extensions).unwrap();
        let written = std::fs::read_to_string(&target).unwrap();
        assert_eq!(
            read_text(&written, &target).integrator.guided,
            written.contains("guided")
        );
        written.contains("guided")
    };
    assert!(is_written(property, Extensions::Keep));
    assert!(!is_written(property, Extensions::Approximate), "Mitsuba refuses it");
    assert!(!is_written("", Extensions::Keep));
}

#[test]
fn a_clamp_is_a_percentile() {
    let with = |value: &str| {
        let text = format!(
            "<scene version='3.0.0'><integrator type='path'><float name='clamp_percentile' value='{value}'/></integrator></scene>"
        );
        let mut document = document::parse_str(&*text, Path::new("/scene.xml"), &[]);
        let settings = read(&mut document).integrator;
        let is_refused = document
            .diagnostics
            .list
            .iter()
            .any(|it| it.message.contains("clamp_percentile"));
        (settings.clamp_percentile, is_refused)
    };
    assert_eq!(with("99.9"), (Some(99.9), false));
    for wrong in ["49", "100", "-1"] {
        assert_eq!(with(wrong), (None, true), "{wrong}");
    }
}

/// A scene with every plugin and parameter.
const EVERYTHING: &str = "<scene version=\"3.0.0\">
  <integrator type=\"volpathmis\"><boolean name=\"use_spectral_mis\" value=\"true\"/></integrator>
  <medium type=\"homogeneous\" id=\"fog\">
    <!-- thin -->
    <rgb name=\"sigma_t\" value=\".1 .2 .3\"/>
    <phase type=\"blendphase\">
      <phase type=\"hg\"><float name=\"g\" value=\".5\"/></phase>
      <ref id=\"sky\"/>
      <float name=\"weight\" value=\".25\"/>
    </phase>
  </medium>
  <phase type=\"rayleigh\" id=\"sky\"/>
  <volume type=\"gridvolume\" id=\"grid\"><string name=\"filename\" value=\"smoke.vol\"/></volume>
  <sensor type=\"perspective\">
    <ref id=\"fog\"/>
  </sensor>
  <shape type=\"cube\">
    <medium type=\"heterogeneous\" name=\"interior\">
      <ref name=\"sigma_t\" id=\"grid\"/>
      <float name=\"scale\" value=\"10\"/>
      <rgb name=\"emission\" value=\"1, .5, .25\"/>
      <float name=\"emission_scale\" value=\"2\"/>
      <phase type=\"tabphase\"><string name=\"values\" value=\"1, 2, 3\"/></phase>
    </medium>
    <ref name=\"exterior\" id=\"fog\"/>
  </shape>
  <shape type=\"sphere\">
    <medium type=\"homogeneous\" name=\"interior\">
      <rgb name=\"sigma_s\" value=\"1, 2, 3\"/>
      <rgb name=\"sigma_a\" value=\"3, 2, 1\"/>
    </medium>
  </shape>
  <emitter type=\"point\">
    <ref id=\"fog\"/>
  </emitter>
</scene>
";

fn read_text(text: &str, path: &Path) -> SceneDescription {
    let mut document = document::parse_str(text, path, &[]);
    let scene = read(&mut document);
    assert!(!document.diagnostics.has_errors(), "{}", document.diagnostics);
    scene
}

/// The text of the scene after an edit.
fn edited(edit: impl FnOnce(&mut SceneDescription)) -> String {
    let path = Path::new("/nowhere/scene.xml");
    let mut scene = read_text(EVERYTHING, path);
    edit(&mut scene);
    let (_, text) = files(&scene, path).unwrap().remove(0);
    let media = |scene: &SceneDescription| scene.media.iter().map(|it| it.medium.clone()).collect::<Vec<_>>();
    assert_eq!(media(&read_text(&text, path)).len(), scene.media.len(), "{text}");
    for medium in media(&read_text(&text, path)) {
        assert!(media(&scene).contains(&medium), "{text}");
    }
    text
}

/// The text of a scene of this body after an edit. The body may have faults.
fn edited_body(body: &str, edit: impl FnOnce(&mut SceneDescription)) -> String {
    let path = Path::new("/nowhere/scene.xml");
    let text =
        format!("<scene version='3.0.0'>\n{body}\n<integrator type='volpath'/><sensor type='perspective'/></scene>");
    let mut document = document::parse_str(&*text, path, &[]);
    let mut scene = read(&mut document);
    edit(&mut scene);
    files(&scene, path).unwrap().remove(0).1
}

#[test]
fn a_colour_above_one_takes_the_place_of_one() {
    let body = "<medium type='homogeneous' id='m'><rgb name='sigma_t' value='5 2 1'/></medium>";
    let text = edited_body(body, |scene| {
        if let Coefficients::Extinction { sigma_t, .. } = &mut scene.media[0].medium.coefficients {
            *sigma_t = Rgb::new(6.0, 2.0, 1.0).into();
        }
    });
    assert!(text.contains("6, 2, 1") && !text.contains("5 2 1"), "{text}");
}

#[test]
fn media_that_cannot_be_read_stay_in_the_file() {
    let body = "<shape type='sphere' id='ball'><medium type='homogenous' name='interior'><float name='scale' value='3'/></medium></shape>
        <emitter type='point' id='lamp'><medium type='smoke'/></emitter>";
    // Something else is edited in both.
    let move_both = |scene: &mut SceneDescription| {
        scene.shapes[0].to_world = Affine3A::from_translation(Vec3::X);
        scene.emitters[0].to_world = Affine3A::from_translation(Vec3::X);
    };
    let text = edited_body(body, move_both);
    assert!(text.contains("type='homogenous' name='interior'"), "{text}");
    assert!(text.contains("<medium type='smoke'/>"), "{text}");
    // A medium that is given to the shape takes the place of that which could not be read.
    let other = format!("{body}<medium type='homogeneous' id='fog'/>");
    let text = edited_body(&other, |scene| scene.shapes[0].interior = Some(0));
    assert!(!text.contains("homogenous'"), "{text}");
    assert_eq!(text.matches("name=\"interior\"").count(), 1, "{text}");
}

#[test]
fn keys_inside_a_medium_are_those_of_the_medium() {
    let body = "<shape type='sphere' id='ball'><medium type='homogeneous' name='interior' id='fog'>
        <animation name='scale'><float time='0' value='1'/><float time='1' value='3'/></animation></medium></shape>";
    let (scene, diagnostics) = describe(body);
    assert!(!diagnostics.has_errors(), "{diagnostics}");
    let tracks = |identity: &description::Identity| {
        let keys = identity.keys.iter().flat_map(|keys| keys.tracks());
        keys.map(|(path, _)| path.as_str().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(tracks(&scene.media[0].identity), ["scale"]);
    assert_eq!(tracks(&scene.shapes[0].identity), [""; 0]);
}

#[test]
fn a_spectrum_in_a_constant_volume_means_what_it_means_without() {
    let light = |inside: &str| medium("homogeneous", inside).emission;
    let black_body = |name: &str| {
        format!("<spectrum type='blackbody' name='{name}'><float name='temperature' value='2500'/></spectrum>")
    };
    let within = format!(
        "<volume type='constvolume' name='emission'>{}</volume>",
        black_body("value")
    );
    assert_eq!(light(&within), light(&black_body("emission")));
}

/// The lines that came with an edit.
fn lines_of_edit(edit: impl FnOnce(&mut SceneDescription)) -> Vec<String> {
    let text = edited(edit);
    let new = text.lines().filter(|line| !EVERYTHING.lines().any(|old| old == *line));
    new.map(|line| line.trim().to_owned()).collect()
}

#[test]
fn an_edit_changes_nothing_else_in_the_text() {
    assert_eq!(edited(|_| ()), EVERYTHING);
    // The comment stays.
    assert_eq!(
        lines_of_edit(|scene| scene.media[0].medium.scale = 4.0),
        ["<float name=\"scale\" value=\"4\"/>"]
    );
    let albedo = |scene: &mut SceneDescription| {
        if let Coefficients::Extinction { sigma_t, albedo } = &mut scene.media[0].medium.coefficients {
            *sigma_t = Rgb::new(5.0, 2.0, 1.0).into();
            *albedo = Rgb::new(0.5, 0.25, 1.0).into();
        }
    };
    let expected = [
        "<rgb name=\"albedo\" value=\"0.5, 0.25, 1\"/>",
        "<volume type=\"constvolume\" name=\"sigma_t\">",
        "<rgb name=\"value\" value=\"5, 2, 1\"/>",
        "</volume>",
    ];
    assert_eq!(lines_of_edit(albedo), expected);
    // The other part of the blend is still a reference.
    let inside = |scene: &mut SceneDescription| {
        if let PhaseFunction::Blend(blend) = &mut scene.media[0].medium.phase {
            blend.of[0] = PhaseFunction::HenyeyGreenstein { g: -0.5 };
        }
    };
    assert_eq!(
        lines_of_edit(inside),
        ["<phase type=\"hg\"><float name=\"g\" value=\"-0.5\"/></phase>"]
    );
    let other = lines_of_edit(|scene| scene.media[0].medium.phase = PhaseFunction::Rayleigh);
    assert_eq!(other, ["<phase type=\"rayleigh\">"]);
    let separate = |scene: &mut SceneDescription| {
        scene.media[2].medium.coefficients = Coefficients::Separate {
            sigma_s: Rgb::new(1.0, 2.0, 4.0),
            sigma_a: Rgb::new(3.0, 2.0, 1.0),
        };
    };
    assert_eq!(lines_of_edit(separate), ["<rgb name=\"sigma_s\" value=\"1, 2, 4\"/>"]);
    let joined = |scene: &mut SceneDescription| {
        scene.media[2].medium.coefficients = Coefficients::Extinction {
            sigma_t: Rgb::splat(4.0).into(),
            albedo: Rgb::splat(0.5).into(),
        };
    };
    let expected = [
        "<float name=\"sigma_t\" value=\"4\"/>",
        "<float name=\"albedo\" value=\"0.5\"/>",
    ];
    assert_eq!(lines_of_edit(joined), expected);
    let integrator = lines_of_edit(|scene| scene.integrator.max_depth = Some(9));
    assert!(
        integrator[0].contains("type=\"volpathmis\"") && integrator[0].contains("use_spectral_mis"),
        "{integrator:?}"
    );
}

#[test]
fn media_come_and_go_where_they_are_used() {
    let gone = edited(|scene| {
        scene.shapes[0].exterior = None;
        scene.emitters[0].medium = None;
        scene.sensors[0].medium = None;
    });
    assert!(
        !gone.contains("<ref id=\"fog\"/>") && !gone.contains("exterior"),
        "{gone}"
    );
    // A medium that something else uses, too, needs an id.
    let shared = edited(|scene| scene.emitters[0].medium = scene.shapes[0].interior);
    assert!(
        shared.contains("<medium type=\"heterogeneous\" name=\"interior\" id=\"medium-1\">"),
        "{shared}"
    );
    assert!(shared.contains("<ref id=\"medium-1\"/>"), "{shared}");
    // One that is no longer used where it was written stands at the top level.
    let moved = edited(|scene| {
        scene.emitters[0].medium = scene.shapes[0].interior.take();
        scene.shapes[0].exterior = None;
    });
    assert!(
        moved.contains("\n  <medium type=\"heterogeneous\" id=\"medium-1\">"),
        "{moved}"
    );
}

#[test]
fn a_new_file_means_the_same_and_a_portable_one_has_only_words_of_the_format() {
    let folder = tempfile::tempdir().unwrap();
    let scene = read_text(EVERYTHING, &folder.path().join("old.xml"));
    let target = folder.path().join("new.xml");
    let written = |extensions| {
        write_anew(&scene, &target, extensions).unwrap();
        std::fs::read_to_string(&target).unwrap()
    };
    let again = |text: &str| meaning(&read_text(text, &target));
    let kept = again(&written(Extensions::Keep));
    assert_eq!(kept.shapes, meaning(&scene).shapes);
    assert_eq!(kept.media[..2], meaning(&scene).media[..2]);
    let sigma_t_and_albedo = |scene: &SceneDescription| scene.media[2].medium.coefficients.sigma_t_and_albedo();
    assert_eq!(sigma_t_and_albedo(&kept), sigma_t_and_albedo(&scene));
    let portable = written(Extensions::Approximate);
    for ours in ["sigma_s", "sigma_a", "emission"] {
        assert!(!portable.contains(ours), "{portable}");
    }
    assert_eq!(sigma_t_and_albedo(&again(&portable)), sigma_t_and_albedo(&scene));
    assert!(
        portable.contains("<volume type=\"constvolume\" name=\"sigma_t\">"),
        "{portable}"
    );
}

#[test]
fn entities_become_the_scene_again() {
    let path = Path::new("/nowhere/scene.xml");
    let scene = Arc::new(read_text(EVERYTHING, path));
    let mut world = World::new();
    spawn::spawn_fresh(&mut world, &scene);
    let described = sunroom::scene::write::gather::describe(&mut world);
    assert_eq!(meaning(&described).media, meaning(&scene).media);
    assert_eq!(meaning(&described).shapes, meaning(&scene).shapes);
    assert_eq!(described.sensors[0].medium, scene.sensors[0].medium);
    let (_, text) = files(&described, path).unwrap().remove(0);
    assert_eq!(text, EVERYTHING);
}

#[test]
fn a_reload_changes_the_medium_that_changed() {
    let path = Path::new("/nowhere/scene.xml");
    let mut world = World::new();
    spawn::spawn_fresh(&mut world, &Arc::new(read_text(EVERYTHING, path)));
    let media = |world: &mut World| {
        let mut media = world.query::<(Entity, &Medium, &DocumentOrder)>();
        let mut media: Vec<_> = media
            .iter(world)
            .map(|(entity, medium, order)| (*order, entity, medium.clone()))
            .collect();
        media.sort_by_key(|(order, ..)| *order);
        media
    };
    let before = media(&mut world);
    let shape = world
        .query_filtered::<Entity, With<ExteriorMedium>>()
        .single(&world)
        .unwrap();
    assert_eq!(world.get::<ExteriorMedium>(shape), Some(&ExteriorMedium(before[0].1)));
    assert_eq!(world.get::<InteriorMedium>(shape), Some(&InteriorMedium(before[1].1)));

    let changed = EVERYTHING.replace("value=\"10\"", "value=\"11\"");
    let summary = spawn::update(&mut world, &Arc::new(read_text(&changed, path)));
    assert_eq!(
        (summary.changed, summary.added, summary.removed),
        (1, 0, 0),
        "{summary:?}"
    );
    let now = media(&mut world);
    assert_eq!(
        now.iter().map(|it| it.1).collect::<Vec<_>>(),
        before.iter().map(|it| it.1).collect::<Vec<_>>()
    );
    assert_eq!(
        (now[0] == before[0], now[1].2.scale, now[2] == before[2]),
        (true, 11.0, true)
    );

    // The camera leaves the fog, and the fog goes.
    let cleared = changed
        .replace("    <ref id=\"fog\"/>\n", "")
        .replace("    <ref name=\"exterior\" id=\"fog\"/>\n", "");
    let without = {
        let (start, rest) = cleared
            .split_once("  <medium type=\"homogeneous\" id=\"fog\">")
            .unwrap();
        let (_, end) = rest.split_once("  </medium>\n").unwrap();
        format!("{start}{end}")
    };
    let summary = spawn::update(&mut world, &Arc::new(read_text(&without, path)));
    assert_eq!(summary.removed, 1, "{summary:?}");
    assert_eq!(media(&mut world).len(), 2);
    assert!(world.get::<ExteriorMedium>(shape).is_none());
    assert_eq!(world.query::<&InMedium>().iter(&world).count(), 0);
}

/// A running app with a scene of this body and these files beside it.
struct Open {
    app: App,
    folder: tempfile::TempDir,
}

impl Open {
    fn new(body: &str, volumes: &[(&str, &[u8])]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        for (name, bytes) in volumes {
            std::fs::write(folder.path().join(name), bytes).unwrap();
        }
        let path = folder.path().join("scene.xml");
        let text = format!(
            "<scene version='3.0.0'>\n{body}\n<integrator type='volpath'/><sensor type='perspective'/></scene>"
        );
        std::fs::write(&path, text).unwrap();
        let mut app = App::new();
        app.add_plugins((MinimalPlugins, FileSourcePlugin, asset_plugin(), ScenePlugin));
        app.finish();
        app.cleanup();
        let request = OpenScene {
            path,
            ..OpenScene::default()
        };
        app.world_mut().write_message(request);
        let mut open = Self { app, folder };
        open.until("the scene is complete", |open| open.status().is_complete());
        open
    }

    fn status(&self) -> &SceneStatus {
        self.app.world().resource::<SceneStatus>()
    }

    /// The largest value of the only volume.
    fn value(&self) -> Option<f32> {
        let world = self.app.world();
        let volumes = world.resource::<Volumes>();
        let path = volumes.paths().next()?;
        let map = world.resource::<Assets<VolumeMap>>().get(volumes.get(path)?)?;
        Some(map.grid.voxel(Default::default()).x)
    }

    fn until(&mut self, what: &str, done: impl Fn(&Self) -> bool) {
        let deadline = Instant::now() + Duration::from_secs(120);
        while !done(self) {
            assert!(Instant::now() < deadline, "not in time: {what}: {:?}", self.status());
            self.app.update();
            std::thread::sleep(Duration::from_millis(5));
        }
    }
}

/// A file of one voxel.
fn voxel(value: f32) -> Vec<u8> {
    let grid = VolumeGrid::new(UVec3::ONE, 1, Voxels::F32(vec![value])).unwrap();
    let unit = Aabb {
        min: Vec3::ZERO,
        max: Vec3::ONE,
    };
    let mut bytes = write_vol(&grid, &unit);
    let end = bytes.len();
    bytes[end - 4..].copy_from_slice(&value.to_le_bytes());
    bytes
}

const SMOKE: &str = "<medium type='heterogeneous' id='smoke'>
<volume type='gridvolume' name='sigma_t'><string name='filename' value='smoke.vol'/></volume></medium>";

#[test]
fn volume_files_are_read_again_when_they_change() {
    let mut open = Open::new(SMOKE, &[("smoke.vol", &voxel(2.0))]);
    assert_eq!(open.value(), Some(2.0));
    // The watch needs a frame to hear of the file.
    (0..5).for_each(|_| open.app.update());
    std::fs::write(open.folder.path().join("smoke.vol"), voxel(3.0)).unwrap();
    open.until("the file is read again", |open| open.value() == Some(3.0));
    // One that is broken leaves the last content.
    std::fs::write(open.folder.path().join("smoke.vol"), b"VOX").unwrap();
    open.until("the file is broken", |open| !open.status().volume_errors.is_empty());
    assert_eq!(open.value(), Some(3.0));
}

#[test]
fn what_is_wrong_with_a_volume_file_is_said_where_it_is_named() {
    let message = |volumes: &[(&str, &[u8])]| {
        let open = Open::new(SMOKE, volumes);
        let errors: Vec<String> = open
            .status()
            .volume_errors
            .iter()
            .map(|it| it.message.clone())
            .collect();
        let warnings: Vec<String> = open
            .status()
            .volume_warnings
            .iter()
            .map(|it| it.message.clone())
            .collect();
        assert_eq!(errors.len() + warnings.len(), 1, "{errors:?} {warnings:?}");
        assert_eq!(open.status().has_errors(), !errors.is_empty());
        errors.into_iter().chain(warnings).next().unwrap()
    };
    let missing = message(&[]);
    assert!(
        missing.contains("scene.xml:3:42: volume ") && missing.contains("smoke.vol: no such file; also looked for as "),
        "{missing}"
    );
    let broken = message(&[("smoke.vol", b"VOL\x03")]);
    assert!(
        broken.contains("scene.xml:3:42: ") && broken.contains("ends early"),
        "{broken}"
    );
    for odd in [f32::NAN, -1.0] {
        let mended = message(&[("smoke.vol", &voxel(odd))]);
        assert!(
            mended.contains("scene.xml:3:42: ") && mended.contains("1 value is negative or no number"),
            "{mended}"
        );
    }
}

/// The body of a scene whose density is in a `.vdb` file.
const VDB: &str = "<medium type='heterogeneous' id='smoke'>
<volume type='vdbvolume' name='sigma_t'><string name='filename' value='smoke.vdb'/><string name='grid' value='density'/></volume></medium>";

#[test]
fn vdb_files_have_a_plugin_of_their_own() {
    let smoke = medium(
        "heterogeneous",
        "<volume type='vdbvolume' name='sigma_t'><string name='filename' value='smoke.vdb'/></volume>
        <volume type='vdbvolume' name='emission'><string name='filename' value='smoke.vdb'/><string name='grid' value='flames'/>
            <string name='filter_type' value='nearest'/><transform name='to_world'><scale value='2'/></transform></volume>",
    );
    let vdb = |name: Option<&str>| GridFile {
        format: VolumeFormat::Vdb {
            grid: name.map(str::to_owned),
        },
        ..grid("/somewhere/smoke.vdb")
    };
    assert_eq!(extinction(&smoke).0, VolumeParameter::Grid(vdb(None)));
    let flames = GridFile {
        filter: VolumeFilter::Nearest,
        to_world: Affine3A::from_scale(Vec3::splat(2.0)),
        ..vdb(Some("flames"))
    };
    assert_eq!(smoke.emission, VolumeParameter::Grid(flames));
    let wrapped = VDB.replace("name='grid'", "name='wrap_mode'");
    let found = messages(&wrapped);
    assert!(
        found.len() == 1
            && found[0].contains("scene.xml:3:84: warning: `wrap_mode` is not a parameter of volume `vdbvolume`"),
        "{found:?}"
    );
}

#[test]
fn an_edit_of_a_vdb_volume_changes_nothing_else_in_the_text() {
    let change = |edit: &dyn Fn(&mut GridFile)| {
        edited_body(VDB, |scene| {
            if let Coefficients::Extinction {
                sigma_t: VolumeParameter::Grid(grid),
                ..
            } = &mut scene.media[0].medium.coefficients
            {
                edit(grid);
            }
        })
    };
    let unchanged = change(&|_| ());
    assert!(unchanged.contains(VDB), "{unchanged}");
    let named = |name: Option<&str>| {
        let name = name.map(str::to_owned);
        change(&move |grid| grid.format = VolumeFormat::Vdb { grid: name.clone() })
    };
    let other = named(Some("flames"));
    assert!(
        other.contains(&VDB.replace("'density'", "\"flames\"")) || other.contains(&VDB.replace("density", "flames")),
        "{other}"
    );
    let usual = named(None);
    assert!(usual.contains("smoke.vdb") && !usual.contains("density"), "{usual}");
    let vol = change(&|other| {
        *other = GridFile {
            wrap: VolumeWrap::Repeat,
            ..grid("/nowhere/smoke.vol")
        };
    });
    assert!(
        vol.contains("gridvolume") && vol.contains("repeat") && !vol.contains("density"),
        "{vol}"
    );
    let text = change(&|grid| grid.to_world = Affine3A::from_translation(Vec3::X));
    let again = read_text(&text, Path::new("/nowhere/scene.xml"));
    let moved = GridFile {
        format: VolumeFormat::Vdb {
            grid: Some("density".to_owned()),
        },
        to_world: Affine3A::from_translation(Vec3::X),
        ..grid("/nowhere/smoke.vdb")
    };
    assert_eq!(extinction(&again.media[0].medium).0, VolumeParameter::Grid(moved));
}

#[test]
fn vdb_files_are_read_again_when_they_change() {
    let smoke = include_bytes!("../corpus/vdb/smoke-blosc.vdb");
    let turned = include_bytes!("../corpus/vdb/turned-mask.vdb");
    let size = |open: &Open| {
        let world = open.app.world();
        let volumes = world.resource::<Volumes>();
        let asset = volumes.paths().next()?.to_owned();
        let map = world.resource::<Assets<VolumeMap>>().get(volumes.get(&asset)?)?;
        Some(map.grid.resolution())
    };
    let mut open = Open::new(VDB, &[("smoke.vdb", smoke)]);
    assert_eq!(size(&open), Some(UVec3::new(21, 15, 21)));
    (0..5).for_each(|_| open.app.update());
    let path = open.folder.path().join("smoke.vdb");
    std::fs::write(&path, turned).unwrap();
    open.until("the file is read again", |open| {
        size(open) == Some(UVec3::new(11, 7, 11))
    });
    std::fs::write(&path, b"VDB").unwrap();
    open.until("the file is broken", |open| !open.status().volume_errors.is_empty());
    let error = &open.status().volume_errors[0].message;
    assert!(error.contains("smoke.vdb: this is not a .vdb file"), "{error}");
    assert_eq!(size(&open), Some(UVec3::new(11, 7, 11)));
}
