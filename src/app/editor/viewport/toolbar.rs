//! The buttons above the picture: the mode, axes, pivot and steps of the gizmo, the display mode, and the overlays. A
//! new button is a line of one of the groups, a new group a function beside them. At the left of the picture are the
//! tools that build and place.

use bevy_egui::egui::emath::format_with_decimals_in_range;
use bevy_egui::egui::{self, Align, ComboBox, DragValue, Layout, Margin, Rect, Ui, UiBuilder};

use super::marks::bar_frame;
use super::model::ViewportModel;
use super::snap_menu::snap_menu;
use super::tool_icons::{ToolIcon, icon_button, icon_menu};
use crate::app::editor::command::blocking::{BlockKind, OpeningKind};
use crate::app::editor::command::bvh_overlay::BvhOverlay;
use crate::app::editor::command::display::{DisplayMode, DisplaySettings};
use crate::app::editor::command::gizmo_settings::{Axes, DEGREES, FACTORS, GizmoSettings, LENGTHS, Mode, Pivot, Steps};
use crate::app::editor::command::grid_settings::GridSettings;
use crate::app::editor::command::tool::Tool;
use crate::app::editor::command::{Command, DisplayCommand, ToolCommand, ViewCommand};
use crate::app::editor::input::actions::{self, ActionContext, hint};
use crate::app::editor::input::number_field::{self, Meaning};
use crate::app::editor::picture::denoiser::DenoiserState;

const HEIGHT: f32 = 32.0;
/// The width before the first frame; afterwards it is the width of the buttons.
const WIDTH: f32 = 500.0;

/// Shows the toolbar.
pub(crate) fn toolbar(ui: &mut Ui, panel: Rect, model: &ViewportModel, commands: &mut Vec<Command>) {
    let id = ui.id().with("width of the toolbar");
    let known: f32 = ui.data(|data| data.get_temp(id)).unwrap_or(WIDTH);
    let size = egui::vec2(known.min(panel.width() - 16.0), HEIGHT);
    let place = Rect::from_min_size(panel.center_top() + egui::vec2(-0.5 * size.x, 6.0), size);
    let layout = Layout::left_to_right(Align::Center);
    let mut bar = ui.new_child(UiBuilder::new().id_salt("toolbar").max_rect(place).layout(layout));
    bar.set_clip_rect(panel);
    let shown = bar_frame(&bar, Margin::symmetric(5, 2)).show(&mut bar, |ui| {
        ui.spacing_mut().item_spacing.x = 3.0;
        let mut edited = model.gizmo.settings;
        tools(ui, &model.keys, &mut edited);
        ui.separator();
        frames(ui, &model.keys, &mut edited);
        ui.separator();
        snapping(ui, &model.keys, &mut edited, model.gizmo.length_step);
        if edited != model.gizmo.settings {
            commands.push(ToolCommand::SetGizmo(edited).into());
        }
        ui.separator();
        picture(ui, model, commands);
        overlays(ui, &model.keys, commands);
    });
    let width = shown.response.rect.width();
    if (width - known).abs() > 0.5 {
        ui.data_mut(|data| data.insert_temp(id, width));
        ui.ctx().request_repaint();
    }
}

/// The tools that build and place, each with its action; None: a gap.
const BUILDING: [Option<(ToolIcon, Tool, &str, &str)>; 12] = [
    Some((
        ToolIcon::Box,
        Tool::Draw(BlockKind::Box),
        "draw-box",
        "Draw a box: its foot, then its height",
    )),
    Some((
        ToolIcon::Floor,
        Tool::Draw(BlockKind::Floor),
        "draw-floor",
        "Draw a floor: drag a rectangle",
    )),
    Some((
        ToolIcon::Wall,
        Tool::Draw(BlockKind::Wall),
        "draw-wall",
        "Draw a wall: its line, then its height",
    )),
    None,
    Some((
        ToolIcon::Push,
        Tool::Push,
        "push-faces",
        "Push and pull the faces of boxes and walls",
    )),
    Some((
        ToolIcon::Door,
        Tool::Cut(OpeningKind::Door),
        "cut-door",
        "Cut a door into a wall or a box",
    )),
    Some((
        ToolIcon::Window,
        Tool::Cut(OpeningKind::Window),
        "cut-window",
        "Cut a window into a wall or a box, or a hole into a floor",
    )),
    None,
    Some((
        ToolIcon::Texture,
        Tool::PlaceTexture,
        "place-texture",
        "Place the textures of the selected shape by handles",
    )),
    None,
    Some((
        ToolIcon::Ruler,
        Tool::Ruler,
        "ruler",
        "Measure a distance between two points",
    )),
    Some((
        ToolIcon::LightBrush,
        Tool::PaintLight,
        "light-brush",
        "Paint the light you want: the lamps follow",
    )),
];

