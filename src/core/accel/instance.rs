//! A shape placed in the world.

use std::sync::Arc;

use glam::{Affine3A, DAffine3, DMat3, Mat3A, Vec3, Vec3A};

use super::blas::Blas;
use super::curve_blas::CurveBlas;
use super::hit::Hit;
use super::ray_lanes::RayLanes;
use super::rounding::Rounding;
use super::shape_lanes::local_to;
use super::traverse::TraversalStats;
use crate::geometry::local::LocalHit;
use crate::geometry::{cylinder, disk, rectangle, sphere};
use crate::math::{Aabb, Ray, gamma};

/// A shape in its own local space; the files in [`crate::geometry`] say where each lies in that space.
#[derive(Clone, Debug)]
pub enum Primitive {
    /// Triangles with their own hierarchy.
    Mesh(Arc<Blas>),
    /// Curves with their own hierarchy. Only their outside can be hit.
    Curves(Arc<CurveBlas>),
    /// The unit sphere.
    Sphere,
    /// The square [-1, 1]^2 in the plane z = 0.
    Rectangle,
    /// The unit disk in the plane z = 0.
    Disk,
    /// The cylinder of radius 1 around the z axis from z = 0 to z = 1, without caps.
    Cylinder,
}

/// A shape, where it is, and how its normals are taken.
#[derive(Clone, Debug)]
pub struct Instance {
    /// The shape that is placed.
    pub primitive: Primitive,
    /// The transform from local to world space; invertible.
    pub world_from_local: Affine3A,
    /// Its inverse, rounded once.
    pub local_from_world: Affine3A,
    /// Whether to shade with the geometric normal even if the mesh has vertex normals.
    pub face_normals: bool,
    /// Whether both normals are turned around.
    pub flip_normals: bool,
    /// Whether the transform mirrors: it turns a right-handed frame into a left-handed one.
    pub(super) mirrored: bool,
    /// One over the scale, if the transform preserves angles.
    pub(super) similarity: Option<f32>,
    pub(super) rounding: Rounding,
    /// Unit world normal of the local plane z = 0, on the side of its +z.
    pub plane_normal: Vec3,
}

impl Instance {
    /// Whether both are the same shape at the same place.
    pub(super) fn is_same(&self, other: &Self) -> bool {
        self.primitive.is_same(&other.primitive)
            && self.world_from_local == other.world_from_local
            && (self.face_normals, self.flip_normals) == (other.face_normals, other.flip_normals)
    }

    /// None if the transform is singular, not finite, or has an inverse beyond f32.
    pub fn new(primitive: Primitive, world_from_local: Affine3A) -> Option<Self> {
        // In f64, so that small scales do not make the determinant vanish.
        let wide = world_from_local.as_daffine3();
        let determinant = wide.matrix3.determinant();
        if !wide.is_finite() || !determinant.is_finite() || determinant == 0.0 {
            return None;
        }
        let inverse = wide.inverse();
        let local_from_world = Affine3A {
            matrix3: Mat3A::from_cols(
                inverse.matrix3.x_axis.as_vec3a(),
                inverse.matrix3.y_axis.as_vec3a(),
                inverse.matrix3.z_axis.as_vec3a(),
            ),
            translation: inverse.translation.as_vec3a(),
        };
        let rounding = Rounding::new(&world_from_local, &local_from_world);
        let rounding = match &primitive {
            Primitive::Mesh(blas) if blas.affine.is_some() => rounding.of_whole(&world_from_local, &blas.bounds()),
            _ => rounding,
        };
        local_from_world.is_finite().then_some(Self {
            primitive,
            world_from_local,
            local_from_world,
            face_normals: false,
            flip_normals: false,
            mirrored: determinant < 0.0,
            similarity: similarity(&wide.matrix3),
            rounding,
            plane_normal: Self::plane_normal(&local_from_world),
        })
    }

    pub(super) fn exact_world_from_local(&self) -> DAffine3 {
        self.world_from_local.as_daffine3()
    }

    /// `ray` in local space, with the same `t`.
    ///
    /// The translation is subtracted first: for an origin near the instance that is exact, however far both are from
    /// the world's origin.
    #[inline(always)]
    pub(crate) fn local_ray(&self, ray: &Ray) -> Ray {
        let linear = &self.local_from_world.matrix3;
        Ray {
            origin: (*linear * (Vec3A::from(ray.origin) - self.world_from_local.translation)).into(),
            dir: (*linear * Vec3A::from(ray.dir)).into(),
            t_min: ray.t_min,
            t_max: ray.t_max,
        }
    }

