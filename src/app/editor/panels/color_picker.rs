//! The picker of a colour: a square of saturation and value, the hue, the temperature of a black body, the colours
//! that were chosen last, and a pipette for the picture. Hue, saturation and value are those of the sRGB-encoded colour
//! (Smith 1978, "Color gamut transform pairs"), as in drawing programs.

use bevy_egui::egui::ecolor::{hsv_from_rgb, rgb_from_hsv};
use bevy_egui::egui::{
    self, Color32, Id, Mesh, Pos2, Rect, Response, Sense, Shape, Stroke, Ui, lerp, pos2, remap_clamp, vec2,
};

use super::key_marks::owner;
use crate::app::editor::input::pipette;
use crate::color::temperature::Temperature;
use crate::color::{Rgb, linear_from_srgb, srgb_from_linear};

/// The edge of the square and the height of the bar of hues, in points.
const EDGE: f32 = 176.0;
const BAR: f32 = 16.0;
/// The radius of the ring around the chosen place, in points: small enough for the corners of the square.
const RING: f32 = 4.5;
/// The number of colours along an edge of the square and along the bar, between which colours are interpolated.
const STEPS: usize = 18;
/// The number of colours that are remembered.
const REMEMBERED: usize = 8;
/// The temperatures of black bodies in kelvin: a candle has 1900, an overcast sky 6500.
const TEMPERATURES: std::ops::RangeInclusive<f32> = 1000.0..=12_000.0;
const DAYLIGHT: f32 = 6500.0;
/// The distances from black bodies that lamps have.
const DUVS: std::ops::RangeInclusive<f32> = -0.02..=0.02;

/// Hue, saturation and value in [0, 1].
type Hsv = [f32; 3];

/// Shows the colour as a button that opens the picker; returns true if edited. `label` names the button, with the text
/// `name`.
pub(super) fn color_button(ui: &mut Ui, (label, name): (Id, &str), size: egui::Vec2, color: &mut Rgb) -> bool {
    // The field keeps its id when rows appear above it, and another thing has another one.
    let field = ui.make_persistent_id((name, "pipette", owner(ui)));
    let (place, response) = ui.allocate_exact_size(size, Sense::click());
    let response = response.labelled_by(label);
    response.widget_info(|| egui::WidgetInfo::new(egui::WidgetType::ColorButton));
    let visuals = ui.style().interact(&response);
    ui.painter().rect_filled(place, 2.0, shown(*color));
    let edge = Stroke::new(1.0, visuals.bg_stroke.color);
    ui.painter().rect_stroke(place, 2.0, edge, egui::StrokeKind::Inside);
    let edited = response.id.with("edited");
    let popup = egui::Popup::from_toggle_button_response(&response)
        .close_behavior(egui::PopupCloseBehavior::CloseOnClickOutside)
        .show(|ui| {
            if pipette_button(ui) {
                pipette::begin(ui.ctx(), field);
                ui.close();
            }
            picker(ui, color)
        });
    if let Some(picked) = pipette::take(ui.ctx(), field) {
        *color = picked;
        remember(ui, picked);
        return true;
    }
    match popup {
        Some(shown) => {
            if shown.inner {
                ui.data_mut(|data| data.insert_temp(edited, true));
            }
            shown.inner
        }
        None => {
            if ui.data_mut(|data| data.remove_temp::<bool>(edited)).is_some() {
                remember(ui, *color);
            }
            false
        }
    }
}

/// The key of the pipette while the picker is open.
const PIPETTE: egui::Key = egui::Key::I;

/// Shows the button of the pipette; returns true if it or its key was pressed.
fn pipette_button(ui: &mut Ui) -> bool {
    let button = egui::Button::new("Pick from the picture").min_size(vec2(EDGE, 0.0));
    let hint = format!(
        "The next click in the picture takes the colour of the surface there: its albedo, without the light on it ({})",
        PIPETTE.name()
    );
    let is_typing = ui.ctx().memory(|memory| memory.focused().is_some());
    let is_pressed = !is_typing && ui.input(|input| input.key_pressed(PIPETTE));
    ui.add(button).on_hover_text(hint).clicked() || is_pressed
}

