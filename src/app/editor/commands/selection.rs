//! Commands about the selection.

use std::collections::HashSet;

use bevy::ecs::entity::EntityHashSet;
use bevy::prelude::*;

use super::{files, grouping, seeing, view};
use crate::app::editor::camera::picking;
use crate::app::editor::command::SelectionCommand;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::panel::Panel;
use crate::app::editor::command::selection::{Alike, Extend, Selection};
use crate::app::editor::model::gather::shape_kind;
use crate::app::editor::session::requests::Requests;
use crate::engine::PackedScene;
use crate::scene::{
    ActiveSensor, DocumentOrder, Emitter, Hidden, Locked, Material, MemberOf, ObjectState, Sensor, Shape, UsesMaterial,
};

/// Applies the command.
pub fn apply(world: &mut World, command: SelectionCommand) -> Result<(), CommandError> {
    match command {
        SelectionCommand::Copy => files::copy(world)?,
        SelectionCommand::Select(entities, how) => select(world, &entities, how),
        SelectionCommand::SelectAll => {
            let things = visible_things(world);
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
        SelectionCommand::SelectAlike(alike) => select_alike(world, alike)?,
        SelectionCommand::SelectGroup => grouping::select_group(world)?,
    }
    Ok(())
}

/// The shapes and lights that can be selected in the picture, in the order of the file.
fn visible_things(world: &mut World) -> Vec<Entity> {
    let mut things = world.query_filtered::<(Entity, &DocumentOrder), (
        Or<(With<Shape>, With<Emitter>)>,
        Without<Locked>,
        Without<Hidden>,
        Without<MemberOf>,
    )>();
    let mut things: Vec<_> = things.iter(world).map(|(entity, order)| (*order, entity)).collect();
    things.sort();
    things.into_iter().map(|(_, entity)| entity).collect()
}

fn select_alike(world: &mut World, alike: Alike) -> Result<(), CommandError> {
    let selected = world.resource::<Selection>().entities().to_vec();
    let mut all = visible_things(world);
    match alike {
        Alike::Material => {
            let materials: EntityHashSet = selected
                .iter()
                .filter_map(|entity| material_of(world, *entity))
                .collect();
            if materials.is_empty() {
                return Err("Nothing that is selected has a material.".into());
            }
            all.retain(|entity| material_of(world, *entity).is_some_and(|used| materials.contains(&used)));
        }
        Alike::Type => {
            let kinds: HashSet<&str> = selected.iter().filter_map(|entity| kind_of(world, *entity)).collect();
            if kinds.is_empty() {
                return Err("Select a shape or a light first.".into());
            }
            all.retain(|entity| kind_of(world, *entity).is_some_and(|kind| kinds.contains(&kind)));
        }
    }
    if all.is_empty() {
        return Err("Everything of that kind is hidden or locked.".into());
    }
    select(world, &all, Extend::Replace);
    Ok(())
}

/// The material that a shape uses, or the selected material itself.
fn material_of(world: &World, entity: Entity) -> Option<Entity> {
    let used = world.get::<UsesMaterial>(entity).map(|used| used.0);
    used.or_else(|| world.get::<Material>(entity).map(|_| entity))
}

/// The kind of a shape or a light.
fn kind_of(world: &World, entity: Entity) -> Option<&'static str> {
    let emitter = || world.get::<Emitter>(entity).map(|emitter| emitter.info().label);
    world.get::<Shape>(entity).map(shape_kind).or_else(emitter)
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
