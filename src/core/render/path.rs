//! Unidirectional path tracing with next event estimation and multiple importance sampling (Kajiya 1986; Veach 1997,
//! chapters 9 and 10; PBR 4th ed., section 13.4): one path at a time. The same steps for sixteen paths are in `lanes`.

use std::ops::ControlFlow::{self, Break, Continue};

use glam::Vec3;

pub use super::path_state::PathSample;

use super::dimensions::{BounceDraw, MediumDraw};
use super::observer::{Bounce, PathEnd, PathObserver, PathVertex, SampledLight, SurfaceVertex};
use super::path_state::{Arrival, PathState};
use super::roulette;
use super::scene::{RenderScene, SurfaceSlot};
use super::transmittance::{Arriving, EmptySpace, Media, Noting, ShadowRay, transmittance};
use super::view::{LONGEST_PATH, PathSettings};
use crate::accel::{Detail, Hit, SurfacePoint};
use crate::color::Rgb;
use crate::light::{LightId, LightReference, LightSample, LightTable, SurfaceHit};
use crate::material::{Lobe, ScatterSample, Scattering};
use crate::math::{Ray, offset_origin};
use crate::medium::MediumId;
use crate::sampling::Sampler;
use crate::shading::TransportMode;

/// Traces one sample of the radiance arriving along `-ray.dir` at the ray's origin, which is in `medium`. `observer`
/// receives the events without an effect on them; `()` is no observer.
pub fn trace_path(
    scene: &RenderScene,
    settings: &PathSettings,
    ray: Ray,
    sampler: Sampler,
    medium: Option<MediumId>,
    observer: &mut impl PathObserver,
) -> PathSample {
    let mut path = PathState::new(ray, sampler, medium.filter(|_| settings.media));
    loop {
        path.rays += 1;
        let hit = scene.geometry.intersect(&path.ray);
        let hit = path.behind_hidden_emitters(scene, settings, hit);
        if !path.advance(scene, settings, hit, observer) {
            return path.sample();
        }
    }
}

/// A surface that a path has reached.
struct Vertex<'a> {
    point: &'a SurfacePoint,
    slot: SurfaceSlot,
    scattering: &'a Scattering<'a>,
    /// Whether the surface scatters by a density, so that light sampling helps.
    is_smooth: bool,
    /// The reference point for light sampling.
    reference: LightReference,
}

/// The start of a shadow ray.
pub(super) struct Departure {
    pub origin: Vec3,
    /// The medium there.
    pub medium: Option<MediumId>,
}

/// The scattering at a vertex, as light sampling needs it.
pub(super) trait Scatterer {
    /// The reference point for light sampling.
    fn reference(&self) -> &LightReference;

    /// The part of light from `wi` that is scattered along the path, times the cosine at surfaces; and the density per
    /// solid angle with which the path would have gone to `wi`.
    fn eval_and_pdf(&self, wi: Vec3) -> (Rgb, f32);

    /// Whether a light is sampled: the number by which it is chosen, and the factor on its light. `u_choice` decides
    /// for a path with this squared relative index of refraction.
    #[inline(always)]
    fn seeks_light(&self, u_choice: f32, _eta_squared: f32) -> Option<(f32, f32)> {
        Some((u_choice, 1.0))
    }

    /// Whether a light without extent counts.
    #[inline(always)]
    fn takes_delta(&self, _lights: &LightTable, _id: LightId) -> bool {
        true
    }

    /// The start of the shadow ray to `wi` for a path in `medium`.
    fn leave(&self, wi: Vec3, medium: Option<MediumId>) -> Departure;
}

impl Scatterer for Vertex<'_> {
    #[inline(always)]
    fn reference(&self) -> &LightReference {
        &self.reference
    }

    #[inline(always)]
    fn eval_and_pdf(&self, wi: Vec3) -> (Rgb, f32) {
        self.scattering.eval_and_pdf(wi)
    }

    #[inline(always)]
    fn leave(&self, wi: Vec3, medium: Option<MediumId>) -> Departure {
        Departure {
            origin: leave(self.point, wi),
            medium: self.slot.media.entered(medium, wi, self.point.geometric_normal),
        }
    }
}

impl PathState {
    /// The first hit of a camera ray behind the hidden emitters, if `hit` is its first hit of all. The ray then starts
    /// behind the last of these shapes. As in Mitsuba 3.9, they do not count as depth, whatever side they emit on.
    #[inline(always)]
    pub fn behind_hidden_emitters(
        &mut self,
        scene: &RenderScene,
        settings: &PathSettings,
        hit: Option<Hit>,
    ) -> Option<Hit> {
        if settings.hide_emitters && self.depth == 0 {
            self.pass_hidden_emitters(scene, hit)
        } else {
            hit
        }
    }

