//! The preferences of the user for the program itself.

use std::ops::RangeInclusive;

use bevy_egui::egui::emath::Numeric;
use bevy_egui::egui::{self, Button, ComboBox, DragValue, Id, Response, Slider, Ui, WidgetText};

use super::section::section;
use crate::app::editor::command::Command;
use crate::app::editor::command::ShellCommand;
use crate::app::editor::command::navigation_preset::NavigationPreset;
use crate::app::editor::command::preferences::{
    LONGEST_AUTOSAVE, MOST_MEMORY_GIB, MOVING_SCALES, Preferences, ThemeChoice, UI_SCALES,
};
use crate::app::editor::input::actions::hint;
use crate::app::editor::input::number_field::{self, Meaning};
use crate::app::editor::words::arithmetic;
use crate::render::tonemap::ToneMap;

/// The width of the column of names, in points.
const NAMES: f32 = 116.0;
/// The width of a slider's number, in points.
const NUMBER: f32 = 110.0;

/// Shows the preferences. `problem` is the problem with their file.
pub fn preferences(ui: &mut Ui, shown: &Preferences, problem: Option<&str>, commands: &mut Vec<Command>) {
    let mut edited = shown.clone();
    section(ui, "Window", |ui| window_rows(ui, shown, &mut edited, commands));
    section(ui, "View", |ui| view_rows(ui, &mut edited));
    section(ui, "Files and memory", |ui| file_rows(ui, &mut edited));
    if let Some(problem) = problem {
        ui.separator();
        ui.colored_label(ui.visuals().error_fg_color, problem);
    }
    if edited != *shown {
        commands.push(ShellCommand::SetPreferences(Box::new(edited)).into());
    }
}

/// Shows a row: a name that ends before the control, and a control that ends at the right edge.
fn row(ui: &mut Ui, name: &str, help: impl Into<WidgetText>, control: impl FnOnce(&mut Ui) -> Response) -> Response {
    let (label, response) = named(ui, name, help, control);
    response.labelled_by(label)
}

/// Shows a row whose control has a name of its own; returns the id of the row's name, and the control.
fn named(
    ui: &mut Ui,
    name: &str,
    help: impl Into<WidgetText>,
    control: impl FnOnce(&mut Ui) -> Response,
) -> (Id, Response) {
    ui.horizontal(|ui| {
        let size = egui::vec2(NAMES, ui.spacing().interact_size.y);
        let layout = egui::Layout::right_to_left(egui::Align::Center);
        let label = ui.allocate_ui_with_layout(size, layout, |ui| {
            ui.set_min_size(size);
            ui.label(name)
        });
        let (id, help) = (label.inner.id, help.into());
        label.inner.on_hover_text(help.clone());
        (id, control(ui).on_hover_text(help))
    })
    .inner
}

fn choice<T: Copy + PartialEq>(ui: &mut Ui, id: &str, value: &mut T, options: &[(T, &str, &str)]) -> Response {
    let shown = options.iter().find(|(option, ..)| option == value);
    ComboBox::from_id_salt(id)
        .selected_text(shown.map_or("", |(_, name, _)| name))
        .width(ui.available_width())
        .show_ui(ui, |ui| {
            for (option, name, help) in options {
                let entry = ui.selectable_value(value, *option, *name);
                if !help.is_empty() {
                    entry.on_hover_text(*help);
                }
            }
        })
        .response
}

/// A slider that fills the column of controls, its number included.
fn slider(ui: &mut Ui, slider: Slider, range: RangeInclusive<f32>, format: fn(f64) -> String) -> Response {
    ui.spacing_mut().slider_width = ui.available_width() - NUMBER - ui.spacing().item_spacing.x;
    ui.spacing_mut().interact_size.x = NUMBER;
    let meaning = Meaning::Of(parse_percent);
    ui.add(number_field::slider(ui, slider, (), range, meaning, move |value, _| {
        format(value)
    }))
}

fn number<N: Numeric>(ui: &mut Ui, drag: DragValue, range: RangeInclusive<N>, format: fn(f64) -> String) -> Response {
    ui.spacing_mut().interact_size.x = ui.available_width();
    let meaning = Meaning::Of(parse_within);
    ui.add(number_field::number(ui, drag, (), range, meaning, move |value, _| {
        format(value)
    }))
}

fn switch(ui: &mut Ui, name: &str, text: &str, help: impl Into<WidgetText>, value: &mut bool) {
    named(ui, name, help, |ui| ui.checkbox(value, text));
}

fn parse_percent(text: &str) -> Option<f64> {
    Some(parse_within(text)? / 100.0)
}

/// Parses a number with words around it, such as `every 30 s`.
fn parse_within(text: &str) -> Option<f64> {
    arithmetic::number(text.trim_matches(|letter: char| letter.is_alphabetic() || matches!(letter, ' ' | '%')))
}

