//! The rows below the list of files: the name, the kind of files, a new folder, and the question before a file is
//! replaced.

use std::path::Path;

use bevy_egui::egui::text::{CCursor, CCursorRange};
use bevy_egui::egui::{self, Align, ComboBox, Id, Layout, TextEdit, Ui};

use super::listing::{Entry, changed_text};
use super::names::in_format;
use super::{FileDialog, NAME, Outcome, Purpose, is_entered, select};
use crate::app::editor::panels::look;
use crate::app::editor::words::files::{extension, in_plain_words, size_text};

impl FileDialog {
    /// Shows the name and the format, or the filter of the list, and the buttons.
    pub(super) fn foot(&mut self, ui: &mut Ui) -> Option<Outcome> {
        let mut outcome = None;
        let mut accepts = false;
        ui.horizontal(|ui| {
            match self.purpose.clone() {
                Purpose::Save(formats, _) => self.name_row(ui, formats),
                Purpose::Folder => {}
                Purpose::Open(extensions) => {
                    let mut lists_all = self.filter.extensions.is_empty();
                    let known = extensions.join(", ");
                    if ui
                        .checkbox(&mut lists_all, "All files")
                        .on_hover_text(format!("Otherwise those with the endings {known}"))
                        .changed()
                    {
                        self.filter.extensions = if lists_all { Vec::new() } else { extensions.to_vec() };
                    }
                }
            }
            ui.checkbox(&mut self.filter.shows_hidden, "Hidden")
                .on_hover_text("Also what begins with a dot");
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                let has_path = self.path.is_some();
                let (can, does) = match self.purpose {
                    Purpose::Save(..) => (has_path || !self.name.trim().is_empty(), "Save"),
                    Purpose::Open(_) => (has_path || self.chosen.is_some(), "Open"),
                    Purpose::Folder => (true, "Use this folder"),
                };
                let button = look::primary_if(ui, can, does).min_size(egui::vec2(70.0, 0.0));
                let mut button = ui.add_enabled(can, button);
                if self.purpose == Purpose::Folder {
                    button = button.on_hover_text(self.chosen_folder().display().to_string());
                }
                accepts = button.clicked();
                if ui.button("Cancel").on_hover_text("Esc").clicked() {
                    outcome = Some(Outcome::Cancelled);
                }
                if self.saves() {
                    self.folder_button(ui);
                }
            });
        });
        if accepts && let Some(path) = self.typed_path() {
            outcome = self.go_or_accept(&path, ui.ctx()).or(outcome);
        } else if accepts && self.purpose == Purpose::Folder {
            outcome = Some(Outcome::Picked(self.chosen_folder()));
        } else if accepts {
            let name = if self.saves() {
                self.name.clone()
            } else {
                self.chosen.clone().unwrap_or_default()
            };
            outcome = self.accept(&name).or(outcome);
        }
        outcome
    }

    fn name_row(&mut self, ui: &mut Ui, formats: &[(&'static str, &'static str)]) {
        ui.label("Name");
        let id = Id::new(NAME);
        let field = ui.add(TextEdit::singleline(&mut self.name).id(id).desired_width(220.0));
        if !self.has_begun {
            field.request_focus();
            // The name without its extension is selected, to be typed over.
            let stem = Path::new(&self.name).file_stem().unwrap_or_default();
            let letters = stem.to_string_lossy().chars().count();
            let range = CCursorRange::two(CCursor::new(0), CCursor::new(letters));
            select(ui.ctx(), id, range);
        }
        if formats.len() > 1 {
            let now = extension(Path::new(&self.name));
            let chosen = formats.iter().find(|(_, known)| *known == now).unwrap_or(&formats[0]);
            ComboBox::from_id_salt("format")
                .selected_text(chosen.0)
                .show_ui(ui, |ui| {
                    for (label, known) in formats {
                        let is_chosen = ui.selectable_label(chosen.1 == *known, *label).clicked();
                        if is_chosen && !self.name.is_empty() {
                            self.name = in_format(&self.name, formats, known);
                        }
                    }
                });
        }
    }

    fn folder_button(&mut self, ui: &mut Ui) {
        let Some(name) = &mut self.new_folder else {
            if ui.button("New folder").clicked() {
                self.new_folder = Some(String::new());
            }
            return;
        };
        let field = TextEdit::singleline(name)
            .hint_text("Name, then Enter")
            .desired_width(120.0);
        let field = ui.add(field);
        if field.lost_focus() {
            let name = self.new_folder.take().unwrap_or_default();
            if is_entered(ui) && !name.trim().is_empty() {
                self.make_folder(&name);
            }
        } else {
            field.request_focus();
        }
    }

    fn make_folder(&mut self, name: &str) {
        let folder = self.folder.join(name.trim());
        match std::fs::create_dir(&folder) {
            Ok(()) => self.go_to(&folder),
            Err(error) => self.problem = Some(in_plain_words(&format!("{}: {error}", folder.display()))),
        }
    }

    /// Asks whether to replace a file.
    pub(super) fn replace_row(&mut self, ui: &mut Ui, file: &Path) -> Option<Outcome> {
        let mut outcome = None;
        ui.horizontal(|ui| {
            let lost = self.lost_with(file).into_iter().map(|path| {
                let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
                let known = self.entries.iter().find(|entry| entry.name == name);
                (name, known)
            });
            let lost: Vec<_> = lost.collect();
            ui.add(egui::Label::new(replaced_text(&lost)).truncate());
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if ui.button("Keep it").clicked() {
                    self.replaces = None;
                }
                if ui.add(look::danger(ui, "Replace")).clicked() {
                    outcome = Some(Outcome::Picked(file.to_path_buf()));
                }
            });
        });
        outcome
    }
}

/// The question before files are replaced, with the files that would be lost.
fn replaced_text(lost: &[(String, Option<&Entry>)]) -> String {
    let about = |known: &Entry| {
        let size = size_text(known.bytes);
        match changed_text(known) {
            changed if changed.is_empty() => format!(" ({size})"),
            changed => format!(" ({size}, of {changed})"),
        }
    };
    match lost {
        [(name, known)] => format!(
            "{name} is there already{}. Replace it?",
            known.map_or(String::new(), about)
        ),
        lost => {
            let names: Vec<&str> = lost.iter().map(|(name, _)| name.as_str()).collect();
            format!("{} are there already. Replace both?", names.join(" and "))
        }
    }
}