    #[inline(never)]
    fn pass_hidden_emitters(&mut self, scene: &RenderScene, mut hit: Option<Hit>) -> Option<Hit> {
        for _ in 0..LONGEST_PATH {
            let met = hit?;
            if scene.slot(&met).light.is_none() {
                break;
            }
            let point = scene.geometry.surface_in(&self.ray, &met, Detail::Plain);
            self.ray.origin = leave(&point, self.ray.dir);
            self.ray.t_min = 0.0;
            self.ray.t_max -= met.t;
            self.record.passed += met.t;
            self.rays += 1;
            hit = scene.geometry.intersect(&self.ray);
        }
        hit
    }

    /// Takes the path to `hit`, the nearest hit of its ray, and samples its next ray. False if it ends.
    #[inline(always)]
    pub fn advance(
        &mut self,
        scene: &RenderScene,
        settings: &PathSettings,
        hit: Option<Hit>,
        observer: &mut impl PathObserver,
    ) -> bool {
        let end = self.next_ray(scene, settings, hit, observer);
        goes_on(end, observer)
    }

    /// Samples the next ray of the path, which has reached `hit` already. False if it ends.
    #[inline(always)]
    pub fn advance_from(
        &mut self,
        scene: &RenderScene,
        settings: &PathSettings,
        hit: Hit,
        observer: &mut impl PathObserver,
    ) -> bool {
        let end = self.next_ray_from(scene, settings, hit, observer);
        goes_on(end, observer)
    }

    #[inline(always)]
    fn next_ray(
        &mut self,
        scene: &RenderScene,
        settings: &PathSettings,
        hit: Option<Hit>,
        observer: &mut impl PathObserver,
    ) -> ControlFlow<PathEnd> {
        if let Some(medium) = self.medium
            && self.travel(scene, settings, medium, hit.as_ref(), observer)?
        {
            return Continue(());
        }
        let Some(hit) = hit else {
            self.escape(scene, settings, observer);
            return Break(PathEnd::Escaped);
        };
        self.next_ray_from(scene, settings, hit, observer)
    }

    #[inline(always)]
    fn next_ray_from(
        &mut self,
        scene: &RenderScene,
        settings: &PathSettings,
        hit: Hit,
        observer: &mut impl PathObserver,
    ) -> ControlFlow<PathEnd> {
        let slot = scene.slot(&hit);
        let point = scene.surface(&self.ray, &hit, &slot);
        self.arrive(scene, settings, &hit, &slot, &point, observer);
        let scattering = scene.scattering(slot.material, &hit, &point, -self.ray.dir, TransportMode::Radiance);
        let vertex = Vertex {
            point: &point,
            slot,
            scattering: &scattering,
            is_smooth: scattering.has_smooth_lobe(),
            reference: LightReference {
                position: point.position,
                normal: scattering.one_sided_normal(),
            },
        };
        let is_last = settings.is_last(self.segments());
        // The end of the path may still be behind surfaces that do not count.
        if is_last && !(settings.media && scattering.transmittance() != Rgb::ZERO) {
            self.take_features(&vertex, true);
            return Break(PathEnd::DepthLimit);
        }
        let u_lobe = self.sampler.at_1d(BounceDraw::Lobe.at(self.depth));
        let u_direction = self.sampler.at_2d(BounceDraw::Direction.at(self.depth));
        let sample = scattering.sample(u_lobe, u_direction);
        let passes = sample.is_some_and(|sample| sample.lobe == Lobe::Null);
        if !passes {
            self.take_features(&vertex, is_last);
        }
        if is_last && !passes {
            return Break(PathEnd::DepthLimit);
        }
        if vertex.is_smooth && !is_last {
            self.sample_light(scene, settings, &vertex, observer);
        }
        let sample = self.bounce(settings, &vertex, sample)?;
        let is_scattered = sample.lobe == Lobe::Smooth;
        let survival = self.play_roulette(settings, is_scattered, roulette::survival)?;
        observer.bounced(&Bounce {
            wi: sample.wi,
            lobe: sample.lobe,
            pdf: sample.pdf,
            survival,
            throughput: self.throughput,
        });
        Continue(())
    }

