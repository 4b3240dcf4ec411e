//! Adds the things of a description to the scene, as if they had been made in the editor; and makes descriptions of a
//! part.

use std::collections::HashMap;

use bevy::prelude::*;

use crate::scene::components::description::{DeclarationPlace, Identity, SceneDescription};
use crate::scene::components::folders::FreeFolders;
use crate::scene::components::names::TakenNames;
pub use crate::scene::components::names::names;
use crate::scene::write::gather::describe_entities;
use crate::scene::write::identities;
use crate::scene::{
    DeclaredIn, DocumentOrder, ExteriorMedium, FirstNested, InMedium, InstanceOf, InteriorMedium, Material, Medium,
    MemberOf, SceneId, SecondNested, ShapeGroup, ToWorld, UsesMaterial,
};

/// The entities that [`insert`] has made.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Inserted {
    /// All entities.
    pub all: Vec<Entity>,
    /// The entities that stand for themselves: shapes of the world, lights and cameras; materials and media, if there
    /// is nothing else.
    pub objects: Vec<Entity>,
}

/// The place after everything that there is.
pub(crate) fn next_order(world: &mut World) -> u32 {
    let last = world.query::<&DocumentOrder>().iter(world).map(|order| order.0).max();
    last.map_or(0, |last| last.saturating_add(1))
}

