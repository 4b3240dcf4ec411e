//! The data that the viewport shows.

use bevy::ecs::entity::EntityHashSet;
use bevy::math::{Affine3A, Vec2};
use bevy_egui::egui::{self};

use super::blocking::grips::GripModel;
use super::blocking::hand::{BlockTarget, BlockingModel};
use super::captions::Caption;
use super::gizmo::interaction::GizmoModel;
use super::icons::{Icon, MarkerPath};
use super::lamp_solid::LampSolid;
use super::path_grips::PathGripModel;
use super::side_model::SideModel;
use super::stand_ins::StandIn;
use super::texturing::{TextureTarget, TexturingModel};
use crate::app::editor::camera::navigation::Navigation;
use crate::app::editor::command::arrange::Series;
use crate::app::editor::command::compare_view::CompareView;
use crate::app::editor::command::navigation_preset::NavigationPreset;
use crate::app::editor::command::ruler::Ruler;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::command::tool::Tool;
use crate::app::editor::input::actions::ActionContext;
use crate::app::editor::input::press::Press;
use crate::app::editor::model::{Model, Outline, PaintingModel};
use crate::app::editor::picture::denoiser::DenoiserState;
use crate::app::editor::picture::depths::Depths;
use crate::app::editor::picture::lamp_light::LampFollower;
use crate::app::editor::picture::legend::Legend;
use crate::app::editor::picture::outline::SelectionOutline;
use crate::app::editor::picture::overlay::BoxList;
use crate::app::editor::picture::paths::PathInspector;
use crate::app::editor::picture::reasons::Reasons;
use crate::app::editor::picture::wireframe::Wireframe;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::engine::{Outdated, PackedScene};
use crate::math::Aabb;
use crate::render::camera::Camera;

/// The data that the viewport shows.
#[derive(Clone, Copy, Debug)]
pub struct ViewportModel<'a> {
    /// The picture and its size in pixels.
    pub picture: Option<(egui::TextureId, [u32; 2])>,
    /// The corners of the film in the picture, see [`View::film_corners`](crate::render::view::View::film_corners).
    pub film_in_picture: [Vec2; 2],
    /// Whether the view is that of a camera.
    pub is_through_camera: bool,
    /// The size of the film in pixels.
    pub proportions: [u32; 2],
    /// The text in place of the picture while there is none.
    pub placeholder: &'a str,
    /// Why a paused picture is not the one that would be rendered now.
    pub outdated: Option<Outdated>,
    /// World from camera; None without a camera.
    pub pose: Option<Affine3A>,
    /// The camera of the picture, to draw over it.
    pub camera: Option<Camera>,
    /// The boxes of the acceleration structures to draw.
    pub boxes: &'a BoxList,
    /// Why the inspected pixels are as they are; None while that is unknown.
    pub reasons: &'a Reasons,
    /// The lamp whose light is followed.
    pub lamp: &'a LampFollower,
    /// The inspected paths to draw.
    pub paths: &'a PathInspector,
    /// The outlines of selected things and of the hovered one.
    pub outline: &'a SelectionOutline,
    /// The selection as lines, if they are shown.
    pub wireframe: &'a Wireframe,
    /// The boxes of the volumes of the selection's media, as world from the unit cube.
    pub volume_boxes: &'a [Affine3A],
    /// The intensities of the selected lamp.
    pub lamp_solid: Option<&'a LampSolid>,
    /// The icons of lights and cameras, and the boxes of missing meshes.
    pub icons: &'a [Icon],
    /// The lines of markers that are paths.
    pub marker_paths: &'a [MarkerPath],
    /// The boxes of missing meshes with their names.
    pub stand_ins: &'a [StandIn],
    /// The data that the gizmo acts on.
    pub gizmo: GizmoModel<'a>,
    /// The shapes under the pointer and around it, while a tool blocks out.
    pub blocks: &'a [BlockTarget],
    /// The wall whose openings have handles: it alone is selected, and can be edited.
    pub wall: Option<&'a BlockTarget>,
    /// The textures of the selected shape, while a tool places them.
    pub textures: Option<&'a TextureTarget>,
    /// The entities that cannot be selected.
    pub locked: &'a EntityHashSet,
    /// The light you want; None where it is not painted.
    pub painting: Option<&'a PaintingModel>,
    /// The names of things.
    pub things: &'a Outline,
    /// The packed scene, for picking.
    pub packed: &'a PackedScene,
    /// The legend of false colours, if there are any.
    pub legend: Option<&'a Legend>,
    /// The texts at the edge of the picture.
    pub captions: &'a [Caption],
    /// The comparison that the picture shows.
    pub compared: CompareView,
    /// The region of the picture that is rendered, if not all; (0, 0) top left, (1, 1) bottom right.
    pub region: Option<bevy::math::Rect>,
    /// The speed and centre of the view's movements.
    pub navigation: Navigation,
    /// The state of the denoiser.
    pub denoiser: DenoiserState,
    /// Whether parts of the picture are carried over from an earlier one.
    pub is_carried_over: bool,
    /// The preset that maps drags of the mouse to navigation.
    pub preset: NavigationPreset,
    /// The context of keys.
    pub keys: ActionContext<'a>,
    /// The movement of the mouse since the last frame, in pixels, which is reported even at an edge of the screen.
    pub mouse: egui::Vec2,
    /// The box around the selection in the world.
    pub extent: Option<Aabb>,
    /// The series of copies that the open form would make.
    pub series: Option<Series>,
    /// The distances that were measured.
    pub rulers: &'a [Ruler],
    /// Whether the scene is loaded and has no shapes.
    pub is_empty: bool,
    /// The depths of the surfaces in the picture.
    pub depths: Depths<'a>,
    /// The keys pressed since the last frame, in order.
    pub presses: &'a [Press],
    /// Whether keys and mouse act on the picture, which they do not while a dialog is open.
    pub enabled: bool,
    /// The views beside the main one; none if that is shown alone.
    pub sides: &'a [SideModel<'a>],
    /// The number of the side view that this is the model of; None for the main view.
    pub side: Option<usize>,
}

