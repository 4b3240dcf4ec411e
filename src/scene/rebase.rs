//! Updates the known state of the file after saving: the entities are what is written there, whether they were read or made here.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use bevy::prelude::*;

use super::description::{Identity, SceneDescription};
use super::file_base::{FileBase, Thing, set_authored};
use super::spawn::StandInSensor;
use super::write::gather::Entities;
use super::{Authored, ObjectState, Placements, SceneId};

/// Updates the known file: it now says `written`, which was made of `scene`, of these entities. What was made in the editor belongs to it from now
/// on.
pub(super) fn rebase(world: &mut World, scene: &SceneDescription, entities: &Entities, written: Arc<SceneDescription>) {
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
        materials: paired(&entities.materials, material_pairs(scene, &written, &shapes)),
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
    let mut base = FileBase {
        integrator: Some(written.integrator),
        ..FileBase::default()
    };
    for thing in Thing::all(&written) {
        let entity = thing.entity(&now);
        let state = thing.state(&written, &now);
        set_authored(world, entity, thing.identity(&written).authored.as_ref());
        if ObjectState::of(world, entity).is_there()
            && let Some(id) = &state.id
            && world.get::<SceneId>(entity) != Some(id)
        {
            world.entity_mut(entity).insert((id.clone(), Name::new(id.0.clone())));
        }
        // The memory of their places is shared with the new document.
        if let Some(placements) = state
            .placements
            .clone()
            .filter(|_| world.get::<Placements>(entity).is_some())
        {
            world.entity_mut(entity).insert(placements);
        }
        base.remember(entity, ObjectState::of(world, entity), &state);
    }
    let claimed: HashSet<Entity> = now.all().collect();
    let mut others = world.query_filtered::<Entity, With<Authored>>();
    let others: Vec<Entity> = others.iter(world).filter(|entity| !claimed.contains(entity)).collect();
    for entity in others {
        set_authored(world, entity, None);
    }
    for &camera in &now.sensors {
        world.entity_mut(camera).remove::<StandInSensor>();
    }
    world.insert_resource(written.remains.clone());
    (base.scene, base.entities) = (written, now);
    world.insert_resource(base);
}

/// Finds for each written thing the known one that it is: the one with the same id, or else the next one without an id that is alike.
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

/// The known material that each written one is: it has the same users, outermost first, or else it is what [`pairs`] finds.
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
