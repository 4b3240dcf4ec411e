//! Lights in the inspector.

use bevy::math::{Affine3A, Vec3};
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;
use sunroom::app::editor::command::{Command, EditCommand, FileCommand, FileDialogKind, ValueEdit};
use sunroom::app::editor::model::{Inspected, Model};
use sunroom::color::Rgb;
use sunroom::scene::{AreaLight, Emitter, EmitterKind, Shape, SquarePath};

use super::inspector::inspect;
use super::{Shown, click, drag, entity, light, slide};

pub fn lamp(emitter: Emitter) -> Harness<'static, Shown<Model>> {
    inspect(Inspected {
        emitter: Some(emitter),
        ..Inspected::new(entity(8), "lamp")
    })
}

#[test]
fn a_narrower_cone_takes_its_beam_along() {
    let mut spot = Emitter::of_plugin("spot").unwrap();
    if let EmitterKind::Spot { cone, .. } = &mut spot.kind {
        (cone.cutoff_angle, cone.beam_width) = (80.0, 75.0);
    }
    let mut harness = lamp(spot);
    slide(&mut harness, "Cutoff", 0.2);
    let Some(Command::Edit(EditCommand::Value(ValueEdit::SetEmitter(_, spot)))) = harness.state().commands.last()
    else {
        panic!("no light was set")
    };
    assert!(
        matches!(spot.kind, EmitterKind::Spot { cone, .. } if cone.cutoff_angle < 75.0 && cone.beam_width == cone.cutoff_angle),
        "{spot:?}"
    );
}

#[test]
fn pictures_of_lights_are_chosen() {
    let ways: [(&str, &str, &[&str]); 3] = [
        ("envmap", "filename", &["Picture"]),
        ("spot", "texture", &["Picture source", "picture\u{2026}"]),
        ("projector", "irradiance", &["Picture source", "picture\u{2026}"]),
    ];
    for (plugin, parameter, clicks) in ways {
        let mut harness = lamp(Emitter::of_plugin(plugin).unwrap());
        for name in clicks {
            click(&mut harness, name);
        }
        let dialog = Command::from(FileCommand::ShowDialog(FileDialogKind::OpenPicture {
            owner: entity(8),
            parameter,
            place: SquarePath::WHOLE,
        }));
        assert_eq!(harness.state().commands, [dialog]);
    }
}

#[test]
fn the_strength_of_a_textured_light_ends_at_the_panels_edge() {
    let harness = inspect(Inspected {
        shape: Some(Shape::default()),
        area_light: Some(AreaLight::default()),
        ..Inspected::new(entity(8), "lamp")
    });
    let menu = harness.get_by_label("Radiance source").rect();
    let numbers = harness.query_all_by_role(bevy_egui::egui::accesskit::Role::SpinButton);
    let right = numbers.map(|number| number.rect().right()).fold(0.0, f32::max);
    assert!((menu.right() - right).abs() < 0.6, "{} and {right}", menu.right());
}

#[test]
fn a_light_of_another_kind_keeps_its_colour() {
    let warm = Rgb::new(30.0, 20.0, 10.0);
    let mut harness = lamp(EmitterKind::Point { intensity: warm }.into());
    click(&mut harness, "Type");
    click(&mut harness, "directional");
    let sun = Emitter::from(EmitterKind::Directional { irradiance: warm });
    assert_eq!(
        harness.state().commands,
        [Command::from(ValueEdit::SetEmitter(entity(8), sun))]
    );
}

#[test]
fn an_environment_turns_about_its_upward_axis() {
    let mut harness = inspect(Inspected {
        to_world: Some(Affine3A::IDENTITY),
        emitter: Emitter::of_plugin("envmap"),
        ..Inspected::new(entity(8), "sky")
    });
    slide(&mut harness, "Azimuth", 0.75);
    let Some(Command::Edit(EditCommand::Value(ValueEdit::Transform(poses)))) = harness.state().commands.last() else {
        panic!("{:?}", harness.state().commands)
    };
    let up = poses[0].1.transform_vector3(Vec3::Y);
    assert!(
        up.abs_diff_eq(Vec3::Y, 1e-5) && poses[0].1 != Affine3A::IDENTITY,
        "{up}"
    );
}

#[test]
fn what_is_infinitely_far_away_is_only_turned() {
    let sky = Inspected {
        to_world: Some(Affine3A::IDENTITY),
        emitter: Emitter::of_plugin("sunsky"),
        ..Inspected::new(entity(8), "sky")
    };
    let mut harness = inspect(sky);
    assert!(harness.query_by_label("Position X").is_none());
    drag(&mut harness, "Rotation Y", 20.0);
    assert!(matches!(
        harness.state().commands.last(),
        Some(Command::Edit(EditCommand::Value(ValueEdit::Turn(..))))
    ));
}

#[test]
fn a_shape_can_be_made_to_emit() {
    let mut harness = inspect(Inspected {
        shape: Some(Shape::default()),
        ..Inspected::new(entity(5), "wall")
    });
    click(&mut harness, "Emits light");
    let light = AreaLight::default();
    assert_eq!(
        harness.state().commands,
        [Command::from(ValueEdit::SetAreaLight(entity(5), Some(light)))]
    );
}

#[test]
fn strength_keeps_the_hue() {
    let radiance = Rgb::new(18.4, 9.2, 4.6);
    let mut harness = inspect(Inspected {
        shape: Some(Shape::default()),
        area_light: Some(light(radiance)),
        ..Inspected::new(entity(5), "lamp")
    });
    slide(&mut harness, "Radiance", 0.9);
    let Some(Command::Edit(EditCommand::Value(ValueEdit::SetAreaLight(_, Some(light))))) =
        harness.state().commands.last()
    else {
        panic!("no light was set")
    };
    let stronger = light.radiance.constant().unwrap();
    assert!(stronger.x > radiance.x);
    let (hue, before) = (stronger / stronger.x, radiance / radiance.x);
    assert!(hue.abs_diff_eq(before, 1e-4), "{hue} {before}");
}
