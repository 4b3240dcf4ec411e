//! What the file said of each thing when it was last read or written, and how things are recognised: by kind and id; those without id, of the
//! same kind and plugin, by what they are and their order ([`recognised`]).

use std::collections::HashMap;

use bevy::prelude::*;

use super::description::{DeclarationPlace, Identity, SceneDescription};
use super::recognition::recognised;
use super::write::gather::Entities;
use super::{
    Authored, DeclaredIn, DocumentOrder, FirstNested, InstanceOf, IntegratorSettings, MemberOf, ObjectState, SceneId,
    SecondNested, ShapeGroup, ToWorld, UsesMaterial,
};

/// What the file says, and which entity each thing of it is.
#[derive(Resource, Clone, Debug, Default)]
pub(super) struct FileBase {
    pub(super) things: HashMap<Key, Thing>,
    pub(super) integrator: Option<IntegratorSettings>,
}

#[derive(Clone, Debug)]
pub(super) struct Thing {
    pub(super) entity: Entity,
    /// As the file has it.
    pub(super) state: ObjectState,
    /// As the entity was then; the same, but numbers that were written may have been shortened.
    pub(super) here: ObjectState,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Kind {
    Sensor,
    Material,
    Group,
    Shape,
    Emitter,
}

#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum Key {
    Id(Kind, String),
    Number(Kind, String, usize),
}

/// Gives out keys in the order of the file.
#[derive(Default)]
struct Keys(HashMap<(Kind, String), usize>);

impl Keys {
    fn key(&mut self, kind: Kind, identity: &Identity) -> Key {
        if let Some(id) = &identity.id {
            return Key::Id(kind, id.clone());
        }
        let authored = identity.authored.as_ref();
        let plugin = authored.map_or(String::new(), |authored| authored.object.plugin.clone());
        let next = self.0.entry((kind, plugin.clone())).or_default();
        *next += 1;
        Key::Number(kind, plugin, *next)
    }
}

/// The keys of all that a description has, list by list.
pub(super) struct SceneKeys {
    sensors: Vec<Key>,
    materials: Vec<Key>,
    groups: Vec<Key>,
    shapes: Vec<Key>,
    emitters: Vec<Key>,
}

impl SceneKeys {
    pub(super) fn of(scene: &SceneDescription) -> Self {
        let mut keys = Keys::default();
        let mut list = |kind, identities: &mut dyn Iterator<Item = &Identity>| -> Vec<Key> {
            identities.map(|identity| keys.key(kind, identity)).collect()
        };
        Self {
            sensors: list(Kind::Sensor, &mut scene.sensors.iter().map(|it| &it.identity)),
            materials: list(Kind::Material, &mut scene.materials.iter().map(|it| &it.identity)),
            groups: list(Kind::Group, &mut scene.groups.iter().map(|it| &it.identity)),
            shapes: list(Kind::Shape, &mut scene.shapes.iter().map(|it| &it.identity)),
            emitters: list(Kind::Emitter, &mut scene.emitters.iter().map(|it| &it.identity)),
        }
    }

    /// As [`Self::of`], but those without ids have the keys that they have in `base`.
    pub(super) fn recognised(scene: &SceneDescription, base: &FileBase) -> Self {
        let mut keys = Self::of(scene);
        if base.things.is_empty() {
            return keys;
        }
        let contents = states(scene, &keys.entities(|_| Entity::PLACEHOLDER));
        let mut now: HashMap<(Kind, String), Vec<(&mut Key, ObjectState)>> = HashMap::new();
        for (key, (_, state, _)) in keys.in_order_mut().zip(contents) {
            if let Key::Number(kind, plugin, _) = &*key {
                let like = now.entry((*kind, plugin.clone())).or_default();
                like.push((key, content(state)));
            }
        }
        let mut before: HashMap<(Kind, String), Vec<(Option<DocumentOrder>, usize)>> = HashMap::new();
        for (key, thing) in &base.things {
            if let Key::Number(kind, plugin, number) = key {
                let like = before.entry((*kind, plugin.clone())).or_default();
                like.push((thing.state.order, *number));
            }
        }
        for ((kind, plugin), now) in now {
            let mut before = before.remove(&(kind, plugin.clone())).unwrap_or_default();
            before.sort();
            let key = |number| Key::Number(kind, plugin.clone(), number);
            let known = before.iter().filter_map(|(_, number)| base.things.get(&key(*number)));
            let known: Vec<ObjectState> = known.map(|thing| content(thing.state.clone())).collect();
            let (places, contents): (Vec<&mut Key>, Vec<ObjectState>) = now.into_iter().unzip();
            let mut last = before.iter().map(|(_, number)| *number).max().unwrap_or(0);
            for (place, pair) in places.into_iter().zip(recognised(&known, &contents)) {
                *place = key(pair.map_or_else(
                    || {
                        last += 1;
                        last
                    },
                    |pair| before[pair].1,
                ));
            }
        }
        keys
    }

