//! The edits of the scene that can be undone and redone. An entry holds only the components that an edit changed,
//! before and after; the number of entries and their memory are bounded.
//!
//! Entities are not despawned while entries name them: without components they are out of the scene, and their ids stay
//! valid.

mod edit;
mod entry;
mod files;

use bevy::ecs::entity::EntityHashSet;
use bevy::platform::collections::HashMap;
use bevy::prelude::*;

pub use edit::Edit;
use entry::{Change, Standpoint};
pub use entry::{Entry, MergeKey, StepKind};
use files::PastFiles;
pub(crate) use files::{end_save, nearest_file};

use crate::app::editor::command::error::CommandError;
use crate::scene::names::free_name_for;
use crate::scene::write::TakenId;
use crate::scene::{Authored, DocumentOrder, ObjectState, Placements, SceneId, Side, show_moment, shown_time};

/// The number of steps above which the oldest are dropped.
pub(crate) const MOST_ENTRIES: usize = 1000;
/// The estimated memory above which the oldest steps are dropped. The newest step stays, however large it is.
pub(crate) const MOST_BYTES: usize = 64 << 20;

/// The state of the history that the file holds.
#[derive(Clone, Copy, Debug, Default)]
struct SavedState {
    /// The last entry before it; None: before all of them.
    at: Option<u64>,
    /// Whether undo and redo cannot reach it any more.
    is_lost: bool,
}

impl SavedState {
    fn is_at(&self, position: Option<u64>) -> bool {
        !self.is_lost && position == self.at
    }
}

/// The steps that can be undone and redone.
#[derive(Resource, Debug, Default)]
pub struct History {
    done: Vec<Entry>,
    undone: Vec<Entry>,
    next_number: u64,
    saved: SavedState,
    /// The state of the save in progress.
    being_saved: Option<SavedState>,
    /// Whether oldest entries were dropped.
    has_forgotten: bool,
    /// Entities that dropped entries named.
    named_once: Vec<Entity>,
    /// The file at other states.
    files: PastFiles,
    /// The ids that were taken from entities for the save in progress.
    taken_ids: Vec<TakenId>,
}

impl History {
    /// Clears the history after a scene was opened.
    pub fn clear(&mut self) {
        let gone = self.done.drain(..).chain(self.undone.drain(..));
        self.named_once.extend(gone.flat_map(Entry::into_entities));
        *self = Self {
            next_number: self.next_number,
            named_once: std::mem::take(&mut self.named_once),
            ..Self::default()
        };
    }

    /// The labels of the steps that can be undone, oldest first, and of those that can be redone, next first.
    pub(crate) fn labels(&self) -> (Vec<&str>, Vec<&str>) {
        let done = self.done.iter().map(|entry| entry.label.as_str());
        let undone = self.undone.iter().rev().map(|entry| entry.label.as_str());
        (done.collect(), undone.collect())
    }

    /// Whether the last step other than moves made copies.
    pub(crate) fn was_just_copied(&self) -> bool {
        let mut kinds = self.done.iter().rev().map(|entry| entry.kind);
        kinds.find(|kind| *kind != StepKind::Move) == Some(StepKind::Copy)
    }

    /// The number of steps that can be undone and redone.
    pub fn len(&self) -> (usize, usize) {
        (self.done.len(), self.undone.len())
    }

    /// Whether everything can be undone back to the opened scene.
    pub fn is_whole(&self) -> bool {
        !self.has_forgotten
    }

    /// An estimate of the memory of all steps, in bytes.
    pub fn bytes(&self) -> usize {
        self.done.iter().chain(&self.undone).map(|entry| entry.bytes).sum()
    }

    /// The number of the last edit that a file would hold; equal numbers of one run mean equal files.
    pub fn position(&self) -> Option<u64> {
        let of_file = self.done.iter().rev().find(|entry| entry.is_of_file());
        of_file.map(|entry| entry.number)
    }

    /// The number of the last step, whatever it changed.
    pub fn last_step(&self) -> Option<u64> {
        self.done.last().map(|entry| entry.number)
    }

