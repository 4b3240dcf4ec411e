//! The sizes of several selected things, for the row that sets them together.

use bevy::math::Vec3;

use crate::math::Aabb;

/// The sizes of several things.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sizes {
    /// The extents of the active thing along the axes of the world, in world units.
    pub active: Vec3,
    /// For each axis whether all of them have that extent.
    pub is_common: [bool; 3],
}

impl Sizes {
    /// The largest difference of equal sizes, as a share of them, since bounds are rounded.
    const ROUNDING: f32 = 1e-5;

    /// The sizes of things with these bounds, the active one last; None for fewer than two. Things without bounds, such
    /// as groups, count as different from all others.
    pub fn of(each: impl Iterator<Item = Option<Aabb>>) -> Option<Self> {
        let each: Vec<Option<Aabb>> = each.collect();
        let extents: Vec<Vec3> = each.iter().flatten().map(Aabb::extent).collect();
        let [others @ .., active] = &extents[..] else {
            return None;
        };
        if each.len() < 2 {
            return None;
        }
        let largest = extents.iter().copied().fold(Vec3::ZERO, Vec3::max);
        let is_same = |axis: usize, other: &Vec3| (other[axis] - active[axis]).abs() <= Self::ROUNDING * largest[axis];
        Some(Self {
            active: *active,
            is_common: [0, 1, 2]
                .map(|axis| extents.len() == each.len() && others.iter().all(|other| is_same(axis, other))),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_common_where_all_have_them() {
        let bounds = |extent: Vec3, at: f32| Aabb {
            min: Vec3::splat(at),
            max: Vec3::splat(at) + extent,
        };
        let each = [
            bounds(Vec3::new(1.0, 2.0, 3.0), 0.3),
            bounds(Vec3::new(1.0, 2.1, 3.0), 70.0),
        ];
        let each = each.map(Some);
        assert_eq!(Sizes::of(each[..1].iter().copied()), None);
        let sizes = Sizes::of([&each[..], &[None]].concat().into_iter()).expect("three");
        assert_eq!(sizes.is_common, [false; 3]);
        let sizes = Sizes::of(each.into_iter()).expect("two");
        assert_eq!(sizes.is_common, [true, false, true]);
        assert!(sizes.active.abs_diff_eq(Vec3::new(1.0, 2.1, 3.0), 1e-4));
    }
}
