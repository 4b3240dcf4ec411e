//! Camera rays through borders of media: the medium at a point, the first surface behind borders that do not bend or
//! absorb light, the optical depth up to it, and its colour if a lamp at the camera is the only light. That colour is
//! complete with the first sample, wherever the lights of the scene are.

use glam::Vec3;

use super::path_state::PathSample;
use super::scene::{RenderScene, SurfaceSlot};
use crate::accel::{Detail, Hit, SurfacePoint};
use crate::color::Rgb;
use crate::material::Material;
use crate::math::{Ray, offset_origin};
use crate::medium::{MediumId, Way};
use crate::shading::TransportMode;

/// The most borders that a ray passes.
const MOST_BORDERS: u32 = 1024;

/// The medium at the point `to`, given that `medium` is at the point `from`, both in world space. Every surface on the
/// straight segment between them that names media on its sides is a border, whatever its material.
pub fn medium_at(scene: &RenderScene, from: Vec3, mut medium: Option<MediumId>, to: Vec3) -> Option<MediumId> {
    let mut ray = Ray::segment(from, to);
    for _ in 0..MOST_BORDERS {
        if ray.dir == Vec3::ZERO {
            break;
        }
        let Some(hit) = scene.geometry.intersect(&ray) else {
            break;
        };
        let point = scene.geometry.surface_in(&ray, &hit, Detail::Plain);
        let normal = point.geometric_normal;
        medium = scene.slot(&hit).media.entered(medium, ray.dir, normal);
        let rest = Ray::segment(offset_origin(point.position, point.error, normal, ray.dir), to);
        // The point is on the surface, within rounding.
        if rest.dir.dot(ray.dir) <= 0.0 {
            break;
        }
        ray = rest;
    }
    medium
}

/// A surface that a ray meets.
pub(crate) struct Met {
    /// The hit of the whole ray.
    pub hit: Hit,
    pub slot: SurfaceSlot,
    pub point: SurfacePoint,
}

/// The first surface along a ray that is not just a border, and the number of rays traced. `along` is called with the
/// segments through media up to it; the ray starts in `medium`.
pub(crate) fn behind_borders(
    scene: &RenderScene,
    ray: &Ray,
    mut medium: Option<MediumId>,
    mut along: impl FnMut(MediumId, &Way),
) -> (Option<Met>, u32) {
    let (mut ray, mut before) = (*ray, 0.0);
    let length = ray.dir.length().max(f32::MIN_POSITIVE);
    for rays in 1..=MOST_BORDERS {
        let found = scene.geometry.intersect(&ray);
        if let Some(medium) = medium {
            let end = found.map_or(ray.t_max, |hit| hit.t);
            let way = Way {
                origin: ray.at(ray.t_min),
                dir: ray.dir / length,
                length: (end - ray.t_min) * length,
            };
            along(medium, &way);
        }
        let Some(mut hit) = found else {
            return (None, rays);
        };
        let slot = scene.slot(&hit);
        let point = scene.surface(&ray, &hit, &slot);
        let is_border = slot.light.is_none() && matches!(scene.materials.get(slot.material), Some(Material::Null));
        if !is_border {
            hit.t += before;
            return (Some(Met { hit, slot, point }), rays);
        }
        let normal = point.geometric_normal;
        medium = slot.media.entered(medium, ray.dir, normal);
        before += hit.t;
        ray = Ray {
            t_max: ray.t_max - hit.t,
            ..Ray::new(offset_origin(point.position, point.error, normal, ray.dir), ray.dir)
        };
    }
    (None, MOST_BORDERS)
}

/// The largest depth that is told apart: nothing is seen through it. It is finite, as the film's sums have to be.
const DEEPEST: f32 = 1e4;

/// The optical depth up to the first surface that is not merely the border of a medium, by colour. The ray begins in
/// `medium`.
pub(super) fn optical_depth(scene: &RenderScene, ray: &Ray, medium: Option<MediumId>) -> PathSample {
    let mut depth = Rgb::ZERO;
    let (met, rays) = behind_borders(scene, ray, medium, |medium, way| {
        depth += scene.media.get(medium).optical_depth(way);
    });
    PathSample {
        radiance: depth.min(Rgb::splat(DEEPEST)),
        normal: met
            .as_ref()
            .map_or_else(Default::default, |met| met.point.shading_normal),
        depth: met.as_ref().map_or(0.0, |met| met.hit.t),
        first_hit: met.map(|met| met.hit),
        rays,
        ..PathSample::default()
    }
}

/// The brightness of a surface that is seen edge on, as a share of that of one seen from the front.
const EDGE_ON: f32 = 0.15;
/// The colour of all surfaces in clay.
const CLAY: f32 = 0.55;
/// The colour where there is nothing.
const NOTHING: f32 = 0.03;

/// The colour of the surface that `ray` meets, or that of clay. Masks and glass count as opaque; borders of media are
/// not there.
pub(super) fn headlight(scene: &RenderScene, ray: &Ray, is_clay: bool) -> PathSample {
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
