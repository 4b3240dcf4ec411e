//! The steps of [`super::path`] in participating media: sampling of distances, and scattering (PBR 4th ed., section
//! 14.2.3).
//!
//! Multiple importance sampling compares whole path segments to a light: the density of an arrival is that of the
//! direction times the probability of passing all media on the segment ([`crate::medium::Travel::passed`]). In dense
//! fog a phase function seldom finds a lamp, and then its weight is small.

use std::ops::ControlFlow::{self, Break, Continue};

use glam::Vec3;

use super::dimensions::{BounceDraw, MediumDraw};
use super::observer::{Bounce, Glow, MediumVertex, PathEnd, PathObserver, PathVertex};
use super::path::{Departure, Scatterer};
use super::path_state::{Arrival, PathState};
use super::roulette;
use super::scene::RenderScene;
use super::view::PathSettings;
use crate::accel::Hit;
use crate::color::Rgb;
use crate::light::LightReference;
use crate::material::Lobe;
use crate::math::{Ray, Real};
use crate::medium::{Medium, MediumId, Travel, Way};
use crate::sampling::Sampler;

/// The share of the scatterings in media within refracting surfaces from which lights are sampled. Few samples succeed,
/// because such surfaces let no light pass straight; but there may be a lamp inside.
pub(super) const ENCLOSED_SHARE: f32 = 0.125;

/// Whether a path with this squared relative index of refraction is inside a refracting surface.
#[inline(always)]
pub(super) fn is_enclosed<R: Real>(eta_squared: R) -> R::Mask {
    // The indices of entering and leaving multiply to 1 up to rounding.
    R::is_above(eta_squared, 1.001)
}

/// A vertex in a medium, where a path is scattered.
struct Vertex<'a> {
    medium: &'a Medium,
    /// The direction in which the path has arrived.
    dir: Vec3,
    reference: LightReference,
}

impl Scatterer for Vertex<'_> {
    fn reference(&self) -> &LightReference {
        &self.reference
    }

    fn eval_and_pdf(&self, wi: Vec3) -> (Rgb, f32) {
        let pdf = self.medium.phase().pdf(self.reference.position, self.dir, wi);
        (Rgb::splat(pdf), pdf)
    }

    fn seeks_light(&self, u_choice: f32, eta_squared: f32) -> Option<(f32, f32)> {
        let u_choice = match is_enclosed(eta_squared) {
            false => return Some((u_choice, 1.0)),
            true => u_choice / ENCLOSED_SHARE,
        };
        (u_choice < 1.0).then_some((u_choice, 1.0 / ENCLOSED_SHARE))
    }

    fn leave(&self, _: Vec3, medium: Option<MediumId>) -> Departure {
        Departure {
            origin: self.reference.position,
            medium,
        }
    }
}

/// A path segment through a medium, from vertex number `depth` on.
pub(super) struct Leg {
    pub way: Way,
    pub depth: u32,
    /// The counted segments of the path up to that vertex.
    pub segments: u32,
    /// Whether the segment is inside a refracting surface, see [`is_enclosed`].
    pub is_enclosed: bool,
    pub sampler: Sampler,
}

impl Leg {
    /// Samples the segment as [`Medium::travel`] does.
    #[inline]
    pub fn travel(
        &self,
        scene: &RenderScene,
        settings: &PathSettings,
        medium: &Medium,
        throughput: &mut Rgb,
    ) -> Travel {
        let draw = MediumDraw::Distance.at(self.depth + 1);
        let (u, mut stream) = (self.sampler.at_2d(draw), self.sampler.stream(draw));
        let lamp = self.lamp_near(scene, settings, medium);
        medium.travel(&self.way, lamp, throughput, u, &mut stream)
    }

