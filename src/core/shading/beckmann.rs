//! Beckmann's distribution of microfacet normals, whose slopes are Gaussian: its Smith masking, and sampling of visible
//! normals.
//!
//! Walter et al., Microfacet Models for Refraction through Rough Surfaces, EGSR 2007. Masking is their rational
//! function, as in the renderer whose scene format this program reads; it is within 0.4 % of the exact one, with which
//! visible normals are sampled.
//!
//! At unit roughness, for a view with cosine c and sine s, visible slopes along its azimuth have the density (c - s x)+
//! exp(-x^2); across they are Gaussian (Heitz and d'Eon, Importance Sampling Microfacet-Based BSDFs using the
//! Distribution of Visible Normals, EGSR 2014). With b = erf(x) the cumulative distribution is H(b) / H(b_max), H = c
//! (1 + b) + s exp(-x^2) / sqrt(pi), which is concave: its slope c - s x falls from the left to 0 at x = c / s. It is
//! inverted in b (Jakob, An Improved Visible Normal Sampling Routine for the Beckmann Distribution, 2014), by Newton's
//! method within a bracket.

use std::f32::consts::{FRAC_1_PI, FRAC_2_SQRT_PI};

use super::ggx::SMOOTHEST_ALPHA;
use crate::math::{Mask, Real, Vector, erf, erf_inv, exp, ln, real_struct};

const FRAC_1_SQRT_PI: f32 = 0.5 * FRAC_2_SQRT_PI;

/// Keeps slopes finite: nearer to -1 or 1 the error function has no digits left.
const LARGEST_ERF: f32 = 1.0 - 2.0 * f32::EPSILON;

/// Three steps are usual; far in the tail, where rounding stops Newton's method, bisection finishes.
const MOST_STEPS: usize = 20;

real_struct! {
    /// Roughness along the two tangents.
    pub struct Beckmann<R> {
        alpha_x: R,
        alpha_y: R,
    }
}

impl<R: Real> Beckmann<R> {
    /// The roots of twice the mean squared slopes, above 0; raised to 1e-4 where smaller.
    #[inline(always)]
    pub fn new(alpha_x: R, alpha_y: R) -> Self {
        Self {
            alpha_x: alpha_x.max(R::splat(SMOOTHEST_ALPHA)),
            alpha_y: alpha_y.max(R::splat(SMOOTHEST_ALPHA)),
        }
    }

    /// Density of microfacet area by normal `m` (unit, z > 0), per steradian and unit of surface.
    #[inline(always)]
    pub(crate) fn density(&self, m: R::Vec3) -> R {
        let z2 = m.z() * m.z();
        let (x, y) = (m.x() / self.alpha_x, m.y() / self.alpha_y);
        let slope2 = x.mul_add(x, y * y) / z2;
        let density = R::splat(FRAC_1_PI) * exp(-slope2) / (self.alpha_x * self.alpha_y * z2 * z2);
        // Values below 1e-21 of the peak have no visible effect, and lose digits.
        density.only(slope2.is_at_most(R::splat(50.0)))
    }

    /// |cos v|, and the length of the tangential part at unit roughness, both up to a common factor.
    #[inline(always)]
    fn stretched(&self, v: R::Vec3) -> (R, R) {
        let (x, y) = (self.alpha_x * v.x(), self.alpha_y * v.y());
        (v.z().abs(), x.mul_add(x, y * y).sqrt())
    }

    /// Smith masking of `v`: the visible fraction of the microfacets that face it, in [0, 1].
    #[inline(always)]
    pub(crate) fn g1(&self, v: R::Vec3) -> R {
        let (cos, sin) = self.stretched(v);
        (cos + cos) / rational_reach(cos, sin)
    }

    /// G1(v) / (4 |cos v|), finite at grazing angles.
    #[inline(always)]
    pub(crate) fn g1_over_four_cos(&self, v: R::Vec3) -> R {
        let (cos, sin) = self.stretched(v);
        R::HALF / rational_reach(cos, sin)
    }

