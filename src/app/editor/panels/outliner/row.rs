//! The line of one thing.

use bevy::prelude::Entity;
use bevy_egui::egui::{self, Key, Rect, Response, RichText, Sense, Ui, WidgetText, pos2, vec2};

use super::lines::{LineList, leaf};
use super::marks::{BUTTON, eye, mark, padlock};
use super::state::{OutlinerState, Renaming, how};
use crate::app::editor::command::dragged::Dragged;
use crate::app::editor::command::selection::{Alike, Extend};
use crate::app::editor::command::{Command, OutlineEdit, SceneEdit, SelectionCommand, ViewCommand};
use crate::app::editor::model::panel_textures::Ball;
use crate::app::editor::model::{Item, Model};
use crate::app::editor::panels::drag_start::is_drag_of;
use crate::app::editor::panels::kind_icons;
use crate::app::editor::panels::medium_section::fill_menu;

/// Width of the drawing of a thing's kind, and the edge of a material's ball, in points.
const KIND: f32 = 18.0;
const BALL: f32 = 16.0;

/// The indentation in points of a line at a depth.
pub(super) fn indent(depth: usize) -> f32 {
    8.0 + 12.0 * depth as f32
}

/// A button whose text begins at its left, with another text at its right if there is room for both.
pub(super) fn left_aligned(
    ui: &mut Ui,
    text: RichText,
    right: Option<RichText>,
    selected: bool,
    width: f32,
    height: f32,
) -> Response {
    let measured = |text: &RichText| {
        let text = WidgetText::from(text.clone());
        let galley = text.into_galley(
            ui,
            Some(egui::TextWrapMode::Extend),
            f32::INFINITY,
            egui::TextStyle::Button,
        );
        galley.size().x
    };
    let padding = 2.0 * ui.spacing().button_padding.x + 8.0;
    let right = right.filter(|right| measured(&text) + measured(right) + padding <= width);
    let label = text.text().to_owned();
    // A text at the right pushes the other one to the left.
    let right = right.unwrap_or_default();
    let button = egui::Button::selectable(selected, text)
        .right_text(right)
        .truncate()
        .sense(Sense::click_and_drag());
    let response = ui.add_sized([width, height], button);
    response.widget_info(|| egui::WidgetInfo::selected(egui::WidgetType::Button, true, selected, &label));
    response
}

/// Shows the field for a new name. Returns None while it is typed; then the name, or None in it if the name is
/// unchanged.
pub(super) fn renamed(ui: &mut Ui, renaming: &mut Renaming, width: f32) -> Option<Option<String>> {
    let mut output = egui::TextEdit::singleline(&mut renaming.text)
        .desired_width(width)
        .show(ui);
    if std::mem::take(&mut renaming.is_new) {
        output.response.request_focus();
        // The typed text replaces the old name.
        let all = egui::text::CCursorRange::select_all(&output.galley);
        output.state.cursor.set_char_range(Some(all));
        output.state.store(ui.ctx(), output.response.id);
        return None;
    }
    let typed = renaming.text.trim();
    let is_given_up = ui.input(|input| input.key_pressed(Key::Escape)) || typed.is_empty();
    output
        .response
        .lost_focus()
        .then(|| (!is_given_up).then(|| typed.to_owned()))
}

/// One thing's line.
pub(super) struct Row<'a> {
    pub item: &'a Item,
    pub depth: usize,
    pub has_inside: bool,
    pub is_material: bool,
    /// All visible lines, for ranges.
    pub lines: &'a LineList,
    pub model: &'a Model,
    pub height: f32,
}

