//! An edit of the active thing done to all that is selected: everything of the same sort gets the same change.

use std::collections::HashSet;

use bevy::math::{Affine3A, Mat3A};
use bevy::prelude::*;
use bevy::reflect::PartialReflect;

use super::grouping;
use super::things::{pose_of, set_pose};
use crate::app::editor::command::ValueEdit;
use crate::app::editor::command::conversion::{emitter_turned_into, turned_into};
use crate::app::editor::command::material_tree::materials_inside;
use crate::app::editor::command::selection::Selection;
use crate::app::editor::model::difference::rounding;
use crate::app::editor::session::history::Edit;
use crate::scene::carry_over::{Vectors, carry_over};
use crate::scene::{
    AreaLight, Emitter, ExteriorMedium, Film, InMedium, InteriorMedium, Locked, Material, Medium, Placements, Sensor,
    Shape, UsesMaterial,
};

/// The depth to which materials within materials are followed.
const DEEPEST: usize = 4;

/// Applies to all other selected things what the command is going to do to its thing.
pub fn carry_to_others(edit: &mut Edit, command: &ValueEdit) {
    let selected = edit.world.resource::<Selection>().entities().to_vec();
    let others = |but: Entity| selected.iter().copied().filter(move |entity| *entity != but);
    match command {
        ValueEdit::SetShape(entity, after) => {
            carry::<Shape>(edit, *entity, after, others(*entity), Vectors::ByComponent);
        }
        ValueEdit::SetSensor(entity, after) => carry::<Sensor>(edit, *entity, after, others(*entity), Vectors::Whole),
        ValueEdit::SetFilm(entity, after) => carry::<Film>(edit, *entity, after, others(*entity), Vectors::Whole),
        ValueEdit::SetEmitter(entity, after) => {
            for other in others(*entity) {
                let known = edit.world.get::<Emitter>(*entity).zip(edit.world.get::<Emitter>(other));
                if let Some((before, other_before)) = known {
                    let mut changed = other_before.clone();
                    if before.plugin() == after.plugin() {
                        carry_over(before, after, &mut changed, Vectors::Whole);
                    } else if other_before.plugin() == before.plugin() {
                        changed = emitter_turned_into(&changed, after.plugin());
                    }
                    edit.set(other, changed);
                }
            }
        }
        ValueEdit::SetMaterial(entity, after) => {
            for other in materials_like(edit.world, *entity, &selected) {
                let known = edit
                    .world
                    .get::<Material>(*entity)
                    .zip(edit.world.get::<Material>(other));
                if let Some((before, other_before)) = known {
                    let mut changed = other_before.clone();
                    if before.plugin() == after.plugin() {
                        carry_over(before, &**after, &mut changed, Vectors::Whole);
                    } else if other_before.plugin() == before.plugin() {
                        changed = turned_into(&changed, after.plugin());
                    }
                    edit.set(other, changed);
                }
            }
        }
        ValueEdit::SetMedium(entity, after) => {
            for other in media_like(edit.world, *entity, &selected) {
                let known = edit.world.get::<Medium>(*entity).zip(edit.world.get::<Medium>(other));
                if let Some((before, other_before)) = known {
                    let mut changed = other_before.clone();
                    carry_over(before, &**after, &mut changed, Vectors::Whole);
                    edit.set(other, changed);
                }
            }
        }
        ValueEdit::SetAreaLight(entity, after) => {
            let before = edit.world.get::<AreaLight>(*entity).cloned();
            for other in others(*entity)
                .filter(|other| edit.world.get::<Shape>(*other).is_some())
                .collect::<Vec<_>>()
            {
                let known = edit.world.get::<AreaLight>(other).cloned();
                match (&before, after, known) {
                    (_, None, _) => edit.remove::<AreaLight>(other),
                    (None, Some(after), None) => edit.set(other, after.clone()),
                    (Some(before), Some(after), Some(mut changed)) => {
                        carry_over(before, after, &mut changed, Vectors::Whole);
                        edit.set(other, changed);
                    }
                    (Some(_), Some(_), None) | (None, Some(_), Some(_)) => {}
                }
            }
        }
        ValueEdit::Transform(poses) => {
            if let [(entity, after)] = poses[..] {
                let others = moved_by_themselves(edit.world, entity, others(entity).collect());
                transform(edit, entity, after, others);
            }
        }
        ValueEdit::Turn(entity, after, _) => {
            let others = moved_by_themselves(edit.world, *entity, others(*entity).collect());
            transform(edit, *entity, *after, others);
        }
    }
}

fn carry<C: Component<Mutability = bevy::ecs::component::Mutable> + PartialReflect + Clone + PartialEq>(
    edit: &mut Edit,
    entity: Entity,
    after: &C,
    others: impl Iterator<Item = Entity>,
    vectors: Vectors,
) {
    let Some(before) = edit.world.get::<C>(entity).cloned() else {
        return;
    };
    for other in others {
        if let Some(mut changed) = edit.world.get::<C>(other).cloned() {
            carry_over(&before, after, &mut changed, vectors);
            edit.set(other, changed);
        }
    }
}

