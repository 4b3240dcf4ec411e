//! All lights of a scene, and the choice of one of them for a sample.

use std::f32::consts::FRAC_1_PI;
use std::f64::consts::PI;

use glam::{Vec2, Vec3};

use super::surface::SurfaceLight;
use super::{LightId, LightSample, LightSource, SurfaceHit, Target};
use crate::accel::Tlas;
use crate::color::{Rgb, luminance};
use crate::sampling::{DiscreteDistribution, warp};

#[derive(Clone, Debug)]
enum Light {
    Surface(SurfaceLight),
    Point {
        position: Vec3,
        intensity: Rgb,
    },
    Directional {
        direction: Vec3,
        irradiance: Rgb,
    },
    Constant {
        radiance: Rgb,
    },
    /// A source without area or power; kept so that ids stay those of the sources.
    Dark,
}

/// The lights in the order of their sources, chosen in proportion to power with a floor.
#[derive(Clone, Debug, Default)]
pub struct LightTable {
    lights: Vec<Light>,
    choice: Option<DiscreteDistribution>,
    /// Lights that are seen where a ray meets nothing.
    infinite: Vec<LightId>,
}

/// Share of the choice that is spread evenly, so that a weak light next to the reference point is not forgotten.
const EVEN_SHARE: f32 = 0.2;

impl LightTable {
    pub fn build(sources: &[LightSource], geometry: &Tlas) -> Self {
        let bounds = geometry.bounds();
        // Radiant flux through the scene's bounding sphere, for lights at infinity.
        let radius = 0.5 * bounds.extent().as_dvec3().length();
        let disk = PI * (radius * radius).max(f64::MIN_POSITIVE);
        let mut infinite = Vec::new();
        let mut powers = Vec::with_capacity(sources.len());
        let lights = sources
            .iter()
            .enumerate()
            .map(|(id, source)| {
                let (light, power) = match *source {
                    LightSource::Surface {
                        instance,
                        slot,
                        radiance,
                    } => match SurfaceLight::new(geometry, instance, slot, radiance) {
                        Some(light) => {
                            let power = PI * f64::from(light.area) * f64::from(luminance(radiance));
                            (Light::Surface(light), power)
                        }
                        None => (Light::Dark, 0.0),
                    },
                    LightSource::Point { position, intensity } => (
                        Light::Point { position, intensity },
                        4.0 * PI * f64::from(luminance(intensity)),
                    ),
                    LightSource::Directional { direction, irradiance } => (
                        Light::Directional { direction, irradiance },
                        disk * f64::from(luminance(irradiance)),
                    ),
                    LightSource::Constant { radiance } => {
                        infinite.push(LightId(id as u32));
                        (
                            Light::Constant { radiance },
                            4.0 * PI * disk * f64::from(luminance(radiance)),
                        )
                    }
                };
                powers.push(power);
                light
            })
            .collect();
        Self {
            lights,
            choice: choice_by_power(&powers),
            infinite,
        }
    }

    pub fn len(&self) -> usize {
        self.lights.len()
    }

    pub fn is_empty(&self) -> bool {
        self.lights.is_empty()
    }

    /// Chooses a light by `u_choice`, then a direction to it by `u`. None where the chosen light sends nothing to `reference`.
    pub fn sample(&self, reference: Vec3, u_choice: f32, u: Vec2) -> Option<LightSample> {
        let chosen = self.choice.as_ref()?.sample(u_choice);
        let (light, pmf) = (&self.lights[chosen.index as usize], chosen.pmf);
        match light {
            Light::Surface(surface) => {
                let point = surface.sample(reference, u)?;
                let wi = (point.position - reference).try_normalize()?;
                Some(LightSample {
                    wi,
                    target: Target::Point(surface.shadow_target(&point, reference)),
                    radiance: surface.radiance,
                    pdf: pmf * point.pdf_solid_angle,
                    is_delta: false,
                })
            }
            Light::Point { position, intensity } => {
                let to_light = position - reference;
                Some(LightSample {
                    wi: to_light.try_normalize()?,
                    target: Target::Point(*position),
                    radiance: intensity / to_light.length_squared(),
                    pdf: pmf,
                    is_delta: true,
                })
            }
            Light::Directional { direction, irradiance } => Some(LightSample {
                wi: -direction,
                target: Target::Infinity,
                radiance: *irradiance,
                pdf: pmf,
                is_delta: true,
            }),
            Light::Constant { radiance } => Some(LightSample {
                wi: warp::uniform_sphere(u),
                target: Target::Infinity,
                radiance: *radiance,
                pdf: pmf * UNIFORM_DIRECTION_PDF,
                is_delta: false,
            }),
            Light::Dark => None,
        }
    }

    /// Radiance that light `id` sends along the unit vector `wo` from a point of its surface.
    pub fn emitted(&self, id: LightId, hit: &SurfaceHit, wo: Vec3) -> Rgb {
        match &self.lights[id.0 as usize] {
            Light::Surface(surface) if wo.dot(hit.normal) > 0.0 => surface.radiance,
            _ => Rgb::ZERO,
        }
    }

    /// The density with which [`Self::sample`] gives the direction from `reference` to this point of light `id`.
    pub fn pdf_of_hit(&self, id: LightId, reference: Vec3, hit: &SurfaceHit) -> f32 {
        match &self.lights[id.0 as usize] {
            Light::Surface(surface) => self.pmf(id) * surface.pdf(reference, hit),
            _ => 0.0,
        }
    }

    /// The lights a ray meets that leaves the scene.
    pub fn infinite(&self) -> &[LightId] {
        &self.infinite
    }

    /// Radiance of infinite light `id` arriving against the direction `_wi`.
    pub fn radiance_from(&self, id: LightId, _wi: Vec3) -> Rgb {
        match self.lights[id.0 as usize] {
            Light::Constant { radiance } => radiance,
            _ => Rgb::ZERO,
        }
    }

    /// The density with which [`Self::sample`] gives the direction `_wi` to infinite light `id`.
    pub fn pdf_of_escape(&self, id: LightId, _wi: Vec3) -> f32 {
        match self.lights[id.0 as usize] {
            Light::Constant { .. } => self.pmf(id) * UNIFORM_DIRECTION_PDF,
            _ => 0.0,
        }
    }

    fn pmf(&self, id: LightId) -> f32 {
        self.choice.as_ref().map_or(0.0, |choice| choice.pmf(id.0))
    }
}

const UNIFORM_DIRECTION_PDF: f32 = 0.25 * FRAC_1_PI;

/// None when nothing shines.
fn choice_by_power(powers: &[f64]) -> Option<DiscreteDistribution> {
    let usable = |power: f64| if power.is_finite() { power.max(0.0) } else { 0.0 };
    let total: f64 = powers.iter().map(|&power| usable(power)).sum();
    let shining = powers.iter().filter(|&&power| usable(power) > 0.0).count() as f32;
    let weights: Vec<f32> = powers
        .iter()
        .map(|&power| match usable(power) {
            0.0 => 0.0,
            power => EVEN_SHARE / shining + (1.0 - EVEN_SHARE) * (power / total) as f32,
        })
        .collect();
    DiscreteDistribution::new(&weights)
}
