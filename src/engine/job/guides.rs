//! The guides of a job's paths.

use super::Job;
use crate::render::guide::Guide;
use crate::render::shutter::Shutter;

impl Job {
    /// Counts the rays by which guides were learnt since the last call, which may belong to another picture of the same
    /// scene. The rays of pilots are not among them.
    pub(super) fn count_rays_of_guides(&mut self) {
        let rays = self.guides().map(Guide::take_rays).sum::<u64>();
        self.rays += rays;
        self.guide_rays += rays;
    }

    /// The memory of the guides of the picture, in bytes.
    pub fn guide_bytes(&self) -> u64 {
        let mut guides: Vec<&Guide> = Vec::new();
        for guide in self.guides() {
            if !guides.iter().any(|known| known.is_same(guide)) {
                guides.push(guide);
            }
        }
        guides.into_iter().map(Guide::bytes).sum()
    }

    fn guides(&self) -> impl Iterator<Item = &Guide> {
        let of_moments = self.shutter.iter().flat_map(Shutter::guides);
        self.view.guide.iter().chain(of_moments)
    }
}
