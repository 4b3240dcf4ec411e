//! Copies the scene in steps, so that no frame has to copy a whole large scene. The copy is consistent with its last
//! moment: things that have changed since they were copied are copied again, until few enough are left to copy them at
//! once.

use bevy::ecs::archetype::{Archetype, ArchetypeId};
use bevy::ecs::change_detection::Tick;
use bevy::ecs::entity::{EntityHashMap, EntityHashSet};
use bevy::ecs::relationship::Relationship;
use bevy::prelude::*;

use crate::scene::components::description::{
    DeclarationPlace, EmitterDescription, GroupDescription, Identity, MaterialDescription, MediumDescription,
    SceneDescription, SensorDescription, ShapeDescription,
};
use crate::scene::components::moment::shown_time;
use crate::scene::file::entities::Entities;
use crate::scene::file::file_moment::follow_file;
use crate::scene::{
    AreaLight, Authored, AuthoredScene, DeclaredIn, DocumentOrder, Emitter, EulerAngles, ExteriorMedium, Film,
    FirstNested, InMedium, InstanceOf, IntegratorKeys, IntegratorSettings, InteriorMedium, Keys, Material, Medium,
    MemberOf, Placements, Properties, SceneId, SceneStatus, SecondNested, Sensor, Shape, ShapeGroup, ToWorld,
    UsesMaterial,
};

/// The number of things that are copied at once at the end.
const FEW: usize = 512;
/// The number of rounds after which the rest is copied at once, in case everything changes all the time.
const MOST_ROUNDS: usize = 8;

/// The copied state of an entity: another archetype shows that a component was added or removed.
struct Copied {
    archetype: ArchetypeId,
    kind: Kind,
    /// The index in the list of the kind.
    index: usize,
}

#[derive(Clone, Copy)]
enum Kind {
    Sensor,
    Medium,
    Material,
    Group,
    Shape,
    Emitter,
}

/// The most references of a thing, those of a shape.
const MOST_REFERENCES: usize = 5;

/// The description of an entity.
struct Described<T> {
    /// None if it is outdated.
    entity: Option<Entity>,
    thing: T,
    /// The referenced entities, which the description itself does not have yet.
    refers_to: [Option<Entity>; MOST_REFERENCES],
}

/// A copy of the scene, in progress or complete.
#[derive(Default)]
pub(crate) struct Snapshot {
    /// The part of the scene outside of entities.
    scene: SceneDescription,
    sensors: Vec<Described<SensorDescription>>,
    media: Vec<Described<MediumDescription>>,
    materials: Vec<Described<MaterialDescription>>,
    groups: Vec<Described<GroupDescription>>,
    shapes: Vec<Described<ShapeDescription>>,
    emitters: Vec<Described<EmitterDescription>>,
    copied: EntityHashMap<Copied>,
    /// The things that are still to be copied in this round.
    rest: std::vec::IntoIter<Entity>,
    /// The tick at which this round began.
    since: Tick,
    rounds: usize,
}

type Changes = Or<(
    Or<(
        Changed<DocumentOrder>,
        Changed<SceneId>,
        Changed<Name>,
        Changed<Authored>,
        Changed<ToWorld>,
        Changed<Sensor>,
        Changed<Film>,
        Changed<Emitter>,
        Changed<Shape>,
    )>,
    Or<(
        Changed<Material>,
        Changed<UsesMaterial>,
        Changed<AreaLight>,
        Changed<MemberOf>,
        Changed<InstanceOf>,
        Changed<Placements>,
        Changed<FirstNested>,
        Changed<SecondNested>,
        Changed<DeclaredIn>,
        Changed<Keys>,
    )>,
    Or<(
        Changed<EulerAngles>,
        Changed<Properties>,
        Changed<Medium>,
        Changed<InteriorMedium>,
        Changed<ExteriorMedium>,
        Changed<InMedium>,
    )>,
)>;

impl Snapshot {
    pub fn begin(world: &mut World) -> Self {
        follow_file(world);
        let since = world.increment_change_tick();
        let mut things: Vec<(DocumentOrder, Entity)> = world
            .query::<(&DocumentOrder, Entity)>()
            .iter(world)
            .map(|(order, entity)| (*order, entity))
            .collect();
        things.sort_unstable();
        let mut shapes = world.query_filtered::<(), (With<Shape>, With<DocumentOrder>)>();
        let shapes = shapes.iter(world).len();
        let rest: Vec<Entity> = things.into_iter().map(|(_, entity)| entity).collect();
        Self {
            since,
            shapes: Vec::with_capacity(shapes),
            copied: EntityHashMap::with_capacity(rest.len()),
            rest: rest.into_iter(),
            ..Self::default()
        }
    }

