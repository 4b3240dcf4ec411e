//! The GGX (Trowbridge-Reitz) distribution of microfacet normals, its Smith masking, and sampling of visible normals.
//!
//! Walter et al., Microfacet Models for Refraction through Rough Surfaces, EGSR 2007; Heitz, Understanding the Masking-Shadowing
//! Function, JCGT 2014. Masking is separable, G = G1(wo) G1(wi), as in the renderer whose scene format this program reads.

use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, TAU};

/// The least roughness. Below it a lobe is narrower than the rounding of its half vector.
pub(super) const SMOOTHEST_ALPHA: f32 = 1e-4;

/// Roughness along the two tangents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    alpha_x: f32,
    alpha_y: f32,
}

impl Ggx {
    /// Builds the distribution from root mean square slope scales, above 0; they are raised to 1e-4 if smaller.
    pub fn new(alpha_x: f32, alpha_y: f32) -> Self {
        Self {
            alpha_x: alpha_x.max(SMOOTHEST_ALPHA),
            alpha_y: alpha_y.max(SMOOTHEST_ALPHA),
        }
    }

    /// Roughness along the two tangents.
    pub fn alpha(&self) -> [f32; 2] {
        [self.alpha_x, self.alpha_y]
    }

    /// Density of microfacet area by normal `m` (unit, z > 0), per steradian and unit of surface.
    pub(crate) fn density(&self, m: Vec3) -> f32 {
        let stretched = Vec3::new(m.x / self.alpha_x, m.y / self.alpha_y, m.z).length_squared();
        FRAC_1_PI / (self.alpha_x * self.alpha_y * stretched * stretched)
    }

    /// The divisor of masking: |cos| of `v` plus the length of `v` in the configuration of unit roughness. Smith's G1 = 2 / (1 + sqrt(1 + alpha^2
    /// tan^2)) is 2 |cos| / reach, without a division by a grazing cosine.
    fn reach(&self, v: Vec3) -> f32 {
        v.z.abs() + Vec3::new(self.alpha_x * v.x, self.alpha_y * v.y, v.z).length()
    }

    /// The Smith masking of `v`: the visible fraction of the microfacets that face it, in [0, 1].
    pub(crate) fn g1(&self, v: Vec3) -> f32 {
        2.0 * v.z.abs() / self.reach(v)
    }

    /// The factor G1(v) / (4 |cos v|) of reflection, finite at grazing angles.
    pub(crate) fn g1_over_four_cos(&self, v: Vec3) -> f32 {
        0.5 / self.reach(v)
    }

    /// A microfacet normal among those visible from `wo` (z > 0), with density G1(wo) D(m) max(0, wo.m) / cos wo.
    ///
    /// By spherical caps: Dupuy and Benyoub, Sampling Visible GGX Normals with Spherical Caps, 2023.
    pub(crate) fn sample_visible(&self, wo: Vec3, u: Vec2) -> Vec3 {
        let alpha = Vec3::new(self.alpha_x, self.alpha_y, 1.0);
        let view = (alpha * wo).normalize();
        // In the configuration of unit roughness, reflections off a hemisphere fill the cap z > -view.z uniformly.
        let z = 1.0 - u.y * (1.0 + view.z);
        let radius = (1.0 - z * z).max(0.0).sqrt();
        let (sin, cos) = (TAU * u.x).sin_cos();
        // Rounding must not take it below the horizon.
        let half = Vec3::new(radius * cos + view.x, radius * sin + view.y, (z + view.z).max(0.0));
        // It vanishes for the lower rim of a grazing view only.
        (alpha * half).normalize_or(Vec3::Z)
    }
}