    /// Whether the scene equals its file.
    pub fn is_saved(&self) -> bool {
        self.saved.is_at(self.position())
    }

    /// Notes that the file holds the scene as it is now.
    pub fn note_saved(&mut self) {
        self.begin_save();
        self.end_save(true);
    }

    /// Notes that a save of the scene's present state has begun.
    pub(crate) fn begin_save(&mut self) {
        self.being_saved = Some(SavedState {
            at: self.position(),
            is_lost: false,
        });
        // The next edit is a step of its own, because this one is in the file.
        if let Some(entry) = self.done.last_mut() {
            entry.merge = None;
        }
    }

    /// Notes that the file holds the state of [`Self::begin_save`], or that the save failed.
    pub(crate) fn end_save(&mut self, is_saved: bool) {
        if let Some(state) = self.being_saved.take().filter(|_| is_saved) {
            self.saved = state;
        }
    }

    /// Whether a save is running.
    pub(crate) fn is_saving(&self) -> bool {
        self.being_saved.is_some()
    }

    /// Whether the save in progress has the scene's present state.
    pub(crate) fn is_being_saved(&self) -> bool {
        self.being_saved.is_some_and(|state| state.is_at(self.position()))
    }

    /// Notes that no file holds the scene.
    pub fn note_unsaved(&mut self) {
        self.saved.is_lost = true;
    }

    fn push(&mut self, entry: Entry) {
        if entry.is_empty() {
            return;
        }
        for state in std::iter::once(&mut self.saved).chain(&mut self.being_saved) {
            state.is_lost |= self.undone.iter().any(|entry| Some(entry.number) == state.at);
        }
        let undone = self.undone.drain(..).flat_map(Entry::into_entities);
        self.named_once.extend(undone);
        if let Some(last) = self.done.last_mut()
            && last.merge.is_some()
            && last.merge == entry.merge
            && last.time == entry.time
        {
            last.absorb(entry);
            if last.is_empty() {
                self.done.pop();
            }
            return;
        }
        self.done.push(entry);
        self.forget();
    }

    /// Drops the oldest steps beyond the bounds.
    fn forget(&mut self) {
        let mut bytes = 0;
        let newest = self.done.iter().rev().take(MOST_ENTRIES);
        let kept = newest.take_while(|entry| {
            bytes += entry.bytes;
            bytes <= MOST_BYTES
        });
        let kept = kept.count().max(1);
        for forgotten in self.done.drain(..self.done.len().saturating_sub(kept)) {
            self.has_forgotten = true;
            for state in std::iter::once(&mut self.saved).chain(&mut self.being_saved) {
                match state.at {
                    Some(saved) if saved == forgotten.number => state.at = None,
                    None => state.is_lost = true,
                    Some(_) => {}
                }
            }
            self.named_once.extend(forgotten.into_entities());
        }
    }
}

/// The number of unnamed entities from which on they are despawned: finding them takes a pass over all entries.
const GONE_AT_ONCE: usize = 512;

/// Despawns deleted entities that neither undo nor redo can restore. Entities that are still in the file stay: a reload
/// must know that they were deleted.
pub(crate) fn despawn_forgotten(world: &mut World) {
    let mut history = world.resource_mut::<History>();
    // A save in progress refers to entities by their ids.
    if history.named_once.len() < GONE_AT_ONCE || history.is_saving() {
        return;
    }
    let gone = std::mem::take(&mut history.named_once);
    let entries = history.done.iter().chain(&history.undone);
    let named: EntityHashSet = entries
        .flat_map(|entry| entry.changes.iter().map(|change| change.entity))
        .collect();
    for entity in gone {
        let is_needed = named.contains(&entity)
            || ObjectState::is_in_scene(world, entity)
            || world.get::<Authored>(entity).is_some()
            || world.get::<Placements>(entity).is_some();
        if !is_needed && let Ok(entity) = world.get_entity_mut(entity) {
            entity.despawn();
        }
    }
}

