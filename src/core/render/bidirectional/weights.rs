//! The weights of multiple importance sampling for a path that several techniques can find (Veach 1997, section
//! 10.2.1): the density of each other technique relative to that which has found the path. From one technique to the
//! next, one vertex changes between light path and camera path, which changes the ratio; techniques whose joining
//! vertices have only delta lobes are impossible.

use super::subpath::{LightPath, Vertex};
use crate::render::photon_map::{FewerOfLight, MergeArea};

/// The weight of the power heuristic, from the sum of the squared ratios of all other techniques.
pub(super) fn weight(others: f32) -> f32 {
    // An overflow means that another technique is far better. Along a surface, ratios may be NaN.
    if others.is_nan() { 0.0 } else { 1.0 / (1.0 + others) }
}

/// Merging: the technique that finds a path from both sides up to its vertex `v`, where the light path's vertex counts
/// if it is near `v` (Georgiev et al., "Light Transport Simulation with Vertex Connection and Merging", ACM TOG 31(6),
/// 2012). Its density is that of finding `v` from the camera and joining it with the previous vertex, times the
/// probability that a light path comes near `v`.
///
/// Only light that a delta lobe has sent to `v` is merged: other vertices can be joined without bias.
#[derive(Clone, Copy, Debug)]
pub(super) struct Merging {
    pub area: MergeArea,
    /// The number of light paths whose photons are merged.
    pub paths: f32,
}

impl Merging {
    /// The number of light paths that are expected near a vertex, over their density per area there. Square metres.
    pub fn expected(&self, vertex: &Vertex) -> f32 {
        self.paths * std::f32::consts::PI * self.area.radius_squared(vertex.point.position)
    }
}

/// The techniques of a picture, besides hitting lights and sampling them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ways {
    /// Whether light paths are joined with the lens.
    pub to_lens: bool,
    /// Whether light paths are joined with camera paths.
    pub joins: bool,
    pub merging: Option<Merging>,
}

impl Ways {
    /// The techniques of path tracing.
    pub const OF_PATHS: Self = Self {
        to_lens: false,
        joins: false,
        merging: None,
    };

    /// The squared ratio of joining two vertices, if it is possible.
    fn joined(&self, ratio: f32, is_possible: bool) -> f32 {
        if self.joins && is_possible { square(ratio) } else { 0.0 }
    }

    /// The squared ratio of merging at a vertex, if it is possible. `ratio` is that of the technique in which the
    /// vertex has changed sides, from the side where it has its density to the other.
    fn merged(&self, ratio: f32, vertex: &Vertex, is_possible: bool) -> f32 {
        match &self.merging {
            Some(merging) if is_possible => square(ratio * vertex.pdf * merging.expected(vertex)),
            _ => 0.0,
        }
    }

    /// The techniques with fewer vertices from the light than the current one, which joins the vertex `last` of a light
    /// path. From the camera that vertex has the density `pdf` per area. Relative to merging there, they are those for
    /// a `pdf` of 1, over [`Merging::expected`]; `is_merged` omits it.
    pub fn with_fewer_of_light(
        &self,
        path: &LightPath,
        vertices: &[Vertex],
        last: usize,
        pdf: f32,
        is_merged: bool,
    ) -> FewerOfLight {
        self.with_fewer_of_light_times(path, vertices, last, pdf, is_merged, |_, _| 1.0)
    }

    /// [`Self::with_fewer_of_light`] where camera paths leave each vertex of the light path towards the previous one,
    /// or towards the light's start, with `factor` times the density.
    pub fn with_fewer_of_light_times(
        &self,
        path: &LightPath,
        vertices: &[Vertex],
        last: usize,
        pdf: f32,
        is_merged: bool,
        factor: impl Fn(&Vertex, Option<&Vertex>) -> f32,
    ) -> FewerOfLight {
        let mut number = last;
        // The ratio of the technique in which the vertex has changed sides, without the factor of the density `next`
        // behind the last vertex.
        let mut ratio = pdf / vertices[number].pdf;
        let (mut fixed, mut of_next) = (0.0, 0.0);
        let mut is_delta = false;
        let mut reverse = None;
        loop {
            let vertex = &vertices[number];
            let sum = if number == last { &mut fixed } else { &mut of_next };
            let Some(before) = vertex.before else {
                let start = path.emitted.pdf.start;
                if !is_delta {
                    *sum += square(ratio * vertex.pdf_of_start / start);
                }
                if !path.emitted.start.is_delta() {
                    let reverse = reverse.unwrap_or_else(|| path.start_density(vertex.point.position, 1.0));
                    of_next += square(ratio * reverse / start * factor(vertex, None));
                }
                return FewerOfLight { fixed, of_next };
            };
            let other = &vertices[before];
            let is_left_out = is_merged && number == last;
            *sum += self.joined(ratio, !is_delta && !other.is_delta)
                + self.merged(ratio, vertex, !is_delta && other.is_delta && !is_left_out);
            let reverse_of_other = reverse.unwrap_or_else(|| other.area_pdf(1.0, vertex.point.position));
            ratio *= reverse_of_other / other.pdf * factor(vertex, Some(other));
            is_delta = other.is_delta;
            reverse = Some(match other.before {
                Some(next) => vertices[next].pdf_reverse,
                None => path.pdf_reverse,
            });
            number = before;
        }
    }

    /// The techniques with fewer vertices from the camera, down to one if the lens is joined. `ratio` is that of the
    /// technique in which the vertex `last` has changed sides; `is_delta` says whether it cannot be joined, and `next`
    /// is the density of the previous vertex, if it differs from the one stored there. No delta lobe has sent light to
    /// the vertex `last`, or that light is merged.
    pub fn with_fewer_of_camera(
        &self,
        vertices: &[Vertex],
        last: usize,
        ratio: f32,
        is_delta: bool,
        next: Option<f32>,
    ) -> f32 {
        let (mut sum, mut number, mut ratio, mut is_delta, mut next) = (0.0, last, ratio, is_delta, next);
        let mut is_sent_by_delta = false;
        loop {
            let vertex = &vertices[number];
            sum += self.merged(ratio, vertex, !is_delta && is_sent_by_delta);
            let Some(before) = vertex.before else {
                if self.to_lens && !is_delta {
                    sum += square(ratio);
                }
                return sum;
            };
            let other = &vertices[before];
            sum += self.joined(ratio, !is_delta && !other.is_delta);
            ratio *= next.take().unwrap_or(other.pdf_reverse) / other.pdf;
            is_sent_by_delta = is_delta;
            is_delta = other.is_delta;
            number = before;
        }
    }
}

fn square(ratio: f32) -> f32 {
    ratio * ratio
}
