//! Axis-aligned boxes and the slab test.

use glam::{Affine3A, Vec3};

/// The least radius that a camera frames, relative to the largest coordinate: 80 times the rounding of single
/// precision.
const SMALLEST_SHARE: f32 = 1e-5;
/// The smallest radius; its cube is far above the smallest positive number.
const SMALLEST_RADIUS: f32 = 1e-9;

/// An axis-aligned box; [`Aabb::EMPTY`] (min > max) holds nothing and is the identity of union.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// The least coordinates.
    pub min: Vec3,
    /// The greatest coordinates.
    pub max: Vec3,
}

impl Aabb {
    /// Holds nothing, and is the identity of [`Self::union`].
    pub const EMPTY: Self = Self {
        min: Vec3::INFINITY,
        max: Vec3::NEG_INFINITY,
    };

    /// The smallest box around `points`.
    pub fn from_points(points: impl IntoIterator<Item = Vec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, Self::grown)
    }

    /// Whether `min` is above `max` along any axis. A box without volume is not empty.
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// This box, grown to hold `point`.
    pub fn grown(self, point: Vec3) -> Self {
        Self {
            min: self.min.min(point),
            max: self.max.max(point),
        }
    }

    /// The smallest box around both.
    pub fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
        }
    }

    /// The box of the points that are in both; empty if there are none.
    pub fn intersection(self, other: Self) -> Self {
        Self {
            min: self.min.max(other.min),
            max: self.max.min(other.max),
        }
    }

    /// The edge lengths; zero for the empty box.
    pub fn extent(&self) -> Vec3 {
        (self.max - self.min).max(Vec3::ZERO)
    }

    /// The midpoint; not a number for the empty box.
    pub fn center(&self) -> Vec3 {
        0.5 * self.min + 0.5 * self.max
    }

    /// Half the diagonal; zero for the empty box.
    pub fn radius(&self) -> f32 {
        let extent = self.extent();
        let largest = extent.max_element();
        // Squares of tiny and huge lengths are beyond single precision.
        match largest > 0.0 && largest.is_finite() {
            true => 0.5 * largest * (extent / largest).length(),
            false => 0.5 * largest,
        }
    }

    /// The radius around the centre that a camera frames to show this box: [`Self::radius`], or at least 1 where single
    /// precision cannot resolve it, so that the camera is not within a point that it looks at.
    pub fn framed_radius(&self) -> f32 {
        let reach = self.min.abs().max(self.max.abs()).max_element();
        let least = if self.is_empty() {
            SMALLEST_RADIUS
        } else {
            (SMALLEST_SHARE * reach).max(SMALLEST_RADIUS)
        };
        match self.radius() {
            radius if radius < least => least.max(1.0),
            radius => radius,
        }
    }

    /// Half the surface area, the measure of the surface area heuristic (only ratios matter there).
    pub fn half_area(&self) -> f32 {
        let e = self.extent();
        e.x * e.y + e.y * e.z + e.z * e.x
    }

    /// The box around the image of this box's corners; empty stays empty.
    pub fn transformed(&self, world_from_local: &Affine3A) -> Self {
        if self.is_empty() {
            return Self::EMPTY;
        }
        Self::from_points((0..8).map(|corner| {
            let pick = |bit: u32, lo: f32, hi: f32| if corner >> bit & 1 == 0 { lo } else { hi };
            world_from_local.transform_point3(Vec3::new(
                pick(0, self.min.x, self.max.x),
                pick(1, self.min.y, self.max.y),
                pick(2, self.min.z, self.max.z),
            ))
        }))
    }

    /// Whether the point is in the box or on its faces.
    pub(crate) fn contains_point(&self, point: Vec3) -> bool {
        self.min.cmple(point).all() && point.cmple(self.max).all()
    }

    /// Whether `other` is inside, also on the faces; the empty box is inside every one.
    pub fn contains(&self, other: &Self) -> bool {
        other.is_empty() || (self.min.cmple(other.min).all() && self.max.cmpge(other.max).all())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_camera_cannot_resolve_is_framed_with_a_radius_of_one() {
        let framed = |corner: f32, extent: f32| {
            let corner = Vec3::splat(corner);
            Aabb::from_points([corner, corner + extent * Vec3::X]).framed_radius()
        };
        for (corner, extent, expected) in [
            (0.0, 0.0, 1.0),
            (7.0, 0.0, 1.0),
            (0.0, 1e-30, 1.0),
            (0.0, 1e-6, 0.5e-6),
            (0.0, 1e30, 0.5e30),
            (1e6, 0.25, 10.0),
            (1e6, 30.0, 15.0),
        ] {
            let found = framed(corner, extent);
            assert!(
                (found - expected).abs() <= 1e-6 * expected,
                "{corner} {extent}: {found}"
            );
        }
        assert_eq!((Aabb::EMPTY.framed_radius(), Aabb::EMPTY.radius()), (1.0, 0.0));
    }
}
