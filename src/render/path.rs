//! Unidirectional path tracing with next event estimation and multiple importance sampling (Kajiya 1986; Veach 1997, chapters 9
//! and 10; PBR 4th ed., section 13.4).

use glam::Vec3;

use super::scene::RenderScene;
use super::view::{PathSettings, Strategy};
use crate::color::Rgb;
use crate::light::{LightId, LightReference, LightSample, SurfaceHit, Target};
use crate::math::{Frame, Ray, offset_origin};
use crate::sampling::{Sampler, power_heuristic};

/// What one camera ray brought home.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PathSample {
    pub radiance: Rgb,
    /// Guides for the denoiser, taken at the first surface that is not perfectly specular: colour in [0, 1] and world normal.
    pub albedo: Rgb,
    pub normal: Vec3,
    /// Distance from the camera ray's origin to the first surface; 0 where there is none.
    pub depth: f32,
    /// Rays traced, shadow rays included.
    pub rays: u32,
}

/// Dimensions of the sampler before the first bounce (pixel and lens), and per bounce.
const CAMERA_DIMENSIONS: u32 = 2;
const BOUNCE_DIMENSIONS: u32 = 5;

/// A path goes on with this probability at most, so that bright enclosures end too.
const HIGHEST_SURVIVAL: f32 = 0.95;

/// How the path came to its current vertex; what the weight of an emitter met there depends on.
#[derive(Clone, Copy)]
enum Arrival {
    /// From the camera or a specular bounce: no other technique could have found the emitter.
    Only,
    /// By a bsdf with this density per solid angle, leaving `from`.
    Sampled { pdf: f32, from: LightReference },
}

/// One sample of the radiance arriving along `-ray.dir` at the ray's origin.
pub fn trace_path(scene: &RenderScene, settings: &PathSettings, mut ray: Ray, sampler: &mut Sampler) -> PathSample {
    let mut result = PathSample::default();
    let mut throughput = Rgb::ONE;
    // Squared relative index of refraction so far: radiance is scaled by it inside glass, and roulette must not see that.
    let mut eta_squared = 1.0;
    let mut arrival = Arrival::Only;
    let mut guided = false;
    let mut depth = 0;

    loop {
        result.rays += 1;
        let Some(hit) = scene.geometry.intersect(&ray) else {
            if depth > 0 || !settings.hide_emitters {
                result.radiance += throughput * escaped_radiance(scene, settings, arrival, ray.dir);
            }
            if !guided {
                result.albedo = result.radiance.clamp(Rgb::ZERO, Rgb::ONE);
            }
            return result;
        };
        let point = scene.geometry.surface(&ray, &hit);
        let slot = scene.slot(&hit);
        if depth == 0 {
            result.depth = hit.t;
        }

        if let Some(light) = slot.light
            && (depth > 0 || !settings.hide_emitters)
        {
            let on_light = SurfaceHit {
                position: point.position,
                normal: point.geometric_normal,
                primitive: hit.primitive,
            };
            let emitted = scene.lights.emitted(light, &on_light, -ray.dir);
            if emitted != Rgb::ZERO {
                let weight = match arrival {
                    Arrival::Only => 1.0,
                    Arrival::Sampled { pdf, from } => bsdf_weight(settings.strategy, pdf, || {
                        scene.lights.pdf_of_hit(light, &from, &on_light)
                    }),
                };
                result.radiance += throughput * emitted * weight;
            }
        }

        let smooth = scene.bsdfs.has_smooth_lobe(slot.bsdf);
        if !guided && (smooth || slot.light.is_some()) {
            guided = true;
            let colour = if slot.light.is_some() {
                Rgb::ONE
            } else {
                scene.bsdfs.albedo(slot.bsdf)
            };
            result.albedo = (throughput * colour).clamp(Rgb::ZERO, Rgb::ONE);
            result.normal = point.shading_normal;
        }

        depth += 1;
        if depth >= settings.max_depth {
            return result;
        }
        sampler.start_dimension(CAMERA_DIMENSIONS + (depth - 1) * BOUNCE_DIMENSIONS);
        let (u_light, u_light_point) = (sampler.next_1d(), sampler.next_2d());
        let (u_lobe, u_bsdf) = (sampler.next_1d(), sampler.next_2d());

        let reference = LightReference {
            position: point.position,
            normal: None,
        };
        let frame = Frame::from_normal(point.shading_normal);
        let wo = frame.to_local(-ray.dir);

        if smooth && let Some(light) = scene.lights.sample(&reference, u_light, u_light_point) {
            let wi = frame.to_local(light.wi);
            let pdf = scene.bsdfs.pdf(slot.bsdf, wo, wi);
            if let Some(weight) = light_weight(settings.strategy, &light, pdf) {
                let reflected =
                    throughput * scene.bsdfs.eval(slot.bsdf, wo, wi) * light.radiance * (weight / light.pdf);
                if reflected != Rgb::ZERO {
                    result.rays += 1;
                    let origin = offset_origin(point.position, point.error, point.geometric_normal, light.wi);
                    let shadow = match light.target {
                        Target::Point(target) => Ray::segment(origin, target),
                        Target::Infinity => Ray::new(origin, light.wi),
                    };
                    if !scene.geometry.occluded(&shadow) {
                        result.radiance += reflected;
                    }
                }
            }
        }

        let Some(sample) = scene.bsdfs.sample(slot.bsdf, wo, u_lobe, u_bsdf) else {
            return result;
        };
        throughput *= sample.weight;
        eta_squared *= sample.eta * sample.eta;
        if throughput == Rgb::ZERO {
            return result;
        }
        arrival = if sample.is_delta {
            Arrival::Only
        } else {
            Arrival::Sampled {
                pdf: sample.pdf,
                from: reference,
            }
        };
        let dir = frame.to_world(sample.wi);
        ray = Ray::new(
            offset_origin(point.position, point.error, point.geometric_normal, dir),
            dir,
        );

        if depth >= settings.rr_depth {
            let survival = (throughput.max_element() * eta_squared).min(HIGHEST_SURVIVAL);
            if sampler.next_1d() >= survival {
                return result;
            }
            throughput /= survival;
        }
    }
}

/// Weight of light found by the bsdf with density `pdf`, where sampling the lights has density `light_pdf`.
fn bsdf_weight(strategy: Strategy, pdf: f32, light_pdf: impl FnOnce() -> f32) -> f32 {
    match strategy {
        Strategy::Bsdf => 1.0,
        Strategy::Light => 0.0,
        Strategy::Mis => power_heuristic(pdf, light_pdf()),
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

/// Weighted radiance of the lights at infinity in direction `wi`.
fn escaped_radiance(scene: &RenderScene, settings: &PathSettings, arrival: Arrival, wi: Vec3) -> Rgb {
    let weighted = |&light: &LightId| {
        let weight = match arrival {
            Arrival::Only => 1.0,
            Arrival::Sampled { pdf, from } => {
                bsdf_weight(settings.strategy, pdf, || scene.lights.pdf_of_escape(light, &from, wi))
            }
        };
        scene.lights.radiance_from(light, wi) * weight
    };
    scene.lights.infinite().iter().map(weighted).sum()
}
