//! Moves the description of the scene's file to the shown time. The entities are moved first; this follows only when
//! needed, before saving and reloading.

use std::sync::Arc;

use bevy::prelude::*;

use super::file_base::{FileBase, Recognised, Thing, set_authored};
use crate::document::Document;
use crate::document::animation::is_animated;
use crate::scene::components::moment::shown_time;
use crate::scene::read::read;
use crate::scene::{AuthoredScene, ObjectState};

/// Moves the description of the file to the shown time.
pub(in crate::scene) fn follow_file(world: &mut World) {
    let time = shown_time(world);
    follow_file_to(world, time);
}

/// Moves it to another time, in seconds.
pub(in crate::scene) fn follow_file_to(world: &mut World, time: f64) {
    let is_other = |origin: &Arc<Document>| origin.time != time && is_animated(&origin.root);
    let Some(origin) = origin(world).filter(is_other) else {
        return;
    };
    let scene = Arc::new(read(&mut origin.at(time)));
    let base = world.remove_resource::<FileBase>().unwrap_or_default();
    let recognised = Recognised::in_order(&base.scene, &scene);
    let entities = recognised.entities(&base.entities, |known| {
        known.unwrap_or_else(|| world.spawn_empty().id())
    });
    let mut new_base = FileBase {
        integrator: base.integrator.map(|(_, keys)| (scene.integrator, keys)),
        ..FileBase::default()
    };
    for thing in Thing::all(&scene) {
        let entity = thing.entity(&entities);
        if let Some(known) = recognised.before(thing)
            && let Some(here) = base.unlike_file.get(&entity)
        {
            let (before, now) = (known.state(&base.scene, &base.entities), thing.state(&scene, &entities));
            let here = ObjectState::merged(&before, &now, here, here).state;
            new_base.remember(entity, here, &now);
        }
        set_authored(world, entity, thing.identity(&scene).authored.as_ref());
    }
    world.insert_resource(scene.remains.clone());
    (new_base.scene, new_base.entities) = (scene, entities);
    world.insert_resource(new_base);
}

fn origin(world: &World) -> Option<Arc<Document>> {
    world.get_resource::<AuthoredScene>()?.origin.clone()
}
