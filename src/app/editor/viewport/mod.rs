//! The panel with the picture, with its overlays and the input of the mouse. May import `model`, `input` and the
//! modules below them.

pub mod axes_widget;
pub mod blocking;
pub(crate) mod captions;
pub mod cursor;
mod cut_handle;
pub(crate) mod extent;
pub(crate) mod first_steps;
pub mod gather;
pub mod gizmo;
pub mod grid;
pub mod icons;
pub mod lamp_solid;
pub(crate) mod legend;
mod light_brush;
pub mod marks;
pub mod material_drop;
pub mod model;
pub(crate) mod outlining;
mod over_picture;
pub mod path_grips;
pub mod path_lines;
mod paused;
mod pipette;
pub(crate) mod placing;
pub mod pointer;
pub(crate) mod rulers;
mod scene_marks;
mod series;
pub mod side_model;
pub(crate) mod side_scenes;
pub mod side_views;
mod snap_menu;
pub mod stand_ins;
pub mod state;
pub mod steer_cursor;
pub mod texturing;
mod tool;
pub mod tool_icons;
pub mod toolbar;
mod volume_boxes;
mod wipe;

use std::time::Duration;

use bevy::math::{Vec2, Vec3};
use bevy_egui::egui::{self, Align2, Color32, EventFilter, FontId, Id, Pos2, Rect, Response, Sense, Stroke, Ui, pos2};

use crate::app::editor::camera::navigation::FlyInput;
use crate::app::editor::camera::picking;
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::camera::walking::Body;
use crate::app::editor::command::display::DisplayMode;
use crate::app::editor::command::{Command, ViewCommand};
use crate::app::editor::input::actions::{self, ActionContext};
use crate::app::editor::input::{self, keys};
use crate::app::editor::picture::denoiser::DenoiserState;
use crate::app::editor::picture::overlay::MAX_BOXES;
use crate::math::Aabb;
use crate::render::view::View;
use axes_widget::axes_widget;
use first_steps::first_steps;
use gizmo::interaction::{Rest, place_of_handles};
use marks::{tag, thin_frame};
use material_drop::{Takers, drop_target};
use model::ViewportModel;
use placing::{pixels_of, place_of_film, place_of_picture, place_of_view};
use scene_marks::paint_scene;
use side_views::Pane;
use state::{ScreenPixels, ViewportState};
use toolbar::{tool_column, toolbar};

/// The id of the picture, which has the keyboard when no other widget wants it.
pub const PICTURE: &str = "viewport picture";
/// The height above the foot of the picture of the speed and the legend, in points.
const CAPTION_FOOT: f32 = -36.0;
/// The shade over the surroundings of the film.
const SURROUNDINGS: Color32 = Color32::from_black_alpha(150);
const REGION: Color32 = Color32::from_rgb(230, 70, 60);

