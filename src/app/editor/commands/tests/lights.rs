//! Amounts of light that are given to several lights.

use super::*;
use crate::app::editor::command::lamps::PhotometricValue;
use crate::app::editor::model::gather_light::measures_of;
use crate::color::luminance;
use crate::photometry::LightUnit;
use crate::scene::EmitterKind;

/// A light at the origin.
fn light(world: &mut World, plugin: &str) -> Entity {
    let emitter = Emitter::of_plugin(plugin).expect("a plugin");
    world.spawn((emitter, ToWorld::default())).id()
}

/// How much a light gives in a unit.
fn amount(world: &World, light: Entity, unit: LightUnit) -> f32 {
    let measures = measures_of(world, light);
    let (_, measure) = measures
        .iter()
        .find(|(_, measure)| measure.unit == unit)
        .expect("a measure");
    let strength = match &world.get::<Emitter>(light).expect("a light").kind {
        EmitterKind::Point { intensity } | EmitterKind::Spot { intensity, .. } => luminance(*intensity),
        EmitterKind::Directional { irradiance } => luminance(*irradiance),
        other => panic!("{other:?}"),
    };
    strength * measure.per_strength
}

#[test]
fn each_selected_light_gets_the_amount_that_was_typed() {
    let mut world = bare_world();
    let [bulb, spot, narrow, sun] = ["point", "spot", "spot", "directional"].map(|plugin| light(&mut world, plugin));
    let red = Rgb::new(3.0, 0.5, 0.1);
    let mut emitter = world.get_mut::<Emitter>(narrow).expect("a light");
    if let EmitterKind::Spot { intensity, cone, .. } = &mut emitter.kind {
        *intensity = red;
        (cone.cutoff_angle, cone.beam_width) = (9.0, 5.0);
    }
    world.insert_resource(Selection::of([bulb, narrow, sun, spot]));
    let before = world.get::<Emitter>(sun).cloned();
    let typed = |world: &World, unit| {
        let value = PhotometricValue {
            amount: Some((700.0, unit)),
            color: None,
        };
        let mut edited = world.get::<Emitter>(spot).cloned().expect("a light");
        value
            .apply(&mut edited, &measures_of(world, spot), None)
            .expect("it fits");
        let edit = ValueEdit::SetEmitter(spot, edited);
        EditCommand::OnSelection(Box::new(ValueEdit::Shine(Box::new(edit), "intensity", value)))
    };
    for unit in [LightUnit::Lumen, LightUnit::Candela] {
        let edit = typed(&world, unit);
        say(&mut world, edit);
        for light in [bulb, spot, narrow] {
            let found = amount(&world, light, unit);
            assert!((found / 700.0 - 1.0).abs() < 1e-5, "{unit:?}: {found}");
        }
        // Its colour is its own, and a light without the unit stays.
        let EmitterKind::Spot { intensity, .. } = world.get::<Emitter>(narrow).expect("a light").kind else {
            panic!("it is a spot");
        };
        let hue = intensity / luminance(intensity);
        assert!(hue.abs_diff_eq(red / luminance(red), 1e-5), "{hue}");
        assert_eq!(world.get::<Emitter>(sun).cloned(), before);
        say(&mut world, HistoryCommand::Undo);
        assert_ne!(amount(&world, bulb, unit), 700.0);
    }
}
