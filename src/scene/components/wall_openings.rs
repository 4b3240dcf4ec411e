//! Openings of walls, and their text in files.

use bevy::reflect::Reflect;

use crate::document::value::{ValueError, fields, format_float, parse_float};

/// The most openings of a wall, so that the mesh of a mistyped file stays small.
pub(in crate::scene) const MOST_OPENINGS: usize = 64;

/// A rectangular opening through a wall. Parts beyond the wall are ignored, and openings may overlap.
#[derive(Reflect, Clone, Copy, Debug, Default, PartialEq)]
pub struct Opening {
    /// The distance of its nearer edge from the wall's start.
    pub from: f32,
    /// The height of the lower edge above the wall's foot; 0 for a door or a French window.
    pub sill: f32,
    /// The extent along the wall, above 0.
    pub width: f32,
    /// The extent upwards, above 0.
    pub height: f32,
}

impl Opening {
    /// A door in metres.
    pub const DOOR: Self = Self {
        from: 0.5,
        sill: 0.0,
        width: 0.9,
        height: 2.1,
    };
    /// A window in metres.
    pub const WINDOW: Self = Self {
        from: 0.5,
        sill: 0.9,
        width: 1.2,
        height: 1.2,
    };

    /// A window that reaches the floor, in metres. It ends at the height of the others.
    pub const FRENCH_WINDOW: Self = Self {
        from: 0.5,
        sill: 0.0,
        width: 1.6,
        height: 2.1,
    };

    /// The opening for a wall of this height: unchanged for a wall of a room in metres, otherwise in proportion.
    pub fn in_wall(self, height: f32) -> Self {
        const ROOMS: std::ops::RangeInclusive<f32> = 2.2..=12.0;
        const USUAL: f32 = 2.5;
        let factor = if ROOMS.contains(&height) { 1.0 } else { height / USUAL };
        Self {
            from: self.from * factor,
            sill: self.sill * factor,
            width: self.width * factor,
            height: self.height * factor,
        }
    }
}

/// The text of openings in a file: four numbers for each (from, sill, width, height), with `;` between the openings.
pub fn openings_text(openings: &[Opening]) -> String {
    let text = |opening: &Opening| {
        let numbers = [opening.from, opening.sill, opening.width, opening.height];
        numbers.map(format_float).join(" ")
    };
    openings.iter().map(text).collect::<Vec<_>>().join("; ")
}

/// The reason why a text gives no openings.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OpeningsError {
    /// A part of the text is not a number.
    #[error(transparent)]
    Value(#[from] ValueError),
    /// An opening has more or fewer than four numbers.
    #[error("expected four numbers (from, sill, width, height), found `{0}`")]
    Numbers(String),
    /// An opening has no width or height.
    #[error("expected openings with a width and a height above 0")]
    Extent,
    /// There are more openings than a part may have.
    #[error("expected at most {most} openings, found {0}", most = MOST_OPENINGS)]
    Count(usize),
}

/// Parses the text of openings.
pub fn parse_openings(text: &str) -> Result<Vec<Opening>, OpeningsError> {
    let mut openings = Vec::new();
    for part in text.split(';').filter(|part| !part.trim().is_empty()) {
        let numbers: Vec<f32> = fields(part).map(parse_float).collect::<Result<_, _>>()?;
        let &[from, sill, width, height] = numbers.as_slice() else {
            return Err(OpeningsError::Numbers(part.trim().to_owned()));
        };
        if !(width > 0.0 && height > 0.0) {
            return Err(OpeningsError::Extent);
        }
        openings.push(Opening {
            from,
            sill,
            width,
            height,
        });
    }
    match openings.len() {
        0..=MOST_OPENINGS => Ok(openings),
        count => Err(OpeningsError::Count(count)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn openings_are_read_as_they_are_written() {
        let door = Opening {
            from: 0.5,
            sill: 0.0,
            width: 0.9,
            height: 2.1,
        };
        let window = Opening { sill: 0.9, ..door };
        assert_eq!(openings_text(&[door, window]), "0.5 0 0.9 2.1; 0.5 0.9 0.9 2.1");
        for openings in [vec![], vec![door], vec![door, window]] {
            assert_eq!(parse_openings(&openings_text(&openings)), Ok(openings));
        }
        assert_eq!(parse_openings(" 0.5, 0, 0.9, 2.1 ; "), Ok(vec![door]));
    }

    #[test]
    fn openings_that_are_none_are_refused_with_what_is_expected() {
        for text in ["1 2 3", "1 2 3 4 5", "1 2 x 4", "1 2 0 4", "1 2 3 -4", "1 2 nan 4"] {
            assert!(
                parse_openings(text).is_err_and(|error| {
                    let error = error.to_string();
                    error.starts_with("expected") || error.contains("number")
                }),
                "{text}"
            );
        }
        assert!(parse_openings(&"0 0 1 1;".repeat(65)).is_err());
    }
}
