//! Inserts the things of a description into the scene, as if they had been made in the editor; and describes parts of
//! the scene.

use std::collections::HashMap;

use bevy::prelude::*;

use crate::scene::components::description::{DeclarationPlace, Identity, SceneDescription};
use crate::scene::components::folders::FreeFolders;
use crate::scene::components::names::TakenNames;
pub use crate::scene::components::names::names;
use crate::scene::file::entities::Entities;
use crate::scene::file::file_base::Thing;
use crate::scene::write::gather::describe_entities;
use crate::scene::write::identities;
use crate::scene::{
    DocumentOrder, FirstNested, Material, Medium, ObjectState, Properties, SceneId, SecondNested, ToWorld,
};

/// The entities that [`insert`] has made.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Inserted {
    /// All entities.
    pub all: Vec<Entity>,
    /// The main entities: shapes of the world, lights and cameras; materials and media, if there is nothing else.
    pub objects: Vec<Entity>,
}

/// The order after all existing things.
pub(crate) fn next_order(world: &mut World) -> u32 {
    let last = world.query::<&DocumentOrder>().iter(world).map(|order| order.0).max();
    last.map_or(0, |last| last.saturating_add(1))
}

/// Finds free ids and names.
struct FreeNames {
    folders: FreeFolders,
    taken: TakenNames,
}

impl FreeNames {
    fn new(world: &mut World, scene: &SceneDescription) -> Self {
        let mut folders = FreeFolders::default();
        let frames = scene.shapes.iter().filter(|shape| shape.shape.is_frame());
        let frames = frames.filter_map(|frame| frame.identity.id.as_deref()?.strip_suffix('/'));
        folders.find(|| names(world), frames.map(str::to_owned));
        let ids = identities(scene).filter_map(|identity| identity.id.as_deref());
        let taken = TakenNames::like(world, ids);
        Self { folders, taken }
    }

    fn take(&mut self, identity: &Identity) -> (Option<SceneId>, Name) {
        let in_folder = |name: &str| self.folders.in_copy(name).unwrap_or_else(|| name.to_owned());
        match &identity.id {
            Some(id) => {
                // A name in a folder that is free itself needs no number.
                let id = self.taken.take(&in_folder(id));
                (Some(SceneId(id.clone())), Name::new(id))
            }
            None => {
                let name = in_folder(&identity.name);
                self.taken.note(&name);
                (None, Name::new(name))
            }
        }
    }
}

/// Adds everything but settings; sensors are added with their films. Taken ids get numbers, and so do folders of groups
/// with their content. A material or medium is not added again if the scene has an equal one with the same id: that one
/// is used then.
pub fn insert(world: &mut World, scene: &SceneDescription) -> Inserted {
    let shared = shared_materials(world, scene);
    let shared_media = shared_media(world, scene);
    let mut free_names = FreeNames::new(world, scene);
    let mut order = next_order(world);
    let mut entity_of = |known: &Option<Entity>| known.unwrap_or_else(|| world.spawn_empty().id());
    let media = shared_media.iter().map(&mut entity_of).collect();
    let materials = shared.iter().map(&mut entity_of).collect();
    let mut new = |count: usize| (0..count).map(|_| entity_of(&None)).collect();
    let made = Entities {
        media,
        materials,
        groups: new(scene.groups.len()),
        shapes: new(scene.shapes.len()),
        emitters: new(scene.emitters.len()),
        sensors: new(scene.sensors.len()),
    };
    let is_new = |thing: &Thing| match *thing {
        Thing::Medium(index) => shared_media[index].is_none(),
        Thing::Material(index) => shared[index].is_none(),
        _ => true,
    };
    let mut all = Vec::new();
    let mut new_names: HashMap<&str, String> = HashMap::new();
    for thing in Thing::all(scene).filter(is_new) {
        let mut state = thing.state(scene, &made);
        // Each instance of a crowd becomes an entity of its own here.
        let placements = state.placements.take();
        let placements = placements.iter().flat_map(|many| many.places.iter());
        let mut places = placements.map(|&place| ToWorld(place.into()));
        state.to_world = places.next().or(state.to_world);
        let mut entity = thing.entity(&made);
        loop {
            let (id, name) = free_names.take(thing.identity(scene));
            if let (Some(old), Some(new)) = (&thing.identity(scene).id, &id) {
                new_names.entry(old).or_insert_with(|| new.0.clone());
            }
            let named = ObjectState {
                order: Some(DocumentOrder(order)),
                id,
                name: Some(name),
                ..state.clone()
            };
            named.write_new(world, entity, None);
            order = order.saturating_add(1);
            all.push(entity);
            let Some(place) = places.next() else { break };
            state.to_world = Some(place);
            entity = world.spawn_empty().id();
        }
    }
    // References between new things follow their names.
    for &entity in &all {
        let renamed = |properties: &Properties| properties.renamed(|thing| new_names.get(thing).cloned());
        if let Some(renamed) = world.get::<Properties>(entity).and_then(renamed) {
            world.entity_mut(entity).insert(renamed);
        }
    }
    let shapes = scene.shapes.iter().zip(&made.shapes);
    let shapes = shapes.filter(|(shape, _)| shape.member_of.is_none());
    let shapes = shapes.map(|(_, entity)| entity);
    let mut objects: Vec<Entity> = shapes.chain(&made.emitters).chain(&made.sensors).copied().collect();
    if objects.is_empty() {
        let materials = scene.materials.iter().map(|material| material.declared_in);
        let media = scene.media.iter().map(|medium| medium.declared_in);
        let materials = materials.zip(&made.materials);
        let outermost = materials
            .chain(media.zip(&made.media))
            .filter(|(place, _)| *place == DeclarationPlace::TopLevel);
        objects.extend(outermost.map(|(_, entity)| *entity));
    }
    Inserted { all, objects }
}

