//! Emitters: `point`, `directional`, `constant`, and inside shapes `area`.

use bevy::math::Affine3A;

use super::SceneReader;
use super::parameters::{Parameters, frame_along};
use crate::document::{Object, Reader};
use crate::scene::description::EmitterDescription;
use crate::scene::{AreaLight, Emitter, write};

impl<'a> SceneReader<'a> {
    /// Whether the emitter became part of the description.
    pub(super) fn read_emitter(&mut self, object: &'a Object) -> bool {
        // Read by the shapes that refer to it.
        if object.plugin == "area" {
            if object.id.is_none() {
                let message = "an `area` emitter has no effect outside of a shape";
                self.diagnostics.warn(object.span, message);
            }
            return false;
        }
        let Some((emitter, to_world)) = read_parameters(self.reader(object)) else {
            return false;
        };
        let identity = self.identity(object, write::objects::emitter(&emitter, &to_world));
        self.description.emitters.push(EmitterDescription {
            identity,
            emitter,
            to_world,
        });
        true
    }

    /// The light of a shape; None (reported) if the emitter is not of that kind.
    pub(super) fn read_area_light(&mut self, object: &'a Object) -> Option<AreaLight> {
        if object.plugin != "area" {
            let message = format!("{} has no effect in a shape, only `area` has", object.title());
            self.diagnostics.warn(object.span, message);
            return None;
        }
        let mut reader = self.reader(object);
        let radiance = reader.radiometric("radiance");
        reader.ignore(&["sampling_weight"]);
        reader.finish();
        Some(AreaLight { radiance })
    }
}

fn read_parameters(mut reader: Reader) -> Option<(Emitter, Affine3A)> {
    reader.ignore(&["sampling_weight"]);
    let read = match reader.object().plugin.as_str() {
        "point" => {
            let intensity = reader.radiometric("intensity");
            let to_world = match reader.point("position") {
                None => reader.to_world()?,
                Some(position) => {
                    exclude_to_world(&mut reader, "position");
                    Affine3A::from_translation(position)
                }
            };
            (Emitter::Point { intensity }, to_world)
        }
        "directional" => {
            let irradiance = reader.radiometric("irradiance");
            let to_world = match reader.vector("direction") {
                None => reader.to_world()?,
                Some(direction) if direction.length_squared() > 0.0 => {
                    exclude_to_world(&mut reader, "direction");
                    frame_along(direction)
                }
                Some(_) => {
                    reader.error_at("direction", "`direction` has no length");
                    return None;
                }
            };
            (Emitter::Directional { irradiance }, to_world)
        }
        "constant" => {
            let radiance = reader.radiometric("radiance");
            (Emitter::Constant { radiance }, reader.to_world()?)
        }
        other => {
            let message = format!("emitter `{other}` is not supported: it is left out");
            let span = reader.object().span;
            reader.diagnostics().warn(span, message);
            return None;
        }
    };
    reader.finish();
    Some(read)
}

fn exclude_to_world(reader: &mut Reader, instead: &str) {
    if reader.has("to_world") {
        reader.error_at("to_world", format!("`to_world` and `{instead}` exclude each other"));
        reader.ignore(&["to_world"]);
    }
}