impl Row<'_> {
    pub fn show(&self, ui: &mut Ui, state: &mut OutlinerState, commands: &mut Vec<Command>) {
        ui.horizontal(|ui| {
            ui.add_space(indent(self.depth));
            if self.has_inside {
                state.folding.triangle_of_material(ui, self.item.entity);
            } else {
                ui.add_space(14.0 + ui.spacing().item_spacing.x);
            }
            self.kind(ui, state);
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

    fn kind(&self, ui: &mut Ui, state: &mut OutlinerState) {
        let (rect, response) = ui.allocate_exact_size(vec2(KIND, self.height), Sense::hover());
        if self.is_material {
            state.materials_in_sight.push(self.item.entity);
            let face = Rect::from_center_size(rect.center(), vec2(BALL, BALL));
            self.model
                .textures
                .paint_ball(ui, Ball::Material(self.item.entity), face);
        } else {
            let color = ui.visuals().weak_text_color();
            kind_icons::paint(ui.painter(), rect.center(), self.item.kind, color);
        }
        response.on_hover_text(self.item.kind);
    }

    fn name_field(&self, ui: &mut Ui, state: &mut OutlinerState, commands: &mut Vec<Command>) {
        let Some(renaming) = &mut state.renaming else {
            return;
        };
        let width = ui.available_width() - self.marks_width();
        let Some(typed) = renamed(ui, renaming, width) else {
            return;
        };
        state.renaming = None;
        if let Some(name) = typed {
            let folder = self.item.name.rsplit_once('/').map(|(folder, _)| folder);
            let name = folder.map_or(name.clone(), |folder| format!("{folder}/{name}"));
            commands.push(OutlineEdit::Rename(self.item.entity, name).into());
        }
    }

    fn marks_width(&self) -> f32 {
        match self.item.can_hide {
            true => 2.0 * BUTTON + 8.0,
            false => 4.0,
        }
    }

    fn name(&self, ui: &mut Ui, state: &mut OutlinerState, commands: &mut Vec<Command>) {
        let item = self.item;
        let selected = self.model.selection.contains(item.entity);
        // In a list of a hundred spheres the material is more informative than the kind, which the icon shows.
        let hint = self.model.outline.material_of(item).map_or(item.kind, leaf);
        let kind = RichText::new(hint).weak().small();
        // A shape that shines is listed among the lights without its folder.
        let name = if self.depth == 0 { &item.name } else { leaf(&item.name) };
        let mut text = RichText::new(name);
        if item.hidden {
            text = text.weak();
        }
        let width = (ui.available_width() - self.marks_width()).max(40.0);
        let response = left_aligned(ui, text, Some(kind), selected, width, self.height);
        if response.double_clicked() {
            state.renaming = Some(Renaming::of(item));
        } else if response.clicked() {
            let range = self.range(ui, state);
            match range {
                Some(range) => commands.push(SelectionCommand::Select(range, Extend::Add).into()),
                None => {
                    state.anchor = Some(item.entity);
                    commands.push(SelectionCommand::Select(vec![item.entity], how(ui)).into());
                }
            }
        }
        if is_drag_of(ui, &response) {
            egui::DragAndDrop::set_payload(ui.ctx(), Dragged(self.meant()));
        }
        if let Some(before) = self.dropped_before(ui, &response) {
            commands.push(before);
        }
        response.context_menu(|ui| self.menu(ui, state, commands));
    }

    /// The range of lines between the anchor and this one, with Shift.
    fn range(&self, ui: &Ui, state: &OutlinerState) -> Option<Vec<Entity>> {
        let anchor = state.anchor.filter(|_| ui.input(|input| input.modifiers.shift))?;
        let items: Vec<Entity> = self.lines.things(&self.model.outline).collect();
        let place = |wanted: Entity| items.iter().position(|entity| *entity == wanted);
        let (from, to) = (place(anchor)?, place(self.item.entity)?);
        Some(items[from.min(to)..=from.max(to)].to_vec())
    }

    fn dropped_before(&self, ui: &Ui, response: &Response) -> Option<Command> {
        if response.dnd_hover_payload::<Dragged>().is_some() {
            let rect = response.rect;
            let edge = Rect::from_min_max(rect.left_top() - vec2(0.0, 1.0), pos2(rect.right(), rect.top() + 1.0));
            ui.painter().rect_filled(edge, 0.0, ui.visuals().selection.stroke.color);
        }
        let Dragged(moved) = (*response.dnd_release_payload::<Dragged>()?).clone();
        (!moved.contains(&self.item.entity)).then_some(Command::from(OutlineEdit::Reorder {
            moved,
            before: Some(self.item.entity),
        }))
    }

    /// The whole selection if this thing is selected, else the thing alone.
    fn meant(&self) -> Vec<Entity> {
        let selection = &self.model.selection;
        if selection.contains(self.item.entity) {
            selection.entities().to_vec()
        } else {
            vec![self.item.entity]
        }
    }

    fn marks(&self, ui: &mut Ui, commands: &mut Vec<Command>) {
        let item = self.item;
        if !item.can_hide {
            return;
        }
        let help = if item.hidden { "Show" } else { "Hide" };
        if mark(ui, help, !item.hidden, eye).clicked() {
            commands.push(OutlineEdit::Hide(self.meant(), !item.hidden).into());
        }
        let help = if item.locked {
            "Unlock"
        } else {
            "Lock: cannot be picked in the picture, moved or deleted"
        };
        if mark(ui, help, item.locked, padlock).clicked() {
            commands.push(OutlineEdit::Lock(self.meant(), !item.locked).into());
        }
    }

    fn menu(&self, ui: &mut Ui, state: &mut OutlinerState, commands: &mut Vec<Command>) {
        let entity = self.item.entity;
        let mut entry = |ui: &mut Ui, name: &str, command: Command| {
            if ui.button(name).clicked() {
                if !self.model.selection.contains(entity) {
                    commands.push(SelectionCommand::Select(vec![entity], Extend::Replace).into());
                }
                commands.push(command);
                ui.close();
            }
        };
        entry(ui, "Frame", ViewCommand::FrameSelection.into());
        entry(ui, "Duplicate", SceneEdit::Duplicate.into());
        entry(ui, "Copy as XML", SelectionCommand::Copy.into());
        let alike = |alike| Command::from(SelectionCommand::SelectAlike(alike));
        entry(ui, "Select all of the same material", alike(Alike::Material));
        entry(ui, "Select all of the same type", alike(Alike::Type));
        entry(ui, "Group", OutlineEdit::Group.into());
        entry(ui, "Delete", SceneEdit::Delete.into());
        let meant = self.meant();
        let shapes = self.model.outline.shapes.iter();
        let shapes = shapes.filter(|item| item.kind != "group" && meant.contains(&item.entity));
        let shapes: Vec<Entity> = shapes.map(|item| item.entity).collect();
        if !shapes.is_empty() {
            ui.menu_button("Fill with", |ui| fill_menu(ui, &shapes, self.model, commands));
        }
        if ui.button("Rename (F2)").clicked() {
            state.renaming = Some(Renaming::of(self.item));
            ui.close();
        }
    }
}
