//! Keys of the window while a field or a list has the keyboard. Keys that the field does not need act on the window,
//! but first the field loses the focus, so that its value counts before the scene is saved, undone or closed.

use bevy_egui::egui::{Context, Event, Key, Popup};

use crate::app::editor::command::key_bindings::KeyBindings;
use crate::app::editor::input::actions::ACTIONS;
use crate::app::editor::input::press::Press;

/// The owner of the keyboard, if not the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Keyboard {
    /// A field for texts or numbers.
    Text,
    /// A list or a menu that is open.
    Popup,
    /// A button, a slider or a similar widget.
    Widget,
}

impl Keyboard {
    /// The owner of the keyboard at the end of a frame. `picture`: whether it is the picture.
    pub fn of(context: &Context, picture: bool) -> Option<Self> {
        let is_elsewhere = !picture && context.memory(|memory| memory.focused()).is_some();
        match () {
            () if is_elsewhere && context.text_edit_focused() => Some(Self::Text),
            () if Popup::is_any_open(context) => Some(Self::Popup),
            () if is_elsewhere => Some(Self::Widget),
            () => None,
        }
    }

    /// Whether it uses the key itself.
    fn needs(self, press: &Press) -> bool {
        let (key, held) = (press.key, press.modifiers);
        let moves = matches!(
            key,
            Key::ArrowUp
                | Key::ArrowDown
                | Key::ArrowLeft
                | Key::ArrowRight
                | Key::Home
                | Key::End
                | Key::PageUp
                | Key::PageDown
                | Key::Tab
                | Key::Enter
                | Key::Escape
                | Key::Space
        );
        let is_plain = !held.command && !held.alt && !is_function_key(key);
        match self {
            Self::Widget => moves,
            Self::Popup => moves || is_plain,
            Self::Text => {
                let erases = matches!(key, Key::Backspace | Key::Delete | Key::Insert);
                let edits = matches!(key, Key::A | Key::C | Key::V | Key::X | Key::Y | Key::Z);
                // Some keyboards type signs with Alt, or with Control and Alt.
                let is_sign = held.alt && (held.command || cfg!(target_os = "macos"));
                moves || erases || is_plain || is_sign || held.command && edits
            }
        }
    }
}

fn is_function_key(key: Key) -> bool {
    (Key::F1..=Key::F35).contains(&key)
}

/// Keys that wait until the field has lost the focus and reported its value.
#[derive(Debug, Default)]
pub struct FieldKeys {
    waiting: Vec<Press>,
    step: Step,
    /// Whether a field has lost the focus because the window is to close.
    has_left: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Step {
    /// No field is losing the focus.
    #[default]
    None,
    /// The field loses the focus at the end of this frame, so that it gets the letters of this frame.
    Leaves,
    /// The field reports its value in this frame.
    Says,
}

impl FieldKeys {
    /// The key presses that act on the window in this frame. `keyboard` is the owner of the keyboard at the end of the
    /// last frame. To be called before the fields are shown.
    pub fn take(
        &mut self,
        context: &Context,
        presses: Vec<Press>,
        keyboard: Option<Keyboard>,
        bound: &KeyBindings,
    ) -> Vec<Press> {
        if keyboard == Some(Keyboard::Text) {
            leave_pressed_beside(context);
        }
        let is_for_window = |keyboard: Keyboard, press: &Press| {
            !keyboard.needs(press) && ACTIONS.iter().any(|action| action.is_pressed(press, bound))
        };
        match (self.step, keyboard) {
            (Step::None, Some(keyboard)) if self.waiting.is_empty() => {
                let first = presses.iter().position(|press| is_for_window(keyboard, press));
                if let Some(first) = first {
                    self.waiting.extend_from_slice(&presses[first..]);
                    self.step = Step::Leaves;
                    // Fields use some of them in a manner that no user expects, such as Ctrl+H.
                    forget(context, &self.waiting);
                }
                Vec::new()
            }
            (Step::None, _) => {
                let mut all = std::mem::take(&mut self.waiting);
                all.extend(presses);
                all
            }
            (Step::Leaves | Step::Says, _) => {
                self.waiting.extend(presses);
                Vec::new()
            }
        }
    }

    /// Drops the waiting keys, because a question covers the window.
    pub fn drop_waiting(&mut self) {
        self.waiting.clear();
    }

    /// Takes the focus from the field. Returns true once its value is reported: then the window may close. The focus is
    /// taken only once until then, because some fields request it in every frame.
    pub fn is_left(&mut self, keyboard: Option<Keyboard>) -> bool {
        if self.step == Step::None && keyboard == Some(Keyboard::Text) && !self.has_left {
            self.step = Step::Leaves;
        }
        self.has_left = self.step != Step::None;
        !self.has_left
    }