/// Shows the picture with everything over it, and adds the commands of mouse and keys to `commands`.
pub fn viewport(ui: &mut Ui, model: &ViewportModel, state: &mut ViewportState, commands: &mut Vec<Command>) {
    let mut model = *model;
    if model.keys.tool.hides_handles() {
        model.gizmo.targets = &[];
    }
    let model = &model;
    let all = ui.available_rect_before_wrap();
    ui.painter().rect_filled(all, 0.0, Color32::from_gray(18));
    let (panel, places_of_sides) = side_views::places(all, !model.sides.is_empty());
    let pixels = ui.ctx().pixels_per_point();
    state.room = Some(pixels_of(panel, pixels));
    let has_place = model.has_place();
    let view = model.packed.view.as_ref();
    let picture = match has_place {
        true => place_of_view(panel, pixels, model.proportions.into(), view),
        false => panel,
    };
    let response = ui.interact(picture, Id::new(PICTURE), Sense::click_and_drag());
    let sides = side_views::panes(ui, places_of_sides, model, state);
    match model.picture {
        Some((texture, _)) => {
            let uv = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
            let place = place_of_picture(picture, film_corners_of(view), model.film_in_picture);
            let painter = ui.painter_at(panel);
            painter.image(texture, place, uv, Color32::WHITE);
            if model.is_through_camera {
                shade_surroundings(&painter, picture, place_of_film(picture, film_corners_of(view)));
            }
        }
        // The bar over the picture says why it is black.
        None if has_place => {
            ui.painter().rect_filled(picture, 0.0, Color32::BLACK);
        }
        None => {
            let font = FontId::proportional(16.0);
            ui.painter().text(
                panel.center(),
                Align2::CENTER_CENTER,
                model.placeholder,
                font,
                Color32::GRAY,
            );
        }
    }
    let camera = model.camera.filter(|_| has_place);
    let screen = camera.map(|camera| Screen { camera, picture });
    state.picture = has_place.then(|| ScreenPixels::of(ui, picture));
    let pointed = response.hover_pos().filter(|at| has_place && picture.contains(*at));
    state.pointed = pointed.map(|at| {
        let share = (at - picture.min) / picture.size();
        bevy::math::Vec2::new(share.x, share.y)
    });
    paint_over(ui, panel, picture, screen.as_ref(), model, state);
    for (side, (pane, seen)) in sides.iter().zip(model.sides).enumerate() {
        side_views::paint(ui, pane, side, seen, model.pose, state);
    }
    if let Some(screen) = &screen
        && model.enabled
    {
        let bounds = picking::scene_bounds(model.packed).unwrap_or(Aabb::EMPTY);
        cut_handle::cut_handle(ui, screen, &bounds, &model.keys.seeing, commands);
        wipe::handle(ui, picture, model.compared, commands);
    }
    let main = Pane {
        response: response.clone(),
        screen,
        model: *model,
    };
    act(ui, panel, &main, &sides, state, commands);
    if has_place {
        toolbar(ui, all, model, commands);
        tool_column(ui, panel, &model.keys, commands);
        cut_handle::cut_bar(ui, picture, &model.keys, model.navigation.scene_size, commands);
        let tool = state.tool_mut(model.keys.tool);
        tool.bar(ui, picture, model, commands);
    }
    state.bar = None;
    state.legend = model.legend.map(|shown| legend::place(picture, shown));
    if !state.gizmo.is_dragging() {
        let handles = screen
            .as_ref()
            .and_then(|screen| place_of_handles(screen, &model.gizmo));
        state.bar = paused::bar(ui, panel, picture, handles, model, commands);
    }
    if model.is_empty && model.enabled && has_place && !model.keys.tool.blocks_out() {
        first_steps(ui, picture, &model.keys, commands);
    }
    if let (Some(pose), Some(screen), true) = (model.pose, &screen, model.enabled) {
        let center = || pointer::center(screen, model, pose);
        let bound = model.keys.bound;
        axes_widget(
            ui,
            panel,
            pose,
            &model.navigation,
            bound,
            center,
            &mut state.axes,
            commands,
        );
    }
    let takers = Takers {
        packed: model.packed,
        things: model.things,
        locked: model.locked,
    };
    drop_target(ui, &response, picture, takers, commands);
    ui.advance_cursor_after_rect(all);
}

fn film_corners_of(view: Option<&View>) -> [Vec2; 2] {
    view.map_or(View::WHOLE_FILM, View::film_corners)
}

