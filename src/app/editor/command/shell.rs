//! What the user does to the window itself: panels, overlays, full screen, preferences, questions that are answered.

use bevy::prelude::*;

use super::file_access::Question;
use super::panel::Panel;
use super::preferences::Preferences;
use super::recovery_offer::Offer;

#[derive(Clone, Debug, PartialEq)]
pub enum ShellCommand {
    /// In front of its group, also if it was closed.
    ShowPanel(Panel),
    ClosePanel(Panel),
    /// All panels as in a new window.
    ResetLayout,
    ToggleFullScreen,
    ShowSheet(Sheet),
    SetPreferences(Box<Preferences>),
    /// Opens what was written aside before a crash.
    Recover(Offer),
    DiscardRecovery(Offer),
    /// Lets scenes read the folders of these files.
    AllowFiles(Question),
}

/// What lies over the window until it is closed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sheet {
    Palette,
    Shortcuts,
    Preferences,
}
