//! Beckmann's distribution of microfacet normals, whose slopes are Gaussian: its Smith masking, and sampling of visible normals.
//!
//! Walter et al., Microfacet Models for Refraction through Rough Surfaces, EGSR 2007. Masking is their rational function, as in the
//! renderer whose scene format this program reads; it is within 0.4 % of the exact one, with which visible normals are sampled.
//!
//! At unit roughness, for a view with cosine c and sine s, visible slopes along its azimuth have the density (c - s x)+ exp(-x^2);
//! across they are Gaussian (Heitz and d'Eon, Importance Sampling Microfacet-Based BSDFs using the Distribution of Visible Normals,
//! EGSR 2014). With b = erf(x) the cumulative distribution is H(b) / H(b_max), H = c (1 + b) + s exp(-x^2) / sqrt(pi), which is
//! concave: its slope c - s x falls from the left to 0 at x = c / s. It is inverted in b (Jakob, An Improved Visible Normal Sampling
//! Routine for the Beckmann Distribution, 2014), by Newton's method within a bracket.

use super::ggx::SMOOTHEST_ALPHA;
use crate::math::{erf, erf_inv};
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_1_PI, FRAC_2_SQRT_PI};

const FRAC_1_SQRT_PI: f32 = 0.5 * FRAC_2_SQRT_PI;

/// Keeps slopes finite: nearer to -1 or 1 the error function has no digits left.
const LARGEST_ERF: f32 = 1.0 - 2.0 * f32::EPSILON;

/// Three steps are usual; where rounding leaves Newton nowhere to go, far in the tail, bisection ends.
const MOST_STEPS: usize = 20;

/// Roughness along the two tangents.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beckmann {
    alpha_x: f32,
    alpha_y: f32,
}

impl Beckmann {
    /// The roots of twice the mean squared slopes, above 0; raised to 1e-4 where smaller.
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
        let z2 = m.z * m.z;
        let slope2 = Vec2::new(m.x / self.alpha_x, m.y / self.alpha_y).length_squared() / z2;
        // Values below 1e-21 of the peak have no visible effect, and lose digits.
        if slope2 > 50.0 {
            return 0.0;
        }
        FRAC_1_PI * (-slope2).exp() / (self.alpha_x * self.alpha_y * z2 * z2)
    }

    /// |cos v|, and the length of the tangential part at unit roughness, both but for a common factor.
    fn stretched(&self, v: Vec3) -> (f32, f32) {
        (v.z.abs(), Vec2::new(self.alpha_x * v.x, self.alpha_y * v.y).length())
    }

    /// Smith masking of `v`: the visible fraction of the microfacets that face it, in [0, 1].
    pub(crate) fn g1(&self, v: Vec3) -> f32 {
        let (cos, sin) = self.stretched(v);
        2.0 * cos / rational_reach(cos, sin)
    }

    /// G1(v) / (4 |cos v|), finite at grazing angles.
    pub(crate) fn g1_over_four_cos(&self, v: Vec3) -> f32 {
        let (cos, sin) = self.stretched(v);
        0.5 / rational_reach(cos, sin)
    }

    /// The G1 of [`Self::g1`] over the exact one.
    pub(crate) fn masking_ratio(&self, v: Vec3) -> f32 {
        let (cos, sin) = self.stretched(v);
        reach(cos, sin) / rational_reach(cos, sin)
    }

    /// A microfacet normal among those visible from `wo` (z > 0), with density G1(wo) D(m) max(0, wo.m) / cos wo, G1 being exact.
    pub(crate) fn sample_visible(&self, wo: Vec3, u: Vec2) -> Vec3 {
        let alpha = Vec3::new(self.alpha_x, self.alpha_y, 1.0);
        let view = (alpha * wo).normalize();
        let sin = view.truncate().length();
        let azimuth = view.truncate().normalize_or(Vec2::X);
        let along = visible_slope(view.z, sin, u.x);
        let across = slope(2.0 * u.y - 1.0);
        let normal = -(azimuth * along + azimuth.perp() * across);
        (alpha * normal.extend(1.0)).normalize()
    }
}

/// |cos v| times 2 / G1(v), exactly: H(erf(c / s)).
fn reach(cos: f32, sin: f32) -> f32 {
    let cot = cos / sin;
    cos * (1.0 + erf(cot)) + FRAC_1_SQRT_PI * sin * (-cot * cot).exp()
}

/// The result of [`reach`] by the rational function.
fn rational_reach(cos: f32, sin: f32) -> f32 {
    if cos >= 1.6 * sin {
        return 2.0 * cos;
    }
    2.0 * (sin * sin + 2.276 * cos * sin + 2.577 * cos * cos) / (3.535 * sin + 2.181 * cos)
}

/// Inverts H at the share `u` of its largest value.
fn visible_slope(cos: f32, sin: f32, u: f32) -> f32 {
    let largest = erf(cos / sin);
    let target = u * reach(cos, sin);
    // A concave function lies above its chord: the solution is to the left of that of the chord. The start is the solution for a
    // grazing view, stretched to the range.
    let (mut low, mut high) = (-1.0, u * (1.0 + largest) - 1.0);
    let mut b = (1.0 + largest) * (1.0 - erf((-u.ln()).sqrt())) - 1.0;
    for _ in 0..MOST_STEPS {
        let x = slope(b);
        let excess = cos * (1.0 + b) + FRAC_1_SQRT_PI * sin * (-x * x).exp() - target;
        if excess > 0.0 {
            high = b;
        } else {
            low = b;
        }
        let newton = b - excess / (cos - sin * x);
        let inside = newton > low && newton < high;
        let next = if inside { newton } else { 0.5 * (low + high) };
        let step = (next - b).abs();
        b = next;
        // The error that remains after Newton's step is of the order of its square.
        if inside && step <= 3e-4 * (1.0 + b) {
            break;
        }
    }
    slope(b)
}

/// The x with erf(x) = `b`.
fn slope(b: f32) -> f32 {
    erf_inv(b.clamp(-LARGEST_ERF, LARGEST_ERF))
}