/// Adds everything but settings; sensors are added with their films. Ids that are taken get numbers, and so do folders
/// of groups with everything in them. A material or medium is not added again if the scene has an equal one of the same
/// id: that one is used then.
pub fn insert(world: &mut World, scene: &SceneDescription) -> Inserted {
    let shared = shared_materials(world, scene);
    let shared_media = shared_media(world, scene);
    let mut order = next_order(world);
    let mut inserted = Inserted::default();
    let mut folders = FreeFolders::default();
    let frames = scene.shapes.iter().filter(|shape| shape.shape.is_frame());
    let frames = frames.filter_map(|frame| frame.identity.id.as_deref()?.strip_suffix('/'));
    folders.find(|| names(world), frames.map(str::to_owned));
    let ids = identities(scene).filter_map(|identity| identity.id.as_deref());
    let mut taken = TakenNames::like(world, ids);
    let in_folder = |name: &str| folders.in_copy(name).unwrap_or_else(|| name.to_owned());
    let mut spawn = |world: &mut World, identity: &Identity| {
        let entity = world.spawn(DocumentOrder(order)).id();
        order = order.saturating_add(1);
        let name = match &identity.id {
            Some(id) => {
                // What is in a folder that was found free needs no number.
                let id = taken.take(&in_folder(id));
                world.entity_mut(entity).insert(SceneId(id.clone()));
                id
            }
            None => {
                let name = in_folder(&identity.name);
                taken.note(&name);
                name
            }
        };
        world.entity_mut(entity).insert(Name::new(name));
        if let Some(angles) = identity.angles {
            world.entity_mut(entity).insert(angles);
        }
        if let Some(keys) = &identity.keys {
            world.entity_mut(entity).insert(keys.clone());
        }
        inserted.all.push(entity);
        entity
    };
    let mut media = Vec::with_capacity(scene.media.len());
    for (medium, shared) in scene.media.iter().zip(&shared_media) {
        let entity = shared.unwrap_or_else(|| spawn(world, &medium.identity));
        if shared.is_none() {
            world.entity_mut(entity).insert(medium.medium.clone());
        }
        media.push(entity);
    }
    let mut materials = Vec::with_capacity(scene.materials.len());
    for (material, shared) in scene.materials.iter().zip(&shared) {
        let entity = shared.unwrap_or_else(|| spawn(world, &material.identity));
        if shared.is_none() {
            world.entity_mut(entity).insert(material.material.clone());
        }
        materials.push(entity);
    }
    let mut groups = Vec::with_capacity(scene.groups.len());
    for group in &scene.groups {
        let entity = spawn(world, &group.identity);
        world.entity_mut(entity).insert(ShapeGroup);
        groups.push(entity);
    }
    let mut shapes = Vec::with_capacity(scene.shapes.len());
    for shape in &scene.shapes {
        let entity = spawn(world, &shape.identity);
        let mut shown = world.entity_mut(entity);
        shown.insert((shape.shape.clone(), ToWorld(shape.to_world)));
        if let Some(light) = &shape.area_light {
            shown.insert(light.clone());
        }
        if let Some(material) = shape.material {
            shown.insert(UsesMaterial(materials[material]));
        }
        if let Some(group) = shape.member_of {
            shown.insert(MemberOf(groups[group]));
        }
        if let Some(group) = shape.instance_of {
            shown.insert(InstanceOf(groups[group]));
        }
        if let Some(medium) = shape.interior {
            shown.insert(InteriorMedium(media[medium]));
        }
        if let Some(medium) = shape.exterior {
            shown.insert(ExteriorMedium(media[medium]));
        }
        shapes.push(entity);
        // Each of very many instances becomes an entity of its own here.
        let mut places = shape
            .placements
            .iter()
            .flat_map(|many| many.places.iter().map(|&place| place.into()));
        if let Some(first) = places.next() {
            world.entity_mut(entity).insert(ToWorld(first));
        }
        for place in places {
            let another = spawn(world, &shape.identity);
            let parts = (shape.shape.clone(), ToWorld(place));
            world.entity_mut(another).insert(parts);
            if let Some(group) = shape.instance_of {
                world.entity_mut(another).insert(InstanceOf(groups[group]));
            }
        }
    }
    let added = scene.materials.iter().zip(&materials).zip(&shared);
    for ((material, &entity), _) in added.filter(|(_, shared)| shared.is_none()) {
        let mut nesting = world.entity_mut(entity);
        if let Some(first) = material.first {
            nesting.insert(FirstNested(materials[first]));
        }
        if let Some(second) = material.second {
            nesting.insert(SecondNested(materials[second]));
        }
        let owner = match material.declared_in {
            DeclarationPlace::Shape(index) => shapes.get(index),
            DeclarationPlace::Material(index) => materials.get(index),
            DeclarationPlace::TopLevel | DeclarationPlace::Sensor(_) | DeclarationPlace::Emitter(_) => None,
        };
        if let Some(owner) = owner {
            nesting.insert(DeclaredIn(*owner));
        }
    }
    let mut objects: Vec<Entity> = scene
        .shapes
        .iter()
        .zip(&shapes)
        .filter(|(shape, _)| shape.member_of.is_none())
        .map(|(_, entity)| *entity)
        .collect();
    let mut emitters = Vec::with_capacity(scene.emitters.len());
    for emitter in &scene.emitters {
        let entity = spawn(world, &emitter.identity);
        let light = (emitter.emitter.clone(), ToWorld(emitter.to_world));
        world.entity_mut(entity).insert(light);
        if let Some(medium) = emitter.medium {
            world.entity_mut(entity).insert(InMedium(media[medium]));
        }
        emitters.push(entity);
    }
    objects.extend(&emitters);
    let mut sensors = Vec::with_capacity(scene.sensors.len());
    for sensor in &scene.sensors {
        let entity = spawn(world, &sensor.identity);
        let camera = (sensor.sensor, sensor.film, ToWorld(sensor.to_world));
        world.entity_mut(entity).insert(camera);
        if let Some(medium) = sensor.medium {
            world.entity_mut(entity).insert(InMedium(media[medium]));
        }
        sensors.push(entity);
    }
    objects.extend(&sensors);
    let added = scene.media.iter().zip(&media).zip(&shared_media);
    for ((medium, &entity), _) in added.filter(|(_, shared)| shared.is_none()) {
        let owner = match medium.declared_in {
            DeclarationPlace::Shape(index) => shapes.get(index),
            DeclarationPlace::Sensor(index) => sensors.get(index),
            DeclarationPlace::Emitter(index) => emitters.get(index),
            DeclarationPlace::TopLevel | DeclarationPlace::Material(_) => None,
        };
        if let Some(owner) = owner {
            world.entity_mut(entity).insert(DeclaredIn(*owner));
        }
    }
    if objects.is_empty() {
        let is_outermost = |place| place == DeclarationPlace::TopLevel;
        let outermost = scene.materials.iter().zip(&materials);
        objects.extend(
            outermost
                .filter(|(material, _)| is_outermost(material.declared_in))
                .map(|(_, entity)| *entity),
        );
        let outermost = scene.media.iter().zip(&media);
        objects.extend(
            outermost
                .filter(|(medium, _)| is_outermost(medium.declared_in))
                .map(|(_, entity)| *entity),
        );
    }
    inserted.objects = objects;
    inserted
}

/// Finds for each material of the scene the one in the world that it would duplicate: it is used by a shape, and has
/// the same id and content.
fn shared_materials(world: &mut World, scene: &SceneDescription) -> Vec<Option<Entity>> {
    let mut known = world.query_filtered::<(&SceneId, Entity), With<Material>>();
    let known: HashMap<&str, Entity> = known.iter(world).map(|(id, entity)| (id.0.as_str(), entity)).collect();
    let mut shared = vec![None; scene.materials.len()];
    for used in scene.shapes.iter().filter_map(|shape| shape.material) {
        let id = scene.materials[used].identity.id.as_deref();
        if let Some(&entity) = id.and_then(|id| known.get(id)) {
            let mut pairs = Vec::new();
            if is_same(world, scene, used, entity, &mut pairs) {
                pairs
                    .into_iter()
                    .for_each(|(place, entity)| shared[place] = Some(entity));
            }
        }
    }
    shared
}

