//! Keeps the description of the file as it was last read or written, and the entity of each thing in it.
//!
//! A new description of the file is compared with it. A thing with an id is recognised by its kind and id, a thing
//! without an id among those of the same kind and plugin, by its content and its order ([`recognised`]).

use std::collections::HashMap;
use std::sync::Arc;

use bevy::platform;
use bevy::prelude::*;

use crate::scene::components::description::{
    DeclarationPlace, EmitterDescription, GroupDescription, Identity, MaterialDescription, MediumDescription,
    SceneDescription, SensorDescription, ShapeDescription,
};
use crate::scene::file::entities::Entities;
use crate::scene::read::recognition::recognised;
use crate::scene::{
    Authored, DeclaredIn, DocumentOrder, ExteriorMedium, FirstNested, InMedium, InstanceOf, IntegratorSettings,
    InteriorMedium, Keys, MemberOf, ObjectState, SceneId, SecondNested, ShapeGroup, ToWorld, UsesMaterial,
};

/// The description of the file, and the entity of each thing in it.
#[derive(Resource, Clone, Debug, Default)]
pub(in crate::scene) struct FileBase {
    /// The file as it was last read or written. It shares its memory with the asset that was loaded.
    pub(in crate::scene) scene: Arc<SceneDescription>,
    /// The entities of the scene's lists, in the same order.
    pub(in crate::scene) entities: Entities,
    /// The state that an entity had when the file was read or written, if it differed from the file. The order is not
    /// compared.
    pub(in crate::scene) unlike_file: HashMap<Entity, ObjectState>,
    /// The integrator's settings and their tracks in the file.
    pub(in crate::scene) integrator: Option<(IntegratorSettings, Keys)>,
}

impl FileBase {
    /// The state of an entity when the file was last read or written.
    pub(in crate::scene) fn state_then(&self, thing: Thing) -> ObjectState {
        let entity = thing.entity(&self.entities);
        let unlike = self.unlike_file.get(&entity).cloned();
        unlike.unwrap_or_else(|| thing.state(&self.scene, &self.entities))
    }

    /// Records the state `here` of a thing which the file describes as `in_file`.
    pub(in crate::scene) fn remember(&mut self, entity: Entity, here: ObjectState, in_file: &ObjectState) {
        if here.unordered() != in_file.unordered() {
            self.unlike_file.insert(entity, here);
        }
    }
}

/// An index into one of the lists of a [`SceneDescription`], and into the same list of [`Entities`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::scene) enum Thing {
    Medium(usize),
    Material(usize),
    Group(usize),
    Shape(usize),
    Emitter(usize),
    Sensor(usize),
}

impl Thing {
    /// The identities of all things of a description.
    pub(in crate::scene) fn all(scene: &SceneDescription) -> impl Iterator<Item = Self> + use<> {
        let media = (0..scene.media.len()).map(Self::Medium);
        let materials = (0..scene.materials.len()).map(Self::Material);
        let groups = (0..scene.groups.len()).map(Self::Group);
        let shapes = (0..scene.shapes.len()).map(Self::Shape);
        let emitters = (0..scene.emitters.len()).map(Self::Emitter);
        let sensors = (0..scene.sensors.len()).map(Self::Sensor);
        let surfaces = media.chain(materials).chain(groups).chain(shapes);
        surfaces.chain(emitters).chain(sensors)
    }

    pub(in crate::scene) fn entity(self, entities: &Entities) -> Entity {
        match self {
            Self::Medium(index) => entities.media[index],
            Self::Material(index) => entities.materials[index],
            Self::Group(index) => entities.groups[index],
            Self::Shape(index) => entities.shapes[index],
            Self::Emitter(index) => entities.emitters[index],
            Self::Sensor(index) => entities.sensors[index],
        }
    }

    pub(in crate::scene) fn identity(self, scene: &SceneDescription) -> &Identity {
        match self {
            Self::Medium(index) => &scene.media[index].identity,
            Self::Material(index) => &scene.materials[index].identity,
            Self::Group(index) => &scene.groups[index].identity,
            Self::Shape(index) => &scene.shapes[index].identity,
            Self::Emitter(index) => &scene.emitters[index].identity,
            Self::Sensor(index) => &scene.sensors[index].identity,
        }
    }

