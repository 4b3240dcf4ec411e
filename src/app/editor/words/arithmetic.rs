//! Numbers as people type them: with a decimal point or a decimal comma, and with simple arithmetic.

use crate::scene::decimal;

/// The longest text that is read. No text typed by hand is longer, and the limit bounds the nesting of parentheses.
const LONGEST: usize = 200;

/// The value of a text such as `0,5`, `1/4` or `2*(3+1)`. `operand` parses the text between the signs: a number, and
/// the factor of the unit behind it. None if the text is no number.
pub fn value(text: &str, operand: impl Fn(&str) -> Option<(f64, f64)>) -> Option<f64> {
    if text.len() > LONGEST {
        return None;
    }
    // Blanks part the digits of large numbers as well.
    let text: String = text.chars().filter(|letter| !letter.is_whitespace()).collect();
    let mut reader = Reader { rest: &text, operand };
    let value = reader.sum()?;
    (reader.rest.is_empty() && value.is_finite()).then_some(value)
}

/// A number without a unit.
pub fn plain(text: &str) -> Option<f64> {
    decimal(&text.replace('\u{2212}', "-"))
}

/// The value of arithmetic without units.
pub fn number(text: &str) -> Option<f64> {
    value(text, |operand| Some((plain(operand)?, 1.0)))
}

struct Reader<'t, F> {
    rest: &'t str,
    operand: F,
}

/// A part of the arithmetic.
#[derive(Clone, Copy)]
struct Term {
    value: f64,
    /// The factor of the unit if the part is a single number with its unit.
    factor: f64,
    has_unit: bool,
}

impl<F: Fn(&str) -> Option<(f64, f64)>> Reader<'_, F> {
    /// Reads the next letter if it is one of these signs; returns it.
    fn takes(&mut self, signs: &[char]) -> Option<char> {
        let first = self.rest.chars().next().filter(|first| signs.contains(first))?;
        self.rest = &self.rest[first.len_utf8()..];
        Some(first)
    }

    fn sum(&mut self) -> Option<f64> {
        let mut value = self.product()?;
        while let Some(sign) = self.takes(&['+', '-', '\u{2212}']) {
            let next = self.product()?;
            value += if sign == '+' { next } else { -next };
        }
        Some(value)
    }

    fn product(&mut self) -> Option<f64> {
        let Term {
            mut value,
            mut has_unit,
            ..
        } = self.term()?;
        while let Some(sign) = self.takes(&['*', '×', '·', '/', '÷']) {
            let next = self.term()?;
            value = match sign {
                '*' | '×' | '·' => value * next.value,
                // A quarter of an inch is typed `1/4in`.
                _ if next.has_unit && !has_unit => value / (next.value / next.factor) * next.factor,
                _ => value / next.value,
            };
            has_unit |= next.has_unit;
        }
        Some(value)
    }

    fn term(&mut self) -> Option<Term> {
        let mut sign = 1.0;
        while let Some(found) = self.takes(&['+', '-', '\u{2212}']) {
            sign *= if found == '+' { 1.0 } else { -1.0 };
        }
        if self.takes(&['(']).is_some() {
            let value = self.sum()?;
            self.takes(&[')'])?;
            return Some(Term {
                value: sign * value,
                factor: 1.0,
                has_unit: false,
            });
        }
        let end = operand_end(self.rest);
        let (operand, rest) = self.rest.split_at(end);
        let (number, factor) = (self.operand)(operand)?;
        self.rest = rest;
        Some(Term {
            value: sign * number * factor,
            factor,
            has_unit: factor != 1.0,
        })
    }
}

/// The length of the operand at the start of a text. The sign of an exponent, as in `1e-3`, belongs to it.
fn operand_end(text: &str) -> usize {
    let mut before = [' '; 2];
    for (place, letter) in text.char_indices() {
        let is_exponent = matches!(before[0], '0'..='9' | '.' | ',') && matches!(before[1], 'e' | 'E');
        let is_sign = matches!(letter, '+' | '-' | '\u{2212}');
        if matches!(letter, '*' | '×' | '·' | '/' | '÷' | '(' | ')') || is_sign && !is_exponent {
            return place;
        }
        before = [before[1], letter];
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arithmetic_and_decimal_commas_are_read() {
        for (text, expected) in [
            ("0,5", 0.5),
            ("1/4", 0.25),
            ("2*3+1", 7.0),
            ("1+2*3", 7.0),
            ("(1+2)*3", 9.0),
            ("-(2-5)", 3.0),
            ("--2", 2.0),
            ("2*-3", -6.0),
            ("10-4-3", 3.0),
            ("12/2/3", 2.0),
            ("1e-3", 1e-3),
            ("1e-3-1", 1e-3 - 1.0),
            (" \u{2212}1 000.5 ", -1000.5),
            ("1,5*2", 3.0),
            (".5", 0.5),
            ("5.", 5.0),
            ("3×2", 6.0),
        ] {
            assert_eq!(number(text), Some(expected), "{text}");
        }
    }

    #[test]
    fn what_is_no_number_is_none() {
        let deep = "(".repeat(100_000);
        for text in [
            "", "half", "0;5", "1/", "*2", "(1", "1)", "1//2", "()", "1,000.5", "1,2,3", "1/0", "inf", "nan", "1e400",
            "2 m", "1..2", &deep,
        ] {
            assert_eq!(number(text), None, "{text}");
        }
    }

    #[test]
    fn a_unit_belongs_to_the_number_before_it() {
        let inches = |text: &str| match text.strip_suffix("in") {
            Some(number) => Some((plain(number)?, 2.54)),
            None => Some((plain(text)?, 1.0)),
        };
        for (text, expected) in [
            ("1/4in", 0.635),
            ("2*1in", 5.08),
            ("1in/2", 1.27),
            ("4in/2in", 2.0),
            ("1in+1", 3.54),
            ("3/2", 1.5),
        ] {
            let found = value(text, inches);
            assert!(
                found.is_some_and(|found| (found - expected).abs() < 1e-12),
                "{text}: {found:?}"
            );
        }
    }
}
