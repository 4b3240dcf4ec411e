//! Lambert's ideally diffuse reflection; black from behind.

use super::BsdfSample;
use crate::{color::Rgb, sampling::warp};
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// A surface that looks equally bright from everywhere above it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Diffuse {
    /// Reflected fraction of the power, [0, 1].
    pub reflectance: Rgb,
}

impl Diffuse {
    pub(super) fn eval(&self, wo: Vec3, wi: Vec3) -> Rgb {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return Rgb::ZERO;
        }
        self.reflectance * (FRAC_1_PI * wi.z)
    }

    pub(super) fn pdf(&self, wo: Vec3, wi: Vec3) -> f32 {
        if wo.z <= 0.0 {
            0.0
        } else {
            warp::cosine_hemisphere_pdf(wi.z)
        }
    }

    pub(super) fn sample(&self, wo: Vec3, u: Vec2) -> Option<BsdfSample> {
        let wi = warp::cosine_hemisphere(u);
        let pdf = self.pdf(wo, wi);
        (pdf > 0.0).then_some(BsdfSample {
            wi,
            weight: self.reflectance,
            pdf,
            is_delta: false,
            eta: 1.0,
        })
    }
}
