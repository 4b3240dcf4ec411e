//! The list of everything in the scene: select, rename, hide, lock, reorder, and put into folders.

mod lines;
mod marks;
mod row;
mod search;
mod shared_folders;
pub mod state;

use std::sync::Arc;

use bevy::prelude::Entity;
use bevy_egui::egui::{self, Key, Response, Sense, Stroke, Ui};

use crate::app::editor::command::dragged::Dragged;
use crate::app::editor::command::selection::Extend;
use crate::app::editor::command::{Command, OutlineEdit, SelectionCommand};
use crate::app::editor::model::{Item, Model, Outline};
use crate::app::editor::panels::drag_start::is_drag_of;
use lines::{Folding, Line, LineList, folders_of, leaf};
use row::Row;
use state::{OutlinerState, Renaming, how};

/// The seconds after which a name is not asked for any more, as where the list was hidden.
const PATIENCE: f64 = 0.5;

/// Shows all things of the scene as a tree, with a filter, and adds the user's commands to `commands`.
pub fn outliner(ui: &mut Ui, model: &Model, state: &mut OutlinerState, commands: &mut Vec<Command>) {
    let (outline, selection) = (&model.outline, &model.selection);
    let find = ui.add(
        egui::TextEdit::singleline(&mut state.filter)
            .hint_text("Find")
            .desired_width(f32::INFINITY),
    )
    .on_hover_text(
        "Show only things with these words in their name or kind; material:oak finds what has a material of that name, \
         type:light all lights, has:health what has a property of that name. Enter selects what is found.",
    );
    if state
        .renaming
        .as_ref()
        .is_some_and(|renaming| item_of(outline, renaming.entity).is_none())
    {
        state.renaming = None;
    }
    if let Some((asked, since)) = state.asked {
        let item = item_of(outline, asked).filter(|_| state.filter.trim().is_empty());
        state.renaming = item.map(Renaming::of).or(state.renaming.take());
        if item.is_some() || ui.input(|input| input.time) > since + PATIENCE {
            state.asked = None;
        }
    }
    if state.renaming.is_none() && ui.input(|input| input.key_pressed(Key::F2)) {
        let active = selection.active().and_then(|entity| item_of(outline, entity));
        state.renaming = active.map(Renaming::of);
    }
    let height = ui.spacing().interact_size.y;
    let (lines, offset) = follow_selection(outline, selection.active(), height, ui, state);
    if find.lost_focus() && !state.filter.trim().is_empty() && ui.input(|input| input.key_pressed(Key::Enter)) {
        let things = lines.things(outline).collect();
        commands.push(SelectionCommand::Select(things, Extend::Replace).into());
    }
    let mut area = egui::ScrollArea::vertical().auto_shrink(false);
    if let Some(offset) = offset {
        area = area.vertical_scroll_offset(offset);
    }
    // Only the visible lines are laid out.
    area.show_rows(ui, height, lines.len(), |ui, range| {
        ui.spacing_mut().item_spacing.x = 2.0;
        for line in range.filter_map(|place| lines.get(place)) {
            match &*line {
                Line::Heading { name, count } => heading(ui, name, *count, height, state, commands),
                Line::Folder {
                    path,
                    depth,
                    members,
                    hidden,
                    locked,
                    frame,
                } => {
                    Folder {
                        path,
                        hidden: *hidden,
                        locked: *locked,
                        depth: *depth,
                        members,
                        frame: *frame,
                        is_selected: members.iter().all(|entity| selection.contains(*entity)),
                    }
                    .show(ui, height, state, commands);
                }
                Line::Item {
                    group,
                    index,
                    depth,
                    has_inside,
                } => Row {
                    item: &outline.groups()[*group].1[*index],
                    is_material: outline.groups()[*group].0 == Outline::MATERIALS,
                    depth: *depth,
                    has_inside: *has_inside,
                    lines: &lines,
                    model,
                    height,
                }
                .show(ui, state, commands),
            }
        }
    });
}

/// Returns the lines, and the scroll position if another thing became active that is not visible; closed lines around
/// it are opened.
fn follow_selection(
    outline: &Arc<Outline>,
    active: Option<Entity>,
    height: f32,
    ui: &Ui,
    state: &mut OutlinerState,
) -> (Arc<LineList>, Option<f32>) {
    let is_new = state.shown_active != active;
    state.shown_active = active;
    let place = active.filter(|_| is_new).and_then(|entity| outline.place_of(entity));
    if let Some((group, index)) = place {
        let item = &outline.groups()[group].1[index];
        state.folding.closed.remove(outline.groups()[group].0);
        for folder in folders_of(&item.name) {
            state.folding.closed.remove(folder);
        }
        let outer = |entity: &Entity| item_of(outline, *entity).and_then(|item| item.inside_of);
        let around = std::iter::successors(item.inside_of, outer);
        state.folding.open.extend(around.take(lines::DEEPEST));
    }
    let lines = state.lines.of(outline, &state.filter, &state.folding);
    let offset = place.and_then(|place| {
        let place = lines.place_of(place).or_else(|| lines.place_of_group(active?))?;
        let line = height + ui.spacing().item_spacing.y;
        let seen = ui.available_height();
        let top = place as f32 * line;
        let id = ui.make_persistent_id(ui.id().with(egui::Id::new("scroll_area")));
        let now = egui::scroll_area::State::load(ui.ctx(), id).map_or(0.0, |state| state.offset.y);
        let is_in_sight = top >= now && top + line <= now + seen;
        (!is_in_sight).then(|| (top - 0.4 * seen).max(0.0))
    });
    (lines, offset)
}

fn item_of(outline: &Outline, entity: Entity) -> Option<&Item> {
    let (group, index) = outline.place_of(entity)?;
    Some(&outline.groups()[group].1[index])
}