    pub(in crate::scene) fn identity_mut(self, scene: &mut SceneDescription) -> &mut Identity {
        match self {
            Self::Medium(index) => &mut scene.media[index].identity,
            Self::Material(index) => &mut scene.materials[index].identity,
            Self::Group(index) => &mut scene.groups[index].identity,
            Self::Shape(index) => &mut scene.shapes[index].identity,
            Self::Emitter(index) => &mut scene.emitters[index].identity,
            Self::Sensor(index) => &mut scene.sensors[index].identity,
        }
    }

    /// Whether this thing of a description has the same components as `other` of another one, except for the order.
    /// `entities` belong to each. It makes no copies, unlike a comparison of [`Self::state`].
    pub(in crate::scene) fn is_same(
        self,
        (scene, entities): (&SceneDescription, &Entities),
        other: Self,
        (other_scene, other_entities): (&SceneDescription, &Entities),
    ) -> bool {
        let (one, two) = (self.identity(scene), other.identity(other_scene));
        let are_same = |list: fn(&Entities) -> &Vec<Entity>, one: Option<usize>, two: Option<usize>| {
            let entity = |all, place: Option<usize>| place.map(|place| list(all)[place]);
            entity(entities, one) == entity(other_entities, two)
        };
        let are_same_media = |one: Option<usize>, two: Option<usize>| are_same(|all| &all.media, one, two);
        let is_alike = match (self, other) {
            (Self::Medium(one), Self::Medium(two)) => {
                let (one, two) = (&scene.media[one], &other_scene.media[two]);
                let are_at_top = [one, two].map(|it| it.declared_in) == [DeclarationPlace::TopLevel; 2];
                are_at_top && one.is_alike(two)
            }
            (Self::Material(one), Self::Material(two)) => {
                let (one, two) = (&scene.materials[one], &other_scene.materials[two]);
                let are_at_top = [one, two].map(|it| it.declared_in) == [DeclarationPlace::TopLevel; 2];
                are_at_top
                    && one.is_alike(two)
                    && are_same(|all| &all.materials, one.first, two.first)
                    && are_same(|all| &all.materials, one.second, two.second)
            }
            (Self::Group(_), Self::Group(_)) => true,
            (Self::Shape(one), Self::Shape(two)) => {
                let (one, two) = (&scene.shapes[one], &other_scene.shapes[two]);
                one.is_alike(two)
                    && are_same(|all| &all.materials, one.material, two.material)
                    && are_same(|all| &all.groups, one.member_of, two.member_of)
                    && are_same(|all| &all.groups, one.instance_of, two.instance_of)
                    && are_same_media(one.interior, two.interior)
                    && are_same_media(one.exterior, two.exterior)
            }
            (Self::Emitter(one), Self::Emitter(two)) => {
                let (one, two) = (&scene.emitters[one], &other_scene.emitters[two]);
                one.is_alike(two) && are_same_media(one.medium, two.medium)
            }
            (Self::Sensor(one), Self::Sensor(two)) => {
                let (one, two) = (&scene.sensors[one], &other_scene.sensors[two]);
                one.is_alike(two) && are_same_media(one.medium, two.medium)
            }
            _ => false,
        };
        is_alike
            && (&one.id, &one.name, &one.angles, &one.keys) == (&two.id, &two.name, &two.angles, &two.keys)
            && one.properties == two.properties
    }

