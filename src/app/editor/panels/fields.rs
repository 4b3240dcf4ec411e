//! The rows of panels, in one grid: a column of names, whose texts end before the controls, and a column of controls,
//! which all end at the panel's right edge.
//!
//! Every row edits a copy and writes it back only if the user changed something: showing a value that the control
//! cannot hold exactly (out of its range, more digits than shown) must not change it.

use std::ops::RangeInclusive;

use bevy::math::Vec3;
use bevy_egui::egui::emath::format_with_decimals_in_range;
use bevy_egui::egui::{self, Response, Ui};

use super::caption::Caption;
use super::key_marks::key_mark;
use super::typed;
use crate::app::editor::model::mixed::Mixed;
use crate::app::editor::picture::axis_colors::AXIS_COLORS;
use crate::app::editor::words::figures::{
    DEGREES, MOST_DECIMALS, USUAL_DECIMALS, decimals, legible, tidy, usual_decimals,
};
use crate::scene::ParameterInfo;

/// Width of the names' column in points.
pub(crate) const NAME_WIDTH: f32 = 88.0;
/// The width of the sign that marks differences among the selected things.
const MIXED_WIDTH: f32 = 14.0;
/// The tag of a part of a panel that marks differing values.
const MIXED: &str = "mixed";
/// Width of a slider's number.
pub(super) const VALUE_WIDTH: f32 = 58.0;
/// The tick that distinguishes the axes of a vector: its width and its distance from the edges, in points.
const TICK: egui::Vec2 = egui::vec2(2.0, 4.0);

/// The points at the right of a panel that a scroll bar covers if not everything fits.
const SCROLL_BAR: f32 = 8.0;

/// Leaves the room of a scroll bar at the right, whether there is one or not, so that rows keep their width.
pub(crate) fn leave_scroll_bar(ui: &mut Ui) {
    ui.set_max_width(ui.available_width() - SCROLL_BAR);
}

/// A row with any control; the control is named for assistive technology (and tests) after the row.
pub fn row<'a>(ui: &mut Ui, caption: impl Into<Caption<'a>>, control: impl FnOnce(&mut Ui) -> Response) -> Response {
    let caption = caption.into();
    ui.horizontal(|ui| {
        let name = name_cell(ui, caption);
        control(ui).labelled_by(name.id)
    })
    .inner
}

/// The cell of the name in a row.
pub(crate) fn name_cell<'a>(ui: &mut Ui, caption: impl Into<Caption<'a>>) -> Response {
    let caption = caption.into();
    let size = egui::vec2(NAME_WIDTH, ui.spacing().interact_size.y);
    let is_mixed = is_mixed(ui, caption);
    let layout = egui::Layout::right_to_left(egui::Align::Center);
    let cell = ui.allocate_ui_with_layout(size, layout, |ui| {
        ui.set_min_size(size);
        let label = egui::Label::new(caption.text).truncate();
        if !is_mixed {
            return ui.add(label);
        }
        let (sign, rest) = ui
            .max_rect()
            .split_left_right_at_x(ui.max_rect().right() - size.x + MIXED_WIDTH);
        let rest = egui::UiBuilder::new().max_rect(rest).layout(layout);
        let label = ui.scope_builder(rest, |ui| ui.add(label)).inner;
        let text = egui::RichText::new("≠").strong().color(ui.visuals().warn_fg_color);
        let sign = ui.put(sign.with_min_x(sign.right() - MIXED_WIDTH), egui::Label::new(text));
        sign.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Label, true, MIXED));
        sign.on_hover_text("Mixed: the selected objects differ here; this is the value of the one selected last");
        label
    });
    // The explanation belongs to the whole cell, however short its text is.
    let label = cell.inner.union(cell.response);
    key_mark(ui, caption.name, &label);
    match (caption.info, caption.about) {
        (Some(info), _) => label.on_hover_ui(|ui| explain(ui, info)),
        (None, Some(about)) => label.on_hover_text(about),
        (None, None) => label,
    }
}

/// Marks differing values of the selected things in the rows of `content`. The innermost call applies.
pub fn compared<R>(ui: &mut Ui, mixed: &Mixed, content: impl FnOnce(&mut Ui) -> R) -> R {
    let info = egui::UiStackInfo::default().with_tag_value(MIXED, mixed.clone());
    ui.scope_builder(egui::UiBuilder::new().ui_stack_info(info), content)
        .inner
}

fn is_mixed(ui: &Ui, caption: Caption) -> bool {
    let mixed = ui.stack().iter().find_map(|ui| ui.tags().get_downcast::<Mixed>(MIXED));
    mixed.is_some_and(|mixed| mixed.has(caption.name))
}