impl<'a> ViewportModel<'a> {
    /// Whether there is a picture, or would be one if rendering were not paused. Overlays need its place.
    pub(super) fn has_place(&self) -> bool {
        self.picture.is_some() || self.keys.paused && self.outdated.is_some() && self.camera.is_some()
    }

    /// The data of the block-out tools.
    pub(super) fn blocking(&self) -> BlockingModel<'a> {
        BlockingModel {
            tool: self.keys.tool,
            near: self.blocks,
            step: self.gizmo.length_step,
            up: self.gizmo.up,
            unit: self.gizmo.unit,
            packed: self.packed,
            locked: self.locked,
            is_empty: self.is_empty,
        }
    }

    /// The data of the handles of openings, which the tools that select leave in place.
    pub(super) fn grips(&self) -> GripModel<'a> {
        GripModel {
            wall: self.wall.filter(|_| self.keys.tool == Tool::Select),
            step: self.gizmo.length_step,
            up: self.gizmo.up,
            unit: self.gizmo.unit,
        }
    }

    /// The data of the handles of the points of a path that alone is selected.
    pub(super) fn path_grips(&self) -> PathGripModel<'a> {
        let path = match self.keys.selection.entities() {
            [only] if self.keys.tool == Tool::Select && !self.locked.contains(only) => {
                self.marker_paths.iter().find(|path| path.entity == *only)
            }
            _ => None,
        };
        PathGripModel {
            path,
            step: self.gizmo.length_step,
            up: self.gizmo.up,
        }
    }

    /// The data of the texture tool.
    pub(super) fn texturing(&self) -> TexturingModel<'a> {
        TexturingModel {
            target: self.textures,
            packed: self.packed,
            locked: self.locked,
            unit: self.gizmo.unit,
        }
    }
}

/// The state that actions refer to, from the settings of the view and the model alone.
pub(crate) fn action_context<'a>(
    settings: &ViewSettings,
    model: &Model,
    selection: &'a Selection,
) -> ActionContext<'a> {
    ActionContext {
        display: settings.display,
        overlay: settings.overlay,
        gizmo: settings.gizmo,
        denoising: settings.denoising,
        panels_shown: settings.panels_shown,
        tool: settings.tool,
        meters: settings.meters,
        safe_frame: settings.safe_frame,
        grid: settings.grid,
        dimensions: settings.dimensions,
        seeing: settings.seeing,
        isolated: !settings.isolated.is_empty(),
        walks: settings.walks,
        side_views: settings.side_views,
        timeline_shown: model.timeline.is_shown(settings.timeline_shown),
        playing: settings.playback.is_playing(),
        ..ActionContext::new(selection)
    }
}
