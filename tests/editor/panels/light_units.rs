//! Lights in photometric units in the inspector.

use std::f32::consts::PI;

use bevy::math::{Affine3A, Vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sunroom::app::editor::command::selection::Selection;
use sunroom::app::editor::command::{Command, EditCommand, ValueEdit};
use sunroom::app::editor::model::light_figures::LightFigures;
use sunroom::app::editor::model::{Inspected, Model};
use sunroom::color::{Rgb, luminance};
use sunroom::engine::measures_of_emitter;
use sunroom::photometry::{LUMENS_PER_WATT, LightUnit, PolarCurve};
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
    let Some(Command::Edit(EditCommand::Value(edit))) = harness.state().commands.last() else {
        panic!("{:?}", harness.state().commands)
    };
    let edit = match edit {
        ValueEdit::Shine(edit, ..) => edit,
        edit => edit,
    };
    let ValueEdit::SetEmitter(_, set) = edit else {
        panic!("{edit:?}")
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

#[test]
fn the_curve_of_a_lamp_has_the_figures_of_what_it_emits() {
    let curve = PolarCurve {
        lumens: 1830.0,
        peak: 600.0,
        farthest: 400.0,
        points: vec![Vec2::Y; 4],
    };
    let harness = inspect(Inspected {
        emitter: Emitter::of_plugin("ies"),
        light_figures: LightFigures {
            own_flux: Some(1830.0),
            emitted: Some([915.0, 300.0]),
            curves: Some(vec![curve; 4].into()),
            ..LightFigures::default()
        },
        ..Inspected::new(entity(8), "downlight")
    });
    assert!(
        harness
            .query_by_label_contains("915 lm in all directions, at most 300 cd")
            .is_some()
    );
}

#[test]
fn a_typed_amount_goes_to_all_selected_lights_in_its_unit() {
    let mut harness = bulb(800.0);
    harness.state_mut().given.selection = Selection::of([entity(7), entity(8)]);
    harness.run_steps(2);
    slide(&mut harness, "Flux", 1.0);
    let Some(Command::Edit(EditCommand::OnSelection(edit))) = harness.state().commands.last() else {
        panic!("{:?}", harness.state().commands)
    };
    let ValueEdit::Shine(_, "intensity", value) = &**edit else {
        panic!("{edit:?}")
    };
    let Some((amount, LightUnit::Lumen)) = value.amount else {
        panic!("{value:?}")
    };
    assert!((amount / 1e6 - 1.0).abs() < 0.01 && value.color.is_none(), "{value:?}");
}
