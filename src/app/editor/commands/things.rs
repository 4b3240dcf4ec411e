//! Helpers that several edits of things in the scene share.

use bevy::math::Affine3A;
use bevy::prelude::*;

use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::selection::{Extend, Selection};
use crate::app::editor::session::history::Edit;
use crate::scene::insert::next_order;
use crate::scene::medium::users_of_medium;
use crate::scene::{
    ActiveSensor, DeclaredIn, Declares, DocumentOrder, ExteriorMedium, FirstNested, FirstNestedIn, FreeView, InMedium,
    InteriorMedium, Locked, Material, MaterialUsers, ObjectState, Placements, SceneId, SecondNested, SecondNestedIn,
    Sensor, Shape, ToWorld, UsesMaterial,
};

/// An error unless the entity has a component of this type.
pub(crate) fn need<C: Component>(edit: &Edit, entity: Entity) -> Result<(), CommandError> {
    match edit.world.get::<C>(entity) {
        Some(_) => Ok(()),
        None => Err("That cannot be done to this thing.".into()),
    }
}

/// An error unless the entity is a shape with a surface.
pub(crate) fn need_surface(edit: &Edit, entity: Entity) -> Result<(), CommandError> {
    match edit.world.get::<Shape>(entity) {
        Some(shape) if !shape.is_frame() => Ok(()),
        _ => Err("That cannot be done to this thing.".into()),
    }
}

/// Replaces the value of a component that exists.
pub fn replace<C: Component + PartialEq>(edit: &mut Edit, entity: Entity, value: C) -> Result<(), CommandError> {
    need::<C>(edit, entity)?;
    edit.set(entity, value);
    Ok(())
}

pub(crate) fn selected(edit: &Edit) -> Result<Vec<Entity>, CommandError> {
    let selection = edit.world.resource::<Selection>().entities();
    let free: Vec<Entity> = selection
        .iter()
        .copied()
        .filter(|entity| ObjectState::is_in_scene(edit.world, *entity) && edit.world.get::<Locked>(*entity).is_none())
        .collect();
    match (selection.is_empty(), free.is_empty()) {
        (true, _) => Err("Nothing is selected.".into()),
        (false, true) => Err("What is selected is locked.".into()),
        (false, false) => Ok(free),
    }
}

/// Deletes a thing with the materials and media that were written inside it and that nothing else uses. Users of the thing lose the reference.
pub(super) fn delete(edit: &mut Edit, entity: Entity) {
    let declared: Vec<Entity> = edit
        .world
        .get::<Declares>(entity)
        .map(|declares| declares.iter().collect())
        .unwrap_or_default();
    let users: Vec<Entity> = edit
        .world
        .get::<MaterialUsers>(entity)
        .map(|users| users.iter().collect())
        .unwrap_or_default();
    for user in users {
        edit.remove::<UsesMaterial>(user);
    }
    let in_medium: Vec<Entity> = users_of_medium(edit.world, entity).collect();
    for user in in_medium {
        let world = &edit.world;
        let is_inside = world.get::<InteriorMedium>(user).is_some_and(|it| it.0 == entity);
        let is_outside = world.get::<ExteriorMedium>(user).is_some_and(|it| it.0 == entity);
        let is_around = world.get::<InMedium>(user).is_some_and(|it| it.0 == entity);
        if is_inside {
            edit.remove::<InteriorMedium>(user);
        }
        if is_outside {
            edit.remove::<ExteriorMedium>(user);
        }
        if is_around {
            edit.remove::<InMedium>(user);
        }
    }
    // The material around it needs something in its place.
    for outer in outer_materials(edit.world, entity) {
        let is_first = edit
            .world
            .get::<FirstNested>(outer)
            .is_some_and(|nested| nested.0 == entity);
        let order = DocumentOrder(next_order(edit.world));
        let plain = edit.spawn((Material::default(), order, Name::new("diffuse")));
        edit.set(plain, DeclaredIn(outer));
        if is_first {
            edit.set(outer, FirstNested(plain));
        } else {
            edit.set(outer, SecondNested(plain));
        }
    }
    edit.delete(entity);
    for material in declared {
        let is_used = edit
            .world
            .get::<MaterialUsers>(material)
            .is_some_and(|users| !users.is_empty())
            || users_of_medium(edit.world, material).any(|user| ObjectState::is_in_scene(edit.world, user))
            || !outer_materials(edit.world, material).is_empty();
        if is_used {
            // The material stands for itself from now on.
            edit.remove::<DeclaredIn>(material);
        } else {
            delete(edit, material);
        }
    }
}

/// The materials that this one is nested in.
pub(crate) fn outer_materials(world: &World, material: Entity) -> Vec<Entity> {
    let first = world
        .get::<FirstNestedIn>(material)
        .into_iter()
        .flat_map(|outer| outer.iter());
    let second = world
        .get::<SecondNestedIn>(material)
        .into_iter()
        .flat_map(|outer| outer.iter());
    first
        .chain(second)
        .filter(|outer| ObjectState::is_in_scene(world, *outer))
        .collect()
}

/// Checks a name. An error if the file could not have it as an id.
pub(crate) fn check_name(name: &str) -> Result<(), CommandError> {
    match name.chars().find(|c| is_no_name(*c)) {
        Some(wrong) => Err(format!("Names cannot have {wrong:?} in them.").into()),
        None => Ok(()),
    }
}

/// Whether ids cannot have this character.
pub(crate) fn is_no_name(c: char) -> bool {
    c.is_control() || "$.\"<>&".contains(c)
}

pub(crate) fn call(edit: &mut Edit, entity: Entity, name: &str) {
    edit.set(entity, SceneId(name.to_owned()));
    edit.set(entity, Name::new(name.to_owned()));
}

/// Sets poses, world from local, as one edit. The error is a sentence for the user; poses before the refused one are set then, and the caller
/// abandons the edit.
pub fn transform(edit: &mut Edit, poses: Vec<(Entity, Affine3A)>) -> Result<(), CommandError> {
    for (entity, pose) in poses {
        if edit.world.get::<Placements>(entity).is_some() {
            return Err("So many instances stay where the file has them.".into());
        }
        if edit.world.get::<Locked>(entity).is_some() {
            return Err("That is locked.".into());
        }
        edit.set(entity, ToWorld(pose));
        // A user who moves the camera wants to see from there.
        if edit.world.resource::<ActiveSensor>().0 == Some(entity) && edit.world.get::<Sensor>(entity).is_some() {
            edit.world.insert_resource(FreeView::default());
        }
    }
    Ok(())
}

/// Selects what an edit has made.
pub(crate) fn select_new(edit: &mut Edit, made: Vec<Entity>) {
    edit.world.resource_mut::<Selection>().extend(made, Extend::Replace);
}
