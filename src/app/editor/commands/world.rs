//! Sets resources of the world.

use bevy::prelude::*;

use crate::app::editor::session::toasts::Toasts;
use crate::engine::RenderControl;

pub(crate) fn set_resource<R: Resource + PartialEq>(world: &mut World, value: R) {
    if world.get_resource::<R>() != Some(&value) {
        world.insert_resource(value);
    }
}

/// Shows a message to the user, if the world has messages.
pub(crate) fn tell(world: &mut World, text: impl Into<String>) {
    if let Some(mut toasts) = world.get_resource_mut::<Toasts>() {
        toasts.info(text.into());
    }
}

/// Edits the settings of the renderer. They count as changed only if they differ then.
pub fn control(world: &mut World, edit: impl FnOnce(&mut RenderControl)) {
    let mut edited = world.resource::<RenderControl>().clone();
    edit(&mut edited);
    set_resource(world, edited);
}
