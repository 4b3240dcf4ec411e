//! The arrangement of the window: menus above, lists left and right, the status line below, the picture in between.

use bevy::input::keyboard::KeyboardInput;
use bevy::input::mouse::AccumulatedMouseMotion;
use bevy::prelude::*;
use bevy_egui::{EguiClipboard, EguiContexts, egui};

use super::dialogs::{DialogModel, Dialogs};
use super::docking::{Panels, docked_panels};
use super::dropping::{self, DroppedFiles};
use super::field_keys::{FieldKeys, Keyboard};
use super::guards::Guards;
use super::pointed::pointed_light;
use super::sheet::{self, SheetModel};
use super::widgets::Widgets;
use super::{dialog, full_film, recovery_question, save_question, scene_question, toasts, trust_question, tutorial};
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::command::shell::Sheet;
use crate::app::editor::command::{Command, FileCommand, SceneEdit, SelectionCommand};
use crate::app::editor::input::actions::ActionContext;
use crate::app::editor::input::press::Press;
use crate::app::editor::input::{keys, number_field};
use crate::app::editor::model::{EditorModel, Inspected, Model};
use crate::app::editor::panels::menu_bar::{MenuState, menu_bar};
use crate::app::editor::panels::status;
use crate::app::editor::panels::timeline::timeline;
use crate::app::editor::picture::awaited_image::EndedImage;
use crate::app::editor::picture::depths::Depths;
use crate::app::editor::picture::lamp_light::LampFollower;
use crate::app::editor::picture::paths::PathInspector;
use crate::app::editor::picture::reasons::Reasons;
use crate::app::editor::picture::resolution::PicturePlace;
use crate::app::editor::session::kept_picture::KeptPictures;
use crate::app::editor::session::layout::Layout;
use crate::app::editor::session::preferences::PreferencesFile;
use crate::app::editor::session::recovery::Recovery;
use crate::app::editor::session::requests::{CommandQueue, Requests};
use crate::app::editor::session::toasts::{Toasts, Tone};
use crate::app::editor::session::trust::TrustedFolders;
use crate::app::editor::session::tutorial::Tutorial;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::app::editor::viewport::blocking::hand::{BlockTarget, has_openings};
use crate::app::editor::viewport::gather::ViewportScene;
use crate::app::editor::viewport::gizmo;
use crate::app::editor::viewport::gizmo::interaction::GizmoModel;
use crate::app::editor::viewport::model::{ViewportModel, action_context};
use crate::app::editor::viewport::side_model::SideModel;
use crate::app::editor::viewport::side_scenes::SideScenes;
use crate::app::editor::viewport::state::ViewportState;
use crate::app::editor::viewport::{PICTURE, viewport};
use crate::engine::{PackedScene, RenderFilm};
use crate::scene::{ActiveSensor, Hidden, MemberOf, Placements, SceneState, SceneStatus, Shape, ToWorld};

/// The visible parts of the scene.
#[derive(bevy::ecs::system::SystemParam)]
pub struct Scene<'w, 's> {
    seen: Res<'w, ViewportScene>,
    sides: Res<'w, SideScenes>,
    settings: Res<'w, ViewSettings>,
    packed: Res<'w, PackedScene>,
    film: Res<'w, RenderFilm>,
    selection: Res<'w, Selection>,
    status: Res<'w, SceneStatus>,
    active: Res<'w, ActiveSensor>,
    paths: Res<'w, PathInspector>,
    reasons: Res<'w, Reasons>,
    lamp: Res<'w, LampFollower>,
    tutorial: Res<'w, Tutorial>,
    shapes:
        Query<'w, 's, (&'static Shape, &'static ToWorld), (Without<Hidden>, Without<Placements>, Without<MemberOf>)>,
}

/// Messages to the user, and commands of the user.
#[derive(bevy::ecs::system::SystemParam)]
pub struct Said<'w> {
    queue: ResMut<'w, CommandQueue>,
    requests: ResMut<'w, Requests>,
    toasts: ResMut<'w, Toasts>,
}

/// The state of the window rather than of the scene.
#[derive(bevy::ecs::system::SystemParam)]
pub struct Shell<'w, 's> {
    layout: ResMut<'w, Layout>,
    preferences: Res<'w, Preferences>,
    preferences_file: Res<'w, PreferencesFile>,
    recovery: ResMut<'w, Recovery>,
    trusted: ResMut<'w, TrustedFolders>,
    place: ResMut<'w, PicturePlace>,
    dropped: ResMut<'w, DroppedFiles>,
    clipboard: ResMut<'w, EguiClipboard>,
    mouse: Res<'w, AccumulatedMouseMotion>,
    guards: Local<'s, Guards>,
    kept_pictures: Res<'w, KeptPictures>,
    ended_image: Option<Res<'w, EndedImage>>,
}

