//! What the editor itself remembers: how the picture is shown, messages, the open dialog. None of it is saved.

use bevy::prelude::*;
use bevy_egui::egui::Rect;

use super::command::{Command, FileDialogKind};
use super::display::DisplaySettings;
use super::gizmo::GizmoSettings;
use super::layout::Panel;
use super::navigation::Navigation;
use super::overlay::BvhOverlay;
use super::palette::Palette;
use super::panels::inspector::InspectorState;
use super::panels::library::LibraryState;
use super::panels::outliner::OutlinerState;
use super::save_question::SaveQuestion;
use super::shell::Sheet;
use super::stored_views::StoredViews;
use super::toasts::{Toasts, Tone, Topic};
use super::tool::Tool;
use super::viewport::ViewportState;

#[derive(Resource)]
pub struct EditorState {
    pub display: DisplaySettings,
    pub overlay: BvhOverlay,
    pub navigation: Navigation,
    pub gizmo: GizmoSettings,
    /// Views to come back to.
    pub bookmarks: StoredViews,
    pub panels_shown: bool,
    /// To be brought to the front of its group, unless it is closed.
    pub wanted_panel: Option<Panel>,
    pub outliner: OutlinerState,
    /// The panel with the library of materials.
    pub shelf: LibraryState,
    pub inspector: InspectorState,
    pub viewport: ViewportState,
    pub dialog: Option<FileDialogKind>,
    /// How to save a file that others changed.
    pub save_question: Option<SaveQuestion>,
    /// Counts drags, typings and clicks: edits of one kind within one of them are one step of the history.
    pub interaction: u64,
    pub tool: Tool,
    /// Frames within the picture that titles and actions should keep to.
    pub safe_frame: bool,
    /// A text on its way to the system's clipboard.
    pub clipboard: Option<String>,
    pub toasts: Toasts,
    /// What lies over the window.
    pub sheet: Option<Sheet>,
    pub palette: Palette,
    /// The user wants to close the window.
    pub closes: bool,
    /// Where the picture's panel is, points.
    pub viewport_place: Rect,
}

impl Default for EditorState {
    fn default() -> Self {
        Self {
            display: DisplaySettings::default(),
            overlay: BvhOverlay::default(),
            navigation: Navigation::default(),
            gizmo: GizmoSettings::default(),
            bookmarks: StoredViews::default(),
            panels_shown: true,
            wanted_panel: None,
            outliner: OutlinerState::default(),
            shelf: LibraryState::default(),
            inspector: InspectorState::default(),
            viewport: ViewportState::default(),
            dialog: None,
            save_question: None,
            interaction: 0,
            tool: Tool::default(),
            safe_frame: false,
            clipboard: None,
            toasts: Toasts::default(),
            sheet: None,
            palette: Palette::default(),
            closes: false,
            viewport_place: Rect::ZERO,
        }
    }
}

impl EditorState {
    /// Something was done.
    pub fn say(&mut self, message: impl Into<String>) {
        let message = message.into();
        info!("{message}");
        self.toasts.add(Tone::Note, Topic::Other, message, None);
    }

    /// Something that was asked for cannot be done.
    pub fn refuse(&mut self, message: impl Into<String>) {
        let message = message.into();
        info!("{message}");
        self.toasts.add(Tone::Warning, Topic::Other, message, None);
    }

    /// Something has happened that is perhaps not meant.
    pub fn warn(&mut self, message: impl Into<String>) {
        let message = message.into();
        warn!("{message}");
        self.toasts.add(Tone::Warning, Topic::Other, message, None);
    }

    /// Something is broken, until it is dismissed or mended. `excerpt`: the lines of a file that it is about.
    pub fn complain(&mut self, topic: Topic, message: impl Into<String>, excerpt: Option<String>) {
        let message = message.into();
        error!("{message}");
        self.toasts.add(Tone::Error, topic, message, excerpt);
    }
}

/// What the user did this frame, in order; applied once per frame by `commands`.
#[derive(Resource, Default)]
pub struct CommandQueue(pub Vec<Command>);
