//! Reads IES LM-63 files of 1986, 1991, 1995, 2002 and 2019 (ANSI/IES LM-63-19, Approved Method: IES Standard File
//! Format for the Electronic Transfer of Photometric Data).
//!
//! Numbers may be spread over lines in any manner. The intensities are multiplied by the factor of the file, the
//! ballast factor, and the tilt factor for a luminaire that is not tilted.

use super::cursor::{Cursor, ProfileError};
use super::distribution::{Distribution, Geometry};

/// The most angles of one kind. Files have up to some 700.
const MOST_ANGLES: usize = 4096;

/// The most lines before the angles. Files have some 20.
const MOST_HEADER_LINES: usize = 1000;

/// Whether a line of the beginning of a file starts with `TILT=`, which every file of the format has.
pub(super) fn is_ies(bytes: &[u8]) -> bool {
    let mut lines = bytes.split(|byte| *byte == b'\n').take(MOST_HEADER_LINES);
    lines.any(|line| tilt_of(line).is_some())
}

/// The rest of a line after `TILT=`.
fn tilt_of(line: &[u8]) -> Option<&[u8]> {
    let line = line.trim_ascii();
    let (key, rest) = line.split_at_checked(5)?;
    key.eq_ignore_ascii_case(b"TILT=").then(|| rest.trim_ascii())
}

pub(super) fn read(text: &str) -> Result<Distribution, ProfileError> {
    let mut cursor = Cursor::new(text);
    let tilt = loop {
        let missing = cursor.error("no line begins with TILT=");
        let line = cursor.next_line().ok_or(missing)?;
        if let Some(tilt) = tilt_of(line.as_bytes()) {
            break tilt;
        }
    };
    // Factors in a file of their own are for luminaires that are tilted.
    let tilt_factor = match tilt.eq_ignore_ascii_case(b"INCLUDE") {
        true => untilted(&mut cursor)?,
        false => 1.0,
    };
    cursor.number("the number of lamps")?;
    cursor.number("the lumens per lamp")?;
    let multiplier = cursor.number("the candela multiplier")?;
    let verticals = cursor.count("the number of vertical angles", 1, MOST_ANGLES)?;
    let horizontals = cursor.count("the number of horizontal angles", 1, MOST_ANGLES)?;
    let geometry = match cursor.count("the photometric type", 1, 3)? {
        1 => Geometry::TypeC,
        2 => Geometry::TypeB,
        _ => Geometry::TypeA,
    };
    cursor.count("the units type", 1, 2)?;
    for side in ["width", "length", "height"] {
        cursor.number(&format!("the {side} of the luminous opening"))?;
    }
    let ballast = cursor.number("the ballast factor")?;
    // The ballast-lamp photometric factor of old files; the origin of the data in those of 2019.
    let ballast_lamp = cursor.number("the field after the ballast factor")?;
    let is_of_2019 = text
        .trim_start()
        .get(..4)
        .is_some_and(|first| first.eq_ignore_ascii_case("IES:"));
    let ballast_lamp = if is_of_2019 || ballast_lamp <= 0.0 {
        1.0
    } else {
        ballast_lamp
    };
    cursor.number("the input watts")?;
    let factor = multiplier * ballast * ballast_lamp * tilt_factor;
    if !(factor >= 0.0 && factor.is_finite()) {
        return Err(cursor.error(format!(
            "the factor on intensities is {factor}, where 0 or more is expected"
        )));
    }
    let vertical = cursor.numbers(verticals, "a vertical angle")?;
    let of_angles = cursor.line();
    let horizontal = cursor.numbers(horizontals, "a horizontal angle")?;
    let mut planes = Vec::new();
    for _ in 0..horizontals {
        let mut plane = cursor.numbers(verticals, "an intensity in candela")?;
        plane.iter_mut().for_each(|candela| *candela *= factor);
        planes.push(plane);
    }
    Distribution::new(geometry, horizontal, vertical, planes).map_err(|message| ProfileError::new(of_angles, message))
}

/// The included factor on the intensity at a tilt of 0 degrees.
fn untilted(cursor: &mut Cursor) -> Result<f64, ProfileError> {
    cursor.count("the lamp-to-luminaire geometry", 1, 3)?;
    let count = cursor.count("the number of tilt angles", 1, MOST_ANGLES)?;
    let angles = cursor.numbers(count, "a tilt angle")?;
    let factors = cursor.numbers(count, "a tilt factor")?;
    let first = angles.iter().position(|angle| *angle == 0.0).unwrap_or(0);
    Ok(factors[first])
}