/// The keys, and the owner of the keyboard.
#[derive(bevy::ecs::system::SystemParam)]
pub struct Typing<'w, 's> {
    events: MessageReader<'w, 's, KeyboardInput>,
    held: Res<'w, ButtonInput<KeyCode>>,
    fields: Local<'s, FieldKeys>,
    /// The owner of the keyboard at the end of the last frame, if not the picture.
    keyboard: Local<'s, Option<Keyboard>>,
    /// The widget that last had the keyboard.
    focus: Local<'s, Option<egui::Id>>,
}

impl Typing<'_, '_> {
    /// Whether a key is down, other than a lock key.
    fn is_key_held(&self) -> bool {
        let locks = [KeyCode::CapsLock, KeyCode::NumLock, KeyCode::ScrollLock];
        self.held.get_pressed().any(|key| !locks.contains(key))
    }
}

pub fn show_window(
    mut contexts: EguiContexts,
    model: Res<EditorModel>,
    mut said: Said,
    mut widgets: ResMut<Widgets>,
    mut state: ResMut<ViewportState>,
    mut dialogs: ResMut<Dialogs>,
    mut shell: Shell,
    scene: Scene,
    mut typing: Typing,
) -> Result {
    let context = contexts.ctx_mut()?.clone();
    let modifiers = context.input(|input| input.modifiers);
    let pressed = keys::presses(typing.events.read(), modifiers);
    count_interactions(&context, &pressed, &state, &mut said.requests, &mut typing.focus);
    dialog::note_keys(&context, typing.is_key_held());
    let builder = egui::UiBuilder::new()
        .layer_id(egui::LayerId::background())
        .max_rect(context.viewport_rect());
    let mut ui = egui::Ui::new(context.clone(), "window".into(), builder);
    let (state, widgets, commands, model) = (&mut *state, &mut *widgets, &mut Vec::new(), &model.0);
    let (requests, settings, seen) = (&mut *said.requests, &*scene.settings, &*scene.seen);
    // The panels list visible entries again when they are shown.
    widgets.outliner.materials_in_sight.clear();
    widgets.shelf.in_sight.clear();
    widgets.assets.in_sight.clear();
    widgets.assets.is_shown = false;
    let layout = &mut *shell.layout;
    // A question or a sheet that closes in this frame still owned its keys.
    let has_question = requests.save_question.is_some()
        || requests.full_film_question.is_some()
        || requests.scene_question.is_some()
        || shell.recovery.offer.is_some()
        || shell.trusted.question.is_some()
        || shell.guards.is_asking();
    let is_free = requests.dialog.is_none() && requests.sheet.is_none() && !has_question;
    // A field that loses the focus or a list that closes in this frame still owned its keys.
    let bound = &shell.preferences.keys;
    let presses = match is_free {
        true => {
            let mut presses = typing.fields.take(&context, pressed.clone(), *typing.keyboard, bound);
            // Esc does only one action at a time: the one named in the status line.
            let is_escape = |press: &Press| press.key == egui::Key::Escape;
            if presses.iter().any(is_escape) && number_field::take_back(&context) {
                presses.retain(|press| !is_escape(press));
            }
            presses
        }
        false => {
            typing.fields.drop_waiting();
            Vec::new()
        }
    };
    let action_context = ActionContext {
        paused: model.status.paused,
        bound,
        has_textures: model.inspected.as_ref().is_some_and(Inspected::has_textures),
        has_kept_picture: shell.kept_pictures.is_there,
        navigation: shell.preferences.navigation,
        has_missing: !model.missing.is_empty(),
        can_revert: model.status.scene.is_some() && (model.status.unsaved || model.status.load_failed),
        ..action_context(settings, model, &scene.selection)
    };
    let menus = MenuState {
        context: action_context,
        camera: scene.active.0,
        layout,
        recent: &shell.preferences.recent_files,
    };
    egui::Panel::top("menus").show(&mut ui, |ui| menu_bar(ui, model, menus, commands));
    let pointed = pointed_light(state.pointed, settings.display.mode, &scene.film);
    egui::Panel::bottom("status").show(&mut ui, |ui| status::status_line(ui, &model.status, pointed.as_deref()));
    if model.timeline.is_shown(settings.timeline_shown) && settings.panels_shown {
        egui::Panel::bottom("timeline").show(&mut ui, |ui| {
            let bound = &shell.preferences.keys;
            timeline(ui, &model.timeline, bound, &mut widgets.timeline, commands);
        });
    }
    let mouse = egui::vec2(shell.mouse.delta.x, shell.mouse.delta.y);
    let step = gizmo::step_beside(&seen.targets, settings.length_step());
    let wall = selected_wall(&scene);
    let has_series_form = requests.sheet == Some(Sheet::Series);
    let sides = scene.sides.models(&settings.side_views);
    let shown = ViewportModel {
        wall: wall.as_ref(),
        series: has_series_form.then(|| widgets.series.series(step)),
        ..viewport_model(
            &scene,
            &sides,
            &shell.preferences,
            model,
            action_context,
            &presses,
            mouse,
            is_free,
        )
    };
    widgets.bake.follow(layout, &model.bake);
    if let Some(group) = requests.nameless_group.take() {
        widgets.outliner.ask_for_name(group, ui.input(|input| input.time));
    }
    if let Some(panel) = requests.wanted_panel.take() {
        layout.bring_to_front(panel);
    }
    egui::CentralPanel::no_frame().show(&mut ui, |ui| {
        if settings.panels_shown {
            docked_panels(
                ui,
                layout,
                Panels::new(model, &shown, settings, state, widgets, commands),
            );
        } else {
            widgets.viewport_place = ui.max_rect();
            viewport(ui, &shown, state, commands);
        }
    });
    if let Some(room) = state.room {
        shell.place.bypass_change_detection().note(room);
    }
    if state.gizmo.take_begun() {
        requests.interaction += 1;
    }
    state.light_drags(shell.preferences.headlight_drags, settings.display, commands);
    use_clipboard(&context, &presses, &mut shell.clipboard, commands);
    dialogs.show(
        &context,
        DialogModel {
            scene: scene.status.path.as_deref(),
            tone_map: settings.display.tone_map,
            denoises: settings.denoising,
            recent: &shell.preferences.recent_files,
        },
        requests,
        &mut said.toasts,
        commands,
    );
    let sheets = SheetModel {
        actions: action_context,
        preferences: &shell.preferences,
        problem: shell.preferences_file.problem.as_deref(),
        presses: &pressed,
        left: &shell.recovery.left,
        step,
    };
    // The start page waits until the questions are answered.
    let asks = shell.recovery.offer.is_some() || shell.trusted.question.is_some();
    if !(asks && requests.sheet == Some(Sheet::Start)) {
        sheet::show(&context, model, sheets, &mut requests.sheet, widgets, commands);
    }
    tutorial::show(&context, &scene.tutorial, widgets.viewport_place, commands);
    if recovery_question::question(&context, &mut shell.recovery.offer, commands) {
        said.toasts.info(recovery_question::PUT_OFF);
    }
    save_question::show(&context, requests, commands);
    full_film::question(&context, &mut requests.full_film_question, commands);
    scene_question::question(&context, &mut requests.scene_question, commands);
    let progress = full_film::progress(&context, &model.status, widgets.viewport_place, commands);
    // One question at a time.
    if shell.recovery.offer.is_none() {
        trust_question::question(&context, &mut shell.trusted.question, commands);
    }
    if shell.dropped.hovering > 0 {
        dropping::hint(&context, widgets.viewport_place);
    }
    let is_untouched = model.status.scene.is_none() && !model.status.unsaved;
    commands.extend(shell.dropped.commands(is_untouched));
    commands.extend(shell.trusted.opens.take().map(|it| FileCommand::OpenScene(it).into()));
    if requests.closes && typing.fields.is_left(*typing.keyboard) {
        requests.closes = false;
        commands.push(FileCommand::Quit.into());
    }
    let ended = shell.ended_image.as_deref();
    let (kept, toasts) = (&shell.kept_pictures, &mut said.toasts);
    (shell.guards).apply(&context, model, kept, ended, requests, toasts, commands);
    let hidden = match requests.sheet {
        // The answer may solve the errors.
        _ if shell.trusted.question.is_some() => Some(Tone::Error),
        // A note would cover the page and concern a scene that the user has not asked for.
        Some(Sheet::Start) => Some(Tone::Note),
        _ => None,
    };
    let around = toasts::Surroundings {
        panel: widgets.viewport_place,
        bars: [state.bar, state.legend, progress].into_iter().flatten().collect(),
        has_question,
    };
    toasts::show(&mut said.toasts, hidden, &context, around, commands);
    said.queue.0.append(commands);
    typing.fields.end_frame(&context);
    let is_picture = context.memory(|memory| memory.has_focus(egui::Id::new(PICTURE)));
    *typing.keyboard = Keyboard::of(&context, is_picture);
    Ok(())
}

