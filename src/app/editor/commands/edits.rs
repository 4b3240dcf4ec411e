//! The edits of the scene. Each is made through an [`Edit`], which records the former state.

use std::collections::HashSet;

use bevy::prelude::*;

use super::grouping;
use super::things::{call, check_name, delete, selected};
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::session::history::Edit;
use crate::scene::names::is_taken;
use crate::scene::{DocumentOrder, Emitter, Hidden, MemberOf, SceneId, Shape, ShapeGroup};

pub fn delete_selection(edit: &mut Edit) -> Result<(), CommandError> {
    for entity in selected(edit)? {
        delete(edit, entity);
    }
    edit.world.insert_resource(Selection::default());
    Ok(())
}

pub fn rename(edit: &mut Edit, entity: Entity, name: &str) -> Result<(), CommandError> {
    let name = name.trim();
    if name.is_empty() {
        if edit.world.get::<ShapeGroup>(entity).is_some() || grouping::is_frame(edit.world, entity) {
            return Err("A group needs its name: others refer to it.".into());
        }
        edit.remove::<SceneId>(entity);
        return Ok(());
    }
    if edit.world.get::<SceneId>(entity).is_some_and(|id| id.0 == name)
        && edit
            .world
            .get::<Name>(entity)
            .is_some_and(|known| known.as_str() == name)
    {
        return Ok(());
    }
    check_name(name)?;
    if grouping::is_frame(edit.world, entity) {
        let name = name.trim_end_matches('/');
        if name.is_empty() {
            return Err("A group needs a name.".into());
        }
        grouping::rename_folder(edit, &grouping::path(edit.world, entity), name);
        return Ok(());
    }
    let is_own = edit
        .world
        .get::<Name>(entity)
        .is_some_and(|known| known.as_str() == name);
    if !is_own && is_taken(edit.world, name) {
        return Err(format!("There is something called \"{name}\" already.").into());
    }
    call(edit, entity, name);
    Ok(())
}

/// Moves things in the order. Only the places between the first and the last of those concerned are dealt out anew.
pub fn reorder(edit: &mut Edit, moved: &[Entity], before: Option<Entity>) {
    let mut all = edit.world.query::<(&DocumentOrder, Entity)>();
    let mut all: Vec<(DocumentOrder, Entity)> = all.iter(edit.world).map(|(order, entity)| (*order, entity)).collect();
    all.sort();
    let places: Vec<DocumentOrder> = all.iter().map(|(order, _)| *order).collect();
    let mut sequence: Vec<Entity> = all.into_iter().map(|(_, entity)| entity).collect();
    let known: HashSet<Entity> = sequence.iter().copied().collect();
    let moved = moved.iter().copied();
    let moved: Vec<Entity> = moved.filter(|it| known.contains(it) && Some(*it) != before).collect();
    let leaving: HashSet<Entity> = moved.iter().copied().collect();
    sequence.retain(|entity| !leaving.contains(entity));
    let place = before.and_then(|before| sequence.iter().position(|entity| *entity == before));
    let place = place.unwrap_or(sequence.len());
    sequence.splice(place..place, moved);
    for (entity, place) in sequence.into_iter().zip(places) {
        edit.set(entity, place);
    }
}

/// The shapes of the world and the lights.
pub fn visible_things(world: &mut World, mut wanted: impl FnMut(Entity) -> bool) -> Vec<Entity> {
    let mut things =
        world.query_filtered::<Entity, (Or<(With<Shape>, With<Emitter>)>, Without<Hidden>, Without<MemberOf>)>();
    things.iter(world).filter(|entity| wanted(*entity)).collect()
}

pub fn hide(edit: &mut Edit, entities: &[Entity], hidden: bool) {
    for &entity in entities {
        let can_be = edit.world.get::<Shape>(entity).is_some() || edit.world.get::<Emitter>(entity).is_some();
        match (hidden, can_be) {
            (true, true) => edit.set(entity, Hidden),
            (true, false) => {}
            (false, _) => edit.remove::<Hidden>(entity),
        }
    }
}
