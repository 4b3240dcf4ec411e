//! The settings of the view and of the tools. None of them is part of the scene.

use bevy::prelude::Resource;

use crate::app::editor::camera::navigation::Navigation;
use crate::app::editor::command::bvh_overlay::BvhOverlay;
use crate::app::editor::command::display::DisplaySettings;
use crate::app::editor::command::gizmo_settings::GizmoSettings;
use crate::app::editor::command::stored_view::StoredViews;
use crate::app::editor::command::tool::Tool;

/// The settings that commands change and that the viewport, the menus and scripts read.
#[derive(Resource)]
pub struct ViewSettings {
    /// How the film becomes a picture.
    pub display: DisplaySettings,
    /// Boxes of the acceleration structures over the picture.
    pub overlay: BvhOverlay,
    /// Speed and centre of the view's movements.
    pub navigation: Navigation,
    /// What a drag of the gizmo does.
    pub gizmo: GizmoSettings,
    /// Views to come back to.
    pub bookmarks: StoredViews,
    /// What the next click in the picture does.
    pub tool: Tool,
    /// Frames within the picture that titles and actions should keep to.
    pub safe_frame: bool,
    /// False where the viewport fills the window.
    pub panels_shown: bool,
}

impl Default for ViewSettings {
    fn default() -> Self {
        Self {
            display: DisplaySettings::default(),
            overlay: BvhOverlay::default(),
            navigation: Navigation::default(),
            gizmo: GizmoSettings::default(),
            bookmarks: StoredViews::default(),
            tool: Tool::default(),
            safe_frame: false,
            panels_shown: true,
        }
    }
}
