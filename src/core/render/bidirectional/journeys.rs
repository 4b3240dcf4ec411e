//! Light paths with what they leave on their way: how much of a lamp's light arrives at each surface, and how much of
//! that stays there.

use std::ops::Range;
use std::sync::atomic::AtomicBool;

use glam::UVec2;

use super::subpath::{LightPath, Vertex, Walk};
use super::weights::Ways;
use super::{LIGHT_PIXEL, Techniques, Tracer};
use crate::color::Rgb;
use crate::light::emission::Start;
use crate::render::scene::RenderScene;
use crate::render::view::View;
use crate::sampling::{Sampler, SequenceKind};

/// The arrival of a light path at a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::render) struct Landing {
    /// The instance, as [`crate::accel::Hit::instance`] counts them.
    pub instance: u32,
    /// The power that arrives.
    pub received: Rgb,
    /// The part of it that the path does not carry on.
    pub absorbed: Rgb,
}

/// A light path from its lamp on.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::render) struct Journey {
    /// The power that was emitted: the sum of all that is absorbed and of what escapes.
    pub emitted: Rgb,
    /// The surfaces in turn, without invisible ones.
    pub landings: Vec<Landing>,
    /// The power that leaves the scene.
    pub escaped: Rgb,
    /// Whether the light has come from infinity, where also rays begin that miss the scene.
    pub is_from_infinity: bool,
}

/// Traces light paths with these numbers of all lights of a scene. Media are ignored.
pub(in crate::render) fn journeys(scene: &RenderScene, view: &View, numbers: Range<u32>) -> Vec<Journey> {
    let techniques = Techniques {
        splats: false,
        camera_paths: false,
        merging: None,
    };
    let settings = view.integrator.settings();
    let never = AtomicBool::new(false);
    let Some(tracer) = Tracer::new(scene, view, settings, techniques, std::iter::empty(), &never) else {
        return Vec::new();
    };
    let ways = Ways {
        to_lens: false,
        joins: true,
        merging: None,
    };
    let mut vertices: Vec<Vertex> = Vec::new();
    let journey = |number| {
        let sampler = Sampler::new(SequenceKind::Sobol, UVec2::splat(LIGHT_PIXEL - 3), number, view.seed);
        let mut sample = tracer.begin(ways, sampler, sampler);
        vertices.clear();
        let emitted = sample.emit()?;
        let mut path = LightPath {
            emitted,
            pdf_reverse: 0.0,
        };
        let mut walk = Walk::from_light(&emitted);
        let mut known = 0;
        let longest = settings.longest_path();
        while walk.segments + 1 < longest && sample.extend_light(&mut walk, &mut path, &mut vertices) {
            known = vertices.len();
        }
        // A path ends at a surface that is new, or nowhere.
        let has_escaped = vertices.len() == known && walk.segments + 1 < longest;
        let escaped = if has_escaped { walk.throughput } else { Rgb::ZERO };
        let throughputs = vertices.iter().skip(1).map(|vertex| vertex.throughput);
        let carried_on = throughputs.chain([escaped]);
        // Light does not arrive at the invisible borders of media.
        let visible = vertices.iter().zip(carried_on);
        let visible = visible.filter(|(vertex, _)| !scene.materials.is_null(vertex.slot.material));
        let landings = visible.map(|(vertex, on)| Landing {
            instance: vertex.hit.instance,
            received: emitted.power * vertex.throughput,
            absorbed: emitted.power * (vertex.throughput - on),
        });
        Some(Journey {
            emitted: emitted.power,
            landings: landings.collect(),
            escaped: emitted.power * escaped,
            is_from_infinity: matches!(emitted.start, Start::Infinity { .. }),
        })
    };
    numbers.filter_map(journey).collect()
}
