//! The panel of the meters: illuminance at measuring points and over measuring grids.

use bevy_egui::egui::{self, Button, Color32, Label, Rect, RichText, Sense, Stroke, StrokeKind, Ui, pos2, vec2};

use crate::app::editor::command::addition::AdditionKind;
use crate::app::editor::command::display::heat;
use crate::app::editor::command::selection::{Extend, Selection};
use crate::app::editor::command::{Command, DisplayCommand, SceneEdit, SelectionCommand};
use crate::app::editor::picture::metering::{ShownMeter, ShownMeters};
use crate::meter::estimate::Estimate;
use crate::meter::glare::Glare;
use crate::meter::job::{Judgement, MeterReading};
use crate::photometry::units::{Lux, short};

/// The width of the column of names of values, in points.
const NAMES: f32 = 84.0;
/// The largest size of the picture of a grid, in points.
const PICTURE: egui::Vec2 = vec2(220.0, 120.0);

/// Shows every meter with its values; a click on its name selects it.
pub fn meter(ui: &mut Ui, shown: &ShownMeters, selection: &Selection, commands: &mut Vec<Command>) {
    if shown.meters.is_empty() {
        no_meters(ui, commands);
        choices(ui, shown, commands);
        return;
    }
    ui.horizontal(|ui| {
        add_buttons(ui, commands);
        if shown.is_measuring {
            ui.weak("measuring…");
        }
    });
    choices(ui, shown, commands);
    if let Some(error) = &shown.error {
        ui.add(Label::new(RichText::new(error).color(ui.visuals().error_fg_color)).wrap());
    }
    for meter in &shown.meters {
        ui.add_space(4.0);
        ui.push_id(meter.entity, |ui| {
            let is_selected = selection.contains(meter.entity);
            one(ui, meter, shown.choice.daylight, is_selected, commands)
        });
    }
}

fn no_meters(ui: &mut Ui, commands: &mut Vec<Command>) {
    ui.add_space(4.0);
    let text = "A measuring point shows the illuminance at its place in lux, a measuring grid that over a rectangle. \
                They are things of the scene, and no pictures depend on them.";
    ui.add(Label::new(RichText::new(text).weak()).wrap());
    ui.add_space(4.0);
    ui.horizontal(|ui| add_buttons(ui, commands));
}

/// The quantities that are measured, and the glare of the view.
fn choices(ui: &mut Ui, shown: &ShownMeters, commands: &mut Vec<Command>) {
    let mut choice = shown.choice;
    let daylight = ui.checkbox(&mut choice.daylight, "Daylight factors");
    let hint = "The illuminance as a share of the illuminance on the open ground, under a CIE overcast sky in place of all lights";
    let hint = shown.up.map_or(hint.to_owned(), |up| {
        format!("{hint}. Up is {:.2}, by {}", up.direction, up.source)
    });
    let glare = ui.checkbox(&mut choice.glare, "Glare of the view");
    let has_changed = daylight.on_hover_text(hint).changed()
        | glare
            .on_hover_text("The unified glare rating, UGR (CIE 117), for an eye at the place of the view")
            .changed();
    if has_changed {
        commands.push(DisplayCommand::SetMeters(choice).into());
    }
    if shown.choice.glare {
        let text = match &shown.glare {
            None => "not rated yet".to_owned(),
            Some(Glare { rating: None, .. }) => "none: nothing stands out, or nothing else is lit".to_owned(),
            Some(Glare {
                rating: Some(rating), ..
            }) => rating.in_unit(""),
        };
        row(ui, "UGR", text.trim_end());
    }
}

fn add_buttons(ui: &mut Ui, commands: &mut Vec<Command>) {
    for (text, plugin, hint) in [
        (
            "Add point",
            "illuminancemeter",
            "Puts a measuring point onto what the view shows",
        ),
        (
            "Add grid",
            "illuminancegrid",
            "Puts a measuring grid onto what the view shows",
        ),
    ] {
        if ui.button(text).on_hover_text(hint).clicked() {
            commands.push(SceneEdit::Add(AdditionKind::Emitter(plugin).into()).into());
        }
    }
}

fn one(ui: &mut Ui, meter: &ShownMeter, is_daylight: bool, is_selected: bool, commands: &mut Vec<Command>) {
    let size = vec2(ui.available_width(), ui.spacing().interact_size.y);
    let name = Button::selectable(is_selected, RichText::new(&meter.name).strong());
    let name = ui.add(name.truncate().min_size(size));
    if name.on_hover_text("Selects it").clicked() {
        commands.push(SelectionCommand::Select(vec![meter.entity], Extend::Replace).into());
    }
    let Some(reading) = &meter.reading else {
        ui.weak("no values yet");
        return;
    };
    let lux = |estimate: &Estimate| match is_daylight {
        true => estimate.in_daylight_factor(),
        false => estimate.in_unit(Lux::SYMBOL),
    };
    match (&reading.grid, reading.points.first()) {
        (Some(grid), _) => {
            value(ui, "Least", &lux(&grid.least), reading, "least");
            value(ui, "Mean", &lux(&grid.mean), reading, "mean");
            let uniformity = grid
                .uniformity
                .map_or("none in the dark".to_owned(), |found| found.in_unit(""));
            value(ui, "Uniformity", uniformity.trim_end(), reading, "uniformity");
            picture(ui, reading, grid.darkest);
        }
        (None, Some(point)) => value(ui, "Illuminance", &lux(point), reading, "least"),
        (None, None) => {}
    }
    if reading.is_buried {
        let text = "It lies inside of something, or on the dark side of a surface: the side of its arrow is measured.";
        ui.add(Label::new(RichText::new(text).weak()).wrap());
    }
}

