//! The walk of a camera path or a light path, vertex by vertex.

use glam::Vec3;

use super::Sample;
use crate::accel::{Hit, SurfacePoint};
use crate::color::Rgb;
use crate::light::LightReference;
use crate::light::emission::{EmittedRay, Start};
use crate::material::{Lobe, Scattering};
use crate::math::{Ray, offset_origin};
use crate::render::dimensions::LightDraw;
use crate::render::roulette;
use crate::render::scene::SurfaceSlot;
use crate::shading::TransportMode;

/// A vertex of a path on a surface. Densities are per area, also behind delta lobes, which count as a density of 1 per
/// solid angle: the directions before and behind them correspond, and the weights compare only densities of the same
/// paths.
pub(super) struct Vertex<'a> {
    pub point: SurfacePoint,
    pub slot: SurfaceSlot,
    pub hit: Hit,
    /// The scattering as seen from the previous vertex.
    pub scattering: Scattering<'a>,
    /// The throughput of the path up to here: values over densities.
    pub throughput: Rgb,
    /// The index of the previous vertex; None for the first. Surfaces through which the path has passed straight do not
    /// count.
    pub before: Option<usize>,
    /// The density of the vertex.
    pub pdf: f32,
    /// The density that it would have from the other end of the path, by way of the next vertex.
    pub pdf_reverse: f32,
    /// The density by which light sampling from here finds the start of the path. Only for the first vertex of a light
    /// path.
    pub pdf_of_start: f32,
    /// Whether a delta lobe has sent the path on.
    pub is_delta: bool,
    /// Whether it has more than delta lobes, so that it can be joined with others.
    pub is_smooth: bool,
    /// The number of segments of the path up to here.
    pub segments: u32,
}

/// The start of a light path.
pub(super) struct LightPath {
    pub emitted: EmittedRay,
    /// The density of the start from the camera, by way of the first vertex, in the measure of the emission's start.
    pub pdf_reverse: f32,
}

/// A path between two vertices.
pub(super) struct Walk {
    pub ray: Ray,
    pub throughput: Rgb,
    pub eta_squared: f32,
    /// The density of the ray's direction at the previous vertex.
    pub pdf: Measure,
    pub before: Option<usize>,
    pub segments: u32,
    /// Whether the camera ray has only met surfaces that let it pass straight.
    pub is_straight: bool,
}

/// The density of a ray, in the measure of its origin.
#[derive(Clone, Copy, Debug)]
pub(super) enum Measure {
    /// Per solid angle, from this point.
    SolidAngle(f32, Vec3),
    /// Per area perpendicular to it, at any distance.
    Perpendicular(f32),
    /// The camera's density, for rays from this point of its lens.
    Camera(Vec3),
}

impl Vertex<'_> {
    /// The reference point for light sampling.
    pub fn reference(&self) -> LightReference {
        LightReference {
            position: self.point.position,
            normal: self.scattering.one_sided_normal_both_ways(),
        }
    }

    /// The density per area here of a density per solid angle at `from`.
    pub fn area_pdf(&self, pdf_solid_angle: f32, from: Vec3) -> f32 {
        let way = self.point.position - from;
        let squared = way.length_squared();
        if squared == 0.0 {
            return 0.0;
        }
        pdf_solid_angle * self.cosine(way / squared.sqrt()) / squared
    }

    /// The cosine of a direction with the geometric normal, on either side.
    pub fn cosine(&self, dir: Vec3) -> f32 {
        dir.dot(self.point.geometric_normal).abs()
    }

    /// The origin of a ray that leaves in direction `dir`.
    pub fn leave(&self, dir: Vec3) -> Vec3 {
        offset_origin(self.point.position, self.point.error, self.point.geometric_normal, dir)
    }
}

impl LightPath {
    /// The density of the start for a path that hits it from `reference` with this density per solid angle.
    pub fn start_density(&self, reference: Vec3, pdf_solid_angle: f32) -> f32 {
        self.emitted.start.density(reference, pdf_solid_angle)
    }
}

impl Walk {
    pub fn from_light(emitted: &EmittedRay) -> Self {
        Self {
            ray: Ray::new(emitted.origin, emitted.dir),
            throughput: Rgb::ONE,
            eta_squared: 1.0,
            pdf: match emitted.start {
                Start::Surface(hit) => Measure::SolidAngle(emitted.pdf.next, hit.position),
                Start::Point(position) => Measure::SolidAngle(emitted.pdf.next, position),
                Start::Infinity { .. } => Measure::Perpendicular(emitted.pdf.next),
            },
            before: None,
            segments: 0,
            is_straight: true,
        }
    }

    pub fn from_camera(ray: Ray) -> Self {
        Self {
            ray,
            throughput: Rgb::ONE,
            eta_squared: 1.0,
            pdf: Measure::Camera(ray.origin),
            before: None,
            segments: 0,
            is_straight: true,
        }
    }
}

