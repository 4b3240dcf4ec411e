//! Reads numbers. The original program reads them as C's `atof` does: text that is no number is 0, and what follows a
//! number is ignored. Such text is a slip of the hand, so that it is an error here, and the value counts as not given;
//! what is left empty is 0 with a warning, as programs write it that know no value.

use glam::Vec3;

use super::import::Import;
use super::tree::Node;
use crate::document::value::quote;

impl Import<'_> {
    /// The attribute as a number, if it is there and is one.
    pub fn number(&mut self, node: Node, attribute: &str) -> Option<f32> {
        self.given(node, attribute).ok().flatten()
    }

    /// The attribute as a number, if it is there.
    fn given(&mut self, node: Node, attribute: &str) -> Result<Option<f32>, Slip> {
        let Some((text, span)) = node.attribute(attribute) else {
            return Ok(None);
        };
        if text.trim().is_empty() {
            self.warn(span, "expected a number, found nothing; it is read as 0");
            return Ok(Some(0.0));
        }
        let Some(number) = finite(&text) else {
            self.error(span, format!("expected a number, found {}", quote(&text)));
            return Err(Slip);
        };
        let bounded = number.clamp(-LARGEST_NUMBER, LARGEST_NUMBER);
        if bounded != number {
            self.warn(span, format!("{} is too large; it is read as {bounded}", quote(&text)));
        }
        Ok(Some(bounded))
    }

    /// The `value` of the first element inside with one of these names.
    pub fn value(&mut self, node: Node, names: &[&str]) -> Option<f32> {
        self.number(node.child(names)?, "value")
    }

    /// The `x`, `y` and `z` of such an element; those that are missing are 0.
    pub fn triple(&mut self, node: Node, names: &[&str]) -> Option<Vec3> {
        self.parts(node.child(names)?, ["x", "y", "z"])
    }

    /// Three attributes; those that are missing are 0. None if one is no number.
    fn parts(&mut self, node: Node, names: [&str; 3]) -> Option<Vec3> {
        let [x, y, z] = names.map(|name| self.given(node, name).map(Option::unwrap_or_default));
        Some(Vec3::new(x.ok()?, y.ok()?, z.ok()?))
    }

    /// The `r`, `g` and `b` of such an element, not negative.
    pub fn color(&mut self, node: Node, names: &[&str]) -> Option<Vec3> {
        let node = node.child(names)?;
        let color = self.parts(node, ["r", "g", "b"])?;
        if color.min_element() < 0.0 {
            self.warn(node.span(), "a colour below 0 is read as 0");
        }
        Some(color.max(Vec3::ZERO))
    }
}

/// The largest number: products of three such numbers are finite.
const LARGEST_NUMBER: f32 = 1e12;

/// A text that is no number, which has been reported. Whatever takes its place leads to no further message.
struct Slip;

/// The number that a text is.
fn finite(text: &str) -> Option<f32> {
    text.trim().parse().ok().filter(|number: &f32| number.is_finite())
}

#[cfg(test)]
mod tests {
    use super::finite;

    #[test]
    fn a_number_is_all_of_its_text() {
        for (text, expected) in [
            (" 1.5 ", Some(1.5)),
            ("-.5e1", Some(-5.0)),
            ("+3", Some(3.0)),
            ("2,5", None),
            ("3 m", None),
            ("1e", None),
            ("", None),
            ("red", None),
            ("nan", None),
            ("inf", None),
            // C would give infinity.
            ("1e99", None),
        ] {
            assert_eq!(finite(text), expected, "{text:?}");
        }
    }
}
