//! Reads the media of materials with subsurface scattering.
//!
//! The original program shows them as diffuse in their `Color`. The other parameters have the usual meaning here
//! (Christensen and Burley, Approximate Reflectance Profiles for Efficient Subsurface Scattering, 2015; Chiang, Kutz
//! and Burley, Practical and Controllable Subsurface Scattering for Production Path Tracing, 2016): `Color` is the
//! albedo of a thick object, and `ScatterDistance` the distance d of the falloff around the point of entry, in units of
//! the world, with a factor for each colour in `ScatterColor`. The material names no index of refraction: the boundary
//! is `null`, through which lights of all kinds can be sampled.

use std::sync::Arc;

use glam::Vec3;

use super::import::Import;
use super::tree::Node;
use crate::document::{Category, Child, Object, Span, Value};

/// The shortest distance of a colour relative to the longest: at zero the medium would be infinitely dense.
const SHORTEST: f32 = 0.01;

/// The least depth of paths in scenes with subsurface scattering. The fits are for media with a low albedo compared
/// with milk, in which light is scattered some dozens of times.
const DEPTH: i64 = 256;

impl Import<'_> {
    /// The medium of a material with this diffuse `color`; None (noted) if the file gives no distance.
    pub fn scattering_inside(&mut self, node: Node, color: Vec3) -> Option<Object> {
        let span = node.span();
        let distance = self.value(node, &["ScatterDistance"]).unwrap_or(0.0);
        let share = self.color(node, &["ScatterColor"]).unwrap_or(Vec3::ONE);
        let distances = (distance * share).max(Vec3::splat(SHORTEST * distance * share.max_element()));
        if distances.min_element() <= 0.0 || !distances.recip().is_finite() {
            let message = "<SSS> without a `ScatterDistance` is diffuse in its `Color`, as in the original";
            self.note(span, message);
            return None;
        }
        let message = "light goes below the surface of <SSS>, as far as `ScatterDistance` and `ScatterColor` say; in the original it is diffuse";
        self.note(span, message);
        let (albedo, mean_free_path) = (albedo(color), distances * path_per_distance(color));
        let medium = Object::new(Category::Medium, "homogeneous").at(span);
        let sigma_t = Object::new(Category::Volume, "constvolume").at(span);
        let mut sigma_t = sigma_t.with("value", Value::Rgb(mean_free_path.recip()));
        sigma_t.name = Some("sigma_t".into());
        Some(medium.with("albedo", Value::Rgb(albedo)).with_child(sigma_t))
    }

    /// Makes the integrator trace media, with paths as deep as these need.
    pub fn deepen(&mut self, span: Span) {
        if std::mem::replace(&mut self.is_deep, true) {
            return;
        }
        let mut raised = None;
        for child in &mut self.root.children {
            let Child::Object(object) = child else {
                continue;
            };
            if object.category != Category::Integrator {
                continue;
            }
            let integrator = Arc::make_mut(object);
            integrator.plugin = "volpath".into();
            for property in &mut integrator.properties {
                if let ("max_depth", Value::Integer(depth)) = (property.name.as_str(), &mut property.value)
                    && *depth < DEPTH
                {
                    raised = Some(std::mem::replace(depth, DEPTH));
                }
            }
        }
        if let Some(depth) = raised {
            let message = format!("a depth of {depth} is too little below surfaces: it is {DEPTH}");
            self.note(span, message);
        }
    }
}

/// The single-scattering albedo of a medium that returns this share of the light: the fit of the paper to a flat and
/// infinitely thick body with isotropic scattering.
fn albedo(reflectance: Vec3) -> Vec3 {
    reflectance.map(|a| 1.0 - (a * (-5.09406 + a * (2.61188 - a * 4.31805))).exp())
}

/// The mean free path relative to the distance of the falloff: the fit s(A) of both papers.
fn path_per_distance(reflectance: Vec3) -> Vec3 {
    reflectance.map(|a| 1.9 - a + 3.5 * (a - 0.8) * (a - 0.8))
}