/// Handles keys and mouse: they go to the gizmo first, the rest of the mouse turns and moves the view, and the rest of
/// the keys are shortcuts.
///
/// The view under the pointer gets them. Flying keys are for the main view, wherever the pointer is.
fn act(ui: &Ui, panel: Rect, main: &Pane, sides: &[Pane], state: &mut ViewportState, commands: &mut Vec<Command>) {
    let last = state.panes.active;
    state.panes.follow(ui, sides, &state.gizmo);
    let side = state.panes.active;
    if side != last {
        // A drag ends with its view: it must not go on with another camera.
        state.pointer.let_go(ui);
        state.grips.let_go();
    }
    let active = side.and_then(|side| sides.get(side)).unwrap_or(main);
    let Pane { response, model, .. } = active;
    let is_pressed = response.is_pointer_button_down_on();
    let has_keyboard = takes_keyboard(ui, &main.response, is_pressed, model.enabled);
    let presses = if has_keyboard { model.presses } else { &[] };
    let mut rest = Rest {
        pointer: model.enabled,
        presses: presses.to_vec(),
    };
    let was_flying = std::mem::take(&mut state.flying);
    let mut look = Vec2::ZERO;
    let mut moved = model.pose;
    if let (Some(screen), Some(pose), true) = (&active.screen, &mut moved, model.enabled) {
        state.leave_other_tools(model.keys.tool);
        // Side views show no colours of the picture.
        let takes_color = side.is_none() && pipette::follow(ui, response, screen, model);
        if takes_color {
            rest = Rest {
                pointer: false,
                presses: Vec::new(),
            };
        }
        if rest.pointer && !state.gizmo.is_dragging() {
            let grips = &mut state.grips;
            rest = grips.follow_grips(ui, response, screen, &model.grips(), presses, commands);
            if rest.pointer {
                let model = model.path_grips();
                let presses = std::mem::take(&mut rest.presses);
                rest = (state.path_grips).follow(ui, response, screen, &model, &presses, commands);
            }
        }
        if rest.pointer {
            let tool = state.tool_mut(model.keys.tool);
            rest = tool.follow(ui, response, screen, model, &rest.presses, commands);
        }
        let pointer = ui.input(|input| input.pointer.latest_pos());
        let is_over_axes = pointer.is_some_and(|pointer| axes_widget::place(panel).contains(pointer));
        let is_free = rest.pointer && !is_over_axes;
        look = state
            .pointer
            .follow(ui, response, screen, model, is_free, pose, commands);
    } else {
        state.grips.let_go();
        state.path_grips.let_go();
        state.pointer.let_go(ui);
        state.pointer.hovered = None;
    }
    let fly = ui.input(|input| {
        let modifiers = input.modifiers;
        // Control with a letter is a shortcut, unless the user is flying already.
        let flies = modifiers.is_none() || modifiers.shift_only() || state.pointer.is_looking() || was_flying;
        let is_dragging = state.gizmo.is_dragging() || state.grips.is_busy() || state.path_grips.is_busy();
        let keys_fly = has_keyboard && !is_dragging && !modifiers.alt && flies;
        FlyInput {
            direction: if keys_fly {
                keys::fly_direction(input, model.keys.bound)
            } else {
                Vec3::ZERO
            },
            look,
            fast: modifiers.shift,
            slow: modifiers.command,
            seconds: input.unstable_dt,
        }
    });
    let is_moving = fly.direction != Vec3::ZERO;
    state.flying = state.pointer.is_looking() || is_moving;
    if let (Some(side), Some(pose)) = (side, moved) {
        commands.extend(side_views::moved(side, &pose, model));
        moved = main.model.pose;
    }
    if let Some(pose) = moved {
        let flown = match main.model.keys.walks {
            true => {
                let body = Body::person(main.model.gizmo.unit);
                state.gait.follow(&body, &model.navigation, pose, &fly, model.packed)
            }
            false => model.navigation.fly(pose, &fly).unwrap_or(pose),
        };
        if Some(flown) != main.model.pose && flown.is_finite() {
            commands.push(ViewCommand::MoveView(flown).into());
        }
    }
    state.speed.follow(ui, is_moving, model.navigation.speed);
    if state.flying || main.model.keys.walks && state.gait.is_on_the_move() {
        // Time passes without further events while a key is held.
        ui.ctx().request_repaint_after(Duration::from_millis(16));
    }
    let context = ActionContext {
        flying: state.flying || was_flying,
        ..main.model.keys
    };
    let meant = keys::shortcuts(&rest.presses, &context).into_iter();
    commands.extend(meant.filter_map(|command| match side {
        Some(side) => side_views::in_side(command, side, model),
        None => Some(command),
    }));
}

