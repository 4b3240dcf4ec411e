//! A job that is a share, that is saved, and that goes on where it was.

use std::io;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use super::error::BakeError;
use super::job::{BakeJob, Watch};
use super::lightmap::{Lightmaps, TexelSum};
use super::limits::BakeLimits;
use super::part::{PartHeader, PartLight, write_part};
use crate::memory;
use crate::render::passes::chunks_in;

impl BakeJob {
    /// Makes the job a share of these samples of each texel of a lightmap, and of as many times more for the points of
    /// volumes. A group of samples begins at the first one, see [`crate::render::passes::is_cut`]. Nothing is
    /// gathered yet.
    pub fn begin_share(&mut self, samples: [u32; 2]) -> Result<(), BakeError> {
        let [first, end] = samples;
        let texels_and_groups = self.blueprint.texel_counts().zip(0..).map(|(texels, number)| {
            let range = self.blueprint.samples_of(number, first)..self.blueprint.samples_of(number, end);
            let groups = if range.start == 0 { 1 } else { chunks_in(range) };
            (texels as u64, groups)
        });
        // One group is counted with the texel.
        let sums: u64 = texels_and_groups.map(|(texels, groups)| texels * (groups - 1)).sum();
        let memory = memory::reserve(sums * size_of::<TexelSum>() as u64);
        let begun = self.blueprint.texel_counts().zip(0..);
        let begun =
            begun.map(|(texels, number)| Lightmaps::beginning_at(self.blueprint.samples_of(number, first), texels));
        self.lights = begun.collect();
        self.memory.push(memory.map_err(BakeError::MemoryOfShare)?);
        Ok(())
    }

    /// Gathers all light up to this sample of each texel of a lightmap, and finishes nothing. False if it was
    /// cancelled.
    pub fn gather_share(&mut self, end: u32, cancel: &AtomicBool, watch: Watch) -> bool {
        (0..self.lights.len()).all(|number| {
            let end = self.blueprint.samples_of(number, end);
            self.gather(number, end, &BakeLimits::default(), cancel, watch)
        })
    }

    /// Goes on with the light of a file. The error says what differs; it does not name the file.
    pub fn take_up(&mut self, light: PartLight) -> Result<(), String> {
        let PartLight { lights, spent } = light;
        let counts = |lights: &[Lightmaps]| lights.iter().map(Lightmaps::texel_count).collect::<Vec<_>>();
        let (found, expected) = (counts(&lights), counts(&self.lights));
        if found != expected {
            return Err(format!(
                "its lightmaps and probes have {found:?} texels, and those of this bake have {expected:?}"
            ));
        }
        if lights
            .iter()
            .zip(&self.lights)
            .any(|(one, other)| one.first != other.first)
        {
            return Err("it is of other samples".to_owned());
        }
        (self.lights, self.spent) = (lights, spent);
        Ok(())
    }

    /// Writes the sums of all samples so far in one step: as a share, or as a checkpoint that this bake alone goes on
    /// with. `of` says what it is of; whether the file has all of that is found here.
    pub fn save(&self, path: &Path, of: &PartHeader) -> io::Result<()> {
        let ends = (0..self.lights.len()).map(|number| self.blueprint.samples_of(number, of.samples[1]));
        let header = PartHeader {
            is_finished: self.lights.iter().zip(ends).all(|(light, end)| light.reached() >= end),
            ..of.clone()
        };
        let blueprint = of.is_share.then_some(&self.blueprint);
        write_part(path, &header, blueprint, &self.lights, &self.spent)
    }
}
