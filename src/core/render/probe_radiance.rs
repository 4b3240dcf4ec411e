//! Estimates the radiance that arrives at a point in space, as seen in a mirror there.
//!
//! A sample is a path that begins at the point, in a direction through a part of the surroundings. The point acts as a
//! mirror seen by a camera, so limits of depth count as in mirrors, and emitters that are hidden from cameras are
//! visible. Lights without extent are not.

use std::sync::atomic::AtomicBool;

use glam::Vec3;

use super::dimensions::BounceDraw;
use super::lanes;
use super::path_state::PathState;
use super::scene::RenderScene;
use super::view::View;
use crate::color::Rgb;
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

/// One of the samples of the radiance through a window.
#[derive(Clone, Copy, Debug)]
pub struct RadianceJob {
    /// The window.
    pub window: Window,
    /// The random numbers.
    pub sampler: Sampler,
}

/// One sample of the radiance through a window.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RadianceSample {
    /// The radiance, linear Rec. 709.
    pub radiance: Rgb,
    /// Whether the path first hits the back of a surface.
    pub meets_back: bool,
    /// Rays traced, shadow rays included.
    pub rays: u32,
}

/// Traces samples of radiance in the scene, with the settings and the medium of `view`; its camera is not used. The
/// samples are in the order of the jobs. None if `cancel` was set in the meantime.
pub fn trace_radiance(
    scene: &RenderScene,
    view: &View,
    jobs: &[RadianceJob],
    cancel: &AtomicBool,
) -> Option<Vec<RadianceSample>> {
    let settings = view.integrator.settings();
    if settings.is_last(1) {
        return Some(vec![RadianceSample::default(); jobs.len()]);
    }
    let medium = view.medium.filter(|_| settings.media);
    let begin = |RadianceJob { window, sampler }: &RadianceJob| {
        let at = sampler.at_2d(BounceDraw::Direction.at(1));
        let direction = (window.corner + at.x * window.across + at.y * window.down).normalize();
        let mut path = PathState::new(Ray::new(window.from, direction), *sampler, medium);
        path.depth = 1;
        path.is_straight = false;
        path
    };
    let begun: Vec<PathState> = jobs.iter().map(begin).collect();
    let ended = lanes::trace_begun(scene, view, &settings, &begun, cancel)?;
    let samples = ended.into_iter().map(|ended| RadianceSample {
        radiance: ended.radiance,
        meets_back: ended.meets_back,
        rays: ended.rays,
    });
    Some(samples.collect())
}
