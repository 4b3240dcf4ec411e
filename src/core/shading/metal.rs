//! The fuzzy metal of beginners' ray tracers, made fit for multiple importance sampling; black from behind.
//!
//! The direction is the mirror direction plus `fuzz` times a uniform point of the unit ball, normalised; below the
//! surface it is absorbed. The model is defined by this process (Shirley, Ray Tracing in One Weekend), not by a
//! reflectance formula: its BSDF is colour times the density of the direction over its cosine, which is not reciprocal.
//!
//! The density has a closed form. The point is uniform in a ball of radius f around the unit vector r; the density per
//! solid angle about w is the integral of t^2 dt along the chord of the ray t w, over the volume 4/3 pi f^3. With c =
//! w.r and the half chord s = sqrt(f^2 - sin^2) the chord is c - s to c + s, hence
//!
//!   p(w) = ((c + s)^3 - (c - s)^3) / (4 pi f^3) = s (3 c^2 + s^2) / (2 pi f^3),   where c > 0 and sin < f.

use std::f32::consts::TAU;

use super::{BsdfSample, Model, ShadingTables, TransportMode};
use crate::math::{Real, Vector, real_struct};
use crate::sampling::warp;

/// The least fuzz. Below it the density's `f^2 - sin^2` has too few digits left, and no image shows the difference to a
/// mirror.
const LEAST_FUZZ: f32 = 1e-4;

real_struct! {
    /// A coloured mirror with blur.
    pub struct Metal<R> {
        /// The reflected fraction of the power where nothing is absorbed, [0, 1].
        pub color: R::Vec3,
        /// The radius of the ball, [0, 1]; 0 is a mirror. Values outside are clamped.
        pub fuzz: R,
    }
}

impl<R: Real> Metal<R> {
    /// Whether it is a mirror, without a density.
    #[inline(always)]
    pub(super) fn is_delta(&self) -> R::Mask {
        self.fuzz.is_less(R::splat(LEAST_FUZZ))
    }

    #[inline(always)]
    fn radius(&self) -> R {
        self.fuzz.min(R::ONE)
    }

    #[inline(always)]
    fn pdf(&self, wo: R::Vec3, wi: R::Vec3) -> R {
        let (center, fuzz) = (wo.mirrored(), self.radius());
        let cos = center.dot(wi);
        // The cross product keeps the sine's digits for nearly equal directions.
        let half_chord_squared = fuzz * fuzz - center.cross(wi).length_squared();
        let pdf = half_chord_squared.sqrt() * (R::splat(3.0) * cos * cos + half_chord_squared)
            / (R::splat(TAU) * fuzz * fuzz * fuzz);
        let zero = R::ZERO;
        let is_there = wo.z().is_more(zero) & wi.z().is_more(zero) & cos.is_more(zero);
        pdf.only(is_there & half_chord_squared.is_more(zero) & !self.is_delta())
    }
}

impl<R: Real> Model<R> for Metal<R> {
    #[inline(always)]
    fn eval_and_pdf(&self, _: &ShadingTables, wo: R::Vec3, wi: R::Vec3, _: TransportMode) -> (R::Vec3, R) {
        let pdf = self.pdf(wo, wi);
        (self.color * pdf, pdf)
    }

    #[inline(always)]
    fn sample(&self, _: &ShadingTables, wo: R::Vec3, u_radius: R, u: [R; 2], _: TransportMode) -> BsdfSample<R> {
        let (center, is_delta) = (wo.mirrored(), self.is_delta());
        let sum = center + warp::unit_ball(u, u_radius) * self.radius();
        let length_squared = sum.length_squared();
        let fuzzy = sum * (R::ONE / length_squared.sqrt());
        // The density is zero below the surface (absorbed), and where rounding puts the direction on the rim of the
        // lobe.
        let pdf = self.pdf(wo, fuzzy).only(length_squared.is_more(R::ZERO));
        BsdfSample {
            wi: R::Vec3::select(is_delta, center, fuzzy),
            weight: self.color,
            pdf: R::select(is_delta, R::ONE, pdf),
            is_delta,
            eta: R::ONE,
            is_returned: wo.z().is_more(R::ZERO) & (is_delta | pdf.is_more(R::ZERO)),
        }
    }
}
