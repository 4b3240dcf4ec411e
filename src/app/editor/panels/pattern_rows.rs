//! The rows of a procedural texture inside the slot of a parameter.

use bevy_egui::egui::{self, Ui};

use super::caption::Caption;
use super::color_field;
use super::fields;
use super::texture;
use super::texture_slot::{Slot, SlotEdit};
use crate::color::Rgb;
use crate::scene::pattern::MOST_STOPS;
use crate::scene::{Choice, Declared, Parameter, ParameterInfo, ParameterMut, ParameterRef, Pattern, Stop};

impl Slot<'_> {
    /// Shows the parameters of a pattern.
    pub(super) fn pattern(&self, ui: &mut Ui, pattern: &mut Pattern, edit: &mut SlotEdit) {
        // The numbers of parameters that may be textures, as in places of pictures.
        let mut numbers = 0..;
        pattern.visit_mut(&mut |info, value| match value {
            ParameterMut::Nested(value) => {
                let slot = self.inner(info, "colour", numbers.next());
                let shown = slot.show(ui, value, Rgb::splat(0.5), |ui, caption, color| {
                    color_field::color(ui, caption, color)
                });
                edit.add(shown);
            }
            ParameterMut::OptionalTexture(value) => {
                let mut inside = value.take().map_or(Parameter::Constant(Rgb::ZERO), Parameter::Texture);
                let slot = self.inner(info, "u", numbers.next());
                let shown = slot.show(ui, &mut inside, Rgb::ZERO, |ui, caption, _| {
                    fields::note(ui, caption, "u");
                    false
                });
                edit.add(shown);
                if let Parameter::Texture(texture) = inside {
                    *value = Some(texture);
                }
            }
            other => edit.changed |= plain(ui, info, other),
        });
    }

    /// The slot of the parameter with this number inside of the texture.
    fn inner<'s>(&'s self, info: &'static ParameterInfo, plain: &'static str, number: Option<u32>) -> Slot<'s> {
        Slot {
            caption: info.into(),
            plain,
            textures: self.textures,
            place: self.place.within(number.unwrap_or(0)),
        }
    }
}

/// Shows a parameter that cannot be a texture; returns true if edited.
fn plain(ui: &mut Ui, info: &'static ParameterInfo, value: ParameterMut) -> bool {
    match value {
        ParameterMut::Number(value) => fields::slider(ui, info, value, info.slider_range()),
        ParameterMut::Length(value) => {
            let speed = 0.01 * value.abs().max(1e-3);
            fields::number(ui, info, value, speed, info.range.clone())
        }
        ParameterMut::Integer(value) => {
            let range = *info.range.start() as i32..=*info.range.end() as i32;
            fields::integer(ui, info, value, range)
        }
        ParameterMut::Flag(value) => fields::checkbox(ui, info, value),
        ParameterMut::Choice(value) => choice(ui, info, value),
        ParameterMut::Placing(value) => texture::placing(ui, value),
        ParameterMut::Stops(value) => stops(ui, value),
        other => {
            debug_assert!(false, "{other:?} has no row");
            false
        }
    }
}

fn choice(ui: &mut Ui, info: &'static ParameterInfo, value: &mut Choice) -> bool {
    let options: Vec<_> = value.names().iter().map(|name| (*name, *name)).collect();
    let mut name = value.name();
    let changed = fields::choice(ui, info, &mut name, &options);
    if let Some(chosen) = value.of_name(name) {
        *value = chosen;
    }
    changed
}

/// Shows the stops of a ramp one after the other, and buttons for one more and one less; returns true if edited.
fn stops(ui: &mut Ui, stops: &mut Vec<Stop>) -> bool {
    let mut changed = false;
    let places: Vec<f32> = stops.iter().map(|stop| stop.at).collect();
    for (number, stop) in stops.iter_mut().enumerate() {
        // A stop that is dragged stays between its neighbours, whose rows would change places with its own.
        let low = number.checked_sub(1).map_or(f32::MIN, |before| places[before]);
        let high = places.get(number + 1).copied().unwrap_or(f32::MAX);
        ui.push_id(number, |ui| {
            let name = |what: &str| format!("{what} {}", number + 1);
            let (at, color) = (name("Value"), name("Colour"));
            let value = Caption::from(&at).explained("The value with this colour.");
            changed |= fields::number(ui, value, &mut stop.at, 0.005, low..=high);
            changed |= color_field::color(ui, Caption::from(&color), &mut stop.color);
        });
    }
    ui.horizontal(|ui| {
        let has_room = stops.len() < MOST_STOPS;
        if ui.add_enabled(has_room, egui::Button::new("Add colour")).clicked()
            && let Some(&last) = stops.last()
        {
            stops.push(last);
            changed = true;
        }
        let is_spare = stops.len() > 1;
        if ui.add_enabled(is_spare, egui::Button::new("Remove the last")).clicked() {
            stops.pop();
            changed = true;
        }
    });
    changed
}

/// The parameters of a pattern whose colours stand for it in a small picture.
pub(super) fn shown_colors(pattern: &Pattern) -> Vec<Parameter<Rgb>> {
    let mut colors = Vec::new();
    pattern.visit(&mut |_, value| match value {
        ParameterRef::Nested(color) => colors.push(color.clone()),
        ParameterRef::Stops(stops) => colors.extend(stops.iter().map(|stop| stop.color.into())),
        _ => {}
    });
    colors.truncate(2);
    colors
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pattern_has_colours_to_show() {
        for plugin in Pattern::PLUGINS {
            let pattern = Pattern::of_plugin(plugin).expect("a plugin");
            assert!(!shown_colors(&pattern).is_empty(), "{plugin}");
        }
    }
}
