//! Unidirectional path tracing with next event estimation and multiple importance sampling (Kajiya 1986; Veach 1997, chapters 9
//! and 10; PBR 4th ed., section 13.4).

use glam::{Vec2, Vec3};

use super::observer::{Bounce, MetEmitter, PathEnd, PathObserver, PathVertex, SampledLight};
use super::scene::{RenderScene, SurfaceSlot};
use super::view::{LONGEST_PATH, PathSettings, Strategy};
use crate::accel::{Detail, Hit, SurfacePoint};
use crate::color::Rgb;
use crate::light::{LightId, LightReference, LightSample, SurfaceHit, Target};
use crate::material::Lobe;
use crate::math::{Ray, offset_origin};
use crate::sampling::{SPREAD_DIMENSIONS, Sampler, power_heuristic};

/// What one camera ray brought home.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathSample {
    pub radiance: Rgb,
    /// Guides for the denoiser, taken at the first surface that is not perfectly specular: colour in [0, 1] and world normal.
    pub albedo: Rgb,
    pub normal: Vec3,
    /// Distance from the camera ray's origin to the first surface; 0 where there is none.
    pub depth: f32,
    /// None where the camera ray meets nothing.
    pub first_hit: Option<Hit>,
    /// Rays traced, shadow rays included.
    pub rays: u32,
}

/// Dimensions of the sampler before the first bounce (pixel and lens), and per bounce.
pub(super) const CAMERA_DIMENSIONS: u32 = 2;
pub(super) const BOUNCE_DIMENSIONS: u32 = 5;
/// What the eye sees in the first samples is the noise of the camera and of the first surface.
const _: () = assert!(SPREAD_DIMENSIONS == CAMERA_DIMENSIONS + BOUNCE_DIMENSIONS);

/// A path goes on with this probability at most, so that bright enclosures end too.
pub(super) const HIGHEST_SURVIVAL: f32 = 0.95;
/// Roulette waits so many vertices where the surface has left no choice of direction: what a path brings that has found its way through glass
/// is much, and rare. Its chance was counted where it was last scattered.
pub(super) const SPECULAR_GRACE: u32 = 16;

/// How the path came to its current vertex; what the weight of an emitter met there depends on.
#[derive(Clone, Copy, Debug)]
pub(super) enum Arrival {
    /// From the camera or a specular bounce: no other technique could have found the emitter.
    Only,
    /// By a bsdf with this density per solid angle, leaving `from`.
    Sampled { pdf: f32, from: LightReference },
}

/// A path under way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Path {
    /// Where it goes next.
    pub ray: Ray,
    pub throughput: Rgb,
    /// Squared relative index of refraction so far: radiance is scaled by it inside glass, and roulette must not see that.
    pub eta_squared: f32,
    pub arrival: Arrival,
    /// Whether the guides of the result are taken.
    pub guided: bool,
    /// Surfaces met so far, without the hidden emitters that the camera ray has passed.
    pub depth: u32,
    /// Distance from the camera to the origin of its ray, which hidden emitters have moved.
    passed: f32,
    /// Whether all surfaces met so far have let the camera ray pass straight on.
    pub is_straight: bool,
    pub sampler: Sampler,
    /// So far.
    pub result: PathSample,
}

/// One sample of the radiance arriving along `-ray.dir` at the ray's origin. `observer` is told of it and cannot change it; with `()`
/// there is none.
pub fn trace_path(
    scene: &RenderScene,
    settings: &PathSettings,
    ray: Ray,
    sampler: Sampler,
    observer: &mut impl PathObserver,
) -> PathSample {
    let mut path = Path::new(ray, sampler);
    loop {
        let hit = scene.geometry.intersect(&path.ray);
        let hit = path.behind_hidden_emitters(scene, settings, hit);
        if !path.advance(scene, settings, hit, observer) {
            return path.result;
        }
    }
}

impl Path {
    pub fn new(ray: Ray, sampler: Sampler) -> Self {
        Self {
            ray,
            throughput: Rgb::ONE,
            eta_squared: 1.0,
            arrival: Arrival::Only,
            guided: false,
            depth: 0,
            passed: 0.0,
            is_straight: true,
            sampler,
            result: PathSample::default(),
        }
    }

