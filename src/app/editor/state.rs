//! What the editor itself remembers: how the picture is shown, messages, the open dialog. None of it is saved.

use std::time::{Duration, Instant};

use bevy::prelude::*;

use super::command::{Command, FileDialogKind};
use super::display::DisplaySettings;
use super::navigation::Navigation;
use super::overlay::BvhOverlay;
use super::panels::inspector::InspectorState;
use super::panels::outliner::OutlinerState;
use super::viewport::ViewportState;

#[derive(Resource)]
pub struct EditorState {
    pub display: DisplaySettings,
    pub overlay: BvhOverlay,
    pub navigation: Navigation,
    pub panels_shown: bool,
    pub right_tab: RightTab,
    pub outliner: OutlinerState,
    pub inspector: InspectorState,
    pub viewport: ViewportState,
    pub dialog: Option<FileDialogKind>,
    /// Counts drags, typings and clicks: edits of one kind within one of them are one step of the history.
    pub interaction: u64,
    /// A text on its way to the system's clipboard.
    pub clipboard: Option<String>,
    message: Option<(String, Instant)>,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RightTab {
    #[default]
    Inspector,
    Render,
    Diagnostics,
}

/// How long a message is shown.
const MESSAGE_TIME: Duration = Duration::from_secs(5);

impl Default for EditorState {
    fn default() -> Self {
        Self {
            display: DisplaySettings::default(),
            overlay: BvhOverlay::default(),
            navigation: Navigation::default(),
            panels_shown: true,
            right_tab: RightTab::default(),
            outliner: OutlinerState::default(),
            inspector: InspectorState::default(),
            viewport: ViewportState::default(),
            dialog: None,
            interaction: 0,
            clipboard: None,
            message: None,
        }
    }
}

impl EditorState {
    /// Shows a message for a few seconds.
    pub fn say(&mut self, message: impl Into<String>) {
        let message = message.into();
        info!("{message}");
        self.message = Some((message, Instant::now()));
    }

    pub fn message(&self) -> Option<&str> {
        let (message, since) = self.message.as_ref()?;
        (since.elapsed() < MESSAGE_TIME).then_some(message.as_str())
    }
}

/// What the user did this frame, in order; applied once per frame by `commands`.
#[derive(Resource, Default)]
pub struct CommandQueue(pub Vec<Command>);