    /// The components of the thing's entity according to the description.
    pub(in crate::scene) fn state(self, scene: &SceneDescription, entities: &Entities) -> ObjectState {
        let identity = self.identity(scene);
        let common = ObjectState {
            order: Some(DocumentOrder(identity.order)),
            id: identity.id.clone().map(SceneId),
            name: Some(Name::new(identity.name.clone())),
            angles: identity.angles,
            keys: identity.keys.clone(),
            properties: identity.properties.clone(),
            ..ObjectState::default()
        };
        let in_medium = |medium: Option<usize>| medium.map(|index| InMedium(entities.media[index]));
        match self {
            Self::Medium(index) => {
                let medium = &scene.media[index];
                ObjectState {
                    medium: Some(medium.medium.clone()),
                    declared_in: entities.at(medium.declared_in).map(DeclaredIn),
                    ..common
                }
            }
            Self::Material(index) => {
                let material = &scene.materials[index];
                ObjectState {
                    material: Some(material.material.clone()),
                    first: material.first.map(|index| FirstNested(entities.materials[index])),
                    second: material.second.map(|index| SecondNested(entities.materials[index])),
                    declared_in: entities.at(material.declared_in).map(DeclaredIn),
                    ..common
                }
            }
            Self::Group(_) => ObjectState {
                group: Some(ShapeGroup),
                ..common
            },
            Self::Shape(index) => {
                let shape = &scene.shapes[index];
                ObjectState {
                    shape: Some(shape.shape.clone()),
                    to_world: Some(ToWorld(shape.to_world)),
                    area_light: shape.area_light.clone(),
                    uses: shape.material.map(|index| UsesMaterial(entities.materials[index])),
                    member_of: shape.member_of.map(|index| MemberOf(entities.groups[index])),
                    instance_of: shape.instance_of.map(|index| InstanceOf(entities.groups[index])),
                    interior: shape.interior.map(|index| InteriorMedium(entities.media[index])),
                    exterior: shape.exterior.map(|index| ExteriorMedium(entities.media[index])),
                    placements: shape.placements.clone(),
                    ..common
                }
            }
            Self::Emitter(index) => {
                let emitter = &scene.emitters[index];
                ObjectState {
                    emitter: Some(emitter.emitter.clone()),
                    to_world: Some(ToWorld(emitter.to_world)),
                    in_medium: in_medium(emitter.medium),
                    ..common
                }
            }
            Self::Sensor(index) => {
                let sensor = &scene.sensors[index];
                ObjectState {
                    sensor: Some(sensor.sensor),
                    film: Some(sensor.film),
                    to_world: Some(ToWorld(sensor.to_world)),
                    in_medium: in_medium(sensor.medium),
                    ..common
                }
            }
        }
    }
}

/// For each thing of a new description its index in the same list of the old one; None for new things.
#[derive(Debug)]
pub(in crate::scene) struct Recognised {
    pub media: Vec<Option<usize>>,
    pub materials: Vec<Option<usize>>,
    pub groups: Vec<Option<usize>>,
    pub shapes: Vec<Option<usize>>,
    pub emitters: Vec<Option<usize>>,
    pub sensors: Vec<Option<usize>>,
}

impl Recognised {
    pub(in crate::scene) fn new(before: &SceneDescription, now: &SceneDescription) -> Self {
        Self {
            media: pairs(&before.media, &now.media),
            materials: pairs(&before.materials, &now.materials),
            groups: pairs(&before.groups, &now.groups),
            shapes: pairs(&before.shapes, &now.shapes),
            emitters: pairs(&before.emitters, &now.emitters),
            sensors: pairs(&before.sensors, &now.sensors),
        }
    }

    /// Compares two readings of one file at different times, like [`Self::new`] two files: objects at the same position
    /// are the same.
    pub(in crate::scene) fn in_order(before: &SceneDescription, now: &SceneDescription) -> Self {
        let counts = |scene: &SceneDescription| {
            let (shapes, sensors) = (scene.shapes.len(), scene.sensors.len());
            [
                scene.media.len(),
                scene.materials.len(),
                scene.groups.len(),
                shapes,
                scene.emitters.len(),
                sensors,
            ]
        };
        let all = |count: usize| (0..count).map(Some).collect();
        match counts(now) {
            same if same != counts(before) => Self::new(before, now),
            [media, materials, groups, shapes, emitters, sensors] => Self {
                media: all(media),
                materials: all(materials),
                groups: all(groups),
                shapes: all(shapes),
                emitters: all(emitters),
                sensors: all(sensors),
            },
        }
    }

    /// The thing of the old description for a thing of the new one.
    pub(in crate::scene) fn before(&self, thing: Thing) -> Option<Thing> {
        match thing {
            Thing::Medium(index) => self.media[index].map(Thing::Medium),
            Thing::Material(index) => self.materials[index].map(Thing::Material),
            Thing::Group(index) => self.groups[index].map(Thing::Group),
            Thing::Shape(index) => self.shapes[index].map(Thing::Shape),
            Thing::Emitter(index) => self.emitters[index].map(Thing::Emitter),
            Thing::Sensor(index) => self.sensors[index].map(Thing::Sensor),
        }
    }

