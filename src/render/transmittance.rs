//! The share of a light's radiance that arrives through everything in between.

use glam::Vec3;

use super::scene::RenderScene;
use crate::color::Rgb;
use crate::light::Target;
use crate::math::{Ray, offset_origin};
use crate::shading::TransportMode;

/// The share of a light's radiance that arrives at `origin` from `target`, in the direction `wi`, through at most `crossings` surfaces
/// that let it pass. Counts the rays it traces into `rays`.
///
/// The ray follows one straight line. At each surface its origin moves to the far side of that surface. For a target that is a point the
/// ray is then aimed again, which corrects the rounding of that move, but only if the target lies on the far side as well. Otherwise the
/// target is at the surface itself, within rounding, and the ray has arrived. The distance to the target therefore falls at each crossing:
/// with `r` from the surface to the target, `n` the normal to the far side and `d` the move, `|r - d n|^2 < |r|^2 - d^2` as `n . r > d`.
pub(super) fn transmittance(
    scene: &RenderScene,
    origin: Vec3,
    wi: Vec3,
    target: Target,
    crossings: u32,
    rays: &mut u32,
) -> Rgb {
    let mut shadow = match target {
        Target::Point(target) => Ray::segment(origin, target),
        Target::Infinity => Ray::new(origin, wi),
    };
    let mut arriving = Rgb::ONE;
    for crossed in 0.. {
        *rays += 1;
        if !scene.materials.has_null_lobe() {
            if scene.geometry.occluded(&shadow) {
                return Rgb::ZERO;
            }
            break;
        }
        let Some(hit) = scene.geometry.intersect(&shadow) else {
            break;
        };
        if crossed >= crossings {
            return Rgb::ZERO;
        }
        let slot = scene.slot(&hit);
        let point = scene.surface(&shadow, &hit, &slot);
        // What passes straight through is not refracted, so that any mode will do.
        let scattering = scene.scattering(slot.material, &hit, &point, -wi, TransportMode::Radiance);
        arriving *= scattering.transmittance();
        if arriving == Rgb::ZERO {
            break;
        }
        let normal = point.geometric_normal;
        let beyond = offset_origin(point.position, point.error, normal, shadow.dir);
        shadow = match target {
            Target::Infinity => Ray::new(beyond, wi),
            Target::Point(target) => {
                let rest = Ray::segment(beyond, target);
                if rest.dir.dot(normal) * shadow.dir.dot(normal) <= 0.0 {
                    break;
                }
                rest
            }
        };
    }
    arriving
}
