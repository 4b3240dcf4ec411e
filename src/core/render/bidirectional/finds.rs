//! What path tracing would make of the paths that bidirectional path tracing finds.

use std::f32::consts::FRAC_1_PI;

use glam::{UVec2, Vec3};

use super::Sample;
use super::subpath::{LightPath, Vertex};
use super::weights::Ways;
use crate::color::{Rgb, luminance};
use crate::render::guide::Field;

/// A path with light, and what path tracing would make of it.
#[derive(Clone, Copy, Debug)]
pub(in crate::render) struct Find {
    /// The pixel that it brings light to; None for the sample's own.
    pub pixel: Option<UVec2>,
    /// The luminance that it has brought.
    pub light: f32,
    /// The luminance of the path by path tracing, whenever that finds it: its contribution over the density with which
    /// its ways find it. Infinite if it never does.
    ///
    /// The mean of `light * in_one` is the second moment that such paths have there, so that what path tracing finds
    /// once in a million samples need not be waited for.
    pub in_one: f32,
    /// The same for guided paths. It is that of others where nothing guides them.
    pub in_guided: f32,
}

/// What paths from the camera may be guided by.
#[derive(Clone, Copy)]
pub(super) struct Guidance<'a>(Option<&'a Field>);

impl Sample<'_, '_> {
    /// Notes a path with light, if it is asked for. `whole` is its light without a weight, and `of_paths` the sum of
    /// the squared densities of path tracing's ways relative to that by which it was found.
    pub(super) fn note(&mut self, pixel: Option<UVec2>, light: Rgb, whole: Rgb, of_paths: impl Fn(Guidance) -> f32) {
        let Some(finds) = &mut self.finds else { return };
        let light = luminance(light);
        if light > 0.0 && light.is_finite() {
            let in_one = |field| luminance(whole) / of_paths(Guidance(field)).sqrt();
            let unguided = in_one(None);
            finds.push(Find {
                pixel,
                light,
                in_one: unguided,
                in_guided: self.field.map_or(unguided, |field| in_one(Some(field))),
            });
        }
    }
}

impl Guidance<'_> {
    /// The density with which paths leave a vertex in direction `wi` over that without a guide. Below a coat it is an
    /// estimate, as if all of the model had the density of the cosine: the direction that the path has come from is
    /// not known here.
    pub fn ratio(&self, vertex: &Vertex, wi: Vec3) -> f32 {
        let of_guide = || {
            let (lobe, normal) = vertex.scattering.diffuse_lobe()?;
            let (density, part) = self.0?.density(vertex.point.position, normal, wi)?;
            Some((density, lobe.share * part, normal.dot(wi).max(0.0) * FRAC_1_PI))
        };
        match of_guide() {
            Some((density, part, of_cosine)) if of_cosine > 0.0 => 1.0 - part + part * density / of_cosine,
            _ => 1.0,
        }
    }

    /// The ratios of all vertices before a vertex of the camera's path, multiplied.
    pub fn along(&self, camera: &[Vertex], mut number: usize) -> f32 {
        let mut product = 1.0;
        while let Some(before) = camera[number].before.filter(|_| self.0.is_some()) {
            product *= self.ratio(&camera[before], between(&camera[before], &camera[number]));
            number = before;
        }
        product
    }

    /// The sum of the squared densities of path tracing's ways, relative to that which joins the vertex number `last`
    /// of a path from a light with the camera's. From there it has the density `pdf` per area, and `next` is the
    /// density per solid angle with which a path from the camera would leave it against the light.
    pub fn of_joined(&self, path: &LightPath, light: &[Vertex], last: usize, pdf: f32, next: f32) -> f32 {
        let factor = |vertex: &Vertex, next: Option<&Vertex>| {
            let wi = next.map_or(-path.emitted.dir, |next| between(vertex, next));
            self.ratio(vertex, wi)
        };
        let ways = Ways::OF_PATHS.with_fewer_of_light_times(path, light, last, pdf, false, factor);
        ways.sum(next)
    }
}

fn between(from: &Vertex, to: &Vertex) -> Vec3 {
    (to.point.position - from.point.position).normalize_or_zero()
}