/// The selected wall with openings, if it alone is selected, is in the picture and can be edited.
fn selected_wall(scene: &Scene) -> Option<BlockTarget> {
    let [entity] = *scene.selection.entities() else {
        return None;
    };
    let (shape, to_world) = scene.shapes.get(entity).ok()?;
    (has_openings(shape) && !scene.seen.locked.contains(&entity)).then(|| BlockTarget {
        entity,
        shape: shape.clone(),
        pose: to_world.0,
    })
}

/// What the viewport shows.
fn viewport_model<'a>(
    scene: &'a Scene,
    sides: &'a [SideModel<'a>],
    preferences: &'a Preferences,
    model: &'a Model,
    keys: ActionContext<'a>,
    presses: &'a [Press],
    mouse: egui::Vec2,
    enabled: bool,
) -> ViewportModel<'a> {
    let (settings, seen) = (&*scene.settings, &*scene.seen);
    ViewportModel {
        picture: seen.picture,
        film_in_picture: seen.film_in_picture,
        is_through_camera: seen.is_through_camera,
        proportions: seen.proportions,
        placeholder: &seen.placeholder,
        // While a scene is being read the camera is still that of the scene before.
        outdated: (model.status.status.outdated).filter(|_| scene.status.state == SceneState::Ready),
        pose: seen.pose,
        camera: scene.packed.view.as_ref().map(|view| view.camera),
        boxes: seen.boxes(),
        outline: &seen.outline,
        wireframe: &seen.wireframe,
        volume_boxes: &seen.volume_boxes,
        lamp_solid: seen.lamp_solid.as_ref(),
        icons: &seen.icons,
        stand_ins: &seen.stand_ins,
        marker_paths: &seen.paths,
        gizmo: GizmoModel {
            settings: settings.gizmo,
            targets: &seen.targets,
            length_step: settings.length_step(),
            grid: settings.grid,
            up: settings.navigation.up,
            unit: model.unit,
            packed: &scene.packed,
            bound: &preferences.keys,
        },
        blocks: &seen.blocks,
        wall: None,
        textures: seen.textures.as_ref(),
        locked: &seen.locked,
        painting: Some(&model.render.painting),
        things: &model.outline,
        packed: &scene.packed,
        legend: seen.legend.as_ref(),
        captions: &seen.captions,
        compared: seen.compared,
        region: model.render.region,
        paths: &scene.paths,
        reasons: &scene.reasons,
        lamp: &scene.lamp,
        navigation: settings.navigation,
        denoiser: model.status.denoiser,
        is_carried_over: model.status.is_carried_over,
        preset: preferences.navigation,
        keys,
        mouse,
        extent: model.extent,
        series: None,
        rulers: &settings.rulers,
        is_empty: scene.status.state == SceneState::Ready && model.outline.shapes.is_empty(),
        depths: Depths::rendered(&scene.film),
        sides,
        side: None,
        presses,
        enabled,
    }
}

