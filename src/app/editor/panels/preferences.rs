//! The preferences of the user for the program itself.

use bevy_egui::egui::{self, DragValue, Grid, Slider, Ui};

use crate::app::editor::command::Command;
use crate::app::editor::command::navigation_preset::NavigationPreset;
use crate::app::editor::command::preferences::{
    LONGEST_AUTOSAVE, MOST_MEMORY_GIB, MOVING_SCALES, Preferences, ThemeChoice, UI_SCALES,
};
use crate::app::editor::command::shell::ShellCommand;
use crate::app::editor::input::actions::hint;
use crate::render::tonemap::ToneMap;

/// Shows the preferences. `problem` is what is wrong with their file.
pub fn preferences(ui: &mut Ui, shown: &Preferences, problem: Option<&str>, commands: &mut Vec<Command>) {
    let mut edited = shown.clone();
    Grid::new("preferences")
        .num_columns(2)
        .spacing(egui::vec2(16.0, 8.0))
        .show(ui, |ui| {
            ui.label("Colours");
            ui.horizontal(|ui| {
                for (choice, name, hint) in [
                    (ThemeChoice::Dark, "Dark", "Quiet, for judging pictures"),
                    (ThemeChoice::Light, "Light", "For bright rooms"),
                    (ThemeChoice::System, "As the system", "Dark or light as other windows are"),
                ] {
                    ui.radio_value(&mut edited.theme, choice, name).on_hover_text(hint);
                }
            });
            ui.end_row();

            let label = ui.label("Size of the panels");
            let percent = |scale: f64, _| format!("{:.0} %", 100.0 * scale);
            let parse = |text: &str| Some(text.trim_end_matches(['%', ' ']).parse::<f64>().ok()? / 100.0);
            // A control that is scaled while it is dragged would move away from the pointer, so the scale follows when it is released.
            let mut scale = ui.data_mut(|data| *data.get_temp_mut_or(ui.id().with("scale"), shown.ui_scale));
            let slider = Slider::new(&mut scale, UI_SCALES)
                .step_by(0.05)
                .custom_formatter(percent)
                .custom_parser(parse);
            let response = ui.add(slider).labelled_by(label.id);
            let response = response.on_hover_text("Multiplies the scale of the system. Keys: Ctrl and +, - or 0");
            if response.dragged() {
                ui.data_mut(|data| data.insert_temp(ui.id().with("scale"), scale));
            } else {
                if response.changed() || response.drag_stopped() {
                    edited.ui_scale = scale;
                }
                ui.data_mut(|data| data.insert_temp(ui.id().with("scale"), edited.ui_scale));
            }
            ui.end_row();

            let label = ui.label("Mouse");
            egui::ComboBox::from_id_salt("navigation")
                .selected_text(edited.navigation.name())
                .show_ui(ui, |ui| {
                    for (preset, name, hint) in NavigationPreset::ALL {
                        ui.selectable_value(&mut edited.navigation, preset, name)
                            .on_hover_text(hint);
                    }
                })
                .response
                .labelled_by(label.id)
                .on_hover_text("What drags in the picture do, as in a program that you know; ? shows them all");
            ui.end_row();

            let label = ui.label("Tone map");
            egui::ComboBox::from_id_salt("tone map")
                .selected_text(edited.tone_map.name())
                .show_ui(ui, |ui| {
                    for map in ToneMap::ALL {
                        ui.selectable_value(&mut edited.tone_map, map, map.name());
                    }
                })
                .response
                .labelled_by(label.id)
                .on_hover_text(
                    "Of a new window. agx and filmic let bright light fade to white; clip cuts it off, as `sunroom render` does unless told",
                );
            ui.end_row();

            let label = ui.label("While moving");
            let share = |scale: f64, _| match scale {
                1.0 => "full resolution".to_owned(),
                scale => format!("{:.0} % resolution", 100.0 * scale),
            };
            let slider = Slider::new(&mut edited.moving_scale, MOVING_SCALES)
                .step_by(0.05)
                .custom_formatter(share)
                .custom_parser(parse);
            ui.add(slider).labelled_by(label.id).on_hover_text(
                "Of the picture, while the camera flies or something is dragged, in scenes that are too slow for more",
            );
            ui.end_row();

            ui.label("Motion");
            ui.checkbox(&mut edited.reduced_motion, "Jump to views")
                .on_hover_text("F, Home, stored views and cameras move the view at once, without a short flight");
            ui.end_row();

            ui.label("Opened scenes");
            ui.checkbox(&mut edited.returns_to_views, "Begin with the last view")
                .on_hover_text("Otherwise a scene begins with the view of its first camera");
            ui.end_row();

            ui.label("Status line");
            ui.checkbox(&mut edited.developer_figures, "Developer's figures")
                .on_hover_text("Latency, time between frames, and nodes of the hierarchy");
            ui.end_row();

            ui.label("Views along axes");
            ui.checkbox(&mut edited.axis_views_hide_walls, "Hide walls before rooms")
                .on_hover_text(hint(
                    "Surfaces whose front points away from the camera are left out, so that the view from above shows the room and not its roof. \
                     See into rooms shows them again",
                    "see-into-rooms",
                    &shown.keys,
                ));
            ui.end_row();

            let label = ui.label("Autosave");
            let time = DragValue::new(&mut edited.autosave_seconds)
                .range(0..=LONGEST_AUTOSAVE)
                .custom_formatter(|seconds, _| match seconds as u32 {
                    0 => "never".to_owned(),
                    seconds => format!("every {seconds} s"),
                });
            ui.add(time).labelled_by(label.id).on_hover_text(
                "Unsaved edits are written aside so often, to be recovered after a crash. The scene's file is left alone.",
            );
            ui.end_row();

            let label = ui.label("Memory");
            let budget = DragValue::new(&mut edited.memory_gib)
                .range(0..=MOST_MEMORY_GIB)
                .custom_formatter(|gib, _| match gib as u32 {
                    0 => "three quarters of the machine's".to_owned(),
                    gib => format!("{gib} GiB"),
                })
                .custom_parser(|text| text.trim_end_matches([' ', 'G', 'i', 'B']).parse().ok());
            ui.add(budget).labelled_by(label.id).on_hover_text(
                "For pictures, meshes and the film; 0 is three quarters of the machine's memory. What needs more is refused, and read again with \
                 F5. --memory and SUNROOM_MEMORY count before it",
            );
            ui.end_row();

            ui.label("Recent scenes");
            let count = edited.recent_files.len();
            let button = egui::Button::new("Forget them");
            if ui
                .add_enabled(count > 0, button)
                .on_hover_text(format!("The menu File lists {count}"))
                .clicked()
            {
                edited.recent_files.clear();
            }
            ui.end_row();

            ui.label("Panels");
            if ui
                .button("Reset layout")
                .on_hover_text("Put all panels where they were at first")
                .clicked()
            {
                commands.push(Command::Shell(ShellCommand::ResetLayout));
            }
            ui.end_row();
        });
    if let Some(problem) = problem {
        ui.separator();
        ui.colored_label(ui.visuals().error_fg_color, problem);
    }
    if edited != *shown {
        commands.push(Command::Shell(ShellCommand::SetPreferences(Box::new(edited))));
    }
}
