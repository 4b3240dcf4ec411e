//! An edit in progress, which becomes a step of the history.

use std::collections::HashMap;

use bevy::prelude::*;

use super::History;
use super::entry::{Change, Entry, MergeKey, SettingsState, Standpoint, StepKind};
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::light_mix::LightMix;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::session::toasts::Toasts;
use crate::scene::{Keys, ObjectChange, ObjectState, ToWorld, integrator_keys_after, keys_after, pose, shown_time};

/// An edit in progress: records the state of each entity before its first change.
pub struct Edit<'w> {
    /// The world. Unrecorded parts of it must only be read.
    pub world: &'w mut World,
    /// The kind of the step that this becomes.
    pub kind: StepKind,
    before: Vec<(Entity, ObjectState)>,
    /// The index of each entity in `before`.
    places: HashMap<Entity, usize>,
    settings: SettingsState,
    selection: Selection,
    standpoint: Standpoint,
    mix: LightMix,
}

impl<'w> Edit<'w> {
    pub(crate) fn begin(world: &'w mut World) -> Self {
        Self {
            kind: StepKind::default(),
            before: Vec::new(),
            places: HashMap::new(),
            settings: SettingsState::of(world),
            selection: world.resource::<Selection>().clone(),
            standpoint: Standpoint::of(world),
            mix: mix_of(world),
            world,
        }
    }

    /// Records the entity's state; to be called before any change of it.
    pub(crate) fn touch(&mut self, entity: Entity) {
        if !self.places.contains_key(&entity) {
            let state = ObjectState::of(self.world, entity);
            self.note(entity, state);
        }
    }

    fn note(&mut self, entity: Entity, before: ObjectState) {
        self.places.entry(entity).or_insert(self.before.len());
        self.before.push((entity, before));
    }

    /// Checks the poses of touched entities. An error if a file could not hold one of them.
    pub(crate) fn check_poses(&self) -> Result<(), CommandError> {
        let mut poses = self
            .before
            .iter()
            .filter_map(|(entity, _)| self.world.get::<ToWorld>(*entity));
        match poses.all(ToWorld::is_invertible) {
            true => Ok(()),
            false => Err("Nothing can be so far away, so large, so small or so flat.".into()),
        }
    }

    /// The touched entities with their states before the edit.
    pub(crate) fn touched(&self) -> impl Iterator<Item = (Entity, &ObjectState)> {
        self.before.iter().map(|(entity, before)| (*entity, before))
    }

    /// Sets a component if it differs; an entity that is not in the scene stays out of it.
    pub fn set<C: Component + PartialEq>(&mut self, entity: Entity, value: C) {
        if ObjectState::is_in_scene(self.world, entity) && self.world.get::<C>(entity) != Some(&value) {
            self.touch(entity);
            self.world.entity_mut(entity).insert(value);
        }
    }

    /// Takes a component off; undo puts it back.
    pub fn remove<C: Component>(&mut self, entity: Entity) {
        if self.world.get::<C>(entity).is_some() {
            self.touch(entity);
            self.world.entity_mut(entity).remove::<C>();
        }
    }

    /// A new entity of the scene.
    pub fn spawn(&mut self, bundle: impl Bundle) -> Entity {
        let entity = self.world.spawn_empty().id();
        self.touch(entity);
        self.world.entity_mut(entity).insert(bundle);
        entity
    }

    /// Records entities that were spawned elsewhere.
    pub(crate) fn spawned(&mut self, entities: impl IntoIterator<Item = Entity>) {
        for entity in entities {
            self.note(entity, ObjectState::default());
        }
    }

    /// Removes an entity from the scene.
    pub(crate) fn delete(&mut self, entity: Entity) {
        self.touch(entity);
        ObjectState::default().write(self.world, entity);
    }

    /// Sets keys for changed values that have tracks, and then sets all animated values from their tracks, which may
    /// have changed.
    pub(crate) fn follow_keys(&mut self) {
        if SettingsState::of(self.world).integrator != self.settings.integrator
            && let Some(keys) = integrator_keys_after(self.world)
        {
            self.world.insert_resource(keys);
        }
        let (mut moving, mut lost) = (Vec::new(), Vec::new());
        for (entity, before) in &self.before {
            let is_moving = before.keys.is_some() || self.world.get::<Keys>(*entity).is_some();
            if !is_moving || !ObjectState::is_in_scene(self.world, *entity) {
                continue;
            }
            if let Some(after) = keys_after(self.world, *entity, before) {
                match after.keys.some() {
                    Some(keys) => self.world.entity_mut(*entity).insert(keys),
                    None => self.world.entity_mut(*entity).remove::<Keys>(),
                };
                lost.extend(after.lost);
            }
            moving.push(*entity);
        }
        lost.sort();
        lost.dedup();
        if !lost.is_empty() {
            let names: Vec<String> = lost.iter().map(|path| format!("`{path}`")).collect();
            let names = names.join(", ");
            let message =
                format!("Something else took the place of {names}, which had keys: they are gone until you undo.");
            self.world.resource_mut::<Toasts>().warn(message);
        }
        if !moving.is_empty() {
            pose(self.world, &moving);
        }
    }

    /// Restores all recorded states.
    pub(crate) fn abandon(self) {
        for (entity, before) in self.before.iter().rev() {
            before.write(self.world, *entity);
        }
        let now = SettingsState::of(self.world);
        self.settings.write(self.world, &now);
        self.world.insert_resource(self.selection);
    }

    /// Writes the step into the history, unless nothing has changed.
    pub fn finish(self, label: String, merge: Option<(u64, MergeKey)>) {
        let changes = self.before.into_iter().filter_map(|(entity, before)| {
            let change = ObjectChange::between(&before, &ObjectState::of(self.world, entity))?;
            Some(Change { entity, change })
        });
        let (now, mix) = (Standpoint::of(self.world), mix_of(self.world));
        let mut entry = Entry {
            label,
            changes: changes.collect(),
            settings: [self.settings, SettingsState::of(self.world)],
            selection: [self.selection, self.world.resource::<Selection>().clone()],
            standpoint: (now != self.standpoint).then_some([self.standpoint, now]),
            mix: (mix != self.mix).then_some([self.mix, mix]),
            merge,
            kind: self.kind,
            time: shown_time(self.world),
            number: 0,
            bytes: 0,
        };
        entry.changes.shrink_to_fit();
        entry.count_bytes();
        let mut history = self.world.resource_mut::<History>();
        history.next_number += 1;
        entry.number = history.next_number;
        history.push(entry);
    }
}

fn mix_of(world: &World) -> LightMix {
    world.get_resource::<LightMix>().cloned().unwrap_or_default()
}
