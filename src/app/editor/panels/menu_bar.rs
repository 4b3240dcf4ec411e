//! The menus at the top.

use std::path::PathBuf;

use bevy::prelude::Entity;
use bevy_egui::egui::containers::menu::MenuButton;
use bevy_egui::egui::{self, Button, Id, Key, Popup, RichText, Ui};

use super::lamps::lamps_menu;
use super::medium_section::fill_menu;
use super::menu_marks::{self, Mark};
use crate::app::editor::command::addition::AdditionKind;
use crate::app::editor::command::display::{DisplayMode, DisplaySettings};
use crate::app::editor::command::panel::Panel;
use crate::app::editor::command::{
    Command, DisplayCommand, FileCommand, RenderCommand, SceneEdit, SettingsEdit, ShellCommand, ViewCommand,
};
use crate::app::editor::input::actions::{self, ACTIONS, Action, ActionContext, Group};
use crate::app::editor::model::Model;
use crate::app::editor::picture::denoiser::DenoiserState;
use crate::app::editor::session::layout::Layout;
use crate::app::editor::words::files::folders_apart;
use crate::scene::{LengthUnit, LightUnits};

/// The settings besides the model that menus show as check marks.
#[derive(Clone, Copy)]
pub struct MenuState<'a> {
    /// The context of the menus' actions.
    pub context: ActionContext<'a>,
    /// The camera in use.
    pub camera: Option<Entity>,
    /// The layout, which knows the open panels.
    pub layout: &'a Layout,
    /// The recent scenes, the newest first.
    pub recent: &'a [PathBuf],
}

/// The id under which egui keeps whether a menu of the bar is open.
fn open_id() -> Id {
    Id::new("a menu of the bar is open")
}

/// A menu of the bar. It opens by a click, and by pointing at it while another menu of the bar is open. Returns whether
/// it is open.
fn top_menu(ui: &mut Ui, title: &str, is_one_open: bool, content: &mut dyn FnMut(&mut Ui)) -> bool {
    let (button, _) = MenuButton::new(title).ui(ui, content);
    let popup = Popup::default_response_id(&button);
    let is_open = Popup::is_id_open(ui.ctx(), popup);
    // A click that closes a menu at the pointer must not open it again.
    let is_closed = button.clicked() || ui.input(|input| input.key_pressed(Key::Escape));
    if is_one_open && !is_open && button.hovered() && !is_closed {
        Popup::open_id(ui.ctx(), popup);
        return true;
    }
    is_open
}

/// The menus of the window, in one row.
pub fn menu_bar(ui: &mut Ui, model: &Model, state: MenuState, commands: &mut Vec<Command>) {
    let widgets = ui.visuals().widgets.clone();
    egui::MenuBar::new().ui(ui, |ui| {
        let context = &state.context;
        let was_open = ui.data(|data| data.get_temp(open_id()).unwrap_or(false));
        let mut is_open = false;
        let mut menu = |ui: &mut Ui, title: &str, content: &mut dyn FnMut(&mut Ui)| {
            is_open |= top_menu(ui, title, was_open, content);
        };
        menu(ui, "File", &mut |ui| file_menu(ui, model, &state, commands));
        menu(ui, "Edit", &mut |ui| edit_menu(ui, model, context, commands));
        menu(ui, "Add", &mut |ui| add_menu(ui, model, context, commands));
        menu(ui, "Arrange", &mut |ui| arrange_menu(ui, context, commands));
        menu(ui, "View", &mut |ui| view_menu(ui, model, &state, commands));
        menu(ui, "Time", &mut |ui| {
            group(ui, Group::Time, &["first-frame", "set-key"], context, commands)
        });
        menu(ui, "Render", &mut |ui| render_menu(ui, context, commands));
        menu(ui, "Window", &mut |ui| window_menu(ui, &state, commands));
        ui.data_mut(|data| data.insert_temp(open_id(), is_open));
        ui.separator();
        // Entries that act at once look like buttons, unlike the menus beside them.
        ui.scope(|ui| {
            ui.visuals_mut().widgets = widgets;
            ui.spacing_mut().button_padding.x = 6.0;
            buttons(ui, model, context, commands);
        });
        ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
            let name = match &model.status.scene {
                Some(scene) => scene.file_name().unwrap_or_default().to_string_lossy().into_owned(),
                None => "untitled".to_owned(),
            };
            let mark = if model.status.unsaved { " •" } else { "" };
            let label = ui.add(egui::Label::new(egui::RichText::new(name + mark).weak()).truncate());
            if let Some(scene) = &model.status.scene {
                label.on_hover_text(scene.display().to_string());
            }
        });
    });
}

