//! A camera the other way round: a point that throws a picture along +z.
//!
//! The irradiance is that on the plane z = 1 of its space times pi, as Mitsuba 3 has it; a picture of one colour lights planes
//! perpendicular to the axis evenly.

use std::f32::consts::PI;

use glam::{Affine3A, Vec2, Vec3, Vec3A};

use super::bounds::{LightBounds, NormalCone};
use super::texture_density::mean_luminance;
use super::{LightSample, Target};
use crate::color::Rgb;
use crate::math::Aabb;
use crate::texture::{Parameter, TexturePoint, TextureTable};

/// A projector as a scene describes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projector {
    /// The map to local space, invertible. The light is at the origin of its space, +x is the left of the picture and +y its top.
    pub world_from_local: Affine3A,
    /// The irradiance across the picture, whose uv go from its top left to its bottom right.
    pub irradiance: Parameter<Rgb>,
    /// The factor on the irradiance, not negative.
    pub scale: f32,
    /// Half the picture's size on the plane z = 1: tangents of half the fields of view.
    pub half_size: Vec2,
}

/// The margin that keeps rounding from leaving a corner of the picture without samples.
const COSINE_MARGIN: f32 = 1e-4;

#[derive(Clone, Debug)]
pub(super) struct ProjectorLight {
    projector: Projector,
    local_from_world: Affine3A,
    mean_irradiance: f32,
}

impl ProjectorLight {
    pub fn new(projector: Projector, textures: &TextureTable) -> Self {
        Self {
            mean_irradiance: mean_luminance(textures, projector.irradiance),
            local_from_world: projector.world_from_local.inverse(),
            projector,
        }
    }

    pub fn position(&self) -> Vec3 {
        self.projector.world_from_local.translation.into()
    }

    /// Samples the light; None outside of the picture's frustum.
    pub fn sample(&self, reference: Vec3, textures: &TextureTable) -> Option<LightSample> {
        let local = self.local_from_world.transform_point3(reference);
        if local.z <= 0.0 {
            return None;
        }
        let uv = Vec2::splat(0.5) - 0.5 * local.truncate() / (local.z * self.projector.half_size);
        if uv.min_element() < 0.0 || uv.max_element() > 1.0 {
            return None;
        }
        let wi = (self.position() - reference).try_normalize()?;
        let axis = Vec3::from(self.projector.world_from_local.transform_vector3a(Vec3A::Z));
        let cos = -axis.dot(wi);
        let irradiance = textures.light(self.projector.irradiance, &TexturePoint::of_uv(uv));
        Some(LightSample {
            wi,
            target: Target::Point(self.position()),
            radiance: irradiance * (PI * self.projector.scale / (local.z * local.z * cos)),
            pdf: 1.0,
            is_delta: true,
        })
    }

    pub fn bounds(&self) -> LightBounds {
        let to_world = |local: Vec3| self.projector.world_from_local.transform_vector3(local);
        let axis = to_world(Vec3::Z).normalize_or(Vec3::Z);
        let half = self.projector.half_size;
        let cos_to_corner = [Vec2::ONE, Vec2::NEG_ONE, Vec2::new(1.0, -1.0), Vec2::new(-1.0, 1.0)]
            .map(|corner| to_world((corner * half).extend(1.0)).normalize_or(axis).dot(axis))
            .into_iter()
            .fold(1.0, f32::min);
        LightBounds {
            bounds: Aabb::from_points([self.position()]),
            cone: NormalCone::single(axis),
            cos_emission: (cos_to_corner - COSINE_MARGIN).max(0.0),
            intensity: PI * self.projector.scale * self.mean_irradiance,
        }
    }
}
