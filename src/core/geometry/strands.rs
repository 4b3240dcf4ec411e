//! The control points of curves, and the reader of their files.
//!
//! A file is text as Mitsuba 3 has it: a control point in each line, as `x y z radius`, and blank lines between curves.
//! Further words of a line are ignored, as in Mitsuba. Whether the points are those of B-splines or of polylines is
//! told by the shape that names the file.

use glam::{Affine3A, DMat3, Mat3, Vec3, Vec4, Vec4Swizzles};

use super::curve::Basis;
use super::decimal::leading_f32;
use super::mesh::MeshData;
use super::mesh_file::{LoadedMesh, MeshError, MeshMemory, Place, excerpt};
use super::obj_lines::Words;
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

/// The most control points: their indices leave four bits for the part of a segment.
const MOST_POINTS: usize = 1 << 28;
/// The bytes of memory that control points take for each byte of text, at most: the shortest line has eight bytes.
const BYTES_PER_BYTE: u64 = 3;
/// The bytes of an acceleration structure for each control point, a little more than are needed while it is built.
const HIERARCHY_BYTES: u64 = 250;

impl Strands {
    /// Whether there are no curves.
    pub fn is_empty(&self) -> bool {
        self.firsts.is_empty()
    }

    /// The box around all control points with their radii, which holds the curves of either basis.
    pub fn bounds(&self) -> Aabb {
        self.points
            .iter()
            .map(|point| Aabb {
                min: point.xyz() - point.w,
                max: point.xyz() + point.w,
            })
            .fold(Aabb::EMPTY, Aabb::union)
    }

    /// Memory held by the arrays, in bytes.
    pub fn heap_bytes(&self) -> usize {
        self.points.capacity() * size_of::<Vec4>() + self.firsts.capacity() * size_of::<u32>()
    }

