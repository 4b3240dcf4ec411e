//! The arrangement of the window: menus above, lists left and right, the status line below, the picture in between.

use bevy::ecs::entity::EntityHashSet;
use bevy::input::mouse::AccumulatedMouseMotion;
use bevy::prelude::*;
use bevy_egui::{EguiClipboard, EguiContexts, egui};

use super::actions::ActionContext;
use super::captions::captions;
use super::command::Command;
use super::commands::camera_pose;
use super::compare::CompareView;
use super::dialogs::Dialogs;
use super::display;
use super::docking::{Panels, docked_panels};
use super::dropping::{self, DroppedFiles};
use super::gather::EditorModel;
use super::gizmo::Target;
use super::gizmo::interaction::GizmoModel;
use super::guard::{Guard, Unsaved};
use super::icons::{Icon, IconKind};
use super::keys::{KeyEvents, Press};
use super::layout::Layout;
use super::outline::SelectionOutline;
use super::overlay::{self, BoxList, BvhOverlay};
use super::panels::menu_bar::{MenuState, menu_bar};
use super::panels::status;
use super::panels::transform::Freedom;
use super::paths::PathInspector;
use super::picking;
use super::picture::Picture;
use super::preferences::{Preferences, PreferencesFile};
use super::recovery::Recovery;
use super::recovery_question;
use super::save_question;
use super::selection::Selection;
use super::sheet::{self, SheetModel};
use super::state::{CommandQueue, EditorState};
use super::trust::TrustedFolders;
use super::trust_question;
use super::viewport::{PICTURE, ViewportModel, viewport};
use crate::accel::Tlas;
use crate::engine::{CurrentScene, RenderFilm};
use crate::math::Aabb;
use crate::scene::{
    ActiveSensor, Emitter, EmitterKind, Film, FreeView, Hidden, Locked, MemberOf, Placements, SceneState, SceneStatus,
    Sensor, Shape, ToWorld, world_bounds,
};

/// The boxes as they were last collected.
#[derive(Default)]
pub struct CollectedBoxes {
    from: Option<(std::sync::Arc<Tlas>, BvhOverlay)>,
    list: BoxList,
}

/// World bounds of the selected things as they were last found.
#[derive(Default)]
pub struct SelectionBounds {
    of: Option<(Selection, std::sync::Arc<Tlas>)>,
    bounds: Vec<Option<Aabb>>,
}

impl SelectionBounds {
    fn update(&mut self, current: &CurrentScene, selection: &Selection) {
        let Some(scene) = &current.scene else {
            *self = Self::default();
            return;
        };
        let is_same =
            |(of, geometry): &(Selection, _)| of == selection && std::sync::Arc::ptr_eq(geometry, &scene.geometry);
        if !self.of.as_ref().is_some_and(is_same) {
            self.bounds = picking::bounds_of_each(current, selection.entities());
            self.of = Some((selection.clone(), scene.geometry.clone()));
        }
    }
}

/// What is seen of the scene over the picture, kept from frame to frame.
#[derive(Default)]
pub struct Seen {
    boxes: CollectedBoxes,
    bounds: SelectionBounds,
    outline: SelectionOutline,
    locked: EntityHashSet,
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
    film: Res<'w, RenderFilm>,
    paths: Res<'w, PathInspector>,
    movable: Query<'w, 's, Movable, (Without<Locked>, Without<Placements>, Without<MemberOf>)>,
    emitters: Query<'w, 's, (Entity, &'static Emitter, &'static ToWorld), Without<Hidden>>,
    sensors: Query<'w, 's, (Entity, &'static ToWorld), With<Sensor>>,
    films: Query<'w, 's, &'static Film>,
    locked: Query<'w, 's, Entity, With<Locked>>,
    newly_locked: Query<'w, 's, (), Added<Locked>>,
    unlocked: RemovedComponents<'w, 's, Locked>,
}

type Movable = (
    &'static ToWorld,
    Option<&'static Shape>,
    Option<&'static Emitter>,
    Has<Sensor>,
);

impl Scene<'_, '_> {
    /// The selected things that can be moved, with their bounds.
    fn targets(&self, bounds: &[Option<Aabb>]) -> Vec<Target> {
        let places = self
            .selection
            .entities()
            .iter()
            .zip(bounds.iter().chain(std::iter::repeat(&None)));
        let targets = places.filter_map(|(&entity, &bounds)| {
            let (to_world, shape, emitter, is_sensor) = self.movable.get(entity).ok()?;
            let freedom = match emitter {
                _ if shape.is_some() => Freedom::Affine,
                Some(emitter) if emitter.is_environment() => Freedom::Turning,
                Some(emitter) if matches!(emitter.kind, EmitterKind::Constant { .. }) => return None,
                Some(_) => Freedom::Rigid,
                None if is_sensor => Freedom::Rigid,
                None => return None,
            };
            Some(Target {
                entity,
                to_world: to_world.0,
                freedom,
                // What is hidden is not in the picture.
                bounds: bounds.or_else(|| world_bounds(shape?, &to_world.0, None)),
            })
        });
        targets.collect()
    }

