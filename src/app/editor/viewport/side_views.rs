//! The side views beside the main view: their places in the panel, the view that gets mouse and keys, and their
//! painting. Tools and navigation are those of the main view, with the camera of the view under the pointer.

use bevy::math::{Affine3A, Vec2, Vec3};
use bevy::prelude::Entity;
use bevy_egui::egui::{
    self, Align2, Color32, Id, Painter, Pos2, Rect, Response, Sense, Stroke, StrokeKind, TextureHandle, TextureOptions,
    Ui, pos2,
};

use super::gizmo::interaction::{GizmoModel, GizmoState};
use super::icons::{Icon, IconKind};
use super::marks::tag;
use super::model::ViewportModel;
use super::scene_marks::paint_scene;
use super::side_model::{COUNT, PaneState, SideModel};
use super::state::{ScreenPixels, ViewportState};
use super::{grid, icons};
use crate::app::editor::camera::picking;
use crate::app::editor::camera::screen::Screen;
use crate::app::editor::command::arrange::Direction;
use crate::app::editor::command::side_views::{SIDES, SidePlace};
use crate::app::editor::command::tool::Tool;
use crate::app::editor::command::{ArrangeEdit, Command, EditCommand, ViewCommand};
use crate::app::editor::input::actions::ActionContext;
use crate::app::editor::picture::depths::Depths;
use crate::app::editor::picture::side_pictures::SidePicture;
use crate::math::Aabb;

/// The gap between the views, in points.
const GAP: f32 = 2.0;
/// The border of the view that the mouse is used in.
const FRAME: Color32 = Color32::from_gray(110);
/// The mark of the main view.
const EYE: Color32 = Color32::WHITE;
const BACKGROUND: Color32 = Color32::from_gray(40);

/// The places of the main view and of the side views in the panel. The main view is at the upper left, the view from
/// above beside it and those from the front and the right below, as in the editors of levels.
pub(super) fn places(panel: Rect, has_sides: bool) -> (Rect, [Rect; COUNT]) {
    if !has_sides {
        return (panel, [Rect::NOTHING; COUNT]);
    }
    // Whole points, so that the pixels of the pictures stay sharp.
    let middle = panel.center().round();
    let (left, right) = (middle.x - 0.5 * GAP, middle.x + 0.5 * GAP);
    let (above, below) = (middle.y - 0.5 * GAP, middle.y + 0.5 * GAP);
    let sides = [
        Rect::from_min_max(pos2(right, panel.top()), pos2(panel.right(), above)),
        Rect::from_min_max(pos2(panel.left(), below), pos2(left, panel.bottom())),
        Rect::from_min_max(pos2(right, below), panel.right_bottom()),
    ];
    (Rect::from_min_max(panel.left_top(), pos2(left, above)), sides)
}

/// A view in the panel.
pub(super) struct Pane<'a> {
    /// The place of its picture, which takes drags and clicks.
    pub response: Response,
    pub screen: Option<Screen>,
    pub model: ViewportModel<'a>,
}

/// The id of the picture of a side view.
pub fn id(side: usize) -> Id {
    Id::new(("picture of a side view", side))
}

/// The side views at their places. `state` takes their sizes.
pub(super) fn panes<'a>(
    ui: &Ui,
    places: [Rect; COUNT],
    model: &ViewportModel<'a>,
    state: &mut ViewportState,
) -> Vec<Pane<'a>> {
    let is_shown = model.keys.side_views.shown;
    state.sides = is_shown.then(|| places.map(|place| ScreenPixels::of(ui, place)));
    let pane = |(side, (seen, place)): (usize, (&SideModel<'a>, Rect))| {
        let camera = seen.packed.view.as_ref().map(|view| view.camera);
        Pane {
            response: ui.interact(place, id(side), Sense::click_and_drag()),
            screen: camera.map(|camera| Screen { camera, picture: place }),
            model: of_side(model, seen, side),
        }
    };
    let panes: Vec<Pane> = model.sides.iter().zip(places).enumerate().map(pane).collect();
    let packed = panes.iter().map(|pane| pane.model.packed.view.as_ref());
    let packed = packed.map(|view| view.map(|view| [view.width, view.height]));
    let shown = state.sides.iter().flatten().map(|shown| Some(shown.size.to_array()));
    // Without a scene nothing is packed, however often it is asked for.
    let is_packed = model.packed.scene.is_some() && model.packed.view.is_some();
    if is_packed && !packed.eq(shown) {
        // The views are packed for these sizes before the next frame is shown.
        ui.ctx().request_repaint();
    }
    panes
}

