//! Applies commands that move the view or filter visible things.

use bevy::math::{Affine3A, Vec3A};
use bevy::prelude::*;

use super::world::set_resource;
use super::{flight, projection, seeing};
use crate::app::editor::camera::pose::{self, view_pose};
use crate::app::editor::camera::walking::{self, Body};
use crate::app::editor::camera::{navigation, picking, rounding};
use crate::app::editor::command::axis_view::AxisView;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::command::stored_view::StoredView;
use crate::app::editor::command::{CameraEdit, ViewCommand};
use crate::app::editor::session::history::Edit;
use crate::app::editor::session::toasts::Toasts;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::engine::{PackedScene, RenderControl};
use crate::math::Aabb;
use crate::scene::{ActiveSensor, Film, FreeView, KnownBounds, LengthUnit, Lens, Sensor, Shape, ShapeKind, ToWorld};

/// Applies the command.
pub fn apply(world: &mut World, command: ViewCommand) -> Result<(), CommandError> {
    match command {
        ViewCommand::FrameSelection => frame_selection(world)?,
        ViewCommand::FrameAll => frame_all(world)?,
        ViewCommand::MoveView(pose) => move_view(world, pose),
        ViewCommand::SwitchProjection => projection::switch(world)?,
        ViewCommand::LookThrough(entity) => look_through(world, entity),
        ViewCommand::TurnAbout(point) => world.resource_mut::<ViewSettings>().navigation.pivot = Some(point),
        ViewCommand::LookAlong(axis) => look_along(world, axis),
        ViewCommand::StoreView(number) => store(world, number),
        ViewCommand::RecallView(number) => recall(world, number)?,
        ViewCommand::Walk(walks) => walk(world, walks)?,
        ViewCommand::SetSpeed(speed) => world.resource_mut::<ViewSettings>().navigation.set_speed(speed),
        ViewCommand::SetSeeing(seen) => seeing::set(world, seen),
        ViewCommand::CutOpen => seeing::cut_open(world)?,
        ViewCommand::Isolate(entities) => seeing::isolate(world, entities)?,
        ViewCommand::ShowSideViews(shown) => world.resource_mut::<ViewSettings>().side_views.shown = shown,
        ViewCommand::ShowSidesInClay(clay) => world.resource_mut::<ViewSettings>().side_views.clay = clay,
        ViewCommand::CloseSideView(side, closed) => {
            let views = &mut world.resource_mut::<ViewSettings>().side_views;
            *views = views.with_closed(side, closed);
        }
        ViewCommand::PlaceSideView(side, place) => {
            let views = &mut world.resource_mut::<ViewSettings>().side_views;
            *views = views.with_place(side, place);
        }
    }
    Ok(())
}

/// Applies the edit.
pub fn edit(edit: &mut Edit, command: CameraEdit) -> Result<(), CommandError> {
    match command {
        CameraEdit::MoveCameraToView => {
            move_camera_to_view(edit)?;
        }
        CameraEdit::FocusAt(film) => focus(edit, film)?,
        CameraEdit::KeepLimits => keep_limits(edit)?,
    }
    Ok(())
}

pub fn move_view(world: &mut World, pose: Affine3A) {
    if world.resource::<ActiveSensor>().0.is_some() {
        let lens = world.resource::<FreeView>().lens;
        let pose = Some(pose);
        set_resource(world, FreeView { pose, lens });
    }
}

/// The pose of the view with a rounded position, for a camera that is put there.
pub fn rounded_view(world: &World) -> Option<Affine3A> {
    let pose = view_pose(world)?;
    let unit = rounding::unit_of_scene(world.resource::<ViewSettings>().navigation.scene_size);
    let translation = rounding::rounded_place(pose.translation.into(), unit).into();
    Some(Affine3A { translation, ..pose })
}

/// Moves the camera in use to the pose of the view, with its lens.
pub fn move_camera_to_view(edit: &mut Edit) -> Result<Entity, CommandError> {
    let sensor = edit.world.resource::<ActiveSensor>().0;
    let (Some(sensor), Some(pose)) = (sensor, rounded_view(edit.world)) else {
        return Err("There is no camera.".into());
    };
    if let Some(lens) = edit.world.resource::<FreeView>().lens
        && let Some(seen) = edit.world.get::<Sensor>(sensor).copied()
    {
        edit.set(sensor, Sensor { lens, ..seen });
    }
    edit.set(sensor, ToWorld(pose));
    edit.world.insert_resource(FreeView::default());
    Ok(sensor)
}

/// Moves the view as [`move_view`], but by a short flight, and sets the centre of orbits.
fn fly_to(world: &mut World, pose: Affine3A, center: Option<Vec3>) {
    if center.is_some() {
        world.resource_mut::<ViewSettings>().navigation.pivot = center;
    }
    let from = view_pose(world);
    let lens = world.resource::<FreeView>().lens;
    let pose = Some(pose);
    flight::go(world, from, FreeView { pose, lens }, center);
}

