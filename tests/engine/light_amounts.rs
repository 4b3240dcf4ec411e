//! Lights that are given in lumens: what they send in the packed scene integrates to that, whatever their kind.

use std::path::Path;

use bevy::prelude::*;
use sunroom::app::headless::headless;
use sunroom::color::{Rgb, luminance};
use sunroom::engine::reasons::Things;
use sunroom::engine::{
    Limits, MeasureOf, PackedScene, load_to_completion, measures_of_area_light, measures_of_emitter,
};
use sunroom::light::PictureLight;
use sunroom::photometry::{LUMENS_PER_WATT, LightUnit};
use sunroom::render::breakdown::{Progress, destinations};
use sunroom::scene::{AreaLight, Emitter, EmitterKind, OpenScene, Parameter, ToWorld};
use sunroom::texture::load_image;

/// What is typed, in lumens.
const TYPED: f32 = 800.0;

/// A warm colour, whose luminance is not one of its channels.
const COLOR: Rgb = Rgb::new(1.0, 0.6, 0.2);

const TURNED: &str = r#"<transform name="to_world"><scale value="1.5"/><rotate x="1" y="0.4" angle="70"/><translate x="1" y="2" z="3"/></transform>"#;
const STRETCHED: &str =
    r#"<transform name="to_world"><scale x="1.5" y="0.6" z="0.8"/><rotate x="1" y="0.4" angle="70"/></transform>"#;

