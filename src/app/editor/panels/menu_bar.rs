//! The menus at the top.

use bevy::prelude::Entity;
use bevy_egui::egui::{self, Button, Ui};

use super::super::command::{Command, FileDialogKind};
use super::super::display::{DisplayMode, DisplaySettings};
use super::super::model::{DenoiserState, Model};
use super::super::overlay::BvhOverlay;

/// What the menus tick, beside the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MenuState {
    pub display: DisplaySettings,
    pub overlay: BvhOverlay,
    pub panels_shown: bool,
    /// The camera in use.
    pub camera: Option<Entity>,
}

pub fn menu_bar(ui: &mut Ui, model: &Model, state: MenuState, commands: &mut Vec<Command>) {
    egui::MenuBar::new().ui(ui, |ui| {
        ui.menu_button("File", |ui| file_menu(ui, model, commands));
        ui.menu_button("View", |ui| view_menu(ui, model, state, commands));
        ui.menu_button("Render", |ui| render_menu(ui, model, commands));
        ui.separator();
        let paused = model.status.paused;
        if ui.button(if paused { "Resume" } else { "Pause" }).clicked() {
            commands.push(Command::SetPaused(!paused));
        }
        if ui.button("Restart").clicked() {
            commands.push(Command::Restart);
        }
        denoise_button(ui, model.status.denoiser, commands);
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            if let Some(scene) = &model.status.scene {
                let name = scene.file_name().unwrap_or_default().to_string_lossy();
                ui.add(egui::Label::new(egui::RichText::new(name).weak()).truncate())
                    .on_hover_text(scene.display().to_string());
            }
        });
    });
}

fn denoise_button(ui: &mut Ui, state: DenoiserState, commands: &mut Vec<Command>) {
    match state {
        DenoiserState::Unavailable => {
            ui.add_enabled(false, Button::new("Denoise"))
                .on_disabled_hover_text("Built without the feature `denoise`");
        }
        DenoiserState::Running => {
            ui.add_enabled(false, Button::new("Denoise"));
            ui.spinner();
        }
        DenoiserState::Idle => {
            if ui.button("Denoise").clicked() {
                commands.push(Command::Denoise);
            }
        }
        DenoiserState::Shown { .. } => {
            if ui.button("Denoise").clicked() {
                commands.push(Command::Denoise);
            }
            if ui.button("Show noisy").clicked() {
                commands.push(Command::DropDenoised);
            }
        }
    }
}

fn item(ui: &mut Ui, name: &str, keys: &str) -> bool {
    let clicked = ui.add(Button::new(name).shortcut_text(keys)).clicked();
    if clicked {
        ui.close();
    }
    clicked
}

fn file_menu(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    ui.set_min_width(220.0);
    if item(ui, "Open…", "Ctrl+O") {
        commands.push(Command::ShowDialog(FileDialogKind::OpenScene));
    }
    ui.menu_button("Scenes", |ui| {
        egui::ScrollArea::vertical().max_height(400.0).show(ui, |ui| {
            for path in model.scene_files.iter() {
                let name = path.file_name().unwrap_or_default().to_string_lossy();
                if item(ui, &name, "") {
                    commands.push(Command::OpenScene(path.clone()));
                }
            }
            if model.scene_files.is_empty() {
                ui.weak("no scene files here");
            }
        });
    });
    if item(ui, "Reload", "F5") {
        commands.push(Command::ReloadScene);
    }
    ui.separator();
    if item(ui, "Save scene as…", "Ctrl+S") {
        commands.push(Command::ShowDialog(FileDialogKind::SaveScene));
    }
    if item(ui, "Save image…", "F12") {
        commands.push(Command::ShowDialog(FileDialogKind::SaveImage));
    }
    ui.separator();
    if item(ui, "Quit", "Ctrl+Q") {
        commands.push(Command::Quit);
    }
}

fn view_menu(ui: &mut Ui, model: &Model, state: MenuState, commands: &mut Vec<Command>) {
    ui.set_min_width(220.0);
    for (mode, name) in DisplayMode::ALL {
        let keys = if mode == state.display.mode.next() { "Tab" } else { "" };
        let shown = state.display.mode == mode;
        if ui.add(Button::selectable(shown, name).shortcut_text(keys)).clicked() {
            commands.push(Command::SetDisplay(DisplaySettings { mode, ..state.display }));
            ui.close();
        }
    }
    ui.separator();
    ui.menu_button("Camera", |ui| {
        egui::ScrollArea::vertical().max_height(400.0).show(ui, |ui| {
            for camera in &model.outline.sensors {
                let used = state.camera == Some(camera.entity);
                if ui.add(Button::selectable(used, &camera.name)).clicked() {
                    commands.push(Command::LookThrough(camera.entity));
                    ui.close();
                }
            }
        });
    });
    if item(ui, "Frame selection", "F") {
        commands.push(Command::FrameSelection);
    }
    if item(ui, "Frame everything", "Home") {
        commands.push(Command::FrameAll);
    }
    ui.separator();
    let boxes = if state.overlay.shown {
        "Hide BVH boxes"
    } else {
        "Show BVH boxes"
    };
    if item(ui, boxes, "B") {
        let shown = !state.overlay.shown;
        commands.push(Command::SetOverlay(BvhOverlay { shown, ..state.overlay }));
    }
    let panels = if state.panels_shown {
        "Hide panels"
    } else {
        "Show panels"
    };
    if item(ui, panels, "Ctrl+B") {
        commands.push(Command::ShowPanels(!state.panels_shown));
    }
}

fn render_menu(ui: &mut Ui, model: &Model, commands: &mut Vec<Command>) {
    ui.set_min_width(200.0);
    let paused = model.status.paused;
    if item(ui, if paused { "Resume rendering" } else { "Pause rendering" }, "Space") {
        commands.push(Command::SetPaused(!paused));
    }
    if item(ui, "Start again", "Shift+R") {
        commands.push(Command::Restart);
    }
    if model.status.denoiser != DenoiserState::Unavailable && item(ui, "Denoise now", "N") {
        commands.push(Command::Denoise);
    }
}