/// Shows the explanation of a parameter.
fn explain(ui: &mut Ui, info: &ParameterInfo) {
    ui.set_max_width(280.0);
    ui.label(info.about);
    ui.weak(info.values);
    ui.weak(format!("In the file: {}", info.name));
}

/// Buttons in the column of controls.
pub(crate) fn buttons<R>(ui: &mut Ui, content: impl FnOnce(&mut Ui) -> R) -> R {
    ui.horizontal(|ui| {
        name_cell(ui, "");
        content(ui)
    })
    .inner
}

/// A text that cannot be edited.
pub fn note<'a>(ui: &mut Ui, caption: impl Into<Caption<'a>>, text: impl Into<String>) {
    let caption = caption.into();
    ui.horizontal(|ui| {
        name_cell(ui, caption);
        ui.add(egui::Label::new(egui::RichText::new(text).weak()).truncate());
    });
}

pub(crate) fn slider<'a>(
    ui: &mut Ui,
    caption: impl Into<Caption<'a>>,
    value: &mut f32,
    range: RangeInclusive<f32>,
) -> bool {
    slider_with(ui, caption, value, range, |slider| slider)
}

/// Shows a slider whose steps are even in the exponent.
pub(crate) fn log_slider<'a>(
    ui: &mut Ui,
    caption: impl Into<Caption<'a>>,
    value: &mut f32,
    range: RangeInclusive<f32>,
) -> bool {
    slider_with(ui, caption, value, range, |slider| slider.logarithmic(true))
}

/// Shows a slider of an angle in degrees.
pub(crate) fn angle_slider<'a>(
    ui: &mut Ui,
    caption: impl Into<Caption<'a>>,
    value: &mut f32,
    range: RangeInclusive<f32>,
) -> bool {
    slider_in(ui, caption.into(), value, range, DEGREES, |slider| {
        slider.suffix(DEGREES)
    })
}

pub(crate) fn slider_with<'a>(
    ui: &mut Ui,
    caption: impl Into<Caption<'a>>,
    value: &mut f32,
    range: RangeInclusive<f32>,
    style: impl FnOnce(egui::Slider<'_>) -> egui::Slider<'_>,
) -> bool {
    slider_in(ui, caption.into(), value, range, "", style)
}

/// Shows a slider whose number has the decimals that are usual in `unit`.
fn slider_in(
    ui: &mut Ui,
    caption: Caption,
    value: &mut f32,
    range: RangeInclusive<f32>,
    unit: &str,
    style: impl FnOnce(egui::Slider<'_>) -> egui::Slider<'_>,
) -> bool {
    let mut copy = *value;
    let slider = egui::Slider::new(&mut copy, range.clone())
        .clamping(egui::SliderClamping::Edits)
        .max_decimals(MOST_DECIMALS);
    let slider = typed::slider(ui, slider, caption.text, unit, range);
    let changed = row(ui, caption, |ui| {
        fit_slider(ui, VALUE_WIDTH);
        ui.add(slider.styled(style))
    })
    .changed();
    write_back(changed, value, copy)
}

pub(crate) fn integer_slider<'a>(
    ui: &mut Ui,
    caption: impl Into<Caption<'a>>,
    value: &mut u32,
    range: RangeInclusive<u32>,
    logarithmic: bool,
) -> bool {
    let (caption, mut copy) = (caption.into(), *value);
    let slider = egui::Slider::new(&mut copy, range.clone())
        .clamping(egui::SliderClamping::Edits)
        .logarithmic(logarithmic);
    let slider = typed::slider(ui, slider, caption.text, "", range);
    let changed = row(ui, caption, |ui| {
        fit_slider(ui, VALUE_WIDTH);
        ui.add(slider)
    })
    .changed();
    write_back(changed, value, copy)
}

/// Leaves room for a number of this width, which ends at the panel's edge.
pub(super) fn fit_slider(ui: &mut Ui, number: f32) {
    let room = ui.available_width() - number - ui.spacing().item_spacing.x;
    ui.spacing_mut().slider_width = room.max(32.0);
    ui.spacing_mut().interact_size.x = number;
}

/// A number that is as wide as the column of controls.
pub(crate) fn wide_number(ui: &mut Ui, drag: impl egui::Widget) -> Response {
    ui.spacing_mut().interact_size.x = ui.available_width();
    ui.add(drag)
}

/// A number that is dragged or typed; `speed` is the change per point of drag.
pub fn number<'a>(
    ui: &mut Ui,
    caption: impl Into<Caption<'a>>,
    value: &mut f32,
    speed: f32,
    range: RangeInclusive<f32>,
) -> bool {
    quantity(ui, caption, value, speed, range, "")
}