    /// Memory of an acceleration structure over the curves, in bytes.
    pub(super) fn hierarchy_bytes(&self) -> u64 {
        HIERARCHY_BYTES * self.points.len() as u64
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
/// part, and placed by the rest alone. It is rounded, so that curves that are moved or turned keep theirs.
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
    let largest = [stretch.x_axis, stretch.y_axis, stretch.z_axis].map(|axis| axis.abs().max_element());
    let unit = (largest[0].max(largest[1]).max(largest[2]) * ROUNDED_TO)
        .log2()
        .ceil()
        .exp2();
    let rounded =
        DMat3::from_cols_array(&stretch.to_cols_array().map(|number| (number / unit).round() * unit)).as_mat3();
    // A transform that cannot be inverted has no such part, and its shape is left out.
    match rounded.is_finite() && rounded.determinant() != 0.0 {
        true => rounded,
        false => Mat3::IDENTITY,
    }
}

/// The unit to which a stretch is rounded, as a share of its largest number. Radii are off by as much.
const ROUNDED_TO: f64 = 1.0 / 16384.0;

/// Whether a text is a file of curves: its first word is a number, with which no other format begins.
pub fn is_curve_file(bytes: &[u8]) -> bool {
    let text = without_mark(bytes).trim_ascii_start();
    let digits = text.strip_prefix(b"-").or(text.strip_prefix(b"+")).unwrap_or(text);
    matches!(digits, [b'0'..=b'9', ..] | [b'.', b'0'..=b'9', ..])
}

/// Reads a file of curves, which become the strands of a mesh without triangles. Errors name the line.
pub fn load_curves(bytes: &[u8]) -> Result<LoadedMesh, MeshError> {
    let length = bytes.len() as u64;
    let memory = MeshMemory::reserve(BYTES_PER_BYTE * length, || format!("{length} bytes of text"))?;
    let mut strands = Strands {
        points: Vec::with_capacity(bytes.len() / 32),
        ..Strands::default()
    };
    let mut is_between = true;
    let mut begins_in = 0;
    for (line, number) in without_mark(bytes).split(|&byte| byte == b'\n').zip(1..) {
        if line.trim_ascii().is_empty() {
            if !is_between {
                strands.end_curve(begins_in)?;
            }
            is_between = true;
            continue;
        }
        if std::mem::replace(&mut is_between, false) {
            strands.firsts.push(strands.points.len() as u32);
            begins_in = number;
        }
        strands.points.push(control_point(line, Place::Line(number))?);
        if strands.points.len() > MOST_POINTS {
            return Err(MeshError::TooLarge {
                what: "the number of control points",
                limit: MOST_POINTS as u64,
            });
        }
    }
    if !is_between {
        strands.end_curve(begins_in)?;
    }
    strands.points.shrink_to_fit();
    let mesh = MeshData {
        strands,
        ..MeshData::default()
    };
    Ok(LoadedMesh {
        mesh: memory.hold(mesh)?,
        warnings: Vec::new(),
    })
}

impl Strands {
    /// Ends the last curve, which begins in this line.
    fn end_curve(&mut self, line: u64) -> Result<(), MeshError> {
        let first = self.firsts.last().map_or(0, |&first| first as usize);
        let count = (self.points.len() - first) as u32;
        if count < 2 {
            let expected = "a curve of two control points or more";
            return Err(MeshError::syntax(
                Place::Line(line),
                expected,
                "one with a single point",
            ));
        }
        if self.shortest.0 == 0 || count < self.shortest.0 {
            self.shortest = (count, line);
        }
        Ok(())
    }
}

fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

fn control_point(line: &[u8], place: Place) -> Result<Vec4, MeshError> {
    let mut words = Words::new(line);
    let mut numbers = [0.0; 4];
    for number in &mut numbers {
        let parsed = words.next_if(leading_f32).or_else(|| {
            let word = std::str::from_utf8(words.next()?).ok()?;
            word.parse().ok()
        });
        *number = parsed.ok_or_else(|| MeshError::syntax(place, "a control point `x y z radius`", excerpt(line)))?;
    }
    let point = Vec4::from_array(numbers);
    if !Vec3::from_slice(&numbers).is_finite() {
        return Err(MeshError::NotFinite { place });
    }
    if !(0.0..f32::INFINITY).contains(&point.w) {
        let expected = "a finite radius of at least 0";
        return Err(MeshError::syntax(place, expected, excerpt(line)));
    }
    Ok(point)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(text: &str) -> Result<Strands, String> {
        match load_curves(text.as_bytes()) {
            Ok(loaded) => Ok(loaded.mesh.strands),
            Err(error) => Err(error.to_string()),
        }
    }

    #[test]
    fn blank_lines_separate_curves() {
        let strands = load("\n 0 0 0 .5\r\n1 0 0 0.25 further words\r\n\r\n \t\n1e1 -2 3 0\n4 5 6 1\n7 8 9 1").unwrap();
        assert_eq!(strands.firsts, [0, 2]);
        assert_eq!(strands.points[1], Vec4::new(1.0, 0.0, 0.0, 0.25));
        assert_eq!(strands.points[2], Vec4::new(10.0, -2.0, 3.0, 0.0));
        assert_eq!(strands.shortest, (2, 2));
        let bounds = strands.bounds();
        assert_eq!(
            (bounds.min, bounds.max),
            (Vec3::new(-0.5, -2.0, -0.5), Vec3::new(10.0, 9.0, 10.0))
        );
        assert_eq!(strands.segments(Basis::Linear).collect::<Vec<_>>(), [0, 2, 3]);
        assert_eq!(strands.segment_count(Basis::Linear), 3);
        assert_eq!(
            [0, 2, 3].map(|start| strands.segment_number(start, Basis::Linear)),
            [0, 1, 2]
        );
        assert_eq!(strands.segments(Basis::BSpline).count(), 0);
        assert_eq!(strands.segment_count(Basis::BSpline), 0);
    }

    #[test]
    fn segments_of_splines_begin_with_all_points_but_three() {
        let curve = "0 0 0 1\n1 0 0 1\n2 0 0 1\n3 0 0 1\n4 0 0 1\n";
        let strands = load(&[curve, curve].join("\n")).unwrap();
        assert_eq!(strands.segments(Basis::BSpline).collect::<Vec<_>>(), [0, 1, 5, 6]);
        assert_eq!(
            [0, 1, 5, 6].map(|start| strands.segment_number(start, Basis::BSpline)),
            [0, 1, 2, 3]
        );
    }

    #[test]
    fn errors_name_the_line() {
        let cases = [
            (
                "0 0 0 1\n1 0 0\n",
                "line 2: expected a control point `x y z radius`, found `1 0 0`",
            ),
            (
                "0 0 0 1\n0,0,0,1\n",
                "line 2: expected a control point `x y z radius`, found `0,0,0,1`",
            ),
            ("0 0 0 1\n1 inf 0 1\n", "line 2: a vertex position is not finite"),
            (
                "0 0 0 1\n1 0 0 -1\n",
                "line 2: expected a finite radius of at least 0, found `1 0 0 -1`",
            ),
            (
                "0 0 0 1\n1 0 0 nan\n",
                "line 2: expected a finite radius of at least 0, found `1 0 0 nan`",
            ),
            (
                "0 0 0 1\n1 0 0 1\n\n2 0 0 1\n",
                "line 4: expected a curve of two control points or more, found one with a single point",
            ),
        ];
        for (text, expected) in cases {
            assert_eq!(load(text), Err(expected.to_owned()));
        }
    }

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
        assert_eq!(stretch_of(&Affine3A::from_rotation_x(0.7)), Mat3::IDENTITY);
        for singular in [
            Mat3::ZERO,
            Mat3::from_diagonal(Vec3::new(1.0, 0.0, 1.0)),
            Mat3::from_diagonal(Vec3::NAN),
        ] {
            assert_eq!(stretch_of(&Affine3A::from_mat3(singular)), Mat3::IDENTITY);
        }
    }

    #[test]
    fn files_of_curves_begin_with_a_number() {
        for text in ["\n -1 0 0 1", "\u{feff}.5 0 0 1", "+1 2 3 4"] {
            assert!(is_curve_file(text.as_bytes()), "{text}");
        }
        for text in ["", "v 1 2 3", "# 1", "ply", "-v", "."] {
            assert!(!is_curve_file(text.as_bytes()), "{text}");
        }
    }
}
