//! Estimates irradiance: the light that arrives at one side of a surface, whatever the surface's material.
//!
//! A sample is a path that begins at the surface, with next event estimation and multiple importance sampling there as
//! at every later vertex. The surface replaces the first one that a camera ray hits, so limits of depth count as if a
//! camera looked at it. The integral, of radiance times cosine over the hemisphere, is that of PBR 4th ed., section
//! 4.2.1.

use std::f32::consts::{FRAC_1_PI, PI};
use std::sync::atomic::AtomicBool;

use glam::Vec3;

use super::borders::medium_at;
use super::dimensions::BounceDraw;
use super::gathering::{Arrivals, Gathering, Site};
use super::layers::NoteTaker;
use super::path::{Departure, Scatterer};
use super::path_state::{Arrival, PathState};
use super::scene::RenderScene;
use super::view::PathSettings;
use crate::color::Rgb;
use crate::light::{LightId, LightReference, LightTable};
use crate::math::{Frame, Ray, offset_origin};
use crate::medium::MediumId;
use crate::sampling::{Sampler, warp};

/// A point on one side of a surface, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Receiver {
    /// The point.
    pub position: Vec3,
    /// Bound, per coordinate, on the distance of `position` from the surface that rays meet.
    pub error: f32,
    /// The unit normal from which the cosine is measured.
    pub normal: Vec3,
    /// The unit normal of the surface itself, on the same side. No light arrives from below it.
    pub geometric_normal: Vec3,
}

/// The light that a receiver counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ReceivedLight {
    /// All light.
    #[default]
    All,
    /// All light except that straight from points, spots and single directions, for which file formats of levels have
    /// their own lights.
    WithoutPunctual,
}

/// A receiver as the first vertex of a path, which has the cosine in place of a bsdf.
struct Vertex<'a> {
    receiver: &'a Receiver,
    light: ReceivedLight,
    reference: LightReference,
}

impl Scatterer for Vertex<'_> {
    fn reference(&self) -> &LightReference {
        &self.reference
    }

    fn eval_and_pdf(&self, wi: Vec3) -> (Rgb, f32) {
        let cosine = self.receiver.cosine(wi);
        (Rgb::splat(cosine), cosine * FRAC_1_PI)
    }

    fn takes_delta(&self, lights: &LightTable, id: LightId) -> bool {
        self.light == ReceivedLight::All || lights.is_projector(id)
    }

    fn leave(&self, wi: Vec3, medium: Option<MediumId>) -> Departure {
        Departure {
            origin: self.receiver.leave(wi),
            medium,
        }
    }
}

impl Receiver {
    /// The cosine to the normal; 0 for directions below the surface.
    fn cosine(&self, wi: Vec3) -> f32 {
        match self.geometric_normal.dot(wi) > 0.0 {
            true => self.normal.dot(wi).max(0.0),
            false => 0.0,
        }
    }

    fn leave(&self, wi: Vec3) -> Vec3 {
        offset_origin(self.position, self.error, self.geometric_normal, wi)
    }
}

impl Site for Receiver {
    fn trace(gathering: &Gathering, sites: &[(Self, Sampler)], cancel: &AtomicBool) -> Option<Arrivals> {
        let medium = gathering.view.medium;
        let begin = |site: &Self, sampler, settings: &_, taker: &mut Option<NoteTaker>| {
            site.begin(gathering, medium, sampler, settings, taker)
        };
        gathering.trace(sites, begin, cancel)
    }

    fn at(self, position: Vec3) -> Self {
        Self { position, ..self }
    }
}

/// A receiver in a medium of its own, whatever the medium around the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImmersedReceiver {
    /// The point.
    pub receiver: Receiver,
    /// The medium on the side that is lit; None in empty space.
    pub medium: Option<MediumId>,
}

impl ImmersedReceiver {
    /// The receiver in the medium in front of it, which is found from a point whose medium is known.
    pub fn seen_from(receiver: Receiver, scene: &RenderScene, from: Vec3, medium: Option<MediumId>) -> Self {
        let medium = match scene.media.is_empty() {
            true => None,
            false => medium_at(scene, from, medium, receiver.leave(receiver.geometric_normal)),
        };
        Self { receiver, medium }
    }
}

impl Site for ImmersedReceiver {
    fn trace(gathering: &Gathering, sites: &[(Self, Sampler)], cancel: &AtomicBool) -> Option<Arrivals> {
        let begin = |site: &Self, sampler, settings: &_, taker: &mut Option<NoteTaker>| {
            let Self { receiver, medium } = site;
            receiver.begin(gathering, *medium, sampler, settings, taker)
        };
        gathering.trace(sites, begin, cancel)
    }

    fn at(self, position: Vec3) -> Self {
        let receiver = self.receiver.at(position);
        Self { receiver, ..self }
    }
}

impl Receiver {
    /// A path that has left the place, which is in a medium. `taker` notes the light that is sampled there.
    fn begin(
        &self,
        gathering: &Gathering,
        medium: Option<MediumId>,
        sampler: Sampler,
        settings: &PathSettings,
        taker: &mut Option<NoteTaker>,
    ) -> PathState {
        let Gathering { scene, light, .. } = *gathering;
        let vertex = Vertex {
            receiver: self,
            light,
            reference: LightReference {
                position: self.position,
                normal: Some(self.normal),
            },
        };
        let local = warp::cosine_hemisphere(sampler.at_2d(BounceDraw::Direction.at(1)).to_array());
        let wi = Frame::from_normal(self.normal).to_world(local);
        let medium = medium.filter(|_| settings.media);
        let mut path = PathState::new(Ray::new(self.leave(wi), wi), sampler, medium);
        path.depth = 1;
        path.is_straight = false;
        path.sample_light(scene, settings, &vertex, taker);
        let cosine = self.cosine(wi);
        // What goes below the surface brings nothing.
        path.throughput = if cosine > 0.0 { Rgb::splat(PI) } else { Rgb::ZERO };
        path.arrival = Arrival {
            is_sampled: true,
            pdf: cosine * FRAC_1_PI,
            from: vertex.reference,
        };
        path
    }
}