/// A row with a value, and what has become of its limit.
fn value(ui: &mut Ui, name: &str, text: &str, reading: &MeterReading, of: &str) {
    ui.horizontal(|ui| {
        cells(ui, name, text);
        if let Some(judgement) = reading.judgements().iter().find(|judgement| judgement.of == of) {
            verdict(ui, judgement);
        }
    });
}

fn row(ui: &mut Ui, name: &str, text: &str) {
    ui.horizontal(|ui| cells(ui, name, text));
}

fn cells(ui: &mut Ui, name: &str, text: &str) {
    let height = ui.spacing().interact_size.y;
    let cell = egui::Layout::left_to_right(egui::Align::Center);
    ui.allocate_ui_with_layout(vec2(NAMES, height), cell, |ui| {
        ui.set_min_width(NAMES);
        ui.weak(name);
    });
    ui.label(text)
        .on_hover_text("With the standard error: two of three times the true value is within it");
}

fn verdict(ui: &mut Ui, judgement: &Judgement) {
    let limit = match judgement.of {
        "uniformity" => short(judgement.limit),
        _ => Lux(judgement.limit).to_string(),
    };
    let text = match judgement.passes() {
        true => RichText::new("pass").color(pass_color(ui)),
        false => RichText::new("fail").color(ui.visuals().error_fg_color),
    };
    let hint = match judgement.is_close() {
        true => format!("{limit} are asked for, which is within two errors of the value"),
        false => format!("{limit} are asked for"),
    };
    ui.label(text).on_hover_text(hint);
}

fn pass_color(ui: &Ui) -> Color32 {
    match ui.visuals().dark_mode {
        true => Color32::from_rgb(110, 200, 120),
        false => Color32::from_rgb(20, 120, 40),
    }
}

/// The points of a grid in false colour, from the darkest, which has a frame, to the brightest. The first row is at the
/// foot, so that x goes to the right and y upwards as seen from the lit side.
fn picture(ui: &mut Ui, reading: &MeterReading, darkest: usize) {
    let [columns, rows] = reading.size.to_array();
    let values = || reading.points.iter().map(|point| point.value);
    let (least, most) = (values().fold(f64::INFINITY, f64::min), values().fold(0.0, f64::max));
    let cell = (PICTURE.x.min(ui.available_width()) / columns as f32).min(PICTURE.y / rows as f32);
    let (place, response) = ui.allocate_exact_size(vec2(columns as f32, rows as f32) * cell, Sense::hover());
    let corner = |number: usize| {
        let (column, row) = (number as u32 % columns, number as u32 / columns);
        Rect::from_min_size(
            place.min + vec2(column as f32, (rows - 1 - row) as f32) * cell,
            egui::Vec2::splat(cell),
        )
    };
    for (number, point) in reading.points.iter().enumerate() {
        let share = (point.value - least) / (most - least).max(f64::MIN_POSITIVE);
        let [r, g, b] = heat(share as f32).map(|channel| (255.0 * channel) as u8);
        ui.painter()
            .rect_filled(corner(number), 0.0, Color32::from_rgb(r, g, b));
    }
    let frame = Stroke::new(1.5, Color32::WHITE);
    ui.painter()
        .rect_stroke(corner(darkest), 0.0, frame, StrokeKind::Inside);
    let pointed = response.hover_pos().map(|at| (at - place.min) / cell);
    if let Some(at) = pointed {
        let column = (at.x as u32).min(columns - 1);
        let row = rows - 1 - (at.y as u32).min(rows - 1);
        let number = (row * columns + column) as usize;
        if let Some((point, position)) = reading.points.get(number).zip(reading.positions.get(number)) {
            let at = format!(
                "{}\nat {:.2}, {:.2}, {:.2}",
                point.in_unit(Lux::SYMBOL),
                position.x,
                position.y,
                position.z
            );
            response.on_hover_text_at_pointer(at);
        }
    }
    let ends = [
        (place.left_bottom(), egui::Align2::LEFT_TOP, Lux(least).to_string()),
        (
            pos2(place.right().max(place.left() + 90.0), place.bottom()),
            egui::Align2::RIGHT_TOP,
            Lux(most).to_string(),
        ),
    ];
    let font = egui::TextStyle::Small.resolve(ui.style());
    for (at, align, text) in ends {
        ui.painter().text(
            at + vec2(0.0, 2.0),
            align,
            text,
            font.clone(),
            ui.visuals().weak_text_color(),
        );
    }
    ui.add_space(font.size + 4.0);
}