    /// A copy of the whole scene at once.
    pub fn of(world: &mut World) -> Self {
        let mut snapshot = Self::begin(world);
        while !snapshot.step(world, usize::MAX) {}
        snapshot
    }

    /// A copy of these things only, without their materials and media, but with the groups and materials needed to read
    /// them.
    pub fn of_things(world: &World, things: &[Entity]) -> Self {
        let mut wanted: Vec<Entity> = Vec::new();
        let mut known = EntityHashSet::default();
        let mut waiting = things.to_vec();
        while let Some(thing) = waiting.pop() {
            if !known.insert(thing) {
                continue;
            }
            wanted.push(thing);
            waiting.extend(world.get::<FirstNested>(thing).map(|nested| nested.0));
            waiting.extend(world.get::<SecondNested>(thing).map(|nested| nested.0));
            waiting.extend(world.get::<MemberOf>(thing).map(|group| group.0));
            waiting.extend(world.get::<InstanceOf>(thing).map(|group| group.0));
        }
        let mut snapshot = Self::default();
        for thing in wanted {
            snapshot.copy(world, thing);
        }
        snapshot.copy_settings(world);
        snapshot
    }

    /// Copies this number of things. True once the copy is complete: then it shows the present scene, and must not be
    /// continued.
    pub fn step(&mut self, world: &mut World, things: usize) -> bool {
        for entity in self.rest.by_ref().take(things).collect::<Vec<_>>() {
            self.copy(world, entity);
        }
        if self.rest.len() > 0 {
            return false;
        }
        follow_file(world);
        let since = world.increment_change_tick();
        let outdated = self.outdated(world);
        self.since = since;
        self.rounds += 1;
        if outdated.len() > FEW && self.rounds < MOST_ROUNDS {
            self.rest = outdated.into_iter();
            return false;
        }
        for entity in outdated {
            self.copy(world, entity);
        }
        self.copy_settings(world);
        true
    }

    /// The entities that have changed since they were copied.
    fn outdated(&self, world: &mut World) -> Vec<Entity> {
        let mut there = world.query_filtered::<(Entity, &Archetype), With<DocumentOrder>>();
        let mut outdated = Vec::new();
        let mut known = 0;
        for (entity, archetype) in there.iter(world) {
            match self.copied.get(&entity) {
                Some(copied) => {
                    known += 1;
                    if copied.archetype != archetype.id() {
                        outdated.push(entity);
                    }
                }
                None => outdated.push(entity),
            }
        }
        if known < self.copied.len() {
            let is_gone = |entity: &Entity| world.get::<DocumentOrder>(*entity).is_none();
            outdated.extend(self.copied.keys().copied().filter(is_gone));
        }
        let changed = world.last_change_tick_scope(self.since, |world| {
            let mut changed = world.query_filtered::<Entity, (With<DocumentOrder>, Changes)>();
            changed.iter(world).collect::<Vec<_>>()
        });
        outdated.extend(changed);
        outdated.sort_unstable();
        outdated.dedup();
        outdated
    }