fn picker(ui: &mut Ui, color: &mut Rgb) -> bool {
    ui.set_width(EDGE);
    ui.spacing_mut().item_spacing.y = 6.0;
    let id = ui.id().with("hue, saturation and value");
    // Grey has no hue and black has no saturation: the place that was chosen stays.
    let kept: Option<Hsv> = ui.data(|data| data.get_temp(id));
    let mut hsv = kept
        .filter(|kept| color_of(*kept).abs_diff_eq(*color, 1e-4))
        .unwrap_or_else(|| hsv_of(*color));
    let mut changed = square(ui, &mut hsv);
    changed |= bar(ui, &mut hsv);
    if changed {
        *color = color_of(hsv);
    }
    ui.data_mut(|data| data.insert_temp(id, hsv));
    changed |= temperature(ui, color);
    changed | remembered(ui, color)
}

/// Saturation to the right and value upwards, at the chosen hue.
fn square(ui: &mut Ui, hsv: &mut Hsv) -> bool {
    let (place, response) = ui.allocate_exact_size(vec2(EDGE, EDGE), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Slider, true, "Saturation and value"));
    let hue = hsv[0];
    grid(ui, place, [STEPS, STEPS], |x, y| [hue, x, 1.0 - y]);
    let before = *hsv;
    if let Some(at) = held(&response) {
        hsv[1] = remap_clamp(at.x, place.x_range(), 0.0..=1.0);
        hsv[2] = remap_clamp(at.y, place.y_range(), 1.0..=0.0);
    }
    let at = pos2(
        lerp(place.x_range(), hsv[1]),
        lerp(place.bottom()..=place.top(), hsv[2]),
    );
    ring(ui, at, shown(color_of(*hsv)));
    *hsv != before
}

fn bar(ui: &mut Ui, hsv: &mut Hsv) -> bool {
    let (place, response) = ui.allocate_exact_size(vec2(EDGE, BAR), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Slider, true, "Hue"));
    grid(ui, place, [STEPS, 1], |x, _| [x, 1.0, 1.0]);
    let before = *hsv;
    if let Some(at) = held(&response) {
        hsv[0] = remap_clamp(at.x, place.x_range(), 0.0..=1.0);
    }
    let at = pos2(lerp(place.x_range(), hsv[0]), place.center().y);
    ring(ui, at, shown(color_of([hsv[0], 1.0, 1.0])));
    *hsv != before
}

/// The place of the pointer while it is pressed.
fn held(response: &Response) -> Option<Pos2> {
    let is_held = response.is_pointer_button_down_on() || response.clicked();
    response.interact_pointer_pos().filter(|_| is_held)
}

/// Paints a rectangle with the colours of `of`, which is called with places in [0, 1], (0, 0) top left.
fn grid(ui: &Ui, place: Rect, [columns, rows]: [usize; 2], of: impl Fn(f32, f32) -> Hsv) {
    let mut mesh = Mesh::default();
    for row in 0..=rows {
        for column in 0..=columns {
            let (x, y) = (column as f32 / columns as f32, row as f32 / rows as f32);
            let at = pos2(lerp(place.x_range(), x), lerp(place.y_range(), y));
            mesh.colored_vertex(at, shown(color_of(of(x, y))));
        }
    }
    let width = columns as u32 + 1;
    for row in 0..rows as u32 {
        for column in 0..columns as u32 {
            let corner = row * width + column;
            mesh.add_triangle(corner, corner + 1, corner + width);
            mesh.add_triangle(corner + 1, corner + width, corner + width + 1);
        }
    }
    ui.painter().add(Shape::mesh(mesh));
}

fn ring(ui: &Ui, at: Pos2, color: Color32) {
    ui.painter().circle_filled(at, RING, color);
    for (radius, stroke) in [(RING + 1.0, Color32::BLACK), (RING, Color32::WHITE)] {
        ui.painter().circle_stroke(at, radius, Stroke::new(1.2, stroke));
    }
}

