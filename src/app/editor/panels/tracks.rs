//! The tracks of the timeline: one for each value of the selection that moves.

use bevy::prelude::Entity;

use crate::app::editor::model::timeline::{TickTime, TimelineModel};
use crate::scene::KeyPath;

/// The most tracks. Of more values the keys share one.
pub(super) const MOST: usize = 4;

/// A key of a track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TrackKey {
    pub time: TickTime,
    pub track: usize,
}

/// The tracks of the selection, by the names of their values.
#[derive(Clone, Copy)]
pub(super) struct Tracks<'m> {
    model: &'m TimelineModel,
    /// The value of each track; one track without any has all of them.
    paths: &'m [KeyPath],
}

impl<'m> Tracks<'m> {
    pub fn of(model: &'m TimelineModel) -> Self {
        let paths = if model.values.len() > MOST {
            &[]
        } else {
            &model.values[..]
        };
        Self { model, paths }
    }

    pub fn count(self) -> usize {
        self.paths.len().max(1)
    }

    /// The name of a track, without the parts of the path before it.
    pub fn name(self, track: usize) -> String {
        match self.paths.get(track) {
            Some(path) if path.is_place() => "place".to_owned(),
            Some(path) => path.as_str().rsplit('.').next().unwrap_or_default().replace('_', " "),
            None => String::new(),
        }
    }

    /// The values of a track that have keys at a time.
    pub fn values(self, key: TrackKey) -> impl Iterator<Item = &'m (Entity, KeyPath)> {
        let tick = self.model.selected.get(&key.time);
        let path = self.paths.get(key.track);
        let values = tick.into_iter().flat_map(|tick| &tick.values);
        values.filter(move |(_, of)| path.is_none_or(|path| path == of))
    }

    /// All keys.
    pub fn keys(self) -> impl Iterator<Item = TrackKey> {
        let times = move |track| {
            self.model
                .selected
                .keys()
                .map(move |time| TrackKey { time: *time, track })
        };
        let all = (0..self.count()).flat_map(times);
        all.filter(move |key| self.values(*key).next().is_some())
    }

    /// The times of the keys of other things, in seconds.
    pub fn times_of_others(self) -> impl Iterator<Item = f64> {
        let all = self.model.all.iter().copied();
        all.filter(move |time| !self.model.selected.contains_key(&TickTime(*time)))
    }
}
