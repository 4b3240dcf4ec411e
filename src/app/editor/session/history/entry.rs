//! One step of the history: the changed states, before and after.

use std::collections::HashMap;

use bevy::prelude::*;

use crate::app::editor::command::light_mix::LightMix;
use crate::app::editor::command::selection::Selection;
use crate::scene::{
    AccelMethod, ActiveSensor, FreeView, IntegratorKeys, IntegratorSettings, LengthUnit, LightUnits, ObjectChange,
    SamplerSettings, SceneProperties,
};

/// The settings of a scene as a whole.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct SettingsState {
    pub integrator: IntegratorSettings,
    pub integrator_keys: IntegratorKeys,
    pub sampler: SamplerSettings,
    pub accel: AccelMethod,
    pub unit: LengthUnit,
    pub light_units: LightUnits,
    pub properties: SceneProperties,
}

impl SettingsState {
    pub fn of(world: &World) -> Self {
        Self {
            integrator: world.get_resource().copied().unwrap_or_default(),
            integrator_keys: world.get_resource().cloned().unwrap_or_default(),
            sampler: world.get_resource().copied().unwrap_or_default(),
            accel: world.get_resource().copied().unwrap_or_default(),
            unit: world.get_resource().copied().unwrap_or_default(),
            light_units: world.get_resource().copied().unwrap_or_default(),
            properties: world.get_resource().cloned().unwrap_or_default(),
        }
    }

    /// An estimate of the memory that it has allocated.
    fn bytes(&self) -> usize {
        self.integrator_keys.0.bytes() + self.properties.0.bytes()
    }

    /// Writes the components that differ from `from`; changes by others in the meantime stay.
    pub(super) fn write(&self, world: &mut World, from: &Self) {
        if from.integrator != self.integrator {
            world.insert_resource(self.integrator);
        }
        if from.integrator_keys != self.integrator_keys {
            world.insert_resource(self.integrator_keys.clone());
        }
        if from.sampler != self.sampler {
            world.insert_resource(self.sampler);
        }
        if from.accel != self.accel {
            world.insert_resource(self.accel);
        }
        if from.unit != self.unit {
            world.insert_resource(self.unit);
        }
        if from.light_units != self.light_units {
            world.insert_resource(self.light_units);
        }
        if from.properties != self.properties {
            world.insert_resource(self.properties.clone());
        }
    }
}

/// The camera and view in which the scene is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Standpoint {
    pub camera: ActiveSensor,
    pub free: FreeView,
}

impl Standpoint {
    pub fn of(world: &World) -> Self {
        Self {
            camera: world.get_resource().copied().unwrap_or_default(),
            free: world.get_resource().copied().unwrap_or_default(),
        }
    }
}

#[derive(Clone, Debug)]
pub(super) struct Change {
    pub entity: Entity,
    pub change: ObjectChange,
}

/// The kind of a step, for edits that depend on the step before.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StepKind {
    /// It made copies, which the next duplication may continue.
    Copy,
    /// It moved, turned or scaled things.
    Move,
    /// Anything else.
    #[default]
    Other,
}

/// One step of the history.
#[derive(Clone, Debug)]
pub struct Entry {
    /// The label in the panel.
    pub label: String,
    pub(super) changes: Vec<Change>,
    pub(super) settings: [SettingsState; 2],
    pub(super) selection: [Selection; 2],
    /// The standpoint before and after edits that change it.
    pub(super) standpoint: Option<[Standpoint; 2]>,
    /// The light mix before and after edits that change it: baking writes it into the scene.
    pub(super) mix: Option<[LightMix; 2]>,
    /// The key for merging: steps of one interaction with equal keys are one entry.
    pub(super) merge: Option<(u64, MergeKey)>,
    pub(super) kind: StepKind,
    /// The displayed time of the scene in seconds, at which the states were recorded.
    pub(super) time: f64,
    pub(super) number: u64,
    /// An estimate of its memory.
    pub(super) bytes: usize,
}

/// The kind of an edit and its entities: two equal ones in one drag are one step.
pub type MergeKey = (&'static str, Vec<Entity>);

impl Entry {
    pub(super) fn into_entities(self) -> impl Iterator<Item = Entity> {
        self.changes.into_iter().map(|change| change.entity)
    }

    pub(super) fn is_empty(&self) -> bool {
        self.changes.is_empty() && self.settings[0] == self.settings[1]
    }

    /// Whether the change concerns the file, which hiding and locking do not.
    pub(super) fn is_of_file(&self) -> bool {
        self.settings[0] != self.settings[1] || self.changes.iter().any(|change| change.change.is_of_file())
    }

    pub(super) fn count_bytes(&mut self) {
        let changes = self.changes.iter().map(|change| change.change.bytes());
        let keys = self.settings.iter().map(SettingsState::bytes);
        let selected = self.selection.iter().map(|selection| selection.entities().len());
        self.bytes = size_of::<Self>()
            + self.label.len()
            + changes.sum::<usize>()
            + keys.sum::<usize>()
            + selected.sum::<usize>() * size_of::<Entity>();
    }

    pub(super) fn absorb(&mut self, later: Self) {
        let places: HashMap<Entity, usize> = self.changes.iter().zip(0..).map(|(it, i)| (it.entity, i)).collect();
        let mut is_undone = vec![false; self.changes.len()];
        for change in later.changes {
            match places.get(&change.entity) {
                Some(&place) => is_undone[place] = self.changes[place].change.absorb(change.change),
                None => self.changes.push(change),
            }
        }
        let mut is_undone = is_undone.into_iter();
        self.changes.retain(|_| !is_undone.next().unwrap_or(false));
        self.settings[1].clone_from(&later.settings[1]);
        self.selection[1] = later.selection[1].clone();
        self.count_bytes();
    }
}
