//! The keys of every action: the defaults of the table, unless the user has chosen others. No other module asks the
//! table for keys.

use bevy_egui::egui::Key;

use super::{ACTIONS, Action, Group};
use crate::app::editor::command::key_bindings::KeyBindings;
use crate::app::editor::command::shortcut::Shortcut;
use crate::app::editor::input::press::Press;

/// An action, or a direction of flight, whose keys can be chosen.
#[derive(Clone, Copy, Debug)]
pub struct Bindable {
    /// The name in scripts and preferences.
    pub name: &'static str,
    /// The text in the list.
    pub label: &'static str,
    /// The heading above it; None for flying.
    pub group: Option<Group>,
    /// The default keys.
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

/// Keys that cannot be chosen, with their fixed meanings.
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
    /// The keys in use, any of which triggers it; the first is shown.
    pub fn keys<'a>(&self, bound: &'a KeyBindings) -> &'a [Shortcut] {
        bound.of(self.name).unwrap_or(self.usual)
    }

    /// Whether it flies while the key is held.
    pub fn is_held(&self) -> bool {
        self.group.is_none()
    }

    /// Whether this can be its key: flying takes keys without modifiers only.
    pub fn can_have(&self, key: &Shortcut) -> bool {
        !self.is_held() || *key == Shortcut::plain(key.key)
    }
}

impl Action {
    /// The entry of the action in the list of keys.
    pub fn bindable(&self) -> Bindable {
        Bindable {
            name: self.name,
            label: self.label,
            group: Some(self.group),
            usual: self.keys,
        }
    }

    /// The keys in use, any of which triggers it; the first is shown.
    pub fn keys_in<'a>(&self, bound: &'a KeyBindings) -> &'a [Shortcut] {
        self.bindable().keys(bound)
    }

    /// The text of the first key; empty without one.
    pub fn key_text(&self, bound: &KeyBindings) -> String {
        self.keys_in(bound).first().map(Shortcut::text).unwrap_or_default()
    }

    /// Whether the press is one of its keys.
    pub fn is_pressed(&self, press: &Press, bound: &KeyBindings) -> bool {
        self.keys_in(bound).iter().any(|key| key.is_pressed(press))
    }
}

/// All entries with keys to choose: flying, then the actions in the order of the menus.
pub fn bindables() -> impl Iterator<Item = Bindable> {
    FLIGHT.into_iter().flatten().chain(ACTIONS.iter().map(Action::bindable))
}

/// Whether one press can trigger both keys. The flags tell whether a key flies, to which Shift means fast.
fn meet((key, flies): (&Shortcut, bool), (other, other_flies): (&Shortcut, bool)) -> bool {
    let can_fly = |key: &Shortcut| !key.numpad && !key.command && !key.alt;
    key == other || key.key == other.key && (flies && can_fly(other) || other_flies && can_fly(key))
}

/// The actions other than `name` that a press of the key would trigger; the ones with exactly this key come first. A
/// key that flies can clash with two keys.
pub fn owners(key: &Shortcut, name: &str, bound: &KeyBindings) -> Vec<Bindable> {
    let flies = bindables().any(|own| own.name == name && own.is_held());
    let meets = |other: &Bindable| {
        let mut keys = other.keys(bound).iter();
        other.name != name && keys.any(|its| meet((its, other.is_held()), (key, flies)))
    };
    let mut found: Vec<Bindable> = bindables().filter(meets).collect();
    found.sort_by_key(|other| !other.keys(bound).contains(key));
    found
}

/// The fixed meaning of a key that cannot be chosen.
pub fn reserved(key: &Shortcut) -> Option<&'static str> {
    let found = RESERVED
        .iter()
        .find(|(text, _)| Shortcut::parse(text).as_ref() == Some(key));
    found.map(|(_, what)| *what)
}

/// Binds the key to `name` alone: all others lose keys that clash with it. The first of them gets the former first key
/// of `name`, if that is free then.
pub fn bind(bound: &mut KeyBindings, name: &str, key: Shortcut) {
    let Some(own) = bindables().find(|own| own.name == name) else {
        return;
    };
    let before = own.keys(bound).first().copied();
    let others = owners(&key, name, bound);
    for other in &others {
        let mut keys = other.keys(bound).to_vec();
        keys.retain(|its| !meet((its, other.is_held()), (&key, own.is_held())));
        set(bound, other, keys);
    }
    set(bound, &own, vec![key]);
    if let (Some(first), Some(before)) = (others.first(), before)
        && first.can_have(&before)
        && owners(&before, first.name, bound).is_empty()
    {
        let mut keys = first.keys(bound).to_vec();
        keys.push(before);
        set(bound, first, keys);
    }
}

/// Sets keys, and removes the binding if they equal the defaults.
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

    fn names(key: &Shortcut, name: &str, bound: &KeyBindings) -> Vec<&'static str> {
        owners(key, name, bound).iter().map(|other| other.name).collect()
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
                assert_eq!(names(its, own.name, &KeyBindings::default()), [""; 0], "{}", own.name);
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
        // Back to the defaults: no binding is stored.
        bind(&mut bound, "hide", key("H"));
        assert!(bound.is_empty(), "{bound:?}");
    }

    #[test]
    fn a_key_that_flies_is_given_up_by_all_that_it_would_meet() {
        for (letter, gizmo) in [("G", "gizmo-move"), ("R", "gizmo-rotate")] {
            let mut bound = KeyBindings::default();
            assert_eq!(names(&key(letter), "fly-up", &bound)[0], gizmo);
            bind(&mut bound, "fly-up", key(letter));
            assert_eq!(names(&key(letter), "fly-up", &bound), [""; 0]);
            assert_eq!(keys("fly-up", &bound), [letter]);
            assert_eq!(keys(gizmo, &bound), ["E"]);
        }
        // The key of the other action stays if it does not clash, even if it has the same letter.
        let mut bound = KeyBindings::default();
        bound.set("hide", vec![key("Alt+F6"), key("F6")]);
        bind(&mut bound, "redo", key("F6"));
        assert_eq!(keys("hide", &bound), ["Alt+F6", "Ctrl+Shift+Z"]);
    }

    #[test]
    fn keys_that_fly_are_those_of_flying_also_with_shift() {
        let bound = KeyBindings::default();
        let flies = |text: &str| names(&key(text), "hide", &bound);
        assert_eq!(flies("W"), ["fly-ahead"]);
        assert_eq!(flies("Shift+W"), ["fly-ahead"]);
        assert_eq!(flies("Ctrl+W"), [""; 0]);
        // A letter with Control does not clash with flying, a letter alone does.
        assert_eq!(names(&key("N"), "fly-up", &bound), ["denoise"]);
        assert_eq!(names(&key("J"), "fly-up", &bound), [""; 0]);
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