/// For each material of the scene the duplicate in the world, if there is one: it is used by a shape, and has the same
/// id and content.
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

/// For each medium of the scene the duplicate in the world, if there is one: it is in use, and has the same id and
/// content.
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

/// Whether the material equals that of the entity, nested ones included. `pairs` has the materials already found equal.
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

/// The description of these things with everything that they refer to: of materials, media, groups and their members
/// only the required ones. Their sources in the file are left out.
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
    // Nested materials come before or after their owners, so this repeats until nothing is added.
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
    let renumber = |index: &mut Option<usize>, places: &[Option<usize>]| {
        *index = index.and_then(|index| places[index]);
    };
    let unwritten = |identity: &mut Identity| identity.authored = None;
    SceneDescription {
        media: kept(whole.media, &is_medium_used, |medium| {
            unwritten(&mut medium.identity);
            medium.declared_in = place_of(medium.declared_in);
        }),
        materials: kept(whole.materials, &is_material_used, |material| {
            unwritten(&mut material.identity);
            renumber(&mut material.first, &material_at);
            renumber(&mut material.second, &material_at);
            material.declared_in = place_of(material.declared_in);
        }),
        groups: kept(whole.groups, &is_group_used, |group| unwritten(&mut group.identity)),
        shapes: kept(whole.shapes, &is_shape_used, |shape| {
            unwritten(&mut shape.identity);
            renumber(&mut shape.material, &material_at);
            renumber(&mut shape.member_of, &group_at);
            renumber(&mut shape.instance_of, &group_at);
            renumber(&mut shape.interior, &medium_at);
            renumber(&mut shape.exterior, &medium_at);
            // A crowd would become very many elements here.
            shape.placements = None;
        }),
        emitters: kept(whole.emitters, &is_emitter_used, |emitter| {
            unwritten(&mut emitter.identity);
            renumber(&mut emitter.medium, &medium_at);
        }),
        sensors: kept(whole.sensors, &is_sensor_used, |sensor| {
            unwritten(&mut sensor.identity);
            renumber(&mut sensor.medium, &medium_at);
        }),
        ..SceneDescription::default()
    }
}

/// The used elements, changed by `change`.
fn kept<T>(all: Vec<T>, is_used: &[bool], change: impl Fn(&mut T)) -> Vec<T> {
    let used = all.into_iter().zip(is_used).filter(|(_, used)| **used);
    let mut kept: Vec<T> = used.map(|(item, _)| item).collect();
    kept.iter_mut().for_each(change);
    kept
}

/// For each element its index among the used ones.
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
