//! Numbers of panels: lengths if the panel says so, with keys for the thing that the panel shows.

use std::ops::RangeInclusive;

use bevy_egui::egui::emath::Numeric;
use bevy_egui::egui::{AsId, DragValue, Slider, Ui};

use super::key_marks::owner;
use super::lengths::length_unit;
use crate::app::editor::input::number_field::{self, Meaning, NumberField, SliderField};
use crate::app::editor::words::figures::tidy;

/// A number in this range. `name` gives it a stable id, since a row that appears above moves it. `format` gives its
/// text with so many decimals.
pub(super) fn number<'a, N: Numeric>(
    ui: &Ui,
    drag: DragValue<'a>,
    name: impl AsId,
    range: RangeInclusive<N>,
    format: impl 'a + Fn(f64, RangeInclusive<usize>) -> String,
) -> NumberField<'a> {
    number_field::number(ui, drag, (owner(ui), name), range, meaning(ui), format)
}

/// [`number`] for a slider in this unit.
pub(super) fn slider<'a, N: Numeric>(
    ui: &Ui,
    slider: Slider<'a>,
    name: impl AsId,
    unit: &'a str,
    range: RangeInclusive<N>,
) -> SliderField<'a> {
    slider_shown_to(ui, slider, name, unit, range, usize::MAX)
}

/// [`slider`] that shows so many decimals at most. Typed numbers keep all of theirs.
pub(super) fn slider_shown_to<'a, N: Numeric>(
    ui: &Ui,
    slider: Slider<'a>,
    name: impl AsId,
    unit: &'a str,
    range: RangeInclusive<N>,
    most: usize,
) -> SliderField<'a> {
    let about = (owner(ui), name);
    let format = move |number, decimals: RangeInclusive<usize>| {
        let (fewest, known) = decimals.into_inner();
        tidy(unit, number, fewest.min(most)..=known.min(most))
    };
    number_field::slider(ui, slider, about, range, meaning(ui), format)
}

fn meaning(ui: &Ui) -> Meaning {
    length_unit(ui).map_or(Meaning::Number, Meaning::Length)
}

#[cfg(test)]
mod tests {
    use bevy_egui::egui::{Event, vec2};
    use egui_kittest::Harness;
    use egui_kittest::kittest::Queryable;

    use super::super::fields;
    use super::*;

    #[test]
    fn a_text_that_is_no_number_stays_out_of_the_row_that_comes_to_its_place() {
        let show = |ui: &mut Ui, (has_height, numbers): &mut (bool, [f32; 2])| {
            if *has_height {
                fields::number(ui, "Height", &mut numbers[0], 0.1, -9.0..=9.0);
            }
            fields::number(ui, "Width", &mut numbers[1], 0.1, -9.0..=9.0);
        };
        let mut harness = Harness::builder()
            .with_size(vec2(300.0, 200.0))
            .build_ui_state(show, (false, [0.0; 2]));
        harness.run_steps(3);
        harness.get_by_label("Width").click();
        harness.run_steps(3);
        harness.event(Event::Text("abc".to_owned()));
        harness.run_steps(2);
        harness.ctx.memory_mut(|memory| memory.stop_text_input());
        harness.run_steps(3);
        let shown = |harness: &Harness<_>| harness.query_all_by_value("abc").count();
        assert!(shown(&harness) > 0);
        harness.state_mut().0 = true;
        harness.run_steps(3);
        assert_eq!(shown(&harness), 0);
    }
}
