//! Builds objects of the scene format for parts of a file.

use glam::{Mat4, Vec3};

use super::motion::Placement;
use crate::document::{Category, Object, Property, Span, TransformOp, Value};

pub(super) fn object(category: Category, plugin: &str) -> Object {
    Object::new(category, plugin)
}

pub(super) fn with(mut object: Object, name: &str, value: Value) -> Object {
    object.properties.push(Property::new(name, value, Span::default()));
    object
}

pub(super) fn with_float(object: Object, name: &str, number: f32) -> Object {
    with(object, name, Value::Float(number))
}

pub(super) fn with_color(object: Object, name: &str, color: Vec3) -> Object {
    with(object, name, Value::Rgb(color))
}

pub(super) fn with_child(mut object: Object, child: Object) -> Object {
    object.children.push(child.into());
    object
}

/// The object with the pose of a node, applied after the rotation `turn`.
pub(super) fn with_world(mut object: Object, placement: &Placement, turn: Mat4) -> Object {
    if placement.moves() || placement.world * turn != Mat4::IDENTITY {
        let value = |world: Mat4| Value::Transform(vec![TransformOp::Matrix(world * turn)]);
        object.properties.push(placement.property("to_world", value));
    }
    object
}
