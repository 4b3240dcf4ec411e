//! What was done to the scene, to be taken back and done again. An entry holds the components that an edit changed, before and after;
//! entities are never despawned while entries speak of them: without components they are out of the scene and their ids stay valid.

use bevy::prelude::*;

use super::selection::Selection;
use crate::scene::{AccelMethod, IntegratorSettings, ObjectState, SamplerSettings};

/// Older entries are forgotten. One of a thousand objects takes about a megabyte.
const MOST_ENTRIES: usize = 1000;

/// The settings that a scene has as a whole.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SettingsState {
    pub integrator: IntegratorSettings,
    pub sampler: SamplerSettings,
    pub accel: AccelMethod,
}

impl SettingsState {
    pub fn of(world: &World) -> Self {
        Self {
            integrator: world.get_resource().copied().unwrap_or_default(),
            sampler: world.get_resource().copied().unwrap_or_default(),
            accel: world.get_resource().copied().unwrap_or_default(),
        }
    }

    /// Writes only what differs.
    pub fn write(self, world: &mut World) {
        let now = Self::of(world);
        if now.integrator != self.integrator {
            world.insert_resource(self.integrator);
        }
        if now.sampler != self.sampler {
            world.insert_resource(self.sampler);
        }
        if now.accel != self.accel {
            world.insert_resource(self.accel);
        }
    }
}

#[derive(Clone, Debug)]
struct Change {
    entity: Entity,
    before: ObjectState,
    after: ObjectState,
}

/// One step of the history.
#[derive(Clone, Debug)]
pub struct Entry {
    /// In words, for the panel.
    pub label: String,
    changes: Vec<Change>,
    settings: [SettingsState; 2],
    selection: [Selection; 2],
    /// Steps of one interaction with equal keys are one entry.
    merge: Option<(u64, MergeKey)>,
    number: u64,
}

/// What kind of edit it is and of which entities: two of a kind in one drag are one step.
pub type MergeKey = (&'static str, Vec<Entity>);

#[derive(Resource, Debug, Default)]
pub struct History {
    done: Vec<Entry>,
    undone: Vec<Entry>,
    next_number: u64,
    /// The last entry done when the scene was saved; None: before all of them.
    saved_at: Option<u64>,
    /// The state that was saved cannot be reached any more.
    saved_is_lost: bool,
}

impl History {
    /// As after opening a scene.
    pub fn clear(&mut self) {
        *self = Self {
            next_number: self.next_number,
            ..Self::default()
        };
    }

    /// What can be undone, oldest first, and what can be done again, next first.
    pub fn labels(&self) -> (Vec<&str>, Vec<&str>) {
        let done = self.done.iter().map(|entry| entry.label.as_str());
        let undone = self.undone.iter().rev().map(|entry| entry.label.as_str());
        (done.collect(), undone.collect())
    }

    /// How many steps lie behind and ahead.
    pub fn len(&self) -> (usize, usize) {
        (self.done.len(), self.undone.len())
    }

    /// Counts the edits so far; equal numbers of one run mean equal scenes.
    pub fn position(&self) -> Option<u64> {
        self.done.last().map(|entry| entry.number)
    }

    pub fn is_saved(&self) -> bool {
        !self.saved_is_lost && self.position() == self.saved_at
    }

    pub fn note_saved(&mut self) {
        self.saved_at = self.position();
        self.saved_is_lost = false;
        // What comes next is a step of its own: this one is in the file.
        if let Some(entry) = self.done.last_mut() {
            entry.merge = None;
        }
    }

    /// The scene is not that of any file.
    pub fn note_unsaved(&mut self) {
        self.saved_is_lost = true;
    }

    fn push(&mut self, entry: Entry) {
        if entry.is_empty() {
            return;
        }
        if let Some(saved) = self.saved_at {
            self.saved_is_lost |= self.undone.iter().any(|entry| entry.number == saved);
        }
        self.undone.clear();
        if let Some(last) = self.done.last_mut()
            && last.merge.is_some()
            && last.merge == entry.merge
        {
            last.absorb(entry);
            if last.is_empty() {
                self.done.pop();
            }
            return;
        }
        self.done.push(entry);
        if self.done.len() > MOST_ENTRIES {
            let forgotten = self.done.remove(0);
            match self.saved_at {
                Some(saved) if saved == forgotten.number => self.saved_at = None,
                None => self.saved_is_lost = true,
                Some(_) => {}
            }
        }
    }
}

impl Entry {
    fn is_empty(&self) -> bool {
        self.changes.is_empty() && self.settings[0] == self.settings[1]
    }

    fn absorb(&mut self, later: Self) {
        for change in later.changes {
            match self.changes.iter_mut().find(|known| known.entity == change.entity) {
                Some(known) => known.after = change.after,
                None => self.changes.push(change),
            }
        }
        self.changes.retain(|change| change.before != change.after);
        self.settings[1] = later.settings[1];
        self.selection[1] = later.selection[1].clone();
    }
}

/// An edit under way: remembers what each entity was before it was first touched.
pub struct Edit<'w> {
    pub world: &'w mut World,
    before: Vec<(Entity, ObjectState)>,
    settings: SettingsState,
    selection: Selection,
}