    /// An entity for each thing of the new description: its old one, if `keep` accepts it, or else one from `make`.
    pub(in crate::scene) fn entities(
        &self,
        before: &Entities,
        mut keep_or_make: impl FnMut(Option<Entity>) -> Entity,
    ) -> Entities {
        let mut all = |pairs: &[Option<usize>], before: &[Entity]| {
            let known = pairs.iter().map(|pair| pair.map(|index| before[index]));
            known.map(&mut keep_or_make).collect()
        };
        Entities {
            sensors: all(&self.sensors, &before.sensors),
            media: all(&self.media, &before.media),
            materials: all(&self.materials, &before.materials),
            groups: all(&self.groups, &before.groups),
            shapes: all(&self.shapes, &before.shapes),
            emitters: all(&self.emitters, &before.emitters),
        }
    }
}

/// An element of one of the lists.
trait Described {
    fn identity(&self) -> &Identity;
    /// Whether two things have the same content, regardless of their names, their order in the file and their
    /// references.
    fn is_alike(&self, other: &Self) -> bool;
}

macro_rules! described {
    ($($Description:ty: |$one:ident, $two:ident| $is_alike:expr;)*) => {$(
        impl Described for $Description {
            fn identity(&self) -> &Identity {
                &self.identity
            }

            fn is_alike(&self, $two: &Self) -> bool {
                let $one = self;
                $is_alike
            }
        }
    )*};
}

described! {
    MediumDescription: |one, two| one.medium == two.medium;
    MaterialDescription: |one, two| one.material == two.material;
    GroupDescription: |_one, _two| true;
    ShapeDescription: |one, two| (&one.shape, &one.to_world, &one.area_light, &one.placements)
        == (&two.shape, &two.to_world, &two.area_light, &two.placements);
    EmitterDescription: |one, two| (&one.emitter, &one.to_world) == (&two.emitter, &two.to_world);
    SensorDescription: |one, two| (&one.sensor, &one.film, &one.to_world) == (&two.sensor, &two.film, &two.to_world);
}

/// Compares by [`Described::is_alike`].
struct Content<'s, T>(&'s T);

impl<T: Described> PartialEq for Content<'_, T> {
    fn eq(&self, other: &Self) -> bool {
        self.0.is_alike(other.0)
    }
}

fn pairs<T: Described>(before: &[T], now: &[T]) -> Vec<Option<usize>> {
    let mut pairs = vec![None; now.len()];
    if before.is_empty() {
        return pairs;
    }
    let by_id: platform::collections::HashMap<&str, usize> = (0..)
        .zip(before)
        .filter_map(|(index, thing)| Some((thing.identity().id.as_deref()?, index)))
        .collect();
    for (pair, thing) in pairs.iter_mut().zip(now) {
        *pair = thing.identity().id.as_deref().and_then(|id| by_id.get(id).copied());
    }
    let mut old = nameless(before);
    for (plugin, new) in nameless(now) {
        let old = old.remove(plugin).unwrap_or_default();
        let found = recognised(&contents(before, &old), &contents(now, &new));
        for (place, pair) in new.into_iter().zip(found) {
            pairs[place] = pair.map(|pair| old[pair]);
        }
    }
    pairs
}

fn contents<'s, T>(list: &'s [T], places: &[usize]) -> Vec<Content<'s, T>> {
    places.iter().map(|&place| Content(&list[place])).collect()
}

/// The things without an id, by plugin, in the order of the file.
fn nameless<T: Described>(list: &[T]) -> HashMap<&str, Vec<usize>> {
    let mut by_plugin: HashMap<&str, Vec<usize>> = HashMap::new();
    for (index, thing) in list.iter().enumerate() {
        let identity = thing.identity();
        if identity.id.is_none() {
            let authored = identity.authored.as_ref();
            let plugin = authored.map_or("", |authored| authored.object.plugin.as_str());
            by_plugin.entry(plugin).or_default().push(index);
        }
    }
    by_plugin
}

/// Sets the source of an entity, if it differs. Does nothing if the entity does not exist.
pub(in crate::scene) fn set_authored(world: &mut World, entity: Entity, authored: Option<&Authored>) {
    if world.get::<Authored>(entity) == authored {
        return;
    }
    let Ok(mut entity) = world.get_entity_mut(entity) else {
        return;
    };
    match authored {
        Some(authored) => {
            entity.insert(authored.clone());
        }
        None => {
            entity.remove::<Authored>();
        }
    }
}