/// The depth of the middle of the selection, of the centre of orbits, or of the surface ahead.
pub fn distance_looked(world: &World, pose: &Affine3A) -> f32 {
    let forward = Vec3::from(pose.matrix3.z_axis).normalize_or_zero();
    let selected = selected_bounds(world);
    let selected = (!selected.is_empty()).then(|| (selected.center() - Vec3::from(pose.translation)).dot(forward));
    let navigation = &world.resource::<ViewSettings>().navigation;
    let pivot = || {
        navigation
            .pivot_ahead(pose)
            .map(|pivot| pivot.distance(pose.translation.into()))
    };
    let ahead = || picking::distance_ahead(world.resource::<PackedScene>());
    let distance = selected.filter(|distance| *distance > 0.0);
    distance
        .or_else(pivot)
        .or_else(ahead)
        .unwrap_or(0.5 * navigation.scene_size)
}

/// Looks along an axis at the selection, else at the centre of orbits, or at the surface ahead.
pub fn look_along(world: &mut World, axis: AxisView) {
    let Some(pose) = view_pose(world) else { return };
    let selected = selected_bounds(world);
    let navigation = world.resource::<ViewSettings>().navigation;
    let center = if selected.is_empty() {
        let ahead = distance_looked(world, &pose);
        Vec3::from(pose.translation) + Vec3::from(pose.matrix3.z_axis).normalize_or_zero() * ahead
    } else {
        selected.center()
    };
    seeing::note_axis_view(world);
    fly_to(world, navigation.axis_view(pose, center, axis), Some(center));
}

pub fn store(world: &mut World, number: usize) {
    let orthographic = pose::is_orthographic(world);
    let pose = view_pose(world);
    let mut settings = world.resource_mut::<ViewSettings>();
    let hides_walls = settings.hides_walls();
    let view = pose.map(|pose| StoredView {
        pose,
        orthographic,
        hides_walls,
    });
    let place = number.checked_sub(1);
    if let Some(place) = place.and_then(|place| settings.bookmarks.get_mut(place)) {
        *place = view;
        world.resource_mut::<Toasts>().info(format!("View {number} stored"));
    }
}

pub fn recall(world: &mut World, number: usize) -> Result<(), CommandError> {
    let bookmarks = world.resource::<ViewSettings>().bookmarks;
    let stored = number.checked_sub(1).and_then(|place| *bookmarks.get(place)?);
    let view = stored.ok_or_else(|| format!("There is no view {number}: Ctrl+{number} stores one."))?;
    if world.resource::<ActiveSensor>().0.is_some() {
        seeing::note_stored_view(world, view.hides_walls);
        let from = view_pose(world);
        let end = FreeView {
            pose: Some(view.pose),
            lens: pose::lens_of_view(world, view.orthographic),
        };
        flight::go(world, from, end, None);
    }
    Ok(())
}

/// Puts the view at the eyes of a person on the floor below it, from where flying keys walk; or ends that.
fn walk(world: &mut World, walks: bool) -> Result<(), CommandError> {
    if walks {
        if pose::is_orthographic(world) {
            return Err("An orthographic view cannot walk: switch to perspective first.".into());
        }
        let pose = view_pose(world).ok_or("There is no camera.")?;
        let unit = world.get_resource::<LengthUnit>().copied().unwrap_or_default();
        let (up, eyes) = (world.resource::<ViewSettings>().navigation.up, Body::person(unit).eyes);
        let floor = walking::floor_below(world.resource::<PackedScene>(), pose.translation.into(), up);
        let floor = floor.ok_or("There is no floor below the view to walk on.")?;
        let translation = pose.translation + Vec3A::from(up * (floor + eyes));
        move_view(world, Affine3A { translation, ..pose });
    }
    world.resource_mut::<ViewSettings>().walks = walks;
    Ok(())
}

pub fn look_through(world: &mut World, sensor: Entity) {
    if world.get::<Sensor>(sensor).is_some() {
        seeing::note_other_view(world);
        let from = view_pose(world);
        look_through_first(world, Some(sensor));
        flight::go(world, from, FreeView::default(), None);
    }
}

/// Like [`look_through`]; None uses no camera.
pub fn look_through_first(world: &mut World, sensor: Option<Entity>) {
    let pose = sensor.and_then(|sensor| world.get::<ToWorld>(sensor)).copied();
    if let Some(ToWorld(pose)) = pose {
        world.resource_mut::<ViewSettings>().navigation.up = navigation::up_axis(&pose);
    }
    set_resource(world, ActiveSensor(sensor));
    set_resource(world, FreeView::default());
}