    /// Of the lights that have a place, and of the cameras but the one that is looked through.
    fn icons(&self) -> Vec<Icon> {
        let lights = self.emitters.iter().filter_map(|(entity, emitter, to_world)| {
            let kind = IconKind::of(emitter)?;
            Some(Icon {
                entity,
                kind,
                pose: to_world.0,
            })
        });
        let looked_through = self.active.0.filter(|_| self.free_view.pose.is_none());
        let others = self
            .sensors
            .iter()
            .filter(|(entity, _)| Some(*entity) != looked_through);
        let cameras = others.map(|(entity, to_world)| Icon {
            entity,
            kind: IconKind::Frustum,
            pose: to_world.0,
        });
        lights.chain(cameras).collect()
    }
}

/// What belongs to the window more than to the scene.
#[derive(bevy::ecs::system::SystemParam)]
pub struct Shell<'w, 's> {
    layout: ResMut<'w, Layout>,
    preferences: Res<'w, Preferences>,
    preferences_file: Res<'w, PreferencesFile>,
    recovery: ResMut<'w, Recovery>,
    trusted: ResMut<'w, TrustedFolders>,
    dropped: ResMut<'w, DroppedFiles>,
    clipboard: ResMut<'w, EguiClipboard>,
    mouse: Res<'w, AccumulatedMouseMotion>,
    guard: Local<'s, Guard>,
}

pub fn show_window(
    mut contexts: EguiContexts,
    model: Res<EditorModel>,
    mut state: ResMut<EditorState>,
    mut queue: ResMut<CommandQueue>,
    mut dialogs: ResMut<Dialogs>,
    mut shell: Shell,
    mut scene: Scene,
    mut keys: KeyEvents,
    mut focus: Local<Option<egui::Id>>,
    mut is_typing: Local<bool>,
    mut seen: Local<Seen>,
) -> Result {
    let presses = keys.presses();
    count_interactions(contexts.ctx_mut()?, &presses, &mut state, &mut focus);
    let context = contexts.ctx_mut()?.clone();
    // A field that is left and a list that closes in this frame still had its keys.
    let presses = match *is_typing || egui::Popup::is_any_open(&context) {
        true => Vec::new(),
        false => presses,
    };
    let builder = egui::UiBuilder::new()
        .layer_id(egui::LayerId::background())
        .max_rect(context.viewport_rect());
    let mut ui = egui::Ui::new(context.clone(), "window".into(), builder);
    let (state, commands, model) = (&mut *state, &mut Vec::new(), &model.0);
    // Panels that are shown say it anew.
    state.outliner.materials_in_sight.clear();
    state.shelf.in_sight.clear();
    let layout = &mut *shell.layout;
    // A question or a sheet that closes in this frame still had its keys.
    let is_free = state.dialog.is_none()
        && state.save_question.is_none()
        && state.sheet.is_none()
        && shell.recovery.offer.is_none()
        && shell.trusted.question.is_none()
        && !shell.guard.is_asking();
    let action_context = ActionContext {
        display: state.display,
        overlay: state.overlay,
        gizmo: state.gizmo,
        paused: model.status.paused,
        panels_shown: state.panels_shown,
        selection: &scene.selection,
        tool: state.tool,
        safe_frame: state.safe_frame,
        flying: false,
    };
    let menus = MenuState {
        context: action_context,
        camera: scene.active.0,
        layout,
        recent: &shell.preferences.recent_files,
    };
    egui::Panel::top("menus").show(&mut ui, |ui| menu_bar(ui, model, menus, commands));
    egui::Panel::bottom("status").show(&mut ui, |ui| status::status_line(ui, &model.status));
    let Seen {
        boxes,
        bounds,
        outline,
        locked,
    } = &mut *seen;
    if scene.unlocked.read().count() > 0 || !scene.newly_locked.is_empty() {
        *locked = scene.locked.iter().collect();
    }
    collect_boxes(&scene.current, &state.overlay, boxes);
    bounds.update(&scene.current, &scene.selection);
    let hovered = state.viewport.pointer.hovered;
    outline.update(
        &scene.film,
        &scene.current,
        &scene.selection,
        hovered,
        (scene.picture.revision, &scene.picture.changed),
    );
    let (targets, icons) = (scene.targets(&bounds.bounds), scene.icons());
    let placeholder = placeholder(&scene.status);
    let legend = display::legend(state.display.mode, scene.picture.scales());
    let compared = &model.render.comparison;
    let compared = compared.snapshot.map_or(CompareView::Off, |_| compared.view);
    let is_split = model.render.strategy_split && state.display.mode.is_light();
    let captions = captions(is_split, compared);
    let picture = scene.picture.texture();
    // Whatever resolution is rendered, the picture stays where it is.
    let film = scene.active.0.and_then(|sensor| scene.films.get(sensor).ok());
    let proportions = film.map(Film::window).map(|window| [window.width, window.height]);
    let proportions = proportions.or(picture.map(|(_, size)| size)).unwrap_or([1, 1]);
    let shown = ViewportModel {
        picture,
        proportions,
        placeholder: &placeholder,
        pose: camera_pose(&scene.active, &scene.free_view, &scene.poses),
        camera: scene.current.view.as_ref().map(|view| view.camera),
        boxes: &boxes.list,
        outline,
        icons: &icons,
        gizmo: GizmoModel {
            settings: state.gizmo,
            targets: &targets,
            length_step: state.gizmo.steps.length_in(state.navigation.scene_size),
            up: state.navigation.up,
            current: &scene.current,
        },
        locked,
        things: &model.outline,
        current: &scene.current,
        legend: legend.as_ref(),
        captions: &captions,
        region: model.render.region,
        paths: &scene.paths,
        navigation: state.navigation,
        keys: action_context,
        mouse: egui::vec2(shell.mouse.delta.x, shell.mouse.delta.y),
        presses: &presses,
        enabled: is_free,
    };
    if let Some(panel) = state.wanted_panel.take() {
        layout.bring_to_front(panel);
    }
    egui::CentralPanel::no_frame().show(&mut ui, |ui| {
        if state.panels_shown {
            docked_panels(ui, layout, Panels::new(model, &shown, state, commands));
        } else {
            state.viewport_place = ui.max_rect();
            viewport(ui, &shown, &mut state.viewport, commands);
        }
    });
    if state.viewport.gizmo.take_begun() {
        state.interaction += 1;
    }
    use_clipboard(&context, &presses, &mut shell.clipboard, commands);
    dialogs.show(&context, scene.status.path.as_deref(), state, commands);
    let sheets = SheetModel {
        actions: action_context,
        preferences: &shell.preferences,
        problem: shell.preferences_file.problem.as_deref(),
    };
    sheet::show(&context, model, sheets, state, commands);
    recovery_question::question(&context, &mut shell.recovery.offer, commands);
    save_question::show(&context, state, commands);
    // One question at a time.
    if shell.recovery.offer.is_none() {
        trust_question::question(&context, &mut shell.trusted.question, commands);
    }
    if shell.dropped.hovering > 0 {
        dropping::hint(&context, state.viewport_place);
    }
    let is_untouched = model.status.scene.is_none() && !model.status.unsaved;
    commands.extend(shell.dropped.commands(is_untouched));
    commands.extend(shell.trusted.opens.take().map(Command::OpenScene));
    if std::mem::take(&mut state.closes) {
        commands.push(Command::Quit);
    }
    let file = model.status.scene.as_deref().and_then(std::path::Path::file_name);
    let unsaved = Unsaved {
        name: &file.map_or("the scene".into(), |name| name.to_string_lossy()),
        edits: model.status.unsaved,
        dialog_open: state.dialog.is_some() || state.save_question.is_some(),
    };
    shell.guard.hold(commands, unsaved.edits);
    shell.guard.show(&context, unsaved, commands);
    state.toasts.show(&context, state.viewport_place, commands);
    queue.0.append(commands);
    *is_typing = context
        .memory(|memory| memory.focused())
        .is_some_and(|focused| focused != egui::Id::new(PICTURE));
    Ok(())
}

/// Copies, cuts and pastes things while nothing is being typed. By the presses, not by egui's events: those do without a modifier that was
/// let go of within a slow frame.
fn use_clipboard(
    context: &egui::Context,
    presses: &[Press],
    clipboard: &mut EguiClipboard,
    commands: &mut Vec<Command>,
) {
    if context.memory(|memory| memory.focused()) != Some(egui::Id::new(PICTURE)) {
        return;
    }
    for press in presses.iter().filter(|press| press.modifiers.command_only()) {
        match press.key {
            egui::Key::C => commands.push(Command::Copy),
            egui::Key::X => commands.push(Command::Cut),
            egui::Key::V => commands.extend(clipboard.get_text().map(Command::Paste)),
            _ => {}
        }
    }
}

/// A press of the mouse, a key without a text field, and another field are the beginning of something new.
fn count_interactions(
    context: &egui::Context,
    presses: &[Press],
    state: &mut EditorState,
    focus: &mut Option<egui::Id>,
) {
    let focused = context.memory(|memory| memory.focused());
    let is_typing = focused.is_some_and(|focused| focused != egui::Id::new(PICTURE));
    let key = !presses.is_empty() && !is_typing && !state.viewport.gizmo.is_dragging();
    // What is pressed in the middle of a drag belongs to it.
    let button = !state.viewport.gizmo.is_dragging() && context.input(|input| input.pointer.any_pressed());
    let pressed = key || button;
    if pressed || focused != *focus {
        *focus = focused;
        state.interaction += 1;
    }
    if let Some(text) = state.clipboard.take() {
        context.copy_text(text);
    }
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
    let file = status.subject().map_or(String::new(), |path| {
        path.file_name().unwrap_or_default().to_string_lossy().into_owned()
    });
    match status.state {
        SceneState::Empty => "Open a scene with File, Open (Ctrl+O)".to_owned(),
        SceneState::Loading => format!("Loading {file}"),
        SceneState::Ready => format!("Preparing {file}"),
        SceneState::Failed => format!("{file} could not be read; see Messages at the right"),
    }
}