    /// Copies an entity, replacing its former copy.
    fn copy(&mut self, world: &World, entity: Entity) {
        if let Some(Copied { kind, index, .. }) = self.copied.remove(&entity) {
            match kind {
                Kind::Sensor => self.sensors[index].entity = None,
                Kind::Medium => self.media[index].entity = None,
                Kind::Material => self.materials[index].entity = None,
                Kind::Group => self.groups[index].entity = None,
                Kind::Shape => self.shapes[index].entity = None,
                Kind::Emitter => self.emitters[index].entity = None,
            }
        }
        let Ok(thing) = world.get_entity(entity) else {
            return;
        };
        let Some(identity) = identity_of(thing) else {
            return;
        };
        let to_world = thing.get::<ToWorld>().map(|pose| pose.0);
        let (kind, index) = if let (Some(shape), Some(to_world)) = (thing.get::<Shape>(), to_world) {
            let described = ShapeDescription {
                identity,
                shape: shape.clone(),
                to_world,
                material: None,
                interior: None,
                exterior: None,
                area_light: thing.get::<AreaLight>().cloned(),
                member_of: None,
                instance_of: None,
                placements: thing.get::<Placements>().cloned(),
            };
            let refers_to = [
                referred::<UsesMaterial>(thing),
                referred::<MemberOf>(thing),
                referred::<InstanceOf>(thing),
                referred::<InteriorMedium>(thing),
                referred::<ExteriorMedium>(thing),
            ];
            (Kind::Shape, add(&mut self.shapes, entity, described, refers_to))
        } else if let Some(material) = thing.get::<Material>() {
            let described = MaterialDescription {
                identity,
                material: material.clone(),
                first: None,
                second: None,
                declared_in: DeclarationPlace::TopLevel,
            };
            let [first, second] = [referred::<FirstNested>(thing), referred::<SecondNested>(thing)];
            let refers_to = [first, second, referred::<DeclaredIn>(thing), None, None];
            (Kind::Material, add(&mut self.materials, entity, described, refers_to))
        } else if let Some(medium) = thing.get::<Medium>() {
            let described = MediumDescription {
                identity,
                medium: medium.clone(),
                declared_in: DeclarationPlace::TopLevel,
            };
            let owner = only(referred::<DeclaredIn>(thing));
            (Kind::Medium, add(&mut self.media, entity, described, owner))
        } else if let (Some(emitter), Some(to_world)) = (thing.get::<Emitter>(), to_world) {
            let described = EmitterDescription {
                identity,
                emitter: emitter.clone(),
                to_world,
                medium: None,
            };
            let medium = only(referred::<InMedium>(thing));
            (Kind::Emitter, add(&mut self.emitters, entity, described, medium))
        } else if let (Some(&sensor), Some(&film), Some(to_world)) =
            (thing.get::<Sensor>(), thing.get::<Film>(), to_world)
        {
            let described = SensorDescription {
                identity,
                sensor,
                film,
                to_world,
                medium: None,
            };
            let medium = only(referred::<InMedium>(thing));
            (Kind::Sensor, add(&mut self.sensors, entity, described, medium))
        } else if thing.contains::<ShapeGroup>() {
            let described = GroupDescription { identity };
            (Kind::Group, add(&mut self.groups, entity, described, only(None)))
        } else {
            return;
        };
        let archetype = thing.archetype().id();
        let copied = Copied { archetype, kind, index };
        self.copied.insert(entity, copied);
    }

    fn copy_settings(&mut self, world: &World) {
        let scene = &mut self.scene;
        if let Some(status) = world.get_resource::<SceneStatus>() {
            scene.path = status.path.clone().unwrap_or_default();
        }
        if let Some(settings) = world.get_resource::<IntegratorSettings>() {
            scene.integrator = *settings;
        }
        scene.integrator_keys = world.get_resource::<IntegratorKeys>().cloned().unwrap_or_default().0;
        scene.unit = world.get_resource().copied().unwrap_or_default();
        scene.light_units = world.get_resource().copied().unwrap_or_default();
        scene.properties = world.get_resource().cloned().unwrap_or_default();
        scene.time = shown_time(world);
        if let Some(remains) = world.get_resource::<AuthoredScene>() {
            scene.remains = remains.clone();
        }
    }

    /// The copied part of the scene outside of entities.
    pub fn settings(&self) -> &SceneDescription {
        &self.scene
    }

