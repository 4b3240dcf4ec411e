//! The keyboard: keys that fly, and keys that trigger commands.

use bevy::input::keyboard::{Key as LogicalKey, KeyCode, KeyboardInput};
use bevy::math::Vec3;
use bevy_egui::egui::{InputState, Key, Modifiers};
use bevy_egui::helpers::{bevy_to_egui_key, bevy_to_egui_physical_key};

use super::actions::bindings::FLIGHT;
use super::actions::{ACTIONS, Action, ActionContext};
use super::press::Press;
use crate::app::editor::command::key_bindings::KeyBindings;
use crate::app::editor::command::{Command, FileCommand, ShellCommand};

/// The direction of flight to the left, up and forward, each -1, 0 or 1. Keys with modifiers, which preferences may
/// name, do not fly.
pub(crate) fn fly_direction(input: &InputState, bound: &KeyBindings) -> Vec3 {
    let axes = FLIGHT.map(|ways| {
        let [plus, minus] = ways.map(|way| {
            let mut keys = way.keys(bound).iter().filter(|key| way.can_have(key));
            keys.any(|held| input.key_down(held.key))
        });
        f32::from(plus) - f32::from(minus)
    });
    Vec3::from_array(axes)
}

/// The key presses among a frame's events, in order, with the frame's modifiers: `typing::order_keys` lets no frame
/// have two states of them.
pub fn presses<'a>(events: impl Iterator<Item = &'a KeyboardInput>, modifiers: Modifiers) -> Vec<Press> {
    let pressed = events.filter(|event| event.state.is_pressed() && !event.repeat);
    pressed.filter_map(|event| press(event, modifiers)).collect()
}

/// The press of a key. None for modifier keys and for keys that egui does not know.
fn press(event: &KeyboardInput, modifiers: Modifiers) -> Option<Press> {
    if is_modifier(&event.logical_key) {
        return None;
    }
    let numpad = numpad_digit(event.key_code);
    let key = numpad
        .or_else(|| bevy_to_egui_key(&event.logical_key))
        .or_else(|| bevy_to_egui_physical_key(&event.key_code))?;
    Some(Press {
        key,
        modifiers,
        numpad: numpad.is_some(),
    })
}

/// The digit of a key of the numeric keypad, whether Num Lock is on or not.
fn numpad_digit(code: KeyCode) -> Option<Key> {
    let digits = [
        (KeyCode::Numpad0, Key::Num0),
        (KeyCode::Numpad1, Key::Num1),
        (KeyCode::Numpad2, Key::Num2),
        (KeyCode::Numpad3, Key::Num3),
        (KeyCode::Numpad4, Key::Num4),
        (KeyCode::Numpad5, Key::Num5),
        (KeyCode::Numpad6, Key::Num6),
        (KeyCode::Numpad7, Key::Num7),
        (KeyCode::Numpad8, Key::Num8),
        (KeyCode::Numpad9, Key::Num9),
    ];
    digits.into_iter().find(|(known, _)| *known == code).map(|(_, key)| key)
}

/// Whether the key changes the meaning of others.
pub(crate) fn is_modifier(key: &LogicalKey) -> bool {
    match key {
        LogicalKey::Control | LogicalKey::Shift | LogicalKey::Alt => true,
        LogicalKey::Super => cfg!(target_os = "macos"),
        _ => false,
    }
}

/// The commands of the keys pressed this frame, each for the state after the one before.
pub fn shortcuts(presses: &[Press], context: &ActionContext) -> Vec<Command> {
    let mut context = *context;
    let mut commands = Vec::new();
    for press in presses {
        // While flying, Control means slow.
        if context.flying && press.modifiers.command {
            continue;
        }
        let is_meant = |action: &&Action| action.is_pressed(press, context.bound);
        let Some(command) = ACTIONS
            .iter()
            .find(is_meant)
            .and_then(|action| (action.command)(&context).or_else(|| action.refused()))
        else {
            continue;
        };
        context.follow(&command);
        let opens_dialog = matches!(
            command,
            Command::File(FileCommand::ShowDialog(_)) | Command::Shell(ShellCommand::ShowSheet(_))
        );
        commands.push(command);
        if opens_dialog {
            // Later keys are meant for the dialog.
            break;
        }
    }
    commands
}

