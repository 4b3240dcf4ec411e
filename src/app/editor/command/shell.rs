//! Commands for the window itself: panels, overlays, full screen, preferences, answers to questions.

use bevy::prelude::*;

use super::file_access::Question;
use super::panel::Panel;
use super::preferences::Preferences;
use super::recovery_offer::Offer;

/// What a user can do to the window itself; none of it touches the scene.
#[derive(Clone, Debug, PartialEq)]
pub enum ShellCommand {
    /// Shows a panel in front of its group, also if it was closed.
    ShowPanel(Panel),
    /// Takes a panel out of the window.
    ClosePanel(Panel),
    /// All panels as in a new window.
    ResetLayout,
    /// To the whole screen and back.
    ToggleFullScreen,
    /// Opens what lies over the window.
    ShowSheet(Sheet),
    /// Replaces all preferences; values out of range are clamped.
    SetPreferences(Box<Preferences>),
    /// Opens what was written aside before a crash.
    Recover(Offer),
    /// Deletes what was written aside before a crash.
    DiscardRecovery(Offer),
    /// Lets scenes read the folders of these files.
    AllowFiles(Question),
}

/// A sheet that covers the window until it is closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sheet {
    /// The search among all actions.
    Palette,
    /// The overview of all keys.
    Shortcuts,
    /// The controls of [`Preferences`].
    Preferences,
}
