//! Reads `<Config>` and `<Camera>`: the film, the number of samples, the depth, and the view.

use glam::{DVec3, Vec3};

use super::import::Import;
use super::tree::Node;
use crate::document::transform::direction;
use crate::document::{Category, Object, TransformOp, Value};

const WIDTH: f32 = 800.0;
const ASPECT: f32 = 16.0 / 9.0;
const SAMPLES: f32 = 20.0;
const DEPTH: f32 = 10.0;
/// The field of view in degrees.
const FOV: f32 = 90.0;

impl Import<'_> {
    pub fn read_settings(&mut self, root: Node) {
        let config = root.child(&["Config"]);
        match config {
            Some(config) => self.check_children(
                config,
                &[
                    "Width",
                    "Height",
                    "Aspect_ratio",
                    "Samples_Per_Pixel",
                    "Samples",
                    "Max_Depth",
                    "Depth",
                ],
            ),
            None => self.warn(
                root.span(),
                "there is no <Config>: 800 x 450 pixels, 20 samples and a depth of 10 are taken",
            ),
        }
        let mut setting = |names: &[&str], least: f32, default: f32| {
            let Some(child) = config.and_then(|config| config.child(names)) else {
                return default;
            };
            let Some((text, span)) = child.attribute("value") else {
                return default;
            };
            if text.trim().is_empty() {
                self.warn(span, format!("<{}> is empty; {default} takes its place", child.name()));
                return default;
            }
            match self.number(child, "value") {
                Some(number) if number >= least => number,
                Some(number) => {
                    self.error(
                        span,
                        format!("expected {least} or more for <{}>, found {number}", child.name()),
                    );
                    default
                }
                None => default,
            }
        };
        // Numbers are truncated, not rounded.
        let width = setting(&["Width"], 1.0, WIDTH).trunc();
        let aspect = setting(&["Aspect_ratio"], 1e-3, ASPECT);
        let height = setting(&["Height"], 1.0, (width / aspect).trunc().max(1.0)).trunc();
        let samples = setting(&["Samples_Per_Pixel", "Samples"], 1.0, SAMPLES).trunc();
        let depth = setting(&["Max_Depth", "Depth"], 1.0, DEPTH).trunc();

        let span = config.map_or(root.span(), Node::span);
        let whole = |number: f32| Value::Integer(number as i64);
        // Both formats count the segments of a path, including the one from the camera.
        let integrator = Object::new(Category::Integrator, "path").at(span);
        self.add(integrator.with("max_depth", whole(depth)));
        let filter = Object::new(Category::ReconstructionFilter, "box").at(span);
        let film = Object::new(Category::Film, "hdrfilm").at(span);
        let film = film.with("width", whole(width)).with("height", whole(height));
        let sampler = Object::new(Category::Sampler, "independent").at(span);
        let mut sensor = self.camera(root);
        sensor.children = vec![
            film.with_child(filter).into(),
            sampler.with("sample_count", whole(samples)).into(),
        ];
        self.add(sensor);
    }

    /// A pinhole camera, even if the file gives an aperture: the original reads none.
    fn camera(&mut self, root: Node) -> Object {
        let sensor = Object::new(Category::Sensor, "perspective");
        let (mut origin, mut target, mut up, mut fov) = (Vec3::Z, Vec3::ZERO, Vec3::Y, FOV);
        let mut span = root.span();
        match root.child(&["Camera"]) {
            None => self.warn(span, "there is no <Camera>: one at (0, 0, 1) looks at the origin"),
            Some(camera) => {
                span = camera.span();
                let known = ["Look_From", "LookFrom", "Look_at", "LookAt", "Up", "FOV"];
                let no_effect = ["Viewport_Width", "Focal_Length", "Aspect_ratio"];
                let lens = ["Aperture", "Focus_Distance"];
                let all: Vec<&str> = known.into_iter().chain(no_effect).chain(lens).collect();
                self.check_children(camera, &all);
                if let Some(lens) = camera.child(&lens) {
                    self.note(
                        lens.span(),
                        "the original reads no aperture and no focus distance: everything is sharp",
                    );
                }
                origin = self.triple(camera, &["Look_From", "LookFrom"]).unwrap_or(origin);
                target = self.triple(camera, &["Look_at", "LookAt"]).unwrap_or(target);
                up = self.triple(camera, &["Up"]).unwrap_or(up);
                if let Some(angle) = camera.child(&["FOV"]) {
                    let given = self.number(angle, "angle").or_else(|| self.number(angle, "value"));
                    match given {
                        Some(degrees) if degrees > 0.0 && degrees < 180.0 => fov = degrees,
                        Some(degrees) => {
                            let message =
                                format!("expected a field of view between 0 and 180 degrees, found {degrees}");
                            self.error(angle.span(), message);
                        }
                        None => {}
                    }
                }
            }
        }
        let forward = direction(origin, target).unwrap_or_else(|| {
            self.warn(span, "the camera looks at where it stands: it looks along -z instead");
            target = origin - Vec3::Z;
            DVec3::NEG_Z
        });
        if up.as_dvec3().normalize_or_zero().cross(forward).length() < 1e-6 {
            self.warn(span, "`Up` is along the view: another one is taken");
            up = forward.any_orthonormal_vector().as_vec3();
        }
        sensor
            .at(span)
            .with("fov", Value::Float(fov))
            .with("fov_axis", Value::String("y".to_owned()))
            .with(
                "to_world",
                Value::Transform(vec![TransformOp::LookAt { origin, target, up }]),
            )
    }
}
