//! The densities with which path tracing would find the paths of bidirectional path tracing.

use std::f32::consts::FRAC_1_PI;

use glam::{UVec2, Vec3};

use super::Sample;
use super::subpath::{LightPath, Vertex};
use super::weights::Ways;
use crate::color::{Rgb, luminance};
use crate::render::guide::Field;

/// A path with light, and its contribution in path tracing.
#[derive(Clone, Copy, Debug)]
pub(in crate::render) struct Find {
    /// The pixel that receives the light; None for the sample's own.
    pub pixel: Option<UVec2>,
    /// The luminance that the path has added.
    pub light: f32,
    /// The luminance of the path whenever path tracing finds it: its contribution over the density of path tracing's
    /// techniques. Infinite if they never find it.
    ///
    /// The mean of `light * in_one` is the second moment of such paths in path tracing, known without waiting for light
    /// that path tracing finds once in a million samples.
    pub in_one: f32,
    /// The same luminance for guided paths; equal to `in_one` without a guide.
    pub in_guided: f32,
}

/// The guide of camera paths, if there is one.
#[derive(Clone, Copy)]
pub(super) struct Guidance<'a>(Option<&'a Field>);

impl Sample<'_, '_> {
    /// Records a path with light, if finds are recorded. `whole` is its unweighted light, and `of_paths` the sum of the
    /// squared densities of path tracing's techniques relative to that by which it was found.
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
    /// The density with which guided paths leave a vertex in direction `wi`, over that without a guide. Below a coat it
    /// is an estimate, as if the whole model had the density of the cosine: the direction to the previous vertex is not
    /// known here.
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

    /// The product of the ratios of all vertices before a vertex of the camera path.
    pub fn along(&self, camera: &[Vertex], mut number: usize) -> f32 {
        let mut product = 1.0;
        while let Some(before) = camera[number].before.filter(|_| self.0.is_some()) {
            product *= self.ratio(&camera[before], between(&camera[before], &camera[number]));
            number = before;
        }
        product
    }

    /// The sum of the squared densities of path tracing's techniques, relative to joining the vertex `last` of a light
    /// path with the camera path. From the camera that vertex has the density `pdf` per area, and `next` is the density
    /// per solid angle with which a camera path would continue from it towards the light.
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
