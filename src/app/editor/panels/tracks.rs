//! The tracks of the timeline: one for each value of the selection that moves.

use bevy::prelude::Entity;

use crate::app::editor::model::timeline::{TickTime, TimelineModel};
use crate::scene::KeyPath;

/// The most tracks. Of more the keys share one.
const MOST: usize = 4;

/// A key of a track.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TrackKey {
    pub time: TickTime,
    pub track: usize,
}

/// The tracks of the selection, by the names of their values.
pub(super) struct Tracks {
    /// The values of each track; one track without any has all of them.
    paths: Vec<KeyPath>,
}

impl Tracks {
    pub fn of(model: &TimelineModel) -> Self {
        let values = model.selected.values().flat_map(|tick| &tick.values);
        let mut paths: Vec<KeyPath> = values.map(|(_, path)| path.clone()).collect();
        paths.sort_unstable_by(|one, other| one.as_str().cmp(other.as_str()));
        paths.dedup();
        if paths.len() > MOST {
            paths.clear();
        }
        Self { paths }
    }

    pub fn count(&self) -> usize {
        self.paths.len().max(1)
    }

    /// The name of a track, without the parts of the path before it.
    pub fn name(&self, track: usize) -> String {
        match self.paths.get(track) {
            Some(path) if path.is_place() => "place".to_owned(),
            Some(path) => path.as_str().rsplit('.').next().unwrap_or_default().replace('_', " "),
            None => String::new(),
        }
    }

    /// The values of a track that have keys at a time.
    pub fn values(&self, model: &TimelineModel, key: TrackKey) -> Vec<(Entity, KeyPath)> {
        let values = model.selected.get(&key.time).map_or(&[][..], |tick| &tick.values);
        let path = self.paths.get(key.track);
        let is_here = |(_, of): &&(Entity, KeyPath)| path.is_none_or(|path| path == of);
        values.iter().filter(is_here).cloned().collect()
    }

    /// All keys.
    pub fn keys<'a>(&'a self, model: &'a TimelineModel) -> impl Iterator<Item = TrackKey> + 'a {
        let all =
            (0..self.count()).flat_map(|track| model.selected.keys().map(move |time| TrackKey { time: *time, track }));
        all.filter(|key| !self.values(model, *key).is_empty())
    }
}
