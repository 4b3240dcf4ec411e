//! The start page: sample scenes with pictures, recent files, and the tutorial.

use std::path::PathBuf;

use bevy_egui::egui::{self, Button, Id, Image, Modal, RichText, TextureHandle, TextureOptions, Ui};
use image::ImageFormat;

use super::dialog::ROW;
use super::{dialog, recovery_question};
use crate::app::editor::command::navigation_preset::NavigationPreset;
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::command::recovery_offer::Offer;
use crate::app::editor::command::samples::{SAMPLES, Sample};
use crate::app::editor::command::{Command, FileCommand, ShellCommand};
use crate::app::editor::input::actions::{self, ActionContext};
use crate::app::editor::input::press::Press;
use crate::app::editor::panels::look;
use crate::app::editor::words::files::folders_apart;

/// The size of a sample's picture in points.
const PICTURE: egui::Vec2 = egui::vec2(240.0, 150.0);
/// The space between pictures.
const GAP: f32 = 8.0;
const RECENT_WIDTH: f32 = 260.0;
const MOST_RECENT: usize = 8;

/// Shows the page; returns false when it is to be closed. `presses`: the key presses of this frame.
pub fn show(
    context: &egui::Context,
    preferences: &Preferences,
    left: &[Offer],
    actions: &ActionContext,
    presses: &[Press],
    commands: &mut Vec<Command>,
) -> bool {
    let before = commands.len();
    let modal = dialog::form(context, Modal::new(Id::new("start page")), |ui| {
        let room = ui.ctx().content_rect().size() - egui::vec2(60.0, 60.0);
        // Two columns of pictures in a small window, three in others.
        let columns = if room.x < 3.0 * (PICTURE.x + GAP) + RECENT_WIDTH {
            2
        } else {
            3
        };
        ui.set_width(columns as f32 * (PICTURE.x + GAP) + RECENT_WIDTH);
        ui.set_max_height(room.y);
        ui.label(RichText::new("Sunroom").heading().strong());
        ui.add_space(6.0);
        let mut closes = false;
        ui.horizontal_top(|ui| {
            ui.vertical(|ui| {
                ui.set_width(columns as f32 * (PICTURE.x + GAP));
                title_of_picture(ui, RichText::new("Sample scenes").strong());
                ui.spacing_mut().item_spacing = egui::vec2(GAP, GAP);
                let height = room.y - 90.0;
                egui::ScrollArea::vertical().max_height(height).show(ui, |ui| {
                    for row in SAMPLES.chunks(columns) {
                        ui.horizontal(|ui| row.iter().for_each(|sample| tile(ui, sample, commands)));
                    }
                });
            });
            ui.vertical(|ui| {
                ui.set_width(RECENT_WIDTH - GAP);
                recovery_question::on_start_page(ui, left, commands);
                // Unsaved work comes first.
                let first = match preferences.recent_files.is_empty() {
                    _ if !left.is_empty() => None,
                    true => Some("tutorial"),
                    false => Some("new"),
                };
                closes |= begin(ui, actions, first, presses, commands);
                mouse(ui, preferences.navigation, commands);
                recent(ui, &preferences.recent_files, commands);
            });
        });
        ui.separator();
        ui.horizontal(|ui| {
            let mut shown = preferences.start_page;
            let label = "Show this page when the program starts without a file";
            if ui.checkbox(&mut shown, label).changed() {
                let edited = Preferences {
                    start_page: shown,
                    ..preferences.clone()
                };
                commands.push(ShellCommand::SetPreferences(Box::new(edited)).into());
            }
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                closes |= ui.button("Close").on_hover_text("Esc").clicked();
            });
        });
        closes
    });
    let opens = commands[before..]
        .iter()
        .any(|command| matches!(command, Command::File(FileCommand::OpenScene(_))));
    !(modal.inner || opens || modal.should_close())
}

/// A text aligned with the pictures, which are inset in buttons.
fn title_of_picture(ui: &mut Ui, text: RichText) {
    ui.horizontal(|ui| {
        let padding = ui.spacing().button_padding.x;
        ui.spacing_mut().item_spacing.x = 0.0;
        ui.add_space(padding);
        ui.label(text);
    });
}

