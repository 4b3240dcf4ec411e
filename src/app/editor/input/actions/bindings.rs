//! Which keys an action has: those of the table, or those that the user has chosen. Nothing else asks the table for keys.

use bevy_egui::egui::Key;

use super::{ACTIONS, Action, Group};
use crate::app::editor::command::key_bindings::KeyBindings;
use crate::app::editor::command::shortcut::Shortcut;
use crate::app::editor::input::press::Press;

/// Something that keys can be chosen for.
#[derive(Clone, Copy, Debug)]
pub struct Bindable {
    /// The name in scripts and preferences.
    pub name: &'static str,
    /// The text that users read.
    pub label: &'static str,
    /// The heading above it; None for flying.
    pub group: Option<Group>,
    /// The keys of the program.
    pub usual: &'static [Shortcut],
}

const fn fly(name: &'static str, label: &'static str, usual: &'static [Shortcut]) -> Bindable {
    Bindable {
        name,
        label,
        group: None,
        usual,
    }
}

/// The keys that fly while they are held, as two directions for each axis: left and right, up and down, ahead and back.
pub const FLIGHT: [[Bindable; 2]; 3] = [
    [
        fly("fly-left", "Fly to the left", &[Shortcut::plain(Key::A)]),
        fly("fly-right", "Fly to the right", &[Shortcut::plain(Key::D)]),
    ],
    [
        fly("fly-up", "Fly up", &[Shortcut::plain(Key::E)]),
        fly("fly-down", "Fly down", &[Shortcut::plain(Key::Q)]),
    ],
    [
        fly("fly-ahead", "Fly ahead", &[Shortcut::plain(Key::W)]),
        fly("fly-back", "Fly back", &[Shortcut::plain(Key::S)]),
    ],
];

/// Keys that cannot be chosen, with what they do.
const RESERVED: [(&str, &str); 9] = [
    ("Ctrl+C", "copies"),
    ("Ctrl+X", "cuts"),
    ("Ctrl+V", "pastes"),
    ("Ctrl+Plus", "enlarges the panels"),
    ("Ctrl+Equals", "enlarges the panels"),
    ("Ctrl+Minus", "shrinks the panels"),
    ("Ctrl+0", "gives the panels their usual size"),
    ("F2", "renames in the outliner"),
    ("Enter", "ends what is typed"),
];

impl Bindable {
    /// The keys in use, any of which will do; the first is shown.
    pub fn keys<'a>(&self, bound: &'a KeyBindings) -> &'a [Shortcut] {
        bound.of(self.name).unwrap_or(self.usual)
    }

    /// Whether it flies while the key is held.
    pub fn is_held(&self) -> bool {
        self.group.is_none()
    }
}

impl Action {
    /// The action as something that keys can be chosen for.
    pub fn bindable(&self) -> Bindable {
        Bindable {
            name: self.name,
            label: self.label,
            group: Some(self.group),
            usual: self.keys,
        }
    }

    /// The keys in use, any of which will do; the first is shown.
    pub fn keys_in<'a>(&self, bound: &'a KeyBindings) -> &'a [Shortcut] {
        self.bindable().keys(bound)
    }

    /// The text of the first key; empty without one.
    pub fn key_text(&self, bound: &KeyBindings) -> String {
        self.keys_in(bound).first().map(Shortcut::text).unwrap_or_default()
    }

    /// Whether the press is that of one of its keys.
    pub fn is_pressed(&self, press: &Press, bound: &KeyBindings) -> bool {
        self.keys_in(bound).iter().any(|key| key.is_pressed(press))
    }
}

/// Everything that keys can be chosen for: flying, then the actions in the order of the menus.
pub fn bindables() -> impl Iterator<Item = Bindable> {
    FLIGHT.into_iter().flatten().chain(ACTIONS.iter().map(Action::bindable))
}

/// What the key does already, but for `name`.
pub fn owner(key: &Shortcut, name: &str, bound: &KeyBindings) -> Option<Bindable> {
    // Shift means fast to a key that flies.
    let is_flight =
        |other: &Shortcut, held: bool| held && other.key == key.key && !key.numpad && !key.command && !key.alt;
    let is_held = bindables().any(|own| own.name == name && own.is_held());
    bindables().find(|other| {
        let meets = |its: &Shortcut| {
            its == key
                || is_flight(its, other.is_held())
                || (is_held && its.key == key.key && !its.numpad && !its.command && !its.alt)
        };
        other.name != name && other.keys(bound).iter().any(meets)
    })
}

