//! The lights of a file as emitters, and the stand-in light for a scene without any.
//!
//! Intensities are photometric, in candela and lux (the specification of KHR_lights_punctual): 683 of them are one W/sr
//! or W/m^2.

use std::f32::consts::PI;

use glam::{Mat4, Vec3};

use super::GltfError;
use super::motion::Placement;
use super::objects::*;
use super::profiles::{KnownProfile, node_from_lamp};
use super::scene::Builder;
use super::schema::{Light, Node, NodeProfile};
use crate::document::{Category, Object, Value};
use crate::photometry::LUMENS_PER_WATT;

impl Builder<'_> {
    /// Adds the lamp or the light of a node.
    pub(super) fn lights_of(&mut self, node: &Node, placement: &Placement) -> Result<(), GltfError> {
        let gltf = self.gltf;
        let of_node = node.name.as_deref();
        if let Some(lamp) = &node.extensions.profile {
            let profile = gltf.root.extensions.profiles.lights.get(lamp.light);
            let name = of_node.or_else(|| profile.and_then(|profile| profile.name.as_deref()));
            // The light beside a profile is for programs that have no profiles.
            if self.lamp(lamp, name, placement) {
                return Ok(());
            }
        }
        if let Some(light) = &node.extensions.light {
            let light = gltf.get("light", &gltf.root.extensions.lights.lights, light.light)?;
            self.light(light, of_node.or(light.name.as_deref()), placement);
        }
        Ok(())
    }

    fn light(&mut self, light: &Light, name: Option<&str>, placement: &Placement) {
        let title = format!("light `{}`", name.unwrap_or("unnamed"));
        let power = self.possible_light(Vec3::from(light.color) * (light.intensity / LUMENS_PER_WATT), &title);
        let emitter = |plugin: &str| object(Category::Emitter, plugin);
        // Lights of the file shine along -z.
        let turn = Mat4::from_rotation_y(PI);
        let mut emitter = match light.kind.as_str() {
            "directional" => {
                let mut emitter = with_color(emitter("directional"), "irradiance", power);
                let forward = |world: Mat4| Value::Vector(world.transform_vector3(Vec3::NEG_Z));
                match placement.moves() {
                    // An animated direction would be interpolated linearly, not along an arc.
                    true => emitter = with_world(emitter, placement, turn),
                    false => emitter.properties.push(placement.property("direction", forward)),
                }
                emitter
            }
            "point" => {
                let mut emitter = with_color(emitter("point"), "intensity", power);
                let place = |world: Mat4| Value::Point(world.w_axis.truncate());
                emitter.properties.push(placement.property("position", place));
                emitter
            }
            "spot" => {
                let outer = light.spot.outer_cone_angle.to_degrees();
                let emitter = with_color(emitter("spot"), "intensity", power);
                let emitter = with_float(emitter, "cutoff_angle", outer);
                let inner = light.spot.inner_cone_angle.to_degrees().min(outer);
                with_world(with_float(emitter, "beam_width", inner), placement, turn)
            }
            other => {
                let sentence = format!("lights of type `{other}` are not supported: one is left out");
                return self.warn(sentence);
            }
        };
        self.lighting.has_lights |= power.max_element() > 0.0;
        emitter.id = name
            .filter(|name| !name.trim().is_empty())
            .map(|name| self.unique_in_folder(name).into());
        self.emitters.push(emitter);
    }

    /// Adds the lamp of a node. False (reported) if its profile cannot be read.
    fn lamp(&mut self, lamp: &NodeProfile, name: Option<&str>, placement: &Placement) -> bool {
        let title = format!("light `{}`", name.unwrap_or("unnamed"));
        let Some(KnownProfile { name: file, geometry }) = self.known_profile(lamp.light, &title) else {
            return false;
        };
        let color = Vec3::from(lamp.color).clamp(Vec3::ZERO, Vec3::ONE);
        let scale = self.possible_light(color * lamp.multiplier, &title);
        let emitter = with(object(Category::Emitter, "ies"), "filename", Value::String(file));
        let emitter = match scale == Vec3::ONE {
            true => emitter,
            false => with_color(emitter, "scale", scale),
        };
        let mut emitter = with_world(emitter, placement, node_from_lamp(geometry));
        emitter.id = name
            .filter(|name| !name.trim().is_empty())
            .map(|name| self.unique_in_folder(name).into());
        self.lighting.has_lights |= scale.max_element() > 0.0;
        self.emitters.push(emitter);
        true
    }

    /// The stored file of a profile; None (reported) if it cannot be read.
    fn known_profile(&mut self, index: usize, title: &str) -> Option<KnownProfile> {
        if let Some(known) = self.profiles.get(&index) {
            return known.clone();
        }
        let found = match self.references.profile(index) {
            Ok(profile) => Some(profile),
            Err(error) => {
                self.warn(format!("{title}: {error}: the profile is left out"));
                None
            }
        };
        self.profiles.insert(index, found.clone());
        found
    }

    /// Adds the stand-in light if nothing lights the scene. Returns its id.
    pub(super) fn stand_in_light(&mut self) -> Result<Option<String>, GltfError> {
        if self.lighting.is_enough() {
            return Ok(None);
        }
        let id = self.unique("studio");
        let file = self.studio_file()?;
        let studio = with(object(Category::Emitter, "envmap"), "filename", Value::String(file));
        self.emitters.push(Object {
            id: Some(id.as_str().into()),
            ..studio
        });
        Ok(Some(id))
    }
}
