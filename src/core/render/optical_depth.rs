//! The optical depth along the camera ray up to the first surface.

use super::borders::behind_borders;
use super::path_state::PathSample;
use super::scene::RenderScene;
use crate::color::Rgb;
use crate::math::Ray;
use crate::medium::MediumId;

/// The largest optical depth shown, through which nothing is visible. It is finite, as the film's sums have to be.
const DEEPEST: f32 = 1e4;

/// The optical depth up to the first surface that is not just a border of media, per channel. The ray begins in
/// `medium`.
pub(super) fn sample(scene: &RenderScene, ray: &Ray, medium: Option<MediumId>) -> PathSample {
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