/// The lights of the test by their names, with the whole of each as in a file.
fn lights() -> Vec<(String, String)> {
    let emitter =
        |plugin: &str, inside: &str| format!(r#"<emitter type="{plugin}" id="ID">{inside}{TURNED}</emitter>"#);
    let shape = |plugin: &str, inside: &str| {
        format!(r#"<shape type="{plugin}" id="ID">{STRETCHED}<emitter type="area">{inside}</emitter></shape>"#)
    };
    let checkers = |name: &str| {
        format!(
            r#"<texture type="checkerboard" name="{name}"><rgb name="color0" value="3, 2, 1"/><rgb name="color1" value="0.5, 1, 0"/>
              <transform name="to_uv"><scale value="2"/></transform></texture>"#
        )
    };
    let two_sided = r#"<boolean name="two_sided" value="true"/>"#;
    let lamp = |file: &str, rest: &str| {
        let file = format!("{}/tests/corpus/photometry/{file}", env!("CARGO_MANIFEST_DIR"));
        emitter("ies", &format!(r#"<string name="filename" value="{file}"/>{rest}"#))
    };
    let flux = r#"<float name="flux" value="321"/>"#;
    let cone = r#"<float name="cutoff_angle" value="40"/><float name="beam_width" value="15"/>"#;
    let fov = r#"<float name="fov" value="50"/><float name="scale" value="3"/>"#;
    let bulb = r#"<emitter type="point" id="ID"><point name="position" x="1" y="2" z="0"/></emitter>"#;
    [
        ("point", bulb.to_owned()),
        ("spot", emitter("spot", cone)),
        ("projector", emitter("projector", fov)),
        (
            "projector of a picture",
            emitter("projector", &[fov, &checkers("irradiance")].concat()),
        ),
        ("lamp", lamp("half.ies", "")),
        ("lamp with a flux", lamp("without_symmetry.ldt", flux)),
        ("rectangle", shape("rectangle", "")),
        ("disk", shape("disk", "")),
        ("sphere", shape("sphere", "")),
        ("cylinder", shape("cylinder", two_sided)),
        ("cube", shape("cube", "")),
        ("picture", shape("rectangle", &checkers("radiance"))),
        (
            "picture on both sides",
            shape("rectangle", &[two_sided, &checkers("radiance")].concat()),
        ),
    ]
    .map(|(name, text)| (name.to_owned(), text))
    .into()
}

/// The mean of the checkerboard.
const MEAN: Rgb = Rgb::new(1.75, 1.5, 0.5);

fn opened(folder: &Path, light: &str) -> App {
    let path = folder.join("scene.xml");
    let text = format!(r#"<scene version="3.0.0"><sensor type="perspective"/>{light}</scene>"#);
    std::fs::write(&path, text).expect("a file");
    let mut app = headless(OpenScene { path, ..default() }, Some(2));
    packed(&mut app);
    app
}

fn packed(app: &mut App) {
    let loaded = load_to_completion(app, &Limits::default());
    assert!(loaded.expect("a scene that can be loaded"));
    app.update();
}

/// The strength of luminance 1 gives this many lumens.
fn per_strength(measures: &[MeasureOf]) -> Option<f32> {
    let found = measures.iter().find(|(_, measure)| measure.unit == LightUnit::Lumen);
    found.map(|(_, measure)| measure.per_strength)
}

/// Gives the light of the scene the lumens, or where it is one of a picture the expected ones of that. Returns what is
/// expected.
fn typed(app: &mut App) -> (Entity, f32) {
    let world = app.world_mut();
    let mut emitters = world.query::<(Entity, &Emitter, &ToWorld)>();
    if let Some((entity, emitter, to_world)) = emitters.iter(world).next() {
        let (mut emitter, to_world) = (emitter.clone(), to_world.0);
        let picture = match &emitter.kind {
            EmitterKind::Luminaire { profile, .. } => {
                let bytes = std::fs::read(profile).expect("a file");
                Some(PictureLight::new(&load_image(&bytes).expect("a lamp")))
            }
            _ => None,
        };
        let mut expected = TYPED;
        // A projector of a picture has the flux of one with the mean of the picture.
        let is_picture = |kind: &EmitterKind| {
            matches!(
                kind,
                EmitterKind::Projector {
                    irradiance: Parameter::Texture(_),
                    ..
                }
            )
        };
        let mut plain = emitter.clone();
        if let EmitterKind::Projector { irradiance, .. } = &mut plain.kind {
            *irradiance = Parameter::Constant(Rgb::ONE);
        }
        let lumens = per_strength(&measures_of_emitter(&plain, to_world, picture, 1.0)).expect("it has lumens");
        let shone = COLOR * (TYPED / (lumens * luminance(COLOR)));
        match &mut emitter.kind {
            kind if is_picture(kind) => expected = lumens * luminance(MEAN),
            EmitterKind::Point { intensity: value }
            | EmitterKind::Spot { intensity: value, .. }
            | EmitterKind::Luminaire { scale: value, .. }
            | EmitterKind::Projector {
                irradiance: Parameter::Constant(value),
                ..
            } => *value = shone,
            other => panic!("{other:?}"),
        }
        world.entity_mut(entity).insert(emitter);
        return (entity, expected);
    }
    let mut shapes = world.query::<(Entity, &AreaLight)>();
    let (entity, light) = shapes.iter(world).next().expect("a light");
    let light = light.clone();
    let packed = world.resource::<PackedScene>();
    let area = packed.scene.as_ref().expect("packed").geometry.instances()[0].area();
    let plain = AreaLight {
        radiance: Parameter::Constant(Rgb::ONE),
        ..light.clone()
    };
    let lumens = per_strength(&measures_of_area_light(&plain, Some(area), 1.0)).expect("it has lumens");
    if let Parameter::Texture(_) = light.radiance {
        return (entity, lumens * luminance(MEAN));
    }
    let shone = COLOR * (TYPED / (lumens * luminance(COLOR)));
    world.entity_mut(entity).insert(AreaLight {
        radiance: Parameter::Constant(shone),
        ..light
    });
    (entity, TYPED)
}

#[test]
fn lights_of_all_kinds_send_the_lumens_that_were_typed() {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, light) in lights() {
        let mut app = opened(folder.path(), &light.replace("ID", "light"));
        let (entity, expected) = typed(&mut app);
        packed(&mut app);
        let packed = app.world().resource::<PackedScene>();
        let (scene, view) = (
            packed.scene.clone().expect("packed"),
            packed.view.clone().expect("packed"),
        );
        let alone = Things::of(packed).lit_by(&scene, entity).expect("it shines");
        let found = destinations(&alone, &view, 1 << 18, &Progress::default()).expect("it is not cancelled");
        let [emitted, error] = found.emitted().map(|watts| watts * LUMENS_PER_WATT);
        assert!(
            (emitted / expected - 1.0).abs() < 1e-3,
            "{name}: {emitted} ± {error}, expected {expected}"
        );
    }
}
