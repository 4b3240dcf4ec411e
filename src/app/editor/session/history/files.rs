//! The file at states of the history: saving after an undo reuses the text from before the undone edits.

use std::path::Path;
use std::sync::Arc;

use bevy::prelude::*;

use super::History;
use crate::document::Document;
use crate::scene::AuthoredScene;
use crate::scene::write::{GivenId, PastFile, Saved, TakenId};

/// The number of kept files, above which the oldest are dropped.
const MOST: usize = 100;
/// The total length of their texts in bytes, above which the oldest are dropped. The memory of a file is a multiple of
/// its text.
const LONGEST: usize = 8 << 20;

/// The file at states other than its present one, the oldest save first.
#[derive(Debug, Default)]
pub(super) struct PastFiles {
    all: Vec<AtState>,
    /// The file as the last save wrote it. If the present file differs, others have changed it, and its past is of no
    /// use.
    now: Option<Arc<Document>>,
}

#[derive(Debug)]
struct AtState {
    /// The last edit in the file, as [`History::position`] numbers it.
    at: Option<u64>,
    file: Arc<PastFile>,
    /// The ids that a save after this state gave to entities.
    given: Vec<GivenId>,
}

impl PastFiles {
    /// Keeps the newest files within the bounds, of states that undo and redo can reach.
    fn forget(&mut self, is_reached: impl Fn(Option<u64>) -> bool) {
        let mut kept: Vec<AtState> = Vec::new();
        for state in self.all.drain(..) {
            if is_reached(state.at) {
                kept.push(state);
            } else if let Some(before) = kept.last_mut() {
                before.given.extend(state.given);
            }
        }
        let mut length = 0;
        let newest = kept.iter().rev().take(MOST).take_while(|state| {
            length += state.file.text_len();
            length <= LONGEST
        });
        let gone = kept.len() - newest.count();
        kept.drain(..gone);
        self.all = kept;
    }
}

impl History {
    /// The number of steps before a state, if it is among the states that undo and redo can reach.
    fn steps_before(&self, at: Option<u64>) -> Option<usize> {
        match at {
            None => (!self.has_forgotten).then_some(0),
            Some(number) => {
                let place = self.done.iter().position(|entry| entry.number == number);
                place.map(|place| place + 1)
            }
        }
    }

    /// Stores the file before and after a successful save. To be called before [`Self::end_save`].
    pub(crate) fn note_file(&mut self, saved: Saved, now: Option<Arc<Document>>) {
        let Self { done, undone, .. } = self;
        let is_known = |at: u64| done.iter().chain(undone.iter()).any(|entry| entry.number == at);
        let is_reached = |at: Option<u64>| at.map_or(!self.has_forgotten, is_known);
        match saved.before {
            None => self.files.all.clear(),
            Some(file) if !self.saved.is_lost => self.files.all.push(AtState {
                at: self.saved.at,
                file: Arc::new(file),
                given: saved.given,
            }),
            // Undo does not lead to that state any more.
            Some(_) => {
                if let Some(last) = self.files.all.last_mut() {
                    last.given.extend(saved.given);
                }
            }
        }
        self.files.forget(is_reached);
        self.files.now = now;
    }
}

/// The past file whose state is nearest before the present one. None if the present file is nearer. Entities lose the
/// ids that later saves gave them, until the save has failed ([`end_save`]). To be called when a save to `path` begins,
/// after changes by others were taken in.
pub(crate) fn nearest_file(world: &mut World, path: &Path) -> Option<Arc<PastFile>> {
    let origin = world.get_resource::<AuthoredScene>()?.origin.clone()?;
    let mut history = world.get_resource_mut::<History>()?;
    let history = &mut *history;
    let is_same = |now: &Arc<Document>| now.diagnostics.sources == origin.diagnostics.sources;
    if !history.files.now.as_ref().is_some_and(is_same) {
        history.files = PastFiles::default();
        return None;
    }
    let saved = Some(history.saved).filter(|saved| !saved.is_lost);
    let steps_of_file = saved.and_then(|saved| history.steps_before(saved.at));
    let all = history.files.all.iter().enumerate();
    let reached = all.filter_map(|(index, state)| Some((history.steps_before(state.at)?, index)));
    let (steps, index) = reached.max()?;
    let state = &history.files.all[index];
    if Some(steps) <= steps_of_file || !state.file.is_at(path) {
        return None;
    }
    let file = state.file.clone();
    let later = history.files.all[index..].iter().rev();
    let given: Vec<GivenId> = later.flat_map(|state| state.given.iter().rev().cloned()).collect();
    let taken: Vec<TakenId> = given.iter().filter_map(|given| given.take_back(world)).collect();
    world.resource_mut::<History>().taken_ids.extend(taken);
    Some(file)
}

/// Notes the result of a save, as [`History::end_save`]. A failure restores the ids from before.
pub(crate) fn end_save(world: &mut World, is_saved: bool) {
    let mut history = world.resource_mut::<History>();
    history.end_save(is_saved);
    let taken = std::mem::take(&mut history.taken_ids);
    if !is_saved {
        TakenId::give_again(taken, world);
    }
}
