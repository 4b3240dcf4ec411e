//! Writes parameters into a plugin of a document.

use std::path::Path;

use bevy::math::{Affine2, Affine3A};
use glam::{Mat4, Vec3, Vec4};

use super::poses::{as_look_at, as_steps};
use crate::color::Rgb;
use crate::document::paths::file_name;
use crate::document::value::format_float;
use crate::document::{Category, Object, Property, Span, TransformOp, Value};
use crate::scene::components::medium::{GRID, USE_GRID_BBOX};
use crate::scene::components::pattern::stops_text;
use crate::scene::components::texture_parameters::{
    COLOR0, COLOR1, FILENAME, FILTER_TYPE, NAME, RAW, SCALE, TIMES, TO_UV, UNIFORM, WRAP_MODE, WRAP_MODE_V,
};
use crate::scene::components::wall_openings::openings_text;
use crate::scene::{Bitmap, Declared, EulerAngles, FileValue, Parameter, Texture, VolumeFormat, VolumeParameter};

/// Writes every parameter that it is called with.
pub struct IntoObject<'f> {
    pub object: Object,
    pub folder: &'f Path,
}

impl IntoObject<'_> {
    pub fn put(&mut self, name: &str, value: Value) {
        self.object.properties.push(property(name, value));
    }

    pub fn put_parameter(&mut self, name: &str, value: FileValue) {
        match value {
            FileValue::Color(color) => self.put_color(name, color),
            FileValue::Float(number) => self.put_float(name, number),
            FileValue::Texture(texture) => self.put_texture(name, texture),
            FileValue::UniformTexture(number) => {
                let mut uniform = with_float(Object::new(Category::Texture, UNIFORM), "value", number);
                uniform.name = Some(name.into());
                self.object.children.push(uniform.into());
            }
            FileValue::Number(number) => self.put(name, Value::Float(number)),
            FileValue::Flag(flag) => self.put(name, Value::Boolean(flag)),
            FileValue::Name(text) => self.put(name, Value::String(text.to_owned())),
            FileValue::Rgb(color) => self.put(name, Value::Rgb(color)),
            FileValue::Integer(number) => self.put(name, Value::Integer(number)),
            FileValue::Path(path) => self.put(name, Value::String(file_name(path, self.folder))),
            FileValue::Vector(vector) => self.put(name, Value::Vector(vector)),
            FileValue::VolumeColor(volume) => self.put_volume(name, volume, |color| *color),
            FileValue::VolumeNumber(volume) => self.put_volume(name, volume, |number| Rgb::splat(*number)),
            FileValue::Numbers(numbers) => {
                let numbers: Vec<String> = numbers.iter().copied().map(format_float).collect();
                self.put(name, Value::String(numbers.join(", ")));
            }
            FileValue::Openings(openings) => self.put(name, Value::String(openings_text(openings))),
            FileValue::Placing(to_uv) => self.put_to_uv(to_uv),
            FileValue::Stops(stops) => self.put(name, Value::String(stops_text(stops))),
        }
    }

    pub fn put_color(&mut self, name: &str, color: &Parameter<Rgb>) {
        match color {
            Parameter::Constant(color) => self.put(name, Value::Rgb(*color)),
            Parameter::Texture(texture) => self.put_texture(name, texture),
        }
    }

    pub fn put_float(&mut self, name: &str, number: &Parameter<f32>) {
        match number {
            Parameter::Constant(number) => self.put(name, Value::Float(*number)),
            Parameter::Texture(texture) => self.put_texture(name, texture),
        }
    }

    pub fn put_texture(&mut self, name: &str, texture: &Texture) {
        let mut inside = IntoObject {
            object: Object::new(Category::Texture, texture.plugin()),
            folder: self.folder,
        };
        inside.object.name = Some(name.into());
        match texture {
            Texture::Bitmap(bitmap) => inside.put_bitmap(bitmap),
            Texture::Checkerboard { color0, color1, to_uv } => {
                inside.put_color(COLOR0.name, color0);
                inside.put_color(COLOR1.name, color1);
                inside.put_to_uv(to_uv);
            }
            Texture::MeshAttribute { name, scale, times } => {
                inside.put(NAME.name, Value::String(name.clone()));
                inside.put(SCALE.name, Value::Float(*scale));
                if let Some(times) = times {
                    inside.put_texture(TIMES.name, times);
                }
            }
            Texture::Pattern(pattern) => pattern.visit(&mut |info, value| {
                value.in_file(info, &mut |info, value| inside.put_parameter(info.name, value));
            }),
        }
        self.object.children.push(inside.object.into());
    }

    fn put_bitmap(&mut self, bitmap: &Bitmap) {
        self.put(FILENAME.name, Value::String(file_name(&bitmap.path, self.folder)));
        self.put(FILTER_TYPE.name, Value::String(bitmap.filter.name().to_owned()));
        self.put(WRAP_MODE.name, Value::String(bitmap.wrap.name().to_owned()));
        if let Some(wrap) = bitmap.wrap_v {
            self.put(WRAP_MODE_V.name, Value::String(wrap.name().to_owned()));
        }
        self.put(RAW.name, Value::Boolean(bitmap.raw));
        self.put_to_uv(&bitmap.to_uv);
    }

    fn put_to_uv(&mut self, to_uv: &Affine2) {
        if *to_uv != Affine2::IDENTITY {
            let [x, y, offset] = [to_uv.matrix2.x_axis, to_uv.matrix2.y_axis, to_uv.translation];
            let matrix = Mat4::from_cols(
                Vec4::new(x.x, x.y, 0.0, 0.0),
                Vec4::new(y.x, y.y, 0.0, 0.0),
                Vec4::Z,
                Vec4::new(offset.x, offset.y, 0.0, 1.0),
            );
            let steps = match (x.y, y.x) {
                (0.0, 0.0) => scaled_and_moved(Vec3::new(x.x, y.y, 1.0), offset.extend(0.0)),
                _ => vec![TransformOp::Matrix(matrix)],
            };
            self.put(TO_UV.name, Value::Transform(steps));
        }
    }
}