    /// The counted segments of the path up to its last vertex.
    #[inline(always)]
    pub(super) fn segments(&self) -> u32 {
        self.depth - self.uncounted
    }

    /// Ends the path outside of the scene, and adds the light from there.
    #[inline(always)]
    pub fn escape(&mut self, scene: &RenderScene, settings: &PathSettings, observer: &mut impl PathObserver) {
        let is_hidden = settings.hide_emitters && self.is_straight;
        if settings.max_depth > 0 && !is_hidden {
            let wi = self.ray.dir;
            for &light in scene.lights.infinite() {
                let (radiance, light_pdf) = match self.arrival.is_sampled {
                    true => scene.lights.radiance_and_pdf_from(light, &self.arrival.from, wi),
                    false => (scene.lights.radiance_from(light, wi), 0.0),
                };
                self.add_emitter(settings, light, radiance, |_| light_pdf, observer);
            }
        }
        self.record.escape(self.radiance);
    }

    /// Arrives at the surface at `hit` and adds its emission.
    #[inline(always)]
    fn arrive(
        &mut self,
        scene: &RenderScene,
        settings: &PathSettings,
        hit: &Hit,
        slot: &SurfaceSlot,
        point: &SurfacePoint,
        observer: &mut impl PathObserver,
    ) {
        if self.depth == 0 {
            self.record.meet(hit);
        }
        observer.met(&self.ray, hit);
        observer.vertex(&PathVertex::Surface(SurfaceVertex {
            position: point.position,
            normal: point.shading_normal,
            instance: hit.instance,
            material: slot.material,
        }));
        if let Some(light) = slot.light {
            self.see_light(scene, settings, hit, light, point, observer);
        }
        self.depth += 1;
    }

    /// Adds the emission of the surface at `hit`, a part of `light`, towards the path.
    #[inline(always)]
    pub fn see_light(
        &mut self,
        scene: &RenderScene,
        settings: &PathSettings,
        hit: &Hit,
        light: LightId,
        point: &SurfacePoint,
        observer: &mut impl PathObserver,
    ) {
        if settings.max_depth == 0 {
            return;
        }
        let on_light = SurfaceHit::at(hit, point);
        let emitted = scene.lights.emitted(light, &on_light, -self.ray.dir);
        if emitted != Rgb::ZERO {
            let light_pdf = |from: &LightReference| scene.lights.pdf_of_hit(light, from, &on_light);
            self.add_emitter(settings, light, emitted, light_pdf, observer);
        }
    }

    /// Adds the `radiance` of an emitter that the path has hit. `light_pdf` is that of [`Arrival::weigh`].
    #[inline(always)]
    fn add_emitter(
        &mut self,
        settings: &PathSettings,
        light: LightId,
        radiance: Rgb,
        light_pdf: impl FnOnce(&LightReference) -> f32,
        observer: &mut impl PathObserver,
    ) {
        let met = self
            .arrival
            .weigh(settings.strategy, light_pdf)
            .emitter(light, radiance, self.throughput);
        self.radiance += met.contribution;
        self.record.come_upon(met.contribution);
        observer.emitter_met(&met);
    }

    fn take_features(&mut self, vertex: &Vertex, is_last: bool) {
        let is_light = vertex.slot.light.is_some();
        if self.record.wants_features(vertex.is_smooth, is_light, is_last) {
            let (albedo, normal) = (vertex.scattering.albedo(), vertex.point.shading_normal);
            self.record.take_features(self.throughput, albedo, normal, is_light);
        }
    }

    /// Samples a light from the vertex and adds the light that is scattered along the path (next event estimation).
    #[inline(always)]
    pub(super) fn sample_light(
        &mut self,
        scene: &RenderScene,
        settings: &PathSettings,
        vertex: &impl Scatterer,
        observer: &mut impl PathObserver,
    ) {
        let u_choice = self.sampler.at_1d(BounceDraw::LightChoice.at(self.depth));
        let u_point = self.sampler.at_2d(BounceDraw::LightPoint.at(self.depth));
        let Some((u_choice, raised)) = vertex.seeks_light(u_choice, self.eta_squared) else {
            return;
        };
        let Some((id, light)) = scene.lights.sample(vertex.reference(), u_choice, u_point) else {
            return;
        };
        let strategy = settings.strategy;
        let counts = match light.is_delta {
            true => vertex.takes_delta(&scene.lights, id),
            false => strategy.samples_lights(),
        };
        if !counts {
            return;
        }
        let (value, bsdf_pdf) = vertex.eval_and_pdf(light.wi);
        let carried = self.throughput * value * raised;
        let (mut arriving, mut passed, mut through) = (None, 1.0, None);
        if carried * light.radiance != Rgb::ZERO {
            let departure = vertex.leave(light.wi, self.medium);
            let arrival = self.trace_shadow_ray(scene, settings, departure, carried, &light);
            (arriving, passed, through) = (Some(arrival.share), arrival.passed, arrival.through);
        }
        let weight = strategy.light_weight(light.is_delta, light.pdf, bsdf_pdf * passed);
        let reflected = carried * light.radiance * (weight / light.pdf);
        let sampled = SampledLight {
            light: id,
            sample: light,
            bsdf_pdf,
            passed,
            weight,
            arriving,
            through,
            contribution: reflected * arriving.unwrap_or(Rgb::ZERO),
        };
        self.radiance += sampled.contribution;
        observer.light_sampled(&sampled);
    }