/// The temperature of the light that has the colour, and its distance from a black body.
fn temperature(ui: &mut Ui, color: &mut Rgb) -> bool {
    let id = ui.id().with("temperature");
    // Colours outside of Rec. 709 are clipped, so that what was chosen cannot always be told from the colour.
    let kept: Option<Temperature> = ui.data(|data| data.get_temp(id));
    let brightness = color.max_element();
    let is_it = |kept: &Temperature| (kept.color() * brightness).abs_diff_eq(*color, 1e-4);
    let found = kept.filter(is_it).or_else(|| Temperature::of_color(*color));
    let mut light = found.unwrap_or(Temperature {
        kelvin: DAYLIGHT,
        duv: 0.0,
    });
    ui.spacing_mut().slider_width = EDGE - 72.0;
    let slider = egui::Slider::new(&mut light.kelvin, TEMPERATURES)
        .clamping(egui::SliderClamping::Edits)
        .logarithmic(true)
        .suffix(" K")
        .max_decimals(0);
    let response = ui.add(slider).on_hover_text(
        "The colour of light of this temperature: candle 1900, bulb 2700, noon sun 5500, overcast sky 6500",
    );
    let kelvin = f64::from(light.kelvin);
    response.widget_info(|| egui::WidgetInfo::slider(true, kelvin, "Temperature in kelvin"));
    let slider = egui::Slider::new(&mut light.duv, DUVS)
        .clamping(egui::SliderClamping::Edits)
        .prefix("Duv ")
        .fixed_decimals(3);
    let aside = ui.add(slider).on_hover_text(
        "The distance from the black body in the CIE 1960 diagram: above 0 the light is greener, below pinker. White lamps stay within 0.006.",
    );
    let duv = f64::from(light.duv);
    aside.widget_info(|| egui::WidgetInfo::slider(true, duv, "Duv"));
    let changed = response.changed() || aside.changed();
    if changed {
        ui.data_mut(|data| data.insert_temp(id, light));
        // Black becomes light.
        *color = light.color() * if brightness > 0.0 { brightness } else { 1.0 };
    }
    changed
}

fn remembered_id() -> Id {
    Id::new("remembered colours")
}

fn remember(ui: &Ui, color: Rgb) {
    ui.data_mut(|data| {
        let colors: &mut Vec<Rgb> = data.get_temp_mut_or_default(remembered_id());
        colors.retain(|known| *known != color);
        colors.insert(0, color);
        colors.truncate(REMEMBERED);
    });
}

fn remembered(ui: &mut Ui, color: &mut Rgb) -> bool {
    let colors: Vec<Rgb> = ui.data(|data| data.get_temp(remembered_id())).unwrap_or_default();
    if colors.is_empty() {
        return false;
    }
    let mut changed = false;
    ui.horizontal(|ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        for known in colors {
            let (place, response) = ui.allocate_exact_size(vec2(18.0, 18.0), Sense::click());
            response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, "Recent colour"));
            ui.painter().rect_filled(place, 2.0, shown(known));
            if response.on_hover_text("A colour that was chosen before").clicked() {
                (*color, changed) = (known, true);
            }
        }
    });
    changed
}

fn shown(color: Rgb) -> Color32 {
    let [red, green, blue] = encoded(color).map(|channel| (255.0 * channel).round() as u8);
    Color32::from_rgb(red, green, blue)
}

fn encoded(color: Rgb) -> [f32; 3] {
    color.to_array().map(|linear| srgb_from_linear(linear.clamp(0.0, 1.0)))
}

fn hsv_of(color: Rgb) -> Hsv {
    let (hue, saturation, value) = hsv_from_rgb(encoded(color));
    [hue, saturation, value]
}

fn color_of([hue, saturation, value]: Hsv) -> Rgb {
    Rgb::from_array(rgb_from_hsv((hue, saturation, value)).map(linear_from_srgb))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_come_back_from_hue_saturation_and_value() {
        for color in [[0.0; 3], [1.0; 3], [0.8, 0.2, 0.1], [0.01, 0.5, 0.49], [0.3, 0.3, 0.3]] {
            let color = Rgb::from_array(color);
            assert!(color_of(hsv_of(color)).abs_diff_eq(color, 1e-5), "{color:?}");
        }
        let [hue, saturation, value] = hsv_of(Rgb::new(0.0, 1.0, 0.0));
        let is = |found: f32, expected: f32| (found - expected).abs() < 1e-6;
        assert!(
            is(hue, 1.0 / 3.0) && is(saturation, 1.0) && is(value, 1.0),
            "{hue} {saturation} {value}"
        );
    }
}