/// The place of the tools at the left of the picture's panel.
pub(super) fn column_place(panel: Rect) -> Rect {
    const SIZE: egui::Vec2 = egui::vec2(32.0, 283.0);
    // The caption of the picture is above the column.
    let top = (panel.center().y - 0.5 * SIZE.y).max(panel.top() + 80.0);
    Rect::from_min_size(egui::pos2(panel.left() + 6.0, top), SIZE)
}

/// Shows the tools that build and place, as a column at the left of the picture.
pub(crate) fn tool_column(ui: &mut Ui, panel: Rect, keys: &ActionContext, commands: &mut Vec<Command>) {
    let place = column_place(panel);
    let layout = Layout::top_down(Align::Center);
    let mut column = ui.new_child(UiBuilder::new().id_salt("tool column").max_rect(place).layout(layout));
    column.set_clip_rect(panel);
    bar_frame(&column, Margin::symmetric(2, 4)).show(&mut column, |ui| {
        ui.spacing_mut().item_spacing.y = 2.0;
        for entry in BUILDING {
            let Some((icon, tool, action, help)) = entry else {
                ui.add_space(5.0);
                continue;
            };
            let help = hint(help, action, keys.bound);
            let Some(action) = actions::find(action) else { continue };
            let command = (action.command)(keys);
            ui.add_enabled_ui(command.is_some(), |ui| {
                let help = if ui.is_enabled() { &help } else { action.missing() };
                if icon_button(ui, icon, keys.tool == tool, action.label, help).clicked() {
                    commands.extend(command);
                }
            });
        }
    });
}

/// The modes of the gizmo.
fn tools(ui: &mut Ui, keys: &ActionContext, edited: &mut GizmoSettings) {
    let help = hint("Select without handles", "gizmo-hide", keys.bound);
    if icon_button(ui, ToolIcon::Select, edited.is_hidden, "Select", &help).clicked() {
        edited.is_hidden = true;
    }
    for (mode, icon, name, help, action) in [
        (Mode::Move, ToolIcon::Move, "Move", "Move", "gizmo-move"),
        (Mode::Rotate, ToolIcon::Rotate, "Rotate", "Rotate", "gizmo-rotate"),
        (
            Mode::Scale,
            ToolIcon::Scale,
            "Scale",
            "Scale along the object's own axes",
            "gizmo-scale",
        ),
    ] {
        let is_on = edited.mode == mode && !edited.is_hidden;
        if icon_button(ui, icon, is_on, name, &hint(help, action, keys.bound)).clicked() {
            (edited.mode, edited.is_hidden) = (mode, false);
        }
    }
}

/// The axes and the pivot of the gizmo.
fn frames(ui: &mut Ui, keys: &ActionContext, edited: &mut GizmoSettings) {
    let (icon, name, other, help) = match edited.axes {
        Axes::World => (
            ToolIcon::World,
            "World",
            Axes::Local,
            "The handles are along the axes of the world. A click: those of the active object",
        ),
        Axes::Local => (
            ToolIcon::Local,
            "Local",
            Axes::World,
            "The handles are along the axes of the active object. A click: those of the world",
        ),
    };
    let help = hint(help, "gizmo-axes", keys.bound);
    let can_choose = edited.mode != Mode::Scale;
    ui.add_enabled_ui(can_choose, |ui| {
        if icon_button(ui, icon, false, name, &help).clicked() {
            edited.axes = other;
        }
    });
    let chosen = Pivot::ALL
        .iter()
        .find(|(pivot, _)| *pivot == edited.pivot)
        .map_or("", |(_, name)| name);
    ComboBox::from_id_salt("pivot")
        .width(96.0)
        .selected_text(chosen)
        .show_ui(ui, |ui| {
            for (pivot, name) in Pivot::ALL {
                ui.selectable_value(&mut edited.pivot, pivot, name);
            }
        })
        .response
        .on_hover_text("The point that things turn and grow about");
}

