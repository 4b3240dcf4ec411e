//! Reads numbers. The original program reads them as C's `atof` does: text that is no number is 0, and what follows a number is ignored. Such text is a
//! slip of the hand, so that it is an error here; what is left empty is 0 with a warning, as programs write it that know no value.

use glam::Vec3;

use super::import::Import;
use super::tree::Node;
use crate::document::value::quote;

impl Import<'_> {
    /// The attribute as a number, if it is there.
    pub fn number(&mut self, node: Node, attribute: &str) -> Option<f32> {
        let (text, span) = node.attribute(attribute)?;
        let (number, is_clean) = atof(&text);
        let bounded = number.clamp(-LARGEST_NUMBER, LARGEST_NUMBER);
        if text.trim().is_empty() {
            self.warn(
                span,
                format!("expected a number, found nothing; it is read as {bounded}"),
            );
        } else if !is_clean {
            self.error(span, format!("expected a number, found {}", quote(&text)));
        } else if bounded != number {
            self.warn(span, format!("{} is too large; it is read as {bounded}", quote(&text)));
        }
        Some(bounded)
    }

    /// The `value` of the first element inside with one of these names.
    pub fn value(&mut self, node: Node, names: &[&str]) -> Option<f32> {
        self.number(node.child(names)?, "value")
    }

    /// The `x`, `y` and `z` of such an element; those that are missing are 0.
    pub fn triple(&mut self, node: Node, names: &[&str]) -> Option<Vec3> {
        let node = node.child(names)?;
        let mut axis = |name| self.number(node, name).unwrap_or(0.0);
        Some(Vec3::new(axis("x"), axis("y"), axis("z")))
    }

    /// The `r`, `g` and `b` of such an element, not negative.
    pub fn color(&mut self, node: Node, names: &[&str]) -> Option<Vec3> {
        let node = node.child(names)?;
        let mut part = |name| self.number(node, name).unwrap_or(0.0);
        let color = Vec3::new(part("r"), part("g"), part("b"));
        if color.min_element() < 0.0 {
            self.warn(node.span(), "a colour below 0 is read as 0");
        }
        Some(color.max(Vec3::ZERO))
    }
}

/// The largest number: products of three such numbers are finite.
const LARGEST_NUMBER: f32 = 1e12;

/// A longer text is looked at only so far, in bytes: the effort grows with the square of the length.
const LONGEST_NUMBER: usize = 64;

/// The number a text begins with, and whether that is all of it.
fn atof(text: &str) -> (f32, bool) {
    let text = text.trim();
    let is_part = |c: char| c.is_ascii_digit() || matches!(c, '.' | '+' | '-' | 'e' | 'E');
    let longest = text.find(|c| !is_part(c)).unwrap_or(text.len()).min(LONGEST_NUMBER);
    let number = (1..=longest).rev().find_map(|length| {
        let number = text[..length].parse::<f32>().ok().filter(|number| number.is_finite());
        number.map(|number| (number, length == text.len()))
    });
    number.unwrap_or((0.0, false))
}

#[cfg(test)]
mod tests {
    use super::atof;

    #[test]
    fn numbers_are_read_as_c_does() {
        for (text, expected) in [
            (" 1.5 ", (1.5, true)),
            ("-.5e1", (-5.0, true)),
            ("2,5", (2.0, false)),
            ("3 m", (3.0, false)),
            ("1e", (1.0, false)),
            ("", (0.0, false)),
            ("red", (0.0, false)),
            ("nan", (0.0, false)),
            // C would give infinity.
            ("1e99", (1e9, false)),
        ] {
            assert_eq!(atof(text), expected, "{text:?}");
        }
    }
}
