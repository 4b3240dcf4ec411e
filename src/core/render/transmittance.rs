//! The transmittance between a light and a vertex.

use glam::Vec3;

use super::scene::RenderScene;
use crate::accel::Obstacle;
use crate::color::Rgb;
use crate::light::Target;
use crate::math::{Ray, offset_origin};
use crate::medium::{MediumId, Way};
use crate::sampling::RandomStream;
use crate::shading::TransportMode;

/// A segment from a vertex of a path to a light.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShadowRay {
    /// The start, off the surface if the vertex is on one.
    pub origin: Vec3,
    /// Unit vector to the light.
    pub wi: Vec3,
    pub target: Target,
    /// The most surfaces that the ray may pass.
    pub crossings: u32,
}

impl ShadowRay {
    fn ray(&self) -> Ray {
        match self.target {
            Target::Point(target) => Ray::segment(self.origin, target),
            Target::Infinity => Ray::new(self.origin, self.wi),
        }
    }
}

/// The light of a shadow ray.
pub(super) struct Arriving {
    /// The share of the light's radiance that arrives.
    pub share: Rgb,
    /// The probability with which media would have let the path reach the light.
    pub passed: f32,
    /// The first visible surface that was passed, by its instance.
    pub through: Option<u32>,
}

/// The share of a light's radiance that arrives at the start of `shadow`. Adds the number of traced rays to `rays`.
/// `through` attenuates light between surfaces.
pub(super) fn transmittance(
    scene: &RenderScene,
    shadow: &ShadowRay,
    through: &mut impl Between,
    rays: &mut u32,
) -> Rgb {
    *rays += 1;
    let ray = shadow.ray();
    let obstacle = match scene.materials.has_null_lobe() {
        true => scene.geometry.obstacle(&ray, |shape| scene.is_clear(shape)),
        false => scene.geometry.obstacle(&ray, |_| false),
    };
    match obstacle {
        Obstacle::Nothing => through.medium(scene, &ray, ray.t_max),
        Obstacle::Clear => passing(scene, shadow, through, rays),
        Obstacle::Opaque => Rgb::ZERO,
    }
}

/// [`transmittance`] where there are surfaces through which light may pass.
///
/// The ray follows one straight line. At each surface its origin moves to the far side of that surface. For a target
/// that is a point the ray is then aimed again, which corrects the rounding of that move, but only if the target is on
/// the far side as well. Otherwise the target is at the surface itself, within rounding, and the ray has arrived. The
/// distance to the target therefore falls at each crossing: with `r` from the surface to the target, `n` the normal to
/// the far side and `d` the move, `|r - d n|^2 < |r|^2 - d^2` as `n . r > d`.
#[inline(never)]
pub(super) fn passing(scene: &RenderScene, shadow: &ShadowRay, through: &mut impl Between, rays: &mut u32) -> Rgb {
    let ShadowRay { wi, target, .. } = *shadow;
    let mut ray = shadow.ray();
    let mut arriving = Rgb::ONE;
    for crossed in 0.. {
        *rays += 1;
        let Some(hit) = scene.geometry.intersect(&ray) else {
            return arriving * through.medium(scene, &ray, ray.t_max);
        };
        if crossed >= shadow.crossings {
            return Rgb::ZERO;
        }
        let slot = scene.slot(&hit);
        let point = scene.surface(&ray, &hit, &slot);
        // Light that passes straight is not refracted, so that the mode does not matter.
        let scattering = scene.scattering(slot.material, &hit, &point, -wi, TransportMode::Radiance);
        let passing = scattering.transmittance();
        if passing == Rgb::ZERO {
            return Rgb::ZERO;
        }
        arriving *= through.medium(scene, &ray, hit.t) * passing;
        if arriving == Rgb::ZERO {
            return Rgb::ZERO;
        }
        if !scene.materials.is_null(slot.material) {
            through.pane(hit.instance);
        }
        let normal = point.geometric_normal;
        through.surface(passing, |before| slot.media.entered(before, wi, normal));
        let beyond = offset_origin(point.position, point.error, normal, ray.dir);
        ray = match target {
            Target::Infinity => Ray::new(beyond, wi),
            Target::Point(target) => {
                let rest = Ray::segment(beyond, target);
                if rest.dir.dot(normal) * ray.dir.dot(normal) <= 0.0 {
                    break;
                }
                rest
            }
        };
    }
    arriving
}

/// The space between the surfaces that a shadow ray passes.
pub(super) trait Between {
    /// The transmittance along `ray` up to `t`.
    fn medium(&mut self, scene: &RenderScene, ray: &Ray, t: f32) -> Rgb;

    /// Passes a surface with the transmittance `passing`. `entered` gives the medium behind it from that in front.
    fn surface(&mut self, passing: Rgb, entered: impl FnOnce(Option<MediumId>) -> Option<MediumId>);

    /// Passes a surface of this instance that is not invisible.
    #[inline(always)]
    fn pane(&mut self, _instance: u32) {}
}

/// A space of which the first surface that is passed is noted, for observers.
pub(super) struct Noting<B> {
    pub space: B,
    /// The instance of the surface, which is not that of an invisible border.
    pub first: Option<u32>,
}

impl<B> Noting<B> {
    pub fn new(space: B) -> Self {
        Self { space, first: None }
    }
}

impl<B: Between> Between for Noting<B> {
    #[inline(always)]
    fn medium(&mut self, scene: &RenderScene, ray: &Ray, t: f32) -> Rgb {
        self.space.medium(scene, ray, t)
    }

    #[inline(always)]
    fn surface(&mut self, passing: Rgb, entered: impl FnOnce(Option<MediumId>) -> Option<MediumId>) {
        self.space.surface(passing, entered);
    }

    #[inline(always)]
    fn pane(&mut self, instance: u32) {
        self.first.get_or_insert(instance);
    }
}

/// Empty space, with transmittance 1.
pub(super) struct EmptySpace;

impl Between for EmptySpace {
    #[inline(always)]
    fn medium(&mut self, _: &RenderScene, _: &Ray, _: f32) -> Rgb {
        Rgb::ONE
    }

    #[inline(always)]
    fn surface(&mut self, _: Rgb, _: impl FnOnce(Option<MediumId>) -> Option<MediumId>) {}
}

/// Participating media.
pub(super) struct Media {
    /// The medium at the current point.
    medium: Option<MediumId>,
    /// The throughput that a path would have at the current point, up to a factor.
    carried: Rgb,
    /// The probability with which the path would have reached the current point likewise.
    pub passed: f32,
    stream: RandomStream,
}

impl Media {
    /// The start of a shadow ray in `medium`, with this throughput.
    pub fn new(medium: Option<MediumId>, carried: Rgb, stream: RandomStream) -> Self {
        Self {
            medium,
            carried,
            passed: 1.0,
            stream,
        }
    }
}

impl Between for Media {
    fn medium(&mut self, scene: &RenderScene, ray: &Ray, t: f32) -> Rgb {
        let Some(medium) = self.medium else {
            return Rgb::ONE;
        };
        if self.carried == Rgb::ZERO {
            return Rgb::ZERO;
        }
        let length = ray.dir.length();
        let way = Way {
            origin: ray.origin,
            dir: ray.dir / length,
            length: t * length,
        };
        let (passing, passed) = scene
            .media
            .get(medium)
            .transmit(&way, &mut self.carried, &mut self.stream);
        self.passed *= passed;
        passing
    }

    fn surface(&mut self, passing: Rgb, entered: impl FnOnce(Option<MediumId>) -> Option<MediumId>) {
        self.carried *= passing;
        self.medium = entered(self.medium);
    }
}
