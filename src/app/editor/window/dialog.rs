//! Covers over the window: questions, forms and lists. Keys that were pressed before a cover could be read do not act
//! on it, and each key acts on the uppermost alone.

use bevy_egui::egui::{Context, Event, Id, Key, LayerId, Modal, Modifiers, Popup, RichText, Ui};

/// The height of the buttons that stand below each other on pages and in lists, in points.
pub(super) const ROW: f32 = 24.0;

/// The result of a cover in a frame.
pub struct Cover<R> {
    /// The value that the content has returned.
    pub inner: R,
    closes: bool,
}

impl<R> Cover<R> {
    /// Whether it is to be closed without an answer.
    pub fn should_close(&self) -> bool {
        self.closes
    }
}

/// Asks a question. Esc closes it; a click beside it does not, because it may be meant for the widgets below.
pub fn question<R>(
    context: &Context,
    id: &str,
    width: f32,
    heading: &str,
    content: impl FnOnce(&mut Ui) -> R,
) -> Cover<R> {
    show(context, Modal::new(Id::new(id)), Kind::Question, |ui| {
        ui.set_width(width);
        ui.label(RichText::new(heading).heading().strong());
        ui.add_space(6.0);
        content(ui)
    })
}

/// Shows a form or a list, which Esc and a click beside it close.
pub fn form<R>(context: &Context, modal: Modal, content: impl FnOnce(&mut Ui) -> R) -> Cover<R> {
    show(context, modal, Kind::Form, content)
}

/// Shows a form that a click beside it does not close, because typed text would be lost.
pub fn lasting_form<R>(context: &Context, id: &str, content: impl FnOnce(&mut Ui) -> R) -> Cover<R> {
    show(context, Modal::new(Id::new(id)), Kind::LastingForm, content)
}

/// Whether Enter gives the usual answer to a question. A focused button takes Enter instead.
pub fn is_entered(ui: &Ui) -> bool {
    ui.memory(|memory| memory.focused()).is_none()
        && ui.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Enter))
}

/// The consequence of an answer, as a sentence.
pub fn consequence(ui: &mut Ui, answer: &str, what: &str) {
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        ui.strong(format!("{answer}:"));
        ui.label(what);
    });
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Question,
    Form,
    LastingForm,
}

/// The time for which a question fades in, in seconds. On a slow machine it is hardly visible in its first frame.
const FADE_IN: f64 = 0.2;

/// The readiness of a cover for input.
#[derive(Clone, Copy, Debug, Default)]
struct Progress {
    /// The last pass that showed it.
    pass: u64,
    /// Whether it has been drawn. In its first pass it is only measured.
    is_drawn: bool,
    /// The time of its first drawing, in seconds.
    drawn_at: f64,
    /// Whether no key was held at some time after it was visible.
    were_keys_up: bool,
}

/// Whether keys are held, according to the window.
#[derive(Clone, Copy)]
struct KeysHeld(bool);

/// Notes whether a key is held. egui misses keys that are released while another window is in front, or after Shift.
pub fn note_keys(context: &Context, are_held: bool) {
    context.data_mut(|data| data.insert_temp(Id::NULL, KeysHeld(are_held)));
}

fn are_keys_held(context: &Context) -> bool {
    let told = context
        .data(|data| data.get_temp(Id::NULL))
        .map(|KeysHeld(are_held)| are_held);
    told.unwrap_or_else(|| context.input(|input| !input.keys_down.is_empty()))
}

fn show<R>(context: &Context, modal: Modal, kind: Kind, content: impl FnOnce(&mut Ui) -> R) -> Cover<R> {
    let layer = modal.area.layer();
    let id = layer.id.with("progress");
    let pass = context.cumulative_pass_nr();
    let before: Option<Progress> = context.data(|data| data.get_temp(id));
    // A cover that was not shown in the last pass starts again.
    let before = before.filter(|before| before.pass + 1 >= pass);
    let mut progress = before.unwrap_or_default();
    let is_covered = before.is_some() && is_another_above(context, layer);
    let withheld = withhold(context, |event| {
        is_covered && is_typed(event) || !progress.takes(kind, event)
    });
    let mut is_measured = false;
    let is_popup_open = Popup::is_any_open(context);
    let modal = modal.show(context, |ui| {
        is_measured = ui.is_sizing_pass();
        content(ui)
    });
    let is_beside = kind == Kind::Form && modal.backdrop_response.clicked();
    let leaves = || context.input_mut(|input| input.consume_key(Modifiers::NONE, Key::Escape));
    let closes = modal.response.should_close() || is_beside || !is_popup_open && leaves();
    if is_covered {
        // The withheld events are for the other cover.
        context.input_mut(|input| input.events.extend(withheld));
    }
    progress.pass = pass;
    let time = context.input(|input| input.time);
    if !progress.is_drawn && !is_measured {
        progress.is_drawn = true;
        progress.drawn_at = time;
    }
    let is_seen = progress.is_drawn && time - progress.drawn_at >= FADE_IN;
    progress.were_keys_up |= is_seen && !are_keys_held(context);
    context.data_mut(|data| data.insert_temp(id, progress));
    if !progress.were_keys_up {
        context.request_repaint();
    }
    Cover {
        inner: modal.inner,
        closes,
    }
}

impl Progress {
    /// Whether an event acts on the cover. A form that the user has opened takes typed keys at once.
    fn takes(&self, kind: Kind, event: &Event) -> bool {
        let is_answer = matches!(
            event,
            Event::Key {
                key: Key::Enter | Key::Escape | Key::Space,
                ..
            }
        );
        // A key held since before the cover opened repeats.
        let is_repeated = matches!(event, Event::Key { repeat: true, .. });
        match kind {
            Kind::Question => !is_typed(event) || self.were_keys_up && !is_repeated,
            Kind::Form | Kind::LastingForm => !is_answer || self.is_drawn && !is_repeated,
        }
    }
}

