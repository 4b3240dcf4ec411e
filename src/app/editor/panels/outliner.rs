//! The list of everything in the scene: select, rename, hide, lock, reorder, and put into folders. A name like `table/leg` is a leg in the folder
//! table.

use std::collections::{BTreeSet, HashSet};

use bevy::prelude::Entity;
use bevy_egui::egui::{self, Color32, Key, Rect, Response, Sense, Stroke, Ui};

use super::super::command::Command;
use super::super::model::{Item, Outline};
use super::super::selection::{Extend, Selection};

/// What the panel remembers between frames.
#[derive(Clone, Debug, Default)]
pub struct OutlinerState {
    pub filter: String,
    /// Headings and folders that are closed, as the names of their lines.
    closed: HashSet<String>,
    renaming: Option<Renaming>,
    /// Where a range of lines begins.
    anchor: Option<Entity>,
}

#[derive(Clone, Debug)]
struct Renaming {
    entity: Entity,
    /// The last part of the name, as typed so far.
    text: String,
    /// The field has not had the keyboard yet.
    is_new: bool,
}

/// Things on their way from the list to somewhere else: into a folder, to another place, onto a shape in the picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Dragged(pub Vec<Entity>);

enum Line<'a> {
    Heading {
        name: &'static str,
        count: usize,
    },
    /// With the folder's whole path and what is in it.
    Folder {
        path: String,
        members: Vec<&'a Item>,
    },
    Item {
        item: &'a Item,
        depth: usize,
    },
}

pub fn outliner(
    ui: &mut Ui,
    outline: &Outline,
    selection: &Selection,
    state: &mut OutlinerState,
    commands: &mut Vec<Command>,
) {
    ui.add(
        egui::TextEdit::singleline(&mut state.filter)
            .hint_text("Find")
            .desired_width(f32::INFINITY),
    )
    .on_hover_text("Shows only what has this in its name or kind");
    if state
        .renaming
        .as_ref()
        .is_some_and(|renaming| item_of(outline, renaming.entity).is_none())
    {
        state.renaming = None;
    }
    let lines = lines(outline, state);
    let height = ui.spacing().interact_size.y;
    if state.renaming.is_none() && ui.input(|input| input.key_pressed(Key::F2)) {
        let active = selection.active().and_then(|entity| item_of(outline, entity));
        state.renaming = active.map(Renaming::of);
    }
    // Scenes of thousands of shapes are usual: only the lines in sight are laid out.
    egui::ScrollArea::vertical()
        .auto_shrink(false)
        .show_rows(ui, height, lines.len(), |ui, range| {
            ui.spacing_mut().item_spacing.x = 2.0;
            for line in &lines[range] {
                match line {
                    Line::Heading { name, count } => heading(ui, name, *count, height, state, commands),
                    Line::Folder { path, members } => folder(ui, path, members, selection, height, state, commands),
                    Line::Item { item, depth } => {
                        let mut row = Row {
                            item,
                            depth: *depth,
                            lines: &lines,
                            selection,
                            height,
                        };
                        row.show(ui, state, commands);
                    }
                }
            }
        });
}

fn item_of(outline: &Outline, entity: Entity) -> Option<&Item> {
    outline
        .groups()
        .into_iter()
        .flat_map(|(_, items)| items)
        .find(|item| item.entity == entity)
}

fn triangle(ui: &mut Ui, key: &str, state: &mut OutlinerState) {
    let open = !state.closed.contains(key);
    let size = egui::vec2(14.0, ui.spacing().interact_size.y);
    let (rect, response) = ui.allocate_exact_size(size, Sense::click());
    let color = ui.style().interact(&response).fg_stroke.color;
    let middle = rect.center();
    let points = if open {
        [(-4.0, -2.0), (4.0, -2.0), (0.0, 4.0)]
    } else {
        [(-2.0, -4.0), (4.0, 0.0), (-2.0, 4.0)]
    };
    let points = points.iter().map(|&(x, y)| middle + egui::vec2(x, y)).collect();
    ui.painter()
        .add(egui::Shape::convex_polygon(points, color, Stroke::NONE));
    if response.clicked() && !state.closed.remove(key) {
        state.closed.insert(key.to_owned());
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
        triangle(ui, name, state);
        ui.strong(name);
        ui.weak(count.to_string());
    });
    // Out of every folder.
    let target = ui.interact(row.response.rect, ui.id().with(("heading", name)), Sense::hover());
    if let Some(Dragged(things)) = dropped(ui, &target) {
        commands.push(Command::PutInto { things, folder: None });
    }
}

