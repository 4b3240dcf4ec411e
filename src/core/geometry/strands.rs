//! Curves as lists of control points.

use glam::{Affine3A, DMat3, Mat3, Vec4, Vec4Swizzles};

use super::curve::Basis;
use crate::math::Aabb;

/// Curves of varying radius, as lists of control points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Strands {
    /// The control points of all curves, one curve after the other: positions, and radii of at least 0 as the fourth
    /// coordinate. All are finite.
    pub points: Vec<Vec4>,
    /// The index of the first point of each curve, ascending from 0.
    pub firsts: Vec<u32>,
    /// The number of points of the shortest curve, and the 1-based line in which it begins; zero if there is none.
    pub shortest: (u32, u64),
}

/// The bytes of an acceleration structure for each part of a segment, as many as are needed while it is built.
const HIERARCHY_BYTES: u64 = 250;
/// The most times that a segment is halved in an acceleration structure.
pub(crate) const MOST_HALVINGS: u32 = 3;
/// The most parts into which all segments together are cut. A hierarchy of as many takes 25 MB; larger ones wait for
/// memory longer than they save tests.
const MOST_PARTS: usize = 1 << 19;

/// The times that each of so many segments may be halved.
pub(crate) fn halvings_of(segments: usize) -> u32 {
    (MOST_PARTS / segments.max(1)).max(1).ilog2().min(MOST_HALVINGS)
}

impl Strands {
    /// Whether there are no curves.
    pub fn is_empty(&self) -> bool {
        self.firsts.is_empty()
    }

    /// The box around all control points with their radii, which holds the curves of either basis.
    pub fn bounds(&self) -> Aabb {
        self.bounds_in(&Affine3A::IDENTITY)
    }

    /// The box that holds the curves of either basis after a transform, which leaves radii alone.
    pub fn bounds_in(&self, world_from_local: &Affine3A) -> Aabb {
        let boxes = self.points.iter().map(|point| {
            let place = world_from_local.transform_point3(point.xyz());
            Aabb {
                min: place - point.w,
                max: place + point.w,
            }
        });
        boxes.fold(Aabb::EMPTY, Aabb::union)
    }

    /// Memory held by the arrays, in bytes.
    pub fn heap_bytes(&self) -> usize {
        self.points.capacity() * size_of::<Vec4>() + self.firsts.capacity() * size_of::<u32>()
    }

    /// The most parts that an acceleration structure of the curves has boxes for.
    pub fn most_parts(&self, basis: Basis) -> usize {
        let segments = self.points.len();
        match basis {
            Basis::BSpline => segments.max(MOST_PARTS.min(segments << MOST_HALVINGS)),
            Basis::Linear => segments,
        }
    }

    /// Memory of an acceleration structure over the curves, in bytes.
    pub(super) fn hierarchy_bytes(&self) -> u64 {
        HIERARCHY_BYTES * self.most_parts(Basis::BSpline) as u64
    }

    /// The ranges of control points of the curves, in order.
    pub fn curves(&self) -> impl Iterator<Item = std::ops::Range<usize>> {
        let ends = self.firsts.iter().skip(1).map(|&first| first as usize);
        let starts = self.firsts.iter().map(|&first| first as usize);
        starts
            .zip(ends.chain([self.points.len()]))
            .map(|(start, end)| start..end)
    }

    /// The index of the first control point of each segment.
    pub fn segments(&self, basis: Basis) -> impl Iterator<Item = u32> {
        let beyond = basis.points() - 1;
        self.curves()
            .flat_map(move |curve| curve.start..curve.end.saturating_sub(beyond).max(curve.start))
            .map(|start| start as u32)
    }

    /// The number of all segments.
    pub fn segment_count(&self, basis: Basis) -> usize {
        self.curves()
            .map(|curve| (curve.len() + 1).saturating_sub(basis.points()))
            .sum()
    }

    /// The number of the segment that begins with the control point `start`, counted from 0 over all curves.
    pub(crate) fn segment_number(&self, start: u32, basis: Basis) -> usize {
        let curves_before = self.firsts.partition_point(|&first| first <= start).saturating_sub(1);
        (start as usize).saturating_sub(curves_before * (basis.points() - 1))
    }

    /// Whether a curve begins with this control point.
    #[inline]
    pub(crate) fn is_first(&self, point: u32) -> bool {
        self.firsts.binary_search(&point).is_ok()
    }

    /// Transforms the positions of control points, not their radii.
    pub(super) fn stretch(&mut self, by: &Mat3) {
        for point in &mut self.points {
            *point = (*by * point.xyz()).extend(point.w);
        }
    }
}

