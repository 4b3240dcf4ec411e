//! A point that sends the same intensity in all directions.

use glam::{Vec2, Vec3};

use super::bounds::{LightBounds, NormalCone};
use super::emission::Beam;
use super::{LightSample, Target};
use crate::color::{Rgb, luminance};
use crate::math::Aabb;
use crate::sampling::warp;

#[derive(Clone, Copy, Debug)]
pub(super) struct PointLight {
    pub position: Vec3,
    /// The radiant intensity, in W/sr.
    pub intensity: Rgb,
}

impl PointLight {
    pub fn bounds(&self) -> LightBounds {
        LightBounds {
            bounds: Aabb::from_points([self.position]),
            cone: NormalCone::ALL,
            cos_emission: 0.0,
            intensity: luminance(self.intensity),
        }
    }

    /// Samples the light; None at its very place.
    pub fn sample(&self, reference: Vec3) -> Option<LightSample> {
        let to_light = self.position - reference;
        Some(LightSample {
            wi: to_light.try_normalize()?,
            target: Target::Point(self.position),
            radiance: self.intensity / to_light.length_squared(),
            pdf: 1.0,
            is_delta: true,
        })
    }

    /// A direction in which it shines, uniform over all.
    pub fn sample_beam(&self, u: Vec2) -> Beam {
        Beam {
            dir: warp::uniform_sphere(u),
            intensity: self.intensity,
            pdf_solid_angle: warp::UNIFORM_SPHERE_PDF,
        }
    }
}