    /// Ends the frame, after all widgets are shown.
    pub fn end_frame(&mut self, context: &Context) {
        self.step = match self.step {
            Step::None => return,
            Step::Leaves => {
                context.memory_mut(|memory| memory.stop_text_input());
                Step::Says
            }
            Step::Says => {
                Popup::close_all(context);
                Step::None
            }
        };
        context.request_repaint();
    }
}

/// Takes the focus from the field before a press elsewhere acts, which may replace the field.
fn leave_pressed_beside(context: &Context) {
    let Some(focused) = context.memory(|memory| memory.focused()) else {
        return;
    };
    let place = context.read_response(focused).map(|response| response.interact_rect);
    let press = |event: &Event| match *event {
        Event::PointerButton { pos, pressed: true, .. } => Some(pos),
        _ => None,
    };
    let pressed = context.input(|input| input.events.iter().find_map(press));
    if let (Some(place), Some(pressed)) = (place, pressed)
        && !place.contains(pressed)
    {
        context.memory_mut(|memory| memory.surrender_focus(focused));
    }
}

/// Removes the events of these keys.
fn forget(context: &Context, presses: &[Press]) {
    let is_one = |event: &Event| match event {
        Event::Key { key, pressed: true, .. } => presses.iter().any(|press| press.key == *key),
        _ => false,
    };
    context.input_mut(|input| input.events.retain(|event| !is_one(event)));
}

#[cfg(test)]
mod tests {
    use bevy_egui::egui::{self, DragValue, Id, Modifiers, Ui};
    use egui_kittest::Harness;
    use egui_kittest::kittest::Queryable;

    use super::*;
    use crate::app::editor::command::key_bindings::NO_BINDINGS;
    use crate::app::editor::input::number_field::{Meaning, number};

    /// A number as in a panel, the owner of the keyboard, and the effects of keys and texts in order.
    struct Shown {
        value: f32,
        keys: FieldKeys,
        keyboard: Option<Keyboard>,
        said: Vec<String>,
    }

    fn panel() -> Harness<'static, Shown> {
        let show = |ui: &mut Ui, shown: &mut Shown| {
            let context = ui.ctx().clone();
            let presses = presses(&context);
            for press in shown.keys.take(&context, presses, shown.keyboard, &NO_BINDINGS) {
                shown.said.push(press.shortcut().text());
            }
            let drag = DragValue::new(&mut shown.value);
            let format = |value: f64, _| format!("{value}");
            let label = ui.label("Width");
            let field = number(ui, drag, (), -1000.0..=1000.0, Meaning::Number, format);
            if ui.add(field).labelled_by(label.id).changed() {
                shown.said.push(format!("width {}", shown.value));
            }
            let picture = ui.interact(
                ui.available_rect_before_wrap(),
                Id::new("picture"),
                egui::Sense::click(),
            );
            if ui.memory(|memory| memory.focused()).is_none() {
                picture.request_focus();
            }
            shown.keys.end_frame(&context);
            shown.keyboard = Keyboard::of(&context, picture.has_focus());
        };
        let shown = Shown {
            value: 3.0,
            keys: FieldKeys::default(),
            keyboard: None,
            said: Vec::new(),
        };
        let mut harness = Harness::builder()
            .with_size(egui::vec2(300.0, 200.0))
            .build_ui_state(show, shown);
        harness.run_steps(3);
        harness
    }

    fn presses(context: &Context) -> Vec<Press> {
        let press = |event: &Event| match *event {
            Event::Key {
                key,
                pressed: true,
                repeat: false,
                modifiers,
                ..
            } => Some(Press {
                key,
                modifiers,
                numpad: false,
            }),
            _ => None,
        };
        context.input(|input| input.events.iter().filter_map(press).collect())
    }

    fn key(key: Key, modifiers: Modifiers) -> [Event; 2] {
        [true, false].map(|pressed| Event::Key {
            key,
            physical_key: None,
            pressed,
            repeat: false,
            modifiers,
        })
    }

    /// A frame with these events, and some more.
    fn frame(harness: &mut Harness<Shown>, modifiers: Modifiers, events: &[Event]) {
        let input = harness.input_mut();
        input.events.push(Event::ModifiersChanged(modifiers));
        input.events.extend_from_slice(events);
        harness.run_steps(4);
    }

