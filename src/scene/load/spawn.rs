//! Turns a description into entities, or updates existing ones. Only differences are written, so that a reload of an
//! unchanged file marks nothing as changed.
//!
//! The description of the file as it was last read or written is kept. A change on both sides is taken from the file,
//! and all other edits stay.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use bevy::ecs::entity::EntityHashSet;
use bevy::prelude::*;

use crate::scene::components::description::SceneDescription;
use crate::scene::components::free_name::free_name;
use crate::scene::components::medium::users_of_medium;
use crate::scene::components::moment::ShownTime;
use crate::scene::components::names::names;
use crate::scene::file::entities::Entities;
use crate::scene::file::file_base::{FileBase, Recognised, Thing, set_authored};
use crate::scene::{
    ActiveSensor, Authored, AuthoredScene, DocumentOrder, Emitter, FirstNestedIn, FrameWhenLoaded, FreeView,
    IntegratorKeys, IntegratorSettings, Keys, Material, MaterialUsers, Medium, ObjectState, Properties, ReloadSummary,
    SceneId, SceneProperties, SecondNestedIn, Sensor, Shape, ShapeGroup, ToWorld,
};

/// Spawns the scene in place of the open one.
pub fn spawn_fresh(world: &mut World, scene: &Arc<SceneDescription>) {
    let mut spawning = Spawning::begin(world, scene.clone());
    while !spawning.step(world) {}
    spawning.finish(world);
}

/// A new scene that replaces the open one step by step.
pub(in crate::scene) struct Spawning {
    scene: Arc<SceneDescription>,
    /// The entities of the old scene that are still to be despawned.
    old: Vec<Entity>,
    /// The entities of the new scene, once the old ones are despawned.
    entities: Option<Entities>,
    /// The things whose entities have no components yet.
    rest: Box<dyn Iterator<Item = Thing> + Send + Sync>,
}

impl Spawning {
    /// The number of things that one step despawns or makes, a millisecond's work.
    pub const STEP: usize = 256;

    pub fn begin(world: &mut World, scene: Arc<SceneDescription>) -> Self {
        let mut old = world.query_filtered::<Entity, Or<(
            With<Sensor>,
            With<Medium>,
            With<Material>,
            With<ShapeGroup>,
            With<Shape>,
            With<Emitter>,
            With<Authored>,
        )>>();
        Self {
            old: old.iter(world).collect(),
            entities: None,
            rest: Box::new(Thing::all(&scene)),
            scene,
        }
    }

    /// Does a step; true once everything exists.
    pub fn step(&mut self, world: &mut World) -> bool {
        let left = self.old.len().saturating_sub(Self::STEP);
        if !self.old.is_empty() {
            for entity in self.old.drain(left..) {
                world.despawn(entity);
            }
            return false;
        }
        let entities = self.entities.get_or_insert_with(|| {
            world.insert_resource(FileBase::default());
            world.insert_resource(ActiveSensor::default());
            world.insert_resource(FreeView::default());
            let recognised = Recognised::new(&SceneDescription::default(), &self.scene);
            recognised.entities(&Entities::default(), |_| world.spawn_empty().id())
        });
        let mut made = 0;
        for thing in self.rest.by_ref().take(Self::STEP) {
            let authored = thing.identity(&self.scene).authored.clone();
            let state = thing.state(&self.scene, entities);
            state.write_new(world, thing.entity(entities), authored);
            made += 1;
        }
        made < Self::STEP
    }

    /// Does the remaining work once everything exists.
    pub fn finish(self, world: &mut World) {
        let entities = self.entities.unwrap_or_default();
        world.insert_resource(ShownTime(self.scene.time));
        update_cameras(world, &entities.sensors);
        world.insert_resource(FileBase {
            scene: self.scene.clone(),
            entities,
            ..FileBase::default()
        });
        take_over_remains(world, &self.scene);
        world.insert_resource(self.scene.unit);
        world.insert_resource(self.scene.light_units);
        world.insert_resource(self.scene.properties.clone());
    }
}

