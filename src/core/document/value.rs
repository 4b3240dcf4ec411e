//! Parses and formats the values of attributes.

use arrayvec::ArrayVec;
use glam::Vec3;

use crate::color::linear_from_srgb;

/// The most characters of a text that a message quotes.
const LONGEST_QUOTE: usize = 40;

/// Returns the text in backticks, shortened to 40 characters, for messages.
pub fn quote(text: &str) -> String {
    match text.char_indices().nth(LONGEST_QUOTE) {
        Some((end, _)) => format!("`{}...`", &text[..end]),
        None => format!("`{text}`"),
    }
}

/// The error of a value: what was expected, and a quotation of what was found.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what the variants mean")]
pub enum ValueError {
    #[error("expected {expected}, found {found}")]
    Unexpected { expected: &'static str, found: String },
    #[error("{found} is too large for {kind}")]
    TooLarge { kind: &'static str, found: String },
}

pub(super) fn unexpected(expected: &'static str, text: &str) -> ValueError {
    let found = quote(text);
    ValueError::Unexpected { expected, found }
}

fn too_large(kind: &'static str, text: &str) -> ValueError {
    let found = quote(text);
    ValueError::TooLarge { kind, found }
}

/// The elements of a list, separated by blanks, commas or both.
pub fn fields(text: &str) -> impl Iterator<Item = &str> {
    text.split([' ', ',', '\t', '\n', '\r'])
        .filter(|field| !field.is_empty())
}

/// A finite number.
pub fn parse_float(text: &str) -> Result<f32, ValueError> {
    let text = text.trim();
    let digits = || text.contains(|c: char| c.is_ascii_digit());
    match text.parse::<f32>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) if digits() => Err(too_large("a number", text)),
        Ok(_) => Err(unexpected("a finite number", text)),
        Err(_) => Err(unexpected("a number", text)),
    }
}

/// A relative noise, above 0 and up to 1: `0.01` or `1%`.
pub fn parse_noise(text: &str) -> Result<f32, ValueError> {
    let (number, unit) = text.strip_suffix('%').map_or((text, 1.0), |percent| (percent, 0.01));
    // In double precision, so that 5% equals 0.05.
    let noise = number.trim().parse::<f64>().map(|number| (unit * number) as f32);
    noise
        .ok()
        .filter(|noise| *noise > 0.0 && *noise <= 1.0)
        .ok_or_else(|| unexpected("a noise above 0 and up to 1, such as 0.01 or 1%", text))
}

/// A whole number of at most 64 bits.
pub fn parse_integer(text: &str) -> Result<i64, ValueError> {
    use std::num::IntErrorKind::{NegOverflow, PosOverflow};
    let text = text.trim();
    text.parse::<i64>().map_err(|error| match error.kind() {
        PosOverflow | NegOverflow => too_large("an integer", text),
        _ => unexpected("an integer", text),
    })
}

/// Parses "true" or "false"; old files also write "True".
pub fn parse_boolean(text: &str) -> Result<bool, ValueError> {
    let text = text.trim();
    if text.eq_ignore_ascii_case("true") {
        Ok(true)
    } else if text.eq_ignore_ascii_case("false") {
        Ok(false)
    } else {
        Err(unexpected("`true` or `false`", text))
    }
}

/// Parses `x, y, z`.
pub fn parse_vec3(text: &str) -> Result<Vec3, ValueError> {
    match parse_floats(text)?[..] {
        [x, y, z] => Ok(Vec3::new(x, y, z)),
        _ => Err(unexpected("three numbers", text)),
    }
}

/// Parses `x, y, z`, or one number for all three.
pub fn parse_vec3_or_splat(text: &str) -> Result<Vec3, ValueError> {
    match parse_floats(text)?[..] {
        [all] => Ok(Vec3::splat(all)),
        [x, y, z] => Ok(Vec3::new(x, y, z)),
        _ => Err(unexpected("one number or three", text)),
    }
}

/// The most numbers that are read, one more than in the longest value, a matrix.
const MOST_NUMBERS: usize = 17;

/// Parses a list of numbers. Numbers after the seventeenth are ignored.
pub fn parse_floats(text: &str) -> Result<ArrayVec<f32, MOST_NUMBERS>, ValueError> {
    fields(text).take(MOST_NUMBERS).map(parse_float).collect()
}

