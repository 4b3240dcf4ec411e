//! Sampling emitted rays from all lights, with which light paths start.
//!
//! Rays from infinity start on a disk that covers the scene.

use std::f32::consts::FRAC_1_PI;

use glam::{Vec2, Vec3};

use super::{Finite, LightTable, refined};
use crate::accel::Tlas;
use crate::light::choice::Chosen;
use crate::light::emission::{Aim, Beam, EmissionPdf, EmittedRay, Reach, SceneSphere, Start};
use crate::light::finite::FiniteLight;
use crate::light::infinite::InfiniteLight;
use crate::light::surface::SurfaceLight;
use crate::light::{LightId, LightReference, LightSample, SurfaceHit};
use crate::math::{Aabb, Frame};
use crate::sampling::warp;

/// No surface: lights at infinity are sampled for all directions alike.
const NOWHERE: LightReference = LightReference {
    position: Vec3::ZERO,
    normal: None,
};

impl LightTable {
    /// The region that the lights can reach. The cost is a few steps for each lamp, and for the shapes around the whole
    /// scene.
    pub fn reach(&self, geometry: &Tlas) -> Reach {
        let everything = geometry.bounds();
        let is_outermost =
            |bounds: &Aabb| bounds.min.cmple(everything.min).any() || bounds.max.cmpge(everything.max).any();
        let lamps: Vec<(u32, Aabb)> = (self.lamps.iter())
            .filter(|(_, bounds)| is_outermost(bounds))
            .copied()
            .collect();
        let mut lit = everything;
        if !lamps.is_empty() {
            let numbers: Vec<u32> = lamps.iter().map(|lamp| lamp.0).collect();
            let others = geometry.bounds_without(&numbers);
            if !others.is_empty() {
                // A nearer lamp sends its rays in all directions, and counts as a lit shape.
                let sphere = SceneSphere::around(&others);
                let is_near = |lamp: &Aabb| {
                    let nearest = sphere.center.clamp(lamp.min, lamp.max);
                    nearest.distance(sphere.center) < 2.0 * sphere.radius
                };
                let near = lamps.iter().map(|lamp| lamp.1).filter(is_near);
                lit = near.fold(others, |all, bounds| all.union(bounds));
            }
        }
        Reach {
            everything: SceneSphere::around(&everything),
            lit: SceneSphere::around(&lit),
        }
    }

    /// Samples an emitted ray: its light by `u_choice`, its start by `u_place` and its direction by `u_dir`. None where
    /// the light emits nothing.
    pub fn sample_emission(&self, reach: &Reach, u_choice: f32, u_place: Vec2, u_dir: Vec2) -> Option<EmittedRay> {
        let (chosen, pmf) = self.emission.sample(&reach.everything, u_choice)?;
        match chosen {
            Chosen::Part(part) => {
                let finite = &self.finite[self.light_of_part[part as usize] as usize];
                self.emit_from_part(finite, part - finite.first_part, pmf, reach, u_place, u_dir)
            }
            Chosen::Infinite(index) => {
                let (id, light) = &self.infinite[index as usize];
                let sphere = &reach.everything;
                let sample = light.sample::<f32>(&(&NOWHERE).into(), u_dir.to_array()).if_lit()?;
                let pdf = EmissionPdf {
                    start: pmf * sample.pdf,
                    next: 1.0 / sphere.cross_section(),
                };
                let place = sphere.radius * Vec2::from(warp::concentric_disk(u_place.to_array()));
                let side = Frame::from_normal(sample.wi).to_world(place.extend(0.0));
                Some(EmittedRay {
                    light: *id,
                    origin: sphere.center + side + sphere.radius * sample.wi,
                    dir: -sample.wi,
                    power: sample.radiance / (pdf.start * pdf.next),
                    pdf,
                    start: Start::Infinity {
                        is_delta: sample.is_delta,
                    },
                })
            }
        }
    }