    fn typed(text: &str) -> Harness<'static, Shown> {
        let mut harness = panel();
        harness.get_by_label("Width").click();
        harness.run_steps(3);
        frame(&mut harness, Modifiers::NONE, &[Event::Text(text.to_owned())]);
        harness
    }

    #[test]
    fn what_is_typed_counts_before_the_key_of_the_window() {
        for (pressed, modifiers, name) in [
            (Key::S, Modifiers::COMMAND, "Ctrl+S"),
            (Key::H, Modifiers::COMMAND, "Ctrl+H"),
            (Key::F5, Modifiers::NONE, "F5"),
            (Key::H, Modifiers::ALT, "Alt+H"),
        ] {
            let mut harness = typed("7");
            frame(&mut harness, modifiers, &key(pressed, modifiers));
            assert_eq!(harness.state().said, ["width 7", name]);
        }
    }

    #[test]
    fn letters_of_the_same_frame_are_typed_before() {
        let mut harness = typed("7");
        let mut events = vec![Event::Text("5".to_owned())];
        events.extend(key(Key::F5, Modifiers::NONE));
        frame(&mut harness, Modifiers::NONE, &events);
        assert_eq!(harness.state().said, ["width 75", "F5"]);
    }

    #[test]
    fn a_text_that_is_no_number_stays_and_the_key_counts() {
        let mut harness = typed("7x");
        frame(&mut harness, Modifiers::COMMAND, &key(Key::S, Modifiers::COMMAND));
        assert_eq!(harness.state().said, ["Ctrl+S"]);
        assert!(harness.query_all_by_value("7x").next().is_some());
    }

    #[test]
    fn a_field_keeps_what_it_needs() {
        for (pressed, modifiers) in [
            (Key::G, Modifiers::NONE),
            (Key::Delete, Modifiers::NONE),
            (Key::Z, Modifiers::COMMAND),
            (Key::A, Modifiers::COMMAND),
            (Key::H, Modifiers::COMMAND.plus(Modifiers::ALT)),
        ] {
            let mut harness = typed("7");
            frame(&mut harness, modifiers, &key(pressed, modifiers));
            assert_eq!(harness.state().said, [""; 0], "{pressed:?}");
            assert_eq!(harness.state().keyboard, Some(Keyboard::Text), "{pressed:?}");
        }
        // Without a field the same keys act on the window.
        let mut harness = panel();
        frame(&mut harness, Modifiers::NONE, &key(Key::Delete, Modifiers::NONE));
        assert_eq!(harness.state().said, ["Delete"]);
    }

    #[test]
    fn a_button_with_the_keyboard_keeps_only_what_moves_it() {
        for (pressed, is_needed) in [
            (Key::Space, true),
            (Key::Tab, true),
            (Key::G, false),
            (Key::Delete, false),
        ] {
            let press = Press {
                key: pressed,
                modifiers: Modifiers::NONE,
                numpad: false,
            };
            assert_eq!(Keyboard::Widget.needs(&press), is_needed, "{pressed:?}");
        }
    }

    #[test]
    fn a_window_that_closes_takes_what_was_typed() {
        let mut harness = typed("7");
        let keyboard = harness.state().keyboard;
        assert!(!harness.state_mut().keys.is_left(keyboard));
        harness.run_steps(3);
        assert_eq!(harness.state().said, ["width 7"]);
        let keyboard = harness.state().keyboard;
        assert!(harness.state_mut().keys.is_left(keyboard));
    }

    /// The palette is such a field, for instance.
    #[test]
    fn a_window_closes_although_a_field_takes_the_keyboard_in_every_frame() {
        #[derive(Default)]
        struct Window {
            text: String,
            keys: FieldKeys,
            keyboard: Option<Keyboard>,
            closes: bool,
        }
        let show = |ui: &mut Ui, window: &mut Window| {
            ui.text_edit_singleline(&mut window.text).request_focus();
            if window.closes && window.keys.is_left(window.keyboard) {
                window.closes = false;
            }
            window.keys.end_frame(ui.ctx());
            window.keyboard = Keyboard::of(ui.ctx(), false);
        };
        let mut harness = Harness::builder()
            .with_size(egui::vec2(300.0, 200.0))
            .build_ui_state(show, Window::default());
        harness.run_steps(3);
        assert_eq!(harness.state().keyboard, Some(Keyboard::Text));
        // In the first turn the question that follows may have been cancelled.
        for _ in 0..2 {
            harness.state_mut().closes = true;
            harness.run_steps(6);
            assert!(!harness.state().closes);
        }
    }

    #[test]
    fn a_press_beside_the_field_leaves_it_at_once() {
        let mut harness = typed("7");
        let pos = egui::pos2(150.0, 150.0);
        let button = |pressed| Event::PointerButton {
            pos,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        let input = harness.input_mut();
        input
            .events
            .extend([Event::PointerMoved(pos), button(true), button(false)]);
        harness.run_steps(1);
        assert_eq!(harness.state().said, ["width 7"]);
    }
}
