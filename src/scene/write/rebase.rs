//! Updates the known state of the file after saving: the entities become the things of the file, whether they were read
//! or made here.

use std::collections::HashMap;
use std::sync::Arc;

use bevy::ecs::entity::EntityHashSet;
use bevy::prelude::*;

use crate::scene::components::description::{Identity, SceneDescription};
use crate::scene::file::entities::Entities;
use crate::scene::file::file_base::{FileBase, Recognised, Thing, set_authored};
use crate::scene::load::spawn::{StandInSensor, give_way};
use crate::scene::write::{GivenId, PastFile};
use crate::scene::{Authored, AuthoredScene, Hidden, Locked, ObjectState, Placements, SceneId};

/// The entities with marks that files do not hold.
pub(in crate::scene) struct Marks {
    hidden: EntityHashSet,
    locked: EntityHashSet,
}

impl Marks {
    pub fn of(world: &mut World) -> Self {
        Self {
            hidden: world.query_filtered::<Entity, With<Hidden>>().iter(world).collect(),
            locked: world.query_filtered::<Entity, With<Locked>>().iter(world).collect(),
        }
    }
}

/// Pairs the things of a saved scene with those read again from the file.
pub(in crate::scene) struct Pairing {
    scene: SceneDescription,
    entities: Entities,
    marks: Marks,
    written: SceneDescription,
    recognised: Recognised,
}

impl Pairing {
    /// Finds the pairs. `written` was written from `scene`, of these entities.
    pub fn new(scene: SceneDescription, entities: Entities, marks: Marks, written: SceneDescription) -> Self {
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
        let sensors = pairs(&scene.sensors, &written.sensors, |it| &it.identity, |_, _| true);
        let emitters = pairs(
            &scene.emitters,
            &written.emitters,
            |it| &it.identity,
            |a, b| a.emitter.plugin() == b.emitter.plugin(),
        );
        let recognised = Recognised {
            media: media_pairs(&scene, &written, [&shapes, &emitters, &sensors]),
            materials: material_pairs(&scene, &written, &shapes),
            shapes,
            sensors,
            groups: pairs(&scene.groups, &written.groups, |it| &it.identity, |_, _| true),
            emitters,
        };
        Self {
            scene,
            entities,
            marks,
            written,
            recognised,
        }
    }

    /// The update of the entities, if each thing of the file has one.
    pub fn rebase(self) -> Result<Rebase, Box<Self>> {
        let is_known = |thing| self.recognised.before(thing).is_some();
        if !Thing::all(&self.written).all(is_known) {
            return Err(Box::new(self));
        }
        Ok(self.rebase_with(|| Entity::PLACEHOLDER))
    }

    /// The update of the entities. `make` makes one for each thing that is only in the file.
    pub fn rebase_with(self, mut make: impl FnMut() -> Entity) -> Rebase {
        let now = (self.recognised).entities(&self.entities, |known| known.unwrap_or_else(&mut make));
        let mut base = FileBase {
            integrator: Some((self.written.integrator, self.written.integrator_keys.clone())),
            ..FileBase::default()
        };
        let mut given = Vec::new();
        for thing in Thing::all(&self.written) {
            let entity = thing.entity(&now);
            let in_file = thing.state(&self.written, &now);
            let mut here = match self.recognised.before(thing) {
                Some(known) => ObjectState {
                    hidden: self.marks.hidden.contains(&entity).then_some(Hidden),
                    locked: self.marks.locked.contains(&entity).then_some(Locked),
                    ..known.state(&self.scene, &self.entities)
                },
                None => ObjectState::default(),
            };
            if let Some(id) = in_file
                .id
                .clone()
                .filter(|id| here.is_there() && here.id.as_ref() != Some(id))
            {
                let name_before = here.name.replace(Name::new(id.0.clone()));
                let before = here.id.replace(id.clone());
                given.push(GivenId {
                    entity,
                    before,
                    name_before,
                    id,
                });
            }
            base.remember(entity, here, &in_file);
        }
        let claimed = now.all().collect();
        (base.scene, base.entities) = (Arc::new(self.written), now);
        Rebase {
            rest: Box::new(Thing::all(&base.scene)),
            base,
            given,
            claimed,
        }
    }
}

/// The known state of a file before it was written, and the ids that things got then.
pub(in crate::scene) struct Old {
    base: Option<FileBase>,
    remains: Option<AuthoredScene>,
    pub given: Vec<GivenId>,
}

impl Old {
    /// The former file; None if there was none.
    pub fn file(&self) -> Option<PastFile> {
        PastFile::new(self.remains.as_ref()?, self.base.as_ref()?)
    }
}