/// A [`number`] with a unit.
pub(crate) fn quantity<'a>(
    ui: &mut Ui,
    caption: impl Into<Caption<'a>>,
    value: &mut f32,
    speed: f32,
    range: RangeInclusive<f32>,
    unit: &str,
) -> bool {
    let (caption, mut copy) = (caption.into(), *value);
    let drag = egui::DragValue::new(&mut copy)
        .speed(speed)
        .clamp_existing_to_range(false)
        .max_decimals(4)
        .suffix(unit);
    let format = move |number, decimals| tidy(unit, number, decimals);
    let drag = typed::number(ui, drag, caption.text, range, format);
    let changed = row(ui, caption, |ui| wide_number(ui, drag)).changed();
    write_back(changed, value, copy)
}

/// A whole number to drag or type, in `range`. Returns true if edited.
pub fn integer<'a, N: egui::emath::Numeric>(
    ui: &mut Ui,
    caption: impl Into<Caption<'a>>,
    value: &mut N,
    range: RangeInclusive<N>,
) -> bool {
    let (caption, mut copy) = (caption.into(), *value);
    let drag = egui::DragValue::new(&mut copy).clamp_existing_to_range(false);
    let drag = typed::number(ui, drag, caption.text, range, format_with_decimals_in_range);
    let changed = row(ui, caption, |ui| wide_number(ui, drag)).changed();
    write_back(changed, value, copy)
}

/// Shows three numbers; the controls are named "`name` X", "`name` Y", "`name` Z".
pub fn vector<'a>(ui: &mut Ui, caption: impl Into<Caption<'a>>, value: &mut Vec3, speed: f32, suffix: &str) -> bool {
    let mut copy = value.to_array();
    let drags = ["X", "Y", "Z"].map(|letter| NumberStyle {
        suffix,
        ..NumberStyle::new(letter, speed)
    });
    let changed = numbers(ui, caption, &mut copy, drags);
    write_back(changed, value, Vec3::from_array(copy))
}

/// The style of one of several numbers of a row.
pub struct NumberStyle<'s> {
    /// The letter that tells it from its neighbours.
    pub letter: &'s str,
    /// The change per point of a drag.
    pub speed: f32,
    /// The unit, behind the number.
    pub suffix: &'s str,
    /// The range of values that can be dragged or typed.
    pub range: RangeInclusive<f32>,
    /// A text that is shown in place of the number.
    pub text: Option<&'static str>,
}

impl<'s> NumberStyle<'s> {
    /// The style of any number, without a unit.
    pub(crate) fn new(letter: &'s str, speed: f32) -> Self {
        Self {
            letter,
            speed,
            suffix: "",
            range: f32::MIN..=f32::MAX,
            text: None,
        }
    }
}

/// Shows several numbers side by side, of equal width; the controls are named after the row and their letters.
pub fn numbers<'a, const N: usize>(
    ui: &mut Ui,
    caption: impl Into<Caption<'a>>,
    values: &mut [f32; N],
    styles: [NumberStyle; N],
) -> bool {
    let caption = caption.into();
    ui.horizontal(|ui| {
        name_cell(ui, caption);
        let width = ui.available_width();
        number_cells(ui, caption.text, values, styles, width)
    })
    .inner
}

/// Shows the numbers without a name before them, `width` points wide together.
pub(crate) fn number_cells<const N: usize>(
    ui: &mut Ui,
    name: &str,
    values: &mut [f32; N],
    styles: [NumberStyle; N],
    width: f32,
) -> bool {
    // Fields next to each other need little space.
    ui.spacing_mut().item_spacing.x = 3.0;
    ui.spacing_mut().button_padding.x = 1.0;
    let width = ((width - 3.0 * (N - 1) as f32) / N as f32).max(24.0);
    ui.spacing_mut().interact_size.x = width;
    let usual = styles.iter().map(|style| usual_decimals(style.suffix)).min();
    let needed = values.iter().map(|value| decimals(*value)).max().unwrap_or(0);
    let decimals = needed.clamp(usual.unwrap_or(USUAL_DECIMALS), MOST_DECIMALS);
    let mut changed = false;
    for (value, style) in values.iter_mut().zip(styles) {
        let shown = f64::from(*value);
        let drag = egui::DragValue::new(value)
            .speed(style.speed)
            .suffix(style.suffix)
            .clamp_existing_to_range(false)
            .max_decimals(MOST_DECIMALS);
        // All numbers of a row have as many decimals as the one that needs most.
        let drag = typed::number(
            ui,
            drag,
            (name, style.letter),
            style.range,
            move |number, _| match style.text {
                Some(text) => text.to_owned(),
                None => legible(number, decimals..=decimals),
            },
        );
        let response = ui.add_sized([width, ui.spacing().interact_size.y], drag);
        tick(ui, response.rect, style.letter);
        response.widget_info(|| {
            let mut info = egui::WidgetInfo::drag_value(true, shown);
            info.label = Some(format!("{name} {}", style.letter));
            info
        });
        changed |= response.changed();
    }
    changed
}