/// Gives the keyboard to the picture whenever no other widget wants it. It then keeps Tab, arrows and Escape to itself.
/// It also takes it when one of the views `is_pressed`. Without `enabled` it gives the keyboard back.
fn takes_keyboard(ui: &Ui, response: &Response, is_pressed: bool, enabled: bool) -> bool {
    if !enabled || ui.ctx().any_popup_open() {
        response.surrender_focus();
        return false;
    }
    let focused = ui.memory(|memory| memory.focused());
    if focused.is_none() || is_pressed {
        response.request_focus();
    }
    let filter = EventFilter {
        tab: true,
        horizontal_arrows: true,
        vertical_arrows: true,
        escape: true,
    };
    ui.memory_mut(|memory| memory.set_focus_lock_filter(response.id, filter));
    response.has_focus()
}

/// The opacity of the grid and the axes of the world. They are for work in the picture, and fade while the pointer is
/// elsewhere.
fn strength_of_grid(ui: &Ui, picture: Rect, model: &ViewportModel) -> f32 {
    const FADED: f32 = 0.25;
    const SECONDS: f32 = 0.25;
    let is_wanted = model.is_empty || model.keys.tool.blocks_out() || ui.rect_contains_pointer(picture);
    let shown = ui
        .ctx()
        .animate_bool_with_time(Id::new("strength of the grid"), is_wanted, SECONDS);
    egui::lerp(FADED..=1.0, shown)
}

/// The width of a panel, in points, from which there is room for notes beside the toolbar.
const BESIDE_TOOLBAR: f32 = 960.0;

fn paint_over(
    ui: &Ui,
    panel: Rect,
    picture: Rect,
    screen: Option<&Screen>,
    model: &ViewportModel,
    state: &ViewportState,
) {
    let painter = ui.painter_at(picture);
    if let Some(screen) = screen {
        let mut faded = painter.clone();
        faded.set_opacity(strength_of_grid(ui, picture, model));
        grid::paint(
            &faded,
            Id::new(PICTURE),
            screen,
            model.navigation.up,
            &model.keys.grid,
            model.depths,
        );
    }
    model.outline.paint(&painter, picture, Id::new(PICTURE));
    let film = place_of_film(picture, film_corners_of(model.packed.view.as_ref()));
    if let Some(screen) = screen {
        paint_scene(ui, &painter, screen, model, state, state.panes.active.is_none());
        pipette::paint(ui, &painter, screen, model);
    }
    if let Some(region) = model.region {
        let corner = |corner: Vec2| placing::at(film, corner);
        let border = Rect::from_two_pos(corner(region.min), corner(region.max)).intersect(picture);
        painter.rect_stroke(border, 0.0, Stroke::new(1.5, REGION), egui::StrokeKind::Inside);
    }
    if let Some(inspected) = model.paths.wanted.filter(|wanted| wanted.extent != Vec2::ZERO) {
        let corners = [inspected.place, inspected.place + inspected.extent].map(|corner| placing::at(film, corner));
        thin_frame(&painter, Rect::from_two_pos(corners[0], corners[1]), 200);
    }
    if film != panel && (model.is_through_camera || model.keys.safe_frame) && model.has_place() {
        thin_frame(&ui.painter_at(panel), film, 140);
    }
    if model.keys.safe_frame {
        safe_frame(&painter, film);
    }
    let next = state.tool(model.keys.tool).hint(model);
    let takes_color = input::pipette::is_waiting(ui.ctx()).then_some(pipette::HINT);
    let hint = takes_color.or(next.as_deref()).or(model.keys.tool.hint()).map(|hint| {
        let at = egui::pos2(picture.center().x, (picture.top() + 8.0).max(panel.top() + 42.0));
        tag(&painter, at, Align2::CENTER_TOP, hint)
    });
    let notes = notes(model);
    let mut corner = picture.left_top() + egui::vec2(8.0, 8.0);
    // Texts that begin in a low, wide picture, or have many lines, are placed beside the tools.
    let tools = toolbar::column_place(panel);
    let beside_tools = |corner: egui::Pos2, words: &str| {
        let height = 6.0 + 15.0 * words.lines().count() as f32;
        match Rect::from_min_size(corner, egui::vec2(1.0, height)).intersects(tools) {
            true => egui::pos2(tools.right() + 8.0, corner.y),
            false => corner,
        }
    };
    if !notes.is_empty() {
        // Together they may be wider than the picture, and the toolbar reaches over a narrow one.
        if let Some(hint) = hint {
            corner.y = hint.bottom() + 4.0;
        } else if panel.width() < BESIDE_TOOLBAR {
            corner.y = corner.y.max(panel.top() + 42.0);
        }
        let notes = notes.join("   ");
        let place = beside_tools(corner, &notes);
        corner.y = tag(&painter, place, Align2::LEFT_TOP, &notes).bottom() + 4.0;
    }
    if model.keys.overlay.shown && model.picture.is_some() {
        let figures = model.boxes.figures(&model.keys.overlay);
        tag(&painter, beside_tools(corner, &figures), Align2::LEFT_TOP, &figures);
    }
    if model.pose.is_some() && state.speed.is_shown(ui) {
        let speed = format!(
            "speed {:.2}x, {:.3} units/s",
            model.navigation.speed,
            model.navigation.units_per_second()
        );
        tag(
            &painter,
            picture.left_bottom() + egui::vec2(8.0, -8.0),
            Align2::LEFT_BOTTOM,
            &speed,
        );
    }
    for (middle, words) in model.captions {
        let place = picture.left_bottom() + egui::vec2(middle * picture.width(), CAPTION_FOOT);
        tag(&painter, place, Align2::CENTER_BOTTOM, words);
    }
    if let Some(shown) = model.legend {
        legend::paint(&painter, picture, shown);
    }
}

