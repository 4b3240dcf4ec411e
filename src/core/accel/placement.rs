//! A group of shapes placed in the world. It is kept small, since a scene may have millions.
//!
//! Only the transform into the group is stored. Its inverse is computed once per hit.

use glam::{Affine3A, DAffine3, DMat3, Mat3, Vec3, Vec3A};

use super::hit::SurfacePoint;
use crate::math::{Aabb, Ray, gamma};

/// One placement of a group.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placement {
    /// Index into [`super::Tlas::groups`].
    pub group: u32,
    group_from_world: Mat3,
    /// The group's origin in the world, which is subtracted first, as in [`super::Instance::local_ray`].
    origin: Vec3,
}

impl Placement {
    /// None if the transform is singular, not finite, or has an inverse beyond f32.
    pub fn new(group: u32, world_from_group: &Affine3A) -> Option<Self> {
        // In f64, so that small scales do not make the determinant vanish.
        let wide = DMat3::from_cols(
            world_from_group.matrix3.x_axis.as_dvec3(),
            world_from_group.matrix3.y_axis.as_dvec3(),
            world_from_group.matrix3.z_axis.as_dvec3(),
        );
        let determinant = wide.determinant();
        if !world_from_group.is_finite() || !determinant.is_finite() || determinant == 0.0 {
            return None;
        }
        let group_from_world = wide.inverse().as_mat3();
        let back = group_from_world.as_dmat3().determinant();
        (group_from_world.is_finite() && back != 0.0).then_some(Self {
            group,
            group_from_world,
            origin: world_from_group.translation.into(),
        })
    }

    /// `ray` in the group's space, with the same `t`.
    #[inline(always)]
    pub(crate) fn group_ray(&self, ray: &Ray) -> Ray {
        Ray {
            origin: self.group_from_world * (ray.origin - self.origin),
            dir: self.group_from_world * ray.dir,
            t_min: ray.t_min,
            t_max: ray.t_max,
        }
    }

    /// The exact inverse of the transform applied to rays.
    fn exact_world_from_group(&self) -> DAffine3 {
        DAffine3 {
            matrix3: self.group_from_world.as_dmat3().inverse(),
            translation: self.origin.as_dvec3(),
        }
    }

    /// The transform from the group to the world, rounded to single precision.
    pub fn world_from_group(&self) -> Affine3A {
        let exact = self.exact_world_from_group();
        Affine3A::from_mat3_translation(exact.matrix3.as_mat3(), exact.translation.as_vec3())
    }

    /// The world bounds of a group with the local bounds `group`.
    pub(super) fn exact_bounds(&self, group: &Aabb) -> Aabb {
        if group.is_empty() {
            return Aabb::EMPTY;
        }
        let world_from_group = self.exact_world_from_group();
        let matrix = world_from_group.matrix3;
        let absolute = DMat3::from_cols(matrix.x_axis.abs(), matrix.y_axis.abs(), matrix.z_axis.abs());
        let center = world_from_group.transform_point3(group.center().as_dvec3());
        let half = absolute * (0.5 * (group.max.as_dvec3() - group.min.as_dvec3()));
        Aabb {
            min: (center - half).as_vec3(),
            max: (center + half).as_vec3(),
        }
    }

    /// The [`exact_bounds`](Self::exact_bounds) with a margin for rounding.
    pub(super) fn world_bounds(&self, group: &Aabb) -> Aabb {
        let Aabb { min, max } = self.exact_bounds(group);
        if group.is_empty() {
            return Aabb::EMPTY;
        }
        let rounding = gamma(16) * (min.abs().max(max.abs()) + 2.0 * self.origin.abs());
        Aabb {
            min: min - rounding,
            max: max + rounding,
        }
    }

    /// Transforms a surface of the group to the world. Normals go by the inverse transpose and keep their side, as in
    /// Mitsuba.
    pub(super) fn place(&self, point: &SurfacePoint) -> SurfacePoint {
        let world_from_group = self.exact_world_from_group();
        let linear = world_from_group.matrix3.as_mat3();
        let out = Mat3::from_cols(linear.x_axis.abs(), linear.y_axis.abs(), linear.z_axis.abs());
        let inward = &self.group_from_world;
        let back = Mat3::from_cols(inward.x_axis.abs(), inward.y_axis.abs(), inward.z_axis.abs());
        let normal = |n: Vec3| {
            let scaled = Vec3A::from(inward.transpose() * n);
            Vec3::from(scaled / scaled.abs().max_element())
                .try_normalize()
                .unwrap_or(n)
        };
        let image = out * point.position.abs();
        let error = out * (Vec3::splat(point.error) + gamma(8) * (back * image));
        SurfacePoint {
            position: world_from_group.transform_point3(point.position.as_dvec3()).as_vec3(),
            error: (error + gamma(4) * image + gamma(2) * self.origin.abs()).max_element(),
            geometric_normal: normal(point.geometric_normal),
            shading_normal: normal(point.shading_normal),
            uv: point.uv,
            dp_du: linear * point.dp_du,
            dp_dv: linear * point.dp_dv,
        }
    }
}
