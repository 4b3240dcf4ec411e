//! A description becomes entities, or changes those that are there: only what differs is written, so that a reload of an unchanged file
//! marks nothing as changed.
//!
//! Things are recognised by kind and id, those without id by kind, plugin and their number among their like. What the file said of them when it
//! was last read or written is remembered: of what changed on both sides the file wins, everything else that was edited stays.

use std::collections::{HashMap, HashSet};

use bevy::prelude::*;

use super::description::{DeclarationPlace, Identity, SceneDescription};
use super::write::gather::Entities;
use super::{
    ActiveSensor, Authored, AuthoredScene, DeclaredIn, DocumentOrder, Emitter, FirstNested, FirstNestedIn,
    FrameWhenLoaded, FreeView, InstanceOf, IntegratorSettings, Material, MaterialUsers, MemberOf, ObjectState,
    Placements, SceneId, SecondNested, SecondNestedIn, Sensor, Shape, ShapeGroup, ToWorld, UsesMaterial,
};

/// What the file says, and which entity each thing of it is.
#[derive(Resource, Clone, Debug, Default)]
pub(super) struct FileBase {
    things: HashMap<Key, Thing>,
    integrator: Option<IntegratorSettings>,
}

#[derive(Clone, Debug)]
struct Thing {
    entity: Entity,
    /// As the file has it.
    state: ObjectState,
    /// As the entity was then; the same, but numbers that were written may have been shortened.
    here: ObjectState,
}

/// What a reload did, in numbers of things.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReloadSummary {
    pub added: usize,
    pub changed: usize,
    pub removed: usize,
    /// Are as they were edited here, though the file says otherwise.
    pub kept: usize,
    /// Were edited here and in the file; the file's edit counts.
    pub replaced: usize,
}

impl ReloadSummary {
    /// Whether the entities are as before.
    pub fn is_unchanged(&self) -> bool {
        self.added + self.changed + self.removed + self.replaced == 0
    }

    /// "2 things changed, 1 new, 3 edits kept"; empty if there is nothing to say.
    pub fn text(&self) -> String {
        let parts = [
            (self.changed, "changed"),
            (self.added, "new"),
            (self.removed, "gone"),
            (self.kept, "with edits kept"),
            (self.replaced, "edited on both sides, the file's edit taken"),
        ];
        let parts = parts.iter().filter(|(count, _)| *count > 0);
        parts
            .map(|(count, what)| format!("{count} {what}"))
            .collect::<Vec<_>>()
            .join(", ")
    }
}

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
struct SceneKeys {
    sensors: Vec<Key>,
    materials: Vec<Key>,
    groups: Vec<Key>,
    shapes: Vec<Key>,
    emitters: Vec<Key>,
}

