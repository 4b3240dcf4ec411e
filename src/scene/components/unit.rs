//! The unit of length of a scene: the length of a unit of the world, for typing and display. It does not change the
//! picture.
//!
//! The file has it as `<default name="length_unit" value="cm"/>`, which other readers of the format take for an unused
//! name.

use bevy::prelude::*;

declare_names! {
    /// The unit of length of a scene. Its name is also the sign after a number.
    #[derive(Resource, Reflect, Clone, Copy, Debug, Default, PartialEq, Eq)]
    #[reflect(Resource, PartialEq)]
    pub enum LengthUnit {
        /// No unit is given; lengths with a unit are converted as if it were metres.
        #[default]
        None = "" => "none",
        /// A unit of the world is a metre.
        Metre = "m" => "metres",
        /// A unit of the world is a centimetre.
        Centimetre = "cm" => "centimetres",
        /// A unit of the world is a millimetre.
        Millimetre = "mm" => "millimetres",
        /// A unit of the world is an inch.
        Inch = "in" => "inches",
        /// A unit of the world is a foot.
        Foot = "ft" => "feet",
    }
}

/// The units that may follow a number, in metres. The marks of feet and inches come last, so that the list begins with
/// the names in files.
const UNITS: [(&str, f64); 9] = [
    ("m", 1.0),
    ("cm", 0.01),
    ("mm", 0.001),
    ("in", 0.0254),
    ("ft", 0.3048),
    ("km", 1000.0),
    ("'", 0.3048),
    ("\"", 0.0254),
    ("″", 0.0254),
];

impl LengthUnit {
    /// The length of a unit of the world in metres.
    pub fn metres(self) -> f64 {
        let name = self.name();
        let known = UNITS.iter().find(|(unit, _)| *unit == name);
        known.map_or(1.0, |(_, metres)| *metres)
    }

    /// Parses a length to units of the world: a number, or numbers with units such as `2m`, `30 cm`, `6'`, `4in` or
    /// `6'2"`. A number without a unit is in units of the world. None for any other text.
    pub fn parse(self, text: &str) -> Option<f64> {
        let text = text.trim();
        let (sign, mut rest) = match text.strip_prefix('-') {
            Some(rest) => (-1.0, rest.trim_start()),
            None => (1.0, text),
        };
        if let Some(number) = decimal(text) {
            return Some(number);
        }
        let mut metres = 0.0;
        while !rest.is_empty() {
            let end = rest.find(|c: char| !c.is_ascii_digit() && c != '.' && c != ',')?;
            let number = decimal(&rest[..end])?;
            rest = rest[end..].trim_start();
            let length = rest
                .find(|c: char| c.is_ascii_digit() || c == '.' || c.is_whitespace())
                .unwrap_or(rest.len());
            let (_, unit) = UNITS.iter().find(|(name, _)| *name == &rest[..length])?;
            metres += number * unit;
            rest = rest[length..].trim_start();
        }
        let length = sign * metres / self.metres();
        (text.len() > 1 && length.is_finite()).then_some(length)
    }

    /// Formats a length in units of the world with the sign of the unit: at most three decimals, or more for small
    /// numbers.
    pub fn text(self, length: f32) -> String {
        self.number(length) + &self.sign()
    }

    /// The sign after a number, with a blank before it; empty for no unit.
    pub fn sign(self) -> String {
        match self.name() {
            "" => String::new(),
            name => format!(" {name}"),
        }
    }

    /// The number of [`Self::text`].
    pub fn number(self, length: f32) -> String {
        rounded(length)
    }

    /// Whether an incomplete text may continue with more letters of a unit.
    pub fn begins_unit(text: &str) -> bool {
        UNITS.iter().any(|(name, _)| name.starts_with(text))
    }
}

/// Parses a finite number without a unit. A comma counts as the decimal point if there is no other comma and no point.
pub(crate) fn decimal(text: &str) -> Option<f64> {
    let text = match text.matches([',', '.']).count() {
        1 => text.replace(',', "."),
        _ => text.to_owned(),
    };
    // `parse` accepts names of infinity, too.
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

fn rounded(length: f32) -> String {
    let size = length.abs();
    let decimals = match size {
        _ if !size.is_finite() => 0,
        1000.0.. => 1,
        0.1.. => 3,
        _ if size == 0.0 => 0,
        _ => (2 - size.log10().floor() as i32).clamp(3, 9) as usize,
    };
    let text = format!("{length:.decimals$}");
    let text = match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.'),
        false => &text,
    };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_converted_to_the_unit_of_the_scene() {
        let near = |unit: LengthUnit, text: &str, expected: f64| {
            let found = unit.parse(text);
            assert!(
                found.is_some_and(|found| (found - expected).abs() < 1e-9),
                "{text}: {found:?}"
            );
        };
        near(LengthUnit::None, "30cm", 0.3);
        near(LengthUnit::Metre, " 2m ", 2.0);
        near(LengthUnit::Centimetre, "2 m", 200.0);
        near(LengthUnit::Centimetre, "-4in", -10.16);
        near(LengthUnit::Metre, "6'", 1.8288);
        near(LengthUnit::Inch, "6'2\"", 74.0);
        near(LengthUnit::Inch, "6ft 2in", 74.0);
        near(LengthUnit::Millimetre, "1.5", 1.5);
        near(LengthUnit::Millimetre, "-1e2", -100.0);
        near(LengthUnit::Foot, "1km", 1000.0 / 0.3048);
        near(LengthUnit::Metre, "0,5", 0.5);
        near(LengthUnit::Inch, "1,5ft 2,5in", 20.5);
    }

    #[test]
    fn other_texts_are_no_lengths() {
        for text in [
            "", "-", "m", "2 miles", "2m3", "1,2,3m", "1,000.5", "inf", "nan", "2mm4x", "1e400", "--2m",
        ] {
            assert_eq!(LengthUnit::Metre.parse(text), None, "{text}");
        }
    }

    #[test]
    fn names_come_back_and_lengths_are_short() {
        for unit in LengthUnit::ALL {
            assert_eq!(LengthUnit::of_name(unit.name()), Some(unit));
        }
        for (length, text) in [
            (2.0, "2 m"),
            (0.3, "0.3 m"),
            (1234.5678, "1234.6 m"),
            (0.0012345, "0.00123 m"),
            (-0.0, "0 m"),
            (100.0, "100 m"),
        ] {
            assert_eq!(LengthUnit::Metre.text(length), text);
        }
        assert_eq!(LengthUnit::None.text(1.5), "1.5");
    }
}
