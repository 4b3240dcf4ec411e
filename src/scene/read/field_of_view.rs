//! Fields of view, also given as the focal length of a lens on 35 mm film.

use crate::document::Reader;
use crate::scene::FovAxis;

/// The field of view along the diagonal, in degrees, of a lens of `millimetres` on 35 mm film (a frame of 36 x 24 mm).
pub fn fov_of_focal_length(millimetres: f32) -> f32 {
    2.0 * (0.5 * 36f32.hypot(24.0) / millimetres).atan().to_degrees()
}

/// The millimetres of a `focal_length` such as `50mm`; None for other texts.
pub fn millimetres(focal_length: &str) -> Option<f32> {
    let text = focal_length.trim();
    let number = text.strip_suffix("mm").unwrap_or(text).trim().parse::<f32>().ok();
    number.filter(|millimetres| *millimetres > 0.0 && millimetres.is_finite())
}

/// The field of view, from `fov` and `fov_axis` or from `focal_length`.
pub(super) fn read_fov(reader: &mut Reader) -> (f32, FovAxis) {
    let axis = reader.string_or("fov_axis", "x");
    let focal_length = reader.string("focal_length");
    if reader.has("fov") {
        if focal_length.is_some() {
            reader.error_at("focal_length", "`fov` and `focal_length` exclude each other");
        }
        let axis = axis.to_ascii_lowercase();
        let axis = FovAxis::of_name(&axis).unwrap_or_else(|| {
            let message = format!("expected `x`, `y`, `diagonal`, `smaller` or `larger`, found `{axis}`");
            reader.error_at("fov_axis", message);
            FovAxis::X
        });
        let fov = reader.float("fov").unwrap_or(45.0);
        if fov > 0.0 && fov < 180.0 {
            return (fov, axis);
        }
        reader.error_at(
            "fov",
            format!("`fov` is {fov}, but should be above 0 and below 180 degrees"),
        );
        return (45.0, axis);
    }
    let text = focal_length.unwrap_or("50mm");
    match millimetres(text) {
        Some(millimetres) => (fov_of_focal_length(millimetres), FovAxis::Diagonal),
        None => {
            let message = format!("expected a focal length such as `50mm`, found `{text}`");
            reader.error_at("focal_length", message);
            (fov_of_focal_length(50.0), FovAxis::Diagonal)
        }
    }
}
