//! Holds back an Enter that came in one frame with letters. The file dialog looks at Enter before its text field has taken the letters in.

use bevy_egui::egui::{Context, Event, Key};

/// An Enter that waits for the next frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct LateEnter {
    waits: bool,
}

impl LateEnter {
    /// To be called before a dialog of the frame is shown.
    pub fn hold_back(&mut self, context: &Context) {
        let came_late = context.input_mut(|input| {
            if std::mem::take(&mut self.waits) {
                input.events.push(enter(input.modifiers));
            }
            let is_enter = |event: &Event| {
                matches!(
                    event,
                    Event::Key {
                        key: Key::Enter,
                        pressed: true,
                        ..
                    }
                )
            };
            let has_text = input
                .events
                .iter()
                .any(|event| matches!(event, Event::Text(_) | Event::Paste(_)));
            let before = input.events.len();
            if has_text {
                input.events.retain(|event| !is_enter(event));
            }
            before != input.events.len()
        });
        if came_late {
            self.waits = true;
            context.request_repaint();
        }
    }
}

fn enter(modifiers: bevy_egui::egui::Modifiers) -> Event {
    Event::Key {
        key: Key::Enter,
        physical_key: None,
        pressed: true,
        repeat: false,
        modifiers,
    }
}

#[cfg(test)]
mod tests {
    use bevy_egui::egui::{Modifiers, RawInput};

    use super::*;

    #[test]
    fn letters_come_before_the_enter_behind_them() {
        let context = Context::default();
        let mut late = LateEnter::default();
        let mut frame = |events: Vec<Event>| {
            let mut seen = None;
            let input = RawInput {
                events,
                ..RawInput::default()
            };
            let _ = context.run_ui(input, |ui| {
                late.hold_back(ui.ctx());
                seen.get_or_insert(ui.input(|input| input.key_pressed(Key::Enter)));
            });
            seen
        };
        let none = Modifiers::NONE;
        assert_eq!(frame(vec![Event::Text("a".into()), enter(none)]), Some(false));
        assert_eq!(frame(Vec::new()), Some(true));
        assert_eq!(frame(Vec::new()), Some(false));
        assert_eq!(frame(vec![enter(none)]), Some(true));
    }
}
