//! Lambert's ideally diffuse reflection; black from behind.

use super::BsdfSample;
use crate::{color::Rgb, sampling::warp};
use glam::{Vec2, Vec3};

/// A surface that looks equally bright from everywhere above it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Diffuse {
    /// Reflected fraction of the power, [0, 1].
    pub reflectance: Rgb,
}

impl Diffuse {
    pub(super) fn eval_and_pdf(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        let pdf = if wo.z > 0.0 {
            warp::cosine_hemisphere_pdf(wi.z)
        } else {
            0.0
        };
        (self.reflectance * pdf, pdf)
    }

    pub(super) fn sample(&self, wo: Vec3, u: Vec2) -> Option<BsdfSample> {
        let wi = warp::cosine_hemisphere(u);
        let (_, pdf) = self.eval_and_pdf(wo, wi);
        (pdf > 0.0).then_some(BsdfSample {
            wi,
            weight: self.reflectance,
            pdf,
            is_delta: false,
            eta: 1.0,
        })
    }
}