    /// [`Self::local_ray`] of sixteen rays.
    #[inline(always)]
    pub(super) fn local_rays(&self, rays: &RayLanes) -> RayLanes {
        let linear = &self.local_from_world.matrix3;
        let rows = [linear.row(0).into(), linear.row(1).into(), linear.row(2).into()];
        local_to(rays, &rows, self.world_from_local.translation.into())
    }

    /// World bounds without a margin for rounding, for display and measurement. For a mesh they are those of its local
    /// box.
    pub fn exact_bounds(&self) -> Aabb {
        let linear = &self.world_from_local.matrix3;
        let center = Vec3::from(self.world_from_local.translation);
        let (x, y, z) = (linear.x_axis, linear.y_axis, linear.z_axis);
        // Half the extents of the transformed local box, sphere or disk around the translation.
        let around = |half: Vec3A| Aabb {
            min: center - Vec3::from(half),
            max: center + Vec3::from(half),
        };
        let length = |squares: Vec3A| Vec3A::from_array(squares.to_array().map(f32::sqrt));
        match &self.primitive {
            Primitive::Mesh(blas) => blas.bounds().transformed(&self.world_from_local),
            Primitive::Curves(curves) => curves.bounds().transformed(&self.world_from_local),
            Primitive::Sphere => around(length(x * x + y * y + z * z)),
            Primitive::Rectangle => around(x.abs() + y.abs()),
            Primitive::Disk => around(length(x * x + y * y)),
            Primitive::Cylinder => {
                let ring = around(length(x * x + y * y));
                Aabb {
                    min: ring.min + Vec3::from(z).min(Vec3::ZERO),
                    max: ring.max + Vec3::from(z).max(Vec3::ZERO),
                }
            }
        }
    }

    /// World bounds, a little wider than exact, so that they hold every hit whatever the rounding of the transforms.
    pub fn world_bounds(&self) -> Aabb {
        let tight = self.exact_bounds();
        if tight.is_empty() {
            return Aabb::EMPTY;
        }
        let center = Vec3::from(self.world_from_local.translation);
        let rounding = gamma(16) * (tight.min.abs().max(tight.max.abs()) + 2.0 * center.abs());
        Aabb {
            min: tight.min - rounding,
            max: tight.max + rounding,
        }
    }

    /// The nearest hit of the world ray with this instance, which is the `number`-th. `COUNT` adds the work within a
    /// mesh to `stats`.
    #[inline(always)]
    pub(super) fn closest<const COUNT: bool>(&self, number: u32, ray: &Ray, stats: &mut TraversalStats) -> Option<Hit> {
        let ray = &self.local_ray(ray);
        match &self.primitive {
            Primitive::Mesh(blas) => blas.closest::<COUNT>(ray, stats).map(|hit| Hit::of_mesh(number, hit)),
            Primitive::Curves(curves) => (curves.closest::<COUNT>(ray, stats)).map(|hit| Hit::of_curve(number, hit)),
            shape => shape.intersect(ray).map(|hit| Hit::of_shape(number, hit)),
        }
    }

    #[inline(always)]
    pub(super) fn occluded(&self, ray: &Ray) -> bool {
        let ray = &self.local_ray(ray);
        match &self.primitive {
            Primitive::Mesh(blas) => blas.occluded(ray),
            Primitive::Curves(curves) => curves.occluded(ray),
            shape => shape.intersect(ray).is_some(),
        }
    }
}

/// One over the scale if the matrix preserves angles up to rounding.
fn similarity(linear: &DMat3) -> Option<f32> {
    let products = linear.transpose() * *linear;
    let scale_squared = products.x_axis.x;
    let is_like_one = (products * scale_squared.recip()).abs_diff_eq(DMat3::IDENTITY, 4.0 * f64::from(f32::EPSILON));
    let inverse = scale_squared.sqrt().recip() as f32;
    (is_like_one && inverse.is_normal()).then_some(inverse)
}

impl Primitive {
    /// Whether both are the same shape: of the same kind, and with the same hierarchy if they have one.
    pub fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Mesh(own), Self::Mesh(its)) => Arc::ptr_eq(own, its),
            (Self::Curves(own), Self::Curves(its)) => Arc::ptr_eq(own, its),
            (own, its) => std::mem::discriminant(own) == std::mem::discriminant(its),
        }
    }

    /// The nearest hit of a local ray; `None` for meshes and curves, which have a hierarchy to walk.
    #[inline(always)]
    pub(super) fn intersect(&self, ray: &Ray) -> Option<LocalHit> {
        match self {
            Self::Mesh(_) | Self::Curves(_) => None,
            Self::Sphere => sphere::intersect(ray),
            Self::Rectangle => rectangle::intersect(ray),
            Self::Disk => disk::intersect(ray),
            Self::Cylinder => cylinder::intersect(ray),
        }
    }
}
