//! The state that the window's panels keep between frames.

use bevy::prelude::Resource;
use bevy_egui::egui::Rect;

use super::baking::BakeWidgets;
use super::palette::Palette;
use crate::app::editor::panels::assets::AssetsState;
use crate::app::editor::panels::inspector::InspectorState;
use crate::app::editor::panels::key_bindings::KeyList;
use crate::app::editor::panels::library::LibraryState;
use crate::app::editor::panels::missing_files::MissingForm;
use crate::app::editor::panels::outliner::state::OutlinerState;
use crate::app::editor::panels::projection::ProjectionForm;
use crate::app::editor::panels::series::SeriesForm;
use crate::app::editor::panels::statistics::StatisticsState;
use crate::app::editor::panels::timeline::TimelineState;

#[derive(Resource)]
pub(crate) struct Widgets {
    pub outliner: OutlinerState,
    /// The panel with the library of materials.
    pub shelf: LibraryState,
    pub assets: AssetsState,
    pub inspector: InspectorState,
    pub palette: Palette,
    pub timeline: TimelineState,
    /// The list in which keys are changed.
    pub keys: KeyList,
    /// The form for a series of copies.
    pub series: SeriesForm,
    /// The form for new texture coordinates.
    pub projection: ProjectionForm,
    /// The figures of the scene.
    pub statistics: StatisticsState,
    /// The form and the panel of a bake.
    pub bake: BakeWidgets,
    /// The list of missing files.
    pub missing: MissingForm,
    /// The rectangle of the picture's panel, in points.
    pub viewport_place: Rect,
}

impl Default for Widgets {
    fn default() -> Self {
        Self {
            outliner: OutlinerState::default(),
            shelf: LibraryState::default(),
            assets: AssetsState::default(),
            inspector: InspectorState::default(),
            palette: Palette::default(),
            timeline: TimelineState::default(),
            keys: KeyList::default(),
            series: SeriesForm::default(),
            projection: ProjectionForm::default(),
            statistics: StatisticsState::default(),
            bake: BakeWidgets::default(),
            missing: MissingForm::default(),
            viewport_place: Rect::ZERO,
        }
    }
}
