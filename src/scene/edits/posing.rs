//! Shows another time of an animated scene.
//!
//! The tracks of animated things are components ([`Keys`]). For another time, the plugins of these things are written
//! twice, with the values of the components and with those of the tracks, and read again: the differences are written
//! into the components. So every value of a file can be animated, and the entities are as if the file was read at that
//! time.

use std::collections::HashMap;
use std::sync::Arc;

use bevy::ecs::entity::EntityHashSet;
use bevy::prelude::*;

use crate::document::animation::{is_animated, span_of};
use crate::document::{Child, Document, Object};
use crate::scene::components::moment::{ShownTime, shown_time};
use crate::scene::file::entities::Entities;
use crate::scene::file::file_base::Thing;
use crate::scene::file::file_moment::{follow_file, follow_file_to};
use crate::scene::load::spawn;
use crate::scene::read::{read, read_meaning};
use crate::scene::write::snapshot::Snapshot;
use crate::scene::write::{Writer, folder, home};
use crate::scene::{
    AuthoredScene, IntegratorKeys, IntegratorSettings, Keys, ObjectState, ReloadSummary, SceneDescription,
};

/// The times of the first and the last key of the scene in seconds; None if nothing is animated.
pub fn animated_span(world: &mut World) -> Option<(f64, f64)> {
    let mut spans = Vec::new();
    for keys in world.query::<&Keys>().iter(world) {
        spans.extend(keys.tracks().map(|(_, track)| track.span()));
    }
    if let Some(remains) = world.get_resource::<AuthoredScene>() {
        let rest = remains.rest.iter().filter_map(|(_, child)| match child {
            Child::Object(object) => Some(&**object),
            Child::Reference { .. } => None,
        });
        spans.extend(rest.filter_map(span_of));
    }
    if let Some(keys) = world.get_resource::<IntegratorKeys>() {
        spans.extend(keys.0.tracks().map(|(_, track)| track.span()));
    }
    let both = |(first, last): (f64, f64), (start, end)| (first.min(start), last.max(end));
    spans.into_iter().reduce(both)
}

/// Sets the entities to the time `time`, in seconds. Returns whether they may have changed.
///
/// The text of the file must have been kept ([`crate::scene::KeepSource`]).
pub fn show_moment(world: &mut World, time: f64) -> bool {
    let before = shown_time(world);
    world.insert_resource(ShownTime(time));
    let mut moving = world.query_filtered::<Entity, With<Keys>>();
    let moving: Vec<Entity> = moving.iter(world).collect();
    let is_integrator_moving = world
        .get_resource::<IntegratorKeys>()
        .is_some_and(|keys| !keys.0.is_empty());
    let changes = !moving.is_empty() || is_integrator_moving;
    if changes {
        pose_from(world, &moving, before);
    }
    changes
}

/// Gives things the values of their tracks at the shown time.
pub(crate) fn pose(world: &mut World, things: &[Entity]) {
    let time = shown_time(world);
    pose_from(world, things, time);
}

/// Gives things the values of their tracks at the shown time. They have the values at `before`, or have been edited
/// since.
fn pose_from(world: &mut World, things: &[Entity], before: f64) {
    let time = shown_time(world);
    let follows = |thing: &Entity| world.get::<Keys>(*thing).is_some_and(Keys::follows);
    if things.iter().any(follows) {
        // The values of animated elements that they refer to are known at the time of the file's description.
        follow_file_to(world, before);
    }
    let (mut scene, of) = Snapshot::of_things(world, things).describe();
    scene.time = time;
    let mut entities = HashMap::new();
    let media = scene.media.iter_mut().map(|it| &mut it.identity);
    let materials = scene.materials.iter_mut().map(|it| &mut it.identity);
    let groups = scene.groups.iter_mut().map(|it| &mut it.identity);
    let shapes = scene.shapes.iter_mut().map(|it| &mut it.identity);
    let emitters = scene.emitters.iter_mut().map(|it| &mut it.identity);
    let sensors = scene.sensors.iter_mut().map(|it| &mut it.identity);
    let first = media.chain(materials).chain(groups).chain(shapes);
    let identities = first.chain(emitters).chain(sensors);
    for (identity, entity) in identities.zip(of.all()) {
        let id = format!("entity-{}", entity.to_bits());
        entities.insert(id.clone(), entity);
        identity.id = Some(id);
    }
    let home = home(&scene, scene.path.as_path());
    let origin = scene.remains.origin.clone();
    let document = |root: Object, time: f64| {
        let mut document = Document::new(home.clone(), root);
        document.search_folders.clone_from(&scene.remains.search_folders);
        if let Some(origin) = &origin {
            document.access = origin.access.clone();
            document.diagnostics.sources.clone_from(&origin.diagnostics.sources);
        }
        read_meaning(&mut document.at(time))
    };
    let folder = folder(&home);
    let now = document(Writer::new(&scene, folder).without_keys().root(), before);
    let then = document(Writer::new(&scene, folder).root(), time);
    let entities_of = |scene: &SceneDescription| Entities {
        sensors: found(&entities, scene.sensors.iter().map(|it| &it.identity.id)),
        media: found(&entities, scene.media.iter().map(|it| &it.identity.id)),
        materials: found(&entities, scene.materials.iter().map(|it| &it.identity.id)),
        groups: found(&entities, scene.groups.iter().map(|it| &it.identity.id)),
        shapes: found(&entities, scene.shapes.iter().map(|it| &it.identity.id)),
        emitters: found(&entities, scene.emitters.iter().map(|it| &it.identity.id)),
    };
    let (of_now, of_then) = (entities_of(&now), entities_of(&then));
    let things: EntityHashSet = things.iter().copied().collect();
    let known: HashMap<Entity, Thing> = Thing::all(&now).map(|thing| (thing.entity(&of_now), thing)).collect();
    for thing in Thing::all(&then) {
        let entity = thing.entity(&of_then);
        let Some(known) = known.get(&entity).filter(|_| things.contains(&entity)) else {
            continue;
        };
        let ours = ObjectState::of(world, entity);
        let (now, then) = (known.state(&now, &of_now), thing.state(&then, &of_then));
        let now = ObjectState {
            keys: then.keys.clone(),
            ..now
        };
        ObjectState::merged(&now, &then, &ours, &ours)
            .state
            .write(world, entity);
    }
    if now.integrator != then.integrator {
        let ours = world.get_resource::<IntegratorSettings>().copied().unwrap_or_default();
        world.insert_resource(IntegratorSettings {
            strategy: ours.strategy,
            schlick: ours.schlick,
            ..then.integrator
        });
    }
}

fn found<'i>(entities: &HashMap<String, Entity>, ids: impl Iterator<Item = &'i Option<String>>) -> Vec<Entity> {
    let entity = |id: &Option<String>| id.as_ref().and_then(|id| entities.get(id)).copied();
    ids.map(|id| entity(id).unwrap_or(Entity::PLACEHOLDER)).collect()
}

/// Updates the entities to a new reading of the file, as [`spawn::update`] does, at the shown time.
pub(in crate::scene) fn update(world: &mut World, scene: &Arc<SceneDescription>) -> ReloadSummary {
    let time = shown_time(world);
    follow_file(world);
    let summary = match &scene.remains.origin {
        Some(origin) if scene.time != time && is_animated(&origin.root) => {
            spawn::update(world, &Arc::new(read(&mut origin.at(time))))
        }
        _ => spawn::update(world, scene),
    };
    show_moment(world, time);
    summary
}
