//! Types into fields for numbers without a window.

use bevy_egui::egui;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable;

use super::*;

#[test]
fn numbers_beyond_a_range_are_told_with_its_end() {
    assert_eq!(beyond(1.5, 0.0, 1.0), "1.5 is not possible here: 1 is the most");
    assert_eq!(beyond(-2.0, 0.0, 1.0), "-2 is not possible here: 0 is the least");
}

#[test]
fn lengths_have_units_and_arithmetic() {
    let read = |text| Meaning::Length(LengthUnit::Metre).read(text);
    for (text, expected) in [
        ("30cm", 0.3),
        ("30 cm + 5cm", 0.35),
        ("1/4in", 0.25 * 0.0254),
        ("6'2\"", 74.0 * 0.0254),
        ("2m/4", 0.5),
        ("1,5", 1.5),
        ("0m", 0.0),
    ] {
        assert!(
            read(text).is_some_and(|found| (found - expected).abs() < 1e-9),
            "{text}: {:?}",
            read(text)
        );
    }
    assert_eq!(read("2 miles"), None);
}

/// A field and the values that it was set to, frame by frame.
fn field(value: f64) -> Harness<'static, (f64, usize)> {
    let show = |ui: &mut Ui, (value, changes): &mut (f64, usize)| {
        let drag = DragValue::new(value).clamp_existing_to_range(false);
        let format = |value: f64, _| format!("{value:.2}");
        let label = ui.label("Width");
        let field = number(ui, drag, (), -100.0..=100.0, Meaning::Number, format);
        *changes += usize::from(ui.add(field).labelled_by(label.id).changed());
    };
    let mut harness = Harness::builder()
        .with_size(egui::vec2(300.0, 200.0))
        .build_ui_state(show, (value, 0));
    harness.run_steps(3);
    harness
}

fn type_text(harness: &mut Harness<(f64, usize)>, text: &str) {
    harness.get_by_label("Width").click();
    harness.run_steps(3);
    harness.event(Event::Text(text.to_owned()));
    harness.run_steps(2);
}

/// Whether the field has this text. A text that is edited has a node for each of its lines as well.
fn shows(harness: &Harness<(f64, usize)>, text: &str) -> bool {
    harness.query_all_by_value(text).next().is_some()
}

fn press(harness: &mut Harness<(f64, usize)>, key: Key) {
    harness.key_press(key);
    harness.run_steps(3);
}

#[test]
fn esc_brings_back_what_the_status_line_says_and_does_nothing_else() {
    let mut harness = field(3.0);
    assert!(!take_back(&harness.ctx));
    type_text(&mut harness, "abc");
    // Another widget takes the keyboard, as on a save.
    let focused = harness.ctx.memory(|memory| memory.focused()).expect("the field");
    harness.ctx.memory_mut(|memory| memory.surrender_focus(focused));
    harness.run_steps(3);
    assert!(shows(&harness, "abc") && told(&harness.ctx).is_some());
    assert!(take_back(&harness.ctx));
    assert_eq!(told(&harness.ctx), None);
    harness.run_steps(3);
    assert!(shows(&harness, "3.00") && !take_back(&harness.ctx));
}

#[test]
fn what_is_typed_counts_once_it_is_finished() {
    for (text, expected) in [("0,5", 0.5), ("1/4", 0.25), ("2*3+1", 7.0), ("500", 100.0)] {
        let mut harness = field(3.0);
        type_text(&mut harness, text);
        assert_eq!(*harness.state(), (3.0, 0), "{text}");
        press(&mut harness, Key::Enter);
        assert_eq!(*harness.state(), (expected, 1), "{text}");
        assert_eq!(told(&harness.ctx).is_some(), text == "500");
    }
}

#[test]
fn what_is_no_number_stays_in_the_field_and_is_explained() {
    let mut harness = field(3.0);
    type_text(&mut harness, "0;5");
    press(&mut harness, Key::Enter);
    assert_eq!(*harness.state(), (3.0, 0));
    assert!(told(&harness.ctx).is_some_and(|text| text.contains("“0;5” is no number")));
    // Typing continues where it was: the text is still there.
    harness.event(Event::Text("0".to_owned()));
    harness.run_steps(2);
    press(&mut harness, Key::Tab);
    assert!(told(&harness.ctx).is_some_and(|text| text.contains("“0;50” is no number")));
    assert!(shows(&harness, "0;50"), "it stays where the keyboard is elsewhere");
    // A click shows it for editing, and Esc brings the value back.
    type_text(&mut harness, "x");
    press(&mut harness, Key::Escape);
    assert!(shows(&harness, "3.00"));
    assert_eq!(*harness.state(), (3.0, 0));
}

#[test]
fn a_click_after_enter_selects_all_and_the_next_sets_a_cursor() {
    let click = |harness: &mut Harness<(f64, usize)>| {
        harness.get_by_label("Width").click();
        harness.run_steps(3);
    };
    let mut harness = field(3.0);
    type_text(&mut harness, "0;5");
    press(&mut harness, Key::Enter);
    click(&mut harness);
    harness.event(Event::Text("7".to_owned()));
    harness.run_steps(2);
    press(&mut harness, Key::Enter);
    assert_eq!(*harness.state(), (7.0, 1));
    // A text corrected with the mouse is not lost.
    type_text(&mut harness, "0;5");
    press(&mut harness, Key::Enter);
    click(&mut harness);
    click(&mut harness);
    harness.event(Event::Text("7".to_owned()));
    harness.run_steps(2);
    press(&mut harness, Key::Enter);
    let text = told(&harness.ctx).expect("it is no number");
    assert!(text.contains(';') && text.contains('7'), "{text}");
    assert_eq!(*harness.state(), (7.0, 1));
}

#[test]
fn esc_gives_up_a_number_as_well() {
    let mut harness = field(3.0);
    type_text(&mut harness, "5");
    press(&mut harness, Key::Escape);
    assert_eq!(*harness.state(), (3.0, 0));
    type_text(&mut harness, "7");
    press(&mut harness, Key::Enter);
    assert_eq!(*harness.state(), (7.0, 1));
}

#[test]
fn a_value_that_is_set_otherwise_takes_the_place_of_the_text() {
    let mut harness = field(3.0);
    type_text(&mut harness, "abc");
    press(&mut harness, Key::Tab);
    harness.state_mut().0 = 4.0;
    harness.run_steps(2);
    assert!(shows(&harness, "4.00"));
}

#[test]
fn looking_at_a_number_does_not_round_it() {
    let mut harness = field(1.0 / 3.0);
    harness.get_by_label("Width").click();
    harness.run_steps(3);
    press(&mut harness, Key::Enter);
    assert_eq!(*harness.state(), (1.0 / 3.0, 0));
    // Nor does a field that is left empty.
    type_text(&mut harness, "5");
    press(&mut harness, Key::Backspace);
    press(&mut harness, Key::Tab);
    assert_eq!(*harness.state(), (1.0 / 3.0, 0));
}
