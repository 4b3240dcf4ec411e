//! Orthonormal frames.

use glam::Vec3;

/// The squared sine of the angle to the normal below which a tangent has no direction of its own: its part across the normal would be mere rounding
/// (a relative 1e-7) to more than 1e-4.
const PARALLEL: f32 = 1e-6;

/// A right-handed orthonormal frame whose z axis is `n`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Unit x axis of the local space, in world space.
    pub s: Vec3,
    /// Unit y axis.
    pub t: Vec3,
    /// Unit z axis, most often a normal.
    pub n: Vec3,
}

impl Frame {
    /// A frame around the unit vector `n` (Duff et al., Building an Orthonormal Basis, Revisited, JCGT 2017).
    pub fn from_normal(n: Vec3) -> Self {
        debug_assert!(n.is_normalized(), "the normal {n} is not of unit length");
        let (s, t) = n.any_orthonormal_pair();
        Self { s, t, n }
    }

    /// A frame around the unit vector `n` with s as near to `tangent` (of any length) as it can be; [`Self::from_normal`] if that is zero
    /// or parallel to `n`.
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

    /// World to local.
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        Vec3::new(v.dot(self.s), v.dot(self.t), v.dot(self.n))
    }

    /// Transforms a vector from local to world space.
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.s * v.x + self.t * v.y + self.n * v.z
    }
}
