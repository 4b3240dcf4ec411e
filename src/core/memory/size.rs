//! Parses sizes of memory as users write them.

use std::fmt;

const UNITS: [(&str, u64); 5] = [
    ("TB", 1_000_000_000_000),
    ("GB", 1_000_000_000),
    ("MB", 1_000_000),
    ("kB", 1000),
    ("B", 1),
];

/// A number of bytes, shown with two or three digits and a decimal unit: `14.4 GB`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bytes(pub u64);

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (unit, size) = UNITS.into_iter().find(|&(_, size)| self.0 >= size).unwrap_or(("B", 1));
        let number = self.0 as f64 / size as f64;
        let decimals = usize::from(size > 1 && number < 100.0);
        write!(f, "{number:.decimals$} {unit}")
    }
}

/// The error for a text that is not a size.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a size with its unit, such as 8GB or 512MB")]
pub struct NoSize;

/// The bytes of a size with its unit: `8GB`, `512 MB`, `1.5GiB`, `8G`. Upper and lower case are the same.
pub fn parse_size(text: &str) -> Result<u64, NoSize> {
    let text = text.trim();
    let split = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let unit = unit.to_ascii_lowercase();
    let power = match unit.chars().next() {
        Some('b') if unit == "b" => 0,
        Some('k') => 1,
        Some('m') => 2,
        Some('g') => 3,
        Some('t') => 4,
        _ => return Err(NoSize),
    };
    let base: f64 = match unit.get(1..).unwrap_or_default() {
        "" | "b" => 1000.0,
        "ib" => 1024.0,
        _ => return Err(NoSize),
    };
    let number: f64 = number.trim().parse().map_err(|_| NoSize)?;
    let bytes = number * base.powi(power);
    if bytes.is_finite() && bytes >= 1.0 {
        Ok(bytes as u64)
    } else {
        Err(NoSize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_and_shown() {
        for (text, bytes) in [
            ("8GB", 8_000_000_000),
            ("512 mb", 512_000_000),
            ("1.5GiB", 1_610_612_736),
            ("2T", 2_000_000_000_000),
            ("100kB", 100_000),
            ("7b", 7),
        ] {
            assert_eq!(parse_size(text), Ok(bytes), "{text}");
        }
        for text in ["", "8", "GB", "-1GB", "0GB", "8GBs", "8XB", "infGB", "nan MB", "é"] {
            assert!(parse_size(text).is_err(), "{text}");
        }
        let shown = |bytes| Bytes(bytes).to_string();
        assert_eq!(shown(14_400_000_000), "14.4 GB");
        assert_eq!(shown(512_000_000), "512 MB");
        assert_eq!((shown(999), shown(0)), ("999 B".to_owned(), "0 B".to_owned()));
    }
}