fn buttons(ui: &mut Ui, model: &Model, context: &ActionContext, commands: &mut Vec<Command>) {
    let paused = model.status.paused;
    let pause = ui.button(if paused { "Resume" } else { "Pause" });
    let hint = actions::hint("Samples are kept", "pause", context.bound);
    if pause.on_hover_text(hint).clicked() {
        commands.push(RenderCommand::SetPaused(!paused).into());
    }
    let restart = ui.button("Start again");
    let hint = actions::hint("Begin the picture anew", "restart", context.bound);
    if restart.on_hover_text(hint).clicked() {
        commands.push(RenderCommand::Restart.into());
    }
    denoise_button(ui, model.status.denoiser, context, commands);
}

fn denoise_button(ui: &mut Ui, state: DenoiserState, context: &ActionContext, commands: &mut Vec<Command>) {
    let button = Button::selectable(context.denoising, "Denoise");
    if state == DenoiserState::Unavailable {
        ui.add_enabled(false, button)
            .on_disabled_hover_text("Built without the feature `denoise`");
        return;
    }
    let hint = "Take the noise out of the picture while it is rendered";
    let hint = actions::hint(hint, "denoise", context.bound);
    if ui.add(button).on_hover_text(hint).clicked() {
        commands.push(DisplayCommand::SetDenoising(!context.denoising).into());
    }
}

/// Whether an action chooses one of several values.
fn is_choice(name: &str) -> bool {
    let starts = ["gizmo-", "navigation-", "pivot-", "snap-"];
    starts.iter().any(|start| name.starts_with(start)) && name != "gizmo-axes"
}

/// Shows the action of this name, disabled if it does not apply. `kind`: the kind of thing whose icon stands before it;
/// without one the column has a mark if the action switches or chooses something. The tool in use has a dot.
fn drawn_entry(ui: &mut Ui, name: &str, kind: Option<&str>, context: &ActionContext, commands: &mut Vec<Command>) {
    let Some(action) = actions::find(name) else {
        return;
    };
    let command = (action.command)(context);
    let mark = match (kind, action.switch(context)) {
        (_, Some(is_on)) => Mark::Box(is_on),
        (_, None) if is_choice(name) => Mark::Dot(action.is_on(context)),
        (_, None) if action.is_on(context) => Mark::Dot(true),
        (Some(kind), None) => Mark::Icon(kind),
        (None, None) => Mark::None,
    };
    ui.add_enabled_ui(command.is_some(), |ui| {
        let response = menu_marks::entry(ui, mark, action.label, action.key_text(context.bound));
        if response.clicked() {
            commands.extend(command);
            ui.close();
        }
        response.on_disabled_hover_text(action.missing());
    });
}

/// Shows the action of this name in a menu with marks.
fn entry(ui: &mut Ui, name: &str, context: &ActionContext, commands: &mut Vec<Command>) {
    drawn_entry(ui, name, None, context, commands);
}

/// Shows the actions of a group, with a separator before the named ones.
fn group(ui: &mut Ui, group: Group, lines_before: &[&str], context: &ActionContext, commands: &mut Vec<Command>) {
    ui.set_min_width(220.0);
    for action in ACTIONS.iter().filter(|action| action.group == group) {
        if lines_before.contains(&action.name) {
            ui.separator();
        }
        entry(ui, action.name, context, commands);
    }
}

/// The part of the menu *Add* for an action, and the kind of thing whose icon stands before it.
fn addition(name: &str) -> (&'static str, &str) {
    match name.split_once('-') {
        Some(("add", "camera" | "turntable")) => ("Cameras", "camera"),
        Some(("add", "fog" | "fog-box") | ("fill", _)) => ("Media", "fog"),
        Some(("add", kind)) => {
            let shapes = [
                "sphere",
                "rectangle",
                "cube",
                "disk",
                "cylinder",
                "wall",
                "stairs",
                "prism",
                "gableroof",
                "hiproof",
                "shedroof",
            ];
            let part = if shapes.contains(&kind) { "Shapes" } else { "Lights" };
            (part, kind)
        }
        Some((_, kind @ ("floor" | "faces" | "wall" | "door" | "window" | "roof"))) => ("Build in the picture", kind),
        _ => ("Build in the picture", "cube"),
    }
}

