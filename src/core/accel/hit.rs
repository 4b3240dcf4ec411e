//! The results of ray queries: hits, and the surfaces there.

use glam::{Vec2, Vec3};

use crate::geometry::local::LocalHit;
use crate::math::Frame;

/// A hit in the world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// The parameter of the world ray.
    pub t: f32,
    /// Index into [`super::Tlas::instances`], or beyond them into [`super::Tlas::placements`].
    pub instance: u32,
    /// Index into the instances of the placed group; zero for a shape outside groups.
    pub member: u32,
    /// The mesh's triangle, or the first control point of the curve's segment; zero for other shapes.
    pub primitive: u32,
    /// `u` and `v` have the meaning that [`crate::geometry::local::LocalHit`] or [`CurveHit`] gives them.
    pub u: f32,
    /// See `u`.
    pub v: f32,
    /// The slot of a mesh's triangle, see [`MeshHit::slot`]; [`Hit::NO_SLOT`] for other shapes.
    pub(super) slot: u32,
}

impl Hit {
    pub(super) const NO_SLOT: u32 = u32::MAX;

    /// A hit of a shape that is no mesh.
    #[inline(always)]
    pub(super) fn of_shape(instance: u32, hit: LocalHit) -> Self {
        Self {
            t: hit.t,
            instance,
            member: 0,
            primitive: 0,
            u: hit.u,
            v: hit.v,
            slot: Self::NO_SLOT,
        }
    }

    #[inline(always)]
    pub(super) fn of_curve(instance: u32, hit: CurveHit) -> Self {
        Self {
            t: hit.t,
            instance,
            member: 0,
            primitive: hit.start,
            u: hit.u,
            v: hit.v,
            slot: Self::NO_SLOT,
        }
    }

    #[inline(always)]
    pub(super) fn of_mesh(instance: u32, hit: MeshHit) -> Self {
        Self {
            t: hit.t,
            instance,
            member: 0,
            primitive: hit.triangle,
            u: hit.u,
            v: hit.v,
            slot: hit.slot,
        }
    }
}

/// A hit of a mesh; `u`, `v` are the barycentric weights of the triangle's corners 1 and 2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshHit {
    /// Parameter of the ray, the same in the mesh's space as in the world.
    pub t: f32,
    /// Index into the mesh's triangles.
    pub triangle: u32,
    /// The weight of corner 1, in [0, 1].
    pub u: f32,
    /// The weight of corner 2, in [0, 1]; `u + v` is at most 1 but for rounding.
    pub v: f32,
    /// The triangle's number in the order of the leaves, unused places counted.
    pub slot: u32,
}

/// A hit of a curve, always on its outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveHit {
    /// Parameter of the ray, the same in the curves' space as in the world.
    pub t: f32,
    /// The index of the segment's first control point.
    pub start: u32,
    /// The angle around the curve in turns, in [0, 1).
    pub u: f32,
    /// The parameter along the segment, in [0, 1].
    pub v: f32,
}

/// The point at which a ray met a surface, in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// The point on the surface, which rays that leave it move off by `error`.
    pub position: Vec3,
    /// Bound, per coordinate, on the distance of `position` from the surface that rays meet; for `math::offset_origin`.
    pub error: f32,
    /// Unit length.
    pub geometric_normal: Vec3,
    /// Unit length; may be on the other side than the geometric one.
    pub shading_normal: Vec3,
    /// Texture coordinates; zero, as the derivatives, with [`Detail::Plain`].
    pub uv: Vec2,
    /// How `position` moves with u and with v (Mitsuba 3's parametrisation; world lengths). Zero at the poles of
    /// spheres (`dp_du`) and the centres of disks; any two tangents where a mesh's texture coordinates are
    /// degenerate. Normals that are flipped do not change them.
    pub dp_du: Vec3,
    /// See `dp_du`.
    pub dp_dv: Vec3,
}

/// The parts of a [`SurfacePoint`] that a caller needs. Those that depend on texture coordinates can cost as much as
/// all the rest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Detail {
    /// Position and normals alone.
    Plain,
    /// Texture coordinates and derivatives as well.
    Parametrised,
}

impl SurfacePoint {
    /// A point with its geometric and its shading normal, without a parametrisation.
    #[inline(always)]
    pub(super) fn plain(position: Vec3, error: f32, [geometric_normal, shading_normal]: [Vec3; 2]) -> Self {
        Self {
            position,
            error,
            geometric_normal,
            shading_normal,
            uv: Vec2::ZERO,
            dp_du: Vec3::ZERO,
            dp_dv: Vec3::ZERO,
        }
    }

    /// The frame around the shading normal with s along `dp_du`, to which anisotropic scattering and normal maps refer.
    pub fn shading_frame(&self) -> Frame {
        Frame::from_normal_and_tangent(self.shading_normal, self.dp_du)
    }
}
