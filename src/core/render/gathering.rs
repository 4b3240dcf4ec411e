//! What light is gathered from, and the places that it is gathered at.

use std::sync::atomic::AtomicBool;

use glam::Vec3;

use super::irradiance::ReceivedLight;
use super::lanes::trace_begun;
use super::layers::{LayerNotes, NoteTaker};
use super::path_state::PathState;
use super::scene::RenderScene;
use super::view::{PathSettings, View};
use crate::color::Rgb;
use crate::sampling::Sampler;

/// Everything that the light at a place depends on besides the place.
#[derive(Clone, Debug)]
pub struct Gathering<'a> {
    /// The scene that sends the light.
    pub scene: &'a RenderScene,
    /// The settings of paths, the medium that all surfaces are in, and the random numbers with their seed.
    pub view: &'a View,
    /// The light that counts at a side of a surface.
    pub light: ReceivedLight,
}

/// One sample of the light at a place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Arrived {
    /// Irradiance or radiance, linear Rec. 709.
    pub light: Rgb,
    /// Whether the path first meets the back of a surface.
    pub meets_back: bool,
    /// Rays traced, shadow rays included.
    pub rays: u32,
}

/// A sample of the light at each of some places.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Arrivals {
    /// The samples.
    pub samples: Vec<Arrived>,
    /// The light of each of the view's [light groups](View::light_groups), contiguous for each sample: the part of its
    /// light that they send. Empty without groups.
    pub groups: Vec<Rgb>,
}

/// A place that light is gathered at.
pub trait Site: Copy + Send + Sync {
    /// A sample for each of the sites with its random numbers, in their order. The camera of the view does not matter.
    /// None if `cancel` was set in the meantime.
    fn trace(gathering: &Gathering, sites: &[(Self, Sampler)], cancel: &AtomicBool) -> Option<Arrivals>;

    /// The same at another place beside it.
    fn at(self, place: Vec3) -> Self;
}

impl Gathering<'_> {
    /// [`Site::trace`] by the paths that begin at the sites.
    pub(super) fn trace<S>(
        &self,
        sites: &[(S, Sampler)],
        begin: impl Fn(&S, Sampler, &PathSettings, &mut Option<NoteTaker>) -> PathState,
        cancel: &AtomicBool,
    ) -> Option<Arrivals> {
        let settings = self.view.integrator.settings();
        let mut notes = LayerNotes::of_groups(&self.view.light_groups, sites.len());
        if settings.is_last(1) {
            return Some(Arrivals {
                samples: vec![Arrived::default(); sites.len()],
                groups: notes.map_or_else(Vec::new, LayerNotes::into_groups),
            });
        }
        let begin = |(number, (site, sampler)): (usize, &(S, Sampler))| {
            let mut taker = notes.as_mut().map(|notes| notes.of(number));
            begin(site, *sampler, &settings, &mut taker)
        };
        let begun: Vec<PathState> = sites.iter().enumerate().map(begin).collect();
        trace_begun(self.scene, self.view, &settings, &begun, notes, cancel)
    }
}