/// A sample's picture with its title; a click opens it.
fn tile(ui: &mut Ui, sample: &Sample, commands: &mut Vec<Command>) {
    ui.vertical(|ui| {
        let path = sample.path();
        let response = match picture(ui.ctx(), sample) {
            Some(texture) => {
                let image = Image::new((texture.id(), PICTURE)).alt_text(sample.title);
                ui.add_enabled(path.is_some(), Button::image(image).frame_when_inactive(false))
            }
            None => ui.add_enabled(path.is_some(), Button::new(sample.title).min_size(PICTURE)),
        };
        title_of_picture(ui, sample.title.into());
        let absent = format!("scenes/{} is not there", sample.file);
        let response = response
            .on_hover_text(format!("Open scenes/{}", sample.file))
            .on_disabled_hover_text(absent);
        if let (true, Some(path)) = (response.clicked(), path) {
            commands.push(FileCommand::OpenScene(path).into());
        }
    });
}

/// The texture of a sample's picture, which is made once.
fn picture(context: &egui::Context, sample: &Sample) -> Option<TextureHandle> {
    let id = Id::new(("sample picture", sample.file));
    if let Some(known) = context.data(|data| data.get_temp(id)) {
        return Some(known);
    }
    let decoded = image::load_from_memory_with_format(sample.picture, ImageFormat::Jpeg).ok()?;
    let rgba = decoded.to_rgba8();
    let size = [rgba.width() as usize, rgba.height() as usize];
    let pixels = egui::ColorImage::from_rgba_unmultiplied(size, &rgba);
    let texture = context.load_texture(sample.file, pixels, TextureOptions::LINEAR);
    context.data_mut(|data| data.insert_temp(id, texture.clone()));
    Some(texture)
}

/// The choice of the navigation preset.
fn mouse(ui: &mut Ui, chosen: NavigationPreset, commands: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        let label = ui.label("Navigate as in");
        egui::ComboBox::from_id_salt("navigation")
            .width(ui.available_width())
            .selected_text(chosen.name())
            .show_ui(ui, |ui| {
                for (preset, name, help) in NavigationPreset::ALL {
                    let entry = ui.selectable_label(preset == chosen, name).on_hover_text(help);
                    if entry.clicked() {
                        commands.push(ShellCommand::SetNavigation(preset).into());
                    }
                }
            })
            .response
            .labelled_by(label.id);
    });
    ui.add_space(GAP);
}

/// Shows the buttons to start with, which have keys; returns true if one was chosen. `first`: the button of most users.
fn begin(
    ui: &mut Ui,
    context: &ActionContext,
    first: Option<&str>,
    presses: &[Press],
    commands: &mut Vec<Command>,
) -> bool {
    ui.label(RichText::new("Begin").strong());
    let mut is_chosen = false;
    for (name, help) in [
        (
            "tutorial",
            "Five steps in this window: look around, add, move, paint, save",
        ),
        ("new", "An empty scene with a camera and a sky"),
        ("open", "A scene from a file"),
    ] {
        let Some(action) = actions::find(name) else { continue };
        let button =
            look::primary_if(ui, Some(name) == first, action.label).min_size(egui::vec2(ui.available_width(), ROW));
        let button = ui.add(button).on_hover_text(actions::hint(help, name, context.bound));
        let is_pressed = presses.iter().any(|press| action.is_pressed(press, context.bound));
        if button.clicked() || is_pressed && !is_chosen {
            commands.extend((action.command)(context));
            is_chosen = true;
        }
    }
    ui.add_space(GAP);
    is_chosen
}

fn recent(ui: &mut Ui, files: &[PathBuf], commands: &mut Vec<Command>) {
    ui.label(RichText::new("Recent files").strong());
    if files.is_empty() {
        ui.weak("Files that you open are listed here.");
    }
    let files = &files[..files.len().min(MOST_RECENT)];
    for (path, folder) in files.iter().zip(folders_apart(files)) {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let button = Button::new(name)
            .right_text(RichText::new(folder).weak().small())
            .truncate()
            .min_size(egui::vec2(ui.available_width(), ROW));
        let response = ui.add(button).on_hover_text(path.display().to_string());
        if response.clicked() {
            commands.push(FileCommand::OpenScene(path.clone()).into());
        }
    }
}
