//! Browses folders of pictures, environments, meshes, scenes and materials. A double click uses a file for the
//! selection, a drag takes it into the picture.

use std::cmp::Reverse;
use std::path::{Path, PathBuf};

use bevy_egui::egui::{self, Align2, Color32, FontId, Rect, Response, RichText, Sense, Ui, vec2};

use super::drag_start::is_drag_of;
use crate::app::editor::command::asset_kind::AssetKind;
use crate::app::editor::command::dragged::DraggedFile;
use crate::app::editor::command::{Command, FileCommand, FileDialogKind, SceneEdit, ShellCommand};
use crate::app::editor::model::Model;
use crate::app::editor::model::assets::{AssetEntry, AssetPicture, AssetsModel};
use crate::app::editor::words::files::size_text;
use crate::scene::assets::gltf_scene::is_called_gltf;

/// The state that the panel keeps between frames.
#[derive(Clone, Debug, Default)]
pub struct AssetsState {
    /// The shown folder; None until the window has found one.
    pub folder: Option<PathBuf>,
    filter: String,
    kind: Option<AssetKind>,
    sort: Sort,
    /// Whether the panel is shown in this frame.
    pub is_shown: bool,
    /// The files whose pictures are visible in this frame, from the top.
    pub in_sight: Vec<AssetEntry>,
}

/// The order of the files.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Sort {
    #[default]
    Name,
    Newest,
    Largest,
}

impl Sort {
    const ALL: [(Self, &str); 3] = [
        (Self::Name, "By name"),
        (Self::Newest, "Newest first"),
        (Self::Largest, "Largest first"),
    ];

    fn name(self) -> &'static str {
        let own = Self::ALL.iter().find(|(sort, _)| *sort == self);
        own.map_or("", |(_, name)| name)
    }
}

/// The edge of a picture, and below the height of the two lines under it, in points.
const EDGE: f32 = 64.0;
const LINES: f32 = 28.0;
const GAP: f32 = 6.0;

/// The browser.
pub fn assets(ui: &mut Ui, model: &Model, state: &mut AssetsState, commands: &mut Vec<Command>) {
    state.is_shown = true;
    let known = &model.assets;
    keep_informed(ui, known);
    places(ui, known, state, commands);
    if let Some(folder) = state.folder.clone() {
        breadcrumb(ui, known, &folder, state);
    }
    ui.add(
        egui::TextEdit::singleline(&mut state.filter)
            .hint_text("Find")
            .desired_width(f32::INFINITY),
    );
    ui.horizontal(|ui| choices(ui, state));
    egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
        let Some(listing) = &known.listing else {
            ui.weak("Reading the folder\u{2026}");
            return;
        };
        if let Some(problem) = &listing.problem {
            ui.colored_label(ui.visuals().warn_fg_color, problem);
        }
        let shown = shown(&listing.entries, state);
        if shown.is_empty() && listing.problem.is_none() {
            ui.weak("There is nothing of that kind here.");
        }
        ui.spacing_mut().item_spacing = vec2(GAP, GAP);
        ui.horizontal_wrapped(|ui| {
            for entry in shown {
                match entry.kind {
                    None => folder_cell(ui, entry, state),
                    Some(kind) => file_cell(ui, entry, kind, known, state, commands),
                }
            }
        });
    });
}

/// Updates a drag with the content of its file, which may become known during the drag.
fn keep_informed(ui: &Ui, known: &AssetsModel) {
    let Some(dragged) = egui::DragAndDrop::payload::<DraggedFile>(ui.ctx()) else {
        return;
    };
    let now = self::dragged(known, &dragged.file.path);
    if now != *dragged {
        egui::DragAndDrop::set_payload(ui.ctx(), now);
    }
}

/// A dragged file, with its known content.
fn dragged(known: &AssetsModel, path: &Path) -> DraggedFile {
    DraggedFile {
        file: known.use_of(path),
        is_scene: is_scene(path, known.pictures.get(path)),
    }
}

