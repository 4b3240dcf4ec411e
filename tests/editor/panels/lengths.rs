//! Lengths, sizes and the angles of cameras as they are typed in the inspector.

use bevy::math::{Affine3A, Vec3};
use bevy_egui::egui::{self, Key};
use egui_kittest::Harness;
use sunroom::app::editor::command::{Command, EditCommand, TextureEdit, ValueEdit};
use sunroom::app::editor::model::{Inspected, Model};
use sunroom::app::editor::panels::lengths;
use sunroom::app::editor::panels::projection::{ProjectionForm, projection};
use sunroom::math::Aabb;
use sunroom::scene::{FovAxis, LengthUnit, Sensor, Shape, ShapeKind};

use super::inspector::inspect;
use super::{Shown, click, entity, show_beside_picture};

/// Types a text into the field of this name.
pub fn type_into(harness: &mut Harness<Shown<Model>>, name: &str, text: &str) {
    click(harness, name);
    harness.event(egui::Event::Text(text.into()));
    harness.run_steps(1);
    harness.key_press(Key::Enter);
    harness.run_steps(2);
}

fn cube() -> Inspected {
    Inspected {
        to_world: Some(Affine3A::IDENTITY),
        shape: Some(Shape {
            kind: ShapeKind::Cube,
            ..Shape::default()
        }),
        ..Inspected::new(entity(4), "box")
    }
}

fn pose(harness: &Harness<Shown<Model>>) -> Affine3A {
    match harness.state().commands.last() {
        Some(Command::Edit(EditCommand::Value(ValueEdit::Transform(poses)))) => poses[0].1,
        other => panic!("{other:?}"),
    }
}

#[test]
fn the_tile_of_a_projection_is_a_length() {
    let model = Model {
        unit: LengthUnit::Centimetre,
        ..Model::default()
    };
    let mut form = ProjectionForm::default();
    let size = egui::vec2(700.0, 500.0);
    let mut harness = show_beside_picture(size, 340.0, model, move |ui, model, commands| {
        lengths::in_unit(ui, model.unit, |ui| {
            projection(ui, &mut form, &[entity(4)], commands);
        });
    });
    let tile = |command: Option<&Command>| match command {
        Some(Command::Edit(EditCommand::Texture(TextureEdit::ProjectTextures { shapes, projection })))
            if *shapes == [entity(4)] =>
        {
            projection.tile
        }
        other => panic!("{other:?}"),
    };
    click(&mut harness, "Project");
    assert_eq!(tile(harness.state().commands.last()), 100.0);
    type_into(&mut harness, "Edge of a tile", "0.5m");
    click(&mut harness, "Project");
    assert_eq!(tile(harness.state().commands.last()), 50.0);
}

#[test]
fn lengths_are_typed_in_any_unit() {
    let ball = Inspected {
        shape: Some(Shape {
            kind: ShapeKind::Sphere {
                center: Vec3::ZERO,
                radius: 1.0,
            },
            ..Shape::default()
        }),
        ..Inspected::new(entity(7), "ball")
    };
    for (unit, text, expected) in [
        (LengthUnit::None, "30cm", 0.3),
        (LengthUnit::Centimetre, "2m", 200.0),
        (LengthUnit::Inch, "6'2\"", 74.0),
        (LengthUnit::Metre, "0.5", 0.5),
    ] {
        let mut harness = inspect(ball.clone());
        harness.state_mut().given.unit = unit;
        harness.run_steps(1);
        type_into(&mut harness, "Radius", text);
        let Some(Command::Edit(EditCommand::Value(ValueEdit::SetShape(_, shape)))) = harness.state().commands.last()
        else {
            panic!("{text}: {:?}", harness.state().commands)
        };
        let ShapeKind::Sphere { radius, .. } = shape.kind else {
            panic!("it was a sphere")
        };
        assert!((radius - expected).abs() < 1e-4, "{text}: {radius}");
    }
    let mut harness = inspect(cube());
    type_into(&mut harness, "Position Y", "4in");
    let place = Vec3::from(pose(&harness).translation);
    assert!(place.abs_diff_eq(Vec3::Y * 0.1016, 1e-6), "{place}");
    // A scale is no length.
    let mut harness = inspect(cube());
    type_into(&mut harness, "Scale X", "2m");
    let is_same = |command: &Command| matches!(command, Command::Edit(EditCommand::Value(ValueEdit::Transform(poses))) if poses[0].1.abs_diff_eq(Affine3A::IDENTITY, 1e-5));
    assert!(harness.state().commands.iter().all(is_same));
}

#[test]
fn a_typed_size_scales_the_thing_along_that_axis() {
    let mut harness = inspect(cube());
    harness.state_mut().given.extent = Some(Aabb {
        min: Vec3::NEG_ONE,
        max: Vec3::ONE,
    });
    harness.run_steps(1);
    type_into(&mut harness, "Size Y", "50cm");
    let axes = pose(&harness).matrix3;
    assert!((axes.y_axis.length() - 0.25).abs() < 1e-5 && axes.x_axis.length() == 1.0);
}

#[test]
fn a_camera_is_turned_by_yaw_and_pitch() {
    let camera = Inspected {
        to_world: Some(Affine3A::from_rotation_y(std::f32::consts::PI)),
        sensor: Some(Sensor::default()),
        ..Inspected::new(entity(3), "camera")
    };
    let ahead = |row: &str, text: &str| {
        let mut harness = inspect(camera.clone());
        type_into(&mut harness, row, text);
        Vec3::from(pose(&harness).matrix3.z_axis)
    };
    // It looked along -z.
    let (turned, raised) = (ahead("Yaw", "90"), ahead("Pitch", "-30"));
    assert!(turned.abs_diff_eq(Vec3::X, 1e-5), "{turned}");
    assert!(
        raised.y < -0.49 && raised.x.abs() < 1e-5 && raised.z < -0.86,
        "{raised}"
    );
}

#[test]
fn a_focal_length_is_a_field_of_view() {
    let mut harness = inspect(Inspected {
        sensor: Some(Sensor {
            fov_axis: FovAxis::Diagonal,
            ..Sensor::default()
        }),
        ..Inspected::new(entity(3), "camera")
    });
    type_into(&mut harness, "Focal length", "50");
    let Some(Command::Edit(EditCommand::Value(ValueEdit::SetSensor(_, sensor)))) = harness.state().commands.last()
    else {
        panic!("{:?}", harness.state().commands)
    };
    assert!((sensor.fov - 46.79).abs() < 0.02, "{}", sensor.fov);
}
