//! An inverse camera: a point that projects an image along +z.
//!
//! The irradiance is, as in Mitsuba 3, that on the plane z = 1 of its space times pi; an image of one colour lights
//! planes perpendicular to the axis evenly.

use std::f32::consts::PI;

use glam::{Affine3A, Vec2, Vec3, Vec3A};

use super::bounds::{LightBounds, NormalCone};
use super::emission::Beam;
use super::reference::Reference;
use super::texture_density::{self, mean_luminance};
use super::{LightSample, Target};
use crate::color::Rgb;
use crate::math::{Aabb, Real, Vector};
use crate::sampling::PiecewiseBilinear2d;
use crate::texture::{Parameter, TexturePoint, TextureTable};

/// A projector as a scene describes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projector {
    /// The transform from local to world space, invertible. The light is at the origin of its space, +x is the left of
    /// the image and +y its top.
    pub world_from_local: Affine3A,
    /// The irradiance across the image, whose uv go from its top left to its bottom right.
    pub irradiance: Parameter<Rgb>,
    /// The factor on the irradiance, not negative.
    pub scale: f32,
    /// Half the image's size on the plane z = 1: tangents of half the fields of view.
    pub half_size: Vec2,
}

/// The margin that keeps rounding from leaving a corner of the image without samples.
const COSINE_MARGIN: f32 = 1e-4;

#[derive(Clone, Debug)]
pub(super) struct ProjectorLight {
    projector: Projector,
    local_from_world: Affine3A,
    mean_irradiance: f32,
    /// The density over the image; None if it has a single colour.
    density: Option<Box<PiecewiseBilinear2d>>,
}

impl ProjectorLight {
    pub fn new(projector: Projector, textures: &TextureTable) -> Self {
        Self {
            mean_irradiance: mean_luminance(textures, projector.irradiance),
            density: texture_density::density(textures, projector.irradiance).map(Box::new),
            local_from_world: projector.world_from_local.inverse(),
            projector,
        }
    }

    pub fn position(&self) -> Vec3 {
        self.projector.world_from_local.translation.into()
    }

    /// Samples the light; the density is zero outside of the frustum.
    pub fn sample<R: Real>(&self, from: &Reference<R>, textures: &TextureTable) -> LightSample<R> {
        let position = from.position;
        let numbers = [position.x(), position.y(), position.z()];
        let [red, green, blue, pdf] = R::each(from.asked, numbers, |reference| {
            let reference = Vec3::from(reference);
            let local = self.local_from_world.transform_point3(reference);
            match (self.uv(local), (reference - self.position()).try_normalize()) {
                (Some(uv), Some(dir)) => self.radiance(uv, local.z, dir, textures).extend(1.0).to_array(),
                _ => [0.0; 4],
            }
        });
        LightSample {
            wi: (R::Vec3::same(self.position()) - position).normalize(),
            target: Target::Point(R::Vec3::same(self.position())),
            radiance: R::Vec3::of(red, green, blue),
            pdf,
            is_delta: true,
        }
    }

    /// The image coordinates of a local point; None outside of the frustum.
    fn uv(&self, local: Vec3) -> Option<Vec2> {
        let uv = Vec2::splat(0.5) - 0.5 * local.truncate() / (local.z * self.projector.half_size);
        (local.z > 0.0 && uv.min_element() >= 0.0 && uv.max_element() <= 1.0).then_some(uv)
    }

    /// The radiance along `dir` at a local height of `z`, from this point of the image.
    fn radiance(&self, uv: Vec2, z: f32, dir: Vec3, textures: &TextureTable) -> Rgb {
        let axis = Vec3::from(self.projector.world_from_local.transform_vector3a(Vec3A::Z));
        let irradiance = textures.light(self.projector.irradiance, &TexturePoint::of_uv(uv));
        irradiance * (PI * self.projector.scale / (z * z * axis.dot(dir)))
    }

    /// A direction in which it shines, sampled by the image's brightness.
    pub fn sample_beam(&self, u: Vec2, textures: &TextureTable) -> Option<Beam> {
        let uv = (self.density.as_ref()).map_or(u, |density| density.sample(u.to_array()).position.into());
        let local = (self.projector.half_size * (1.0 - 2.0 * uv)).extend(1.0);
        let dir = self
            .projector
            .world_from_local
            .transform_vector3(local)
            .try_normalize()?;
        let pdf_solid_angle = self.beam_pdf(dir);
        let unit = self.local_from_world.transform_vector3(dir);
        (pdf_solid_angle > 0.0).then(|| Beam {
            dir,
            intensity: self.radiance(uv, unit.z, dir, textures),
            pdf_solid_angle,
        })
    }

    /// Density per solid angle of [`Self::sample_beam`].
    pub fn beam_pdf(&self, dir: Vec3) -> f32 {
        let local = self.local_from_world.transform_vector3(dir);
        let Some(uv) = self.uv(local) else {
            return 0.0;
        };
        let pdf_uv = self.density.as_ref().map_or(1.0, |density| density.pdf(uv.to_array()));
        // From the image to the plane z = 1, and from there to directions: the solid angle of an area on the plane
        // falls with the distance cubed.
        let matrix = &self.projector.world_from_local.matrix3;
        let half = self.projector.half_size;
        let scaled_normal = Vec3::from(matrix.x_axis.cross(matrix.y_axis));
        let distance = 1.0 / local.z;
        pdf_uv * distance.powi(2) / (4.0 * half.x * half.y * scaled_normal.dot(dir).abs())
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
