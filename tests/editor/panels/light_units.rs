//! Lights in photometric units in the inspector.

use std::f32::consts::PI;

use bevy::math::Affine3A;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sunroom::app::editor::command::{Command, EditCommand, ValueEdit};
use sunroom::app::editor::model::light_figures::LightFigures;
use sunroom::app::editor::model::{Inspected, Model};
use sunroom::color::{Rgb, luminance};
use sunroom::engine::measures_of_emitter;
use sunroom::photometry::LUMENS_PER_WATT;
use sunroom::scene::{Emitter, EmitterKind};

use super::inspector::inspect;
use super::{Shown, click, entity, slide};

fn bulb(lumens: f32) -> Harness<'static, Shown<Model>> {
    let intensity = Rgb::splat(lumens / (4.0 * PI * LUMENS_PER_WATT));
    let emitter = Emitter::from(EmitterKind::Point { intensity });
    let light_figures = LightFigures {
        measures: measures_of_emitter(&emitter, Affine3A::IDENTITY, None, 1.0),
        ..LightFigures::default()
    };
    inspect(Inspected {
        emitter: Some(emitter),
        light_figures,
        ..Inspected::new(entity(8), "bulb")
    })
}

/// The lumens of the point light that was set last.
fn lumens(harness: &Harness<Shown<Model>>) -> f32 {
    let Some(Command::Edit(EditCommand::Value(ValueEdit::SetEmitter(_, set)))) = harness.state().commands.last() else {
        panic!("{:?}", harness.state().commands)
    };
    match set.kind {
        EmitterKind::Point { intensity } => 4.0 * PI * LUMENS_PER_WATT * luminance(intensity),
        _ => panic!("{set:?}"),
    }
}

#[test]
fn a_strength_is_shown_in_the_unit_that_is_chosen() {
    let mut harness = bulb(800.0);
    assert!(harness.query_by_value("800").is_some());
    click(&mut harness, "lm");
    click(&mut harness, "candela (cd)");
    // Looking at a light in another unit does not change it.
    assert_eq!(harness.state().commands, []);
    assert!(harness.query_by_value("63.66").is_some());
    click(&mut harness, "cd");
    click(&mut harness, "W/sr, as in the file");
    assert_eq!(harness.state().commands, []);
    assert!(harness.query_by_value("0.093").is_some());
}

#[test]
fn the_slider_moves_the_strength_in_its_unit() {
    let mut harness = bulb(800.0);
    slide(&mut harness, "Flux", 1.0);
    // A million lumens are the end of the slider.
    assert!((lumens(&harness) / 1e6 - 1.0).abs() < 0.01, "{}", lumens(&harness));
}

#[test]
fn a_light_becomes_a_real_lamp() {
    let mut harness = bulb(800.0);
    click(&mut harness, "As a real lamp");
    // Lamps in lux do not fit a point light.
    assert!(harness.query_by_label_contains("Noon sun").is_none());
    click(&mut harness, "Bulb, 60 W, 806 lm");
    assert!((lumens(&harness) / 806.0 - 1.0).abs() < 1e-4, "{}", lumens(&harness));
}

#[test]
fn the_flux_of_a_file_is_shown() {
    let lamp = |flux: f32| {
        let mut emitter = Emitter::of_plugin("ies").expect("a plugin");
        if let EmitterKind::Luminaire { flux: of_lamp, .. } = &mut emitter.kind {
            *of_lamp = flux;
        }
        let light_figures = LightFigures {
            own_flux: Some(1830.0),
            ..LightFigures::default()
        };
        inspect(Inspected {
            emitter: Some(emitter),
            light_figures,
            ..Inspected::new(entity(8), "downlight")
        })
    };
    assert!(lamp(0.0).query_by_value("1830 lm of the file").is_some());
    assert!(lamp(500.0).query_by_value("500 lm").is_some());
}
