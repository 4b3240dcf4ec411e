//! Edits of the outliner: names, order, groups, and the marks of hidden and locked things.

use std::collections::HashSet;

use bevy::prelude::*;

use super::grouping;
use super::things::{call, check_name};
use crate::app::editor::command::OutlineEdit;
use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::session::history::Edit;
use crate::scene::names::is_taken;
use crate::scene::{DocumentOrder, Emitter, Hidden, Locked, MemberOf, SceneId, Shape, ShapeGroup};

/// Applies the edit.
pub fn edit(edit: &mut Edit, command: OutlineEdit) -> Result<(), CommandError> {
    match command {
        OutlineEdit::Rename(entity, name) => rename(edit, entity, &name)?,
        OutlineEdit::Reorder { moved, before } => reorder(edit, &moved, before),
        OutlineEdit::Group => grouping::group(edit)?,
        OutlineEdit::Ungroup => grouping::ungroup(edit)?,
        OutlineEdit::PutInto { things, folder } => grouping::put_into(edit, things, folder.as_deref())?,
        OutlineEdit::Hide(entities, hidden) => hide(edit, &entities, hidden),
        OutlineEdit::HideOthers => {
            let selection = edit.world.resource::<Selection>().clone();
            let others = visible_things(edit.world, |entity| !selection.contains(entity));
            hide(edit, &others, true);
        }
        OutlineEdit::ShowAll => {
            let mut hidden = edit.world.query_filtered::<Entity, With<Hidden>>();
            let hidden: Vec<Entity> = hidden.iter(edit.world).collect();
            hide(edit, &hidden, false);
        }
        OutlineEdit::Lock(entities, locked) => {
            for entity in entities {
                if locked {
                    edit.set(entity, Locked);
                } else {
                    edit.remove::<Locked>(entity);
                }
            }
        }
    }
    Ok(())
}

fn rename(edit: &mut Edit, entity: Entity, name: &str) -> Result<(), CommandError> {
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

/// Moves things in the order. Only the positions between the first and the last moved thing are assigned anew.
fn reorder(edit: &mut Edit, moved: &[Entity], before: Option<Entity>) {
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
fn visible_things(world: &mut World, mut wanted: impl FnMut(Entity) -> bool) -> Vec<Entity> {
    let mut things =
        world.query_filtered::<Entity, (Or<(With<Shape>, With<Emitter>)>, Without<Hidden>, Without<MemberOf>)>();
    things.iter(world).filter(|entity| wanted(*entity)).collect()
}

fn hide(edit: &mut Edit, entities: &[Entity], hidden: bool) {
    for &entity in entities {
        let can_be = edit.world.get::<Shape>(entity).is_some() || edit.world.get::<Emitter>(entity).is_some();
        match (hidden, can_be) {
            (true, true) => edit.set(entity, Hidden),
            (true, false) => {}
            (false, _) => edit.remove::<Hidden>(entity),
        }
    }
}
