//! Spheres that emit, sampled by the cone that they subtend; and their affine images, sampled by area.

use std::f32::consts::{FRAC_1_PI, PI};

use glam::{Affine3A, Mat3A, Vec3};

use super::hit::{AreaSample, SurfaceHit, SurfaceSample, axes, solid_angle_pdf};
use crate::math::{Frame, Mask, Real, Vector, real_struct};
use crate::sampling::warp;

/// The largest deviation of a transform's axes from perpendicular and equally long with which its sphere counts as
/// round.
const ROUNDNESS: f32 = 1e-5;

real_struct! {
    #[same]
    /// A sphere in world space.
    pub(crate) struct SphereLight<R> {
        center: R::Vec3,
        radius: R,
        /// 1 when it emits outwards, -1 when inwards.
        side: R,
    }
}

impl SphereLight {
    /// The transformed unit sphere; None if that is not a sphere.
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

    pub fn pdf(&self, reference: Vec3, hit: &SurfaceHit) -> f32 {
        match self.cone(reference) {
            (one_minus_cos, true) => warp::uniform_cone_pdf(one_minus_cos),
            _ => solid_angle_pdf(1.0 / self.area(), hit.position, hit.normal, reference),
        }
    }
}

impl<R: Real> SphereLight<R> {
    pub fn area(&self) -> R {
        R::splat(4.0 * PI) * self.radius.squared()
    }

    /// 1 - cos of the half angle of the cone around the sphere, and a mask of the references that are outside and have
    /// one.
    #[inline(always)]
    fn cone(&self, reference: R::Vec3) -> (R, R::Mask) {
        let distance_squared = (reference - self.center).length_squared();
        let radius_squared = self.radius.squared();
        let sin_squared = radius_squared / distance_squared;
        let cos = (R::ONE - sin_squared).max(R::ZERO).sqrt();
        let is_outside = distance_squared.is_more(radius_squared) & self.side.is_more(R::ZERO);
        (sin_squared / (R::ONE + cos), is_outside)
    }

    #[inline(always)]
    pub(super) fn sample(&self, reference: R::Vec3, u: [R; 2]) -> SurfaceSample<R> {
        let (one_minus_cos, is_outside) = self.cone(reference);
        let to_center = self.center - reference;
        let distance = to_center.length_squared().sqrt();
        let local = warp::uniform_cone(u, one_minus_cos);
        let direction = Frame::<R>::around(to_center / distance).to_world(local);
        // The nearer of the two points where the direction meets the sphere, by the law of sines around the centre.
        let sin_squared = local.with_third(R::ZERO).length_squared() * distance * distance;
        let half_chord = (self.radius.squared() - sin_squared).max(R::ZERO).sqrt();
        let along = local.z() * distance - half_chord;
        let normal = (direction * along - to_center).normalize();
        let sample = SurfaceSample {
            position: self.center.plus_scaled(self.radius, normal),
            normal,
            pdf_solid_angle: warp::uniform_cone_pdf(one_minus_cos),
        };
        match (!is_outside).any() {
            true => SurfaceSample::select(is_outside, sample, self.sample_area(u).seen_from(reference)),
            false => sample,
        }
    }

    /// A point that is uniform in area, with its normal and the density.
    #[inline(always)]
    pub(super) fn sample_area(&self, u: [R; 2]) -> AreaSample<R> {
        let normal = warp::uniform_sphere(u);
        AreaSample {
            position: self.center.plus_scaled(self.radius, normal),
            normal: normal * self.side,
            pdf_area: R::ONE / self.area(),
        }
    }
}

/// The transformed unit sphere under any invertible affine map.
///
/// Points are uniform on the unit sphere; with M the linear part and n the local normal, area grows by |det M| |M^-T
/// n|.
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

    /// The area by Knud Thomsen's approximation, within about one percent; only the choice between lights depends on
    /// it.
    pub fn area(&self) -> f32 {
        const P: f32 = 1.6075;
        let m = self.world_from_local.matrix3;
        let [a, b, c] = [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.length().powf(P));
        4.0 * PI * ((a * b + b * c + c * a) / 3.0).powf(1.0 / P)
    }

    /// World normal (outward) and density per area at the local point on the unit sphere.
    #[inline(always)]
    fn normal_and_pdf_area<R: Real>(&self, local: R::Vec3) -> (R::Vec3, R) {
        let normal = local.coordinates(axes(&self.local_from_world));
        let length = normal.length_squared().sqrt();
        (normal / length, R::splat(0.25 * FRAC_1_PI / self.determinant) / length)
    }

    /// A point that is uniform on the unit sphere.
    #[inline(always)]
    pub fn sample_area<R: Real>(&self, u: [R; 2]) -> AreaSample<R> {
        let local = warp::uniform_sphere(u);
        let (normal, pdf_area) = self.normal_and_pdf_area::<R>(local);
        AreaSample {
            position: R::Vec3::same(self.world_from_local.translation.into())
                + local.along(axes(&self.world_from_local)),
            normal: normal * R::splat(self.side),
            pdf_area,
        }
    }

    pub fn pdf(&self, reference: Vec3, hit: &SurfaceHit) -> f32 {
        solid_angle_pdf(self.pdf_area(hit.position), hit.position, hit.normal, reference)
    }

    /// Density per area of [`Self::sample_area`].
    pub fn pdf_area(&self, position: Vec3) -> f32 {
        let local = self.local_from_world.transform_point3(position);
        self.normal_and_pdf_area::<f32>(local.normalize_or_zero()).1
    }
}
