//! Surfaces lit only by a lamp at the camera: complete with the first sample, whatever the lights of the scene.

use glam::Vec3;

use super::borders::{Met, behind_borders};
use super::path_state::PathSample;
use super::scene::RenderScene;
use crate::color::Rgb;
use crate::math::Ray;
use crate::shading::TransportMode;

/// The brightness of a surface seen edge-on, relative to one seen from the front.
const EDGE_ON: f32 = 0.15;
/// The colour of all surfaces in clay.
const CLAY: f32 = 0.55;
/// The colour of the background.
const NOTHING: f32 = 0.03;

/// The colour of the surface that `ray` hits, or that of clay. Masks and glass count as opaque; borders of media are
/// ignored.
pub(super) fn sample(scene: &RenderScene, ray: &Ray, is_clay: bool) -> PathSample {
    let (met, rays) = behind_borders(scene, ray, None, |_, _| {});
    let Some(Met { hit, slot, point }) = met else {
        return PathSample {
            radiance: Rgb::splat(NOTHING),
            rays,
            ..PathSample::default()
        };
    };
    let albedo = match slot.light {
        Some(_) => Rgb::ONE,
        None => scene
            .scattering(slot.material, &hit, &point, -ray.dir, TransportMode::Radiance)
            .albedo()
            .clamp(Rgb::ZERO, Rgb::ONE),
    };
    let normal = point.shading_normal;
    let facing = normal.dot(ray.dir).abs() / ray.dir.length().max(f32::MIN_POSITIVE);
    let color = if is_clay { Vec3::splat(CLAY) } else { albedo };
    PathSample {
        radiance: color * (EDGE_ON + (1.0 - EDGE_ON) * facing.min(1.0)),
        seen: Rgb::ZERO,
        albedo,
        normal,
        depth: hit.t,
        first_hit: Some(hit),
        rays,
    }
}
