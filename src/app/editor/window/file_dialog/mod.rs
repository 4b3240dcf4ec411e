//! The dialog that chooses a file: shortcuts to folders at the left, the files of a folder with their sizes and dates,
//! a path and a search.

mod fields;
mod foot;
pub mod listing;
mod names;
mod table;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};
use std::time::Duration;

use bevy_egui::egui::text::{CCursor, CCursorRange};
use bevy_egui::egui::{self, Button, Event, Id, Key, RichText, ScrollArea, TextEdit, Ui};
use crossbeam_channel::{Receiver, RecvTimeoutError};

use crate::app::editor::window::dialog;
use crate::app::editor::words::files::home_for_tilde;
use fields::{is_entered, select};
use listing::{Entry, Filter, Listed, Order};
use names::{is_of, is_path, with_end, without_dots};

/// The purpose of the dialog.
#[derive(Clone, Debug, PartialEq)]
pub enum Purpose {
    /// Open an existing file. Only files of these extensions are listed at first.
    Open(&'static [&'static str]),
    /// Write a file in one of these formats, given by name and extension. The text is the proposed name.
    Save(&'static [(&'static str, &'static str)], String),
    /// Choose an existing folder: the shown one, or the one selected in it.
    Folder,
}

/// A shortcut to a folder.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// The name in the list.
    pub name: String,
    /// The absolute path.
    pub folder: PathBuf,
    /// Whether it is a recent folder, which is listed apart from the others.
    pub is_recent: bool,
}

/// The state of the dialog after a frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Outcome {
    /// The dialog goes on.
    Open,
    /// This file or folder was chosen.
    Picked(PathBuf),
    /// The dialog was closed without a choice.
    Cancelled,
}

/// A dialog that is open.
#[derive(Clone, Debug)]
pub struct FileDialog {
    title: String,
    purpose: Purpose,
    places: Vec<Place>,
    folder: PathBuf,
    entries: Vec<Entry>,
    /// The receiver of the folder's entries while it is being read.
    reading: Option<Receiver<Listed>>,
    problem: Option<String>,
    filter: Filter,
    order: Order,
    /// The indices of the shown entries, and the filter and the order that they are for.
    shown: Vec<usize>,
    shown_for: Option<(Filter, Order)>,
    /// The name of the selected entry.
    chosen: Option<String>,
    /// The text of the path while it is edited.
    path: Option<String>,
    /// The name of the file to write.
    name: String,
    /// The second file that is written with the chosen one, if any.
    second: fn(&Path) -> Option<PathBuf>,
    /// The file to write, while the user is asked whether to replace it.
    replaces: Option<PathBuf>,
    /// The name of a folder to make, while it is typed.
    new_folder: Option<String>,
    has_begun: bool,
    /// Whether the list scrolls to the selected entry in the next frame.
    shows_chosen: bool,
    /// Whether Enter was pressed in the search before the folder was read.
    is_entered_early: bool,
}

/// The largest size of the dialog, and that of the column of shortcuts, in points.
const SIZE: egui::Vec2 = egui::vec2(820.0, 480.0);
const PLACES: f32 = 150.0;
/// The time that a frame waits for a folder: most are read by then, and the list does not flicker.
const SOON: Duration = Duration::from_millis(50);
/// The fields for the path, for the name of the file to write, and for the search.
const PATH: &str = "path of the folder";
const NAME: &str = "name of the file";
const SEARCH: &str = "search for a file";

impl FileDialog {
    /// A dialog in a folder, which is absolute.
    pub fn new(title: impl Into<String>, purpose: Purpose, folder: PathBuf, places: Vec<Place>) -> Self {
        let (extensions, name) = match &purpose {
            Purpose::Open(extensions) => (extensions.to_vec(), String::new()),
            Purpose::Save(formats, name) => (formats.iter().map(|(_, known)| *known).collect(), name.clone()),
            Purpose::Folder => (Vec::new(), String::new()),
        };
        let only_folders = purpose == Purpose::Folder;
        let mut dialog = Self {
            title: title.into(),
            purpose,
            places,
            folder: PathBuf::new(),
            entries: Vec::new(),
            reading: None,
            problem: None,
            filter: Filter {
                extensions,
                only_folders,
                ..Filter::default()
            },
            order: Order::default(),
            shown: Vec::new(),
            shown_for: None,
            chosen: None,
            path: None,
            name,
            second: |_| None,
            replaces: None,
            new_folder: None,
            has_begun: false,
            shows_chosen: false,
            is_entered_early: false,
        };
        dialog.go_to(&folder);
        dialog
    }