impl<'a> Sample<'a, '_> {
    /// The vertex at a hit of the walk's ray.
    pub(super) fn vertex(&self, walk: &Walk, hit: &Hit, mode: TransportMode) -> Vertex<'a> {
        let slot = self.scene.slot(hit);
        let point = self.scene.surface(&walk.ray, hit, &slot);
        let scattering = self.scene.scattering(slot.material, hit, &point, -walk.ray.dir, mode);
        let mut vertex = Vertex {
            is_smooth: scattering.has_smooth_lobe(),
            point,
            slot,
            hit: *hit,
            scattering,
            throughput: walk.throughput,
            before: walk.before,
            pdf: 0.0,
            pdf_reverse: 0.0,
            pdf_of_start: 0.0,
            is_delta: false,
            segments: walk.segments + 1,
        };
        vertex.pdf = match walk.pdf {
            Measure::SolidAngle(pdf, from) => vertex.area_pdf(pdf, from),
            Measure::Perpendicular(pdf) => pdf * vertex.cosine(walk.ray.dir),
            Measure::Camera(lens) => {
                let distance = vertex.point.position.distance(lens);
                let density = self.view.camera.ray_density(walk.ray.dir, distance);
                density * vertex.cosine(walk.ray.dir)
            }
        };
        vertex
    }

    /// Extends a light path by a vertex and, unless it ends there, samples its next direction. False if it has ended.
    pub(super) fn extend_light(
        &mut self,
        walk: &mut Walk,
        path: &mut LightPath,
        vertices: &mut Vec<Vertex<'a>>,
    ) -> bool {
        self.rays += 1;
        let Some(hit) = self.scene.geometry.intersect(&walk.ray) else {
            return false;
        };
        let mut vertex = self.vertex(walk, &hit, TransportMode::Importance);
        if vertex.before.is_none() {
            let (reference, wi) = (vertex.reference(), -walk.ray.dir);
            let EmittedRay { light, start, .. } = &path.emitted;
            let pdf = self.scene.lights.pdf_of_start(*light, &reference, start, wi);
            vertex.pdf_of_start = path.start_density(reference.position, pdf);
        }
        let depth = vertex.segments;
        let sampler = self.light_sampler;
        let sample = vertex.scattering.sample_adjoint(
            sampler.at_1d(LightDraw::Lobe.at(depth)),
            sampler.at_2d(LightDraw::Direction.at(depth)),
            vertex.point.geometric_normal,
        );
        let number = vertices.len();
        vertices.push(vertex);
        let Some(sample) = sample else {
            return false;
        };
        walk.throughput *= sample.weight;
        if walk.throughput == Rgb::ZERO {
            return false;
        }
        if sample.lobe != Lobe::Null {
            let reverse = reverse_pdf(vertices, number, sample.wi, sample.lobe);
            match vertices[number].before {
                Some(before) => {
                    let pdf = vertices[before].area_pdf(reverse, vertices[number].point.position);
                    vertices[before].pdf_reverse = pdf;
                }
                None => path.pdf_reverse = path.start_density(vertices[number].point.position, reverse),
            }
        }
        walk.go_on(vertices, number, sample.wi, sample.lobe, sample.pdf);
        let is_scattered = sample.lobe == Lobe::Smooth;
        if roulette::is_played::<f32>(&self.settings, walk.segments, is_scattered) {
            let survival = roulette::survival(walk.throughput.max_element(), 1.0);
            if sampler.at_1d(LightDraw::Roulette.at(depth)) >= survival {
                return false;
            }
            walk.throughput /= survival;
        }
        true
    }
}

/// The density per solid angle with which a path that comes from `wi` would return to the previous vertex.
pub(super) fn reverse_pdf(vertices: &[Vertex], number: usize, wi: Vec3, lobe: Lobe) -> f32 {
    match lobe {
        Lobe::Smooth => vertices[number].scattering.reverse_pdf(wi),
        Lobe::Delta | Lobe::Null => 1.0,
    }
}

impl Walk {
    /// Continues the walk from the vertex with this number in direction `wi`.
    pub fn go_on(&mut self, vertices: &mut [Vertex], number: usize, wi: Vec3, lobe: Lobe, pdf: f32) {
        let vertex = &mut vertices[number];
        self.segments = vertex.segments;
        self.is_straight &= lobe == Lobe::Null;
        if lobe != Lobe::Null {
            vertex.is_delta = lobe == Lobe::Delta;
            let pdf = if vertex.is_delta { 1.0 } else { pdf };
            self.pdf = Measure::SolidAngle(pdf, vertex.point.position);
            self.before = Some(number);
        }
        self.ray = Ray::new(vertex.leave(wi), wi);
    }
}
