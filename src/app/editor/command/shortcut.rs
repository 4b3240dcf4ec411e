//! Keys with their modifiers, as they are shown and as preferences store them.

use bevy_egui::egui::Key;

/// A key with its modifiers; `command` is Control, on a Mac the command key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shortcut {
    /// The key that goes down last.
    pub key: Key,
    /// Whether Control, or the command key of a Mac, is held.
    pub command: bool,
    /// Whether Shift is held.
    pub shift: bool,
    /// Whether Alt is held.
    pub alt: bool,
    /// Whether it is a digit of the numeric keypad.
    pub numpad: bool,
}

const CONTROL: &str = "Ctrl";
const ALT: &str = "Alt";
const SHIFT: &str = "Shift";
const NUMPAD: &str = "Numpad ";

impl Shortcut {
    /// The key alone.
    pub const fn plain(key: Key) -> Self {
        Self {
            key,
            command: false,
            shift: false,
            alt: false,
            numpad: false,
        }
    }

    /// The text of a shortcut, such as `Ctrl+Shift+Z`.
    pub fn text(&self) -> String {
        // Users do not think of the question mark as a key with Shift.
        let shift = self.shift && self.key != Key::Questionmark;
        self.written(shift, shown(self.key))
    }

    /// The text that [`Shortcut::parse`] reads.
    pub fn name(&self) -> String {
        self.written(self.shift, self.key.name())
    }

    fn written(&self, shift: bool, key: &str) -> String {
        let modifiers = [(self.command, CONTROL), (self.alt, ALT), (shift, SHIFT)];
        let mut text = String::new();
        for (_, name) in modifiers.into_iter().filter(|(held, _)| *held) {
            text += name;
            text.push('+');
        }
        text += if self.numpad { NUMPAD } else { "" };
        text + key
    }

    /// Reads a text such as `Ctrl+Shift+Z`, `Numpad 7` or `F5`. None if it names no key.
    pub fn parse(text: &str) -> Option<Self> {
        let mut parts: Vec<&str> = text.split('+').map(str::trim).collect();
        let last = parts.pop()?;
        let (numpad, name) = match last.strip_prefix(NUMPAD) {
            Some(digit) => (true, digit.trim()),
            None => (false, last),
        };
        let mut shortcut = Self {
            numpad,
            ..Self::plain(Key::from_name(name)?)
        };
        for part in parts {
            let held = match part {
                CONTROL => &mut shortcut.command,
                ALT => &mut shortcut.alt,
                SHIFT => &mut shortcut.shift,
                _ => return None,
            };
            *held = true;
        }
        Some(shortcut)
    }
}

/// The name of a key on keyboards; the symbols of arrows are too small to be told apart.
fn shown(key: Key) -> &'static str {
    match key {
        Key::ArrowLeft => "Left",
        Key::ArrowRight => "Right",
        Key::ArrowUp => "Up",
        Key::ArrowDown => "Down",
        Key::PageUp => "Page Up",
        Key::PageDown => "Page Down",
        _ => key.symbol_or_name(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_named_as_people_do() {
        let all = Shortcut {
            command: true,
            shift: true,
            alt: true,
            ..Shortcut::plain(Key::Z)
        };
        assert_eq!(all.text(), "Ctrl+Alt+Shift+Z");
        let slash = Shortcut {
            key: Key::Questionmark,
            command: false,
            alt: false,
            ..all
        };
        assert_eq!(slash.text(), "?");
    }

    #[test]
    fn every_key_comes_back_from_its_name() {
        for &key in Key::ALL {
            for (command, shift, numpad) in [(false, false, false), (true, false, true), (true, true, false)] {
                let shortcut = Shortcut {
                    command,
                    shift,
                    numpad,
                    ..Shortcut::plain(key)
                };
                assert_eq!(Shortcut::parse(&shortcut.name()), Some(shortcut), "{}", shortcut.name());
            }
        }
    }

    #[test]
    fn what_is_no_key_is_none() {
        for text in ["", "Ctrl+", "Hyper+A", "Ctrl+Nothing", "+"] {
            assert_eq!(Shortcut::parse(text), None, "{text}");
        }
    }
}
