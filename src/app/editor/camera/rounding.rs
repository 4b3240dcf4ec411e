//! Rounds results of tools to short decimal numbers, so that a file says 2 where arithmetic gives 1.999999. Typed
//! numbers are kept as they are.

use bevy::math::Vec3;

/// The finest unit of positions for tools without a pointer, as a share of the scene's extent.
const OF_SCENE: f32 = 1e-4;
/// The share of a length below which a difference is rounding error, not the user's intent.
const RESIDUE: f32 = 1e-6;

/// The largest power of ten that is at most `size`; 0 if `size` is not a positive number. Rounding to 0 changes
/// nothing.
pub fn unit_below(size: f32) -> f64 {
    match size.is_finite() && size > f32::MIN_POSITIVE {
        // Single precision may have a power of ten a little too small.
        true => 10f64.powf((f64::from(size) * (1.0 + 1e-6)).log10().floor()),
        false => 0.0,
    }
}

/// The unit of positions chosen by a pointer: at most half a pixel, whose width is given in world units.
pub(crate) fn unit_of_pixel(pixel: f32) -> f64 {
    unit_below(0.5 * pixel)
}

/// The unit of positions in a scene of this extent.
pub fn unit_of_scene(extent: f32) -> f64 {
    unit_below(OF_SCENE * extent)
}

/// The unit of positions computed from other positions, such as those of aligned things. It is a hundredth of
/// [`unit_of_scene`], because a gap of a whole unit would be visible.
pub fn fine_unit(extent: f32) -> f64 {
    1e-2 * unit_of_scene(extent)
}

/// The nearest multiple of `unit`; never a negative zero.
pub fn rounded(number: f32, unit: f64) -> f32 {
    let multiple = (f64::from(number) / unit).round() * unit;
    match multiple.is_finite() {
        true => multiple as f32 + 0.0,
        false => number,
    }
}

/// Each coordinate [`rounded`].
pub fn rounded_place(place: Vec3, unit: f64) -> Vec3 {
    place.map(|number| rounded(number, unit))
}

/// The number with this many significant digits, at least 1.
pub fn with_digits(number: f32, digits: i32) -> f32 {
    rounded(number, unit_below(number.abs()) * 10f64.powi(1 - digits))
}

/// The sum of numbers in decimal: 0.1 and 0.2 are 0.3.
pub fn sum(one: f32, other: f32) -> f32 {
    (decimal(one) + decimal(other)) as f32 + 0.0
}

/// A multiple of a number in decimal.
pub fn multiple(number: f32, times: u32) -> f32 {
    (decimal(number) * f64::from(times)) as f32 + 0.0
}

/// The shortest decimal that rounds to a number, which is the one that was written.
fn decimal(number: f32) -> f64 {
    number.to_string().parse().unwrap_or(f64::from(number))
}

/// The [`sum`] of each coordinate.
pub fn sum_of_places(one: Vec3, other: Vec3) -> Vec3 {
    Vec3::new(sum(one.x, other.x), sum(one.y, other.y), sum(one.z, other.z))
}

/// A move without rounding errors: if the axis of the move has been turned to x, its y and z become exactly zero.
pub(crate) fn without_residue(by: Vec3) -> Vec3 {
    rounded_place(by, unit_below(RESIDUE * by.abs().max_element()))
}

/// A position moved by `by`, rounded to `unit` in the coordinates that changed.
pub(crate) fn moved(place: Vec3, by: Vec3, unit: f64) -> Vec3 {
    let sum = sum_of_places(place, by);
    Vec3::select(by.cmpne(Vec3::ZERO), rounded_place(sum, unit), place)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_powers_of_ten_below_what_is_asked() {
        for (size, unit) in [(8.0, 1.0), (0.05, 0.01), (1.0, 1.0), (0.0, 0.0), (f32::NAN, 0.0)] {
            assert!((unit_below(size) - unit).abs() < 1e-9, "{size}");
        }
        for extent in [1.0, 8.0] {
            assert!((unit_of_scene(extent) - 1e-4).abs() < 1e-12, "{extent}");
        }
    }

    #[test]
    fn numbers_are_as_people_write_them() {
        assert_eq!(rounded(1.999_999, 1e-3), 2.0);
        assert_eq!(rounded(-2.4e-7, 1e-4).to_string(), "0");
        assert_eq!(rounded(0.123_46, 0.0), 0.123_46);
        assert_eq!(sum(0.1, 0.2).to_string(), "0.3");
        assert_eq!(with_digits(0.012_345_6, 3), 0.0123);
        assert_eq!(with_digits(0.0, 3), 0.0);
    }

    #[test]
    fn only_what_moves_is_rounded() {
        let place = Vec3::new(0.123_456, 1.0, 0.333_333);
        let moved = moved(place, Vec3::new(0.0, 0.123_4, 0.0), 1e-2);
        assert_eq!(moved, Vec3::new(0.123_456, 1.12, 0.333_333));
        let along = without_residue(Vec3::new(-8e-8, 0.0, -1.999_999_9));
        assert_eq!(along, Vec3::new(0.0, 0.0, -2.0));
    }
}