impl<'w> Edit<'w> {
    pub fn begin(world: &'w mut World) -> Self {
        Self {
            before: Vec::new(),
            settings: SettingsState::of(world),
            selection: world.resource::<Selection>().clone(),
            world,
        }
    }

    /// Remembers the entity as it is; to be called before anything of it is changed.
    pub fn touch(&mut self, entity: Entity) {
        if !self.before.iter().any(|(known, _)| *known == entity) {
            self.before.push((entity, ObjectState::of(self.world, entity)));
        }
    }

    /// Writes a component if it differs.
    pub fn set<C: Component + PartialEq>(&mut self, entity: Entity, value: C) {
        if self.world.get_entity(entity).is_ok() && self.world.get::<C>(entity) != Some(&value) {
            self.touch(entity);
            self.world.entity_mut(entity).insert(value);
        }
    }

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

    /// Notes entities that were spawned by others.
    pub fn spawned(&mut self, entities: impl IntoIterator<Item = Entity>) {
        for entity in entities {
            self.before.push((entity, ObjectState::default()));
        }
    }

    /// Takes an entity out of the scene.
    pub fn delete(&mut self, entity: Entity) {
        self.touch(entity);
        ObjectState::default().write(self.world, entity);
    }

    /// Puts everything back.
    pub fn abandon(self) {
        for (entity, before) in self.before.iter().rev() {
            before.write(self.world, *entity);
        }
        self.settings.write(self.world);
        self.world.insert_resource(self.selection);
    }

    /// Writes the step into the history; without one nothing is written where nothing changed.
    pub fn finish(self, label: String, merge: Option<(u64, MergeKey)>) {
        let changes = self.before.into_iter().filter_map(|(entity, before)| {
            let after = ObjectState::of(self.world, entity);
            (before != after).then_some(Change { entity, before, after })
        });
        let mut entry = Entry {
            label,
            changes: changes.collect(),
            settings: [self.settings, SettingsState::of(self.world)],
            selection: [self.selection, self.world.resource::<Selection>().clone()],
            merge,
            number: 0,
        };
        let mut history = self.world.resource_mut::<History>();
        history.next_number += 1;
        entry.number = history.next_number;
        history.push(entry);
    }
}

/// Back to what it was, where the edit changed it: what the file changed meanwhile stays.
fn revert(world: &mut World, entity: Entity, from: &ObjectState, to: &ObjectState) {
    let now = ObjectState::of(world, entity);
    if from.is_there() && !now.is_there() {
        // The file took it away since.
        return;
    }
    ObjectState::merged(from, to, &now).state.write(world, entity);
}

/// An error, in words, if there is nothing to undo.
pub fn undo(world: &mut World) -> Result<(), &'static str> {
    let Some(mut entry) = world.resource_mut::<History>().done.pop() else {
        return Err("There is nothing to undo.");
    };
    for change in entry.changes.iter().rev() {
        revert(world, change.entity, &change.after, &change.before);
    }
    entry.settings[0].write(world);
    world.insert_resource(entry.selection[0].clone());
    entry.merge = None;
    world.resource_mut::<History>().undone.push(entry);
    Ok(())
}

/// An error, in words, if there is nothing to do again.
pub fn redo(world: &mut World) -> Result<(), &'static str> {
    let Some(entry) = world.resource_mut::<History>().undone.pop() else {
        return Err("There is nothing to undo.");
    };
    for change in &entry.changes {
        revert(world, change.entity, &change.before, &change.after);
    }
    entry.settings[1].write(world);
    world.insert_resource(entry.selection[1].clone());
    world.resource_mut::<History>().done.push(entry);
    Ok(())
}