/// The notes in the corner of the picture: what it shows other than usual.
fn notes(model: &ViewportModel) -> Vec<String> {
    let mut notes = Vec::new();
    if model.camera.is_some_and(|camera| camera.is_orthographic()) {
        notes.push("Orthographic".to_owned());
    }
    if model.keys.display.mode != DisplayMode::Shaded {
        notes.push(model.keys.display.mode.name().to_owned());
    }
    if let DenoiserState::Shown { seconds, samples } = model.denoiser {
        notes.push(format!("denoised, {samples} spp, {seconds:.1} s"));
    }
    if model.is_carried_over {
        notes.push("carried over".to_owned());
    }
    if model.keys.overlay.shown {
        let (shown, total) = (model.boxes.boxes.len(), model.boxes.total);
        notes.push(if total > MAX_BOXES {
            format!("{shown} of {total} boxes")
        } else {
            format!("{total} boxes")
        });
    }
    if model.keys.paused && paused::words(model).is_none() {
        notes.push("Paused".to_owned());
    }
    // The view may have come to it by itself, or long ago: the key tells how it ends.
    let isolated = model.keys.isolated.then_some(("Shown alone", "isolate"));
    let walks = model.keys.walks.then_some(("Walking", "walk"));
    let left_out = model.keys.seeing.notes().chain(isolated).chain(walks);
    notes.extend(left_out.map(|(text, action)| actions::hint(text, action, model.keys.bound)));
    if let [total, drawn] = model.wireframe.triangles
        && drawn < total
    {
        notes.push(format!("{drawn} of {total} triangles as lines"));
    }
    notes
}

/// Darkens the surroundings of the film while one looks through a camera.
fn shade_surroundings(painter: &egui::Painter, picture: Rect, film: Rect) {
    let surroundings = [
        Rect::from_min_max(picture.min, pos2(picture.right(), film.top())),
        Rect::from_min_max(pos2(picture.left(), film.top()), film.left_bottom()),
        Rect::from_min_max(film.right_top(), pos2(picture.right(), film.bottom())),
        Rect::from_min_max(pos2(picture.left(), film.bottom()), picture.max),
    ];
    for place in surroundings.into_iter().filter(Rect::is_positive) {
        painter.rect_filled(place, 0.0, SURROUNDINGS);
    }
}

/// Shows frames of nine tenths of the picture for actions and eight for titles, as television has it (SMPTE ST 2046-1
/// has 93 and 90 per cent since).
fn safe_frame(painter: &egui::Painter, picture: Rect) {
    for share in [0.9, 0.8] {
        let frame = Rect::from_center_size(picture.center(), share * picture.size());
        thin_frame(painter, frame, 140);
    }
}
