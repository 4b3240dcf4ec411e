//! A point that shines into a cone along +z, with full intensity within the beam and a falloff linear in the angle up
//! to the cutoff.

use std::f32::consts::PI;

use glam::{Affine3A, Mat3A, Vec2, Vec3, Vec3A};

use super::LightSample;
use super::bounds::{LightBounds, NormalCone};
use super::emission::Beam;
use super::hit::axes;
use super::reference::Reference;
use super::texture_density::mean_luminance;
use crate::color::{Rgb, luminance};
use crate::math::{Aabb, Frame, Real, Vector, asin_positive};
use crate::sampling::warp;
use crate::texture::{Parameter, TexturePoint, TextureTable};

/// A spot light as a scene describes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// The transform from local to world space, invertible; the light is at the origin of its space.
    pub world_from_local: Affine3A,
    /// The radiant intensity along the axis, in W/sr.
    pub intensity: Rgb,
    /// Half angle of the cone in radians, beyond which there is no light. 0 <= beam <= cutoff <= pi.
    pub cutoff_angle: f32,
    /// Half angle of the beam in radians, up to which the intensity is full.
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

    /// Samples the light; the density is zero outside of the cone.
    pub fn sample<R: Real>(&self, from: &Reference<R>, textures: &TextureTable) -> LightSample<R> {
        let dir = from.position - R::Vec3::same(self.position());
        let (intensity, is_lit) = self.intensity::<R>(from.asked, dir, textures);
        let sample = LightSample::<R>::of_point(self.position(), from.position, intensity);
        LightSample {
            pdf: sample.pdf.only(is_lit),
            ..sample
        }
    }

    /// The radiant intensity in a direction of any length, and a mask of the directions within the cone.
    fn intensity<R: Real>(&self, asked: R::Mask, dir: R::Vec3, textures: &TextureTable) -> (R::Vec3, R::Mask) {
        let local = dir.along(axes(&self.local_from_world)).normalize();
        let falloff = self.falloff(local.z());
        let is_lit = asked & R::is_above(falloff, 0.0);
        let color = match self.spot.texture {
            Parameter::Constant(color) => R::Vec3::same(color.max(Rgb::ZERO)),
            Parameter::Texture(_) => {
                let [red, green, blue] = R::each(is_lit, [local.x(), local.y(), local.z()], |[x, y, z]| {
                    let uv = Vec2::splat(0.5) + 0.5 * Vec2::new(x, y) / (z * self.spot.cutoff_angle.tan());
                    textures.light(self.spot.texture, &TexturePoint::of_uv(uv)).to_array()
                });
                R::Vec3::of(red, green, blue)
            }
        };
        (color * R::Vec3::same(self.spot.intensity) * falloff, is_lit)
    }

    /// A direction in which it shines, uniform over the cone; None where the texture is black.
    pub fn sample_beam(&self, u: Vec2, textures: &TextureTable) -> Option<Beam> {
        let dir = match self.cone() {
            Some((axis, one_minus_cos)) => {
                Frame::from_normal(axis).to_world(warp::uniform_cone(u.to_array(), one_minus_cos))
            }
            None => warp::uniform_sphere(u.to_array()),
        };
        let (intensity, is_lit) = self.intensity::<f32>(true, dir, textures);
        is_lit.then(|| Beam {
            dir,
            intensity,
            pdf_solid_angle: self.beam_pdf(),
        })
    }

    /// Density per solid angle of [`Self::sample_beam`] in the directions in which it shines.
    pub fn beam_pdf(&self) -> f32 {
        self.cone().map_or(warp::UNIFORM_SPHERE_PDF, |(_, one_minus_cos)| {
            warp::uniform_cone_pdf(one_minus_cos)
        })
    }

    /// The axis of the cone, and 1 - cos of its half angle; None if the transform does not preserve the cone's shape.
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
    fn falloff<R: Real>(&self, cos_theta: R) -> R {
        let (cutoff, beam) = (self.spot.cutoff_angle, self.spot.beam_angle);
        // The sine of half the angle.
        let sin_half = (R::HALF * (R::ONE - cos_theta)).saturated().sqrt();
        let angle = R::splat(2.0) * asin_positive(sin_half);
        let fading = (R::splat(cutoff) - angle) / R::splat(cutoff - beam);
        let share = R::select(cos_theta.is_less(R::splat(self.cos_beam)), fading, R::ONE);
        share.only(R::is_above(cos_theta, self.cos_cutoff))
    }

    pub fn bounds(&self) -> LightBounds {
        let axis = self.axis();
        let cos_emission = (self.spot.cutoff_angle + ANGLE_MARGIN).min(PI).cos();
        // The angle of the cone is unknown if the transform does not preserve angles.
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

/// Whether a transform preserves angles: it rotates, mirrors and scales uniformly.
fn keeps_angles(map: Mat3A) -> bool {
    const TOLERANCE: f32 = 1e-4;
    let gram = map.transpose() * map;
    let scale = gram.x_axis.x;
    gram.abs_diff_eq(Mat3A::from_diagonal(Vec3::splat(scale)), TOLERANCE * scale)
}
