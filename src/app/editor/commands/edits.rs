//! The edits of the scene. Each is made through an [`Edit`], which records the former state.

use std::collections::HashSet;

use bevy::prelude::*;

use super::placing;
use super::things::{call, check_name, delete, is_no_name, selected};
use crate::app::editor::camera::rounding;
use crate::app::editor::command::Direction;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::session::history::Edit;
use crate::scene::insert::{free_name, names, next_order};
use crate::scene::{DocumentOrder, Emitter, Hidden, MemberOf, ObjectState, SceneId, Shape, ShapeGroup, ToWorld};

pub fn delete_selection(edit: &mut Edit) -> Result<(), CommandError> {
    for entity in selected(edit)? {
        delete(edit, entity);
    }
    edit.world.insert_resource(Selection::default());
    Ok(())
}

/// Copies use the same materials and groups; they are selected then.
pub fn duplicate(edit: &mut Edit) -> Result<(), CommandError> {
    let mut taken = names(edit.world);
    let mut order = next_order(edit.world);
    let mut copies = Vec::new();
    // The copy is placed where it is visible beside the original.
    let aside = placing::step(edit.world, Direction::Right);
    for original in selected(edit)? {
        let mut state = ObjectState::of(edit.world, original);
        if state.placements.is_some() {
            return Err("So many instances cannot be doubled.".into());
        }
        let name = state.name.as_ref().map_or("copy", |name| name.as_str());
        let name = free_name(&taken, name);
        taken.insert(name.clone());
        state.id = Some(SceneId(name.clone()));
        state.name = Some(Name::new(name));
        state.order = Some(DocumentOrder(order));
        state.declared_in = None;
        if let Some(ToWorld(pose)) = &mut state.to_world {
            pose.translation = rounding::sum_of_places(pose.translation.into(), aside).into();
        }
        order = order.saturating_add(1);
        let copy = edit.spawn(());
        state.write(edit.world, copy);
        copies.push(copy);
    }
    edit.world.insert_resource(Selection::of(copies));
    Ok(())
}

pub fn rename(edit: &mut Edit, entity: Entity, name: &str) -> Result<(), CommandError> {
    let name = name.trim();
    if name.is_empty() {
        if edit.world.get::<ShapeGroup>(entity).is_some() {
            return Err("A group needs its name: instances refer to it.".into());
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
    let is_own = edit
        .world
        .get::<Name>(entity)
        .is_some_and(|known| known.as_str() == name);
    if !is_own && names(edit.world).contains(name) {
        return Err(format!("There is something called \"{name}\" already.").into());
    }
    call(edit, entity, name);
    Ok(())
}

pub fn group(edit: &mut Edit) -> Result<(), CommandError> {
    let members = selected(edit)?;
    let taken = names(edit.world);
    let folders = taken.iter().filter_map(|name| Some(name.split_once('/')?.0.to_owned()));
    let folder = free_name(&folders.collect::<HashSet<_>>(), "group");
    put_into(edit, members, Some(&folder))
}

/// Puts things into a folder. Folders are written as the part of names before the last `/`.
pub fn put_into(edit: &mut Edit, things: Vec<Entity>, folder: Option<&str>) -> Result<(), CommandError> {
    if folder.is_some_and(|folder| folder.chars().any(is_no_name)) {
        return Err("The folder's name has a character that names cannot have.".into());
    }
    let mut taken = names(edit.world);
    for thing in things {
        let name = edit
            .world
            .get::<Name>(thing)
            .map_or_else(String::new, |name| name.as_str().to_owned());
        let leaf = name.rsplit('/').next().unwrap_or_default();
        let wanted = match folder {
            Some(folder) => format!("{folder}/{leaf}"),
            None => leaf.to_owned(),
        };
        if wanted != name {
            let free = free_name(&taken, &wanted);
            call(edit, thing, &free);
            taken.remove(&name);
            taken.insert(free);
        }
    }
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