fn add_menu(ui: &mut Ui, model: &Model, context: &ActionContext, commands: &mut Vec<Command>) {
    ui.set_min_width(220.0);
    ui.spacing_mut().item_spacing.y = 1.0;
    let mut before = "";
    for action in ACTIONS.iter().filter(|action| action.group == Group::Add) {
        let (part, drawing) = addition(action.name);
        if part != before {
            ui.add_space(3.0);
            ui.label(RichText::new(part).small().weak());
            before = part;
        }
        drawn_entry(ui, action.name, Some(drawing), context, commands);
        if action.name == "add-area" {
            let lamp = lamps_menu(ui, menu_marks::inset("Real lamps and skies"), |_| true);
            commands.extend(lamp.map(|lamp| SceneEdit::Add(AdditionKind::Lamp(lamp).into()).into()));
        }
        if action.name != "fill-smoke" || model.outline.media.is_empty() {
            continue;
        }
        let shapes = model.selected_shapes();
        if !shapes.is_empty() {
            ui.menu_button(menu_marks::inset("Fill with a medium of the scene"), |ui| {
                fill_menu(ui, &shapes, model, commands)
            });
        }
    }
}

fn render_menu(ui: &mut Ui, context: &ActionContext, commands: &mut Vec<Command>) {
    let lines_before = ["pause", "render-full", "denoise", "keep-limits", "take-snapshot"];
    group(ui, Group::Render, &lines_before, context, commands);
    ui.separator();
    entry(ui, "save-image", context, commands);
}

fn edit_menu(ui: &mut Ui, model: &Model, context: &ActionContext, commands: &mut Vec<Command>) {
    ui.set_min_width(220.0);
    let in_group = |action: &&Action| {
        action.group == Group::Edit
            && !["unit-", "light-units-"]
                .iter()
                .any(|start| action.name.starts_with(start))
    };
    for action in ACTIONS.iter().filter(in_group) {
        if ["duplicate", "group", "select-all", "hide", "gizmo-move"].contains(&action.name) {
            ui.separator();
        }
        entry(ui, action.name, context, commands);
    }
    ui.separator();
    ui.menu_button(menu_marks::inset("Unit of length"), |ui| {
        for (unit, name) in LengthUnit::LABELED {
            if menu_marks::choice(ui, model.unit == unit, name).clicked() {
                commands.push(SettingsEdit::SetUnit(unit).into());
                ui.close();
            }
        }
    });
    ui.menu_button(menu_marks::inset("Units of light"), |ui| {
        for (units, name) in LightUnits::LABELED {
            if menu_marks::choice(ui, model.light_units == units, name).clicked() {
                commands.push(SettingsEdit::SetLightUnits(units).into());
                ui.close();
            }
        }
    });
}

/// Shows the entries of the group, some of them in submenus.
fn arrange_menu(ui: &mut Ui, context: &ActionContext, commands: &mut Vec<Command>) {
    const INNER: [(&str, &str); 5] = [
        ("snap-", "Snap to"),
        ("pivot-", "Pivot"),
        ("align-active-", "Align to the active"),
        ("align-", "Align to each other"),
        ("distribute-", "Distribute"),
    ];
    let inner = |name: &str| INNER.into_iter().find(|(start, _)| name.starts_with(start));
    ui.set_min_width(220.0);
    let of_group = || ACTIONS.iter().filter(|action| action.group == Group::Arrange);
    for action in of_group().filter(|action| inner(action.name).is_none()) {
        entry(ui, action.name, context, commands);
    }
    ui.separator();
    for (start, title) in INNER {
        ui.menu_button(menu_marks::inset(title), |ui| {
            for action in of_group().filter(|action| inner(action.name).is_some_and(|(its, _)| its == start)) {
                entry(ui, action.name, context, commands);
            }
        });
    }
}

