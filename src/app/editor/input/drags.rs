//! The effect of a drag in the picture, by its button and the keys held at the press. There is a table for each
//! navigation preset; the overview of keys shows it.

use bevy_egui::egui::{Modifiers, PointerButton};

use crate::app::editor::command::navigation_preset::NavigationPreset;

/// The effect of a drag in the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DragUse {
    /// Turns the view about the camera.
    Look,
    /// Turns the view around the selection.
    Orbit,
    /// Moves the view parallel to the image plane.
    Pan,
    /// Moves the view towards the surface under the pointer, or away from it.
    Dolly,
    /// Selects by a box.
    Box,
}

impl DragUse {
    /// The description in the overview of keys.
    pub fn label(self) -> &'static str {
        match self {
            Self::Look => "Look around",
            Self::Orbit => "Orbit the selection",
            Self::Pan => "Pan",
            Self::Dolly => "Dolly",
            Self::Box => "Select by a box",
        }
    }
}

/// A key that is held while a drag begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Held {
    Nothing,
    Control,
    Shift,
    Alt,
}

/// A row of a table: the effect of a drag with a button while a key is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DragRule {
    button: PointerButton,
    held: Held,
    /// The effect.
    pub what: DragUse,
}

const fn rule(held: Held, button: PointerButton, what: DragUse) -> DragRule {
    DragRule { button, held, what }
}

use PointerButton::{Middle, Primary, Secondary};

const SUNROOM: &[DragRule] = &[
    rule(Held::Nothing, Primary, DragUse::Look),
    rule(Held::Nothing, Secondary, DragUse::Look),
    rule(Held::Nothing, Middle, DragUse::Pan),
    rule(Held::Shift, Middle, DragUse::Orbit),
    rule(Held::Alt, Primary, DragUse::Orbit),
    rule(Held::Control, Middle, DragUse::Dolly),
    rule(Held::Shift, Primary, DragUse::Box),
];

const BLENDER: &[DragRule] = &[
    rule(Held::Nothing, Middle, DragUse::Orbit),
    rule(Held::Alt, Primary, DragUse::Orbit),
    rule(Held::Shift, Middle, DragUse::Pan),
    rule(Held::Control, Middle, DragUse::Dolly),
    rule(Held::Nothing, Secondary, DragUse::Look),
    rule(Held::Nothing, Primary, DragUse::Box),
];

const GODOT: &[DragRule] = &[
    rule(Held::Nothing, Middle, DragUse::Orbit),
    rule(Held::Shift, Middle, DragUse::Pan),
    rule(Held::Control, Middle, DragUse::Dolly),
    rule(Held::Nothing, Secondary, DragUse::Look),
    rule(Held::Nothing, Primary, DragUse::Box),
];

const TRENCH_BROOM: &[DragRule] = &[
    rule(Held::Nothing, Secondary, DragUse::Look),
    rule(Held::Nothing, Middle, DragUse::Pan),
    rule(Held::Alt, Secondary, DragUse::Orbit),
    rule(Held::Shift, Middle, DragUse::Orbit),
    rule(Held::Alt, Middle, DragUse::Dolly),
    rule(Held::Control, Middle, DragUse::Dolly),
    rule(Held::Nothing, Primary, DragUse::Box),
];

/// The drags of a preset, in the order of the overview.
pub fn drags(preset: NavigationPreset) -> &'static [DragRule] {
    match preset {
        NavigationPreset::Sunroom => SUNROOM,
        NavigationPreset::Blender => BLENDER,
        NavigationPreset::Godot => GODOT,
        NavigationPreset::TrenchBroom => TRENCH_BROOM,
    }
}

/// The effect of a drag that begins with this button and these keys. Keys without a rule are ignored: Shift and Control
/// also make flying fast and slow.
pub fn drag_use(preset: NavigationPreset, button: PointerButton, modifiers: Modifiers) -> DragUse {
    let held = match (modifiers.command, modifiers.shift, modifiers.alt) {
        (_, _, true) => Held::Alt,
        (_, true, _) => Held::Shift,
        (true, ..) => Held::Control,
        _ => Held::Nothing,
    };
    let find = |held: Held| {
        drags(preset)
            .iter()
            .find(|rule| rule.button == button && rule.held == held)
    };
    find(held)
        .or_else(|| find(Held::Nothing))
        .map_or(DragUse::Look, |rule| rule.what)
}

impl DragRule {
    /// The text of the drag, such as `Shift+Middle drag`.
    pub fn text(&self) -> String {
        let held = match self.held {
            Held::Nothing => "",
            Held::Control => "Ctrl+",
            Held::Shift => "Shift+",
            Held::Alt => "Alt+",
        };
        let button = match self.button {
            Primary => "Left",
            Secondary => "Right",
            Middle => "Middle",
            _ => "Extra",
        };
        format!("{held}{button} drag")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_orbits_pans_looks_and_draws_a_box() {
        for (preset, name, _) in NavigationPreset::ALL {
            for what in [
                DragUse::Look,
                DragUse::Orbit,
                DragUse::Pan,
                DragUse::Dolly,
                DragUse::Box,
            ] {
                assert!(drags(preset).iter().any(|rule| rule.what == what), "{name}: {what:?}");
            }
            // Window managers take Alt and a button for themselves.
            let orbits = |rule: &&DragRule| rule.what == DragUse::Orbit && rule.held != Held::Alt;
            assert!(drags(preset).iter().any(|rule| orbits(&rule)), "{name}");
        }
    }

    #[test]
    fn no_drag_means_two_things() {
        for (preset, name, _) in NavigationPreset::ALL {
            for (place, rule) in drags(preset).iter().enumerate() {
                let same = |other: &DragRule| (other.button, other.held) == (rule.button, rule.held);
                assert!(!drags(preset)[..place].iter().any(same), "{name}: {}", rule.text());
            }
        }
    }

    #[test]
    fn keys_without_a_rule_change_nothing() {
        let fast = drag_use(NavigationPreset::Blender, Secondary, Modifiers::SHIFT);
        assert_eq!(fast, DragUse::Look);
        let toggled = drag_use(NavigationPreset::Godot, Primary, Modifiers::COMMAND);
        assert_eq!(toggled, DragUse::Box);
        let dolly = drag_use(NavigationPreset::Blender, Middle, Modifiers::COMMAND);
        assert_eq!(dolly, DragUse::Dolly);
    }
}
