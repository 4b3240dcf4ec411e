//! Requests the outline of the selection and of the hovered thing, as of this frame.

use std::sync::Arc;

use bevy::prelude::*;

use super::side_scenes::SideScenes;
use super::state::{ScreenPixels, ViewportState};
use crate::app::editor::command::selection::Selection;
use crate::app::editor::picture::outline::Level;
use crate::app::editor::picture::outline_pass::{OutlinePass, OutlineRequest};
use crate::engine::{PackedScene, RenderControl, WakeUp};
use crate::render::view::View;

/// The width of outlines in points of the window.
const WIDTH: f32 = 2.0;

/// The outlined things, and the hovered thing when they were listed.
#[derive(Default)]
pub(crate) struct Marked {
    hovered: Option<Entity>,
    things: Arc<[(Entity, Level)]>,
}

/// Takes the results since the last frame. It must run before the viewport is gathered.
pub(crate) fn collect_outline(mut pass: ResMut<OutlinePass>, mut sides: ResMut<SideScenes>) {
    pass.bypass_change_detection().collect();
    sides.bypass_change_detection().collect();
}

/// Requests the outlines for the scene as packed in this frame. It must run after the side views are packed.
pub(crate) fn request_outline(
    mut pass: ResMut<OutlinePass>,
    mut sides: ResMut<SideScenes>,
    mut marked: Local<Marked>,
    packed: Res<PackedScene>,
    selection: Res<Selection>,
    state: Res<ViewportState>,
    control: Res<RenderControl>,
    wake_up: Res<WakeUp>,
) {
    let hovered = state.pointer.hovered;
    if selection.is_changed() || marked.hovered != hovered {
        *marked = Marked {
            hovered,
            things: things(&selection, hovered),
        };
    }
    let request_of = |view: &View, picture: ScreenPixels| {
        let scene = packed.scene.as_ref()?;
        Some(OutlineRequest {
            geometry: scene.geometry.clone(),
            entity_of_instance: packed.entity_of_instance.clone(),
            camera: view.camera,
            sight: view.sight.clone(),
            picture: picture.size,
            width: WIDTH * picture.per_point,
            marked: marked.things.clone(),
        })
    };
    let request = packed.view.as_ref().zip(state.picture);
    let request = request.and_then(|(view, picture)| request_of(view, picture));
    pass.bypass_change_detection()
        .request(request, control.threads.get(), &wake_up);
    let sides = sides.bypass_change_detection();
    sides.request_outlines(state.sides, request_of, &wake_up);
}

/// The hovered thing, then the selected ones, the active one last.
fn things(selection: &Selection, hovered: Option<Entity>) -> Arc<[(Entity, Level)]> {
    let hovered = hovered.filter(|entity| !selection.contains(*entity));
    let active = selection.active();
    let selected = selection.entities().iter().map(|&entity| {
        let level = if Some(entity) == active {
            Level::Active
        } else {
            Level::Selected
        };
        (entity, level)
    });
    hovered
        .map(|entity| (entity, Level::Hovered))
        .into_iter()
        .chain(selected)
        .collect()
}