/// Finds for each medium of the scene the one in the world that it would duplicate: something is in it, and it has the
/// same id and content.
fn shared_media(world: &mut World, scene: &SceneDescription) -> Vec<Option<Entity>> {
    let mut known = world.query::<(&SceneId, &Medium, Entity)>();
    let known: HashMap<&str, (&Medium, Entity)> = (known
        .iter(world)
        .map(|(id, medium, entity)| (id.0.as_str(), (medium, entity))))
    .collect();
    let mut shared = vec![None; scene.media.len()];
    for used in scene.media_in_use() {
        let (identity, medium) = (&scene.media[used].identity, &scene.media[used].medium);
        let same = identity.id.as_deref().and_then(|id| known.get(id));
        shared[used] = same.filter(|(known, _)| *known == medium).map(|(_, entity)| *entity);
    }
    shared
}

/// Whether the material is equal to that of the entity, with all that is inside. `pairs` has the materials that are
/// known to be equal.
fn is_same(
    world: &World,
    scene: &SceneDescription,
    place: usize,
    entity: Entity,
    pairs: &mut Vec<(usize, Entity)>,
) -> bool {
    let material = &scene.materials[place];
    pairs.push((place, entity));
    let insides = [
        (material.first, world.get::<FirstNested>(entity).map(|nested| nested.0)),
        (
            material.second,
            world.get::<SecondNested>(entity).map(|nested| nested.0),
        ),
    ];
    world.get::<Material>(entity) == Some(&material.material)
        && insides.into_iter().all(|(wanted, known)| match (wanted, known) {
            (Some(place), Some(entity)) => is_same(world, scene, place, entity, pairs),
            (wanted, known) => wanted.is_none() && known.is_none(),
        })
}

