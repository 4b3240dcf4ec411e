//! The description of the entities as they are now.

use bevy::ecs::entity::EntityHashMap;
use bevy::prelude::*;

use crate::scene::description::{
    DeclarationPlace, EmitterDescription, GroupDescription, Identity, MaterialDescription, SceneDescription,
    SensorDescription, ShapeDescription,
};
use crate::scene::{
    AreaLight, Authored, AuthoredScene, DeclaredIn, DocumentOrder, Emitter, Film, FirstNested, InstanceOf,
    IntegratorSettings, Material, MemberOf, Placements, SceneId, SceneStatus, SecondNested, Sensor, Shape, ShapeGroup,
    ToWorld, UsesMaterial,
};

/// The components that every kind of entity has.
type Common = (
    Entity,
    &'static DocumentOrder,
    Option<&'static SceneId>,
    Option<&'static Name>,
    Option<&'static Authored>,
);

/// The entities of a description, in its order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Entities {
    pub sensors: Vec<Entity>,
    pub materials: Vec<Entity>,
    pub groups: Vec<Entity>,
    pub shapes: Vec<Entity>,
    pub emitters: Vec<Entity>,
}

impl Entities {
    /// The entities of all lists, one list after the other.
    pub fn all(&self) -> impl Iterator<Item = Entity> {
        let lists = [
            &self.materials,
            &self.groups,
            &self.shapes,
            &self.emitters,
            &self.sensors,
        ];
        lists.into_iter().flatten().copied()
    }
}

/// Describes all shapes, materials, emitters and sensors, each kind in the order of the file.
pub fn describe(world: &mut World) -> SceneDescription {
    describe_entities(world).0
}

/// Describes the scene as [`describe`] does, and returns the entities that the descriptions are of.
pub(crate) fn describe_entities(world: &mut World) -> (SceneDescription, Entities) {
    let mut scene = SceneDescription::default();
    if let Some(status) = world.get_resource::<SceneStatus>() {
        scene.path = status.path.clone().unwrap_or_default();
    }
    if let Some(settings) = world.get_resource::<IntegratorSettings>() {
        scene.integrator = *settings;
    }
    scene.unit = world.get_resource().copied().unwrap_or_default();
    if let Some(remains) = world.get_resource::<AuthoredScene>() {
        scene.remains = remains.clone();
    }

    let sensors = in_order(
        world.query::<(Common, &Sensor, &Film, &ToWorld)>().iter(world),
        |item| item.0,
    );
    let sensor_entities = sensors.iter().map(|item| item.0.0).collect();
    scene.sensors = sensors
        .into_iter()
        .map(|(common, sensor, film, to_world)| SensorDescription {
            identity: identity(common),
            sensor: *sensor,
            film: *film,
            to_world: to_world.0,
        })
        .collect();

    let emitters = in_order(world.query::<(Common, &Emitter, &ToWorld)>().iter(world), |item| item.0);
    let emitter_entities = emitters.iter().map(|item| item.0.0).collect();
    scene.emitters = emitters
        .into_iter()
        .map(|(common, emitter, to_world)| EmitterDescription {
            identity: identity(common),
            emitter: emitter.clone(),
            to_world: to_world.0,
        })
        .collect();

    let mut shapes_query = world.query::<(
        Common,
        &Shape,
        &ToWorld,
        Option<&UsesMaterial>,
        Option<&AreaLight>,
        (Option<&MemberOf>, Option<&InstanceOf>, Option<&Placements>),
    )>();
    let mut materials_query = world.query::<(
        Common,
        &Material,
        Option<&FirstNested>,
        Option<&SecondNested>,
        Option<&DeclaredIn>,
    )>();
    let mut groups_query = world.query_filtered::<Common, With<ShapeGroup>>();
    let shapes = in_order(shapes_query.iter(world), |item| item.0);
    let groups = in_order(groups_query.iter(world), |item| *item);
    let group_of: EntityHashMap<usize> = groups.iter().enumerate().map(|(i, item)| (item.0, i)).collect();
    let materials = in_order(materials_query.iter(world), |item| item.0);
    let entities = Entities {
        sensors: sensor_entities,
        groups: groups.iter().map(|item| item.0).collect(),
        materials: materials.iter().map(|item| item.0.0).collect(),
        shapes: shapes.iter().map(|item| item.0.0).collect(),
        emitters: emitter_entities,
    };
    let material_of: EntityHashMap<usize> = materials.iter().enumerate().map(|(i, item)| (item.0.0, i)).collect();
    let shape_of: EntityHashMap<usize> = shapes.iter().enumerate().map(|(i, item)| (item.0.0, i)).collect();
    let place_of = |declared: Option<&DeclaredIn>| {
        let owner = declared.map(|declared| declared.0);
        let in_shape = owner.and_then(|owner| shape_of.get(&owner).copied());
        let in_material = owner.and_then(|owner| material_of.get(&owner).copied());
        match (in_shape, in_material) {
            (Some(shape), _) => DeclarationPlace::Shape(shape),
            (None, Some(material)) => DeclarationPlace::Material(material),
            (None, None) => DeclarationPlace::TopLevel,
        }
    };
    scene.shapes = shapes
        .into_iter()
        .map(
            |(common, shape, to_world, material, area_light, (member, instance, placements))| ShapeDescription {
                identity: identity(common),
                shape: shape.clone(),
                to_world: to_world.0,
                material: material.and_then(|uses| material_of.get(&uses.0).copied()),
                area_light: area_light.cloned(),
                member_of: member.and_then(|member| group_of.get(&member.0).copied()),
                instance_of: instance.and_then(|instance| group_of.get(&instance.0).copied()),
                placements: placements.cloned(),
            },
        )
        .collect();
    scene.groups = groups
        .into_iter()
        .map(|common| GroupDescription {
            identity: identity(common),
        })
        .collect();
    scene.materials = materials
        .into_iter()
        .map(|(common, material, first, second, declared)| MaterialDescription {
            identity: identity(common),
            material: material.clone(),
            first: first.and_then(|nested| material_of.get(&nested.0).copied()),
            second: second.and_then(|nested| material_of.get(&nested.0).copied()),
            declared_in: place_of(declared),
        })
        .collect();
    (scene, entities)
}

type CommonItem<'w> = (
    Entity,
    &'w DocumentOrder,
    Option<&'w SceneId>,
    Option<&'w Name>,
    Option<&'w Authored>,
);

fn in_order<'w, T>(items: impl Iterator<Item = T>, common: impl Fn(&T) -> CommonItem<'w>) -> Vec<T> {
    let mut items: Vec<T> = items.collect();
    items.sort_by_key(|item| {
        let (entity, order, ..) = common(item);
        (*order, entity)
    });
    items
}

fn identity((_, order, id, name, authored): CommonItem) -> Identity {
    Identity {
        id: id.map(|id| id.0.clone()),
        name: name.map(|name| name.as_str().to_owned().into()).unwrap_or_default(),
        order: order.0,
        span: authored.map(|authored| authored.object.span).unwrap_or_default(),
        authored: authored.cloned(),
    }
}
