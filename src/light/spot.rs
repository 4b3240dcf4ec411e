//! A point that shines into a cone along +z, as bright all over the beam and fading out linearly in the angle towards the cutoff.

use std::f32::consts::PI;

use glam::{Affine3A, Mat3A, Vec2, Vec3, Vec3A};

use super::bounds::{LightBounds, NormalCone};
use super::emission::Beam;
use super::texture_density::mean_luminance;
use super::{LightSample, Target};
use crate::color::{Rgb, luminance};
use crate::math::{Aabb, Frame};
use crate::sampling::warp;
use crate::texture::{Parameter, TexturePoint, TextureTable};

/// A spot light as a scene describes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// The map to local space, invertible; the light is at the origin of its space.
    pub world_from_local: Affine3A,
    /// The radiant intensity along the axis, in W/sr.
    pub intensity: Rgb,
    /// Half angles, radians: no light beyond the cutoff, all of it within the beam. 0 <= beam <= cutoff <= pi.
    pub cutoff_angle: f32,
    /// The angle up to which the intensity is full, see `cutoff_angle`.
    pub beam_angle: f32,
    /// The factor on the intensity, over the square around the cone's cross section.
    pub texture: Parameter<Rgb>,
}

/// The margin (radians) that keeps rounding from leaving a part of the cone without samples.
const ANGLE_MARGIN: f32 = 1e-3;

#[derive(Clone, Debug)]
pub(super) struct SpotLight {
    spot: Spot,
    local_from_world: Affine3A,
    cos_cutoff: f32,
    cos_beam: f32,
    mean_texture: f32,
}

impl SpotLight {
    pub fn new(spot: Spot, textures: &TextureTable) -> Self {
        Self {
            local_from_world: spot.world_from_local.inverse(),
            cos_cutoff: spot.cutoff_angle.cos(),
            cos_beam: spot.beam_angle.cos(),
            mean_texture: mean_luminance(textures, spot.texture),
            spot,
        }
    }

    pub fn position(&self) -> Vec3 {
        self.spot.world_from_local.translation.into()
    }

    /// Samples the light; None outside of the cone.
    pub fn sample(&self, reference: Vec3, textures: &TextureTable) -> Option<LightSample> {
        let to_light = self.position() - reference;
        let intensity = self.intensity(-to_light, textures)?;
        Some(LightSample {
            wi: to_light.normalize(),
            target: Target::Point(self.position()),
            radiance: intensity / to_light.length_squared(),
            pdf: 1.0,
            is_delta: true,
        })
    }

    /// The radiant intensity in a direction, which is of any length; None outside of the cone.
    fn intensity(&self, dir: Vec3, textures: &TextureTable) -> Option<Rgb> {
        let local = self.local_from_world.transform_vector3(dir).try_normalize()?;
        let falloff = self.falloff(local.z);
        (falloff > 0.0).then(|| {
            let uv = Vec2::splat(0.5) + 0.5 * local.truncate() / (local.z * self.spot.cutoff_angle.tan());
            let color = textures.light(self.spot.texture, &TexturePoint::of_uv(uv));
            self.spot.intensity * color * falloff
        })
    }

    /// A direction in which it shines, uniform over the cone; None where it is dark.
    pub fn sample_beam(&self, u: Vec2, textures: &TextureTable) -> Option<Beam> {
        let dir = match self.cone() {
            Some((axis, one_minus_cos)) => {
                Frame::from_normal(axis).to_world(warp::uniform_cone(u.to_array(), one_minus_cos))
            }
            None => warp::uniform_sphere(u.to_array()),
        };
        Some(Beam {
            dir,
            intensity: self.intensity(dir, textures)?,
            pdf_solid_angle: self.beam_pdf(),
        })
    }

    /// Density per solid angle of [`Self::sample_beam`] in the directions in which it shines.
    pub fn beam_pdf(&self) -> f32 {
        self.cone().map_or(warp::UNIFORM_SPHERE_PDF, |(_, one_minus_cos)| {
            warp::uniform_cone_pdf(one_minus_cos)
        })
    }

    /// The axis of the cone, and 1 - cos of its half angle; None if it is not known in the world.
    fn cone(&self) -> Option<(Vec3, f32)> {
        let axis = self.axis().try_normalize()?;
        keeps_angles(self.spot.world_from_local.matrix3).then(|| {
            let half = 0.5 * (self.spot.cutoff_angle + ANGLE_MARGIN).min(PI);
            (axis, 2.0 * half.sin().powi(2))
        })
    }

    fn axis(&self) -> Vec3 {
        self.spot.world_from_local.transform_vector3a(Vec3A::Z).into()
    }

    /// The share of the intensity at an angle from the axis.
    fn falloff(&self, cos_theta: f32) -> f32 {
        if cos_theta <= self.cos_cutoff {
            0.0
        } else if cos_theta >= self.cos_beam {
            1.0
        } else {
            (self.spot.cutoff_angle - cos_theta.acos()) / (self.spot.cutoff_angle - self.spot.beam_angle)
        }
    }

    pub fn bounds(&self) -> LightBounds {
        let axis = self.axis();
        let cos_emission = (self.spot.cutoff_angle + ANGLE_MARGIN).min(PI).cos();
        // The width of the cone is not known if the map does not keep angles.
        let is_known = cos_emission >= 0.0 && keeps_angles(self.spot.world_from_local.matrix3);
        LightBounds {
            bounds: Aabb::from_points([self.position()]),
            cone: if is_known {
                NormalCone::single(axis.normalize_or(Vec3::Z))
            } else {
                NormalCone::ALL
            },
            cos_emission: if is_known { cos_emission } else { 0.0 },
            intensity: luminance(self.spot.intensity) * self.mean_texture,
        }
    }
}

/// Whether a map turns, mirrors and scales, but by the same factor everywhere.
fn keeps_angles(map: Mat3A) -> bool {
    const TOLERANCE: f32 = 1e-4;
    let gram = map.transpose() * map;
    let scale = gram.x_axis.x;
    gram.abs_diff_eq(Mat3A::from_diagonal(Vec3::splat(scale)), TOLERANCE * scale)
}
