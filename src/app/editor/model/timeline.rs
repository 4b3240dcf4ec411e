//! Fills the model of the timeline: the present time, and the keys.

use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

use bevy::ecs::change_detection::Tick as ChangeTick;
use bevy::ecs::entity::EntityHashSet;
use bevy::prelude::*;

use super::EditorModel;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::command::timeline::Timeline;
use crate::app::editor::session::view_settings::ViewSettings;
use crate::document::Track;
use crate::scene::{FirstNested, KeyPath, Keys, SecondNested, UsesMaterial, shown_time};

/// A key of the selection, with all values that have a key at its time.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tick {
    /// The values with a key at this time.
    pub values: Vec<(Entity, KeyPath)>,
}

/// The keys by their times.
pub type Ticks = BTreeMap<TickTime, Tick>;

/// The time of a key in seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TickTime(pub f64);

impl Eq for TickTime {}

impl PartialOrd for TickTime {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for TickTime {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

/// The content of the timeline.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TimelineModel {
    /// The frames.
    pub frames: Timeline,
    /// The displayed time, in seconds.
    pub time: f64,
    /// Whether the frames are played.
    pub is_playing: bool,
    /// The keys of the selection and of its materials.
    pub selected: Arc<Ticks>,
    /// The values of the selection and of its materials that have keys, by their names; things share them.
    pub values: Arc<Vec<KeyPath>>,
    /// The times of all keys in seconds.
    pub all: Arc<Vec<f64>>,
    /// The tracks of the things that the inspector shows.
    pub tracks: Arc<HashMap<Entity, Vec<(KeyPath, Arc<Track>)>>>,
}

impl TimelineModel {
    /// Whether the timeline is shown, given the user's choice.
    pub fn is_shown(&self, wanted: Option<bool>) -> bool {
        wanted.unwrap_or(!self.all.is_empty())
    }
}

/// The state that the keys in the model were gathered from.
#[derive(Debug, Default, PartialEq)]
pub struct Gathered {
    /// The animated things, and when their keys changed.
    moving: Vec<(Entity, ChangeTick)>,
    /// The things whose keys count as those of the selection.
    shown: Vec<Entity>,
}

/// Gathers the keys when they or the selection have changed.
pub fn gather_timeline(world: &mut World, mut gathered: Local<Gathered>) {
    let time = shown_time(world);
    let settings = world.resource::<ViewSettings>();
    let (frames, is_playing) = (settings.timeline, settings.playback.is_playing());
    let model = &mut world.resource_mut::<EditorModel>().0.timeline;
    (model.frames, model.time, model.is_playing) = (frames, time, is_playing);
    let mut moving = world.query::<(Entity, Ref<Keys>)>();
    let mut now = Gathered::default();
    let changes = moving.iter(world).map(|(entity, keys)| (entity, keys.last_changed()));
    now.moving.extend(changes);
    if !now.moving.is_empty() {
        now.shown = shown_things(world);
    }
    if *gathered == now {
        return;
    }
    *gathered = now;
    let shown: EntityHashSet = gathered.shown.iter().copied().collect();
    let mut all: Vec<f64> = Vec::new();
    let mut selected = Ticks::new();
    let mut tracks: HashMap<Entity, Vec<(KeyPath, Arc<Track>)>> = HashMap::new();
    for (entity, keys) in moving.iter(world) {
        for (path, track) in keys.tracks() {
            all.extend(track.keys.iter().map(|key| key.time));
            if !shown.contains(&entity) {
                continue;
            }
            tracks.entry(entity).or_default().push((path.clone(), track.clone()));
            for key in &track.keys {
                let tick = selected.entry(TickTime(key.time)).or_default();
                tick.values.push((entity, path.clone()));
            }
        }
    }
    all.sort_by(f64::total_cmp);
    all.dedup();
    let model = &mut world.resource_mut::<EditorModel>().0.timeline;
    share(&mut model.all, all);
    share(&mut model.values, values_of(&selected));
    share(&mut model.selected, selected);
    share(&mut model.tracks, tracks);
}

/// The values that have keys, each once, by their names.
pub fn values_of(ticks: &Ticks) -> Vec<KeyPath> {
    let values = ticks.values().flat_map(|tick| &tick.values);
    let mut paths: Vec<&KeyPath> = values.map(|(_, path)| path).collect();
    paths.sort_unstable_by_key(|path| path.as_str());
    paths.dedup();
    paths.into_iter().cloned().collect()
}

/// The selection, its materials and their nested ones.
fn shown_things(world: &World) -> Vec<Entity> {
    let mut shown = world.resource::<Selection>().entities().to_vec();
    let mut known: EntityHashSet = shown.iter().copied().collect();
    let mut next = 0;
    while let Some(&thing) = shown.get(next) {
        let uses = world.get::<UsesMaterial>(thing).map(|it| it.0);
        let first = world.get::<FirstNested>(thing).map(|it| it.0);
        let second = world.get::<SecondNested>(thing).map(|it| it.0);
        for inner in [uses, first, second].into_iter().flatten() {
            if known.insert(inner) {
                shown.push(inner);
            }
        }
        next += 1;
    }
    shown
}

fn share<T: PartialEq>(known: &mut Arc<T>, now: T) {
    if **known != now {
        *known = Arc::new(now);
    }
}