/// The part of a transform that changes distances: the transform is a rotation and a translation after it. A transform
/// of curves moves their control points and leaves their radii, as in Mitsuba, so that curves are traced after this
/// part, and placed by the rest alone. It is rounded, so that curves that are moved or turned keep theirs bit by bit,
/// unless it is so flat that their radii would be off. It is the identity for a transform that cannot be inverted.
pub fn stretch_of(world_from_local: &Affine3A) -> Mat3 {
    let linear = world_from_local.as_daffine3().matrix3;
    let side = linear.determinant().signum();
    // The rotation next to the transform (Higham, Computing the polar decomposition, 1986).
    let mut rotation = side * linear;
    for _ in 0..64 {
        let next = 0.5 * (rotation + rotation.inverse().transpose());
        let is_settled = next.abs_diff_eq(rotation, 1e-14);
        rotation = next;
        if is_settled {
            break;
        }
    }
    let stretch = rotation.transpose() * linear;
    let unit = (largest_of(&stretch) * ROUNDED_TO).log2().ceil().exp2();
    // One over the largest number of the inverse is near the smallest factor by which a distance is scaled.
    let is_flat = largest_of(&stretch.inverse()) * unit > ROUNDED_FROM.recip();
    let rounded = |number: f64| match is_flat {
        true => number,
        // The sum has no zero with a sign.
        false => (number / unit).round() * unit + 0.0,
    };
    let stretch = DMat3::from_cols_array(&stretch.to_cols_array().map(rounded)).as_mat3();
    match stretch.is_finite() && stretch.inverse().is_finite() {
        true => stretch,
        false => Mat3::IDENTITY,
    }
}

/// The largest absolute value of a matrix.
fn largest_of(matrix: &DMat3) -> f64 {
    matrix.to_cols_array().into_iter().map(f64::abs).fold(0.0, f64::max)
}

/// The unit to which a stretch is rounded, as a share of its largest number; it is a power of two up to twice as large.
const ROUNDED_TO: f64 = 1.0 / 16384.0;
/// A stretch that scales a distance by less than so many units is not rounded: radii would be off by over a hundredth.
const ROUNDED_FROM: f64 = 100.0;

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn curves_that_are_turned_keep_their_stretch() {
        let scales = [
            Vec3::ONE,
            Vec3::splat(2.5),
            Vec3::new(1.0, -2.0, 3.0),
            Vec3::splat(-1e-4),
        ];
        for scale in scales {
            let scaled = Mat3::from_diagonal(scale);
            for turns in 0..50 {
                let turned = Mat3::from_euler(glam::EulerRot::XYZ, 0.3 * turns as f32, 1.7, -0.9 * turns as f32);
                let stretch = stretch_of(&Affine3A::from_mat3_translation(turned * scaled, Vec3::ONE));
                let same = match scale == Vec3::splat(scale.x) {
                    true => scaled,
                    // A mirror turned by half a turn about its axis is the same as all axes mirrored.
                    false => stretch_of(&Affine3A::from_mat3(scaled)),
                };
                assert!(
                    stretch.abs_diff_eq(same, 2.0 / 16384.0 * scale.abs().max_element()),
                    "{stretch} {same}"
                );
                let rest = turned * scaled * stretch.inverse();
                assert!((rest * rest.transpose()).abs_diff_eq(Mat3::IDENTITY, 1e-3) && rest.determinant() > 0.0);
            }
        }
        let bits = |stretch: Mat3| stretch.to_cols_array().map(f32::to_bits);
        for turns in 0..50 {
            let turned = Affine3A::from_rotation_x(0.7 * turns as f32) * Affine3A::from_rotation_z(1.3 * turns as f32);
            assert_eq!(bits(stretch_of(&turned)), bits(Mat3::IDENTITY), "zeros have one sign");
        }
        for singular in [
            Mat3::ZERO,
            Mat3::from_diagonal(Vec3::new(1.0, 0.0, 1.0)),
            Mat3::from_diagonal(Vec3::NAN),
        ] {
            assert_eq!(stretch_of(&Affine3A::from_mat3(singular)), Mat3::IDENTITY);
        }
    }
    #[test]
    fn flat_transforms_keep_the_radii() {
        for thickness in [0.03, 1e-3, 2e-5] {
            for turns in 0..20 {
                let turned = Mat3::from_euler(glam::EulerRot::XYZ, 0.3 * turns as f32, 1.7, -0.9 * turns as f32);
                let first = Mat3::from_rotation_y(0.2 * turns as f32);
                let placed = turned * Mat3::from_diagonal(Vec3::new(1.0, 1.0, thickness)) * first;
                let stretch = stretch_of(&Affine3A::from_mat3(placed));
                let rest = placed.as_dmat3() * stretch.as_dmat3().inverse();
                let off = rest * rest.transpose() - DMat3::IDENTITY;
                let off = off.to_cols_array().map(f64::abs).into_iter().fold(0.0, f64::max);
                assert!(off < 0.02, "{thickness} {turns}: {off}");
            }
        }
    }
    #[test]
    fn bounds_after_a_transform_have_the_same_radii() {
        let strands = Strands {
            points: vec![Vec4::new(1.0, 0.0, 0.0, 0.5), Vec4::new(2.0, 1.0, 0.0, 0.25)],
            firsts: vec![0],
            shortest: (2, 1),
        };
        let bounds = strands.bounds_in(&Affine3A::from_scale(Vec3::splat(10.0)));
        assert_eq!(
            (bounds.min, bounds.max),
            (Vec3::new(9.5, -0.5, -0.5), Vec3::new(20.25, 10.25, 0.5))
        );
    }
}
