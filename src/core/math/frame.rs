//! Orthonormal frames.

use glam::Vec3;

use super::per_lane::real_struct;
use super::real::{Real, Vector};

/// The squared sine of the angle to the normal below which a tangent is ignored: rounding (a relative 1e-7) would make
/// up more than 1e-4 of its part across the normal.
const PARALLEL: f32 = 1e-6;

real_struct! {
    /// A right-handed orthonormal frame whose z axis is `n`.
    pub struct Frame<R> {
        /// Unit x axis of the local space, in world space.
        pub s: R::Vec3,
        /// Unit y axis.
        pub t: R::Vec3,
        /// Unit z axis, most often a normal.
        pub n: R::Vec3,
    }
}

impl<R: Real> Frame<R> {
    /// A frame around the unit vector `n` (Duff et al., Building an Orthonormal Basis, Revisited, JCGT 2017).
    #[inline(always)]
    pub(crate) fn around(n: R::Vec3) -> Self {
        let (x, y, z) = (n.x(), n.y(), n.z());
        let sign = R::ONE.copy_sign(z);
        let a = -R::ONE / (sign + z);
        let b = x * y * a;
        Self {
            s: R::Vec3::of(sign * x * x * a + R::ONE, sign * b, -sign * x),
            t: R::Vec3::of(b, y * y * a + sign, -y),
            n,
        }
    }

    /// World to local.
    #[inline(always)]
    pub fn to_local(&self, v: R::Vec3) -> R::Vec3 {
        R::Vec3::of(v.dot(self.s), v.dot(self.t), v.dot(self.n))
    }

    /// Transforms a vector from local to world space.
    #[inline(always)]
    pub fn to_world(&self, v: R::Vec3) -> R::Vec3 {
        (self.s * v.x()).plus_scaled(v.y(), self.t).plus_scaled(v.z(), self.n)
    }
}

impl Frame {
    /// `Self::around` a unit vector.
    pub fn from_normal(n: Vec3) -> Self {
        debug_assert!(n.is_normalized(), "the normal {n} is not of unit length");
        Self::around(n)
    }

    /// A frame around the unit vector `n` with s as close as possible to `tangent` (of any length);
    /// [`Self::from_normal`] if that is zero or parallel to `n`.
    pub(crate) fn from_normal_and_tangent(n: Vec3, tangent: Vec3) -> Self {
        debug_assert!(n.is_normalized(), "the normal {n} is not of unit length");
        if tangent == Vec3::ZERO {
            return Self::from_normal(n);
        }
        let across = tangent - n * n.dot(tangent);
        match across.try_normalize() {
            Some(s) if across.length_squared() > PARALLEL * tangent.length_squared() => Self { s, t: n.cross(s), n },
            _ => Self::from_normal(n),
        }
    }
}