fn folder(
    ui: &mut Ui,
    path: &str,
    members: &[&Item],
    selection: &Selection,
    height: f32,
    state: &mut OutlinerState,
    commands: &mut Vec<Command>,
) {
    let entities: Vec<Entity> = members.iter().map(|item| item.entity).collect();
    let is_selected = entities.iter().all(|entity| selection.contains(*entity));
    let depth = path.matches('/').count();
    ui.horizontal(|ui| {
        ui.add_space(8.0 + 12.0 * depth as f32);
        triangle(ui, path, state);
        let leaf = path.rsplit('/').next().unwrap_or(path);
        let text = format!("{leaf}  ({})", members.len());
        let size = egui::vec2(ui.available_width(), height);
        let button = egui::Button::selectable(is_selected, text)
            .truncate()
            .min_size(size)
            .sense(Sense::click_and_drag());
        let response = ui
            .add(button)
            .on_hover_text("A folder: click selects all that is in it");
        if response.clicked() {
            commands.push(Command::Select(entities.clone(), how(ui)));
        }
        response.dnd_set_drag_payload(Dragged(entities));
        if let Some(Dragged(things)) = dropped(ui, &response) {
            let folder = Some(path.to_owned());
            commands.push(Command::PutInto { things, folder });
        }
    });
}

/// What is let go of over this; while it hovers, the place is marked.
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

/// How a click changes the selection.
fn how(ui: &Ui) -> Extend {
    if ui.input(|input| input.modifiers.command) {
        Extend::Toggle
    } else {
        Extend::Replace
    }
}

impl Renaming {
    fn of(item: &Item) -> Self {
        Self {
            entity: item.entity,
            text: leaf(&item.name).to_owned(),
            is_new: true,
        }
    }
}

fn leaf(name: &str) -> &str {
    name.rsplit('/').next().unwrap_or(name)
}

/// One thing's line.
struct Row<'a> {
    item: &'a Item,
    depth: usize,
    /// All that are shown, for ranges.
    lines: &'a [Line<'a>],
    selection: &'a Selection,
    height: f32,
}

/// Of each of the two buttons at the right.
const BUTTON: f32 = 18.0;