    /// A point on a light that is likely to matter along the segment. The medium decides whether it is used.
    fn lamp_near(&self, scene: &RenderScene, settings: &PathSettings, medium: &Medium) -> Option<Vec3> {
        // Light scattered at the last vertex would be lost.
        let is_of_use = settings.strategy.samples_lights() && !self.is_enclosed && !settings.is_last(self.segments + 1);
        if !is_of_use || scene.lights.finite_bounds().is_none() {
            return None;
        }
        let reference = LightReference {
            position: self.way.origin + self.way.dir * medium.midway(self.way.length)?,
            normal: None,
        };
        let u_choice = self.sampler.at_1d(MediumDraw::Lamp.at(self.depth + 1));
        let u_point = self.sampler.at_2d(MediumDraw::LampPoint.at(self.depth + 1));
        scene.lights.sample_place(&reference, u_choice, u_point)
    }
}

impl PathState {
    /// Takes the path through its medium up to `hit`, the end of its ray, or to a scattering before that. True if it
    /// was scattered and has its next ray.
    #[inline(never)]
    pub(super) fn travel(
        &mut self,
        scene: &RenderScene,
        settings: &PathSettings,
        id: MediumId,
        hit: Option<&Hit>,
        observer: &mut impl PathObserver,
    ) -> ControlFlow<PathEnd, bool> {
        let medium = scene.media.get(id);
        // Hidden emitters have moved the origin of the camera ray.
        let passed = if self.depth == 0 { self.record.passed } else { 0.0 };
        let way = Way {
            origin: self.ray.origin - self.ray.dir * passed,
            dir: self.ray.dir,
            length: hit.map_or(f32::INFINITY, |hit| passed + hit.t),
        };
        let leg = Leg {
            way,
            depth: self.depth,
            segments: self.segments(),
            is_enclosed: is_enclosed(self.eta_squared),
            sampler: self.sampler,
        };
        let travel = leg.travel(scene, settings, medium, &mut self.throughput);
        if travel.emitted != Rgb::ZERO && settings.max_depth > 0 {
            self.radiance += travel.emitted;
            self.record.come_upon(travel.emitted);
            observer.emitted(&Glow {
                medium: id,
                contribution: travel.emitted,
            });
        }
        self.arrival.pdf *= travel.passed;
        let Some(distance) = travel.scattered_at else {
            return match self.throughput == Rgb::ZERO {
                true => Break(PathEnd::Absorbed),
                false => Continue(false),
            };
        };
        if let Some(hit) = hit {
            if self.depth == 0 {
                self.record.meet(hit);
            }
            observer.met(&self.ray, hit);
        }
        let vertex = Vertex {
            medium,
            dir: self.ray.dir,
            reference: LightReference {
                position: way.origin + way.dir * distance,
                normal: None,
            },
        };
        observer.vertex(&PathVertex::Medium(MediumVertex {
            position: vertex.reference.position,
            medium: id,
        }));
        self.scatter_in_medium(scene, settings, &vertex, observer)?;
        Continue(true)
    }

    /// Scatters the path at a point in its medium.
    fn scatter_in_medium(
        &mut self,
        scene: &RenderScene,
        settings: &PathSettings,
        vertex: &Vertex,
        observer: &mut impl PathObserver,
    ) -> ControlFlow<PathEnd> {
        self.depth += 1;
        if self.throughput == Rgb::ZERO {
            return Break(PathEnd::Absorbed);
        }
        self.record.take_medium_features(self.throughput);
        if settings.is_last(self.segments()) {
            return Break(PathEnd::DepthLimit);
        }
        self.sample_light(scene, settings, vertex, observer);
        let u_choice = self.sampler.at_1d(BounceDraw::Lobe.at(self.depth));
        let u_direction = self.sampler.at_2d(BounceDraw::Direction.at(self.depth));
        let position = vertex.reference.position;
        let (wi, pdf) = vertex
            .medium
            .phase()
            .sample(position, vertex.dir, u_choice, u_direction);
        self.is_straight = false;
        self.arrival = Arrival {
            is_sampled: true,
            pdf,
            from: vertex.reference,
        };
        self.ray = Ray::new(position, wi);
        let survival = self.play_roulette(settings, true, roulette::survival_in_media)?;
        observer.bounced(&Bounce {
            wi,
            lobe: Lobe::Smooth,
            pdf,
            survival,
            throughput: self.throughput,
        });
        Continue(())
    }
}