/// Takes the parts of the scene that became no entity, and its integrator.
fn take_over_remains(world: &mut World, scene: &SceneDescription) {
    if world.get_resource::<AuthoredScene>() != Some(&scene.remains) {
        world.insert_resource(scene.remains.clone());
    }
    update_integrator(world, scene);
}

/// Updates the entities to the description, without the edits since it was last read or written.
pub fn update(world: &mut World, scene: &Arc<SceneDescription>) -> ReloadSummary {
    let base = world.remove_resource::<FileBase>().unwrap_or_default();
    let mut summary = ReloadSummary::default();
    let recognised = Recognised::new(&base.scene, scene);
    let entities = recognised.entities(&base.entities, |known| match known {
        Some(entity) if world.get_entity(entity).is_ok() => entity,
        _ => world.spawn_empty().id(),
    });
    let keeps_order = is_in_order(world, scene, &entities);
    let watched = looked_from(world);
    let mut new_base = FileBase {
        scene: scene.clone(),
        integrator: base.integrator.clone(),
        ..FileBase::default()
    };
    let mut new_ids = HashMap::new();
    // If nothing has an id, ids cannot collide.
    let has_ids = world.query::<&SceneId>().iter(world).next().is_some();
    for thing in Thing::all(scene) {
        let entity = thing.entity(&entities);
        let known = recognised.before(thing);
        let known = known.filter(|known| known.entity(&base.entities) == entity);
        // Most things of a large scene have not changed in the file: only their order is updated.
        if let Some(known) = known
            && keeps_order
            && !base.unlike_file.contains_key(&entity)
            && thing.is_same((scene, &entities), known, (&base.scene, &base.entities))
        {
            set_authored(world, entity, thing.identity(scene).authored.as_ref());
            continue;
        }
        let theirs = thing.state(scene, &entities);
        let Some(known) = known else {
            summary.added += 1;
            if has_ids {
                new_ids.extend(theirs.id.clone().map(|id| (id, entity)));
            }
            theirs.write_new(world, entity, thing.identity(scene).authored.clone());
            continue;
        };
        let ours = ObjectState::of(world, entity);
        let now = taken_over(
            &base,
            known,
            &thing.identity(scene).name,
            (&theirs, &ours),
            &mut summary,
        );
        let now = ObjectState {
            order: if keeps_order { ours.order } else { theirs.order },
            ..now
        };
        now.write(world, entity);
        set_authored(world, entity, thing.identity(scene).authored.as_ref());
        // An edit since the last reading stays an edit.
        let here = match ours == now {
            true => base.state_then(known),
            false => now,
        };
        new_base.remember(entity, here, &theirs);
    }
    let claimed: EntityHashSet = match base.entities.all().next() {
        Some(_) => entities.all().collect(),
        None => EntityHashSet::default(),
    };
    let is_gone: EntityHashSet = base.entities.all().filter(|entity| !claimed.contains(entity)).collect();
    let gone = Thing::all(&base.scene).filter(|thing| is_gone.contains(&thing.entity(&base.entities)));
    for thing in gone {
        let entity = thing.entity(&base.entities);
        let ours = ObjectState::of(world, entity);
        set_authored(world, entity, None);
        if !ours.is_there() {
            continue;
        }
        let is_untouched = ours.for_file().unordered() == base.state_then(thing).for_file().unordered();
        if is_untouched && !is_needed(world, entity, &is_gone) {
            // The entity loses its components but stays, so that it can come back when its edit is undone.
            ObjectState::default().write(world, entity);
            summary.removed += 1;
        } else {
            summary.kept += 1;
        }
    }
    summary.renamed = give_way(world, &new_ids);
    update_cameras(world, &entities.sensors);
    new_base.entities = entities;
    world.insert_resource(new_base);
    if watched.is_some() && looked_from(world) != watched {
        // A user who moves the camera in the file wants its view.
        world.insert_resource(FreeView::default());
    }
    summary.replaced.extend(integrator_edited_twice(world, scene));
    take_over_remains(world, scene);
    if base.scene.unit != scene.unit {
        world.insert_resource(scene.unit);
    }
    if base.scene.light_units != scene.light_units {
        world.insert_resource(scene.light_units);
    }
    if base.scene.properties != scene.properties {
        let ours = world.get_resource_or_init::<SceneProperties>().0.clone();
        let [before, theirs] = [&base.scene.properties.0, &scene.properties.0];
        world.insert_resource(SceneProperties(Properties::merged(before, theirs, &ours)));
    }
    summary
}

