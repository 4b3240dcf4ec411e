//! A description becomes entities, or changes those that are there: only what differs is written, so that a reload of an unchanged file
//! marks nothing as changed.
//!
//! Entities are recognised by kind and id, those without id by kind, plugin and their number among their like. Entities made in the
//! editor (without [`Authored`]) are left alone by reloads.

use std::collections::{HashMap, HashSet};

use bevy::ecs::component::Mutable;
use bevy::math::Affine3A;
use bevy::prelude::*;

use super::description::{DeclarationPlace, Identity, SceneDescription};
use super::write::gather::Entities;
use super::{
    ActiveSensor, Authored, AuthoredScene, DeclaredIn, DocumentOrder, Emitter, Film, FirstNested, FrameWhenLoaded,
    InstanceOf, IntegratorSettings, Material, MemberOf, SceneId, SecondNested, Sensor, Shape, ShapeGroup, ToWorld,
    UsesMaterial,
};

/// What the file said of a sensor when it was last read. The user moves the camera; a reload moves it back only if the file moved it.
#[derive(Component, Clone, Debug, PartialEq)]
struct SensorOfFile {
    sensor: Sensor,
    film: Film,
    to_world: Affine3A,
}

/// What the file said of the integrator when it was last read.
#[derive(Resource, Clone, Debug, PartialEq)]
struct IntegratorOfFile(IntegratorSettings);

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Kind {
    Sensor,
    Material,
    Group,
    Shape,
    Emitter,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Key {
    Id(Kind, String),
    Number(Kind, String, usize),
}

/// Replaces whatever scene was there.
pub fn spawn_fresh(world: &mut World, scene: &SceneDescription) {
    let old: Vec<Entity> = world
        .query_filtered::<Entity, Or<(
            With<Sensor>,
            With<Material>,
            With<ShapeGroup>,
            With<Shape>,
            With<Emitter>,
        )>>()
        .iter(world)
        .collect();
    for entity in old {
        world.despawn(entity);
    }
    world.remove_resource::<IntegratorOfFile>();
    world.insert_resource(ActiveSensor::default());
    update(world, scene);
}

/// Gives the entities made in the editor their places in the file they were written to, so that they are recognised when it is read again.
/// `written` is what that file says now, `scene` what was written, of these entities.
pub fn adopt(world: &mut World, scene: &SceneDescription, entities: &Entities, written: &SceneDescription) {
    let materials = scene.materials.iter().zip(&written.materials);
    if scene.materials.len() == written.materials.len() {
        for ((old, new), &entity) in materials.zip(&entities.materials) {
            adopt_one(world, entity, &old.identity, &new.identity);
        }
    }
    let shapes = scene.shapes.iter().zip(&written.shapes);
    if scene.shapes.len() == written.shapes.len() {
        for ((old, new), &entity) in shapes.zip(&entities.shapes) {
            adopt_one(world, entity, &old.identity, &new.identity);
        }
    }
    let emitters = scene.emitters.iter().zip(&written.emitters);
    if scene.emitters.len() == written.emitters.len() {
        for ((old, new), &entity) in emitters.zip(&entities.emitters) {
            adopt_one(world, entity, &old.identity, &new.identity);
        }
    }
}

fn adopt_one(world: &mut World, entity: Entity, old: &Identity, new: &Identity) {
    if old.authored.is_none() {
        set(world, entity, DocumentOrder(new.order));
        set_or_remove(world, entity, new.id.clone().map(SceneId));
        set_or_remove(world, entity, new.authored.clone());
    }
}

/// Makes the entities what the description says.
pub fn update(world: &mut World, scene: &SceneDescription) {
    let mut known = Known::new(world);

    let mut materials = Vec::with_capacity(scene.materials.len());
    for material in &scene.materials {
        let entity = known.entity(world, Kind::Material, &material.identity);
        set(world, entity, material.material.clone());
        materials.push(entity);
    }
    let mut groups = Vec::with_capacity(scene.groups.len());
    for group in &scene.groups {
        let entity = known.entity(world, Kind::Group, &group.identity);
        set(world, entity, ShapeGroup);
        groups.push(entity);
    }
    let mut shapes = Vec::with_capacity(scene.shapes.len());
    for shape in &scene.shapes {
        let entity = known.entity(world, Kind::Shape, &shape.identity);
        set(world, entity, shape.shape.clone());
        set(world, entity, ToWorld(shape.to_world));
        set_or_remove(world, entity, shape.area_light.clone());
        relate(
            world,
            entity,
            shape.material.map(|index| UsesMaterial(materials[index])),
        );
        relate(world, entity, shape.member_of.map(|index| MemberOf(groups[index])));
        relate(world, entity, shape.instance_of.map(|index| InstanceOf(groups[index])));
        set_or_remove(world, entity, shape.placements.clone());
        shapes.push(entity);
    }
    for (material, &entity) in scene.materials.iter().zip(&materials) {
        relate(world, entity, material.first.map(|index| FirstNested(materials[index])));
        relate(
            world,
            entity,
            material.second.map(|index| SecondNested(materials[index])),
        );
        let owner = match material.declared_in {
            DeclarationPlace::TopLevel => None,
            DeclarationPlace::Shape(index) => shapes.get(index),
            DeclarationPlace::Material(index) => materials.get(index),
        };
        relate(world, entity, owner.map(|owner| DeclaredIn(*owner)));
    }
    for emitter in &scene.emitters {
        let entity = known.entity(world, Kind::Emitter, &emitter.identity);
        set(world, entity, emitter.emitter.clone());
        set(world, entity, ToWorld(emitter.to_world));
    }
    update_sensors(world, scene, &mut known);
    known.despawn_the_rest(world);

    if world.get_resource::<AuthoredScene>() != Some(&scene.remains) {
        world.insert_resource(scene.remains.clone());
    }
    update_integrator(world, &scene.integrator);
}

fn update_sensors(world: &mut World, scene: &SceneDescription, known: &mut Known) {
    let mut first = None;
    for description in &scene.sensors {
        let entity = known.entity(world, Kind::Sensor, &description.identity);
        first.get_or_insert(entity);
        let now = SensorOfFile {
            sensor: description.sensor,
            film: description.film,
            to_world: description.to_world,
        };
        let before = world.get::<SensorOfFile>(entity).cloned();
        let moved =
            |same: fn(&SensorOfFile, &SensorOfFile) -> bool| before.as_ref().is_none_or(|before| !same(before, &now));
        if moved(|before, now| before.sensor == now.sensor) {
            set(world, entity, now.sensor);
        }
        if moved(|before, now| before.film == now.film) {
            set(world, entity, now.film);
        }
        if moved(|before, now| before.to_world == now.to_world) {
            set(world, entity, ToWorld(now.to_world));
        }
        set(world, entity, now);
    }
    let stand_ins: Vec<Entity> = world
        .query_filtered::<Entity, With<StandInSensor>>()
        .iter(world)
        .collect();
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
    let is_alive = active.is_some_and(|entity| world.get::<Sensor>(entity).is_some() && !known.is_unclaimed(entity));
    if !is_alive {
        world.insert_resource(ActiveSensor(first));
    }
}

/// The sensor of a scene that has none.
#[derive(Component, Clone, Copy, Debug, Default)]
struct StandInSensor;

/// The command line and the panels may have changed the settings; only what the file changed is taken over. What is not the file's
/// business is kept.
fn update_integrator(world: &mut World, now: &IntegratorSettings) {
    let before = world.get_resource::<IntegratorOfFile>().map(|before| before.0);
    if before == Some(*now) {
        return;
    }
    let current = world.get_resource::<IntegratorSettings>().copied().unwrap_or_default();
    let merged = IntegratorSettings {
        strategy: current.strategy,
        schlick: current.schlick,
        ..*now
    };
    if world.get_resource::<IntegratorSettings>() != Some(&merged) {
        world.insert_resource(merged);
    }
    world.insert_resource(IntegratorOfFile(*now));
}

/// The entities of the file as it was, and which of them the new one has claimed.
struct Known {
    entities: HashMap<Key, Entity>,
    unclaimed: HashSet<Entity>,
    numbers: HashMap<(Kind, String), usize>,
}

impl Known {
    fn new(world: &mut World) -> Self {
        let mut items: Vec<_> = world
            .query::<(
                Entity,
                &DocumentOrder,
                &Authored,
                Option<&SceneId>,
                Has<Sensor>,
                Has<Material>,
                Has<Shape>,
                Has<ShapeGroup>,
            )>()
            .iter(world)
            .map(|(entity, order, authored, id, sensor, material, shape, group)| {
                let kind = match (sensor, material, shape, group) {
                    (true, ..) => Kind::Sensor,
                    (_, true, ..) => Kind::Material,
                    (_, _, true, _) => Kind::Shape,
                    (.., true) => Kind::Group,
                    _ => Kind::Emitter,
                };
                (*order, entity, kind, id.cloned(), authored.object.plugin.clone())
            })
            .collect();
        items.sort_by_key(|(order, entity, ..)| (*order, *entity));
        let mut known = Self {
            entities: HashMap::new(),
            unclaimed: HashSet::new(),
            numbers: HashMap::new(),
        };
        for (_, entity, kind, id, plugin) in items {
            let key = known.key(kind, id.as_ref().map(|id| id.0.as_str()), &plugin);
            known.entities.insert(key, entity);
            known.unclaimed.insert(entity);
        }
        known.numbers.clear();
        known
    }

    fn key(&mut self, kind: Kind, id: Option<&str>, plugin: &str) -> Key {
        if let Some(id) = id {
            return Key::Id(kind, id.to_owned());
        }
        let next = self.numbers.entry((kind, plugin.to_owned())).or_default();
        *next += 1;
        Key::Number(kind, plugin.to_owned(), *next)
    }

    /// The entity of this object, new if there was none, with what all kinds have in common up to date.
    fn entity(&mut self, world: &mut World, kind: Kind, identity: &Identity) -> Entity {
        let plugin = identity
            .authored
            .as_ref()
            .map_or("", |authored| &authored.object.plugin);
        let key = self.key(kind, identity.id.as_deref(), plugin);
        let entity = match self.entities.get(&key) {
            Some(&entity) if self.unclaimed.remove(&entity) => entity,
            _ => world.spawn_empty().id(),
        };
        set(world, entity, DocumentOrder(identity.order));
        set_or_remove(world, entity, identity.id.clone().map(SceneId));
        set_or_remove(world, entity, identity.authored.clone());
        if world.get::<Name>(entity).map(Name::as_str) != Some(&identity.name) {
            world.entity_mut(entity).insert(Name::new(identity.name.clone()));
        }
        entity
    }

    fn is_unclaimed(&self, entity: Entity) -> bool {
        self.unclaimed.contains(&entity)
    }

    fn despawn_the_rest(self, world: &mut World) {
        for entity in self.unclaimed {
            world.despawn(entity);
        }
    }
}

/// Writes a component only if it differs.
fn set<C: Component<Mutability = Mutable> + PartialEq>(world: &mut World, entity: Entity, value: C) {
    match world.get_mut::<C>(entity) {
        Some(mut current) => {
            current.set_if_neq(value);
        }
        None => {
            world.entity_mut(entity).insert(value);
        }
    }
}

fn set_or_remove<C: Component<Mutability = Mutable> + PartialEq>(world: &mut World, entity: Entity, value: Option<C>) {
    match value {
        Some(value) => set(world, entity, value),
        None => {
            if world.get::<C>(entity).is_some() {
                world.entity_mut(entity).remove::<C>();
            }
        }
    }
}

/// The same for relationships, which cannot be changed in place.
fn relate<C: Component + PartialEq>(world: &mut World, entity: Entity, value: Option<C>) {
    if world.get::<C>(entity) == value.as_ref() {
        return;
    }
    match value {
        Some(value) => {
            world.entity_mut(entity).insert(value);
        }
        None => {
            world.entity_mut(entity).remove::<C>();
        }
    }
}
