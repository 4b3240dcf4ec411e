//! Estimates the radiance that arrives at a point in space, as seen in a mirror there.
//!
//! A sample is a path that begins at the point, in a direction through a part of the surroundings. The point acts as a
//! mirror seen by a camera, so limits of depth count as in mirrors, and emitters that are hidden from cameras are
//! visible. Lights without extent are not.

use std::sync::atomic::AtomicBool;

use glam::Vec3;

use super::dimensions::BounceDraw;
use super::gathering::{Arrivals, Gathering, Site};
use super::layers::NoteTaker;
use super::path_state::PathState;
use super::view::PathSettings;
use crate::math::Ray;
use crate::sampling::Sampler;

/// A part of the directions around a point: those through a parallelogram, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// The point.
    pub from: Vec3,
    /// A corner of the parallelogram relative to the point; of any length.
    pub corner: Vec3,
    /// The edge from there to the right.
    pub across: Vec3,
    /// The edge from there downwards.
    pub down: Vec3,
}

impl Window {
    /// The centre of the parallelogram relative to the point.
    pub fn middle(&self) -> Vec3 {
        self.corner + 0.5 * (self.across + self.down)
    }

    /// The solid angle in sr, of a small parallelogram.
    pub fn solid_angle(&self) -> f32 {
        let middle = self.middle();
        middle.dot(self.across.cross(self.down)).abs() / middle.length().powi(3)
    }
}

impl Site for Window {
    fn trace(gathering: &Gathering, sites: &[(Self, Sampler)], cancel: &AtomicBool) -> Option<Arrivals> {
        let begin = |window: &Self, sampler: Sampler, settings: &PathSettings, _: &mut Option<NoteTaker>| {
            let at = sampler.at_2d(BounceDraw::Direction.at(1));
            let direction = (window.corner + at.x * window.across + at.y * window.down).normalize();
            let medium = gathering.view.medium.filter(|_| settings.media);
            let mut path = PathState::new(Ray::new(window.from, direction), sampler, medium);
            path.depth = 1;
            path.is_straight = false;
            path
        };
        gathering.trace(sites, begin, cancel)
    }

    fn at(self, _: Vec3) -> Self {
        self
    }
}