/// The names of things that [`update`] would find edited both here and in the file, the integrator among them. Changes
/// nothing.
pub fn edited_twice(world: &World, scene: &SceneDescription) -> Vec<String> {
    let none = FileBase::default();
    let base = world.get_resource::<FileBase>().unwrap_or(&none);
    let recognised = Recognised::new(&base.scene, scene);
    let entities = recognised.entities(&base.entities, |known| match known {
        Some(entity) if world.get_entity(entity).is_ok() => entity,
        _ => Entity::PLACEHOLDER,
    });
    let mut summary = ReloadSummary::default();
    for thing in Thing::all(scene) {
        let entity = thing.entity(&entities);
        let known = recognised.before(thing);
        if let Some(known) = known.filter(|known| known.entity(&base.entities) == entity) {
            let (theirs, ours) = (thing.state(scene, &entities), ObjectState::of(world, entity));
            let name = &thing.identity(scene).name;
            taken_over(base, known, name, (&theirs, &ours), &mut summary);
        }
    }
    summary.replaced.extend(integrator_edited_twice(world, scene));
    summary.replaced
}

/// Renames things of the scene whose ids are taken by new things of the file. Returns their number.
pub(in crate::scene) fn give_way(world: &mut World, new_ids: &HashMap<SceneId, Entity>) -> usize {
    if new_ids.is_empty() {
        return 0;
    }
    let mut known = world.query::<(Entity, &SceneId)>();
    let is_of_same_id = |(entity, id): &(Entity, &SceneId)| new_ids.get(*id).is_some_and(|new| new != entity);
    let same: Vec<(Entity, SceneId)> = known
        .iter(world)
        .filter(is_of_same_id)
        .map(|(entity, id)| (entity, id.clone()))
        .collect();
    let mut taken = if same.is_empty() { HashSet::new() } else { names(world) };
    for (entity, id) in &same {
        let name = free_name(&taken, &id.0);
        world
            .entity_mut(*entity)
            .insert((SceneId(name.clone()), Name::new(name.clone())));
        taken.insert(name);
    }
    same.len()
}

/// Whether a thing that stays uses this material or medium.
fn is_needed(world: &World, material: Entity, is_gone: &EntityHashSet) -> bool {
    let stays = |user: Entity| !is_gone.contains(&user) && ObjectState::is_in_scene(world, user);
    if users_of_medium(world, material).any(stays) {
        return true;
    }
    let users = world
        .get::<MaterialUsers>(material)
        .is_some_and(|users| users.iter().any(stays));
    let first = world
        .get::<FirstNestedIn>(material)
        .is_some_and(|outer| outer.iter().any(stays));
    users
        || first
        || world
            .get::<SecondNestedIn>(material)
            .is_some_and(|outer| outer.iter().any(stays))
}

/// Whether the entities are already in the order of the file; then their numbers are kept.
fn is_in_order(world: &World, scene: &SceneDescription, entities: &Entities) -> bool {
    let order_of = |thing: Thing| {
        let here = world.get::<DocumentOrder>(thing.entity(entities)).copied();
        Some((thing.identity(scene).order, here?))
    };
    let Some(mut places) = Thing::all(scene).map(order_of).collect::<Option<Vec<_>>>() else {
        return false;
    };
    places.sort();
    places.is_sorted_by(|a, b| a.1 < b.1)
}