/// Whether another cover lies over this layer.
fn is_another_above(context: &Context, layer: LayerId) -> bool {
    context.memory(|memory| memory.top_modal_layer().is_some() && !memory.is_above_modal_layer(layer))
}

/// Removes events, and returns them.
fn withhold(context: &Context, is_withheld: impl Fn(&Event) -> bool) -> Vec<Event> {
    context.input_mut(|input| {
        let events = std::mem::take(&mut input.events);
        let (withheld, left) = events.into_iter().partition(|event| is_withheld(event));
        input.events = left;
        withheld
    })
}

/// Whether the event is a key press, or an effect of one.
pub(super) fn is_typed(event: &Event) -> bool {
    use Event::{Copy, Cut, Key, Paste, Text};
    matches!(event, Copy | Cut | Key { pressed: true, .. } | Paste(_) | Text(_))
}

#[cfg(test)]
mod tests {
    use bevy_egui::egui;
    use egui_kittest::Harness;

    use super::*;

    /// A question behind another, each with its answer: by Enter or by Esc.
    #[derive(Default)]
    struct Shown {
        is_open: [bool; 2],
        said: [Option<&'static str>; 2],
    }

    fn questions() -> Harness<'static, Shown> {
        let show = |ui: &mut Ui, shown: &mut Shown| {
            let context = ui.ctx().clone();
            for (place, id) in ["first", "second"].into_iter().enumerate() {
                if !shown.is_open[place] {
                    continue;
                }
                let cover = question(&context, id, 200.0, id, |ui| is_entered(ui));
                if cover.inner {
                    shown.said[place] = Some("entered");
                } else if cover.should_close() {
                    shown.said[place] = Some("closed");
                }
                shown.is_open[place] &= shown.said[place].is_none();
            }
        };
        Harness::builder()
            .with_size(egui::vec2(600.0, 400.0))
            .build_ui_state(show, Shown::default())
    }

    fn key(key: Key, pressed: bool) -> Event {
        Event::Key {
            key,
            physical_key: None,
            pressed,
            repeat: false,
            modifiers: Modifiers::NONE,
        }
    }

    /// A frame with these events.
    fn frame(harness: &mut Harness<Shown>, events: &[Event]) {
        harness.input_mut().events.extend_from_slice(events);
        harness.run_steps(1);
    }

    #[test]
    fn a_key_that_was_pressed_before_a_question_is_not_for_it() {
        for answer in [Key::Enter, Key::Escape] {
            let mut harness = questions();
            harness.state_mut().is_open[0] = true;
            // It opens in the frame of the key, which is held and repeats.
            frame(&mut harness, &[key(answer, true)]);
            for _ in 0..4 {
                frame(&mut harness, &[key(answer, true)]);
            }
            assert_eq!(harness.state().said, [None; 2], "{answer:?}");
            // Another key does not count before all are up.
            frame(&mut harness, &[key(Key::Escape, true), key(Key::Escape, false)]);
            assert_eq!(harness.state().said, [None; 2], "{answer:?}");
            frame(&mut harness, &[key(answer, false)]);
            frame(&mut harness, &[key(answer, true)]);
            assert!(harness.state().said[0].is_some(), "{answer:?}");
        }
    }

    #[test]
    fn the_answer_to_one_question_is_not_that_to_the_next() {
        let mut harness = questions();
        harness.state_mut().is_open[0] = true;
        for _ in 0..3 {
            frame(&mut harness, &[]);
        }
        // The second comes in the frame of the answer.
        harness.state_mut().is_open[1] = true;
        frame(&mut harness, &[key(Key::Enter, true)]);
        assert_eq!(harness.state().said, [Some("entered"), None]);
        frame(&mut harness, &[key(Key::Enter, true)]);
        assert_eq!(harness.state().said[1], None);
        frame(&mut harness, &[key(Key::Enter, false)]);
        frame(&mut harness, &[key(Key::Enter, true)]);
        assert_eq!(harness.state().said[1], Some("entered"));
    }

    #[test]
    fn keys_are_for_the_uppermost_question() {
        let mut harness = questions();
        harness.state_mut().is_open[0] = true;
        for _ in 0..3 {
            frame(&mut harness, &[]);
        }
        harness.state_mut().is_open[1] = true;
        for _ in 0..3 {
            frame(&mut harness, &[]);
        }
        frame(&mut harness, &[key(Key::Escape, true), key(Key::Escape, false)]);
        assert_eq!(harness.state().said, [None, Some("closed")]);
        for _ in 0..2 {
            frame(&mut harness, &[]);
        }
        frame(&mut harness, &[key(Key::Enter, true)]);
        assert_eq!(harness.state().said[0], Some("entered"));
    }

    #[test]
    fn a_click_beside_a_question_leaves_it_open() {
        let mut harness = questions();
        harness.state_mut().is_open[0] = true;
        for _ in 0..3 {
            frame(&mut harness, &[]);
        }
        let corner = egui::pos2(5.0, 5.0);
        let button = |pressed| Event::PointerButton {
            pos: corner,
            button: egui::PointerButton::Primary,
            pressed,
            modifiers: Modifiers::NONE,
        };
        frame(&mut harness, &[Event::PointerMoved(corner), button(true)]);
        frame(&mut harness, &[button(false)]);
        frame(&mut harness, &[]);
        assert!(harness.state().is_open[0]);
    }
}
