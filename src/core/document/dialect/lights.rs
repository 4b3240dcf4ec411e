//! `<Sun>`, the sky, `<PointLight>` and `<Environment>`.
//!
//! In the original the sun is no light source: it tints reflected light. Here it is a directional light, and the
//! colours that the original shows for rays that leave the scene become a constant light of their mean.

use glam::Vec3;

use super::import::Import;
use super::tree::Node;
use crate::document::paths::file_name;
use crate::document::{Category, Object, TransformOp, Value};

/// Mean of the original's sky over all directions: from white at the horizon to (0.5, 0.7, 1) above (half of each on
/// average) and to grey 0.5 below, which it reaches half way down (three quarters on average).
const SKY: Vec3 = Vec3::new(0.5 * (0.75 + 0.625), 0.5 * (0.85 + 0.625), 0.5 * (1.0 + 0.625));

/// The darkest sun, as the sum of its colour components, that gives a sky.
const DARK: f32 = 1e-3;

/// Degrees about y from Mitsuba's `envmap`, whose middle column is towards +z, to the original's, whose middle column
/// is towards +x.
const ENVIRONMENT_TURN: f32 = 90.0;

impl Import<'_> {
    pub fn read_lights(&mut self, root: Node) {
        let lights = root.child(&["Lights"]);
        let has_environment = self.read_environment(root);
        match lights
            .and_then(|lights| lights.child(&["Sun"]))
            .or(root.child(&["Sun"]))
        {
            Some(sun) => self.read_sun(sun, has_environment),
            None => self.warn(root.span(), "there is no <Sun>: neither sun nor sky shine"),
        }
        let Some(lights) = lights else { return };
        self.check_children(lights, &["Sun", "PointLight", "PointLights"]);
        for light in lights.children() {
            match light.name() {
                "PointLight" => self.read_point_light(light),
                "PointLights" => {
                    self.note(
                        light.span(),
                        "the original passes over <PointLights>; the lights in it are read here",
                    );
                    self.check_children(light, &["PointLight"]);
                    for light in light.children().filter(|light| light.name() == "PointLight") {
                        self.read_point_light(light);
                    }
                }
                _ => {}
            }
        }
    }

    fn read_sun(&mut self, sun: Node, has_environment: bool) {
        self.check_children(sun, &["Direction", "Dir", "Intensity", "Color"]);
        let mut towards = self.triple(sun, &["Direction", "Dir"]).unwrap_or(Vec3::Y);
        let color = self.color(sun, &["Color"]).unwrap_or(Vec3::ONE);
        let irradiance = color * self.value(sun, &["Intensity"]).unwrap_or(1.0).max(0.0);
        let brightness = irradiance.element_sum();
        if brightness < DARK {
            return;
        }
        if towards.try_normalize().is_none() {
            self.warn(sun.span(), "the direction to the sun has no length: it stands overhead");
            towards = Vec3::Y;
        }
        let direction = -towards.normalize_or(Vec3::Y);
        let object = Object::new(Category::Emitter, "directional").at(sun.span());
        let object = object.with("direction", Value::Vector(direction));
        self.add(object.with("irradiance", Value::Rgb(irradiance)));
        self.note(
            sun.span(),
            "the sun, which in the original tints reflected light, is a directional light of irradiance Color x Intensity",
        );
        if !has_environment {
            let radiance = SKY * (brightness / 3.0).min(1.0);
            let object = Object::new(Category::Emitter, "constant").at(sun.span());
            self.add(object.with("radiance", Value::Rgb(radiance)));
            self.note(
                sun.span(),
                "the sky, white to blue above and to grey below, has its mean colour everywhere",
            );
        }
    }

    fn read_point_light(&mut self, light: Node) {
        self.check_children(light, &["Position", "Color", "Intensity"]);
        let off = ["false", "0"];
        if light
            .text_of("enabled")
            .is_some_and(|enabled| off.contains(&enabled.trim()))
        {
            self.note(
                light.span(),
                "a light that is not enabled is left out; the original does not ask",
            );
            return;
        }
        let position = self.triple(light, &["Position"]).unwrap_or(Vec3::ZERO);
        let color = self.color(light, &["Color"]).unwrap_or(Vec3::ONE);
        let intensity = color * self.value(light, &["Intensity"]).unwrap_or(1.0).max(0.0);
        let mut object = Object::new(Category::Emitter, "point").at(light.span());
        object.id = self.free_id(light.text_of("name")).map(Into::into);
        let object = object.with("position", Value::Point(position));
        self.add(object.with("intensity", Value::Rgb(intensity)));
    }

    /// Reads the environment map; false if there is none.
    fn read_environment(&mut self, root: Node) -> bool {
        let Some(environment) = root.child(&["Environment"]) else {
            return false;
        };
        let Some((name, span)) = environment.attribute("hdri") else {
            self.warn(
                environment.span(),
                "<Environment> names no file in `hdri`: the sky stays",
            );
            return false;
        };
        let folder = self.folder();
        let Some(path) = self.find_file(&name) else {
            self.warn(span, format!("`{name}` is not found: the sky stays"));
            return false;
        };
        let scale = self.number(environment, "intensity").unwrap_or(1.0).max(0.0);
        let turn = self.number(environment, "rotation").unwrap_or(0.0);
        let steps = vec![TransformOp::Rotate {
            axis: Vec3::Y,
            degrees: ENVIRONMENT_TURN + turn,
        }];
        let object = Object::new(Category::Emitter, "envmap").at(environment.span());
        let object = object.with("filename", Value::String(file_name(&path, &folder)));
        let object = object.with("scale", Value::Float(scale));
        self.add(object.with("to_world", Value::Transform(steps)));
        true
    }
}
