//! The rows panels are made of: a name at the left, a control at the right.
//!
//! Every row edits a copy and writes it back only if the user changed something: showing a value that the control cannot hold exactly
//! (out of its range, more digits than shown) must not change it.

use std::ops::RangeInclusive;

use bevy::math::Vec3;
use bevy_egui::egui::{self, Response, Ui};

use crate::color::Rgb;

/// Width of the names' column in points.
const NAME_WIDTH: f32 = 92.0;

/// A row with any control; the control is named for assistive technology (and tests) after the row.
pub fn row(ui: &mut Ui, name: &str, control: impl FnOnce(&mut Ui) -> Response) -> Response {
    ui.horizontal(|ui| {
        let name = name_cell(ui, name);
        control(ui).labelled_by(name.id)
    })
    .inner
}

fn name_cell(ui: &mut Ui, name: &str) -> Response {
    let size = egui::vec2(NAME_WIDTH, ui.spacing().interact_size.y);
    let layout = egui::Layout::left_to_right(egui::Align::Center);
    ui.allocate_ui_with_layout(size, layout, |ui| {
        ui.set_min_size(size);
        ui.add(egui::Label::new(name).truncate())
    })
    .inner
}

/// A text that cannot be edited.
pub fn note(ui: &mut Ui, name: &str, text: impl Into<String>) {
    ui.horizontal(|ui| {
        name_cell(ui, name);
        ui.add(egui::Label::new(egui::RichText::new(text).weak()).truncate());
    });
}

pub fn slider(ui: &mut Ui, name: &str, value: &mut f32, range: RangeInclusive<f32>) -> bool {
    slider_with(ui, name, value, range, |slider| slider)
}

/// A slider whose steps are even in the exponent.
pub fn log_slider(ui: &mut Ui, name: &str, value: &mut f32, range: RangeInclusive<f32>) -> bool {
    slider_with(ui, name, value, range, |slider| slider.logarithmic(true))
}

