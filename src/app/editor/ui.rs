//! The arrangement of the window: menus above, lists left and right, the status line below, the picture in between.

use bevy::prelude::*;
use bevy_egui::{EguiContexts, egui};

use super::actions::ActionContext;
use super::command::{Command, FileDialogKind};
use super::commands::camera_pose;
use super::dialogs::Dialogs;
use super::gather::EditorModel;
use super::keys::KeyEvents;
use super::model::Model;
use super::overlay::{self, BoxList, BvhOverlay, WorldBox};
use super::panels::menu_bar::{MenuState, menu_bar};
use super::panels::{diagnostics, inspector, outliner, render, status};
use super::picking;
use super::picture::Picture;
use super::selection::Selection;
use super::state::{CommandQueue, EditorState, RightTab};
use super::viewport::{ViewportModel, viewport};
use crate::accel::Tlas;
use crate::engine::CurrentScene;
use crate::scene::{ActiveSensor, FreeView, SceneState, SceneStatus, ToWorld};

const LEFT_WIDTH: f32 = 216.0;
const RIGHT_WIDTH: f32 = 300.0;

/// The boxes as they were last collected.
#[derive(Default)]
pub struct CollectedBoxes {
    from: Option<(std::sync::Arc<Tlas>, BvhOverlay)>,
    list: BoxList,
}

/// The selection's box as it was last found.
#[derive(Default)]
pub struct SelectionBox {
    of: Option<(Entity, std::sync::Arc<Tlas>)>,
    shown: Option<WorldBox>,
}

impl SelectionBox {
    fn update(&mut self, current: &CurrentScene, selection: Option<Entity>) -> Option<WorldBox> {
        let (Some(scene), Some(selection)) = (&current.scene, selection) else {
            *self = Self::default();
            return None;
        };
        let is_same = |(entity, geometry): &(Entity, _)| {
            *entity == selection && std::sync::Arc::ptr_eq(geometry, &scene.geometry)
        };
        if !self.of.as_ref().is_some_and(is_same) {
            self.shown = picking::bounds_of(current, selection).map(|bounds| WorldBox::of(&bounds));
            self.of = Some((selection, scene.geometry.clone()));
        }
        self.shown
    }
}

#[derive(bevy::ecs::system::SystemParam)]
pub struct Scene<'w, 's> {
    current: Res<'w, CurrentScene>,
    selection: Res<'w, Selection>,
    status: Res<'w, SceneStatus>,
    active: Res<'w, ActiveSensor>,
    free_view: Res<'w, FreeView>,
    poses: Query<'w, 's, &'static ToWorld>,
    picture: Res<'w, Picture>,
}

pub fn show_window(
    mut contexts: EguiContexts,
    model: Res<EditorModel>,
    mut state: ResMut<EditorState>,
    mut queue: ResMut<CommandQueue>,
    mut dialogs: ResMut<Dialogs>,
    scene: Scene,
    mut keys: KeyEvents,
    mut focus: Local<Option<egui::Id>>,
    mut boxes: Local<CollectedBoxes>,
    mut selection_box: Local<SelectionBox>,
) -> Result {
    let presses = keys.presses();
    count_interactions(contexts.ctx_mut()?, &mut state, &mut focus);
    let context = contexts.ctx_mut()?.clone();
    let builder = egui::UiBuilder::new()
        .layer_id(egui::LayerId::background())
        .max_rect(context.viewport_rect());
    let mut ui = egui::Ui::new(context.clone(), "window".into(), builder);
    let (state, commands, model) = (&mut *state, &mut queue.0, &model.0);
    let action_context = ActionContext {
        display: state.display,
        overlay: state.overlay,
        paused: model.status.paused,
        panels_shown: state.panels_shown,
        selection: &scene.selection,
        flying: false,
    };
    let menus = MenuState {
        context: action_context,
        camera: scene.active.0,
    };
    egui::Panel::top("menus").show(&mut ui, |ui| menu_bar(ui, model, menus, commands));
    egui::Panel::bottom("status").show(&mut ui, |ui| status::status_line(ui, &model.status, state.message()));
    if state.panels_shown {
        left_panel(&mut ui, model, state, commands);
        right_panel(&mut ui, model, state, commands);
    }
    collect_boxes(&scene.current, &state.overlay, &mut boxes);
    let placeholder = placeholder(&scene.status);
    let shown = ViewportModel {
        picture: scene.picture.texture(),
        placeholder: &placeholder,
        pose: camera_pose(&scene.active, &scene.free_view, &scene.poses),
        camera: scene.current.view.as_ref().map(|view| view.camera),
        boxes: &boxes.list,
        selection_box: selection_box.update(&scene.current, scene.selection.active()),
        navigation: state.navigation,
        keys: action_context,
        presses: &presses,
        enabled: state.dialog.is_none(),
    };
    egui::CentralPanel::no_frame().show(&mut ui, |ui| viewport(ui, &shown, &mut state.viewport, commands));
    dialogs.show(&context, scene.status.path.as_deref(), state, commands);
    Ok(())
}

