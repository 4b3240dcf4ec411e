//! Helpers that several edits of things in the scene share.

use bevy::math::{Affine3A, Mat3A};
use bevy::prelude::*;

use crate::app::editor::command::error::CommandError;
use crate::app::editor::command::selection::{Extend, Selection};
use crate::app::editor::session::history::Edit;
use crate::scene::insert::next_order;
use crate::scene::medium::users_of_medium;
use crate::scene::{
    ActiveSensor, Authored, DeclaredIn, Declares, DocumentOrder, EulerAngles, ExteriorMedium, FirstNested,
    FirstNestedIn, FreeView, InMedium, InteriorMedium, KeyPath, Keys, Locked, Material, MaterialUsers, ObjectState,
    Placements, SceneId, SecondNested, SecondNestedIn, Sensor, Shape, ToWorld, UsesMaterial,
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

/// Deletes a thing with the materials and media that were written inside it and that nothing else uses. Users of the
/// thing lose the reference.
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
    // The material around it needs a replacement.
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
            // The material is declared at the top level from now on.
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

/// Whether the character is forbidden in ids.
pub(crate) fn is_no_name(c: char) -> bool {
    c.is_control() || "$.\"<>&".contains(c)
}

pub(crate) fn call(edit: &mut Edit, entity: Entity, name: &str) {
    edit.set(entity, SceneId(name.to_owned()));
    edit.set(entity, Name::new(name.to_owned()));
}

/// The pose of a thing: world from a space whose origin is the thing's place, such as the centre of a sphere
/// ([`Shape::middle`]).
pub fn pose_of(world: &World, entity: Entity) -> Option<Affine3A> {
    let to_world = world.get::<ToWorld>(entity)?.0;
    Some(match middle_of(world, entity) {
        Vec3::ZERO => to_world,
        middle => to_world * Affine3A::from_translation(middle),
    })
}

/// The pose that a thing had in a state, see [`pose_of`].
pub(crate) fn pose_in(state: &ObjectState) -> Option<Affine3A> {
    let middle = state.shape.as_ref().map_or(Vec3::ZERO, Shape::middle);
    Some(state.to_world?.0 * Affine3A::from_translation(middle))
}

fn middle_of(world: &World, entity: Entity) -> Vec3 {
    world.get::<Shape>(entity).map_or(Vec3::ZERO, Shape::middle)
}

/// Gives a thing a pose, see [`pose_of`]. A thing without a transform but with a position parameter, such as a centre,
/// is moved by that. Angles that do not match the new rotation are updated.
pub fn set_pose(edit: &mut Edit, entity: Entity, pose: Affine3A) {
    if let Some(shape) = moved_by_itself(edit.world, entity, &pose) {
        edit.set(entity, shape);
        edit.set(entity, ToWorld::default());
        edit.remove::<EulerAngles>(entity);
        return;
    }
    let known = edit.world.get::<EulerAngles>(entity).copied();
    let before = edit.world.get::<ToWorld>(entity).map(|before| before.0.matrix3);
    let has_angles = known.is_some() || edit.world.get::<Shape>(entity).is_some();
    if has_angles && before != Some(pose.matrix3) {
        let nearest = EulerAngles::following(known, &pose.matrix3);
        // Between key frames a thing turns from angle to angle.
        let goes_on = nearest == known || has_track(edit.world, entity);
        let shortest = || nearest.map(EulerAngles::within_half_turns);
        set_angles(edit, entity, if goes_on { nearest } else { shortest() });
    }
    let to_world = match middle_of(edit.world, entity) {
        Vec3::ZERO => pose,
        middle => pose * Affine3A::from_translation(-middle),
    };
    edit.set(entity, ToWorld(to_world));
}

/// Gives a thing the angles of its rotation.
pub fn set_angles(edit: &mut Edit, entity: Entity, angles: Option<EulerAngles>) {
    match angles.filter(|angles| angles.0 != Vec3::ZERO) {
        Some(angles) => edit.set(entity, angles),
        None => edit.remove::<EulerAngles>(entity),
    }
}

/// The shape moved to a pose by its own parameters. None if they do not suffice, or if the shape has a transform, which
/// is edited then.
fn moved_by_itself(world: &World, entity: Entity, pose: &Affine3A) -> Option<Shape> {
    let has_transform = match world.get::<Authored>(entity) {
        Some(authored) => authored
            .object
            .properties
            .iter()
            .any(|property| property.name == "to_world"),
        None => world.get::<ToWorld>(entity)?.0 != Affine3A::IDENTITY,
    };
    if has_transform || has_track(world, entity) || pose.matrix3 != Mat3A::IDENTITY {
        return None;
    }
    world.get::<Shape>(entity)?.moved_to(pose.translation.into())
}

/// Whether the pose has key frames.
fn has_track(world: &World, entity: Entity) -> bool {
    world
        .get::<Keys>(entity)
        .is_some_and(|keys| keys.track(&KeyPath::new("to_world")).is_some())
}

/// Sets poses, see [`pose_of`], as one edit. The error is a sentence for the user; poses before the refused one are set
/// then, and the caller abandons the edit.
pub fn transform(edit: &mut Edit, poses: Vec<(Entity, Affine3A)>) -> Result<(), CommandError> {
    for (entity, pose) in poses {
        if edit.world.get::<Placements>(entity).is_some() {
            return Err("So many instances stay where the file has them.".into());
        }
        if edit.world.get::<Locked>(entity).is_some() {
            return Err("That is locked.".into());
        }
        set_pose(edit, entity, pose);
        // A user who moves the camera in use wants to see its new view.
        if edit.world.resource::<ActiveSensor>().0 == Some(entity) && edit.world.get::<Sensor>(entity).is_some() {
            edit.world.insert_resource(FreeView::default());
        }
    }
    Ok(())
}

/// Selects the created things.
pub(crate) fn select_new(edit: &mut Edit, made: Vec<Entity>) {
    edit.world.resource_mut::<Selection>().extend(made, Extend::Replace);
}