/// The description of these things with all that they refer to, and nothing else: of materials, media, groups and their
/// members only what is needed. What the file said of them is left out.
pub(crate) fn describe_part(world: &mut World, wanted: &[Entity]) -> SceneDescription {
    let (whole, entities) = describe_entities(world);
    let is_wanted = |entity: &Entity| wanted.contains(entity);
    let mut is_group_used = vec![false; whole.groups.len()];
    for (shape, entity) in whole.shapes.iter().zip(&entities.shapes) {
        if let Some(group) = shape.instance_of.filter(|_| is_wanted(entity)) {
            is_group_used[group] = true;
        }
    }
    let is_shape_used: Vec<bool> = whole
        .shapes
        .iter()
        .zip(&entities.shapes)
        .map(|(shape, entity)| is_wanted(entity) || shape.member_of.is_some_and(|group| is_group_used[group]))
        .collect();
    let mut is_material_used: Vec<bool> = entities.materials.iter().map(is_wanted).collect();
    for (shape, _) in whole.shapes.iter().zip(&is_shape_used).filter(|(_, used)| **used) {
        if let Some(material) = shape.material {
            is_material_used[material] = true;
        }
    }
    // Nested materials come before or after those they are in, so this repeats until nothing is added.
    loop {
        let before = is_material_used.clone();
        for (material, _) in whole.materials.iter().zip(&before).filter(|(_, used)| **used) {
            for nested in material.first.into_iter().chain(material.second) {
                is_material_used[nested] = true;
            }
        }
        if is_material_used == before {
            break;
        }
    }
    let is_emitter_used: Vec<bool> = entities.emitters.iter().map(is_wanted).collect();
    let is_sensor_used: Vec<bool> = entities.sensors.iter().map(is_wanted).collect();
    let mut is_medium_used: Vec<bool> = entities.media.iter().map(is_wanted).collect();
    let shapes = whole.shapes.iter().zip(&is_shape_used).filter(|(_, used)| **used);
    let of_shapes = shapes.flat_map(|(shape, _)| shape.interior.into_iter().chain(shape.exterior));
    let emitters = whole.emitters.iter().zip(&is_emitter_used).filter(|(_, used)| **used);
    let sensors = whole.sensors.iter().zip(&is_sensor_used).filter(|(_, used)| **used);
    let of_emitters = emitters.filter_map(|(emitter, _)| emitter.medium);
    let of_sensors = sensors.filter_map(|(sensor, _)| sensor.medium);
    for medium in of_shapes.chain(of_emitters).chain(of_sensors) {
        is_medium_used[medium] = true;
    }
    let (medium_at, material_at) = (places(&is_medium_used), places(&is_material_used));
    let (group_at, shape_at) = (places(&is_group_used), places(&is_shape_used));
    let (emitter_at, sensor_at) = (places(&is_emitter_used), places(&is_sensor_used));
    let place_of = |place: DeclarationPlace| {
        let place = match place {
            DeclarationPlace::TopLevel => None,
            DeclarationPlace::Shape(index) => shape_at[index].map(DeclarationPlace::Shape),
            DeclarationPlace::Material(index) => material_at[index].map(DeclarationPlace::Material),
            DeclarationPlace::Sensor(index) => sensor_at[index].map(DeclarationPlace::Sensor),
            DeclarationPlace::Emitter(index) => emitter_at[index].map(DeclarationPlace::Emitter),
        };
        place.unwrap_or(DeclarationPlace::TopLevel)
    };
    let unwritten = |identity: Identity| Identity {
        authored: None,
        ..identity
    };
    let media = kept(whole.media, &is_medium_used)
        .map(|mut medium| {
            medium.identity = unwritten(medium.identity);
            medium.declared_in = place_of(medium.declared_in);
            medium
        })
        .collect();
    let materials = kept(whole.materials, &is_material_used)
        .map(|mut material| {
            material.identity = unwritten(material.identity);
            material.first = material.first.and_then(|index| material_at[index]);
            material.second = material.second.and_then(|index| material_at[index]);
            material.declared_in = place_of(material.declared_in);
            material
        })
        .collect();
    let groups = kept(whole.groups, &is_group_used)
        .map(|mut group| {
            group.identity = unwritten(group.identity);
            group
        })
        .collect();
    let shapes = kept(whole.shapes, &is_shape_used)
        .map(|mut shape| {
            shape.identity = unwritten(shape.identity);
            shape.material = shape.material.and_then(|index| material_at[index]);
            shape.member_of = shape.member_of.and_then(|index| group_at[index]);
            shape.instance_of = shape.instance_of.and_then(|index| group_at[index]);
            shape.interior = shape.interior.and_then(|index| medium_at[index]);
            shape.exterior = shape.exterior.and_then(|index| medium_at[index]);
            // Very many instances would become very many elements here.
            shape.placements = None;
            shape
        })
        .collect();
    let emitters = kept(whole.emitters, &is_emitter_used)
        .map(|mut emitter| {
            emitter.identity = unwritten(emitter.identity);
            emitter.medium = emitter.medium.and_then(|index| medium_at[index]);
            emitter
        })
        .collect();
    let sensors = kept(whole.sensors, &is_sensor_used)
        .map(|mut sensor| {
            sensor.identity = unwritten(sensor.identity);
            sensor.medium = sensor.medium.and_then(|index| medium_at[index]);
            sensor
        })
        .collect();
    SceneDescription {
        media,
        materials,
        groups,
        shapes,
        emitters,
        sensors,
        ..SceneDescription::default()
    }
}

fn kept<'a, T: 'a>(all: Vec<T>, is_used: &'a [bool]) -> impl Iterator<Item = T> + 'a {
    let used = all.into_iter().zip(is_used).filter(|(_, used)| **used);
    used.map(|(item, _)| item)
}

/// The index of each used one among the used ones.
fn places(is_used: &[bool]) -> Vec<Option<usize>> {
    let mut next = 0..;
    is_used
        .iter()
        .map(|used| if *used { next.next() } else { None })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::components::free_name::free_name;
    use crate::scene::components::names::{free_name_for, is_taken};

    /// Both ways to find a free name agree.
    #[test]
    fn free_names_are_those_of_the_whole_list() {
        let known = [
            "ball",
            "ball-2",
            "ball-04",
            "a-b",
            "x-0",
            "x-1",
            "y-+7",
            "y-8",
            "z-4294967294",
            "z-4294967295",
            "f/",
            "f-2/",
            "f-3",
            "g/-2",
        ];
        for wanted in [
            "ball",
            "ball-2",
            "ball-04",
            "ball-4",
            "a",
            "a-b",
            "x",
            "x-0",
            "y-+7",
            "z-4294967294",
            "f/",
            "f",
            "g/",
            "f-2/",
            "",
        ] {
            let mut world = World::new();
            for (name, order) in known.iter().zip(0..) {
                world.spawn((DocumentOrder(order), SceneId((*name).to_owned())));
            }
            let expected = free_name(&names(&mut world), wanted);
            assert_eq!(free_name_for(&mut world, wanted), expected, "{wanted}");
            assert_eq!(is_taken(&mut world, wanted), known.contains(&wanted));
        }
    }
}