fn file_menu(ui: &mut Ui, model: &Model, state: &MenuState, commands: &mut Vec<Command>) {
    let context = &state.context;
    ui.set_min_width(220.0);
    for name in ["start-page", "new", "open"] {
        entry(ui, name, context, commands);
    }
    ui.menu_button(menu_marks::inset("Recent"), |ui| scenes(ui, state.recent, commands));
    ui.menu_button(menu_marks::inset("Scenes"), |ui| {
        scenes(ui, &model.scene_files, commands)
    });
    entry(ui, "reload", context, commands);
    entry(ui, "revert", context, commands);
    entry(ui, "recover", context, commands);
    ui.separator();
    entry(ui, "import", context, commands);
    entry(ui, "missing-files", context, commands);
    ui.separator();
    for name in ["save", "save-as", "export", "bake-lightmaps", "save-image"] {
        entry(ui, name, context, commands);
    }
    ui.separator();
    for name in ["keep-picture", "continue-picture", "discard-picture"] {
        entry(ui, name, context, commands);
    }
    ui.separator();
    entry(ui, "quit", context, commands);
}

fn scenes(ui: &mut Ui, files: &[PathBuf], commands: &mut Vec<Command>) {
    egui::ScrollArea::vertical().max_height(400.0).show(ui, |ui| {
        for (path, folder) in files.iter().zip(folders_apart(files)) {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let button = Button::new(name).shortcut_text(RichText::new(folder).weak());
            let entry = ui.add(button).on_hover_text(path.display().to_string());
            if entry.clicked() {
                commands.push(FileCommand::OpenScene(path.clone()).into());
                ui.close();
            }
        }
        if files.is_empty() {
            ui.weak("no scene files here");
        }
    });
}

fn view_menu(ui: &mut Ui, model: &Model, state: &MenuState, commands: &mut Vec<Command>) {
    ui.set_min_width(220.0);
    let display = state.context.display;
    for (mode, name) in DisplayMode::ALL {
        let keys = match mode == display.mode.next() {
            true => actions::key_text("next-mode", state.context.bound),
            false => String::new(),
        };
        let entry = menu_marks::entry(ui, Mark::Dot(display.mode == mode), name, keys);
        if entry.on_hover_text(mode.about()).clicked() {
            commands.push(DisplayCommand::SetDisplay(DisplaySettings { mode, ..display }).into());
            ui.close();
        }
    }
    ui.separator();
    ui.menu_button(menu_marks::inset("Cameras"), |ui| {
        egui::ScrollArea::vertical().max_height(400.0).show(ui, |ui| {
            for camera in &model.outline.sensors {
                let used = state.camera == Some(camera.entity);
                if menu_marks::choice(ui, used, &camera.name).clicked() {
                    commands.push(ViewCommand::LookThrough(camera.entity).into());
                    ui.close();
                }
            }
        });
    });
    ui.menu_button(menu_marks::inset("Along an axis"), |ui| {
        for name in [
            "view-front",
            "view-back",
            "view-right",
            "view-left",
            "view-top",
            "view-bottom",
        ] {
            entry(ui, name, &state.context, commands);
        }
    });
    for name in ["four-views", "side-views-clay"] {
        entry(ui, name, &state.context, commands);
    }
    ui.menu_button(menu_marks::inset("Mouse"), |ui| {
        for name in [
            "navigation-sunroom",
            "navigation-blender",
            "navigation-godot",
            "navigation-trenchbroom",
        ] {
            entry(ui, name, &state.context, commands);
        }
    });
    for name in ["see-into-rooms", "cut-open", "isolate", "wireframe"] {
        entry(ui, name, &state.context, commands);
    }
    ui.separator();
    for name in ["camera-to-view", "frame-selection", "frame-all"] {
        entry(ui, name, &state.context, commands);
    }
    ui.separator();
    for name in [
        "grid",
        "safe-frame",
        "dimensions",
        "ruler",
        "clear-rulers",
        "light-brush",
        "boxes",
    ] {
        entry(ui, name, &state.context, commands);
    }
}

fn window_menu(ui: &mut Ui, state: &MenuState, commands: &mut Vec<Command>) {
    ui.set_min_width(220.0);
    for &panel in Panel::CLOSEABLE {
        let shown = state.layout.has(panel);
        if menu_marks::entry(ui, Mark::Box(shown), panel.title(), String::new()).clicked() {
            let command = match shown {
                true => ShellCommand::ClosePanel(panel),
                false => ShellCommand::ShowPanel(panel),
            };
            commands.push(Command::Shell(command));
            ui.close();
        }
    }
    ui.separator();
    group(
        ui,
        Group::Window,
        &["preferences", "tutorial", "reset-layout"],
        &state.context,
        commands,
    );
}
