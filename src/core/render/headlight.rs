//! Surfaces lit by nothing but a lamp at the camera: complete with the first sample, wherever the lights of the scene
//! are.

use glam::Vec3;

use super::borders::{Met, behind_borders};
use super::path_state::PathSample;
use super::scene::RenderScene;
use crate::color::Rgb;
use crate::math::Ray;
use crate::shading::TransportMode;

/// The brightness of a surface that is seen edge on, as a share of that of one seen from the front.
const EDGE_ON: f32 = 0.15;
/// The colour of all surfaces in clay.
const CLAY: f32 = 0.55;
/// The colour where there is nothing.
const NOTHING: f32 = 0.03;

/// The colour of the surface that `ray` meets, or that of clay. Masks and glass count as opaque; borders of media are
/// not there.
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
