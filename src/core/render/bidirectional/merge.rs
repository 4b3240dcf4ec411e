//! Merging camera paths with the photons near their vertices.

use super::Sample;
use super::subpath::Vertex;
use super::weights::weight;
use crate::color::Rgb;
use crate::render::observer::{Joined, PathObserver};
use crate::render::photon_map::Photon;

/// The squared distance of photons from the plane of the surface, relative to the squared merging radius, up to which
/// they are merged. Photons beyond belong to another surface.
const OFF_PLANE_SQUARED: f32 = 0.1;
/// The least cosine of a photon's direction with the normal. Below it a photon would represent more area than its light
/// comes from.
const LEAST_COSINE: f32 = 1e-3;

impl Sample<'_, '_> {
    /// Adds the light of the photons near a vertex of the camera path.
    pub(super) fn merge(&mut self, camera: &[Vertex], number: usize, observer: &mut impl PathObserver) {
        let (Some(photons), Some(merging)) = (self.photons, self.ways.merging) else {
            return;
        };
        let vertex = &camera[number];
        let place = vertex.point.position;
        let radius_squared = merging.area.radius_squared(place);
        let expected = merging.expected(vertex);
        let ratio = 1.0 / (vertex.pdf * expected);
        let longest = self.settings.longest_path();
        let mut sum = Rgb::ZERO;
        photons.near(place, radius_squared, |photon: &Photon| {
            let off_plane = (photon.position - place).dot(vertex.point.geometric_normal);
            let cosine = vertex.cosine(photon.wi);
            if vertex.segments + photon.segments > longest
                || off_plane * off_plane > OFF_PLANE_SQUARED * radius_squared
                || cosine < LEAST_COSINE
            {
                return;
            }
            let (value, pdf) = vertex.scattering.eval_and_pdf(photon.wi);
            if value == Rgb::ZERO {
                return;
            }
            let next = self.next_of_camera(camera, number, photon.wi);
            let others = photon.fewer.sum(pdf) / (expected * expected)
                + self.ways.with_fewer_of_camera(camera, number, ratio, false, next);
            // Photons measure power per area, whose cosine is in `value` as well.
            let weight = weight(others);
            let contribution = vertex.throughput * value * photon.power * (weight / (cosine * expected));
            sum += contribution;
            observer.joined(&Joined {
                light: photon.light,
                position: photon.position,
                weight,
                contribution,
            });
        });
        self.radiance += sum;
    }
}
