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
use crate::engine::{PackedScene, RenderStatus, SeenThrough, WakeUp};
use crate::math::Aabb;
use crate::render::view::View;
use crate::render::visibility::outer_walls::OuterWalls;
use crate::render::visibility::sight::Sight;
use crate::scene::{SceneState, SceneStatus};

/// The threads that search the outlines of a side view.
const OUTLINE_THREADS: usize = 2;
/// The size of a scene, in sizes of what the main view looks at, from which side views do not show all of it at first.
const MUCH_MORE: f32 = 2.0;

/// The side views as they are shown.
#[derive(Resource, Default)]
pub struct SideScenes {
    scenes: [SideScene; COUNT],
    pictures: SidePictures,
    walls: SeenThrough,
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
    fn outer_walls(&mut self, packed: &PackedScene, geometry: &Arc<Tlas>) -> OuterWalls {
        let main = packed.view.as_ref().map(|view| &view.sight);
        let known = main.filter(|sight| sight.passes_backs);
        let found = self.walls.update(known.is_none(), geometry);
        known.map_or(found, |sight| sight.outer_walls.clone())
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
    let open = Sight {
        passes_backs: true,
        outer_walls: sides.outer_walls(&packed, &scene.geometry),
        ..main.sight.clone()
    };
    let closed = Sight {
        passes_backs: false,
        ..main.sight.clone()
    };
    // While a scene is being read its bounds are not those of all of it.
    let is_whole = scene_status.state == SceneState::Ready && status.is_up_to_date;
    let navigation = settings.navigation;
    let mut views = settings.side_views;
    let first = |view, aspect| {
        let shown = interesting(&packed, bounds, navigation.scene_size);
        SidePlace::framing(&shown, view, aspect, &navigation)
    };
    for (side, ((view, _), size)) in SIDES.into_iter().zip(sizes).enumerate() {
        let aspect = size.size.x as f32 / size.size.y as f32;
        let place = views.places[side].unwrap_or_else(|| first(view, aspect));
        if is_whole {
            views = views.with_place(side, place);
        }
        let own = &mut sides.scenes[side];
        own.pose = place.pose(view, aspect, &navigation, &bounds);
        let camera = SidePlace::camera(&own.pose, place.center.into(), aspect);
        let sight = if views.closed[side] { &closed } else { &open };
        own.packed = PackedScene {
            view: Some(side_view(camera, size.size, views.clay, sight.clone())),
            scene: Some(scene.clone()),
            entity_of_instance: packed.entity_of_instance.clone(),
            material_of_entity: packed.material_of_entity.clone(),
            medium_of_entity: packed.medium_of_entity.clone(),
            lamps: packed.lamps.clone(),
        };
    }
    let wanted = sides.scenes.each_ref().map(|own| own.packed.view.as_ref());
    sides.pictures.request(scene, wanted, state.panes.active, &wake_up);
    if views != settings.side_views {
        settings.side_views = views;
    }
}

/// The part of the scene that side views show at first: all of it, or the surroundings of what the main view looks at
/// where much more lies around, such as a lawn around a house.
fn interesting(packed: &PackedScene, all: Aabb, scene_size: f32) -> Aabb {
    if all.extent().length() <= MUCH_MORE * scene_size {
        return all;
    }
    let (Some(view), Some(ahead)) = (&packed.view, picking::ahead(packed)) else {
        return all;
    };
    // The size is about twice the distance, so that the camera is seen as well.
    let middle = ahead.position.midpoint(view.camera.unproject(Vec2::splat(0.5), 0.0));
    let half = Vec3::splat(0.5 * scene_size);
    let shown = Aabb {
        min: (middle - half).max(all.min),
        max: (middle + half).min(all.max),
    };
    if shown.is_empty() { all } else { shown }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::editor::camera::picking::tests::spheres;
    use crate::app::editor::picture::material_ball;
    use crate::render::camera::Camera;

    /// A world with two balls, ten units apart, before a camera.
    fn world(state: SceneState, is_up_to_date: bool) -> World {
        let (packed, _) = spheres(&[Vec3::ZERO, 10.0 * Vec3::X]);
        let mut world = World::new();
        let pose = Affine3A::from_translation(-5.0 * Vec3::Z);
        world.insert_resource(PackedScene {
            view: Some(View {
                camera: Camera::new(pose, 60.0, 1.0, 0.01, 100.0, None),
                ..material_ball::view(16)
            }),
            ..packed
        });
        let mut settings = ViewSettings::default();
        settings.side_views.shown = true;
        settings.navigation.scene_size = 12.0;
        world.insert_resource(settings);
        let size = ScreenPixels {
            size: UVec2::new(60, 40),
            per_point: 1.0,
        };
        let mut shown = ViewportState::default();
        shown.sides = Some([size; COUNT]);
        world.insert_resource(shown);
        world.insert_resource(SceneStatus {
            state,
            ..SceneStatus::default()
        });
        world.insert_resource(RenderStatus {
            is_up_to_date,
            ..RenderStatus::default()
        });
        world.init_resource::<WakeUp>();
        world.init_resource::<SideScenes>();
        world.run_system_cached(follow_side_views).expect("runs");
        world
    }

    fn places(world: &World) -> [Option<SidePlace>; COUNT] {
        world.resource::<ViewSettings>().side_views.places
    }

    #[test]
    fn the_scene_is_framed_once_it_is_whole() {
        for (state, is_up_to_date) in [(SceneState::Loading, true), (SceneState::Ready, false)] {
            let world = world(state, is_up_to_date);
            assert_eq!(places(&world), [None; COUNT]);
            // It is shown meanwhile.
            let sides = world.resource::<SideScenes>();
            let models = sides.models(&world.resource::<ViewSettings>().side_views);
            assert!(models.len() == COUNT && models.iter().all(|model| model.packed.view.is_some()));
        }
        let mut world = world(SceneState::Ready, true);
        let framed = places(&world);
        let plan = framed[0].expect("framed");
        assert!(
            plan.center[0] > 4.9 && plan.center[0] < 5.1 && plan.height > 8.0,
            "{plan:?}"
        );
        // It stays while the scene grows.
        let (grown, _) = spheres(&[Vec3::ZERO, 30.0 * Vec3::X]);
        let mut packed = world.resource_mut::<PackedScene>();
        packed.scene = grown.scene;
        world.run_system_cached(follow_side_views).expect("runs");
        assert_eq!(places(&world), framed);
    }

    #[test]
    fn much_around_what_is_looked_at_is_left_out_at_first() {
        let mut world = world(SceneState::Ready, true);
        let mut settings = world.resource_mut::<ViewSettings>();
        settings.side_views.places = [None; COUNT];
        settings.navigation.scene_size = 4.0;
        world.run_system_cached(follow_side_views).expect("runs");
        let plan = places(&world)[0].expect("framed");
        assert!(plan.center[0].abs() < 1.0 && plan.height < 5.0, "{plan:?}");
    }

    #[test]
    fn side_views_see_into_rooms_and_keep_the_cut() {
        let mut world = world(SceneState::Ready, true);
        let cut = crate::render::visibility::sight::CutPlane {
            normal: Vec3::Y,
            offset: 1.0,
        };
        let mut packed = world.resource_mut::<PackedScene>();
        if let Some(view) = &mut packed.view {
            view.sight.cut = Some(cut);
        }
        world.run_system_cached(follow_side_views).expect("runs");
        let sides = world.resource::<SideScenes>();
        for model in sides.models(&world.resource::<ViewSettings>().side_views) {
            let view = model.packed.view.as_ref().expect("a view");
            assert!(view.sight.passes_backs && view.sight.cut == Some(cut));
        }
        let mut settings = world.resource_mut::<ViewSettings>();
        settings.side_views = settings.side_views.with_closed(1, true);
        world.run_system_cached(follow_side_views).expect("runs");
        let settings = world.resource::<ViewSettings>();
        let models = world.resource::<SideScenes>().models(&settings.side_views);
        let seen = models.iter().filter_map(|model| model.packed.view.as_ref());
        assert!(seen.map(|view| view.sight.passes_backs).eq([true, false, true]));
        // Without them nothing is kept.
        world.resource_mut::<ViewportState>().sides = None;
        world.run_system_cached(follow_side_views).expect("runs");
        let sides = world.resource::<SideScenes>();
        assert!(sides.scenes.iter().all(|scene| scene.packed.scene.is_none()));
    }
}
