//! The pose and the lens of the view.

use bevy::math::Affine3A;
use bevy::prelude::*;

use crate::scene::{ActiveSensor, FreeView, Lens, Sensor, ToWorld};

/// The pose of the view, which may have left the camera in use: world from camera.
pub(crate) fn camera_pose(active: &ActiveSensor, free: &FreeView, poses: &Query<&ToWorld>) -> Option<Affine3A> {
    let sensor = poses.get(active.0?).ok()?;
    Some(free.pose.unwrap_or(sensor.0))
}

/// Reads [`camera_pose`] from the world.
pub(crate) fn view_pose(world: &World) -> Option<Affine3A> {
    let sensor = world.resource::<ActiveSensor>().0?;
    let own = world.get::<ToWorld>(sensor)?.0;
    Some(world.resource::<FreeView>().pose.unwrap_or(own))
}

/// The lens of the view: its own, or that of the camera.
pub fn lens(world: &World) -> Option<Lens> {
    let sensor = world.get::<Sensor>(world.resource::<ActiveSensor>().0?)?;
    Some(world.resource::<FreeView>().lens.unwrap_or(sensor.lens))
}

pub(crate) fn is_orthographic(world: &World) -> bool {
    lens(world) == Some(Lens::Orthographic)
}

/// The lens that a view needs in place of that of the camera in use to be orthographic or not; None if the camera's own
/// is right.
pub(crate) fn lens_of_view(world: &World, orthographic: bool) -> Option<Lens> {
    let sensor = world.get::<Sensor>(world.resource::<ActiveSensor>().0?)?;
    sensor.lens.for_projection(orthographic)
}
