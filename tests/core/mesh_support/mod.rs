//! What tests of mesh readers have in common.

pub use crate::fuzz_corpus::entries::meshes::assert_sound;
pub use crate::split_mix::Random;

impl Random {
    /// From -8 to about 8.8.
    pub fn float(&mut self) -> f32 {
        (self.next() >> 40) as f32 / 1e6 - 8.0
    }
}
