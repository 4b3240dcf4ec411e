//! The same radiance from all directions.

use glam::{Vec2, Vec3};

use super::{LightReference, LightSample, Target};
use crate::color::Rgb;
use crate::math::Frame;
use crate::sampling::warp;

#[derive(Clone, Copy, Debug)]
pub(super) struct ConstantLight {
    pub radiance: Rgb,
}

impl ConstantLight {
    /// Samples a direction: by the cosine with the normal if there is one, for the light itself prefers no direction; otherwise uniformly.
    pub fn sample(&self, reference: &LightReference, u: Vec2) -> Option<LightSample> {
        let wi = match reference.normal {
            Some(normal) => Frame::from_normal(normal).to_world(warp::cosine_hemisphere(u.to_array())),
            None => warp::uniform_sphere(u.to_array()),
        };
        let pdf = self.pdf(reference, wi);
        (pdf > 0.0).then_some(LightSample {
            wi,
            target: Target::Infinity,
            radiance: self.radiance,
            pdf,
            is_delta: false,
        })
    }

    /// Density per solid angle of [`Self::sample`].
    pub fn pdf(&self, reference: &LightReference, wi: Vec3) -> f32 {
        match reference.normal {
            Some(normal) => warp::cosine_hemisphere_pdf(normal.dot(wi)),
            None => warp::UNIFORM_SPHERE_PDF,
        }
    }
}