/// Whether the file is known to be a whole scene, which can be added or opened.
fn is_scene(path: &Path, picture: Option<&AssetPicture>) -> bool {
    match AssetKind::of(path) {
        Some(AssetKind::Mesh) => is_called_gltf(path),
        Some(AssetKind::Scene) => picture.is_some_and(|picture| !picture.is_material),
        _ => false,
    }
}

/// The buttons beside the list of folders.
const ADD: &str = "Add…";
const KEEP: &str = "+";
const TAKE_OUT: &str = "\u{2212}";

/// The width that a button with this text needs in a row, with the gap before it.
fn width_of_button(ui: &Ui, text: &str) -> f32 {
    let font = egui::TextStyle::Button.resolve(ui.style());
    let text = ui
        .painter()
        .layout_no_wrap(text.to_owned(), font, egui::Color32::PLACEHOLDER);
    let spacing = ui.spacing();
    text.size().x.ceil() + 2.0 * spacing.button_padding.x + spacing.item_spacing.x
}

/// Shows the root folders, and the buttons to add and remove one.
fn places(ui: &mut Ui, known: &AssetsModel, state: &mut AssetsState, commands: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        let place = place_of(known, state.folder.as_deref()).map(|place| &known.places[place]);
        let beside: f32 = [ADD, KEEP, TAKE_OUT].iter().map(|text| width_of_button(ui, text)).sum();
        let width = (ui.available_width() - beside).max(60.0);
        // A list truncates its text only where its row ends.
        ui.scope(|ui| {
            ui.set_max_width(width);
            egui::ComboBox::from_id_salt("places")
                .width(width)
                .truncate()
                .selected_text(place.map_or("Folders", |place| &place.name))
                .show_ui(ui, |ui| {
                    for place in known.places.iter() {
                        let is_shown = state.folder.as_ref() == Some(&place.folder);
                        let entry = ui.selectable_label(is_shown, &place.name);
                        if entry.on_hover_text(place.folder.display().to_string()).clicked() {
                            state.folder = Some(place.folder.clone());
                        }
                    }
                })
                .response
                .on_hover_text("Folders to begin with");
        });
        let button = ui.button(ADD);
        if button.on_hover_text("Choose a folder for this list").clicked() {
            commands.push(FileCommand::ShowDialog(FileDialogKind::AssetFolder).into());
        }
        let is_known = |folder: &PathBuf| known.places.iter().any(|place| place.folder == *folder);
        let new = state.folder.clone().filter(|folder| !is_known(folder));
        let button = ui.add_enabled(new.is_some(), egui::Button::new(KEEP));
        let button = button
            .on_hover_text("Keep this folder in the list")
            .on_disabled_hover_text("This folder is in the list");
        if let (true, Some(folder)) = (button.clicked(), new) {
            commands.push(ShellCommand::AddAssetFolder(folder).into());
        }
        let own = place.filter(|place| place.is_own);
        let button = ui.add_enabled(own.is_some(), egui::Button::new(TAKE_OUT));
        let help = "Take the folder from the list. Its files stay.";
        if let (true, Some(own)) = (button.on_hover_text(help).clicked(), own) {
            commands.push(ShellCommand::RemoveAssetFolder(own.folder.clone()).into());
        }
    });
}

/// The index of the innermost root folder around a folder.
fn place_of(known: &AssetsModel, folder: Option<&Path>) -> Option<usize> {
    let around = |place: &usize| folder.is_some_and(|folder| folder.starts_with(&known.places[*place].folder));
    let places = (0..known.places.len()).filter(around);
    places.max_by_key(|place| known.places[*place].folder.components().count())
}

