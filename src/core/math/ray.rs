//! A ray, and the only function that moves a new ray's origin off the surface it leaves.

use glam::Vec3;

use super::real::{Real, Vector};

/// The part `t_min < t < t_max` of the line `origin + t dir`.
///
/// `dir` need not be of unit length: a ray taken into an instance's local space keeps its `t`, so that hits compare
/// across instances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// The point where `t` is 0.
    pub origin: Vec3,
    /// The direction, of any length but zero.
    pub dir: Vec3,
    /// The least t of a hit, at least 0.
    pub t_min: f32,
    /// The greatest t of a hit; it may be infinite.
    pub t_max: f32,
}

impl Ray {
    /// An unbounded ray.
    pub fn new(origin: Vec3, dir: Vec3) -> Self {
        Self {
            origin,
            dir,
            t_min: 0.0,
            t_max: f32::INFINITY,
        }
    }

    /// The open segment from `a` to `b`, as a shadow ray needs it: `t` runs in (0, 1).
    pub fn segment(a: Vec3, b: Vec3) -> Self {
        Self {
            origin: a,
            dir: b - a,
            t_min: 0.0,
            t_max: 1.0,
        }
    }

    /// The point at parameter `t`.
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + t * self.dir
    }
}

/// Moves `position` off its surface to the side that `dir` points to.
///
/// `normal` is the unit geometric normal, `error` a bound on the absolute error of each coordinate of `position` (world
/// units). The offset follows the error's extent along the normal and is rounded away from the surface (Pharr, Jakob,
/// Humphreys, PBR 4th ed., section 6.8.6), so that it scales with the scene instead of being a fixed epsilon.
#[inline(always)]
pub fn offset_origin<R: Real>(position: R::Vec3, error: R, normal: R::Vec3, dir: R::Vec3) -> R::Vec3 {
    let distance = (error * normal.map(R::abs).sum()).copy_sign(dir.dot(normal));
    let moved = position.plus_scaled(distance, normal);
    // One step of the last digit or two, away from the old position.
    let away = |moved: R, position: R| {
        let step = moved.abs().max(position.abs()) * R::splat(f32::EPSILON);
        let change = moved - position;
        moved + step.copy_sign(change).only(!change.equals(R::ZERO))
    };
    R::Vec3::of(
        away(moved.x(), position.x()),
        away(moved.y(), position.y()),
        away(moved.z(), position.z()),
    )
}
