//! Rows for colours. Colours are linear Rec. 709 inside and in files; the panel shows them so, or as sRGB in
//! hexadecimal as drawing programs do, and names the form.

use bevy_egui::egui::{self, Ui};

use super::caption::Caption;
use super::color_picker::color_button;
use super::fields::{NumberStyle, name_cell, number_cells, write_back};
use super::key_marks::owner;
use super::light_strength::{StrengthUnits, light_strength};
use crate::app::editor::input::number_field;
use crate::color::{Rgb, linear_from_srgb8, luminance, srgb_from_linear};

/// The form in which colours are shown, the same in all rows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Notation {
    /// The colour is shown as three linear numbers, as `rgb` in files.
    #[default]
    Linear,
    /// The colour is shown as `#rrggbb`, sRGB-encoded.
    Hex,
}

const SWATCH: f32 = 24.0;
const SWITCH: f32 = 28.0;

/// A reflectance: linear, each channel in [0, 1]. The controls are named "`name` R", "`name` G", "`name` B", or "`name`
/// hex".
pub fn color<'a>(ui: &mut Ui, caption: impl Into<Caption<'a>>, value: &mut Rgb) -> bool {
    let caption = caption.into();
    let mut copy = *value;
    let changed = ui
        .horizontal(|ui| {
            let label = name_cell(ui, caption);
            ui.spacing_mut().item_spacing.x = 3.0;
            let size = egui::vec2(SWATCH, ui.spacing().interact_size.y);
            let mut changed = color_button(ui, (label.id, caption.text), size, &mut copy);
            let room = ui.available_width() - SWITCH - 3.0;
            let notation = notation(ui);
            changed |= match notation {
                Notation::Linear => channels(ui, caption.text, &mut copy, room),
                Notation::Hex => hex_text(ui, caption.text, &mut copy, room),
            };
            switch(ui, notation);
            changed
        })
        .inner;
    write_back(changed, value, copy)
}

/// Shows an emitted quantity: a colour whose largest channel is 1, times a strength in one of `units`. `beyond`: the
/// points at the right that the row of the colour leaves to a menu, and that the row of the strength uses.
pub fn emission<'a>(
    ui: &mut Ui,
    caption: impl Into<Caption<'a>>,
    units: StrengthUnits,
    beyond: f32,
    value: &mut Rgb,
) -> bool {
    let caption = caption.into();
    colored(ui, caption, caption.part("Colour"), units, beyond, value)
}

/// [`emission`] with another name of the row of the colour.
pub fn colored(
    ui: &mut Ui,
    caption: Caption,
    colour: Caption,
    units: StrengthUnits,
    beyond: f32,
    value: &mut Rgb,
) -> bool {
    let mut strength = value.max_element();
    // A strength of zero has no colour: the colour that was edited here is kept, so that it returns with the strength.
    let id = ui.make_persistent_id((colour.text, "of nothing"));
    let edited = || ui.data(|data| data.get_temp(id)).unwrap_or(Rgb::ONE);
    let mut hue = if strength > 0.0 { *value / strength } else { edited() };
    let before = luminance(hue);
    let recolored = color(ui, colour, &mut hue);
    if recolored && hue.max_element() > 0.0 {
        // The strength has a row of its own, and a press that lasts must not lower it from frame to frame.
        hue /= hue.max_element();
        // Photometric amounts are of the luminance, which a colour or temperature leaves as it is.
        if units.chosen(ui).is_some() && luminance(hue) > 0.0 && before > 0.0 {
            strength *= before / luminance(hue);
        }
    }
    // The row extends beyond this column without widening it.
    let size = egui::vec2(ui.available_width(), ui.spacing().interact_size.y);
    let (_, place) = ui.allocate_space(size);
    let place = place.with_max_x(place.right() + beyond);
    let mut row = ui.new_child(egui::UiBuilder::new().max_rect(place));
    let scaled = light_strength(&mut row, caption, units, luminance(hue), &mut strength);
    if recolored || scaled {
        ui.data_mut(|data| data.insert_temp(id, hue));
    }
    write_back(recolored || scaled, value, hue * strength)
}

fn channels(ui: &mut Ui, name: &str, color: &mut Rgb, width: f32) -> bool {
    let mut values = color.to_array();
    let styles = ["R", "G", "B"].map(|letter| NumberStyle {
        range: 0.0..=1.0,
        ..NumberStyle::new(letter, 0.005)
    });
    let changed = ui.scope(|ui| number_cells(ui, name, &mut values, styles, width)).inner;
    write_back(changed, color, Rgb::from_array(values))
}

