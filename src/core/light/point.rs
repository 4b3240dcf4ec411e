//! A point that sends the same intensity in all directions.

use glam::{Vec2, Vec3};

use super::LightSample;
use super::bounds::{LightBounds, NormalCone};
use super::emission::{Aim, Beam, SceneSphere};
use crate::color::{Rgb, luminance};
use crate::math::{Aabb, Real, Vector};
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

    #[inline(always)]
    pub fn sample<R: Real>(&self, reference: R::Vec3) -> LightSample<R> {
        LightSample::of_point(self.position, reference, R::Vec3::same(self.intensity))
    }

    /// A direction in which it shines: towards the lit sphere if that is distant, or uniform over all directions.
    pub fn sample_beam(&self, lit: &SceneSphere, u: Vec2) -> Beam {
        let dir = match (Aim::at(lit, self.position), Aim::choose(u)) {
            (None, _) => warp::uniform_sphere(u.to_array()),
            (Some(aim), (true, u)) => aim.sample(u),
            (Some(_), (false, u)) => warp::uniform_sphere(u.to_array()),
        };
        Beam {
            dir,
            intensity: self.intensity,
            pdf_solid_angle: self.beam_pdf(lit, dir),
        }
    }

    /// Density per solid angle of [`Self::sample_beam`].
    pub fn beam_pdf(&self, lit: &SceneSphere, dir: Vec3) -> f32 {
        Aim::mixed(Aim::at(lit, self.position).as_ref(), warp::UNIFORM_SPHERE_PDF, dir)
    }
}