/// Shows the path from the root folder to the folder; a click on a part goes there.
fn breadcrumb(ui: &mut Ui, known: &AssetsModel, folder: &Path, state: &mut AssetsState) {
    let root = place_of(known, Some(folder)).map(|place| known.places[place].folder.as_path());
    let is_below = |part: &&Path| root.is_none_or(|root| part.starts_with(root));
    let mut parts: Vec<&Path> = folder.ancestors().take_while(is_below).collect();
    parts.reverse();
    ui.horizontal_wrapped(|ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        if let Some(parent) = folder.parent() {
            let up = ui.small_button("Up");
            if up.on_hover_text(format!("Up to {}", parent.display())).clicked() {
                state.folder = Some(parent.to_owned());
            }
        }
        for part in &parts {
            let name = part.file_name().unwrap_or(part.as_os_str()).to_string_lossy();
            if *part == folder {
                ui.label(RichText::new(name).small().strong())
                    .on_hover_text(folder.display().to_string());
            } else {
                if ui.link(RichText::new(name).small()).clicked() {
                    state.folder = Some(part.to_path_buf());
                }
                ui.label(RichText::new("\u{203a}").small().weak());
            }
        }
    });
}

fn choices(ui: &mut Ui, state: &mut AssetsState) {
    let width = 0.5 * (ui.available_width() - ui.spacing().item_spacing.x);
    let name = |kind: Option<AssetKind>| {
        let own = AssetKind::ALL.iter().find(|(known, _)| Some(*known) == kind);
        own.map_or("All kinds", |(_, name)| name)
    };
    egui::ComboBox::from_id_salt("kind")
        .width(width)
        .truncate()
        .selected_text(name(state.kind))
        .show_ui(ui, |ui| {
            for kind in std::iter::once(None).chain(AssetKind::ALL.map(|(kind, _)| Some(kind))) {
                ui.selectable_value(&mut state.kind, kind, name(kind));
            }
        })
        .response
        .widget_info(|| list("Kind"));
    egui::ComboBox::from_id_salt("order")
        .width(width)
        .truncate()
        .selected_text(state.sort.name())
        .show_ui(ui, |ui| {
            for (sort, name) in Sort::ALL {
                ui.selectable_value(&mut state.sort, sort, name);
            }
        })
        .response
        .widget_info(|| list("Order"));
}

/// The accessibility info of a list without a label beside it.
fn list(name: &str) -> egui::WidgetInfo {
    egui::WidgetInfo::labeled(egui::WidgetType::ComboBox, true, name)
}

/// The entries that pass the filters, in the chosen order. Folders come first, always by name.
fn shown<'e>(entries: &'e [AssetEntry], state: &AssetsState) -> Vec<&'e AssetEntry> {
    let wanted = state.filter.trim().to_lowercase();
    let is_wanted = |entry: &&AssetEntry| {
        (entry.kind.is_none() || state.kind.is_none() || entry.kind == state.kind)
            && entry.name.to_lowercase().contains(&wanted)
    };
    let mut found: Vec<&AssetEntry> = entries.iter().filter(is_wanted).collect();
    match state.sort {
        Sort::Name => found.sort_by_key(|entry| entry.kind.is_some()),
        Sort::Newest => {
            found.sort_by_key(|entry| (entry.kind.is_some(), entry.kind.map(|_| Reverse(entry.modified))));
        }
        Sort::Largest => found.sort_by_key(|entry| (entry.kind.is_some(), Reverse(entry.bytes))),
    }
    found
}

/// Allocates a cell; the second rectangle is that of its picture. None if it is not visible.
fn cell(ui: &mut Ui, name: &str) -> (Response, Option<Rect>) {
    let (rect, response) = ui.allocate_exact_size(vec2(EDGE, EDGE + LINES), Sense::click_and_drag());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::WidgetType::Button, true, name));
    let face = ui
        .is_rect_visible(rect)
        .then(|| Rect::from_min_size(rect.min, vec2(EDGE, EDGE)));
    (response, face)
}

