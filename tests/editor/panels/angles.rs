//! The rows of a rotation: the angles that were typed, from the position at which a thing is at rest.

use bevy::math::{Affine3A, Mat3A, Vec3};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use sunroom::app::editor::command::{Command, EditCommand, ValueEdit};
use sunroom::app::editor::model::{Inspected, Model};
use sunroom::scene::{EulerAngles, Shape, ShapeKind, Solid};

use super::inspector::inspect;
use super::lengths::type_into;
use super::{Shown, entity};

fn number(harness: &Harness<Shown<Model>>, row: &str) -> f64 {
    let shown = harness.get_by_label(row).accesskit_node().numeric_value();
    shown.expect("it shows a number")
}

/// A thing that is turned and shown from a rest position, both in degrees about x, then y, then z.
fn turned(kind: ShapeKind, angles: Vec3, rest: Vec3) -> Inspected {
    let [x, y, z] = angles.map(f32::to_radians).to_array();
    let rotation = Mat3A::from_rotation_z(z) * Mat3A::from_rotation_y(y) * Mat3A::from_rotation_x(x);
    Inspected {
        to_world: Some(Affine3A::from_mat3(rotation.into())),
        angles: Some(EulerAngles(angles)),
        rest,
        shape: Some(Shape {
            kind,
            ..Shape::default()
        }),
        ..Inspected::new(entity(9), "thing")
    }
}

#[test]
fn a_rotation_shows_the_angles_that_were_typed() {
    for angles in [
        Vec3::Y * 180.0,
        Vec3::new(180.0, 0.0, 180.0),
        Vec3::new(0.0, 370.0, 0.0),
    ] {
        let harness = inspect(turned(ShapeKind::Cube, angles, Vec3::ZERO));
        for (row, angle) in ["Rotation X", "Rotation Y", "Rotation Z"]
            .into_iter()
            .zip(angles.to_array())
        {
            assert_eq!(number(&harness, row), f64::from(angle), "{row} of {angles}");
        }
    }
    // What is typed goes on its way as it is.
    let mut harness = inspect(turned(ShapeKind::Cube, Vec3::Y * 90.0, Vec3::ZERO));
    type_into(&mut harness, "Rotation Y", "180");
    let Some(Command::Edit(EditCommand::Value(ValueEdit::Turn(thing, pose, EulerAngles(angles))))) =
        harness.state().commands.last()
    else {
        panic!("{:?}", harness.state().commands)
    };
    assert_eq!((*thing, *angles), (entity(9), Vec3::Y * 180.0));
    assert_eq!(pose.matrix3, Mat3A::from_diagonal(Vec3::new(-1.0, 1.0, -1.0)));
}

#[test]
fn a_wall_stands_upright_at_rotation_0() {
    let wall = || turned(ShapeKind::Solid(Solid::default()), Vec3::X * -90.0, Vec3::X * -90.0);
    let mut harness = inspect(wall());
    for row in ["Rotation X", "Rotation Y", "Rotation Z"] {
        assert_eq!(number(&harness, row), 0.0, "{row}");
    }
    type_into(&mut harness, "Rotation Y", "90");
    let Some(Command::Edit(EditCommand::Value(ValueEdit::Turn(_, pose, EulerAngles(angles))))) =
        harness.state().commands.last()
    else {
        panic!("{:?}", harness.state().commands)
    };
    assert_eq!(*angles, Vec3::new(-90.0, 90.0, 0.0));
    assert_eq!(pose.transform_vector3(Vec3::Z), Vec3::Y, "it still stands");
    assert_eq!(pose.transform_vector3(Vec3::X), Vec3::NEG_Z);
}