/// The update of the entities after saving, step by step.
pub(in crate::scene) struct Rebase {
    base: FileBase,
    /// The things whose entities do not have their new order and source yet.
    rest: Box<dyn Iterator<Item = Thing> + Send + Sync>,
    /// The ids that things got during the save.
    given: Vec<GivenId>,
    claimed: EntityHashSet,
}

impl Rebase {
    /// Updates the order and source of this number of entities; true once all are updated.
    pub fn step(&mut self, world: &mut World, things: usize) -> bool {
        let mut left = things;
        while left > 0 {
            let Some(thing) = self.rest.next() else {
                return true;
            };
            left -= 1;
            let entity = thing.entity(&self.base.entities);
            set_authored(world, entity, thing.identity(&self.base.scene).authored.as_ref());
        }
        false
    }

    /// Completes the update, and returns the file's description. Things made in the editor belong to the file from now
    /// on. The known state of the old file is returned as well.
    pub fn finish(self, world: &mut World) -> (Arc<SceneDescription>, Old) {
        let mut new_ids = HashMap::new();
        let mut given = self.given;
        // A thing that was renamed since then keeps its new name.
        given.retain(|GivenId { entity, before, .. }| {
            ObjectState::is_in_scene(world, *entity) && world.get::<SceneId>(*entity) == before.as_ref()
        });
        for GivenId { entity, id, .. } in &given {
            let name = Name::new(id.0.clone());
            new_ids.insert(id.clone(), *entity);
            world.entity_mut(*entity).insert((id.clone(), name));
        }
        // Another thing may have got such an id meanwhile.
        give_way(world, &new_ids);
        let written = self.base.scene.clone();
        // The memory of their transforms is shared with the new document.
        for (shape, &entity) in written.shapes.iter().zip(&self.base.entities.shapes) {
            if let Some(placements) = &shape.placements
                && world.get::<Placements>(entity).is_some()
            {
                world.entity_mut(entity).insert(placements.clone());
            }
        }
        let mut others = world.query_filtered::<Entity, With<Authored>>();
        let others: Vec<Entity> = (others.iter(world))
            .filter(|entity| !self.claimed.contains(entity))
            .collect();
        for entity in others {
            set_authored(world, entity, None);
        }
        for &camera in &self.base.entities.sensors {
            if let Ok(mut camera) = world.get_entity_mut(camera) {
                camera.remove::<StandInSensor>();
            }
        }
        let old = Old {
            base: world.remove_resource(),
            remains: world.remove_resource(),
            given,
        };
        world.insert_resource(written.remains.clone());
        world.insert_resource(self.base);
        (written, old)
    }
}

/// For each written thing its known counterpart: the one with the same id, or else the next equal one without an id.
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

/// For each written material its known counterpart: the one with the same users, outermost first, or else the result of
/// [`pairs`].
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
    fill_in(&mut pairs, &mut is_taken, by_order);
    pairs
}

/// For each written medium its known counterpart: the one with the same users, or else the result of [`pairs`]. The
/// pairs of shapes, emitters and sensors are given.
fn media_pairs(
    scene: &SceneDescription,
    written: &SceneDescription,
    [shapes, emitters, sensors]: [&Vec<Option<usize>>; 3],
) -> Vec<Option<usize>> {
    let mut found = vec![None; written.media.len()];
    let mut is_taken = vec![false; scene.media.len()];
    let mut note = |new: Option<usize>, known: Option<usize>| {
        if let Some((new, known)) = new.zip(known)
            && found[new].is_none()
            && !is_taken[known]
        {
            found[new] = Some(known);
            is_taken[known] = true;
        }
    };
    for (new, known) in written.shapes.iter().zip(shapes) {
        let known = known.map(|known| &scene.shapes[known]);
        note(new.interior, known.and_then(|known| known.interior));
        note(new.exterior, known.and_then(|known| known.exterior));
    }
    for (new, known) in written.emitters.iter().zip(emitters) {
        note(new.medium, known.and_then(|known| scene.emitters[known].medium));
    }
    for (new, known) in written.sensors.iter().zip(sensors) {
        note(new.medium, known.and_then(|known| scene.sensors[known].medium));
    }
    let by_order = pairs(&scene.media, &written.media, |it| &it.identity, |_, _| true);
    fill_in(&mut found, &mut is_taken, by_order);
    found
}

/// Fills gaps in pairs with others whose things are not paired yet.
fn fill_in(pairs: &mut [Option<usize>], is_taken: &mut [bool], others: Vec<Option<usize>>) {
    for (pair, other) in pairs.iter_mut().zip(others) {
        if pair.is_none()
            && let Some(other) = other.filter(|other| !is_taken[*other])
        {
            is_taken[other] = true;
            *pair = Some(other);
        }
    }
}