fn window_rows(ui: &mut Ui, shown: &Preferences, edited: &mut Preferences, commands: &mut Vec<Command>) {
    named(ui, "Colours", "Of the panels", |ui| {
        ui.horizontal(|ui| {
            for (choice, name, hint) in [
                (ThemeChoice::Dark, "Dark", "Quiet, for judging pictures"),
                (ThemeChoice::Light, "Light", "For bright rooms"),
                (
                    ThemeChoice::System,
                    "As the system",
                    "Dark or light as other windows are",
                ),
            ] {
                ui.radio_value(&mut edited.theme, choice, name).on_hover_text(hint);
            }
        })
        .response
    });
    panel_size(ui, shown, edited);
    switch(
        ui,
        "Motion",
        "Jump to views",
        "F, Home, stored views and cameras move the view at once, without a short flight",
        &mut edited.reduced_motion,
    );
    switch(
        ui,
        "Status line",
        "Developer's figures",
        "Latency, time between frames, and nodes of the hierarchy",
        &mut edited.developer_figures,
    );
    let help = "Put all panels where they were at first";
    let (_, reset) = named(ui, "Panels", help, |ui| ui.button("Reset layout"));
    if reset.clicked() {
        commands.push(ShellCommand::ResetLayout.into());
    }
}

fn panel_size(ui: &mut Ui, shown: &Preferences, edited: &mut Preferences) {
    // A control that is scaled during a drag would move away from the pointer, so that the scale is applied on release.
    let id = ui.id().with("scale");
    let mut scale = ui.data_mut(|data| *data.get_temp_mut_or(id, shown.ui_scale));
    let help = "Multiplies the scale of the system. Keys: Ctrl and +, - or 0";
    let response = row(ui, "Size of the panels", help, |ui| {
        let control = Slider::new(&mut scale, UI_SCALES).step_by(0.05);
        slider(ui, control, UI_SCALES, |scale| format!("{:.0} %", 100.0 * scale))
    });
    if !response.dragged() {
        if response.changed() || response.drag_stopped() {
            edited.ui_scale = scale;
        }
        scale = edited.ui_scale;
    }
    ui.data_mut(|data| data.insert_temp(id, scale));
}

fn view_rows(ui: &mut Ui, edited: &mut Preferences) {
    let help = "What drags in the picture do, as in a program that you know; ? shows them all";
    row(ui, "Mouse", help, |ui| {
        choice(ui, "navigation", &mut edited.navigation, &NavigationPreset::ALL)
    });
    let help = "Of a new window. agx and filmic let bright light fade to white; clip cuts it off, as `sunroom render` does unless told";
    row(ui, "Tone map", help, |ui| {
        let maps: Vec<_> = ToneMap::ALL.iter().map(|map| (*map, map.name(), "")).collect();
        choice(ui, "tone map", &mut edited.tone_map, &maps)
    });
    let help = "Of the picture, while the camera flies or something is dragged, in scenes that are too slow for more";
    row(ui, "While moving", help, |ui| {
        let control = Slider::new(&mut edited.moving_scale, MOVING_SCALES).step_by(0.05);
        slider(ui, control, MOVING_SCALES, |scale| match scale {
            1.0 => "full resolution".to_owned(),
            scale => format!("{:.0} % resolution", 100.0 * scale),
        })
    });
    switch(
        ui,
        "After changes",
        "Carry the picture over",
        "Until a new picture has samples of its own, it shows what is still known from the one before. Saved pictures have none of that",
        &mut edited.carries_over,
    );
    switch(
        ui,
        "While dragging",
        "Show the picture in headlight",
        "So that things are seen in dark rooms while the gizmo moves them. The light comes back at the end",
        &mut edited.headlight_drags,
    );
    switch(
        ui,
        "Opened scenes",
        "Begin with the last view",
        "Otherwise a scene begins with the view of its first camera",
        &mut edited.returns_to_views,
    );
    let help = hint(
        "Surfaces whose front points away from the camera are left out, so that the view from above shows the room and not its roof. See into \
         rooms shows them again",
        "see-into-rooms",
        &edited.keys,
    );
    switch(
        ui,
        "Views along axes",
        "Hide walls before rooms",
        help,
        &mut edited.axis_views_hide_walls,
    );
}

fn file_rows(ui: &mut Ui, edited: &mut Preferences) {
    let help =
        "Unsaved edits are written aside so often, to be recovered after a crash. The scene's file is left alone.";
    row(ui, "Autosave", help, |ui| {
        let time = DragValue::new(&mut edited.autosave_seconds);
        number(ui, time, 0..=LONGEST_AUTOSAVE, |seconds| match seconds as u32 {
            0 => "never".to_owned(),
            seconds => format!("every {seconds} s"),
        })
    });
    let help = "For pictures, meshes and the film; 0 is three quarters of the machine's memory. What needs more is refused, and read again with \
                F5. --memory and SUNROOM_MEMORY count before it";
    row(ui, "Memory", help, |ui| {
        let budget = DragValue::new(&mut edited.memory_gib);
        number(ui, budget, 0..=MOST_MEMORY_GIB, |gib| match gib as u32 {
            0 => "three quarters of the machine's".to_owned(),
            gib => format!("{gib} GiB"),
        })
    });
    let count = edited.recent_files.len();
    let help = format!("The menu File lists {count}");
    let (_, forget) = named(ui, "Recent scenes", help, |ui| {
        ui.add_enabled(count > 0, Button::new("Forget them"))
    });
    if forget.clicked() {
        edited.recent_files.clear();
    }
}