impl IntoObject<'_> {
    fn put_volume<T>(&mut self, name: &str, volume: &VolumeParameter<T>, color: impl Fn(&T) -> Rgb) {
        let object = match volume {
            VolumeParameter::Constant(value) => match volume_value(color(value)) {
                // Mitsuba takes a colour without a volume for a reflectance.
                Value::Rgb(color) if color.max_element() > 1.0 => constant_volume(color),
                value => return self.put(name, value),
            },
            VolumeParameter::Box { value, to_world } => with_to_world(constant_volume(color(value)), to_world, None),
            VolumeParameter::Grid(grid) => {
                let object = Object::new(Category::Volume, grid.format.plugin());
                let mut object = with_string(object, FILENAME.name, &file_name(&grid.path, self.folder));
                if let VolumeFormat::Vdb { grid: Some(name) } = &grid.format {
                    object = with_string(object, GRID, name);
                }
                object = with_string(object, FILTER_TYPE.name, grid.filter.name());
                if grid.format == VolumeFormat::Vol {
                    object = with_string(object, WRAP_MODE.name, grid.wrap.name());
                    if grid.use_grid_bbox {
                        object = with_flag(object, USE_GRID_BBOX, true);
                    }
                }
                with_to_world(object, &grid.to_world, None)
            }
        };
        let name = Some(name.into());
        self.object.children.push(Object { name, ..object }.into());
    }
}

/// The plugin with all of its parameters. `folder`: the folder of the written file, to which file names are relative.
pub fn declared(category: Category, plugin: &str, values: &impl Declared, folder: &Path) -> Object {
    let mut writer = IntoObject {
        object: Object::new(category, plugin),
        folder,
    };
    values.visit(&mut |info, value| value.in_file(info, &mut |info, value| writer.put_parameter(info.name, value)));
    writer.object
}

/// A colour, or one number if all its channels are the same.
fn volume_value(color: Rgb) -> Value {
    match color == Rgb::splat(color.x) {
        true => Value::Float(color.x),
        false => Value::Rgb(color),
    }
}

fn constant_volume(color: Rgb) -> Object {
    with(
        Object::new(Category::Volume, "constvolume"),
        "value",
        volume_value(color),
    )
}

/// The steps of a scale and a translation. Steps without effect are left out.
fn scaled_and_moved(scale: Vec3, by: Vec3) -> Vec<TransformOp> {
    let scale = (scale != Vec3::ONE).then_some(TransformOp::Scale(scale));
    let by = (by != Vec3::ZERO).then_some(TransformOp::Translate(by));
    scale.into_iter().chain(by).collect()
}

fn property(name: &str, value: Value) -> Property {
    Property::new(name, value, Span::default())
}

pub fn with(mut object: Object, name: &str, value: Value) -> Object {
    object.properties.push(property(name, value));
    object
}

pub fn with_float(object: Object, name: &str, number: f32) -> Object {
    with(object, name, Value::Float(number))
}

pub fn with_nonzero(object: Object, name: &str, number: f32) -> Object {
    if number == 0.0 {
        object
    } else {
        with_float(object, name, number)
    }
}

pub fn with_integer(object: Object, name: &str, number: u32) -> Object {
    with(object, name, Value::Integer(number.into()))
}

pub fn with_flag(object: Object, name: &str, truth: bool) -> Object {
    with(object, name, Value::Boolean(truth))
}

pub fn with_string(object: Object, name: &str, text: &str) -> Object {
    with(object, name, Value::String(text.to_owned()))
}

pub fn with_child(mut object: Object, child: Object) -> Object {
    object.children.push(child.into());
    object
}

/// Adds `to_world`. `angles`: the rotation angles, if known.
pub fn with_to_world(object: Object, to_world: &Affine3A, angles: Option<EulerAngles>) -> Object {
    match as_steps(to_world, angles) {
        steps if steps.is_empty() => object,
        steps => with(object, "to_world", Value::Transform(steps)),
    }
}

/// Adds the pose of an object that looks along +z, spelled as people write it.
pub fn with_view(object: Object, to_world: &Affine3A, angles: Option<EulerAngles>) -> Object {
    match as_look_at(to_world).filter(|_| angles.is_none()) {
        Some(step) if *to_world != Affine3A::IDENTITY => with(object, "to_world", Value::Transform(vec![step])),
        _ => with_to_world(object, to_world, angles),
    }
}
