//! The scene as the side views see it, packed anew in every frame in which they are shown, with their pictures and
//! outlines.

use std::sync::Arc;

use bevy::math::Affine3A;
use bevy::prelude::*;

use super::side_model::{COUNT, SideModel};
use super::state::{ScreenPixels, ViewportState};
use crate::accel::Tlas;
use crate::app::editor::camera::picking;
use crate::app::editor::command::side_views::{SIDES, SidePlace, SideViews};
use crate::app::editor::picture::outline_pass::{OutlinePass, OutlineRequest};
use crate::app::editor::picture::side_pictures::{SidePictures, side_view};
use crate::app::editor::session::view_settings::ViewSettings;
use crate::engine::{PackedScene, RenderStatus, WakeUp};
use crate::math::Aabb;
use crate::render::view::View;
use crate::render::visibility::outer_walls::OuterWalls;
use crate::render::visibility::sight::Sight;
use crate::scene::{SceneState, SceneStatus};

/// The threads that search the outlines of a side view.
const OUTLINE_THREADS: usize = 2;

/// The side views as they are shown.
#[derive(Resource, Default)]
pub struct SideScenes {
    scenes: [SideScene; COUNT],
    pictures: SidePictures,
    walls: Option<(Arc<Tlas>, OuterWalls)>,
}

/// The scene as a side view sees it.
#[derive(Default)]
struct SideScene {
    packed: PackedScene,
    pose: Affine3A,
    outline: OutlinePass,
}

impl SideScenes {
    /// The models of the side views; none while they are not shown.
    pub fn models(&self, views: &SideViews) -> Vec<SideModel<'_>> {
        let model = |(side, scene): (usize, &'_ SideScene)| SideModel {
            packed: &self.scenes[side].packed,
            pose: scene.pose,
            picture: self.pictures.picture(side),
            outline: self.scenes[side].outline.outline(),
        };
        match views.shown {
            true => self.scenes.iter().enumerate().map(model).collect(),
            false => Vec::new(),
        }
    }

    /// Takes the pictures and outlines that are ready.
    pub(super) fn collect(&mut self) {
        self.pictures.collect();
        self.scenes.iter_mut().for_each(|scene| scene.outline.collect());
    }

    /// Requests the outlines of the side views. `request` makes that of a view of this size in pixels.
    pub(super) fn request_outlines(
        &mut self,
        sizes: Option<[ScreenPixels; COUNT]>,
        request: impl Fn(&View, ScreenPixels) -> Option<OutlineRequest>,
        wake_up: &WakeUp,
    ) {
        for (side, scene) in self.scenes.iter_mut().enumerate() {
            let size = sizes.map(|sizes| sizes[side]);
            let view = scene.packed.view.as_ref().zip(size);
            let request = view.and_then(|(view, size)| request(view, size));
            scene.outline.request(request, OUTLINE_THREADS, wake_up);
        }
    }

    /// The outer walls of the scene, through which side views see into rooms.
    fn walls(&mut self, packed: &PackedScene, geometry: &Arc<Tlas>) -> OuterWalls {
        if let Some(sight) = packed
            .view
            .as_ref()
            .map(|view| &view.sight)
            .filter(|it| it.passes_backs)
        {
            return sight.outer_walls.clone();
        }
        match &self.walls {
            Some((of, walls)) if Arc::ptr_eq(of, geometry) => walls.clone(),
            _ => {
                let walls = OuterWalls::find(geometry);
                self.walls = Some((geometry.clone(), walls.clone()));
                walls
            }
        }
    }
}

/// Packs the side views for the scene of this frame, and requests their pictures.
pub(crate) fn follow_side_views(
    mut sides: ResMut<SideScenes>,
    mut settings: ResMut<ViewSettings>,
    state: Res<ViewportState>,
    packed: Res<PackedScene>,
    status: Res<RenderStatus>,
    scene_status: Res<SceneStatus>,
    wake_up: Res<WakeUp>,
) {
    let sides = sides.bypass_change_detection();
    let (Some(scene), Some(main), Some(sizes)) = (&packed.scene, &packed.view, state.sides) else {
        sides.pictures.clear();
        (sides.scenes, sides.walls) = Default::default();
        return;
    };
    let bounds = picking::scene_bounds(&packed).unwrap_or(Aabb::EMPTY);
    let sight = Sight {
        passes_backs: true,
        outer_walls: sides.walls(&packed, &scene.geometry),
        ..main.sight.clone()
    };
    // While a scene is being read its bounds are not those of all of it.
    let is_whole = scene_status.state == SceneState::Ready && status.is_up_to_date;
    let navigation = settings.navigation;
    let mut views = settings.side_views;
    for (side, ((view, _), size)) in SIDES.into_iter().zip(sizes).enumerate() {
        let aspect = size.size.x as f32 / size.size.y as f32;
        let place = views.places[side].unwrap_or_else(|| SidePlace::framing(&bounds, view, aspect, &navigation));
        if is_whole {
            views = views.with_place(side, place);
        }
        let own = &mut sides.scenes[side];
        own.pose = place.pose(view, aspect, &navigation, &bounds);
        let camera = SidePlace::camera(&own.pose, place.center.into(), aspect);
        own.packed = PackedScene {
            view: Some(side_view(camera, size.size, views.clay, sight.clone())),
            scene: Some(scene.clone()),
            entity_of_instance: packed.entity_of_instance.clone(),
            material_of_entity: packed.material_of_entity.clone(),
            medium_of_entity: packed.medium_of_entity.clone(),
        };
    }
    let wanted = sides.scenes.each_ref().map(|own| own.packed.view.as_ref());
    sides.pictures.request(scene, wanted, state.panes.active, &wake_up);
    if views != settings.side_views {
        settings.side_views = views;
    }
}
