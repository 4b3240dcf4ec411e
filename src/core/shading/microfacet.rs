//! The distributions of the normals of rough surfaces.
//!
//! Heitz, Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs, JCGT 2014. Masking is separable, G =
//! G1(wo) G1(wi).

use super::ggx::SMOOTHEST_ALPHA;
use super::{Beckmann, Ggx};
use crate::math::{Mask, Real, Vector, real_struct};

/// A family of distributions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum MicrofacetKind {
    /// The distribution has Gaussian slopes.
    #[default]
    Beckmann,
    /// The Trowbridge-Reitz distribution, with longer tails.
    Ggx,
}

real_struct! {
    /// A distribution of microfacet normals with its masking.
    pub struct Microfacet<R> {
        alpha_x: R,
        alpha_y: R,
        /// Whether the distribution is Beckmann's rather than GGX.
        is_beckmann: R::Mask,
    }
}

impl Microfacet {
    /// Roughness along the two tangents, above 0; raised to 1e-4 where smaller.
    pub fn new(kind: MicrofacetKind, alpha_x: f32, alpha_y: f32) -> Self {
        Self::with(kind == MicrofacetKind::Beckmann, alpha_x, alpha_y)
    }

    /// Whether the roughness is equal along both tangents.
    pub fn is_isotropic(&self) -> bool {
        self.alpha_x == self.alpha_y
    }

    /// The root mean square of both roughnesses.
    pub(crate) fn mean_alpha(&self) -> f32 {
        (0.5 * (self.alpha_x * self.alpha_x + self.alpha_y * self.alpha_y)).sqrt()
    }
}

impl<R: Real> Microfacet<R> {
    #[inline(always)]
    pub(super) fn with(is_beckmann: R::Mask, alpha_x: R, alpha_y: R) -> Self {
        Self {
            alpha_x: alpha_x.max(R::splat(SMOOTHEST_ALPHA)),
            alpha_y: alpha_y.max(R::splat(SMOOTHEST_ALPHA)),
            is_beckmann,
        }
    }

    /// The result of `ggx`, or that of `beckmann` where the distribution is Beckmann's.
    #[inline(always)]
    fn choose(&self, ggx: impl FnOnce(Ggx<R>) -> R, beckmann: impl FnOnce(Beckmann<R>) -> R) -> R {
        let of_ggx = ggx(Ggx::new(self.alpha_x, self.alpha_y));
        if !self.is_beckmann.any() {
            return of_ggx;
        }
        R::select(
            self.is_beckmann,
            beckmann(Beckmann::new(self.alpha_x, self.alpha_y)),
            of_ggx,
        )
    }

    /// Density of microfacet area by normal `m` (unit, z > 0), per steradian and unit of surface.
    #[inline(always)]
    pub(crate) fn density(&self, m: R::Vec3) -> R {
        self.choose(|ggx| ggx.density(m), |beckmann| beckmann.density(m))
    }

    /// The Smith masking of `v`: the visible fraction of the microfacets that face it, in [0, 1].
    #[inline(always)]
    pub(crate) fn g1(&self, v: R::Vec3) -> R {
        self.choose(|ggx| ggx.g1(v), |beckmann| beckmann.g1(v))
    }

    /// The factor G1(v) / (4 |cos v|) of reflection, finite at grazing angles.
    #[inline(always)]
    pub(crate) fn g1_over_four_cos(&self, v: R::Vec3) -> R {
        self.choose(|ggx| ggx.g1_over_four_cos(v), |beckmann| beckmann.g1_over_four_cos(v))
    }

    /// The ratio of G1(v) to the G1 of sampled visible normals: 1, except where the model's masking is an
    /// approximation.
    #[inline(always)]
    pub(crate) fn masking_ratio(&self, v: R::Vec3) -> R {
        self.choose(|_| R::ONE, |beckmann| beckmann.masking_ratio(v))
    }

    /// The density of [`Self::sample_visible`] over 4 wo.m, the Jacobian of reflection.
    #[inline(always)]
    pub(crate) fn reflected_density(&self, wo: R::Vec3, m: R::Vec3) -> R {
        self.density(m) * self.g1_over_four_cos(wo) / self.masking_ratio(wo)
    }

    /// A microfacet normal among those visible from `wo` (z > 0), with density G1(wo) D(m) max(0, wo.m) / cos wo for an
    /// exact G1.
    #[inline(always)]
    pub(crate) fn sample_visible(&self, wo: R::Vec3, u: [R; 2]) -> R::Vec3 {
        let of_ggx = Ggx::new(self.alpha_x, self.alpha_y).sample_visible(wo, u);
        if !self.is_beckmann.any() {
            return of_ggx;
        }
        let of_beckmann = Beckmann::new(self.alpha_x, self.alpha_y).sample_visible(wo, u, self.is_beckmann);
        R::Vec3::select(self.is_beckmann, of_beckmann, of_ggx)
    }
}
