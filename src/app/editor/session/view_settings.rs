//! The settings of the view and of the tools. None of them is part of the scene.

use bevy::prelude::{Entity, Resource, Vec3};

use crate::app::editor::camera::navigation::Navigation;
use crate::app::editor::command::bvh_overlay::BvhOverlay;
use crate::app::editor::command::display::DisplaySettings;
use crate::app::editor::command::gizmo_settings::GizmoSettings;
use crate::app::editor::command::grid_settings::GridSettings;
use crate::app::editor::command::meter_choice::MeterChoice;
use crate::app::editor::command::resolution::{Enlarging, Resolution};
use crate::app::editor::command::ruler::Ruler;
use crate::app::editor::command::seeing::{Seeing, Walls};
use crate::app::editor::command::side_views::SideViews;
use crate::app::editor::command::stored_view::StoredViews;
use crate::app::editor::command::timeline::Timeline;
use crate::app::editor::command::tool::Tool;
use crate::app::editor::session::playback::Playback;
use crate::engine::SightControl;
use crate::render::visibility::sight::CutPlane;

/// The settings that commands change and that the viewport, the menus and scripts read.
#[derive(Resource)]
pub struct ViewSettings {
    /// The display settings, which turn the film into a picture.
    pub display: DisplaySettings,
    /// Whether the picture is denoised while it is rendered.
    pub denoising: bool,
    /// The overlay of the boxes of the acceleration structures.
    pub overlay: BvhOverlay,
    /// The speed and centre of the view's movements.
    pub navigation: Navigation,
    /// Whether flying keys walk on the floor.
    pub walks: bool,
    /// The mode, axes, pivot and snapping of the gizmo.
    pub gizmo: GizmoSettings,
    /// The step of lengths fixed when a building tool was first chosen in this scene, so that the grid stays as it is
    /// while the scene grows. None before that.
    pub building_step: Option<f32>,
    /// The pixels of the film that are traced.
    pub resolution: Resolution,
    /// The look of a picture of few pixels.
    pub enlarging: Enlarging,
    /// The stored views.
    pub bookmarks: StoredViews,
    /// The tool for the next click in the picture.
    pub tool: Tool,
    /// Whether the frames for titles and actions are shown.
    pub safe_frame: bool,
    /// Whether the dimensions of the selection are shown in the picture.
    pub dimensions: bool,
    /// The measured distances.
    pub rulers: Vec<Ruler>,
    /// The quantities that meters measure.
    pub meters: MeterChoice,
    /// The grid on the ground and the axes of the world.
    pub grid: GridSettings,
    /// The filters of the view: cut plane and hidden walls.
    pub seeing: Seeing,
    /// The isolated shapes. If it is empty, all are shown.
    pub isolated: Vec<Entity>,
    /// The views beside the main one.
    pub side_views: SideViews,
    /// The frames of the timeline.
    pub timeline: Timeline,
    /// The playback of the timeline.
    pub playback: Playback,
    /// Whether the timeline is shown. None: shown if the scene has keys.
    pub timeline_shown: Option<bool>,
    /// Whether the panels are shown; otherwise the viewport fills the window.
    pub panels_shown: bool,
}

impl ViewSettings {
    /// The step of lengths in world units: the chosen one, or the one fixed when building began, or the one that suits
    /// the scene now.
    pub fn length_step(&self) -> f32 {
        let steps = &self.gizmo.steps;
        let kept = self.building_step.filter(|_| steps.length.is_none());
        kept.unwrap_or_else(|| steps.length_in(self.navigation.scene_size))
    }

    /// Whether walls between the camera and a room are hidden.
    pub(crate) fn hides_walls(&self) -> bool {
        self.seeing.walls != Walls::Shown
    }

    /// The filters of the view for the renderer.
    pub(crate) fn sight(&self) -> SightControl {
        let cut = self.seeing.cut.map(|cut| {
            let side = if cut.above { 1.0 } else { -1.0 };
            CutPlane {
                normal: side * Vec3::AXES[cut.axis],
                offset: side * cut.at,
            }
        });
        SightControl {
            passes_backs: self.hides_walls(),
            cut,
            only: self.isolated.clone(),
        }
    }
}

impl Default for ViewSettings {
    fn default() -> Self {
        Self {
            display: DisplaySettings::default(),
            denoising: false,
            overlay: BvhOverlay::default(),
            navigation: Navigation::default(),
            walks: false,
            gizmo: GizmoSettings::default(),
            building_step: None,
            resolution: Resolution::default(),
            enlarging: Enlarging::default(),
            bookmarks: StoredViews::default(),
            tool: Tool::default(),
            safe_frame: false,
            dimensions: false,
            rulers: Vec::new(),
            meters: MeterChoice::default(),
            grid: GridSettings::default(),
            seeing: Seeing::default(),
            isolated: Vec::new(),
            side_views: SideViews::default(),
            timeline: Timeline::default(),
            playback: Playback::default(),
            timeline_shown: None,
            panels_shown: true,
        }
    }
}