fn folder_cell(ui: &mut Ui, entry: &AssetEntry, state: &mut AssetsState) {
    let (response, face) = cell(ui, &entry.name);
    let Some(face) = face else { return };
    let color = ui.visuals().widgets.inactive.fg_stroke.color.gamma_multiply(0.55);
    let body = Rect::from_center_size(face.center() + vec2(0.0, 3.0), vec2(42.0, 28.0));
    let tab = Rect::from_min_size(body.min - vec2(0.0, 5.0), vec2(18.0, 8.0));
    ui.painter().rect_filled(tab, 2.0, color);
    ui.painter().rect_filled(body, 2.0, color);
    frame(ui, &response, face);
    lines(ui, face, &entry.name, "");
    if response.on_hover_text(entry.path.display().to_string()).clicked() {
        state.folder = Some(entry.path.clone());
    }
}

fn file_cell(
    ui: &mut Ui,
    entry: &AssetEntry,
    kind: AssetKind,
    known: &AssetsModel,
    state: &mut AssetsState,
    commands: &mut Vec<Command>,
) {
    let (response, face) = cell(ui, &entry.name);
    let Some(face) = face else { return };
    state.in_sight.push(entry.clone());
    let picture = known.pictures.get(&entry.path);
    paint(ui, entry, picture, face);
    frame(ui, &response, face);
    let size = size_text(entry.bytes);
    let note = picture.map_or("", |picture| &picture.note);
    lines(ui, face, &entry.name, if note.is_empty() { &size } else { note });
    if is_drag_of(ui, &response) {
        egui::DragAndDrop::set_payload(ui.ctx(), dragged(known, &entry.path));
    }
    let is_scene = kind == AssetKind::Scene && !picture.is_some_and(|picture| picture.is_material);
    let used = || Command::from(SceneEdit::UseFile(Box::new(known.use_of(&entry.path))));
    let opened = || Command::from(FileCommand::OpenScene(entry.path.clone()));
    let asked = || Command::Shell(ShellCommand::AskAboutScene(Box::new(known.use_of(&entry.path))));
    // A file of materials must not be opened as a scene before its content is known.
    let is_known = kind != AssetKind::Scene || picture.is_some();
    let can_open = is_scene || is_called_gltf(&entry.path);
    if response.double_clicked() && is_known {
        commands.push(match (is_scene, can_open) {
            (true, _) => opened(),
            (false, true) => asked(),
            (false, false) => used(),
        });
    }
    response.context_menu(|ui| {
        let (word, help) = match kind {
            AssetKind::Picture | AssetKind::Environment => ("Use", "As texture of the selected shapes, or all around"),
            AssetKind::Scene if !is_scene => ("Use", "For the selected shapes"),
            AssetKind::Mesh | AssetKind::Volume | AssetKind::Lamp | AssetKind::Scene => ("Add to the scene", ""),
        };
        let mut button = ui.button(word);
        if !help.is_empty() {
            button = button.on_hover_text(help);
        }
        if button.clicked() {
            commands.push(used());
            ui.close();
        }
        if matches!(kind, AssetKind::Picture | AssetKind::Environment) && ui.button("Use as environment").clicked() {
            commands.push(SceneEdit::Import(entry.path.clone()).into());
            ui.close();
        }
        if can_open && ui.button("Open instead of the scene").clicked() {
            commands.push(opened());
            ui.close();
        }
        if ui.button("Copy the path").clicked() {
            ui.ctx().copy_text(entry.path.display().to_string());
            ui.close();
        }
    });
    response.on_hover_ui(|ui| tool_tip(ui, entry, kind, picture, &size));
}

