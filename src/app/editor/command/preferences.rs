//! The preferences, which are remembered between runs, and the ranges of their values.

use std::path::{Path, PathBuf};

use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::gizmo_settings::Steps;
use super::grid_settings::GridSettings;
use super::key_bindings::KeyBindings;
use super::lenient::or_default;
use super::navigation_preset::NavigationPreset;
use super::resolution::{Enlarging, Resolution};
use super::snapping::Snapping;
use crate::memory;
use crate::render::tonemap::ToneMap;

/// The version of the file's format.
const VERSION: u32 = 1;

pub(crate) const MOST_RECENT_FILES: usize = 10;
/// The most folders of the user in the browser of assets.
const MOST_ASSET_FOLDERS: usize = 50;

/// The colours of the window.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ThemeChoice {
    /// Light text on dark grey.
    #[default]
    Dark,
    /// The theme has dark text on light grey.
    Light,
    /// Follows the theme of the system.
    System,
}

/// The size and the place of the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct WindowPlace {
    /// Width and height in points.
    pub size: [u32; 2],
    /// The upper left corner in pixels of the screens; None if the system does not report it.
    pub position: Option<[i32; 2]>,
}

impl WindowPlace {
    /// The range of each side.
    pub const SIDES: std::ops::RangeInclusive<u32> = 320..=16_384;
    /// The farthest that a corner may be from the first screen's, along each axis.
    const FARTHEST: i32 = 100_000;

    /// The place with a size that can be used, and without a position that no screen has.
    pub(crate) fn within_range(self) -> Self {
        let is_near = |position: &[i32; 2]| position.iter().all(|at| at.unsigned_abs() <= Self::FARTHEST as u32);
        Self {
            size: self
                .size
                .map(|side| side.clamp(*Self::SIDES.start(), *Self::SIDES.end())),
            position: self.position.filter(is_near),
        }
    }
}

/// The choices of a user for all scenes; a JSON file holds them.
#[derive(Resource, Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Preferences {
    /// The version of the file's format.
    pub version: u32,
    /// The colours of the window.
    #[serde(deserialize_with = "or_default")]
    pub theme: ThemeChoice,
    /// The scale of texts and controls, beside that of the system.
    pub ui_scale: f32,
    /// The seconds between autosaves; 0 is never.
    pub autosave_seconds: u32,
    /// The tone map of a new window. Preferences from before this choice keep the hard clip that they had.
    #[serde(with = "tone_map_by_name", default = "hard_clip")]
    pub tone_map: ToneMap,
    /// Whether the picture is denoised while it is rendered.
    pub denoising: bool,
    /// The keys that the user has chosen.
    pub keys: KeyBindings,
    /// The preset of mouse navigation.
    #[serde(deserialize_with = "or_default")]
    pub navigation: NavigationPreset,
    /// The speed of flying, as a factor of the usual speed.
    pub speed: f32,
    /// The steps of the gizmo.
    pub steps: Steps,
    /// The target of snapping.
    #[serde(deserialize_with = "or_default")]
    pub snapping: Snapping,
    /// The grid on the ground and the axes of the world.
    pub grid: GridSettings,
    /// Whether the dimensions of the selection are shown in the picture.
    pub dimensions: bool,
    /// The share of the picture's resolution that is rendered during motion, if full resolution takes too long; 1 is
    /// full resolution.
    pub moving_scale: f32,
    /// Whether a new picture shows the pixels of the last one that are still valid.
    pub carries_over: bool,
    /// Whether the picture is in headlight mode during drags.
    pub headlight_drags: bool,
    /// The pixels of the film that are traced.
    #[serde(deserialize_with = "or_default")]
    pub resolution: Resolution,
    /// The filter of a picture with fewer pixels than its panel.
    #[serde(deserialize_with = "or_default")]
    pub enlarging: Enlarging,
    /// Whether the status line shows figures for developers: latency, frame times, nodes.
    pub developer_figures: bool,
    /// Whether a scene is opened in its last view.
    pub returns_to_views: bool,
    /// Whether the view jumps to its goal.
    pub reduced_motion: bool,
    /// Whether a view along an axis hides the walls between the camera and rooms.
    pub axis_views_hide_walls: bool,
    /// The budget for pictures, meshes and the film in GiB; 0 is the default share of the machine's memory.
    pub memory_gib: u32,
    /// Whether the start page is shown when the program starts without a file.
    pub start_page: bool,
    /// The user's folders in the browser of assets, absolute.
    pub asset_folders: Vec<PathBuf>,
    /// Recent scenes, absolute, the newest first.
    pub recent_files: Vec<PathBuf>,
    /// The size and place of the window when it was closed.
    #[serde(deserialize_with = "or_default")]
    pub window: Option<WindowPlace>,
    /// The docked panels, as the layout serializes them.
    pub layout: Value,
    /// Entries that other versions of the program wrote.
    #[serde(flatten)]
    pub unknown: Map<String, Value>,
}