    fn emit_from_part(
        &self,
        finite: &Finite,
        part: u32,
        pmf: f32,
        reach: &Reach,
        u_place: Vec2,
        u_dir: Vec2,
    ) -> Option<EmittedRay> {
        let beam = |beam: Beam, position: Vec3| EmittedRay {
            light: finite.id,
            origin: position,
            dir: beam.dir,
            power: beam.intensity / (pmf * beam.pdf_solid_angle),
            pdf: EmissionPdf {
                start: pmf,
                next: beam.pdf_solid_angle,
            },
            start: Start::Point(position),
        };
        match &finite.light {
            FiniteLight::Point(light) => Some(beam(light.sample_beam(&reach.lit, u_dir), light.position)),
            FiniteLight::Spot(light) => Some(beam(light.sample_beam(u_dir, &self.textures)?, light.position())),
            FiniteLight::Luminaire(light) => Some(beam(light.sample_beam(u_dir)?, light.position)),
            FiniteLight::Projector(light) => Some(beam(light.sample_beam(u_dir, &self.textures)?, light.position())),
            FiniteLight::Surface(light) => {
                let (hit, pdf_area) = light.sample_start(part, u_place)?;
                let (dir, next) = Side::of(light, part, &hit, reach).sample(u_dir)?;
                let radiance = finite.light.emitted(&hit, dir, &self.textures);
                let pdf = EmissionPdf {
                    start: pmf * pdf_area,
                    next,
                };
                Some(EmittedRay {
                    light: finite.id,
                    origin: light.leave(&hit, dir),
                    dir,
                    power: radiance * (dir.dot(hit.normal).abs() / (pdf.start * pdf.next)),
                    pdf,
                    start: Start::Surface(hit),
                })
            }
        }
    }

    /// The densities of [`Self::sample_emission`] for the ray along `dir` from this point of light `id`.
    pub fn emission_pdf_of_hit(&self, id: LightId, reach: &Reach, hit: &SurfaceHit, dir: Vec3) -> EmissionPdf {
        let none = EmissionPdf { start: 0.0, next: 0.0 };
        let Some(finite) = self.finite(id) else {
            return none;
        };
        match (&finite.light, finite.light.part_of(hit)) {
            (FiniteLight::Surface(light), Some(part)) => {
                let pmf = self
                    .emission
                    .pmf(&reach.everything, Chosen::Part(finite.first_part + part));
                surface_pdf(light, part, pmf, hit, dir, reach)
            }
            _ => none,
        }
    }

    /// The densities of [`Self::sample_emission`] for a ray from the direction `wi` of light `id`, which is at
    /// infinity.
    pub fn emission_pdf_from(&self, id: LightId, reach: &Reach, wi: Vec3) -> EmissionPdf {
        let start = self.at_infinity(id).map_or(0.0, |(index, light)| {
            let pdf = match light {
                InfiniteLight::Directional(_) => 1.0,
                _ => light.radiance_and_pdf(&NOWHERE, wi).1,
            };
            self.emission.pmf(&reach.everything, Chosen::Infinite(index)) * pdf
        });
        EmissionPdf {
            start,
            next: 1.0 / reach.everything.cross_section(),
        }
    }

    /// [`Self::sample`] with the point on the light, and the densities of [`Self::sample_emission`] for the ray from
    /// there to the reference.
    pub fn sample_start(
        &self,
        reach: &Reach,
        reference: &LightReference,
        u_choice: f32,
        u: Vec2,
    ) -> Option<(LightId, LightSample, Start, EmissionPdf)> {
        let (chosen, pmf) = self.choice.sample(reference, || refined(u_choice, u))?;
        let (id, sample, start, pdf) = match chosen {
            Chosen::Infinite(_) => {
                let (id, sample) = self.sample_chosen::<f32>((chosen, 1.0), &reference.into(), u.to_array());
                let sample = sample.if_lit()?;
                let is_delta = sample.is_delta;
                let pdf = self.emission_pdf_from(id, reach, sample.wi);
                (id, sample, Start::Infinity { is_delta }, pdf)
            }
            Chosen::Part(chosen_part) => {
                let finite = &self.finite[self.light_of_part[chosen_part as usize] as usize];
                let part = chosen_part - finite.first_part;
                let start = self.emission.pmf(&reach.everything, chosen);
                let (sample, place, pdf) = match &finite.light {
                    FiniteLight::Surface(light) => {
                        let (sample, hit) = light.sample_hit(part, reference, u, &self.textures)?;
                        let pdf = surface_pdf(light, part, start, &hit, -sample.wi, reach);
                        (sample, Start::Surface(hit), pdf)
                    }
                    point => {
                        let sample = point.sample::<f32>(part, &reference.into(), u.to_array(), &self.textures);
                        let sample = sample.if_lit()?;
                        let next = match point {
                            FiniteLight::Spot(light) => light.beam_pdf(),
                            FiniteLight::Luminaire(light) => light.beam_pdf(-sample.wi),
                            FiniteLight::Projector(light) => light.beam_pdf(-sample.wi),
                            FiniteLight::Point(light) => light.beam_pdf(&reach.lit, -sample.wi),
                            FiniteLight::Surface(_) => warp::UNIFORM_SPHERE_PDF,
                        };
                        let position = point.sample_place(part, u);
                        (sample, Start::Point(position), EmissionPdf { start, next })
                    }
                };
                (finite.id, sample, place, pdf)
            }
        };
        let pdf_solid_angle = pmf * sample.pdf;
        Some((
            id,
            LightSample {
                pdf: pdf_solid_angle,
                ..sample
            },
            start,
            pdf,
        ))
    }