/// The merged state of a thing with this name in the file, which is `theirs` in the file now and `ours` here. `known`
/// is the thing in `base`.
fn taken_over(
    base: &FileBase,
    known: Thing,
    name: &str,
    (theirs, ours): (&ObjectState, &ObjectState),
    summary: &mut ReloadSummary,
) -> ObjectState {
    let (before, new) = (known.state(&base.scene, &base.entities).unordered(), theirs.unordered());
    if !ours.is_there() {
        // The thing was deleted here: it returns only if the file has changed it.
        if before == new {
            return ours.clone();
        }
        summary.replaced.push(name.to_owned());
        return theirs.clone();
    }
    let marks = ObjectState {
        hidden: ours.hidden,
        locked: ours.locked,
        ..base.state_then(known).unordered()
    };
    let merged = ObjectState::merged(&before, &new, &marks, &ours.unordered());
    summary.kept += usize::from(merged.kept && before != new);
    if merged.replaced {
        summary.replaced.push(name.to_owned());
    }
    summary.changed += usize::from(merged.state != ours.unordered() && !merged.replaced);
    merged.state
}

/// The camera in use and its pose.
fn looked_from(world: &World) -> Option<(Entity, ToWorld)> {
    let active = world.get_resource::<ActiveSensor>()?.0?;
    Some((active, *world.get::<ToWorld>(active)?))
}

/// A scene without a camera gets a stand-in until it has its own, and a sensor becomes active.
fn update_cameras(world: &mut World, of_file: &[Entity]) {
    let is_camera = |world: &World, entity: &Entity| world.get::<Sensor>(*entity).is_some();
    let is_stand_in = |world: &World, entity: Entity| world.get::<StandInSensor>(entity).is_some();
    let stand_ins: Vec<Entity> = world
        .query_filtered::<Entity, With<StandInSensor>>()
        .iter(world)
        .collect();
    let mut first = of_file
        .iter()
        .copied()
        .find(|entity| is_camera(world, entity) && !is_stand_in(world, *entity));
    if first.is_some() {
        for entity in stand_ins {
            world.despawn(entity);
        }
    } else {
        first = stand_ins.first().copied().or_else(|| {
            let name = Name::new("camera");
            let sensor = Sensor {
                fov: 45.0,
                ..Sensor::default()
            };
            Some(world.spawn((sensor, name, StandInSensor, FrameWhenLoaded)).id())
        });
    }
    let active = world.get_resource::<ActiveSensor>().and_then(|active| active.0);
    if !active.is_some_and(|active| is_camera(world, &active)) {
        world.insert_resource(ActiveSensor(first));
    }
}

/// The stand-in sensor of a scene without one.
#[derive(Component, Clone, Copy, Debug, Default)]
pub(in crate::scene) struct StandInSensor;

/// The integrator as the name of a thing, if its settings were edited both here and in the file.
fn integrator_edited_twice(world: &World, scene: &SceneDescription) -> Option<String> {
    let theirs = (scene.integrator, &scene.integrator_keys);
    let of_file = |settings: IntegratorSettings| IntegratorSettings {
        strategy: scene.integrator.strategy,
        schlick: scene.integrator.schlick,
        ..settings
    };
    let none = Keys::default();
    let our_keys = world.get_resource::<IntegratorKeys>().map_or(&none, |keys| &keys.0);
    let ours = world.get_resource::<IntegratorSettings>().copied().unwrap_or_default();
    let ours = (of_file(ours), our_keys);
    let base = world.get_resource::<FileBase>();
    let (settings, keys) = base?.integrator.as_ref()?;
    let before = (of_file(*settings), keys);
    (before != theirs && before != ours && ours != theirs).then(|| "the integrator".to_owned())
}

/// The command line and the panels may have changed the settings, so only changes of the file are taken. Settings that
/// are not in files are kept.
fn update_integrator(world: &mut World, scene: &SceneDescription) {
    let now = (scene.integrator, scene.integrator_keys.clone());
    let mut base = world.get_resource_or_init::<FileBase>();
    let before = base.integrator.replace(now.clone());
    if before.as_ref() == Some(&now) {
        return;
    }
    world.insert_resource(IntegratorKeys(now.1));
    let current = world.get_resource::<IntegratorSettings>().copied().unwrap_or_default();
    let merged = IntegratorSettings {
        strategy: current.strategy,
        schlick: current.schlick,
        ..now.0
    };
    if current != merged || !world.contains_resource::<IntegratorSettings>() {
        world.insert_resource(merged);
    }
}