/// A press of the mouse, a key without a text field, and another field are the beginning of something new.
fn count_interactions(context: &egui::Context, state: &mut EditorState, focus: &mut Option<egui::Id>) {
    let focused = context.memory(|memory| memory.focused());
    let pressed = context.input(|input| input.pointer.any_pressed());
    if pressed || focused != *focus {
        *focus = focused;
        state.interaction += 1;
    }
    if let Some(text) = state.clipboard.take() {
        context.copy_text(text);
    }
}

fn left_panel(ui: &mut egui::Ui, model: &Model, state: &mut EditorState, commands: &mut Vec<Command>) {
    egui::Panel::left("outliner")
        .default_size(LEFT_WIDTH)
        .size_range(140.0..=400.0)
        .show(ui, |ui| {
            ui.add_space(4.0);
            outliner::outliner(ui, &model.outline, &model.selection, &mut state.outliner, commands);
        });
}

fn right_panel(ui: &mut egui::Ui, model: &Model, state: &mut EditorState, commands: &mut Vec<Command>) {
    egui::Panel::right("properties")
        .default_size(RIGHT_WIDTH)
        .size_range(260.0..=460.0)
        .show(ui, |ui| {
            ui.add_space(4.0);
            ui.horizontal(|ui| {
                ui.selectable_value(&mut state.right_tab, RightTab::Inspector, "Inspector");
                ui.selectable_value(&mut state.right_tab, RightTab::Render, "Render");
                let errors = model.notices.iter().filter(|notice| notice.is_error).count();
                let title = match (errors, model.notices.len()) {
                    (0, 0) => egui::RichText::new("Messages"),
                    (0, warnings) => egui::RichText::new(format!("Messages ({warnings})")),
                    (_, all) => {
                        let title = egui::RichText::new(format!("Messages ({all})"));
                        let is_shown = state.right_tab == RightTab::Diagnostics;
                        if is_shown {
                            title
                        } else {
                            title.color(ui.visuals().error_fg_color)
                        }
                    }
                };
                ui.selectable_value(&mut state.right_tab, RightTab::Diagnostics, title);
            });
            ui.separator();
            egui::ScrollArea::vertical()
                .auto_shrink(false)
                .show(ui, |ui| match state.right_tab {
                    RightTab::Inspector => {
                        inspector::inspector(ui, model, state.navigation.scene_size, &mut state.inspector, commands)
                    }
                    RightTab::Render => render::render(ui, &model.render, state.display, state.overlay, commands),
                    RightTab::Diagnostics => diagnostics::diagnostics(ui, &model.notices),
                });
        });
}

fn collect_boxes(current: &CurrentScene, overlay: &BvhOverlay, boxes: &mut CollectedBoxes) {
    let Some(scene) = current.scene.as_ref().filter(|_| overlay.shown) else {
        *boxes = CollectedBoxes::default();
        return;
    };
    let is_same = boxes
        .from
        .as_ref()
        .is_some_and(|(geometry, from)| std::sync::Arc::ptr_eq(geometry, &scene.geometry) && from == overlay);
    if !is_same {
        boxes.list = overlay::boxes(&scene.geometry, overlay);
        boxes.from = Some((scene.geometry.clone(), *overlay));
    }
}

fn placeholder(status: &SceneStatus) -> String {
    let file = status.path.as_ref().map_or(String::new(), |path| {
        path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    });
    match status.state {
        SceneState::Empty => "Open a scene with File, Open (Ctrl+O)".to_owned(),
        SceneState::Loading => format!("Loading {file}"),
        SceneState::Ready => format!("Preparing {file}"),
        SceneState::Failed => format!("{file} could not be read; see Messages at the right"),
    }
}

/// What a finished dialog asks for.
pub fn picked(kind: FileDialogKind, path: std::path::PathBuf) -> Command {
    match kind {
        FileDialogKind::OpenScene => Command::OpenScene(path),
        FileDialogKind::SaveScene => Command::SaveScene(path),
        FileDialogKind::SaveImage => Command::SaveImage(path),
        FileDialogKind::Import => Command::Import(path),
        FileDialogKind::OpenPicture {
            owner,
            parameter,
            place,
        } => Command::SetPicture {
            owner,
            parameter,
            place,
            path,
        },
    }
}
