//! The photons of a round: the vertices of light paths to which a delta lobe has sent light.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use glam::{UVec2, Vec2, Vec3};

use super::subpath::Vertex;
use super::weights::{Merging, Ways};
use super::{LIGHT_PIXEL, Tracer};
use crate::render::photon_map::{MergeArea, Photon, PhotonMap};
use crate::render::photon_rounds::{PATHS_OF_BLOCK, RoundId};
use crate::render::view::{PhotonSettings, View};
use crate::sampling::Sampler;

/// The exponent of the round's number in the squared radius: merging areas shrink so slowly that both the blur and the
/// noise of the mean of all rounds vanish (Georgiev et al. 2012, section 5.3; alpha is 3/4).
const SHRINKING: f32 = -0.25;
/// The largest merging radius, relative to the scene's radius.
const LARGEST_RADIUS: f32 = 0.01;
/// The fewest and the most light paths of a round by default.
const PATHS: [u32; 2] = [1 << 12, 1 << 16];

/// The number of light paths of a round.
pub(in crate::render) fn photon_paths(view: &View, settings: PhotonSettings) -> u32 {
    let pixels = view.width.saturating_mul(view.height);
    settings.paths.unwrap_or((pixels / 4).clamp(PATHS[0], PATHS[1]))
}

impl<'a> Tracer<'a> {
    /// The photons of a round. None if cancelled.
    pub(super) fn photons(
        &self,
        number: u32,
        settings: PhotonSettings,
        cancel: &AtomicBool,
    ) -> Option<(Merging, Arc<PhotonMap>)> {
        let paths = photon_paths(self.view, settings);
        let area = self.merge_area(number, settings.radius);
        let id = RoundId {
            number,
            sequence: self.view.sequence,
            seed: self.view.seed,
            paths,
            area,
            longest_path: self.settings.longest_path(),
            rr_depth: self.settings.rr_depth,
        };
        let ways = Ways {
            to_lens: self.techniques.splats,
            joins: true,
            merging: Some(Merging {
                area,
                paths: paths as f32,
            }),
        };
        let trace = |block| {
            let first = block * PATHS_OF_BLOCK;
            let last = paths.min(first + PATHS_OF_BLOCK);
            self.trace_photons(
                ways,
                (first..last).map(|path| u64::from(number) * u64::from(paths) + u64::from(path)),
            )
        };
        let map = self.view.photons.get(self.scene, id, trace, cancel)?;
        Some((ways.merging?, map))
    }

    fn merge_area(&self, number: u32, radius_in_pixels: f32) -> MergeArea {
        let camera = &self.view.camera;
        let pixels = self.view.width as f32 * self.view.height as f32;
        let eye = camera.eye();
        // At distance 1, at the centre of the picture.
        let middle = camera.ray(Vec2::splat(0.5), Vec2::splat(0.5));
        let area_of_pixel = 1.0 / (camera.ray_density(middle.dir, 1.0) * pixels);
        let shrunk = (number as f32 + 1.0).powf(SHRINKING);
        MergeArea {
            radius_squared: radius_in_pixels * radius_in_pixels * area_of_pixel * shrunk,
            eye,
            largest: (LARGEST_RADIUS * self.scene.reach.lit.radius).powi(2) * shrunk,
        }
    }

    fn trace_photons(&self, ways: Ways, numbers: impl Iterator<Item = u64>) -> Vec<Photon> {
        let mut photons = Vec::new();
        let mut vertices: Vec<Vertex<'a>> = Vec::new();
        for number in numbers {
            // These numbers differ from those of the light paths that are joined.
            let pixel = UVec2::new(LIGHT_PIXEL - 1, LIGHT_PIXEL - (number >> 32) as u32);
            let sampler = Sampler::new(self.view.sequence, pixel, number as u32, self.view.seed);
            let mut sample = self.begin(ways, sampler, sampler);
            vertices.clear();
            let Some(path) = sample.trace_light(&mut vertices) else {
                continue;
            };
            for (last, vertex) in vertices.iter().enumerate().filter(|(_, vertex)| vertex.is_smooth) {
                let Some(before) = vertex.before.map(|before| &vertices[before]) else {
                    continue;
                };
                if !before.is_delta {
                    continue;
                }
                let power = path.emitted.power * vertex.throughput;
                let wi: Vec3 = (before.point.position - vertex.point.position).normalize_or_zero();
                photons.push(Photon {
                    light: path.emitted.light,
                    position: vertex.point.position,
                    wi,
                    power,
                    fewer: ways.with_fewer_of_light(&path, &vertices, last, 1.0, true),
                    segments: vertex.segments,
                });
            }
        }
        photons
    }
}
