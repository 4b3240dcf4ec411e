//! Passes keys on in the order in which they came. A frame has one state of the modifier keys and one owner of the
//! keyboard, but during a slow one a user may have clicked into a number, pressed Control and A, some digits and Enter.
//! Keys after a change of either wait for the next frame.

use bevy::ecs::message::MessageCursor;
use bevy::input::keyboard::{Key, KeyboardFocusLost, KeyboardInput};
use bevy::prelude::*;
use bevy::window::{RequestRedraw, WindowEvent};

use super::keys::is_modifier;

/// Orders the keys. Runs before all readers of the keyboard.
pub fn order_keys(
    mut keys: ResMut<Messages<KeyboardInput>>,
    mut events: MessageReader<WindowEvent>,
    mut losses: ResMut<Messages<KeyboardFocusLost>>,
    mut redraws: MessageWriter<RequestRedraw>,
    mut read: Local<MessageCursor<KeyboardInput>>,
    mut read_losses: Local<MessageCursor<KeyboardFocusLost>>,
    mut waiting: Local<Vec<KeyboardInput>>,
    mut loss_waits: Local<bool>,
) {
    let before_button = before_button(events.read());
    let is_focus_lost = read_losses.read(&losses).count() > 0;
    if std::mem::take(&mut *loss_waits) {
        losses.write(KeyboardFocusLost);
        read_losses.clear(&losses);
    }
    let held = waiting.len();
    waiting.extend(read.read(&keys).cloned());
    let free = before_button.map_or(waiting.len(), |count| held + count);
    let now = batch(&waiting).min(free).min(waiting.len());
    if is_focus_lost && now > 0 {
        // Losing the focus releases the modifiers: keys from before are read first.
        losses.clear();
        *loss_waits = true;
        redraws.write(RequestRedraw);
    }
    if held == 0 && now == waiting.len() {
        waiting.clear();
        return;
    }
    keys.clear();
    keys.write_batch(waiting.drain(..now));
    read.clear(&keys);
    if is_focus_lost {
        // No key is held after this frame: one that went down now and was played later would stay down.
        waiting.retain(|key| !key.state.is_pressed());
    }
    if !waiting.is_empty() {
        redraws.write(RequestRedraw);
    }
}

/// The keys that came before the first mouse button of the frame; None if there was no button.
fn before_button<'a>(events: impl Iterator<Item = &'a WindowEvent>) -> Option<usize> {
    let (mut keys, mut found) = (0, None);
    for event in events {
        match event {
            WindowEvent::KeyboardInput(_) => keys += 1,
            WindowEvent::MouseButtonInput(_) => found = found.or(Some(keys)),
            _ => {}
        }
    }
    found
}

/// The number of leading keys that share one state of the modifiers, namely that of the first other key, and one owner
/// of the keyboard.
fn batch(keys: &[KeyboardInput]) -> usize {
    let (mut has_press, mut has_left) = (false, false);
    let next = keys.iter().position(|key| {
        let is_modifier = is_modifier(&key.logical_key);
        let is_next = has_left || (is_modifier && has_press);
        has_press |= !is_modifier && key.state.is_pressed();
        // Slow frames would never get through the repeats of a held key.
        has_left |= key.state.is_pressed() && !key.repeat && leaves(&key.logical_key);
        is_next
    });
    next.unwrap_or(keys.len())
}

/// Whether the keyboard may have another owner after the key.
fn leaves(key: &Key) -> bool {
    let is_of_window = matches!(
        key,
        Key::F1
            | Key::F2
            | Key::F3
            | Key::F4
            | Key::F5
            | Key::F6
            | Key::F7
            | Key::F8
            | Key::F9
            | Key::F10
            | Key::F11
            | Key::F12
    );
    is_of_window || matches!(key, Key::Enter | Key::Tab | Key::Escape)
}

#[cfg(test)]
mod tests {
    use bevy::input::ButtonState::{self, Pressed, Released};
    use bevy::input::keyboard::KeyCode;
    use bevy::input::mouse::{MouseButton, MouseButtonInput};

    use super::*;

    const CONTROL: (KeyCode, Key) = (KeyCode::ControlLeft, Key::Control);

    fn letter(code: KeyCode, text: &str) -> (KeyCode, Key) {
        (code, Key::Character(text.into()))
    }

    fn key((key_code, logical_key): (KeyCode, Key), state: ButtonState) -> KeyboardInput {
        KeyboardInput {
            key_code,
            logical_key,
            state,
            text: None,
            repeat: false,
            window: Entity::PLACEHOLDER,
        }
    }

    /// The keys that each frame reads if all of these arrive in the first one; None is a mouse button.
    fn frames(came: &[Option<((KeyCode, Key), ButtonState)>]) -> Vec<Vec<(KeyCode, ButtonState)>> {
        frames_in(World::new(), came)
    }

    /// The keys as in [`frames`], if the focus is lost in the first frame.
    fn frames_without_focus(came: &[Option<((KeyCode, Key), ButtonState)>]) -> Vec<Vec<(KeyCode, ButtonState)>> {
        let mut world = World::new();
        world.init_resource::<Messages<KeyboardFocusLost>>();
        world.write_message(KeyboardFocusLost);
        frames_in(world, came)
    }