/// The model of a side view: that of the main view with another camera.
fn of_side<'a>(model: &ViewportModel<'a>, seen: &SideModel<'a>, side: usize) -> ViewportModel<'a> {
    let tool = match model.keys.tool {
        // These are about the picture of the main view.
        Tool::Focus | Tool::Region | Tool::Paths | Tool::PaintLight => Tool::Select,
        tool => tool,
    };
    ViewportModel {
        side: Some(side),
        pose: Some(seen.pose),
        camera: seen.packed.view.as_ref().map(|view| view.camera),
        packed: seen.packed,
        outline: seen.outline,
        depths: Depths::UNKNOWN,
        gizmo: GizmoModel {
            packed: seen.packed,
            ..model.gizmo
        },
        keys: ActionContext { tool, ..model.keys },
        ..*model
    }
}

impl PaneState {
    /// Finds the view that has the mouse: the one in which a button went down as long as it is down, and the one under
    /// the pointer otherwise. A drag by the handles that follows the pointer without a button stays in its view too.
    pub(super) fn follow(&mut self, ui: &Ui, panes: &[Pane], gizmo: &GizmoState) {
        let (at, is_down) = ui.input(|input| {
            let at = input.pointer.press_origin().or(input.pointer.latest_pos());
            (at, input.pointer.any_down())
        });
        if !(self.is_held || gizmo.follows_pointer()) {
            let is_there = |pane: &Pane| at.is_some_and(|at| pane.response.rect.contains(at));
            let active = panes.iter().position(is_there);
            if active != self.active {
                self.active = active;
                ui.ctx().request_repaint();
            }
        }
        self.is_held = is_down;
        self.active = self.active.filter(|side| *side < panes.len());
    }
}

/// The command that a key of the main view gives in a side view; None if there is nothing to frame.
pub(super) fn in_side(command: Command, side: usize, model: &ViewportModel) -> Option<Command> {
    match command {
        Command::View(ViewCommand::FrameSelection) => {
            let place = match model.extent {
                Some(bounds) => framing(&bounds, side, model)?,
                None => around_selection(side, model)?,
            };
            Some(ViewCommand::PlaceSideView(side, place).into())
        }
        Command::View(ViewCommand::FrameAll) => {
            let bounds = picking::scene_bounds(model.packed).unwrap_or(Aabb::EMPTY);
            Some(ViewCommand::PlaceSideView(side, framing(&bounds, side, model)?).into())
        }
        Command::View(ViewCommand::SetSeeing(seeing)) if seeing.walls != model.keys.seeing.walls => {
            let is_closed = model.keys.side_views.closed.get(side).copied()?;
            Some(ViewCommand::CloseSideView(side, !is_closed).into())
        }
        Command::Edit(EditCommand::Arrange(ArrangeEdit::Nudge(direction))) => {
            let along = across(direction, model).map_or(ArrangeEdit::Nudge(direction), ArrangeEdit::NudgeAlong);
            Some(along.into())
        }
        other => Some(other),
    }
}

/// The place that shows all of `bounds`; None before the view has been packed.
fn framing(bounds: &Aabb, side: usize, model: &ViewportModel) -> Option<SidePlace> {
    let view = model.packed.view.as_ref()?;
    let aspect = view.width as f32 / view.height as f32;
    Some(SidePlace::framing(bounds, SIDES[side].0, aspect, &model.navigation))
}

/// The place with the selection in its middle, for lights and cameras, which have no extent. It is not narrower than
/// the present one. None without a selection.
fn around_selection(side: usize, model: &ViewportModel) -> Option<SidePlace> {
    let targets = model.gizmo.targets.iter();
    let points = targets.map(|target| Vec3::from(target.to_world.translation));
    let bounds = points
        .map(|point| Aabb { min: point, max: point })
        .reduce(Aabb::union)?;
    let (shown, place) = (model.keys.side_views.places[side]?, framing(&bounds, side, model)?);
    Some(SidePlace {
        height: place.height.max(shown.height),
        ..place
    })
}

