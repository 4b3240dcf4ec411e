//! The techniques that join a camera path with a light path.

use glam::Vec3;

use super::subpath::{LightPath, Measure, Vertex, Walk, reverse_pdf};
use super::weights::weight;
use super::{Sample, splat};
use crate::accel::Hit;
use crate::color::Rgb;
use crate::light::emission::{EmissionPdf, Start};
use crate::light::{LightId, LightSample, SurfaceHit, Target};
use crate::material::Lobe;
use crate::math::Ray;
use crate::render::dimensions::{BounceDraw, LightDraw};
use crate::render::observer::{
    Bounce, Joined, MetEmitter, PathEnd, PathObserver, PathVertex, SampledLight, SurfaceVertex,
};
use crate::render::path_state::PathState;
use crate::render::roulette;
use crate::render::splats::Splat;
use crate::render::transmittance::{EmptySpace, Noting, ShadowRay, transmittance};
use crate::shading::TransportMode;

/// The relative difference up to which two distances from the camera belong to the same point.
const SAME_PLACE: f32 = 1e-4;

/// An emitter that the camera path has hit.
struct Seen {
    light: LightId,
    radiance: Rgb,
    /// The density of its point from the camera, in the measure of the emission's start.
    pdf: f32,
    /// The density of light sampling from the previous vertex, in the same measure.
    pdf_of_light: f32,
    emission: EmissionPdf,
    /// The density of the previous vertex for light that comes from the emitter.
    pdf_before: f32,
}

