//! Where the light of a lamp goes: by the things that it arrives at, found on threads of its own whenever the lamp or
//! the scene has changed.

use std::sync::Arc;

use bevy::prelude::*;

use super::paths::Names;
use super::search::{Search, SearchState};
use crate::app::editor::command::selection::Selection;
use crate::engine::reasons::Things;
use crate::engine::{PackedScene, RenderControl, WakeUp};
use crate::render::breakdown::{Destination, Destinations, destinations};
use crate::render::scene::RenderScene;

/// The paths that are traced from the lamp.
const PATHS: u32 = 1 << 16;

/// The scene and the lamp that is asked about.
#[derive(Clone, Debug)]
struct Question {
    scene: RenderScene,
    lamp: Entity,
}

impl Question {
    fn is_same(&self, other: &Self) -> bool {
        self.lamp == other.lamp && self.scene.is_same(&other.scene)
    }
}

/// A thing at which the light arrives.
#[derive(Clone, Debug, PartialEq)]
pub struct Receiver {
    /// The thing and how much of the light it gets; None for a thing that is gone.
    pub destination: Destination<Option<Entity>>,
    /// Its name.
    pub name: String,
}

/// The light of a lamp, in the words of the panel.
#[derive(Clone, Debug, PartialEq)]
pub struct LampLight {
    /// The emitted power with its standard error, by luminance in W.
    pub emitted: [f32; 2],
    /// The part of it that leaves the scene, with its standard error.
    pub escaped: [f32; 2],
    /// The things that get it, those at which most stays first.
    pub receivers: Vec<Receiver>,
}

/// The lamp whose light is followed.
#[derive(Resource, Debug, Default)]
pub struct LampFollower {
    /// The lamp; None if the light of none is followed.
    pub lamp: Option<Entity>,
    /// The name of the lamp.
    pub name: String,
    /// The selected thing and its name, if it is a lamp.
    pub selected: Option<(Entity, String)>,
    /// Where its light goes; None while that is unknown.
    pub light: Option<Arc<LampLight>>,
    /// The state of the search for that.
    pub state: SearchState,
    search: Search<Question, Destinations>,
    answered: Option<Question>,
}

impl LampFollower {
    fn forget(&mut self) {
        self.search.cancel();
        (self.light, self.answered) = (None, None);
        self.state = SearchState::Idle;
    }
}

/// Asks anew when the lamp or the scene has changed, which stops what was asked before.
pub(crate) fn follow_lamp(
    mut follower: ResMut<LampFollower>,
    selection: Res<Selection>,
    packed: Res<PackedScene>,
    control: Res<RenderControl>,
    wake_up: Res<WakeUp>,
    names: Names,
) {
    let shines = |entity: &Entity| packed.lamps.owners.contains(entity);
    let selected = selection.active().filter(shines);
    if selected != follower.selected.as_ref().map(|selected| selected.0) {
        follower.selected = selected.map(|entity| (entity, names.thing(entity)));
    }
    let lamp = follower.lamp.filter(shines);
    if lamp.is_none() && follower.lamp.is_some() && packed.scene.is_some() {
        follower.lamp = None;
    }
    let (Some(lamp), Some(scene), Some(view)) = (lamp, &packed.scene, &packed.view) else {
        if follower.state != SearchState::Idle || follower.answered.is_some() {
            follower.forget();
        }
        return;
    };
    let question = Question {
        scene: scene.clone(),
        lamp,
    };
    if let Some((asked, found)) = follower.search.collect() {
        follower.light = Some(Arc::new(named(&found, &Things::of(&packed), &names)));
        follower.name = names.thing(asked.lamp);
        follower.answered = Some(asked);
    }
    let is_known = |known: &Question| known.is_same(&question);
    if follower.answered.as_ref().is_some_and(is_known) || follower.search.is_about(is_known) {
        follower.state = follower.search.state();
        return;
    }
    follower.forget();
    let (things, view) = (Things::of(&packed), view.clone());
    let find = move |question: Question, progress: &_| {
        let alone = things.lit_by(&question.scene, question.lamp);
        let alone = alone.ok_or("it does not shine in the scene as it is rendered")?;
        destinations(&alone, &view, PATHS, progress).ok_or_else(|| "the search was given up".to_owned())
    };
    follower.search.start(question, control.threads.get(), &wake_up, find);
    follower.state = follower.search.state();
}

fn named(found: &Destinations, things: &Things, names: &Names) -> LampLight {
    let by_thing = found.by(|instance| things.instance(instance));
    let receiver = |destination: Destination<Option<Entity>>| Receiver {
        name: destination
            .key
            .map_or_else(|| "?".to_owned(), |thing| names.thing(thing)),
        destination,
    };
    LampLight {
        emitted: found.emitted(),
        escaped: found.escaped(),
        receivers: by_thing.into_iter().map(receiver).collect(),
    }
}
