//! Colours of OpenEXR pictures in other primaries than those of Rec. 709.
//!
//! The physical light of a colour is kept: there is no adaptation to another white point, as in Mitsuba and in the
//! functions of OpenEXR itself.

use exr::meta::attribute::Chromaticities;
use exr::prelude::Vec2;
use glam::{DMat3, DVec3};

use super::image::Samples;

/// The primaries and the white of Rec. 709.
const REC_709: [[f32; 2]; 4] = [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], [0.3127, 0.329]];
/// Coordinates that differ from [`REC_709`] by less count as equal: programs round them.
const AS_GOOD_AS_EQUAL: f32 = 1e-3;

/// Converts pixels of three channels to Rec. 709. They are unchanged if they have its primaries already, or if the
/// file's primaries are degenerate.
pub(super) fn to_rec709(samples: Samples, file: &Chromaticities) -> Samples {
    let points = [file.red, file.green, file.blue, file.white].map(|Vec2(x, y)| [x, y]);
    let differs = |(a, b): (&[f32; 2], &[f32; 2])| (0..2).any(|i| (a[i] - b[i]).abs() > AS_GOOD_AS_EQUAL);
    if !points.iter().zip(&REC_709).any(differs) {
        return samples;
    }
    let (Some(of_file), Some(of_rec_709)) = (xyz_from_rgb(points), xyz_from_rgb(REC_709)) else {
        return samples;
    };
    let matrix = (of_rec_709.inverse() * of_file).as_mat3();
    let mut floats = match samples {
        Samples::F16(halves) => halves.into_iter().map(|half| half.to_f32()).collect(),
        Samples::F32(floats) => floats,
        integers => return integers,
    };
    for pixel in floats.as_chunks_mut::<3>().0 {
        *pixel = (matrix * glam::Vec3::from(*pixel)).to_array();
    }
    Samples::F32(floats)
}

/// The matrix from colours to XYZ that gives white a Y of 1. None if the primaries lie on a line or white has no
/// luminance.
fn xyz_from_rgb([red, green, blue, white]: [[f32; 2]; 4]) -> Option<DMat3> {
    let column = |[x, y]: [f32; 2]| DVec3::new(x.into(), y.into(), 1.0 - f64::from(x) - f64::from(y));
    let primaries = DMat3::from_cols(column(red), column(green), column(blue));
    let white = column(white) / f64::from(white[1]);
    let matrix = primaries * DMat3::from_diagonal(primaries.inverse() * white);
    let is_sound = matrix.is_finite() && matrix.determinant().abs() > 1e-9;
    is_sound.then_some(matrix)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_matrix_of_rec_709_is_the_known_one() {
        let matrix = xyz_from_rgb(REC_709).unwrap();
        let known = [
            [0.4124, 0.2126, 0.0193],
            [0.3576, 0.7152, 0.1192],
            [0.1805, 0.0722, 0.9505],
        ];
        for (column, known) in [matrix.x_axis, matrix.y_axis, matrix.z_axis].into_iter().zip(known) {
            assert!(column.abs_diff_eq(known.into(), 2e-4), "{column} {known:?}");
        }
    }

    #[test]
    fn primaries_that_span_nothing_are_left_alone() {
        for wrong in [[[0.0; 2]; 4], [[0.3; 2]; 4], [[f32::NAN; 2]; 4]] {
            assert!(xyz_from_rgb(wrong).is_none(), "{wrong:?}");
        }
    }
}
