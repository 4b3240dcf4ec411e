//! The distributions of the normals of rough surfaces.
//!
//! Heitz, Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs, JCGT 2014. Masking is separable, G = G1(wo) G1(wi).

use super::{Beckmann, Ggx};
use glam::{Vec2, Vec3};

/// A family of distributions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum MicrofacetKind {
    /// The distribution has Gaussian slopes.
    #[default]
    Beckmann,
    /// The Trowbridge-Reitz distribution, with longer tails.
    Ggx,
}

/// A distribution of microfacet normals with its masking.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Microfacet {
    /// The distribution of Gaussian slopes.
    Beckmann(Beckmann),
    /// The Trowbridge-Reitz distribution, with longer tails.
    Ggx(Ggx),
}

impl Microfacet {
    /// Roughness along the two tangents, above 0; raised to 1e-4 where smaller.
    pub fn new(kind: MicrofacetKind, alpha_x: f32, alpha_y: f32) -> Self {
        match kind {
            MicrofacetKind::Beckmann => Self::Beckmann(Beckmann::new(alpha_x, alpha_y)),
            MicrofacetKind::Ggx => Self::Ggx(Ggx::new(alpha_x, alpha_y)),
        }
    }

    /// Density of microfacet area by normal `m` (unit, z > 0), per steradian and unit of surface.
    pub(crate) fn density(&self, m: Vec3) -> f32 {
        match self {
            Self::Beckmann(beckmann) => beckmann.density(m),
            Self::Ggx(ggx) => ggx.density(m),
        }
    }

    /// The Smith masking of `v`: the visible fraction of the microfacets that face it, in [0, 1].
    pub(crate) fn g1(&self, v: Vec3) -> f32 {
        match self {
            Self::Beckmann(beckmann) => beckmann.g1(v),
            Self::Ggx(ggx) => ggx.g1(v),
        }
    }

    /// The factor G1(v) / (4 |cos v|) of reflection, finite at grazing angles.
    pub(crate) fn g1_over_four_cos(&self, v: Vec3) -> f32 {
        match self {
            Self::Beckmann(beckmann) => beckmann.g1_over_four_cos(v),
            Self::Ggx(ggx) => ggx.g1_over_four_cos(v),
        }
    }

    /// The ratio of G1(v) to that with which visible normals are sampled: 1, except where the masking of the model is an approximation.
    pub(crate) fn masking_ratio(&self, v: Vec3) -> f32 {
        match self {
            Self::Beckmann(beckmann) => beckmann.masking_ratio(v),
            Self::Ggx(_) => 1.0,
        }
    }

    /// The density of [`Self::sample_visible`] over 4 wo.m, the Jacobian of reflection.
    pub(crate) fn reflected_density(&self, wo: Vec3, m: Vec3) -> f32 {
        self.density(m) * self.g1_over_four_cos(wo) / self.masking_ratio(wo)
    }

    /// A microfacet normal among those visible from `wo` (z > 0), with density G1(wo) D(m) max(0, wo.m) / cos wo for an exact G1.
    pub(crate) fn sample_visible(&self, wo: Vec3, u: Vec2) -> Vec3 {
        match self {
            Self::Beckmann(beckmann) => beckmann.sample_visible(wo, u),
            Self::Ggx(ggx) => ggx.sample_visible(wo, u),
        }
    }

    fn alpha(&self) -> [f32; 2] {
        match self {
            Self::Beckmann(beckmann) => beckmann.alpha(),
            Self::Ggx(ggx) => ggx.alpha(),
        }
    }

    /// Whether it is as rough along both tangents.
    pub fn is_isotropic(&self) -> bool {
        let [x, y] = self.alpha();
        x == y
    }

    /// One roughness for both directions: the root mean square.
    pub(crate) fn mean_alpha(&self) -> f32 {
        let [x, y] = self.alpha();
        (0.5 * (x * x + y * y)).sqrt()
    }
}