/// The targets of snapping, and the step of the mode.
fn snapping(ui: &mut Ui, keys: &ActionContext, edited: &mut GizmoSettings, length_step: f32) {
    snap_menu(ui, keys, &mut edited.snap);
    let steps = &mut edited.steps;
    let mut length = length_step;
    let (value, speed, range, suffix) = match edited.mode {
        Mode::Move => (&mut length, 0.02 * length_step, LENGTHS, ""),
        Mode::Rotate => (&mut steps.degrees, 0.5, DEGREES, "°"),
        Mode::Scale => (&mut steps.factor, 0.01, FACTORS, ""),
    };
    let drag = DragValue::new(value).speed(speed).suffix(suffix).max_decimals(4);
    let field = number_field::number(
        ui,
        drag,
        edited.mode as usize,
        range,
        Meaning::Number,
        format_with_decimals_in_range,
    );
    let response = ui.add(field).on_hover_text(
        "The step: what Control rounds to while dragging, and how far the arrow keys go. A click with the right button: as in the beginning",
    );
    if response.secondary_clicked() {
        let usual = Steps::default();
        match edited.mode {
            Mode::Move => edited.steps.length = usual.length,
            Mode::Rotate => edited.steps.degrees = usual.degrees,
            Mode::Scale => edited.steps.factor = usual.factor,
        }
    } else if response.changed() && edited.mode == Mode::Move {
        edited.steps.length = Some(length);
    }
}

/// The display of the picture.
fn picture(ui: &mut Ui, model: &ViewportModel, commands: &mut Vec<Command>) {
    let keys = &model.keys;
    let display = keys.display;
    let help = hint("What the picture shows", "next-mode", keys.bound);
    icon_menu(ui, ToolIcon::Shading, false, "Display mode", &help, |ui| {
        for (mode, name) in DisplayMode::ALL {
            let entry = ui.selectable_label(display.mode == mode, name);
            if entry.on_hover_text(mode.about()).clicked() {
                commands.push(DisplayCommand::SetDisplay(DisplaySettings { mode, ..display }).into());
                ui.close();
            }
        }
    });
    let can = model.denoiser != DenoiserState::Unavailable;
    let help = match (can, keys.denoising) {
        (false, _) => "Built without the feature `denoise`".to_owned(),
        (true, true) => hint("Show the picture as it was sampled", "denoise", keys.bound),
        (true, false) => hint(
            "Take the noise out of the picture while it is rendered",
            "denoise",
            keys.bound,
        ),
    };
    ui.add_enabled_ui(can, |ui| {
        if icon_button(ui, ToolIcon::Denoise, keys.denoising, "Denoiser", &help).clicked() {
            commands.push(DisplayCommand::SetDenoising(!keys.denoising).into());
        }
    });
}

/// The overlays of the picture.
fn overlays(ui: &mut Ui, keys: &ActionContext, commands: &mut Vec<Command>) {
    let help = hint("The grid on the ground and the axes", "grid", keys.bound);
    if icon_button(ui, ToolIcon::Grid, keys.grid.shown, "Grid", &help).clicked() {
        let grid = GridSettings {
            shown: !keys.grid.shown,
            ..keys.grid
        };
        commands.push(DisplayCommand::SetGrid(grid).into());
    }
    icon_menu(
        ui,
        ToolIcon::Overlays,
        false,
        "Overlays",
        "What is drawn over the picture",
        |ui| {
            let mut boxes = keys.overlay.shown;
            if ui
                .checkbox(&mut boxes, "BVH boxes")
                .on_hover_text(hint("The boxes of the acceleration structure", "boxes", keys.bound))
                .changed()
            {
                let overlay = BvhOverlay {
                    shown: boxes,
                    ..keys.overlay
                };
                commands.push(DisplayCommand::SetOverlay(overlay).into());
            }
            let mut safe = keys.safe_frame;
            if ui
                .checkbox(&mut safe, "Safe frame")
                .on_hover_text("Frames of nine and eight tenths of the picture")
                .changed()
            {
                commands.push(DisplayCommand::ShowSafeFrame(safe).into());
            }
            for name in ["dimensions", "wireframe"] {
                let Some(action) = actions::find(name) else { continue };
                let mut is_on = action.is_on(keys);
                let help = hint("Of what is selected", name, keys.bound);
                if ui.checkbox(&mut is_on, action.label).on_hover_text(help).changed() {
                    commands.extend((action.command)(keys));
                }
            }
        },
    );
    let help = hint(
        "One view, or four: also from above, the front and the right",
        "four-views",
        keys.bound,
    );
    if icon_button(ui, ToolIcon::Views, keys.side_views.shown, "Four views", &help).clicked() {
        commands.push(ViewCommand::ShowSideViews(!keys.side_views.shown).into());
    }
}