/// Parses `r, g, b` or one number, linear; or `#rrggbb`, `#rgb`, which are sRGB.
pub fn parse_rgb(text: &str) -> Result<Vec3, ValueError> {
    let text = text.trim();
    if let Some(digits) = text.strip_prefix('#') {
        return parse_hex(digits).ok_or_else(|| unexpected("a colour like `#ff8000`", text));
    }
    match parse_floats(text)?[..] {
        [all] => Ok(Vec3::splat(all)),
        [r, g, b] => Ok(Vec3::new(r, g, b)),
        _ => Err(unexpected("a colour: three numbers, one, or `#rrggbb`", text)),
    }
}

/// Parses a colour as [`parse_rgb`] does, but numbers are sRGB as well: the `<srgb>` of old files.
pub fn parse_srgb(text: &str) -> Result<Vec3, ValueError> {
    let color = parse_rgb(text)?;
    if text.trim().starts_with('#') {
        return Ok(color);
    }
    let linear = color.map(linear_from_srgb);
    match linear.is_finite() {
        true => Ok(linear),
        false => Err(too_large("a colour", text)),
    }
}

fn parse_hex(digits: &str) -> Option<Vec3> {
    let values: Vec<u32> = digits.chars().map(|c| c.to_digit(16)).collect::<Option<_>>()?;
    let bytes = match values[..] {
        [r, g, b] => [r * 17, g * 17, b * 17],
        [r1, r0, g1, g0, b1, b0] => [r1 * 16 + r0, g1 * 16 + g0, b1 * 16 + b0],
        _ => return None,
    };
    Some(Vec3::from_array(
        bytes.map(|byte| linear_from_srgb(byte as f32 / 255.0)),
    ))
}

/// The shortest text that reads back to the same number; `number` is finite.
pub fn format_float(number: f32) -> String {
    let size = number.abs();
    if size != 0.0 && !(1e-4..1e7).contains(&size) {
        format!("{number:e}")
    } else {
        format!("{number}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_what_is_none() {
        assert_eq!(parse_float(" +1.5e1 "), Ok(15.0));
        assert_eq!(parse_float("-.5"), Ok(-0.5));
        assert_eq!(parse_float("3."), Ok(3.0));
        for (text, expected) in [
            ("", "expected a number, found ``"),
            ("0.5f", "expected a number, found `0.5f`"),
            ("nan", "expected a finite number, found `nan`"),
            ("-inf", "expected a finite number, found `-inf`"),
            ("1e39", "`1e39` is too large for a number"),
            ("1,5", "expected a number, found `1,5`"),
        ] {
            assert_eq!(parse_float(text).unwrap_err().to_string(), expected);
        }
        assert_eq!(parse_integer("-12"), Ok(-12));
        let error = parse_integer("1.0").unwrap_err().to_string();
        assert_eq!(error, "expected an integer, found `1.0`");
        let huge = "9".repeat(30);
        assert!(
            parse_integer(&huge)
                .unwrap_err()
                .to_string()
                .ends_with("is too large for an integer")
        );
        assert_eq!(parse_boolean("True"), Ok(true));
        assert!(parse_boolean("1").is_err());
        assert!(parse_float(&"x".repeat(10_000)).unwrap_err().to_string().len() < 100);
    }

    #[test]
    fn colours() {
        assert_eq!(parse_rgb("0.1 , 0.2,0.3"), Ok(Vec3::new(0.1, 0.2, 0.3)));
        assert_eq!(parse_rgb("0.5"), Ok(Vec3::splat(0.5)));
        assert_eq!(parse_rgb("#fff"), Ok(Vec3::ONE));
        assert_eq!(parse_rgb("#808080"), Ok(Vec3::splat(linear_from_srgb(128.0 / 255.0))));
        assert_eq!(parse_srgb("#808080"), parse_rgb("#808080"));
        assert_eq!(parse_srgb("0.5"), Ok(Vec3::splat(linear_from_srgb(0.5))));
        let error = parse_srgb("1e38").unwrap_err().to_string();
        assert_eq!(error, "`1e38` is too large for a colour");
        for bad in ["#ff", "#gggggg", "#ffééé", "1, 2", "1 2 3 4", "red"] {
            assert!(parse_rgb(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn floats_read_back() {
        for number in [
            0.0,
            -0.0,
            1.0,
            0.1,
            1e-30,
            3.402_823_5e38,
            1e-45,
            16_777_216.0,
            123_456.79,
            -1e-4,
        ] {
            let text = format_float(number);
            assert_eq!(parse_float(&text).map(f32::to_bits), Ok(number.to_bits()), "{text}");
            assert!(text.len() <= 14, "{text}");
        }
    }
}
