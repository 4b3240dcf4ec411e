//! The views of the open scene under the numbers 1 to 9, its last view, its side views, and the settings of its bakes:
//! read when it is opened, and written to the [`ViewsFile`].

use bevy::prelude::*;

use super::toasts::Toasts;
use super::view_settings::ViewSettings;
use super::views_file::{ViewsFile, canonical};
use crate::app::editor::command::baking::BakePlan;
use crate::app::editor::command::preferences::Preferences;
use crate::app::editor::command::seeing::Walls;
use crate::app::editor::command::side_views::SideViews;
use crate::app::editor::command::stored_view::{StoredView, StoredViews};
use crate::engine::RenderControl;
use crate::scene::{ActiveSensor, FreeView, Lens, SceneState, SceneStatus, Sensor, ToWorld};

/// Reads the views of a scene that has been opened, and writes stored views.
pub fn follow_views(
    mut file: ResMut<ViewsFile>,
    mut settings: ResMut<ViewSettings>,
    mut toasts: ResMut<Toasts>,
    mut plan: Option<ResMut<BakePlan>>,
    status: Res<SceneStatus>,
    mut seen: Local<u64>,
) {
    let file = file.bypass_change_detection();
    let is_opened = *seen != status.revision && status.fresh_load;
    *seen = status.revision;
    // A script starts with the defaults, and does not change the choices of a user.
    let plan = plan.as_mut().filter(|_| file.returns);
    if let Some(plan) = &plan
        && ***plan != file.bake
    {
        // The plan still belongs to the previous scene.
        file.bake = BakePlan::clone(plan);
    }
    let path = status.path.as_deref().filter(|_| status.state == SceneState::Ready);
    if is_opened && let Err(error) = file.leave() {
        warn!("The view is not remembered: {error}");
    }
    if is_opened {
        settings.playback.stop();
        // A scene without side views of its own begins with as many views as the last one had, and frames them.
        settings.side_views.places = Default::default();
    }
    match path {
        Some(path) if is_opened => {
            settings.bookmarks = file.open(path);
            (settings.timeline, settings.timeline_shown) = (file.timeline, None);
            // A script shows the same whatever its user has looked at.
            let sides = file.sides.filter(|_| file.returns);
            settings.side_views = sides.unwrap_or(settings.side_views);
        }
        None if is_opened => settings.timeline = file.timeline,
        // The scene was saved under this name.
        Some(path) if status.is_changed() => {
            let scene = Some(canonical(path));
            if file.scene != scene {
                file.scene = scene;
                file.written = StoredViews::default();
                // The file has no views of a scene of this name.
                (file.last_written, file.keeps_last) = (None, false);
                file.sides_written = None;
                file.bake_written = BakePlan::default();
            }
        }
        _ => {}
    }
    if let Some(plan) = plan.filter(|_| is_opened) {
        **plan = file.bake.clone();
    }
    // While the user chooses numbers, nothing is written.
    let is_baked_elsewhere = file.bake.folder != file.bake_written.folder;
    let is_new = settings.bookmarks != file.written || settings.timeline != file.timeline || is_baked_elsewhere;
    file.timeline = settings.timeline;
    if is_new && let Err(error) = file.store(settings.bookmarks) {
        toasts.reject(format!("The view is not remembered: {error}"));
    }
}

/// Restores the last view of a scene that has been opened, if the user prefers that. To be run after [`follow_views`].
pub fn return_to_view(
    mut file: ResMut<ViewsFile>,
    mut free_view: ResMut<FreeView>,
    mut settings: ResMut<ViewSettings>,
    mut control: ResMut<RenderControl>,
    mut toasts: ResMut<Toasts>,
    preferences: Res<Preferences>,
    status: Res<SceneStatus>,
    active: Res<ActiveSensor>,
    sensors: Query<&Sensor>,
    mut seen: Local<u64>,
) {
    let is_opened = *seen != status.revision && status.fresh_load;
    *seen = status.revision;
    if !is_opened || status.state != SceneState::Ready {
        return;
    }
    let file = file.bypass_change_detection();
    let returns = file.returns && !std::mem::take(&mut file.begins_at_camera);
    let view = file.last;
    let sensor = active.0.and_then(|sensor| sensors.get(sensor).ok());
    if let (Some(view), Some(sensor), true) = (view, sensor, returns && preferences.returns_to_views) {
        if view.hides_walls {
            settings.seeing.walls = Walls::HiddenForAxis;
            control.sight = settings.sight();
        }
        free_view.pose = Some(view.pose);
        free_view.lens = sensor.lens.for_projection(view.orthographic);
        toasts.info("The view is where it was left; View > Cameras has that of the file");
    } else {
        file.keeps_last = view.is_some();
    }
}