/// Shows a triangle that opens and closes a line; returns true if clicked.
fn triangle(ui: &mut Ui, is_open: bool) -> bool {
    let size = egui::vec2(14.0, ui.spacing().interact_size.y);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let color = ui.style().interact(&response).fg_stroke.color;
    let middle = rect.center();
    let points = if is_open {
        [(-4.0, -2.0), (4.0, -2.0), (0.0, 4.0)]
    } else {
        [(-2.0, -4.0), (4.0, 0.0), (-2.0, 4.0)]
    };
    let points = points.iter().map(|&(x, y)| middle + egui::vec2(x, y)).collect();
    ui.painter()
        .add(egui::Shape::convex_polygon(points, color, Stroke::NONE));
    response.clicked()
}

impl Folding {
    fn triangle_of(&mut self, ui: &mut Ui, key: &str) {
        if triangle(ui, !self.closed.contains(key)) && !self.closed.remove(key) {
            self.closed.insert(key.to_owned());
        }
    }

    fn triangle_of_material(&mut self, ui: &mut Ui, material: Entity) {
        if triangle(ui, self.open.contains(&material)) && !self.open.remove(&material) {
            self.open.insert(material);
        }
    }
}

fn heading(
    ui: &mut Ui,
    name: &'static str,
    count: usize,
    height: f32,
    state: &mut OutlinerState,
    commands: &mut Vec<Command>,
) {
    let row = ui.horizontal(|ui| {
        ui.set_min_height(height);
        state.folding.triangle_of(ui, name);
        ui.strong(name);
        ui.weak(count.to_string());
    });
    // A drop on the heading moves things out of all folders.
    let target = ui.interact(row.response.rect, ui.id().with(("heading", name)), Sense::hover());
    if let Some(Dragged(things)) = dropped(ui, &target) {
        commands.push(OutlineEdit::PutInto { things, folder: None }.into());
    }
}

struct Folder<'a> {
    path: &'a str,
    /// Whether all members are hidden; None if they cannot be.
    hidden: Option<bool>,
    /// Whether all members are locked.
    locked: bool,
    depth: usize,
    members: &'a [Entity],
    /// The entity that holds the folder's transform.
    frame: Option<Entity>,
    is_selected: bool,
}

impl Folder<'_> {
    fn show(&self, ui: &mut Ui, height: f32, state: &mut OutlinerState, commands: &mut Vec<Command>) {
        ui.horizontal(|ui| {
            ui.add_space(row::indent(self.depth));
            state.folding.triangle_of(ui, self.path);
            if self.frame.is_some() && state.renaming.as_ref().map(|renaming| renaming.entity) == self.frame {
                self.name_field(ui, state, commands);
                return;
            }
            let things = self.members.len() - usize::from(self.frame.is_some());
            let text = format!("{}  ({things})", leaf(self.path));
            let marks = match self.hidden {
                Some(_) => 2.0 * marks::BUTTON + 8.0,
                None => 4.0,
            };
            let width = (ui.available_width() - marks).max(40.0);
            let response = row::left_aligned(ui, text.into(), None, self.is_selected, width, height).on_hover_text(
                match self.frame {
                    Some(_) => "A group; a click selects it with everything in it, a double click renames it",
                    None => "A folder; a click selects everything in it",
                },
            );
            if let (Some(frame), true) = (self.frame, response.double_clicked()) {
                state.renaming = Some(Renaming::new(frame, leaf(self.path)));
            } else if response.clicked() {
                commands.push(SelectionCommand::Select(self.members.to_vec(), how(ui)).into());
            }
            if is_drag_of(ui, &response) {
                egui::DragAndDrop::set_payload(ui.ctx(), Dragged(self.members.to_vec()));
            }
            if let Some(Dragged(things)) = dropped(ui, &response) {
                let folder = Some(self.path.to_owned());
                commands.push(OutlineEdit::PutInto { things, folder }.into());
            }
            if let Some(hidden) = self.hidden {
                let help = match hidden {
                    true => "Show everything in the folder",
                    false => "Hide everything in the folder",
                };
                if marks::mark(ui, help, !hidden, marks::eye).clicked() {
                    commands.push(OutlineEdit::Hide(self.members.to_vec(), !hidden).into());
                }
                let help = match self.locked {
                    true => "Unlock everything in the folder",
                    false => "Lock everything in the folder",
                };
                if marks::mark(ui, help, self.locked, marks::padlock).clicked() {
                    commands.push(OutlineEdit::Lock(self.members.to_vec(), !self.locked).into());
                }
            }
        });
    }
}

impl Folder<'_> {
    fn name_field(&self, ui: &mut Ui, state: &mut OutlinerState, commands: &mut Vec<Command>) {
        let (Some(renaming), Some(frame)) = (&mut state.renaming, self.frame) else {
            return;
        };
        let width = ui.available_width();
        let Some(typed) = row::renamed(ui, renaming, width) else {
            return;
        };
        state.renaming = None;
        if let Some(name) = typed {
            let outer = self.path.rsplit_once('/').map(|(outer, _)| outer);
            let name = outer.map_or(name.clone(), |outer| format!("{outer}/{name}"));
            commands.push(OutlineEdit::Rename(frame, name).into());
        }
    }
}

/// The things dropped onto this line; a hovering drag highlights it.
fn dropped(ui: &Ui, response: &Response) -> Option<Dragged> {
    if response.dnd_hover_payload::<Dragged>().is_some() {
        let stroke = ui.visuals().selection.stroke;
        ui.painter()
            .rect_stroke(response.rect, 2.0, stroke, egui::StrokeKind::Inside);
    }
    response
        .dnd_release_payload::<Dragged>()
        .map(|dragged| (*dragged).clone())
}
