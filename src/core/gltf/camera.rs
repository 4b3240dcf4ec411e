//! The cameras of a file as sensors, and an overview camera for files without any.

use std::f32::consts::PI;

use glam::{Mat4, Vec3};

use super::GltfError;
use super::motion::Placement;
use super::objects::{object, with, with_child, with_float, with_world};
use super::scene::Builder;
use super::schema::Camera;
use crate::document::{Category, Object, TransformOp, Value};

/// The height of a picture in pixels, and below its aspect ratio if the camera gives none.
const ROWS: f32 = 720.0;
const ASPECT: f32 = 16.0 / 9.0;
/// The far plane of a camera with an infinite far plane, in multiples of the distance of its near plane.
const FARTHEST: f32 = 1e7;
const SAMPLES: i64 = 64;
/// The direction from the centre of the scene to the camera, if the file has no camera.
const VIEWPOINT: Vec3 = Vec3::new(0.5, 0.4, 1.0);
const VIEW_DEGREES: f32 = 40.0;
/// The largest coordinate of a scene for which a camera is placed. Products of three such lengths still fit in single
/// precision.
const FARTHEST_REACH: f32 = 1e12;

impl Builder<'_> {
    /// Adds the sensor of a camera of the file.
    pub(super) fn camera(&mut self, camera: &Camera, id: String, placement: &Placement) {
        // Cameras of the file look along -z with +x to the right.
        let turn = Mat4::from_rotation_y(PI);
        let sensor = |plugin: &str, near: f32, far: f32| {
            let sensor = with_float(object(Category::Sensor, plugin), "near_clip", near);
            with_float(sensor, "far_clip", far)
        };
        let (sensor, turn, aspect) = match (&camera.perspective, &camera.orthographic) {
            (Some(lens), _) => {
                let near = lens.znear.max(f32::MIN_POSITIVE);
                let far = lens.zfar.unwrap_or(FARTHEST * near);
                let sensor = with_float(sensor("perspective", near, far), "fov", lens.yfov.to_degrees());
                let sensor = with(sensor, "fov_axis", Value::String("y".into()));
                (sensor, turn, lens.aspect_ratio.unwrap_or(ASPECT))
            }
            (None, Some(lens)) => {
                let scale = Mat4::from_scale(Vec3::new(lens.xmag.abs(), lens.xmag.abs(), 1.0));
                let near = lens.znear.max(f32::MIN_POSITIVE);
                (
                    sensor("orthographic", near, lens.zfar),
                    turn * scale,
                    (lens.xmag / lens.ymag).abs(),
                )
            }
            (None, None) => {
                self.warn(format!("the camera `{id}` has no projection: it is left out"));
                return;
            }
        };
        let sensor = with_film(with_world(sensor, placement, turn), aspect);
        let id = Some(id.into());
        self.sensors.push(Object { id, ..sensor });
    }

    /// A camera that sees the whole scene. An error if single precision cannot hold its distance.
    pub(super) fn overview(&mut self) -> Result<Object, GltfError> {
        if self.shapes.is_empty() {
            self.warn("the scene has no triangles".to_owned());
            return Ok(overview(Vec3::ZERO, 1.0));
        }
        let reach = self.bounds.min.abs().max(self.bounds.max.abs()).max_element();
        // NaN is refused as well.
        if reach.is_nan() || reach > FARTHEST_REACH {
            return Err(GltfError::Reach {
                reach,
                limit: FARTHEST_REACH,
            });
        }
        let (radius, framed) = (self.bounds.radius(), self.bounds.framed_radius());
        if radius < framed {
            let [radius, framed] = [radius, framed].map(rounded);
            self.warn(format!(
                "the scene has an extent of {radius}, too small for a camera to frame: the camera frames {framed}"
            ));
        }
        Ok(overview(self.bounds.center(), framed))
    }
}

/// A length rounded to three digits, with an exponent only if it is very large or very small.
fn rounded(length: f32) -> String {
    let rounded = format!("{length:.2e}").parse().unwrap_or(length);
    match rounded == 0.0 || (1e-4..1e7).contains(&rounded) {
        true => rounded.to_string(),
        false => format!("{rounded:e}"),
    }
}

/// A camera that sees a sphere.
fn overview(center: Vec3, radius: f32) -> Object {
    let distance = radius / (0.5 * VIEW_DEGREES.to_radians()).sin();
    let look = TransformOp::LookAt {
        origin: center + distance * VIEWPOINT.normalize(),
        target: center,
        up: Vec3::Y,
    };
    let sensor = with_float(object(Category::Sensor, "perspective"), "fov", VIEW_DEGREES);
    let sensor = with(sensor, "fov_axis", Value::String("smaller".into()));
    let sensor = with_float(sensor, "near_clip", 1e-3 * distance);
    let sensor = with_float(sensor, "far_clip", 1e3 * distance);
    with_film(with(sensor, "to_world", Value::Transform(vec![look])), ASPECT)
}

fn with_film(sensor: Object, aspect: f32) -> Object {
    let aspect = if aspect.is_finite() && aspect > 0.0 {
        aspect
    } else {
        ASPECT
    };
    let pixels = |side: f32| Value::Integer(side.round().clamp(1.0, 16.0 * ROWS) as i64);
    let film = with(object(Category::Film, "hdrfilm"), "width", pixels(ROWS * aspect));
    let film = with(film, "height", pixels(ROWS));
    let sampler = with(
        object(Category::Sampler, "independent"),
        "sample_count",
        Value::Integer(SAMPLES),
    );
    with_child(with_child(sensor, film), sampler)
}