    /// The dialog for a save that writes a second file: the user is asked about both before either is replaced.
    pub fn with_second(self, second: fn(&Path) -> Option<PathBuf>) -> Self {
        Self { second, ..self }
    }

    /// The dialog as if its folder had this path and these entries.
    pub fn with_entries(mut self, folder: PathBuf, entries: Vec<Entry>) -> Self {
        (self.folder, self.entries) = (folder, entries);
        (self.reading, self.problem, self.shown_for) = (None, None, None);
        self
    }

    fn saves(&self) -> bool {
        matches!(self.purpose, Purpose::Save(..))
    }

    /// Shows a folder once it has been read. An unreadable folder is shown empty, with its problem.
    fn go_to(&mut self, folder: &Path) {
        self.folder = without_dots(folder);
        (self.entries, self.problem) = (Vec::new(), None);
        self.reading = Some(listing::begin(self.folder.clone()));
        self.shown_for = None;
        (self.chosen, self.path, self.new_folder, self.replaces) = (None, None, None, None);
        self.filter.part.clear();
        self.is_entered_early = false;
        self.take_listing(SOON);
    }

    /// Takes the entries of the folder, after waiting for them this long at most.
    fn take_listing(&mut self, wait: Duration) {
        let Some(reading) = &self.reading else { return };
        (self.entries, self.problem) = match reading.recv_timeout(wait) {
            Ok(listed) => listed,
            Err(RecvTimeoutError::Timeout) => return,
            Err(RecvTimeoutError::Disconnected) => (Vec::new(), Some("The folder could not be read.".to_owned())),
        };
        (self.reading, self.shown_for) = (None, None);
        self.choose_first_found();
    }

    /// Selects the first entry found, which Enter opens.
    fn choose_first_found(&mut self) {
        if self.filter.part.is_empty() {
            return;
        }
        self.update_shown();
        let first = self.shown.first();
        self.chosen = first.map(|place| self.entries[*place].name.clone());
    }

    /// Goes to a folder, or accepts a file. A path that does not exist stays in its field to be corrected, and so does
    /// the list.
    fn go_or_accept(&mut self, path: &Path, context: &egui::Context) -> Option<Outcome> {
        if !path.exists() {
            self.problem = Some(format!("There is no {}", path.display()));
            let path = path.display().to_string();
            let end = CCursor::new(path.chars().count());
            self.path = Some(path);
            context.memory_mut(|memory| memory.request_focus(Id::new(PATH)));
            select(context, Id::new(PATH), CCursorRange::one(end));
            return None;
        }
        if !path.is_file() {
            self.go_to(path);
            return None;
        }
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        self.go_to(path.parent().unwrap_or(path));
        if self.saves() {
            self.name.clone_from(&name);
        }
        self.choose(name.clone());
        self.accept(&name)
    }

    /// Shows the dialog.
    pub fn show(&mut self, context: &egui::Context) -> Outcome {
        let size = SIZE.min(context.content_rect().size() - egui::vec2(60.0, 120.0));
        self.take_listing(Duration::ZERO);
        if self.reading.is_some() {
            context.request_repaint();
        }
        // A text field loses the focus in the frame in which Enter is pressed in it.
        let focused = context.memory(|memory| memory.focused());
        let modal = dialog::lasting_form(context, "file dialog", |ui| {
            ui.set_width(size.x);
            ui.label(RichText::new(&self.title).heading().strong());
            ui.add_space(4.0);
            let mut went = self.path_row(ui);
            ui.add_space(2.0);
            let height = (size.y - 110.0).max(80.0);
            let mut picked = None;
            ui.horizontal_top(|ui| {
                ui.set_height(height);
                went = self.place_list(ui, height).or(went.take());
                ui.separator();
                ui.vertical(|ui| picked = self.table(ui, height));
            });
            ui.add_space(4.0);
            // Enter acts on the field that was active before this frame.
            let has_field = self.path.is_some() || self.new_folder.is_some() || self.replaces.is_some();
            let outcome = match self.replaces.clone() {
                Some(file) => self.replace_row(ui, &file),
                None => self.foot(ui),
            };
            if outcome.is_some() {
                return outcome;
            }
            if let Some(path) = went {
                return self.go_or_accept(&path, ui.ctx());
            }
            let accepted = picked.or_else(|| self.keys(ui, focused).filter(|_| !has_field));
            accepted.and_then(|name| self.accept(&name))
        });
        self.has_begun = true;
        match modal.inner {
            Some(outcome) => outcome,
            None if modal.should_close() => Outcome::Cancelled,
            None => Outcome::Open,
        }
    }