/// World bounds of the selected things that have a place; empty without any.
pub fn selected_bounds(world: &World) -> Aabb {
    let packed = world.resource::<PackedScene>();
    let selection = world.resource::<Selection>().entities();
    let bounds = selection.iter().filter_map(|entity| {
        let of_mesh = || stand_in_bounds(world, *entity);
        picking::bounds_of(packed, *entity).or_else(of_mesh).or_else(|| {
            // A light or a camera has no extent, but a position.
            let place = Vec3::from(world.get::<ToWorld>(*entity)?.0.translation);
            let half = 0.05 * world.resource::<ViewSettings>().navigation.scene_size;
            Some(Aabb::from_points([place - half, place + half]))
        })
    });
    bounds.fold(Aabb::EMPTY, Aabb::union)
}

/// World bounds of the box in place of a missing mesh.
fn stand_in_bounds(world: &World, entity: Entity) -> Option<Aabb> {
    let ShapeKind::Mesh(file) = &world.get::<Shape>(entity)?.kind else {
        return None;
    };
    let local = world.get_resource::<KnownBounds>()?.of(file);
    Some(local.transformed(&world.get::<ToWorld>(entity)?.0))
}

pub fn frame_selection(world: &mut World) -> Result<(), CommandError> {
    let bounds = selected_bounds(world);
    if bounds.is_empty() {
        return Err("Nothing that is in the picture is selected.".into());
    }
    frame(world, bounds);
    Ok(())
}

pub fn frame_all(world: &mut World) -> Result<(), CommandError> {
    let bounds = picking::scene_bounds(world.resource::<PackedScene>());
    frame(world, bounds.ok_or("The scene is empty.")?);
    Ok(())
}

fn frame(world: &mut World, bounds: Aabb) {
    let Some(pose) = view_pose(world) else {
        return;
    };
    let view = world.resource::<PackedScene>().view.as_ref();
    let half_fov = view.map_or(0.3, |view| picking::half_fov(&view.camera));
    // The scale of a parallel view is that of the film.
    let aspect = view.map_or(1.0, |view| {
        let extent = view.of_film().half_extent();
        extent.x / extent.y
    });
    let framed = if pose::is_orthographic(world) {
        navigation::framing_parallel(pose, &bounds, aspect)
    } else {
        navigation::framing(pose, &bounds, half_fov)
    };
    if let Some(pose) = framed {
        fly_to(world, pose, Some(bounds.center()));
    }
}

/// The digits of a focus distance: well within the depth of field.
const FOCUS_DIGITS: i32 = 4;
const SHARP_EVERYWHERE: &str = "An orthographic camera is sharp everywhere.";

/// Focuses on the surface at a point of the picture; the aperture of a pinhole becomes a two-hundredth of the distance.
pub fn focus(edit: &mut Edit, film: Vec2) -> Result<(), CommandError> {
    let packed = edit.world.resource::<PackedScene>();
    let (Some(scene), Some(view)) = (&packed.scene, &packed.view) else {
        return Err("There is no picture.".into());
    };
    let ray = view.camera.ray(film, Vec2::splat(0.5));
    let ray = view.sight.narrow(&scene.geometry, ray);
    let hit = scene.geometry.intersect(&ray).ok_or("There is nothing to focus on.")?;
    let (_, distance) = view.camera.project(ray.at(hit.t));
    let distance = rounding::with_digits(distance, FOCUS_DIGITS);
    let Some(camera) = edit.world.resource::<ActiveSensor>().0 else {
        return Err("There is no camera.".into());
    };
    if pose::is_orthographic(edit.world) {
        return Err(SHARP_EVERYWHERE.into());
    }
    let Some(mut sensor) = edit.world.get::<Sensor>(camera).copied() else {
        return Ok(());
    };
    match &mut sensor.lens {
        // The view has a lens of its own.
        Lens::Orthographic => return Err(SHARP_EVERYWHERE.into()),
        Lens::Thin { focus_distance, .. } => *focus_distance = distance,
        Lens::Pinhole => {
            sensor.lens = Lens::Thin {
                aperture_radius: rounding::with_digits(0.005 * distance, FOCUS_DIGITS),
                focus_distance: distance,
                blades: 0,
                blade_rotation: 0.0,
            };
        }
    }
    edit.set(camera, sensor);
    Ok(())
}

/// Writes samples, limit of noise and adaptive sampling into the film of the camera. The limits of the window stay:
/// they are the same then, and still apply after an undo.
fn keep_limits(edit: &mut Edit) -> Result<(), CommandError> {
    let sensor = edit.world.resource::<ActiveSensor>().0;
    let film = sensor.and_then(|sensor| Some((sensor, *edit.world.get::<Film>(sensor)?)));
    let (sensor, film) = film.ok_or("There is no camera.")?;
    let control = edit.world.resource::<RenderControl>();
    let kept = Film {
        sample_count: control.target_samples.unwrap_or(film.sample_count),
        // Zero is no limit, also where the film has one.
        noise_target: control
            .noise_target
            .map_or(film.noise_target, |noise| Some(noise).filter(|noise| *noise > 0.0)),
        adaptive: control.adaptive.unwrap_or(film.adaptive),
        ..film
    };
    if kept == film {
        return Err("The camera has these limits already.".into());
    }
    edit.set(sensor, kept);
    Ok(())
}