impl SceneKeys {
    fn of(scene: &SceneDescription) -> Self {
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

    /// Each with the entity it is.
    fn entities(&self, mut entity: impl FnMut(&Key) -> Entity) -> Entities {
        let mut all = |keys: &[Key]| keys.iter().map(&mut entity).collect();
        Entities {
            sensors: all(&self.sensors),
            materials: all(&self.materials),
            groups: all(&self.groups),
            shapes: all(&self.shapes),
            emitters: all(&self.emitters),
        }
    }

    fn in_order(self) -> impl Iterator<Item = Key> {
        let lists = [self.materials, self.groups, self.shapes, self.emitters, self.sensors];
        lists.into_iter().flatten()
    }
}

/// What the description says of each entity, in the order of [`SceneKeys::in_order`].
fn states<'s>(scene: &'s SceneDescription, entities: &Entities) -> Vec<(Entity, ObjectState, Option<&'s Authored>)> {
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

/// Replaces whatever scene was there.
pub fn spawn_fresh(world: &mut World, scene: &SceneDescription) {
    let old: Vec<Entity> = world
        .query_filtered::<Entity, Or<(
            With<Sensor>,
            With<Material>,
            With<ShapeGroup>,
            With<Shape>,
            With<Emitter>,
            With<Authored>,
        )>>()
        .iter(world)
        .collect();
    for entity in old {
        world.despawn(entity);
    }
    world.insert_resource(FileBase::default());
    world.insert_resource(ActiveSensor::default());
    world.insert_resource(FreeView::default());
    update(world, scene);
}

/// Makes the entities what the description says, but for what was edited since it was last read or written.
pub fn update(world: &mut World, scene: &SceneDescription) -> ReloadSummary {
    let base = world.remove_resource::<FileBase>().unwrap_or_default();
    let mut summary = ReloadSummary::default();
    let keys = SceneKeys::of(scene);
    let entities = keys.entities(|key| match base.things.get(key) {
        Some(thing) if world.get_entity(thing.entity).is_ok() => thing.entity,
        _ => world.spawn_empty().id(),
    });
    let states = states(scene, &entities);
    let keeps_order = is_in_order(world, &states);
    let watched = looked_from(world);
    let mut things = HashMap::new();
    for (key, (entity, theirs, authored)) in keys.in_order().zip(states) {
        let ours = ObjectState::of(world, entity);
        let now = match base.things.get(&key).filter(|thing| thing.entity == entity) {
            None => {
                summary.added += 1;
                theirs.clone()
            }
            Some(thing) => taken_over(thing, &theirs, &ours, &mut summary),
        };
        let now = ObjectState {
            order: if keeps_order { ours.order } else { theirs.order },
            ..now
        };
        now.write(world, entity);
        set_authored(world, entity, authored.cloned());
        // What was edited since stays an edit.
        let here = base
            .things
            .get(&key)
            .filter(|_| ours == now)
            .map_or(now, |thing| thing.here.clone());
        let state = theirs;
        things.insert(key, Thing { entity, state, here });
    }
    let claimed: HashSet<Entity> = things.values().map(|thing| thing.entity).collect();
    let gone: Vec<&Thing> = base
        .things
        .values()
        .filter(|thing| !claimed.contains(&thing.entity))
        .collect();
    let is_gone: HashSet<Entity> = gone.iter().map(|thing| thing.entity).collect();
    for thing in gone {
        let ours = ObjectState::of(world, thing.entity);
        set_authored(world, thing.entity, None);
        if !ours.is_there() {
            continue;
        }
        let is_untouched = ours.for_file().unordered() == thing.here.for_file().unordered();
        if is_untouched && !is_needed(world, thing.entity, &is_gone) {
            // Without components it can come back when an edit of it is taken back.
            ObjectState::default().write(world, thing.entity);
            summary.removed += 1;
        } else {
            summary.kept += 1;
        }
    }
    world.insert_resource(FileBase {
        things,
        integrator: base.integrator,
    });
    update_cameras(world, &entities.sensors);
    if watched.is_some() && looked_from(world) != watched {
        // Whoever moves the camera in the file wants to see from there.
        world.insert_resource(FreeView::default());
    }
    if world.get_resource::<AuthoredScene>() != Some(&scene.remains) {
        world.insert_resource(scene.remains.clone());
    }
    update_integrator(world, &scene.integrator);
    summary
}

/// Whether something that stays uses this material.
fn is_needed(world: &World, material: Entity, is_gone: &HashSet<Entity>) -> bool {
    let stays = |user: Entity| !is_gone.contains(&user) && ObjectState::is_in_scene(world, user);
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

/// Whether the entities stand in the order of the file already, whatever their numbers; numbers are not changed then.
fn is_in_order(world: &World, states: &[(Entity, ObjectState, Option<&Authored>)]) -> bool {
    let mut places: Vec<(Option<DocumentOrder>, Option<DocumentOrder>)> = states
        .iter()
        .map(|(entity, state, _)| (state.order, world.get::<DocumentOrder>(*entity).copied()))
        .collect();
    places.sort();
    places.iter().all(|(_, here)| here.is_some()) && places.is_sorted_by(|a, b| a.1 < b.1)
}

/// What a thing is after the file said `theirs`, and it is `ours` here.
fn taken_over(thing: &Thing, theirs: &ObjectState, ours: &ObjectState, summary: &mut ReloadSummary) -> ObjectState {
    let (before, new) = (thing.state.unordered(), theirs.unordered());
    if !ours.is_there() {
        // Deleted here: it comes back only if the file has something new to say of it.
        if before == new {
            return ours.clone();
        }
        summary.replaced += 1;
        return theirs.clone();
    }
    let marks = ObjectState {
        hidden: ours.hidden,
        locked: ours.locked,
        ..thing.here.unordered()
    };
    let merged = ObjectState::merged_since(&before, &new, &marks, &ours.unordered());
    summary.kept += usize::from(merged.kept && before != new);
    summary.replaced += usize::from(merged.replaced);
    summary.changed += usize::from(merged.state != ours.unordered() && !merged.replaced);
    merged.state
}

/// The camera in use and where it stands.
fn looked_from(world: &World) -> Option<(Entity, ToWorld)> {
    let active = world.get_resource::<ActiveSensor>()?.0?;
    Some((active, *world.get::<ToWorld>(active)?))
}

fn set_authored(world: &mut World, entity: Entity, authored: Option<Authored>) {
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

/// The file now says what `written` says, which was made of `scene`, of these entities: what was made in the editor belongs to it from now on.
pub(super) fn rebase(world: &mut World, scene: &SceneDescription, entities: &Entities, written: &SceneDescription) {
    let keys = SceneKeys::of(written);
    let mut paired = |known: &[Entity], pairs: Vec<Option<usize>>| {
        let pairs = pairs.into_iter().map(|index| index.map(|index| known[index]));
        pairs
            .map(|entity| entity.unwrap_or_else(|| world.spawn_empty().id()))
            .collect()
    };
    let shapes = pairs(
        &scene.shapes,
        &written.shapes,
        |it| &it.identity,
        |a, b| {
            std::mem::discriminant(&a.shape.kind) == std::mem::discriminant(&b.shape.kind)
                && a.member_of.is_some() == b.member_of.is_some()
                && a.instance_of.is_some() == b.instance_of.is_some()
        },
    );
    let now = Entities {
        materials: paired(&entities.materials, material_pairs(scene, written, &shapes)),
        shapes: paired(&entities.shapes, shapes),
        sensors: paired(
            &entities.sensors,
            pairs(&scene.sensors, &written.sensors, |it| &it.identity, |_, _| true),
        ),
        groups: paired(
            &entities.groups,
            pairs(&scene.groups, &written.groups, |it| &it.identity, |_, _| true),
        ),
        emitters: paired(
            &entities.emitters,
            pairs(
                &scene.emitters,
                &written.emitters,
                |it| &it.identity,
                |a, b| a.emitter.plugin() == b.emitter.plugin(),
            ),
        ),
    };
    let mut things = HashMap::new();
    for (key, (entity, state, authored)) in keys.in_order().zip(states(written, &now)) {
        set_authored(world, entity, authored.cloned());
        if ObjectState::of(world, entity).is_there()
            && let Some(id) = &state.id
            && world.get::<SceneId>(entity) != Some(id)
        {
            world.entity_mut(entity).insert((id.clone(), Name::new(id.0.clone())));
        }
        // They stand elsewhere in this text.
        if let Some(placements) = state
            .placements
            .clone()
            .filter(|_| world.get::<Placements>(entity).is_some())
        {
            world.entity_mut(entity).insert(placements);
        }
        let here = ObjectState::of(world, entity);
        things.insert(key, Thing { entity, state, here });
    }
    let claimed: HashSet<Entity> = things.values().map(|thing| thing.entity).collect();
    let mut others = world.query_filtered::<Entity, With<Authored>>();
    let others: Vec<Entity> = others.iter(world).filter(|entity| !claimed.contains(entity)).collect();
    for entity in others {
        set_authored(world, entity, None);
    }
    for &camera in &now.sensors {
        world.entity_mut(camera).remove::<StandInSensor>();
    }
    world.insert_resource(FileBase {
        things,
        integrator: Some(written.integrator),
    });
    world.insert_resource(written.remains.clone());
}

/// For each of the written things which of the known ones it is: of the same id, or else the next without one that is alike.
fn pairs<T>(
    known: &[T],
    written: &[T],
    identity: fn(&T) -> &Identity,
    is_alike: fn(&T, &T) -> bool,
) -> Vec<Option<usize>> {
    fn id<T>(thing: &T, identity: fn(&T) -> &Identity) -> Option<&String> {
        identity(thing).id.as_ref()
    }
    let by_id: HashMap<&String, usize> = known
        .iter()
        .zip(0..)
        .filter_map(|(it, index)| Some((id(it, identity)?, index)))
        .collect();
    let mut next = 0;
    let partner = |thing: &T| {
        if let Some(&same) = id(thing, identity).and_then(|id| by_id.get(id)) {
            return Some(same);
        }
        let nameless = |index: &usize| id(&known[*index], identity).is_none() && is_alike(&known[*index], thing);
        let found = (next..known.len()).find(nameless)?;
        next = found + 1;
        Some(found)
    };
    written.iter().map(partner).collect()
}

/// Which of the known materials each written one is: by who uses it, outermost first, or else as [`pairs`] finds it.
fn material_pairs(
    scene: &SceneDescription,
    written: &SceneDescription,
    shapes: &[Option<usize>],
) -> Vec<Option<usize>> {
    let mut pairs = vec![None; written.materials.len()];
    let mut is_taken = vec![false; scene.materials.len()];
    let mut waiting: Vec<(usize, usize)> = Vec::new();
    for (shape, known) in written.shapes.iter().zip(shapes) {
        let known = known.and_then(|known| scene.shapes[known].material);
        waiting.extend(shape.material.zip(known));
    }
    let is_alike = |known: usize, new: usize| {
        let (known, new) = (&scene.materials[known], &written.materials[new]);
        known.material.plugin() == new.material.plugin()
    };
    while let Some((new, known)) = waiting.pop() {
        if pairs[new].is_some() || is_taken[known] || !is_alike(known, new) {
            continue;
        }
        pairs[new] = Some(known);
        is_taken[known] = true;
        let (known, new) = (&scene.materials[known], &written.materials[new]);
        waiting.extend(new.first.zip(known.first));
        waiting.extend(new.second.zip(known.second));
    }
    let by_order = self::pairs(
        &scene.materials,
        &written.materials,
        |it| &it.identity,
        |a, b| a.material.plugin() == b.material.plugin(),
    );
    for (pair, other) in pairs.iter_mut().zip(by_order) {
        if pair.is_none()
            && let Some(other) = other.filter(|other| !is_taken[*other])
        {
            is_taken[other] = true;
            *pair = Some(other);
        }
    }
    pairs
}

/// A scene without a camera gets one until it has its own, and something is looked through.
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

/// The sensor of a scene that has none.
#[derive(Component, Clone, Copy, Debug, Default)]
struct StandInSensor;

/// The command line and the panels may have changed the settings; only what the file changed is taken over. What is not the file's
/// business is kept.
fn update_integrator(world: &mut World, now: &IntegratorSettings) {
    let mut base = world.get_resource_or_init::<FileBase>();
    if base.integrator.replace(*now) == Some(*now) {
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
}
