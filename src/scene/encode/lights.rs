//! Lights as plugins of the file.

use std::path::Path;

use bevy::math::Affine3A;
use glam::Vec3;

use super::FRAME;
use super::into_object::{declared, with, with_float, with_string, with_to_world, with_view};
use crate::document::{Category, Object, Value};
use crate::scene::components::emitter::frame_along;
use crate::scene::components::marker::FORM;
use crate::scene::{AreaLight, Emitter, EmitterKind, EulerAngles};

/// `angles`: the rotation angles, if known. `folder`: the folder of the written file, to which names of pictures are
/// relative.
pub fn emitter(emitter: &Emitter, to_world: &Affine3A, angles: Option<EulerAngles>, folder: &Path) -> Object {
    if let Some(form) = emitter.form() {
        // Mitsuba reads such a volume and ignores it, because nothing refers to it.
        let volume = with_float(Object::new(Category::Volume, FRAME), "value", 1.0);
        return with_to_world(with_string(volume, FORM, form), to_world, angles);
    }
    let object = declared(Category::Emitter, emitter.plugin(), emitter, folder);
    let position = Vec3::from(to_world.translation);
    let direction = Vec3::from(to_world.matrix3.z_axis);
    match emitter.kind {
        EmitterKind::Point { .. } if *to_world == Affine3A::from_translation(position) => {
            with(object, "position", Value::Point(position))
        }
        EmitterKind::Directional { .. }
            if direction.is_normalized() && to_world.abs_diff_eq(frame_along(direction), 1e-6) =>
        {
            with(object, "direction", Value::Vector(direction))
        }
        EmitterKind::Spot { .. } | EmitterKind::Luminaire { .. } | EmitterKind::Projector { .. } => {
            with_view(object, to_world, angles)
        }
        _ => with_to_world(object, to_world, angles),
    }
}

/// `folder`: as for [`emitter`].
pub fn area_light(light: &AreaLight, folder: &Path) -> Object {
    declared(Category::Emitter, "area", light, folder)
}
