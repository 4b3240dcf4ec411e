//! A key press.

use bevy_egui::egui::{Key, Modifiers};

use crate::app::editor::command::shortcut::Shortcut;

/// A key press, with the modifiers held at that moment; never a repeat of a held key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Press {
    /// The key as egui names it.
    pub key: Key,
    /// The modifiers that were held when the key went down.
    pub modifiers: Modifiers,
    /// Whether it is a digit of the numeric keypad.
    pub numpad: bool,
}

impl Press {
    /// The key with its modifiers.
    pub fn shortcut(&self) -> Shortcut {
        Shortcut {
            key: self.key,
            command: self.modifiers.command,
            shift: self.modifiers.shift,
            alt: self.modifiers.alt,
            numpad: self.numpad,
        }
    }
}

impl Shortcut {
    /// Whether the press is this key with these modifiers.
    pub(crate) fn is_pressed(&self, press: &Press) -> bool {
        *self == press.shortcut()
    }
}