    /// Each with the entity it is.
    pub(super) fn entities(&self, mut entity: impl FnMut(&Key) -> Entity) -> Entities {
        let mut all = |keys: &[Key]| keys.iter().map(&mut entity).collect();
        Entities {
            sensors: all(&self.sensors),
            materials: all(&self.materials),
            groups: all(&self.groups),
            shapes: all(&self.shapes),
            emitters: all(&self.emitters),
        }
    }

    pub(super) fn in_order(self) -> impl Iterator<Item = Key> {
        let lists = [self.materials, self.groups, self.shapes, self.emitters, self.sensors];
        lists.into_iter().flatten()
    }

    fn in_order_mut(&mut self) -> impl Iterator<Item = &mut Key> {
        let lists = [
            &mut self.materials,
            &mut self.groups,
            &mut self.shapes,
            &mut self.emitters,
            &mut self.sensors,
        ];
        lists.into_iter().flatten()
    }
}

/// What a thing is in itself, whatever it is called, wherever it stands and whatever it refers to.
fn content(state: ObjectState) -> ObjectState {
    ObjectState {
        order: None,
        id: None,
        name: None,
        uses: None,
        first: None,
        second: None,
        declared_in: None,
        member_of: None,
        instance_of: None,
        ..state
    }
}

/// What the description says of each entity, in the order of [`SceneKeys::in_order`].
pub(super) fn states<'s>(
    scene: &'s SceneDescription,
    entities: &Entities,
) -> Vec<(Entity, ObjectState, Option<&'s Authored>)> {
    let mut states = Vec::new();
    let common = |identity: &Identity| ObjectState {
        order: Some(DocumentOrder(identity.order)),
        id: identity.id.clone().map(SceneId),
        name: Some(Name::new(identity.name.clone())),
        ..ObjectState::default()
    };
    for (material, &entity) in scene.materials.iter().zip(&entities.materials) {
        let owner = match material.declared_in {
            DeclarationPlace::TopLevel => None,
            DeclarationPlace::Shape(index) => entities.shapes.get(index),
            DeclarationPlace::Material(index) => entities.materials.get(index),
        };
        let state = ObjectState {
            material: Some(material.material.clone()),
            first: material.first.map(|index| FirstNested(entities.materials[index])),
            second: material.second.map(|index| SecondNested(entities.materials[index])),
            declared_in: owner.map(|owner| DeclaredIn(*owner)),
            ..common(&material.identity)
        };
        states.push((entity, state, material.identity.authored.as_ref()));
    }
    for (group, &entity) in scene.groups.iter().zip(&entities.groups) {
        let state = ObjectState {
            group: Some(ShapeGroup),
            ..common(&group.identity)
        };
        states.push((entity, state, group.identity.authored.as_ref()));
    }
    for (shape, &entity) in scene.shapes.iter().zip(&entities.shapes) {
        let state = ObjectState {
            shape: Some(shape.shape.clone()),
            to_world: Some(ToWorld(shape.to_world)),
            area_light: shape.area_light.clone(),
            uses: shape.material.map(|index| UsesMaterial(entities.materials[index])),
            member_of: shape.member_of.map(|index| MemberOf(entities.groups[index])),
            instance_of: shape.instance_of.map(|index| InstanceOf(entities.groups[index])),
            placements: shape.placements.clone(),
            ..common(&shape.identity)
        };
        states.push((entity, state, shape.identity.authored.as_ref()));
    }
    for (emitter, &entity) in scene.emitters.iter().zip(&entities.emitters) {
        let state = ObjectState {
            emitter: Some(emitter.emitter.clone()),
            to_world: Some(ToWorld(emitter.to_world)),
            ..common(&emitter.identity)
        };
        states.push((entity, state, emitter.identity.authored.as_ref()));
    }
    for (sensor, &entity) in scene.sensors.iter().zip(&entities.sensors) {
        let state = ObjectState {
            sensor: Some(sensor.sensor),
            film: Some(sensor.film),
            to_world: Some(ToWorld(sensor.to_world)),
            ..common(&sensor.identity)
        };
        states.push((entity, state, sensor.identity.authored.as_ref()));
    }
    states
}

pub(super) fn set_authored(world: &mut World, entity: Entity, authored: Option<Authored>) {
    if world.get::<Authored>(entity) == authored.as_ref() {
        return;
    }
    match authored {
        Some(authored) => {
            world.entity_mut(entity).insert(authored);
        }
        None => {
            world.entity_mut(entity).remove::<Authored>();
        }
    }
}