fn stand(world: &mut World, at: Standpoint) {
    world.insert_resource(at.camera);
    world.insert_resource(at.free);
}

/// Makes ids unique after undo and redo. Saves and reloads give ids that the history does not know: a restored entity
/// with the id of another gets a free one, since no file may have an id twice.
fn separate_ids(world: &mut World, changes: &[Change]) {
    let mut restored: HashMap<SceneId, Vec<Entity>> = HashMap::new();
    for change in changes.iter().filter(|change| change.change.is_about_id()) {
        if let Some(id) = world.get::<SceneId>(change.entity) {
            restored.entry(id.clone()).or_default().push(change.entity);
        }
    }
    if restored.is_empty() {
        return;
    }
    let mut all = world.query_filtered::<(Entity, &SceneId), With<DocumentOrder>>();
    let mut owners: HashMap<&SceneId, usize> = HashMap::new();
    for (_, id) in all.iter(world) {
        if let Some((id, _)) = restored.get_key_value(id) {
            *owners.entry(id).or_default() += 1;
        }
    }
    let is_shared = |id: &SceneId| owners.get(id).is_some_and(|&owners| owners > 1);
    let shared = changes.iter().filter_map(|change| {
        let (id, entities) = restored.get_key_value(world.get::<SceneId>(change.entity)?)?;
        (is_shared(id) && entities.contains(&change.entity)).then(|| (change.entity, id.clone()))
    });
    let shared: Vec<(Entity, SceneId)> = shared.collect();
    for (entity, id) in shared {
        // If several are restored with the same id, one of them may keep it.
        let mut all = world.query_filtered::<(Entity, &SceneId), With<DocumentOrder>>();
        if all.iter(world).any(|(other, its)| other != entity && *its == id) {
            let free = free_name_for(world, &id.0);
            world
                .entity_mut(entity)
                .insert((SceneId(free.clone()), Name::new(free)));
        }
    }
}

/// Shows the time of a step, at which its states were recorded.
fn go_to_time(world: &mut World, time: f64) {
    if time != shown_time(world) {
        show_moment(world, time);
    }
}

/// Undoes a step. An error, in words, if there is none.
pub(crate) fn undo(world: &mut World) -> Result<(), CommandError> {
    let Some(mut entry) = world.resource_mut::<History>().done.pop() else {
        return Err("There is nothing to undo.".into());
    };
    let shown = shown_time(world);
    go_to_time(world, entry.time);
    for change in &mut entry.changes {
        change.change.refresh(world, change.entity);
    }
    for change in entry.changes.iter().rev() {
        change.change.write(world, change.entity, Side::Before);
    }
    entry.settings[0].write(world, &entry.settings[1]);
    show_moment(world, shown);
    separate_ids(world, &entry.changes);
    world.insert_resource(entry.selection[0].clone());
    if let Some([before, _]) = &entry.mix {
        world.insert_resource(before.clone());
    }
    if let Some([before, _]) = entry.standpoint {
        stand(world, before);
    }
    entry.merge = None;
    world.resource_mut::<History>().undone.push(entry);
    Ok(())
}

/// Redoes a step. An error, in words, if there is none.
pub(crate) fn redo(world: &mut World) -> Result<(), CommandError> {
    let Some(entry) = world.resource_mut::<History>().undone.pop() else {
        return Err("There is nothing to do again.".into());
    };
    let shown = shown_time(world);
    go_to_time(world, entry.time);
    for change in &entry.changes {
        change.change.write(world, change.entity, Side::After);
    }
    entry.settings[1].write(world, &entry.settings[0]);
    show_moment(world, shown);
    separate_ids(world, &entry.changes);
    world.insert_resource(entry.selection[1].clone());
    if let Some([_, after]) = &entry.mix {
        world.insert_resource(after.clone());
    }
    if let Some([_, after]) = entry.standpoint {
        stand(world, after);
    }
    world.resource_mut::<History>().done.push(entry);
    Ok(())
}