/// Applies a change of pose: coordinates that were changed are set to the same number, and each thing is turned and
/// scaled about its own place.
fn transform(edit: &mut Edit, entity: Entity, after: Affine3A, others: Vec<Entity>) {
    let Some(before) = pose_of(edit.world, entity) else {
        return;
    };
    let middle = edit.world.get::<Shape>(entity).map_or(Vec3::ZERO, Shape::middle);
    let rounding = rounding(&before, middle);
    let turn = before.matrix3.inverse() * after.matrix3;
    let turn = if turn.is_finite() && before.matrix3 != after.matrix3 {
        turn
    } else {
        Mat3A::IDENTITY
    };
    let mut poses = Vec::new();
    for other in others {
        let stays = edit.world.get::<Locked>(other).is_some() || edit.world.get::<Placements>(other).is_some();
        let Some(mut pose) = pose_of(edit.world, other).filter(|_| !stays) else {
            continue;
        };
        pose.matrix3 *= turn;
        for axis in 0..3 {
            if (before.translation[axis] - after.translation[axis]).abs() > rounding[axis] {
                pose.translation[axis] = after.translation[axis];
            }
        }
        poses.push((other, pose));
    }
    for (other, pose) in grouping::with_members(edit, poses) {
        set_pose(edit, other, pose);
    }
}

/// The others, but not what moves with one of the groups among them anyway, and not groups that contain the thing
/// itself.
fn moved_by_themselves(world: &mut World, thing: Entity, others: Vec<Entity>) -> Vec<Entity> {
    let all = others.iter().copied().chain([thing]);
    let frames: Vec<Entity> = all.filter(|entity| grouping::is_frame(world, *entity)).collect();
    let mut left_out = HashSet::new();
    for frame in frames {
        let folder = grouping::path(world, frame);
        let mut inside = grouping::named_within(world, &folder);
        inside.retain(|entity| *entity != frame);
        match inside.contains(&thing) {
            true => _ = left_out.insert(frame),
            false => left_out.extend(inside),
        }
    }
    others.into_iter().filter(|other| !left_out.contains(other)).collect()
}

/// The materials in the same place as this one within what other selected things are made of.
fn materials_like(world: &World, material: Entity, selected: &[Entity]) -> Vec<Entity> {
    let whole = |entity: Entity| match world.get::<UsesMaterial>(entity) {
        Some(uses) => Some(uses.0),
        None => world.get::<Material>(entity).map(|_| entity),
    };
    let wholes: Vec<Entity> = selected.iter().copied().filter_map(whole).collect();
    let Some(path) = wholes.iter().find_map(|from| path_to(world, *from, material, DEEPEST)) else {
        return Vec::new();
    };
    let mut found: Vec<Entity> = wholes.iter().filter_map(|from| follow(world, *from, &path)).collect();
    found.sort();
    found.dedup();
    found.retain(|other| *other != material);
    found
}

/// The other media that the selected things have in the same place as one of them has this medium.
fn media_like(world: &World, medium: Entity, selected: &[Entity]) -> Vec<Entity> {
    let in_place: [fn(&World, Entity) -> Option<Entity>; 4] = [
        |world, thing| world.get::<Medium>(thing).map(|_| thing),
        |world, thing| world.get::<InteriorMedium>(thing).map(|medium| medium.0),
        |world, thing| world.get::<ExteriorMedium>(thing).map(|medium| medium.0),
        |world, thing| world.get::<InMedium>(thing).map(|medium| medium.0),
    ];
    let all =
        |place: fn(&World, Entity) -> Option<Entity>| selected.iter().filter_map(move |thing| place(world, *thing));
    let place = in_place.into_iter().find(|place| all(*place).any(|it| it == medium));
    let mut found: Vec<Entity> = place.map_or(Vec::new(), |place| all(place).collect());
    found.sort();
    found.dedup();
    found.retain(|other| *other != medium);
    found
}

/// The path from one material to another inside it.
fn path_to(world: &World, from: Entity, to: Entity, deepest: usize) -> Option<Vec<usize>> {
    if from == to {
        return Some(Vec::new());
    }
    let deepest = deepest.checked_sub(1)?;
    materials_inside(world, from)
        .into_iter()
        .enumerate()
        .find_map(|(place, inner)| {
            let mut path = path_to(world, inner, to, deepest)?;
            path.insert(0, place);
            Some(path)
        })
}

fn follow(world: &World, from: Entity, path: &[usize]) -> Option<Entity> {
    path.iter().try_fold(from, |material, place| {
        materials_inside(world, material).get(*place).copied()
    })
}
