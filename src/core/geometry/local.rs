//! The results of every shape's intersection and surface functions, in the shape's own local space.

use glam::{Vec2, Vec3};

use crate::math::Real;

/// A hit at ray parameter `t` (the world's `t`: local rays are not renormalised).
///
/// `u`, `v` mean: triangle: barycentric weights of its corners 1 and 2; rectangle and disk: local x and y; others:
/// unused, zero.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalHit {
    /// The parameter of the ray, within its bounds.
    pub t: f32,
    /// The first coordinate of the hit, see the type.
    pub u: f32,
    /// The second coordinate of the hit, see the type.
    pub v: f32,
}

/// The surface at a hit, in local space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalSurface<R: Real = f32> {
    /// The point on the surface, up to rounding. It is never computed as origin + t dir.
    pub position: R::Vec3,
    /// The bound, per coordinate, on the distance of `position` from the surface as the intersection test sees it.
    /// Displacement within the surface is not counted: it cannot make an outgoing ray meet the surface again.
    pub error: R::Vec3,
    /// The geometric normal, not of unit length.
    pub normal: R::Vec3,
}

/// A point in Mitsuba 3's parametrisation of its shape, in local space. It is not part of [`LocalSurface`], because
/// most paths do not need it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Parametrisation {
    pub uv: Vec2,
    /// The derivatives of `position` by u and by v. Both are zero where the parametrisation is degenerate on a whole
    /// triangle.
    pub dp_du: Vec3,
    pub dp_dv: Vec3,
}