/// What a key does that cannot be chosen.
pub fn reserved(key: &Shortcut) -> Option<&'static str> {
    let found = RESERVED
        .iter()
        .find(|(text, _)| Shortcut::parse(text).as_ref() == Some(key));
    found.map(|(_, what)| *what)
}

/// Gives `name` the key alone. If the key was that of another action, that one gets the first key that `name` had.
pub fn bind(bound: &mut KeyBindings, name: &str, key: Shortcut) {
    let before = bindables()
        .find(|own| own.name == name)
        .and_then(|own| own.keys(bound).first().copied());
    if let Some(other) = owner(&key, name, bound) {
        let mut keys: Vec<Shortcut> = other.keys(bound).to_vec();
        keys.retain(|its| its.key != key.key || its.numpad != key.numpad || its.command != key.command);
        // Nothing but a key alone can be held to fly.
        keys.extend(before.filter(|before| !other.is_held() || *before == Shortcut::plain(before.key)));
        set(bound, &other, keys);
    }
    if let Some(own) = bindables().find(|own| own.name == name) {
        set(bound, &own, vec![key]);
    }
}

/// Stores nothing for the keys of the program.
fn set(bound: &mut KeyBindings, of: &Bindable, keys: Vec<Shortcut>) {
    match keys == of.usual {
        true => bound.reset(of.name),
        false => bound.set(of.name, keys),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn key(text: &str) -> Shortcut {
        Shortcut::parse(text).expect("a key")
    }

    fn keys(name: &str, bound: &KeyBindings) -> Vec<String> {
        let found = bindables().find(|own| own.name == name).expect("a name");
        found.keys(bound).iter().map(Shortcut::text).collect()
    }

    #[test]
    fn no_name_and_no_key_means_two_things() {
        for own in bindables() {
            assert_eq!(
                bindables().filter(|other| other.name == own.name).count(),
                1,
                "{}",
                own.name
            );
            for its in own.usual {
                let other = owner(its, own.name, &KeyBindings::default()).map(|other| other.name);
                assert_eq!(other, None, "{}", own.name);
                assert_eq!(reserved(its), None, "{}", own.name);
            }
        }
        assert!(RESERVED.iter().all(|(text, _)| Shortcut::parse(text).is_some()));
    }

    #[test]
    fn a_key_of_another_action_is_exchanged() {
        let mut bound = KeyBindings::default();
        bind(&mut bound, "hide", key("G"));
        assert_eq!(
            (keys("hide", &bound), keys("gizmo-move", &bound)),
            (vec!["G".to_owned()], vec!["H".to_owned()])
        );
        // Back again: nothing is left to store.
        bind(&mut bound, "hide", key("H"));
        assert!(bound.is_empty(), "{bound:?}");
    }

    #[test]
    fn keys_that_fly_are_those_of_flying_also_with_shift() {
        let bound = KeyBindings::default();
        let flies = |text: &str| owner(&key(text), "hide", &bound).map(|other| other.name);
        assert_eq!(flies("W"), Some("fly-ahead"));
        assert_eq!(flies("Shift+W"), Some("fly-ahead"));
        assert_eq!(flies("Ctrl+W"), None);
        // A letter with Control is free for flying, one alone is not.
        assert_eq!(
            owner(&key("N"), "fly-up", &bound).map(|other| other.name),
            Some("denoise")
        );
        assert_eq!(owner(&key("O"), "fly-up", &bound).map(|other| other.name), None);
    }

    #[test]
    fn chosen_keys_replace_those_of_the_table() {
        let mut bound = KeyBindings::default();
        bind(&mut bound, "redo", key("Ctrl+R"));
        assert_eq!(keys("redo", &bound), ["Ctrl+R"]);
        bound.reset("redo");
        assert_eq!(keys("redo", &bound), ["Ctrl+Shift+Z", "Ctrl+Y"]);
    }
}