    /// The description of the copied scene, each kind in the order of the file, and the described entities.
    pub fn describe(self) -> (SceneDescription, Entities) {
        let Self {
            mut scene,
            sensors,
            media,
            materials,
            groups,
            shapes,
            emitters,
            ..
        } = self;
        let sensors = in_order(sensors, |sensor| &sensor.identity);
        let media = in_order(media, |medium| &medium.identity);
        let materials = in_order(materials, |material| &material.identity);
        let groups = in_order(groups, |group| &group.identity);
        let shapes = in_order(shapes, |shape| &shape.identity);
        let emitters = in_order(emitters, |emitter| &emitter.identity);
        let (medium_of, material_of, group_of) = (places(&media), places(&materials), places(&groups));
        let (shape_of, sensor_of, emitter_of) = (places(&shapes), places(&sensors), places(&emitters));
        let place_in = |places: &EntityHashMap<usize>, entity: Option<Entity>| places.get(&entity?).copied();
        let entities = Entities {
            sensors: sensors.iter().filter_map(|it| it.entity).collect(),
            media: media.iter().filter_map(|it| it.entity).collect(),
            materials: materials.iter().filter_map(|it| it.entity).collect(),
            groups: groups.iter().filter_map(|it| it.entity).collect(),
            shapes: shapes.iter().filter_map(|it| it.entity).collect(),
            emitters: emitters.iter().filter_map(|it| it.entity).collect(),
        };
        let sensor = |it: Described<SensorDescription>| SensorDescription {
            medium: place_in(&medium_of, it.refers_to[0]),
            ..it.thing
        };
        scene.sensors = sensors.into_iter().map(sensor).collect();
        scene.groups = groups.into_iter().map(|it| it.thing).collect();
        let emitter = |it: Described<EmitterDescription>| EmitterDescription {
            medium: place_in(&medium_of, it.refers_to[0]),
            ..it.thing
        };
        scene.emitters = emitters.into_iter().map(emitter).collect();
        let shape = |it: Described<ShapeDescription>| {
            let [material, member_of, instance_of, interior, exterior] = it.refers_to;
            ShapeDescription {
                material: place_in(&material_of, material),
                member_of: place_in(&group_of, member_of),
                instance_of: place_in(&group_of, instance_of),
                interior: place_in(&medium_of, interior),
                exterior: place_in(&medium_of, exterior),
                ..it.thing
            }
        };
        scene.shapes = shapes.into_iter().map(shape).collect();
        let place_of = |owner: Option<Entity>| {
            let in_shape = place_in(&shape_of, owner).map(DeclarationPlace::Shape);
            let in_material = || place_in(&material_of, owner).map(DeclarationPlace::Material);
            let in_sensor = || place_in(&sensor_of, owner).map(DeclarationPlace::Sensor);
            let in_emitter = || place_in(&emitter_of, owner).map(DeclarationPlace::Emitter);
            let found = in_shape.or_else(in_material).or_else(in_sensor).or_else(in_emitter);
            found.unwrap_or(DeclarationPlace::TopLevel)
        };
        let medium = |it: Described<MediumDescription>| MediumDescription {
            declared_in: place_of(it.refers_to[0]),
            ..it.thing
        };
        scene.media = media.into_iter().map(medium).collect();
        let material = |it: Described<MaterialDescription>| {
            let [first, second, owner, ..] = it.refers_to;
            MaterialDescription {
                first: place_in(&material_of, first),
                second: place_in(&material_of, second),
                declared_in: place_of(owner),
                ..it.thing
            }
        };
        scene.materials = materials.into_iter().map(material).collect();
        (scene, entities)
    }
}

/// The identity of a thing; None for other entities.
fn identity_of(thing: EntityRef) -> Option<Identity> {
    let authored = thing.get::<Authored>();
    let name = thing.get::<Name>().map(|name| name.as_str().to_owned().into());
    Some(Identity {
        id: thing.get::<SceneId>().map(|id| id.0.clone()),
        name: name.unwrap_or_default(),
        order: thing.get::<DocumentOrder>()?.0,
        span: authored.map(|authored| authored.object.span).unwrap_or_default(),
        authored: authored.cloned(),
        angles: thing.get::<EulerAngles>().copied(),
        keys: thing.get::<Keys>().cloned(),
        properties: thing.get::<Properties>().cloned(),
    })
}

/// The entity to which a thing refers.
fn referred<R: Relationship>(thing: EntityRef) -> Option<Entity> {
    thing.get::<R>().map(Relationship::get)
}

/// Adds the description of an entity to those of its kind, and returns its index.
fn add<T>(
    list: &mut Vec<Described<T>>,
    entity: Entity,
    thing: T,
    refers_to: [Option<Entity>; MOST_REFERENCES],
) -> usize {
    list.push(Described {
        entity: Some(entity),
        thing,
        refers_to,
    });
    list.len() - 1
}

/// The list for at most one reference.
fn only(entity: Option<Entity>) -> [Option<Entity>; MOST_REFERENCES] {
    [entity, None, None, None, None]
}

/// The things that are not outdated, in the order of the file.
fn in_order<T>(mut list: Vec<Described<T>>, identity: fn(&T) -> &Identity) -> Vec<Described<T>> {
    list.retain(|it| it.entity.is_some());
    list.sort_by_key(|it| (identity(&it.thing).order, it.entity));
    list
}

fn places<T>(list: &[Described<T>]) -> EntityHashMap<usize> {
    let entities = list.iter().filter_map(|it| it.entity);
    entities.zip(0..).collect()
}
