//! Numbers that are typed: other units of lengths are understood, and what is beyond the range of a field is told in the status line.

use std::ops::RangeInclusive;

use bevy_egui::egui::emath::Numeric;
use bevy_egui::egui::{Context, DragValue, Id, Slider, Ui};

use super::lengths::length_unit;
use crate::app::editor::words::figures::legible;
use crate::scene::LengthUnit;

/// The time for which a note is shown, seconds.
const SHOWN: f64 = 6.0;

/// What was typed beyond a range, and when.
#[derive(Clone)]
struct Note {
    text: String,
    time: f64,
}

/// Lets the range of a number be told, and other units be typed into one that is a length. A unit has an effect once it is complete, so that
/// `30cm` is never 30 metres.
pub(super) fn number<'a, N: Numeric>(ui: &Ui, drag: DragValue<'a>, range: RangeInclusive<N>) -> DragValue<'a> {
    let unit = length_unit(ui);
    let drag = drag.range(range.clone()).custom_parser(parser(ui, unit, range));
    match unit {
        Some(_) => drag.update_while_editing(false),
        None => drag,
    }
}

/// [`number`] for a slider.
pub(super) fn slider<'a, N: Numeric>(ui: &Ui, slider: Slider<'a>, range: RangeInclusive<N>) -> Slider<'a> {
    slider.custom_parser(parser(ui, length_unit(ui), range))
}

fn parser<N: Numeric>(
    ui: &Ui,
    unit: Option<LengthUnit>,
    range: RangeInclusive<N>,
) -> impl Fn(&str) -> Option<f64> + use<N> {
    let context = ui.ctx().clone();
    let (least, most) = (range.start().to_f64(), range.end().to_f64());
    move |text| {
        let number = match unit {
            Some(unit) => unit.parse(text)?,
            None => plain(text)?,
        };
        if number < least || number > most {
            note(&context, beyond(number, least, most));
        } else {
            // Some fields understand each letter as it is typed.
            context.data_mut(|data| data.remove::<Note>(id()));
        }
        Some(number)
    }
}

/// A number as fields understand it by themselves.
fn plain(text: &str) -> Option<f64> {
    let text: String = text.split_whitespace().collect();
    text.replace('\u{2212}', "-").parse().ok()
}

fn beyond(number: f64, least: f64, most: f64) -> String {
    let shown = |number: f64| legible(number, 0..=4);
    let (limit, word) = match number < least {
        true => (least, "least"),
        false => (most, "most"),
    };
    format!("{} is not possible here: {} is the {word}", shown(number), shown(limit))
}

fn id() -> Id {
    Id::new("typed beyond the range")
}

fn note(context: &Context, text: String) {
    let time = context.input(|input| input.time);
    context.data_mut(|data| data.insert_temp(id(), Note { text, time }));
}

/// What was typed beyond a range just now.
pub(super) fn told(context: &Context) -> Option<String> {
    let note: Note = context.data(|data| data.get_temp(id()))?;
    let left = SHOWN - (context.input(|input| input.time) - note.time);
    if left <= 0.0 {
        context.data_mut(|data| data.remove::<Note>(id()));
        return None;
    }
    context.request_repaint_after_secs(left as f32);
    Some(note.text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_beyond_a_range_are_told_with_its_end() {
        assert_eq!(beyond(1.5, 0.0, 1.0), "1.5 is not possible here: 1 is the most");
        assert_eq!(beyond(-2.0, 0.0, 1.0), "-2 is not possible here: 0 is the least");
        assert_eq!(plain(" \u{2212}1 000.5 "), Some(-1000.5));
        assert_eq!(plain("half"), None);
    }
}