/// Marks the number of an axis with the axis' colour.
fn tick(ui: &Ui, cell: egui::Rect, letter: &str) {
    let axis = ["X", "Y", "Z"].iter().position(|axis| *axis == letter);
    if let Some(axis) = axis {
        let corner = cell.min + egui::vec2(1.0, TICK.y);
        let bar = egui::Rect::from_min_size(corner, egui::vec2(TICK.x, cell.height() - 2.0 * TICK.y));
        ui.painter().rect_filled(bar, 1.0, AXIS_COLORS[axis]);
    }
}

/// A text. What is typed counts once the field loses the focus.
pub(crate) fn text<'a>(ui: &mut Ui, caption: impl Into<Caption<'a>>, value: &mut String) -> bool {
    let caption = caption.into();
    let id = ui.make_persistent_id(("text", caption.text));
    let mut typed: String = ui.data(|data| data.get_temp(id)).unwrap_or_else(|| value.clone());
    let response = row(ui, caption, |ui| {
        let width = ui.available_width() - 8.0;
        ui.add(egui::TextEdit::singleline(&mut typed).id(id).desired_width(width))
    });
    let is_typing = response.has_focus();
    ui.data_mut(|data| match is_typing {
        true => _ = data.insert_temp(id, typed.clone()),
        false => data.remove::<String>(id),
    });
    let is_chosen = !is_typing && typed != *value;
    write_back(is_chosen, value, typed)
}

pub(crate) fn checkbox<'a>(ui: &mut Ui, caption: impl Into<Caption<'a>>, value: &mut bool) -> bool {
    let caption = caption.into();
    let mut copy = *value;
    let changed = row(ui, caption, |ui| {
        let response = ui.add(egui::Checkbox::without_text(&mut copy));
        // The empty text of the check box would count as its name.
        response.widget_info(|| egui::WidgetInfo::selected(egui::WidgetType::Checkbox, true, copy, caption.text));
        response
    })
    .changed();
    write_back(changed, value, copy)
}

/// A choice among a few values; `options` are value and name.
pub(crate) fn choice<'a, T: Copy + PartialEq>(
    ui: &mut Ui,
    caption: impl Into<Caption<'a>>,
    value: &mut T,
    options: &[(T, &str)],
) -> bool {
    let caption = caption.into();
    let mut copy = *value;
    let shown = options
        .iter()
        .find(|(option, _)| option == value)
        .map_or("", |(_, name)| name);
    row(ui, caption, |ui| {
        egui::ComboBox::from_id_salt(caption.text)
            .selected_text(shown)
            .width(ui.available_width().max(80.0))
            .truncate()
            .show_ui(ui, |ui| {
                for (option, name) in options {
                    ui.selectable_value(&mut copy, *option, *name);
                }
            })
            .response
    });
    write_back(copy != *value, value, copy)
}

/// A choice among a few words that are all visible; `options` are value and name. Returns true if edited.
pub(crate) fn switch<'a, T: Copy + PartialEq>(
    ui: &mut Ui,
    caption: impl Into<Caption<'a>>,
    value: &mut T,
    options: &[(T, &str)],
) -> bool {
    let mut copy = *value;
    ui.horizontal(|ui| {
        name_cell(ui, caption);
        const GAP: f32 = 3.0;
        ui.spacing_mut().item_spacing.x = GAP;
        // Each word has its own width, and a share of the rest.
        let font = egui::TextStyle::Button.resolve(ui.style());
        let padding = 2.0 * ui.spacing().button_padding.x;
        let measure = |name: &str| {
            let word = ui
                .painter()
                .layout_no_wrap(name.to_owned(), font.clone(), egui::Color32::PLACEHOLDER);
            word.size().x + padding
        };
        let widths: Vec<f32> = options.iter().map(|(_, name)| measure(name)).collect();
        let count = options.len().max(1) as f32;
        let room = (ui.available_width() - GAP * (count - 1.0)).max(0.0);
        let wanted = widths.iter().sum::<f32>().max(1.0);
        // In a narrow panel the words are cut off.
        let (share, rest) = ((room / wanted).min(1.0), (room - wanted).max(0.0));
        for ((option, name), width) in options.iter().zip(widths) {
            let width = share * width + rest / count;
            let button = egui::Button::selectable(copy == *option, *name)
                .frame_when_inactive(true)
                .truncate();
            if ui.add_sized([width, ui.spacing().interact_size.y], button).clicked() {
                copy = *option;
            }
        }
    });
    write_back(copy != *value, value, copy)
}

pub(crate) fn write_back<T>(changed: bool, value: &mut T, copy: T) -> bool {
    if changed {
        *value = copy;
    }
    changed
}
