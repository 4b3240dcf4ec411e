//! The keyboard: which keys fly, and which are commands.

use bevy::ecs::system::SystemParam;
use bevy::input::keyboard::{Key as LogicalKey, KeyCode, KeyboardFocusLost, KeyboardInput};
use bevy::math::Vec3;
use bevy::prelude::{Local, MessageReader};
use bevy_egui::egui::{InputState, Key, Modifiers};
use bevy_egui::helpers::{bevy_to_egui_key, bevy_to_egui_physical_key};

use super::actions::{ACTIONS, Action, ActionContext};
use super::press::Press;
use crate::app::editor::command::Command;
use crate::app::editor::command::shell::ShellCommand;

/// To the left, up, forward, each -1, 0 or 1.
pub fn fly_direction(input: &InputState) -> Vec3 {
    let axis = |plus: Key, minus: Key| f32::from(input.key_down(plus)) - f32::from(input.key_down(minus));
    Vec3::new(axis(Key::A, Key::D), axis(Key::E, Key::Q), axis(Key::W, Key::S))
}

/// The modifier keys that are down. egui knows them once per frame only: of Control and S pressed and let go within one slow frame it
/// would keep the S alone.
#[derive(Debug, Default)]
pub struct HeldModifiers(Vec<(KeyCode, Modifiers)>);

impl HeldModifiers {
    /// Follows one event; returns the press it is, if it is one.
    fn follow(&mut self, event: &KeyboardInput) -> Option<Press> {
        let is_down = event.state.is_pressed();
        if !is_down {
            self.0.retain(|(code, _)| *code != event.key_code);
            return None;
        }
        if event.repeat {
            return None;
        }
        if let Some(modifier) = modifier(&event.logical_key) {
            self.0.retain(|(code, _)| *code != event.key_code);
            self.0.push((event.key_code, modifier));
            return None;
        }
        let numpad = numpad_digit(event.key_code);
        let key = numpad
            .or_else(|| bevy_to_egui_key(&event.logical_key))
            .or_else(|| bevy_to_egui_physical_key(&event.key_code))?;
        let modifiers = self.0.iter().fold(Modifiers::NONE, |all, (_, held)| all | *held);
        Some(Press {
            key,
            modifiers,
            numpad: numpad.is_some(),
        })
    }
}

/// Whatever Num Lock makes of it.
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

/// What a key is that changes what others mean.
pub fn modifier(key: &LogicalKey) -> Option<Modifiers> {
    let is_mac = cfg!(target_os = "macos");
    match key {
        LogicalKey::Control => Some(Modifiers {
            ctrl: true,
            command: !is_mac,
            ..Modifiers::NONE
        }),
        LogicalKey::Super if is_mac => Some(Modifiers {
            mac_cmd: true,
            command: true,
            ..Modifiers::NONE
        }),
        LogicalKey::Shift => Some(Modifiers::SHIFT),
        LogicalKey::Alt => Some(Modifiers::ALT),
        _ => None,
    }
}

/// The keyboard's events since the last frame.
#[derive(SystemParam)]
pub struct KeyEvents<'w, 's> {
    events: MessageReader<'w, 's, KeyboardInput>,
    focus_lost: MessageReader<'w, 's, KeyboardFocusLost>,
    held: Local<'s, HeldModifiers>,
}

impl KeyEvents<'_, '_> {
    /// The presses, in order. To be called each frame, whoever has the keyboard.
    pub fn presses(&mut self) -> Vec<Press> {
        let held = &mut *self.held;
        let presses = self.events.read().filter_map(|event| held.follow(event)).collect();
        if self.focus_lost.read().count() > 0 {
            held.0.clear();
        }
        presses
    }
}

/// The commands of the keys pressed this frame: each is made from what the one before left.
pub fn shortcuts(presses: &[Press], context: &ActionContext) -> Vec<Command> {
    let mut context = *context;
    let mut commands = Vec::new();
    for press in presses {
        // While flying, Control means slow.
        if context.flying && press.modifiers.command {
            continue;
        }
        let is_meant = |action: &&Action| action.keys.iter().any(|key| key.is_pressed(press));
        let Some(command) = ACTIONS
            .iter()
            .find(is_meant)
            .and_then(|action| (action.command)(&context))
        else {
            continue;
        };
        context.follow(&command);
        let opens_dialog = matches!(
            command,
            Command::ShowDialog(_) | Command::Shell(ShellCommand::ShowSheet(_))
        );
        commands.push(command);
        if opens_dialog {
            // What follows is meant for the dialog.
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
    use crate::app::editor::command::bvh_overlay::BvhOverlay;
    use crate::app::editor::command::display::{DisplayMode, DisplaySettings};
    use crate::app::editor::command::gizmo_settings::GizmoSettings;
    use crate::app::editor::command::selection::Selection;

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

    fn commands(events: &[KeyboardInput]) -> Vec<Command> {
        let mut held = HeldModifiers::default();
        let presses: Vec<Press> = events.iter().filter_map(|event| held.follow(event)).collect();
        assert!(held.0.is_empty(), "{held:?}");
        let context = ActionContext {
            display: DisplaySettings::default(),
            overlay: BvhOverlay::default(),
            paused: false,
            panels_shown: true,
            gizmo: GizmoSettings::default(),
            selection: &Selection::default(),
            tool: Default::default(),
            safe_frame: false,
            flying: false,
        };
        shortcuts(&presses, &context)
    }

    #[test]
    fn a_shortcut_tapped_within_a_frame_keeps_its_modifier() {
        let s = || LogicalKey::Character("s".into());
        let events = [
            event(KeyCode::ControlLeft, LogicalKey::Control, ButtonState::Pressed),
            event(KeyCode::KeyS, s(), ButtonState::Pressed),
            event(KeyCode::KeyS, s(), ButtonState::Released),
            event(KeyCode::ControlLeft, LogicalKey::Control, ButtonState::Released),
        ];
        assert_eq!(commands(&events), [Command::Save]);
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
        let modes: Vec<DisplayMode> = commands(&events)
            .into_iter()
            .filter_map(|command| match command {
                Command::SetDisplay(display) => Some(display.mode),
                _ => None,
            })
            .collect();
        assert_eq!(modes, [DisplayMode::Albedo, DisplayMode::Normal]);
    }
}