    /// The path that was typed, absolute; its field shows the folder again.
    fn typed_path(&mut self) -> Option<PathBuf> {
        let typed = self.path.take()?;
        Some(self.folder.join(home_for_tilde(&typed)))
    }

    /// Shows the button up, the path, and the search; returns the folder to go to, or the file.
    fn path_row(&mut self, ui: &mut Ui) -> Option<PathBuf> {
        let mut went = None;
        ui.horizontal(|ui| {
            let parent = self.folder.parent().map(Path::to_path_buf);
            let up = ui.add_enabled(parent.is_some(), Button::new("⬆"));
            if up.on_hover_text("To the folder around this one (Alt+Up)").clicked() {
                went.clone_from(&parent);
            }
            if ui.button("⟳").on_hover_text("Read the folder again").clicked() {
                went = Some(self.folder.clone());
            }
            let search = 170.0;
            let mut path = self.path.clone().unwrap_or_else(|| self.folder.display().to_string());
            let width = (ui.available_width() - search - ui.spacing().item_spacing.x).max(80.0);
            let field = ui.add(TextEdit::singleline(&mut path).id(Id::new(PATH)).desired_width(width));
            if field.changed() {
                self.path = Some(path);
            }
            // A path that was not entered stays in its field for the button.
            if field.lost_focus() && is_entered(ui) {
                went = self.typed_path();
            }
            let search = TextEdit::singleline(&mut self.filter.part)
                .id(Id::new(SEARCH))
                .hint_text("Find")
                .desired_width(f32::INFINITY);
            let search = ui.add(search);
            if !self.has_begun && !self.saves() {
                search.request_focus();
            }
            if search.changed() {
                // The field shows the typed text in the next frame.
                ui.ctx().request_repaint();
                if is_path(&self.filter.part) {
                    self.take_path(ui.ctx());
                }
                (self.chosen, self.is_entered_early) = (None, false);
                self.choose_first_found();
            }
        });
        went
    }

    /// Moves a path typed into the search to its field: the name of the file to write, or else the path.
    fn take_path(&mut self, context: &egui::Context) {
        let typed = std::mem::take(&mut self.filter.part);
        let end = CCursor::new(typed.chars().count());
        let field = Id::new(if self.saves() { NAME } else { PATH });
        match self.saves() {
            true => self.name = typed,
            false => self.path = Some(typed),
        }
        // The field may be shown after the search in this frame, and must not get the typed text again.
        context.input_mut(|input| {
            let is_typed = |event: &Event| matches!(event, Event::Text(_) | Event::Paste(_));
            input.events.retain(|event| !is_typed(event));
        });
        context.memory_mut(|memory| memory.request_focus(field));
        select(context, field, CCursorRange::one(end));
    }

    /// Filters and sorts the entries again if something has changed.
    fn update_shown(&mut self) {
        let is_for = |(filter, order): &(Filter, Order)| *filter == self.filter && *order == self.order;
        if !self.shown_for.as_ref().is_some_and(is_for) {
            self.shown = listing::shown(&self.entries, &self.filter, self.order);
            self.shown_for = Some((self.filter.clone(), self.order));
        }
    }

    fn choose(&mut self, name: String) {
        if self.saves() && self.entries.iter().any(|entry| entry.name == name && !entry.is_folder) {
            self.name.clone_from(&name);
        }
        self.chosen = Some(name);
        (self.path, self.replaces) = (None, None);
        self.shows_chosen = true;
    }

    /// Shows the shortcuts; returns the clicked one.
    fn place_list(&self, ui: &mut Ui, height: f32) -> Option<PathBuf> {
        let mut went = None;
        ui.vertical(|ui| {
            ui.set_width(PLACES);
            ScrollArea::vertical().max_height(height).show(ui, |ui| {
                for (heading, is_recent) in [("Places", false), ("Recent", true)] {
                    let mut places = self
                        .places
                        .iter()
                        .filter(|place| place.is_recent == is_recent)
                        .peekable();
                    if places.peek().is_some() {
                        ui.label(RichText::new(heading).small().weak());
                    }
                    for place in places {
                        let button = Button::selectable(place.folder == self.folder, &place.name).truncate();
                        let button = button.min_size(egui::vec2(PLACES, 0.0));
                        let response = ui.add(button).on_hover_text(place.folder.display().to_string());
                        if response.clicked() {
                            went = Some(place.folder.clone());
                        }
                    }
                    ui.add_space(6.0);
                }
            });
        });
        went
    }