impl Default for Preferences {
    fn default() -> Self {
        Self {
            version: VERSION,
            theme: ThemeChoice::default(),
            ui_scale: 1.0,
            autosave_seconds: 60,
            tone_map: ToneMap::AgX,
            denoising: false,
            keys: KeyBindings::default(),
            navigation: NavigationPreset::default(),
            speed: 1.0,
            steps: Steps::default(),
            snapping: Snapping::default(),
            grid: GridSettings::default(),
            dimensions: false,
            moving_scale: 0.5,
            carries_over: true,
            headlight_drags: false,
            resolution: Resolution::default(),
            enlarging: Enlarging::default(),
            developer_figures: false,
            returns_to_views: true,
            reduced_motion: false,
            axis_views_hide_walls: true,
            memory_gib: 0,
            start_page: true,
            asset_folders: Vec::new(),
            recent_files: Vec::new(),
            window: None,
            layout: Value::Null,
            unknown: Map::new(),
        }
    }
}

/// The tone map of windows before this choice.
fn hard_clip() -> ToneMap {
    ToneMap::Clip
}

/// Tone maps by their names; an unknown name is the hard clip.
mod tone_map_by_name {
    use serde::{Deserialize, Deserializer, Serializer};
    use serde_json::Value;

    use super::{ToneMap, hard_clip};

    pub(super) fn serialize<S: Serializer>(map: &ToneMap, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(map.name())
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<ToneMap, D::Error> {
        let value = Value::deserialize(deserializer)?;
        Ok(value.as_str().and_then(ToneMap::of_name).unwrap_or_else(hard_clip))
    }
}

/// The range of [`Preferences::ui_scale`].
pub const UI_SCALES: std::ops::RangeInclusive<f32> = 0.5..=3.0;
/// The largest [`Preferences::autosave_seconds`].
pub const LONGEST_AUTOSAVE: u32 = 3600;
pub(crate) const MOST_MEMORY_GIB: u32 = 4096;
/// The range of [`Preferences::moving_scale`].
pub const MOVING_SCALES: std::ops::RangeInclusive<f32> = 0.25..=1.0;

impl Preferences {
    /// The memory budget in bytes.
    pub fn memory_limit(&self) -> u64 {
        match self.memory_gib {
            0 => memory::default_limit(),
            gib => u64::from(gib) << 30,
        }
    }

    /// Moves a file to the top of the list. Names that JSON cannot hold are left out.
    pub fn note_recent(&mut self, path: &Path) {
        self.recent_files.retain(|known| known != path);
        if path.to_str().is_some() {
            self.recent_files.insert(0, path.to_owned());
            self.recent_files.truncate(MOST_RECENT_FILES);
        }
    }

    /// Adds a folder of assets, the newest first. Names that JSON cannot hold are left out.
    pub(crate) fn add_asset_folder(&mut self, folder: PathBuf) {
        self.asset_folders.retain(|known| *known != folder);
        if folder.to_str().is_some() {
            self.asset_folders.insert(0, folder);
            self.asset_folders.truncate(MOST_ASSET_FOLDERS);
        }
    }

    /// The preferences with values limited to what the controls can set.
    pub(crate) fn within_range(mut self) -> Self {
        self.ui_scale = self.ui_scale.clamp(*UI_SCALES.start(), *UI_SCALES.end());
        self.speed = self.speed.clamp(*SPEED_RANGE.start(), *SPEED_RANGE.end());
        self.steps = self.steps.within_range();
        self.grid = self.grid.within_range();
        self.moving_scale = self.moving_scale.clamp(*MOVING_SCALES.start(), *MOVING_SCALES.end());
        self.autosave_seconds = self.autosave_seconds.min(LONGEST_AUTOSAVE);
        self.memory_gib = self.memory_gib.min(MOST_MEMORY_GIB);
        self.recent_files.truncate(MOST_RECENT_FILES);
        self.asset_folders.retain(|folder| folder.is_absolute());
        self.asset_folders.truncate(MOST_ASSET_FOLDERS);
        self.window = self.window.map(WindowPlace::within_range);
        self
    }
}

/// The range of [`Preferences::speed`].
pub const SPEED_RANGE: std::ops::RangeInclusive<f32> = 0.01..=100.0;
