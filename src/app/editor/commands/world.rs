//! Sets resources of the world.

use bevy::prelude::*;

use crate::app::editor::session::toasts::Toasts;
use crate::engine::RenderControl;
use crate::scene::{AuthoredScene, LengthUnit};

pub(crate) fn set_resource<R: Resource + PartialEq>(world: &mut World, value: R) {
    if world.get_resource::<R>() != Some(&value) {
        world.insert_resource(value);
    }
}

/// Tells the user something, where there are messages.
pub(crate) fn tell(world: &mut World, text: impl Into<String>) {
    if let Some(mut toasts) = world.get_resource_mut::<Toasts>() {
        toasts.info(text.into());
    }
}

/// Sets the unit of length, and says so if the file cannot keep it.
pub(crate) fn set_unit(world: &mut World, unit: LengthUnit) {
    set_resource(world, unit);
    let origin = world
        .get_resource::<AuthoredScene>()
        .and_then(|scene| scene.origin.as_ref());
    if origin.is_some_and(|origin| origin.uses_unit_name)
        && let Some(mut toasts) = world.get_resource_mut::<Toasts>()
    {
        toasts.warn("The file will not keep the unit: it uses the name `length_unit` for something else.");
    }
}

/// Edits the settings of the renderer. They count as changed only if they are others then.
pub fn control(world: &mut World, edit: impl FnOnce(&mut RenderControl)) {
    let mut edited = world.resource::<RenderControl>().clone();
    edit(&mut edited);
    set_resource(world, edited);
}
