//! Notes along the paths of samples, from which the film's layers are computed. They are recorded by an observer for
//! paths traced one by one, and directly for paths in lanes.

use crate::accel::Hit;
use crate::color::Rgb;
use crate::light::LightId;
use crate::material::Lobe;
use crate::math::Ray;
use crate::render::light_layers::LightGroups;
use crate::render::observer::{Bounce, Glow, Joined, MetEmitter, PathObserver, SampledLight};
use crate::render::view::View;

/// The notes of some samples.
pub(in crate::render) struct LayerNotes<'v> {
    light_groups: &'v LightGroups,
    samples: Vec<SampleNotes>,
    /// The light of each group, contiguous for each sample.
    groups: Vec<Rgb>,
}

/// The notes of one sample.
#[derive(Clone, Copy, Default)]
pub(super) struct SampleNotes {
    /// The first surface that does not let the camera ray pass straight on, as the hit of a ray; None before one is
    /// hit.
    pub surface: Option<(Ray, Hit)>,
    /// The distance from the first surface to that one.
    pub beyond: f32,
    /// The number of surfaces that have scattered the path so far, without those passed straight.
    scatterings: u32,
    has_passed: bool,
    /// The light that reaches the camera unscattered, scattered once, and more often.
    pub light: [Rgb; 3],
}

/// Records the notes of one sample.
pub(in crate::render) struct NoteTaker<'a> {
    light_groups: &'a LightGroups,
    sample: &'a mut SampleNotes,
    groups: &'a mut [Rgb],
}

impl<'v> LayerNotes<'v> {
    /// Empty notes of `samples` samples; None if no layer of the view needs them.
    pub fn new(view: &'v View, samples: usize) -> Option<Self> {
        view.film_layers()
            .are_noted()
            .then(|| Self::empty(&view.light_groups, samples))
    }

    /// Empty notes of `samples` samples, for the light of groups alone; None without groups.
    pub fn of_groups(light_groups: &'v LightGroups, samples: usize) -> Option<Self> {
        (light_groups.count() > 0).then(|| Self::empty(light_groups, samples))
    }

    fn empty(light_groups: &'v LightGroups, samples: usize) -> Self {
        Self {
            light_groups,
            samples: vec![SampleNotes::default(); samples],
            groups: vec![Rgb::ZERO; samples * light_groups.count()],
        }
    }

    /// The light of each group, contiguous for each sample.
    pub fn into_groups(self) -> Vec<Rgb> {
        self.groups
    }

    /// Clears all notes.
    pub fn clear(&mut self) {
        self.samples.fill(SampleNotes::default());
        self.groups.fill(Rgb::ZERO);
    }

    /// The recorder for the sample with this number.
    pub fn of(&mut self, sample: usize) -> NoteTaker<'_> {
        let groups = self.light_groups.count();
        NoteTaker {
            light_groups: self.light_groups,
            sample: &mut self.samples[sample],
            groups: &mut self.groups[sample * groups..][..groups],
        }
    }

    /// The notes of the sample with this number, with the light of each group.
    pub(super) fn get(&self, sample: usize) -> (&SampleNotes, &[Rgb]) {
        let groups = self.light_groups.count();
        (&self.samples[sample], &self.groups[sample * groups..][..groups])
    }
}

impl NoteTaker<'_> {
    /// Adds light that the path has found, which `scatterings` surfaces have scattered.
    fn add(&mut self, light: LightId, contribution: Rgb, scatterings: u32) {
        self.sample.light[scatterings.min(2) as usize] += contribution;
        if let Some(group) = self.light_groups.group(light) {
            self.groups[group] += contribution;
        }
    }

    /// Adds the light of a lamp that was sampled from the last vertex.
    pub fn add_sampled(&mut self, light: LightId, contribution: Rgb) {
        self.add(light, contribution, self.sample.scatterings + 1);
    }

    /// Counts a scattering by a surface.
    pub fn add_scattering(&mut self) {
        self.sample.scatterings += 1;
    }
}

impl PathObserver for NoteTaker<'_> {
    fn met(&mut self, ray: &Ray, hit: &Hit) {
        if self.sample.scatterings == 0 {
            if self.sample.has_passed {
                self.sample.beyond += hit.t;
            }
            self.sample.surface = Some((*ray, *hit));
        }
    }

    fn emitted(&mut self, glow: &Glow) {
        self.sample.light[self.sample.scatterings.min(2) as usize] += glow.contribution;
    }

    fn emitter_met(&mut self, met: &MetEmitter) {
        self.add(met.light, met.contribution, self.sample.scatterings);
    }

    fn light_sampled(&mut self, sampled: &SampledLight) {
        self.add_sampled(sampled.light, sampled.contribution);
    }

    fn joined(&mut self, joined: &Joined) {
        // Both joined vertices scatter it.
        self.add(joined.light, joined.contribution, self.sample.scatterings + 2);
    }

    fn bounced(&mut self, bounce: &Bounce) {
        if bounce.lobe != Lobe::Null {
            self.add_scattering();
        } else if self.sample.scatterings == 0 {
            self.sample.has_passed = true;
            self.sample.surface = None;
        }
    }
}
