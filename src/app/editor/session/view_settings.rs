//! How the scene is looked at and worked on. None of it is part of the scene.

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
    pub display: DisplaySettings,
    pub overlay: BvhOverlay,
    pub navigation: Navigation,
    pub gizmo: GizmoSettings,
    /// Views to come back to.
    pub bookmarks: StoredViews,
    pub tool: Tool,
    /// Frames within the picture that titles and actions should keep to.
    pub safe_frame: bool,
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
