//! Lights as plugins of the file.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use bevy::math::Affine3A;
use glam::Vec3;

use super::into_object::{IntoObject, fov_axis_name, with, with_to_world, with_view};
use crate::color::Rgb;
use crate::document::paths::file_name;
use crate::document::{Category, Object, Value};
use crate::scene::emitter::frame_along;
use crate::scene::{AreaLight, Emitter, EmitterKind, EmitterVisitor, FovAxis, Parameter, SunPosition, Texture};

/// `folder`: of the file that is written; names of pictures are relative to it.
pub fn emitter(emitter: &Emitter, to_world: &Affine3A, folder: &Path) -> Object {
    let mut writer = IntoObject {
        object: Object::new(Category::Emitter, emitter.plugin()),
        folder,
    };
    emitter.clone().visit(&mut writer);
    let object = writer.object;
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
        EmitterKind::Spot { .. } | EmitterKind::Projector { .. } => with_view(object, to_world),
        _ => with_to_world(object, to_world),
    }
}

/// `folder`: as that of [`emitter`].
pub fn area_light(light: &AreaLight, folder: &Path) -> Object {
    let mut writer = IntoObject {
        object: Object::new(Category::Emitter, "area"),
        folder,
    };
    light.clone().visit(&mut writer);
    writer.object
}

impl EmitterVisitor for IntoObject<'_> {
    fn emission(&mut self, name: &'static str, value: &mut Rgb) {
        self.put(name, Value::Rgb(*value));
    }

    fn textured_emission(&mut self, name: &'static str, value: &mut Parameter<Rgb>) {
        self.put_color(name, value);
    }

    fn uniform_reflectance(&mut self, name: &'static str, value: &mut Rgb) {
        self.put(name, Value::Rgb(*value));
    }

    fn integer(&mut self, name: &'static str, value: &mut i32, _range: RangeInclusive<i32>) {
        self.put(name, Value::Integer((*value).into()));
    }

    fn angle(&mut self, name: &'static str, value: &mut f32, _range: RangeInclusive<f32>) {
        self.put(name, Value::Float(*value));
    }

    fn picture(&mut self, name: &'static str, value: &mut PathBuf) {
        self.put(name, Value::String(file_name(value, self.folder)));
    }

    fn optional_texture(&mut self, name: &'static str, value: &mut Option<Texture>) {
        if let Some(texture) = value {
            self.put_texture(name, texture);
        }
    }

    fn cone(&mut self, cutoff_angle: &mut f32, beam_width: &mut f32) {
        self.put("cutoff_angle", Value::Float(*cutoff_angle));
        self.put("beam_width", Value::Float(*beam_width));
    }

    fn field_of_view(&mut self, fov: &mut f32, axis: &mut FovAxis) {
        self.put("fov", Value::Float(*fov));
        self.put("fov_axis", Value::String(fov_axis_name(*axis).to_owned()));
    }

    fn sun_position(&mut self, value: &mut SunPosition) {
        if let SunPosition::Direction(direction) = value {
            self.put("sun_direction", Value::Vector(*direction));
        }
    }

    /// Only where it says something.
    fn sampling_weight(&mut self, value: &mut f32) {
        if *value != 1.0 {
            self.put("sampling_weight", Value::Float(*value));
        }
    }
}
