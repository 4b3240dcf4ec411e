//! The GGX (Trowbridge-Reitz) distribution of microfacet normals, its Smith masking, and sampling of visible normals.
//!
//! Walter et al., Microfacet Models for Refraction through Rough Surfaces, EGSR 2007; Heitz, Understanding the
//! Masking-Shadowing Function, JCGT 2014. Masking is separable, G = G1(wo) G1(wi), as in the renderer whose scene
//! format this program reads.

use std::f32::consts::{FRAC_1_PI, TAU};

use crate::math::{Real, Vector, real_struct, sin_cos};

/// The least roughness. Below it a lobe is narrower than the rounding of its half vector.
pub(super) const SMOOTHEST_ALPHA: f32 = 1e-4;

real_struct! {
    /// Roughness along the two tangents.
    pub struct Ggx<R> {
        alpha_x: R,
        alpha_y: R,
    }
}

impl<R: Real> Ggx<R> {
    /// Builds the distribution from root mean square slope scales, above 0; they are raised to 1e-4 if smaller.
    #[inline(always)]
    pub fn new(alpha_x: R, alpha_y: R) -> Self {
        Self {
            alpha_x: alpha_x.max(R::splat(SMOOTHEST_ALPHA)),
            alpha_y: alpha_y.max(R::splat(SMOOTHEST_ALPHA)),
        }
    }

    /// This distribution where `condition` holds, else `other`.
    #[inline(always)]
    pub(super) fn or(self, condition: R::Mask, other: Self) -> Self {
        Self {
            alpha_x: R::select(condition, self.alpha_x, other.alpha_x),
            alpha_y: R::select(condition, self.alpha_y, other.alpha_y),
        }
    }

    /// Density of microfacet area by normal `m` (unit, z > 0), per steradian and unit of surface.
    #[inline(always)]
    pub(crate) fn density(&self, m: R::Vec3) -> R {
        let stretched = R::Vec3::of(m.x() / self.alpha_x, m.y() / self.alpha_y, m.z()).length_squared();
        R::splat(FRAC_1_PI) / (self.alpha_x * self.alpha_y * stretched * stretched)
    }

    /// The divisor of masking: |cos| of `v` plus the length of `v` in the configuration of unit roughness. Smith's G1 =
    /// 2 / (1 + sqrt(1 + alpha^2 tan^2)) is 2 |cos| / reach, without a division by a grazing cosine.
    #[inline(always)]
    fn reach(&self, v: R::Vec3) -> R {
        v.z().abs()
            + R::Vec3::of(self.alpha_x * v.x(), self.alpha_y * v.y(), v.z())
                .length_squared()
                .sqrt()
    }

    /// The Smith masking of `v`: the visible fraction of the microfacets that face it, in [0, 1].
    #[inline(always)]
    pub(crate) fn g1(&self, v: R::Vec3) -> R {
        let cos = v.z().abs();
        (cos + cos) / self.reach(v)
    }

    /// The factor G1(v) / (4 |cos v|) of reflection, finite at grazing angles.
    #[inline(always)]
    pub(crate) fn g1_over_four_cos(&self, v: R::Vec3) -> R {
        R::HALF / self.reach(v)
    }

    /// A microfacet normal among those visible from `wo` (z > 0), with density G1(wo) D(m) max(0, wo.m) / cos wo.
    ///
    /// By spherical caps: Dupuy and Benyoub, Sampling Visible GGX Normals with Spherical Caps, 2023.
    #[inline(always)]
    pub(crate) fn sample_visible(&self, wo: R::Vec3, [u, v]: [R; 2]) -> R::Vec3 {
        let alpha = R::Vec3::of(self.alpha_x, self.alpha_y, R::ONE);
        let view = (alpha * wo).normalize();
        // In the configuration of unit roughness, reflections off a hemisphere fill the cap z > -view.z uniformly.
        let z = (-v).mul_add(R::ONE + view.z(), R::ONE);
        let radius = (-z).mul_add(z, R::ONE).max(R::ZERO).sqrt();
        let (sin, cos) = sin_cos(R::splat(TAU) * u);
        // Rounding must not put it below the horizon.
        let half = alpha
            * R::Vec3::of(
                radius.mul_add(cos, view.x()),
                radius.mul_add(sin, view.y()),
                (z + view.z()).max(R::ZERO),
            );
        // It vanishes only for the lower rim of a grazing view.
        unit_or_up::<R>(half)
    }
}

/// The vector scaled to unit length; the z axis where it has no direction.
#[inline(always)]
fn unit_or_up<R: Real>(v: R::Vec3) -> R::Vec3 {
    let length_squared = v.length_squared();
    let up = R::Vec3::of(R::ZERO, R::ZERO, R::ONE);
    R::Vec3::select(
        length_squared.is_more(R::ZERO),
        v * (R::ONE / length_squared.sqrt()),
        up,
    )
}