/// The direction of an arrow key across the view, in world space; None for directions that are the same in all views.
fn across(direction: Direction, model: &ViewportModel) -> Option<Vec3> {
    let axes = model.pose?.matrix3;
    let [left, upward] = [axes.x_axis, axes.y_axis].map(Vec3::from);
    match direction {
        Direction::Left => Some(left),
        Direction::Right => Some(-left),
        Direction::Ahead => Some(upward),
        Direction::Back => Some(-upward),
        Direction::Up | Direction::Down => None,
    }
}

/// The command that moves a side view from its pose to another one.
pub(super) fn moved(side: usize, to: &Affine3A, model: &ViewportModel) -> Option<Command> {
    let (from, views) = (model.pose?, model.keys.side_views);
    let place = views.places.get(side).copied().flatten()?;
    let is_moved = *to != from && to.is_finite();
    is_moved.then(|| ViewCommand::PlaceSideView(side, place.moved(&from, to)).into())
}

/// Paints a side view with everything over its picture. `main` is the pose of the main view, which is marked.
pub(super) fn paint(
    ui: &Ui,
    pane: &Pane,
    side: usize,
    seen: &SideModel,
    main: Option<Affine3A>,
    state: &ViewportState,
) {
    let place = pane.response.rect;
    let painter = ui.painter_at(place);
    painter.rect_filled(place, 0.0, BACKGROUND);
    if let (Some(picture), Some(screen)) = (seen.picture, &pane.screen) {
        paint_picture(&painter, picture, side, screen);
    }
    let is_active = state.panes.active == Some(side);
    if let Some(screen) = &pane.screen {
        let model = &pane.model;
        grid::paint(
            &painter,
            id(side),
            screen,
            model.navigation.up,
            &model.keys.grid,
            model.depths,
        );
        model.outline.paint(&painter, place, id(side));
        let eye = main.map(|pose| Icon {
            entity: Entity::PLACEHOLDER,
            kind: IconKind::Frustum,
            pose,
            tint: None,
        });
        icons::paint(&painter, screen, eye.as_slice(), |_| EYE);
        paint_scene(ui, &painter, screen, model, state, is_active);
    }
    let corner = place.left_bottom() + egui::vec2(8.0, -8.0);
    let name = match pane.model.keys.side_views.closed[side] {
        true => format!("{}, closed", SIDES[side].1),
        false => SIDES[side].1.to_owned(),
    };
    tag(&painter, corner, Align2::LEFT_BOTTOM, &name);
    if is_active {
        painter.rect_stroke(place, 0.0, Stroke::new(1.0, FRAME), StrokeKind::Inside);
    }
}

/// The picture that is on the GPU, by its number.
type Uploaded = Option<(u64, TextureHandle)>;

/// Paints a picture where its camera saw it: the view may have moved since.
fn paint_picture(painter: &Painter, picture: &SidePicture, side: usize, screen: &Screen) {
    let id = id(side).with("texture");
    let context = painter.ctx();
    let mut uploaded: Uploaded = context.data(|data| data.get_temp(id)).flatten();
    if uploaded.as_ref().is_none_or(|(number, _)| *number != picture.number) {
        match &mut uploaded {
            Some((number, texture)) => {
                texture.set(picture.image.clone(), TextureOptions::LINEAR);
                *number = picture.number;
            }
            None => {
                let texture = context.load_texture("side view", picture.image.clone(), TextureOptions::LINEAR);
                uploaded = Some((picture.number, texture));
            }
        }
        context.data_mut(|data| data.insert_temp(id, uploaded.clone()));
    }
    let corner = |film: Vec2| {
        let (film, _) = screen.camera.project(picture.camera.unproject(film, 0.0));
        screen.point_of_film(film)
    };
    if let Some((_, texture)) = uploaded {
        let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
        painter.image(
            texture.id(),
            Rect::from_min_max(corner(Vec2::ZERO), corner(Vec2::ONE)),
            whole,
            Color32::WHITE,
        );
    }
}
