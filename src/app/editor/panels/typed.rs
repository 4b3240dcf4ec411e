//! Numbers of panels: they are lengths where the panel says so, and are about the thing that the panel shows.

use std::ops::RangeInclusive;

use bevy_egui::egui::emath::{Numeric, format_with_decimals_in_range};
use bevy_egui::egui::{DragValue, Slider, Ui};

use super::key_marks::owner;
use super::lengths::length_unit;
use crate::app::editor::input::number_field::{self, Meaning, NumberField, SliderField};

/// A number in this range; `format` gives its text with so many decimals.
pub(super) fn number<'a, N: Numeric>(
    ui: &Ui,
    drag: DragValue<'a>,
    range: RangeInclusive<N>,
    format: impl 'a + Fn(f64, RangeInclusive<usize>) -> String,
) -> NumberField<'a> {
    number_field::number(ui, drag, owner(ui), range, meaning(ui), format)
}

/// [`number`] for a slider.
pub(super) fn slider<'a, N: Numeric>(ui: &Ui, slider: Slider<'a>, range: RangeInclusive<N>) -> SliderField<'a> {
    number_field::slider(ui, slider, owner(ui), range, meaning(ui), format_with_decimals_in_range)
}

fn meaning(ui: &Ui) -> Meaning {
    length_unit(ui).map_or(Meaning::Number, Meaning::Length)
}
