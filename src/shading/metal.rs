//! The fuzzy metal of beginners' ray tracers, made fit for multiple importance sampling; black from behind.
//!
//! The direction is the mirror direction plus `fuzz` times a uniform point of the unit ball, normalised; below the surface it is
//! absorbed. The model is defined by this process (Shirley, Ray Tracing in One Weekend), not by a reflectance formula: its BSDF is
//! colour times the density of the direction over its cosine, which is not reciprocal.
//!
//! The density has a closed form. The point is uniform in a ball of radius f around the unit vector r; per solid angle about w that
//! leaves the integral of t^2 dt along the chord of the ray t w, over the volume 4/3 pi f^3. With c = w.r and the half chord
//! s = sqrt(f^2 - sin^2) the chord is c - s to c + s, hence
//!
//!   p(w) = ((c + s)^3 - (c - s)^3) / (4 pi f^3) = s (3 c^2 + s^2) / (2 pi f^3),   where c > 0 and sin < f.

use super::{BsdfSample, mirrored};
use crate::{color::Rgb, sampling::warp};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;

/// The least fuzz. Below it the density's `f^2 - sin^2` has too few digits left, and no picture shows the difference to a mirror.
const LEAST_FUZZ: f32 = 1e-4;

/// A coloured mirror with a blur.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metal {
    /// The reflected fraction of the power where nothing is absorbed, [0, 1].
    pub color: Rgb,
    /// The radius of the ball, [0, 1]; 0 is a mirror. Values outside are clamped.
    pub fuzz: f32,
}

impl Metal {
    /// Whether it is a mirror, without a density.
    pub(super) fn is_delta(&self) -> bool {
        self.fuzz < LEAST_FUZZ
    }

    fn radius(&self) -> f32 {
        self.fuzz.min(1.0)
    }

    pub(super) fn eval_and_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        let pdf = self.pdf(wo, wi);
        (self.color * pdf, pdf)
    }

    fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if self.is_delta() || wo.z <= 0.0 || wi.z <= 0.0 {
            return 0.0;
        }
        let (center, fuzz) = (mirrored(wo), self.radius());
        let cos = center.dot(wi);
        // The cross product keeps the sine's digits for nearly equal directions.
        let half_chord_squared = fuzz * fuzz - center.cross(wi).length_squared();
        if cos <= 0.0 || half_chord_squared <= 0.0 {
            return 0.0;
        }
        half_chord_squared.sqrt() * (3.0 * cos * cos + half_chord_squared) / (TAU * fuzz * fuzz * fuzz)
    }

    pub(super) fn sample(&self, wo: Vec3, u_radius: f32, u: Vec2) -> Option<BsdfSample> {
        if wo.z <= 0.0 {
            return None;
        }
        let center = mirrored(wo);
        if self.is_delta() {
            return Some(BsdfSample {
                wi: center,
                weight: self.color,
                pdf: 1.0,
                is_delta: true,
                eta: 1.0,
            });
        }
        let wi = (center + self.radius() * warp::unit_ball(u, u_radius)).try_normalize()?;
        // The density is zero below the surface (absorbed), and where rounding has put the direction on the rim of the lobe.
        let pdf = self.pdf(wo, wi);
        (pdf > 0.0).then_some(BsdfSample {
            wi,
            weight: self.color,
            pdf,
            is_delta: false,
            eta: 1.0,
        })
    }
}