/// Copies, cuts and pastes things while nothing is being typed.
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
            egui::Key::C => commands.push(SelectionCommand::Copy.into()),
            egui::Key::X => commands.push(SceneEdit::Cut.into()),
            egui::Key::V => commands.extend(clipboard.get_text().map(|it| SceneEdit::Paste(it).into())),
            _ => {}
        }
    }
}

/// Counts interactions: a press of the mouse, a key outside of text fields, and a change of the field begin a new one.
fn count_interactions(
    context: &egui::Context,
    presses: &[Press],
    state: &ViewportState,
    requests: &mut Requests,
    focus: &mut Option<egui::Id>,
) {
    let focused = context.memory(|memory| memory.focused());
    let is_typing = focused.is_some_and(|focused| focused != egui::Id::new(PICTURE));
    let is_dragging = state.gizmo.is_dragging()
        || state.grips.is_busy()
        || state.blocking.is_busy()
        || state.texturing.is_busy()
        || state.light_brush.is_busy();
    let key = !presses.is_empty() && !is_typing && !is_dragging;
    // A button that is pressed in the middle of a drag belongs to it.
    let button = !is_dragging && context.input(|input| input.pointer.any_pressed());
    let pressed = key || button;
    if pressed || focused != *focus {
        *focus = focused;
        requests.interaction += 1;
    }
    if let Some(text) = requests.clipboard.take() {
        context.copy_text(text);
    }
}
