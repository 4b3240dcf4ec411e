//! The weights of multiple importance sampling for a path that can be found in many ways (Veach 1997, section 10.2.1): how likely each other way is,
//! relative to that by which the path was found. From one way to the next, one vertex changes from the path of the light to that of the camera
//! or back, and the ratio with it; those whose joining vertices only have delta lobes are impossible.

use super::subpath::{LightPath, Vertex};

/// The weight of the power heuristic, from the sum of the squared ratios of all other ways.
pub(super) fn weight(others: f32) -> f32 {
    // An overflow means that another way is far better. Along a surface, ratios may be no numbers.
    if others.is_nan() { 0.0 } else { 1.0 / (1.0 + others) }
}

/// The ends of the part of a path on one side of the joint, as seen from the other side.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ends {
    /// The number of the last vertex.
    pub last: usize,
    /// The density that it would have from the other side.
    pub pdf: f32,
    /// The density, per solid angle, with which the path would go on to the vertex before it.
    pub next: f32,
}

/// The ways with fewer vertices from the light. The path ends in `ends` on the side of the light.
pub(super) fn with_fewer_of_light(path: &LightPath, vertices: &[Vertex], ends: &Ends) -> f32 {
    let mut sum = 0.0;
    let mut number = ends.last;
    let mut ratio = ends.pdf / vertices[number].pdf;
    let mut is_delta = false;
    let mut reverse = None;
    loop {
        let vertex = &vertices[number];
        let Some(before) = vertex.before else {
            let start = path.emitted.pdf.start;
            if !is_delta {
                sum += square(ratio * vertex.pdf_of_start / start);
            }
            if !path.emitted.start.is_delta() {
                let position = vertex.point.position;
                let reverse = reverse.unwrap_or_else(|| path.start_density(position, ends.next));
                sum += square(ratio * reverse / start);
            }
            return sum;
        };
        let other = &vertices[before];
        if !is_delta && !other.is_delta {
            sum += square(ratio);
        }
        let reverse_of_other = reverse.unwrap_or_else(|| other.area_pdf(ends.next, vertex.point.position));
        ratio *= reverse_of_other / other.pdf;
        is_delta = other.is_delta;
        reverse = Some(match other.before {
            Some(next) => vertices[next].pdf_reverse,
            None => path.pdf_reverse,
        });
        number = before;
    }
}

/// The ways with fewer vertices from the camera, down to one if `to_lens`. `ratio` is that of the way in which the vertex `last` has changed sides;
/// `is_delta` says whether it cannot be joined, and `next` is the density of the vertex before it, if it is not the one that the vertex behind it knows.
pub(super) fn with_fewer_of_camera(
    vertices: &[Vertex],
    last: usize,
    ratio: f32,
    is_delta: bool,
    next: Option<f32>,
    to_lens: bool,
) -> f32 {
    let (mut sum, mut number, mut ratio, mut is_delta, mut next) = (0.0, last, ratio, is_delta, next);
    loop {
        let Some(before) = vertices[number].before else {
            if to_lens && !is_delta {
                sum += square(ratio);
            }
            return sum;
        };
        let other = &vertices[before];
        if !is_delta && !other.is_delta {
            sum += square(ratio);
        }
        ratio *= next.take().unwrap_or(other.pdf_reverse) / other.pdf;
        is_delta = other.is_delta;
        number = before;
    }
}

fn square(ratio: f32) -> f32 {
    ratio * ratio
}