    /// G1 of [`Self::g1`] over the exact G1.
    #[inline(always)]
    pub(crate) fn masking_ratio(&self, v: R::Vec3) -> R {
        let (cos, sin) = self.stretched(v);
        reach(cos, sin) / rational_reach(cos, sin)
    }

    /// A microfacet normal among those visible from `wo` (z > 0), with density G1(wo) D(m) max(0, wo.m) / cos wo for
    /// the exact G1. It is undefined where `is_asked` is not set.
    #[inline(always)]
    pub(crate) fn sample_visible(&self, wo: R::Vec3, [u, v]: [R; 2], is_asked: R::Mask) -> R::Vec3 {
        let alpha = R::Vec3::of(self.alpha_x, self.alpha_y, R::ONE);
        let view = (alpha * wo).normalize();
        let sin = view.x().mul_add(view.x(), view.y() * view.y()).sqrt();
        let has_azimuth = sin.is_more(R::ZERO);
        let azimuth = [
            R::select(has_azimuth, view.x() / sin, R::ONE),
            (view.y() / sin).only(has_azimuth),
        ];
        let along = visible_slope(view.z(), sin, u, is_asked & wo.z().is_more(R::ZERO));
        let across = slope(v + v - R::ONE);
        let normal = R::Vec3::of(
            azimuth[1] * across - azimuth[0] * along,
            -(azimuth[1] * along + azimuth[0] * across),
            R::ONE,
        );
        (alpha * normal).normalize()
    }
}

/// |cos v| times 2 / G1(v), exactly: H(erf(c / s)).
#[inline(always)]
fn reach<R: Real>(cos: R, sin: R) -> R {
    let cot = cos / sin;
    cos * (R::ONE + erf(cot)) + R::splat(FRAC_1_SQRT_PI) * sin * exp(-cot * cot)
}

/// [`reach`] by the rational function.
#[inline(always)]
fn rational_reach<R: Real>(cos: R, sin: R) -> R {
    let (c, s) = (R::splat, sin);
    let above = s * s + c(2.276) * cos * s + c(2.577) * cos * cos;
    let below = c(3.535) * s + c(2.181) * cos;
    R::select(cos.is_less(c(1.6) * s), (above + above) / below, cos + cos)
}

/// Inverts H at the fraction `u` of its largest value.
#[inline(always)]
fn visible_slope<R: Real>(cos: R, sin: R, u: R, is_asked: R::Mask) -> R {
    let one = R::ONE;
    let largest = erf(cos / sin);
    let target = u * reach(cos, sin);
    // A concave function lies above its chord: the solution is to the left of that of the chord. The start is the
    // solution for a grazing view, stretched to the range.
    let (mut low, mut high) = (-one, u * (one + largest) - one);
    let mut b = (one + largest) * (one - erf((-ln(u)).max(R::ZERO).sqrt())) - one;
    let mut goes_on = is_asked;
    for _ in 0..MOST_STEPS {
        let x = slope(b);
        let excess = cos * (one + b) + R::splat(FRAC_1_SQRT_PI) * sin * exp(-x * x) - target;
        let is_beyond = excess.is_more(R::ZERO);
        high = R::select(is_beyond, b, high);
        low = R::select(is_beyond, low, b);
        let newton = b - excess / (cos - sin * x);
        let inside = newton.is_more(low) & newton.is_less(high);
        let next = R::select(inside, newton, R::HALF * (low + high));
        let step = (next - b).abs();
        b = R::select(goes_on, next, b);
        // Newton's step leaves an error of the order of its square.
        goes_on = goes_on & !(inside & step.is_at_most(R::splat(3e-4) * (one + b)));
        if !goes_on.any() {
            break;
        }
    }
    slope(b)
}

/// The x with erf(x) = `b`.
#[inline(always)]
fn slope<R: Real>(b: R) -> R {
    erf_inv(b.max(R::splat(-LARGEST_ERF)).min(R::splat(LARGEST_ERF)))
}