    /// Shows the files; returns the name of a double-clicked one.
    fn table(&mut self, ui: &mut Ui, height: f32) -> Option<String> {
        if self.reading.is_some() {
            ui.weak("The folder is being read.");
            return None;
        }
        let top = ui.cursor().top();
        if let Some(problem) = &self.problem {
            ui.colored_label(ui.visuals().error_fg_color, problem);
        }
        let height = height - (ui.cursor().top() - top);
        self.update_shown();
        if self.shown.is_empty() && self.problem.is_none() {
            ui.weak(self.nothing_here());
        }
        let scrolls = std::mem::take(&mut self.shows_chosen);
        let clicked = table::show(
            ui,
            height,
            &self.entries,
            &self.shown,
            self.chosen.as_deref(),
            scrolls,
            &mut self.order,
        )?;
        let name = self.entries[clicked.place].name.clone();
        self.choose(name.clone());
        self.shows_chosen = false;
        clicked.twice.then_some(name)
    }

    /// The reason why the list is empty, with advice.
    fn nothing_here(&self) -> &'static str {
        match (self.entries.is_empty(), self.saves()) {
            _ if !self.filter.part.is_empty() => "Nothing here is called so.",
            _ if self.filter.only_folders => "There is no folder in this one.",
            (_, true) => "This folder has no files of this kind yet.",
            (true, false) => "The folder is empty.",
            (false, false) => "This folder has no files of this kind. Choose All files to see the others.",
        }
    }

    /// Handles the keys of the list; returns the entry that Enter accepts. A focused button or field takes Enter
    /// itself, other than the field with the file's name.
    fn keys(&mut self, ui: &Ui, focused: Option<Id>) -> Option<String> {
        if egui::Popup::is_any_open(ui.ctx()) {
            return None;
        }
        let (up, down, alt) = ui.input(|input| {
            let pressed = |key| input.key_pressed(key);
            (pressed(Key::ArrowUp), pressed(Key::ArrowDown), input.modifiers.alt)
        });
        if alt && up {
            let parent = self.folder.parent().map(Path::to_path_buf);
            parent.iter().for_each(|parent| self.go_to(parent));
            return None;
        }
        if up || down {
            self.update_shown();
            let shown = &self.shown;
            let is_chosen = |place: &usize| Some(&self.entries[*place].name) == self.chosen.as_ref();
            let next = match (shown.iter().position(is_chosen), down) {
                (None, true) => 0,
                (None, false) => shown.len().saturating_sub(1),
                (Some(at), true) => (at + 1).min(shown.len() - 1),
                (Some(at), false) => at.saturating_sub(1),
            };
            if let Some(place) = shown.get(next).copied() {
                self.choose(self.entries[place].name.clone());
            }
        }
        let is_moving = up || down;
        let wanted = match self.saves() {
            true => Some(self.name.clone()).filter(|name| !name.trim().is_empty()),
            false => self.chosen.clone(),
        };
        let own = Id::new(if self.saves() { NAME } else { SEARCH });
        let is_own = focused.is_none_or(|focused| focused == own);
        if self.reading.is_some() && wanted.is_none() && !self.filter.part.is_empty() {
            self.is_entered_early |= is_own && is_entered(ui);
            return None;
        }
        let is_entered = std::mem::take(&mut self.is_entered_early) || is_own && !is_moving && is_entered(ui);
        wanted.filter(|_| is_entered)
    }

    /// The folder selected in the list, else the shown one.
    fn chosen_folder(&self) -> PathBuf {
        let chosen = self.chosen.as_ref().map(|name| self.folder.join(name));
        chosen.unwrap_or_else(|| self.folder.clone())
    }

    /// Goes to the folder of that name, or accepts the file.
    fn accept(&mut self, name: &str) -> Option<Outcome> {
        let path = without_dots(&self.folder.join(home_for_tilde(name.trim())));
        if path.is_dir() {
            self.go_to(&path);
            return None;
        }
        let Purpose::Save(formats, _) = &self.purpose else {
            return path.exists().then_some(Outcome::Picked(path));
        };
        // Any other ending is a part of the name.
        let path = match formats.first() {
            Some((_, first)) if !is_of(formats, &path) => with_end(path, first),
            _ => path,
        };
        if !self.lost_with(&path).is_empty() {
            self.replaces = Some(path);
            return None;
        }
        Some(Outcome::Picked(path))
    }

    /// The existing files that writing this one replaces.
    fn lost_with(&self, path: &Path) -> Vec<PathBuf> {
        let written = std::iter::once(path.to_path_buf()).chain((self.second)(path));
        written.filter(|path| path.exists()).collect()
    }
}
