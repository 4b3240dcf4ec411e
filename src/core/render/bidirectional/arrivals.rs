//! The photons that a guide is learnt from: all vertices of light paths but the first, whose light comes straight from
//! a lamp.

use std::ops::Range;
use std::sync::atomic::AtomicBool;

use glam::{UVec2, Vec3};

use super::subpath::Vertex;
use super::weights::Ways;
use super::{LIGHT_PIXEL, Techniques, Tracer};
use crate::color::luminance;
use crate::render::guide::{MOST_OF_PATH, PhotonArrival, Photons};
use crate::render::scene::RenderScene;
use crate::render::view::View;
use crate::sampling::{Sampler, SequenceKind};

/// The seed of these paths: a guide does not depend on the seed of the picture.
const SEED: u32 = 0x5eed_901d;

/// Traces light paths with these numbers.
pub(in crate::render) fn arrivals(scene: &RenderScene, view: &View, numbers: Range<u32>) -> Photons {
    let techniques = Techniques {
        splats: false,
        camera_paths: false,
        merging: None,
    };
    let settings = view.integrator.settings();
    let never = AtomicBool::new(false);
    let mut photons = Photons {
        arrivals: Vec::new(),
        rays: 0,
    };
    let Some(tracer) = Tracer::new(scene, view, settings, techniques, std::iter::empty(), &never) else {
        return photons;
    };
    let ways = Ways {
        to_lens: false,
        joins: true,
        merging: None,
    };
    let mut vertices: Vec<Vertex> = Vec::new();
    for number in numbers {
        let sampler = Sampler::new(SequenceKind::Sobol, UVec2::splat(LIGHT_PIXEL - 2), number, SEED);
        let mut sample = tracer.begin(ways, sampler, sampler);
        vertices.clear();
        let path = sample.trace_light(&mut vertices);
        photons.rays += u64::from(sample.rays);
        let Some(path) = path else { continue };
        for vertex in vertices.iter().filter(|vertex| vertex.is_smooth).take(MOST_OF_PATH) {
            let Some(before) = vertex.before.map(|before| &vertices[before]) else {
                continue;
            };
            let wi: Vec3 = (before.point.position - vertex.point.position).normalize_or_zero();
            let normal = vertex.point.shading_normal;
            let arrival = PhotonArrival {
                position: vertex.point.position,
                normal: if normal.dot(wi) < 0.0 { -normal } else { normal },
                wi,
                power: luminance(path.emitted.power * vertex.throughput),
            };
            if arrival.power > 0.0 && arrival.power.is_finite() && wi != Vec3::ZERO {
                photons.arrivals.push(arrival);
            }
        }
    }
    photons
}
