//! Bounds on rounding errors, in the tests of boxes and in the transforms of instances.

use glam::{Affine3A, Mat3A, Vec3A};

use crate::math::{Aabb, gamma};

/// The factor that widens an exit distance by the rounding of both distances.
pub(super) const EXIT_SCALE: f32 = 1.0 + 2.0 * gamma(3);

/// The least margin around a box's faces. Times the largest inverse it is 3e20, farther than any hit that f32 could
/// resolve.
pub(super) const LEAST_MARGIN: f32 = 1e-18;

/// Bounds on the rounding of an instance's transforms, per coordinate, in world units.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rounding {
    /// The bound on a position's rounding, as a factor of the magnitudes of the local position.
    pub of_position: Mat3A,
    pub of_translation: Vec3A,
}

impl Rounding {
    pub fn new(world_from_local: &Affine3A, local_from_world: &Affine3A) -> Self {
        let out = absolute(&world_from_local.matrix3);
        let back = absolute(&local_from_world.matrix3);
        Self {
            of_position: out * (back * out) * gamma(8) + out * gamma(4),
            of_translation: gamma(2) * world_from_local.translation.abs(),
        }
    }

    /// Widens the bounds for a shape that rays intersect in its local space, where the rounding of every hit grows with
    /// the whole shape's `bounds`.
    pub fn of_whole(mut self, world_from_local: &Affine3A, bounds: &Aabb) -> Self {
        let extent = bounds.min.abs().max(bounds.max.abs());
        self.of_translation += gamma(6) * (absolute(&world_from_local.matrix3) * Vec3A::from(extent));
        self
    }
}

/// The matrix of the magnitudes.
#[inline(always)]
pub(super) fn absolute(matrix: &Mat3A) -> Mat3A {
    Mat3A::from_cols(matrix.x_axis.abs(), matrix.y_axis.abs(), matrix.z_axis.abs())
}
