//! The ids in a pixel, from which a cryptomatte is made.

use bytemuck::{Pod, Zeroable};

/// The number of ids that a pixel remembers. Those that come when all places are taken are left out while they have
/// fewer samples.
const PLACES: usize = 8;

/// The ids in one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Matte([MatteEntry; PLACES]);

/// An id, and the number of samples that met it; the place is free if there are none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct MatteEntry {
    /// The instance or the material.
    pub id: u32,
    /// The number of samples.
    pub samples: u32,
}

impl Matte {
    /// Counts a sample.
    pub(super) fn add(&mut self, id: u32) {
        self.add_entry(MatteEntry { id, samples: 1 });
    }

    /// Adds the samples of another range for the same pixel.
    pub(in crate::render) fn merge(&mut self, other: &Self) {
        other.entries().for_each(|entry| self.add_entry(entry));
    }

    pub(in crate::render) fn add_entry(&mut self, new: MatteEntry) {
        for place in &mut self.0 {
            if place.samples == 0 {
                *place = new;
                return;
            }
            if place.id == new.id {
                place.samples = place.samples.saturating_add(new.samples);
                return;
            }
        }
        if let Some(least) = self.0.iter_mut().min_by_key(|entry| entry.samples)
            && least.samples < new.samples
        {
            *least = new;
        }
    }

    /// The ids with their samples.
    pub fn entries(&self) -> impl Iterator<Item = MatteEntry> {
        self.0.iter().copied().take_while(|entry| entry.samples > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pixel_keeps_what_covers_most() {
        let mut matte = Matte::default();
        for id in 0..PLACES as u32 + 1 {
            matte.add(id);
        }
        assert_eq!(matte.entries().count(), PLACES, "the last one finds no place");
        let mut many = Matte::default();
        (0..3).for_each(|_| many.add(100));
        matte.add(0);
        matte.merge(&many);
        let samples = |matte: &Matte, id| matte.entries().find(|entry| entry.id == id).map(|entry| entry.samples);
        assert_eq!((samples(&matte, 100), samples(&matte, 0)), (Some(3), Some(2)));
        matte.merge(&many);
        assert_eq!(samples(&matte, 100), Some(6));
    }
}