/// Notes the view and the side views, and writes them when the program ends.
pub fn note_view(
    mut file: ResMut<ViewsFile>,
    free_view: Res<FreeView>,
    settings: Res<ViewSettings>,
    active: Res<ActiveSensor>,
    sensors: Query<(&Sensor, &ToWorld)>,
    mut exits: MessageReader<AppExit>,
) {
    let file = file.bypass_change_detection();
    let sensor = active.0.and_then(|sensor| sensors.get(sensor).ok());
    let is_free = free_view.pose.is_some() || free_view.lens.is_some();
    file.keeps_last &= !is_free;
    // Otherwise those of the file stay.
    if file.returns {
        let sides = settings.side_views;
        file.sides = (file.scene.is_some() && sides != SideViews::default()).then_some(sides);
    }
    if !file.keeps_last {
        file.last = sensor
            .filter(|_| is_free && file.scene.is_some())
            .map(|(sensor, pose)| StoredView {
                pose: free_view.pose.unwrap_or(pose.0),
                orthographic: free_view.lens.unwrap_or(sensor.lens) == Lens::Orthographic,
                hides_walls: settings.hides_walls(),
            });
    }
    if exits.read().next().is_some()
        && let Err(error) = file.leave()
    {
        warn!("The view is not remembered: {error}");
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use bevy::math::Affine3A;

    use super::super::views_file::tests::views;
    use super::*;
    use crate::app::editor::command::baking::BakeChoices;
    use crate::app::editor::command::side_views::SidePlace;

    #[test]
    fn each_scene_has_its_own_way_to_be_baked() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let plan = |texels_per_unit| BakePlan {
            choices: BakeChoices {
                texels_per_unit,
                ..BakeChoices::default()
            },
            folder: Some(folder.path().join("level")),
        };
        let start = |is_attended: bool| {
            let mut world = World::new();
            let file = ViewsFile::new(Some(folder.path()));
            world.insert_resource(if is_attended { file.returning(false) } else { file });
            world.init_resource::<ViewSettings>();
            world.init_resource::<Toasts>();
            world.init_resource::<BakePlan>();
            world.init_resource::<SceneStatus>();
            world
        };
        let open = |world: &mut World, name: &str| {
            let mut status = world.resource_mut::<SceneStatus>();
            (status.state, status.fresh_load) = (SceneState::Ready, true);
            status.path = Some(folder.path().join(name));
            status.revision += 1;
            world.run_system_cached(follow_views).expect("runs");
            world.resource::<BakePlan>().clone()
        };
        let mut world = start(true);
        assert_eq!(open(&mut world, "a.xml"), BakePlan::default());
        world.insert_resource(plan(Some(8.0)));
        assert_eq!(open(&mut world, "b.xml"), BakePlan::default());
        world.insert_resource(plan(Some(-3.0)));
        assert_eq!(open(&mut world, "a.xml"), plan(Some(8.0)));
        assert_eq!(open(&mut world, "b.xml"), plan(None), "there is no such number");
        assert_eq!(open(&mut start(true), "a.xml"), plan(Some(8.0)));
        // A script neither reads nor changes it.
        let mut world = start(false);
        assert_eq!(open(&mut world, "a.xml"), BakePlan::default());
        world.insert_resource(plan(Some(2.0)));
        assert_eq!(open(&mut world, "b.xml"), plan(Some(2.0)));
        assert_eq!(open(&mut start(true), "a.xml"), plan(Some(8.0)));
    }

    /// A world with a scene that has just been opened and has a last view.
    fn opened(returns: bool, prefers: bool) -> World {
        let mut world = World::new();
        let sensor = world.spawn((Sensor::default(), ToWorld::default())).id();
        world.insert_resource(ActiveSensor(Some(sensor)));
        world.insert_resource(SceneStatus {
            state: SceneState::Ready,
            fresh_load: true,
            revision: 1,
            ..SceneStatus::default()
        });
        world.insert_resource(ViewsFile {
            scene: Some("/a.xml".into()),
            last: views(60.0)[2],
            returns,
            ..ViewsFile::default()
        });
        world.insert_resource(Preferences {
            returns_to_views: prefers,
            ..Preferences::default()
        });
        world.init_resource::<FreeView>();
        world.init_resource::<ViewSettings>();
        world.init_resource::<RenderControl>();
        world.init_resource::<Toasts>();
        world.init_resource::<Messages<AppExit>>();
        world.run_system_cached(return_to_view).expect("runs");
        world
    }

    #[test]
    fn a_scene_begins_where_it_was_left_if_that_is_wanted() {
        for (returns, prefers) in [(true, true), (false, true), (true, false)] {
            let mut world = opened(returns, prefers);
            let view = views(60.0)[2].expect("stored");
            assert!(view.hides_walls);
            // The walls that were hidden in it are hidden again.
            let hides_walls = world.resource::<ViewSettings>().hides_walls();
            let passes_backs = world.resource::<RenderControl>().sight.passes_backs;
            assert_eq!((hides_walls, passes_backs), (returns && prefers, returns && prefers));
            let free = *world.resource::<FreeView>();
            if returns && prefers {
                assert_eq!((free.pose, free.lens), (Some(view.pose), Some(Lens::Orthographic)));
            } else {
                assert_eq!(free, FreeView::default());
            }
            world.run_system_cached(note_view).expect("runs");
            assert_eq!(world.resource::<ViewsFile>().last, Some(view));
            // The view of the camera does not replace it until the user has moved the view.
            let other = FreeView {
                pose: Some(Affine3A::IDENTITY),
                ..FreeView::default()
            };
            for (free, expected) in [(other, Some(Affine3A::IDENTITY)), (FreeView::default(), None)] {
                world.insert_resource(free);
                world.run_system_cached(note_view).expect("runs");
                let last = world.resource::<ViewsFile>().last;
                assert_eq!(last.map(|view| view.pose), expected);
            }
        }
    }

    #[test]
    fn side_views_come_back_for_users_and_scripts_leave_them() {
        let shown = |height| SideViews {
            shown: true,
            places: [Some(SidePlace {
                center: [1.0, 2.0, 3.0],
                height,
            }); 3],
            ..SideViews::default()
        };
        let (left, other) = (shown(4.0), shown(5.0));
        for returns in [true, false] {
            let folder = tempfile::tempdir().expect("a temporary folder");
            let path = folder.path().join("a.xml");
            let mut file = ViewsFile::new(Some(folder.path()));
            file.open(&path);
            file.sides = Some(left);
            file.leave().expect("a writable folder");
            let mut world = opened(returns, true);
            world.insert_resource(ViewsFile { returns, ..file });
            world.resource_mut::<SceneStatus>().path = Some(path.clone());
            world.run_system_cached(follow_views).expect("runs");
            let expected = if returns { left } else { SideViews::default() };
            assert_eq!(world.resource::<ViewSettings>().side_views, expected);
            world.resource_mut::<ViewSettings>().side_views = other;
            world.run_system_cached(note_view).expect("runs");
            let mut file = world.resource_mut::<ViewsFile>();
            file.leave().expect("a writable folder");
            file.open(&path);
            assert_eq!(file.sides, Some(if returns { other } else { left }));
        }
    }

    #[test]
    fn a_scene_that_is_opened_does_not_play() {
        let mut world = opened(true, true);
        world.resource_mut::<ViewSettings>().playback.start(0.0);
        let mut plays = |fresh_load: bool| {
            let mut status = world.resource_mut::<SceneStatus>();
            (status.fresh_load, status.revision) = (fresh_load, status.revision + 1);
            world.run_system_cached(follow_views).expect("runs");
            world.resource::<ViewSettings>().playback.is_playing()
        };
        assert!(plays(false));
        assert!(!plays(true));
    }

    #[test]
    fn a_scene_that_is_saved_under_another_name_has_its_view_there() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mut world = opened(true, true);
        let last = views(60.0)[2];
        world.insert_resource(ViewsFile {
            path: Some(folder.path().join("views.json")),
            scene: Some("/a.xml".into()),
            last,
            last_written: last,
            ..ViewsFile::default()
        });
        let mut status = world.resource_mut::<SceneStatus>();
        status.path = Some("/b.xml".into());
        status.fresh_load = false;
        world.run_system_cached(follow_views).expect("runs");
        let mut file = world.resource_mut::<ViewsFile>();
        file.leave().expect("a writable folder");
        file.open(Path::new("/b.xml"));
        assert_eq!(file.last, last);
    }
}
