//! Commands about the selection.

use bevy::prelude::*;

use super::{files, grouping, seeing, view};
use crate::app::editor::camera::picking;
use crate::app::editor::command::SelectionCommand;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::panel::Panel;
use crate::app::editor::command::selection::{Extend, Selection};
use crate::app::editor::session::requests::Requests;
use crate::engine::PackedScene;
use crate::scene::{ActiveSensor, DocumentOrder, Emitter, Hidden, Locked, MemberOf, ObjectState, Sensor, Shape};

/// Applies the command.
pub fn apply(world: &mut World, command: SelectionCommand) -> Result<(), CommandError> {
    match command {
        SelectionCommand::Copy => files::copy(world)?,
        SelectionCommand::Select(entities, how) => select(world, &entities, how),
        SelectionCommand::SelectAll => {
            let mut things = world.query_filtered::<(Entity, &DocumentOrder), (
                Or<(With<Shape>, With<Emitter>)>,
                Without<Locked>,
                Without<Hidden>,
                Without<MemberOf>,
            )>();
            let mut things: Vec<_> = things.iter(world).map(|(entity, order)| (*order, entity)).collect();
            things.sort();
            let things: Vec<Entity> = things.into_iter().map(|(_, entity)| entity).collect();
            select(world, &things, Extend::Replace);
        }
        SelectionCommand::Pick(film, how) => {
            let found = picking::pick(world.resource::<PackedScene>(), film);
            let found = found.filter(|entity| world.get::<Locked>(*entity).is_none());
            match (found, how) {
                (None, Extend::Add | Extend::Toggle) => {}
                (found, how) => select(world, found.as_slice(), how),
            }
        }
        SelectionCommand::SelectGroup => grouping::select_group(world)?,
    }
    Ok(())
}

fn select(world: &mut World, entities: &[Entity], how: Extend) {
    world.resource_mut::<Selection>().extend(entities.iter().copied(), how);
    if !entities.is_empty() {
        world.resource_mut::<Requests>().wanted_panel = Some(Panel::Inspector);
    }
}

/// Drops entities that are not in the scene any more from the selection, and a camera in use that is not.
pub fn keep_what_is_there(world: &mut World) {
    let is_there = ObjectState::is_in_scene;
    let selection = world.resource::<Selection>().clone();
    if selection.entities().iter().any(|entity| !is_there(world, *entity)) {
        let mut kept = selection;
        kept.retain(|entity| is_there(world, *entity));
        world.insert_resource(kept);
    }
    seeing::keep_what_is_there(world, is_there);
    let active = world.resource::<ActiveSensor>().0;
    if active.is_none_or(|sensor| world.get::<Sensor>(sensor).is_none()) {
        let mut sensors = world.query_filtered::<(&DocumentOrder, Entity), With<Sensor>>();
        let first = sensors.iter(world).min().map(|(_, entity)| entity);
        if first != active {
            view::look_through_first(world, first);
        }
    }
}
