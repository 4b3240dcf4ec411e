//! The file as it was at states of the history: a save of edits that are undone takes up the text from before them.

use std::path::Path;
use std::sync::Arc;

use bevy::prelude::*;

use super::History;
use crate::document::Document;
use crate::scene::AuthoredScene;
use crate::scene::write::{GivenId, PastFile, Saved, TakenId};

/// Older files are forgotten above this number.
const MOST: usize = 100;
/// Older files are also forgotten above this length of their texts in bytes: of each, much more is kept than its text.
const LONGEST: usize = 8 << 20;

/// The file at other states than the one that it has, the oldest save first.
#[derive(Debug, Default)]
pub(super) struct PastFiles {
    all: Vec<AtState>,
    /// What the last save wrote. If the file is another one now, others have changed it, and what it was is of no use.
    now: Option<Arc<Document>>,
}

#[derive(Debug)]
struct AtState {
    /// The last edit that it had, as [`History::position`] says it.
    at: Option<u64>,
    file: Arc<PastFile>,
    /// The ids that things got when the file was saved after this state.
    given: Vec<GivenId>,
}

impl PastFiles {
    /// Keeps the newest that the bounds have room for, of states that can be reached.
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
    /// The number of steps before a state, if undo or redo have led to it or past it.
    fn steps_before(&self, at: Option<u64>) -> Option<usize> {
        match at {
            None => (!self.has_forgotten).then_some(0),
            Some(number) => {
                let place = self.done.iter().position(|entry| entry.number == number);
                place.map(|place| place + 1)
            }
        }
    }

    /// Notes what the file was before a save that has succeeded, and what it is. To be called before
    /// [`Self::end_save`].
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

/// The file at the state before the present one that is the nearest to it. None if none is nearer than the file as it
/// is. Things lose the ids that saves after it gave them, until the save has failed ([`end_save`]). To be called when a
/// save to `path` begins, after changes by others were taken in.
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

/// Notes how a save has ended, as [`History::end_save`]. After a failure things have the ids again that they had
/// before.
pub(crate) fn end_save(world: &mut World, is_saved: bool) {
    let mut history = world.resource_mut::<History>();
    history.end_save(is_saved);
    let taken = std::mem::take(&mut history.taken_ids);
    if !is_saved {
        TakenId::give_again(taken, world);
    }
}
