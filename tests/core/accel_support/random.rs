//! Random numbers for tests.

use glam::Vec3;

/// A small generator for tests (PCG-RXS-M-XS 32).
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        let mut random = Self(seed);
        random.next_u32();
        random
    }

    pub fn next_u32(&mut self) -> u32 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        let word = ((self.0 >> ((self.0 >> 59) + 5)) ^ self.0).wrapping_mul(12605985483714917081);
        (word >> 43 ^ word) as u32
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f32 {
        (self.next_u32() >> 8) as f32 / (1 << 24) as f32
    }

    /// In [-1, 1)^3.
    pub fn in_cube(&mut self) -> Vec3 {
        2.0 * Vec3::new(self.unit(), self.unit(), self.unit()) - 1.0
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> Vec3 {
        let z = 2.0 * self.unit() - 1.0;
        let (sin, cos) = (std::f32::consts::TAU * self.unit()).sin_cos();
        let r = (1.0 - z * z).max(0.0).sqrt();
        Vec3::new(r * cos, r * sin, z)
    }
}
