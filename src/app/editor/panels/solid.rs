//! The rows of building parts: their numbers, and the openings of walls.

use bevy_egui::egui::{Button, Ui};

use super::fields::{self, NumberStyle};
use super::lengths;
use crate::scene::{Declared, Opening, ParameterMut, Solid};

/// The forms of roofs, by their plugins.
const ROOFS: [(&str, &str); 3] = [
    ("gableroof", "gable roof"),
    ("hiproof", "hip roof"),
    ("shedroof", "shed roof"),
];

/// Shows the rows of a building part; returns true if edited.
pub(super) fn rows(ui: &mut Ui, part: &mut Solid) -> bool {
    if part.roof().is_some() {
        let mut form = part.plugin();
        if fields::choice(ui, ("Type", "kind"), &mut form, &ROOFS)
            && let Some(other) = part.roof_as(form)
        {
            *part = other;
            return true;
        }
    } else {
        fields::note(ui, ("Type", "kind"), part.plugin());
    }
    let [low, high] = part.corners();
    let speed = 0.005 * (high - low).max_element().max(1e-3);
    let wall_height = high.z;
    let mut changed = false;
    part.visit_mut(&mut |info, value| match value {
        ParameterMut::Length(length) => {
            // A length below the range is not changed.
            let range = info.range.start().min(*length)..=*info.range.end();
            changed |= lengths::length(ui, info, length, speed, range);
        }
        ParameterMut::Count(count) => {
            let range = *info.range.start() as u32..=*info.range.end() as u32;
            changed |= fields::integer(ui, info, count, range);
        }
        ParameterMut::Openings(openings) => changed |= opening_rows(ui, openings, wall_height, speed),
        // A kind that building parts get later needs a row here.
        _ => debug_assert!(false, "`{}` has no row", info.name),
    });
    changed
}

/// Shows the openings one after the other, each with its place and size, and buttons for new ones; returns true if
/// edited.
fn opening_rows(ui: &mut Ui, openings: &mut Vec<Opening>, wall_height: f32, speed: f32) -> bool {
    let mut changed = false;
    let mut removed = None;
    for (number, opening) in openings.iter_mut().enumerate() {
        // Only its user knows whether an opening that reaches the floor is a door or a French window.
        let (what, close) = match opening.sill == 0.0 {
            true => ("door or French window", "Remove this opening"),
            false => ("window", "Remove this window"),
        };
        ui.push_id(number, |ui| {
            fields::note(ui, &format!("Opening {}", number + 1), what);
            let place = ["From", "Sill"].map(|letter| style(letter, speed, f32::MIN..=f32::MAX));
            let mut numbers = [opening.from, opening.sill];
            if lengths::numbers(ui, "Along, sill", &mut numbers, place) {
                [opening.from, opening.sill] = numbers;
                changed = true;
            }
            let least = opening.width.min(opening.height).min(1e-4);
            let size = ["Wide", "High"].map(|letter| style(letter, speed, least..=f32::MAX));
            let mut numbers = [opening.width, opening.height];
            if lengths::numbers(ui, "Width, height", &mut numbers, size) {
                [opening.width, opening.height] = numbers;
                changed = true;
            }
            let button = fields::buttons(ui, |ui| ui.button(close));
            if button
                .on_hover_text(format!("Fill the {what} with wall again"))
                .clicked()
            {
                removed = Some(number);
            }
        });
    }
    if let Some(number) = removed {
        openings.remove(number);
        changed = true;
    }
    let has_room = openings.len() < Solid::MOST_OPENINGS;
    fields::buttons(ui, |ui| {
        ui.horizontal_wrapped(|ui| {
            for (name, new) in [
                ("Add door", Opening::DOOR),
                ("Add window", Opening::WINDOW),
                ("Add French window", Opening::FRENCH_WINDOW),
            ] {
                let button = ui.add_enabled(has_room, Button::new(name));
                let button =
                    button.on_disabled_hover_text(format!("A wall has at most {} openings.", Solid::MOST_OPENINGS));
                if button.clicked() {
                    let new = new.in_wall(wall_height);
                    let after = openings.iter().map(|opening| opening.from + opening.width);
                    let from = after.fold(0.0, f32::max) + new.from;
                    openings.push(Opening { from, ..new });
                    changed = true;
                }
            }
        });
    });
    changed
}

fn style(letter: &'static str, speed: f32, range: std::ops::RangeInclusive<f32>) -> NumberStyle<'static> {
    NumberStyle {
        range,
        ..NumberStyle::new(letter, speed)
    }
}
