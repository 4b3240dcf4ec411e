//! Spheres that emit, sampled by the cone that they fill; and their affine images, sampled by area.

use std::f32::consts::PI;

use glam::{Affine3A, Mat3A, Vec2, Vec3, Vec3A};

use super::hit::{AreaSample, SurfaceHit, SurfaceSample, solid_angle_pdf};
use crate::math::Frame;
use crate::sampling::warp;

/// The most that the axes of a transform may differ from perpendicular and equally long for its sphere to count as one.
const ROUNDNESS: f32 = 1e-5;

/// A sphere in world space. `side` is 1 when it emits outwards, -1 when inwards.
#[derive(Clone, Copy, Debug)]
pub(super) struct SphereLight {
    center: Vec3,
    radius: f32,
    side: f32,
}

impl SphereLight {
    /// The image of the unit sphere if that is a sphere.
    pub fn new(world_from_local: &Affine3A, side: f32) -> Option<Self> {
        let gram = world_from_local.matrix3.transpose() * world_from_local.matrix3;
        let square = (gram.x_axis.x + gram.y_axis.y + gram.z_axis.z) / 3.0;
        let round = gram.abs_diff_eq(Mat3A::from_diagonal(Vec3::splat(square)), ROUNDNESS * square);
        round.then_some(Self {
            center: world_from_local.translation.into(),
            radius: square.sqrt(),
            side,
        })
    }

    pub fn area(&self) -> f32 {
        4.0 * PI * self.radius * self.radius
    }

    /// 1 - cos of the half angle of the cone around the sphere; None if `reference` is not outside.
    fn cone(&self, reference: Vec3) -> Option<f32> {
        let distance_squared = reference.distance_squared(self.center);
        let radius_squared = self.radius * self.radius;
        if self.side < 0.0 || distance_squared <= radius_squared {
            return None;
        }
        let sin_squared = radius_squared / distance_squared;
        Some(sin_squared / (1.0 + (1.0 - sin_squared).max(0.0).sqrt()))
    }

    pub fn sample(&self, reference: Vec3, u: Vec2) -> Option<SurfaceSample> {
        let Some(one_minus_cos) = self.cone(reference) else {
            let normal = warp::uniform_sphere(u.to_array());
            let position = self.center + self.radius * normal;
            return SurfaceSample::from_area(position, self.side * normal, 1.0 / self.area(), reference);
        };
        let to_center = self.center - reference;
        let distance = to_center.length();
        let local = warp::uniform_cone(u.to_array(), one_minus_cos);
        let direction = Frame::from_normal(to_center / distance).to_world(local);
        // The nearer of the two points where the direction meets the sphere, by the law of sines around the centre.
        let sin_squared = (1.0 - local.z * local.z).max(0.0) * distance * distance;
        let along = local.z * distance - (self.radius * self.radius - sin_squared).max(0.0).sqrt();
        let normal = (reference + along * direction - self.center).normalize_or_zero();
        Some(SurfaceSample {
            position: self.center + self.radius * normal,
            normal,
            pdf_solid_angle: warp::uniform_cone_pdf(one_minus_cos),
        })
    }

    /// A point that is uniform in area, with its normal and the density.
    pub fn sample_area(&self, u: Vec2) -> AreaSample {
        let normal = warp::uniform_sphere(u.to_array());
        AreaSample {
            position: self.center + self.radius * normal,
            normal: self.side * normal,
            pdf_area: 1.0 / self.area(),
        }
    }

    pub fn pdf(&self, reference: Vec3, hit: &SurfaceHit) -> f32 {
        match self.cone(reference) {
            Some(one_minus_cos) => warp::uniform_cone_pdf(one_minus_cos),
            None => solid_angle_pdf(1.0 / self.area(), hit.position, hit.normal, reference),
        }
    }
}

/// The image of the unit sphere under any invertible affine map.
///
/// Points are uniform on the unit sphere; with M the linear part and n the local normal, area grows by |det M| |M^-T n|.
#[derive(Clone, Copy, Debug)]
pub(super) struct EllipsoidLight {
    world_from_local: Affine3A,
    local_from_world: Affine3A,
    determinant: f32,
    side: f32,
}

impl EllipsoidLight {
    pub fn new(world_from_local: Affine3A, local_from_world: Affine3A, side: f32) -> Self {
        Self {
            world_from_local,
            local_from_world,
            determinant: world_from_local.matrix3.determinant().abs(),
            side,
        }
    }

    /// The area by Knud Thomsen's approximation, within about one percent; only the choice between lights depends on it.
    pub fn area(&self) -> f32 {
        const P: f32 = 1.6075;
        let m = self.world_from_local.matrix3;
        let [a, b, c] = [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.length().powf(P));
        4.0 * PI * ((a * b + b * c + c * a) / 3.0).powf(1.0 / P)
    }

    /// World normal (outward, not normalised) and density per area at the local point on the unit sphere.
    fn normal_and_pdf_area(&self, local: Vec3A) -> (Vec3A, f32) {
        let normal = self.local_from_world.matrix3.transpose() * local;
        (normal, 1.0 / (4.0 * PI * self.determinant * normal.length()))
    }

    pub fn sample(&self, reference: Vec3, u: Vec2) -> Option<SurfaceSample> {
        self.sample_area(u).seen_from(reference)
    }

    /// A point that is uniform on the unit sphere.
    pub fn sample_area(&self, u: Vec2) -> AreaSample {
        let local = Vec3A::from(warp::uniform_sphere(u.to_array()));
        let (normal, pdf_area) = self.normal_and_pdf_area(local);
        AreaSample {
            position: self.world_from_local.transform_point3a(local).into(),
            normal: self.side * Vec3::from(normal.normalize_or_zero()),
            pdf_area,
        }
    }

    pub fn pdf(&self, reference: Vec3, hit: &SurfaceHit) -> f32 {
        solid_angle_pdf(self.pdf_area(hit.position), hit.position, hit.normal, reference)
    }

    /// Density per area of [`Self::sample_area`].
    pub fn pdf_area(&self, position: Vec3) -> f32 {
        let local = self.local_from_world.transform_point3a(position.into());
        self.normal_and_pdf_area(local.normalize_or_zero()).1
    }
}