impl Row<'_> {
    fn show(&mut self, ui: &mut Ui, state: &mut OutlinerState, commands: &mut Vec<Command>) {
        ui.horizontal(|ui| {
            ui.add_space(22.0 + 12.0 * self.depth as f32);
            if state
                .renaming
                .as_ref()
                .is_some_and(|renaming| renaming.entity == self.item.entity)
            {
                self.name_field(ui, state, commands);
            } else {
                self.name(ui, state, commands);
            }
            self.marks(ui, commands);
        });
    }

    fn name_field(&self, ui: &mut Ui, state: &mut OutlinerState, commands: &mut Vec<Command>) {
        let Some(renaming) = &mut state.renaming else {
            return;
        };
        let field =
            egui::TextEdit::singleline(&mut renaming.text).desired_width(ui.available_width() - 2.0 * BUTTON - 8.0);
        let response = ui.add(field);
        if std::mem::take(&mut renaming.is_new) {
            response.request_focus();
        } else if response.lost_focus() {
            let is_given_up = ui.input(|input| input.key_pressed(Key::Escape)) || renaming.text.trim().is_empty();
            if !is_given_up {
                let folder = self.item.name.rsplit_once('/').map(|(folder, _)| folder);
                let name = match folder {
                    Some(folder) => format!("{folder}/{}", renaming.text.trim()),
                    None => renaming.text.trim().to_owned(),
                };
                commands.push(Command::Rename(self.item.entity, name));
            }
            state.renaming = None;
        }
    }

    fn name(&self, ui: &mut Ui, state: &mut OutlinerState, commands: &mut Vec<Command>) {
        let (item, selected) = (self.item, self.selection.contains(self.item.entity));
        let kind = egui::RichText::new(item.kind).weak().small();
        let mut text = egui::RichText::new(leaf(&item.name));
        if item.hidden {
            text = text.weak();
        }
        let width = (ui.available_width() - 2.0 * BUTTON - 8.0).max(40.0);
        let line = egui::Button::selectable(selected, text)
            .right_text(kind)
            .truncate()
            .min_size(egui::vec2(width, self.height))
            .sense(Sense::click_and_drag());
        let response = ui.add_sized([width, self.height], line);
        response.widget_info(|| egui::WidgetInfo::selected(egui::WidgetType::Button, true, selected, leaf(&item.name)));
        if response.double_clicked() {
            state.renaming = Some(Renaming::of(item));
        } else if response.clicked() {
            let range = self.range(ui, state);
            match range {
                Some(range) => commands.push(Command::Select(range, Extend::Add)),
                None => {
                    state.anchor = Some(item.entity);
                    commands.push(Command::Select(vec![item.entity], how(ui)));
                }
            }
        }
        if response.drag_started() {
            response.dnd_set_drag_payload(Dragged(self.meant()));
        }
        if let Some(before) = self.dropped_before(ui, &response) {
            commands.push(before);
        }
        response.context_menu(|ui| self.menu(ui, state, commands));
    }

    /// Lines between the anchor and this one, with Shift.
    fn range(&self, ui: &Ui, state: &OutlinerState) -> Option<Vec<Entity>> {
        let anchor = state.anchor.filter(|_| ui.input(|input| input.modifiers.shift))?;
        let items: Vec<Entity> = self
            .lines
            .iter()
            .filter_map(|line| match line {
                Line::Item { item, .. } => Some(item.entity),
                _ => None,
            })
            .collect();
        let place = |wanted: Entity| items.iter().position(|entity| *entity == wanted);
        let (from, to) = (place(anchor)?, place(self.item.entity)?);
        Some(items[from.min(to)..=from.max(to)].to_vec())
    }

    fn dropped_before(&self, ui: &Ui, response: &Response) -> Option<Command> {
        if response.dnd_hover_payload::<Dragged>().is_some() {
            let edge = Rect::from_x_y_ranges(
                response.rect.x_range(),
                response.rect.top() - 1.0..=response.rect.top() + 1.0,
            );
            ui.painter().rect_filled(edge, 0.0, ui.visuals().selection.stroke.color);
        }
        let Dragged(moved) = (*response.dnd_release_payload::<Dragged>()?).clone();
        (!moved.contains(&self.item.entity)).then_some(Command::Reorder {
            moved,
            before: Some(self.item.entity),
        })
    }

    /// The whole selection, if this is of it.
    fn meant(&self) -> Vec<Entity> {
        if self.selection.contains(self.item.entity) {
            self.selection.entities().to_vec()
        } else {
            vec![self.item.entity]
        }
    }

    fn marks(&self, ui: &mut Ui, commands: &mut Vec<Command>) {
        let item = self.item;
        if item.can_hide {
            let help = if item.hidden { "Show" } else { "Hide (H)" };
            let response = mark(ui, help, !item.hidden, eye);
            if response.clicked() {
                commands.push(Command::Hide(self.meant(), !item.hidden));
            }
            let help = if item.locked {
                "Unlock"
            } else {
                "Lock: cannot be picked in the picture, moved or deleted"
            };
            if mark(ui, help, item.locked, padlock).clicked() {
                commands.push(Command::Lock(self.meant(), !item.locked));
            }
        }
    }

    fn menu(&self, ui: &mut Ui, state: &mut OutlinerState, commands: &mut Vec<Command>) {
        let entity = self.item.entity;
        let mut entry = |ui: &mut Ui, name: &str, command: Command| {
            if ui.button(name).clicked() {
                if !self.selection.contains(entity) {
                    commands.push(Command::Select(vec![entity], Extend::Replace));
                }
                commands.push(command);
                ui.close();
            }
        };
        entry(ui, "Frame", Command::FrameSelection);
        entry(ui, "Duplicate", Command::Duplicate);
        entry(ui, "Copy as XML", Command::Copy);
        entry(ui, "Group", Command::Group);
        entry(ui, "Delete", Command::Delete);
        if ui.button("Rename (F2)").clicked() {
            state.renaming = Some(Renaming::of(self.item));
            ui.close();
        }
    }
}

fn mark(ui: &mut Ui, help: &str, is_on: bool, paint: fn(&egui::Painter, Rect, Stroke)) -> Response {
    let (rect, response) = ui.allocate_exact_size(egui::vec2(BUTTON, ui.spacing().interact_size.y), Sense::click());
    let color: Color32 = if is_on || response.hovered() {
        ui.visuals().text_color()
    } else {
        ui.visuals().weak_text_color().gamma_multiply(0.5)
    };
    let face = Rect::from_center_size(rect.center(), egui::vec2(12.0, 12.0));
    paint(ui.painter(), face, Stroke::new(1.2, color));
    response.widget_info(|| egui::WidgetInfo::selected(egui::WidgetType::Button, true, is_on, help));
    response.on_hover_text(help)
}

fn eye(painter: &egui::Painter, face: Rect, stroke: Stroke) {
    let (middle, width) = (face.center(), 0.5 * face.width());
    let lid = |height: f32| -> Vec<egui::Pos2> {
        let points = (0..=8).map(|i| i as f32 / 4.0 - 1.0);
        points
            .map(|x| middle + egui::vec2(x * width, height * (1.0 - x * x)))
            .collect()
    };
    painter.line(lid(4.0), stroke);
    painter.line(lid(-4.0), stroke);
    painter.circle_filled(middle, 2.0, stroke.color);
}