#[cfg(test)]
mod tests {
    use bevy::input::ButtonState;
    use bevy::prelude::Entity;

    use super::*;
    use crate::app::editor::command::display::DisplayMode;
    use crate::app::editor::command::seeing::{CutOpen, Seeing, Walls};
    use crate::app::editor::command::selection::Selection;
    use crate::app::editor::command::shortcut::Shortcut;
    use crate::app::editor::command::tool::Tool;
    use crate::app::editor::command::{DisplayCommand, ToolCommand, ViewCommand};
    use crate::app::editor::input::actions::find;

    fn event(key_code: KeyCode, logical_key: LogicalKey, state: ButtonState) -> KeyboardInput {
        KeyboardInput {
            key_code,
            logical_key,
            state,
            text: None,
            repeat: false,
            window: Entity::PLACEHOLDER,
        }
    }

    fn commands(events: &[KeyboardInput], modifiers: Modifiers) -> Vec<Command> {
        let presses = presses(events.iter(), modifiers);
        shortcuts(&presses, &ActionContext::new(&Selection::default()))
    }

    #[test]
    fn notes_over_the_picture_name_the_actions_that_end_them() {
        let seeing = Seeing {
            walls: Walls::HiddenForAxis,
            cut: Some(CutOpen {
                axis: 1,
                at: 2.0,
                above: true,
            }),
            wireframe: false,
        };
        let selection = Selection::default();
        let context = ActionContext {
            seeing,
            ..ActionContext::new(&selection)
        };
        assert_eq!(seeing.notes().count(), 2);
        for (text, name) in seeing.notes() {
            let action = find(name).expect(text);
            let Some(Command::View(ViewCommand::SetSeeing(after))) = (action.command)(&context) else {
                panic!("{text}");
            };
            assert!(!after.notes().any(|(left, _)| left == text), "{text}");
        }
    }

    #[test]
    fn keys_with_modifiers_do_not_fly() {
        let mut bound = KeyBindings::default();
        for (text, up) in [("G", 1.0), ("Ctrl+G", 0.0)] {
            bound.set("fly-up", Shortcut::parse(text).into_iter().collect());
            let mut input = InputState::default();
            input.keys_down.insert(Key::G);
            assert_eq!(fly_direction(&input, &bound), Vec3::Y * up, "{text}");
        }
    }

    #[test]
    fn modifier_keys_are_no_presses() {
        let s = || LogicalKey::Character("s".into());
        let events = [
            event(KeyCode::ControlLeft, LogicalKey::Control, ButtonState::Pressed),
            event(KeyCode::KeyS, s(), ButtonState::Pressed),
            event(KeyCode::KeyS, s(), ButtonState::Released),
        ];
        assert_eq!(
            commands(&events, Modifiers::COMMAND),
            [Command::from(FileCommand::Save)]
        );
    }

    #[test]
    fn a_key_without_its_texture_is_refused_aloud() {
        let u = event(KeyCode::KeyU, LogicalKey::Character("u".into()), ButtonState::Pressed);
        assert_eq!(
            commands(&[u], Modifiers::NONE),
            [Command::from(ToolCommand::SetTool(Tool::PlaceTexture))]
        );
    }

    #[test]
    fn each_press_counts_and_repeats_do_not() {
        let tab = |state| event(KeyCode::Tab, LogicalKey::Tab, state);
        let repeat = KeyboardInput {
            repeat: true,
            ..tab(ButtonState::Pressed)
        };
        let events = [
            tab(ButtonState::Pressed),
            repeat,
            tab(ButtonState::Released),
            tab(ButtonState::Pressed),
            tab(ButtonState::Released),
        ];
        let modes: Vec<DisplayMode> = commands(&events, Modifiers::NONE)
            .into_iter()
            .filter_map(|command| match command {
                Command::Display(DisplayCommand::SetDisplay(display)) => Some(display.mode),
                _ => None,
            })
            .collect();
        assert_eq!(modes, [DisplayMode::Albedo, DisplayMode::Normal]);
    }
}