    /// What a camera ray meets behind the emitting shapes that the camera does not see, if `hit` is what it meets first. The ray then
    /// starts behind the last of these shapes. As in Mitsuba 3.9, they count for no depth, whichever way they shine.
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
            self.ray.origin = offset_origin(point.position, point.error, point.geometric_normal, self.ray.dir);
            self.ray.t_min = 0.0;
            self.ray.t_max -= met.t;
            self.passed += met.t;
            self.result.rays += 1;
            hit = scene.geometry.intersect(&self.ray);
        }
        hit
    }

    /// Takes the path to `hit`, the nearest of its ray, and turns it to where it goes on. False if it ends.
    #[inline(always)]
    pub fn advance(
        &mut self,
        scene: &RenderScene,
        settings: &PathSettings,
        hit: Option<Hit>,
        observer: &mut impl PathObserver,
    ) -> bool {
        self.result.rays += 1;
        let Some(hit) = hit else {
            self.escape(scene, settings, observer);
            return false;
        };
        let slot = scene.slot(&hit);
        let point = scene.surface(&self.ray, &hit, &slot);
        self.arrive(scene, settings, &hit, &slot, &point, observer);

        let wo = -self.ray.dir;
        let scattering = scene.scattering(slot.material, &hit, &point, wo);
        let smooth = scattering.has_smooth_lobe();

        self.depth += 1;
        let depth = self.depth;
        if depth >= settings.longest_path() {
            if !self.guided {
                self.guide(scattering.albedo(), &slot, &point);
            }
            observer.ended(PathEnd::DepthLimit);
            return false;
        }
        let sampler = &mut self.sampler;
        sampler.start_dimension(CAMERA_DIMENSIONS + (depth - 1) * BOUNCE_DIMENSIONS);
        let (u_light, u_light_point) = (sampler.next_1d(), sampler.next_2d());
        let (u_lobe, u_bsdf) = (sampler.next_1d(), sampler.next_2d());
        let sample = scattering.sample(u_lobe, u_bsdf);

        let passes = sample.is_some_and(|sample| sample.lobe == Lobe::Null);
        if !self.guided && !passes && (smooth || slot.light.is_some()) {
            self.guide(scattering.albedo(), &slot, &point);
        }

        let reference = LightReference {
            position: point.position,
            normal: scattering.half_space(),
        };
        if smooth && let Some((id, light)) = scene.lights.sample(&reference, u_light, u_light_point) {
            let (value, pdf) = scattering.eval_and_pdf(light.wi);
            if let Some(weight) = light_weight(settings.strategy, &light, pdf) {
                let reflected = self.throughput * value * light.radiance * (weight / light.pdf);
                let mut sampled = SampledLight {
                    light: id,
                    sample: light,
                    bsdf_pdf: pdf,
                    weight,
                    arriving: None,
                    contribution: Rgb::ZERO,
                };
                if reflected != Rgb::ZERO {
                    let origin = offset_origin(point.position, point.error, point.geometric_normal, light.wi);
                    let crossings = settings.longest_path() - depth - 1;
                    let arriving = shadow_ray(scene, origin, light.wi, light.target, crossings, &mut self.result.rays);
                    sampled.arriving = Some(arriving);
                    sampled.contribution = reflected * arriving;
                    self.result.radiance += sampled.contribution;
                }
                observer.light_sampled(&sampled);
            }
        }

        let Some(sample) = sample else {
            observer.ended(PathEnd::Absorbed);
            return false;
        };
        self.throughput *= sample.weight;
        self.eta_squared *= sample.eta * sample.eta;
        if self.throughput == Rgb::ZERO {
            observer.ended(PathEnd::Absorbed);
            return false;
        }
        self.is_straight &= sample.lobe == Lobe::Null;
        match sample.lobe {
            Lobe::Smooth => {
                self.arrival = Arrival::Sampled {
                    pdf: sample.pdf,
                    from: reference,
                }
            }
            Lobe::Delta => self.arrival = Arrival::Only,
            // Shadow rays pass as well: the weights stay those of the vertex before.
            Lobe::Null => {}
        }
        self.ray = Ray::new(
            offset_origin(point.position, point.error, point.geometric_normal, sample.wi),
            sample.wi,
        );

        let mut survival = 1.0;
        let grace = if sample.lobe == Lobe::Smooth { 0 } else { SPECULAR_GRACE };
        if depth >= settings.rr_depth.saturating_add(grace) {
            survival = (self.throughput.max_element() * self.eta_squared).min(HIGHEST_SURVIVAL);
            if self.sampler.next_1d() >= survival {
                observer.ended(PathEnd::Roulette);
                return false;
            }
            self.throughput /= survival;
        }
        observer.bounced(&Bounce {
            wi: sample.wi,
            lobe: sample.lobe,
            pdf: sample.pdf,
            survival,
            throughput: self.throughput,
        });
        true
    }

    /// Leaves the scene.
    #[inline(always)]
    pub fn escape(&mut self, scene: &RenderScene, settings: &PathSettings, observer: &mut impl PathObserver) {
        let is_hidden = settings.hide_emitters && self.is_straight;
        if settings.max_depth > 0 && !is_hidden {
            for &light in scene.lights.infinite() {
                let wi = self.ray.dir;
                let (radiance, pdf) = match &self.arrival {
                    Arrival::Sampled { from, .. } => scene.lights.radiance_and_pdf_from(light, from, wi),
                    Arrival::Only => (scene.lights.radiance_from(light, wi), 0.0),
                };
                let found = self.arrival.weigh(settings.strategy, |_| pdf);
                let met = found.emitter(light, radiance, self.throughput);
                self.result.radiance += met.contribution;
                observer.emitter_met(&met);
            }
        }
        if !self.guided {
            self.result.albedo = self.result.radiance.clamp(Rgb::ZERO, Rgb::ONE);
        }
        observer.ended(PathEnd::Escaped);
    }

    /// Comes to the surface at `hit` and sees what it emits.
    #[inline(always)]
    pub fn arrive(
        &mut self,
        scene: &RenderScene,
        settings: &PathSettings,
        hit: &Hit,
        slot: &SurfaceSlot,
        point: &SurfacePoint,
        observer: &mut impl PathObserver,
    ) {
        if self.depth == 0 {
            let mut first = *hit;
            first.t += self.passed;
            self.result.depth = first.t;
            self.result.first_hit = Some(first);
        }
        observer.vertex(&PathVertex {
            position: point.position,
            normal: point.shading_normal,
            instance: hit.instance,
            material: slot.material,
        });
        if let Some(light) = slot.light
            && settings.max_depth > 0
        {
            let on_light = SurfaceHit {
                position: point.position,
                normal: point.geometric_normal,
                shading_normal: point.shading_normal,
                primitive: hit.primitive,
                barycentric: Vec2::new(hit.u, hit.v),
                uv: point.uv,
            };
            let emitted = scene.lights.emitted(light, &on_light, -self.ray.dir);
            if emitted != Rgb::ZERO {
                let found = self.arrival.weigh(settings.strategy, |from| {
                    scene.lights.pdf_of_hit(light, from, &on_light)
                });
                let met = found.emitter(light, emitted, self.throughput);
                self.result.radiance += met.contribution;
                observer.emitter_met(&met);
            }
        }
    }

    /// Tells the denoiser of the surface that the path has come to, whose colour is `albedo` unless it is a light.
    pub fn guide(&mut self, albedo: Rgb, slot: &SurfaceSlot, point: &SurfacePoint) {
        self.guided = true;
        let colour = match slot.light {
            Some(_) => Rgb::ONE,
            None => albedo,
        };
        self.result.albedo = (self.throughput * colour).clamp(Rgb::ZERO, Rgb::ONE);
        self.result.normal = point.shading_normal;
    }
}