    fn frames_in(mut world: World, came: &[Option<((KeyCode, Key), ButtonState)>]) -> Vec<Vec<(KeyCode, ButtonState)>> {
        world.init_resource::<Messages<KeyboardInput>>();
        world.init_resource::<Messages<WindowEvent>>();
        world.init_resource::<Messages<KeyboardFocusLost>>();
        world.init_resource::<Messages<RequestRedraw>>();
        let window = Entity::PLACEHOLDER;
        for event in came {
            let Some((which, state)) = event.clone() else {
                let (button, state) = (MouseButton::Left, Pressed);
                world.write_message(WindowEvent::from(MouseButtonInput { button, state, window }));
                continue;
            };
            let key = key(which, state);
            world.write_message(WindowEvent::from(key.clone()));
            world.write_message(key);
        }
        let system = world.register_system(order_keys);
        let mut reader = MessageCursor::default();
        let mut frames = Vec::new();
        for _ in 0..came.len() + 1 {
            world.run_system(system).expect("runs");
            let keys = world.resource::<Messages<KeyboardInput>>();
            frames.push(reader.read(keys).map(|key| (key.key_code, key.state)).collect());
        }
        while frames.last().is_some_and(Vec::is_empty) {
            frames.pop();
        }
        frames
    }

    #[test]
    fn a_letter_keeps_the_modifiers_it_was_pressed_with() {
        let (a, five) = (letter(KeyCode::KeyA, "a"), letter(KeyCode::Digit5, "5"));
        let came = [
            (CONTROL, Pressed),
            (a.clone(), Pressed),
            (a, Released),
            (CONTROL, Released),
            (five, Pressed),
        ];
        let seen = frames(&came.map(Some));
        let first = vec![
            (KeyCode::ControlLeft, Pressed),
            (KeyCode::KeyA, Pressed),
            (KeyCode::KeyA, Released),
        ];
        let second = vec![(KeyCode::ControlLeft, Released), (KeyCode::Digit5, Pressed)];
        assert_eq!(seen, [first, second]);
    }

    #[test]
    fn what_is_typed_after_a_click_is_for_what_was_clicked() {
        let (a, b) = (letter(KeyCode::KeyA, "a"), letter(KeyCode::KeyB, "b"));
        let seen = frames(&[Some((a, Pressed)), None, Some((b, Pressed))]);
        assert_eq!(seen, [vec![(KeyCode::KeyA, Pressed)], vec![(KeyCode::KeyB, Pressed)]]);
    }

    #[test]
    fn nothing_goes_down_after_the_focus_is_lost() {
        let (s, w) = (letter(KeyCode::KeyS, "s"), letter(KeyCode::KeyW, "w"));
        let came = [
            (CONTROL, Pressed),
            (s, Pressed),
            (CONTROL, Released),
            (w, Pressed),
            ((KeyCode::AltLeft, Key::Alt), Pressed),
        ];
        let first = vec![(KeyCode::ControlLeft, Pressed), (KeyCode::KeyS, Pressed)];
        let second = vec![(KeyCode::ControlLeft, Released)];
        assert_eq!(frames_without_focus(&came.map(Some)), [first, second]);
    }

    #[test]
    fn keys_are_read_before_the_loss_of_the_focus_that_came_after_them() {
        let mut world = World::new();
        world.init_resource::<Messages<KeyboardInput>>();
        world.init_resource::<Messages<WindowEvent>>();
        world.init_resource::<Messages<KeyboardFocusLost>>();
        world.init_resource::<Messages<RequestRedraw>>();
        world.write_message(key(letter(KeyCode::KeyS, "s"), Pressed));
        world.write_message(KeyboardFocusLost);
        let system = world.register_system(order_keys);
        let mut losses = MessageCursor::default();
        let seen = [(); 3].map(|()| {
            world.run_system(system).expect("runs");
            losses.read(world.resource::<Messages<KeyboardFocusLost>>()).count()
        });
        assert_eq!(seen, [0, 1, 0]);
    }

    #[test]
    fn what_is_typed_after_a_key_that_moves_the_focus_is_for_the_next() {
        for (code, key) in [
            (KeyCode::Enter, Key::Enter),
            (KeyCode::Tab, Key::Tab),
            (KeyCode::Escape, Key::Escape),
            (KeyCode::F5, Key::F5),
        ] {
            let (five, w) = (letter(KeyCode::Digit5, "5"), letter(KeyCode::KeyW, "w"));
            let came = [
                (five, Pressed),
                ((code, key.clone()), Pressed),
                ((code, key), Released),
                (w, Pressed),
            ];
            let first = vec![(KeyCode::Digit5, Pressed), (code, Pressed)];
            let second = vec![(code, Released), (KeyCode::KeyW, Pressed)];
            assert_eq!(frames(&came.map(Some)), [first, second]);
        }
    }

    #[test]
    fn plain_typing_waits_for_nothing() {
        let typed = ["a", "b", "c"].map(|text| Some((letter(KeyCode::KeyA, text), Pressed)));
        assert_eq!(frames(&typed).len(), 1);
    }
}