pub fn slider_with(
    ui: &mut Ui,
    name: &str,
    value: &mut f32,
    range: RangeInclusive<f32>,
    style: impl FnOnce(egui::Slider<'_>) -> egui::Slider<'_>,
) -> bool {
    let mut copy = *value;
    let slider = egui::Slider::new(&mut copy, range)
        .clamping(egui::SliderClamping::Edits)
        .max_decimals(3);
    let changed = row(ui, name, |ui| ui.add(style(slider))).changed();
    write_back(changed, value, copy)
}

pub fn integer_slider(ui: &mut Ui, name: &str, value: &mut u32, range: RangeInclusive<u32>, logarithmic: bool) -> bool {
    let mut copy = *value;
    let slider = egui::Slider::new(&mut copy, range)
        .clamping(egui::SliderClamping::Edits)
        .logarithmic(logarithmic);
    let changed = row(ui, name, |ui| ui.add(slider)).changed();
    write_back(changed, value, copy)
}

/// A number that is dragged or typed; `speed` is the change per point of drag.
pub fn number(ui: &mut Ui, name: &str, value: &mut f32, speed: f32, range: RangeInclusive<f32>) -> bool {
    quantity(ui, name, value, speed, range, "")
}

/// The same with a unit.
pub fn quantity(ui: &mut Ui, name: &str, value: &mut f32, speed: f32, range: RangeInclusive<f32>, unit: &str) -> bool {
    let mut copy = *value;
    let drag = egui::DragValue::new(&mut copy)
        .speed(speed)
        .range(range)
        .clamp_existing_to_range(false)
        .max_decimals(4)
        .suffix(unit);
    let changed = row(ui, name, |ui| ui.add(drag)).changed();
    write_back(changed, value, copy)
}

pub fn integer<N: egui::emath::Numeric>(ui: &mut Ui, name: &str, value: &mut N, range: RangeInclusive<N>) -> bool {
    let mut copy = *value;
    let drag = egui::DragValue::new(&mut copy)
        .range(range)
        .clamp_existing_to_range(false);
    let changed = row(ui, name, |ui| ui.add(drag)).changed();
    write_back(changed, value, copy)
}

/// Three numbers; the controls are named "`name` X", "`name` Y", "`name` Z".
pub fn vector(ui: &mut Ui, name: &str, value: &mut Vec3, speed: f32, suffix: &str) -> bool {
    let mut copy = *value;
    let changed = ui
        .horizontal(|ui| {
            name_cell(ui, name);
            let gap = ui.spacing().item_spacing.x;
            let width = ((ui.available_width() - 2.0 * gap) / 3.0).max(40.0);
            let mut changed = false;
            for (axis, letter) in ["X", "Y", "Z"].into_iter().enumerate() {
                let drag = egui::DragValue::new(&mut copy[axis])
                    .speed(speed)
                    .suffix(suffix)
                    .max_decimals(3);
                let response = ui.add_sized([width, ui.spacing().interact_size.y], drag);
                response.widget_info(|| {
                    let mut info = egui::WidgetInfo::drag_value(true, f64::from(value[axis]));
                    info.label = Some(format!("{name} {letter}"));
                    info
                });
                changed |= response.changed();
            }
            changed
        })
        .inner;
    write_back(changed, value, copy)
}

pub fn checkbox(ui: &mut Ui, name: &str, value: &mut bool) -> bool {
    let mut copy = *value;
    let changed = row(ui, name, |ui| {
        let response = ui.add(egui::Checkbox::without_text(&mut copy));
        // Its empty text would count as its name.
        response.widget_info(|| egui::WidgetInfo::selected(egui::WidgetType::Checkbox, true, copy, name));
        response
    })
    .changed();
    write_back(changed, value, copy)
}

/// A reflectance: linear, each channel in [0, 1].
pub fn color(ui: &mut Ui, name: &str, value: &mut Rgb) -> bool {
    let mut channels = value.to_array();
    let changed = ui
        .horizontal(|ui| {
            let label = name_cell(ui, name);
            let picker = ui.color_edit_button_rgb(&mut channels).labelled_by(label.id);
            let mut changed = picker.changed();
            for (channel, letter) in channels.iter_mut().zip(["R", "G", "B"]) {
                let drag = egui::DragValue::new(channel)
                    .range(0.0..=1.0)
                    .clamp_existing_to_range(false)
                    .speed(0.005)
                    .fixed_decimals(2);
                let response = ui.add_sized([38.0, ui.spacing().interact_size.y], drag);
                response.widget_info(|| {
                    let mut info = egui::WidgetInfo::drag_value(true, 0.0);
                    info.label = Some(format!("{name} {letter}"));
                    info
                });
                changed |= response.changed();
            }
            changed
        })
        .inner;
    write_back(changed, value, Rgb::from_array(channels))
}

/// An emitted quantity: a colour whose largest channel is 1, times a strength.
pub fn emission(ui: &mut Ui, unit: &str, value: &mut Rgb) -> bool {
    let mut strength = value.max_element();
    let mut hue = if strength > 0.0 { *value / strength } else { Rgb::ONE };
    let recolored = color(ui, "Colour", &mut hue);
    let scaled = slider_with(ui, "Strength", &mut strength, 0.0..=1000.0, |slider| {
        slider.logarithmic(true).smallest_positive(0.01).suffix(unit)
    });
    write_back(recolored || scaled, value, hue * strength)
}

/// A choice among a few; `options` are value and name.
pub fn choice<T: Copy + PartialEq>(ui: &mut Ui, name: &str, value: &mut T, options: &[(T, &str)]) -> bool {
    let mut copy = *value;
    let shown = options
        .iter()
        .find(|(option, _)| option == value)
        .map_or("", |(_, name)| name);
    row(ui, name, |ui| {
        egui::ComboBox::from_id_salt(name)
            .selected_text(shown)
            .width(150.0)
            .show_ui(ui, |ui| {
                for (option, name) in options {
                    ui.selectable_value(&mut copy, *option, *name);
                }
            })
            .response
    });
    write_back(copy != *value, value, copy)
}

fn write_back<T>(changed: bool, value: &mut T, copy: T) -> bool {
    if changed {
        *value = copy;
    }
    changed
}