/// A text field with the colour. The typed text stays until it is a colour; the field shows the colour again once it
/// loses the focus, or after Esc.
fn hex_text(ui: &mut Ui, name: &str, color: &mut Rgb, width: f32) -> bool {
    let id = ui.make_persistent_id((name, "hex", owner(ui)));
    let shown = hex_of(*color);
    let is_edited = ui.memory(|memory| memory.has_focus(id));
    // A colour that was set elsewhere replaces an invalid text.
    let is_current = |(_, of): &(String, String)| is_edited || *of == shown;
    let kept: Option<(String, String)> = ui.data(|data| data.get_temp(id)).filter(is_current);
    let mut text = kept.map_or_else(|| shown.clone(), |(text, _)| text);
    let is_wrong = !is_edited && color_of(&text).is_none();
    let mut edit = egui::TextEdit::singleline(&mut text)
        .id(id)
        .char_limit(7)
        .font(egui::TextStyle::Monospace)
        .margin(egui::Margin::symmetric(3, 2))
        .desired_width(width - 6.0);
    if is_wrong {
        edit = edit.text_color(ui.visuals().error_fg_color);
    }
    let mut response = ui.add(edit);
    if is_wrong {
        response = response.on_hover_text(problem(&text));
    }
    response.widget_info(|| {
        let mut info = egui::WidgetInfo::text_edit(true, &shown, &shown, "");
        info.label = Some(format!("{name} hex"));
        info
    });
    let typed = response.changed().then(|| color_of(&text)).flatten();
    let is_colour = color_of(&text).is_some();
    let is_given_up = response.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Escape));
    if response.lost_focus() && !is_colour && !is_given_up {
        number_field::note(ui.ctx(), problem(&text));
    }
    // A text with the same value must not cost the colour its finer digits.
    let meant = typed.filter(|typed| hex_of(*typed) != shown);
    let keeps = response.has_focus() || (!is_colour && !is_given_up);
    ui.data_mut(|data| {
        if keeps {
            data.insert_temp(id, (text, shown));
        } else {
            data.remove::<(String, String)>(id);
        }
    });
    write_back(meant.is_some(), color, meant.unwrap_or(*color))
}

fn problem(text: &str) -> String {
    format!("“{text}” is no colour: #rrggbb and #rgb are some. Esc brings back the last one")
}

/// Shows the notation of colours; a click shows all colours in the other one.
fn switch(ui: &mut Ui, notation: Notation) {
    let (text, about, other) = match notation {
        Notation::Linear => (
            "RGB",
            "Linear numbers (Rec. 709), as rgb in the file. A click: sRGB in hexadecimal, as #rrggbb",
            Notation::Hex,
        ),
        Notation::Hex => (
            "Hex",
            "sRGB in hexadecimal, as in drawing programs and on the web. A click: linear numbers",
            Notation::Linear,
        ),
    };
    ui.spacing_mut().button_padding.x = 1.0;
    let text = egui::RichText::new(text).small();
    let button = egui::Button::new(text).frame_when_inactive(false);
    let size = [SWITCH, ui.spacing().interact_size.y];
    if ui.add_sized(size, button).on_hover_text(about).clicked() {
        ui.data_mut(|data| data.insert_temp(notation_id(), other));
    }
}

fn notation(ui: &Ui) -> Notation {
    ui.data(|data| data.get_temp(notation_id())).unwrap_or_default()
}

fn notation_id() -> egui::Id {
    egui::Id::new("notation of colours")
}

/// The hexadecimal form of a colour. Values outside of [0, 1] are shown as the nearest end.
fn hex_of(color: Rgb) -> String {
    let [red, green, blue] = color
        .to_array()
        .map(|linear| (srgb_from_linear(linear.clamp(0.0, 1.0)) * 255.0).round() as u8);
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// Parses `#rrggbb` or `#rgb`, with or without the sign.
fn color_of(text: &str) -> Option<Rgb> {
    let digits: Vec<u8> = text
        .trim()
        .trim_start_matches('#')
        .chars()
        .map(|digit| digit.to_digit(16).map(|digit| digit as u8))
        .collect::<Option<_>>()?;
    let bytes = match digits[..] {
        [r, g, b] => [r * 17, g * 17, b * 17],
        [r1, r0, g1, g0, b1, b0] => [r1 * 16 + r0, g1 * 16 + g0, b1 * 16 + b0],
        _ => return None,
    };
    Some(Rgb::from_array(bytes.map(linear_from_srgb8)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hexadecimal_comes_back() {
        for text in ["#000000", "#ffffff", "#bc8040", "#010203"] {
            let color = color_of(text);
            assert_eq!(color.map(hex_of).as_deref(), Some(text));
        }
        assert_eq!(color_of("f80").map(hex_of).as_deref(), Some("#ff8800"));
        for text in ["", "#12", "#12345", "#ggg", "#-1-1-1", "1234567"] {
            assert_eq!(color_of(text), None, "{text}");
        }
    }

    #[test]
    fn middle_grey_of_a_screen_is_a_fifth_of_the_light() {
        // The value follows IEC 61966-2-1 at 128 / 255.
        let grey = color_of("#808080").map(|color| color.x);
        assert!(grey.is_some_and(|grey| (grey - 0.215_86).abs() < 1e-4), "{grey:?}");
    }
}