fn tool_tip(ui: &mut Ui, entry: &AssetEntry, kind: AssetKind, picture: Option<&AssetPicture>, size: &str) {
    ui.label(entry.path.display().to_string());
    let note = picture.map_or("", |picture| &picture.note);
    match note.is_empty() {
        true => ui.weak(size),
        false => ui.weak(format!("{note}, {size}")),
    };
    if let Some(problem) = picture.and_then(|picture| picture.problem.as_ref()) {
        ui.colored_label(ui.visuals().error_fg_color, problem);
        return;
    }
    let is_material = picture.is_some_and(|picture| picture.is_material);
    ui.label(match kind {
        AssetKind::Picture | AssetKind::Environment => {
            "Drag it onto a shape for a texture, or beside all shapes for the light from all around. A double click is for the selection."
        }
        AssetKind::Mesh if is_called_gltf(&entry.path) => {
            "Drag it into the picture, or click it twice: it can be added to the scene, or opened."
        }
        AssetKind::Mesh => "Drag it to where it is to stand. A double click adds it where its file says.",
        AssetKind::Volume => "Drag it to where it is to stand, in a box of its own. A double click puts it where there is room.",
        AssetKind::Lamp => "Drag it to where it is to hang; it shines down. A double click puts it above what is in the middle of the view.",
        AssetKind::Scene if is_material => "Drag it onto a shape. A double click is for the selection.",
        AssetKind::Scene if picture.is_none() => "It has not been read yet.",
        AssetKind::Scene => "Drag it into the picture to add it to the scene, or to open it. A double click opens it.",
    });
}

fn paint(ui: &Ui, entry: &AssetEntry, picture: Option<&AssetPicture>, face: Rect) {
    let visuals = ui.visuals();
    ui.painter().rect_filled(face, 2.0, visuals.extreme_bg_color);
    let texture = picture.and_then(|picture| Some((picture.texture?, picture.size)));
    if let Some((texture, [width, height])) = texture {
        let size = vec2(width as f32, height as f32);
        let place = Rect::from_center_size(face.center(), size * (EDGE / size.max_elem().max(1.0)));
        let whole = Rect::from_min_max(egui::Pos2::ZERO, egui::pos2(1.0, 1.0));
        ui.painter().image(texture, place, whole, Color32::WHITE);
        return;
    }
    let end = entry
        .path
        .extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_uppercase();
    let font = FontId::proportional(15.0);
    let color = visuals.weak_text_color();
    ui.painter()
        .text(face.center(), Align2::CENTER_CENTER, end, font, color);
    if picture.is_some_and(|picture| picture.problem.is_some()) {
        let corner = face.right_top() + vec2(-5.0, 3.0);
        let font = FontId::proportional(18.0);
        ui.painter()
            .text(corner, Align2::RIGHT_TOP, "\u{26a0}", font, visuals.error_fg_color);
    }
}

fn frame(ui: &Ui, response: &Response, face: Rect) {
    if response.hovered() || response.has_focus() {
        let stroke = ui.visuals().selection.stroke;
        ui.painter().rect_stroke(face, 2.0, stroke, egui::StrokeKind::Inside);
    }
}

/// Shows the name, and the known content.
fn lines(ui: &Ui, face: Rect, name: &str, note: &str) {
    let font = egui::TextStyle::Small.resolve(ui.style());
    let mut top = face.center_bottom() + vec2(0.0, 2.0);
    for (text, color) in [
        (name, ui.visuals().text_color()),
        (note, ui.visuals().weak_text_color()),
    ] {
        let mut job = egui::text::LayoutJob::simple_singleline(text.to_owned(), font.clone(), color);
        job.wrap.max_width = face.width();
        job.wrap.max_rows = 1;
        job.wrap.break_anywhere = true;
        job.halign = egui::Align::Center;
        let galley = ui.painter().layout_job(job);
        let height = galley.size().y;
        ui.painter().galley(top, galley, color);
        top.y += height;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_innermost_place_counts() {
        use crate::app::editor::model::assets::AssetPlace;
        let place = |folder: &str| AssetPlace {
            name: folder.to_owned(),
            folder: folder.into(),
            is_own: false,
        };
        let known = AssetsModel {
            places: vec![place("/a"), place("/a/b"), place("/c")].into(),
            ..AssetsModel::default()
        };
        let of = |folder: &str| place_of(&known, Some(Path::new(folder)));
        assert_eq!(
            (of("/a/b/d"), of("/a/d"), of("/d"), place_of(&known, None)),
            (Some(1), Some(0), None, None)
        );
    }
}
