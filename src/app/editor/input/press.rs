//! A key going down.

use bevy_egui::egui::{Key, Modifiers};

/// A key going down, with the modifiers held at that moment; never a repeat of a key held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Press {
    /// The key as egui names it.
    pub key: Key,
    /// The modifiers that were held when the key went down.
    pub modifiers: Modifiers,
    /// A digit of the block at the keyboard's right.
    pub numpad: bool,
}