fn padlock(painter: &egui::Painter, face: Rect, stroke: Stroke) {
    let body = Rect::from_min_max(
        face.left_center() + egui::vec2(1.5, -0.5),
        face.right_bottom() + egui::vec2(-1.5, 0.0),
    );
    painter.rect_filled(body, 1.0, stroke.color);
    let top = face.top() + 3.5;
    let bow = [
        (-3.0, 0.0),
        (-3.0, -1.5),
        (-1.5, -3.2),
        (1.5, -3.2),
        (3.0, -1.5),
        (3.0, 0.0),
    ];
    let bow = bow
        .iter()
        .map(|&(x, y)| egui::pos2(face.center().x + x, top + 2.0 + y))
        .collect();
    painter.line(bow, stroke);
}

/// The lines in order. While something is looked for nothing is closed.
fn lines<'a>(outline: &'a Outline, state: &OutlinerState) -> Vec<Line<'a>> {
    let wanted = state.filter.trim().to_lowercase();
    let is_open = |key: &str| !wanted.is_empty() || !state.closed.contains(key);
    let mut lines = Vec::new();
    for (name, items) in outline.groups() {
        let matches = |item: &&Item| {
            wanted.is_empty() || item.name.to_lowercase().contains(&wanted) || item.kind.contains(&wanted)
        };
        let found: Vec<&Item> = items.iter().filter(matches).collect();
        if found.is_empty() {
            continue;
        }
        let count = found.len();
        lines.push(Line::Heading { name, count });
        if is_open(name) {
            folder_lines("", &found, &is_open, &mut lines);
        }
    }
    lines
}

/// What lies in the folder of this path (empty: in none): its folders where their first member stands, and things.
fn folder_lines<'a>(path: &str, items: &[&'a Item], is_open: &dyn Fn(&str) -> bool, lines: &mut Vec<Line<'a>>) {
    let mut shown = BTreeSet::new();
    let depth = if path.is_empty() {
        0
    } else {
        path.matches('/').count() + 1
    };
    for item in items {
        let name = item.name.trim_start_matches('/');
        let rest = name.get(path.len()..).unwrap_or_default();
        let rest = rest.strip_prefix('/').unwrap_or(rest);
        let Some((inner, _)) = rest.split_once('/') else {
            lines.push(Line::Item { item, depth });
            continue;
        };
        if !shown.insert(inner) {
            continue;
        }
        let inner = if path.is_empty() {
            inner.to_owned()
        } else {
            format!("{path}/{inner}")
        };
        let is_inside = |item: &&&Item| {
            let name = item.name.trim_start_matches('/');
            name.strip_prefix(inner.as_str())
                .is_some_and(|rest| rest.starts_with('/'))
        };
        let members: Vec<&Item> = items.iter().filter(is_inside).copied().collect();
        lines.push(Line::Folder {
            path: inner.clone(),
            members: members.clone(),
        });
        if is_open(&inner) {
            folder_lines(&inner, &members, is_open, lines);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn item(number: u32, name: &str) -> Item {
        Item {
            entity: Entity::from_raw_u32(number).expect("a small number"),
            name: name.to_owned(),
            kind: "cube",
            hidden: false,
            locked: false,
            can_hide: true,
        }
    }

    fn text(lines: &[Line]) -> Vec<String> {
        let text = |line: &Line| match line {
            Line::Heading { name, count } => format!("{name} {count}"),
            Line::Folder { path, members } => format!("[{path} {}]", members.len()),
            Line::Item { item, depth } => format!("{depth} {}", leaf(&item.name)),
        };
        lines.iter().map(text).collect()
    }

    #[test]
    fn folders_are_where_their_first_member_stands() {
        let outline = Outline {
            shapes: vec![
                item(1, "floor"),
                item(2, "table/leg"),
                item(3, "lamp"),
                item(4, "table/top/plate"),
            ],
            ..Outline::default()
        };
        let mut state = OutlinerState::default();
        let all = [
            "Shapes 4",
            "0 floor",
            "[table 2]",
            "1 leg",
            "[table/top 1]",
            "2 plate",
            "0 lamp",
        ];
        assert_eq!(text(&lines(&outline, &state)), all);
        state.closed.insert("table".to_owned());
        assert_eq!(
            text(&lines(&outline, &state)),
            ["Shapes 4", "0 floor", "[table 2]", "0 lamp"]
        );
        state.filter = "plate".to_owned();
        assert_eq!(
            text(&lines(&outline, &state)),
            ["Shapes 1", "[table 1]", "[table/top 1]", "2 plate"]
        );
    }
}