impl<'a> Sample<'a, '_> {
    /// Joins the vertices of a light path with the lens (t = 1).
    pub(super) fn join_lens(&mut self, path: Option<&LightPath>, vertices: &[Vertex<'a>], splats: &mut Vec<Splat>) {
        let Some(path) = path else { return };
        let longest = self.settings.longest_path();
        let ends = |vertex: &&Vertex| vertex.is_smooth && vertex.segments < longest;
        for (number, vertex) in vertices.iter().enumerate().filter(|(_, vertex)| ends(vertex)) {
            let sampler = self.light_sampler;
            let u_lens = sampler.at_2d(LightDraw::Lens.at(vertex.segments));
            let Some(to) = self.view.camera.ray_to(vertex.point.position, u_lens) else {
                continue;
            };
            let u_pixel = sampler.at_1d(LightDraw::Pixel.at(vertex.segments));
            let size = glam::Vec2::new(self.view.width as f32, self.view.height as f32);
            let value = vertex
                .scattering
                .eval_adjoint(-to.ray.dir, vertex.point.geometric_normal);
            let carried = path.emitted.power * vertex.throughput * value;
            let Some(found) = splat(self.view, to.film * size, carried * to.density, u_pixel) else {
                continue;
            };
            let arriving = self.seen_share(vertex, to.ray, to.distance);
            if arriving == Rgb::ZERO {
                continue;
            }
            let weight = match self.camera_paths {
                false => 1.0,
                true => {
                    let pdf = to.density * vertex.cosine(to.ray.dir);
                    let next = vertex.scattering.reverse_pdf(-to.ray.dir);
                    let fewer = self.ways.with_fewer_of_light(path, vertices, number, pdf, false);
                    weight(fewer.sum(next))
                }
            };
            let radiance = found.radiance * arriving * weight;
            if radiance != Rgb::ZERO {
                splats.push(Splat { radiance, ..found });
                self.note(Some(found.pixel), radiance, found.radiance * arriving, |guidance| {
                    let pdf = to.density * vertex.cosine(to.ray.dir);
                    let next = vertex.scattering.reverse_pdf(-to.ray.dir);
                    guidance.of_joined(path, vertices, number, pdf, next)
                });
            }
        }
    }

    /// The share of light from a vertex that reaches the lens against the direction of a camera ray.
    fn seen_share(&mut self, vertex: &Vertex, ray: Ray, distance: f32) -> Rgb {
        let mut ray = self.view.sight.narrow(&self.scene.geometry, ray);
        if !(ray.t_min..=ray.t_max).contains(&distance) {
            return Rgb::ZERO;
        }
        if self.settings.hide_emitters {
            let (beyond, _) = self.first_seen(ray);
            // The vertex is on a lamp that is invisible to the camera.
            if vertex.slot.light.is_some() && beyond.record.passed >= distance * (1.0 - SAME_PLACE) {
                return Rgb::ZERO;
            }
            ray = beyond.ray;
        }
        let wi = -ray.dir;
        let shadow = ShadowRay {
            origin: vertex.leave(wi),
            wi,
            target: Target::Point(ray.at(ray.t_min)),
            crossings: self.settings.longest_path() - vertex.segments - 1,
        };
        transmittance(self.scene, &shadow, &mut EmptySpace, &mut self.rays)
    }

    /// Traces the camera path and joins each of its vertices with the light path.
    pub(super) fn trace_camera(
        &mut self,
        ray: Ray,
        camera: &mut Vec<Vertex<'a>>,
        path: Option<&LightPath>,
        light: &[Vertex<'a>],
        observer: &mut impl PathObserver,
    ) {
        let mut walk = Walk::from_camera(self.view.sight.narrow(&self.scene.geometry, ray));
        loop {
            let hit = if self.settings.hide_emitters && walk.segments == 0 {
                let (beyond, hit) = self.first_seen(walk.ray);
                (self.record.passed, walk.ray) = (beyond.record.passed, beyond.ray);
                hit
            } else {
                self.rays += 1;
                self.scene.geometry.intersect(&walk.ray)
            };
            let Some(hit) = hit else {
                self.escape(&walk, camera, observer);
                self.record.escape(self.radiance);
                return observer.ended(PathEnd::Escaped);
            };
            if let Some(end) = self.extend_camera(&mut walk, &hit, camera, path, light, observer) {
                return observer.ended(end);
            }
        }
    }

    /// The first hit of a camera ray behind lamps that are invisible to the camera, and the path's state there.
    fn first_seen(&mut self, ray: Ray) -> (PathState, Option<Hit>) {
        let mut path = PathState::new(ray, self.camera_sampler, None);
        path.rays += 1;
        let hit = self.scene.geometry.intersect(&ray);
        let hit = path.behind_hidden_emitters(self.scene, &self.settings, hit);
        self.rays += path.rays;
        (path, hit)
    }

    /// Extends the camera path by a vertex. Returns why it has ended, if it has.
    fn extend_camera(
        &mut self,
        walk: &mut Walk,
        hit: &Hit,
        camera: &mut Vec<Vertex<'a>>,
        path: Option<&LightPath>,
        light: &[Vertex<'a>],
        observer: &mut impl PathObserver,
    ) -> Option<PathEnd> {
        let vertex = self.vertex(walk, hit, TransportMode::Radiance);
        let depth = vertex.segments;
        if depth == 1 {
            self.record.meet(hit);
        }
        observer.met(&walk.ray, hit);
        observer.vertex(&PathVertex::Surface(SurfaceVertex {
            position: vertex.point.position,
            normal: vertex.point.shading_normal,
            instance: hit.instance,
            material: vertex.slot.material,
        }));
        if let Some(id) = vertex.slot.light.filter(|_| self.settings.max_depth > 0) {
            self.meet_emitter(walk, id, &vertex, camera, observer);
        }
        let is_last = self.settings.is_last(depth);
        let number = camera.len();
        let sampler = self.camera_sampler;
        let sample = vertex.scattering.sample(
            sampler.at_1d(BounceDraw::Lobe.at(depth)),
            sampler.at_2d(BounceDraw::Direction.at(depth)),
        );
        let passes = sample.is_some_and(|sample| sample.lobe == Lobe::Null);
        if !passes || is_last {
            let is_light = vertex.slot.light.is_some();
            if self.record.wants_features(vertex.is_smooth, is_light, is_last) {
                let (albedo, normal) = (vertex.scattering.albedo(), vertex.point.shading_normal);
                self.record.take_features(walk.throughput, albedo, normal, is_light);
            }
        }
        if is_last {
            return Some(PathEnd::DepthLimit);
        }
        camera.push(vertex);
        if camera[number].is_smooth && self.camera_paths {
            self.sample_light(camera, number, observer);
            if let Some(path) = path.filter(|_| self.ways.joins) {
                self.join_one(path, light, camera, number, observer);
            }
            self.merge(camera, number, observer);
        }
        let Some(sample) = sample else {
            return Some(PathEnd::Absorbed);
        };
        // Light tracing follows camera paths only to directly visible surfaces.
        if !self.camera_paths && sample.lobe != Lobe::Null {
            return Some(PathEnd::DepthLimit);
        }
        walk.throughput *= sample.weight;
        walk.eta_squared = roulette::eta_squared(walk.eta_squared, sample.eta);
        if walk.throughput == Rgb::ZERO {
            return Some(PathEnd::Absorbed);
        }
        if sample.lobe != Lobe::Null
            && let Some(before) = camera[number].before
        {
            let reverse = reverse_pdf(camera, number, sample.wi, sample.lobe);
            camera[before].pdf_reverse = camera[before].area_pdf(reverse, camera[number].point.position);
        }
        walk.go_on(camera, number, sample.wi, sample.lobe, sample.pdf);
        let is_scattered = sample.lobe == Lobe::Smooth;
        let mut survival = 1.0;
        if roulette::is_played::<f32>(&self.settings, walk.segments, is_scattered) {
            survival = roulette::survival(walk.throughput.max_element(), walk.eta_squared);
            if sampler.at_1d(BounceDraw::Roulette.at(depth)) >= survival {
                return Some(PathEnd::Roulette);
            }
            walk.throughput /= survival;
        }
        observer.bounced(&Bounce {
            wi: sample.wi,
            lobe: sample.lobe,
            pdf: sample.pdf,
            survival,
            throughput: walk.throughput,
        });
        None
    }

    /// Adds the emission of the surface at `vertex`, which the walk has hit (s = 0).
    fn meet_emitter(
        &mut self,
        walk: &Walk,
        light: LightId,
        vertex: &Vertex<'a>,
        camera: &[Vertex<'a>],
        observer: &mut impl PathObserver,
    ) {
        let (point, hit) = (&vertex.point, &vertex.hit);
        let place = SurfaceHit::at(hit, point);
        let lights = &self.scene.lights;
        let radiance = lights.emitted(light, &place, -walk.ray.dir);
        if radiance == Rgb::ZERO {
            return;
        }
        let mut seen = Seen {
            light,
            radiance,
            pdf: vertex.pdf,
            pdf_of_light: 0.0,
            emission: lights.emission_pdf_of_hit(light, self.reach, &place, -walk.ray.dir),
            pdf_before: 0.0,
        };
        if let Some(before) = walk.before {
            let before = &camera[before];
            let pdf = lights.pdf_of_hit(light, &before.reference(), &place);
            seen.pdf_of_light = Start::Surface(place).density(before.point.position, pdf);
            seen.pdf_before = before.area_pdf(seen.emission.next, point.position);
        }
        self.add_seen(walk, &seen, camera, observer);
    }

    /// Adds the light from infinity along the walk's ray, which has left the scene (s = 0).
    fn escape(&mut self, walk: &Walk, camera: &[Vertex<'a>], observer: &mut impl PathObserver) {
        if self.settings.max_depth == 0 || self.settings.hide_emitters && walk.is_straight {
            return;
        }
        let (lights, wi) = (&self.scene.lights, walk.ray.dir);
        for &light in lights.infinite() {
            let mut seen = Seen {
                light,
                radiance: lights.radiance_from(light, wi),
                pdf: match walk.pdf {
                    Measure::SolidAngle(pdf, _) => pdf,
                    Measure::Perpendicular(_) | Measure::Camera(_) => 0.0,
                },
                pdf_of_light: 0.0,
                emission: lights.emission_pdf_from(light, self.reach, wi),
                pdf_before: 0.0,
            };
            if let Some(before) = walk.before {
                let before = &camera[before];
                seen.pdf_of_light = lights.radiance_and_pdf_from(light, &before.reference(), wi).1;
                seen.pdf_before = seen.emission.next * before.cosine(wi);
            }
            self.add_seen(walk, &seen, camera, observer);
        }
    }

    fn add_seen(&mut self, walk: &Walk, seen: &Seen, camera: &[Vertex<'a>], observer: &mut impl PathObserver) {
        let by_sampling = match walk.before.map(|before| &camera[before]) {
            Some(vertex) if !vertex.is_delta => (seen.pdf_of_light / seen.pdf).powi(2),
            _ => 0.0,
        };
        let others = match walk.before {
            // Directly visible light is found by no other technique.
            None => 0.0,
            Some(_) if !self.camera_paths => f32::INFINITY,
            Some(before) => {
                let vertex = &camera[before];
                let ratio = seen.emission.start / seen.pdf * (seen.pdf_before / vertex.pdf);
                let joined = self
                    .ways
                    .with_fewer_of_camera(camera, before, ratio, vertex.is_delta, None);
                by_sampling + joined
            }
        };
        let weight = weight(others);
        let contribution = walk.throughput * seen.radiance * weight;
        self.radiance += contribution;
        if let Some(before) = walk.before {
            self.note(None, contribution, walk.throughput * seen.radiance, |guidance| {
                let on = guidance.ratio(&camera[before], walk.ray.dir);
                guidance.along(camera, before).powi(2) * (on * on + by_sampling)
            });
        }
        self.record.come_upon(contribution);
        observer.emitter_met(&MetEmitter {
            light: seen.light,
            radiance: seen.radiance,
            bsdf_pdf: match walk.pdf {
                Measure::SolidAngle(pdf, _) => Some(pdf),
                Measure::Perpendicular(_) | Measure::Camera(_) => None,
            },
            light_pdf: Some(seen.pdf_of_light),
            weight,
            contribution,
        });
    }

    /// Samples a light from a vertex of the camera path (s = 1).
    fn sample_light(&mut self, camera: &[Vertex<'a>], number: usize, observer: &mut impl PathObserver) {
        let vertex = &camera[number];
        let (depth, sampler) = (vertex.segments, self.camera_sampler);
        let u_choice = sampler.at_1d(BounceDraw::LightChoice.at(depth));
        let u_point = sampler.at_2d(BounceDraw::LightPoint.at(depth));
        let found = self
            .scene
            .lights
            .sample_start(self.reach, &vertex.reference(), u_choice, u_point);
        let Some((id, light, start, emission)) = found else {
            return;
        };
        let (value, bsdf_pdf) = vertex.scattering.eval_and_pdf(light.wi);
        let carried = vertex.throughput * value;
        let mut arriving = None;
        let mut space = Noting::new(EmptySpace);
        if carried * light.radiance != Rgb::ZERO {
            let shadow = ShadowRay {
                origin: vertex.leave(light.wi),
                wi: light.wi,
                target: light.target,
                crossings: self.settings.longest_path() - depth - 1,
            };
            arriving = Some(transmittance(self.scene, &shadow, &mut space, &mut self.rays));
        }
        let weight = match arriving {
            Some(share) if share != Rgb::ZERO => {
                weight(self.others_than_sampling(camera, number, &light, &start, &emission, bsdf_pdf))
            }
            _ => 0.0,
        };
        let whole = carried * light.radiance * arriving.unwrap_or(Rgb::ZERO) / light.pdf;
        let contribution = carried * light.radiance * arriving.unwrap_or(Rgb::ZERO) * (weight / light.pdf);
        self.radiance += contribution;
        self.note(None, contribution, whole, |guidance| {
            let on = guidance.ratio(vertex, light.wi);
            guidance.along(camera, number).powi(2) * (1.0 + by_bsdf(&start, &light, bsdf_pdf) * on * on)
        });
        observer.light_sampled(&SampledLight {
            light: id,
            sample: light,
            bsdf_pdf,
            passed: 1.0,
            weight,
            arriving,
            through: space.first,
            contribution,
        });
    }

    /// The squared ratios of all other techniques that find a light sampled from a vertex of the camera path.
    fn others_than_sampling(
        &self,
        camera: &[Vertex<'a>],
        number: usize,
        light: &LightSample,
        start: &Start,
        emission: &EmissionPdf,
        bsdf_pdf: f32,
    ) -> f32 {
        let vertex = &camera[number];
        let pdf = match start {
            Start::Surface(hit) => vertex.area_pdf(emission.next, hit.position),
            Start::Point(position) => vertex.area_pdf(emission.next, *position),
            Start::Infinity { .. } => emission.next * vertex.cosine(light.wi),
        };
        let of_light = start.density(vertex.point.position, light.pdf);
        let ratio = emission.start / of_light * (pdf / vertex.pdf);
        let next = self.next_of_camera(camera, number, light.wi);
        by_bsdf(start, light, bsdf_pdf) + self.ways.with_fewer_of_camera(camera, number, ratio, false, next)
    }

    /// The density of the vertex before a vertex of the camera path, for light that comes to the latter from `wi`.
    pub(super) fn next_of_camera(&self, camera: &[Vertex<'a>], number: usize, wi: Vec3) -> Option<f32> {
        let vertex = &camera[number];
        let before = &camera[vertex.before?];
        Some(before.area_pdf(vertex.scattering.reverse_pdf(wi), vertex.point.position))
    }

    /// Joins a vertex of the camera path with one of the light path (s > 1, t > 1), chosen at random: joining all of
    /// them would multiply the cost by their number, and reduce noise by less than that.
    fn join_one(
        &mut self,
        path: &LightPath,
        light: &[Vertex<'a>],
        camera: &[Vertex<'a>],
        number: usize,
        observer: &mut impl PathObserver,
    ) {
        let longest = self.settings.longest_path();
        let vertex = &camera[number];
        // Later vertices of the light path have more segments.
        let count = light.partition_point(|other| vertex.segments + other.segments < longest);
        let u = self.camera_sampler.at_1d(LightDraw::Partner.at(vertex.segments));
        let last = (u * count as f32) as usize;
        let Some(other) = light[..count].get(last).filter(|other| other.is_smooth) else {
            return;
        };
        let segments = vertex.segments + other.segments + 1;
        let way = other.point.position - vertex.point.position;
        let squared = way.length_squared();
        let Some(wi) = way.try_normalize() else { return };
        let (value, pdf) = vertex.scattering.eval_and_pdf(wi);
        if value == Rgb::ZERO {
            return;
        }
        let other_value = other.scattering.eval_adjoint(-wi, other.point.geometric_normal);
        // `eval_adjoint` has the cosine at the light path's vertex, `eval_and_pdf` that at the camera path's.
        let carried = vertex.throughput * value * path.emitted.power * other.throughput * other_value / squared;
        if carried == Rgb::ZERO {
            return;
        }
        let shadow = ShadowRay {
            origin: vertex.leave(wi),
            wi,
            target: Target::Point(other.leave(-wi)),
            crossings: longest - segments,
        };
        let arriving = transmittance(self.scene, &shadow, &mut EmptySpace, &mut self.rays);
        if arriving == Rgb::ZERO {
            return;
        }
        let other_density = other.area_pdf(pdf, vertex.point.position);
        let fewer = self.ways.with_fewer_of_light(path, light, last, other_density, false);
        let (_, other_pdf) = other.scattering.eval_and_pdf(-wi);
        let ratio = vertex.area_pdf(other_pdf, other.point.position) / vertex.pdf;
        let next = self.next_of_camera(camera, number, wi);
        let others = fewer.sum(other.scattering.reverse_pdf(-wi))
            + self.ways.with_fewer_of_camera(camera, number, ratio, false, next);
        let weight = weight(others);
        let contribution = carried * arriving * (count as f32 * weight);
        self.radiance += contribution;
        self.note(None, contribution, carried * arriving, |guidance| {
            let on = guidance.along(camera, number) * guidance.ratio(vertex, wi);
            let next = other.scattering.reverse_pdf(-wi);
            on * on * guidance.of_joined(path, light, last, other_density, next)
        });
        observer.joined(&Joined {
            light: path.emitted.light,
            position: other.point.position,
            weight,
            contribution,
        });
    }
}

/// The squared ratio of hitting a light by the BSDF to sampling it, which has found it with this density.
fn by_bsdf(start: &Start, light: &LightSample, bsdf_pdf: f32) -> f32 {
    match start.is_delta() {
        true => 0.0,
        false => (bsdf_pdf / light.pdf).powi(2),
    }
}
