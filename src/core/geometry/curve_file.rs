//! Reads files of curves.
//!
//! A file is text as Mitsuba 3 has it: a control point in each line, as `x y z radius`, and blank lines between curves.
//! Further words of a line are ignored, as in Mitsuba. Whether the points are those of B-splines or of polylines is
//! told by the shape that names the file.

use glam::{Vec3, Vec4};

use super::decimal::leading_f32;
use super::mesh::MeshData;
use super::mesh_file::{LoadedMesh, MeshError, MeshMemory, Place, excerpt};
use super::obj_lines::Words;
use super::strands::Strands;

/// The most control points: their indices leave four bits for the part of a segment.
const MOST_POINTS: usize = 1 << 28;
/// The bytes of memory that control points take for each byte of text, at most: the shortest line has eight bytes.
const BYTES_PER_BYTE: u64 = 3;

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
        points: Vec::with_capacity(bytes.len() / 8 + 1),
        ..Strands::default()
    };
    let mut is_between = true;
    let mut begins_in = 0;
    for (line, number) in without_mark(bytes).split(|&byte| byte == b'\n').zip(1..) {
        if line.trim_ascii().is_empty() {
            if !is_between {
                end_curve(&mut strands, begins_in)?;
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
        end_curve(&mut strands, begins_in)?;
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

/// Ends the last curve, which begins in this line.
fn end_curve(strands: &mut Strands, line: u64) -> Result<(), MeshError> {
    let first = strands.firsts.last().map_or(0, |&first| first as usize);
    let count = (strands.points.len() - first) as u32;
    if count < 2 {
        let expected = "a curve of two control points or more";
        return Err(MeshError::syntax(
            Place::Line(line),
            expected,
            "one with a single point",
        ));
    }
    if strands.shortest.0 == 0 || count < strands.shortest.0 {
        strands.shortest = (count, line);
    }
    Ok(())
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
    use crate::geometry::curve::Basis;

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
    fn files_of_curves_begin_with_a_number() {
        for text in ["\n -1 0 0 1", "\u{feff}.5 0 0 1", "+1 2 3 4"] {
            assert!(is_curve_file(text.as_bytes()), "{text}");
        }
        for text in ["", "v 1 2 3", "# 1", "ply", "-v", "."] {
            assert!(!is_curve_file(text.as_bytes()), "{text}");
        }
    }
}
