//! Fills the data about the bake, once per frame.

use std::path::Path;

use bevy::prelude::*;

use super::EditorModel;
use super::baking::{BakeModel, ShownBake};
use crate::app::editor::command::baking::BakePlan;
use crate::app::editor::picture::baking::thread::BakeNews;
use crate::app::editor::picture::baking::{Baking, Work};
use crate::app::editor::picture::compare::Comparison;
use crate::scene::SceneStatus;

pub(crate) fn gather_bake(
    baking: Option<Res<Baking>>,
    plan: Res<BakePlan>,
    comparison: Res<Comparison>,
    scene: Res<SceneStatus>,
    mut model: ResMut<EditorModel>,
) {
    let Some(baking) = baking else { return };
    let (view, is_of_open_scene) = (comparison.view, baking.is_of_open_scene);
    let shown = match &baking.work {
        Work::None => None,
        Work::Waiting(folder) => Some(ShownBake {
            folder: folder.path().to_owned(),
            news: BakeNews {
                stage: match baking.ending.is_empty() {
                    true => "Waiting for the scene".to_owned(),
                    false => "Waiting for the end of the last bake".to_owned(),
                },
                ..BakeNews::default()
            },
            is_stopped: false,
            is_busy: true,
            page: 0,
            view,
            is_of_open_scene,
        }),
        Work::UnderWay(thread) | Work::Ended(thread) => Some(ShownBake {
            folder: thread.folder().to_owned(),
            news: thread.news(),
            is_stopped: thread.is_stopped(),
            is_busy: baking.is_busy(),
            page: thread.wanted().page,
            view,
            is_of_open_scene,
        }),
    };
    model.0.bake = BakeModel {
        choices: plan.choices,
        folder: plan.folder.clone(),
        scene_folder: scene.path.as_deref().and_then(Path::parent).map(Path::to_owned),
        shown,
    };
}