    /// The density with which [`Self::sample`] finds `start` on light `id` from the reference, in direction `wi`.
    pub fn pdf_of_start(&self, id: LightId, reference: &LightReference, start: &Start, wi: Vec3) -> f32 {
        match start {
            Start::Surface(hit) => self.pdf_of_hit(id, reference, hit),
            Start::Point(_) => self.finite(id).map_or(0.0, |finite| {
                self.choice.pmf(reference, Chosen::Part(finite.first_part))
            }),
            Start::Infinity { is_delta: false } => self.radiance_and_pdf_from(id, reference, wi).1,
            Start::Infinity { is_delta: true } => self
                .at_infinity(id)
                .map_or(0.0, |(index, _)| self.choice.pmf(reference, Chosen::Infinite(index))),
        }
    }
}

/// A point of an emitting surface, with its emitting sides: that of its normal, or both.
struct Side {
    normal: Vec3,
    is_two_sided: bool,
    aim: Option<Aim>,
}

impl Side {
    fn of(light: &SurfaceLight, part: u32, hit: &SurfaceHit, reach: &Reach) -> Self {
        let is_two_sided = light.is_two_sided(part);
        let aim = Aim::at(&reach.lit, hit.position).filter(|aim| is_two_sided || aim.is_before(hit.normal));
        Self {
            normal: hit.normal,
            is_two_sided,
            aim,
        }
    }

    /// A direction towards the lit sphere, or one sampled by the cosine with the normal, and its density. None where it
    /// does not shine.
    fn sample(&self, u: Vec2) -> Option<(Vec3, f32)> {
        let (is_aimed, u) = self.aim.map_or((false, u), |_| Aim::choose(u));
        let dir = match &self.aim {
            Some(aim) if is_aimed => aim.sample(u),
            _ => self.sample_cosine(u),
        };
        let shines = self.is_two_sided || dir.dot(self.normal) > 0.0;
        let pdf = self.pdf(dir);
        (shines && pdf > 0.0).then_some((dir, pdf))
    }

    fn sample_cosine(&self, mut u: Vec2) -> Vec3 {
        let mut side = 1.0;
        if self.is_two_sided {
            side = if u.x < 0.5 { 1.0 } else { -1.0 };
            u.x = (2.0 * u.x).fract();
        }
        let local = warp::cosine_hemisphere(u.to_array());
        Frame::from_normal(side * self.normal).to_world(local).normalize()
    }

    /// Density per solid angle of [`Self::sample`] in directions in which it shines.
    fn pdf(&self, dir: Vec3) -> f32 {
        let sides = if self.is_two_sided { 2.0 } else { 1.0 };
        let cosine = self.normal.dot(dir).abs() * FRAC_1_PI / sides;
        Aim::mixed(self.aim.as_ref(), cosine, dir)
    }
}

/// The densities of a ray along `dir` from a point of a part that is chosen with probability `pmf`.
fn surface_pdf(light: &SurfaceLight, part: u32, pmf: f32, hit: &SurfaceHit, dir: Vec3, reach: &Reach) -> EmissionPdf {
    EmissionPdf {
        start: pmf * light.start_pdf(part, hit),
        next: Side::of(light, part, hit, reach).pdf(dir),
    }
}
