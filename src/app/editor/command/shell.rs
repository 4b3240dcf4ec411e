//! Commands for the window itself: panels, overlays, full screen, preferences, answers to questions.

use super::traits::Traits;

use std::path::PathBuf;

use bevy::prelude::*;

use super::asset_kind::FileUse;
use super::file_access::Question;
use super::navigation_preset::NavigationPreset;
use super::panel::Panel;
use super::preferences::Preferences;
use super::recovery_offer::Offer;
use crate::scene::FileKind;

/// A command for the window itself; none of them changes the scene.
#[derive(Clone, Debug, PartialEq)]
pub enum ShellCommand {
    /// Shows all panels, or the viewport alone.
    ShowPanels(bool),
    /// Shows a panel in front of its group, also if it was closed.
    ShowPanel(Panel),
    /// Closes a panel.
    ClosePanel(Panel),
    /// Arranges all panels as in a new window.
    ResetLayout,
    /// Switches to the full screen and back.
    ToggleFullScreen,
    /// Opens a sheet that covers the window.
    ShowSheet(Sheet),
    /// Replaces all preferences; values out of range are clamped.
    SetPreferences(Box<Preferences>),
    /// Sets the preset of mouse navigation.
    SetNavigation(NavigationPreset),
    /// Shows a step of the tutorial, from 0; None leaves it.
    ShowTutorial(Option<usize>),
    /// Asks about an autosave, or lists them if there are several.
    ShowRecovery,
    /// Asks about this autosave.
    AskAboutRecovery(Offer),
    /// Opens an autosave.
    Recover(Offer),
    /// Deletes an autosave.
    DiscardRecovery(Offer),
    /// Adds a root folder to the browser of assets.
    AddAssetFolder(PathBuf),
    /// Removes a root folder of the browser of assets.
    RemoveAssetFolder(PathBuf),
    /// Asks whether to add or open a whole scene.
    AskAboutScene(Box<FileUse>),
    /// Lets scenes read the folders of these files.
    AllowFiles(Question),
    /// Asks for the path of a missing file.
    FindFile(SoughtFile),
}

impl ShellCommand {
    pub(super) fn traits(&self) -> Traits {
        match self {
            Self::Recover(_) => Traits::NONE.losing_edits(),
            Self::ShowPanels(_)
            | Self::ShowPanel(_)
            | Self::ClosePanel(_)
            | Self::ResetLayout
            | Self::ToggleFullScreen
            | Self::ShowSheet(_)
            | Self::SetPreferences(_)
            | Self::SetNavigation(_)
            | Self::ShowTutorial(_)
            | Self::ShowRecovery
            | Self::AskAboutRecovery(_)
            | Self::DiscardRecovery(_)
            | Self::AddAssetFolder(_)
            | Self::RemoveAssetFolder(_)
            | Self::AskAboutScene(_)
            | Self::AllowFiles(_)
            | Self::FindFile(_) => Traits::NONE,
        }
    }
}

/// A missing file that the user is asked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SoughtFile {
    /// Its kind.
    pub kind: FileKind,
    /// The path in the scene.
    pub path: PathBuf,
    /// Whether the other missing files are searched in the folder of the found one.
    pub others: bool,
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
    /// The list in which keys are changed, beside the preferences.
    Keys,
    /// The form for a series of copies.
    Series,
    /// The form for new texture coordinates.
    Projection,
    /// The form for a bake of lightmaps.
    Bake,
    /// The list of autosaves to recover.
    Recovery,
    /// The list of the files of the scene that are missing.
    Missing,
    /// The start page: sample scenes, recent files, the tutorial.
    Start,
}
