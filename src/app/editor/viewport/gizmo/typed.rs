//! Numbers typed while dragging: text from key presses, one number per axis with commas between them.

use bevy_egui::egui::Key;

use crate::scene::LengthUnit;

/// The typed text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Typed(String);

/// The longest text that can be typed.
const LONGEST: usize = 32;

impl Typed {
    /// Whether nothing was typed.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The text that is shown beside the pointer.
    pub fn text(&self) -> &str {
        &self.0
    }

    /// Adds the key to the text if it belongs to a number; returns whether it did. Minus turns the sign of the number
    /// being typed over.
    pub fn press(&mut self, key: Key) -> bool {
        let typed = match key {
            Key::Minus => {
                let start = self.0.rfind(',').map_or(0, |comma| comma + 1);
                if self.0[start..].starts_with('-') {
                    self.0.remove(start);
                } else {
                    self.0.insert(start, '-');
                }
                return true;
            }
            Key::Backspace => return self.0.pop().is_some(),
            Key::Period => '.',
            Key::Comma | Key::Tab => ',',
            _ => match digit(key) {
                Some(digit) => digit,
                None => return false,
            },
        };
        let is_separator = typed == ',';
        if is_separator && self.0.is_empty() {
            return false;
        }
        if self.0.len() < LONGEST {
            self.0.push(typed);
        }
        true
    }

    /// Adds the key to the text if it continues the unit of a length, such as `cm` or `'`; returns whether it did.
    pub fn press_unit(&mut self, key: Key, shift: bool) -> bool {
        let letter = match key {
            Key::M => 'm',
            Key::C => 'c',
            Key::I => 'i',
            Key::N => 'n',
            Key::F => 'f',
            Key::T => 't',
            Key::Quote if shift => '"',
            Key::Quote => '\'',
            _ => return false,
        };
        let (number, unit) = split(self.0.rsplit(',').next().unwrap_or_default());
        let unit = format!("{unit}{letter}");
        let goes_on =
            number.contains(|c: char| c.is_ascii_digit()) && self.0.len() < LONGEST && LengthUnit::begins_unit(&unit);
        if goes_on {
            self.0.push(letter);
        }
        goes_on
    }

    /// The typed lengths in order, in units of the scene. An incomplete unit is ignored.
    pub fn lengths(&self, unit: LengthUnit) -> Option<Vec<f32>> {
        let length = |text: &str| {
            let known = unit.parse(text).or_else(|| unit.parse(split(text).0));
            known.unwrap_or(0.0) as f32
        };
        (!self.is_empty()).then(|| self.0.split(',').map(length).collect())
    }

    /// The typed numbers in order, zero for an incomplete one; None if nothing is typed.
    pub fn numbers(&self) -> Option<Vec<f32>> {
        let number = |text: &str| {
            text.parse()
                .ok()
                .filter(|number: &f32| number.is_finite())
                .unwrap_or(0.0)
        };
        (!self.is_empty()).then(|| self.0.split(',').map(number).collect())
    }
}

/// The text before its last unit, and the unit.
fn split(text: &str) -> (&str, &str) {
    let end = text
        .trim_end_matches(|c: char| !c.is_ascii_digit() && c != '.' && c != '-')
        .len();
    text.split_at(end)
}

fn digit(key: Key) -> Option<char> {
    const DIGITS: [Key; 10] = [
        Key::Num0,
        Key::Num1,
        Key::Num2,
        Key::Num3,
        Key::Num4,
        Key::Num5,
        Key::Num6,
        Key::Num7,
        Key::Num8,
        Key::Num9,
    ];
    (0..)
        .zip(DIGITS)
        .find(|(_, digit)| *digit == key)
        .and_then(|(value, _)| char::from_digit(value, 10))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn typed(keys: &[Key]) -> Typed {
        let mut typed = Typed::default();
        for &key in keys {
            typed.press(key);
        }
        typed
    }

    #[test]
    fn keys_become_numbers() {
        assert_eq!(typed(&[]).numbers(), None);
        let keys = [Key::Num1, Key::Period, Key::Num5, Key::Minus];
        assert_eq!(typed(&keys).numbers(), Some(vec![-1.5]));
        let keys = [
            Key::Num2,
            Key::Comma,
            Key::Minus,
            Key::Num3,
            Key::Tab,
            Key::Period,
            Key::Num5,
        ];
        assert_eq!(typed(&keys).numbers(), Some(vec![2.0, -3.0, 0.5]));
        assert_eq!(typed(&[Key::Minus]).numbers(), Some(vec![0.0]));
        assert_eq!(
            typed(&[Key::Num7, Key::Minus, Key::Minus, Key::Backspace]).numbers(),
            None
        );
    }

    #[test]
    fn units_follow_numbers() {
        let mut length = typed(&[Key::Num3, Key::Num0]);
        assert!(!length.press_unit(Key::T, false) && !length.press_unit(Key::N, false));
        assert!(length.press_unit(Key::C, false));
        assert_eq!(
            length.lengths(LengthUnit::None),
            Some(vec![30.0]),
            "the unit is not complete"
        );
        assert!(length.press_unit(Key::M, false) && !length.press_unit(Key::M, false));
        assert_eq!(length.lengths(LengthUnit::None), Some(vec![0.3]));
        assert_eq!(length.lengths(LengthUnit::Millimetre), Some(vec![300.0]));
        length.press(Key::Minus);
        assert_eq!(length.lengths(LengthUnit::Metre), Some(vec![-0.3]));
        let mut feet = typed(&[Key::Num1, Key::Comma, Key::Num6]);
        assert!(feet.press_unit(Key::Quote, false) && feet.press(Key::Num2) && feet.press_unit(Key::Quote, true));
        assert_eq!(feet.lengths(LengthUnit::Inch), Some(vec![1.0, 74.0]));
        assert!(!typed(&[]).press_unit(Key::M, false) && !typed(&[Key::Minus]).press_unit(Key::M, false));
    }

    #[test]
    fn other_keys_are_left_alone() {
        let mut empty = Typed::default();
        assert!(!empty.press(Key::W) && !empty.press(Key::Backspace) && !empty.press(Key::Tab));
        assert!(empty.is_empty());
    }
}