/// The share of a light's radiance that arrives at `origin` from `target`, in the direction `wi`, through at most `crossings` surfaces
/// that let it pass.
///
/// The ray follows one straight line. At each surface its origin moves to the far side of that surface. For a target that is a point the
/// ray is then aimed again, which corrects the rounding of that move, but only if the target lies on the far side as well. Otherwise the
/// target is at the surface itself, within rounding, and the ray has arrived. The distance to the target therefore falls at each crossing:
/// with `r` from the surface to the target, `n` the normal to the far side and `d` the move, `|r - d n|^2 < |r|^2 - d^2` as `n . r > d`.
pub(super) fn shadow_ray(
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
        if !scene.materials.lets_through() {
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
        arriving *= scene.scattering(slot.material, &hit, &point, -wi).passing();
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

/// What an emitter counts that the path has come upon, and why.
struct Found {
    weight: f32,
    bsdf_pdf: Option<f32>,
    light_pdf: Option<f32>,
}

impl Arrival {
    /// `light_pdf`: the density with which sampling the lights would have found it from there.
    fn weigh(&self, strategy: Strategy, light_pdf: impl FnOnce(&LightReference) -> f32) -> Found {
        let (weight, bsdf_pdf, light_pdf) = match (self, strategy) {
            (Self::Only, _) => (1.0, None, None),
            (Self::Sampled { pdf, .. }, Strategy::Bsdf) => (1.0, Some(*pdf), None),
            (Self::Sampled { pdf, .. }, Strategy::Light) => (0.0, Some(*pdf), None),
            (Self::Sampled { pdf, from }, Strategy::Mis) => {
                let light_pdf = light_pdf(from);
                (power_heuristic(*pdf, light_pdf), Some(*pdf), Some(light_pdf))
            }
        };
        Found {
            weight,
            bsdf_pdf,
            light_pdf,
        }
    }
}

impl Found {
    fn emitter(self, light: LightId, radiance: Rgb, throughput: Rgb) -> MetEmitter {
        MetEmitter {
            light,
            radiance,
            bsdf_pdf: self.bsdf_pdf,
            light_pdf: self.light_pdf,
            weight: self.weight,
            contribution: throughput * radiance * self.weight,
        }
    }
}

/// Weight of light found by sampling the lights, where the bsdf has density `bsdf_pdf`; None when the strategy does not use it.
fn light_weight(strategy: Strategy, light: &LightSample, bsdf_pdf: f32) -> Option<f32> {
    match strategy {
        _ if light.is_delta => Some(1.0),
        Strategy::Bsdf => None,
        Strategy::Light => Some(1.0),
        Strategy::Mis => Some(power_heuristic(light.pdf, bsdf_pdf)),
    }
}