    /// Traces the light that arrives at the path's vertex, which the path would scatter with the throughput `carried`.
    fn trace_shadow_ray(
        &mut self,
        scene: &RenderScene,
        settings: &PathSettings,
        departure: Departure,
        carried: Rgb,
        light: &LightSample,
    ) -> Arriving {
        let shadow = ShadowRay {
            origin: departure.origin,
            wi: light.wi,
            target: light.target,
            crossings: settings.crossings(self.depth),
        };
        if !settings.media {
            let mut space = Noting::new(EmptySpace);
            return Arriving {
                share: transmittance(scene, &shadow, &mut space, &mut self.rays),
                passed: 1.0,
                through: space.first,
            };
        }
        let stream = self.sampler.stream(MediumDraw::Shadow.at(self.depth));
        let mut space = Noting::new(Media::new(departure.medium, carried, stream));
        let share = transmittance(scene, &shadow, &mut space, &mut self.rays);
        Arriving {
            share,
            through: space.first,
            passed: space.space.passed,
        }
    }

    /// Sets the ray of the path to the sampled direction.
    #[inline(always)]
    fn bounce(
        &mut self,
        settings: &PathSettings,
        vertex: &Vertex,
        sample: Option<ScatterSample>,
    ) -> ControlFlow<PathEnd, ScatterSample> {
        let Some(sample) = sample else {
            return Break(PathEnd::Absorbed);
        };
        self.throughput *= sample.weight;
        self.eta_squared = roulette::eta_squared(self.eta_squared, sample.eta);
        if self.throughput == Rgb::ZERO {
            return Break(PathEnd::Absorbed);
        }
        self.is_straight &= sample.lobe == Lobe::Null;
        if settings.media {
            self.uncounted += u32::from(sample.lobe == Lobe::Null);
            let normal = vertex.point.geometric_normal;
            self.medium = vertex.slot.media.entered(self.medium, sample.wi, normal);
        }
        // Shadow rays pass null lobes as well, so the weights are still those of the previous vertex.
        if sample.lobe != Lobe::Null {
            self.arrival = Arrival {
                is_sampled: sample.lobe == Lobe::Smooth,
                pdf: sample.pdf,
                from: vertex.reference,
            };
        }
        self.ray = Ray::new(leave(vertex.point, sample.wi), sample.wi);
        Continue(sample)
    }

    /// Ends the path at random, or returns the probability of its survival. `is_scattered` is that of
    /// [`roulette::is_played`].
    #[inline(always)]
    pub(super) fn play_roulette(
        &mut self,
        settings: &PathSettings,
        is_scattered: bool,
        survival: impl FnOnce(f32, f32) -> f32,
    ) -> ControlFlow<PathEnd, f32> {
        if !roulette::is_played::<f32>(settings, self.segments(), is_scattered) {
            return Continue(1.0);
        }
        let survival = survival(self.throughput.max_element(), self.eta_squared);
        if self.sampler.at_1d(BounceDraw::Roulette.at(self.depth)) >= survival {
            return Break(PathEnd::Roulette);
        }
        self.throughput /= survival;
        Continue(survival)
    }
}

/// Whether a path continues; if not, the observer is notified.
fn goes_on(end: ControlFlow<PathEnd>, observer: &mut impl PathObserver) -> bool {
    if let Break(end) = end {
        observer.ended(end);
    }
    end.is_continue()
}

/// The origin of a ray that leaves a surface in direction `dir`.
fn leave(point: &SurfacePoint, dir: Vec3) -> Vec3 {
    offset_origin(point.position, point.error, point.geometric_normal, dir)
}
