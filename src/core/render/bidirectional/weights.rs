//! The weights of multiple importance sampling for a path that can be found in many ways (Veach 1997, section 10.2.1):
//! how likely each other way is, relative to that by which the path was found. From one way to the next, one vertex
//! changes from the path of the light to that of the camera or back, and the ratio with it; those whose joining
//! vertices only have delta lobes are impossible.

use super::subpath::{LightPath, Vertex};
use crate::render::photon_map::{FewerOfLight, MergeArea};

/// The weight of the power heuristic, from the sum of the squared ratios of all other ways.
pub(super) fn weight(others: f32) -> f32 {
    // An overflow means that another way is far better. Along a surface, ratios may be no numbers.
    if others.is_nan() { 0.0 } else { 1.0 / (1.0 + others) }
}

/// Merging: the way of finding a path whose vertex `v` is found from both sides, where the place found from the light
/// counts if it is near the other one (Georgiev et al., "Light Transport Simulation with Vertex Connection and
/// Merging", ACM TOG 31(6), 2012). It has the density of the way in which `v` is found from the camera and joined with
/// the vertex before, times the probability that a path from the light comes near `v`.
///
/// Only what a delta lobe has sent to `v` is merged: anything else can be joined without bias.
#[derive(Clone, Copy, Debug)]
pub(super) struct Merging {
    pub area: MergeArea,
    /// The paths from the lights whose photons are at hand.
    pub paths: f32,
}

impl Merging {
    /// The number of paths from the lights that are expected near a vertex, over their density per area there. Square
    /// metres.
    pub fn expected(&self, vertex: &Vertex) -> f32 {
        self.paths * std::f32::consts::PI * self.area.radius_squared(vertex.point.position)
    }
}

/// The ways by which a picture finds its paths, besides coming upon lights and sampling them.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ways {
    /// Paths from lights are joined with the lens.
    pub to_lens: bool,
    /// Paths from lights are joined with paths from the camera.
    pub joins: bool,
    pub merging: Option<Merging>,
}

impl Ways {
    /// The ways of path tracing.
    pub const OF_PATHS: Self = Self {
        to_lens: false,
        joins: false,
        merging: None,
    };

    /// The squared ratio of joining two vertices, if it is possible.
    fn joined(&self, ratio: f32, is_possible: bool) -> f32 {
        if self.joins && is_possible { square(ratio) } else { 0.0 }
    }

    /// The squared ratio of merging at a vertex, if it is possible. `ratio` is that of the way in which the vertex has
    /// changed from its own side, where it has its density, to the other.
    fn merged(&self, ratio: f32, vertex: &Vertex, is_possible: bool) -> f32 {
        match &self.merging {
            Some(merging) if is_possible => square(ratio * vertex.pdf * merging.expected(vertex)),
            _ => 0.0,
        }
    }

    /// The ways with fewer vertices from the light than the one at hand, which joins the vertex number `last` of a path
    /// from the light. From the other side that has the density `pdf` per area. Relative to merging there, they are
    /// those for a `pdf` of 1, over [`Merging::expected`]; `is_merged` leaves it out.
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

    /// [`Self::with_fewer_of_light`] where paths from the camera have `factor` times the density with which they leave
    /// a vertex of the light's for the one that was before it, or for the start of the light.
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
        // The ratio of the way in which the vertex has changed sides, but for the factor of the density `next` behind
        // the last vertex.
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

    /// The ways with fewer vertices from the camera, down to one if the lens is joined. `ratio` is that of the way in
    /// which the vertex `last` has changed sides; `is_delta` says whether it cannot be joined, and `next` is the
    /// density of the vertex before it, if it is not the one that the vertex behind it knows. No delta lobe has
    /// sent light to the vertex `last`, or what it has sent is merged.
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
